"""The client for asyncio: the same methods, streams without threads, cancellation that leaves nothing behind."""

import asyncio
import inspect
import threading
from collections.abc import Awaitable, Callable, Coroutine
from typing import Any

import numpy as np
import pytest
from conftest import DRUM, SPACE, kill

import sturz
import sturz.aio

PATIENCE_S = 60.0


def run(main: Callable[[], Coroutine[Any, Any, None]]) -> None:
    """Runs it, and looks for threads that are left."""
    before = set(threading.enumerate())

    async def patient() -> None:
        async with asyncio.timeout(PATIENCE_S):
            await main()

    asyncio.run(patient())
    left = {thread.name for thread in set(threading.enumerate()) - before if thread.name.startswith("sturz")}
    assert not left


async def until(condition: Callable[[], Awaitable[bool]]) -> None:
    """Waits for the daemon; `run` has the limit."""
    while not await condition():
        await asyncio.sleep(0.01)


def test_every_method_has_its_twin() -> None:
    streams = {"states", "contact_networks", "fields", "reports", "events"}
    for name, method in inspect.getmembers(sturz.Simulation, inspect.isfunction):
        if name.startswith("_"):
            continue
        twin = getattr(sturz.aio.AsyncSimulation, name)
        assert list(inspect.signature(twin).parameters) == list(inspect.signature(method).parameters), name
        assert inspect.iscoroutinefunction(twin) is (name not in streams | {"new_request_id"}), name
    for name, _ in inspect.getmembers(sturz.Simulation, lambda member: isinstance(member, property)):
        assert isinstance(getattr(sturz.aio.AsyncSimulation, name), property)


def test_a_run_is_the_same_as_that_of_the_blocking_client() -> None:
    def poses() -> dict[str, Any]:
        return {"shape": "cross", "material": "glass", "positions_m": [[0, 0.006, 0], [0.005, 0.006, 0]]}

    with sturz.launch(scene_text=DRUM) as simulation:
        simulation.insert_poses(**poses())
        expected = simulation.advance(window_s=5e-3, columns=["positions"]).state

    async def main() -> None:
        async with sturz.aio.launch(scene_text=DRUM) as simulation:
            ids = await simulation.insert_poses(**poses())
            state = (await simulation.advance(window_s=5e-3, columns=["positions"])).state
            info, shapes, report = await asyncio.gather(simulation.info(), simulation.shapes(), simulation.report())
            assert (info.particles, len(shapes), report.particles) == (2, 3, 2)
            assert expected is not None
            assert state is not None
            assert np.array_equal(state.positions_m, expected.positions_m)
            async with sturz.aio.connect(simulation.instance, endpoint=simulation.endpoint) as other:
                assert np.array_equal((await other.state()).ids, ids)
            with pytest.raises(sturz.CommandError, match="nothing"):
                await simulation.set_fixed(boundary="nothing")
        with pytest.raises(sturz.NotConnected, match="was closed"):
            await simulation.info()
        await simulation.close()

    run(main)


def test_streams_are_iterated_and_end_with_the_simulation() -> None:
    async def main() -> None:
        simulation = await sturz.aio.launch(scene_text=SPACE)
        await simulation.insert_poses(shape="bead", material="glass", positions_m=[[0, 0, 0]])
        async with simulation.states(keep=1000) as states:
            done = await simulation.advance(window_s=2e-3)
            async for state in states:
                if state.step == done.step:
                    break
            assert len(state) == 1
        assert await states.next_frame() is None
        async with simulation.events() as events:
            async for event in events:
                if event.kind is sturz.EventKind.PARTICLES:
                    break
            assert event.inserted == range(1)
        # It waits while the simulation is closed.
        silent = simulation.fields("none")
        with pytest.raises(sturz.Timeout, match="no frame within 0"):
            await silent.next_frame(timeout_s=0.0)
        waiting = asyncio.create_task(silent.next_frame())
        await asyncio.sleep(0)
        await simulation.close()
        assert await waiting is None

    run(main)


def test_a_lost_daemon_is_told_to_calls_and_streams() -> None:
    async def main() -> None:
        async with sturz.aio.launch(scene_text=SPACE) as simulation:
            reports = simulation.fields("none")
            reading = asyncio.create_task(reports.next_frame())
            window = asyncio.create_task(simulation.advance(window_s=1e4))
            await until(lambda: is_in(simulation, sturz.RunState.ADVANCING))
            kill(simulation.blocking)
            for task in (reading, window):
                with pytest.raises(sturz.DaemonDied):
                    await task

    run(main)


async def is_in(simulation: sturz.aio.AsyncSimulation, state: sturz.RunState) -> bool:
    """Whether the daemon does that."""
    return (await simulation.info()).state is state


