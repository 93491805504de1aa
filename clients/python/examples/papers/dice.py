"""I19: frictional tetrahedra settle, and are shaken: towards the 0.76 of Jaoshvili's tetrahedral dice.

Jaoshvili et al. 2010 (Phys. Rev. Lett. 104, 185501) found a solid fraction of 0.76 for dice with rounded corners, in
containers that were shaken. Here: the tetrahedra of the porosity scene (mu = 0.55) in a periodic cell, softer (2e3
N/m), are poured, then shaken by their floor up and down at 30 Hz and four times gravity; after so many shakes the floor
rests, and so do they. Part `tetrahedron`, and `sphere` to compare.
Writes rows.json, dice.png and a picture of either end.
"""

from __future__ import annotations

import math

import numpy as np
from common import COLOURS, REFERENCE, SCENES, Options, Row, Rows, Run, figure, launched, options, portrait, settle
from porosity import D, shower

from sturz import measures

PARTS = ("tetrahedron", "sphere")
HZ, OVER_GRAVITY = 30.0, 4.0
AMPLITUDE_M = OVER_GRAVITY * 9.81 / (2 * math.pi * HZ) ** 2
SETTLED, SHAKEN = 0.5254, 0.76  # 1 - 0.4746 of Rakotonirina 2019, table 5; Jaoshvili


def scene(opts: Options) -> str:
    """The porosity scene, softer and narrower."""
    text = (SCENES / "porosity-shapes.toml").read_text()
    text = text.replace(
        "[0.036, 0.036, 0.0]", opts.pick("[0.015, 0.015, 0.0]", "[0.015, 0.015, 0.0]", "[0.03, 0.03, 0.0]")
    )
    return text.replace("stiffness_n_per_m = 1e5", "stiffness_n_per_m = 2e3").replace("= 2e-6", "= 8e-6")


def look(run: Run) -> tuple[float, float, np.ndarray]:
    """Solid fraction from 2 diameters over the floor to 2 below the surface, its standard error, and the profile."""
    state = run.simulation.state()
    top = float(state.positions_m[:, 2].max()) + 0.5 * D
    edges = np.linspace(0.0, top, max(int(top / (0.1 * D)), 4) + 1)
    area = float(np.prod(run.info.domain.max_m[:2] - run.info.domain.min_m[:2]))
    profile = measures.solid_fraction_profile(state, run.shapes, edges, area_m2=area)
    full = np.median(profile.solid_fraction[(profile.middles_m > 0.2 * top) & (profile.middles_m < 0.6 * top)])
    surface = profile.edges_m[np.flatnonzero(profile.solid_fraction > 0.5 * full)[-1] + 1]
    low, high = min(2 * D, 0.3 * surface), max(surface - 2 * D, 0.6 * surface)
    slices = [profile.mean(a, a + (high - low) / 4)[0] for a in np.linspace(low, high, 5)[:4]]
    mean = profile.mean(low, high)[0]
    return float(mean), float(np.std(slices, ddof=1) / 2), np.stack([profile.middles_m, profile.solid_fraction])


def rest(opts: Options, run: Run) -> bool:
    """Until the kinetic energy per particle is below 1e-6 m g d, for 0.2 s at most."""
    longest = run.time_s + opts.pick(0.01, 0.2, 1.0)
    return settle(run, window_s=0.02, longest_s=longest, size_m=D, quiet=1e-6, save_every=1000)


