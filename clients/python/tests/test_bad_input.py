"""Whatever clients send, the state stays as it was, and the answer names the place."""

import os
from typing import Any

import numpy as np
import pytest
import zenoh
from conftest import drop, fill

import sturz
from sturz import columns
from sturz._proto.sturz.v1 import command_pb2 as pb
from sturz._proto.sturz.v1 import data_pb2

NAN, INFINITY = float("nan"), float("inf")


def vec3(x: float, y: float = 0.0, z: float = 0.0) -> data_pb2.Vec3:
    """Three numbers, whatever they are."""
    return data_pb2.Vec3(x=x, y=y, z=z)


def insertion(**placement: Any) -> pb.InsertRequest:
    """Of beads."""
    return pb.InsertRequest(shape="bead", material="glass", **placement)


def lattice(**changes: Any) -> pb.InsertRequest:
    """A good one, but for the changes."""
    good = {"origin_m": vec3(0), "spacing_m": vec3(0.003, 0.003, 0.003), "count_x": 1, "count_y": 1, "count_z": 1}
    return insertion(lattice=pb.LatticePlacement(**{**good, **changes}))


def random(**changes: Any) -> pb.InsertRequest:
    """A good one, but for the changes."""
    box = pb.BoxRegion(min_m=vec3(-0.01, 0.0, -0.01), max_m=vec3(0.01, 0.01, 0.01))
    return insertion(random=pb.RandomPlacement(**{"box": box, "count": 3, **changes}))


def poses(positions: Any, orientations: Any = None) -> pb.InsertRequest:
    """At given places."""
    placement = pb.PosesPlacement(positions_m=columns.encode("positions_m", positions, components=3))
    if orientations is not None:
        placement.orientations_wxyz.CopyFrom(columns.encode("orientations_wxyz", orientations, components=4))
    return insertion(poses=placement)


def changed(request: pb.InsertRequest, **changes: Any) -> pb.InsertRequest:
    """The same with other fields."""
    request.MergeFrom(pb.InsertRequest(**changes))
    return request


def rotation(**changes: Any) -> pb.SetMotionRequest:
    """A good one, but for the changes."""
    good = {"point_m": vec3(0), "axis": vec3(0, 1), "constant": pb.ConstantAngularVelocity(rad_per_s=1.0)}
    return pb.SetMotionRequest(boundary="drum", motion=pb.Motion(rotation=pb.RotationMotion(**{**good, **changes})))


def field(**changes: Any) -> pb.DefineFieldRequest:
    """A good one, but for the changes."""
    grid = data_pb2.Grid(min_m=vec3(0), max_m=vec3(1, 1, 1), cells_x=2, cells_y=2, cells_z=2)
    good = {"name": "f", "grid": grid, "quantities": [data_pb2.FIELD_QUANTITY_DENSITY], "width_m": 0.1}
    return pb.DefineFieldRequest(field=data_pb2.FieldDefinition(**{**good, **changes}))


def advance(**changes: Any) -> pb.AdvanceRequest:
    """A good one, but for the changes."""
    return pb.AdvanceRequest(**{"from_step": 0, "window_s": 1e-3, **changes})


def short_column() -> pb.InsertRequest:
    """Bytes that are no whole rows."""
    request = poses([[0, 0, 0]])
    request.poses.positions_m.data = request.poses.positions_m.data[:-1]
    return request


def wrong_type() -> pb.InsertRequest:
    """Positions as whole numbers."""
    request = poses([[0, 0, 0]])
    request.poses.positions_m.dtype = data_pb2.DATA_TYPE_U64
    return request


