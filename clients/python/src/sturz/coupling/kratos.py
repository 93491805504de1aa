"""A fluid solved by Kratos Multiphysics as the partner of a coupled run, in this process or in one of its own.

`KratosSolver` needs Kratos in this interpreter; `KratosProcess` has the same methods and starts a worker with an
interpreter of its choice. docs/kratos.md says which equations are solved, and what was measured.

>>> from sturz.coupling.kratos import Box, Inlet, KratosCase, KratosProcess
>>> sides = dict.fromkeys(("x_low", "x_high", "y_low", "y_high"), "slip")
>>> case = KratosCase(
...     mesh=Box(origin_m=(0, 0, 0), size_m=(0.02, 0.02, 0.08), counts=(6, 6, 24)),
...     boundaries={**sides, "z_low": Inlet((0, 0, 0.01)), "z_high": "outlet"},
...     density_kg_per_m3=1000.0,
...     viscosity_pa_s=1e-3,
... )
>>> with KratosProcess(case) as fluid:  # doctest: +SKIP
...     print(fluid.mesh.points_m.shape, fluid.fields().velocity_m_per_s.shape)
"""

from __future__ import annotations

from .kratos_case import Inlet, KratosCase, KratosState
from .kratos_equations import KratosFailed, KratosMissing, load_kratos
from .kratos_grid import Box, GridError, MdpaFile
from .kratos_process import KratosDied, KratosProcess
from .kratos_solver import KratosSolver

__all__ = [
    "Box",
    "GridError",
    "Inlet",
    "KratosCase",
    "KratosDied",
    "KratosFailed",
    "KratosMissing",
    "KratosProcess",
    "KratosSolver",
    "KratosState",
    "MdpaFile",
    "load_kratos",
]
