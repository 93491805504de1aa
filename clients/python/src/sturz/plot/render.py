"""Triangles to pixels with numpy alone: orthographic, depth-buffered, shaded.

Painter's algorithm (sorted polygons) fails for crosses that reach into one another, and 3D axes of matplotlib use it.
A depth buffer is exact, and takes a second for a hundred thousand triangles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..state import Shape, State

Array = NDArray[np.float64]

# Corners whose faces differ by less are drawn smooth: surfaces of spheres are, edges of boxes are not.
_SMOOTH_BELOW_RAD = np.deg2rad(35.0)
# Bounds the memory of one pass.
_PIXELS_PER_PASS = 2_000_000


@dataclass(frozen=True)
class View:
    """An orthographic view.

    Attributes:
        towards: direction in which one looks, (3,).
        up: what is up in the picture, (3,); need not be perpendicular.
    """

    towards: tuple[float, float, float] = (0.0, 1.0, 0.0)
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def axes(self) -> Array:
        """Rows: right, up and towards the viewer, (3, 3).

        Raises:
            ValueError: `up` is parallel to `towards`.
        """
        back = -np.asarray(self.towards, dtype=float)
        right = np.cross(np.asarray(self.up, dtype=float), back)
        if not np.linalg.norm(back) > 0 or not np.linalg.norm(right) > 1e-9 * np.linalg.norm(back):
            raise ValueError(f"a view towards {self.towards} with {self.up} up is none: they are parallel or zero")
        back, right = back / np.linalg.norm(back), right / np.linalg.norm(right)
        return np.array([right, np.cross(back, right), back])


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles in view coordinates (right, up, towards the viewer), m.

    Attributes:
        corners: (t, 3, 3).
        normals: of the corners, (t, 3, 3).
        particles: row of the particle of each triangle, (t,).
    """

    corners: Array
    normals: Array
    particles: NDArray[np.int64]


def corner_normals(shape: Shape) -> tuple[Array, Array]:
    """Corners (t, 3, 3) and unit normals of the corners (t, 3, 3) in the body frame.

    A corner takes the mean of all faces at its vertex that lie within some angle of its own face.
    """
    corners = np.asarray(shape.vertices_m, dtype=float)[shape.triangles]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(areas, axis=1)
    keep = lengths > 1e-12 * lengths.max(initial=0.0)
    corners, areas = corners[keep], areas[keep]
    faces = areas / np.linalg.norm(areas, axis=1, keepdims=True)
    rounded = np.round(corners.reshape(-1, 3) / (shape.bounding_radius_m * 1e-7))
    _, vertex = np.unique(rounded, axis=0, return_inverse=True)
    vertex = vertex.reshape(-1)
    face = np.repeat(np.arange(len(corners)), 3)
    normals = np.repeat(faces, 3, axis=0)
    order = np.argsort(vertex, kind="stable")
    for group in np.split(order, np.flatnonzero(np.diff(vertex[order])) + 1):
        around = faces[face[group]]
        near = around @ around.T > np.cos(_SMOOTH_BELOW_RAD)
        normals[group] = near @ areas[face[group]]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return corners, normals.reshape(-1, 3, 3)


def mesh(state: State, shapes: tuple[Shape, ...], view: View, rows: NDArray[np.int64]) -> Mesh:
    """The front faces of particles `rows`, seen in `view`."""
    axes = view.axes()
    rotations = state.rotations()
    scales = np.asarray(state.columns.get("scales", np.ones(len(state))), dtype=float)
    corners, normals, particles = [], [], []
    for index, shape in enumerate(shapes):
        of_shape = rows[state.shapes[rows] == index]
        if not len(of_shape):
            continue
        body_corners, body_normals = corner_normals(shape)
        view_from_body = axes @ rotations[of_shape]
        turned = np.einsum("nij,tcj->ntci", view_from_body, body_corners) * scales[of_shape, None, None, None]
        centres = np.asarray(state.positions_m[of_shape], dtype=float) @ axes.T
        corners.append((turned + centres[:, None, None, :]).reshape(-1, 3, 3))
        normals.append(np.einsum("nij,tcj->ntci", view_from_body, body_normals).reshape(-1, 3, 3))
        particles.append(np.repeat(of_shape, len(body_corners)))
    if not corners:
        return Mesh(np.empty((0, 3, 3)), np.empty((0, 3, 3)), np.empty(0, dtype=np.int64))
    all_corners = np.concatenate(corners)
    edges = all_corners[:, 1:, :2] - all_corners[:, :1, :2]
    front = edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0] > 0
    return Mesh(all_corners[front], np.concatenate(normals)[front], np.concatenate(particles)[front])


