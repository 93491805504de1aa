"""States and shapes as arrays."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import sturz
from sturz import columns
from sturz._proto.sturz.v1 import data_pb2 as pb
from sturz.state import rotation_matrices

COMPONENT = st.floats(-1.0, 1.0)


def test_columns_are_found_by_name_and_missing_ones_say_so() -> None:
    message = pb.Frame(n=2)
    message.header.step, message.header.sim_time_s, message.header.topology_epoch = 5, 0.25, 1
    message.columns.append(columns.encode("ids", [3, 8], components=1, dtype=pb.DATA_TYPE_U64))
    message.columns.append(columns.encode("velocities", [[3, 4, 0], [0, 0, -2]], components=3, unit="m/s"))
    message.boundaries.add(name="drum", angle_rad=1.5)
    state = sturz.State.from_message(pb.Frame.FromString(message.SerializeToString()))
    assert (len(state), state.step, state.time_s, state.header.topology_epoch) == (2, 5, 0.25, 1)
    assert state.ids.tolist() == [3, 8]
    np.testing.assert_allclose(state.speeds_m_per_s, [5.0, 2.0])
    assert state.boundaries[0].angle_rad == 1.5
    with pytest.raises(sturz.ColumnMissing, match="no column 'positions' was asked for; there are ids, velocities"):
        _ = state.positions_m


def test_a_column_of_another_length_is_refused() -> None:
    message = pb.Frame(n=3)
    message.columns.append(columns.encode("ids", [3, 8], components=1, dtype=pb.DATA_TYPE_U64))
    with pytest.raises(sturz.ProtocolError, match="2 rows instead of 3"):
        sturz.State.from_message(message)


@given(st.tuples(*[COMPONENT] * 4).filter(lambda q: np.linalg.norm(q) > 0.1), st.tuples(*[COMPONENT] * 3))
def test_matrices_turn_vectors_as_their_quaternions_do(
    quaternion: tuple[float, ...], vector: tuple[float, ...]
) -> None:
    unit, v = np.array(quaternion) / np.linalg.norm(quaternion), np.array(vector)
    w, u = unit[0], unit[1:]
    # v + 2 w (u x v) + 2 u x (u x v); both ways differ by rounding alone.
    expected = v + 2 * w * np.cross(u, v) + 2 * np.cross(u, np.cross(u, v))
    matrix = rotation_matrices(unit[None])[0]
    np.testing.assert_allclose(matrix @ v, expected, atol=1e-14)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-14)
