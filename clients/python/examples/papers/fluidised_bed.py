"""CFD3: a bed of glass in water, fluidised: pressure drop, minimum fluidisation, expansion; spheres against cubes.

The superficial velocity goes up in steps. Above minimum fluidisation the pressure drop is the buoyant weight per
area; the expansion follows Richardson and Zaki.

    python fluidised_bed.py [--short | --full] [--only sphere cube] [--out FOLDER]
"""

from __future__ import annotations

import math

import beds
import numpy as np
from common import Rows, figure, launched, options

from sturz.coupling import ColumnSolver, CoupledRun, Fluid

SPEEDS_M_PER_S = (2e-3, 4e-3, 6e-3, 8e-3, 10e-3, 14e-3, 20e-3, 30e-3)
SHORT_SPEEDS_M_PER_S = (4e-3, 20e-3)
# explicit: the pressure of the water that a packed bed pushes aside is 0.6 of what the grains' own inertia is, and what
# drag adds to that grows with the window
WINDOW_S = 5e-4


def main() -> None:
    opts = options(__doc__ or "", "fluidised_bed", ("sphere", "cube"))
    rows = Rows(opts.out / "rows.json")
    count, width = opts.pick(150, 2000, 20000), opts.pick(5e-3, 8e-3, 20e-3)
    for name in ("sphere", "cube"):
        if not opts.wants(name) or rows.has(name):
            continue
        grain = beds.grains()[name]
        with launched(opts, name, beds.scene(f"fluidised-{name}", grain, width_m=width)) as run:
            beds.poured(run.simulation, count, width, 0.3)
            beds.settle_in_water(run.simulation, opts.pick(0.3, 1.0, 1.0))
            found = fluidise(run, opts, count, width)
            rows.keep(name, judge(run, name, found, count, width), curves={"table": np.array(found)})
    with figure(opts.out / "fluidisation") as axes:
        draw(axes, rows, count, width)


def fluidise(run, opts, count: int, width: float) -> list[tuple[float, float, float]]:  # type: ignore[no-untyped-def]
    """(superficial velocity, pressure drop, void fraction of the middle) of each step."""
    height = 4.0 * count * beds.VOLUME_M3 / width**2
    cells = max(round(height / 1.5e-3), 10)
    speeds = opts.pick(SHORT_SPEEDS_M_PER_S, SPEEDS_M_PER_S, SPEEDS_M_PER_S)
    now = {"speed": speeds[0]}
    solver = ColumnSolver(
        beds.column(width, height, cells),
        density_kg_per_m3=beds.WATER,
        flux_m_per_s=lambda _: now["speed"],
        time_s=run.time_s,
    )
    water = Fluid(
        beds.WATER,
        beds.VISCOSITY,
        smoothing_length_m=3 * beds.DIAMETER_M,
        drag="haider_levenspiel",
        voidage="gidaspow",
        buoyancy=True,
    )
    found = []
    with CoupledRun(run.simulation, solver, fluid=water) as pair:
        for speed in speeds:
            now["speed"] = speed
            drops, voids = [], []
            waiting, looking = opts.pick(40, 800, 2400), opts.pick(20, 400, 1200)
            for window in range(waiting + looking):
                pair.advance(WINDOW_S)
                if window >= waiting:
                    drops.append(solver.pressure_drop_pa(0.0, height))
                    voids.append(float(beds.inside(solver, pair.exchange, 0.3, 0.7)[0].mean()))
            found.append((speed, float(np.mean(drops)), float(np.mean(voids))))
            print(f"{1e3 * speed:5.1f} mm/s: {found[-1][1]:8.2f} Pa, void fraction {found[-1][2]:.3f}", flush=True)
    run.info = run.simulation.info()
    return found


def weight_per_area(count: int, width: float) -> float:
    """Buoyant, Pa."""
    return count * beds.VOLUME_M3 * (beds.GLASS - beds.WATER) * beds.GRAVITY / width**2


def onset(found: list[tuple[float, float, float]], weight: float, sphericity: float) -> float:
    """Where Ergun's curve through the packed points meets the weight, m/s."""
    packed = [(u, drop, void) for u, drop, void in found if drop < 0.9 * weight]
    if not packed:
        return math.nan
    scale = np.mean([drop / beds.ergun(void, u, sphericity) for u, drop, void in packed])
    void = packed[0][2]
    low, high = 0.0, 1.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if scale * beds.ergun(void, middle, sphericity) < weight else (low, middle)
    return low


def judge(run, name: str, found: list[tuple[float, float, float]], count: int, width: float) -> list:  # type: ignore[no-untyped-def, type-arg]
    """Plateau, onset, expansion."""
    grain, weight = beds.grains()[name], weight_per_area(count, width)
    packed_void = found[0][2]
    wanted = beds.minimum_fluidisation(packed_void, grain.sphericity)
    u_mf = onset(found, weight, grain.sphericity)
    ergun = "Ergun, Chem. Eng. Prog. 48 (1952) 89"
    rows = [
        run.row("CFD3", f"{name}: void fraction at rest", packed_void),
        run.row(
            "CFD3",
            f"{name}: minimum fluidisation over Ergun's",
            u_mf / wanted,
            reference=1.0,
            tolerance=0.1,
            source=ergun,
        ),
        run.row(
            "CFD3",
            f"{name}: minimum fluidisation",
            1e3 * u_mf,
            unit="mm/s",
            reference=1e3 * beds.wen_yu(),
            source="Wen and Yu",
        ),
    ]
    terminal = beds.terminal_speed()
    n = beds.richardson_zaki(beds.WATER * terminal * beds.DIAMETER_M / beds.VISCOSITY)
    for speed, drop, void in found:
        if speed < 1.15 * wanted:
            continue
        label = f"{name}, {1e3 * speed:g} mm/s"
        rows.append(
            run.row("CFD3", f"{label}: pressure drop over weight", drop / weight, reference=1.0, tolerance=0.02)
        )
        expanded = (speed / terminal) ** (1 / n)
        judged = name == "sphere"
        rows.append(
            run.row(
                "CFD3",
                f"{label}: void fraction",
                void,
                reference=expanded if judged else math.nan,
                tolerance=0.1 * expanded if judged else math.nan,
                source="Richardson and Zaki, Trans. Inst. Chem. Eng. 32 (1954) 35",
            )
        )
    return rows


def draw(axes, rows: Rows, count: int, width: float) -> None:  # type: ignore[no-untyped-def]
    """Pressure drop over weight, and void fraction, against the velocity."""
    for k, name in enumerate(rows.parts):
        table = rows.arrays(name, "curves")["table"]
        axes.plot(
            1e3 * table[:, 0],
            table[:, 1] / weight_per_area(count, width),
            "o-",
            color=f"C{k}",
            label=f"{name}: pressure drop over weight",
        )
        axes.plot(1e3 * table[:, 0], table[:, 2], "s--", color=f"C{k}", label=f"{name}: void fraction")
    axes.axhline(1, color="0.6", lw=0.8)
    axes.set_xlabel("superficial velocity, mm/s")
    axes.legend(fontsize=7)


if __name__ == "__main__":
    main()
