"""Coarse-grained fields as numpy arrays on a grid."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from dataclasses import field as dataclass_field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import columns
from ._proto.sturz.v1 import data_pb2 as pb
from .errors import ProtocolError
from .state import ColumnMissing, Header

QUANTITIES: dict[str, pb.FieldQuantity] = {
    name.removeprefix("FIELD_QUANTITY_").lower(): value for name, value in pb.FieldQuantity.items() if value
}
KERNELS: dict[str, pb.FieldKernel] = {
    name.removeprefix("FIELD_KERNEL_").lower(): value for name, value in pb.FieldKernel.items() if value
}
BODY_AXES: dict[str, pb.BodyAxis] = {
    name.removeprefix("BODY_AXIS_").lower(): value for name, value in pb.BodyAxis.items() if value
}
WINDOWS: dict[str, pb.AverageWindow] = {
    name.removeprefix("AVERAGE_WINDOW_").lower(): value for name, value in pb.AverageWindow.items() if value
}

Vector = tuple[float, float, float]


def _tuple(message: Any) -> Vector:
    return (message.x, message.y, message.z)


def _name(names: dict[str, Any], value: int, unspecified: str) -> str:
    return {number: name for name, number in names.items()}.get(value, unspecified if value == 0 else str(value))


def _value(what: str, names: dict[str, Any], name: str) -> Any:
    if name not in names:
        raise ValueError(f"unknown {what} {name!r}; there are {list(names)}")
    return names[name]


@dataclass(frozen=True)
class GridCylinder:
    """Axis of a cylindrical grid.

    Attributes:
        point_m: height 0 on the axis, m.
        axis: its direction.
        zero: where the angle is 0; None: x, or y where the axis is near x.
    """

    point_m: Vector
    axis: Vector
    zero: Vector | None = None


@dataclass(frozen=True)
class Grid:
    """Grid of sample points at cell centres; one cell along an axis averages over the whole extent.

    Attributes:
        min_m: lower corner, m; of a cylindrical grid radius (m), angle (rad) and height (m).
        max_m: upper corner.
        cells: along x, y and z, or radius, angle and height.
        cylinder: of a cylindrical grid.
    """

    min_m: Vector
    max_m: Vector
    cells: tuple[int, int, int]
    cylinder: GridCylinder | None = None

    @classmethod
    def from_message(cls, message: pb.Grid) -> Grid:
        cylinder = None
        if message.HasField("cylinder"):
            wire = message.cylinder
            zero = _tuple(wire.zero) if wire.HasField("zero") else None
            cylinder = GridCylinder(_tuple(wire.point_m), _tuple(wire.axis), zero)
        return cls(
            min_m=_tuple(message.min_m),
            max_m=_tuple(message.max_m),
            cells=(message.cells_x, message.cells_y, message.cells_z),
            cylinder=cylinder,
        )

    def to_message(self) -> pb.Grid:
        message = pb.Grid(
            min_m=columns.vec3("min_m", self.min_m),
            max_m=columns.vec3("max_m", self.max_m),
            cells_x=self.cells[0],
            cells_y=self.cells[1],
            cells_z=self.cells[2],
        )
        if self.cylinder is not None:
            message.cylinder.point_m.CopyFrom(columns.vec3("point_m", self.cylinder.point_m))
            message.cylinder.axis.CopyFrom(columns.vec3("axis", self.cylinder.axis))
            if self.cylinder.zero is not None:
                message.cylinder.zero.CopyFrom(columns.vec3("zero", self.cylinder.zero))
        return message

    def axis_m(self, axis: int) -> NDArray[np.float64]:
        """Cell centres along axis 0, 1 or 2, (cells,), m; of the angle of a cylinder rad."""
        edges = self.edges_m(axis)
        return (edges[1:] + edges[:-1]) / 2

    def edges_m(self, axis: int) -> NDArray[np.float64]:
        """Borders of cells along axis 0, 1 or 2, (cells + 1,), m; of the angle of a cylinder rad."""
        return np.linspace(self.min_m[axis], self.max_m[axis], self.cells[axis] + 1)

    @property
    def cell_volume_m3(self) -> float:
        """Of one cell of a cartesian grid, m3.

        Raises:
            ValueError: the cells of a cylinder are not equal: see `cell_volumes_m3`.
        """
        if self.cylinder is not None:
            raise ValueError("the cells of a cylindrical grid have different volumes: cell_volumes_m3")
        sizes = (np.array(self.max_m) - np.array(self.min_m)) / np.array(self.cells)
        return float(np.prod(sizes))

    @property
    def cell_volumes_m3(self) -> NDArray[np.float64]:
        """Of every cell, (nx, ny, nz), m3."""
        if self.cylinder is None:
            return np.full(self.cells, self.cell_volume_m3)
        rings = np.diff(self.edges_m(0) ** 2) / 2
        across = np.diff(self.edges_m(1))[0] * np.diff(self.edges_m(2))[0]
        return np.asarray(np.broadcast_to((rings * across)[:, None, None], self.cells))


@dataclass(frozen=True)
class FieldAverage:
    """Mean over time, taken by the daemon whether anybody listens or not; its checkpoints hold it.

    Attributes:
        every_steps: steps from one sample to the next: those whose number is a multiple.
        samples_per_block: long enough that blocks know nothing of each other; errors are from the scatter of blocks.
        blocks: how many, at least 2.
        window: ``growing``: over all samples (with twice as many blocks, each two become one); ``sliding``: over the
            last so many blocks and the one that is being filled.
        from_time_s: nothing is sampled before this simulated time, s.
    """

    every_steps: int
    samples_per_block: int
    blocks: int = 20
    window: str = "growing"
    from_time_s: float = 0.0

    @classmethod
    def from_message(cls, message: pb.FieldAverage) -> FieldAverage:
        return cls(
            every_steps=message.every_steps,
            samples_per_block=message.samples_per_block,
            blocks=message.blocks if message.HasField("blocks") else 20,
            window=_name(WINDOWS, message.window, "growing"),
            from_time_s=message.from_time_s,
        )

    def to_message(self) -> pb.FieldAverage:
        return pb.FieldAverage(
            every_steps=self.every_steps,
            samples_per_block=self.samples_per_block,
            blocks=self.blocks,
            window=_value("window", WINDOWS, self.window),
            from_time_s=self.from_time_s,
        )


@dataclass(frozen=True)
class FieldDefinition:
    """What a field samples.

    Attributes:
        name: letters, digits, `_` and `-`.
        grid: where.
        quantities: names as in `QUANTITIES`.
        width_m: coarse-graining width w of the kernel, m.
        cutoff_widths: support of the kernel over its width; None: the daemon's default.
        kernel: ``gaussian``, ``lucy`` or ``heaviside``.
        more_widths_m: further widths, sampled in the same pass, m.
        wall_correction: gives what plane walls cut off a kernel back to its part in front of them.
        body_axis: whose orientation is sampled: ``longest``, ``shortest``, ``x``, ``y`` or ``z`` of the body frame.
        average: mean over time; None: the state of now.
        moves_at_m_per_s: velocity of the grid, which is where it is given at time 0; None: at rest.
        moves_with: name of a boundary that the grid moves with; None: none.
    """

    name: str
    grid: Grid
    quantities: tuple[str, ...]
    width_m: float
    cutoff_widths: float | None = None
    kernel: str = "gaussian"
    more_widths_m: tuple[float, ...] = ()
    wall_correction: bool = False
    body_axis: str = "longest"
    average: FieldAverage | None = None
    moves_at_m_per_s: Vector | None = None
    moves_with: str | None = None

    @classmethod
    def from_message(cls, message: pb.FieldDefinition) -> FieldDefinition:
        names = {value: name for name, value in QUANTITIES.items()}
        motion = message.motion.WhichOneof("motion") if message.HasField("motion") else None
        return cls(
            name=message.name,
            grid=Grid.from_message(message.grid),
            quantities=tuple(names.get(quantity, str(quantity)) for quantity in message.quantities),
            width_m=message.width_m,
            cutoff_widths=message.cutoff_widths if message.HasField("cutoff_widths") else None,
            kernel=_name(KERNELS, message.kernel, "gaussian"),
            more_widths_m=tuple(message.more_widths_m),
            wall_correction=message.wall_correction,
            body_axis=_name(BODY_AXES, message.body_axis, "longest"),
            average=FieldAverage.from_message(message.average) if message.HasField("average") else None,
            moves_at_m_per_s=_tuple(message.motion.translation_m_per_s) if motion == "translation_m_per_s" else None,
            moves_with=message.motion.boundary if motion == "boundary" else None,
        )

    def to_message(self) -> pb.FieldDefinition:
        unknown = [name for name in self.quantities if name not in QUANTITIES]
        if unknown:
            raise ValueError(f"unknown quantities {unknown}; there are {list(QUANTITIES)}")
        if self.moves_at_m_per_s is not None and self.moves_with is not None:
            raise ValueError("moves_at_m_per_s and moves_with exclude each other")
        message = pb.FieldDefinition(
            name=self.name,
            grid=self.grid.to_message(),
            quantities=[QUANTITIES[name] for name in self.quantities],
            width_m=self.width_m,
            kernel=_value("kernel", KERNELS, self.kernel),
            more_widths_m=self.more_widths_m,
            wall_correction=self.wall_correction,
            body_axis=_value("body axis", BODY_AXES, self.body_axis),
            average=None if self.average is None else self.average.to_message(),
        )
        if self.cutoff_widths is not None:
            message.cutoff_widths = self.cutoff_widths
        if self.moves_at_m_per_s is not None:
            message.motion.translation_m_per_s.CopyFrom(columns.vec3("moves_at_m_per_s", self.moves_at_m_per_s))
        if self.moves_with is not None:
            message.motion.boundary = self.moves_with
        return message


def grid_from(min_m: ArrayLike, max_m: ArrayLike, cells: Iterable[int], cylinder: GridCylinder | None = None) -> Grid:
    """Grid from any three numbers each."""
    low, high = columns.vec3("min_m", min_m), columns.vec3("max_m", max_m)
    counts = tuple(int(count) for count in cells)
    if len(counts) != 3:
        raise ValueError(f"cells are {counts}; three numbers are needed")
    return Grid(_tuple(low), _tuple(high), counts, cylinder)


@dataclass(frozen=True, eq=False)
class Field:
    """A sampled field. Arrays have the shape (nx, ny, nz), (nx, ny, nz, 3) or (nx, ny, nz, 3, 3) and are read-only.

    Attributes:
        header: step, time, run.
        name: of the definition.
        grid: where it was sampled, before any motion.
        columns: arrays by quantity, (nx, ny, nz) or (nx, ny, nz, components).
        kernel: ``truncated_gaussian``, ``lucy`` or ``heaviside``.
        width_m: of the kernel, m.
        cutoff_widths: support of the kernel over its width.
        total_mass_kg: of all particles: what the integral of the density is checked against.
        total_momentum_kg_m_per_s: of all particles, (3,).
        standard_errors: of the mean over time, by quantity, shaped as `columns`; empty with fewer than two blocks.
        more_widths: the same field smeared with the other widths of its definition.
        samples: that the mean is over; 1 for the state of now, 0 before the first.
        blocks: that the errors are from.
        from_time_s: of the first sample, s.
        grid_origin_m: where a moved grid's frame has gone, (3,), m.
        grid_orientation_wxyz: world from the axes of a moved grid, (4,).
    """

    header: Header
    name: str
    grid: Grid
    columns: dict[str, NDArray[Any]]
    kernel: str
    width_m: float
    cutoff_widths: float
    total_mass_kg: float
    total_momentum_kg_m_per_s: NDArray[np.float64]
    standard_errors: dict[str, NDArray[Any]] = dataclass_field(default_factory=dict)
    more_widths: tuple[Field, ...] = ()
    samples: int = 1
    blocks: int = 0
    from_time_s: float = 0.0
    grid_origin_m: NDArray[np.float64] = dataclass_field(default_factory=lambda: np.zeros(3))
    grid_orientation_wxyz: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)

    @classmethod
    def from_message(cls, message: pb.FieldFrame) -> Field:
        grid = Grid.from_message(message.grid)
        cells = int(np.prod(grid.cells))

        def arrays(sent: Iterable[pb.Column]) -> dict[str, NDArray[Any]]:
            found = {}
            for column in sent:
                values = columns.decode(column)
                if len(values) != cells:
                    raise ProtocolError(
                        f"field {message.name!r}: {column.name} has {len(values)} cells instead of {cells}"
                    )
                found[column.name] = values.reshape(*grid.cells, *values.shape[1:])
            return found

        q = message.grid_orientation
        main = cls(
            header=Header.from_message(message.header),
            name=message.name,
            grid=grid,
            columns=arrays(message.columns),
            kernel=message.kernel,
            width_m=message.width_m,
            cutoff_widths=message.cutoff_widths,
            total_mass_kg=message.total_mass_kg,
            total_momentum_kg_m_per_s=columns.from_vec3(message.total_momentum_kg_m_per_s),
            standard_errors=arrays(message.standard_errors),
            samples=message.samples,
            blocks=message.blocks,
            from_time_s=message.from_time_s,
            grid_origin_m=columns.from_vec3(message.grid_origin_m),
            grid_orientation_wxyz=(q.w, q.x, q.y, q.z)
            if message.HasField("grid_orientation")
            else (1.0, 0.0, 0.0, 0.0),
        )
        more = tuple(
            replace(
                main,
                width_m=width.width_m,
                columns=arrays(width.columns),
                standard_errors=arrays(width.standard_errors),
            )
            for width in message.more_widths
        )
        return replace(main, more_widths=more)

    def _column(self, name: str) -> NDArray[Any]:
        try:
            return self.columns[name]
        except KeyError:
            raise ColumnMissing(f"field {self.name!r} samples {', '.join(self.columns)}, not {name}") from None

    def _tensor(self, name: str) -> NDArray[Any]:
        values = self._column(name)
        return values.reshape(*values.shape[:-1], 3, 3)

    def standard_error(self, name: str) -> NDArray[Any]:
        """Standard error of the mean over time of a quantity, shaped as `columns[name]`.

        Raises:
            ColumnMissing: the field is no mean, or one over fewer than two blocks.
        """
        self._column(name)
        if name not in self.standard_errors:
            raise ColumnMissing(f"field {self.name!r} has {self.blocks} complete blocks: no standard error")
        return self.standard_errors[name]

    @property
    def widths_m(self) -> tuple[float, ...]:
        """All widths of the definition, its main one first, m."""
        return (self.width_m, *(other.width_m for other in self.more_widths))

    def at_width(self, width_m: float) -> Field:
        """The same field smeared with another width of its definition."""
        for field in (self, *self.more_widths):
            if field.width_m == width_m:
                return field
        raise ValueError(f"field {self.name!r} has the widths {self.widths_m}, not {width_m}")

    def __repr__(self) -> str:
        return f"Field({self.name!r}, time_s={self.time_s:g}, cells={self.grid.cells}, columns={list(self.columns)})"

    @property
    def step(self) -> int:
        """Steps done."""
        return self.header.step

    @property
    def time_s(self) -> float:
        """Simulated time, s."""
        return self.header.time_s

    @property
    def x_m(self) -> NDArray[np.float64]:
        """Cell centres along x, (nx,), m."""
        return self.grid.axis_m(0)

    @property
    def y_m(self) -> NDArray[np.float64]:
        """Cell centres along y, (ny,), m."""
        return self.grid.axis_m(1)

    @property
    def z_m(self) -> NDArray[np.float64]:
        """Cell centres along z, or the height of a cylinder, (nz,), m."""
        return self.grid.axis_m(2)

    @property
    def radius_m(self) -> NDArray[np.float64]:
        """Cell centres along the radius of a cylindrical grid, (nx,), m."""
        return self.grid.axis_m(0)

    @property
    def angle_rad(self) -> NDArray[np.float64]:
        """Cell centres along the angle of a cylindrical grid, (ny,), rad."""
        return self.grid.axis_m(1)

    @property
    def solid_fraction(self) -> NDArray[np.float64]:
        """Volume of particles per volume, each at its centre, (nx, ny, nz)."""
        return self._column("solid_fraction")

    @property
    def solid_fraction_of_shapes(self) -> NDArray[np.float64]:
        """Volume of particles per volume, spread over their true shapes, (nx, ny, nz)."""
        return self._column("solid_fraction_of_shapes")

    @property
    def density_kg_per_m3(self) -> NDArray[np.float64]:
        """(nx, ny, nz), kg/m3."""
        return self._column("density")

    @property
    def number_density_per_m3(self) -> NDArray[np.float64]:
        """Particles per volume, (nx, ny, nz), 1/m3."""
        return self._column("number_density")

    @property
    def momentum_kg_per_m2_s(self) -> NDArray[np.float64]:
        """Per volume, (nx, ny, nz, 3), kg/(m2 s)."""
        return self._column("momentum")

    @property
    def velocity_m_per_s(self) -> NDArray[np.float64]:
        """Momentum over density, 0 where the density is 0, (nx, ny, nz, 3), m/s."""
        return self._column("velocity")

    @property
    def angular_velocity_rad_per_s(self) -> NDArray[np.float64]:
        """Mean weighted by mass, 0 where the density is 0, (nx, ny, nz, 3), rad/s."""
        return self._column("angular_velocity")

    @property
    def velocity_gradient_per_s(self) -> NDArray[np.float64]:
        """dV_a/dx_b at [..., a, b], (nx, ny, nz, 3, 3), 1/s."""
        return self._tensor("velocity_gradient")

    @property
    def shear_rate_per_s(self) -> NDArray[np.float64]:
        """sqrt(2 S:S) of the deviatoric strain rate S, (nx, ny, nz), 1/s."""
        return self._column("shear_rate")

    @property
    def contact_stress_pa(self) -> NDArray[np.float64]:
        """Positive in compression, (nx, ny, nz, 3, 3), Pa."""
        return self._tensor("contact_stress")

    @property
    def contact_stress_pairs_pa(self) -> NDArray[np.float64]:
        """Its part between particles, (nx, ny, nz, 3, 3), Pa."""
        return self._tensor("contact_stress_pairs")

    @property
    def contact_stress_boundaries_pa(self) -> NDArray[np.float64]:
        """Its part at boundaries, (nx, ny, nz, 3, 3), Pa."""
        return self._tensor("contact_stress_boundaries")

    @property
    def kinetic_stress_pa(self) -> NDArray[np.float64]:
        """Of fluctuations about V(r), (nx, ny, nz, 3, 3), Pa."""
        return self._tensor("kinetic_stress")

    @property
    def kinetic_stress_about_particles_pa(self) -> NDArray[np.float64]:
        """Of fluctuations about the field at each particle, (nx, ny, nz, 3, 3), Pa."""
        return self._tensor("kinetic_stress_about_particles")

    @property
    def kinetic_stress_of_gradient_pa(self) -> NDArray[np.float64]:
        """T^gamma: what shear within the reach of the kernel adds, (nx, ny, nz, 3, 3), Pa."""
        return self._tensor("kinetic_stress_of_gradient")

    @property
    def kinetic_stress_scale_free_pa(self) -> NDArray[np.float64]:
        """T^k: kinetic stress less T^gamma, (nx, ny, nz, 3, 3), Pa."""
        return self._tensor("kinetic_stress_scale_free")

    @property
    def kinetic_stress_of_rotation_pa(self) -> NDArray[np.float64]:
        """Flux of momentum by the rotation of particles, (nx, ny, nz, 3, 3), Pa."""
        return self._tensor("kinetic_stress_of_rotation")

    @property
    def stress_pa(self) -> NDArray[np.float64]:
        """Contact and kinetic stress together, (nx, ny, nz, 3, 3), Pa."""
        return self._tensor("stress")

    @property
    def pressure_pa(self) -> NDArray[np.float64]:
        """A third of the trace of the stress, (nx, ny, nz), Pa."""
        return self._column("pressure")

    @property
    def second_moment_m2(self) -> NDArray[np.float64]:
        """D: mean of (r - r_i)(r - r_i) weighted by m phi, (nx, ny, nz, 3, 3), m2."""
        return self._tensor("second_moment")

    @property
    def granular_temperature_m2_per_s2(self) -> NDArray[np.float64]:
        """tr(kinetic stress) / (3 density), 0 where the density is 0, (nx, ny, nz), m2/s2."""
        return self._column("granular_temperature")

    @property
    def orientation(self) -> NDArray[np.float64]:
        """Mean of (3 n n - 1) / 2 over the axes n of particles, (nx, ny, nz, 3, 3)."""
        return self._tensor("orientation")

    @property
    def coordination(self) -> NDArray[np.float64]:
        """Mean number of touching neighbours, (nx, ny, nz, 8).

        All, particles, boundaries; of all those smooth, vertex on face, edge on edge, manifold, overlap.
        """
        return self._column("coordination")

    @property
    def inertial_number(self) -> NDArray[np.float64]:
        """Shear rate times diameter times sqrt(density of particles / pressure), (nx, ny, nz)."""
        return self._column("inertial_number")

    @property
    def wall_force_density_n_per_m3(self) -> NDArray[np.float64]:
        """Force of the particles on boundaries per volume, (nx, ny, nz, 3), N/m3."""
        return self._column("wall_force_density")

    def wall_traction_pa(self, across: int) -> NDArray[np.float64]:
        """Force on walls per area, (nx, ny, nz, 3) with one cell along `across`, Pa: `wall_force_density` integrated
        across a wall, of a cartesian grid that resolves the directions along it."""
        if self.grid.cylinder is not None:
            raise ValueError("the traction is an integral across a wall of a cartesian grid")
        thickness = (self.grid.max_m[across] - self.grid.min_m[across]) / self.grid.cells[across]
        return np.asarray(self._column("wall_force_density").sum(axis=across, keepdims=True) * thickness)

    def integral(self, name: str) -> NDArray[np.float64]:
        """Sum over cells times their volumes; of the density it is the mass inside of the grid, kg."""
        values = self._column(name)
        volumes = self.grid.cell_volumes_m3.reshape(*self.grid.cells, *[1] * (values.ndim - 3))
        return np.asarray((values * volumes).sum(axis=(0, 1, 2)))


class FieldMean:
    """Mean of many frames of one field, one after another: `mean.add(field)`, then `mean.field()`.

    Volume averages are averaged over frames; velocity and granular temperature are weighted by density, as mass
    averages must be. The fluctuation of the velocity between frames is not added to the granular temperature.
    """

    _MEANT = frozenset(
        {
            "solid_fraction",
            "solid_fraction_of_shapes",
            "density",
            "number_density",
            "momentum",
            "velocity",
            "contact_stress",
            "contact_stress_pairs",
            "contact_stress_boundaries",
            "kinetic_stress_of_rotation",
            "wall_force_density",
            "granular_temperature",
        }
    )

    def __init__(self) -> None:
        self.frames = 0
        self._last: Field | None = None
        self._sums: dict[str, NDArray[np.float64]] = {}

    def add(self, field: Field) -> None:
        """Counts one more frame. Needs density where velocity or granular temperature are sampled.

        Raises:
            ValueError: the mean of one of the quantities is not the mean over frames: let the daemon take it
                (`average` of the definition).
        """
        bad = [name for name in field.columns if name not in self._MEANT]
        if bad:
            raise ValueError(f"means of {bad} need the daemon's own sums: define the field with average=...")
        for name, values in field.columns.items():
            weighted = self._weighted(field, name, values)
            self._sums[name] = weighted + self._sums[name] if name in self._sums else weighted
        self._last = field
        self.frames += 1

    @staticmethod
    def _weighted(field: Field, name: str, values: NDArray[Any]) -> NDArray[np.float64]:
        if name == "velocity":
            return np.asarray(values * field.density_kg_per_m3[..., None])
        if name == "granular_temperature":
            return np.asarray(values * field.density_kg_per_m3)
        return np.array(values, dtype=float)

    def field(self) -> Field:
        """The mean, with the header of the last frame.

        Raises:
            ValueError: no frame was added.
        """
        if self._last is None:
            raise ValueError("no frame was added: the mean of none is not defined")
        means = {name: total / self.frames for name, total in self._sums.items()}
        for name in means.keys() & {"velocity", "granular_temperature"}:
            density = means["density"] if means[name].ndim == 3 else means["density"][..., None]
            means[name] = np.divide(means[name], density, out=np.zeros_like(means[name]), where=density > 0)
        last = self._last
        return Field(
            header=last.header,
            name=last.name,
            grid=last.grid,
            columns=means,
            kernel=last.kernel,
            width_m=last.width_m,
            cutoff_widths=last.cutoff_widths,
            total_mass_kg=last.total_mass_kg,
            total_momentum_kg_m_per_s=last.total_momentum_kg_m_per_s,
        )
