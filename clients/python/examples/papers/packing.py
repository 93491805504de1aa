"""K1: gravity packing of frictionless pinacoids, as Descantes 2022 (Powder Technology 401, 117295), section 3.1.

Scaled (K1s): 625 pinacoids on 5 x 5 circumscribed diameters. Part `default` uses the law that conserves energy
(generalized overlap), part `shared` the paper's eq. 3 (linear, largest overlap shared by the points), part `deposited`
the default law on a bed of deposited spheres, as the paper prepares its own. Each further part changes one thing, to
tell why the numbers are what they are: `sharper` is `deposited` with less rounding, the others go on from where
`deposited` ended. Writes rows.json, profiles.png (solid fraction, stress, coordination, pair correlation) and a picture
of each packing.
"""

from __future__ import annotations

import numpy as np
from common import COLOURS, REFERENCE, SCENES, Options, Row, Rows, Run, figure, launched, options, portrait

from sturz import measures

SOURCE = "Descantes 2022, section 3.1"
# Of the mean circumscribed diameter, which is 1.
D_EQ = 0.648433
T_INERTIA = 0.805254
VOLUME = 0.142756004
MAIN = ("default", "shared", "deposited")
# What else: of the bundled scene, and instead.
CHANGED = {
    "sharper": ("rounding_fraction = 0.05", "rounding_fraction = 0.02"),
    "finer": ("time_step_s = 3.2e-4", "time_step_s = 1.6e-4"),
    "undamped": ("local_damping = 0.7", "local_damping = 0.0"),
    "inelastic": ("restitution = 0.5", "restitution = 0.2"),
}
LATER = ("finer", "undamped", "inelastic")
PARTS = (*MAIN, *CHANGED)
SHARED = """normal = "linear"
sharing = "max_overlap_shared"
"""


def scene(opts: Options, part: str) -> str:
    """The bundled scene, with the law of the part and the size of the options."""
    text = (SCENES / "packing-pinacoids.toml").read_text()
    if part == "shared":
        text = text.replace("generalized_overlap = { rounding_fraction = 0.05 }\n", SHARED)
    if part in CHANGED:
        text = text.replace(*CHANGED[part])
    if part in ("deposited", "sharper"):
        text = text.replace('method = "random"', 'method = "deposition"').replace(
            "[-0.55, -0.55, 0.0]", "[0.0, 0.0, 0.0]"
        )
        text = text.replace("[5.55, 5.55, 16.0]", "[5.0, 5.0, 60.0]")
    if part in LATER:
        text = text[: text.index("[[insertion]]")]
    if opts.size == "short":
        text = text.replace("[5.0, 5.0, 0.0]", "[2.5, 2.5, 0.0]").replace("[5.55, 5.55, 16.0]", "[3.05, 3.05, 6.0]")
        text = text.replace("count = 625", "count = 25").replace("[5.0, 5.0, 60.0]", "[2.5, 2.5, 60.0]")
    if opts.size == "full":
        text = text.replace("[5.0, 5.0, 0.0]", "[10.0, 10.0, 0.0]").replace("[5.55, 5.55", "[10.55, 10.55")
        text = text.replace("[5.0, 5.0, 60.0]", "[10.0, 10.0, 60.0]")
        text = text.replace("count = 625", "count = 2500").replace("3.2e-4", "2.5164e-5")
        text = text.replace("stiffness_n_per_m = 1100.8", "stiffness_n_per_m = 17612.4")
        text = text.replace("restitution = 0.5", "damping_n_s_per_m = 70.91")
    return text


def lay(run: Run, bed: dict[str, np.ndarray]) -> None:
    """The bed that another part left, at rest."""
    for position, orientation, scale in zip(bed["x"], bed["q"], bed["scales"], strict=True):
        run.simulation.insert_poses(
            shape="pinacoid",
            material="stone",
            positions_m=[position],
            orientations_wxyz=[orientation],
            scale=float(scale),
        )
    run.info = run.simulation.info()
    run.save()


def weight_n(run: Run) -> float:
    """Of all particles."""
    state, _, heavy = run.seen()
    return float(heavy.mass_kg.sum() * np.linalg.norm(state.gravity_m_per_s2))


