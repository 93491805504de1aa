"""The particles as one side of a coupled run, in the verbs of preCICE."""

from __future__ import annotations

import dataclasses
import math
import secrets
from collections.abc import Mapping
from types import TracebackType
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import CommandError, SturzError
from .loads import Loads
from .simulation import Advanced, Simulation
from .state import State

DataName = Literal["positions", "orientations", "velocities", "angular_velocities"]
_READ: tuple[DataName, ...] = ("positions", "orientations", "velocities", "angular_velocities")
_WRITTEN = {
    "force_n": 3,
    "torque_n_m": 3,
    "drag_n_s_per_m": 1,
    "fluid_velocity_m_per_s": 3,
    "rotational_drag_n_m_s": 1,
    "fluid_angular_velocity_rad_per_s": 3,
}


class CouplingError(SturzError):
    """The verbs came in an order that makes no sense, or a window did not end as it should."""


class Participant:
    """A simulation that marches in step with another program, window by window.

    The other program reads where the particles are, writes the loads on them, and advances; both then stand at the end
    of the window::

        with sturz.launch("my-bed") as simulation:
            particles = sturz.Participant(simulation, window_s=1e-3, end_time_s=2.0)
            particles.initialize()
            while particles.is_coupling_ongoing():
                if particles.requires_writing_checkpoint():
                    fluid.save()
                fluid.solve(particles.read("positions"), particles.read("velocities"), particles.window_s)
                particles.write("force_n", fluid.forces())
                particles.advance()
                if particles.requires_reading_checkpoint():
                    fluid.go_back()
            particles.finalize()

    **Explicit** (default): each window is done once, with the loads written before it.

    **Implicit** (`converge` given): each window is repeated from its start, with the loads of the last iteration, until
    what is read at its end changes from one iteration to the next by no more than the relative tolerances. The
    particles go back to the bit; when `requires_reading_checkpoint` says so after `advance`, the other side must go
    back, too.
    `read` then still gives the end of the rejected iteration: it is what the next one starts from.

    The participant holds the lease of the simulation: nobody else can let its time go on.

    Args:
        simulation: connected.
        window_s: length of a window, s. The last one may be shorter.
        end_time_s: simulated time of the end; without end when absent.
        read: columns to read at the end of each window.
        converge: by column, the largest change relative to the values (both as the norm over all particles) that
            counts as converged.
        max_iterations: of an implicit window.

    Attributes:
        iterations: of the window that was ended last.
        changes: relative changes by column between its last two iterations.
    """

    def __init__(
        self,
        simulation: Simulation,
        *,
        window_s: float,
        end_time_s: float | None = None,
        read: tuple[DataName, ...] = ("positions", "velocities", "angular_velocities"),
        converge: Mapping[DataName, float] | None = None,
        max_iterations: int = 50,
    ) -> None:
        for name, value in (("window_s", window_s), ("end_time_s", math.inf if end_time_s is None else end_time_s)):
            if not value > 0:
                raise ValueError(f"{name} is {value}; it must be above 0")
        for name in (*read, *(converge or ())):
            if name not in _READ:
                raise ValueError(f"{name!r} cannot be read; there are {', '.join(_READ)}")
        for name, tolerance in (converge or {}).items():
            if not tolerance > 0:
                raise ValueError(f"converge[{name!r}] is {tolerance}; it must be above 0")
        if max_iterations < 2 and converge:
            raise ValueError(f"max_iterations is {max_iterations}; two is the least that can show a change")
        self.iterations = 0
        self.changes: dict[str, float] = {}
        self._simulation = simulation
        self._window_s = window_s
        self._end_time_s = end_time_s
        self._read = tuple(dict.fromkeys((*read, *(converge or ()))))
        self._converge = dict(converge or {})
        self._max_iterations = max_iterations
        self._token = f"window-{secrets.token_hex(4)}"
        self._start: State | None = None
        self._now: State | None = None
        self._written: dict[str, NDArray[np.float64]] = {}
        self._iteration = 0
        self._go_back = False
        self._completed = False

    def initialize(self) -> None:
        """Takes the lease, and reads where the particles are. The simulation must be paused."""
        if self._now is not None:
            raise CouplingError("the participant is initialized already")
        self._simulation.acquire_lease()
        self._start = self._now = self._simulation.state(columns=self._read)
        self._save()

    def _save(self) -> None:
        """At the start of a window; only what is repeated needs it."""
        self._iteration = 0
        if self._converge and self.is_coupling_ongoing():
            self._simulation.checkpoint(token=self._token)

    def _state(self) -> State:
        if self._now is None:
            raise CouplingError("initialize comes first")
        return self._now

    @property
    def ids(self) -> NDArray[np.uint64]:
        """Of the particles, in the order of all that is read and written, (n,)."""
        return self._state().ids

    @property
    def time_s(self) -> float:
        """Where the window under way starts, simulated time, s."""
        self._state()
        assert self._start is not None
        return self._start.time_s

    @property
    def window_s(self) -> float:
        """Length of the window under way, s: shorter at the end."""
        left = math.inf if self._end_time_s is None else self._end_time_s - self.time_s
        # what rounding leaves of a window is no window
        return left if left < self._window_s * (1 + 1e-9) else self._window_s

    def is_coupling_ongoing(self) -> bool:
        """Whether there is a window to do."""
        return self._end_time_s is None or self._end_time_s - self.time_s > 1e-9 * self._window_s

    def is_time_window_complete(self) -> bool:
        """Whether the last `advance` has ended a window for good."""
        return self._completed

    def requires_writing_checkpoint(self) -> bool:
        """Whether the other side must save itself now: a window starts that may be repeated."""
        return bool(self._converge) and self._iteration == 0 and self.is_coupling_ongoing()

    def requires_reading_checkpoint(self) -> bool:
        """Whether the other side must go back to the start of the window: it is repeated."""
        return self._go_back

    def read(self, name: DataName) -> NDArray[Any]:
        """A column of the particles at the end of the last `advance`, (n, 3) or (n, 4), by `ids`."""
        if name not in self._read:
            raise ValueError(f"{name!r} is not among what this participant reads: {', '.join(self._read)}")
        column: NDArray[Any] = self._state().columns[name]
        return column

    def write(self, name: str, values: ArrayLike) -> None:
        """Sets a column of the loads (see `Loads`) for the next `advance` and those after it.

        Args:
            name: ``force_n``, ``torque_n_m``, ``drag_n_s_per_m``, ``fluid_velocity_m_per_s``,
                ``rotational_drag_n_m_s``, ``fluid_angular_velocity_rad_per_s``.
            values: by `ids`, (n, 3), or (n,) for the drags.
        """
        components = _WRITTEN.get(name)
        if components is None:
            raise ValueError(f"{name!r} cannot be written; there are {', '.join(_WRITTEN)}")
        n = len(self.ids)
        shape = (n,) if components == 1 else (n, components)
        array = np.array(values, dtype=np.float64)
        if array.shape != shape:
            raise ValueError(f"{name} has the shape {array.shape}; {n} particles need {shape}")
        if not np.isfinite(array).all():
            raise ValueError(f"{name} has a value that is not finite at row {np.argwhere(~np.isfinite(array))[0][0]}")
        self._written[name] = array

    def advance(self) -> Advanced:
        """Goes to the end of the window with the loads written last, and reads there.

        Raises:
            CouplingError: the window was ended early, or has not converged within `max_iterations`.
            CommandError: the daemon refused; the particles are where they were.
        """
        now = self._state()
        if not self.is_coupling_ongoing():
            raise CouplingError(f"the end, {self._end_time_s} s, is reached")
        assert self._start is not None
        if self._go_back:
            self._simulation.restore(token=self._token)
            self._go_back = False
        loads = Loads(topology_epoch=self._start.header.topology_epoch, ids=self._start.ids) if self._written else None
        if loads is not None:
            loads = dataclasses.replace(loads, **self._written)  # type: ignore[arg-type]
        done = self._simulation.advance(
            window_s=self.window_s, from_time_s=self._start.time_s, columns=self._read, loads=loads
        )
        assert done.state is not None
        if done.stop_reason != "complete":
            raise CouplingError(f"the window ended early, at {done.time_reached_s} s: {done.stop_reason}")
        self._iteration += 1
        self._now = done.state
        self._completed = self._has_converged(now, done.state)
        if self._completed:
            self.iterations = self._iteration
            self._start = done.state
            self._save()
        elif self._iteration >= self._max_iterations:
            raise CouplingError(
                f"the window from {self._start.time_s} s has not converged in {self._iteration} iterations; "
                f"relative changes {self.changes}, wanted {self._converge}"
            )
        else:
            self._go_back = True
        return done

    def _has_converged(self, before: State, after: State) -> bool:
        """Against the iteration before; the first one has none."""
        if not self._converge:
            return True
        if self._iteration == 1:
            self.changes = dict.fromkeys(self._converge, math.inf)
            return False
        for name in self._converge:
            size = np.linalg.norm(after.columns[name])
            change = np.linalg.norm(after.columns[name] - before.columns[name])
            self.changes[name] = float(change / size) if size > 0 else float(change > 0)
        return all(self.changes[name] <= tolerance for name, tolerance in self._converge.items())

    def finalize(self) -> None:
        """Gives the lease back. The simulation stays connected, where it is. Twice is harmless."""
        if self._now is None:
            return
        if self._converge and any(saved.token == self._token for saved in self._simulation.checkpoints()):
            self._simulation.drop_checkpoint(token=self._token)
        try:
            self._simulation.release_lease()
        except CommandError as error:
            raise CouplingError(f"the lease was lost on the way: {error}") from error
        finally:
            self._now = self._start = None

    def __enter__(self) -> Self:
        self.initialize()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self.finalize()
        except SturzError:
            if error is None:
                raise