# Verb, request, path of the answer.
BAD: dict[str, tuple[str, Any, str]] = {
    "gravity missing": ("set_gravity", pb.SetGravityRequest(), "gravity_m_per_s2"),
    "gravity NaN": ("set_gravity", pb.SetGravityRequest(gravity_m_per_s2=vec3(0, NAN)), "gravity_m_per_s2"),
    "gravity infinite": ("set_gravity", pb.SetGravityRequest(gravity_m_per_s2=vec3(INFINITY)), "gravity_m_per_s2"),
    "placement missing": ("insert", insertion(), "placement"),
    "shape unknown": ("insert", changed(lattice(), shape="pebble"), "shape"),
    "material unknown": ("insert", changed(lattice(), material="cheese"), "material"),
    "material without density": ("insert", changed(lattice(), material="steel"), "material"),
    "velocity NaN": ("insert", changed(lattice(), velocity_m_per_s=vec3(NAN)), "velocity_m_per_s"),
    "scale zero": ("insert", changed(lattice(), scale=pb.ScaleRange(min=0, max=1)), "scale"),
    "scale reversed": ("insert", changed(lattice(), scale=pb.ScaleRange(min=2, max=1)), "scale"),
    "scale NaN": ("insert", changed(lattice(), scale=pb.ScaleRange(min=1, max=NAN)), "scale.max"),
    "lattice origin NaN": ("insert", lattice(origin_m=vec3(0, 0, NAN)), "placement.lattice.origin_m"),
    "a million insertions": (
        "insert",
        lattice(count_x=1000, count_y=1000, count_z=1000),
        "placement.lattice.count_x",
    ),
    "position NaN": ("insert", poses([[0, 0, 0], [0, NAN, 0]]), "placement.poses.positions_m[1][1]"),
    "quaternion zero": ("insert", poses([[0, 0, 0]], [[0, 0, 0, 0]]), "placement.poses.orientations_wxyz[0]"),
    "a quaternion too few": (
        "insert",
        poses([[0, 0, 0], [0.004, 0, 0]], [[1, 0, 0, 0]]),
        "placement.poses.orientations_wxyz",
    ),
    "short column": ("insert", short_column(), "placement.poses.positions_m"),
    "column of another type": ("insert", wrong_type(), "placement.poses.positions_m"),
    "amount missing": ("insert", insertion(random=pb.RandomPlacement(box=pb.BoxRegion())), "placement.random"),
    "box reversed": (
        "insert",
        random(box=pb.BoxRegion(min_m=vec3(1, 1, 1), max_m=vec3(0, 0, 0))),
        "placement.random",
    ),
    "solid fraction above one": ("insert", random(solid_fraction=1.5), "placement.random.solid_fraction"),
    "more than fit": ("insert", random(count=5000, attempts=20), "placement.random"),
    "unknown id": ("remove", pb.RemoveRequest(ids=[0, 12345]), "ids[1]"),
    "unknown boundary": ("set_motion", pb.SetMotionRequest(boundary="lid", motion=rotation().motion), "boundary"),
    "motion missing": ("set_motion", pb.SetMotionRequest(boundary="drum"), "motion"),
    "rotation NaN": (
        "set_motion",
        rotation(constant=pb.ConstantAngularVelocity(rad_per_s=NAN)),
        "motion.rotation.constant.rad_per_s",
    ),
    "axis zero": ("set_motion", rotation(axis=vec3(0)), "motion.rotation.axis"),
    "ramp backwards": (
        "set_motion",
        rotation(ramp=pb.RampAngularVelocity(rad_per_s=1, duration_s=-1)),
        "motion.rotation.ramp.duration_s",
    ),
    "steps zero": ("step", pb.StepRequest(steps=0), "steps"),
    "window negative": ("advance", advance(window_s=-1), "window_s"),
    "window NaN": ("advance", advance(window_s=NAN), "window_s"),
    "window from elsewhere": ("advance", advance(from_step=99), "from_step"),
    "window from nowhere": ("advance", pb.AdvanceRequest(window_s=1e-3), "from"),
    "unknown column": ("advance", advance(outputs=pb.Outputs(columns=["colour"])), "outputs.columns[0]"),
    "unknown field": ("advance", advance(outputs=pb.Outputs(fields=["none"])), "outputs.fields[0]"),
    "field missing": ("define_field", pb.DefineFieldRequest(), "field"),
    "field name with a slash": ("define_field", field(name="a/b"), "field.name"),
    "field without cells": (
        "define_field",
        field(grid=data_pb2.Grid(min_m=vec3(0), max_m=vec3(1, 1, 1), cells_x=0, cells_y=1, cells_z=1)),
        "field.grid",
    ),
    "field with too many cells": (
        "define_field",
        field(grid=data_pb2.Grid(min_m=vec3(0), max_m=vec3(1, 1, 1), cells_x=9000, cells_y=9000, cells_z=9000)),
        "field.grid",
    ),
    "field width NaN": ("define_field", field(width_m=NAN), "field.width_m"),
    "field of nothing": ("define_field", field(quantities=[]), "field.quantities"),
    "unknown field dropped": ("drop_field", pb.DropFieldRequest(name="none"), "name"),
    "time NaN": (
        "set_gravity",
        pb.SetGravityRequest(header=pb.CommandHeader(at_time_s=NAN), gravity_m_per_s2=vec3(1)),
        "header.at_time_s",
    ),
    "time for a pause": ("pause", pb.PauseRequest(header=pb.CommandHeader(at_time_s=1.0)), "header.at_time_s"),
    "client id too long": (
        "pause",
        pb.PauseRequest(header=pb.CommandHeader(client_id="x" * 65)),
        "header.client_id",
    ),
}


@pytest.fixture(scope="module")
def populated() -> Any:
    """A drum with particles that no test here may change."""
    from conftest import DRUM

    with sturz.launch(scene_text=DRUM) as simulation:
        fill(simulation, beads=10, crosses=3)
        yield simulation


