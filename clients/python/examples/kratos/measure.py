"""Accuracy and cost of the Kratos partner: prints the tables of docs/kratos.md.

`python measure.py` with Kratos installed in this interpreter; some minutes. `python measure.py cost`: only the times.
"""

from __future__ import annotations

import sys

import numpy as np
from numpy.typing import NDArray

from sturz.coupling import Exchange
from sturz.coupling.kratos import Box, Inlet, KratosCase, KratosProcess, KratosSolver

DENSITY, VISCOSITY, DIAMETER, VOID = 1000.0, 1e-3, 1e-3, 0.4


def column(speed: float, size: tuple[float, float, float], counts: tuple[int, int, int], cells: str) -> KratosCase:
    """Water that rises through a box with slip walls."""
    sides = dict.fromkeys(("x_low", "x_high", "y_low", "y_high"), "slip")
    boundaries = {**sides, "z_low": Inlet((0.0, 0.0, speed)), "z_high": "outlet"}
    return KratosCase(Box((0.0, 0.0, 0.0), size, counts, cells), boundaries, DENSITY, VISCOSITY)


def resting(velocity: NDArray[np.float64], void: NDArray[np.float64]) -> Exchange:
    """Resting spheres with Ergun's drag."""
    speed = np.linalg.norm(velocity, axis=1)
    viscous = 150 * VISCOSITY * (1 - void) ** 2 / (void * DIAMETER**2)
    beta = viscous + 1.75 * DENSITY * (1 - void) / DIAMETER * speed
    still = np.zeros_like(velocity)
    return Exchange(0.0, 0.0, void, still, -beta[:, None] * velocity, still, beta, seen_velocity_m_per_s=velocity)


def packed(cells: str) -> None:
    """Pressure gradient of a packed bed after 12 windows of 10 ms from rest."""
    for speed in (1e-3, 5e-3, 10e-3, 20e-3):
        solver = KratosSolver(column(speed, (0.01, 0.01, 0.02), (3, 3, 6), cells))
        void = np.full(solver.grid.n, VOID)
        for _ in range(12):
            bed = resting(solver.fields().velocity_m_per_s, void)
            gradient = -solver.advance(0.01, bed, bed).pressure_gradient_pa_per_m[:, 2]
        viscous = 150 * VISCOSITY * (1 - VOID) ** 2 / (VOID**3 * DIAMETER**2) * speed
        exact = viscous + 1.75 * DENSITY * (1 - VOID) / (VOID**3 * DIAMETER) * speed**2
        print(f"{cells:12s} U {speed:.3f} m/s: {gradient.mean():.3f} Pa/m, error {gradient.mean() / exact - 1:+.1e}")


def surface(cells: str, widths: float) -> None:
    """Error of e u at points about the surface of a bed, steady; widths of the surface in elements, 0: one element."""
    solver = KratosSolver(column(20e-3, (0.004, 0.004, 0.08), (2, 2, 40), cells))
    height = (solver.mesh.points_m[:, 2] - 0.04) / 0.002
    solid = 1 / (1 + np.exp(height / widths)) if widths > 0 else np.clip(0.5 - height, 0.0, 1.0)
    void = 1 - (1 - VOID) * solid
    for _ in range(30):
        bed = resting(solver.fields().velocity_m_per_s, void)
        velocity = solver.advance(0.01, bed, bed).velocity_m_per_s
    error = np.abs(void * velocity[:, 2] / 20e-3 - 1).max()
    side = np.abs(velocity[:, :2]).max() / 0.02
    print(f"{cells:12s} surface of {widths} elements: max |e u / U - 1| = {error:.4f}, sideways {side:.1e} U")


def cost(cells: str, counts: tuple[int, int, int]) -> None:
    """Processor time of a window of 2 ms over a bed that is not uniform, in a worker with one thread."""
    with KratosProcess(column(20e-3, (0.02, 0.02, 0.08), counts, cells)) as fluid:
        x, y, z = fluid.mesh.points_m.T
        solid = 0.55 / (1 + np.exp((z - 0.04) / 0.005)) * (1 + 0.1 * np.sin(300 * x) * np.sin(300 * y))
        velocity = fluid.fields().velocity_m_per_s
        before = fluid.statistics()
        for _ in range(4):
            bed = resting(velocity, 1 - solid)
            velocity = fluid.advance(2e-3, bed, bed).velocity_m_per_s
        after = fluid.statistics()
    spent = {name: after[name] - before[name] for name in after}
    print(
        f"{cells:12s} {counts}: {len(x)} points, {250 * spent['processor_time_s']:.0f} ms of processor a window, "
        f"{spent['solves'] / 4:.2f} solves a window, {1e3 * spent['processor_time_s'] / spent['solves']:.0f} ms a solve"
    )


def accuracy() -> None:
    """Packed beds and surfaces of beds."""
    for cells in ("hexahedra", "tetrahedra"):
        packed(cells)
    for cells in ("hexahedra", "tetrahedra"):
        for widths in (0.0, 0.5, 1.0, 1.5, 3.0):
            surface(cells, widths)


def main() -> None:
    """All tables; with the argument `cost` only the last."""
    if sys.argv[1:] != ["cost"]:
        accuracy()
    for cells in ("hexahedra", "tetrahedra"):
        for counts in ((4, 4, 16), (6, 6, 24), (8, 8, 32), (10, 10, 40)):
            cost(cells, counts)


if __name__ == "__main__":
    main()
