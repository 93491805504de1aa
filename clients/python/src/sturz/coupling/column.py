"""Our own volume-averaged incompressible solver in one dimension."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..fluid import Exchange, FluidFields, StructuredMesh

Flux = float | Callable[[float], float]


class ColumnSolver:
    """A column of fluid along one axis: one cell across, n along.

    Continuity, de/dt + dq/dz = 0 with q = e u, leaves one unknown of the flow: the flux of fluid and solid together,
    J = e u + (1 - e) v, is the same everywhere along the column. It is the superficial velocity at the inlet, 0 in a
    closed column, and given in a periodic one. The fluid's velocity follows from it, and the pressure gradient from the
    momentum balance of model A (Gidaspow 1994; Zhou et al., J. Fluid Mech. 661 (2010) 482, set II),

        -e dp/dz = d(rho e u)/dt + d(rho q u)/dz - interaction(u) - e rho g,

    whose first two terms are rho e Du/Dt. No viscosity and no friction at walls: both are small beside particles.

    The velocities of `fields` are those of the end of the window, pressure gradient and acceleration its means.

    Args:
        mesh: more than one cell along `axis` only; its sides along it say whether the column is periodic.
        density_kg_per_m3: of the fluid.
        flux_m_per_s: J along the axis, a number or a function of the time: the superficial velocity of what flows in.
        gravity_m_per_s2: along the axis (below 0 where the axis points up); its part of the pressure gradient is then
            in the field. 0 leaves the hydrostatic pressure out: give the particles `Fluid(buoyancy=True)`.
        axis: of the column, 0, 1 or 2.
        time_s: where it starts.

    Attributes:
        pressure_pa: at the centres of the cells, 0 at the upper end, (n,). Periodic: the part beside the mean gradient.
        momentum_error: of the last window: momentum that came in, by pressure and by particles, less the change, over
            the largest of them.
        flux_through_sides_m_per_s: of the fluid through the n + 1 sides, mean over the last window.
    """

    def __init__(
        self,
        mesh: StructuredMesh,
        *,
        density_kg_per_m3: float,
        flux_m_per_s: Flux = 0.0,
        gravity_m_per_s2: float = 0.0,
        axis: Literal[0, 1, 2] = 2,
        time_s: float = 0.0,
    ) -> None:
        across = [count for k, count in enumerate(mesh.counts) if k != axis]
        if across != [1, 1]:
            raise ValueError(f"the mesh has {across} cells across axis {axis}; a column has one each way")
        if not density_kg_per_m3 > 0:
            raise ValueError(f"density_kg_per_m3 is {density_kg_per_m3}; it must be above 0")
        self.mesh = mesh
        self.time_s = float(time_s)
        self.momentum_error = 0.0
        self._axis = axis
        self._density = float(density_kg_per_m3)
        self._gravity = float(gravity_m_per_s2)
        self._flux: Callable[[float], float] = flux_m_per_s if callable(flux_m_per_s) else lambda _: float(flux_m_per_s)
        n = mesh.counts[axis]
        self._step = mesh.spacing_m[axis]
        self._periodic = mesh.sides[axis] == "periodic"
        self.pressure_pa = np.zeros(n)
        self.flux_through_sides_m_per_s = np.full(n + 1, self._flux(self.time_s))
        # interstitial velocity; of a column without particles until it hears of them
        self._velocity: NDArray[np.float64] = np.full(n, self._flux(self.time_s))
        self._gradient: NDArray[np.float64] = np.full(n, self._density * self._gravity)
        self._acceleration: NDArray[np.float64] = np.zeros(n)
        self._met = False

    def start(self, exchange: Exchange) -> FluidFields:
        """The flow around the particles that are there, before the first window, which else begins with it."""
        self._velocity = self._flow(exchange)
        self._met = True
        return self.fields()

    def fields(self) -> FluidFields:
        """The fluid now."""
        return FluidFields(
            velocity_m_per_s=self._along(self._velocity),
            pressure_gradient_pa_per_m=self._along(self._gradient),
            acceleration_m_per_s2=self._along(self._acceleration),
        )

    def _along(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        vectors = np.zeros((len(values), 3))
        vectors[:, self._axis] = values
        return vectors

    def _flow(self, exchange: Exchange) -> NDArray[np.float64]:
        """Velocity at the end of a window: J is the same everywhere."""
        void = exchange.void_fraction
        if (void <= 0).any():
            k = int(np.argmin(void))
            raise ValueError(
                f"the void fraction of cell {k} is {void[k]:.3g}: no fluid is left; smooth over a longer length"
            )
        solid = exchange.solid_velocity_m_per_s[:, self._axis]
        flow: NDArray[np.float64] = (self._flux(exchange.time_s) - (1.0 - void) * solid) / void
        return flow

    def advance(self, window_s: float, before: Exchange, after: Exchange) -> FluidFields:
        """Goes on by a window with what the particles did in it."""
        if not self._met:
            # until now it knew of no particles: they must not cost an acceleration
            self.start(before)
        void_0, void = before.void_fraction, after.void_fraction
        velocity_0, velocity = self._velocity, self._flow(after)
        middle = self._flux(self.time_s + 0.5 * window_s)
        # continuity, side by side from the lower end
        swelling = (void - void_0) * self._step / window_s
        through = np.concatenate([[0.0], -np.cumsum(swelling)])
        if self._periodic:
            mean_solid = 0.5 * sum(
                float(np.mean((1.0 - e.void_fraction) * e.solid_velocity_m_per_s[:, self._axis]))
                for e in (before, after)
            )
            through += middle - mean_solid - float(np.mean(through[:-1]))
        else:
            through += middle
        self.flux_through_sides_m_per_s = through
        # momentum, conservatively: the side's velocity is the mean of both cells
        centre = 0.5 * (velocity_0 + velocity)
        mean_void = 0.5 * (void_0 + void)
        # the void fraction goes on beyond the inlet: no jump of the velocity there, whose pressure is not the bed's
        inlet = through[0] / mean_void[0]
        low = np.roll(centre, 1) if self._periodic else np.concatenate([[inlet], centre[:-1]])
        side = np.concatenate(
            [0.5 * (low + centre), [0.5 * (centre[-1] + centre[0]) if self._periodic else centre[-1]]]
        )
        if not self._periodic:
            side[0] = inlet
        carried = self._density * through * side
        change = self._density * (void * velocity - void_0 * velocity_0) / window_s
        rate = change + np.diff(carried) / self._step
        seen = after.seen_velocity_m_per_s
        push = after.interaction_n_per_m3[:, self._axis].copy()
        if seen is not None:
            push += after.drag_kg_per_m3_s * (seen[:, self._axis] - velocity)
        weight = mean_void * self._density * self._gravity
        self._gradient = -(rate - push - weight) / mean_void
        self._acceleration = rate / (self._density * mean_void)
        self._velocity = velocity
        self._integrate_pressure()
        self.time_s += window_s
        # what came through the ends, not what went from cell to cell
        ends = 0.0 if self._periodic else float(carried[0] - carried[-1]) / self._step
        parts = (change, mean_void * self._gradient, -push, -weight)
        size = max(abs(ends), *(float(np.abs(part).sum()) for part in parts))
        rest = sum(float(part.sum()) for part in parts) - ends
        self.momentum_error = abs(rest) / size if size > 0 else 0.0
        return self.fields()

    def _integrate_pressure(self) -> None:
        """From the upper end, where it is 0, down; the side's gradient is the mean of both cells."""
        gradient = self._gradient - (np.mean(self._gradient) if self._periodic else 0.0)
        sides = 0.5 * (gradient[1:] + gradient[:-1]) * self._step
        top = -0.5 * self._step * gradient[-1]
        self.pressure_pa = np.concatenate([top - np.cumsum(sides[::-1])[::-1], [top]])

    def pressure_drop_pa(self, low_m: float, high_m: float) -> float:
        """Pressure at `low_m` less that at `high_m`, positions along the axis: the integral of the gradient."""
        centres = self.mesh.centres()[:, self._axis]
        ends = np.clip([low_m, high_m], centres[0] - 0.5 * self._step, centres[-1] + 0.5 * self._step)
        edges = np.linspace(centres[0] - 0.5 * self._step, centres[-1] + 0.5 * self._step, len(centres) + 1)
        integral = np.concatenate([[0.0], np.cumsum(self._gradient) * self._step])
        low, high = np.interp(ends, edges, integral)
        return float(low - high)

    def save(self) -> dict[str, Any]:
        """A token to go back to."""
        return {
            "time_s": self.time_s,
            "velocity": self._velocity.copy(),
            "gradient": self._gradient.copy(),
            "acceleration": self._acceleration.copy(),
            "pressure": self.pressure_pa.copy(),
            "through": self.flux_through_sides_m_per_s.copy(),
            "met": self._met,
        }

    def restore(self, token: dict[str, Any]) -> None:
        """Goes back."""
        if np.shape(token["velocity"]) != self._velocity.shape:
            raise ValueError(
                f"the saved column has {np.shape(token['velocity'])} cells, this one {self._velocity.shape}"
            )
        self.time_s, self._met = float(token["time_s"]), bool(token["met"])
        self._velocity = np.array(token["velocity"])
        self._gradient = np.array(token["gradient"])
        self._acceleration = np.array(token["acceleration"])
        self.pressure_pa = np.array(token["pressure"])
        self.flux_through_sides_m_per_s = np.array(token["through"])

    def to_file(self, path: str | os.PathLike[str]) -> None:
        """Writes what `from_file` goes on from."""
        with open(path, "wb") as file:
            np.savez(file, **self.save())

    def from_file(self, path: str | os.PathLike[str]) -> None:
        """Takes over what `to_file` wrote."""
        with np.load(path) as saved:
            self.restore(dict(saved))
