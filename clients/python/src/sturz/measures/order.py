"""Order of positions and orientations: pair correlation and nematic order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..status import Domain
from .bodies import Floats, minimum_image


@dataclass(frozen=True, eq=False)
class PairCorrelation:
    """g(r): pairs at a distance, over those of an ideal gas in the same box.

    Attributes:
        edges_m: of the bins, (k + 1,), m.
        g: (k,); NaN where the ideal gas has no pairs.
        pairs: found, (k,).
        ideal_pairs: expected of the ideal gas, (k,).
    """

    edges_m: Floats
    g: Floats
    pairs: NDArray[np.int64]
    ideal_pairs: Floats

    @property
    def distances_m(self) -> Floats:
        """Middles of the bins, (k,), m."""
        return 0.5 * (self.edges_m[1:] + self.edges_m[:-1])


def pair_correlation(
    positions_m: ArrayLike,
    edges_m: ArrayLike,
    *,
    min_m: ArrayLike,
    max_m: ArrayLike,
    domain: Domain | None = None,
) -> PairCorrelation:
    """Pair correlation of the particles whose centres lie in a box.

    Distances are of nearest images along periodic axes. The ideal gas fills the same box: along an axis that is not
    periodic it has fewer pairs at large distances, which the usual 4 pi r^2 would take for a falling g.

    Args:
        positions_m: centres, (n, 3), m.
        edges_m: ascending, (k + 1,), m; along a periodic axis nothing lies beyond half of the cell.
        min_m, max_m: box, (3,), m; along periodic axes it must be the whole cell.
        domain: which axes are periodic; none when absent.
    """
    edges = np.asarray(edges_m, dtype=float)
    low, high = np.asarray(min_m, dtype=float), np.asarray(max_m, dtype=float)
    periodic = np.array(domain.periodic if domain is not None else (False, False, False))
    if domain is not None and not (
        np.allclose(low[periodic], domain.min_m[periodic]) and np.allclose(high[periodic], domain.max_m[periodic])
    ):
        raise ValueError("along a periodic axis the box must be the whole cell")
    points = np.asarray(positions_m, dtype=float).reshape(-1, 3)
    inside = (periodic | ((points >= low) & (points <= high))).all(axis=1)
    points = points[inside]
    n = len(points)
    counts = np.zeros(len(edges) - 1, dtype=np.int64)
    for first in range(n - 1):
        distances = np.linalg.norm(minimum_image(points[first + 1 :] - points[first], domain), axis=1)
        counts += np.histogram(distances, bins=edges)[0]
    ideal = 0.5 * n * (n - 1) * _ideal_shares(edges, high - low, periodic)
    with np.errstate(divide="ignore", invalid="ignore"):
        g = np.where(ideal > 0.0, counts / ideal, np.nan)
    return PairCorrelation(edges, g, counts, ideal)


def _ideal_shares(edges: Floats, lengths: Floats, periodic: NDArray[np.bool_]) -> Floats:
    """Share of the pairs of two independent uniform points whose distance lies in each bin.

    Along a periodic axis the difference is uniform up to L/2, else triangular up to L. Two axes by quadrature, which
    ends where their densities do; the third by its distribution function.
    """
    nodes, weights = np.polynomial.legendre.leggauss(64)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    reach = np.where(periodic, 0.5 * lengths, lengths)

    def density(axis: int, x: Floats) -> Floats:
        even: Floats = np.full_like(x, 2.0 / lengths[axis])
        return even if periodic[axis] else even * (1.0 - x / lengths[axis])

    def up_to(axis: int, x: Floats) -> Floats:
        x = np.minimum(x, reach[axis]) / lengths[axis]
        share: Floats = 2.0 * x if periodic[axis] else (2.0 - x) * x
        return share

    def within(r: float) -> float:
        x = min(r, reach[0]) * nodes
        widths = np.minimum(np.sqrt(np.maximum(r * r - x * x, 0.0)), reach[1])
        y = widths[:, None] * nodes
        inner = density(1, y) * up_to(2, np.sqrt(np.maximum(r * r - x[:, None] ** 2 - y * y, 0.0)))
        return float(min(r, reach[0]) * weights @ (density(0, x) * widths * (inner @ weights)))

    shares: Floats = np.diff([within(float(edge)) for edge in edges])
    return shares


@dataclass(frozen=True, eq=False)
class NematicOrder:
    """Order of axes.

    Attributes:
        tensor: Q = mean of (3 u u - 1) / 2, (3, 3).
        order: its largest eigenvalue: 1 when all axes are parallel, about `baseline` when there is no order.
        director: eigenvector of `order`, (3,).
        baseline: mean of `order` for as many random axes.
        baseline_deviation: standard deviation of that.
        n: axes.
    """

    tensor: Floats
    order: float
    director: Floats
    baseline: float
    baseline_deviation: float
    n: int


def nematic_order(axes: ArrayLike) -> NematicOrder:
    """Nematic order of axes (u and -u are the same), with what no order would give for as many.

    Args:
        axes: unit vectors, (n, 3), such as ``state.rotations()[:, :, k]`` for the body axis k.
    """
    u = np.asarray(axes, dtype=float).reshape(-1, 3)
    n = len(u)
    if n == 0:
        nothing = np.full(3, np.nan)
        return NematicOrder(np.full((3, 3), np.nan), float("nan"), nothing, float("nan"), float("nan"), 0)
    tensor = 1.5 * u.T @ u / n - 0.5 * np.eye(3)
    values, vectors = np.linalg.eigh(tensor)
    baseline, deviation = isotropic_order(n)
    return NematicOrder(tensor, float(values[-1]), vectors[:, -1], baseline, deviation, n)


def isotropic_order(n: int, *, samples: int = 4000, seed: int = 1) -> tuple[float, float]:
    """Mean and standard deviation of the largest eigenvalue of Q for n independent random axes.

    Drawn: up to 300 axes as axes, beyond that from the Gaussian limit of Q, whose entries scale with n^-1/2.
    """
    random = np.random.default_rng(seed)
    if n <= 300:
        normal = random.standard_normal((samples, n, 3))
        u = normal / np.linalg.norm(normal, axis=2, keepdims=True)
        tensors = 1.5 * np.einsum("sni,snj->sij", u, u) / n - 0.5 * np.eye(3)
    else:
        # Variances of one axis: 1/5 on the diagonal of Q, 3/20 beside it; the trace is 0.
        entries = random.standard_normal((samples, 3, 3)) * np.sqrt(0.15 / n)
        tensors = (entries + entries.transpose(0, 2, 1)) / np.sqrt(2.0)
        trace = np.trace(tensors, axis1=1, axis2=2)
        tensors -= trace[:, None, None] * np.eye(3) / 3.0
    largest = np.linalg.eigvalsh(tensors)[:, -1]
    return float(largest.mean()), float(largest.std(ddof=1))
