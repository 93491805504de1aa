"""Columns of the wire to numpy arrays and back. Little-endian, row-major."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._proto.sturz.v1 import data_pb2 as pb
from .errors import ProtocolError

DTYPES: dict[pb.DataType, np.dtype[Any]] = {
    pb.DATA_TYPE_F64: np.dtype("<f8"),
    pb.DATA_TYPE_F32: np.dtype("<f4"),
    pb.DATA_TYPE_U64: np.dtype("<u8"),
    pb.DATA_TYPE_U32: np.dtype("<u4"),
}


def decode(column: pb.Column, rows: int | None = None) -> NDArray[Any]:
    """Array of shape (rows,) or (rows, components), read-only because it shares memory with the message.

    Raises:
        ProtocolError: unknown type, or another length than `rows` ask for.
    """
    dtype = DTYPES.get(column.dtype)
    if dtype is None:
        raise ProtocolError(f"column {column.name!r} has the unknown type {column.dtype}")
    components = column.components
    row_bytes = dtype.itemsize * components
    if row_bytes == 0 or len(column.data) % row_bytes != 0:
        raise ProtocolError(f"column {column.name!r}: {len(column.data)} bytes are no whole rows of {row_bytes} bytes")
    found = len(column.data) // row_bytes
    if rows is not None and found != rows:
        raise ProtocolError(f"column {column.name!r} has {found} rows instead of {rows}")
    values = np.frombuffer(column.data, dtype=dtype)
    return values if components == 1 else values.reshape(found, components)


def encode(
    name: str, values: ArrayLike, *, components: int, unit: str = "", dtype: pb.DataType = pb.DATA_TYPE_F64
) -> pb.Column:
    """Column from an array of shape (rows,) for one component, else (rows, components).

    Raises:
        ValueError: another shape.
    """
    array = np.ascontiguousarray(values, dtype=DTYPES[dtype])
    if array.size == 0:
        array = array.reshape((0,) if components == 1 else (0, components))
    expected = "(n,)" if components == 1 else f"(n, {components})"
    if array.ndim != (1 if components == 1 else 2) or (components > 1 and array.shape[1] != components):
        raise ValueError(f"{name} has the shape {array.shape}; {expected} is needed")
    return pb.Column(name=name, dtype=dtype, components=components, data=array.tobytes(), unit=unit)


def vec3(name: str, values: ArrayLike) -> pb.Vec3:
    """Message from three numbers.

    Raises:
        ValueError: not three of them.
    """
    array = np.asarray(values, dtype=float)
    if array.shape != (3,):
        raise ValueError(f"{name} has the shape {array.shape}; three numbers are needed")
    return pb.Vec3(x=float(array[0]), y=float(array[1]), z=float(array[2]))


def from_vec3(message: pb.Vec3) -> NDArray[np.float64]:
    """Array of shape (3,)."""
    return np.array([message.x, message.y, message.z])
