"""States and networks made by hand, for the tests of `sturz.measures`."""

from typing import Any

import numpy as np

import sturz
from sturz.contacts import NO_BOUNDARY, NO_PARTICLE
from sturz.state import Header, Shape, State
from sturz.status import Domain

HEADER = Header(run_id="made", seq=0, step=0, time_s=0.0, wall_time_ns=0, topology_epoch=0)
GRAVITY = np.array([0.0, 0.0, -9.81])


def state_of(positions: Any, **columns: Any) -> State:
    """A state of unrotated particles of shape 0 at rest, unless told otherwise."""
    x = np.asarray(positions, dtype=float).reshape(-1, 3)
    n = len(x)
    given: dict[str, Any] = {
        "ids": np.arange(n, dtype=np.uint64),
        "shapes": np.zeros(n, dtype=np.uint32),
        "materials": np.zeros(n, dtype=np.uint32),
        "scales": np.ones(n),
        "positions": x,
        "orientations": np.tile([1.0, 0.0, 0.0, 0.0], (n, 1)),
        "velocities": np.zeros((n, 3)),
        "angular_velocities": np.zeros((n, 3)),
        **columns,
    }
    return State(HEADER, given, (), GRAVITY)


def contacts_of(rows: list[tuple[int, int | None, Any, Any, float]], **columns: Any) -> sturz.Contacts:
    """A network from (a, b or None for a wall, point, normal, normal force)."""
    n = len(rows)
    ids = [(a, NO_PARTICLE if b is None else b) for a, b, *_ in rows]
    given: dict[str, Any] = {
        "ids": np.array(ids, dtype=np.uint64).reshape(n, 2),
        "boundaries": np.array([0 if b is None else NO_BOUNDARY for _, b, *_ in rows], dtype=np.uint32),
        "parts": np.zeros((n, 2), dtype=np.uint32),
        "points": np.array([row[2] for row in rows], dtype=float).reshape(n, 3),
        "normals": np.array([row[3] for row in rows], dtype=float).reshape(n, 3),
        "overlaps": np.full(n, 1e-3),
        "normal_forces": np.array([row[4] for row in rows], dtype=float),
        "tangential_forces": np.zeros((n, 3)),
        "moments": np.zeros((n, 3)),
        "kinds": np.full(n, sturz.ContactKind.SMOOTH, dtype=np.uint32),
        "point_counts": np.ones(n, dtype=np.uint32),
        **columns,
    }
    return sturz.Contacts(HEADER, given)


def shape_of(kind: str, vertices: Any, triangles: Any, volume: float, moments: Any, **parameters: float) -> Shape:
    """A shape at scale 1."""
    v = np.asarray(vertices, dtype=float).reshape(-1, 3)
    radius = float(np.linalg.norm(v, axis=1).max()) if len(v) else parameters["radius_m"]
    return Shape(
        name=kind,
        kind=kind,
        volume_m3=volume,
        bounding_radius_m=radius,
        principal_moments_per_density_m5=np.asarray(moments, dtype=float),
        vertices_m=v,
        triangles=np.asarray(triangles, dtype=np.uint32).reshape(-1, 3),
        parameters=parameters,
        parts=1,
    )


def sphere(radius: float = 0.5) -> Shape:
    """A sphere; its surface is never looked at."""
    volume = 4.0 / 3.0 * np.pi * radius**3
    return shape_of("sphere", [], [], volume, [0.4 * volume * radius**2] * 3, radius_m=radius)


def box(x: float = 1.0, y: float = 1.0, z: float = 1.0) -> Shape:
    """A box about the origin."""
    corners = np.array([[i, j, k] for i in (-0.5, 0.5) for j in (-0.5, 0.5) for k in (-0.5, 0.5)]) * [x, y, z]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    volume = x * y * z
    moments = volume / 12.0 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    return shape_of("box", corners, triangles, volume, moments)


def tetrahedron(edge: float = 1.0) -> Shape:
    """A regular tetrahedron about its centre."""
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) * edge / np.sqrt(8.0)
    triangles = [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)]
    volume = edge**3 / np.sqrt(72.0)
    return shape_of("tetrahedron", corners, triangles, volume, [volume * edge**2 / 20.0] * 3)


def rod(radius: float, length: float, kind: str) -> Shape:
    """A spherocylinder or cylinder along z; of its surface only the outermost points."""
    half = 0.5 * length if kind == "cylinder" else 0.5 * length - radius
    rim = [
        (radius * np.cos(a), radius * np.sin(a), z)
        for a in np.linspace(0, 2 * np.pi, 24, endpoint=False)
        for z in (-half, half)
    ]
    ends = [(0.0, 0.0, -0.5 * length), (0.0, 0.0, 0.5 * length)]
    cap = 0.0 if kind == "cylinder" else 4.0 / 3.0 * np.pi * radius**3
    name = "length_m" if kind == "cylinder" else "total_length_m"
    volume = 2.0 * half * np.pi * radius**2 + cap
    return shape_of(kind, [*rim, *ends], [], volume, [1.0, 1.0, 0.5], radius_m=radius, **{name: length})


def random_rotations(random: np.random.Generator, n: int) -> np.ndarray:
    """Unit quaternions, uniform, (n, 4)."""
    q = random.standard_normal((n, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def domain_of(low: Any, high: Any, periodic: tuple[bool, bool, bool]) -> Domain:
    """A cell."""
    return Domain(np.asarray(low, dtype=float), np.asarray(high, dtype=float), periodic)
