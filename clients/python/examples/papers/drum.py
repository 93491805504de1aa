"""G8: rotating drum of spheres and 3D crosses, as Rakotonirina et al. 2019 (Comput. Part. Mech. 6, 55-84), section 4.2.

Scaled (G8s): 14 mm deep, 1e3 N/m; half a turn at 5 rpm, three turns at 80 and 200 rpm. Each shape settles once; each
rate starts from there. Parts `map-<shape>` are all rates of a shape, those between in shorter runs, for the map of
regimes over shape and rate (fig. 30). Writes rows.json, speeds.png (fig. 26), distributions.png (fig. 27), map.png
(fig. 30) and a picture of each run.
"""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
from common import COLOURS, SCENES, Options, Row, Rows, Run, figure, launched, options, portrait, settle

import sturz
from sturz import measures

SOURCE = "Rakotonirina 2019, section 4.2"
RADIUS_M = 0.05
AXIS = np.array([0.0, 1.0, 0.0])
# 7/12 of the paper's numbers; the full depth has all.
COUNTS = {"sphere": 1750, "cross_3d": 729, "cross_2d": 875, "tetrahedron": 1517, "cube": 1750}
RATES = (200, 80, 5)
# Of the map: simulated time of each rate, s. From 125 rpm on two turns or more, of which the last third is judged.
BETWEEN_S = {250: 0.6, 150: 0.9, 125: 1.0, 20: 1.5}
DURATION_S = {5: 6.0, 80: 2.25, 200: 0.9} | BETWEEN_S
# What the paper calls them, from its pictures (figs. 20 to 24; of spheres from the paper that it cites as [39]).
REGIMES = {
    ("sphere", 250): "centrifuging",
    ("sphere", 200): "cataracting",
    ("sphere", 150): "cataracting",
    ("sphere", 5): "rolling",
    ("cross_3d", 5): "avalanching",
    ("cross_3d", 20): "avalanching",
    ("cross_3d", 80): "avalanching",
    ("cross_3d", 125): "cataracting",
    ("cross_3d", 200): "centrifuging",
    ("cross_3d", 250): "centrifuging",
}
# The same as ranges of the rate, for the map: what the text says; its fig. 30 is a picture.
NAMED = {
    "sphere": (("rolling", 5, 20), ("cataracting", 150, 200), ("centrifuging", 220, 250)),
    "cross_3d": (
        ("avalanching", 5, 80),
        ("cataracting", 125, 140),
        ("pseudo-cataracting", 150, 165),
        ("centrifuging", 200, 250),
    ),
}
MARKS = {"rolling": "o", "avalanching": "s", "cascading": "D", "cataracting": "^", "centrifuging": "P"}
PARTS = tuple(f"{shape}-{rate}" for shape in COUNTS for rate in (*RATES, *BETWEEN_S))
DEFAULT_PARTS = tuple(f"{shape}-{rate}" for shape in ("sphere", "cross_3d") for rate in RATES)


def scene(opts: Options) -> str:
    """The bundled scene; the paper's depth and stiffness in full."""
    text = (SCENES / "drum-shapes.toml").read_text()
    if opts.size == "full":
        text = text.replace("[0.0, 0.014, 0.0]", "[0.0, 0.024, 0.0]").replace("= 1e3", "= 1e5").replace("2e-5", "2e-6")
    return text


