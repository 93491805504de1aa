"""How well two kinds of particles are mixed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class MixingIndex:
    """Lacey's index of a mixture of two kinds.

    Attributes:
        index: 0 where each cell holds one kind, 1 as random as can be; above 1 more even than random. NaN with one kind
            only, or where cells hold one particle each.
        variance: of the share of the first kind over the cells, weighted by their particles.
        segregated_variance: p (1 - p).
        random_variance: p (1 - p) over the particles per cell.
        share: p, of the first kind among all particles that count.
        cells: that count.
        particles_per_cell: mean over the cells that count.
    """

    index: float
    variance: float
    segregated_variance: float
    random_variance: float
    share: float
    cells: int
    particles_per_cell: float

    @property
    def segregation(self) -> float:
        """Danckwerts' intensity of segregation, s^2 over p (1 - p): 1 where each cell holds one kind."""
        return self.variance / self.segregated_variance if self.segregated_variance > 0.0 else float("nan")


def lacey_index(
    positions_m: ArrayLike,
    is_first: ArrayLike,
    *,
    min_m: ArrayLike,
    max_m: ArrayLike,
    cells: ArrayLike,
    least_particles: int = 2,
) -> MixingIndex:
    """Lacey's mixing index (Lacey 1954): (s0^2 - s^2) / (s0^2 - sr^2) over the cells of a grid.

    Args:
        positions_m: (n, 3), m; particles outside of the grid do not count.
        is_first: whether a particle is of the first kind, (n,).
        min_m, max_m: corners of the grid, (3,), m.
        cells: along each axis, (3,).
        least_particles: cells with fewer do not count.
    """
    low, high, shape = np.asarray(min_m, float), np.asarray(max_m, float), np.asarray(cells, dtype=int)
    x = np.asarray(positions_m, dtype=float).reshape(-1, 3)
    first = np.asarray(is_first, dtype=bool)
    place = np.floor((x - low) / (high - low) * shape).astype(int)
    inside = ((place >= 0) & (place < shape)).all(axis=1)
    flat = np.ravel_multi_index(tuple(place[inside].T), tuple(shape))
    n = np.bincount(flat, minlength=int(shape.prod()))
    k = np.bincount(flat, weights=first[inside], minlength=int(shape.prod()))
    counted = n >= max(least_particles, 1)
    n, k = n[counted], k[counted]
    total = int(n.sum())
    if total == 0:
        nothing = float("nan")
        return MixingIndex(nothing, nothing, nothing, nothing, nothing, 0, nothing)
    p = float(k.sum() / total)
    variance = float((n * (k / n - p) ** 2).sum() / total)
    per_cell = total / len(n)
    segregated, random = p * (1.0 - p), p * (1.0 - p) / per_cell
    span = segregated - random
    index = (segregated - variance) / span if span > 0.0 else float("nan")
    return MixingIndex(index, variance, segregated, random, p, len(n), per_cell)