@dataclass(frozen=True, eq=False)
class Buffer:
    """What each pixel shows; row 0 is the lowest.

    Attributes:
        triangle: index in the mesh, -1 for none, (height, width).
        depth_m: towards the viewer, -inf for none.
        normal: unit, in view coordinates, (height, width, 3).
        particle: row of the particle, -1 for none.
    """

    triangle: NDArray[np.int64]
    depth_m: Array
    normal: Array
    particle: NDArray[np.int64]


def _weights(xy: Array, x: NDArray[Any], y: NDArray[Any]) -> Array:
    """Barycentric weights (k, 3) of points in triangles (k, 3, 2)."""
    (ax, ay), (bx, by), (cx, cy) = (xy[:, i].T for i in range(3))
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    b = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area
    c = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area
    return np.stack([1 - b - c, b, c], axis=1)


def rasterise(mesh: Mesh, *, left_m: float, bottom_m: float, pixel_m: float, width: int, height: int) -> Buffer:
    """The nearest triangle at every pixel's centre."""
    xy = (mesh.corners[:, :, :2] - (left_m, bottom_m)) / pixel_m - 0.5
    depth = mesh.corners[:, :, 2]
    low = np.clip(np.ceil(xy.min(axis=1)), 0, (width, height)).astype(np.int64)
    high = np.clip(np.floor(xy.max(axis=1)), -1, (width - 1, height - 1)).astype(np.int64)
    spans = np.maximum(high - low + 1, 0)
    counts = spans[:, 0] * spans[:, 1]
    nearest, farthest = depth.max(initial=0.0), depth.min(initial=0.0)
    # Depth in the high bits, triangle in the low ones: one maximum finds both, whatever the order.
    resolution = (2**31 - 1) / max(nearest - farthest, 1e-30)
    best = np.zeros(width * height, dtype=np.uint64)
    ends = np.cumsum(counts)
    start = 0
    while start < len(counts):
        done = ends[start - 1] if start else 0
        stop = max(int(np.searchsorted(ends, done + _PIXELS_PER_PASS, side="right")), start + 1)
        count = counts[start:stop]
        triangle = np.repeat(np.arange(start, stop), count)
        within = np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count)
        x = low[triangle, 0] + within % spans[triangle, 0]
        y = low[triangle, 1] + within // spans[triangle, 0]
        weights = _weights(xy[triangle], x, y)
        inside = (weights >= -1e-9).all(axis=1)
        triangle, x, y, weights = triangle[inside], x[inside], y[inside], weights[inside]
        level = ((weights * depth[triangle]).sum(axis=1) - farthest) * resolution
        key = (np.clip(level, 0, 2**31 - 1).astype(np.uint64) << np.uint64(32)) | (triangle + 1).astype(np.uint64)
        np.maximum.at(best, y * width + x, key)
        start = stop
    shown = (best & np.uint64(0xFFFFFFFF)).astype(np.int64).reshape(height, width) - 1
    rows, columns = np.nonzero(shown >= 0)
    triangle = shown[rows, columns]
    weights = _weights(xy[triangle], columns, rows)
    depths = np.full((height, width), -np.inf)
    depths[rows, columns] = (weights * depth[triangle]).sum(axis=1)
    normals = np.zeros((height, width, 3))
    mean = (weights[:, :, None] * mesh.normals[triangle]).sum(axis=1)
    normals[rows, columns] = mean / np.linalg.norm(mean, axis=1, keepdims=True)
    particles = np.full((height, width), -1, dtype=np.int64)
    particles[rows, columns] = mesh.particles[triangle]
    return Buffer(shown, depths, normals, particles)


def _blurred(values: Array, radius: int) -> Array:
    """Three box filters of `radius` pixels in either direction: nearly a Gaussian."""
    for _ in range(3):
        for axis in (0, 1):
            padded = np.pad(values, [(radius + 1, radius) if each == axis else (0, 0) for each in (0, 1)], mode="edge")
            total = np.cumsum(padded, axis=axis)
            size = values.shape[axis]
            upper = np.take(total, np.arange(2 * radius + 1, 2 * radius + 1 + size), axis=axis)
            values = (upper - np.take(total, np.arange(size), axis=axis)) / (2 * radius + 1)
    return values


