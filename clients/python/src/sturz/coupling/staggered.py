"""Operators of a staggered grid in a plane, for `PlaneSolver`: velocities on the sides of the cells they cross.

All are written for the component along the last axis; the other component's are the same with the axes swapped. With
m rows of n cells, `along` is (m, n + 1) on the sides that the component crosses, `across` (m + 1, n) on the others;
corners are (m + 1, n + 1). Periodic: the last side is the first. Control volumes of sides at an end are half cells, so
that those of all sides fill the plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Kind = Literal["periodic", "no_slip", "slip", "inflow", "outflow"]
Convection = Literal["upwind", "limited", "central"]


@dataclass(frozen=True)
class Axis:
    """One direction of the grid: its cells, their size, and what it ends in."""

    count: int
    step_m: float
    low: Kind
    high: Kind

    @property
    def periodic(self) -> bool:
        """Both ends are one."""
        return self.low == "periodic"

    @property
    def widths_m(self) -> Array:
        """Of the control volumes of the sides, (count + 1,); of the periodic pair each counts half."""
        widths = np.full(self.count + 1, self.step_m)
        widths[[0, -1]] *= 0.5
        return widths

    @property
    def free(self) -> NDArray[np.bool_]:
        """Sides whose velocity is found, not given, (count + 1,)."""
        free = np.full(self.count + 1, True)
        free[0] = self.low in ("periodic", "outflow")
        free[-1] = self.high in ("periodic", "outflow")
        return free


def to_sides(cells: Array, periodic: bool) -> Array:
    """Cells (m, n) to the sides between them along the last axis, (m, n + 1): means; at an end the cell's value.

    Sums are kept: over the control volumes of the sides as over the cells.
    """
    sides = np.empty((cells.shape[0], cells.shape[1] + 1))
    sides[:, 1:-1] = 0.5 * (cells[:, 1:] + cells[:, :-1])
    if periodic:
        sides[:, 0] = sides[:, -1] = 0.5 * (cells[:, 0] + cells[:, -1])
    else:
        sides[:, 0], sides[:, -1] = cells[:, 0], cells[:, -1]
    return sides


def to_cells(sides: Array) -> Array:
    """Sides (m, n + 1) to the cells between them: means, (m, n)."""
    mean: Array = 0.5 * (sides[:, 1:] + sides[:, :-1])
    return mean


def between(padded: Array, flux: Array, convection: Convection) -> Array:
    """Values between points along the last axis, as `flux` carries them.

    Args:
        padded: (m, k + 3): the points, with one more before and after those between which the k values lie.
        flux: at the k places, its sign says which side is upwind, (m, k).
        convection: ``upwind``; ``central``; ``limited``: central where smooth, van Leer's limiter (J. Comput. Phys. 14
            (1974) 361) elsewhere.
    """
    a, b = padded[:, 1:-2], padded[:, 2:-1]
    if convection == "central":
        middle: Array = 0.5 * (a + b)
        return middle
    forward = flux >= 0
    up, down = np.where(forward, a, b), np.where(forward, b, a)
    if convection == "upwind":
        return up
    further = np.where(forward, padded[:, :-3], padded[:, 3:])
    before, after = up - further, down - up
    product, total = before * after, before + after
    # harmonic mean of both slopes, 0 at an extremum: r = before / after, half psi(r) after
    slope = np.where(product > 0, product / np.where(product > 0, total, 1.0), 0.0)
    limited: Array = up + slope
    return limited


def shear_gradients(along: Array, across: Array, x: Axis, z: Axis) -> tuple[Array, Array]:
    """At the corners: change of `along` over the rows, of `across` over the columns, 1/s, both (m + 1, n + 1).

    At walls that hold the fluid, and where it flows in, the tangential velocity is 0; at others it does not change.
    """
    return _over_rows(along, z), _over_rows(across.T, x).T


def _over_rows(values: Array, axis: Axis) -> Array:
    change = np.zeros((values.shape[0] + 1, values.shape[1]))
    change[1:-1] = (values[1:] - values[:-1]) / axis.step_m
    if axis.periodic:
        change[0] = change[-1] = (values[0] - values[-1]) / axis.step_m
        return change
    held = ("no_slip", "inflow")
    if axis.low in held:
        change[0] = values[0] / (0.5 * axis.step_m)
    if axis.high in held:
        change[-1] = -values[-1] / (0.5 * axis.step_m)
    return change


@dataclass(frozen=True)
class Transport:
    """Momentum that the fluid carries and that its viscosity passes on.

    Attributes:
        convection: -div(rho q u), on the sides, N/m3, (m, n + 1).
        viscosity: div(e tau), likewise.
        through_ends: what came in through the ends of the plane by both, per depth, N/m.
        through_ends_size: sum of its parts' absolute values.
    """

    convection: Array
    viscosity: Array
    through_ends: float
    through_ends_size: float


def transport(
    velocity: tuple[Array, Array],
    flux: tuple[Array, Array],
    void: Array,
    axes: tuple[Axis, Axis],
    density: float,
    viscosity: float,
    scheme: Convection,
) -> Transport:
    """Of the component along the last axis.

    Args:
        velocity: interstitial, along and across.
        flux: that carries it, e u, along and across.
        void: fraction in the cells, (m, n).
        axes: along the component, across it.
        density: kg/m3.
        viscosity: dynamic, Pa s.
        scheme: for the values that the flux carries.
    """
    (u, w), (qu, qw), (x, z) = velocity, flux, axes
    inner = to_cells(qu)
    edge = np.column_stack([u[:, -2], u, u[:, 1]] if x.periodic else [u[:, 0], u, u[:, -1]])
    carried = density * inner * between(edge, inner, scheme)
    stretch, other = np.diff(u, axis=1) / x.step_m, np.diff(w, axis=0) / z.step_m
    # tau = mu (grad u + its transpose - 2/3 div u): div u is not 0 where the void fraction varies
    pulled = void * viscosity * (2.0 * stretch - (2.0 / 3.0) * (stretch + other))
    corner = to_sides(qw, x.periodic)
    rows = np.take(u, np.arange(-2, len(u) + 2), axis=0, mode="wrap" if z.periodic else "clip")
    at_corner = between(rows.T, corner.T, scheme).T
    if not z.periodic:
        # a wall carries nothing; what flows in has no tangential velocity; what flows out has that of the last row
        at_corner[0] = u[0] if z.low == "outflow" else 0.0
        at_corner[-1] = u[-1] if z.high == "outflow" else 0.0
    swept = density * corner * at_corner
    du, dw = shear_gradients(u, w, x, z)
    sheared = to_sides(to_sides(void, x.periodic).T, z.periodic).T * viscosity * (du + dw)
    for k, kind in ((0, z.low), (-1, z.high)):
        if kind in ("slip", "outflow"):
            sheared[k] = 0.0
    ends = density * qu[:, [0, -1]] * u[:, [0, -1]], pulled[:, [0, -1]]
    convection = -_change(carried, ends[0], x) - np.diff(swept, axis=0) / z.step_m
    viscous = _change(pulled, ends[1], x) + np.diff(sheared, axis=0) / z.step_m
    parts = []
    if not x.periodic:
        total = (ends[0] - ends[1]) * z.step_m
        parts += [float(total[:, 0].sum()), -float(total[:, 1].sum())]
    if not z.periodic:
        total = (swept - sheared) * x.widths_m
        parts += [float(total[0].sum()), -float(total[-1].sum())]
    return Transport(convection, viscous, sum(parts), sum(abs(part) for part in parts))


def _change(cells: Array, ends: Array, axis: Axis) -> Array:
    """Difference over the control volumes of the sides, of values at the cells (m, n) and at both ends (m, 2)."""
    change = np.empty((cells.shape[0], cells.shape[1] + 1))
    change[:, 1:-1] = np.diff(cells, axis=1) / axis.step_m
    if axis.periodic:
        change[:, 0] = change[:, -1] = (cells[:, 0] - cells[:, -1]) / axis.step_m
        return change
    change[:, 0] = (cells[:, 0] - ends[:, 0]) / (0.5 * axis.step_m)
    change[:, -1] = (ends[:, 1] - cells[:, -1]) / (0.5 * axis.step_m)
    return change


def gradient(cells: Array, axis: Axis) -> Array:
    """Of a pressure in the cells that is 0 at outflows, on the sides, (m, n + 1); 0 at other ends."""
    outside = np.zeros((cells.shape[0], 2))
    change = _change(cells, outside, axis)
    if not axis.periodic:
        for k, kind in ((0, axis.low), (-1, axis.high)):
            if kind != "outflow":
                change[:, k] = 0.0
    return change


def divergence(qx: Array, qz: Array, x: Axis, z: Axis) -> Array:
    """Of the flux, in the cells, 1/s, (m, n)."""
    change: Array = np.diff(qx, axis=1) / x.step_m + np.diff(qz, axis=0) / z.step_m
    return change


def factorised(cx: Array, cz: Array, x: Axis, z: Axis) -> Any:
    """LU factors of p -> -div(c grad p), pinned in the first cell where no outflow sets the pressure.

    Raises:
        ImportError: scipy is missing.
    """
    try:
        from scipy.sparse import coo_matrix
        from scipy.sparse.linalg import splu
    except ImportError as error:
        raise ImportError("the plane needs scipy: install sturz[coupling]") from error
    numbers = np.arange(x.count * z.count).reshape(z.count, x.count)
    entries = [_couplings(cx, numbers, x), _couplings(cz.T, numbers.T, z)]
    row, column, value = (np.concatenate([part[k] for part in entries]) for k in range(3))
    if "outflow" not in (x.low, x.high, z.low, z.high):
        row, column = np.append(row, 0), np.append(column, 0)
        value = np.append(value, value[row[:-1] == column[:-1]].max())
    matrix = coo_matrix((value, (row, column)), shape=(numbers.size, numbers.size)).tocsc()
    return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def _couplings(c: Array, numbers: NDArray[np.int_], axis: Axis) -> tuple[Array, Array, Array]:
    """Rows, columns and values that the sides along the last axis bring."""
    low, high = [numbers[:, :-1].ravel()], [numbers[:, 1:].ravel()]
    value = [c[:, 1:-1].ravel() / axis.step_m**2]
    # a ring of one cell has no difference to itself
    if axis.periodic and axis.count > 1:
        low.append(numbers[:, -1])
        high.append(numbers[:, 0])
        value.append(c[:, 0] / axis.step_m**2)
    a, b, v = np.concatenate(low), np.concatenate(high), np.concatenate(value)
    row, column, values = [a, b, a, b], [a, b, b, a], [v, v, -v, -v]
    for k, kind in ((0, axis.low), (-1, axis.high)):
        if kind == "outflow":
            row.append(numbers[:, k])
            column.append(numbers[:, k])
            values.append(2.0 * c[:, k] / axis.step_m**2)
    return np.concatenate(row), np.concatenate(column), np.concatenate(values)
