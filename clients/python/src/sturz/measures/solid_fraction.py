"""Solid fraction in layers, from the particles' true volumes."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..state import Shape, State
from ..status import Domain
from .bodies import Floats, minimum_image

CURVED = ("sphere", "spherocylinder", "cylinder")
"""Kinds of shapes with a formula; their surface to draw is only near."""


@dataclass(frozen=True, eq=False)
class SolidFraction:
    """Solid fraction in layers.

    Attributes:
        edges_m: of the layers, ascending, (k + 1,), m.
        solid_fraction: (k,).
        standard_error: (k,); 0 where it is exact.
    """

    edges_m: Floats
    solid_fraction: Floats
    standard_error: Floats

    @property
    def middles_m(self) -> Floats:
        """Middles of the layers, (k,), m."""
        return 0.5 * (self.edges_m[1:] + self.edges_m[:-1])

    def mean(self, low_m: float, high_m: float) -> tuple[float, float]:
        """Mean over the layers whose middles lie between, by thickness, and its standard error."""
        inside = (self.middles_m >= low_m) & (self.middles_m <= high_m)
        thickness = np.diff(self.edges_m) * inside
        if not inside.any():
            return float("nan"), float("nan")
        weights = thickness / thickness.sum()
        return float(weights @ self.solid_fraction), float(np.sqrt(weights**2 @ self.standard_error**2))


def solid_fraction_profile(
    state: State, shapes: Sequence[Shape], edges_m: ArrayLike, *, area_m2: float, axis: int = 2
) -> SolidFraction:
    """Exact solid fraction of layers between parallel planes.

    Spheres by their caps, spherocylinders and cylinders by quadrature along their axis (to 1e-6 of their volume), all
    others by the exact integral over their closed surface. What particles share in an overlap counts twice.

    Args:
        state: with the columns ``shapes``, ``scales``, ``positions`` and ``orientations``.
        shapes: of `Simulation.shapes`.
        edges_m: of the layers, ascending, (k + 1,), m.
        area_m2: of a layer: of the cell across `axis`.
        axis: 0, 1 or 2; it must not be periodic.

    Raises:
        ValueError: a shape whose surface does not enclose its volume (rounded polyhedra, composites whose parts
            overlap): use `monte_carlo_solid_fraction`.
    """
    edges = np.asarray(edges_m, dtype=float)
    below = np.zeros(len(edges))
    for index, shape in enumerate(shapes):
        rows = np.flatnonzero(state.shapes == index)
        if len(rows) == 0:
            continue
        scales = np.asarray(state.scales, dtype=float)[rows]
        heights = np.asarray(state.positions_m, dtype=float)[rows, axis]
        if shape.kind == "sphere":
            below += _sphere_below(heights, shape.bounding_radius_m * scales, edges)
        elif shape.kind in CURVED:
            cosines = state.rotations()[rows][:, axis, _symmetry_axis(shape)]
            below += _revolution_below(heights, scales, cosines, shape, edges)
        else:
            _check_closed(shape)
            up = state.rotations()[rows][:, axis, :]
            below += _mesh_below(heights, scales, up, shape, edges)
    fraction = np.diff(below) / (area_m2 * np.diff(edges))
    return SolidFraction(edges, fraction, np.zeros_like(fraction))


def _sphere_below(heights: Floats, radii: Floats, edges: Floats) -> Floats:
    """Volume of all spheres below each edge: caps, pi h^2 (3 r - h) / 3."""
    cap = np.clip(edges[None, :] - heights[:, None] + radii[:, None], 0.0, 2.0 * radii[:, None])
    volumes: Floats = (np.pi * cap**2 * (3.0 * radii[:, None] - cap) / 3.0).sum(axis=0)
    return volumes


def _symmetry_axis(shape: Shape) -> int:
    """Body axis of a body of revolution: no point of the surface is farther from it than the radius."""
    squares = shape.vertices_m**2
    farthest = np.sqrt((squares.sum(axis=1, keepdims=True) - squares).max(axis=0))
    return int(np.argmin(np.abs(farthest - shape.parameters["radius_m"])))


def _length(shape: Shape) -> float:
    return shape.parameters["length_m" if shape.kind == "cylinder" else "total_length_m"]


def _revolution_below(heights: Floats, scales: Floats, cosines: Floats, shape: Shape, edges: Floats) -> Floats:
    """Volume below each edge of bodies of revolution, disc by disc, each cut along a chord.

    The integral is split where discs begin and cease to be cut, so that each piece is smooth.
    """
    r, half = shape.parameters["radius_m"], 0.5 * _length(shape)
    straight = half if shape.kind == "cylinder" else half - r
    # Either end may be called the upper one.
    cosine = np.abs(cosines)[:, None]
    sine = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
    reach = (edges[None, :] - heights[:, None]) / scales[:, None]
    slope = np.maximum(cosine, 1e-12)
    breaks = ((reach - r * sine) / slope, (reach + r * sine) / slope)
    below = _cut_discs(reach, cosine, sine, breaks, (-straight, straight), lambda s: np.full_like(s, r))
    if shape.kind == "spherocylinder":
        for end in (-1.0, 1.0):
            from_centre = reach - end * straight * cosine
            root = sine * np.sqrt(np.maximum(r * r - from_centre**2, 0.0))
            breaks = (from_centre * cosine - root, from_centre * cosine + root)
            span = (-r, 0.0) if end < 0 else (0.0, r)
            below += _cut_discs(
                from_centre, cosine, sine, breaks, span, lambda s: np.sqrt(np.maximum(r * r - s * s, 0.0))
            )
    volumes: Floats = scales**3 @ below
    return volumes


def _cut_discs(
    reach: Floats,
    cosine: Floats,
    sine: Floats,
    breaks: tuple[Floats, Floats],
    span: tuple[float, float],
    radius_at: Callable[[Floats], Floats],
) -> Floats:
    """Integral over s along the axis, within `span`, of the area of a disc that lies below the plane, (n, k)."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    ends = [np.full_like(reach, span[0]), *(np.clip(each, *span) for each in breaks), np.full_like(reach, span[1])]
    total = np.zeros_like(reach)
    for start, end in itertools.pairwise(ends):
        for node, weight in zip(nodes, weights, strict=True):
            s = 0.5 * (end - start) * node + 0.5 * (end + start)
            disc = radius_at(s)
            # A level disc is wholly above or below; the tiny lower limit makes it so.
            offset = np.clip((reach - s * cosine) / np.maximum(disc * sine, 1e-12 * disc + 1e-300), -1.0, 1.0)
            area = disc**2 * (np.arccos(-offset) + offset * np.sqrt(1.0 - offset**2))
            total += 0.5 * (end - start) * weight * area
    return total


