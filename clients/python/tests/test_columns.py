"""Columns of the wire: every array survives the way there and back, and no bytes are read as what they are not."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from sturz import ProtocolError, columns
from sturz._proto.sturz.v1 import data_pb2 as pb

DTYPES = st.sampled_from(sorted(columns.DTYPES))


@st.composite
def tables(draw: st.DrawFn) -> tuple[pb.DataType, int, np.ndarray]:
    """Type on the wire, components and an array, with NaN, infinities and signed zeros."""
    dtype, components, rows = draw(DTYPES), draw(st.integers(1, 5)), draw(st.integers(0, 20))
    shape = (rows,) if components == 1 else (rows, components)
    return dtype, components, draw(arrays.arrays(columns.DTYPES[dtype], shape))


@given(tables())
def test_arrays_come_back_bit_for_bit(table: tuple[pb.DataType, int, np.ndarray]) -> None:
    dtype, components, values = table
    column = columns.encode("name", values, components=components, unit="m", dtype=dtype)
    sent = pb.Column.FromString(column.SerializeToString())
    back = columns.decode(sent, len(values))
    assert (sent.name, sent.unit, sent.components) == ("name", "m", components)
    assert back.dtype == columns.DTYPES[dtype]
    assert back.shape == values.shape
    assert back.tobytes() == values.tobytes()


@given(DTYPES, st.integers(0, 6), st.binary(max_size=100))
def test_any_bytes_are_whole_rows_or_an_error(dtype: pb.DataType, components: int, data: bytes) -> None:
    column = pb.Column(name="c", dtype=dtype, components=components, data=data)
    row_bytes = columns.DTYPES[dtype].itemsize * components
    if row_bytes == 0 or len(data) % row_bytes:
        with pytest.raises(ProtocolError, match="no whole rows"):
            columns.decode(column)
    else:
        assert columns.decode(column).tobytes() == data


def test_the_wire_is_little_endian_and_row_major() -> None:
    column = columns.encode("positions_m", [[1.0, 2.0, 3.0], [4.0, 5.0, -6.5]], components=3)
    assert column.data == struct.pack("<6d", 1.0, 2.0, 3.0, 4.0, 5.0, -6.5)
    big = np.array([1, 2**40], dtype=">u8")
    assert columns.encode("ids", big, components=1, dtype=pb.DATA_TYPE_U64).data == struct.pack("<2Q", 1, 2**40)
    fortran = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    assert columns.encode("x", fortran, components=3).data == struct.pack("<6d", *range(6))


def test_decoded_arrays_share_memory_and_are_read_only() -> None:
    values = columns.decode(columns.encode("x", [1.0, 2.0], components=1))
    with pytest.raises(ValueError, match="read-only"):
        values[0] = 3.0


def test_another_number_of_rows_and_an_unknown_type_are_errors() -> None:
    column = columns.encode("x", [1.0, 2.0], components=1)
    with pytest.raises(ProtocolError, match="'x' has 2 rows instead of 3"):
        columns.decode(column, 3)
    column.dtype = 77  # type: ignore[assignment]
    with pytest.raises(ProtocolError, match="unknown type 77"):
        columns.decode(column)


@pytest.mark.parametrize(
    ("values", "components"),
    [([1.0, 2.0, 3.0], 3), ([[1.0, 2.0]], 3), ([[1.0], [2.0]], 1), (5.0, 3), (np.zeros((2, 3, 1)), 3)],
)
def test_arrays_of_another_shape_are_refused_by_name(values: object, components: int) -> None:
    with pytest.raises(ValueError, match="positions_m has the shape"):
        columns.encode("positions_m", values, components=components)  # type: ignore[arg-type]


def test_no_rows_are_rows_too() -> None:
    column = columns.encode("positions_m", [], components=3)
    assert columns.decode(column, 0).shape == (0, 3)


@given(st.tuples(*[st.floats(allow_nan=False)] * 3))
def test_vectors_come_back(values: tuple[float, float, float]) -> None:
    assert tuple(columns.from_vec3(columns.vec3("v", values))) == values


@pytest.mark.parametrize("values", [(1.0, 2.0), 3.0, [[1.0, 2.0, 3.0]]])
def test_vectors_have_three_numbers(values: object) -> None:
    with pytest.raises(ValueError, match="gravity_m_per_s2 has the shape"):
        columns.vec3("gravity_m_per_s2", values)  # type: ignore[arg-type]
