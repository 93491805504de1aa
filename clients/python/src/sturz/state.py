"""Particles, boundaries and shapes as numpy arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import columns
from ._proto.sturz.v1 import data_pb2 as pb
from ._proto.sturz.v1 import status_pb2 as status_pb
from .errors import SturzError

Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True)
class Header:
    """Which run, which state, which message.

    Attributes:
        run_id: another one for every start of a daemon.
        seq: counts the messages of one stream; 0 in replies.
        step: steps done by the state.
        time_s: simulated time of the state, s.
        wall_time_ns: wall clock when the state was captured, ns since 1970.
        topology_epoch: counts insertions and removals; ids are the same as long as it is.
    """

    run_id: str
    seq: int
    step: int
    time_s: float
    wall_time_ns: int
    topology_epoch: int

    @classmethod
    def from_message(cls, message: pb.Header) -> Header:
        return cls(
            run_id=message.run_id,
            seq=message.seq,
            step=message.step,
            time_s=message.sim_time_s,
            wall_time_ns=message.wall_time_ns,
            topology_epoch=message.topology_epoch,
        )


@dataclass(frozen=True, eq=False)
class BoundaryState:
    """Where a boundary is, how it moves, and what acts on it.

    Attributes:
        name: in the scene.
        point_m: a point of the plane or of the cylinder's axis, or where a mesh's origin is, now, (3,), m.
        direction: normal of the plane, or direction of the axis, (3,).
        angle_rad: of rotation since the start.
        angular_velocity_rad_per_s: about the axis of its motion.
        force_n: of the particles on it, (3,), N.
        torque_n_m: of the particles on it about `point_m`, (3,), N m.
        orientation_wxyz: world from the frame of a mesh's vertices, (4,).
    """

    name: str
    point_m: NDArray[np.float64]
    direction: NDArray[np.float64]
    angle_rad: float
    angular_velocity_rad_per_s: float
    force_n: NDArray[np.float64]
    torque_n_m: NDArray[np.float64]
    orientation_wxyz: NDArray[np.float64]

    @classmethod
    def from_message(cls, message: pb.BoundaryState) -> BoundaryState:
        return cls(
            name=message.name,
            point_m=columns.from_vec3(message.point_m),
            direction=columns.from_vec3(message.direction),
            angle_rad=message.angle_rad,
            angular_velocity_rad_per_s=message.angular_velocity_rad_per_s,
            force_n=columns.from_vec3(message.force_n),
            torque_n_m=columns.from_vec3(message.torque_n_m),
            orientation_wxyz=np.array([getattr(message.orientation, axis) for axis in "wxyz"]),
        )


class ColumnMissing(SturzError, KeyError):
    """A column that was not asked for."""

    def __str__(self) -> str:
        return str(self.args[0])


@dataclass(frozen=True, eq=False)
class State:
    """The particles at one step, in ascending order of id; row i of every array belongs to `ids[i]`.

    Arrays are read-only; `array.copy()` can be written to. Columns that were not asked for raise `ColumnMissing`.

    Attributes:
        header: step, time, run.
        columns: arrays by their names on the wire.
        boundaries: in the order of the scene.
        gravity_m_per_s2: (3,).
    """

    header: Header
    columns: dict[str, NDArray[Any]]
    boundaries: tuple[BoundaryState, ...]
    gravity_m_per_s2: NDArray[np.float64]

    @classmethod
    def from_message(cls, message: pb.Frame) -> State:
        return cls(
            header=Header.from_message(message.header),
            columns={column.name: columns.decode(column, message.n) for column in message.columns},
            boundaries=tuple(BoundaryState.from_message(boundary) for boundary in message.boundaries),
            gravity_m_per_s2=columns.from_vec3(message.gravity_m_per_s2),
        )

    def _column(self, name: str) -> NDArray[Any]:
        try:
            return self.columns[name]
        except KeyError:
            raise ColumnMissing(f"no column {name!r} was asked for; there are {', '.join(self.columns)}") from None

    def __len__(self) -> int:
        return len(self.ids)

    def __repr__(self) -> str:
        return f"State(step={self.step}, time_s={self.time_s:g}, n={len(self)}, columns={list(self.columns)})"

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
        """Ids, ascending, (n,)."""
        return self._column("ids")

    @property
    def shapes(self) -> NDArray[np.uint32]:
        """Index into `Info.shapes`, (n,)."""
        return self._column("shapes")

    @property
    def materials(self) -> NDArray[np.uint32]:
        """Index into `Info.materials`, (n,)."""
        return self._column("materials")

    @property
    def scales(self) -> Floats:
        """Size relative to the shape, (n,)."""
        return self._column("scales")

    @property
    def positions_m(self) -> Floats:
        """Centres of mass, wrapped into the periodic cell, (n, 3), m."""
        return self._column("positions")

    @property
    def orientations_wxyz(self) -> Floats:
        """Unit quaternions `world_from_body` (w, x, y, z), (n, 4)."""
        return self._column("orientations")

    @property
    def velocities_m_per_s(self) -> Floats:
        """Of the centres of mass, (n, 3), m/s."""
        return self._column("velocities")

    @property
    def angular_velocities_rad_per_s(self) -> Floats:
        """In world axes, (n, 3), rad/s."""
        return self._column("angular_velocities")

    @property
    def forces_n(self) -> Floats:
        """Sum over the contacts as they acted in the last step, (n, 3), N, without gravity and loads. On request."""
        return self._column("forces")

    @property
    def torques_n_m(self) -> Floats:
        """Of the contacts about the centre of mass, world axes, (n, 3), N m. On request."""
        return self._column("torques")

    @property
    def frozen(self) -> NDArray[np.bool_]:
        """Which particles keep their velocity whatever pushes them, (n,). On request."""
        return self._column("frozen").astype(bool)

    @property
    def speeds_m_per_s(self) -> Floats:
        """Of the centres of mass, (n,), m/s."""
        speeds: Floats = np.linalg.norm(self.velocities_m_per_s, axis=1)
        return speeds

    def rotations(self) -> NDArray[np.float64]:
        """Matrices `world_from_body`, (n, 3, 3)."""
        return rotation_matrices(self.orientations_wxyz)


def rotation_matrices(orientations_wxyz: NDArray[Any]) -> NDArray[np.float64]:
    """Matrices (n, 3, 3) of unit quaternions (n, 4)."""
    w, x, y, z = np.asarray(orientations_wxyz, dtype=float).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


@dataclass(frozen=True, eq=False)
class Shape:
    """One shape at scale 1, in the body frame: centre of mass at the origin, axes along the principal axes.

    Attributes:
        name: in the scene.
        kind: as in scene files, such as ``cross_3d``.
        volume_m3: of the union of parts.
        bounding_radius_m: about the centre of mass.
        principal_moments_per_density_m5: (3,).
        vertices_m: of the surface to draw, (v, 3), m.
        triangles: indices of vertices, counter-clockwise seen from outside, (t, 3).
        parameters: numbers that define it, the unit in the name.
        parts: convex parts.
    """

    name: str
    kind: str
    volume_m3: float
    bounding_radius_m: float
    principal_moments_per_density_m5: NDArray[np.float64]
    vertices_m: NDArray[np.float64]
    triangles: NDArray[np.uint32]
    parameters: dict[str, float]
    parts: int

    @classmethod
    def from_message(cls, message: status_pb.Shape) -> Shape:
        return cls(
            name=message.name,
            kind=message.kind,
            volume_m3=message.volume_m3,
            bounding_radius_m=message.bounding_radius_m,
            principal_moments_per_density_m5=columns.from_vec3(message.principal_moments_per_density_m5),
            vertices_m=columns.decode(message.vertices),
            triangles=columns.decode(message.triangles),
            parameters={parameter.name: parameter.value for parameter in message.parameters},
            parts=message.parts,
        )
