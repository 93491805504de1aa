"""A bed of water and resting particles in a box, the water solved by Kratos; the skeleton of a fluidised bed.

`python fixed_bed.py` runs the fluid alone against a bed that is only a void fraction and Ergun's drag, and prints the
pressure drop beside Ergun's. `python fixed_bed.py --scene BED.toml` puts the particles of a Sturz scene there instead.
"""

from __future__ import annotations

import argparse

import numpy as np
from numpy.typing import NDArray

from sturz.coupling import Exchange
from sturz.coupling.kratos import Box, Inlet, KratosCase, KratosProcess

DENSITY_KG_PER_M3, VISCOSITY_PA_S, DIAMETER_M = 1000.0, 1e-3, 1e-3
SIZE_M, BED_M, VOID = (0.02, 0.02, 0.08), 0.04, 0.4


def water(speed_m_per_s: float, counts: tuple[int, int, int], steps: int) -> KratosCase:
    """Water that rises through the box; elements of about three particle diameters."""
    sides = dict.fromkeys(("x_low", "x_high", "y_low", "y_high"), "slip")
    return KratosCase(
        mesh=Box(origin_m=(0.0, 0.0, 0.0), size_m=SIZE_M, counts=counts),
        boundaries={**sides, "z_low": Inlet((0.0, 0.0, speed_m_per_s)), "z_high": "outlet"},
        density_kg_per_m3=DENSITY_KG_PER_M3,
        viscosity_pa_s=VISCOSITY_PA_S,
        gravity_m_per_s2=(0.0, 0.0, -9.81),  # particles feel buoyancy through the pressure gradient
        steps_per_window=steps,
    )


def void_fraction(height_m: NDArray[np.float64], width_m: float) -> NDArray[np.float64]:
    """Of a bed whose surface is so wide; at heights over the floor."""
    return 1 - (1 - VOID) / (1 + np.exp((height_m - BED_M) / width_m))


def ergun(void: NDArray[np.float64], speed: NDArray[np.float64]) -> NDArray[np.float64]:
    """Drag beta, kg/(m3 s), at interstitial speeds (Chem. Eng. Prog. 48, 89, 1952): e grad p = -beta u."""
    viscous = 150 * VISCOSITY_PA_S * (1 - void) ** 2 / (void * DIAMETER_M**2)
    return viscous + 1.75 * DENSITY_KG_PER_M3 * (1 - void) / DIAMETER_M * speed


def homogeneous_bed(fluid: KratosProcess, velocity: NDArray[np.float64], width_m: float) -> Exchange:
    """What resting particles would send."""
    void = void_fraction(fluid.mesh.points_m[:, 2], width_m)
    beta = ergun(void, np.linalg.norm(velocity, axis=1))
    still = np.zeros_like(velocity)
    return Exchange(
        from_time_s=fluid.time_s,
        time_s=fluid.time_s,
        void_fraction=void,
        solid_velocity_m_per_s=still,
        interaction_n_per_m3=-beta[:, None] * velocity,
        pressure_force_n_per_m3=still,
        drag_kg_per_m3_s=beta,
        seen_velocity_m_per_s=velocity,
    )


def floor_pressure(fluid: KratosProcess) -> float:
    """Mean pressure at the points of the floor, Pa; at the outlet it is 0."""
    return float(np.mean(fluid.pressure_pa[fluid.mesh.points_m[:, 2] == 0.0]))


def without_particles(fluid: KratosProcess, window_s: float, windows: int, speed_m_per_s: float) -> None:
    """The bed as a void fraction with a surface of one and a half elements."""
    width_m = 1.5 * SIZE_M[2] / fluid.case.mesh.counts[2]
    bed = homogeneous_bed(fluid, fluid.fields().velocity_m_per_s, width_m)
    for window in range(1, windows + 1):
        velocity = fluid.advance(window_s, bed, bed).velocity_m_per_s
        bed = homogeneous_bed(fluid, velocity, width_m)
        if window % 5 == 0 or window == windows:
            out = fluid.fluxes_m3_per_s()["z_high"]
            print(f"t = {fluid.time_s:.3f} s: pressure drop {floor_pressure(fluid):.1f} Pa, {out:.3e} m3/s leave")
    void = void_fraction(np.linspace(0.0, SIZE_M[2], 10_001), width_m)
    drop = SIZE_M[2] * np.mean(ergun(void, speed_m_per_s / void) * speed_m_per_s / void**2)
    print(f"Ergun along the axis of this bed: {drop:.1f} Pa")


def with_particles(fluid: KratosProcess, scene: str, window_s: float, windows: int) -> None:
    """The particles of a scene, marched in step with the fluid."""
    import sturz
    from sturz.coupling import CoupledRun, Explicit, Fluid

    water = Fluid(
        density_kg_per_m3=DENSITY_KG_PER_M3,
        viscosity_pa_s=VISCOSITY_PA_S,
        smoothing_length_m=1.5 * SIZE_M[2] / fluid.case.mesh.counts[2],
        voidage="gidaspow",
    )
    folder = "fixed_bed_state"
    with (
        sturz.launch(scene, checkpoints=folder) as simulation,
        CoupledRun(simulation, fluid, fluid=water, scheme=Explicit()) as run,
    ):
        for window in range(1, windows + 1):
            run.advance(window_s)
            if window % 10 == 0 or window == windows:
                void = run.exchange.void_fraction
                print(
                    f"t = {fluid.time_s:.3f} s: pressure drop {floor_pressure(fluid):.1f} Pa, least e {void.min():.3f}"
                )
        run.save_to(folder)


def main() -> None:
    """Reads the command line and runs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", help="a Sturz scene with particles in the box; without it the bed is homogeneous")
    parser.add_argument("--interpreter", help="a Python that has Kratos, if it is not this one")
    parser.add_argument("--speed", type=float, default=5e-3, help="superficial velocity, m/s")
    parser.add_argument("--counts", type=int, nargs=3, default=(6, 6, 24), help="elements along x, y, z")
    parser.add_argument("--window", type=float, default=2e-3, help="window, s")
    parser.add_argument("--windows", type=int, default=20)
    parser.add_argument("--steps", type=int, default=1, help="time steps of the fluid in a window")
    options = parser.parse_args()
    case = water(options.speed, tuple(options.counts), options.steps)
    with KratosProcess(case, interpreter=options.interpreter, timeout_s=600.0) as fluid:
        if options.scene is None:
            without_particles(fluid, options.window, options.windows, options.speed)
        else:
            with_particles(fluid, options.scene, options.window, options.windows)


if __name__ == "__main__":
    main()