def prepare(opts: Options, run: Run, shape: str) -> None:
    """Fills the drum and lets the bed come to rest, once per shape."""
    if run.notes.get("settled"):
        return
    if not run.info.particles:
        depth = float(run.info.domain.max_m[1])
        count = opts.pick(40, COUNTS[shape], COUNTS[shape] * 12 // 7)
        region = sturz.Cylinder((0.0, 0.0, 0.0), AXIS, radius_m=0.0495, length_m=depth)
        run.simulation.insert_random(shape=shape, material="grain", region=region, count=count, attempts=100_000)
    # It saves on its way: a run that was interrupted there is not at rest.
    settle(run, window_s=0.02, longest_s=opts.pick(0.04, 0.6, 0.6), size_m=3e-3, quiet=1e-5)
    run.notes["settled"] = True
    run.save()


def turn(opts: Options, run: Run, rpm: int) -> tuple[list[measures.DrumState], dict[str, np.ndarray]]:
    """Turns the drum from where the bed came to rest; states and numbers at equal intervals."""
    rate = rpm * 2 * np.pi / 60
    duration = opts.pick(0.04, DURATION_S[rpm], 10.0)
    windows = opts.pick(4, 90, 500)
    # By the right-hand rule about +y the bottom moves towards -x.
    run.simulation.set_rotation(boundary="drum", angular_velocity_rad_per_s=rate, ramp_s=0.05)
    states: list[measures.DrumState] = []
    angles, neighbours, ratios, speeds = [], [], [], []
    for _ in range(windows):
        run.advance(duration / windows)
        state, contacts, heavy = run.seen()
        geometry = {"axis": AXIS, "centre_m": np.zeros(3), "radius_m": RADIUS_M}
        states.append(measures.drum_state(state, contacts, heavy.mass_kg, angular_velocity_rad_per_s=rate, **geometry))
        radii = 0.5 * heavy.equivalent_diameter_m
        angle = measures.drum_angle(state.positions_m, radii, gravity_m_per_s2=state.gravity_m_per_s2, **geometry)
        angles.append(np.rad2deg(angle.angle_rad))
        neighbours.append(measures.coordination(state, contacts, with_walls=True).mean)
        energy = measures.energy_partition(state, heavy)
        ratios.append([energy.translation_j, energy.rotation_j])
        speeds.append(state.speeds_m_per_s / (rate * RADIUS_M))
    late = speeds[windows // 3 :]
    found = measures.distribution(np.concatenate(late), np.linspace(0, 2.5, 51))
    kept = {name: np.array([asdict(each)[name] for each in states]) for name in asdict(states[0])}
    kept |= {"angle_deg": np.array(angles), "neighbours": np.array(neighbours), "energies_j": np.array(ratios)}
    kept |= {"distribution": found.density, "middles": found.middles}
    return states, kept


def rows_of(run: Run, shape: str, rpm: int, states: list[measures.DrumState], kept: dict[str, np.ndarray]) -> list[Row]:
    """The numbers of one run: of its last third, where it has three turns the third one; slowly, of the last two."""
    late = slice(2 * len(states) // 3 if rpm > 50 else len(states) // 3, None)
    rate = rpm * 2 * np.pi / 60
    regime = measures.drum_regime(
        states[late], angular_velocity_rad_per_s=rate, radius_m=RADIUS_M, gravity_m_per_s2=9.81
    )
    name = f"G8s-{shape}-{rpm}"

    def mean(metric: str, values: np.ndarray, unit: str = "1") -> Row:
        found = measures.block_mean(values[late])
        return run.row(name, metric, found.value, uncertainty=found.standard_error, unit=unit)

    def gate(metric: str, value: float, low: float, high: float, unit: str = "1") -> Row:
        """A range, as its middle and half its width."""
        return run.row(
            name, metric, value, reference=0.5 * (low + high), tolerance=0.5 * (high - low), unit=unit, source=SOURCE
        )

    expected = REGIMES.get((shape, rpm))
    same = float(regime.regime == expected) if expected else np.nan
    rows = [
        run.row(
            name,
            f"regime: {regime.regime}" + (f" (paper: {expected})" if expected else ""),
            same,
            reference=1.0 if expected else np.nan,
            tolerance=0.0 if expected else np.nan,
            source=SOURCE,
        ),
        run.row(name, "Froude number", regime.froude),
        mean("mean speed over that of the rim", kept["mean_speed"]),
        mean("slip against the drum", kept["slip"]),
        mean("share of particles without contact", kept["flying"]),
        mean("coordination number", kept["neighbours"]),
        mean("translational over rotational energy", kept["energies_j"][:, 0] / kept["energies_j"][:, 1]),
    ]
    deviation = regime.intermittence
    if rpm == 200 and shape != "sphere":
        rows.append(gate("deviation over mean of the mean speed in time", deviation, 0.0, 0.02))
        rows.append(gate("radius of the centre of mass over the drum's", regime.centre_radius, 0.0, 0.15))
    else:
        rows.append(run.row(name, "deviation over mean of the mean speed in time", deviation))
        rows.append(mean("radius of the centre of mass over the drum's", kept["centre_radius"]))
    if rpm == 5:
        steepest = float(np.nanmax(kept["angle_deg"][late]))
        low, high = (60.0, 90.0) if shape == "cross_3d" else (0.0, 40.0)
        judge = (
            gate
            if shape in ("sphere", "cross_3d")
            else lambda metric, value, *_: run.row(name, metric, value, unit="deg")
        )
        rows.append(judge("steepest surface", steepest, low, high, "deg"))
        rows.append(mean("angle of the surface", kept["angle_deg"], "deg"))
        angles = kept["angle_deg"][late]
        falls = measures.drops(kept["time_s"][late], angles, least_drop=2.0)
        rows.append(run.row(name, "falls of the surface by 2 degrees or more", len(falls)))
        if len(falls):
            rows.append(run.row(name, "mean fall", float(falls.size.mean()), unit="deg"))
        if len(falls) > 1:
            rows.append(run.row(name, "mean wait between falls", float(falls.waiting_s.mean()), unit="s"))
    return rows


def draw(opts: Options, rows: Rows) -> None:
    """Figures 26 and 27 of the paper."""
    there = [part for part in PARTS if rows.has(part)]
    if not there:
        return
    shapes = list(dict.fromkeys(part.rsplit("-", 1)[0] for part in there))
    with figure(opts.out / "speeds", 9.6, 3.4, ncols=3) as axes:
        for each, rate in zip(axes, sorted(RATES), strict=True):
            for shape in shapes:
                if rows.has(f"{shape}-{rate}"):
                    kept = rows.arrays(f"{shape}-{rate}", "series")
                    turns = (kept["time_s"] - kept["time_s"][0]) * rate / 60
                    each.plot(
                        turns,
                        kept["mean_speed"],
                        color=COLOURS[list(COUNTS).index(shape)],
                        linewidth=1.1,
                        label=shape.replace("_", " "),
                    )
            each.set_title(f"{rate} rpm")
            each.set_xlabel("turns")
            each.set_ylim(bottom=0)
            if each.lines:
                each.legend(frameon=False)
        axes[0].set_ylabel("mean speed / ΩR (fig. 26)")
    with figure(opts.out / "distributions", 9.6, 3.4, ncols=max(len(shapes), 2), squeeze=False, sharey=True) as axes:
        for each, shape in zip(axes[0], shapes, strict=False):
            for k, rate in enumerate(sorted(RATES)):
                if rows.has(f"{shape}-{rate}"):
                    kept = rows.arrays(f"{shape}-{rate}", "series")
                    each.plot(
                        kept["middles"], kept["distribution"], color=COLOURS[k], linewidth=1.1, label=f"{rate} rpm"
                    )
            each.set_title(shape.replace("_", " "))
            each.set_xlabel("speed / ΩR (fig. 27)")
            if each.lines:
                each.legend(frameon=False)
        axes[0, 0].set_ylabel("probability density")


def draw_map(opts: Options, rows: Rows) -> None:
    """Fig. 30: regimes over shape and rate, beside what the text of the paper names."""
    shapes = [shape for shape in COUNTS if any(rows.has(f"{shape}-{rate}") for rate in BETWEEN_S)]
    if not shapes:
        return
    with figure(opts.out / "map", 8.0, 1.6 + 0.8 * len(shapes)) as axes:
        for height, shape in enumerate(shapes):
            for regime, low, high in NAMED.get(shape, ()):
                axes.barh(height + 0.3, high - low, 0.16, left=low, color="#dde2e6", zorder=0)
                axes.text(0.5 * (low + high), height + 0.3, regime, fontsize=5.5, ha="center", va="center")
            for rate in DURATION_S:
                part = f"{shape}-{rate}"
                if rows.has(part):
                    regime = rows.parts[part][0]["metric"].removeprefix("regime: ").split(" ")[0]
                    colour = COLOURS[list(MARKS).index(regime)]
                    axes.plot(rate, height, MARKS[regime], color=colour, markersize=8)
        for (regime, mark), colour in zip(MARKS.items(), COLOURS, strict=False):
            axes.plot([], [], mark, color=colour, label=regime)
        axes.set_yticks(range(len(shapes)), [shape.replace("_", " ") for shape in shapes])
        axes.set_ylim(-0.5, len(shapes) - 0.3)
        axes.set_xlim(0, 265)
        axes.set_xlabel("rate, rpm (grey: what the paper's text names)")
        axes.set_title("Regimes of the drum (fig. 30)")
        axes.legend(frameon=False, ncols=5, loc="upper center", bbox_to_anchor=(0.5, -0.35), fontsize=8)


def main() -> None:
    """Command line."""
    maps = {f"map-{shape}": [f"{shape}-{rate}" for rate in DURATION_S] for shape in COUNTS}
    opts = options(__doc__ or "", "drum", (*PARTS, *maps))
    asked = {part for each in opts.only for part in maps.get(each, [each])} or set(DEFAULT_PARTS)
    rows = Rows(opts.out / "rows.json")
    for part in PARTS:
        if part not in asked or rows.has(part):
            continue
        shape, rpm = part.rsplit("-", 1)
        with launched(opts, shape, scene(opts)) as run:
            prepare(opts, run, shape)
            states, kept = turn(opts, run, int(rpm))
            rows.keep(part, rows_of(run, shape, int(rpm), states, kept), series=kept)
            state = run.simulation.state()
            portrait(opts, run, f"{part}.png", f"{len(state)} particles ({shape.replace('_', ' ')}), {rpm} rpm")
        draw(opts, rows)
    draw(opts, rows)
    draw_map(opts, rows)


if __name__ == "__main__":
    main()