def shake(opts: Options, rows: Rows, part: str) -> None:
    """Pours, shakes, and looks in between."""
    counts = opts.pick([1], [1, 3, 10, 30], [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000])
    with launched(opts, part, scene(opts)) as run:
        seen = run.notes.setdefault("seen", [])
        if not seen:
            count = opts.pick(12, 160, 1600)
            if run.info.particles < count:
                shower(run, part, count, opts.pick((0.015, 0.023), (0.05, 0.058), (0.07, 0.078)))
            settled = rest(opts, run)
            seen.append([0, *look(run)[:2], float(settled)])
            run.save()
            portrait(opts, run, f"poured_{part}.png", f"{count} particles, poured: {part}")
        for number in counts:
            done = int(seen[-1][0])
            if number <= done:
                continue
            run.simulation.set_oscillation(
                boundary="floor", amplitude_m=(0, 0, AMPLITUDE_M), frequency_hz=HZ, phase_rad=-math.pi / 2
            )
            run.advance((number - done) / HZ)  # whole periods: the floor is back, and stands still
            run.simulation.set_fixed(boundary="floor")
            settled = rest(opts, run)
            seen.append([number, *look(run)[:2], float(settled)])
            run.save()
        rows.keep(part, rows_of(run, part, np.array(seen)), shakes={"table": np.array(seen), "profile": look(run)[2]})
        shaken = int(seen[-1][0])
        portrait(opts, run, f"shaken_{part}.png", f"{run.info.particles} particles, shaken {shaken} times: {part}")


def rows_of(run: Run, part: str, table: np.ndarray) -> list[Row]:
    """A table of number of shakes, solid fraction, its error, and whether all was at rest."""
    name, found = f"I19-{part}", []
    for number, value, error, _ in table:
        what = f"after {int(number)} shakes" if number else "poured"
        reference, source = np.nan, ""
        if part == "tetrahedron" and number == 0:
            reference, source = SETTLED, "Rakotonirina 2019, table 5"
        elif part == "tetrahedron" and number == table[-1, 0]:
            reference, source = SHAKEN, "Jaoshvili 2010"
        found.append(
            run.row(name, f"solid fraction, {what}", value, uncertainty=error, reference=reference, source=source)
        )
    gain, error = table[-1, 1] - table[0, 1], float(np.hypot(table[-1, 2], table[0, 2]))
    overlap = run.simulation.report().largest_overlap_ratio_so_far
    return [
        *found,
        run.row(name, "gain by shaking", gain, uncertainty=error),
        run.row(name, "states looked at that came to rest, share", float(table[:, 3].mean())),
        run.row(name, "largest overlap over bounding radius", overlap),
    ]


def draw(opts: Options, rows: Rows) -> None:
    """Solid fraction over the number of shakes."""
    there = [part for part in PARTS if rows.has(part)]
    if not there:
        return
    with figure(opts.out / "dice", 5.6, 3.6) as axes:
        for k, part in enumerate(there):
            table = rows.arrays(part, "shakes")["table"]
            # A shake to the left of the first one stands for none.
            axes.errorbar(
                np.maximum(table[:, 0], 0.5),
                table[:, 1],
                table[:, 2],
                fmt="o-",
                color=COLOURS[k],
                markersize=4,
                label=part,
            )
        axes.set_xscale("log")
        axes.axhline(SHAKEN, color=REFERENCE, linewidth=1.2)
        axes.text(0.5, SHAKEN - 0.012, "dice, shaken (Jaoshvili 2010)", fontsize=7)
        axes.axhline(SETTLED, color=REFERENCE, linewidth=1.2, linestyle="--")
        axes.text(0.5, SETTLED + 0.005, "tetrahedra, poured (Rakotonirina 2019)", fontsize=7)
        axes.set_ylim(0.5, 0.8)
        axes.set_xlabel("shakes (poured: 0.5)")
        axes.set_ylabel("solid fraction of the bulk")
        axes.set_title("Tetrahedra, poured and shaken")
        axes.legend(frameon=False, loc="center right")


def main() -> None:
    """Command line."""
    opts = options(__doc__ or "", "dice", PARTS)
    rows = Rows(opts.out / "rows.json")
    for part in PARTS:
        if opts.wants(part) and not rows.has(part):
            shake(opts, rows, part)
            draw(opts, rows)
    draw(opts, rows)


if __name__ == "__main__":
    main()
