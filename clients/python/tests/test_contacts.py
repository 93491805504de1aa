"""The contact network and the forces of particles, by query, by window and by stream."""

import numpy as np
import pytest
from conftest import SPACE, drop, fill, wait_until

import sturz

STIFFNESS_N_PER_M = 1e3


def two_beads(simulation: sturz.Simulation) -> None:
    """Two beads of 1 mm at rest that overlap by 0.1 mm along x."""
    drop(simulation, positions_m=[[0, 0, 0], [1.9e-3, 0, 0]])


def test_two_beads_press_by_stiffness_times_overlap(space: sturz.Simulation) -> None:
    two_beads(space)
    contacts = space.contacts()
    assert (len(contacts), contacts.step) == (1, 0)
    assert contacts.ids.tolist() == [[0, 1]]
    assert contacts.boundaries.tolist() == [sturz.NO_BOUNDARY]
    assert not contacts.is_with_boundary.any()
    assert contacts.kinds.tolist() == [sturz.ContactKind.SMOOTH]
    assert contacts.point_counts.tolist() == [1]
    assert contacts.parts.tolist() == [[0, 0]]
    # 1.9 mm and 2 mm are rounded to 2e-19 m
    np.testing.assert_allclose(contacts.overlaps_m, 1e-4, rtol=1e-14)
    np.testing.assert_allclose(contacts.points_m, [[0.95e-3, 0, 0]], atol=1e-18)
    np.testing.assert_allclose(contacts.normals, [[1, 0, 0]], rtol=1e-15)
    np.testing.assert_allclose(contacts.normal_forces_n, STIFFNESS_N_PER_M * contacts.overlaps_m, rtol=1e-14)
    np.testing.assert_allclose(contacts.tangential_forces_n, 0, atol=1e-16)
    assert not contacts.moments_n_m.any()
    state = space.state(columns=["forces", "torques"])
    on_a = contacts.forces_on_a_n()[0]
    np.testing.assert_allclose(state.forces_n, [on_a, -on_a], rtol=1e-14)
    assert not state.torques_n_m.any()
    assert contacts.rows_of(1).tolist() == [0]
    assert contacts.rows_of(2).tolist() == []
    assert contacts.rows_of(1, 0).tolist() == [0]
    assert contacts.rows_of(1, 2).tolist() == []


def test_columns_are_chosen_and_may_be_narrow(space: sturz.Simulation) -> None:
    two_beads(space)
    contacts = space.contacts(columns=["points"], float_type="f32")
    assert list(contacts.columns) == ["ids", "boundaries", "points"]
    assert contacts.points_m.dtype == np.float32
    with pytest.raises(sturz.ColumnMissing, match="no column 'normals' was asked for"):
        _ = contacts.normals
    with pytest.raises(sturz.CommandError, match="colour"):
        space.contacts(columns=["colour"])
    assert "forces" not in space.state().columns
    assert {"forces", "torques"} <= space.state(columns=["all"]).columns.keys()
    features = space.features()
    assert "forces" in features.columns
    assert features.contact_columns == tuple(space.contacts().columns)


def test_rows_add_up_to_the_forces_of_particles_and_boundaries(drum: sturz.Simulation) -> None:
    fill(drum)
    window = drum.advance(window_s=0.05, columns=["forces"], contacts=True)
    contacts, state = window.contacts, window.state
    assert contacts is not None
    assert state is not None
    assert contacts.step == state.step
    assert contacts.is_with_boundary.any()
    on_a, total = contacts.forces_on_a_n(), np.zeros((len(state), 3))
    row = {int(particle): k for k, particle in enumerate(state.ids)}
    at_drum = np.zeros(3)
    for (a, b), force in zip(contacts.ids.tolist(), on_a, strict=True):
        total[row[a]] += force
        if b == sturz.NO_PARTICLE:
            at_drum -= force
        else:
            total[row[b]] -= force
    # sums of some ten terms each, of a hundred for the drum
    largest = np.abs(on_a).max()
    np.testing.assert_allclose(total, state.forces_n, atol=1e-13 * largest)
    np.testing.assert_allclose(at_drum, state.boundaries[0].force_n, atol=1e-12 * largest)
    assert drum.advance(window_s=1e-4).contacts is None


def test_nobody_listens_and_nothing_is_computed() -> None:
    # contacts and forces at every step, if anybody would have them
    output = '[output]\nstate_columns = ["forces"]\nstate_every_steps = 1\ncontacts_every_steps = 1\n'
    with sturz.launch(scene_text=SPACE + output) as simulation:
        two_beads(simulation)
        simulation.step(steps=100)
        counts = simulation.report().streams
        assert (counts["state"].offered, counts["contacts"].offered) == (0, 0)
        with simulation.contact_networks() as networks, simulation.states() as states:
            first, state = networks.next_frame(5.0), states.next_frame(5.0)
            assert first is not None
            assert state is not None
            assert list(state.columns) == ["ids", "forces"]
            simulation.step(steps=100)
        counts = simulation.report().streams
        assert counts["contacts"].offered > 0
        assert counts["state"].offered > 0