def wait(opts: Options, run: Run, part: str) -> None:
    """Lets the packing densify until its kinetic energy is 1e-8 of the potential one, or for 100 inertial times."""
    longest = (opts.pick(3.0, 20.0, 40.0) if part in LATER else opts.pick(3.0, 100.0, 437.5)) * T_INERTIA
    history = run.notes.setdefault("history", [])
    weight = weight_n(run)
    windows = 0
    while run.time_s < longest * (1 - 1e-9):
        run.advance(min(T_INERTIA, longest - run.time_s))
        energy = run.simulation.report().energy
        kinetic = energy.kinetic_translation_j + energy.kinetic_rotation_j
        # The mean height of the bed tells of sinking, the residual of energy that the time step makes.
        height = energy.potential_j / weight / D_EQ
        lost = energy.dissipated_normal_j + energy.dissipated_local_j
        history.append([run.time_s / T_INERTIA, kinetic / energy.potential_j, height, energy.residual_j, lost])
        windows += 1
        if windows % 10 == 0:
            run.save()
        if kinetic < 1e-8 * energy.potential_j and run.time_s > 20 * T_INERTIA:
            break


def average(opts: Options, run: Run) -> dict[str, np.ndarray]:
    """Profiles and numbers of several configurations, 2000 steps apart."""
    area = float(np.prod(run.info.domain.max_m[:2] - run.info.domain.min_m[:2]))
    frames: list[dict[str, np.ndarray]] = []
    for frame in range(opts.pick(2, 5, 5)):
        if frame:
            run.advance(opts.pick(20, 2000, 2000) * run.info.time_step_s)
        state, contacts, heavy = run.seen()
        z = state.positions_m[:, 2]
        top = float(z.max())
        fine = np.arange(0.0, top + 0.5, 0.1 * D_EQ)
        coarse = np.arange(0.0, top + 0.5, 0.5 * D_EQ)
        fraction = measures.solid_fraction_profile(state, run.shapes, fine, area_m2=area)
        stress = measures.layer_stress(state, contacts, heavy, coarse, area_m2=area, domain=run.info.domain)
        types = measures.contact_types(state, contacts, run.shapes)
        central = (z >= 3 * D_EQ) & (z <= min(6 * D_EQ, top - D_EQ))
        shares = measures.type_shares(state, contacts, types, selected=central)
        touching = measures.coordination(state, contacts, with_walls=True)
        layer = np.searchsorted(coarse, z, side="right") - 1
        of_types = [
            measures.type_shares(state, contacts, types, selected=layer == k, with_walls=True).contacts_per_particle
            for k in range(len(coarse) - 1)
        ]
        energy = run.simulation.report().energy
        parts = measures.energy_partition(state, heavy, energy)
        order = [measures.nematic_order(state.rotations()[:, :, k]) for k in range(3)]
        thick = int(np.argmax(run.shapes[0].principal_moments_per_density_m5))
        floor = float(run.simulation.state(columns=["forces"]).boundaries[0].force_n[2])
        frames.append(
            {
                "fine_m": fine,
                "coarse_m": coarse,
                "solid_fraction": fraction.solid_fraction,
                "stress_pa": stress.contact,
                "weight_pa": stress.weight_pa,
                "types": np.array(of_types),
                "nu": np.array(fraction.mean(3 * D_EQ, min(6 * D_EQ, top - D_EQ))[0]),
                "z": np.array(touching.per_particle[central].mean() if central.any() else np.nan),
                "rattlers": np.array(touching.is_rattler.mean()),
                "shares": np.array([shares.single, shares.edge_face, shares.face_face]),
                "z_iso": np.array(shares.z_iso),
                "kinetic": np.array(parts.kinetic_over_potential),
                "order": np.array([order[thick].order, order[thick].baseline, order[thick].baseline_deviation]),
                "orders": np.array([each.order for each in order]),
                "overlap": np.array([contacts.overlaps_m.mean(), contacts.overlaps_m.max()]),
                "floor": np.array(-floor / area),
                "height": np.array(top),
                "weight": np.array(heavy.mass_kg.sum() / area),
            }
        )
    # Layers of all frames: those that all of them have.
    mean = {}
    for name in frames[0]:
        length = min(len(np.atleast_1d(frame[name])) for frame in frames)
        mean[name] = np.mean([np.atleast_1d(frame[name])[:length] for frame in frames], axis=0)
        mean[f"{name}_spread"] = np.std([np.atleast_1d(frame[name])[:length] for frame in frames], axis=0)
    state = run.simulation.state()
    low, high = run.info.domain.min_m.copy(), run.info.domain.max_m.copy()
    low[2], high[2] = 2 * D_EQ, float(state.positions_m[:, 2].max()) - D_EQ
    pairs = measures.pair_correlation(
        state.positions_m, np.arange(0.3, 2.45, 0.05), min_m=low, max_m=high, domain=run.info.domain
    )
    mean["r_m"], mean["g"] = pairs.distances_m, pairs.g
    return mean


