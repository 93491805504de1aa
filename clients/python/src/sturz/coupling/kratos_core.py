"""The fluid itself: time steps, boundary conditions and fields at the points."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .kratos_case import Inlet, KratosCase, KratosState
from .kratos_equations import Equations, KratosFailed
from .kratos_grid import SIDES, Box, Grid, box_grid, read_mdpa


class KratosCore:
    """Kratos' elements for flow through particles ("model A"), in arrays: what a worker runs and `KratosSolver` wraps.

    It needs numpy and Kratos, and nothing else of `sturz`.

    Args:
        case: mesh, boundaries, fluid and time stepping.

    Raises:
        KratosMissing: Kratos is not installed here.
        KratosFailed, GridError: a case that cannot be run.
    """

    def __init__(self, case: KratosCase) -> None:
        self.case = case
        self.grid = _grid(case)
        self.points_m = self.grid.nodes_m[self.grid.first_node]
        self._inlets = {side: kind for side, kind in case.boundaries.items() if isinstance(kind, Inlet)}
        self._closed = "outlet" not in case.boundaries.values()
        if self._closed and self._inlets:
            raise KratosFailed(f"boundaries: fluid enters by {', '.join(self._inlets)}, but there is no 'outlet'")
        self._equations = Equations(self.grid, case.viscosity_pa_s, case.linear_solver, case.threads)
        self._fixed = self._boundary_conditions()
        for component in range(4):
            self._equations.fix(np.flatnonzero(self._fixed[:, component]), component)
        self._equations.initialize()
        n = self.grid.n
        self.time_s = 0.0
        self._last_step_s = 0.0
        self._pressure = np.zeros(n)
        self._void_fraction = np.ones(n)
        self._rate = np.zeros((n, 3))
        self._velocity = np.tile(np.asarray(case.initial_velocity_m_per_s, float), (n, 1))
        self._velocity = self._with_boundary_values(self._velocity, self._void_fraction)
        self._previous = self._velocity.copy()

    def _boundary_conditions(self) -> NDArray[np.bool_]:
        """Which unknowns are held, (n, 4): three velocities and the pressure."""
        grid = self.grid
        fixed = np.zeros((grid.n, 4), bool)
        for side, kind in self.case.boundaries.items():
            points = grid.owner[grid.groups[side]]
            if isinstance(kind, Inlet) or kind == "no_slip":
                fixed[points, :3] = True
            elif kind == "slip":
                across = np.flatnonzero(np.ptp(grid.nodes_m[grid.groups[side]], axis=0) < 1e-9 * _extent(grid))
                if len(across) != 1:
                    raise KratosFailed(f"boundaries[{side!r}]: 'slip' is possible only on a plane across an axis")
                fixed[points, across[0]] = True
        if self._closed:
            fixed[0, 3] = True  # the pressure is known but for a constant
        return fixed

    def _with_boundary_values(
        self, velocity: NDArray[np.float64], void_fraction: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Velocities with the held ones at their values for a void fraction."""
        result = np.where(self._fixed[:, :3], 0.0, velocity)
        walls = [self.grid.groups[side] for side, kind in self.case.boundaries.items() if kind == "no_slip"]
        at_wall = np.zeros(self.grid.n, bool)
        for nodes in walls:
            at_wall[self.grid.owner[nodes]] = True
        for side, inlet in self._inlets.items():
            points = np.unique(self.grid.owner[self.grid.groups[side]])
            points = points[~at_wall[points]]
            superficial = np.asarray(inlet.superficial_velocity_m_per_s, float)
            alone = np.zeros_like(result)
            alone[points] = superficial / void_fraction[points, None]
            found = self.grid.flux_m3_per_s(side, void_fraction, alone)
            wanted = float(np.sum(self.grid.areas_m2(self.grid.faces(side)) @ superficial))
            # Walls at the rim and a void fraction that varies there would change the flux of the interpolated product.
            result[points] = alone[points] * (wanted / found if found != 0.0 else 1.0)
        return result

    def set_inlet(self, side: str, superficial_velocity_m_per_s: ArrayLike) -> None:
        """Changes an inlet from the next time step on; e u, (3,), m/s.

        Raises:
            KratosFailed: no such inlet.
        """
        if side not in self._inlets:
            raise KratosFailed(f"{side!r} is no inlet of this case; inlets are {sorted(self._inlets)}")
        velocity = np.asarray(superficial_velocity_m_per_s, float)
        if velocity.shape != (3,) or not np.all(np.isfinite(velocity)):
            raise KratosFailed(f"set_inlet({side!r}): {velocity} is not a velocity of three finite numbers")
        self._inlets[side] = replace(self._inlets[side], superficial_velocity_m_per_s=tuple(velocity.tolist()))

    @property
    def pressure_pa(self) -> NDArray[np.float64]:
        """Pressure at the points without its hydrostatic part, (n,), Pa."""
        return self._pressure.copy()

    def arrays(self) -> dict[str, NDArray[np.float64]]:
        """The fluid now, at the points: the arrays of `sturz.FluidFields`."""
        slopes = self.grid.gradient(self._velocity)
        convected = np.einsum("nd,ndc->nc", self._velocity, slopes)
        curl = [slopes[:, a, b] - slopes[:, b, a] for a, b in ((1, 2), (2, 0), (0, 1))]
        hydrostatic = self.case.density_kg_per_m3 * np.asarray(self.case.gravity_m_per_s2)
        return {
            "velocity_m_per_s": self._velocity.copy(),
            "pressure_gradient_pa_per_m": self.grid.gradient(self._pressure) + hydrostatic,
            "acceleration_m_per_s2": self._rate + convected,
            "vorticity_rad_per_s": np.stack(curl, axis=-1),
        }

    def march(
        self,
        window_s: float,
        void_before: ArrayLike,
        void_after: ArrayLike,
        interaction_n_per_m3: ArrayLike,
        drag_kg_per_m3_s: ArrayLike,
        seen_velocity_m_per_s: ArrayLike | None,
    ) -> None:
        """One window: the void fraction goes linearly from one to the other; without a seen velocity drag is explicit.

        Raises:
            KratosFailed: unusable input, or a step that does not converge.
        """
        if not (np.isfinite(window_s) and window_s > 0):
            raise KratosFailed(f"advance: window_s is {window_s}; a positive time is needed")
        start = self._checked_void_fraction("before", void_before)
        end = self._checked_void_fraction("after", void_after)
        rate = (end - start) / window_s
        if self._closed:
            rate = rate - np.average(rate, weights=self.grid.volumes_m3)  # nothing can leave an incompressible fluid
        n = self.grid.n
        force = _checked("after.interaction_n_per_m3", interaction_n_per_m3, (n, 3))
        drag = _checked("after.drag_kg_per_m3_s", drag_kg_per_m3_s, (n,))
        if np.any(drag < 0):
            raise KratosFailed(
                f"after.drag_kg_per_m3_s is {drag.min()} at point {int(drag.argmin())}; 0 or more is needed"
            )
        if seen_velocity_m_per_s is None:
            seen, drag = np.zeros((n, 3)), np.zeros(n)
        else:
            seen = _checked("after.seen_velocity_m_per_s", seen_velocity_m_per_s, (n, 3))
        steps = self.case.steps_per_window
        for step in range(1, steps + 1):
            self._step(window_s / steps, start + (end - start) * (step / steps), rate, (force, drag, seen))
        self.time_s += window_s

    def _step(
        self,
        step_s: float,
        void: NDArray[np.float64],
        void_rate: NDArray[np.float64],
        sources: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    ) -> None:
        """One implicit step: BDF2 of a variable step, backward Euler at the start."""
        grid, density = self.grid, self.case.density_kg_per_m3
        force, drag, seen = sources
        ratio = step_s / self._last_step_s if self._last_step_s > 0 else 0.0
        first = (1 + 2 * ratio) / (1 + ratio) / step_s
        history = (ratio**2 / (1 + ratio) * self._previous - (1 + ratio) * self._velocity) / step_s
        resistance = grid.cell_mean(drag / void)
        pulled = grid.mass_times(seen, resistance)
        driven = density * (np.asarray(self.case.body_acceleration_m_per_s2) - history) + force / void[:, None]
        target = pulled + grid.mass_times(driven, np.ones(len(grid.cells)))
        self._equations.set_void_fraction(void, void_rate, grid.consistent_gradient(void))
        self._equations.set_inertia(resistance, density * first, density, target)
        guess = self._with_boundary_values(self._velocity + ratio * (self._velocity - self._previous), void)
        velocity, pressure = self._solve(guess, first)
        self._rate = first * velocity + history
        self._previous, self._velocity, self._pressure = self._velocity, velocity, pressure
        self._void_fraction, self._last_step_s = void, step_s

    def _solve(self, guess: NDArray[np.float64], first: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Iterations about the newest velocity that convects, from a guess."""
        pressure = self._pressure
        left = 0.0
        for _ in range(self.case.nonlinear_iterations):
            velocity, pressure = self._equations.solve(guess, pressure)
            # A change du of what convects leaves rho (du.grad) u, which inertia rho du / dt turns into the next change.
            steepness = float(np.abs(self.grid.gradient(velocity)).max()) / first
            left = min(1.0, steepness) * float(np.abs(velocity - guess).max())
            if left <= self.case.nonlinear_tolerance * float(np.abs(velocity).max()):
                return velocity, pressure
            guess = velocity
        raise KratosFailed(
            f"velocities still change by about {left:.3g} m/s after {self.case.nonlinear_iterations} iterations at "
            f"{self.time_s:.6g} s: raise steps_per_window, or shorten the window"
        )

    def _checked_void_fraction(self, name: str, values: ArrayLike) -> NDArray[np.float64]:
        void = _checked(f"{name}.void_fraction", values, (self.grid.n,))
        least = self.case.least_void_fraction
        for bad, wrong in ((int(void.argmin()), void.min() < least), (int(void.argmax()), void.max() > 1 + 1e-9)):
            if wrong:
                where = ", ".join(f"{x:.4g}" for x in self.points_m[bad])
                raise KratosFailed(
                    f"{name}.void_fraction is {void[bad]:.4g} at point {bad} ({where}) m; allowed are {least} to 1: "
                    "a wider smoothing length or a coarser mesh evens it out"
                )
        return void

    def fluxes_m3_per_s(self) -> dict[str, float]:
        """Volume of fluid that leaves by each boundary, the integral of e u.n, m3/s."""
        sides = [side for side, kind in self.case.boundaries.items() if kind != "periodic"]
        return {side: self.grid.flux_m3_per_s(side, self._void_fraction, self._velocity) for side in sides}

    def statistics(self) -> dict[str, float]:
        """Linear solves so far, the time that they took, s, and the processor time of this process, s."""
        return {
            "solves": self._equations.solves,
            "solve_time_s": self._equations.solve_time_s,
            "processor_time_s": time.process_time(),
        }

    def save(self) -> KratosState:
        """A token for `restore`, in memory."""
        return KratosState(
            self.time_s,
            self._last_step_s,
            {
                "velocity": self._velocity.copy(),
                "previous_velocity": self._previous.copy(),
                "velocity_rate": self._rate.copy(),
                "pressure": self._pressure.copy(),
                "void_fraction": self._void_fraction.copy(),
            },
        )

    def restore(self, token: KratosState) -> None:
        """Back to a token.

        Raises:
            KratosFailed: a token of another mesh.
        """
        n = self.grid.n
        for name, values in token.arrays.items():
            _checked(f"state: {name}", values, (n,) if name in ("pressure", "void_fraction") else (n, 3))
        self.time_s, self._last_step_s = token.time_s, token.last_step_s
        arrays = {name: values.copy() for name, values in token.arrays.items()}
        self._velocity, self._previous = arrays["velocity"], arrays["previous_velocity"]
        self._rate, self._pressure = arrays["velocity_rate"], arrays["pressure"]
        self._void_fraction = arrays["void_fraction"]


def _checked(name: str, values: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    array = np.asarray(values, float)
    if array.shape != shape:
        raise KratosFailed(f"{name} has the shape {array.shape}; {shape} is needed")
    if not np.all(np.isfinite(array)):
        bad = int(np.argwhere(~np.isfinite(array))[0, 0])
        raise KratosFailed(f"{name} has a number that is not finite at point {bad}")
    return array


def _extent(grid: Grid) -> float:
    return float(np.ptp(grid.nodes_m, axis=0).max())


def _grid(case: KratosCase) -> Grid:
    if not isinstance(case.mesh, Box):
        grid = read_mdpa(case.mesh.path)
        periodic = [side for side, kind in case.boundaries.items() if kind == "periodic"]
        if periodic:
            raise KratosFailed(f"boundaries[{periodic[0]!r}] is 'periodic', which only a Box can be")
    else:
        missing = [side for side in SIDES if side not in case.boundaries]
        if missing:
            raise KratosFailed(f"boundaries has no entry for {', '.join(missing)} of the box")
        sides = np.array([case.boundaries[side] == "periodic" for side in SIDES]).reshape(3, 2)
        if np.any(sides[:, 0] != sides[:, 1]):
            raise KratosFailed("boundaries: both sides of an axis are 'periodic', or neither")
        grid = box_grid(case.mesh, sides[:, 0].tolist())
    unknown = [side for side in case.boundaries if side not in grid.groups]
    if unknown:
        raise KratosFailed(f"boundaries has {unknown[0]!r}, which the mesh has not; it has {sorted(grid.groups)}")
    return grid
