"""Where a heap ends: centre of mass, free surface, angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..status import Domain
from .bodies import Floats


def centre_of_mass_m(positions_m: ArrayLike, masses_kg: ArrayLike, domain: Domain | None = None) -> Floats:
    """Centre of mass, (3,), m; along periodic axes the circular mean, in the cell. NaN of nothing."""
    x, m = np.asarray(positions_m, dtype=float).reshape(-1, 3), np.asarray(masses_kg, dtype=float)
    if len(x) == 0:
        return np.full(3, np.nan)
    centre = np.average(x, axis=0, weights=m)
    for axis in np.flatnonzero(domain.periodic) if domain is not None else ():
        low, length = domain.min_m[axis], domain.max_m[axis] - domain.min_m[axis]
        turn = np.exp(2j * np.pi * (x[:, axis] - low) / length)
        centre[axis] = low + length * ((np.angle(np.average(turn, weights=m)) / (2.0 * np.pi)) % 1.0)
    return centre


@dataclass(frozen=True, eq=False)
class FreeSurface:
    """Height of the highest particle in columns.

    Attributes:
        along_m: middles of the columns, (k,), m.
        height_m: highest top in each, (k,), m; NaN where it is empty.
    """

    along_m: Floats
    height_m: Floats


def free_surface(
    positions_m: ArrayLike, radii_m: ArrayLike, edges_m: ArrayLike, *, along: ArrayLike, up: ArrayLike
) -> FreeSurface:
    """Top of the particles in columns: centre of the highest one plus its radius.

    Args:
        positions_m: (n, 3), m.
        radii_m: by which a particle reaches above its centre, (n,) or one for all: half of the equivalent diameter.
        edges_m: of the columns along `along`, ascending, (k + 1,), m.
        along, up: unit vectors, (3,).
    """
    x, edges = np.asarray(positions_m, dtype=float).reshape(-1, 3), np.asarray(edges_m, dtype=float)
    column = np.searchsorted(edges, x @ np.asarray(along, dtype=float), side="right") - 1
    tops = x @ np.asarray(up, dtype=float) + np.asarray(radii_m, dtype=float)
    height = np.full(len(edges) - 1, -np.inf)
    inside = (column >= 0) & (column < len(height))
    np.maximum.at(height, column[inside], tops[inside])
    height[~np.isfinite(height)] = np.nan
    return FreeSurface(0.5 * (edges[1:] + edges[:-1]), height)


@dataclass(frozen=True)
class Angle:
    """Inclination of a fitted line.

    Attributes:
        angle_rad: against the horizontal, positive where it rises; NaN below two places.
        standard_error_rad: from the scatter about the line; NaN below three places.
        height_m: of the line at 0, m.
        places: fitted.
    """

    angle_rad: float
    standard_error_rad: float
    height_m: float
    places: int


def surface_angle(surface: FreeSurface, *, low_m: float = -np.inf, high_m: float = np.inf) -> Angle:
    """Angle of the straight line that fits a free surface between two places: of repose of a heap's flank at rest,
    dynamic in a drum."""
    chosen = np.isfinite(surface.height_m) & (surface.along_m >= low_m) & (surface.along_m <= high_m)
    x, y = surface.along_m[chosen], surface.height_m[chosen]
    n = len(x)
    if n < 2:
        return Angle(float("nan"), float("nan"), float("nan"), n)
    centred = x - x.mean()
    spread = float((centred**2).sum())
    slope = float(centred @ y) / spread
    rest = y - y.mean() - slope * centred
    error = float(np.sqrt((rest**2).sum() / (n - 2) / spread)) if n > 2 else float("nan")
    return Angle(float(np.arctan(slope)), error / (1.0 + slope**2), float(y.mean() - slope * x.mean()), n)


def drum_angle(
    positions_m: ArrayLike,
    radii_m: ArrayLike,
    *,
    gravity_m_per_s2: ArrayLike,
    axis: ArrayLike,
    centre_m: ArrayLike,
    radius_m: float,
    columns: int = 20,
    part: float = 0.6,
) -> Angle:
    """Dynamic angle of the bed in a drum: line through the free surface over the middle of the drum.

    Positive where the bed is higher on the side to which ``gravity x axis`` points: where a drum that turns by the
    right-hand rule about `axis` carries its bottom.

    Args:
        columns: over the middle part.
        part: of the drum's diameter that is fitted.
    """
    gravity, along_axis = np.asarray(gravity_m_per_s2, dtype=float), np.asarray(axis, dtype=float)
    along_axis = along_axis / np.linalg.norm(along_axis)
    down = gravity - along_axis * (gravity @ along_axis)
    up = -down / np.linalg.norm(down)
    along = np.cross(along_axis, -up)
    offset = np.asarray(positions_m, dtype=float).reshape(-1, 3) - np.asarray(centre_m, dtype=float)
    edges = np.linspace(-part * radius_m, part * radius_m, columns + 1)
    return surface_angle(free_surface(offset, radii_m, edges, along=along, up=up))
