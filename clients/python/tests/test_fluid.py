"""A fluid around the particles of a real daemon: alone, on a mesh, and marched in step with our own column."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

import sturz
from sturz.coupling import Aitken, ColumnSolver, CoupledRun, Explicit, Fluid, FluidFields, Implicit, StructuredMesh

WATER, VISCOSITY = 1000.0, 1e-3


def scene(*, gravity: float = 9.81, density: float = 2500.0, radius_m: float = 2.5e-5, step_s: float = 1e-3) -> str:
    return f"""
[scene]
name = "grain"
gravity_m_per_s2 = [0.0, 0.0, {-gravity}]
time_step_s = {step_s}
[[material]]
name = "glass"
density_kg_per_m3 = {density}
[[material_pair]]
materials = ["glass", "glass"]
stiffness_n_per_m = 1e-9
restitution = 0.5
[[shape]]
name = "ball"
geometry = {{ kind = "sphere", radius_m = {radius_m!r} }}
[[insertion]]
shape = "ball"
material = "glass"
placement = {{ method = "poses", positions_m = [[0.0, 0.0, 0.0]] }}
"""


def test_a_grain_in_water_reaches_the_speed_of_the_law():
    """Haider and Levenspiel: 1.96449 mm/s for 50 um glass, at a step of three relaxation times."""
    with sturz.launch(scene_text=scene()) as simulation:
        simulation.set_fluid(Fluid(WATER, VISCOSITY, voidage="none", buoyancy=True))
        done = simulation.advance(window_s=0.1, columns=["velocities"])
        assert done.state is not None
        assert done.state.columns["velocities"][0, 2] == pytest.approx(-1.96449e-3, rel=3e-6)
        simulation.set_fluid(None)
        after = simulation.advance(window_s=0.1, columns=["velocities"]).state
        assert after is not None
        assert after.columns["velocities"][0, 2] == pytest.approx(
            done.state.columns["velocities"][0, 2] - 0.981, rel=1e-12
        )


def mesh(cells: int = 4, side_m: float = 1e-2) -> StructuredMesh:
    return StructuredMesh(
        (-side_m / 2, -side_m / 2, -side_m),
        (side_m, side_m, side_m / 2),
        (1, 1, cells),
        sides=("periodic", "periodic", "closed"),
    )


def test_the_exchange_has_all_that_the_particles_gave():
    with sturz.launch(scene_text=scene(radius_m=1e-3, gravity=0.0)) as simulation:
        with pytest.raises(sturz.CommandError) as missing:
            simulation.advance(window_s=1e-3, fluid=FluidFields(np.zeros((4, 3))))
        assert missing.value.path == "fluid"
        with pytest.raises(sturz.SturzError, match="no fluid with a mesh"):
            simulation.exchange()
        grid = mesh()
        simulation.set_fluid(Fluid(WATER, VISCOSITY, mesh=grid, smoothing_length_m=3e-3))
        volume = 4 / 3 * math.pi * 1e-9
        before = simulation.exchange()
        assert ((1 - before.void_fraction) * grid.volumes_m3).sum() == pytest.approx(volume, rel=1e-12)
        velocity = np.zeros((4, 3))
        velocity[:, 2] = 0.1
        done = simulation.advance(window_s=0.02, fluid=FluidFields(velocity), exchange=True, columns=["velocities"])
        assert done.exchange is not None and done.state is not None
        exchange = done.exchange
        gained = 2500.0 * volume * done.state.columns["velocities"][0, 2]
        assert exchange.from_time_s == 0.0 and exchange.time_s == done.time_reached_s
        assert exchange.totals["impulse_on_fluid_n_s"][2] == pytest.approx(-gained, rel=1e-12)
        impulse = exchange.interaction_n_per_m3[:, 2] @ grid.volumes_m3 * 0.02
        assert impulse == pytest.approx(-gained, rel=1e-12)
        assert exchange.drag_kg_per_m3_s.sum() > 0
        assert simulation.exchange().totals["momentum_kg_m_per_s"][2] == pytest.approx(gained, rel=1e-12)


def test_what_does_not_fit_is_named_and_changes_nothing():
    with sturz.launch(scene_text=scene(radius_m=1e-3)) as simulation:
        fluid = Fluid(WATER, VISCOSITY, mesh=mesh(), smoothing_length_m=3e-3)
        simulation.set_fluid(fluid)
        before = simulation.info()
        for wrong, path in (
            (Fluid(0.0, VISCOSITY), "fluid.density_kg_per_m3"),
            (Fluid(WATER, VISCOSITY, mesh=mesh()), "fluid.smoothing_length_m"),
            (Fluid(WATER, VISCOSITY, mesh=mesh(cells=10_000_000), smoothing_length_m=3e-3), "fluid.structured"),
        ):
            with pytest.raises(sturz.CommandError) as refused:
                simulation.set_fluid(wrong)
            assert refused.value.path == path
        with pytest.raises(sturz.CommandError) as short:
            simulation.advance(window_s=1e-3, fluid=FluidFields(np.zeros((3, 3))))
        assert short.value.path == "fluid.velocity_m_per_s"
        with pytest.raises(ValueError, match="drag is 'honey'"):
            simulation.set_fluid(Fluid(WATER, VISCOSITY, drag="honey"))  # type: ignore[arg-type]
        after = simulation.info()
        assert (after.state_hash, after.step) == (before.state_hash, before.step)


def closed_column(
    scheme: Explicit | Implicit, *, windows: int, window_s: float = 1e-3, step_s: float = 1e-4
) -> tuple[float, list[int]]:
    """Speed of a light ball in a closed cell of water after some windows, and the iterations of each."""
    side = 1e-2
    radius = side * (0.4 * 3 / 4 / math.pi) ** (1 / 3)
    text = scene(density=100.0, radius_m=radius, step_s=step_s)
    one = StructuredMesh((-side / 2,) * 3, (side,) * 3, (1, 1, 1), sides=("periodic",) * 3)
    with sturz.launch(scene_text=text) as simulation:
        fluid = Fluid(WATER, 1.0, drag="stokes", voidage="none", smoothing_length_m=side, buoyancy=True)
        solver = ColumnSolver(one, density_kg_per_m3=WATER)
        iterations = []
        with CoupledRun(simulation, solver, fluid=fluid, scheme=scheme) as run:
            for _ in range(windows):
                report = run.advance(window_s)
                iterations.append(report.iterations)
                assert report.momentum_error < 1e-12 and report.solid_volume_error < 1e-12
        return float(simulation.state(["velocities"]).columns["velocities"][0, 2]), iterations


def exact_speed(time_s: float) -> float:
    """Of that ball: (rho_p + rho e'/e) dv/dt = (rho - rho_p) g - K v / (e^2 V), e' = 1 - e."""
    volume = 0.4e-6
    radius = 1e-2 * (0.4 * 3 / 4 / math.pi) ** (1 / 3)
    inertia = 100.0 + WATER * 0.4 / 0.6
    rise, rate = (WATER - 100.0) * 9.81 / inertia, 6 * math.pi * radius / (0.36 * volume) / inertia
    return rise / rate * -math.expm1(-rate * time_s)


def test_a_light_particle_in_a_dense_fluid_needs_iterations():
    """CFD5: the fluid that the ball sets in motion weighs 6.7 times what it does."""
    runaway, _ = closed_column(Explicit(), windows=12)
    assert abs(runaway) > 1e4 * exact_speed(12e-3)
    speed, iterations = closed_column(Implicit(tolerance=1e-8), windows=12)
    assert speed == pytest.approx(exact_speed(12e-3), rel=3e-4)
    assert max(iterations) <= 8
    with pytest.raises(sturz.CouplingError, match="has not converged in 3 iterations"):
        closed_column(Implicit(Aitken(0.01), tolerance=1e-8, max_iterations=3, extrapolate=False), windows=1)


def test_iterated_windows_are_second_order():
    """CFD1, with our own column: the error falls with the square of the window."""
    errors = []
    for windows in (2, 4, 8):
        speed, _ = closed_column(Implicit(tolerance=1e-9), windows=windows, window_s=4e-3 / windows, step_s=1e-5)
        errors.append(abs(speed / exact_speed(4e-3) - 1))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(orders - 2) < 0.25), (errors, orders)


class Dies(ColumnSolver):
    """A partner that is lost in the midst of a window."""

    windows_left = 5

    def advance(self, window_s, before, after):  # type: ignore[no-untyped-def]
        """Until its last one."""
        self.windows_left -= 1
        if self.windows_left < 0:
            raise ConnectionError("the partner is gone")
        return super().advance(window_s, before, after)


@pytest.mark.parametrize("scheme", [Explicit(), Implicit(tolerance=1e-8)])
def test_a_run_goes_on_from_the_common_checkpoint_when_its_partner_dies(tmp_path, scheme):
    """CFD6: the same bits as the run that nothing happened to."""
    fluid = Fluid(WATER, VISCOSITY, smoothing_length_m=3e-3, added_mass_coefficient=0.5, buoyancy=True)

    def partner(kind=ColumnSolver):  # type: ignore[no-untyped-def]
        return kind(mesh(), density_kg_per_m3=WATER, flux_m_per_s=0.05)

    with sturz.launch(scene_text=scene(radius_m=1e-3, step_s=1e-4), checkpoints=tmp_path / "daemon") as simulation:
        with CoupledRun(simulation, partner(), fluid=fluid, scheme=scheme) as run:
            for _ in range(3):
                run.advance(2e-3)
            with pytest.raises(sturz.CouplingError, match="nothing was saved"):
                run.resume(tmp_path / "nowhere")
            run.save_to(tmp_path / "pair")
            for _ in range(4):
                run.advance(2e-3)
            undisturbed = simulation.info().state_hash
            run.resume(tmp_path / "pair")
            assert run.windows == 3 and run.time_s == pytest.approx(6e-3, rel=1e-12)
            run.solver = partner(Dies)
            run.resume(tmp_path / "pair")
            run.solver.windows_left = 2
            with pytest.raises(ConnectionError):
                for _ in range(4):
                    run.advance(2e-3)
        with CoupledRun(simulation, partner(), fluid=fluid, scheme=scheme) as run:
            run.resume(tmp_path / "pair")
            for _ in range(4):
                run.advance(2e-3)
            assert simulation.info().state_hash == undisturbed
            assert run.windows == 7


def test_a_journal_resumes_a_coupled_run_to_the_bit(tmp_path):
    """The fluid, its fields and what the particles gave are in the log and in the snapshots."""
    fluid = Fluid(WATER, VISCOSITY, mesh=mesh(), smoothing_length_m=3e-3, added_mass_coefficient=0.5)
    velocity = np.zeros((4, 3))
    velocity[:, 2] = [0.1, 0.2, 0.0, -0.1]
    journal = tmp_path / "journal"
    with sturz.launch(scene_text=scene(radius_m=1e-3, step_s=1e-4), journal=journal) as simulation:
        simulation.set_fluid(fluid, FluidFields(velocity))
        for k in range(5):
            done = simulation.advance(window_s=1e-3, fluid=FluidFields(velocity * k), fluid_ramp=True, exchange=True)
        wanted, given = simulation.info(), done.exchange
        assert simulation.daemon is not None and given is not None
        simulation.daemon.process.kill()
    with sturz.launch(resume=journal) as simulation:
        assert simulation.info().state_hash == wanted.state_hash
        again = simulation.exchange()
        for name in ("void_fraction", "interaction_n_per_m3", "drag_kg_per_m3_s"):
            assert np.array_equal(getattr(again, name), getattr(given, name)), name


def test_the_blocks_of_the_page_run_in_order():
    page = (Path(__file__).resolve().parents[3] / "docs" / "coupling.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```", page, flags=re.DOTALL | re.MULTILINE)
    assert len(blocks) >= 2
    names: dict[str, object] = {"__name__": "page"}
    for block in blocks:
        exec(compile(block, "docs/coupling.md", "exec"), names)
