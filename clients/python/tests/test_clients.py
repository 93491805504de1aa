"""Many clients, dead clients, interrupted clients."""

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from conftest import SPACE, Background, drop, fill, wait_for_state, wait_until

import sturz

Script = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def script() -> Iterator[Script]:
    """Another Python with this package; it does not outlive the test."""
    with contextlib.ExitStack() as stack:

        def start(text: str, *arguments: str) -> "subprocess.Popen[str]":
            # A job in the background of a shell ignores Ctrl-C, and so would its children.
            heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
            command = [sys.executable, "-c", heard + text, *arguments]
            process = subprocess.Popen(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            stack.enter_context(process)
            stack.callback(process.kill)
            return process

        yield start


def alive(pid: int) -> bool:
    """Whether a process runs; a zombie does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


LONG_WINDOW = """
import sys, sturz
simulation = sturz.connect(sys.argv[1], endpoint=sys.argv[2])
states = simulation.states()
simulation.advance(window_s=1000.0)
"""


def test_two_clients_steer_and_see_the_same(drum: sturz.Simulation) -> None:
    fill(drum, beads=5, crosses=2)
    with sturz.connect(drum.instance, endpoint=drum.endpoint) as other:
        assert other.daemon is None
        other.set_gravity(gravity_m_per_s2=(0, 0, -1))
        np.testing.assert_array_equal(drum.info().gravity_m_per_s2, [0, 0, -1])
        ids = other.insert_lattice(
            shape="bead", material="glass", origin_m=(0, 0.006, 0.01), spacing_m=(1, 1, 1), counts=(1, 1, 1)
        )
        assert ids[0] in drum.state().ids
        with drum.states(keep=500) as mine, other.states(keep=500) as theirs:
            window = drum.advance(window_s=0.02)
            for stream in (mine, theirs):
                last = stream.next_frame(5.0)
                while last is not None and last.step < window.step:
                    last = stream.next_frame(5.0)
                assert last is not None
        assert other.info().state_hash == drum.info().state_hash
    assert drum.info().particles == 8, "a client that leaves takes nothing along"


def test_one_window_at_a_time_and_any_client_may_end_it(space: sturz.Simulation) -> None:
    drop(space)
    with sturz.connect(space.instance, endpoint=space.endpoint) as other:
        call = Background(lambda: space.advance(window_s=1000.0))
        wait_for_state(other, sturz.RunState.ADVANCING)
        assert other.report().progress is not None
        for refused in (other.step, other.resume, lambda: other.advance(window_s=1.0, from_time_s=0.0)):
            with pytest.raises(sturz.CommandError) as caught:
                refused()
            assert caught.value.code is sturz.ErrorCode.WINDOW_IN_FLIGHT
        other.set_gravity(gravity_m_per_s2=(0, 0, 0))
        paused_s = other.pause()
        window = call.join().result
        assert isinstance(window, sturz.Advanced)
        assert (window.stop_reason, window.time_reached_s) == ("paused", paused_s)
        assert 0 < window.steps_done < window.window_steps
        other.advance(window_s=1e-3)
        space.info()
        assert space.advance(window_s=1e-3).stop_reason == "complete"


def test_a_client_killed_in_the_middle_of_a_window_leaves_the_daemon_fine(
    space: sturz.Simulation, script: Script
) -> None:
    drop(space)
    client = script(LONG_WINDOW, space.instance, space.endpoint)
    wait_for_state(space, sturz.RunState.ADVANCING)
    client.kill()
    client.communicate()
    first = space.info()
    assert space.pause() >= first.time_s
    assert space.info().state is sturz.RunState.PAUSED
    hash_before = space.info().state_hash
    window = space.advance(window_s=1e-3, columns=["positions"])
    assert window.stop_reason == "complete"
    assert window.state is not None
    assert np.isfinite(window.state.positions_m).all()
    assert space.info().state_hash != hash_before


def test_ctrl_c_in_a_window_pauses_the_simulation(space: sturz.Simulation, script: Script) -> None:
    drop(space)
    client = script(LONG_WINDOW, space.instance, space.endpoint)
    wait_for_state(space, sturz.RunState.ADVANCING)
    client.send_signal(signal.SIGINT)
    _, said = client.communicate(timeout=20)
    assert "KeyboardInterrupt" in said
    assert space.info().state is sturz.RunState.PAUSED


def test_ctrl_c_that_does_not_wake_the_waiting_thread_pauses_too(space: sturz.Simulation, script: Script) -> None:
    # As when it comes between the last look at signals and the wait: another thread takes it here.
    drop(space)
    taken = "import signal, threading; t = threading.Timer(1.0, lambda: signal.raise_signal(signal.SIGINT)); "
    client = script(taken + "t.daemon = True; t.start()\n" + LONG_WINDOW, space.instance, space.endpoint)
    _, said = client.communicate(timeout=20)
    assert "KeyboardInterrupt" in said
    assert space.info().state is sturz.RunState.PAUSED


def test_a_daemon_ends_with_the_program_that_launched_it(tmp_path: Path, script: Script) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text(SPACE)
    text = "import sys, time, sturz\ns = sturz.launch(sys.argv[1])\nprint(s.info().pid, flush=True)\ntime.sleep(100)"
    client = script(text, str(scene))
    assert client.stdout is not None
    pid = int(client.stdout.readline())
    assert alive(pid)
    os.kill(client.pid, signal.SIGKILL)
    client.communicate()
    wait_until(lambda: not alive(pid), what="the end of the daemon")


def test_a_program_that_forgets_to_close_leaves_no_daemon(tmp_path: Path, script: Script) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text(SPACE)
    text = "import sys, sturz\ns = sturz.launch(sys.argv[1])\nstream = s.states()\nprint(s.info().pid)"
    client = script(text, str(scene))
    said, errors = client.communicate(timeout=30)
    assert client.returncode == 0, errors
    assert errors == ""
    wait_until(lambda: not alive(int(said)), what="the end of the daemon")


def test_nobody_there_and_another_name_say_so(space: sturz.Simulation) -> None:
    with pytest.raises(sturz.NotConnected, match=r"no daemon listens at tcp/127\.0\.0\.1:1$"):
        sturz.connect("any", endpoint="tcp/127.0.0.1:1", timeout_s=0.3)
    with pytest.raises(sturz.NotConnected, match=f"no simulation 'any' is alive.*there are {space.instance}"):
        sturz.connect("any", endpoint=space.endpoint, timeout_s=0.5)
