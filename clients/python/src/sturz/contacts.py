"""The contact network as numpy arrays."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import columns
from ._proto.sturz.v1 import data_pb2 as pb
from .state import ColumnMissing, Floats, Header

NO_PARTICLE = 2**64 - 1
"""In `Contacts.ids`, where side b is a boundary."""
NO_BOUNDARY = 2**32 - 1
"""In `Contacts.boundaries`, where side b is a particle."""


class ContactKind(enum.IntEnum):
    """What touches."""

    UNSPECIFIED = 0
    SMOOTH = 1
    VERTEX_FACE = 2
    EDGE_EDGE = 3
    MANIFOLD = 4
    OVERLAP = 5

    @classmethod
    def _missing_(cls, value: object) -> ContactKind:
        return cls.UNSPECIFIED


@dataclass(frozen=True, eq=False)
class Contacts:
    """Who touches whom at one step: a row per pair of convex parts, in ascending order of the ids.

    Side a is the particle with the lower id, side b the other particle or a boundary. On a acts
    ``tangential_forces_n - normal_forces_n[:, None] * normals``, and about its centre that force at `points_m` and
    `moments_n_m`; on b the opposite of all. Arrays are read-only. Columns that were not asked for raise
    `ColumnMissing`.

    Attributes:
        header: step, time, run.
        columns: arrays by their names on the wire.
    """

    header: Header
    columns: dict[str, NDArray[Any]]

    @classmethod
    def from_message(cls, message: pb.ContactFrame) -> Contacts:
        return cls(
            header=Header.from_message(message.header),
            columns={column.name: columns.decode(column, message.n) for column in message.columns},
        )

    def _column(self, name: str) -> NDArray[Any]:
        try:
            return self.columns[name]
        except KeyError:
            raise ColumnMissing(f"no column {name!r} was asked for; there are {', '.join(self.columns)}") from None

    def __len__(self) -> int:
        return len(self.ids)

    def __repr__(self) -> str:
        return f"Contacts(step={self.step}, time_s={self.time_s:g}, n={len(self)}, columns={list(self.columns)})"

    @property
    def step(self) -> int:
        """Steps done."""
        return self.header.step

    @property
    def time_s(self) -> float:
        """Simulated time, s."""
        return self.header.time_s

    @property
    def ids(self) -> NDArray[np.uint64]:
        """Of a and b, (n, 2); `NO_PARTICLE` where b is a boundary."""
        return self._column("ids")

    @property
    def boundaries(self) -> NDArray[np.uint32]:
        """Index into `Info.boundaries`, (n,); `NO_BOUNDARY` between particles."""
        return self._column("boundaries")

    @property
    def parts(self) -> NDArray[np.uint32]:
        """Convex parts of a and b, (n, 2); of a mesh the element."""
        return self._column("parts")

    @property
    def points_m(self) -> Floats:
        """Mean of the touching points, weighted by what their springs carry, at the wrapped centre of a, (n, 3), m."""
        return self._column("points")

    @property
    def normals(self) -> Floats:
        """Unit vectors from a to b, (n, 3)."""
        return self._column("normals")

    @property
    def overlaps_m(self) -> Floats:
        """(n,), m; below 0 where cohesion holds parts that are apart."""
        return self._column("overlaps")

    @property
    def normal_forces_n(self) -> Floats:
        """(n,), N: positive where the parts are pushed apart."""
        return self._column("normal_forces")

    @property
    def tangential_forces_n(self) -> Floats:
        """On a, at right angles to the normal, (n, 3), N."""
        return self._column("tangential_forces")

    @property
    def moments_n_m(self) -> Floats:
        """On a about the point, (n, 3), N m: several points' couple, rolling and twisting resistance."""
        return self._column("moments")

    @property
    def kinds(self) -> NDArray[np.uint32]:
        """What touches, (n,): numbers of `ContactKind`."""
        return self._column("kinds")

    @property
    def point_counts(self) -> NDArray[np.uint32]:
        """Touching points, (n,)."""
        return self._column("point_counts")

    @property
    def is_with_boundary(self) -> NDArray[np.bool_]:
        """Whether b is a boundary, (n,)."""
        return np.asarray(self.boundaries != NO_BOUNDARY)

    def forces_on_a_n(self) -> Floats:
        """On a, (n, 3), N; b takes the opposite."""
        forces: Floats = self.tangential_forces_n - self.normal_forces_n[:, None] * self.normals
        return forces

    def rows_of(self, *particle_ids: int) -> NDArray[np.intp]:
        """Indices of the rows that a particle is a side of; of two particles, those of the pair."""
        sides = [(self.ids == np.uint64(each)).any(axis=1) for each in particle_ids]
        return np.flatnonzero(np.logical_and.reduce(sides))
