"""Coarse-grained fields as numpy arrays on a grid."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import columns
from ._proto.sturz.v1 import data_pb2 as pb
from .errors import ProtocolError
from .state import ColumnMissing, Header

QUANTITIES: dict[str, pb.FieldQuantity] = {
    "solid_fraction": pb.FIELD_QUANTITY_SOLID_FRACTION,
    "density": pb.FIELD_QUANTITY_DENSITY,
    "momentum": pb.FIELD_QUANTITY_MOMENTUM,
    "velocity": pb.FIELD_QUANTITY_VELOCITY,
    "granular_temperature": pb.FIELD_QUANTITY_GRANULAR_TEMPERATURE,
}


@dataclass(frozen=True)
class Grid:
    """Cartesian grid of sample points at cell centres; one cell along an axis averages over the whole extent.

    Attributes:
        min_m: lower corner, m.
        max_m: upper corner, m.
        cells: along x, y and z.
    """

    min_m: tuple[float, float, float]
    max_m: tuple[float, float, float]
    cells: tuple[int, int, int]

    @classmethod
    def from_message(cls, message: pb.Grid) -> Grid:
        low, high = message.min_m, message.max_m
        return cls(
            min_m=(low.x, low.y, low.z),
            max_m=(high.x, high.y, high.z),
            cells=(message.cells_x, message.cells_y, message.cells_z),
        )

    def axis_m(self, axis: int) -> NDArray[np.float64]:
        """Cell centres along axis 0, 1 or 2, (cells,), m."""
        edges = self.edges_m(axis)
        return (edges[1:] + edges[:-1]) / 2

    def edges_m(self, axis: int) -> NDArray[np.float64]:
        """Borders of cells along axis 0, 1 or 2, (cells + 1,), m."""
        return np.linspace(self.min_m[axis], self.max_m[axis], self.cells[axis] + 1)

    @property
    def cell_volume_m3(self) -> float:
        """Of one cell, m3."""
        sizes = (np.array(self.max_m) - np.array(self.min_m)) / np.array(self.cells)
        return float(np.prod(sizes))


@dataclass(frozen=True)
class FieldDefinition:
    """What a field samples.

    Attributes:
        name: letters, digits, `_` and `-`.
        grid: where.
        quantities: names as in `QUANTITIES`.
        width_m: coarse-graining width w of the kernel exp(-R^2 / (2 w^2)), m.
        cutoff_widths: support of the kernel over its width; None: the daemon's default.
    """

    name: str
    grid: Grid
    quantities: tuple[str, ...]
    width_m: float
    cutoff_widths: float | None = None

    @classmethod
    def from_message(cls, message: pb.FieldDefinition) -> FieldDefinition:
        names = {value: name for name, value in QUANTITIES.items()}
        return cls(
            name=message.name,
            grid=Grid.from_message(message.grid),
            quantities=tuple(names.get(quantity, str(quantity)) for quantity in message.quantities),
            width_m=message.width_m,
            cutoff_widths=message.cutoff_widths if message.HasField("cutoff_widths") else None,
        )

    def to_message(self) -> pb.FieldDefinition:
        unknown = [name for name in self.quantities if name not in QUANTITIES]
        if unknown:
            raise ValueError(f"unknown quantities {unknown}; there are {list(QUANTITIES)}")
        message = pb.FieldDefinition(
            name=self.name,
            grid=pb.Grid(
                min_m=columns.vec3("min_m", self.grid.min_m),
                max_m=columns.vec3("max_m", self.grid.max_m),
                cells_x=self.grid.cells[0],
                cells_y=self.grid.cells[1],
                cells_z=self.grid.cells[2],
            ),
            quantities=[QUANTITIES[name] for name in self.quantities],
            width_m=self.width_m,
        )
        if self.cutoff_widths is not None:
            message.cutoff_widths = self.cutoff_widths
        return message


def grid_from(min_m: ArrayLike, max_m: ArrayLike, cells: Iterable[int]) -> Grid:
    """Grid from any three numbers each."""
    low, high = columns.vec3("min_m", min_m), columns.vec3("max_m", max_m)
    counts = tuple(int(count) for count in cells)
    if len(counts) != 3:
        raise ValueError(f"cells are {counts}; three numbers are needed")
    return Grid((low.x, low.y, low.z), (high.x, high.y, high.z), counts)


@dataclass(frozen=True, eq=False)
class Field:
    """A sampled field. Arrays have the shape (nx, ny, nz) or (nx, ny, nz, 3) and are read-only.

    Attributes:
        header: step, time, run.
        name: of the definition.
        grid: where it was sampled.
        columns: arrays by quantity.
        kernel: such as ``truncated_gaussian``.
        width_m: of the kernel, m.
        cutoff_widths: support of the kernel over its width.
        total_mass_kg: of all particles: what the integral of the density is checked against.
        total_momentum_kg_m_per_s: of all particles, (3,).
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

    @classmethod
    def from_message(cls, message: pb.FieldFrame) -> Field:
        grid = Grid.from_message(message.grid)
        cells = int(np.prod(grid.cells))
        arrays = {}
        for column in message.columns:
            values = columns.decode(column)
            if len(values) != cells:
                raise ProtocolError(f"field {message.name!r}: {column.name} has {len(values)} cells instead of {cells}")
            arrays[column.name] = values.reshape(*grid.cells, *values.shape[1:])
        return cls(
            header=Header.from_message(message.header),
            name=message.name,
            grid=grid,
            columns=arrays,
            kernel=message.kernel,
            width_m=message.width_m,
            cutoff_widths=message.cutoff_widths,
            total_mass_kg=message.total_mass_kg,
            total_momentum_kg_m_per_s=columns.from_vec3(message.total_momentum_kg_m_per_s),
        )

    def _column(self, name: str) -> NDArray[Any]:
        try:
            return self.columns[name]
        except KeyError:
            raise ColumnMissing(f"field {self.name!r} samples {', '.join(self.columns)}, not {name}") from None

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
        """Cell centres along z, (nz,), m."""
        return self.grid.axis_m(2)

    @property
    def solid_fraction(self) -> NDArray[np.float64]:
        """Volume of particles per volume, (nx, ny, nz)."""
        return self._column("solid_fraction")

    @property
    def density_kg_per_m3(self) -> NDArray[np.float64]:
        """(nx, ny, nz), kg/m3."""
        return self._column("density")

    @property
    def momentum_kg_per_m2_s(self) -> NDArray[np.float64]:
        """Per volume, (nx, ny, nz, 3), kg/(m2 s)."""
        return self._column("momentum")

    @property
    def velocity_m_per_s(self) -> NDArray[np.float64]:
        """Momentum over density, 0 where the density is 0, (nx, ny, nz, 3), m/s."""
        return self._column("velocity")

    @property
    def granular_temperature_m2_per_s2(self) -> NDArray[np.float64]:
        """tr(kinetic stress) / (3 density), 0 where the density is 0, (nx, ny, nz), m2/s2."""
        return self._column("granular_temperature")

    def integral(self, name: str) -> NDArray[np.float64]:
        """Sum over cells times the volume of a cell; of the density it is the mass inside of the grid, kg."""
        return np.asarray(self._column(name).sum(axis=(0, 1, 2)) * self.grid.cell_volume_m3)


class FieldMean:
    """Mean of many frames of one field, one after another: `mean.add(field)`, then `mean.field()`.

    Volume averages are averaged over frames; velocity and granular temperature are weighted by density, as mass
    averages must be. The fluctuation of the velocity between frames is not added to the granular temperature.
    """

    def __init__(self) -> None:
        self.frames = 0
        self._last: Field | None = None
        self._sums: dict[str, NDArray[np.float64]] = {}

    def add(self, field: Field) -> None:
        """Counts one more frame. Needs density where velocity or granular temperature are sampled."""
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
