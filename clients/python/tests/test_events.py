"""Events say what happened in numbers, come late joiners' way, and a gap among them is noticed."""

import json
import socket
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import zenoh
from conftest import DRUM, drop, fill, wait_until

import sturz
from sturz._proto.sturz.v1 import status_pb2 as pb

Kind = sturz.EventKind


def next_of(events: sturz.Stream[sturz.Event], kind: sturz.EventKind) -> sturz.Event:
    """The next event of a kind."""
    return next_where(events, lambda event: event.kind is kind)


def next_where(events: sturz.Stream[sturz.Event], wanted: Callable[[sturz.Event], object]) -> sturz.Event:
    """The next event that is so."""
    while True:
        event = events.next_frame(timeout_s=20.0)
        assert event is not None
        if wanted(event):
            return event


def test_every_outcome_is_told_with_step_and_request(space: sturz.Simulation) -> None:
    with space.events() as events:
        drop(space)
        space.step(steps=3)
        space.set_gravity(gravity_m_per_s2=(0, 0, -1))
        with pytest.raises(sturz.CommandError):
            space.remove(ids=[77])
        window = space.advance(window_s=1e-4, columns=["all"], contacts=True)
        told = {}
        while "advance" not in told:
            event = next_of(events, Kind.COMMAND)
            assert event.outcome is not None
            assert event.outcome.client_id == space.client_id
            told[event.outcome.command] = event
    assert list(told) == ["insert", "step", "set_gravity", "remove", "advance"]
    outcome = told["set_gravity"].outcome
    assert outcome is not None
    assert (outcome.step, outcome.request_id, outcome.error) == (3, "3", "")
    assert outcome.time_s == pytest.approx(3e-5)
    refused = told["remove"]
    assert refused.severity is sturz.Severity.WARNING
    assert refused.outcome is not None
    assert refused.outcome.path == "ids[0]"
    assert "77" in refused.outcome.error
    assert window.contacts is not None


def test_large_payloads_are_left_out_of_outcomes(space: sturz.Simulation) -> None:
    drop(space)
    outcomes: dict[str, Any] = {}

    def take(payload: bytes) -> None:
        outcome = pb.Event.FromString(payload).outcome
        outcomes[outcome.command] = outcome

    # With the past: a subscriber hears some time after it is one.
    stop = space._bus.subscribe("event/command", take, missed=lambda count: None)
    space.advance(window_s=1e-4, columns=["all"], contacts=True)
    space.checkpoint(token="a")
    space.checkpoints()
    wait_until(lambda: {"advance", "list_checkpoints"} <= outcomes.keys(), what="both outcomes")
    stop()
    window, listed = outcomes["advance"], outcomes["list_checkpoints"]
    assert window.advanced.steps_done == 10
    assert not window.advanced.HasField("frame")
    assert not window.advanced.HasField("contacts")
    assert listed.WhichOneof("result") == "checkpoints"
    assert not listed.checkpoints.checkpoints


def test_particles_lease_and_checkpoints_are_told_in_numbers(space: sturz.Simulation) -> None:
    with space.events() as events:
        drop(space, positions_m=[[0.01 * k, 0, 0] for k in range(8)])
        assert next_of(events, Kind.PARTICLES).inserted == range(8)
        space.remove(ids=[6, 2, 3, 4])
        assert next_of(events, Kind.PARTICLES).removed == (range(2, 5), range(6, 7))
        space.acquire_lease()
        event = next_of(events, Kind.LEASE)
        assert (event.lease, event.name) == (sturz.LeaseChange.ACQUIRED, space.client_id)
        space.release_lease()
        assert next_of(events, Kind.LEASE).lease is sturz.LeaseChange.RELEASED
        saved = space.checkpoint(token="here")
        assert next_of(events, Kind.CHECKPOINT).checkpoint == saved
        space.restore(token="here")
        event = next_of(events, Kind.RESTORED)
        assert (event.name, event.checkpoint) == ("here", saved)
        space.drop_checkpoint(token="here")
        event = next_of(events, Kind.CHECKPOINT)
        assert (event.name, event.checkpoint) == ("here", None)


def test_the_loss_of_the_lease_is_told(space: sturz.Simulation) -> None:
    with space.events() as events, sturz.connect(space.instance, endpoint=space.endpoint) as other:
        other.acquire_lease()
        name = other.client_id
        other.close()
        event = next_where(events, lambda event: event.lease is sturz.LeaseChange.LOST)
        assert (event.name, event.severity) == (name, sturz.Severity.WARNING)


