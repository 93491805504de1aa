"""CFD3 with Kratos: some hundred glass beads in water, fluidised in a box.

The velocity of the water goes up in steps; above minimum fluidisation its pressure drop, without the hydrostatic part,
is the buoyant weight of the beads per area. Leaves a table and a picture.

    python fluidised_bed.py [--interpreter VENV/bin/python] [--speeds 8 16 24 32] [--out FOLDER]
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path

import numpy as np

import sturz
from sturz.coupling import CoupledRun, Explicit, Fluid, Implicit
from sturz.coupling.kratos import Box, Inlet, KratosCase, KratosProcess
from sturz.plot import picture

WATER, VISCOSITY, GLASS, GRAVITY, DIAMETER_M = 1000.0, 1e-3, 2500.0, 9.81, 1e-3
WIDTH_M, HEIGHT_M, COUNTS = 6e-3, 33e-3, (2, 2, 11)
BEADS = 400
VOLUME_M3 = BEADS * math.pi / 6 * DIAMETER_M**3
STIFFNESS = 20.0
STEP_S = math.pi * math.sqrt(0.5 * GLASS * math.pi / 6 * DIAMETER_M**3 / STIFFNESS) / 35


def wall(name: str, point: tuple[float, float, float], normal: tuple[int, int, int]) -> str:
    """A plane, in a scene file."""
    geometry = f'{{ kind = "plane", point_m = {list(point)}, normal = {[float(n) for n in normal]} }}'
    return f'[[boundary]]\nname = "{name}"\nmaterial = "glass"\ngeometry = {geometry}\n'


def scene() -> str:
    """A box of glass without a lid."""
    walls = wall("floor", (0.0, 0.0, 0.0), (0, 0, 1)) + "".join(
        wall(
            f"{axis}-{end}",
            tuple(WIDTH_M * end if k == a else 0.0 for k in range(3)),
            tuple((1 - 2 * end) * (k == a) for k in range(3)),
        )
        for a, axis in enumerate("xy")
        for end in (0, 1)
    )
    return f"""
[scene]
name = "fluidised"
gravity_m_per_s2 = [0.0, 0.0, {-GRAVITY}]
time_step_s = {STEP_S!r}
seed = 1
[[material]]
name = "glass"
density_kg_per_m3 = {GLASS}
[[material_pair]]
materials = ["glass", "glass"]
stiffness_n_per_m = {STIFFNESS}
restitution = 0.3
friction = 0.3
[[shape]]
name = "bead"
geometry = {{ kind = "sphere", radius_m = {DIAMETER_M / 2!r} }}
{walls}
"""


def main() -> None:
    """Reads the command line and runs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--interpreter", help="a Python that has Kratos, if it is not this one")
    parser.add_argument("--speeds", type=float, nargs="+", default=(8.0, 16.0, 24.0, 32.0), help="superficial, mm/s")
    parser.add_argument("--windows", type=int, default=500, help="of each speed; the last 200 are averaged")
    parser.add_argument("--window", type=float, default=1e-3, help="s")
    parser.add_argument("--implicit", action="store_true", help="iterate each window")
    parser.add_argument("--out", type=Path, default=Path("out/kratos"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    sides = dict.fromkeys(("x_low", "x_high", "y_low", "y_high"), "slip")
    case = KratosCase(
        mesh=Box(origin_m=(0.0, 0.0, 0.0), size_m=(WIDTH_M, WIDTH_M, HEIGHT_M), counts=COUNTS),
        boundaries={**sides, "z_low": Inlet((0.0, 0.0, 1e-3 * options.speeds[0])), "z_high": "outlet"},
        density_kg_per_m3=WATER,
        viscosity_pa_s=VISCOSITY,
        # the beads feel buoyancy through the pressure gradient
        gravity_m_per_s2=(0.0, 0.0, -GRAVITY),
    )
    water = Fluid(WATER, VISCOSITY, smoothing_length_m=1.5 * HEIGHT_M / COUNTS[2], voidage="gidaspow")
    scheme = Implicit(tolerance=1e-3) if options.implicit else Explicit()
    rows = []
    with (
        sturz.launch(scene_text=scene(), checkpoints=options.out / "checkpoints") as simulation,
        KratosProcess(case, interpreter=options.interpreter, timeout_s=600.0) as fluid,
    ):
        region = sturz.Box((0.0, 0.0, 0.0), (WIDTH_M, WIDTH_M, 0.2))
        simulation.insert_deposition(shape="bead", material="glass", region=region, count=BEADS)
        simulation.set_fluid(Fluid(WATER, VISCOSITY, buoyancy=True, void_fraction=0.6, voidage="gidaspow"))
        simulation.advance(window_s=0.5)
        with CoupledRun(simulation, fluid, fluid=water, scheme=scheme) as run:
            for speed in options.speeds:
                fluid.set_inlet("z_low", (0.0, 0.0, 1e-3 * speed))
                rows.append(look(run, simulation, fluid, speed, options))
        info = simulation.info()
        picture(simulation.state(), simulation.shapes(), info.boundaries, options.out / "beads", domain=info.domain)
    (options.out / "rows.json").write_text(json.dumps(rows, indent=1) + "\n")


def look(
    run: CoupledRun, simulation: sturz.Simulation, fluid: KratosProcess, speed: float, options: argparse.Namespace
) -> dict[str, float]:
    """Pressure drop over the buoyant weight, height of the centre of mass, after the bed has followed the water."""
    drops, iterations = [], 0
    for window in range(options.windows):
        iterations += run.advance(options.window).iterations
        if window >= options.windows - 200:
            floor = fluid.mesh.points_m[:, 2] == 0.0
            drops.append(float(np.mean(fluid.pressure_pa[floor])))
    weight = VOLUME_M3 * (GLASS - WATER) * GRAVITY / WIDTH_M**2
    z = simulation.state(["positions"]).columns["positions"][:, 2]
    row = {
        "superficial_mm_per_s": speed,
        "pressure_drop_over_weight": float(np.mean(drops)) / weight,
        "centre_mm": 1e3 * float(z.mean()),
        "iterations_per_window": iterations / options.windows,
    }
    print(
        f"{speed:5.1f} mm/s: pressure drop {np.mean(drops):7.2f} Pa, "
        f"{row['pressure_drop_over_weight']:.4f} of the weight; centre at {row['centre_mm']:.2f} mm",
        flush=True,
    )
    return row


if __name__ == "__main__":
    main()