def test_a_cancelled_window_pauses_and_the_next_one_goes_on_from_there() -> None:
    async def main() -> None:
        async with sturz.aio.launch(scene_text=SPACE) as simulation:
            for begin in (lambda: simulation.advance(window_s=1e4), lambda: simulation.step(steps=10**9)):
                window = asyncio.create_task(begin())
                await until(lambda: is_in(simulation, sturz.RunState.ADVANCING))
                window.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await window
                info = await simulation.info()
                assert info.state is sturz.RunState.PAUSED
                # Its start is what the client believes, and the daemon checks it to the bit.
                assert (await simulation.advance(window_s=1e-4)).time_reached_s > info.time_s
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.05):
                    await simulation.advance(window_s=1e4)
            assert await is_in(simulation, sturz.RunState.PAUSED)

    run(main)


def test_a_cancelled_command_is_answered_first_or_was_never_sent() -> None:
    async def main() -> None:
        async with sturz.aio.launch(scene_text=SPACE) as simulation:
            loop = asyncio.get_running_loop()
            go_on, began = threading.Event(), asyncio.Event()

            def slow() -> None:
                loop.call_soon_threadsafe(began.set)
                go_on.wait(PATIENCE_S)
                simulation.blocking.set_gravity(gravity_m_per_s2=(0, 0, -1))

            begun = asyncio.create_task(simulation.call(slow))
            await began.wait()
            others = [asyncio.create_task(simulation.call(go_on.wait, PATIENCE_S)) for _ in range(20)]
            waiting = asyncio.create_task(simulation.set_gravity(gravity_m_per_s2=(0, 0, -2)))
            await asyncio.sleep(0)
            # All threads are taken: a pause has its own.
            await simulation.pause()
            for task in (begun, waiting):
                task.cancel()
            with pytest.raises(asyncio.CancelledError):
                await waiting
            assert not begun.done()
            go_on.set()
            with pytest.raises(asyncio.CancelledError):
                await begun
            await asyncio.gather(*others)
            assert (await simulation.state()).gravity_m_per_s2[2] == -1

    run(main)


def test_a_cancelled_launch_leaves_no_daemon() -> None:
    launched: list[sturz.Simulation] = []

    async def main() -> None:
        loop = asyncio.get_running_loop()
        began = asyncio.Event()

        def launch() -> sturz.Simulation:
            loop.call_soon_threadsafe(began.set)
            launched.append(sturz.launch(scene_text=SPACE))
            return launched[0]

        async def opened() -> sturz.aio.AsyncSimulation:
            return await sturz.aio.Opening(launch)

        opening = asyncio.create_task(opened())
        await began.wait()
        opening.cancel()
        with pytest.raises(asyncio.CancelledError):
            await opening
        (simulation,) = launched
        assert simulation.daemon is not None
        assert simulation.daemon.process.poll() is not None

    run(main)


def test_commands_take_effect_later() -> None:
    async def main() -> None:
        async with sturz.aio.launch(scene_text=SPACE) as simulation:
            weak = await simulation.later(1e-4, simulation.set_gravity, gravity_m_per_s2=(0, 0, -1))
            wrong = await simulation.later(1e-4, simulation.set_fixed, boundary="nothing")
            assert not weak.done()
            await simulation.advance(window_s=2e-4)
            await weak
            with pytest.raises(sturz.CommandError):
                await wrong
            assert (await simulation.state()).gravity_m_per_s2[2] == -1

    run(main)


def test_what_has_no_twin_is_called_on_a_thread() -> None:
    async def main() -> None:
        async with sturz.aio.launch(scene_text=SPACE) as simulation:
            await simulation.insert_poses(shape="bead", material="glass", positions_m=[[0, 0, 0]])
            particles = sturz.Participant(simulation.blocking, window_s=1e-3, end_time_s=2e-3)
            await simulation.call(particles.initialize)
            while particles.is_coupling_ongoing():
                particles.write("force_n", [[0, 0, 0]])
                done = await simulation.call(particles.advance)
            await simulation.call(particles.finalize)
            assert done.time_reached_s == 2e-3

    run(main)


def test_a_second_cancellation_does_not_wait() -> None:
    async def main() -> None:
        async with sturz.aio.launch(scene_text=SPACE) as simulation:
            loop = asyncio.get_running_loop()
            go_on, began, ended = threading.Event(), asyncio.Event(), asyncio.Event()

            def slow() -> None:
                loop.call_soon_threadsafe(began.set)
                go_on.wait(PATIENCE_S)
                loop.call_soon_threadsafe(ended.set)

            call = asyncio.create_task(simulation.call(slow))
            await began.wait()
            call.cancel()
            await asyncio.sleep(0)
            assert not call.done()
            call.cancel()
            with pytest.raises(asyncio.CancelledError):
                await call
            assert not ended.is_set()
            go_on.set()
            await ended.wait()

    run(main)
