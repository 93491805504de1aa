"""What a Kratos partner is told: mesh, boundaries, fluid and time stepping; and the state that it saves."""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .kratos_equations import SOLVERS, KratosFailed
from .kratos_grid import Box, MdpaFile

_WALLS = ("slip", "no_slip", "outlet", "periodic")


@dataclass(frozen=True)
class Inlet:
    """A side through which fluid enters (or leaves) at a given rate.

    Attributes:
        superficial_velocity_m_per_s: e u, (3,), m/s; its flux through the side is met exactly.
    """

    superficial_velocity_m_per_s: tuple[float, float, float]


@dataclass(frozen=True)
class KratosCase:
    """A fluid and its container.

    Attributes:
        mesh: a `Box`, or an `MdpaFile`.
        boundaries: of a box, one entry for each of x_low, x_high, y_low, y_high, z_low, z_high; of a file, one for each
            sub model part that is a boundary. Values: an `Inlet`, "outlet" (no traction, so a pressure of 0), "slip"
            (only on sides across an axis), "no_slip", "periodic" (boxes, both sides of an axis). Where sides meet,
            no_slip goes before an inlet, and an inlet before slip.
        density_kg_per_m3: of the fluid.
        viscosity_pa_s: dynamic viscosity.
        gravity_m_per_s2: adds the hydrostatic rho g to the pressure gradient that particles see, and nothing else: the
            solved pressure is without it. Leave it at 0 where the run adds buoyancy itself.
        body_acceleration_m_per_s2: drives the fluid, (3,); for periodic channels.
        initial_velocity_m_per_s: interstitial, of the whole fluid at time 0.
        steps_per_window: time steps of the solver in each window.
        nonlinear_tolerance: iterations end when the next is expected to change velocities by less than this
            part of the largest speed.
        nonlinear_iterations: at most so many in a time step; more needed is an error.
        least_void_fraction: a smaller void fraction is refused.
        linear_solver: "amgcl" (iterative), or "lu" (direct, needs KratosLinearSolversApplication).
        threads: of Kratos; with one, the same input gives the same bits.
    """

    mesh: Box | MdpaFile
    boundaries: Mapping[str, str | Inlet]
    density_kg_per_m3: float
    viscosity_pa_s: float
    gravity_m_per_s2: tuple[float, float, float] = (0.0, 0.0, 0.0)
    body_acceleration_m_per_s2: tuple[float, float, float] = (0.0, 0.0, 0.0)
    initial_velocity_m_per_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
    steps_per_window: int = 1
    nonlinear_tolerance: float = 1e-4
    nonlinear_iterations: int = 20
    least_void_fraction: float = 0.1
    linear_solver: str = "amgcl"
    threads: int = 1

    def __post_init__(self) -> None:
        for name in ("density_kg_per_m3", "viscosity_pa_s", "nonlinear_tolerance", "least_void_fraction"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise KratosFailed(f"KratosCase.{name} is {value}; a positive number is needed")
        for name in ("steps_per_window", "nonlinear_iterations", "threads"):
            if getattr(self, name) < 1:
                raise KratosFailed(f"KratosCase.{name} is {getattr(self, name)}; at least 1 is needed")
        for name in ("gravity_m_per_s2", "body_acceleration_m_per_s2", "initial_velocity_m_per_s"):
            if np.shape(getattr(self, name)) != (3,) or not np.all(np.isfinite(getattr(self, name))):
                raise KratosFailed(f"KratosCase.{name} is {getattr(self, name)}; three finite numbers are needed")
        if self.linear_solver not in SOLVERS:
            raise KratosFailed(f"KratosCase.linear_solver is {self.linear_solver!r}; allowed are {sorted(SOLVERS)}")
        for side, kind in self.boundaries.items():
            if isinstance(kind, Inlet):
                velocity = kind.superficial_velocity_m_per_s
                if np.shape(velocity) != (3,) or not np.all(np.isfinite(velocity)):
                    raise KratosFailed(f"boundaries[{side!r}]: {velocity} is not a velocity of three finite numbers")
            elif kind not in _WALLS:
                raise KratosFailed(f"boundaries[{side!r}] is {kind!r}; allowed are an Inlet and {', '.join(_WALLS)}")

    def to_json(self) -> str:
        """For another process."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        values["mesh"] = {"kind": type(self.mesh).__name__, **asdict(self.mesh)}
        values["boundaries"] = {
            side: list(kind.superficial_velocity_m_per_s) if isinstance(kind, Inlet) else kind
            for side, kind in self.boundaries.items()
        }
        return json.dumps(values)

    @staticmethod
    def from_json(text: str) -> KratosCase:
        """The case that `to_json` wrote."""
        values: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in json.loads(text).items()}
        mesh: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in values.pop("mesh").items()}
        kind = {"Box": Box, "MdpaFile": MdpaFile}[mesh.pop("kind")]
        boundaries = {
            side: Inlet(tuple(value)) if isinstance(value, list) else value
            for side, value in values.pop("boundaries").items()
        }
        return KratosCase(mesh=kind(**mesh), boundaries=boundaries, **values)


_ARRAYS = ("velocity", "previous_velocity", "velocity_rate", "pressure", "void_fraction")


@dataclass(frozen=True)
class KratosState:
    """All that a solver needs to go on as if nothing had happened: the token of `save`. Arrays have a row per point.

    Attributes:
        time_s: simulated time.
        last_step_s: time step before; 0 at the start.
        arrays: velocity and previous_velocity (n, 3), m/s, of the last two steps; velocity_rate (n, 3), m/s2;
            pressure (n,), Pa; void_fraction (n,).
    """

    time_s: float
    last_step_s: float
    arrays: dict[str, NDArray[np.float64]] = field(repr=False)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Into a file (.npz), at once or not at all."""
        part = Path(f"{os.fspath(path)}.part")
        with part.open("wb") as file:
            columns: dict[str, Any] = {"times": np.array([self.time_s, self.last_step_s]), **self.arrays}
            np.savez(file, **columns)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)

    @staticmethod
    def read(path: str | os.PathLike[str]) -> KratosState:
        """From a file of `write`.

        Raises:
            KratosFailed: no such file, or not one of `write`.
        """
        try:
            with np.load(path, allow_pickle=False) as file:
                time_s, last_step_s = (float(value) for value in file["times"])
                return KratosState(time_s, last_step_s, {name: file[name] for name in _ARRAYS})
        except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
            raise KratosFailed(f"{path} is not a state of a Kratos solver: {error}") from error
