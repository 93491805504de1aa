"""A simulation as one side of a coupled run."""

import math

import numpy as np
import pytest
from conftest import drop

import sturz

MASS_KG = 2500.0 * 4.0 / 3.0 * math.pi * 1e-9
WINDOW_S = 1e-3


def beads(simulation: sturz.Simulation, count: int = 2) -> None:
    """At rest without gravity."""
    simulation.set_gravity(gravity_m_per_s2=(0, 0, 0))
    for k in range(count):
        drop(simulation, positions_m=[[0.1 * k, 0, 0]])


def test_explicit_windows_follow_the_closed_form(space: sturz.Simulation) -> None:
    beads(space)
    with sturz.Participant(space, window_s=WINDOW_S, end_time_s=2.5 * WINDOW_S) as particles:
        windows = []
        while particles.is_coupling_ongoing():
            assert not particles.requires_writing_checkpoint()
            windows.append(particles.window_s)
            particles.write("force_n", [[2e-5, 0, 0], [0, 0, 0]])
            particles.advance()
            assert particles.is_time_window_complete() and not particles.requires_reading_checkpoint()
        assert windows == pytest.approx([WINDOW_S, WINDOW_S, 0.5 * WINDOW_S], rel=1e-9)
        assert particles.read("velocities")[0, 0] == pytest.approx(2e-5 / MASS_KG * 2.5 * WINDOW_S, rel=1e-10)
        assert np.array_equal(particles.ids, [0, 1]) and particles.iterations == 1
        with pytest.raises(sturz.CouplingError, match="the end"):
            particles.advance()
    assert space.info().time_s == pytest.approx(2.5 * WINDOW_S, rel=1e-12)
    assert space.checkpoints() == ()


class AddedMass:
    """A fluid that resists acceleration with `ratio` masses of the particle while a weight pulls on it."""

    def __init__(self, ratio: float, relaxation: float) -> None:
        self.mass, self.relaxation, self.force = ratio * MASS_KG, relaxation, np.zeros((2, 3))
        self.before = np.zeros((2, 3))

    def solve(self, velocities: np.ndarray, window_s: float) -> np.ndarray:
        wanted = -self.mass * (velocities - self.before) / window_s
        self.force = self.force + self.relaxation * (wanted - self.force)
        return self.force + np.array([MASS_KG, 0, 0])


def test_an_implicit_window_converges_where_an_explicit_one_cannot(space: sturz.Simulation) -> None:
    beads(space)
    fluid = AddedMass(ratio=3.0, relaxation=0.3)
    particles = sturz.Participant(
        space, window_s=WINDOW_S, end_time_s=3 * WINDOW_S, read=("velocities",), converge={"velocities": 1e-10}
    )
    particles.initialize()
    start, writes, backs = fluid.before, 0, 0
    last = None
    while particles.is_coupling_ongoing():
        if particles.requires_writing_checkpoint():
            start = fluid.before = particles.read("velocities").copy()
            writes += 1
        last = fluid.solve(particles.read("velocities"), WINDOW_S)
        particles.write("force_n", last)
        particles.advance()
        if particles.requires_reading_checkpoint():
            fluid.before = start
            backs += 1
    # (1 + 3) m a = m g
    assert particles.read("velocities")[0, 0] == pytest.approx(3 * WINDOW_S / 4.0, rel=1e-8)
    assert writes == 3 and backs >= 3 and 1 < particles.iterations < 50
    assert particles.changes["velocities"] <= 1e-10
    # to the bit as if the last iteration had been the only one
    velocities = particles.read("velocities").copy()
    particles.finalize()
    assert space.checkpoints() == ()
    assert last is not None
    state = space.state()
    assert np.array_equal(state.velocities_m_per_s, velocities)
    assert np.all(np.isfinite(state.positions_m))

    diverging = AddedMass(ratio=3.0, relaxation=1.0)
    diverging.before = velocities
    with sturz.Participant(
        space, window_s=WINDOW_S, read=("velocities",), converge={"velocities": 1e-10}, max_iterations=8
    ) as again:
        with pytest.raises(sturz.CouplingError, match="has not converged in 8 iterations"):
            while True:
                again.write("force_n", diverging.solve(again.read("velocities"), WINDOW_S))
                again.advance()
        assert not again.is_time_window_complete()


def test_rejected_iterations_leave_no_trace(space: sturz.Simulation) -> None:
    beads(space)
    space.checkpoint(token="before")
    final = [[3e-5, 1e-5, 0], [0, 0, -2e-5]]
    with sturz.Participant(space, window_s=WINDOW_S, converge={"velocities": 1e-12}) as particles:
        for force in ([[9e-5, 0, 0], [0, 0, 0]], [[1e-5, 7e-5, 0], [0, 1, 0]], final, final):
            particles.write("force_n", force)
            particles.advance()
        assert particles.is_time_window_complete() and particles.iterations == 4
    coupled = space.info().state_hash
    space.restore(token="before")
    epoch = space.state(columns=["positions"]).header.topology_epoch
    space.advance(window_s=WINDOW_S, loads=sturz.Loads(topology_epoch=epoch, ids=[0, 1], force_n=final))
    assert space.info().state_hash == coupled


def test_others_cannot_let_time_go_on(space: sturz.Simulation) -> None:
    beads(space)
    with (
        sturz.Participant(space, window_s=WINDOW_S) as particles,
        sturz.connect(space.instance, endpoint=space.endpoint) as other,
    ):
        with pytest.raises(sturz.CommandError, match="lease"):
            other.advance(window_s=WINDOW_S)
        particles.advance()
    space.advance(window_s=WINDOW_S)


def test_mistakes_are_named(space: sturz.Simulation) -> None:
    for arguments, text in (
        ({"window_s": 0.0}, "window_s is 0.0; it must be above 0"),
        ({"window_s": 1.0, "end_time_s": math.nan}, "end_time_s is nan"),
        ({"window_s": 1.0, "read": ("speed",)}, "'speed' cannot be read; there are positions"),
        ({"window_s": 1.0, "converge": {"velocities": -1.0}}, "it must be above 0"),
        ({"window_s": 1.0, "converge": {"velocities": 0.1}, "max_iterations": 1}, "two is the least"),
    ):
        with pytest.raises(ValueError, match=text):
            sturz.Participant(space, **arguments)  # type: ignore[arg-type]
    beads(space)
    particles = sturz.Participant(space, window_s=WINDOW_S)
    with pytest.raises(sturz.CouplingError, match="initialize comes first"):
        particles.advance()
    particles.initialize()
    with pytest.raises(sturz.CouplingError, match="already"):
        particles.initialize()
    for name, values, text in (
        ("weight", [1, 2], "'weight' cannot be written; there are force_n"),
        ("force_n", [1, 2], r"force_n has the shape \(2,\); 2 particles need \(2, 3\)"),
        ("drag_n_s_per_m", [1, math.inf], "not finite at row 1"),
    ):
        with pytest.raises(ValueError, match=text):
            particles.write(name, values)
    with pytest.raises(ValueError, match="'orientations' is not among what this participant reads"):
        particles.read("orientations")
    particles.finalize()
    particles.finalize()
