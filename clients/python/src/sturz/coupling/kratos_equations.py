"""The linear system of one time step, built and solved by Kratos' element for flow through particles.

What the element of Kratos 10.4 solves, and why its density, its constitutive law and its mesh velocity are used here
for other things than their names say, is in docs/kratos.md.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import SturzError
from .kratos_grid import Grid

# First coefficient of Kratos' BDF2 for its constant fictitious step of 1 s: the inertia is density * this * u.
_INERTIA_PER_S = 1.5
# The element's tau is 1 / (4 mu / h^2 + 2 rho |a| / h) with h the cube root of its volume (measured, docs/kratos.md).
_TAU_VISCOUS = 4.0
_ELEMENTS = {8: "QSVMSDEMCoupled3D8N", 4: "QSVMSDEMCoupled3D4N"}
_VARIABLES = (
    "VELOCITY ACCELERATION MESH_VELOCITY PRESSURE DISPLACEMENT BODY_FORCE NODAL_AREA ADVPROJ DIVPROJ "
    "FLUID_FRACTION FLUID_FRACTION_RATE FLUID_FRACTION_GRADIENT PERMEABILITY REACTION REACTION_WATER_PRESSURE"
)
SOLVERS = {
    "amgcl": """{"solver_type": "amgcl", "smoother_type": "ilu0", "krylov_type": "gmres", "tolerance": 1e-10,
        "coarsening_type": "aggregation", "max_iteration": 500, "gmres_krylov_space_dimension": 100, "verbosity": 0,
        "provide_coordinates": false, "use_block_matrices_if_possible": true, "scaling": true}""",
    "lu": """{"solver_type": "LinearSolversApplication.sparse_lu"}""",
}


class KratosMissing(SturzError):
    """Kratos, or an application of it, is not installed in this interpreter."""


class KratosFailed(SturzError):
    """Kratos or the solver refused; the text says what, and what is allowed."""


def load_kratos() -> tuple[Any, Any]:
    """Kratos' core and its FluidDynamicsApplication.

    Raises:
        KratosMissing: it cannot be imported.
    """
    try:
        import KratosMultiphysics as core

        core.Logger.GetDefaultOutput().SetSeverity(core.Logger.Severity.WARNING)
        import KratosMultiphysics.FluidDynamicsApplication as fluid
    except ImportError as error:
        raise KratosMissing(f"Kratos cannot be imported ({error}): pip install 'sturz[kratos]'") from error
    return core, fluid


class Equations:
    """The model part, its elements and the solver; arrays of points in, arrays of points out.

    Args:
        grid: nodes, elements and points.
        viscosity_pa_s: of the fluid.
        linear_solver: a key of `SOLVERS`.
        threads: of Kratos.
    """

    def __init__(self, grid: Grid, viscosity_pa_s: float, linear_solver: str, threads: int) -> None:
        self._kratos, self._fluid = load_kratos()
        self._grid = grid
        self._viscosity = viscosity_pa_s
        self._kratos.ParallelUtilities.SetNumThreads(threads)
        self._model = self._kratos.Model()
        self._part = self._model.CreateModelPart("fluid")
        for name in _VARIABLES.split():
            self._part.AddNodalSolutionStepVariable(getattr(self._kratos, name))
        self._part.AddNodalSolutionStepVariable(self._fluid.MASS_SOURCE)
        self._part.SetBufferSize(3)
        self._build()
        self._strategy = self._make_strategy(linear_solver)
        self._refresh = self._kratos.ResidualBasedIncrementalUpdateStaticScheme()
        space = self._kratos.UblasSparseSpace()
        vectors = space.CreateEmptyVectorPointer(), space.CreateEmptyVectorPointer()
        self._no_system = (space.CreateEmptyMatrixPointer(), *vectors)
        self._adaptors: dict[str, Any] = {}
        self.solves = 0
        self.solve_time_s = 0.0

    def _build(self) -> None:
        kratos, part = self._kratos, self._part
        info = part.ProcessInfo
        info[kratos.DOMAIN_SIZE], info[kratos.OSS_SWITCH] = 3, 0
        info[kratos.DYNAMIC_TAU], info[kratos.DELTA_TIME] = 0.0, 1.0
        for index, (x, y, z) in enumerate(self._grid.nodes_m.tolist(), 1):
            part.CreateNewNode(index, x, y, z)
        for step in (1.0, 2.0, 3.0):  # fills the buffer, so that BDF2 sees a constant step of 1 s
            part.CloneTimeStep(step)
        name = _ELEMENTS[self._grid.cells.shape[1]]
        self._properties = []
        for index, cell in enumerate((self._grid.cells + 1).tolist(), 1):
            properties = part.CreateNewProperties(index)
            properties.SetValue(kratos.DYNAMIC_VISCOSITY, self._viscosity)
            properties.SetValue(kratos.CONSTITUTIVE_LAW, self._fluid.HerschelBulkley3DLaw())
            properties.SetValue(kratos.POWER_LAW_N, 1.0)
            properties.SetValue(kratos.YIELD_STRESS, 0.0)
            properties.SetValue(self._fluid.REGULARIZATION_COEFFICIENT, 1.0)
            part.CreateNewElement(name, index, cell, properties)
            self._properties.append(properties)
        zero = kratos.Matrix(3, 3)
        zero.fill(0.0)
        for node in part.Nodes:
            node.SetSolutionStepValue(kratos.PERMEABILITY, 0, zero)
        dofs = kratos.VariableUtils()
        for component in "XYZ":
            dofs.AddDof(getattr(kratos, f"VELOCITY_{component}"), getattr(kratos, f"REACTION_{component}"), part)
        dofs.AddDof(kratos.PRESSURE, kratos.REACTION_WATER_PRESSURE, part)
        self._tie_images()

    def _tie_images(self) -> None:
        """Periodic images follow the node that stands for their point, in every unknown."""
        kratos, grid = self._kratos, self._grid
        variables = [kratos.VELOCITY_X, kratos.VELOCITY_Y, kratos.VELOCITY_Z, kratos.PRESSURE]
        masters = grid.first_node[grid.owner]
        count = 0
        for image in np.flatnonzero(masters != np.arange(len(masters))):
            slave, master = self._part.Nodes[int(image) + 1], self._part.Nodes[int(masters[image]) + 1]
            for variable in variables:
                count += 1
                self._part.CreateNewMasterSlaveConstraint(
                    "LinearMasterSlaveConstraint", count, master, variable, slave, variable, 1.0, 0.0
                )

    def _make_strategy(self, linear_solver: str) -> Any:
        kratos = self._kratos
        if linear_solver not in SOLVERS:
            raise KratosFailed(f"linear_solver is {linear_solver!r}; allowed are {sorted(SOLVERS)}")
        if linear_solver == "lu":
            try:
                import KratosMultiphysics.LinearSolversApplication  # noqa: F401
            except ImportError as error:
                raise KratosMissing(f"linear_solver 'lu' needs KratosLinearSolversApplication ({error})") from error
        from KratosMultiphysics.python_linear_solver_factory import ConstructSolver

        builder = kratos.ResidualBasedBlockBuilderAndSolver(ConstructSolver(kratos.Parameters(SOLVERS[linear_solver])))
        scheme = self._fluid.BDF2TurbulentScheme()
        strategy = kratos.ResidualBasedLinearStrategy(self._part, scheme, builder, False, False, False, False)
        strategy.SetEchoLevel(0)
        strategy.SetRebuildLevel(1)
        return strategy

    def fix(self, points: NDArray[np.intp], component: int) -> None:
        """Holds a component (0 to 2: velocity, 3: pressure) at points; its values come with `solve`'s first guess."""
        variable = getattr(self._kratos, ("VELOCITY_X", "VELOCITY_Y", "VELOCITY_Z", "PRESSURE")[component])
        for node in self._grid.first_node[points]:
            self._part.Nodes[int(node) + 1].Fix(variable)

    def initialize(self) -> None:
        """To be called once, after all `fix`."""
        self._strategy.Initialize()

    def _write(self, name: str, values: NDArray[np.float64]) -> None:
        adaptor = self._adaptor(name)
        adaptor.data[...] = values[self._grid.owner]
        adaptor.StoreData()

    def _adaptor(self, name: str) -> Any:
        if name not in self._adaptors:
            variable = getattr(self._kratos, name)
            adaptors = self._kratos.TensorAdaptors
            self._adaptors[name] = adaptors.HistoricalVariableTensorAdaptor(self._part.Nodes, variable)
        return self._adaptors[name]

    def _read(self, name: str) -> NDArray[np.float64]:
        adaptor = self._adaptor(name)
        adaptor.CollectData()
        return np.array(adaptor.data)[self._grid.first_node]

    def set_void_fraction(
        self, fraction: NDArray[np.float64], rate: NDArray[np.float64], gradient: NDArray[np.float64]
    ) -> None:
        """Void fraction (n,), its rate (n,), 1/s, and its gradient (n, 3), 1/m."""
        self._write("FLUID_FRACTION", fraction)
        self._write("FLUID_FRACTION_RATE", rate)
        self._write("FLUID_FRACTION_GRADIENT", gradient)

    def set_inertia(
        self, resistance: NDArray[np.float64], inertia: float, density: float, target: NDArray[np.float64]
    ) -> None:
        """What multiplies the new velocity, and what it is pulled to.

        Args:
            resistance: drag per volume and velocity in the momentum equation divided by e, (M,), kg/(m3 s).
            inertia: density times the first coefficient of the time integration, kg/(m3 s).
            density: of the fluid, kg/m3.
            target: terms of the momentum equation without the new velocity, integrated over each point: (n, 3), N.
        """
        kratos, grid = self._kratos, self._grid
        total = inertia + resistance
        size = np.cbrt(grid.cell_volumes_m3)
        smoothing = self._viscosity + total * size**2 / _TAU_VISCOUS
        for properties, value, viscosity in zip(
            self._properties, (total / _INERTIA_PER_S).tolist(), smoothing.tolist(), strict=True
        ):
            properties.SetValue(kratos.DENSITY, value)
            properties.SetValue(kratos.POWER_LAW_K, viscosity)
        weight = grid.gather(grid.shares_m3 * total[:, None] / _INERTIA_PER_S)
        self._write("BODY_FORCE", grid.solve_mass(target, total / _INERTIA_PER_S))
        # The element convects `its density` times u - mesh velocity: this leaves the fluid's density times u.
        self._convected = density * grid.volumes_m3 / weight
        # The element reads BODY_FORCE only in this call, which the BDF2 scheme leaves out. The scheme also leaves out
        # the one that would set the element's subscale velocities: they stay 0, so there is no hidden state.
        self._refresh.InitializeNonLinIteration(self._part, *self._no_system)

    def solve(
        self, velocity: NDArray[np.float64], pressure: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """One linearised solution about a guess: velocities (n, 3) and pressures (n,)."""
        start = time.perf_counter()
        self._write("VELOCITY", velocity)
        self._write("PRESSURE", pressure)
        self._write("MESH_VELOCITY", velocity * (1.0 - self._convected)[:, None])
        self._write("ACCELERATION", _INERTIA_PER_S * velocity)
        self._strategy.InitializeSolutionStep()
        self._strategy.SolveSolutionStep()
        self._strategy.FinalizeSolutionStep()
        self.solves += 1
        self.solve_time_s += time.perf_counter() - start
        found = self._read("VELOCITY"), self._read("PRESSURE")
        if not (np.all(np.isfinite(found[0])) and np.all(np.isfinite(found[1]))):
            raise KratosFailed(
                "Kratos returned numbers that are not finite: try linear_solver='lu' or a shorter window"
            )
        return found
