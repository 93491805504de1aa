"""C5: steady flow of spherocylinders down a chute, as the proceedings paper of seed 003: figures 2 and 3.

Scaled (C5s): 6 x 3 lengths instead of 16 x 16, half as deep, k/10, Tc/20. Parts are
aspect and angle. Writes rows.json, regimes.png (mean speed over time) and kinetic.png (kinetic stress by width).
"""

from __future__ import annotations

import numpy as np
from common import COLOURS, SCENES, Options, Row, Rows, Run, figure, launched, options, portrait

from sturz import measures

LENGTH_M = 0.125
TIME_S = LENGTH_M**0.5
# Particles per l^2 of base in the paper: N / 256; half of that here.
PER_AREA = {"1.01": 5664 / 256, "1.5": 10752 / 256, "2.0": 17824 / 256, "3.0": 37632 / 256}
WIDTHS = (0.125, 0.25, 0.5, 1.0)
PARTS = tuple(f"{aspect}-{angle}" for aspect in PER_AREA for angle in (14, 18, 22, 24, 26, 28, 30, 34))
DEFAULT_PARTS = ("1.01-24", "1.01-14", "1.01-34", "2.0-28")


def scene(opts: Options, aspect: str, angle: int) -> str:
    """The bundled scene with another aspect and angle."""
    text = (SCENES / "chute-spherocylinders.toml").read_text()
    radius = LENGTH_M / (2 * float(aspect))
    straight = LENGTH_M - 2 * radius
    mass = 2500.0 * (np.pi * radius**2 * straight + 4 / 3 * np.pi * radius**3)
    count = int(PER_AREA[aspect] / 2 * 18)
    theta = np.deg2rad(angle)
    text = text.replace("[0.4067366, -0.9135455, 0.0]", f"[{np.sin(theta):.9f}, {-np.cos(theta):.9f}, 0.0]")
    text = text.replace("4.03e5", f"{2e4 * mass / LENGTH_M:.6g}").replace(
        "radius_m = 0.0618812", f"radius_m = {radius:.7f}"
    )
    if opts.size == "short":
        count = 40
    if opts.size == "full":  # the paper's base and depth
        count = int(PER_AREA[aspect] * 256)
        text = text.replace("max_m = [0.75, 0.0, 0.375]", "max_m = [2.0, 0.0, 2.0]").replace(
            "[0.82, 2.5, 0.445]", "[2.07, 5.0, 2.07]"
        )
        text = text.replace(f"{2e4 * mass / LENGTH_M:.6g}", f"{2e5 * mass / LENGTH_M:.6g}").replace("2.7e-4", "3.5e-5")
        random = np.random.default_rng(5)
        places = [
            [round((i + 0.5) * LENGTH_M, 4), round(random.uniform(-0.025, 0.025), 4), round((k + 0.5) * LENGTH_M, 4)]
            for i in range(16)
            for k in range(16)
        ]
        start = text.index("positions_m = ")
        text = f"{text[:start]}positions_m = {places} }}\n"
    return text.replace("count = 199", f"count = {count}")


def flow(opts: Options, run: Run) -> np.ndarray:
    """Lets it flow; time, kinetic energy and mean velocity down the slope. Steady: the energy of the last third changes
    by less than 2 %; else it goes on, up to twice as long."""
    shortest = opts.pick(5.0, 300.0, 2000.0)
    history = run.notes.setdefault("history", [])
    while True:
        run.advance(TIME_S)
        state, _, heavy = run.seen()
        rods = state.materials == run.info.materials.index("rod")
        # Of those that flow.
        kinetic = 0.5 * float(heavy.mass_kg[rods] @ (state.velocities_m_per_s[rods] ** 2).sum(axis=1))
        history.append([run.time_s / TIME_S, kinetic, float(state.velocities_m_per_s[rods, 0].mean())])
        if len(history) % 20 == 0:
            run.save()
        if len(history) >= shortest and (change(np.array(history)) < 0.02 or len(history) >= 1.5 * shortest):
            return np.array(history)
        if len(history) > 50 and kinetic < 1e-7 * float(heavy.mass_kg[rods].sum()) * LENGTH_M:
            return np.array(history)


