"""States, fields, reports and events come as they happen, to as many as listen."""

import numpy as np
import pytest
from conftest import drop, fill, wait_until

import sturz


def define_density(simulation: sturz.Simulation) -> None:
    """The field `f` of the whole drum."""
    low, high = (-0.02, 0, -0.02), (0.02, 0.012, 0.02)
    simulation.define_field(name="f", min_m=low, max_m=high, cells=(8, 1, 8), quantities=["density"], width_m=4e-3)


def test_states_fields_and_reports_come_while_it_runs(drum: sturz.Simulation) -> None:
    fill(drum)
    define_density(drum)
    with drum.states(keep=1000) as states, drum.fields("f", keep=1000) as fields, drum.reports(keep=1000) as reports:
        drum.resume()
        wait_until(lambda: min(states.received, fields.received, reports.received) >= 5, what="five of each")
        drum.pause()
        frames = [states.next_frame(5.0) for _ in range(5)]
        samples = [fields.next_frame(5.0) for _ in range(5)]
        told = [reports.next_frame(5.0) for _ in range(5)]
    steps = [frame.step for frame in frames if frame is not None]
    assert len(steps) == 5
    assert steps == sorted(steps)
    assert steps[-1] > steps[0]
    assert all(frame is not None and len(frame) == 40 for frame in frames)
    total = samples[0].total_mass_kg if samples[0] is not None else 0.0
    assert total > 0
    assert all(sample is not None and sample.total_mass_kg == pytest.approx(total) for sample in samples)
    assert all(report is not None and report.particles == 40 for report in told)
    assert told[-1] is not None
    assert told[-1].sim_s_per_wall_s > 0
    assert told[-1].stages_s_per_step


def test_the_last_state_comes_even_when_paused_at_once(space: sturz.Simulation) -> None:
    drop(space)
    with space.states(keep=1000) as states:
        for _ in range(20):
            window = space.advance(window_s=1e-3)
        newest = None
        while newest is None or newest.step < window.step:
            newest = states.next_frame(timeout_s=5.0)
            assert newest is not None
    np.testing.assert_array_equal(newest.positions_m, space.state().positions_m)


def test_a_stream_of_a_paused_simulation_begins_with_the_state_of_now(space: sturz.Simulation) -> None:
    drop(space)
    for _ in range(3):
        with space.states() as states:
            frame = states.next_frame(timeout_s=5.0)
            assert frame is not None
            assert frame.step == 0
            assert len(frame) == 1


def test_an_exception_of_a_callback_is_raised_at_the_end_of_the_simulation(space: sturz.Simulation) -> None:
    def broken(state: sturz.State) -> None:
        raise ZeroDivisionError(f"at step {state.step}")

    stream = space.states().for_each(broken)
    wait_until(lambda: stream._ended)
    with pytest.raises(ZeroDivisionError, match="at step 0"):
        space.close()
    with pytest.raises(sturz.NotConnected, match="was closed"):
        space.info()


def test_closing_the_simulation_ends_its_streams() -> None:
    from conftest import SPACE

    with sturz.launch(scene_text=SPACE) as simulation:
        states = simulation.states()
        assert states.next_frame(timeout_s=5.0) is not None
    assert list(states) == []


def test_fields_are_computed_for_listeners_alone(drum: sturz.Simulation) -> None:
    fill(drum, beads=5, crosses=0)
    define_density(drum)
    drum.advance(window_s=0.01)
    assert drum.report().streams["field/f"].offered == 0
    assert drum.report().streams["state"].offered == 0
    with drum.fields("f") as fields:
        assert fields.next_frame(timeout_s=5.0) is not None
    assert drum.report().streams["field/f"].offered > 0


def test_a_late_listener_hears_of_the_past(space: sturz.Simulation) -> None:
    drop(space)
    space.define_field(name="late", min_m=[0] * 3, max_m=[1] * 3, cells=[1] * 3, quantities=["density"], width_m=0.1)
    space.resume()
    space.pause()
    with sturz.connect(space.instance, endpoint=space.endpoint) as other, other.events() as events:
        wanted = {
            sturz.EventKind.STARTED,
            sturz.EventKind.PARTICLES,
            sturz.EventKind.FIELD,
            sturz.EventKind.RESUMED,
            sturz.EventKind.PAUSED,
        }
        seen: dict[sturz.EventKind, sturz.Event] = {}
        while wanted - set(seen):
            event = events.next_frame(timeout_s=10.0)
            assert event is not None
            seen[event.kind] = event
        assert seen[sturz.EventKind.FIELD].name == "late"
        space.remove(ids=[0])
        removed = events.next_frame(timeout_s=10.0)
        while removed is not None and "removed" not in removed.message:
            removed = events.next_frame(timeout_s=10.0)
        assert removed is not None
        assert removed.kind is sturz.EventKind.PARTICLES
