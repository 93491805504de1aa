"""A request is applied once, however often it is sent; what is put is answered on `event/command`."""

import pytest
import zenoh
from conftest import Background, drop, wait_until
from test_bad_input import raw_config

import sturz
from sturz._proto.sturz.v1 import command_pb2 as pb
from sturz._proto.sturz.v1 import data_pb2, status_pb2


def header(request_id: str, client_id: str = "tester") -> pb.CommandHeader:
    """Of a client that chooses its ids."""
    return pb.CommandHeader(client_id=client_id, request_id=request_id)


def insertion(request_id: str, x: float = 0.0, client_id: str = "tester") -> pb.InsertRequest:
    """One bead."""
    request = pb.InsertRequest(header=header(request_id, client_id), shape="bead", material="glass")
    request.lattice.origin_m.x = x
    request.lattice.spacing_m.CopyFrom(data_pb2.Vec3(x=1, y=1, z=1))
    request.lattice.count_x = request.lattice.count_y = request.lattice.count_z = 1
    return request


def test_a_repeated_request_is_answered_from_memory(space: sturz.Simulation) -> None:
    first = space.command("insert", insertion("a"))
    once = space.info()
    again = space.command("insert", insertion("a"))
    assert (first.repeated, again.repeated) == (False, True)
    assert again.inserted == first.inserted
    assert (space.info().state_hash, space.info().particles) == (once.state_hash, 1)
    space.command("insert", insertion("b", x=0.1))
    space.command("insert", insertion("a", x=0.2, client_id="another"))
    assert space.info().particles == 3, "other ids and other clients are other requests"


def test_a_refusal_is_remembered_too(space: sturz.Simulation) -> None:
    for _ in range(2):
        with pytest.raises(sturz.CommandError, match="pebble"):
            request = insertion("a")
            request.shape = "pebble"
            space.command("insert", request)


def test_an_id_that_was_used_for_another_request_is_refused(space: sturz.Simulation) -> None:
    space.command("insert", insertion("a"))
    for verb, request in (("insert", insertion("a", x=1.0)), ("step", pb.StepRequest(header=header("a"), steps=1))):
        with pytest.raises(sturz.CommandError) as caught:
            space.command(verb, request)
        assert (caught.value.code, caught.value.path) == (sturz.ErrorCode.REQUEST_ID_REUSED, "header.request_id")
    assert (space.info().particles, space.info().step) == (1, 0)


def test_a_retry_of_a_request_under_way_waits_for_it(space: sturz.Simulation) -> None:
    drop(space)

    def ask() -> pb.Outcome:
        return space.command("step", pb.StepRequest(header=header("long"), steps=200_000))

    calls = [Background(ask) for _ in range(3)]
    outcomes = [call.join(60.0).result for call in calls]
    assert [call.error for call in calls] == [None] * 3
    assert [outcome.stepped.steps_done for outcome in outcomes] == [200_000] * 3  # type: ignore[attr-defined]
    assert sorted(outcome.repeated for outcome in outcomes) == [False, True, True]  # type: ignore[attr-defined]
    assert space.info().step == 200_000


def test_a_timeout_names_the_request_and_asking_again_finds_out(space: sturz.Simulation) -> None:
    drop(space)
    request = pb.StepRequest(header=header("slow"), steps=300_000)
    with pytest.raises(sturz.Timeout, match="'slow'"):
        space.command("step", request, timeout_s=0.02)
    outcome = space.command("step", request)
    assert outcome.repeated
    assert outcome.stepped.steps_done == 300_000
    assert space.info().step == 300_000, "sent three times, done once"


def test_a_repeated_window_brings_its_data_while_the_state_is_still_there(space: sturz.Simulation) -> None:
    drop(space)
    outputs = pb.Outputs(columns=["positions"])
    request = pb.AdvanceRequest(header=header("window"), from_step=0, window_s=1e-3, outputs=outputs)
    first = space.command("advance", request).advanced
    again = space.command("advance", request).advanced
    assert again.frame.columns == first.frame.columns
    assert len(first.frame.columns) == 2
    space.step()
    late = space.command("advance", request).advanced
    assert late.time_reached_s == first.time_reached_s
    assert not late.HasField("frame")


def test_what_is_put_is_answered_by_an_event(space: sturz.Simulation) -> None:
    root = f"sturz/v1/{space.instance}"
    outcomes: dict[str, pb.Outcome] = {}

    def hear(payload: bytes) -> None:
        event = status_pb2.Event.FromString(payload)
        outcomes[event.outcome.request_id or event.outcome.command] = event.outcome

    undeclare = space._bus.subscribe("event/command", hear, missed=lambda count: None)
    bad = insertion("bad")
    bad.material = "cheese"
    with zenoh.open(raw_config(space.endpoint)) as session, space.events() as events:
        for key, payload in (
            ("insert", insertion("good").SerializeToString()),
            ("insert", bad.SerializeToString()),
            ("set_gravity", b"\xff\xff"),
            ("explode", b""),
        ):
            session.put(f"{root}/cmd/{key}", payload)
        wait_until(lambda: len(outcomes) == 4, what="four outcomes")
        seen: list[sturz.Event] = []
        while len([event for event in seen if event.kind is sturz.EventKind.COMMAND]) < 4:
            event = events.next_frame(timeout_s=10.0)
            assert event is not None
            seen.append(event)
    undeclare()
    assert outcomes["good"].inserted.count == 1
    assert outcomes["bad"].error.path == "material"
    assert outcomes["set_gravity"].error.code == pb.ERROR_CODE_UNDECODABLE
    assert outcomes["explode"].error.code == pb.ERROR_CODE_NOT_FOUND
    severities = {event.request_id: event.severity for event in seen if event.kind is sturz.EventKind.COMMAND}
    assert severities["good"] is sturz.Severity.INFO
    assert severities["bad"] is sturz.Severity.WARNING
    assert space.info().particles == 1
    assert space.command("insert", insertion("good")).repeated, "put and get share their memory"
