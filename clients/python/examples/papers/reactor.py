"""G7, G9: a reactor filled with shapes of one volume, and a single particle in a drum (Rakotonirina et al. 2019).

G7 (figure 19): 250 particles of the volume of an 8 mm sphere fall one by one into a cylinder of 50 mm; parts `sphere`,
`tetrahedron`, `cross_2d`, `cross_3d`. Sped up: 80 instead of 1 per second, from 20 mm over the bed instead of from the
top; 1e4 N/m. G9 (figure 21): part `single`, a sphere and a 3D cross alone in the drum at 150 rpm for 10 s.
Writes rows.json, heights.png, single.png and a picture of each bed.
"""

from __future__ import annotations

import re

import numpy as np
from common import COLOURS, REFERENCE, SCENES, Options, Row, Rows, Run, figure, launched, options, portrait, settle

import sturz
from sturz import measures

SOURCE = "Rakotonirina 2019, section 4.1, fig. 19"
REACTOR_M, D = 0.05, 8e-3
# Height of the bed over that of spheres: the text says 5 for 3D crosses, 4 times tetrahedra, 2 times 2D crosses.
RATIOS = {"sphere": 1.0, "tetrahedron": 1.25, "cross_2d": 2.5, "cross_3d": 5.0}
PARTS = ("single", *RATIOS)
RPM, DRUM_M = 150, 0.05


def reactor() -> str:
    """The shapes of the porosity scene, larger, over a floor inside of a cylinder."""
    text = (SCENES / "porosity-shapes.toml").read_text()

    def larger(line: re.Match[str]) -> str:
        return re.sub(r"(?<== )[\d.]+e-3", lambda number: f"{float(number[0]) * 8 / 3:.8g}", line[0])

    text = re.sub(r"geometry = .*_m = .*e-3.*", larger, text)
    text = re.sub(r"\[domain\][^\[]*\[[^\n]*\n[^\n]*\n[^\n]*\n", "", text)
    text = text.replace("stiffness_n_per_m = 1e5", "stiffness_n_per_m = 1e4").replace("= 2e-6", "= 1.5e-5")
    return (
        text
        + '\n[[boundary]]\nname = "wall"\nmaterial = "grain"\n'
        + 'geometry = { kind = "cylinder_inside", point_m = [0.0, 0.0, 0.0], axis = [0.0, 0.0, 1.0], '
        + f"radius_m = {REACTOR_M / 2} }}\n"
    )


def fill(opts: Options, run: Run, shape: str) -> None:
    """One particle after the other, from over the bed."""
    count, rate = opts.pick(8, 250, 250), opts.pick(80.0, 80.0, 1.0)
    while run.info.particles < count:
        state, contacts = run.simulation.state(), run.simulation.contacts()
        touch = np.isin(state.ids, contacts.ids)
        over = (float(state.positions_m[touch, 2].max()) if touch.any() else 0.0) + 0.02
        low, high = over + 0.008, over + 0.024
        region = sturz.Cylinder((0.0, 0.0, low), (0.0, 0.0, 1.0), radius_m=REACTOR_M / 2, length_m=high - low)
        try:
            run.simulation.insert_random(shape=shape, material="grain", region=region, count=1)
        except sturz.CommandError as error:
            if "no free place" not in error.message:
                raise
        run.advance(1 / rate)
        if run.info.particles % 50 == 0:
            run.save()


def height_m(run: Run) -> tuple[float, float]:
    """Height of the bed, up to where the solid fraction is half of its middle's; twice that of the centre of mass."""
    state, _, heavy = run.seen()
    top = float(state.positions_m[:, 2].max()) + D
    edges = np.linspace(0.0, top, 31)
    radius = REACTOR_M / 2
    profile = measures.monte_carlo_solid_fraction(
        state, run.shapes, edges, min_m=(-radius, -radius, 0), max_m=(radius, radius, top), points_per_layer=6000
    )
    solid = profile.solid_fraction
    full = np.median(solid[5:20])
    surface = float(profile.edges_m[np.flatnonzero(solid > 0.5 * full)[-1] + 1])
    return surface, 2 * float(measures.centre_of_mass_m(state.positions_m, heavy.mass_kg)[2])


def bed(opts: Options, rows: Rows, shape: str) -> None:
    """Fills the reactor with a shape."""
    with launched(opts, shape, reactor()) as run:
        fill(opts, run, shape)
        start = run.notes.setdefault("filled_s", run.time_s)
        settled = settle(run, window_s=0.02, longest_s=start + opts.pick(0.02, 0.5, 3.0), size_m=D)
        run.save()
        surface, twice = height_m(run)
        volume = run.info.particles * np.pi * D**3 / 6
        area = np.pi * REACTOR_M**2 / 4
        name = f"G7-{shape}"
        found = [
            run.row(name, "height of the bed", 1e3 * surface, unit="mm"),
            run.row(name, "twice the height of the centre of mass", 1e3 * twice, unit="mm"),
            run.row(name, "porosity from floor to surface", 100 * (1 - volume / (area * surface)), unit="%"),
            run.row(name, "came to rest", float(settled)),
        ]
        rows.keep(shape, found)
        portrait(opts, run, f"bed_{shape}.png", f"{run.info.particles} particles: {shape.replace('_', ' ')}")


