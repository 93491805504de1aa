"""Kratos in a process of its own, behind the methods of `KratosSolver`."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import tempfile
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import SturzError
from ..fluid import Exchange, FluidFields, PointMesh
from .kratos_case import KratosCase, KratosState
from .kratos_equations import KratosFailed, KratosMissing
from .kratos_grid import GridError
from .kratos_wire import decode, encode

_ERRORS = {"KratosFailed": KratosFailed, "KratosMissing": KratosMissing, "GridError": GridError}
_END_OF_LOG = 2000


class KratosDied(SturzError):
    """The worker ended or was ended; the text holds how, and the end of what it said. `restart` starts another."""


class KratosProcess:
    """A `FluidSolver` whose Kratos runs in another process, perhaps with another interpreter.

    Args:
        case: mesh, boundaries, fluid and time stepping.
        interpreter: a Python that has numpy and Kratos (sturz need not be installed there); this one when absent.
        timeout_s: longest time for an answer; a worker that takes longer is ended. Without limit when absent.
        log: file to which the worker's output is appended; a temporary one when absent.

    Raises:
        KratosMissing: that interpreter has no Kratos.
        KratosFailed, GridError: a case that cannot be run.
        KratosDied: the worker could not be started.
    """

    def __init__(
        self,
        case: KratosCase,
        interpreter: str | Path | None = None,
        timeout_s: float | None = None,
        log: str | Path | None = None,
    ) -> None:
        self.case = case
        self.time_s = 0.0
        self.mesh: PointMesh
        self._interpreter = str(interpreter or sys.executable)
        self._timeout_s = timeout_s
        self._log = Path(log) if log is not None else None
        self._inlets: dict[str, list[float]] = {}
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: Connection | None = None
        self._start()

    def _start(self) -> None:
        here, there = socket.socketpair()
        self._output: IO[bytes] = tempfile.TemporaryFile() if self._log is None else self._log.open("ab+")  # noqa: SIM115
        # Kratos prints to stdout from C++, so the messages need a channel of their own.
        command = [self._interpreter, str(Path(__file__).with_name("kratos_worker.py")), str(there.fileno())]
        environment = {**os.environ, "OMP_NUM_THREADS": str(self.case.threads)}
        try:
            self._process = subprocess.Popen(
                command,
                pass_fds=[there.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=self._output,
                stderr=subprocess.STDOUT,
                env=environment,
            )
        except OSError as error:
            here.close()
            raise KratosDied(f"the interpreter {self._interpreter} cannot be started: {error.strerror}") from error
        finally:
            there.close()
        self._connection = Connection(here.detach())
        try:
            _, arrays = self._ask({"call": "start", "case": self.case.to_json()})
        except SturzError:
            self.close()
            raise
        self.mesh = PointMesh(arrays["points_m"], arrays["volumes_m3"])

    @property
    def pid(self) -> int:
        """Process id of the worker."""
        if self._process is None:
            raise KratosDied("the worker of Kratos was closed")
        return self._process.pid

    def _ask(
        self, header: dict[str, Any], arrays: dict[str, NDArray[np.float64]] | None = None
    ) -> tuple[dict[str, Any], dict[str, NDArray[np.float64]]]:
        if self._connection is None:
            raise KratosDied("the worker of Kratos was closed or has died: restart() starts another")
        try:
            self._connection.send_bytes(encode(header, arrays))
            if not self._connection.poll(self._timeout_s):
                raise self._death(f"took longer than timeout_s = {self._timeout_s} s for {header['call']!r}")
            answer, values = decode(self._connection.recv_bytes())
        except (EOFError, OSError) as error:
            raise self._death(f"died during {header['call']!r}") from error
        if "error" in answer:
            kind = _ERRORS.get(answer["kind"], KratosFailed)
            raise kind(answer["error"])
        return answer, values

    def _death(self, what: str) -> KratosDied:
        """Ends the worker and says how it ended."""
        process = self._process
        assert process is not None, "a connection is open only while there is a process"
        try:
            process.wait(timeout=1.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        code = process.returncode
        how = f"signal {-code}" if code < 0 else f"exit status {code}"
        self._output.seek(0, os.SEEK_END)
        self._output.seek(max(0, self._output.tell() - _END_OF_LOG))
        said = self._output.read().decode(errors="replace").strip()
        pid = process.pid
        self.close()
        return KratosDied(
            f"the worker of Kratos (process {pid}, {how}) {what}; restart() goes on from a state that was saved. "
            f"The end of what it said:\n{said}"
        )

    def close(self) -> None:
        """Ends the worker; may be called twice."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None
        if self._process is not None:
            try:
                self._process.wait(timeout=5.0)  # it ends by itself when its socket closes
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
            self._process = None
            self._output.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def restart(self, state: KratosState | str | Path) -> None:
        """A new worker that goes on from a token of `save` or a file of `to_file`.

        Raises:
            KratosFailed: the state is not one of this case.
        """
        token = state if isinstance(state, KratosState) else KratosState.read(state)
        self.close()
        self._start()
        for side, velocity in self._inlets.items():
            self.set_inlet(side, velocity)
        self.restore(token)

    def fields(self) -> FluidFields:
        """The fluid now, at the points of `mesh`."""
        return FluidFields(**self._ask({"call": "fields"})[1])

    def advance(self, window_s: float, before: Exchange, after: Exchange) -> FluidFields:
        """As `KratosSolver.advance`.

        Raises:
            KratosFailed: unusable input, or a step that does not converge.
            KratosDied: the worker is gone.
        """
        sent = {
            "void_before": before.void_fraction,
            "void_after": after.void_fraction,
            "interaction_n_per_m3": after.interaction_n_per_m3,
            "drag_kg_per_m3_s": after.drag_kg_per_m3_s,
        }
        if after.seen_velocity_m_per_s is not None:
            sent["seen_velocity_m_per_s"] = after.seen_velocity_m_per_s
        arrays = {name: np.asarray(values, float) for name, values in sent.items()}
        answer, found = self._ask({"call": "advance", "window_s": window_s}, arrays)
        self.time_s = answer["time_s"]
        return FluidFields(**found)

    def save(self) -> KratosState:
        """A token for `restore`; it is held in this process, and outlives the worker."""
        answer, arrays = self._ask({"call": "save"})
        return KratosState(answer["time_s"], answer["last_step_s"], arrays)

    def restore(self, token: KratosState) -> None:
        """Back to a token."""
        header = {"call": "restore", "time_s": token.time_s, "last_step_s": token.last_step_s}
        self.time_s = self._ask(header, token.arrays)[0]["time_s"]

    def to_file(self, path: str | os.PathLike[str]) -> None:
        """All that decides its future, for `restart` and `from_file`."""
        self.save().write(path)

    def from_file(self, path: str | os.PathLike[str]) -> None:
        """Goes on from a file of `to_file`, in another worker if this one has died."""
        token = KratosState.read(path)
        if self._connection is None:
            self.restart(token)
        else:
            self.restore(token)

    def set_inlet(self, side: str, superficial_velocity_m_per_s: ArrayLike) -> None:
        """As `KratosSolver.set_inlet`; it holds for workers that are started again."""
        velocity = np.asarray(superficial_velocity_m_per_s, float).tolist()
        self._ask({"call": "set_inlet", "side": side, "superficial_velocity_m_per_s": velocity})
        self._inlets[side] = velocity

    @property
    def pressure_pa(self) -> NDArray[np.float64]:
        """Pressure at the points without its hydrostatic part, (n,), Pa."""
        return self._ask({"call": "pressure"})[1]["pressure_pa"]

    def fluxes_m3_per_s(self) -> dict[str, float]:
        """As `KratosSolver.fluxes_m3_per_s`."""
        return dict(self._ask({"call": "fluxes_m3_per_s"})[0]["result"])

    def statistics(self) -> dict[str, float]:
        """As `KratosSolver.statistics`."""
        return dict(self._ask({"call": "statistics"})[0]["result"])
