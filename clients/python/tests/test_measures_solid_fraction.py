"""Solid fraction of layers: closed forms, brute force, and random points against the exact integral."""

import numpy as np
import pytest
from measured import box, domain_of, random_rotations, rod, sphere, state_of, tetrahedron

from sturz.measures import enclosed_volume_m3, is_inside, monte_carlo_solid_fraction, solid_fraction_profile


def test_a_box_fills_its_layers() -> None:
    profile = solid_fraction_profile(state_of([[0, 0, 0.3]]), [box(1, 2, 0.5)], [0.0, 0.1, 0.4, 0.9], area_m2=4.0)
    # The box lies between 0.05 and 0.55.
    assert profile.solid_fraction == pytest.approx([0.25, 0.5, 0.5 * 0.15 / 0.5], abs=1e-15)
    assert profile.mean(0.0, 0.5) == (pytest.approx((0.025 + 0.15) / 0.4), 0.0)


def test_a_sphere_has_its_caps() -> None:
    edges = np.array([-1.0, -0.3, 0.2, 1.0])
    profile = solid_fraction_profile(state_of([[5, 5, 0.1]], scales=np.array([1.2])), [sphere()], edges, area_m2=2.0)
    r, reach = 0.6, np.clip(edges - 0.1 + 0.6, 0.0, 1.2)
    cap = np.pi * reach**2 * (3 * r - reach) / 3
    assert profile.solid_fraction * 2.0 * np.diff(edges) == pytest.approx(np.diff(cap), rel=1e-14)
    assert cap[-1] == pytest.approx(4 / 3 * np.pi * 0.6**3)


@pytest.mark.parametrize("shape", [box(1.0, 0.7, 0.4), tetrahedron(1.3)], ids=["box", "tetrahedron"])
def test_turned_polyhedra_against_a_count_of_lattice_points(shape) -> None:
    random = np.random.default_rng(5)
    state = state_of([[0, 0, 0.1]], orientations=random_rotations(random, 1), scales=np.array([1.1]))
    edges = np.linspace(-1.0, 1.0, 9)
    profile = solid_fraction_profile(state, [shape], edges, area_m2=1.0)
    assert profile.solid_fraction @ np.diff(edges) == pytest.approx(shape.volume_m3 * 1.1**3, rel=1e-13)
    step = 2.0 / 80
    axis = np.arange(-1.0 + step / 2, 1.0, step)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = is_inside((points - [0, 0, 0.1]) @ state.rotations()[0] / 1.1, shape)
    counted = np.histogram(points[inside, 2], bins=edges)[0] * step**3
    # The lattice errs by a fraction of the cells that the surface cuts.
    assert profile.solid_fraction * np.diff(edges) == pytest.approx(counted, abs=3e-3)


def test_planes_through_corners_and_faces_are_no_trouble() -> None:
    random = np.random.default_rng(6)
    shape = tetrahedron()
    corner = shape.vertices_m[0, 2]
    for _ in range(20):
        cut = random.uniform(-0.5, 0.5)
        edges = np.sort([-1.0, -corner, corner, cut, 1.0])
        profile = solid_fraction_profile(state_of([[0, 0, 0]]), [shape], edges, area_m2=1.0)
        below = [profile.solid_fraction[:k] @ np.diff(edges)[:k] for k in range(5)]
        # Two edges of the tetrahedron lie in the planes z = -+h; between, the section is a rectangle of
        # (a/2 + z a/(2h)) (a/2 - z a/(2h)) with a = 1.
        h = abs(corner)
        z = np.clip(edges, -h, h)
        exact = 0.25 * 2.0 * ((z + h) - (z**3 + h**3) / (3 * h * h)) / 1.0
        area_scale = shape.volume_m3 / (0.5 * (2 * h - 2 * h / 3))
        assert below == pytest.approx(exact * area_scale, abs=1e-14)


@pytest.mark.parametrize("kind", ["spherocylinder", "cylinder"])
def test_bodies_of_revolution(kind: str) -> None:
    shape = rod(0.3, 1.7, kind)
    edges = np.linspace(-1.2, 1.2, 25)
    upright = solid_fraction_profile(state_of([[0, 0, 0]]), [shape], edges, area_m2=1.0)
    middle = np.abs(upright.middles_m) < 0.4
    assert upright.solid_fraction[middle] == pytest.approx(np.pi * 0.09, rel=1e-12)
    level = state_of([[0, 0, 0]], orientations=np.array([[np.sqrt(0.5), np.sqrt(0.5), 0, 0]]))
    cut = solid_fraction_profile(level, [shape], [-1.2, 0.1, 1.2], area_m2=1.0).solid_fraction[0] * 1.3
    segment = 0.09 * (np.pi - np.arccos(1 / 3)) + 0.1 * np.sqrt(0.09 - 0.01)
    ball = np.pi * 0.4**2 * (0.9 - 0.4) / 3
    assert cut == pytest.approx(1.7 * segment if kind == "cylinder" else 1.1 * segment + ball, rel=1e-6)
    turned = state_of([[0, 0, 0]], orientations=random_rotations(np.random.default_rng(7), 1))
    profile = solid_fraction_profile(turned, [shape], edges, area_m2=1.0)
    assert profile.solid_fraction @ np.diff(edges) == pytest.approx(shape.volume_m3, rel=1e-12)
    shot = monte_carlo_solid_fraction(
        turned, [shape], edges, min_m=(-1.2, -1.2, 0), max_m=(1.2, 1.2, 0), points_per_layer=20000
    )
    deviations = (shot.solid_fraction - profile.solid_fraction / 2.4**2) / shot.standard_error
    assert np.abs(deviations).max() < 4.0


def test_random_points_in_a_periodic_cell_agree_with_the_exact_integral() -> None:
    random = np.random.default_rng(8)
    # A loose lattice across the cell's sides: nothing overlaps, much is cut by the boundary.
    places = np.array([[i, j, k] for i in range(3) for j in range(3) for k in range(4)]) * 1.8
    kinds = random.integers(0, 3, len(places)).astype(np.uint32)
    shapes = [sphere(), box(0.9, 0.8, 0.7), tetrahedron(1.2)]
    state = state_of(places, shapes=kinds, orientations=random_rotations(random, len(places)))
    cell = domain_of([0, 0, 0], [5.4, 5.4, 0], (True, True, False))
    edges = np.linspace(-1.0, 6.4, 12)
    exact = solid_fraction_profile(state, shapes, edges, area_m2=5.4**2)
    shot = monte_carlo_solid_fraction(
        state, shapes, edges, min_m=cell.min_m, max_m=cell.max_m, points_per_layer=20000, domain=cell
    )
    deviations = (shot.solid_fraction - exact.solid_fraction) / shot.standard_error
    assert np.abs(deviations).max() < 4.0
    assert 0.5 < np.sqrt((deviations**2).mean()) < 1.6


def test_nothing_and_what_cannot_be_done() -> None:
    empty = solid_fraction_profile(state_of([]), [box()], [0.0, 1.0], area_m2=1.0)
    assert empty.solid_fraction == pytest.approx([0.0])
    shape = box()
    assert enclosed_volume_m3(shape) == pytest.approx(1.0, rel=1e-15)
    object.__setattr__(shape, "volume_m3", 0.9)
    with pytest.raises(ValueError, match="monte_carlo_solid_fraction"):
        solid_fraction_profile(state_of([[0, 0, 0]]), [shape], [0.0, 1.0], area_m2=1.0)
