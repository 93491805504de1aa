"""Coordination, rattlers, kinds of contacts."""

import numpy as np
import pytest
from measured import box, contacts_of, random_rotations, sphere, state_of, tetrahedron

import sturz
from sturz.measures import ContactType, contact_types, coordination, type_shares
from sturz.state import rotation_matrices

UP = [0.0, 0.0, 1.0]


def test_neighbours_are_bodies_not_parts_and_touch_only_with_force() -> None:
    state = state_of(np.zeros((4, 3)), ids=np.array([3, 5, 8, 9], dtype=np.uint64))
    rows = [(3, 5, UP, UP, 1.0), (3, 5, UP, UP, 2.0), (3, 8, UP, UP, 1.0), (5, 8, UP, UP, 0.0), (9, None, UP, UP, 1.0)]
    found = coordination(state, contacts_of(rows), least_neighbours=1)
    assert found.per_particle.tolist() == [2, 1, 1, 0]
    assert found.mean == 1.0 and found.mean_without_rattlers == 1.0
    with_walls = coordination(state, contacts_of(rows), least_neighbours=1, with_walls=True)
    assert with_walls.per_particle.tolist() == [2, 1, 1, 1]


def test_rattlers_go_one_after_the_other() -> None:
    # A ring of five, each with the next and the one after it, and a tail of two.
    pairs = [*sorted({tuple(sorted((k, (k + d) % 5))) for k in range(5) for d in (1, 2)}), (4, 5), (5, 6)]
    found = coordination(state_of(np.zeros((7, 3))), contacts_of([(a, b, UP, UP, 1.0) for a, b in pairs]))
    assert found.is_rattler.tolist() == [False] * 5 + [True, True]
    assert found.mean_without_rattlers == 4.0
    assert found.per_particle_without_rattlers.tolist() == [4] * 5 + [0, 0]
    assert found.mean == pytest.approx((4 * 4 + 5 + 2 + 1) / 7)
    chain = contacts_of([(k, k + 1, UP, UP, 1.0) for k in range(6)])
    all_loose = coordination(state_of(np.zeros((7, 3))), chain, least_neighbours=2)
    assert all_loose.is_rattler.all() and np.isnan(all_loose.mean_without_rattlers)


def test_against_brute_force_on_random_graphs() -> None:
    random = np.random.default_rng(1)
    for _ in range(20):
        n = int(random.integers(2, 30))
        pairs = [(a, b) for a in range(n) for b in range(a + 1, n) if random.random() < 4 / n]
        found = coordination(state_of(np.zeros((n, 3))), contacts_of([(a, b, UP, UP, 1.0) for a, b in pairs]))
        alive = set(range(n))
        while True:
            degree = {k: sum(k in pair and set(pair) <= alive for pair in pairs) for k in alive}
            loose = {k for k in alive if degree[k] < 4}
            if not loose:
                break
            alive -= loose
        assert found.is_rattler.tolist() == [k not in alive for k in range(n)]
        if alive:
            assert found.mean_without_rattlers == pytest.approx(sum(degree.values()) / len(alive))


def test_laws_of_points_count_points() -> None:
    state = state_of(np.zeros((2, 3)))
    rows = [(0, 1, UP, UP, 1.0)] * 4
    network = contacts_of(rows, point_counts=np.array([1, 2, 3, 6], dtype=np.uint32))
    assert contact_types(state, network, [sphere()]).tolist() == [1, 2, 3, 3]


@pytest.mark.parametrize(
    ("turn", "expected"),
    [
        ((1, 0, 0, 0), ContactType.FACE_FACE),
        ((np.cos(0.4), 0, 0, np.sin(0.4)), ContactType.FACE_FACE),
        ((np.cos(np.pi / 8), np.sin(np.pi / 8), 0, 0), ContactType.EDGE_FACE),
        ((np.cos(0.3), 0.6 * np.sin(0.3), 0.8 * np.sin(0.3), 0), ContactType.SINGLE),
    ],
)
def test_generalized_overlap_looks_at_the_features(turn, expected) -> None:
    # The upper cube b comes down on the face of a, flat, on an edge, on a corner; all turned together at random.
    random = np.random.default_rng(2)
    kinds = np.array([sturz.ContactKind.OVERLAP], dtype=np.uint32)
    for _ in range(10):
        whole = random_rotations(random, 1)[0]
        both = np.array([whole, product(whole, np.array(turn, dtype=float))])
        state = state_of(np.zeros((2, 3)), orientations=both)
        normal = rotation_matrices(whole[None])[0] @ UP
        network = contacts_of([(0, 1, UP, normal, 1.0)], kinds=kinds, point_counts=np.array([5], dtype=np.uint32))
        assert contact_types(state, network, [box()]).tolist() == [int(expected)]
        wall = contacts_of([(1, None, UP, -normal, 1.0)], kinds=kinds)
        assert contact_types(state, wall, [box()]).tolist() == [int(expected)]


@pytest.mark.parametrize(("turn", "expected"), [(0.0, ContactType.EDGE_FACE), (0.4, ContactType.SINGLE)])
def test_edges_that_cross_touch_in_a_point_and_parallel_ones_along_their_length(turn, expected) -> None:
    on_edge = np.array([np.cos(np.pi / 8), np.sin(np.pi / 8), 0, 0])
    yaw = np.array([np.cos(turn / 2), 0, 0, np.sin(turn / 2)])
    state = state_of(np.zeros((2, 3)), orientations=np.array([on_edge, product(yaw, on_edge)]))
    network = contacts_of([(0, 1, UP, UP, 1.0)], kinds=np.array([sturz.ContactKind.OVERLAP], dtype=np.uint32))
    assert contact_types(state, network, [box()]).tolist() == [int(expected)]


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Of quaternions."""
    w = p[0] * q[0] - p[1:] @ q[1:]
    return np.array([w, *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))])


def test_a_composite_under_generalized_overlap_is_refused() -> None:
    shape = tetrahedron()
    object.__setattr__(shape, "parts", 2)
    network = contacts_of([(0, 1, UP, UP, 1.0)], kinds=np.array([sturz.ContactKind.OVERLAP], dtype=np.uint32))
    with pytest.raises(ValueError, match="2 parts"):
        contact_types(state_of(np.zeros((2, 3))), network, [shape])


def test_shares_and_constraints() -> None:
    state = state_of(np.zeros((3, 3)))
    network = contacts_of([(0, 1, UP, UP, 1.0), (0, 2, UP, UP, 1.0), (1, 2, UP, UP, 1.0), (0, None, UP, UP, 1.0)])
    types = np.array([1, 1, 2, 3])
    shares = type_shares(state, network, types)
    assert (shares.single, shares.edge_face, shares.face_face) == (pytest.approx(2 / 3), pytest.approx(1 / 3), 0.0)
    assert shares.z_iso == pytest.approx((2 + 3 + 3) / 3)
    with_walls = type_shares(state, network, types, with_walls=True)
    assert with_walls.z_iso == pytest.approx((2 + 3 + 3 + 3) / 3)
    one = type_shares(state, network, types, selected=np.array([False, False, True]))
    assert one.contacts_per_particle.tolist() == [1.0, 1.0, 0.0] and one.z_iso == 3.0


def test_no_contacts_and_no_particles() -> None:
    for n in (0, 2):
        state, network = state_of(np.zeros((n, 3))), contacts_of([])
        found = coordination(state, network)
        assert found.per_particle.tolist() == [0] * n
        assert np.isnan(type_shares(state, network, contact_types(state, network, [])).single)
