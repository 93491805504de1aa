"""Particles and a fluid, marched in step: explicitly, or by iterating each window until both agree.

>>> from sturz.coupling import CoupledRun, Implicit, StructuredMesh  # doctest: +SKIP

`docs/coupling.md` takes you from nothing to a fluidised bed, and to a partner of your own.
"""

from ..fluid import Exchange, Fluid, FluidFields, Mesh, PointMesh, StructuredMesh
from .solver import FluidSolver

__all__ = [
    "Exchange",
    "Fluid",
    "FluidFields",
    "FluidSolver",
    "Mesh",
    "PointMesh",
    "StructuredMesh",
]
