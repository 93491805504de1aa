"""The plane against closed forms, and its balances."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fluid_exchange import DENSITY, ERGUN, VISCOSITY, VOID, ergun_beta, exchange, fixed_bed
from numpy.typing import NDArray

import sturz
from sturz.coupling import ColumnSolver, CoupledRun, Fluid, Implicit, PlaneSolver, StructuredMesh

pytest.importorskip("scipy")

Array = NDArray[np.float64]


def plane(nx: int, nz: int, size: tuple[float, float], x: Any, z: Any) -> StructuredMesh:
    spacing = (size[0] / nx, 0.01, size[1] / nz)
    return StructuredMesh((0.0, 0.0, 0.0), spacing, (nx, 1, nz), (x, "closed", z))


def run_empty(solver: PlaneSolver, window_s: float, windows: int) -> None:
    for _ in range(windows):
        empty = exchange(solver.mesh, solver.time_s, solver.time_s + window_s)
        solver.advance(window_s, empty, empty)


def test_poiseuille_between_plates() -> None:
    # -dp/dz = 8 Pa/m over plates 1 m apart, viscosity 1: w = 4 x (1 - x) + h^2, the last for the walls' half cells
    n, gradient = 4, 8.0
    mesh = plane(n, 3, (1.0, 3.0), "closed", "periodic")
    solver = PlaneSolver(
        mesh, density_kg_per_m3=1.0, viscosity_pa_s=1.0, mean_gradient_pa_per_m=(0.0, -gradient), convection="central"
    )
    # the slowest mode decays with pi^2 per second
    run_empty(solver, 0.5, 4)
    x = mesh.centres()[:, 0]
    fields = solver.fields()
    assert fields.velocity_m_per_s[:, 2] == pytest.approx(4.0 * x * (1.0 - x) + gradient / n**2 / 8.0, rel=1e-7)
    assert fields.velocity_m_per_s[:, 0] == pytest.approx(0.0, abs=1e-12)
    assert fields.vorticity_rad_per_s is not None
    # (curl u)_y = du/dz - dw/dx
    assert fields.vorticity_rad_per_s[:, 1] == pytest.approx(-4.0 * (1.0 - 2.0 * x), abs=1e-7)
    assert solver.momentum_error < 1e-13
    # walls take what the gradient gives: 8 Pa/m over 1 x 0.01 x 3 m3
    assert solver.momentum_n["ends"][1] == pytest.approx(-gradient * 0.03, rel=1e-6)


def test_a_uniform_inflow_becomes_poiseuille() -> None:
    # a channel 5 widths long at Re 1; mean velocity 1, so nearly 6 x (1 - x) in its middle
    n = 4
    mesh = plane(n, 20, (1.0, 5.0), "closed", ("closed", "open"))
    solver = PlaneSolver(mesh, density_kg_per_m3=1.0, viscosity_pa_s=1.0, inflow_m_per_s={"z_low": 1.0})
    run_empty(solver, 0.5, 3)
    x = (np.arange(n) + 0.5) / n
    velocity = mesh.reshape(solver.fields().velocity_m_per_s)[:, 0, :, 2]
    # the discrete profile: 4 x (1 - x) + h^2, scaled to mean 1
    profile = 4.0 * x * (1.0 - x) + 1.0 / n**2
    assert velocity[10] == pytest.approx(profile / profile.mean(), rel=1e-5)
    assert velocity.mean(axis=1) == pytest.approx(1.0, rel=1e-12)
    assert solver.divergence_error_per_s < 1e-10
    assert solver.momentum_error < 1e-12


def vortices(cells: int, step_s: float, time_s: float = 0.2, convection: Any = "central") -> tuple[Array, float]:
    """Taylor-Green vortices that a mean flow carries along; velocity at the end, rms error."""
    k, viscosity, drift = 2.0 * np.pi, 0.02, 0.5
    mesh = plane(cells, cells, (1.0, 1.0), "periodic", "periodic")
    solver = PlaneSolver(mesh, density_kg_per_m3=1.0, viscosity_pa_s=viscosity, convection=convection)

    def exact(x: Array, z: Array, t: float) -> tuple[Array, Array]:
        decay = np.exp(-2.0 * viscosity * k**2 * t)
        x = x - drift * t
        return drift + decay * np.sin(k * x) * np.cos(k * z), -decay * np.cos(k * x) * np.sin(k * z)

    solver.start(exchange(mesh, 0.0, 0.0), lambda x, z: exact(x, z, 0.0))
    run_empty(solver, step_s, round(time_s / step_s))
    assert solver.steps == 1, "the step is the window: the order in time is that of the step"
    assert solver.divergence_error_per_s < 1e-10
    assert solver.momentum_error < 1e-13
    centres = mesh.centres()
    u, w = exact(centres[:, 0], centres[:, 2], time_s)
    velocity = solver.fields().velocity_m_per_s
    error = np.sqrt(np.mean((velocity[:, 0] - u) ** 2 + (velocity[:, 2] - w) ** 2))
    return velocity, float(error)


def test_decaying_vortices_are_second_order_in_space_and_time() -> None:
    errors = [vortices(cells, 0.08 / cells)[1] for cells in (16, 32)]
    assert 1.85 < np.log2(errors[0] / errors[1]) < 2.15
    # in time on one grid, against a step a quarter of the shorter: 2 would be log2((64 - 1) / (16 - 1)) = 2.07
    finest = vortices(16, 1.25e-3)[0]
    lags = [float(np.abs(vortices(16, step)[0] - finest).max()) for step in (1e-2, 5e-3)]
    assert np.log2(lags[0] / lags[1]) == pytest.approx(2.07, abs=0.1)


def test_the_limiter_is_better_than_upwind() -> None:
    upwind, limited = (vortices(24, 4e-3, convection=name)[1] for name in ("upwind", "limited"))
    assert limited < 0.4 * upwind


@pytest.mark.parametrize(("superficial", "pascal_per_metre"), ERGUN)
@pytest.mark.parametrize("axis", ["x", "z"])
def test_ergun_through_a_bed_that_fills_the_plane(superficial: float, pascal_per_metre: float, axis: str) -> None:
    along_x = axis == "x"
    through, across = ("closed", "open"), "closed"
    mesh = plane(8, 4, (0.04, 0.02), through, across) if along_x else plane(4, 8, (0.02, 0.04), across, through)
    k = 0 if along_x else 2
    solver = PlaneSolver(
        mesh,
        density_kg_per_m3=DENSITY,
        viscosity_pa_s=VISCOSITY,
        walls="slip",
        inflow_m_per_s={"x_low" if along_x else "z_low": superficial},
    )
    beta = ergun_beta(superficial)
    seen = np.zeros((mesh.n, 3))
    start = fixed_bed(mesh, 0.0, 0.0, void=VOID, drag=beta, seen=seen)
    token = solver.save()
    before = solver.start(start)
    assert before.velocity_m_per_s[:, k] == pytest.approx(superficial / VOID, rel=1e-12)
    fields = solver.advance(1e-3, start, fixed_bed(mesh, 0.0, 1e-3, void=VOID, drag=beta, seen=before.velocity_m_per_s))
    assert fields.pressure_gradient_pa_per_m is not None
    # rounding of rho u / h over beta u: the projection of 1 ms starts from velocities that fit to 1e-16
    assert fields.pressure_gradient_pa_per_m[:, k] == pytest.approx(-pascal_per_metre, rel=1e-9)
    assert fields.velocity_m_per_s[:, k] == pytest.approx(superficial / VOID, rel=1e-12)
    # from the first cell's middle to the open end
    assert solver.pressure_pa.max() == pytest.approx(pascal_per_metre * (0.04 - 0.0025), rel=1e-9)
    # without `start`, too: meeting the particles is no acceleration
    solver.restore(token)
    fields = solver.advance(1e-3, start, fixed_bed(mesh, 0.0, 1e-3, void=VOID, drag=beta, seen=seen))
    assert fields.pressure_gradient_pa_per_m is not None
    assert fields.pressure_gradient_pa_per_m[:, k] == pytest.approx(-pascal_per_metre, rel=1e-9)
    assert solver.momentum_error < 1e-12


def march(solver: PlaneSolver, void: Array, drag: Array, window_s: float, windows: int) -> None:
    """Explicit windows with particles that stand still."""
    mesh: Any = solver.mesh
    fields = solver.start(exchange(mesh, 0.0, 0.0, void=void))
    for _ in range(windows):
        end = solver.time_s + window_s
        bed = fixed_bed(mesh, solver.time_s, end, void=void, drag=drag, seen=fields.velocity_m_per_s)
        fields = solver.advance(window_s, bed, bed)


def bed_in_a_channel(z: Array, blur_m: float) -> Array:
    """Void fraction of a bed from 20 to 60 mm, whose ends spread over `blur_m`."""
    rise, fall = (np.clip((z - end) / blur_m + 0.5, 0.0, 1.0) for end in (0.02, 0.06))
    inside: Array = 0.5 * (np.cos(np.pi * fall) - np.cos(np.pi * rise))
    return 1.0 - (1.0 - VOID) * inside


@pytest.mark.parametrize(("blur_m", "order"), [(1e-9, 1.0), (0.02, 2.0)])
def test_a_porous_block_in_a_channel_has_the_pressure_drop_of_ergun(blur_m: float, order: float) -> None:
    superficial = ERGUN[1][0]

    def beta(void: Array) -> Array:
        return np.array([ergun_beta(superficial, e) if e < 1.0 else 0.0 for e in void])

    fine: Array = (np.arange(20000, dtype=np.float64) + 0.5) * (0.08 / 20000)
    void: Array = bed_in_a_channel(fine, blur_m)
    # -dp/dz = beta U / e^2; the fluid's inertia gives back at the end what it took at the beginning
    exact = float(np.sum(beta(void) * superficial / void**2) * (0.08 / 20000))
    assert blur_m > 1e-3 or exact == pytest.approx(ERGUN[1][1] * 0.04, rel=1e-3)
    errors = []
    for cells in (32, 64):
        mesh = plane(2, cells, (0.01, 0.08), "closed", ("closed", "open"))
        solver = PlaneSolver(
            mesh,
            density_kg_per_m3=DENSITY,
            viscosity_pa_s=VISCOSITY,
            walls="slip",
            inflow_m_per_s={"z_low": superficial},
        )
        void = bed_in_a_channel(mesh.centres()[:, 2], blur_m)
        march(solver, void, beta(void), 0.01, 2)
        assert solver.divergence_error_per_s < 1e-10
        assert solver.momentum_error < 1e-12
        errors.append(abs(float(solver.pressure_pa[1, 0] - solver.pressure_pa[-2, 0]) - exact) / exact)
    # a jump is as wide as a cell for the grid; a kernel's end is resolved
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)
    assert errors[1] < (0.025 if order == 1.0 else 0.005)
    gradient = solver.fields().pressure_gradient_pa_per_m
    assert gradient is not None
    inner = mesh.reshape(gradient)[30:34, 0, :, 2]
    assert inner == pytest.approx(-ERGUN[1][1], rel=1e-6)


def test_fluid_goes_around_a_block_and_the_projection_bears_any_drag() -> None:
    # drag that stops the fluid within 1e-7 of a window
    mesh = plane(12, 24, (0.012, 0.024), "closed", ("closed", "open"))
    solver = PlaneSolver(mesh, density_kg_per_m3=DENSITY, viscosity_pa_s=VISCOSITY, inflow_m_per_s={"z_low": 5e-3})
    x, z = mesh.centres()[:, 0], mesh.centres()[:, 2]
    void = np.where((z > 0.008) & (z < 0.016) & (x < 0.006), VOID, 1.0)
    march(solver, void, np.where(void < 1.0, 1e12, 0.0), 1e-2, 10)
    velocity = mesh.reshape(solver.fields().velocity_m_per_s)[:, 0]
    assert np.abs(velocity[9:15, :5]).max() < 1e-6
    assert velocity[12, 6:, 2].mean() == pytest.approx(2 * 5e-3, rel=1e-3)
    assert solver.divergence_error_per_s < 1e-10
    assert solver.momentum_error < 1e-10
    # what the mean flow carries through each row of cells is what came in
    sides = VOID * velocity[12, :6, 2].sum() + velocity[12, 6:, 2].sum()
    assert sides / 12 == pytest.approx(5e-3, rel=1e-6)


def changing(mesh: StructuredMesh, time_s: float) -> Array:
    """A void fraction that moves about, its mean staying the same."""
    size = np.array(mesh.counts) * mesh.spacing_m
    x, z = (mesh.centres()[:, k] / size[k] for k in (0, 2))
    wave: Array = np.cos(np.pi * x) * np.cos(2.0 * np.pi * z) * np.cos(40.0 * time_s)
    void: Array = 0.6 + 0.25 * wave + 0.05 * np.cos(3.0 * np.pi * x) * np.sin(25.0 * time_s)
    return void


@pytest.mark.parametrize(
    ("x", "z", "inflow"),
    [("closed", "closed", {}), ("periodic", ("closed", "open"), {"z_low": 0.02}), ("closed", "periodic", {})],
)
def test_continuity_and_momentum_hold_while_the_void_fraction_changes(x: Any, z: Any, inflow: Any) -> None:
    mesh = plane(9, 12, (0.03, 0.04), x, z)
    solver = PlaneSolver(
        mesh,
        density_kg_per_m3=DENSITY,
        viscosity_pa_s=VISCOSITY,
        inflow_m_per_s=inflow,
        gravity_m_per_s2=(0.3, -9.81),
    )
    random = np.random.default_rng(5)
    fields = solver.start(exchange(mesh, 0.0, 0.0, void=changing(mesh, 0.0)))
    window, volume = 5e-3, mesh.cell_volume_m3
    for k in range(6):
        sources = {"push": random.normal(0.0, 100.0, (mesh.n, 3)), "drag": random.uniform(0.0, 1e5, mesh.n)}
        before, after = (
            exchange(mesh, k * window, t, void=changing(mesh, t), seen=fields.velocity_m_per_s, **sources)
            for t in (k * window, (k + 1) * window)
        )
        fields = solver.advance(window, before, after)
        assert solver.divergence_error_per_s < 1e-10
        assert solver.momentum_error < 1e-12
        # all of the particles' push arrives, but for the drag's part in what changed since
        quiet = float(sources["push"][:, 2].sum()) * volume
        drag = float(sources["drag"].max()) * float(np.abs(fields.velocity_m_per_s).max())
        assert abs(solver.momentum_n["interaction"][1] - quiet) < 2.0 * drag * volume * mesh.n


def test_all_of_the_push_arrives() -> None:
    mesh = plane(5, 7, (0.05, 0.07), "closed", ("closed", "open"))
    solver = PlaneSolver(mesh, density_kg_per_m3=DENSITY, viscosity_pa_s=VISCOSITY)
    push = np.random.default_rng(1).normal(0.0, 50.0, (mesh.n, 3))
    after = exchange(mesh, 0.0, 1e-3, push=push)
    solver.advance(1e-3, after, after)
    assert solver.momentum_n["interaction"] == pytest.approx(
        push[:, [0, 2]].sum(axis=0) * mesh.cell_volume_m3, rel=1e-12
    )


def test_what_particles_give_is_what_the_fluid_gets_once_they_saw_it() -> None:
    # uneven drag that the mean over sides and cells would smooth: the sums agree when seen is what comes out
    mesh = plane(6, 9, (0.03, 0.045), "closed", ("closed", "open"))
    solver = PlaneSolver(mesh, density_kg_per_m3=DENSITY, viscosity_pa_s=VISCOSITY, inflow_m_per_s={"z_low": 0.01})
    random = np.random.default_rng(8)
    bed = {"void": random.uniform(0.4, 1.0, mesh.n), "drag": random.uniform(0.0, 1e6, mesh.n)}
    seen = solver.start(exchange(mesh, 0.0, 0.0, void=bed["void"])).velocity_m_per_s
    token = solver.save()
    for _ in range(8):
        solver.restore(token)
        after = fixed_bed(mesh, 0.0, 2e-3, seen=seen, **bed)
        found = solver.advance(2e-3, after, after).velocity_m_per_s
        change, seen = float(np.abs(found - seen).max()), found
    assert change < 1e-12
    assert solver.steps == 1
    given = after.interaction_n_per_m3[:, [0, 2]].sum(axis=0) * mesh.cell_volume_m3
    assert solver.momentum_n["interaction"] == pytest.approx(given, rel=1e-9)


def test_one_cell_across_is_the_column() -> None:
    # particles that come and go in a column with inflow: same flux through its sides, same pressure gradient
    n, height, superficial, window = 16, 0.04, 0.01, 1e-3
    mesh = plane(1, n, (0.01, height), "closed", ("closed", "open"))
    z = mesh.centres()[:, 2]

    def void(t: float) -> Array:
        return 0.7 + 0.1 * np.sin(2 * np.pi * (z - 0.03 * t) / height)

    flat = PlaneSolver(
        mesh, density_kg_per_m3=DENSITY, viscosity_pa_s=0.0, walls="slip", inflow_m_per_s={"z_low": superficial}
    )
    flat.start(exchange(mesh, 0.0, 0.0, void=void(0.0)))
    column = ColumnSolver(mesh, density_kg_per_m3=DENSITY, flux_m_per_s=superficial)
    before = exchange(mesh, 0.0, 0.0, void=void(0.0))
    for k in range(3):
        after = exchange(mesh, k * window, (k + 1) * window, void=void((k + 1) * window), drag=2e5, push=[0, 0, 50.0])
        flat.advance(window, before, after)
        column.advance(window, before, after)
        e = np.concatenate([after.void_fraction[:1], 0.5 * (after.void_fraction[1:] + after.void_fraction[:-1])])
        flux = np.append(e, after.void_fraction[-1]) * flat.save()["w"][:, 0]
        assert flux == pytest.approx(column.flux_through_sides_m_per_s, rel=1e-10)
        before = after


def test_a_mean_gradient_drives_a_periodic_bed() -> None:
    # rho e du/dt = -e G - B u: backward Euler in B, one step per window
    gradient, drag, window = -2000.0, 3e5, 1e-3
    mesh = plane(1, 6, (0.01, 0.03), "closed", "periodic")
    solver = PlaneSolver(
        mesh,
        density_kg_per_m3=DENSITY,
        viscosity_pa_s=VISCOSITY,
        walls="slip",
        mean_gradient_pa_per_m=(0.0, gradient),
    )
    final, velocity = -VOID * gradient / drag, 0.0
    for k in range(1, 5):
        seen = solver.fields().velocity_m_per_s
        bed = fixed_bed(mesh, solver.time_s, k * window, void=VOID, drag=drag, seen=seen)
        fields = solver.advance(window, bed, bed)
        velocity = (velocity + window * -gradient / DENSITY) / (1.0 + window * drag / (VOID * DENSITY))
        assert solver.steps == 1
        assert fields.velocity_m_per_s[:, 2] == pytest.approx(velocity, rel=1e-10)
    assert fields.pressure_gradient_pa_per_m is not None
    assert fields.pressure_gradient_pa_per_m[:, 2] == pytest.approx(gradient, rel=1e-10)
    assert velocity == pytest.approx(final, rel=0.15)


def test_a_closed_box_at_rest_is_hydrostatic() -> None:
    mesh = plane(6, 8, (0.06, 0.08), "closed", "closed")
    solver = PlaneSolver(mesh, density_kg_per_m3=DENSITY, viscosity_pa_s=VISCOSITY, gravity_m_per_s2=(0.0, -9.81))
    bed = exchange(mesh, 0.0, 1e-2, void=np.random.default_rng(2).uniform(0.3, 1.0, mesh.n))
    solver.start(bed)
    fields = solver.advance(1e-2, bed, bed)
    assert fields.pressure_gradient_pa_per_m is not None
    assert fields.pressure_gradient_pa_per_m[:, 2] == pytest.approx(-9810.0, rel=1e-11)
    assert fields.velocity_m_per_s == pytest.approx(0.0, abs=1e-12)


def test_a_flux_that_grows_needs_the_pressure_of_its_inertia() -> None:
    mesh, rate = plane(3, 10, (0.03, 0.1), "closed", ("closed", "open")), 0.5
    inflow: Callable[[float], float] = lambda time_s: rate * time_s  # noqa: E731
    solver = PlaneSolver(
        mesh, density_kg_per_m3=DENSITY, viscosity_pa_s=0.0, walls="slip", inflow_m_per_s={"z_low": inflow}
    )
    run_empty(solver, 1e-2, 3)
    fields = solver.fields()
    assert fields.pressure_gradient_pa_per_m is not None and fields.acceleration_m_per_s2 is not None
    assert fields.pressure_gradient_pa_per_m[:, 2] == pytest.approx(-DENSITY * rate, rel=1e-9)
    assert fields.acceleration_m_per_s2[:, 2] == pytest.approx(rate, rel=1e-9)
    assert fields.velocity_m_per_s[:, 2] == pytest.approx(rate * 0.03, rel=1e-12)


def test_saved_planes_go_on_to_the_bit(tmp_path: Path) -> None:
    def make() -> PlaneSolver:
        mesh = plane(6, 8, (0.06, 0.08), "closed", ("closed", "open"))
        return PlaneSolver(mesh, density_kg_per_m3=1.2, viscosity_pa_s=1.8e-5, inflow_m_per_s={"z_low": np.arange(6.0)})

    def go_on(solver: PlaneSolver) -> Array:
        run_empty(solver, 5e-3, 2)
        return solver.fields().velocity_m_per_s

    solver = make()
    go_on(solver)
    token = solver.save()
    solver.to_file(tmp_path / "plane.npz")
    expected = go_on(solver)
    solver.restore(token)
    assert solver.time_s == 1e-2
    assert np.array_equal(go_on(solver), expected)
    other = make()
    other.from_file(tmp_path / "plane.npz")
    assert np.array_equal(go_on(other), expected)
    small = PlaneSolver(plane(2, 2, (1, 1), "closed", "closed"), density_kg_per_m3=1.0, viscosity_pa_s=0.0)
    with pytest.raises(ValueError, match="saved plane"):
        small.restore(token)


def test_bad_input_is_named() -> None:
    mesh = plane(3, 4, (0.03, 0.04), "closed", "closed")
    water: Any = {"density_kg_per_m3": DENSITY, "viscosity_pa_s": VISCOSITY}
    deep = StructuredMesh((0, 0, 0), (1, 1, 1), (2, 2, 2))
    round_mesh = plane(3, 4, (1, 1), "periodic", "closed")
    for make, word in (
        (lambda: PlaneSolver(deep, **water), "2 cells in y"),
        (lambda: PlaneSolver(mesh, density_kg_per_m3=-1.0, viscosity_pa_s=0.0), "density_kg_per_m3 is -1"),
        (lambda: PlaneSolver(mesh, density_kg_per_m3=1.0, viscosity_pa_s=-2.0), "viscosity_pa_s is -2"),
        (lambda: PlaneSolver(mesh, **water, convection="best"), "convection is 'best'; there are upwind"),
        (lambda: PlaneSolver(mesh, **water, walls="wet"), "walls is 'wet'"),
        (lambda: PlaneSolver(mesh, **water, inflow_m_per_s={"top": 1.0}), "'top'; there are x_low"),
        (lambda: PlaneSolver(mesh, **water, inflow_m_per_s={"z_low": 1.0}), "no end is open"),
        (lambda: PlaneSolver(mesh, **water, inflow_m_per_s={"z_low": np.ones(4)}), r"shape \(4,\)"),
        (lambda: PlaneSolver(round_mesh, **water, inflow_m_per_s={"x_low": 1.0}), "periodic"),
    ):
        with pytest.raises(ValueError, match=word):
            make()
    solver = PlaneSolver(mesh, **water)
    for void, word in ((np.zeros(12), "void fraction of cell 0 is 0"), (np.ones(5), "shape")):
        bad = exchange(mesh, 0.0, 1.0)
        object.__setattr__(bad, "void_fraction", void)
        with pytest.raises(ValueError, match=word):
            solver.advance(1.0, bad, bad)
    with pytest.raises(ValueError, match="no end is open"):
        solver.advance(1.0, exchange(mesh, 0.0, 0.0), exchange(mesh, 0.0, 1.0, void=0.9))
    push = np.where(np.arange(36).reshape(12, 3) == 14, np.nan, 0.0)
    with pytest.raises(ValueError, match="interaction_n_per_m3 is not finite in cell 4"):
        solver.advance(1.0, exchange(mesh, 0.0, 0.0), exchange(mesh, 0.0, 1.0, push=push))
    with pytest.raises(ValueError, match="window_s is 0"):
        solver.advance(0.0, exchange(mesh, 0.0, 0.0), exchange(mesh, 0.0, 1.0))


BEADS = f"""
[scene]
name = "beads"
gravity_m_per_s2 = [0.0, 0.0, -9.81]
time_step_s = 2e-5
[domain]
min_m = [0.0, 0.0, 0.0]
max_m = [0.006, 0.004, 0.012]
periodic = [true, true, false]
[[material]]
name = "glass"
density_kg_per_m3 = 2500.0
[[material_pair]]
materials = ["glass", "glass"]
stiffness_n_per_m = 200.0
restitution = 0.8
friction = 0.3
[[shape]]
name = "bead"
geometry = {{ kind = "sphere", radius_m = 5e-4 }}
[[boundary]]
name = "plate"
material = "glass"
geometry = {{ kind = "plane", normal = [0, 0, 1], point_m = [0, 0, 0] }}
[[insertion]]
shape = "bead"
material = "glass"
placement = {{ method = "poses", positions_m = {
    [
        [1.2e-3 * i + 6e-4 + 2e-4 * (k % 2), 1.3e-3 * j + 6e-4, 1.1e-3 * k + 6e-4]
        for k in range(5)
        for j in range(3)
        for i in range(5)
    ]
} }}
"""


def test_particles_of_a_daemon_in_a_plane() -> None:
    """What a real bed gives is what the plane gets, once windows are iterated."""
    mesh = plane(4, 8, (0.006, 0.012), "periodic", ("closed", "open"))
    mesh = StructuredMesh(mesh.origin_m, (0.0015, 0.004, 0.0015), mesh.counts, ("periodic", "periodic", mesh.sides[2]))
    solver = PlaneSolver(mesh, density_kg_per_m3=DENSITY, viscosity_pa_s=VISCOSITY, inflow_m_per_s={"z_low": 0.03})
    water = Fluid(DENSITY, VISCOSITY, smoothing_length_m=3e-3, buoyancy=True)
    with (
        sturz.launch(scene_text=BEADS) as simulation,
        CoupledRun(simulation, solver, fluid=water, scheme=Implicit(tolerance=1e-6)) as run,
    ):
        for _ in range(4):
            report = run.advance(1e-3)
            assert report.momentum_error < 1e-12
            assert solver.divergence_error_per_s < 1e-10
            assert solver.momentum_error < 1e-12
            given = run.exchange.interaction_n_per_m3[:, [0, 2]].sum(axis=0) * mesh.cell_volume_m3
            assert solver.momentum_n["interaction"] == pytest.approx(given, abs=1e-4 * np.abs(given).max())
        # the plane's flux is what flows in and what the beads' own motion displaces
        fluid = run.exchange.void_fraction * run.fields.velocity_m_per_s[:, 2]
        solid = (1.0 - run.exchange.void_fraction) * run.exchange.solid_velocity_m_per_s[:, 2]
        rows = mesh.reshape(fluid + solid)[:, 0].mean(axis=1)
        # 7 % at the plate: the cell's void fraction is not that of its sides, between which the fluid is counted
        assert rows == pytest.approx(0.03, rel=0.1)
        assert rows.mean() == pytest.approx(0.03, rel=0.02)
