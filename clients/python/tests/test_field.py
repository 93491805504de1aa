"""Grids, definitions and sampled fields as arrays, and means over frames."""

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


@given(
    low=st.tuples(*[COORDINATES] * 3),
    high=st.tuples(*[COORDINATES] * 3),
    cells=st.tuples(*[st.integers(0, 2**32 - 1)] * 3),
    quantities=st.lists(st.sampled_from(sorted(QUANTITIES)), unique=True),
    width_m=st.floats(1e-9, 1e3),
    cutoff_widths=st.none() | st.floats(0.1, 10.0),
)
def test_definitions_come_back_from_the_wire(
    low: tuple[float, float, float],
    high: tuple[float, float, float],
    cells: tuple[int, int, int],
    quantities: list[str],
    width_m: float,
    cutoff_widths: float | None,
) -> None:
    definition = sturz.FieldDefinition("f", sturz.Grid(low, high, cells), tuple(quantities), width_m, cutoff_widths)
    sent = pb.FieldDefinition.FromString(definition.to_message().SerializeToString())
    assert sturz.FieldDefinition.from_message(sent) == definition


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
