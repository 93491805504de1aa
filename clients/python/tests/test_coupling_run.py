"""The driver of coupled runs against a stand-in of particles with a closed form: no daemon, no bus."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from sturz import CouplingError
from sturz.coupling import (
    Aitken,
    ColumnSolver,
    CoupledRun,
    Exchange,
    Explicit,
    FluidFields,
    Implicit,
    Iqn,
    Relaxation,
    StructuredMesh,
)

VOID, WATER = 0.6, 1000.0
MESH = StructuredMesh((0, 0, 0), (1e-2,) * 3, (1, 1, 1), sides=("periodic",) * 3)


class Grains:
    """Grains that move as one in a closed cell: rho_p dv/dt = (rho - rho_p) g - dp/dz + k (u - v), per their volume."""

    def __init__(self, density: float, drag: float = 2e3, steps: int = 200) -> None:
        self.density, self.drag, self.steps = density, drag, steps
        self.time_s, self.v, self.u = 0.0, 0.0, 0.0
        self.restored = 0

    def _tell(self, from_s: float, force: float) -> Exchange:
        one = np.ones(1)
        vector = lambda z: np.array([[0.0, 0.0, z]])  # noqa: E731
        return Exchange(
            from_time_s=from_s,
            time_s=self.time_s,
            void_fraction=VOID * one,
            solid_velocity_m_per_s=vector(self.v),
            interaction_n_per_m3=vector(-(1 - VOID) * force),
            pressure_force_n_per_m3=vector(0.0),
            drag_kg_per_m3_s=(1 - VOID) * self.drag * one,
        )

    def exchange(self) -> Exchange:
        """Now."""
        return self._tell(self.time_s, 0.0)

    def advance(self, window_s: float, fields: FluidFields, ramp: bool) -> Exchange:
        """Exactly, in steps of a frozen fluid."""
        assert fields.pressure_gradient_pa_per_m is not None
        end, gradient = fields.velocity_m_per_s[0, 2], fields.pressure_gradient_pa_per_m[0, 2]
        begun, h, impulse = self.time_s, window_s / self.steps, 0.0
        for k in range(self.steps):
            u = self.u + (end - self.u) * (k + 0.5) / self.steps if ramp else end
            push = (WATER - self.density) * 9.81 - gradient
            rate = self.drag / self.density
            steady = u + push / self.drag
            v = steady + (self.v - steady) * np.exp(-rate * h)
            impulse += self.density * (v - self.v) - push * h
            self.v = v
        self.u, self.time_s = end, begun + window_s
        return self._tell(begun, impulse / window_s)

    def save(self) -> Any:
        """All of it."""
        return self.time_s, self.v, self.u

    def restore(self, token: Any) -> None:
        """Back."""
        self.time_s, self.v, self.u = token
        self.restored += 1

    def forget(self, token: Any) -> None:
        """Nothing to do."""


def exact(density: float, time_s: float, drag: float = 2e3) -> float:
    """(rho_p + rho e'/e) dv/dt = (rho - rho_p) g - k v / e^2."""
    inertia = density + WATER * (1 - VOID) / VOID
    rise, rate = (WATER - density) * 9.81 / inertia, drag / VOID**2 / inertia
    return rise / rate * -np.expm1(-rate * time_s)


def run_of(density: float, scheme: Explicit | Implicit, **more: Any) -> tuple[CoupledRun, Grains]:
    grains = Grains(density)
    return CoupledRun(grains, ColumnSolver(MESH, density_kg_per_m3=WATER), scheme=scheme, **more), grains


def speed(density: float, scheme: Explicit | Implicit, windows: int, time_s: float = 0.08) -> float:
    run, grains = run_of(density, scheme)
    for _ in range(windows):
        run.advance(time_s / windows)
    return grains.v


def test_heavy_grains_can_be_explicit_at_first_order():
    errors = np.array([abs(speed(8000.0, Explicit(), n) - exact(8000.0, 0.08)) for n in (40, 80, 160)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all(np.abs(orders - 1) < 0.15), (errors, orders)


def test_iterated_windows_are_of_second_order():
    errors = np.array([abs(speed(100.0, Implicit(tolerance=1e-10), n) - exact(100.0, 0.08)) for n in (4, 8, 16)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all(np.abs(orders - 2) < 0.25), (errors, orders)


def test_light_grains_diverge_explicitly_and_converge_iterated():
    """CFD5 without a daemon: the fluid that they push aside weighs 6.7 times what they do."""
    with np.errstate(over="ignore", invalid="ignore"):
        assert not abs(speed(100.0, Explicit(), 40)) < 1e3
    counts = {}
    for name, acceleration in (("relaxation", Relaxation(0.15)), ("aitken", Aitken(0.15)), ("iqn", Iqn(0.15))):
        run, grains = run_of(100.0, Implicit(acceleration, tolerance=1e-8, max_iterations=400, extrapolate=False))
        counts[name] = max(run.advance(1e-3).iterations for _ in range(10))
        assert grains.v == pytest.approx(exact(100.0, 1e-2), rel=1e-3)
        assert grains.restored >= counts[name] - 1
    assert counts["iqn"] <= 6 < counts["relaxation"]


def test_substeps_of_the_solver_share_the_window():
    """A flux that grows: the acceleration is its rate, whatever the parts."""
    for parts in (1, 2, 4):
        grains = Grains(8000.0)
        solver = ColumnSolver(MESH, density_kg_per_m3=WATER, flux_m_per_s=lambda t: 0.5 * t)
        run = CoupledRun(grains, solver, solver_substeps=parts)
        grains.v = 0.0
        grains.advance = lambda w, fields, ramp, grains=grains: still(grains, w)  # type: ignore[method-assign]
        run.advance(0.1)
        assert run.fields.acceleration_m_per_s2 is not None
        assert run.fields.acceleration_m_per_s2[0, 2] == pytest.approx(0.5 / VOID, rel=1e-12)
        assert run.fields.velocity_m_per_s[0, 2] == pytest.approx(0.05 / VOID, rel=1e-12)


def still(grains: Grains, window_s: float) -> Exchange:
    grains.time_s += window_s
    return grains._tell(grains.time_s - window_s, 0.0)


class Broken(ColumnSolver):
    """Fails in its second window, in one way or another."""

    how: str = "raise"
    windows = 0

    def advance(self, window_s: float, before: Exchange, after: Exchange) -> FluidFields:
        """Once well."""
        self.windows += 1
        fields = super().advance(window_s, before, after)
        if self.windows < 2:
            return fields
        if self.how == "raise":
            raise ConnectionError("gone")
        return dataclasses.replace(fields, velocity_m_per_s=fields.velocity_m_per_s * np.nan)


@pytest.mark.parametrize("how", ["raise", "nan"])
def test_a_failed_window_leaves_both_sides_together_or_says_that_they_are_apart(how):
    failure = ConnectionError if how == "raise" else CouplingError
    solver = Broken(MESH, density_kg_per_m3=WATER)
    solver.how, solver.windows = how, -3
    run = CoupledRun(Grains(8000.0), solver, scheme=Implicit(tolerance=1e-9, extrapolate=False))
    with pytest.raises(failure):
        for _ in range(9):
            run.advance(1e-3)
    assert run.solver.time_s == pytest.approx(run.time_s) and run._particles.time_s == pytest.approx(run.time_s)
    explicit = Broken(MESH, density_kg_per_m3=WATER)
    explicit.how = how
    run = CoupledRun(Grains(8000.0), explicit)
    run.advance(1e-3)
    with pytest.raises(failure):
        run.advance(1e-3)
    with pytest.raises(CouplingError, match="apart"):
        run.advance(1e-3)


def test_what_nobody_counted_is_not_conserved():
    run, _ = run_of(8000.0, Explicit())
    report = run.advance(1e-3)
    assert np.isnan(report.momentum_error) and np.isnan(report.solid_volume_error)
