"""Particles and a fluid solver, window by window."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
import os
import secrets
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from ..errors import CommandError, SturzError
from ..fluid import Exchange, Fluid, FluidFields
from ..participant import CouplingError
from ..simulation import Simulation
from .acceleration import Acceleration, Iqn
from .solver import FluidSolver

Column = Literal["velocity_m_per_s", "pressure_gradient_pa_per_m", "acceleration_m_per_s2", "vorticity_rad_per_s"]
_COLUMNS: tuple[Column, ...] = (
    "velocity_m_per_s",
    "pressure_gradient_pa_per_m",
    "acceleration_m_per_s2",
    "vorticity_rad_per_s",
)


class ParticleSide(Protocol):
    """The particles, as a coupled run needs them."""

    def exchange(self) -> Exchange:
        """What the fluid gets, now."""

    def advance(self, window_s: float, fields: FluidFields, ramp: bool) -> Exchange:
        """Goes on by a window in these fields, held, or reached linearly at its end out of those before."""

    def save(self) -> Any:
        """A token to go back to, in memory."""

    def restore(self, token: Any) -> None:
        """Goes back, to the bit."""

    def forget(self, token: Any) -> None:
        """A token that nobody goes back to any more."""


class DaemonParticles:
    """The particles of a daemon. It must be paused.

    Args:
        simulation: connected.
    """

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation
        self._name = f"window-{secrets.token_hex(4)}"

    def exchange(self) -> Exchange:
        """What the fluid gets, now."""
        return self.simulation.exchange()

    def advance(self, window_s: float, fields: FluidFields, ramp: bool) -> Exchange:
        """Goes on by a window.

        Raises:
            CouplingError: it ended early.
        """
        done = self.simulation.advance(window_s=window_s, fluid=fields, fluid_ramp=ramp, exchange=True)
        if done.stop_reason != "complete":
            raise CouplingError(f"the window ended early, at {done.time_reached_s} s: {done.stop_reason}")
        if done.exchange is None:
            raise CouplingError("the daemon sent no exchange: the fluid was taken away by somebody else")
        return done.exchange

    def save(self) -> str:
        """A checkpoint in the daemon's memory, instead of the one before."""
        return self.simulation.checkpoint(token=self._name).token

    def restore(self, token: str) -> None:
        """Goes back to it."""
        self.simulation.restore(token=token)

    def forget(self, token: str) -> None:
        """Drops it, if it is there."""
        if any(saved.token == token for saved in self.simulation.checkpoints()):
            self.simulation.drop_checkpoint(token=token)


@dataclass(frozen=True)
class Explicit:
    """Each window once: the particles in the fluid of its start, then the fluid with what they did.

    First order in the window. Unstable where the fluid that particles carry along outweighs them.
    """


@dataclass(frozen=True)
class Implicit:
    """Each window again from its start, until the fluid at its end is the one that the particles saw.

    Second order in the window.

    Attributes:
        acceleration: how the next guess is made: `Iqn`, `Aitken` or `Relaxation`.
        tolerance: largest difference of what was guessed and what was found, over what was found, for each column of
            the fluid's fields.
        max_iterations: then the window fails, and both sides are at its start.
        extrapolate: the first guess goes on as the window before did, instead of standing still.
    """

    acceleration: Acceleration = dataclasses.field(default_factory=Iqn)
    tolerance: float = 1e-6
    max_iterations: int = 30
    extrapolate: bool = True

    def __post_init__(self) -> None:
        if not self.tolerance > 0:
            raise ValueError(f"tolerance is {self.tolerance}; it must be above 0")
        if self.max_iterations < 2:
            raise ValueError(f"max_iterations is {self.max_iterations}; two is the least that can show a difference")


@dataclass(frozen=True)
class WindowReport:
    """What became of a window.

    Attributes:
        time_s: its end.
        iterations: 1 when explicit.
        residuals: after each iteration, the largest over the columns, relative.
        lag: change of the fluid over the window that the particles did not see, relative: 0 when converged.
        momentum_error: impulse that the particles lost to the fluid less what the cells got, over the larger of both;
            NaN where the particles do not say.
        solid_volume_error: volume of the particles in the mesh less what the cells have, relative; NaN likewise.
        wall_s: seconds spent by ``particles`` (with the bus), ``solver`` and ``saving``.
    """

    time_s: float
    iterations: int
    residuals: tuple[float, ...]
    lag: float
    momentum_error: float
    solid_volume_error: float
    wall_s: dict[str, float]


