"""Loads from outside: forces, torques, drag, in windows and between them."""

import math

import numpy as np
import pytest
from conftest import drop

import sturz

MASS_KG = 2500.0 * 4.0 / 3.0 * math.pi * 1e-9


def still(simulation: sturz.Simulation, count: int = 3) -> int:
    """Beads at rest without gravity; their epoch."""
    simulation.set_gravity(gravity_m_per_s2=(0, 0, 0))
    for k in range(count):
        drop(simulation, positions_m=[[0.1 * k, 0, 0]])
    return simulation.state(columns=["positions"]).header.topology_epoch


def test_a_window_carries_loads_and_ends_as_the_closed_forms_say(space: sturz.Simulation) -> None:
    epoch = still(space)
    window_s = 2e-3
    loads = sturz.Loads(
        topology_epoch=epoch,
        ids=[0, 2],
        force_n=[[3e-5, 0, 0], [0, 0, 0]],
        torque_n_m=[[0, 0, 1e-10], [0, 0, 0]],
        drag_n_s_per_m=[0.0, MASS_KG / 1e-3],
        fluid_velocity_m_per_s=[[0, 0, 0], [0, 0.5, 0]],
    )
    state = space.advance(window_s=window_s, columns=["velocities", "angular_velocities"], loads=loads).state
    assert state is not None
    inertia = 0.4 * MASS_KG * 1e-6
    assert state.velocities_m_per_s[0, 0] == pytest.approx(3e-5 * window_s / MASS_KG, rel=1e-10)
    assert state.angular_velocities_rad_per_s[0, 2] == pytest.approx(1e-10 * window_s / inertia, rel=1e-10)
    assert np.all(state.velocities_m_per_s[1] == 0)
    assert state.velocities_m_per_s[2, 1] == pytest.approx(0.5 * (1 - math.exp(-window_s / 1e-3)), rel=1e-10)
    energy = space.report().energy
    assert energy.work_loads_j == pytest.approx(energy.kinetic_translation_j + energy.kinetic_rotation_j, rel=1e-9)
    space.set_loads(sturz.Loads(topology_epoch=epoch))
    after = space.advance(window_s=window_s, columns=["velocities"]).state
    assert after is not None
    assert np.array_equal(after.velocities_m_per_s, state.velocities_m_per_s)


def test_bad_loads_are_refused_with_their_place(space: sturz.Simulation) -> None:
    epoch = still(space, 2)
    before = space.info().state_hash
    for arguments, path in (
        ({"topology_epoch": epoch + 1, "ids": [0]}, "loads.topology_epoch"),
        ({"topology_epoch": epoch, "ids": [0, 7]}, "loads.ids[1]"),
        ({"topology_epoch": epoch, "ids": [0, 1], "force_n": [[0, 0, 1]]}, "loads.force_n"),
        ({"topology_epoch": epoch, "ids": [0], "torque_n_m": [[0, math.nan, 1]]}, "loads.torque_n_m[0]"),
    ):
        loads = sturz.Loads(**arguments)  # type: ignore[arg-type]
        with pytest.raises(sturz.CommandError) as alone:
            space.set_loads(loads)
        with pytest.raises(sturz.CommandError) as in_window:
            space.advance(window_s=1e-3, loads=loads)
        assert alone.value.path == in_window.value.path == path
    with pytest.raises(ValueError, match="force_n has the shape"):
        space.set_loads(sturz.Loads(topology_epoch=epoch, ids=[0], force_n=[1.0, 2.0]))
    assert space.info().state_hash == before
    assert space.info().time_s == 0.0