def enclosed_volume_m3(shape: Shape) -> float:
    """Volume that the triangles of a shape's surface enclose, by the divergence theorem, m3."""
    corners = shape.vertices_m[shape.triangles]
    return float(np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0)


def _check_closed(shape: Shape) -> None:
    enclosed = enclosed_volume_m3(shape)
    if not np.isclose(enclosed, shape.volume_m3, rtol=1e-6, atol=0.0):
        raise ValueError(
            f"the surface of shape {shape.name!r} ({shape.kind}) encloses {enclosed:.6g} m3, its volume is "
            f"{shape.volume_m3:.6g} m3: use monte_carlo_solid_fraction"
        )


def _mesh_below(heights: Floats, scales: Floats, up: Floats, shape: Shape, edges: Floats) -> Floats:
    """Volume below each edge of closed surfaces.

    By the divergence theorem with the field (z - h) e_z below the plane z = h, on which it vanishes: what is left is
    -(n_z A) times the mean of max(h - z, 0) of each triangle.
    """
    corners = shape.vertices_m[shape.triangles]
    normals = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros(len(edges))
    for first in range(0, len(heights), 64):
        part = slice(first, first + 64)
        z = np.sort(np.einsum("tci,ni->ntc", corners, up[part]), axis=2) * scales[part, None, None]
        nz = np.einsum("ti,ni->nt", normals, up[part]) * scales[part, None] ** 2
        levels = edges[None, :] - heights[part, None]
        for k in range(len(edges)):
            total[k] -= float((nz * _mean_ramp(levels[:, k, None], z)).sum())
    return total


