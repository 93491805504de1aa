"""Messages between a `KratosProcess` and its worker: a JSON header and numpy arrays, framed by multiprocessing.

Arrays travel as .npz without pickles: both interpreters may have other numpy versions, and no code is carried over.
"""

from __future__ import annotations

import io
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

Message = tuple[dict[str, Any], dict[str, NDArray[np.float64]]]
_HEADER = "header"


def encode(header: dict[str, Any], arrays: dict[str, NDArray[np.float64]] | None = None) -> bytes:
    """A message as bytes."""
    buffer = io.BytesIO()
    text = np.frombuffer(json.dumps(header).encode(), np.uint8)
    columns: dict[str, Any] = {_HEADER: text, **(arrays or {})}
    np.savez(buffer, **columns)
    return buffer.getvalue()


def decode(message: bytes) -> Message:
    """Header and arrays of a message."""
    with np.load(io.BytesIO(message), allow_pickle=False) as file:
        header = json.loads(file[_HEADER].tobytes())
        return header, {name: file[name] for name in file.files if name != _HEADER}
