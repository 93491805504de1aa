"""Particles and a fluid, marched in step: explicitly, or by iterating each window until both agree.

>>> from sturz.coupling import ColumnSolver, CoupledRun, Fluid, Implicit  # doctest: +SKIP

`docs/coupling.md` takes you from nothing to a fluidised bed, and to a partner of your own.
"""

from ..fluid import Exchange, Fluid, FluidFields, Mesh, PointMesh, StructuredMesh
from .acceleration import Acceleration, Aitken, Iqn, Relaxation
from .column import ColumnSolver
from .plane import PlaneSolver
from .run import CoupledRun, Explicit, Implicit, ParticleSide, WindowReport
from .solver import FluidSolver

__all__ = [
    "Acceleration",
    "Aitken",
    "ColumnSolver",
    "CoupledRun",
    "Exchange",
    "Explicit",
    "Fluid",
    "FluidFields",
    "FluidSolver",
    "Implicit",
    "Iqn",
    "Mesh",
    "ParticleSide",
    "PlaneSolver",
    "PointMesh",
    "Relaxation",
    "StructuredMesh",
    "WindowReport",
]