def _mean_ramp(level: Floats, z: Floats) -> Floats:
    """Mean of max(level - z, 0) over triangles whose corners have the ascending heights z[..., 0:3]."""
    low, middle, high = z[..., 0], z[..., 1], z[..., 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        small = (level - low) ** 3 / (3.0 * (middle - low) * (high - low))
        rest = (high - level) ** 3 / (3.0 * (high - low) * (high - middle))
    whole = level - z.mean(axis=-1)
    return np.select([level <= low, level >= high, level <= middle], [0.0, whole, small], whole + rest)


def monte_carlo_solid_fraction(
    state: State,
    shapes: Sequence[Shape],
    edges_m: ArrayLike,
    *,
    min_m: ArrayLike,
    max_m: ArrayLike,
    points_per_layer: int,
    domain: Domain | None = None,
    axis: int = 2,
    seed: int = 1,
) -> SolidFraction:
    """Solid fraction of layers from random points: share of them inside of any particle, overlaps once.

    For all shapes with a closed surface, and for those with a formula. The standard error is the binomial one.

    Args:
        min_m, max_m: box that the layers cut, (3,), m; its extent along `axis` is not read.
        points_per_layer: random points in each layer.
        domain: which axes are periodic; none when absent.
        seed: of the random points.

    The other arguments are those of `solid_fraction_profile`.
    """
    edges = np.asarray(edges_m, dtype=float)
    low, high = np.array(min_m, dtype=float), np.array(max_m, dtype=float)
    layers = len(edges) - 1
    random = np.random.default_rng(seed)
    points = low + (high - low) * random.random((layers * points_per_layer, 3))
    layer = np.repeat(np.arange(layers), points_per_layer)
    points[:, axis] = edges[layer] + np.diff(edges)[layer] * random.random(len(points))
    order = np.argsort(points[:, axis])
    points, layer = points[order], layer[order]
    hit = _inside_any(points, state, shapes, domain, axis)
    share = np.bincount(layer, weights=hit, minlength=layers) / points_per_layer
    # With no or only hits the plain formula says 0: a pseudo-count keeps the error honest.
    guess = (share * points_per_layer + 1.0) / (points_per_layer + 2.0)
    return SolidFraction(edges, share, np.sqrt(guess * (1.0 - guess) / points_per_layer))


def _inside_any(points: Floats, state: State, shapes: Sequence[Shape], domain: Domain | None, axis: int) -> Floats:
    """1 for each point inside of some particle; the points ascend along `axis`, which is not periodic."""
    hit = np.zeros(len(points))
    rotations = state.rotations()
    positions = np.asarray(state.positions_m, dtype=float)
    for row in range(len(state)):
        shape, scale = shapes[int(state.shapes[row])], float(state.scales[row])
        reach = shape.bounding_radius_m * scale
        start, end = np.searchsorted(points[:, axis], [positions[row, axis] - reach, positions[row, axis] + reach])
        offset = minimum_image(points[start:end] - positions[row], domain)
        near = np.flatnonzero((offset**2).sum(axis=1) <= reach * reach)
        if len(near):
            hit[start + near[is_inside(offset[near] @ rotations[row] / scale, shape)]] = 1.0
    return hit


def is_inside(points_m: Floats, shape: Shape) -> np.ndarray:
    """Whether points of the body frame at scale 1, (n, 3), m, lie inside of a shape, (n,)."""
    if shape.kind == "sphere":
        inside: np.ndarray = (points_m**2).sum(axis=1) <= shape.bounding_radius_m**2
        return inside
    if shape.kind in CURVED:
        k = _symmetry_axis(shape)
        along = np.abs(points_m[:, k])
        across = (points_m**2).sum(axis=1) - along**2
        r, half = shape.parameters["radius_m"], 0.5 * _length(shape)
        if shape.kind == "cylinder":
            return (along <= half) & (across <= r * r)
        return across + np.maximum(along - (half - r), 0.0) ** 2 <= r * r
    return _winding(points_m, shape) != 0


def _winding(points: Floats, shape: Shape) -> np.ndarray:
    """How often the surface winds around each point: signed crossings of a ray upwards. Overlapping parts count twice,
    which is not 0 either."""
    a, b, c = (shape.vertices_m[shape.triangles[:, k]] for k in range(3))
    area = _cross_2d(b - a, c - a)
    keep = area != 0.0
    a, b, c, area = a[keep], b[keep], c[keep], area[keep]
    p = points[:, None, :]
    # Barycentric coordinates of the projection; half-open, so that an edge belongs to one of its triangles.
    u, v = _cross_2d(p - a, c - a) / area, _cross_2d(b - a, p - a) / area
    over = (u >= 0.0) & (v >= 0.0) & (u + v < 1.0)
    height = a[:, 2] + u * (b - a)[:, 2] + v * (c - a)[:, 2]
    winding: np.ndarray = (np.sign(area) * (over & (height > p[..., 2]))).sum(axis=1)
    return winding


def _cross_2d(p: Floats, q: Floats) -> Floats:
    product: Floats = p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]
    return product