def test_a_stream_of_contacts_has_numbers_without_gaps_and_the_steps_of_its_pace(space: sturz.Simulation) -> None:
    two_beads(space)
    space.define_output("contacts", columns=["normal_forces"], float_type="f32", every_steps=10)
    with space.contact_networks(keep=1000) as networks:
        assert networks.next_frame(5.0) is not None
        for _ in range(5):
            space.step(steps=10)
            # one at a time: the daemon may overwrite what it has not yet published
            step = space.info().step
            frame = networks.next_frame(5.0)
            while frame is not None and frame.step != step:
                frame = networks.next_frame(5.0)
            assert frame is not None
            assert list(frame.columns) == ["ids", "boundaries", "normal_forces"]
            assert frame.normal_forces_n.dtype == np.float32
        assert networks.dropped_on_the_way == 0


def test_outputs_are_told_and_go_back_to_those_of_the_scene(space: sturz.Simulation) -> None:
    before = {output.stream: output for output in space.info().outputs}
    assert set(before) == {"state", "contacts", "report"}
    assert before["state"].every_wall_s == pytest.approx(0.1)
    assert "forces" not in before["state"].columns
    with space.events() as events:
        space.define_output("state", columns=["positions", "forces"], float_type="f32", every_sim_s=1e-3)
        event = events.next_frame(5.0)
        while event is not None and event.kind is not sturz.EventKind.OUTPUT:
            event = events.next_frame(5.0)
    now = next(output for output in space.info().outputs if output.stream == "state")
    assert now == sturz.Output("state", ("ids", "positions", "forces"), "f32", None, None, 1e-3)
    assert event is not None
    assert event.output == now
    space.define_output("state")
    assert {output.stream: output for output in space.info().outputs} == before


def test_bad_outputs_are_refused_with_their_path(space: sturz.Simulation) -> None:
    refused = [
        ({"stream": "states"}, "output.stream"),
        ({"stream": "field/nothing"}, "output.stream"),
        ({"stream": "state", "columns": ["positions", "colour"]}, "output.columns[1]"),
        ({"stream": "report", "columns": ["energy"]}, "output.columns"),
        ({"stream": "state", "every_steps": 0}, "output.every_steps"),
        ({"stream": "state", "every_wall_s": 1e-9}, "output.every_wall_s"),
        ({"stream": "contacts", "every_sim_s": float("nan")}, "output.every_sim_s"),
    ]
    for arguments, path in refused:
        with pytest.raises(sturz.CommandError) as error:
            space.define_output(**arguments)  # type: ignore[arg-type]
        assert error.value.path == path
    with pytest.raises(ValueError, match="give one pace, not every_steps and every_sim_s"):
        space.define_output("state", every_steps=1, every_sim_s=1.0)


def test_several_subscribers_get_the_same_frames(space: sturz.Simulation) -> None:
    two_beads(space)
    space.define_output("state", columns=["forces"], every_sim_s=1e-4)
    with (
        sturz.connect(space.instance, endpoint=space.endpoint) as other,
        space.states(keep=100) as mine,
        other.states(keep=100) as theirs,
    ):
        wait_until(lambda: mine.received and theirs.received, what="a frame for each")
        space.step(steps=10)
        frames = []
        for stream in (mine, theirs):
            frame = stream.next_frame(5.0)
            while frame is not None and frame.step != 10:
                frame = stream.next_frame(5.0)
            assert frame is not None
            frames.append(frame)
    assert frames[0].header.seq == frames[1].header.seq
    np.testing.assert_array_equal(frames[0].forces_n, frames[1].forces_n)


def test_a_field_may_go_out_in_part_and_narrow(space: sturz.Simulation) -> None:
    two_beads(space)
    grid = {"min_m": [-0.1] * 3, "max_m": [0.1] * 3, "cells": [2, 2, 2]}
    space.define_field(name="f", **grid, quantities=["density", "velocity"], width_m=0.05)  # type: ignore[arg-type]
    space.define_output("field/f", columns=["velocity"], float_type="f32", every_steps=5)
    with space.fields("f") as fields:
        sample = fields.next_frame(5.0)
    assert sample is not None
    assert list(sample.columns) == ["velocity"]
    assert sample.columns["velocity"].dtype == np.float32
    with pytest.raises(sturz.CommandError) as error:
        space.define_output("field/f", columns=["momentum"])
    assert error.value.path == "output.columns[0]"