def test_guards_warn_with_the_particle(space: sturz.Simulation) -> None:
    with space.events() as events:
        # 0.15 mm of a radius of 1 mm; and 15 m/s, which are 0.15 radii in a step
        drop(space, positions_m=[[0, 0, 0], [1.85e-3, 0, 0]])
        space.step(steps=1)
        warning = next_of(events, Kind.WARNING).warning
        assert warning is not None
        assert (warning.kind, warning.particle_id) == (sturz.WarningKind.LARGE_OVERLAP, 0)
        assert (warning.count, warning.total, warning.limit) == (1, 1, 0.1)
        # they have been pushed apart for one step
        assert 0.14 < warning.value < 0.15
        drop(space, positions_m=[[0, 0, 1]], velocity_m_per_s=(0, 0, 15))
        space.step(steps=1)
        event = next_where(events, lambda e: e.warning and e.warning.kind is sturz.WarningKind.FAST_PARTICLE)
        assert event.severity is sturz.Severity.WARNING
        assert event.warning is not None
        assert event.warning.particle_id == 2
        assert event.warning.value == pytest.approx(0.15, rel=1e-3)
        assert "particle 2 moves by 0.150" in event.message


def test_the_end_of_the_run_is_told(space: sturz.Simulation) -> None:
    with sturz.connect(space.instance, endpoint=space.endpoint) as other, other.events() as events:
        next_of(events, Kind.STARTED)
        space.stop()
        assert next_of(events, Kind.ENDED).severity is sturz.Severity.INFO


def test_a_late_joiner_has_the_last_hundred_of_a_topic_in_order(space: sturz.Simulation) -> None:
    for k in range(130):
        space.set_gravity(gravity_m_per_s2=(0, 0, -k))
    with sturz.connect(space.instance, endpoint=space.endpoint) as other, other.events() as events:
        last = next_where(events, lambda event: event.request_id == "130")
        wait_until(lambda: events.received >= 131, what="the past")
        assert events.missed == 0
    assert last.header.seq == 129
    with sturz.connect(space.instance, endpoint=space.endpoint) as third, third.events() as events:
        seqs = [next_of(events, Kind.COMMAND).header.seq for _ in range(100)]
    assert seqs == list(range(seqs[0], seqs[0] + 100))


def test_who_joins_in_the_midst_of_a_run_gets_all_there_is_to_know() -> None:
    with sturz.launch(scene_text=DRUM) as simulation:
        fill(simulation, beads=5, crosses=3)
        simulation.resume()
        with sturz.connect(simulation.instance, endpoint=simulation.endpoint) as late:
            info = late.info()
            assert (info.state, info.particles, info.scene) == (sturz.RunState.RUNNING, 8, "small-drum")
            assert [shape.name for shape in late.shapes()] == list(info.shapes)
            assert late.plan() == simulation.plan()
            assert len(late.plan()) > 3
            with late.states() as states:
                frame = states.next_frame(timeout_s=20.0)
            assert frame is not None
            assert frame.ids.tolist() == list(range(8))
            assert frame.step >= info.step
        simulation.pause()
        with sturz.connect(simulation.instance, endpoint=simulation.endpoint) as late:
            assert late.state().step == simulation.info().step
            with late.states() as states, late.contact_networks() as networks:
                frame, network = states.next_frame(timeout_s=20.0), networks.next_frame(timeout_s=20.0)
            assert frame is not None
            assert network is not None
            assert (frame.step, network.step) == (late.info().step, late.info().step)


@pytest.fixture
def gappy() -> Iterator[tuple[str, Callable[[int], None]]]:
    """Where an instance `gappy` is alive that is no daemon, and how to publish an event of any number."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    config = zenoh.Config()
    for key, value in {
        "mode": "peer",
        "listen/endpoints": [endpoint],
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
    }.items():
        config.insert_json5(key, json.dumps(value))
    with zenoh.open(config) as session:
        token = session.liveliness().declare_token("sturz/v1/gappy/alive")
        publisher = session.declare_publisher("sturz/v1/gappy/event/run")

        def publish(number: int) -> None:
            event = pb.Event(kind=pb.EVENT_KIND_PAUSED)
            event.header.seq = number
            publisher.put(event.SerializeToString(), source_info=zenoh.SourceInfo(publisher.id, number))

        yield endpoint, publish
        token.undeclare()


def test_a_gap_is_counted(gappy: tuple[str, Callable[[int], None]]) -> None:
    endpoint, publish = gappy
    with sturz.connect("gappy", endpoint=endpoint) as simulation, simulation.events() as events:
        # until the subscription is there, nothing arrives
        wait_until(lambda: publish(0) or events.received, what="the first event")
        for number in (1, 2, 6, 7, 9):
            publish(number)
        seqs = [next_of(events, Kind.PAUSED).header.seq for _ in range(6)]
        assert seqs == [0, 1, 2, 6, 7, 9]
        assert (events.missed, events.dropped) == (4, 4)


def test_no_gap_is_made_up(space: sturz.Simulation) -> None:
    with space.events() as events:
        for k in range(50):
            space.set_gravity(gravity_m_per_s2=(0, 0, -k))
        next_where(events, lambda event: event.request_id == "50")
        assert events.missed == 0
