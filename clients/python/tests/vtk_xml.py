"""Reads VTK's XML files with Python's own parser: what our writer claims is checked without our writer."""

from __future__ import annotations

import base64
import zlib
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

_TYPES = {"Float32": "<f4", "Float64": "<f8", "Int32": "<i4", "Int64": "<i8"}


@dataclass
class VtkFile:
    """Arrays by section (`PointData`, `CellData`, `Points`, `Polys`, ...) and name; attributes of the piece."""

    kind: str
    attributes: dict[str, str]
    sections: dict[str, dict[str, NDArray[np.generic]]]
    time_s: float

    def triangles_of(self, name: str, value: int) -> NDArray[np.float64]:
        """Corners of the triangles whose points have this value: (n, 3, 3)."""
        points = self.sections["Points"]["Points"]
        corners = self.sections["Polys"]["connectivity"].reshape(-1, 3)
        return points[corners[self.sections["PointData"][name][corners[:, 0]] == value]].astype(float)


def volume(triangles: NDArray[np.float64]) -> float:
    """Volume inside a closed surface, by the divergence theorem."""
    a, b, c = (triangles - triangles.mean(axis=(0, 1)))[:, 0:3].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def _decode(text: str, compressed: bool) -> bytes:
    """Bytes of an array that begins at the start of `text`."""

    def words(n_bytes: int) -> str:
        return text[: -(-n_bytes // 3) * 4]

    if not compressed:
        (length,) = np.frombuffer(base64.b64decode(words(8))[:8], "<u8")
        return base64.b64decode(words(8 + int(length)))[8 : 8 + int(length)]
    (blocks,) = np.frombuffer(base64.b64decode(words(8))[:8], "<u8")
    head = words(8 * (3 + int(blocks)))
    _, block_size, rest, *sizes = (int(word) for word in np.frombuffer(base64.b64decode(head), "<u8"))
    text = text[len(head) :]
    data = base64.b64decode(words(sum(sizes)))
    parts, start = [], 0
    for size in sizes:
        parts.append(zlib.decompress(data[start : start + size]))
        start += size
    if parts:
        assert all(len(part) == block_size for part in parts[:-1])
        assert len(parts[-1]) == (rest or block_size)
    return b"".join(parts)


def read(path: Path) -> VtkFile:
    """A .vtp or .vti file."""
    root = ElementTree.parse(path).getroot()
    assert root.get("byte_order") == "LittleEndian"
    assert root.get("header_type") == "UInt64"
    appended = root.findtext("AppendedData", "").strip()
    assert not appended or appended[0] == "_"
    body = root[0]
    piece = body.find("Piece")
    assert piece is not None
    sections: dict[str, dict[str, NDArray[np.generic]]] = {}
    for section in piece:
        arrays = sections.setdefault(section.tag, {})
        for array in section:
            dtype = _TYPES[str(array.get("type"))]
            if array.get("format") == "ascii":
                values = np.array((array.text or "").split(), dtype=dtype)
            else:
                start = 1 + int(str(array.get("offset")))
                values = np.frombuffer(_decode(appended[start:], bool(root.get("compressor"))), dtype)
            components = int(str(array.get("NumberOfComponents")))
            arrays[str(array.get("Name"))] = values.reshape(-1, components) if components > 1 else values
    time = body.findtext("FieldData/DataArray")
    assert time is not None
    file = VtkFile(root.get("type") or "", {**body.attrib, **piece.attrib}, sections, float(time))
    _check_lengths(file)
    return file


def _check_lengths(file: VtkFile) -> None:
    """Every array has a row per point or cell, and cells refer to points that exist."""
    if file.kind == "ImageData":
        extent = [int(word) for word in file.attributes["Extent"].split()]
        cells = int(np.prod([extent[1], extent[3], extent[5]]))
        assert all(len(array) == cells for array in file.sections["CellData"].values())
        return
    points = int(file.attributes["NumberOfPoints"])
    assert file.sections["Points"]["Points"].shape == (points, 3)
    assert all(len(array) == points for array in file.sections["PointData"].values())
    cells = 0
    for kind in ("Verts", "Lines", "Polys"):
        n = int(file.attributes[f"NumberOf{kind}"])
        cells += n
        if kind in file.sections:
            offsets, corners = file.sections[kind]["offsets"], file.sections[kind]["connectivity"]
            assert len(offsets) == n
            assert len(corners) == (offsets[-1] if n else 0)
            assert not len(corners) or (corners.min() >= 0 and corners.max() < points)
    assert all(len(array) == cells for array in file.sections["CellData"].values())


def series(path: Path) -> dict[float, VtkFile]:
    """The files of a .pvd by their times."""
    root = ElementTree.parse(path).getroot()
    files = {float(entry.attrib["timestep"]): read(path.parent / entry.attrib["file"]) for entry in root[0]}
    for time_s, file in files.items():
        assert file.time_s == time_s
    return files