def rows_of(run: Run, part: str, m: dict[str, np.ndarray]) -> list[Row]:
    """The numbers beside those of the paper."""
    middles = 0.5 * (m["coarse_m"][1:] + m["coarse_m"][:-1])
    bulk = (middles > 2 * D_EQ) & (middles < m["height"][0] - D_EQ)
    stress = m["stress_pa"][bulk].mean(axis=0) if bulk.any() else np.full((3, 3), np.nan)
    if stress[2, 2] == 0.0:  # nothing presses yet
        stress = np.full((3, 3), np.nan)
    above = m["weight_pa"][bulk].mean() if bulk.any() else np.nan
    name = f"K1s-{part}"

    def row(metric: str, value: float, reference: float = np.nan, tolerance: float = np.nan, **more) -> Row:
        source = more.pop("source", SOURCE if np.isfinite(reference) else "")
        return run.row(name, metric, float(value), reference=reference, tolerance=tolerance, source=source, **more)

    return [
        row("solid fraction, z in 3 to 6 d_eq", m["nu"][0], 0.67, 0.01, uncertainty=float(m["nu_spread"][0])),
        row("coordination number, z in 3 to 6 d_eq", m["z"][0], 8.3, 0.4, uncertainty=float(m["z_spread"][0])),
        row("share of single contacts", 100 * m["shares"][0], 76.0, unit="%"),
        row("share of edge-face contacts", 100 * m["shares"][1], 21.0, unit="%"),
        row("share of face-face contacts", 100 * m["shares"][2], 3.0, unit="%"),
        row("constraints per particle z_iso", m["z_iso"][0], 11.0),
        row("share of rattlers", 100 * m["rattlers"][0], unit="%"),
        row("nematic order of the thickness", m["order"][0], 0.18),
        row("the same of as many random axes", m["order"][1]),
        row("pressure on the floor over the weight", m["floor"][0] / m["weight"][0], 1.0, 0.01, source="balance"),
        row("sigma_zz over the weight above in the bulk", stress[2, 2] / above, 1.0, source="balance"),
        row("sigma_xx over sigma_zz in the bulk", stress[0, 0] / stress[2, 2], 1.0, 0.05),
        row("sigma_yy over sigma_zz in the bulk", stress[1, 1] / stress[2, 2], 1.0, 0.05),
        row("sigma_yz over sigma_zz in the bulk", abs(stress[1, 2]) / stress[2, 2], 0.0, 0.02),
        row("kinetic over potential energy", m["kinetic"][0], 0.0, 1e-7),
        row("mean overlap over d_sph", m["overlap"][0], 3.9e-4, 0.4 * 3.9e-4, source="contact force from the weight"),
        row("largest overlap over d_sph", m["overlap"][1]),
        row("height of the highest centre over d_sph", m["height"][0], 5.33),
    ]


