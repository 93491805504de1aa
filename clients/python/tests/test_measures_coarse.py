"""Coarse-grained profiles: a manufactured shear flow (PHYSICS C3), brute force, nothing."""

import numpy as np
import pytest
from measured import state_of

from sturz.measures import coarse_profile


def sheared(random: np.random.Generator, n: int, rate: float, temperature: float):
    x = random.random((n, 3)) * [4, 4, 20] - [0, 0, 10]
    v = random.standard_normal((n, 3)) * np.sqrt(temperature)
    v[:, 0] += rate * x[:, 2]
    return state_of(x, velocities=v)


def test_the_width_makes_kinetic_stress_of_shear_and_it_is_taken_out() -> None:
    random = np.random.default_rng(1)
    n, rate, temperature = 3000, 0.7, 0.3
    states = [sheared(random, n, rate, temperature) for _ in range(60)]
    density = n / (16 * 20)
    for width in (0.25, 0.5, 1.0):
        found = coarse_profile(states, np.ones(n), np.linspace(-2, 2, 9), width_m=width, area_m2=16.0)
        # Effective samples per place: 60 n w sqrt(4 pi) / 20; the variance of a variance is 2 / N.
        error = np.sqrt(2 / (60 * n * width * np.sqrt(4 * np.pi) / 20))
        expected = density * (temperature + rate**2 * width**2)
        assert found.density_kg_per_m3 == pytest.approx(np.full(9, density), rel=4 * error)
        assert found.shear_rate_per_s[:, 0] == pytest.approx(np.full(9, rate), rel=0.1)
        assert found.kinetic_stress_pa[:, 0, 0] == pytest.approx(np.full(9, expected), rel=5 * error)
        assert found.scale_free_stress_pa[:, 0, 0] == pytest.approx(np.full(9, density * temperature), rel=8 * error)
        for k in (1, 2):
            assert found.kinetic_stress_pa[:, k, k] == pytest.approx(np.full(9, density * temperature), rel=5 * error)


def test_against_sums() -> None:
    random = np.random.default_rng(2)
    states = [sheared(random, 7, 1.0, 1.0) for _ in range(2)]
    mass, keep = random.uniform(1, 2, 7), np.array([1, 1, 0, 1, 1, 1, 1], dtype=bool)
    y, w = 0.3, 4.0
    found = coarse_profile(states, mass, [y, y + 1e-6], width_m=w, area_m2=2.0, selected=keep)
    rho, p, rows = 0.0, np.zeros(3), []
    for state in states:
        for k in np.flatnonzero(keep):
            phi = np.exp(-((y - state.positions_m[k, 2]) ** 2) / (2 * w * w)) / (np.sqrt(2 * np.pi) * w * 2.0 * 2)
            rho += mass[k] * phi
            p += mass[k] * phi * state.velocities_m_per_s[k]
            rows.append((mass[k] * phi, state.velocities_m_per_s[k]))
    kinetic = sum(m * np.outer(v - p / rho, v - p / rho) for m, v in rows)
    assert found.density_kg_per_m3[0] == pytest.approx(rho) and found.velocity_m_per_s[0] == pytest.approx(p / rho)
    assert found.kinetic_stress_pa[0] == pytest.approx(kinetic, abs=1e-12)
    difference = (found.velocity_m_per_s[1] - found.velocity_m_per_s[0]) / 1e-6
    assert found.shear_rate_per_s[0] == pytest.approx(difference, rel=1e-4)


def test_nothing() -> None:
    found = coarse_profile([state_of([])], [], [0.0], width_m=1.0, area_m2=1.0)
    assert found.density_kg_per_m3.tolist() == [0.0] and np.isnan(found.velocity_m_per_s).all()
