"""Masses and moments of the particles of a state, and distances in a periodic cell."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..state import Shape, State
from ..status import Domain, Info

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Bodies:
    """What the particles of a state weigh, row by row.

    Attributes:
        volume_m3: (n,).
        mass_kg: (n,).
        moments_kg_m2: principal moments about the centre of mass, body axes, (n, 3).
        radius_m: bounding radius, (n,).
        equivalent_diameter_m: of the sphere of the same volume, (n,).
    """

    volume_m3: Floats
    mass_kg: Floats
    moments_kg_m2: Floats
    radius_m: Floats
    equivalent_diameter_m: Floats


def densities_kg_per_m3(info: Info) -> Floats:
    """Densities of the materials in the order that `State.materials` indexes, (k,); NaN for those that have none."""
    given = {each["name"]: each.get("density_kg_per_m3", np.nan) for each in tomllib.loads(info.scene_toml)["material"]}
    return np.array([float(given[name]) for name in info.materials])


def bodies(state: State, shapes: Sequence[Shape], densities: ArrayLike) -> Bodies:
    """Masses and moments of the particles.

    Args:
        state: with the columns ``shapes``, ``materials`` and ``scales``.
        shapes: of `Simulation.shapes`.
        densities: one for all, or one per material as of `densities_kg_per_m3`, kg/m3.

    Raises:
        ValueError: another number of densities than materials.
    """
    density = np.asarray(densities, dtype=float)
    if density.ndim:
        if len(state) and density.shape[0] <= int(state.materials.max()):
            raise ValueError(f"{density.shape[0]} densities for materials up to index {int(state.materials.max())}")
        density = density[state.materials]
    scale = np.asarray(state.scales, dtype=float)
    index = state.shapes
    volume = _of(shapes, index, "volume_m3") * scale**3
    moments = np.array([shape.principal_moments_per_density_m5 for shape in shapes]).reshape(-1, 3)[index]
    return Bodies(
        volume_m3=volume,
        mass_kg=np.broadcast_to(density, volume.shape) * volume,
        moments_kg_m2=(np.broadcast_to(density, volume.shape) * scale**5)[:, None] * moments,
        radius_m=_of(shapes, index, "bounding_radius_m") * scale,
        equivalent_diameter_m=np.cbrt(6.0 * volume / np.pi),
    )


def _of(shapes: Sequence[Shape], index: NDArray[Any], name: str) -> Floats:
    values: Floats = np.array([getattr(shape, name) for shape in shapes], dtype=float)[index]
    return values


def minimum_image(differences_m: ArrayLike, domain: Domain | None) -> Floats:
    """Differences of positions, (..., 3), as between nearest images; unchanged along axes that are not periodic, and
    without a domain. m."""
    differences = np.array(differences_m, dtype=float)
    if domain is None:
        return differences
    for axis in np.flatnonzero(domain.periodic):
        length = domain.max_m[axis] - domain.min_m[axis]
        differences[..., axis] -= length * np.round(differences[..., axis] / length)
    return differences


def rows_of(ids: NDArray[Any], wanted: NDArray[Any]) -> NDArray[np.intp]:
    """Rows of `wanted` in the ascending `ids`.

    Raises:
        ValueError: one of them is not there: the contacts are of another state.
    """
    if len(ids) == 0:
        if len(wanted):
            raise ValueError("contacts of particles, and a state without any: they are of different steps")
        return np.zeros(0, dtype=np.intp)
    rows = np.searchsorted(ids, wanted)
    if len(wanted) and (rows.max() >= len(ids) or (ids[np.minimum(rows, len(ids) - 1)] != wanted).any()):
        raise ValueError("contacts name particles that the state has not: they are of different steps")
    return rows
