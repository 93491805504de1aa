"""Velocities, energies, surfaces, avalanches, mixing, drums."""

import numpy as np
import pytest
from measured import box, contacts_of, domain_of, random_rotations, sphere, state_of

import sturz.measures as measures


def test_a_normal_distribution() -> None:
    x = np.random.default_rng(1).normal(2.0, 3.0, 100_000)
    found = measures.distribution(x, np.linspace(-10, 14, 25))
    assert found.kurtosis == pytest.approx(3.0, abs=0.07)
    assert found.mean == pytest.approx(2.0, abs=0.04) and found.deviation == pytest.approx(3.0, abs=0.03)
    expected = np.exp(-0.5 * ((found.middles - 2) / 3) ** 2) / np.sqrt(18 * np.pi)
    assert found.density == pytest.approx(expected, abs=5e-3)
    assert np.isnan(measures.distribution([], [0, 1]).mean)


def test_masses_moments_and_energy_of_turned_boxes() -> None:
    random = np.random.default_rng(2)
    w, scale = random.standard_normal((2, 3)), np.array([1.0, 2.0])
    state = state_of(
        [[0, 0, 1], [0, 0, 4]],
        scales=scale,
        materials=np.array([1, 0], dtype=np.uint32),
        orientations=random_rotations(random, 2),
        velocities=random.standard_normal((2, 3)),
        angular_velocities=w,
    )
    shape = box(1.0, 0.5, 0.2)
    heavy = measures.bodies(state, [shape], [7.0, 3.0])
    assert heavy.mass_kg == pytest.approx([0.3, 0.1 * 8 * 7])
    assert heavy.equivalent_diameter_m == pytest.approx(np.cbrt(6 * heavy.volume_m3 / np.pi))
    energy = measures.energy_partition(state, heavy)
    expected = 0.0
    for k, turn in enumerate(state.rotations()):
        inertia = turn @ np.diag(heavy.moments_kg_m2[k]) @ turn.T
        expected += 0.5 * w[k] @ inertia @ w[k]
    assert energy.rotation_j == pytest.approx(expected)
    assert energy.potential_j == pytest.approx(9.81 * (0.3 + 4 * 5.6)) and np.isnan(energy.elastic_j)
    with pytest.raises(ValueError, match="1 densities"):
        measures.bodies(state, [shape], [7.0])


def test_profile_against_brute_force() -> None:
    random = np.random.default_rng(3)
    mass = random.uniform(1, 2, 40)
    states = [
        state_of(
            random.random((40, 3)),
            velocities=random.standard_normal((40, 3)),
            angular_velocities=random.standard_normal((40, 3)),
        )
        for _ in range(3)
    ]
    edges = np.array([0.0, 0.3, 0.5, 0.51, 2.0, 3.0])
    found = measures.velocity_profile(states, mass, edges, axis=1)
    y = np.concatenate([state.positions_m[:, 1] for state in states])
    v = np.concatenate([state.velocities_m_per_s for state in states])
    m = np.tile(mass, 3)
    for k in range(4):
        inside = (y >= edges[k]) & (y < edges[k + 1])
        if inside.any():
            mean = np.average(v[inside], axis=0, weights=m[inside])
            assert found.velocity_m_per_s[k] == pytest.approx(mean)
            d = v[inside] - mean
            tensor = (m[inside, None, None] * d[:, :, None] * d[:, None, :]).sum(axis=0) / m[inside].sum()
            assert found.temperature_m2_per_s2[k] == pytest.approx(tensor, abs=1e-13)
            assert found.granular_temperature_m2_per_s2[k] == pytest.approx(
                measures.granular_temperature(v[inside], m[inside]), abs=1e-13
            )
    assert np.isnan(found.velocity_m_per_s[4]).all() and found.particles[4] == 0
    assert np.isnan(measures.granular_temperature([]))


def test_shear_rate_and_inertial_number_of_uniform_shear() -> None:
    z = (np.arange(200) + 0.5) / 200
    state = state_of(np.stack([0 * z, 0 * z, z], axis=1), velocities=np.stack([3 * z, 0 * z, 0 * z], axis=1))
    profile = measures.velocity_profile([state], np.ones(200), np.linspace(0, 1, 6))
    assert profile.shear_rate_per_s(0)[1:-1] == pytest.approx(3.0, rel=1e-12)
    i = measures.inertial_number([-3.0, 3.0], 0.1, 2500.0, [900.0, 0.0])
    assert i[0] == pytest.approx(3.0 * 0.1 * 50 / 30) and np.isnan(i[1])