def _pack(fields: FluidFields, columns: Sequence[Column]) -> NDArray[np.float64]:
    return np.concatenate([np.asarray(getattr(fields, name), float).ravel() for name in columns])


def _unpack(vector: NDArray[np.float64], like: FluidFields, columns: Sequence[Column]) -> FluidFields:
    parts = np.split(vector, len(columns))
    shape = np.shape(like.velocity_m_per_s)
    return FluidFields(**{name: part.reshape(shape) for name, part in zip(columns, parts, strict=True)})


class CoupledRun:
    """Particles and a fluid solver that march in step.

    >>> with CoupledRun(simulation, solver, fluid=Fluid(1000, 1e-3, smoothing_length_m=3e-3)) as run:  # doctest: +SKIP
    ...     while run.time_s < 1.0:
    ...         report = run.advance(1e-3)

    It holds the lease of the simulation: nobody else lets its time go on.

    Args:
        simulation: connected and paused, or anything that is a `ParticleSide`.
        solver: of the fluid; its mesh becomes that of the exchange. Where it has a method `start(exchange)` that
            returns the fluid around the particles that are there, the run begins with that.
        fluid: density, viscosity, smoothing length and laws.
        scheme: `Explicit()` or `Implicit(...)`.
        solver_substeps: equal parts of a window that the solver does it in, with the same sources.

    Attributes:
        exchange: of the last window.
        fields: of the fluid now.
        windows: done.
    """

    def __init__(
        self,
        simulation: Simulation | ParticleSide,
        solver: FluidSolver,
        *,
        fluid: Fluid | None = None,
        scheme: Explicit | Implicit | None = None,
        solver_substeps: int = 1,
    ) -> None:
        if solver_substeps < 1:
            raise ValueError(f"solver_substeps is {solver_substeps}; 1 is the least")
        self.solver = solver
        self.scheme = scheme or Explicit()
        self.windows = 0
        self._substeps = solver_substeps
        self._simulation = simulation if isinstance(simulation, Simulation) else None
        self._particles = DaemonParticles(simulation) if isinstance(simulation, Simulation) else simulation
        self._before: tuple[FluidFields, float] | None = None
        self._apart = False
        self._wall: dict[str, float] = {}
        self.fields = solver.fields()
        self._columns = tuple(name for name in _COLUMNS if getattr(self.fields, name) is not None)
        if self._simulation is not None:
            if fluid is None:
                raise ValueError("fluid is missing: density, viscosity, smoothing length and laws")
            self._simulation.acquire_lease()
            try:
                self._begin(self._simulation, dataclasses.replace(fluid, mesh=solver.mesh))
            except BaseException:
                self._simulation.release_lease()
                raise
        self.exchange = self._particles.exchange()

    def _begin(self, simulation: Simulation, fluid: Fluid) -> None:
        """The fluid around the particles that are there, where the solver can begin with it."""
        simulation.set_fluid(fluid, fields=self.fields)
        start = getattr(self.solver, "start", None)
        if start is not None:
            self.fields = start(self._particles.exchange())
            simulation.set_fluid(fluid, fields=self.fields)

    @property
    def time_s(self) -> float:
        """Where both stand."""
        return self.exchange.time_s

    def advance(self, window_s: float) -> WindowReport:
        """Both go on by a window.

        Raises:
            CouplingError: it ended early, did not converge, or the solver's fields are not finite. After an implicit
                window that fails, for whatever reason, both sides are at its start; after an explicit one they are
                apart, and only `resume` goes on.
        """
        if not window_s > 0:
            raise ValueError(f"window_s is {window_s}; it must be above 0")
        if self._apart:
            raise CouplingError("particles and fluid are apart since a window failed: resume what was saved")
        self._wall = {"particles": 0.0, "solver": 0.0, "saving": 0.0}
        start = self.fields
        if isinstance(self.scheme, Implicit):
            after, found, residuals = self._iterate(window_s, self.scheme)
            lag = residuals[-1]
        else:
            self._apart = True
            after = self._timed("particles", self._particles.advance, window_s, start, False)
            after = dataclasses.replace(after, seen_velocity_m_per_s=start.velocity_m_per_s)
            found = self._solve(window_s, after)
            self._apart = False
            residuals, lag = [], self._difference(found, start)
        report = WindowReport(
            time_s=after.time_s,
            iterations=max(len(residuals), 1),
            residuals=tuple(residuals),
            lag=lag,
            momentum_error=self._momentum_error(after),
            solid_volume_error=self._volume_error(after),
            wall_s=self._wall,
        )
        self._before = (start, window_s)
        self.fields, self.exchange = found, after
        self.windows += 1
        return report

    def _timed(self, stage: str, function: Any, *arguments: Any) -> Any:
        begun = time.perf_counter()
        try:
            return function(*arguments)
        finally:
            self._wall[stage] += time.perf_counter() - begun

    def _solve(self, window_s: float, after: Exchange) -> FluidFields:
        before, part = self.exchange, window_s / self._substeps
        ends = [self._between(before, after, k / self._substeps, window_s) for k in range(self._substeps)] + [after]
        parts = [
            self._timed("solver", self.solver.advance, part, first, last) for first, last in itertools.pairwise(ends)
        ]
        for name in self._columns:
            broken = np.argwhere(~np.isfinite(getattr(parts[-1], name)))
            if len(broken):
                raise CouplingError(f"the solver's {name} is not finite in row {broken[0][0]} at {after.time_s} s")
        # velocities are states, these are means over the window
        means = {
            name: np.mean([getattr(each, name) for each in parts], axis=0)
            for name in ("pressure_gradient_pa_per_m", "acceleration_m_per_s2")
            if name in self._columns and len(parts) > 1
        }
        found: FluidFields = dataclasses.replace(parts[-1], **means)
        return found

    def _between(self, before: Exchange, after: Exchange, part: float, window_s: float) -> Exchange:
        """The end of a part of a window: the sources are those of all of it."""

        def mix(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
            return a + (b - a) * part

        seen = after.seen_velocity_m_per_s
        return dataclasses.replace(
            after if part > 0 else before,
            time_s=after.time_s - window_s * (1.0 - part),
            void_fraction=mix(before.void_fraction, after.void_fraction),
            solid_velocity_m_per_s=mix(before.solid_velocity_m_per_s, after.solid_velocity_m_per_s),
            seen_velocity_m_per_s=None if seen is None else mix(self.fields.velocity_m_per_s, seen),
        )

    def _guess(self, window_s: float, scheme: Implicit) -> NDArray[np.float64]:
        now = _pack(self.fields, self._columns)
        if self._before is None or not scheme.extrapolate:
            return now
        fields, length = self._before
        return now + (now - _pack(fields, self._columns)) * (window_s / length)

    def _iterate(self, window_s: float, scheme: Implicit) -> tuple[Exchange, FluidFields, list[float]]:
        particles = self._timed("saving", self._particles.save)
        solver = self._timed("saving", self.solver.save)
        try:
            return self._iterations(window_s, scheme, particles, solver)
        except BaseException:
            # a partner that died cannot go back
            self._apart = True
            self._particles.restore(particles)
            self.solver.restore(solver)
            self._apart = False
            raise

    def _iterations(
        self, window_s: float, scheme: Implicit, particles: Any, solver: Any
    ) -> tuple[Exchange, FluidFields, list[float]]:
        scheme.acceleration.reset()
        guess, residuals = self._guess(window_s, scheme), list[float]()
        # the same for all iterations of a window
        scale: NDArray[np.float64] | None = None
        while True:
            seen = _unpack(guess, self.fields, self._columns)
            after = self._timed("particles", self._particles.advance, window_s, seen, True)
            after = dataclasses.replace(after, seen_velocity_m_per_s=seen.velocity_m_per_s)
            found = self._solve(window_s, after)
            residuals.append(self._difference(found, seen))
            if residuals[-1] <= scheme.tolerance:
                return after, found, residuals
            if len(residuals) >= scheme.max_iterations:
                raise CouplingError(
                    f"the window from {self.exchange.time_s} s has not converged in {len(residuals)} iterations: "
                    f"residual {residuals[-1]:.3g}, wanted {scheme.tolerance:.3g}; both sides are at its start. "
                    "Shorten the window, or give another acceleration"
                )
            self._timed("saving", self._particles.restore, particles)
            self._timed("saving", self.solver.restore, solver)
            if scale is None:
                scale = self._scales(found)
            guess = scale * scheme.acceleration.next(guess / scale, (_pack(found, self._columns) - guess) / scale)

    def _scales(self, found: FluidFields) -> NDArray[np.float64]:
        """Size of each column, so that all count alike."""
        sizes = [
            max(float(np.sqrt(np.mean(np.square(getattr(fields, name))))) for fields in (self.fields, found))
            for name in self._columns
        ]
        return np.repeat([size if size > 0 else 1.0 for size in sizes], 3 * len(found.velocity_m_per_s))

    def _difference(self, found: FluidFields, seen: FluidFields) -> float:
        """The largest over the columns, relative to what was found or, if that is more, to what it was before."""
        worst = 0.0
        for name in self._columns:
            a, b, now = (getattr(fields, name) for fields in (found, seen, self.fields))
            size = max(float(np.linalg.norm(a)), float(np.linalg.norm(now)))
            change = float(np.linalg.norm(a - b))
            worst = max(worst, change / size if size > 0 else float(change > 0))
        return worst

    def _momentum_error(self, after: Exchange) -> float:
        if "impulse_on_fluid_n_s" not in after.totals:
            return math.nan
        window_s = after.time_s - after.from_time_s
        cells = (after.interaction_n_per_m3 * self.solver.mesh.volumes_m3[:, None]).sum(axis=0) * window_s
        total = np.asarray(after.totals["impulse_on_fluid_n_s"])
        size = max(float(np.abs(cells).max()), float(np.abs(total).max()))
        return float(np.abs(cells - total).max()) / size if size > 0 else 0.0

    def _volume_error(self, after: Exchange) -> float:
        solid = float(((1.0 - after.void_fraction) * self.solver.mesh.volumes_m3).sum())
        total = after.totals.get("immersed_volume_m3", math.nan)
        if math.isnan(total):
            return math.nan
        return abs(solid - total) / total if total > 0 else abs(solid)

    # What outlives either side.

    def save_to(self, folder: str | os.PathLike[str]) -> Path:
        """Writes both sides, so that `resume` can go on from here after either has died.

        The particles go to a checkpoint on the daemon's disk (it must have a folder for them), the fluid to a file of
        its solver (`to_file`), and last, atomically, the file that names both. A save that was cut short is never gone
        on from.

        Args:
            folder: made if need be.

        Returns:
            The file that names both.
        """
        if self._simulation is None:
            raise CouplingError("only the particles of a daemon can be saved")
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        stem = f"window-{self.windows}-{secrets.token_hex(3)}"
        checkpoint = self._simulation.checkpoint(token=stem, on_disk=True)
        self.solver.to_file(folder / f"{stem}.fluid.npz")
        # what the next first guess is made of
        fields, length_s = self._before or (self.fields, 0.0)
        columns = {name: getattr(fields, name) for name in self._columns}
        with (folder / f"{stem}.before.npz").open("wb") as before:
            np.savez(before, length_s=length_s, **columns)
        names = {
            "windows": self.windows,
            "time_s": self.time_s,
            "checkpoint": checkpoint.token,
            "fluid": f"{stem}.fluid.npz",
            "before": f"{stem}.before.npz",
        }
        written = folder / "latest.json.new"
        with written.open("w") as file:
            json.dump(names, file, indent=1)
            file.flush()
            os.fsync(file.fileno())
        return written.rename(folder / "latest.json")

    def resume(self, folder: str | os.PathLike[str]) -> None:
        """Both go back to the last `save_to`: with the same solver, or with another one of the same mesh.

        Raises:
            CouplingError: nothing was saved there.
        """
        if self._simulation is None:
            raise CouplingError("only the particles of a daemon can be resumed")
        latest = Path(folder) / "latest.json"
        try:
            names = json.loads(latest.read_text())
        except FileNotFoundError:
            raise CouplingError(f"{latest} is not there: nothing was saved") from None
        self.solver.from_file(Path(folder) / names["fluid"])
        self._simulation.restore(token=names["checkpoint"])
        self.windows = names["windows"]
        self.fields = self.solver.fields()
        with np.load(Path(folder) / names["before"]) as before:
            length_s = float(before["length_s"])
            fields = FluidFields(**{name: before[name] for name in self._columns})
        self._before = (fields, length_s) if length_s > 0 else None
        self._apart = False
        self.exchange = self._particles.exchange()

    def close(self) -> None:
        """Gives the lease back; both sides stay where they are. Twice is harmless."""
        simulation, self._simulation = self._simulation, None
        if simulation is None:
            return
        if isinstance(self._particles, DaemonParticles):
            self._particles.forget(self._particles._name)
        try:
            simulation.release_lease()
        except CommandError as error:
            raise CouplingError(f"the lease was lost on the way: {error}") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self.close()
        except SturzError:
            if error is None:
                raise
