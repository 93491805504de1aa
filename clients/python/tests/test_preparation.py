"""Preparation of beds over the bus: sizes, frozen particles, depositions, stages and inflows."""

import numpy as np
import pytest
from conftest import SPACE

import sturz

COURSE = (
    SPACE
    + """
[[inflow]]
name = "window"
shape = "bead"
material = "glass"
region = { kind = "box", min_m = [0.0, 0.0, 0.0], max_m = [0.01, 0.01, 0.004] }
rate_per_s = 3e4
interval_s = 1e-3
count = 50
attempts = 10
[[stage]]
name = "soft"
steps = 100
stiffness_factor = 0.5
[[stage]]
name = "still"
time_s = 1e-3
gravity_factor = 0.0
"""
)


def test_sizes_follow_a_law(space: sturz.Simulation) -> None:
    lattice = {"shape": "bead", "material": "glass", "spacing_m": (0.004, 0.004, 0.004)}
    ids = space.insert_lattice(
        **lattice, origin_m=(0, 0, 0), counts=(10, 10, 4), scale=sturz.ScaleTable(scales=(0.5, 1.0), weights=(3, 1))
    )
    scales = space.state().scales[np.isin(space.state().ids, ids)]
    assert set(scales) == {0.5, 1.0}
    # four standard errors of a binomial count
    assert abs((scales == 0.5).mean() - 0.75) < 4 * (0.75 * 0.25 / 400) ** 0.5
    normal = sturz.NormalScale(mean=0.8, standard_deviation=0.1, min=0.6, max=1.0)
    space.insert_lattice(**lattice, origin_m=(0.1, 0, 0), counts=(10, 10, 2), scale=normal)
    lognormal = sturz.LognormalScale(median=0.8, log_standard_deviation=0.1, min=0.6, max=1.0)
    space.insert_lattice(**lattice, origin_m=(0.2, 0, 0), counts=(10, 10, 2), scale=lognormal)
    drawn = space.state().scales[400:]
    assert ((drawn > 0.6) & (drawn < 1.0)).all()
    assert abs(drawn.mean() - 0.8) < 0.02
    with pytest.raises(sturz.CommandError) as caught:
        space.insert_lattice(
            **lattice, origin_m=(0.3, 0, 0), counts=(1, 1, 1), scale=sturz.ScaleTable(scales=(1.0,), weights=(0.0,))
        )
    assert caught.value.path.startswith("scale")


def test_frozen_particles_bear_and_stay(space: sturz.Simulation) -> None:
    base = space.insert_poses(shape="bead", material="glass", positions_m=[[0, 0, 0]], frozen=True)
    space.insert_poses(shape="bead", material="glass", positions_m=[[0, 0, 0.00199999]])
    space.advance(window_s=0.02)
    state = space.state(columns=["all"])
    assert state.frozen.tolist() == [True, False]
    assert state.positions_m[0].tolist() == [0, 0, 0]
    assert state.velocities_m_per_s[0].tolist() == [0, 0, 0]
    assert base.tolist() == [0]
    np.testing.assert_allclose(state.forces_n[0], -state.forces_n[1], rtol=1e-12, atol=1e-18)
    assert state.forces_n[0, 2] < 0


def test_a_deposition_lies_close(space: sturz.Simulation) -> None:
    box = sturz.Box((0, 0, 0), (0.02, 0.02, 1))
    ids = space.insert_deposition(shape="bead", material="glass", region=box, count=200)
    positions = space.state().positions_m
    assert len(ids) == 200
    apart = np.linalg.norm(positions[:, None] - positions[None], axis=2) + np.eye(200)
    assert apart.min() > 2e-3 * (1 - 1e-9)
    assert ((positions >= 1e-3 * (1 - 1e-9)) & (positions <= [0.019 + 1e-9, 0.019 + 1e-9, 1])).all()
    with pytest.raises(sturz.CommandError, match="above the region") as caught:
        low = sturz.Box((0.05, 0, 0), (0.07, 0.02, 0.005))
        space.insert_deposition(shape="bead", material="glass", region=low, count=1000)
    assert caught.value.path == "placement.deposition"


def test_stages_and_inflows_are_told() -> None:
    with sturz.launch(scene_text=COURSE) as simulation, simulation.events() as events:
        simulation.advance(window_s=4e-3)
        there = len(simulation.state())
        stages: list[str] = []
        came, late = 0, []
        while "" not in stages or came < there or not late:
            event = events.next_frame(timeout_s=20.0)
            assert event is not None
            if event.kind is sturz.EventKind.STAGE:
                stages.append(event.name)
            elif event.kind is sturz.EventKind.PARTICLES:
                assert event.name == "window"
                assert event.inserted is not None
                came += len(event.inserted)
            elif event.kind is sturz.EventKind.INFLOW:
                late.append(event)
        assert stages == ["soft", "still", ""]
        assert came == there > 0
        assert late[0].severity is sturz.Severity.WARNING
        assert simulation.info().gravity_m_per_s2 == pytest.approx((0, 0, -9.81))
