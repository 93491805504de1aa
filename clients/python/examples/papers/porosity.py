"""G6, I16, I19: porosity of packings of spheres, cylinders, cubes, tetrahedra and crosses of one volume.

Rakotonirina et al. 2019 (Comput. Part. Mech. 6, 55-84), section 4.1, table 5: bi-periodic cell, particles fall in and
come to rest, restitution 0.73, friction 0.55. Part `frictionless`: spheres without friction, random close packing.
Parts `match-<ratio>`: 3D crosses with beams so many times as long as wide, softer and so quicker, to find the ratio
that the paper leaves out. Writes rows.json, porosity.png and profiles.png. Every shape is resumed where it was
interrupted.
"""

from __future__ import annotations

import numpy as np
from common import COLOURS, REFERENCE, SCENES, Options, Row, Rows, Run, figure, launched, options, portrait, settle

import sturz
from sturz import measures

SOURCE = "Rakotonirina 2019, table 5"
D = 3e-3
VOLUME_M3 = np.pi * D**3 / 6
REFERENCES = {
    "sphere": 38.18,
    "cylinder": 38.59,
    "cube": 39.6,
    "tetrahedron": 47.46,
    "cross_2d": 69.46,
    "cross_3d": 79.63,
}
TOLERANCE = {"sphere": 1.5, "cylinder": 1.5, "cube": 1.5, "tetrahedron": 1.5, "cross_2d": np.nan, "cross_3d": np.nan}
# Of the scaled form, in a cell of seven diameters: beds of some eight to twelve diameters.
SCALED_COUNT = {"frictionless": 700, "cross_2d": 250, "cross_3d": 200}
# The window of the shower, over the floor; the paper does not say how high its own is.
WINDOW_M = (0.066, 0.074)
HIGH_WINDOW_M = (0.08, 0.088)
# Polyhedra under the law of points, too: does the law make the difference?
POINTS = ("cube_points", "tetrahedron_points")
# Beam ratios of the 3D cross.
MATCHED = tuple(f"match-{ratio}" for ratio in (4, 5, 6, 7))
PARTS = (*REFERENCES, "frictionless", *POINTS, *MATCHED)
DEFAULT_PARTS = (*REFERENCES, "frictionless")


def scene(opts: Options, part: str) -> str:
    """The bundled scene; a smaller cell for the short form, no friction for random close packing."""
    text = (SCENES / "porosity-shapes.toml").read_text()
    text = text.replace(
        "[0.036, 0.036, 0.0]", opts.pick("[0.014, 0.014, 0.0]", "[0.021, 0.021, 0.0]", "[0.036, 0.036, 0.0]")
    )
    if opts.size == "short":
        text = text.replace("stiffness_n_per_m = 1e5", "stiffness_n_per_m = 1e4").replace("2e-6", "5e-6")
    if part == "frictionless" and opts.size == "scaled":  # it rests slowly; at rest softness does not matter
        text = text.replace("stiffness_n_per_m = 1e5", "stiffness_n_per_m = 1e4").replace("2e-6", "6e-6")
    if part in MATCHED:
        ratio = float(part.split("-")[1])
        width = (VOLUME_M3 / (3 * ratio - 2)) ** (1 / 3)
        text = text.replace(
            "beam_length_m = 5.1417e-3, beam_width_m = 1.02834e-3",
            f"beam_length_m = {ratio * width:.6g}, beam_width_m = {width:.6g}",
        )
        text = text.replace("stiffness_n_per_m = 1e5", "stiffness_n_per_m = 2.5e4").replace("2e-6", "4e-6")
    if part in POINTS:
        text = text.replace("generalized_overlap = { rounding_fraction = 0.05 }", 'normal = "linear"')
    return text.replace("friction = 0.55", "friction = 0.0") if part == "frictionless" else text


def shower(run: Run, shape: str, count: int, window_m: tuple[float, float]) -> None:
    """Lets particles fall from a window at the top, at random places and orientations, as many as find room."""
    side = run.info.domain.max_m[0]
    reach = 4e-3
    region = sturz.Box((-reach, -reach, window_m[0]), (side + reach, side + reach, window_m[1]))
    batch = max(int(0.1 * side**2 * (window_m[1] - window_m[0]) / VOLUME_M3), 1)
    while run.info.particles < count:
        try:
            wanted = min(batch, count - run.info.particles)
            run.simulation.insert_random(shape=shape, material="grain", region=region, count=wanted)
        except sturz.CommandError as error:
            if "no free place" not in error.message:
                raise
            batch = max(batch - 1, 1)
        run.advance(0.01)


