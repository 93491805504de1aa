"""What the contact network says: kinds of contacts, coordination number, isostaticity."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..contacts import NO_PARTICLE, ContactKind, Contacts
from ..state import Shape, State
from .bodies import Floats, rows_of


class ContactType(enum.IntEnum):
    """How two bodies touch, as Descantes 2022, section 3.1.2 counts; the number is that of the constraints."""

    SINGLE = 1
    EDGE_FACE = 2
    FACE_FACE = 3


@dataclass(frozen=True, eq=False)
class Coordination:
    """Touching neighbours per particle.

    Attributes:
        per_particle: neighbours of each particle, (n,).
        mean: over all particles; NaN of none.
        is_rattler: which particles carry nothing, (n,).
        per_particle_without_rattlers: neighbours that are no rattlers; 0 for rattlers themselves, (n,).
        mean_without_rattlers: the mean of that over those that are no rattlers; NaN when there are none.
    """

    per_particle: NDArray[np.int64]
    mean: float
    is_rattler: NDArray[np.bool_]
    per_particle_without_rattlers: NDArray[np.int64]
    mean_without_rattlers: float


def neighbour_pairs(state: State, contacts: Contacts, *, least_force_n: float = 0.0) -> NDArray[np.intp]:
    """Rows in the state of pairs of particles that touch, each pair once however many of their parts do, (m, 2).

    Args:
        least_force_n: pairs of parts that are pushed apart by no more than this are left out; those without force, too.
    """
    between = (contacts.ids[:, 1] != np.uint64(NO_PARTICLE)) & (contacts.normal_forces_n > least_force_n)
    rows = np.stack([rows_of(state.ids, contacts.ids[between, side]) for side in (0, 1)], axis=1)
    return np.unique(rows, axis=0) if len(rows) else rows.astype(np.intp)


def wall_neighbours(state: State, contacts: Contacts, *, least_force_n: float = 0.0) -> NDArray[np.int64]:
    """Boundaries that touch each particle, (n,)."""
    walls = (contacts.ids[:, 1] == np.uint64(NO_PARTICLE)) & (contacts.normal_forces_n > least_force_n)
    rows = rows_of(state.ids, contacts.ids[walls, 0])
    each = np.unique(np.stack([rows, contacts.boundaries[walls].astype(np.intp)], axis=1), axis=0)
    return np.bincount(each[:, 0].astype(np.intp), minlength=len(state)).astype(np.int64)


def coordination(
    state: State,
    contacts: Contacts,
    *,
    with_walls: bool = False,
    least_neighbours: int = 4,
    least_force_n: float = 0.0,
) -> Coordination:
    """Touching neighbours per particle: bodies, not points or parts.

    Rattlers have fewer than `least_neighbours` contacts with others that are none, walls included: they are taken away
    until none is left. Four hold a sphere without friction; three hold with friction, and hold a polyhedron on a face.

    Args:
        state, contacts: of the same step.
        with_walls: whether boundaries count as neighbours in the numbers that are returned.
        least_neighbours: of a particle that is no rattler.
        least_force_n: see `neighbour_pairs`.
    """
    n = len(state)
    pairs = neighbour_pairs(state, contacts, least_force_n=least_force_n)
    walls = wall_neighbours(state, contacts, least_force_n=least_force_n)
    rattler = np.zeros(n, dtype=bool)
    while True:
        kept = pairs[~rattler[pairs].any(axis=1)]
        held = np.bincount(kept.ravel(), minlength=n) + walls
        more = ~rattler & (held < least_neighbours)
        if not more.any():
            break
        rattler |= more
    counted = walls if with_walls else np.zeros(n, dtype=np.int64)
    per_particle = (np.bincount(pairs.ravel(), minlength=n) + counted).astype(np.int64)
    others = ~rattler
    inner = np.where(rattler, 0, np.bincount(kept.ravel(), minlength=n) + counted).astype(np.int64)
    return Coordination(
        per_particle=per_particle,
        mean=float(per_particle.mean()) if n else float("nan"),
        is_rattler=rattler,
        per_particle_without_rattlers=inner,
        mean_without_rattlers=float(inner[others].mean()) if others.any() else float("nan"),
    )


def contact_types(state: State, contacts: Contacts, shapes: Sequence[Shape]) -> NDArray[np.int64]:
    """`ContactType` of each row of the network, (m,).

    Under the laws of points the number of touching points decides: one, two, or more. Under `generalized_overlap` the
    points are those of a norm and fade into each other, so features decide: corners of either body that are no farther
    than the overlap behind its foremost one along the normal are in touch; two are an edge, three a face. A corner on
    anything and crossed edges are `SINGLE`, an edge on a face and edges side by side `EDGE_FACE`, faces `FACE_FACE`.

    Raises:
        ValueError: `generalized_overlap` of bodies of several parts: the client does not know which corner is whose.
    """
    types = np.clip(contacts.point_counts.astype(np.int64), 1, 3)
    by_features = np.flatnonzero(contacts.kinds == ContactKind.OVERLAP)
    if len(by_features) == 0:
        return types
    rotations = state.rotations()
    tolerance = np.maximum(contacts.overlaps_m, 0.0)
    # Corners in touch on either side: a plane or drum is a face. Directions of edges, for crossed ones.
    corners = np.full((len(types), 2), 3)
    edges = np.zeros((len(types), 2, 3))
    for side, sign in ((0, 1.0), (1, -1.0)):
        ids = contacts.ids[by_features, side]
        present = ids != np.uint64(NO_PARTICLE)
        chosen = by_features[present]
        rows = rows_of(state.ids, ids[present])
        for index, shape in enumerate(shapes):
            here = state.shapes[rows] == index
            if not here.any():
                continue
            if shape.parts != 1:
                raise ValueError(
                    f"shape {shape.name!r} has {shape.parts} parts: use a law of points to count its contacts"
                )
            contact, row = chosen[here], rows[here]
            normals = sign * np.einsum("nji,nj->ni", rotations[row], contacts.normals[contact])
            vertices = _corners(shape)
            depths = (normals @ vertices.T) * state.scales[row, None]
            size = shape.bounding_radius_m * state.scales[row]
            behind = depths.max(axis=1, keepdims=True) - depths
            corners[contact, side] = (behind <= np.maximum(tolerance[contact], 1e-9 * size)[:, None]).sum(axis=1)
            foremost = vertices[np.argsort(behind, axis=1)[:, :2]] * state.scales[row, None, None]
            edges[contact, side] = np.einsum("nij,nj->ni", rotations[row], foremost[:, 1] - foremost[:, 0])
    fewest, most = corners.min(axis=1), corners.max(axis=1)
    # Edges that cross touch in one point, edges side by side along their length.
    lengths = np.linalg.norm(edges, axis=2)
    apart = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / np.maximum(lengths.max(axis=1), 1e-300)
    along = (fewest == 2) & ((most >= 3) | (apart <= np.maximum(tolerance, 1e-9 * lengths.max(axis=1))))
    found = np.where(fewest >= 3, ContactType.FACE_FACE, np.where(along, ContactType.EDGE_FACE, ContactType.SINGLE))
    types[by_features] = found[by_features]
    return types


def _corners(shape: Shape) -> Floats:
    """Corners of the surface, each once."""
    rounded = np.round(shape.vertices_m / shape.bounding_radius_m, 9)
    corners: Floats = shape.vertices_m[np.unique(rounded, axis=0, return_index=True)[1]]
    return corners


@dataclass(frozen=True, eq=False)
class TypeShares:
    """How the particles of a set touch their neighbours.

    Attributes:
        single, edge_face, face_face: share of each type among the contacts; NaN without any.
        contacts_per_particle: of each type, (3,): z_s, z_d and z_t of Descantes 2022.
        z_iso: z_s + 2 z_d + 3 z_t, constraints per particle: 12 where they are as many as the degrees of freedom of
            bodies without symmetry and friction.
    """

    single: float
    edge_face: float
    face_face: float
    contacts_per_particle: Floats
    z_iso: float


def type_shares(
    state: State,
    contacts: Contacts,
    types: NDArray[np.int64],
    *,
    selected: NDArray[np.bool_] | None = None,
    with_walls: bool = False,
) -> TypeShares:
    """Shares of the types of contacts, and what they constrain.

    Args:
        types: of `contact_types`.
        selected: particles that count, (n,); all when absent. A pair is seen once from each of its sides.
        with_walls: whether contacts with boundaries count.
    """
    chosen = np.ones(len(state), dtype=bool) if selected is None else np.asarray(selected, dtype=bool)
    sums = np.zeros(3)
    pairs = contacts.ids[:, 1] != np.uint64(NO_PARTICLE)
    for side in (0, 1):
        seen = pairs | with_walls if side == 0 else pairs
        seen = np.flatnonzero(seen)
        rows = rows_of(state.ids, contacts.ids[seen, side])
        sums += np.bincount(types[seen][chosen[rows]] - 1, minlength=3)[:3]
    n, total = int(chosen.sum()), sums.sum()
    shares = sums / total if total else np.full(3, np.nan)
    per_particle = sums / n if n else np.full(3, np.nan)
    return TypeShares(
        single=float(shares[0]),
        edge_face=float(shares[1]),
        face_face=float(shares[2]),
        contacts_per_particle=per_particle,
        z_iso=float(per_particle @ [1.0, 2.0, 3.0]),
    )