def draw(opts: Options, rows: Rows) -> None:
    """Figures 7, 8 and 9 of the paper."""
    parts = [part for part in MAIN if rows.has(part)]
    if not parts:
        return
    names = {
        "default": "generalized overlap",
        "shared": "largest overlap shared (paper's law)",
        "deposited": "generalized overlap, deposited",
    }
    with figure(opts.out / "profiles", 9.6, 6.4, nrows=2, ncols=2) as axes:
        for colour, part in zip(COLOURS, parts, strict=False):
            m = rows.arrays(part, "profiles")
            z = 0.5 * (m["fine_m"][1:] + m["fine_m"][:-1]) / D_EQ
            axes[0, 0].plot(z, m["solid_fraction"], color=colour, linewidth=1, label=names[part])
            layer = 0.5 * (m["coarse_m"][1:] + m["coarse_m"][:-1]) / D_EQ
            for k, (style, index) in enumerate(zip(("-", "--", ":"), ((2, 2), (0, 0), (1, 1)), strict=True)):
                label = ("σzz", "σxx", "σyy")[k] if part == parts[0] else None
                axes[0, 1].plot(layer, m["stress_pa"][:, *index], style, color=colour, linewidth=1.1, label=label)
            axes[0, 1].plot(
                layer,
                m["stress_pa"][:, 1, 2],
                "-.",
                color=colour,
                linewidth=0.8,
                label="σyz" if part == parts[0] else None,
            )
            total = m["types"].sum(axis=1)
            axes[1, 0].plot(layer, total, "-", color=colour, label=f"total, {names[part]}")
            axes[1, 0].plot(layer, m["types"][:, 0], "--", color=colour, linewidth=0.9, label="single")
            axes[1, 0].plot(layer, m["types"][:, 1], ":", color=colour, linewidth=0.9, label="edge-face")
            axes[1, 0].plot(layer, m["types"] @ [1, 2, 3], "-.", color=colour, linewidth=0.9, label="z_iso")
            axes[1, 1].plot(m["r_m"], m["g"], color=colour, linewidth=1.1, label=names[part])
        m = rows.arrays(parts[0], "profiles")
        layer = 0.5 * (m["coarse_m"][1:] + m["coarse_m"][:-1]) / D_EQ
        axes[0, 1].plot(layer, m["weight_pa"], color=REFERENCE, linewidth=2.5, zorder=0, label="weight above")
        axes[0, 0].hlines(0.67, 3, 6, color=REFERENCE, linewidth=3, zorder=0, label="paper: 0.67")
        axes[1, 0].hlines(8.3, 3, 6, color=REFERENCE, linewidth=3, zorder=0, label="paper: total 8.3")
        axes[1, 0].hlines(11.0, 3, 6, color=REFERENCE, linewidth=3, linestyle=":", zorder=0, label="paper: z_iso 11")
        axes[1, 1].axhline(1.0, color=REFERENCE, linewidth=2, zorder=0)
        for each, title, x, y in zip(
            np.ravel(axes),
            ("Solid fraction (fig. 7)", "Stress (fig. 8)", "Coordination (fig. 9b)", "Pair correlation (fig. 9a)"),
            ("z / d_eq", "z / d_eq", "z / d_eq", "r / d_sph"),
            ("solid fraction", "stress / (ρ g d_sph)", "contacts per particle", "g(r)"),
            strict=True,
        ):
            each.set_title(title)
            each.set_xlabel(x)
            each.set_ylabel(y)
            each.legend(frameon=False, fontsize=7, loc="best" if each is not axes[1, 0] else "upper center", ncols=2)
            each.set_ylim(bottom=0 if each is not axes[0, 1] else None)
        axes[1, 0].set_ylim(top=19)


def main() -> None:
    """Command line."""
    opts = options(__doc__ or "", "packing", PARTS)
    rows = Rows(opts.out / "rows.json")
    for part in PARTS:
        if (opts.wants(part) if opts.only else part in MAIN) and not rows.has(part):
            with launched(opts, part, scene(opts, part)) as run:
                if part in LATER and not run.resumed:
                    lay(run, rows.arrays("deposited", "bed"))
                wait(opts, run, part)
                run.save()
                m = average(opts, run)
                history = np.array(run.notes["history"])
                m["history"] = history
                state = run.simulation.state()
                bed = {"x": state.positions_m, "q": state.orientations_wxyz, "scales": state.scales}
                rows.keep(part, rows_of(run, part, m), profiles=m, bed=bed)
                portrait(opts, run, f"packing_{part}.png", f"{len(state)} pinacoids")
            draw(opts, rows)
    draw(opts, rows)


if __name__ == "__main__":
    main()
