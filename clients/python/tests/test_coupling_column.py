"""The column against closed forms."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fluid_exchange import DENSITY, ERGUN, VOID, ergun_beta, exchange, fixed_bed

from sturz.coupling import ColumnSolver, Exchange, FluidSolver, StructuredMesh

PAGE = Path(__file__).resolve().parents[3] / "docs" / "coupling_solver.md"
CELLS, HEIGHT = 20, 0.04


def column(sides: str = "open", axis: int = 2) -> StructuredMesh:
    counts, spacing = [1, 1, 1], [0.01, 0.01, 0.01]
    counts[axis], spacing[axis] = CELLS, HEIGHT / CELLS
    ends = ["closed"] * 3
    ends[axis] = sides
    return StructuredMesh((0.0, 0.0, 0.0), tuple(spacing), tuple(counts), tuple(ends))  # type: ignore[arg-type]


@pytest.mark.parametrize(("superficial", "pascal_per_metre"), ERGUN)
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_ergun_through_a_fixed_bed(superficial: float, pascal_per_metre: float, axis: int) -> None:
    mesh = column(axis=axis)
    solver = ColumnSolver(mesh, density_kg_per_m3=DENSITY, flux_m_per_s=superficial, axis=axis)  # type: ignore[arg-type]
    beta = ergun_beta(superficial)
    # what the particles saw is not what the fluid does: the implicit part must make up for it
    seen = np.zeros((mesh.n, 3))
    seen[:, axis] = 0.1 * superficial
    start = fixed_bed(mesh, 0.0, 0.0, void=VOID, drag=beta, seen=seen)
    # without `start`: meeting the particles is no acceleration
    fields = solver.advance(1e-3, start, fixed_bed(mesh, 0.0, 1e-3, void=VOID, drag=beta, seen=seen))
    assert fields.velocity_m_per_s[:, axis] == pytest.approx(superficial / VOID, rel=1e-14)
    assert fields.pressure_gradient_pa_per_m is not None
    assert fields.pressure_gradient_pa_per_m[:, axis] == pytest.approx(-pascal_per_metre, rel=1e-12)
    assert solver.pressure_drop_pa(0.0, HEIGHT) == pytest.approx(pascal_per_metre * HEIGHT, rel=1e-12)
    assert solver.momentum_error < 1e-14


def moving_bed(time_s: float, z: np.ndarray, speed: float) -> np.ndarray:
    """Void fraction of a wave of particles that travels."""
    return 0.7 + 0.1 * np.sin(2.0 * np.pi * (z - speed * time_s) / HEIGHT)


def test_a_travelling_wave_of_particles_drives_the_fluid_back() -> None:
    # particles that travel at v in a column whose total flux is 0: e u = -(1 - e) v
    mesh, speed = column("periodic"), 0.03
    z = mesh.centres()[:, 2]
    solver = ColumnSolver(mesh, density_kg_per_m3=DENSITY)

    def particles(begin: float, end: float) -> Exchange:
        return exchange(mesh, begin, end, void=moving_bed(end, z, speed), solid_m_per_s=[0.0, 0.0, speed])

    before = particles(0.0, 0.0)
    solver.start(before)
    window = 1e-3
    for k in range(5):
        after = particles(k * window, (k + 1) * window)
        solver.advance(window, before, after)
        e = after.void_fraction
        assert solver.fields().velocity_m_per_s[:, 2] == pytest.approx(-(1 - e) * speed / e, rel=1e-12)
        through = solver.flux_through_sides_m_per_s
        # continuity with the change of the void fraction, cell by cell
        assert np.diff(through) * CELLS / HEIGHT == pytest.approx(-(e - before.void_fraction) / window, abs=1e-12)
        middle = 0.5 * (z[:-1] + z[1:])
        exact = -(1.0 - moving_bed((k + 0.5) * window, middle, speed)) * speed
        assert through[1:-1] == pytest.approx(exact, rel=0.01)
        assert solver.momentum_error < 1e-12
        before = after


def test_a_flux_that_grows_needs_the_pressure_of_its_inertia() -> None:
    # U = a t in an empty column: -dp/dz = rho a, Du/Dt = a
    mesh, rate = column(), 0.5
    solver = ColumnSolver(mesh, density_kg_per_m3=DENSITY, flux_m_per_s=lambda time_s: rate * time_s)
    empty = exchange(mesh, 0.0, 0.0)
    for k in range(3):
        fields = solver.advance(1e-2, empty, exchange(mesh, 1e-2 * k, 1e-2 * (k + 1)))
    assert fields.pressure_gradient_pa_per_m is not None and fields.acceleration_m_per_s2 is not None
    assert fields.pressure_gradient_pa_per_m[:, 2] == pytest.approx(-DENSITY * rate, rel=1e-12)
    assert fields.acceleration_m_per_s2[:, 2] == pytest.approx(rate, rel=1e-12)
    assert solver.pressure_pa[0] == pytest.approx(DENSITY * rate * HEIGHT * (1 - 0.5 / CELLS), rel=1e-12)


def test_a_closed_column_at_rest_is_hydrostatic() -> None:
    mesh = column("closed")
    solver = ColumnSolver(mesh, density_kg_per_m3=DENSITY, gravity_m_per_s2=-9.81)
    bed = exchange(mesh, 0.0, 1e-3, void=np.linspace(0.4, 1.0, CELLS))
    fields = solver.advance(1e-3, bed, bed)
    assert fields.pressure_gradient_pa_per_m is not None
    assert fields.velocity_m_per_s == pytest.approx(0.0, abs=1e-15)
    assert fields.pressure_gradient_pa_per_m[:, 2] == pytest.approx(-9810.0, rel=1e-13)


def test_saved_columns_go_on_to_the_bit(tmp_path: Path) -> None:
    mesh, superficial = column(), 5e-3
    void = np.linspace(0.4, 0.9, CELLS)

    def advance(solver: ColumnSolver, k: int) -> np.ndarray:
        seen = solver.fields().velocity_m_per_s
        windows = [fixed_bed(mesh, 1e-3 * j, 1e-3 * (j + 1), void=void, drag=1e5, seen=seen) for j in (k - 1, k)]
        gradient = solver.advance(1e-3, *windows).pressure_gradient_pa_per_m
        assert gradient is not None
        return gradient

    solver = ColumnSolver(mesh, density_kg_per_m3=DENSITY, flux_m_per_s=superficial)
    advance(solver, 0)
    token = solver.save()
    solver.to_file(tmp_path / "column.npz")
    expected = [advance(solver, k) for k in (1, 2)]
    solver.restore(token)
    assert solver.time_s == 1e-3
    assert all(np.array_equal(advance(solver, k), gradient) for k, gradient in zip((1, 2), expected, strict=True))
    other = ColumnSolver(mesh, density_kg_per_m3=DENSITY, flux_m_per_s=superficial)
    other.from_file(tmp_path / "column.npz")
    assert all(np.array_equal(advance(other, k), gradient) for k, gradient in zip((1, 2), expected, strict=True))


def test_bad_input_is_named() -> None:
    with pytest.raises(ValueError, match="across axis 0"):
        ColumnSolver(column(), density_kg_per_m3=DENSITY, axis=0)
    with pytest.raises(ValueError, match="density_kg_per_m3 is 0"):
        ColumnSolver(column(), density_kg_per_m3=0.0)
    mesh = column()
    solver = ColumnSolver(mesh, density_kg_per_m3=DENSITY)
    full = exchange(mesh, 0.0, 1e-3, void=np.where(np.arange(CELLS) == 7, -0.1, 0.5))
    with pytest.raises(ValueError, match=r"void fraction of cell 7 is -0\.1"):
        solver.advance(1e-3, full, full)


def test_the_partner_of_the_page(tmp_path: Path) -> None:
    names: dict[str, Any] = {"__name__": "page"}
    (block,) = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(), flags=re.DOTALL | re.MULTILINE)
    exec(compile(block, str(PAGE), "exec"), names)
    mesh, drag, window = column("closed"), 2e5, 1e-3
    tank = names["Tank"](mesh, DENSITY)
    assert isinstance(tank, FluidSolver)
    # a bed that moves at 0.1 m/s takes the fluid along: backward Euler of (0.1 - u)' = -B / (e rho) (0.1 - u)
    for k in range(1, 4):
        seen = tank.fields().velocity_m_per_s
        push = drag * (np.array([0.0, 0.0, 0.1]) - seen)
        bed = exchange(mesh, tank.time_s, tank.time_s + window, void=VOID, push=push, drag=drag, seen=seen)
        tank.advance(window, bed, bed)
        left = (1.0 + window * drag / (VOID * DENSITY)) ** -k
        assert tank.velocity[2] == pytest.approx(0.1 * (1.0 - left), rel=1e-12)
    tank.to_file(tmp_path / "tank.npz")
    other = names["Tank"](mesh, DENSITY)
    other.from_file(tmp_path / "tank.npz")
    assert np.array_equal(other.fields().velocity_m_per_s, tank.fields().velocity_m_per_s)
    assert other.time_s == tank.time_s == pytest.approx(3 * window)