def test_centre_of_mass_across_the_side_of_the_cell() -> None:
    cell = domain_of([1, 0, 0], [3, 0, 0], (True, False, False))
    centre = measures.centre_of_mass_m([[1.1, 0, 1], [2.9, 4, 2]], [1.0, 1.0], cell)
    assert min(abs(centre[0] - 1.0), abs(centre[0] - 3.0)) < 1e-12
    assert centre[1:] == pytest.approx([2.0, 1.5])
    assert np.isnan(measures.centre_of_mass_m([], [])).all()


def test_the_angle_of_a_slope_and_its_error() -> None:
    random = np.random.default_rng(4)
    slope, noise, errors, angles = np.tan(0.5), 0.02, [], []
    for _ in range(100):
        x = np.linspace(0.025, 0.975, 20)
        surface = measures.FreeSurface(x, slope * x + 0.3 + noise * random.standard_normal(20))
        angle = measures.surface_angle(surface)
        angles.append(angle.angle_rad)
        errors.append(angle.standard_error_rad)
    assert np.mean(angles) == pytest.approx(0.5, abs=4 * np.std(angles) / 10)
    assert np.mean(errors) == pytest.approx(np.std(angles), rel=0.2)
    assert np.isnan(measures.surface_angle(measures.FreeSurface(np.array([1.0]), np.array([1.0]))).angle_rad)


def test_the_surface_of_a_bed_in_a_tilted_drum() -> None:
    random = np.random.default_rng(5)
    centre, gravity, axis = np.array([3.0, 0, 2]), np.array([0, 0, -9.81]), np.array([0, -1.0, 0])
    x = random.uniform(-1, 1, (400_000, 3))
    # The bottom moves along axis x down = +x here: a bed that is carried is higher there.
    bed = x[(np.hypot(x[:, 0], x[:, 2]) < 1) & (x[:, 2] < np.tan(0.4) * x[:, 0])]
    turned = measures.drum_angle(bed + centre, 0.0, gravity_m_per_s2=gravity, axis=axis, centre_m=centre, radius_m=1.0)
    forward = np.cross(axis, gravity)[0] > 0
    assert turned.angle_rad == pytest.approx(0.4 if forward else -0.4, abs=0.01)
    state = state_of(bed[:2000] + centre)
    found = measures.drum_state(
        state,
        contacts_of([]),
        np.ones(2000),
        axis=axis,
        centre_m=centre,
        radius_m=1.0,
        angular_velocity_rad_per_s=1.0,
    )
    assert np.sign(found.centre_angle_rad) == np.sign(turned.angle_rad)
    assert abs(found.centre_angle_rad) == pytest.approx(0.4, abs=0.05)
    assert found.centre_radius == pytest.approx(4 / (3 * np.pi), abs=0.03)


def test_empty_columns_have_no_surface() -> None:
    surface = measures.free_surface([[0.1, 0, 1], [0.2, 0, 2]], 0.5, [0, 1, 2], along=[1, 0, 0], up=[0, 0, 1])
    assert surface.height_m[0] == 2.5 and np.isnan(surface.height_m[1])


def test_drops_of_a_saw_tooth_with_noise() -> None:
    random = np.random.default_rng(6)
    times, signal, drops = [0.0], [30.0], []
    while len(drops) < 50:
        up, down = random.uniform(2, 6), random.uniform(2, 6)
        start = signal[-1]
        signal += [*np.linspace(start, start + up, 12)[1:], *np.linspace(start + up, start + up - down, 5)[1:]]
        times += [times[-1] + 1.0 * k for k in range(1, 12)]
        times += [times[-1] + 0.1 * k for k in range(1, 5)]
        drops.append(down)
    found = measures.drops(times, signal, least_drop=1.0)
    assert found.size == pytest.approx(drops)
    assert found.duration_s == pytest.approx(np.full(50, 0.4))
    assert found.waiting_s == pytest.approx(np.full(49, 11.0))
    noisy = measures.drops(times, np.array(signal) + random.uniform(-0.2, 0.2, len(signal)), least_drop=1.0)
    assert noisy.size == pytest.approx(drops, abs=0.4)
    assert len(measures.drops([], [], least_drop=1.0)) == 0
    with pytest.raises(ValueError, match="above 0"):
        measures.drops([], [], least_drop=0.0)


