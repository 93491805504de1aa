"""Our own volume-averaged incompressible solver in two dimensions."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from ..fluid import Exchange, FluidFields, StructuredMesh
from . import staggered
from .staggered import Array, Axis, Convection, Kind

End = Literal["x_low", "x_high", "z_low", "z_high"]
Inflow = ArrayLike | Callable[[float], ArrayLike]
Start = Callable[[Array, Array], tuple[ArrayLike, ArrayLike]]

# Explicit midpoint rule: largest Courant number of the limited scheme, and of the viscous term (its bound is 0.5).
COURANT = 0.5
DIFFUSION = 0.4
MOST_STEPS = 100_000


@dataclass(frozen=True)
class _Source:
    """What particles do to one component, on the sides: push + part ramp - drag u, after this part of the window."""

    push: Array
    ramp: Array
    drag: Array


@dataclass(frozen=True)
class _Window:
    """What is given in a window; void fractions in the cells, their change in 1/s."""

    void_0: Array
    void_1: Array
    change: Array
    sources: tuple[_Source, _Source]

    def void(self, part: float) -> Array:
        """After this part of the window."""
        now: Array = self.void_0 + (self.void_1 - self.void_0) * part
        return now


class PlaneSolver:
    """A fluid in a plane: x and z, one cell in y.

    Model A (Gidaspow 1994; Zhou et al., J. Fluid Mech. 661 (2010) 482, set II), with the void fraction e given:

        de/dt + div(e u) = 0
        d(rho e u)/dt + div(rho e u u) = -e grad p + div(e tau) + e rho g + interaction + drag (u_seen - u)

    Marker-and-cell grid (Harlow and Welch, Phys. Fluids 8 (1965) 2182): velocities on the sides of the cells, pressure
    in their middle. Explicit midpoint rule for convection and viscosity; drag and pressure at the new time, and
    together: the projection knows the drag, so that a dense bed is as stable as none, and div(e u) = -de/dt holds to
    rounding. A window is divided into as many equal steps as stability asks for.

    Where the mesh's side is ``open`` fluid leaves freely, at pressure 0; where it is ``closed`` is a wall; where an
    inflow is given it enters, whatever the mesh says there: a plate that holds particles is ``closed`` with an inflow.

    The velocities of `fields` are those of the end of the window, pressure gradient and acceleration its means.

    Args:
        mesh: with one cell in y. Inflow, walls and y know nothing of friction in y.
        density_kg_per_m3: of the fluid.
        viscosity_pa_s: dynamic.
        inflow_m_per_s: by end (``x_low``, ``x_high``, ``z_low``, ``z_high``) the superficial velocity e u along the
            axis, so below 0 for what enters at a high end: a number, one per cell of that end, or a function of the
            time that gives either.
        walls: ``no_slip`` or ``slip``.
        gravity_m_per_s2: along x and z; its part of the pressure gradient is then in the field. Without it the
            hydrostatic pressure is left out: give the particles `Fluid(buoyancy=True)`.
        mean_gradient_pa_per_m: of the pressure along x and z, beside the one that is found: drives periodic flows.
        convection: ``limited``, ``upwind`` or ``central``.
        time_s: where it starts.

    Attributes:
        pressure_pa: in the cells, (counts[2], counts[0]), of the last step; its mean is 0 where nothing flows out.
            Beside the mean gradient.
        divergence_error_per_s: of the last window: largest ``|de/dt + div(e u)|``.
        momentum_error: of the last window: change of momentum less what came in by pressure, gravity, particles and
            through the ends, over the largest of them.
        momentum_n: of the last window: its parts, means, x and z: ``change``, ``pressure``, ``gravity``,
            ``interaction``, ``ends``.
        steps: taken in the last window.
    """

    def __init__(
        self,
        mesh: StructuredMesh,
        *,
        density_kg_per_m3: float,
        viscosity_pa_s: float,
        inflow_m_per_s: Mapping[End, Inflow] | None = None,
        walls: Literal["no_slip", "slip"] = "no_slip",
        gravity_m_per_s2: tuple[float, float] = (0.0, 0.0),
        mean_gradient_pa_per_m: tuple[float, float] = (0.0, 0.0),
        convection: Convection = "limited",
        time_s: float = 0.0,
    ) -> None:
        if mesh.counts[1] != 1:
            raise ValueError(f"the mesh has {mesh.counts[1]} cells in y; a plane has one")
        if not density_kg_per_m3 > 0:
            raise ValueError(f"density_kg_per_m3 is {density_kg_per_m3}; it must be above 0")
        if not viscosity_pa_s >= 0:
            raise ValueError(f"viscosity_pa_s is {viscosity_pa_s}; it must be at least 0")
        for name, value, choices in (("convection", convection, Convection), ("walls", walls, ("no_slip", "slip"))):
            allowed = choices if isinstance(choices, tuple) else get_args(choices)
            if value not in allowed:
                raise ValueError(f"{name} is {value!r}; there are {', '.join(allowed)}")
        self.mesh = mesh
        self.time_s = float(time_s)
        self._density, self._viscosity = float(density_kg_per_m3), float(viscosity_pa_s)
        self._convection: Convection = convection
        self._body = np.array(gravity_m_per_s2, float), np.array(mean_gradient_pa_per_m, float)
        self._inflow: dict[End, Inflow] = dict(inflow_m_per_s or {})
        self._x, self._z = self._axis("x", 0, walls), self._axis("z", 2, walls)
        shape = (self._z.count, self._x.count)
        self._factors: list[tuple[Array, Array, Any]] = []
        self.pressure_pa: Array = np.zeros(shape)
        self.divergence_error_per_s = self.momentum_error = 0.0
        self.momentum_n: dict[str, Array] = {}
        self._size_n: Array = np.zeros(2)
        self.steps = 0
        self._gradient: Array = np.broadcast_to(self._body[1] + self._density * self._body[0], (*shape, 2)).copy()
        self._acceleration: Array = np.zeros((*shape, 2))
        self._u: Array = np.zeros((shape[0], shape[1] + 1))
        self._w: Array = np.zeros((shape[0] + 1, shape[1]))
        self._begin(np.ones(shape), None)
        self._met = False

    def _axis(self, name: Literal["x", "z"], axis: int, walls: Kind) -> Axis:
        sides = self.mesh.sides[axis]
        ends: list[Kind] = []
        for side, end in zip((sides, sides) if isinstance(sides, str) else sides, ("low", "high"), strict=True):
            given = any(key == f"{name}_{end}" for key in self._inflow)
            if given and side == "periodic":
                raise ValueError(f"inflow_m_per_s has {name}_{end}, where the mesh is periodic")
            ends.append(
                "inflow" if given else "outflow" if side == "open" else walls if side == "closed" else "periodic"
            )
        known = get_args(End)
        for key in self._inflow:
            if key not in known:
                raise ValueError(f"inflow_m_per_s has {key!r}; there are {', '.join(known)}")
        return Axis(self.mesh.counts[axis], float(self.mesh.spacing_m[axis]), ends[0], ends[1])

    # What it starts from.

    def start(self, exchange: Exchange, velocity: Start | None = None) -> FluidFields:
        """The flow around the particles that are there, before the first window, which else begins with it.

        Args:
            exchange: its void fraction.
            velocity: of x and z, arrays in m, gives the interstitial velocity along both, m/s; without it the
                slowest flow that the ends allow. Made to fulfil continuity with particles at rest.
        """
        self._begin(self._void(exchange), velocity)
        self._met = True
        return self.fields()

    def _begin(self, void: Array, velocity: Start | None) -> None:
        x, z = self._x, self._z
        ex, ez = staggered.to_sides(void, x.periodic), staggered.to_sides(void.T, z.periodic).T
        u, w = np.zeros_like(self._u), np.zeros_like(self._w)
        if velocity is not None:
            low = np.array(self.mesh.origin_m)[[0, 2]]
            edges = [low[k] + axis.step_m * np.arange(axis.count + 1) for k, axis in enumerate((x, z))]
            middles = [(edge[1:] + edge[:-1]) / 2 for edge in edges]
            u[:] = velocity(*np.meshgrid(edges[0], middles[1]))[0]
            w[:] = velocity(*np.meshgrid(middles[0], edges[1]))[1]
        self._give_ends(u, w, ex, ez, self.time_s)
        # the smallest change of e u that fulfils continuity
        cx, cz = ex**2, ez**2
        pressure = self._project(u, w, (ex, ez), (cx, cz), np.zeros_like(void))
        self._u = u - np.where(x.free, ex * staggered.gradient(pressure, x), 0.0)
        self._w = w - np.where(z.free, ez.T * staggered.gradient(pressure.T, z), 0.0).T

    def fields(self) -> FluidFields:
        """The fluid now."""
        velocity = np.stack([staggered.to_cells(self._u), staggered.to_cells(self._w.T).T], axis=-1)
        du, dw = staggered.shear_gradients(self._u, self._w, self._x, self._z)
        curl = staggered.to_cells(staggered.to_cells(du - dw).T).T
        vorticity = np.zeros((self.mesh.n, 3))
        vorticity[:, 1] = curl.ravel()
        return FluidFields(
            velocity_m_per_s=self._vectors(velocity),
            pressure_gradient_pa_per_m=self._vectors(self._gradient),
            acceleration_m_per_s2=self._vectors(self._acceleration),
            vorticity_rad_per_s=vorticity,
        )

    def _vectors(self, plane: Array) -> Array:
        vectors = np.zeros((self.mesh.n, 3))
        vectors[:, [0, 2]] = plane.reshape(-1, 2)
        return vectors

    def _void(self, exchange: Exchange) -> Array:
        void = np.asarray(exchange.void_fraction, float)
        if void.shape != (self.mesh.n,):
            raise ValueError(f"the void fraction has the shape {void.shape}; the mesh has {self.mesh.n} cells")
        if not (void > 0).all():
            k = int(np.argmin(void > 0))
            raise ValueError(
                f"the void fraction of cell {k} is {void[k]:.3g}: no fluid is left; smooth over a longer length"
            )
        return void.reshape(self._z.count, self._x.count)

    def _give_ends(self, u: Array, w: Array, ex: Array, ez: Array, time_s: float) -> None:
        """Sets the velocities that are given, at walls and inflows."""
        for name, axis, sides, void in (("x", self._x, u, ex), ("z", self._z, w.T, ez.T)):
            for k, end, kind in ((0, "low", axis.low), (-1, "high", axis.high)):
                if kind in ("no_slip", "slip"):
                    sides[:, k] = 0.0
                elif kind == "inflow":
                    given = self._inflow[f"{name}_{end}"]  # type: ignore[index]
                    flux = np.asarray(given(time_s) if callable(given) else given, float)
                    if flux.shape not in ((), sides[:, k].shape):
                        raise ValueError(
                            f"inflow_m_per_s of {name}_{end} has the shape {flux.shape}; "
                            f"a number or one for each of the {len(sides)} cells there is needed"
                        )
                    sides[:, k] = flux / void[:, k]
                elif kind == "periodic":
                    # one side, two places
                    sides[:, -1] = sides[:, 0]

    # Windows.

    def advance(self, window_s: float, before: Exchange, after: Exchange) -> FluidFields:
        """Goes on by a window with what the particles did in it.

        Raises:
            ValueError: no fluid is left in a cell, or its volume changes where nothing flows out.
        """
        if not window_s > 0:
            raise ValueError(f"window_s is {window_s}; it must be above 0")
        void_0, void_1 = self._void(before), self._void(after)
        if not self._met:
            # until now it knew of no particles: they must not cost an acceleration
            self._begin(void_0, None)
            self._met = True
        window = _Window(void_0, void_1, (void_1 - void_0) / window_s, self._sources(after))
        self.steps, self.divergence_error_per_s = 0, 0.0
        self._gradient, self._acceleration = np.zeros_like(self._gradient), np.zeros_like(self._acceleration)
        self.momentum_n = {name: np.zeros(2) for name in ("change", "pressure", "gravity", "interaction", "ends")}
        self._size_n = np.zeros(2)
        done, start_s, shorter = 0.0, self.time_s, 1
        while done < 1.0:
            left = (1.0 - done) * window_s
            count = shorter * max(1, math.ceil(left / self._limit_s(self._u, self._w) - 1e-9))
            if count + self.steps > MOST_STEPS:
                raise ValueError(f"{count} steps would be needed for the rest of the window: the flow has run away")
            step_s, end = left / count, 1.0 if count == 1 else done + left / count / window_s
            half = self._half(step_s, window, (done, end))
            # the flow may have set off: then this step was too long
            if step_s > 2.0 * self._limit_s(*half):
                shorter *= 2
                continue
            self._whole(step_s, window, (done, end), half)
            done, shorter = end, 1
            self.steps += 1
            self.time_s = start_s + done * window_s
        self.time_s = start_s + window_s
        rest = sum((part for name, part in self.momentum_n.items() if name != "change"), -self.momentum_n["change"])
        largest = float(self._size_n.max())
        self.momentum_error = float(np.abs(rest).max()) / largest if largest > 0 else 0.0
        return self.fields()

    def _limit_s(self, u: Array, w: Array) -> float:
        """Longest stable step."""
        dx, dz = self._x.step_m, self._z.step_m
        rate = (float(np.abs(u).max()) / dx + float(np.abs(w).max()) / dz) / COURANT
        # 4/3: the normal stress where the void fraction varies
        spread = 4.0 / 3.0 * self._viscosity / self._density * (1.0 / dx**2 + 1.0 / dz**2) / DIFFUSION
        return 1.0 / max(rate, spread, 1e-300)

    def _sources(self, after: Exchange) -> tuple[_Source, _Source]:
        """For x and z."""
        for name in ("interaction_n_per_m3", "drag_kg_per_m3_s", "seen_velocity_m_per_s"):
            values = getattr(after, name)
            if values is not None and not np.isfinite(values).all():
                raise ValueError(f"{name} is not finite in cell {int(np.argwhere(~np.isfinite(values))[0][0])}")
        shape = (self._z.count, self._x.count)
        drag = np.asarray(after.drag_kg_per_m3_s, float).reshape(shape)
        now = staggered.to_cells(self._u), staggered.to_cells(self._w.T).T
        found = []
        for k, component, axis in ((0, 0, self._x), (1, 2, self._z)):
            push = np.asarray(after.interaction_n_per_m3, float)[:, component].reshape(shape)
            ramp = np.zeros(shape)
            if after.seen_velocity_m_per_s is not None:
                ramp = drag * (after.seen_velocity_m_per_s[:, component].reshape(shape) - now[k])
            # with the drag: what the mean over two sides smooths in the interaction cancels, and the sums agree
            parts = (push + drag * now[k], ramp, drag)
            found.append(_Source(*(staggered.to_sides(part.T if k else part, axis.periodic) for part in parts)))
        return found[0], found[1]

    def _transports(self, u: Array, w: Array, void: Array) -> tuple[staggered.Transport, staggered.Transport]:
        x, z = self._x, self._z
        qx = staggered.to_sides(void, x.periodic) * u
        qz = (staggered.to_sides(void.T, z.periodic) * w.T).T
        constants = self._density, self._viscosity, self._convection
        along_x = staggered.transport((u, w), (qx, qz), void, (x, z), *constants)
        return along_x, staggered.transport((w.T, u.T), (qz.T, qx.T), void.T, (z, x), *constants)

    def _half(self, step_s: float, window: _Window, place: tuple[float, float]) -> tuple[Array, Array]:
        """Velocities in the middle of a step."""
        x, z = self._x, self._z
        void, part = window.void(place[0]), 0.5 * (place[0] + place[1])
        moved = self._transports(self._u, self._w, void)
        # the flux of the window before carries here, and the void fraction of this one does not fit: advective form
        qx = staggered.to_sides(void, x.periodic) * self._u
        qz = (staggered.to_sides(void.T, z.periodic) * self._w.T).T
        excess = self._density * staggered.divergence(qx, qz, x, z)
        forces = (
            moved[0].convection + moved[0].viscosity + staggered.to_sides(excess, x.periodic) * self._u,
            moved[1].convection + moved[1].viscosity + staggered.to_sides(excess.T, z.periodic) * self._w.T,
        )
        middle = window.void(part)
        u, w, _ = self._solve(0.5 * step_s, (middle, middle), window, forces, part)
        return u, w

    def _solve(
        self,
        step_s: float,
        voids: tuple[Array, Array],
        window: _Window,
        forces: tuple[Array, Array],
        part: float,
    ) -> tuple[Array, Array, Array]:
        """Velocities and pressure after a step from those of now, in the given forces.

        With m = rho e_1 + drag h: u* = (rho e_0 u_0 + h (forces + interaction + drag u_seen)) / m, then
        u_1 = u* - e h / m grad p and div(e_1 u_1) = -de/dt, e being the mean of e_0 and e_1.
        """
        gravity, mean = self._body
        axes, starts = (self._x, self._z), (self._u, self._w.T)
        guessed, sides, slopes = [], [], []
        for k, (axis, velocity, force) in enumerate(zip(axes, starts, forces, strict=True)):
            e0, e1 = (staggered.to_sides(void.T if k else void, axis.periodic) for void in voids)
            source = window.sources[k]
            middle = 0.5 * (e0 + e1)
            pull = middle * (self._density * gravity[k] - mean[k])
            inertia = self._density * e1 + step_s * source.drag
            impulse = step_s * (force + pull + source.push + part * source.ramp)
            guessed.append((self._density * e0 * velocity + impulse) / inertia)
            sides.append(e1)
            slopes.append(step_s * middle / inertia)
        u, w = guessed[0], guessed[1].T.copy()
        ex, ez = sides[0], sides[1].T
        self._give_ends(u, w, ex, ez, self.time_s + step_s)
        c = ex * slopes[0], ez * slopes[1].T
        pressure = self._project(u, w, (ex, ez), c, window.change)
        u -= np.where(self._x.free, slopes[0] * staggered.gradient(pressure, self._x), 0.0)
        w -= np.where(self._z.free, slopes[1] * staggered.gradient(pressure.T, self._z), 0.0).T
        return u, w, pressure

    def _project(self, u: Array, w: Array, void: tuple[Array, Array], c: tuple[Array, Array], change: Array) -> Array:
        """The pressure with div(e u - c grad p) = -de/dt, in the cells."""
        x, z = self._x, self._z
        qx, qz = void[0] * u, void[1] * w
        right = -change - staggered.divergence(qx, qz, x, z)
        enclosed = "outflow" not in (x.low, x.high, z.low, z.high)
        if enclosed:
            # fluid that must go and cannot
            excess = float(right.mean())
            size = float(np.abs(change).mean() + np.abs(qx).mean() / x.step_m + np.abs(qz).mean() / z.step_m)
            if abs(excess) > 1e-10 + 1e-8 * size:
                raise ValueError(
                    f"no end is open, and {abs(excess):.3g} of the fluid's volume per second would have to "
                    f"{'come from' if excess > 0 else 'go'} elsewhere: open a side, or let in what goes out"
                )
            right = right - excess
        factors = next((f for a, b, f in self._factors if np.array_equal(a, c[0]) and np.array_equal(b, c[1])), None)
        if factors is None:
            factors = staggered.factorised(*c, x, z)
            # two per step length
            self._factors = [*self._factors[-3:], (c[0].copy(), c[1].copy(), factors)]
        pressure: Array = factors.solve(right.ravel()).reshape(right.shape)
        return pressure - pressure.mean() if enclosed else pressure

    def _whole(self, step_s: float, window: _Window, place: tuple[float, float], half: tuple[Array, Array]) -> None:
        """A step with the forces of its middle; adds its share of the window to gradient, acceleration and balance."""
        share = place[1] - place[0]
        voids = window.void(place[0]), window.void(place[1])
        moved = self._transports(*half, window.void(0.5 * (place[0] + place[1])))
        forces = moved[0].convection + moved[0].viscosity, moved[1].convection + moved[1].viscosity
        u, w, pressure = self._solve(step_s, voids, window, forces, place[1])
        x, z = self._x, self._z
        starts, ends, slope = (self._u, self._w.T), (u, w.T), (pressure, pressure.T)
        for k, axis in enumerate((x, z)):
            e0, e1 = (staggered.to_sides(void.T if k else void, axis.periodic) for void in voids)
            source = window.sources[k]
            middle = 0.5 * (e0 + e1)
            rate = self._density * (e1 * ends[k] - e0 * starts[k]) / step_s
            weight = middle * self._density * self._body[0][k]
            interaction = source.push + place[1] * source.ramp - source.drag * ends[k]
            # where the velocity is given, the pressure is what it takes
            needed = (forces[k] + weight + interaction - rate) / middle
            gradient = np.where(axis.free, staggered.gradient(slope[k], axis) + self._body[1][k], needed)
            acceleration = (rate - moved[k].convection) / (self._density * middle)
            for total, sides in ((self._gradient, gradient), (self._acceleration, acceleration)):
                cells = staggered.to_cells(sides)
                total[..., k] += share * (cells.T if k else cells)
            depth = self.mesh.spacing_m[1]
            volumes = axis.widths_m * (z, x)[k].step_m * depth
            parts = {"change": rate, "pressure": -middle * gradient, "gravity": weight, "interaction": interaction}
            for name, value in parts.items():
                self.momentum_n[name][k] += share * float((value * volumes).sum())
                self._size_n[k] += share * float((np.abs(value) * volumes).sum())
            self.momentum_n["ends"][k] += share * moved[k].through_ends * depth
            self._size_n[k] += share * moved[k].through_ends_size * depth
        self._u, self._w, self.pressure_pa = u, w, pressure
        ex, ez = staggered.to_sides(voids[1], x.periodic), staggered.to_sides(voids[1].T, z.periodic).T
        wrong = window.change + staggered.divergence(ex * u, ez * w, x, z)
        self.divergence_error_per_s = max(self.divergence_error_per_s, float(np.abs(wrong).max()))

    # What it goes back to.

    def save(self) -> dict[str, Any]:
        """A token to go back to."""
        return {
            "time_s": self.time_s,
            "u": self._u.copy(),
            "w": self._w.copy(),
            "pressure": self.pressure_pa.copy(),
            "gradient": self._gradient.copy(),
            "acceleration": self._acceleration.copy(),
            "met": self._met,
        }

    def restore(self, token: dict[str, Any]) -> None:
        """Goes back. What the last window reported stays as it is."""
        for name, now in (("u", self._u), ("w", self._w)):
            if np.shape(token[name]) != now.shape:
                raise ValueError(f"{name} of the saved plane has the shape {np.shape(token[name])}, here {now.shape}")
        self.time_s, self._met = float(token["time_s"]), bool(token["met"])
        self._u, self._w = np.array(token["u"]), np.array(token["w"])
        self.pressure_pa = np.array(token["pressure"])
        self._gradient, self._acceleration = np.array(token["gradient"]), np.array(token["acceleration"])

    def to_file(self, path: str | os.PathLike[str]) -> None:
        """Writes what `from_file` goes on from."""
        with open(path, "wb") as file:
            np.savez(file, **self.save())

    def from_file(self, path: str | os.PathLike[str]) -> None:
        """Takes over what `to_file` wrote."""
        with np.load(path) as saved:
            self.restore(dict(saved))
