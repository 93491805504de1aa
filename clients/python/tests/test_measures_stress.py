"""Layer stress: balance of a column, brute force over branches, and the turning of free bodies."""

import numpy as np
import pytest
from measured import GRAVITY, box, contacts_of, domain_of, random_rotations, sphere, state_of

from sturz.measures import Bodies, bodies, layer_stress, particle_contact_moments_j, rotation_moments_j


def balls(positions, **columns):
    state = state_of(positions, **columns)
    return state, bodies(state, [sphere()], 2.0)


def test_a_column_at_rest_carries_its_weight() -> None:
    n = 5
    state, heavy = balls([[0, 0, 0.5 + k] for k in range(n)])
    weight = heavy.mass_kg[0] * 9.81
    rows = [(k, k + 1, [0, 0, k + 1.0], [0, 0, 1.0], weight * (n - 1 - k)) for k in range(n - 1)]
    rows.append((0, None, [0, 0, 0], [0, 0, -1.0], weight * n))
    stress = layer_stress(state, contacts_of(rows), heavy, np.arange(n + 1.0), area_m2=3.0)
    # A layer with one particle: half of what presses from below and from above.
    expected = [weight * (n - k - 0.5) / 3.0 for k in range(n)]
    assert stress.contact[:, 2, 2] == pytest.approx(expected, rel=1e-14)
    assert stress.weight_pa == pytest.approx([weight * (n - k) / 3.0 for k in range(n)], rel=1e-14)
    assert np.abs(np.delete(stress.contact.reshape(n, 9), 8, axis=1)).max() == 0.0
    assert (stress.total == stress.contact).all() and (stress.moreau == stress.contact).all()


def test_layers_add_up_to_the_sum_over_branches_of_a_periodic_cell() -> None:
    random = np.random.default_rng(1)
    cell = domain_of([0, 0, 0], [4, 4, 0], (True, True, False))
    state, heavy = balls(random.uniform(0, 4, (30, 3)))
    rows, expected = [], np.zeros((3, 3))
    for a in range(30):
        for b in range(a + 1, 30):
            d = state.positions_m[b] - state.positions_m[a]
            d[:2] -= 4 * np.round(d[:2] / 4)
            if np.linalg.norm(d) < 1.4:
                normal = d / np.linalg.norm(d)
                rows.append((a, b, state.positions_m[a] + 0.5 * d, normal, random.uniform(1, 2)))
    network = contacts_of(rows)
    network.columns["tangential_forces"] = np.cross(network.normals, random.standard_normal((len(rows), 3)))
    for row, force in zip(rows, network.forces_on_a_n(), strict=True):
        branch = 2 * (state.positions_m[row[0]] - row[2])
        expected += np.outer(force, branch)
    assert particle_contact_moments_j(state, network, cell).sum(axis=0) == pytest.approx(expected, rel=1e-12)
    stress = layer_stress(state, network, heavy, [0, 1, 1.5, 4], area_m2=16.0, domain=cell)
    whole = (stress.contact * (16.0 * np.diff(stress.edges_m))[:, None, None]).sum(axis=0)
    assert whole == pytest.approx(0.5 * (expected + expected.T), rel=1e-12)


def test_kinetic_stress_is_about_the_mean_of_the_layer() -> None:
    v = np.array([[1.0, 2, 3], [3.0, 2, 1], [7, 7, 7]])
    state, heavy = balls([[0, 0, 0.2], [1, 1, 0.7], [0, 0, 1.5]], velocities=v)
    stress = layer_stress(state, contacts_of([]), heavy, [0, 1, 2], area_m2=2.0)
    d = v[:2] - [2, 2, 2]
    assert stress.kinetic[0] == pytest.approx(heavy.mass_kg[0] * d.T @ d / 2.0, rel=1e-14)
    assert np.abs(stress.kinetic[1]).max() < 1e-14
    assert stress.particles.tolist() == [2, 1]


def pieces(shape) -> tuple[np.ndarray, float]:
    """A box as 8 x 8 x 8 small ones: centres, and the volume of each."""
    span = shape.vertices_m.max(axis=0) - shape.vertices_m.min(axis=0)
    grid = (np.arange(8) + 0.5) / 8 - 0.5
    points = np.stack(np.meshgrid(grid, grid, grid, indexing="ij"), axis=-1).reshape(-1, 3) * span
    return points, shape.volume_m3 / 512


