"""Finite-element grids for the Kratos partner: boxes and .mdpa files, and sums over elements.

Pure numpy: nothing here knows Kratos. Elements are hexahedra of 8 nodes or tetrahedra of 4, linear in each direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import SturzError

SIDES = ("x_low", "x_high", "y_low", "y_high", "z_low", "z_high")
_CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
_FACES = {
    8: np.array([(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (3, 7, 6, 2), (0, 4, 7, 3), (1, 2, 6, 5)]),
    4: np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]),
}
# Kuhn's cut of a cube into six tetrahedra along its diagonal: neighbouring cubes cut their common face alike.
_TETRAHEDRA = np.array([(0, 1, 2, 6), (0, 5, 1, 6), (0, 4, 5, 6), (0, 7, 4, 6), (0, 3, 7, 6), (0, 2, 3, 6)])


class GridError(SturzError):
    """A mesh that cannot be used; the text says why."""


@dataclass(frozen=True)
class Box:
    """A box cut into equal bricks.

    Attributes:
        origin_m: its lowest corner, m.
        size_m: its edges, m.
        counts: bricks along x, y and z.
        cells: "hexahedra", or "tetrahedra": each brick is cut into six.
    """

    origin_m: tuple[float, float, float]
    size_m: tuple[float, float, float]
    counts: tuple[int, int, int]
    cells: str = "hexahedra"

    def __post_init__(self) -> None:
        if self.cells not in ("hexahedra", "tetrahedra"):
            raise GridError(f"Box.cells is {self.cells!r}; allowed are 'hexahedra' and 'tetrahedra'")
        if len(self.counts) != 3 or min(self.counts) < 1:
            raise GridError(f"Box.counts is {self.counts}; three numbers of at least 1 are needed")
        if len(self.size_m) != 3 or not min(self.size_m) > 0 or not np.all(np.isfinite(self.origin_m)):
            raise GridError(f"Box.size_m is {self.size_m}; three positive lengths are needed, and a finite origin_m")


@dataclass(frozen=True)
class MdpaFile:
    """A mesh in Kratos' own format, of tetrahedra or of hexahedra; its sub model parts name the boundaries.

    Attributes:
        path: of the file (`.mdpa`).
    """

    path: str


@dataclass
class Grid:
    """Nodes and elements, with periodic nodes seen as one.

    A *node* is what Kratos sees, a *point* what the coupling sees: periodic images of a node are one point.

    Attributes:
        nodes_m: (N, 3), m.
        cells: node numbers of each element, (M, 8) or (M, 4), in Kratos' order.
        groups: node numbers of each named part of the boundary.
        owner: the point of each node, (N,).
    """

    nodes_m: NDArray[np.float64]
    cells: NDArray[np.intp]
    groups: dict[str, NDArray[np.intp]]
    owner: NDArray[np.intp] = field(default_factory=lambda: np.zeros(0, np.intp))
    _same_shape: bool = False

    def __post_init__(self) -> None:
        if len(self.owner) == 0:
            self.owner = np.arange(len(self.nodes_m))
        volumes = np.sum(self._gauss[1], axis=-1)
        if not np.all(volumes > 0):
            bad = int(np.argmin(volumes))
            raise GridError(f"element {bad + 1} has the volume {volumes[bad]:.3g} m3: its nodes are in a wrong order")

    @property
    def n(self) -> int:
        """Number of points."""
        return int(self.owner.max()) + 1

    @cached_property
    def first_node(self) -> NDArray[np.intp]:
        """The node that stands for each point, (n,)."""
        return np.unique(self.owner, return_index=True)[1]

    @cached_property
    def cell_points(self) -> NDArray[np.intp]:
        """Points of each element, as `cells`."""
        return self.owner[self.cells]

    @cached_property
    def _gauss(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Shape functions (q, k), weights (M or 1, q) and gradients (M or 1, q, k, 3) at quadrature points."""
        shapes, slopes, weights = _quadrature(self.cells.shape[1])
        corners = self.nodes_m[self.cells[:1] if self._same_shape else self.cells]
        jacobian = np.einsum("qka,ekb->eqab", slopes, corners)
        weight = np.linalg.det(jacobian) * weights
        gradient = np.einsum("eqba,qka->eqkb", np.linalg.inv(jacobian), slopes)
        return shapes, weight, gradient

    @cached_property
    def mass(self) -> NDArray[np.float64]:
        """Element integrals of N_i N_j, (M or 1, k, k), m3."""
        shapes, weight, _ = self._gauss
        return np.asarray(np.einsum("eq,qi,qj->eij", weight, shapes, shapes), float)

    @cached_property
    def _slope(self) -> NDArray[np.float64]:
        """Element integrals of N_i dN_j/dx_d, (M or 1, k * 3, k)."""
        shapes, weight, gradient = self._gauss
        k = self.cells.shape[1]
        return np.asarray(np.einsum("eq,qi,eqjd->eidj", weight, shapes, gradient), float).reshape(-1, k * 3, k)

    @cached_property
    def shares_m3(self) -> NDArray[np.float64]:
        """Part of each element's volume that belongs to each of its nodes, (M, k), m3."""
        return np.broadcast_to(self.mass.sum(axis=-1), self.cells.shape)

    @cached_property
    def cell_volumes_m3(self) -> NDArray[np.float64]:
        """(M,), m3."""
        return np.asarray(self.shares_m3.sum(axis=-1), float)

    @cached_property
    def volumes_m3(self) -> NDArray[np.float64]:
        """Volume of each point, (n,), m3: the integral of its shape function."""
        return self.gather(self.shares_m3)

    def gather(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sums (M, k) or (M, k, c) over the elements of each point: (n,) or (n, c)."""
        index = self.cell_points.ravel()
        if values.ndim == 2:
            return np.asarray(np.bincount(index, weights=values.ravel(), minlength=self.n), float)
        return np.stack([self.gather(values[..., c]) for c in range(values.shape[-1])], axis=-1)

    def cell_mean(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean of a point field (n,) over each element, (M,)."""
        return np.asarray(np.sum(self.shares_m3 * values[self.cell_points], axis=-1) / self.cell_volumes_m3, float)

    def _slope_sums(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Integrals of N_i grad f: of (n,) values (n, 3); of (n, c) values (n, 3, c)."""
        columns = values.reshape(len(values), -1)
        local = self._slope @ columns[self.cell_points]
        sums = self.gather(local.reshape(len(self.cells), self.cells.shape[1], -1))
        return sums.reshape(len(values), 3, *values.shape[1:])

    def gradient(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Gradient at the points by lumped projection; axis 1 is the direction of the derivative."""
        sums = self._slope_sums(values)
        return sums / self.volumes_m3.reshape(-1, *(1,) * (sums.ndim - 1))

    def consistent_gradient(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Gradient (n, 3) of (n,) values by L2 projection, by conjugate gradients to 1e-12.

        The integral of N_j g equals that of N_j grad f for every j, so the mass that crosses the boundary is exact.
        """
        return self.solve_mass(self._slope_sums(values), np.ones(len(self.cells)))

    def mass_times(self, values: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """Integrals of w N_i f for f (n, c) and a w that is constant in each element, (M,): (n, c)."""
        return self.gather(weights[:, None, None] * (self.mass @ values[self.cell_points]))

    def solve_mass(self, wanted: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """The f (n, c) with `mass_times(f, weights) == wanted` to 1e-12, by conjugate gradients."""
        inverse = 1.0 / self.gather(self.shares_m3 * weights[:, None])[:, None]
        result, residual = np.zeros_like(wanted), wanted
        scale = max(float(np.abs(wanted).max()), np.finfo(float).tiny)
        search = inverse * residual
        rho = np.sum(residual * search, axis=0)
        for _ in range(500):
            if np.abs(residual).max() <= 1e-12 * scale:
                return result
            image = self.mass_times(search, weights)
            step = rho / np.maximum(np.sum(search * image, axis=0), np.finfo(float).tiny)
            result = result + step * search
            residual = residual - step * image
            conditioned = inverse * residual
            previous, rho = rho, np.sum(residual * conditioned, axis=0)
            search = conditioned + rho / np.maximum(previous, np.finfo(float).tiny) * search
        raise GridError("a projection onto the nodes did not converge in 500 iterations")

    @cached_property
    def _boundary(self) -> NDArray[np.intp]:
        """Faces that only one element has, (F, 4) or (F, 3), ordered so that normals point outwards."""
        local = _FACES[self.cells.shape[1]]
        faces = self.cells[:, local].reshape(-1, local.shape[1])
        _, index, times = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        return np.asarray(faces[index[times == 1]], np.intp)

    def faces(self, group: str) -> NDArray[np.intp]:
        """Boundary faces all of whose nodes are in a group, (F, 4) or (F, 3)."""
        inside = np.zeros(len(self.nodes_m), bool)
        inside[self.groups[group]] = True
        return self._boundary[np.all(inside[self._boundary], axis=1)]

    def areas_m2(self, faces: NDArray[np.intp]) -> NDArray[np.float64]:
        """Outward area vectors of faces, (F, 3), m2."""
        corners = self.nodes_m[faces]
        if faces.shape[1] == 3:
            return 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])

    def flux_m3_per_s(self, group: str, void_fraction: NDArray[np.float64], velocity: NDArray[np.float64]) -> float:
        """Outward volume flux of fluid through a group, the integral of e u.n over its plane faces, m3/s."""
        faces = self.faces(group)
        if len(faces) == 0:
            return 0.0
        k = faces.shape[1]
        apart = np.abs(np.subtract.outer(np.arange(k), np.arange(k)))
        mass = np.array([4, 2, 1])[np.minimum(apart, 4 - apart)] / 36 if k == 4 else (1 + np.eye(3)) / 12
        points = self.owner[faces]
        normal = np.einsum("fjd,fd->fj", velocity[points], self.areas_m2(faces))
        return float(np.einsum("fi,ij,fj->", void_fraction[points], mass, normal))


def _quadrature(k: int) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Shape functions (q, k), their local slopes (q, k, 3), weights (q,): exact for products of two shape functions."""
    if k == 4:
        a, b = (5 + 3 * 5**0.5) / 20, (5 - 5**0.5) / 20
        shapes = np.full((4, 4), b) + (a - b) * np.eye(4)
        slopes = np.broadcast_to(np.array([(-1, -1, -1), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float), (4, 4, 3))
        return shapes, slopes, np.full(4, 1 / 24)
    at = (_CORNERS - 0.5) / 3**0.5 + 0.5
    line = np.where(_CORNERS == 1, at[:, None, :], 1 - at[:, None, :])
    sign = np.where(_CORNERS == 1, 1.0, -1.0)
    slopes = np.stack([sign[:, d] * np.prod(np.delete(line, d, axis=2), axis=2) for d in range(3)], axis=-1)
    return np.prod(line, axis=2), slopes, np.full(8, 0.125)


def box_grid(box: Box, periodic: Sequence[bool] = (False, False, False)) -> Grid:
    """The grid of a box; nodes run fastest along x. On a periodic axis the last layer of nodes images the first."""
    counts = np.array(box.counts)
    axes = [np.arange(m + 1) for m in counts]
    k, j, i = (a.ravel() for a in np.meshgrid(axes[2], axes[1], axes[0], indexing="ij"))
    index = np.stack([i, j, k], axis=-1)
    nodes = np.array(box.origin_m) + index * (np.array(box.size_m) / counts)
    strides = np.array([1, counts[0] + 1, (counts[0] + 1) * (counts[1] + 1)])
    low = index[np.all(index < counts, axis=1)] @ strides
    cells = low[:, None] + _CORNERS @ strides
    if box.cells == "tetrahedra":
        cells = cells[:, _TETRAHEDRA].reshape(-1, 4)
    groups = {}
    for axis, name in enumerate("xyz"):
        groups[f"{name}_low"] = np.flatnonzero(index[:, axis] == 0)
        groups[f"{name}_high"] = np.flatnonzero(index[:, axis] == counts[axis])
    wrapped = np.where(np.array(periodic), index % counts, index)
    owner = np.unique(wrapped @ strides, return_inverse=True)[1].reshape(-1)
    return Grid(nodes, cells, groups, owner, _same_shape=box.cells == "hexahedra")


def read_mdpa(path: str | Path) -> Grid:
    """Nodes, elements and the nodes of sub model parts of an .mdpa file; conditions and data are passed over.

    Raises:
        GridError: a file that cannot be read, or with other elements than linear tetrahedra or hexahedra of one kind.
    """
    try:
        lines = Path(path).read_text().splitlines()
    except OSError as error:
        raise GridError(f"{path}: {error.strerror}") from error
    nodes: dict[int, list[float]] = {}
    cells: list[list[int]] = []
    groups: dict[str, list[int]] = {}
    blocks: list[list[str]] = []
    for number, line in enumerate(lines, 1):
        words = line.split("//")[0].split()
        if not words:
            continue
        if words[0] == "Begin":
            blocks.append(words[1:])
            if words[1] == "SubModelPart":
                groups[words[2]] = []
        elif words[0] == "End":
            blocks.pop()
        elif blocks:
            try:
                _read_row(blocks, words, nodes, cells, groups)
            except ValueError as error:
                raise GridError(f"{path}, line {number}: {error}") from error
    return _from_mdpa(path, nodes, cells, groups)


def _read_row(
    blocks: list[list[str]],
    words: list[str],
    nodes: dict[int, list[float]],
    cells: list[list[int]],
    groups: dict[str, list[int]],
) -> None:
    kind = blocks[-1][0]
    if kind == "Nodes":
        nodes[int(words[0])] = [float(word) for word in words[1:4]]
    elif kind == "Elements":
        cells.append([int(word) for word in words[2:]])
    elif kind == "SubModelPartNodes":
        for block in blocks:
            if block[0] == "SubModelPart":
                groups[block[1]].append(int(words[0]))


def _from_mdpa(
    path: str | Path, nodes: dict[int, list[float]], cells: list[list[int]], groups: dict[str, list[int]]
) -> Grid:
    sizes = {len(cell) for cell in cells}
    if sizes not in ({4}, {8}):
        raise GridError(f"{path}: elements of {sorted(sizes)} nodes; allowed are all of 4 (tetrahedra) or all of 8")
    ids = np.array(sorted(nodes))
    known = set(nodes)
    unknown = {i for cell in cells for i in cell} - known | {i for group in groups.values() for i in group} - known
    if unknown:
        raise GridError(f"{path}: node {min(unknown)} is used but not defined")
    coordinates = np.array([nodes[i] for i in ids])
    parts = {name: np.unique(np.searchsorted(ids, group)) for name, group in groups.items() if group}
    return Grid(coordinates, np.searchsorted(ids, np.array(cells)), parts)
