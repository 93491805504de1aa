"""The state at a step is the same to the last bit, whoever looks and however many threads there are."""

import contextlib
import itertools
import os
import threading

import pytest
import zenoh
from conftest import DRUM, fill
from test_bad_input import VERBS, raw_config

import sturz

FIELD = {"min_m": [-0.02, 0, -0.02], "max_m": [0.02, 0.012, 0.02], "cells": [20, 1, 20], "width_m": 2e-3}


def prepared(threads: int = 1) -> sturz.Simulation:
    """A filled drum that has settled, turning."""
    simulation = sturz.launch(scene_text=DRUM, threads=threads)
    fill(simulation, beads=120, crosses=60)
    simulation.advance(window_s=0.05)
    simulation.define_field(name="f", quantities=["density", "velocity", "granular_temperature"], **FIELD)  # type: ignore[arg-type]
    simulation.set_rotation(boundary="drum", angular_velocity_rad_per_s=12.0, ramp_s=0.005)
    return simulation


def run(simulation: sturz.Simulation) -> tuple[int, int]:
    """Some windows with a tilt in between; step and hash."""
    simulation.advance(window_s=0.02)
    simulation.set_gravity(gravity_m_per_s2=(1.0, 0.0, -9.7))
    for _ in range(3):
        simulation.advance(window_s=3.3e-3)
    info = simulation.info()
    return info.step, info.state_hash


@pytest.fixture(scope="module")
def reference() -> tuple[int, int]:
    """On one thread, with nobody looking."""
    with prepared() as simulation:
        result = run(simulation)
        # Particles must have met, else this proves little.
        report = simulation.report()
        assert report.touching_pairs > 20
        assert report.touching_boundary_pairs > 5
        return result


@pytest.mark.parametrize("threads", [2, 4])
def test_equal_on_any_number_of_threads(reference: tuple[int, int], threads: int) -> None:
    with prepared(threads) as simulation:
        assert simulation.info().threads == threads
        assert run(simulation) == reference


def test_another_command_gives_another_state(reference: tuple[int, int]) -> None:
    with prepared() as simulation:
        simulation.set_gravity(gravity_m_per_s2=(0, 0, -9.80))
        step, state_hash = run(simulation)
        assert step == reference[0]
        assert state_hash != reference[1], "a hash that never changes proves nothing"


def test_equal_with_ten_subscribers(reference: tuple[int, int]) -> None:
    with prepared() as simulation, contextlib.ExitStack() as stack:
        other = stack.enter_context(sturz.connect(simulation.instance, endpoint=simulation.endpoint))
        streams: list[sturz.Stream[object]] = []
        for client in (simulation, other):
            for stream in (
                client.states(),
                client.states(keep=1),
                client.fields("f"),
                client.reports(),
                client.events(),
            ):
                streams.append(stack.enter_context(stream))  # type: ignore[arg-type]
        assert len(streams) == 10
        assert run(simulation) == reference
        counts = simulation.report().streams
        assert counts["state"].offered > 1
        assert counts["field/f"].offered > 1
        assert all(stream.received for stream in streams)


def test_equal_under_a_flood_of_undecodable_commands(reference: tuple[int, int]) -> None:
    with prepared() as simulation:
        root = f"sturz/v1/{simulation.instance}/cmd"
        done, sent = threading.Event(), itertools.count()

        def flood() -> None:
            with zenoh.open(raw_config(simulation.endpoint)) as session:
                while not done.is_set():
                    number = next(sent)
                    session.put(f"{root}/{VERBS[number % len(VERBS)]}", b"\xff" + os.urandom(number % 200))

        flooding = threading.Thread(target=flood)
        flooding.start()
        try:
            assert run(simulation) == reference
        finally:
            done.set()
            flooding.join()
        assert next(sent) > 1000