def test_the_term_of_rotation_is_the_integral_of_density_acceleration_and_place() -> None:
    random = np.random.default_rng(2)
    shape, omega, torque = box(1.0, 0.6, 0.3), random.standard_normal(3), random.standard_normal(3)
    state = state_of(
        [[0, 0, 0]],
        orientations=random_rotations(random, 1),
        angular_velocities=omega[None],
        torques=torque[None],
    )
    points, volume = pieces(shape)
    # The small boxes' own moments are 1/64 of the whole: points on the nodes of Gauss would have none.
    points *= np.sqrt(64 / 63)
    heavy = bodies(state, [shape], 3.0)
    acceleration, momentum = rotation_moments_j(state, heavy)
    turned = points @ state.rotations()[0].T
    inertia = 3.0 * volume * ((turned**2).sum() * np.eye(3) - turned.T @ turned)
    change = np.linalg.solve(inertia, torque - np.cross(omega, inertia @ omega))
    a = np.cross(change, turned) + np.cross(omega, np.cross(omega, turned))
    assert acceleration[0] == pytest.approx(3.0 * volume * a.T @ turned, abs=1e-12)
    v = np.cross(omega, turned)
    assert momentum[0] == pytest.approx(3.0 * volume * v.T @ v, abs=1e-12)


def test_the_inertia_tensor_in_its_place_would_be_far_off() -> None:
    # Seed 000 prints it so: a rod that spins about a cross axis pulls along itself, not across.
    shape = box(1.0, 0.1, 0.1)
    state = state_of([[0, 0, 0]], angular_velocities=np.array([[0, 0, 2.0]]))
    acceleration, _ = rotation_moments_j(state, bodies(state, [shape], 1.0))
    euler = shape.volume_m3 * 1.0 / 12
    assert acceleration[0, 0, 0] == pytest.approx(-4.0 * euler, rel=1e-12)
    assert acceleration[0, 1, 1] == pytest.approx(-4.0 * euler * 0.01, rel=1e-12)


def test_both_terms_of_rotation_cancel_in_the_mean_over_a_free_tumble() -> None:
    moments = np.array([1.0, 2.0, 2.7])
    heavy = Bodies(np.ones(1), np.ones(1), moments[None], np.ones(1), np.ones(1))
    w, q, dt, steps = np.array([1.0, 0.3, 0.2]), np.array([1.0, 0, 0, 0]), 1e-2, 10_000
    total, size = np.zeros((3, 3)), 0.0

    def rates(q, w):
        spin = np.array(
            [[0, -w[0], -w[1], -w[2]], [w[0], 0, w[2], -w[1]], [w[1], -w[2], 0, w[0]], [w[2], w[1], -w[0], 0]]
        )
        return 0.5 * spin @ q, -np.cross(w, moments * w) / moments

    for k in range(steps):
        dq1, dw1 = rates(q, w)
        dq2, dw2 = rates(q + dt * dq1, w + dt * dw1)
        if k % 5 == 0:
            state = state_of([[0, 0, 0]], orientations=q[None])
            state.columns["angular_velocities"] = (state.rotations()[0] @ w)[None]
            acceleration, momentum = rotation_moments_j(state, heavy)
            total += acceleration[0] + momentum[0]
            size += np.abs(momentum[0]).max()
        q, w = q + 0.5 * dt * (dq1 + dq2), w + 0.5 * dt * (dw1 + dw2)
        q /= np.linalg.norm(q)
    # d(W E)/dt over 100 s: at most 2 |W E| / T, here 0.05, and the sum is that of 2000 samples.
    assert np.abs(total).max() / 2000 < 0.05
    assert size / 2000 > 0.5


def test_no_particles_and_contacts_of_another_state() -> None:
    state, nothing = balls([])
    stress = layer_stress(state, contacts_of([]), nothing, [0, 1], area_m2=1.0)
    assert (stress.total == 0.0).all() and stress.weight_pa.tolist() == [0.0]
    assert abs(GRAVITY[2]) == 9.81
    one, _ = balls([[0, 0, 0]])
    with pytest.raises(ValueError, match="different steps"):
        particle_contact_moments_j(one, contacts_of([(0, 7, [0, 0, 0], [0, 0, 1], 1.0)]))