def ratios(rows: Rows) -> None:
    """Heights over that of spheres."""
    there = [shape for shape in RATIOS if rows.has(shape) and rows.parts[shape][0]["verdict"] != "short"]
    if "sphere" not in there or len(there) < 2 or len(rows.parts.get("ratios", [])) == len(there) - 1:
        return
    found = []
    for shape in there[1:]:
        value = rows.value(shape, "height of the bed") / rows.value("sphere", "height of the bed")
        cost = rows.parts[shape][0]["wall_s"], rows.parts[shape][0]["particle_steps"]
        metric = "height of the bed over that of spheres"
        nan = float("nan")
        found.append(Row(f"G7-{shape}", metric, value, nan, RATIOS[shape], nan, "1", "reported", *cost, SOURCE))
    rows.keep("ratios", found)


def single(opts: Options, rows: Rows) -> None:
    """One particle alone in the drum: how high it is carried, and how much of its energy is of rotation."""
    rate = RPM * 2 * np.pi / 60
    duration = opts.pick(0.05, 10.0, 10.0)
    text = (SCENES / "drum-shapes.toml").read_text()
    text = text.replace("= 1e3", "= 1e5").replace("time_step_s = 2e-5", "time_step_s = 2e-6")
    paths, found, runs = {}, [], []
    for shape in ("sphere", "cross_3d"):
        with launched(opts, f"single-{shape}", text) as run:
            run.simulation.insert_poses(shape=shape, material="grain", positions_m=[[0.0, 0.007, -0.046]])
            run.simulation.set_rotation(boundary="drum", angular_velocity_rad_per_s=rate, ramp_s=0.05)
            path, energy = [], []
            while run.time_s < duration:
                run.advance(0.004)
                state = run.simulation.state()
                path.append([state.time_s, *state.positions_m[0]])
                heavy = measures.bodies(state, run.shapes, run.densities)
                parts = measures.energy_partition(state, heavy)
                energy.append([parts.translation_j, parts.rotation_j])
            place, shares = np.array(path), np.array(energy)
            late = place[:, 0] > 0.1 * duration
            height = (place[late, 3] + DRUM_M) / (2 * DRUM_M)
            ratio = float(shares[late, 0].mean() / shares[late, 1].mean())
            runs.append((float(height.max()), float(np.mean(height)), ratio))
            name, source = f"G9-{shape}", "Rakotonirina 2019, fig. 21"
            found += [
                run.row(name, "greatest height over the drum's diameter", float(height.max()), source=source),
                run.row(name, "mean height over the drum's diameter", float(height.mean())),
                run.row(name, "translational over rotational energy, means", ratio),
            ]
            paths[shape] = place
            if shape == "cross_3d":
                higher, more = float(runs[1][0] > runs[0][0]), float(runs[1][2] > runs[0][2])
                found += [
                    run.row("G9", "the cross rises higher", higher, reference=1.0, tolerance=0.0, source=source),
                    run.row(
                        "G9",
                        "more of the cross's energy is of translation",
                        more,
                        reference=1.0,
                        tolerance=0.0,
                        source=source,
                    ),
                ]
    rows.keep("single", found, paths=paths)


def draw(opts: Options, rows: Rows) -> None:
    """Heights of the beds, and the paths in the drum."""
    there = [shape for shape in RATIOS if rows.has(shape)]
    if there:
        with figure(opts.out / "heights", 5.2, 3.4) as axes:
            x = np.arange(len(there))
            values = [rows.value(shape, "height of the bed") for shape in there]
            axes.bar(x + 0.2, values, 0.38, color=COLOURS[0], label="Sturz")
            if there[0] == "sphere":
                axes.bar(
                    x - 0.2,
                    [RATIOS[shape] * values[0] for shape in there],
                    0.38,
                    color=REFERENCE,
                    label="the text's ratios, times our spheres",
                )
            axes.set_xticks(x, [shape.replace("_", " ") for shape in there])
            axes.set_ylabel("height of the bed, mm")
            axes.set_title("250 particles of one volume in a reactor of 50 mm")
            axes.legend(frameon=False)
    if rows.has("single"):
        paths = rows.arrays("single", "paths")
        with figure(opts.out / "single", 7.2, 4.2, ncols=2) as axes:
            turn = np.linspace(0, 2 * np.pi, 200)
            for axis, shape, colour in zip(axes, ("sphere", "cross_3d"), COLOURS, strict=False):
                axis.plot(np.cos(turn), np.sin(turn), color=REFERENCE, linewidth=1)
                # The drum turns from the bottom to the left; mirrored, as the paper's figure has it.
                axis.plot(-paths[shape][:, 1] / DRUM_M, paths[shape][:, 3] / DRUM_M, color=colour, linewidth=0.6)
                axis.set_aspect("equal")
                axis.set_title(f"{shape.replace('_', ' ')}, {RPM} rpm")
                axis.set_xlabel("x / R")


def main() -> None:
    """Command line."""
    opts = options(__doc__ or "", "reactor", PARTS)
    rows = Rows(opts.out / "rows.json")
    for part in PARTS:
        if opts.wants(part) and not rows.has(part):
            if part == "single":
                single(opts, rows)
            else:
                bed(opts, rows, part)
            draw(opts, rows)
    ratios(rows)
    draw(opts, rows)


if __name__ == "__main__":
    main()
