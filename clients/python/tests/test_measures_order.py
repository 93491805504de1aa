"""Pair correlation and nematic order."""

import numpy as np
import pytest
from measured import domain_of, random_rotations

from sturz.measures import isotropic_order, nematic_order, pair_correlation
from sturz.state import rotation_matrices


@pytest.mark.parametrize("periodic", [(True, True, True), (True, True, False), (False, False, False)])
def test_an_ideal_gas_has_one_everywhere(periodic) -> None:
    random = np.random.default_rng(1)
    low, high = np.array([0, 0, 0.0]), np.array([1.0, 1.5, 0.6])
    cell = domain_of(low, high, periodic)
    edges = np.linspace(0.0, 0.5, 6)
    snapshots = []
    for _ in range(40):
        points = low + (high - low) * random.random((300, 3))
        snapshots.append(pair_correlation(points, edges, min_m=low, max_m=high, domain=cell).g)
    # Pairs of one snapshot are not independent: the scatter over snapshots is the error.
    error = np.std(snapshots, axis=0, ddof=1) / np.sqrt(40)
    assert np.abs((np.mean(snapshots, axis=0) - 1.0) / error).max() < 4.0
    assert error.max() < 0.02
    whole = pair_correlation(np.zeros((2, 3)), np.linspace(0, 2.0, 81), min_m=low, max_m=high, domain=cell)
    assert whole.ideal_pairs.sum() == pytest.approx(1.0, abs=1e-12)


def test_a_fully_periodic_shell_has_its_volume() -> None:
    cell = domain_of([0, 0, 0], [2, 2, 2], (True, True, True))
    found = pair_correlation(np.zeros((11, 3)), [0.2, 0.3, 0.9], min_m=[0] * 3, max_m=[2] * 3, domain=cell)
    shells = 4 / 3 * np.pi * np.diff(np.array([0.2, 0.3, 0.9]) ** 3)
    assert found.ideal_pairs == pytest.approx(55 * shells / 8, rel=2e-4)


def test_a_periodic_lattice_has_its_neighbours() -> None:
    places = np.stack(np.meshgrid(*[np.arange(4.0)] * 3), axis=-1).reshape(-1, 3)
    cell = domain_of([0, 0, 0], [4, 4, 4], (True, True, True))
    found = pair_correlation(places, [0.9, 1.1, 1.3, 1.5], min_m=[0] * 3, max_m=[4] * 3, domain=cell)
    assert found.pairs.tolist() == [64 * 6 // 2, 0, 64 * 12 // 2]
    assert found.distances_m == pytest.approx([1.0, 1.2, 1.4])


def test_none_one_and_a_box_that_is_not_the_cell() -> None:
    for n in (0, 1):
        found = pair_correlation(np.zeros((n, 3)), [0.0, 1.0], min_m=[0] * 3, max_m=[1] * 3)
        assert found.pairs.tolist() == [0] and np.isnan(found.g[0])
    cell = domain_of([0, 0, 0], [4, 4, 4], (True, False, False))
    with pytest.raises(ValueError, match="whole cell"):
        pair_correlation(np.zeros((2, 3)), [0.0, 1.0], min_m=[0, 0, 0], max_m=[1, 1, 1], domain=cell)


def test_parallel_axes_and_axes_in_a_plane() -> None:
    u = np.array([0.6, 0.0, 0.8])
    parallel = nematic_order(np.outer([1, -1, 1, -1], u))
    assert parallel.order == pytest.approx(1.0) and abs(parallel.director @ u) == pytest.approx(1.0)
    angles = np.linspace(0, np.pi, 60, endpoint=False)
    plane = nematic_order(np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1))
    assert plane.order == pytest.approx(0.25) and np.trace(plane.tensor) == pytest.approx(0.0, abs=1e-15)
    assert np.isnan(nematic_order(np.zeros((0, 3))).order)


@pytest.mark.parametrize("n", [1, 2, 500, 2500])
def test_the_baseline_is_that_of_random_axes(n: int) -> None:
    random = np.random.default_rng(2)
    orders = [nematic_order(rotation_matrices(random_rotations(random, n))[:, :, 0]).order for _ in range(100)]
    mean, deviation = isotropic_order(n)
    assert np.mean(orders) == pytest.approx(mean, abs=4.0 * max(deviation, 1e-12) / np.sqrt(100))
    if n == 1:
        assert mean == pytest.approx(1.0)
