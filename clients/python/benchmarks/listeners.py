"""What listeners and floods cost the physics loop: `python listeners.py [--rounds N]`.

Runs the same windows of the same drum again and again, in turn with nobody, one, and ten subscribers, with a subscriber
that is killed half-way, and under a flood of undecodable commands. Prints the steps per second of each, the ratio to
nobody (median of the rounds, each against its own round), and whether the state hash is that of nobody.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator

import zenoh

import sturz

SUBSCRIBER = """
import sys, time, sturz
simulation = sturz.connect(sys.argv[1], endpoint=sys.argv[2])
states = simulation.states()
states.for_each(lambda state: None)
print("ready", flush=True)
time.sleep(600)
"""


def windows(simulation: sturz.Simulation, during: Callable[[], None]) -> tuple[float, int, int]:
    """Steps per second over four windows, step and hash at their end."""
    steps, start = 0, time.monotonic()
    for k in range(4):
        steps += simulation.advance(window_s=0.01).steps_done
        if k == 1:
            during()
    rate = steps / (time.monotonic() - start)
    info = simulation.info()
    return rate, info.step, info.state_hash


@contextlib.contextmanager
def prepared() -> Iterator[sturz.Simulation]:
    """A drum with 150 crosses that have settled."""
    with sturz.launch("drum-crosses", threads=1) as simulation:
        region = sturz.Cylinder((0, 0, 0), (0, 1, 0), radius_m=0.049, length_m=0.024)
        simulation.insert_random(shape="cross", material="particle", region=region, count=150)
        simulation.advance(window_s=0.15)
        simulation.set_rotation(boundary="drum", angular_velocity_rad_per_s=2.0)
        yield simulation


@contextlib.contextmanager
def subscribers(simulation: sturz.Simulation, count: int) -> Iterator[list[subprocess.Popen[str]]]:
    """Processes that read every state frame."""
    command = [sys.executable, "-c", SUBSCRIBER, simulation.instance, simulation.endpoint]
    processes = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(count)]
    try:
        for process in processes:
            assert process.stdout is not None
            process.stdout.readline()
        yield processes
    finally:
        for process in processes:
            process.kill()
            process.wait()


@contextlib.contextmanager
def flood(simulation: sturz.Simulation, per_second: float) -> Iterator[None]:
    """Bytes that are no message, on every command's key."""
    config = zenoh.Config()
    for key, value in {"mode": "client", "connect/endpoints": [simulation.endpoint]}.items():
        config.insert_json5(key, json.dumps(value))
    config.insert_json5("scouting/multicast/enabled", "false")
    over = threading.Event()

    def work() -> None:
        with zenoh.open(config) as session:
            while not over.wait(0.01):
                for _ in range(int(per_second / 100)):
                    session.put(f"sturz/v1/{simulation.instance}/cmd/insert", b"\xff" * 40)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def measure(case: str) -> tuple[float, int, int]:
    """One run of a case."""
    with prepared() as simulation:
        if case == "nobody":
            return windows(simulation, lambda: None)
        if case.startswith("flood"):
            with flood(simulation, 2000.0):
                return windows(simulation, lambda: None)
        count = 10 if case == "ten subscribers" else 1
        with subscribers(simulation, count) as processes:
            return windows(simulation, processes[0].kill if "killed" in case else lambda: None)


CASES = ("nobody", "one subscriber", "ten subscribers", "a subscriber is killed", "flood of 2,000 puts/s")


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5, help="of all cases in turn")
    rounds = parser.parse_args().rounds
    results = [{case: measure(case) for case in CASES} for _ in range(rounds)]
    print("| case | steps/s | over nobody | same hash |\n|---|---:|---:|---|")
    for case in CASES:
        rate = statistics.median(each[case][0] for each in results)
        ratio = statistics.median(each[case][0] / each["nobody"][0] for each in results)
        same = all(each[case][1:] == results[0]["nobody"][1:] for each in results)
        print(f"| {case} | {rate:.0f} | {ratio:.3f} | {'yes' if same else 'NO'} |")


if __name__ == "__main__":
    main()