def measure(run: Run, part: str, shape: str, settled: bool) -> tuple[list[Row], dict[str, np.ndarray]]:
    """Porosity of the bulk and of the whole, coordination number."""
    state, contacts, heavy = run.seen()
    domain = run.info.domain
    top = float(state.positions_m[:, 2].max()) + 0.5 * D
    edges = np.linspace(0.0, top, max(int(top / (0.1 * D)), 4) + 1)
    area = float(np.prod(domain.max_m[:2] - domain.min_m[:2]))
    if shape.startswith("cross"):  # its beams overlap: no formula
        profile = measures.monte_carlo_solid_fraction(
            state, run.shapes, edges, min_m=domain.min_m, max_m=domain.max_m, points_per_layer=4000, domain=domain
        )
    else:
        profile = measures.solid_fraction_profile(state, run.shapes, edges, area_m2=area)
    # The bed ends where half of the bulk's solid fraction is reached, seen from above.
    full = np.median(profile.solid_fraction[(profile.middles_m > 0.2 * top) & (profile.middles_m < 0.6 * top)])
    surface = profile.edges_m[np.flatnonzero(profile.solid_fraction > 0.5 * full)[-1] + 1]
    # Spheres without friction form layers on the floor, several diameters high.
    low, high = min((5 if part == "frictionless" else 2) * D, 0.3 * surface), max(surface - 2 * D, 0.6 * surface)
    bulk, _ = profile.mean(low, high)
    slices = np.array([profile.mean(a, a + (high - low) / 4)[0] for a in np.linspace(low, high, 5)[:4]])
    whole = float(heavy.volume_m3.sum()) / (area * surface)
    touching = measures.coordination(state, contacts, least_neighbours=4 if part == "frictionless" else 3)
    z = state.positions_m[:, 2]
    inner = (z > low) & (z < high) & ~touching.is_rattler
    carried = float(touching.per_particle_without_rattlers[inner].mean()) if inner.any() else np.nan
    name = f"I16-{part}" if part == "frictionless" else f"G6-{part}"
    error = 100 * float(slices.std(ddof=1) / 2)
    rows = []
    if part == "frictionless":
        rows.append(
            run.row(
                name,
                "solid fraction of the bulk",
                bulk,
                uncertainty=error / 100,
                reference=0.64,
                tolerance=0.005,
                source="random close packing of spheres",
            )
        )
        rows.append(
            run.row(
                name,
                "coordination number of the bulk without rattlers",
                carried,
                reference=6.0,
                tolerance=0.1,
                source="isostatic",
            )
        )
    else:
        rows.append(
            run.row(
                name,
                "porosity of the bulk",
                100 * (1 - bulk),
                uncertainty=error,
                reference=REFERENCES[shape],
                tolerance=TOLERANCE[shape],
                unit="%",
                source=SOURCE,
            )
        )
        rows.append(
            run.row(
                name,
                "porosity from floor to surface",
                100 * (1 - whole),
                reference=REFERENCES[shape],
                unit="%",
                source=SOURCE,
            )
        )
        rows.append(run.row(name, "coordination number", touching.mean))
        rows.append(run.row(name, "coordination number without rattlers", touching.mean_without_rattlers))
    report = run.simulation.report()
    rows.append(run.row(name, "largest overlap over bounding radius, whole run", report.largest_overlap_ratio_so_far))
    rows.append(run.row(name, "came to rest", float(settled)))
    return rows, {"edges_m": profile.edges_m, "solid_fraction": profile.solid_fraction, "surface_m": np.array(surface)}


def pack(opts: Options, rows: Rows, part: str) -> None:
    """One packing."""
    shape = "sphere" if part == "frictionless" else "cross_3d" if part in MATCHED else part.removesuffix("_points")
    count = opts.pick(12, SCALED_COUNT.get(shape, 450), 1000)
    if part == "frictionless":
        count = opts.pick(12, SCALED_COUNT[part], 2000)
    with launched(opts, part, scene(opts, part)) as run:
        if run.info.particles < count:
            high = HIGH_WINDOW_M if part == "frictionless" else WINDOW_M
            shower(run, shape, count, opts.pick((0.015, 0.023), high, high))
            run.save()
        longest = run.notes.setdefault("shower_end_s", run.time_s) + opts.pick(0.02, 1.0, 3.0)
        quiet = 1e-11 if part == "frictionless" else 1e-6
        settled = settle(run, window_s=0.01, longest_s=longest, size_m=D, quiet=quiet)
        run.save()
        found, profile = measure(run, part, shape, settled)
        rows.keep(part, found, profile=profile)
        state = run.simulation.state()
        portrait(opts, run, f"packing_{part}.png", f"{len(state)} particles: {part.replace('_', ' ')}")


def draw(opts: Options, rows: Rows) -> None:
    """Figures of what is there."""
    shapes = [shape for shape in REFERENCES if rows.has(shape)]
    if not shapes:
        return
    with figure(opts.out / "porosity") as axes:
        x = np.arange(len(shapes))
        axes.bar(x - 0.2, [REFERENCES[shape] for shape in shapes], 0.38, color=REFERENCE, label=SOURCE)
        values = [rows.value(shape, "porosity of the bulk") for shape in shapes]
        axes.bar(x + 0.2, values, 0.38, color=COLOURS[0], label="Sturz, bulk")
        for k, value in enumerate(values):
            axes.text(k + 0.2, value + 1, f"{value:.1f}", ha="center", fontsize=8)
            axes.text(
                k - 0.2,
                REFERENCES[shapes[k]] + 1,
                f"{REFERENCES[shapes[k]]:.1f}",
                ha="center",
                fontsize=8,
                color="#7a8791",
            )
        axes.set_xticks(x, [shape.replace("_", " ") for shape in shapes])
        axes.set_ylabel("porosity, %")
        axes.set_ylim(0, 95)
        axes.set_title("Packings of particles of one volume")
        axes.legend(frameon=False, loc="upper left")
    with figure(opts.out / "profiles") as axes:
        for k, shape in enumerate(shapes):
            kept = rows.arrays(shape, "profile")
            middle = 0.5 * (kept["edges_m"][1:] + kept["edges_m"][:-1])
            axes.plot(middle / D, kept["solid_fraction"], color=COLOURS[k], linewidth=1, label=shape.replace("_", " "))
        axes.set_xlabel("height over the floor / diameter of the sphere of the same volume")
        axes.set_ylabel("solid fraction")
        axes.set_title("Solid fraction from floor to surface")
        axes.legend(frameon=False, ncols=2)


def main() -> None:
    """Command line."""
    opts = options(__doc__ or "", "porosity", PARTS)
    rows = Rows(opts.out / "rows.json")
    for part in PARTS:
        if (opts.wants(part) if opts.only else part in DEFAULT_PARTS) and not rows.has(part):
            pack(opts, rows, part)
            draw(opts, rows)
    draw(opts, rows)


if __name__ == "__main__":
    main()
