"""Grids, definitions and sampled fields as arrays, and means over frames."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import sturz
from sturz import columns
from sturz._proto.sturz.v1 import data_pb2 as pb
from sturz.field import QUANTITIES, grid_from

GRID = sturz.Grid(min_m=(0.0, -1.0, 2.0), max_m=(2.0, 1.0, 5.0), cells=(2, 1, 3))
COORDINATES = st.floats(-1e3, 1e3)


def frame(time_s: float = 0.0, **arrays: object) -> pb.FieldFrame:
    """A sampled field on `GRID`, arrays of shape (2, 1, 3) or (2, 1, 3, 3)."""
    message = pb.FieldFrame(name="drum", kernel="truncated_gaussian", width_m=0.1, cutoff_widths=4.0, total_mass_kg=7.0)
    message.header.step, message.header.sim_time_s, message.header.run_id = 3, time_s, "run"
    message.grid.CopyFrom(sturz.FieldDefinition("drum", GRID, ("density",), 0.1).to_message().grid)
    message.total_momentum_kg_m_per_s.CopyFrom(columns.vec3("p", (1, 2, 3)))
    for name, values in arrays.items():
        array = np.asarray(values, dtype=float)
        components = 3 if array.ndim == 4 else 1
        rows = array.reshape(-1, 3) if components == 3 else array.ravel()
        message.columns.append(columns.encode(name, rows, components=components))
    return message


def test_a_grid_knows_its_axes_edges_and_cells() -> None:
    np.testing.assert_allclose(GRID.axis_m(0), [0.5, 1.5])
    np.testing.assert_allclose(GRID.axis_m(1), [0.0])
    np.testing.assert_allclose(GRID.edges_m(2), [2.0, 3.0, 4.0, 5.0])
    assert GRID.cell_volume_m3 == pytest.approx(2.0)


def test_a_grid_needs_three_numbers_everywhere() -> None:
    with pytest.raises(ValueError, match="cells are"):
        grid_from((0, 0, 0), (1, 1, 1), (1, 2))
    with pytest.raises(ValueError, match="max_m has the shape"):
        grid_from((0, 0, 0), (1, 1), (1, 1, 1))


VECTORS = st.tuples(*[COORDINATES] * 3)
CYLINDERS = st.builds(sturz.GridCylinder, VECTORS, VECTORS, st.none() | VECTORS)
COUNTS = st.integers(0, 2**32 - 1)
AVERAGES = st.builds(
    sturz.FieldAverage, COUNTS, COUNTS, COUNTS, st.sampled_from(["growing", "sliding"]), st.floats(0.0, 1e3)
)
DEFINITIONS = st.builds(
    sturz.FieldDefinition,
    name=st.just("f"),
    grid=st.builds(sturz.Grid, VECTORS, VECTORS, st.tuples(COUNTS, COUNTS, COUNTS), st.none() | CYLINDERS),
    quantities=st.lists(st.sampled_from(sorted(QUANTITIES)), unique=True).map(tuple),
    width_m=st.floats(1e-9, 1e3),
    cutoff_widths=st.none() | st.floats(0.1, 10.0),
    kernel=st.sampled_from(["gaussian", "lucy", "heaviside"]),
    more_widths_m=st.lists(st.floats(1e-9, 1e3), max_size=3).map(tuple),
    wall_correction=st.booleans(),
    body_axis=st.sampled_from(["longest", "shortest", "x", "y", "z"]),
    average=st.none() | AVERAGES,
    moves_at_m_per_s=st.none() | VECTORS,
)


@given(definition=DEFINITIONS)
def test_definitions_come_back_from_the_wire(definition: sturz.FieldDefinition) -> None:
    for one in (definition, replace(definition, moves_at_m_per_s=None, moves_with="drum")):
        sent = pb.FieldDefinition.FromString(one.to_message().SerializeToString())
        assert sturz.FieldDefinition.from_message(sent) == one


def test_a_grid_moves_in_one_way_and_names_are_known() -> None:
    both = sturz.FieldDefinition("f", GRID, ("density",), 0.1, moves_at_m_per_s=(1.0, 0.0, 0.0), moves_with="drum")
    with pytest.raises(ValueError, match="exclude each other"):
        both.to_message()
    for name in ("kernel", "body_axis"):
        with pytest.raises(ValueError, match="colour"):
            replace(both, moves_with=None, **{name: "colour"}).to_message()


def test_cells_of_a_cylinder_have_the_volume_of_their_part_of_a_ring() -> None:
    cylinder = sturz.GridCylinder((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    grid = sturz.Grid((1.0, 0.0, 0.0), (3.0, 2 * np.pi, 2.0), (2, 4, 1), cylinder)
    volumes = grid.cell_volumes_m3
    assert volumes.shape == (2, 4, 1)
    np.testing.assert_allclose(volumes[:, 0, 0], [np.pi * 3 * 2 / 4, np.pi * 5 * 2 / 4])
    with pytest.raises(ValueError, match="cell_volumes_m3"):
        _ = grid.cell_volume_m3
    np.testing.assert_allclose(GRID.cell_volumes_m3, 2.0)


def test_an_unknown_quantity_is_refused_with_what_there_is() -> None:
    with pytest.raises(ValueError, match=r"unknown quantities \['colour'\]; there are .*solid_fraction"):
        sturz.FieldDefinition("f", GRID, ("density", "colour"), 0.1).to_message()


def test_arrays_have_the_shape_of_the_grid_x_slowest() -> None:
    message = frame(density=np.arange(6.0).reshape(2, 1, 3), velocity=np.arange(18.0).reshape(2, 1, 3, 3))
    field = sturz.Field.from_message(pb.FieldFrame.FromString(message.SerializeToString()))
    assert field.density_kg_per_m3.shape == (2, 1, 3)
    assert field.velocity_m_per_s.shape == (2, 1, 3, 3)
    assert field.density_kg_per_m3[1, 0, 2] == 5.0
    np.testing.assert_array_equal(field.velocity_m_per_s[1, 0, 0], [9.0, 10.0, 11.0])
    np.testing.assert_allclose(field.z_m, [2.5, 3.5, 4.5])
    assert field.integral("density") == pytest.approx(2.0 * 15.0)
    assert (field.step, field.total_mass_kg) == (3, 7.0)
    with pytest.raises(sturz.ColumnMissing, match="'drum' samples density, velocity, not solid_fraction"):
        _ = field.solid_fraction


def test_tensors_errors_and_widths_are_at_hand() -> None:
    message = frame(density=np.full((2, 1, 3), 2.0), wall_force_density=np.ones((2, 1, 3, 3)))
    stress = np.arange(54.0).reshape(6, 9)
    message.columns.append(columns.encode("stress", stress, components=9))
    message.standard_errors.append(columns.encode("stress", stress / 100, components=9))
    wide = message.more_widths.add(width_m=0.2)
    wide.columns.append(columns.encode("stress", 2 * stress, components=9))
    message.samples, message.blocks, message.from_time_s = 40, 4, 1.5
    field = sturz.Field.from_message(pb.FieldFrame.FromString(message.SerializeToString()))
    assert field.stress_pa.shape == (2, 1, 3, 3, 3)
    np.testing.assert_array_equal(field.stress_pa[0, 0, 1], np.arange(9.0, 18.0).reshape(3, 3))
    np.testing.assert_allclose(field.standard_error("stress"), field.columns["stress"] / 100)
    assert (field.widths_m, field.samples, field.blocks, field.from_time_s) == ((0.1, 0.2), 40, 4, 1.5)
    np.testing.assert_array_equal(field.at_width(0.2).stress_pa, 2 * field.stress_pa)
    with pytest.raises(ValueError, match="has the widths"):
        field.at_width(0.3)
    with pytest.raises(sturz.ColumnMissing, match="no standard error"):
        field.at_width(0.2).standard_error("stress")
    # ones over 5 - 2 = 3 m
    np.testing.assert_allclose(field.wall_traction_pa(across=2), np.full((2, 1, 1, 3), 3.0))
    np.testing.assert_allclose(field.integral("stress"), 2.0 * stress.sum(axis=0))


def test_means_over_frames_are_refused_where_they_would_be_wrong() -> None:
    with pytest.raises(ValueError, match=r"means of \['kinetic_stress'\] need the daemon's own sums"):
        sturz.FieldMean().add(
            sturz.Field.from_message(frame(density=np.ones((2, 1, 3)), kinetic_stress=np.ones((2, 1, 3))))
        )


def test_a_field_of_another_size_than_its_grid_is_refused() -> None:
    message = frame(density=np.zeros((2, 1, 3)))
    message.grid.cells_x = 3
    with pytest.raises(sturz.ProtocolError, match="density has 6 cells instead of 9"):
        sturz.Field.from_message(message)


def test_means_weigh_velocity_and_temperature_by_density() -> None:
    density, shape = np.full((2, 1, 3), 2.0), (2, 1, 3)
    velocity = np.zeros((2, 1, 3, 3))
    velocity[..., 0] = 1.0
    mean = sturz.FieldMean()
    first = frame(density=density, velocity=velocity, granular_temperature=np.full(shape, 4.0))
    second = frame(5.0, density=3 * density, velocity=5 * velocity, granular_temperature=np.full(shape, 8.0))
    mean.add(sturz.Field.from_message(first))
    mean.add(sturz.Field.from_message(second))
    field = mean.field()
    np.testing.assert_allclose(field.density_kg_per_m3, 4.0)
    np.testing.assert_allclose(field.velocity_m_per_s[..., 0], (2 * 1 + 6 * 5) / 8)
    np.testing.assert_allclose(field.granular_temperature_m2_per_s2, (2 * 4 + 6 * 8) / 8)
    assert (mean.frames, field.time_s) == (2, 5.0)


def test_a_mean_over_empty_cells_is_zero_and_over_no_frames_an_error() -> None:
    with pytest.raises(ValueError, match="no frame was added"):
        sturz.FieldMean().field()
    mean = sturz.FieldMean()
    mean.add(sturz.Field.from_message(frame(density=np.zeros((2, 1, 3)), velocity=np.zeros((2, 1, 3, 3)))))
    assert not mean.field().velocity_m_per_s.any()