def test_bursts_of_triangles() -> None:
    times, signal = np.arange(9.0), np.array([0, 2, 0, 0, 4, 0, 0, 0, 3])
    found = measures.bursts(times, signal, threshold=1.0)
    assert found.start_s == pytest.approx([0.5, 3.25, 7 + 1 / 3])
    assert found.end_s == pytest.approx([1.5, 4.75, 8.0])
    assert found.size == pytest.approx([0.5, 2.25, 2 * (2 / 3) / 2])
    assert len(measures.bursts([], [], threshold=0.0)) == 0


def test_mixing_from_apart_to_random() -> None:
    random = np.random.default_rng(7)
    x = random.random((4000, 3))
    grid = {"min_m": [0, 0, 0], "max_m": [1, 1, 1], "cells": [4, 4, 4]}
    apart = measures.lacey_index(x, x[:, 0] < 0.5, **grid)
    assert apart.index == pytest.approx(0.0, abs=1e-12) and apart.variance == pytest.approx(apart.segregated_variance)
    assert apart.segregation == pytest.approx(1.0)
    values = [measures.lacey_index(x, random.random(4000) < 0.3, **grid).index for _ in range(50)]
    assert np.mean(values) == pytest.approx(1.0, abs=4 * np.std(values) / np.sqrt(50))
    even = np.arange(4000) % 2 == 0
    assert measures.lacey_index(np.repeat(x[:2000], 2, axis=0), even, **grid).index > 1.0
    for nothing in (measures.lacey_index([], [], **grid), measures.lacey_index(x, np.ones(4000), **grid)):
        assert np.isnan(nothing.index)


def ring(random: np.random.Generator, thickness: float) -> np.ndarray:
    angle, r = random.uniform(0, 2 * np.pi, 2000), np.sqrt(random.uniform((1 - thickness) ** 2, 1, 2000))
    return np.stack([r * np.cos(angle), random.random(2000), r * np.sin(angle)], axis=1)


def drum_states(positions, velocities, touching: float, n: int = 5) -> list[measures.DrumState]:
    random = np.random.default_rng(9)
    states = []
    for _ in range(n):
        state = state_of(positions, velocities=velocities)
        held = np.flatnonzero(random.random(len(positions)) < touching)
        rows = contacts_of([(int(k), None, [0, 0, 0], [0, 0, 1], 1.0) for k in held])
        states.append(
            measures.drum_state(
                state,
                rows,
                np.ones(len(positions)),
                axis=[0, 1, 0],
                centre_m=[0, 0, 0],
                radius_m=1.0,
                angular_velocity_rad_per_s=2.0,
            )
        )
    return states


def test_regimes_of_made_beds() -> None:
    random = np.random.default_rng(8)
    settings = {"angular_velocity_rad_per_s": 2.0, "radius_m": 1.0, "gravity_m_per_s2": 9.81}
    x = ring(random, 0.3)
    co_rotating = drum_states(x, np.cross([0, 2.0, 0], x), 1.0)
    found = measures.drum_regime(co_rotating, **settings)
    assert found.regime == "centrifuging" and found.slip < 1e-12 and found.froude == pytest.approx(4 / 9.81)
    y = random.uniform(-1, 1, (60_000, 3))
    bed = y[(np.hypot(y[:, 0], y[:, 2]) < 1) & (y[:, 2] < -0.3)]
    v = np.cross([0, 2.0, 0], bed) + random.normal(0, 1, bed.shape)
    assert measures.drum_regime(drum_states(bed, v, 1.0), **settings).regime == "rolling"
    assert measures.drum_regime(drum_states(bed, v, 0.6), **settings).regime == "cataracting"
    mixed = [*drum_states(bed, v, 1.0, 2), *drum_states(bed, 3 * v, 1.0, 2)]
    assert measures.drum_regime(mixed, **settings).regime == "avalanching"
    bent = y[(np.hypot(y[:, 0], y[:, 2]) < 1) & (y[:, 2] < -0.3 + 0.3 * np.sin(4 * y[:, 0]))]
    v = np.cross([0, 2.0, 0], bent) + random.normal(0, 1, bent.shape)
    assert measures.drum_regime(drum_states(bent, v, 1.0), **settings).regime == "cascading"
    with pytest.raises(ValueError, match="no states"):
        measures.drum_regime([], **settings)
    assert sphere().volume_m3 > 0