def change(history: np.ndarray) -> float:
    """Change of the kinetic energy over the last third, by a straight line, over its mean."""
    last = history[-max(len(history) // 3, 3) :]
    mean = last[:, 1].mean()
    return abs(np.polyfit(last[:, 0], last[:, 1], 1)[0]) * (last[-1, 0] - last[0, 0]) / mean if mean > 0 else 0.0


def measure(opts: Options, run: Run, part: str, history: np.ndarray) -> tuple[list[Row], dict[str, np.ndarray]]:
    """Fields by width, stress ratio, regime."""
    angle = part.split("-")[1]
    states, ratios = [], []
    domain = run.info.domain
    area = float((domain.max_m[0] - domain.min_m[0]) * (domain.max_m[2] - domain.min_m[2]))
    top = float(run.simulation.state().positions_m[:, 1].max())
    edges = np.arange(0.0625, top, LENGTH_M)
    for _ in range(opts.pick(3, 60, 400)):
        run.advance(0.5 * TIME_S)
        state, contacts, heavy = run.seen()
        states.append(state)
        stress = measures.layer_stress(state, contacts, heavy, edges, area_m2=area, axis=1, domain=domain)
        ratios.append(stress.total)
    total = np.mean(ratios, axis=0)
    bulk = slice(2, max(len(edges) - 4, 3))
    shear = -total[bulk, 0, 1].sum() / total[bulk, 1, 1].sum()
    place = np.arange(0.5, top / LENGTH_M, 0.25) * LENGTH_M
    kept = {"history": history, "places_m": place, "edges_m": edges, "stress_pa": total}
    middle = (place > 2 * LENGTH_M) & (place < top - 3 * LENGTH_M)
    means = {}
    for width in WIDTHS:
        found = measures.coarse_profile(
            states,
            heavy.mass_kg,
            place,
            width_m=width * LENGTH_M,
            area_m2=area,
            axis=1,
            selected=state.materials == run.info.materials.index("rod"),
        )
        kept[f"kinetic_{width}"] = found.kinetic_stress_pa
        kept[f"free_{width}"] = found.scale_free_stress_pa
        kept[f"velocity_{width}"] = found.velocity_m_per_s
        kept[f"density_{width}"] = found.density_kg_per_m3
        means[width] = [
            found.kinetic_stress_pa[middle][:, 0, 0].mean(),
            found.kinetic_stress_pa[middle][:, 1, 1].mean(),
            found.kinetic_stress_pa[middle][:, 2, 2].mean(),
            found.scale_free_stress_pa[middle][:, 0, 0].mean(),
        ]
    name = f"C5s-{part}"
    last = history[-max(len(history) // 3, 3) :]
    slope = np.polyfit(last[:, 0], last[:, 2], 1)[0]
    speed = float(last[:, 2].mean())
    at_rest = history[-1, 1] < 1e-4 * history[:, 1].max() or speed < 1e-3
    regime = (
        "arresting" if at_rest else "steady" if change(history) < 0.02 else "accelerating" if slope > 0 else "slowing"
    )
    rows = [
        run.row(name, f"regime: {regime}", np.nan),
        run.row(name, "change of the kinetic energy over the last third", change(history)),
        run.row(name, "mean velocity over sqrt(g l)", speed / TIME_S),
        run.row(
            name,
            "shear over normal stress",
            shear,
            reference=float(np.tan(np.deg2rad(float(angle)))),
            tolerance=0.02 if regime == "steady" else np.nan,
            source="balance of momentum",
        ),
    ]
    if regime == "steady":
        first, last = means[WIDTHS[0]], means[WIDTHS[-1]]
        rows += [
            run.row(name, "sigma_k_xx, width l over l/8", last[0] / first[0], source="seed 003, fig. 2: grows"),
            run.row(
                name,
                "sigma_k_yy, width l over l/8",
                last[1] / first[1],
                reference=1.0,
                tolerance=0.1,
                source="seed 003: collapses",
            ),
            run.row(
                name,
                "sigma_k_zz, width l over l/8",
                last[2] / first[2],
                reference=1.0,
                tolerance=0.1,
                source="seed 003, fig. 3: collapses",
            ),
            run.row(
                name,
                "T_k_xx, width l/2 over l/8",
                means[0.5][3] / first[3],
                reference=1.0,
                tolerance=0.1,
                source="seed 003: independent of the width",
            ),
            run.row(
                name,
                "T_k_xx, width l over l/8",
                last[3] / first[3],
                reference=1.0,
                tolerance=0.1,
                source="seed 003: independent of the width",
            ),
            run.row(name, "sigma_k_xx over contact stress sigma_yy", first[0] / total[bulk, 1, 1].mean()),
        ]
    return rows, kept


def draw(opts: Options, rows: Rows) -> None:
    """Kinetic energy over time, and figures 2 and 3 of the paper."""
    there = [part for part in PARTS if rows.has(part)]
    if not there:
        return
    with figure(opts.out / "regimes", 6.4, 3.4) as axes:
        for colour, part in zip(COLOURS, there, strict=False):
            history = rows.arrays(part, "fields")["history"]
            aspect, angle = part.split("-")
            axes.plot(
                history[:, 0], history[:, 2] / TIME_S, color=colour, linewidth=1, label=f"aspect {aspect}, {angle}°"
            )
        axes.set_xlabel("time / sqrt(l/g)")
        axes.set_ylabel("mean velocity / sqrt(g l)")
        axes.set_title("Regimes of the chute")
        axes.legend(frameon=False)
    steady = [part for part in there if any(row["metric"].startswith("sigma_k_xx,") for row in rows.parts[part])]
    if steady:
        with figure(opts.out / "kinetic", 9.6, 3.2 * len(steady), nrows=len(steady), ncols=3, squeeze=False) as axes:
            for line, part in zip(axes, steady, strict=True):
                kept = rows.arrays(part, "fields")
                y = kept["places_m"] / LENGTH_M
                for colour, width in zip(COLOURS, WIDTHS, strict=False):
                    label = f"w = {width:g} l"
                    line[0].plot(kept[f"kinetic_{width}"][:, 0, 0], y, color=colour, linewidth=1.1, label=label)
                    line[1].plot(kept[f"kinetic_{width}"][:, 2, 2], y, color=colour, linewidth=1.1, label=label)
                    line[2].plot(kept[f"free_{width}"][:, 0, 0], y, color=colour, linewidth=1.1, label=label)
                for each, title in zip(
                    line, ("σk_xx (fig. 2)", "σk_zz (fig. 3)", "T_k_xx, without the width's part"), strict=True
                ):
                    each.set_title(f"{title}: aspect {part.replace('-', ', ')}°")
                    each.set_xlabel("Pa")
                    each.set_xlim(left=0)
                line[0].set_ylabel("depth y / l")
                line[0].legend(frameon=False)


def main() -> None:
    """Command line."""
    opts = options(__doc__ or "", "chute", PARTS)
    rows = Rows(opts.out / "rows.json")
    for part in PARTS:
        if not (opts.wants(part) if opts.only else part in DEFAULT_PARTS) or rows.has(part):
            continue
        aspect, angle = part.split("-")
        with launched(opts, part, scene(opts, aspect, int(angle))) as run:
            history = flow(opts, run)
            run.save()
            found, kept = measure(opts, run, part, history)
            rows.keep(part, found, fields=kept)
            portrait(opts, run, f"chute_{part}.png", f"Aspect {aspect}, {angle}°")
        draw(opts, rows)
    draw(opts, rows)


if __name__ == "__main__":
    main()