@pytest.mark.parametrize("case", BAD)
def test_a_bad_command_is_refused_with_its_path_and_changes_nothing(populated: sturz.Simulation, case: str) -> None:
    verb, original, path = BAD[case]
    request = type(original).FromString(original.SerializeToString())
    before = populated.info()
    with pytest.raises(sturz.CommandError) as caught:
        populated.command(verb, request, timeout_s=20.0)
    error = caught.value
    assert error.code in (
        sturz.ErrorCode.INVALID_INPUT,
        sturz.ErrorCode.TOO_LARGE,
        sturz.ErrorCode.NOT_FOUND,
        sturz.ErrorCode.WRONG_TIME,
    )
    assert error.path.startswith(path), str(error)
    assert len(error.message) > 5, "it says what is wrong"
    assert error.command == verb
    after = populated.info()
    assert (after.state_hash, after.step, after.particles, after.fields, after.state) == (
        before.state_hash,
        before.step,
        before.particles,
        before.fields,
        before.state,
    )


VERBS = [name for name in pb.DESCRIPTOR.message_types_by_name if name.endswith("Request")]
VERBS = ["".join("_" + c.lower() if c.isupper() else c for c in name.removesuffix("Request"))[1:] for name in VERBS]


@pytest.mark.parametrize("verb", VERBS)
def test_bytes_that_are_no_request_are_answered_and_change_nothing(populated: sturz.Simulation, verb: str) -> None:
    before = populated.info().state_hash
    # no field number; a header longer than the message. Random bytes alone are now and then a message of unknown fields
    for payload in (b"\xff" * 40, b"\x0a\x7f" + os.urandom(100)):
        outcome = pb.Outcome.FromString(populated._bus.ask(f"cmd/{verb}", payload=payload, timeout_s=10.0))
        assert outcome.error.code == pb.ERROR_CODE_UNDECODABLE
        assert outcome.command == verb
        assert verb in outcome.error.message
    assert populated.info().state_hash == before


def test_an_unknown_command_is_answered(populated: sturz.Simulation) -> None:
    with pytest.raises(sturz.CommandError, match="explode") as caught:
        populated.command("explode", pb.PauseRequest(), timeout_s=10.0)
    assert caught.value.code is sturz.ErrorCode.NOT_FOUND


@pytest.mark.parametrize("key", ["field/none/latest", "shapes/99", "state/latest?float=f16", "state/latest?columns=x"])
def test_a_question_about_what_is_not_there_is_answered(populated: sturz.Simulation, key: str) -> None:
    with pytest.raises(sturz.CommandError) as caught:
        populated._bus.ask(key, timeout_s=10.0)
    assert caught.value.code is sturz.ErrorCode.NOT_FOUND
    assert caught.value.command == key


def test_a_key_that_nobody_answers_says_so_while_the_daemon_lives(populated: sturz.Simulation) -> None:
    with pytest.raises(sturz.NoAnswer, match="nonsense"):
        populated._bus.ask("nonsense", timeout_s=10.0)
    assert populated.info().particles == 13


def test_a_message_over_the_limit_is_refused(populated: sturz.Simulation) -> None:
    before = populated.info().state_hash
    limit = populated.features().limits.message_bytes
    count = limit // 24 + 10
    request = insertion(poses=pb.PosesPlacement(positions_m=columns.encode("p", np.zeros((count, 3)), components=3)))
    with pytest.raises(sturz.CommandError, match=str(limit)) as caught:
        populated.command("insert", request, timeout_s=60.0)
    assert caught.value.code is sturz.ErrorCode.TOO_LARGE
    assert populated.info().state_hash == before


@pytest.mark.parametrize("ids", [[1.5], [-1], ["a"]])
def test_ids_that_are_no_ids_do_not_leave_the_client(populated: sturz.Simulation, ids: list[Any]) -> None:
    with pytest.raises((ValueError, TypeError)):
        populated.remove(ids=ids)


def test_arguments_that_contradict_do_not_leave_the_client(populated: sturz.Simulation) -> None:
    region = sturz.Box((0, 0, 0), (1, 1, 1))
    for count, solid_fraction in ((None, None), (1, 0.1)):
        with pytest.raises(ValueError, match="either count or solid_fraction"):
            populated.insert_random(
                shape="bead", material="glass", region=region, count=count, solid_fraction=solid_fraction
            )
    with pytest.raises(ValueError, match="positions_m has the shape"):
        populated.insert_poses(shape="bead", material="glass", positions_m=[0, 0, 0])


def test_the_daemon_lives_on_after_a_flood_of_rubbish(space: sturz.Simulation) -> None:
    drop(space)
    before = space.info().state_hash
    with zenoh.open(raw_config(space.endpoint)) as session:
        for number in range(3000):
            verb = VERBS[number % len(VERBS)]
            session.put(f"sturz/v1/{space.instance}/cmd/{verb}", b"\xff" * (1 + number % 50))
        session.put(f"sturz/v1/{space.instance}/cmd/step", os.urandom(1_000_000))
    assert space.info().state_hash == before
    space.advance(window_s=1e-3)


def raw_config(endpoint: str) -> zenoh.Config:
    """Of a client that knows nothing of the package."""
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", f'["{endpoint}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    return config