def _edges(buffer: Buffer, jump_m: float) -> tuple[Array, Array]:
    """Outlines of particles where one hides another, and creases of one, as 0 or 1 per pixel."""
    outline = np.zeros(buffer.depth_m.shape, dtype=bool)
    crease = np.zeros_like(outline)
    for axis in (0, 1):
        first = tuple(slice(None, -1) if each == axis else slice(None) for each in (0, 1))
        second = tuple(slice(1, None) if each == axis else slice(None) for each in (0, 1))
        with np.errstate(invalid="ignore"):
            step = buffer.depth_m[first] - buffer.depth_m[second]
        other = buffer.particle[first] != buffer.particle[second]
        far = other | (np.abs(np.nan_to_num(step, nan=0.0, posinf=1e30, neginf=-1e30)) > jump_m)
        # The line belongs to what is in front, so that it is one pixel wide.
        nearer = np.nan_to_num(step, nan=0.0, posinf=1.0, neginf=-1.0) > 0
        outline[first] |= far & nearer
        outline[second] |= far & ~nearer
        bent = (buffer.normal[first] * buffer.normal[second]).sum(axis=-1) < np.cos(_SMOOTH_BELOW_RAD)
        crease[first] |= bent & ~far
    return outline.astype(float), crease.astype(float)


def shade(buffer: Buffer, colours: Array, *, size_m: float, pixel_m: float) -> Array:
    """RGBA picture, (height, width, 4): diffuse light from above left, occlusion in gaps, outlines.

    Args:
        colours: of the particles, (n, 3), 0 to 1.
        size_m: typical size of a particle.
        pixel_m: size of a pixel.
    """
    covered = buffer.particle >= 0
    if not covered.any():
        return np.zeros((*covered.shape, 4))
    key = np.array([-0.45, 0.65, 0.75])
    fill = np.array([0.6, -0.1, 0.5])
    key, fill = key / np.linalg.norm(key), fill / np.linalg.norm(fill)
    light = 0.42 + 0.62 * np.clip(buffer.normal @ key, 0, 1) + 0.14 * np.clip(buffer.normal @ fill, 0, 1)
    # Luft et al. 2006: what lies deeper than its blurred surroundings is in their shade.
    back = buffer.depth_m[covered].min() - 0.3 * size_m
    depth = np.where(covered, buffer.depth_m, back)
    for radius_m, strength in ((0.12 * size_m, 0.30), (0.45 * size_m, 0.32)):
        hidden = (_blurred(depth, max(int(radius_m / pixel_m), 1)) - depth) / (0.5 * size_m)
        light *= 1 - strength * np.clip(hidden, 0, 1)
    # A little haze tells near from far.
    span = max(buffer.depth_m[covered].max() - back, 1e-30)
    light *= 0.86 + 0.14 * (depth - back) / span
    outline, crease = _edges(buffer, 0.12 * size_m)
    light *= (1 - 0.62 * outline) * (1 - 0.22 * crease)
    picture = np.zeros((*covered.shape, 4))
    shaded = colours[buffer.particle[covered]] * light[covered, None]
    # Where light exceeds one it turns white instead of being cut off.
    over = np.clip(shaded - 1, 0, None).sum(axis=1, keepdims=True)
    picture[covered, :3] = np.clip(shaded + 0.3 * over, 0, 1)
    picture[covered, 3] = 1.0
    return picture


def reduced(picture: Array, factor: int) -> Array:
    """Means over blocks of factor x factor pixels, colours weighted by coverage."""
    height, width = (size // factor for size in picture.shape[:2])
    blocks = picture[: height * factor, : width * factor].reshape(height, factor, width, factor, 4)
    alpha = blocks[..., 3:]
    coverage = alpha.mean(axis=(1, 3))
    colours = (blocks[..., :3] * alpha).mean(axis=(1, 3)) / np.maximum(coverage, 1e-9)
    return np.concatenate([colours, coverage], axis=-1)


def project(points_m: ArrayLike, view: View) -> Any:
    """View coordinates of points (..., 3)."""
    return np.asarray(points_m, dtype=float) @ view.axes().T
