"""I14, I15: steady flow of spheres down a bumpy incline: Bagnold's profile, and friction over inertial number.

Spheres of Silbert et al. 2001 (k = 2e5 m g/d, k_t = 2/7 k, restitution 0.88, friction 0.5; m = d = g = 1), scaled: 6 x
5 diameters, flows of 8 to 16 diameters; diameters differ by up to a tenth, else the flow orders itself into layers in
so narrow a cell and goes faster and faster. A part is angle and number of spheres: three heights at 24 degrees, one at
21 to 26. Flows start near Bagnold's profile with the mu(I) of glass, and run until the kinetic energy is steady.
Writes rows.json, bagnold.png (velocity and solid fraction over height) and mu_of_i.png.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from common import COLOURS, REFERENCE, SCENES, Options, Row, Rows, Run, figure, launched, options, portrait

import sturz
from sturz import measures

X, Y = 6.0, 5.0
PARTS = ("24-400", "24-260", "24-520", "22-400", "26-400", "23-400", "25-400", "21-400")
GRAIN = 6 / np.pi  # density of a mass of 1 in a diameter of 1
GLASS = (0.38, 0.64, 0.279)  # mu_s, mu_2, I_0 of glass beads
SHORTEST = 80.0  # sqrt(d/g): two relaxation times of a flow of 10 d, one of 15 d


def scene(angle: float) -> str:
    """The bundled scene at another angle, without its own cloud."""
    text = (SCENES / "bagnold-spheres.toml").read_text()
    theta = np.deg2rad(angle)
    text = text.replace("[0.4067366, 0.0, -0.9135455]", f"[{np.sin(theta):.9f}, 0.0, {-np.cos(theta):.9f}]")
    return text[: text.rindex("[[insertion]]")]


def bagnold(height: float, inertial: float, angle: float, z: Any, nu: float = 0.57) -> Any:
    """Velocity at heights z over the base, PHYSICS.md I15, with d = g = 1."""
    scale = 2 / 3 * inertial * math.sqrt(nu * math.cos(math.radians(angle))) * height**1.5
    return scale * (1 - np.clip(1 - np.asarray(z) / height, 0, 1) ** 1.5)


def pour(run: Run, angle: float, count: int) -> None:
    """A cloud a third as dense as the flow, in slabs that have the velocity of the height to which they sink."""
    mu_s, mu_2, i_0 = GLASS
    mu = math.tan(math.radians(angle))
    inertial = max(i_0 * (mu - mu_s) / (mu_2 - mu), 0.005)
    cloud, thick = 0.2, 2.0
    height = count * np.pi / 6 / (X * Y * 0.57)
    low, left = 1.0, count
    while left > 0:
        batch = min(left, int(cloud * X * Y * thick * GRAIN))
        speed = float(bagnold(height, inertial, angle, (low + thick / 2) * cloud / 0.57))
        region = sturz.Box((-0.6, -0.6, low - 0.5), (X + 0.6, Y + 0.6, low + thick + 0.5))
        run.simulation.insert_random(
            shape="ball", material="grain", region=region, count=batch, velocity_m_per_s=(speed, 0, 0), scale=(0.9, 1.1)
        )
        left, low = left - batch, low + thick


def flow(opts: Options, run: Run) -> np.ndarray:
    """Lets it flow until the kinetic energy of the last third changes by less than 2 %; time, energy, mean velocity."""
    shortest = opts.pick(3.0, SHORTEST, 3 * SHORTEST)
    history = run.notes.setdefault("history", [])
    moving = run.simulation.state(columns=["frozen"]).frozen == 0
    while True:
        run.advance(opts.pick(0.5, 1.0, 1.0))
        v = run.simulation.state(columns=["velocities"]).velocities_m_per_s[moving]
        history.append([run.time_s, 0.5 * float((v**2).sum()), float(v[:, 0].mean())])
        if len(history) % 20 == 0:
            run.save()
        enough = run.time_s >= shortest * (1 - 1e-9)
        if enough and (change(np.array(history)) < 0.02 or run.time_s >= 1.5 * shortest):
            return np.array(history)


def change(history: np.ndarray) -> float:
    """Change of the kinetic energy over the last third, by a straight line, over its mean."""
    last = history[-max(len(history) // 3, 3) :]
    mean = last[:, 1].mean()
    return abs(np.polyfit(last[:, 0], last[:, 1], 1)[0]) * (last[-1, 0] - last[0, 0]) / mean if mean > 0 else 0.0


def profiles(opts: Options, run: Run) -> dict[str, np.ndarray]:
    """Means over time in layers of a diameter, of the spheres that flow."""
    domain = run.info.domain
    top = float(run.simulation.state().positions_m[:, 2].max()) + 1.0
    edges = np.arange(0.5, max(top, 4.0), 1.0)
    stresses, solids, states = [], [], []
    for _ in range(opts.pick(3, 160, 600)):
        run.advance(0.25)
        state, contacts, heavy = run.seen()
        states.append(state)
        stress = measures.layer_stress(state, contacts, heavy, edges, area_m2=X * Y, domain=domain)
        stresses.append(np.stack([stress.contact, stress.kinetic]))
        solids.append(measures.solid_fraction_profile(state, run.shapes, edges, area_m2=X * Y).solid_fraction)
    motion = measures.velocity_profile(states, heavy.mass_kg, edges)
    contact, kinetic = np.mean(stresses, axis=0)
    return {
        "edges": edges,
        "contact": contact,
        "kinetic": kinetic,
        "solid_fraction": np.mean(solids, axis=0),
        "velocity": motion.velocity_m_per_s[:, 0],
        "temperature": motion.granular_temperature_m2_per_s2,
    }


def surface_height(edges: np.ndarray, solid: np.ndarray) -> float:
    """Where the solid fraction falls to half of that of the bulk, between layers by a straight line."""
    middles = 0.5 * (edges[1:] + edges[:-1])
    half = 0.5 * float(np.median(solid[solid > 0.3])) if (solid > 0.3).any() else 0.5 * float(solid.max())
    last = int(np.flatnonzero(solid > half)[-1])
    if last + 1 == len(solid):
        return float(middles[last])
    return float(np.interp(-half, -solid[last : last + 2], middles[last : last + 2]))


def fit_depth(z: np.ndarray, velocity: np.ndarray, height: float, power: float) -> tuple[np.ndarray, float]:
    """Slip and rise of v = slip + rise (1 - (1 - z/h)^power) by least squares, and the root mean square left over."""
    form = np.stack([np.ones_like(z), 1 - np.clip(1 - z / height, 0, 1) ** power], axis=1)
    found = np.linalg.lstsq(form, velocity, rcond=None)[0]
    return found, float(np.sqrt(((form @ found - velocity) ** 2).mean()))


def measure(run: Run, part: str, history: np.ndarray, kept: dict[str, np.ndarray]) -> list[Row]:
    """What the profiles say about Bagnold's."""
    angle = float(part.split("-")[0])
    tangent = math.tan(math.radians(angle))
    middles = 0.5 * (kept["edges"][1:] + kept["edges"][:-1])
    height = surface_height(kept["edges"], kept["solid_fraction"])
    bulk = (middles > 2.0) & (middles < height - 2.0)
    if bulk.sum() < 3:  # short form
        bulk = np.isfinite(kept["velocity"])
    z, v = middles[bulk], kept["velocity"][bulk]
    total = kept["contact"] + kept["kinetic"]
    ratio = -total[bulk, 0, 2].sum() / total[bulk, 2, 2].sum()
    each = -total[bulk, 0, 2] / total[bulk, 2, 2]
    error = float(each.std(ddof=1) / math.sqrt(len(each)))
    contact_ratio = -kept["contact"][bulk, 0, 2].sum() / kept["contact"][bulk, 2, 2].sum()
    rate = np.gradient(kept["velocity"], middles)[bulk]
    inertial = measures.inertial_number(rate, 1.0, GRAIN, total[bulk, 2, 2])
    solid = kept["solid_fraction"][bulk]
    (slip, rise), left = fit_depth(z, v, height, 1.5)
    powers = np.arange(0.6, 3.01, 0.02)
    power = float(powers[np.argmin([fit_depth(z, v, height, p)[1] for p in powers])])
    fitted = slip + rise * (1 - np.clip(1 - z / height, 0, 1) ** 1.5)
    changed = change(history)
    steady = changed < 0.02
    mean_i, mean_nu = float(np.mean(inertial)), float(solid.mean())
    name = f"I15-{part}"
    kept |= {"height": np.array(height), "inertial": inertial, "bulk": bulk, "fit": np.array([slip, rise])}
    balance: dict[str, Any] = {"reference": tangent, "source": "balance of momentum"}
    balance["tolerance"] = 0.01 * tangent if steady else np.nan
    gate: dict[str, Any] = {"tolerance": 0.05 if steady else np.nan, "source": "Bagnold's profile"}
    uneven = float(np.abs(solid / mean_nu - 1).max())
    away = float(np.abs(fitted - v).max() / (slip + rise))
    expected = float(bagnold(height, mean_i, angle, height, mean_nu))
    return [
        run.row(name, f"regime: {'steady' if steady else 'not steady'}", np.nan),
        run.row(name, "change of the kinetic energy over the last third", changed),
        run.row(name, "height over d", height),
        run.row(name, "shear over normal stress, contact + kinetic", ratio, uncertainty=error, **balance),
        run.row(name, "shear over normal stress, contact alone", contact_ratio, reference=tangent),
        run.row(name, "solid fraction of the bulk", mean_nu, uncertainty=float(solid.std())),
        run.row(
            name, "largest deviation of the solid fraction of a layer over the mean", uneven, reference=0.0, **gate
        ),
        run.row(name, "largest deviation from Bagnold's profile over v_max", away, reference=0.0, **gate),
        run.row(name, "fitted exponent of the depth", power, reference=1.5),
        run.row(name, "root mean square left by the fit over v_max", left / (slip + rise)),
        run.row(name, "slip at the base over v_max", slip / (slip + rise)),
        run.row(name, "v_max over sqrt(g d)", float(slip + rise)),
        run.row(name, "v_max over (2/3) I sqrt(nu cos) h^1.5", (slip + rise) / expected, reference=1.0, **gate),
        run.row(name, "the same of v_max - slip", rise / expected, reference=1.0, **gate),
        run.row(name, "inertial number of the bulk", mean_i, uncertainty=float(np.std(inertial))),
    ]


def over_parts(rows: Rows, part: str, id_: str, found: list[tuple[str, float, float, float, str]], of: int) -> None:
    """Rows that several flows make together, with the cost of all; written anew when there are more of them."""
    if rows.value(part, "flows") == of:
        return
    flows = [row[0] for name, row in rows.parts.items() if name in PARTS]
    wall, steps = sum(row["wall_s"] for row in flows), sum(row["particle_steps"] for row in flows)
    every = [Row(id_, "flows", of, math.nan, math.nan, math.nan, "1", "reported", wall, steps, "")]
    for metric, value, reference, tolerance, source in found:
        verdict = "reported" if math.isnan(tolerance) else "pass" if abs(value - reference) <= tolerance else "miss"
        every.append(Row(id_, metric, value, math.nan, reference, tolerance, "1", verdict, wall, steps, source))
    rows.keep(part, every)


def steady_parts(rows: Rows) -> list[str]:
    """Flows that are there, steady, and not of the short form."""
    first = {part: rows.parts[part][0] for part in PARTS if rows.has(part)}
    return [part for part, row in first.items() if row["metric"] == "regime: steady" and row["verdict"] != "short"]


def scaling(rows: Rows) -> None:
    """How the greatest velocity grows with the height, at 24 degrees."""
    there = [part for part in steady_parts(rows) if part.startswith("24-")]
    if len(there) >= 2:
        height = [rows.value(part, "height over d") for part in there]
        speed = [rows.value(part, "v_max over sqrt(g d)") for part in there]
        power = float(np.polyfit(np.log(height), np.log(speed), 1)[0])
        over_parts(
            rows,
            "heights",
            "I15-heights",
            [("exponent of v_max over height", power, 1.5, 0.075, "Bagnold's profile")],
            len(there),
        )


def friction_law(inertial: np.ndarray, mu_s: float, mu_2: float, i_0: float) -> np.ndarray:
    """mu(I) of PHYSICS.md I14."""
    return np.asarray(mu_s + (mu_2 - mu_s) / (i_0 / inertial + 1))


def fit_friction(inertial: np.ndarray, mu: np.ndarray) -> tuple[float, float, float]:
    """mu_s, mu_2 and I_0 by least squares: linear in the first two for each I_0."""
    best, least = (math.nan,) * 3, math.inf
    for i_0 in np.geomspace(0.02, 5.0, 400):
        form = np.stack([1 / (1 + inertial / i_0), 1 / (i_0 / inertial + 1)], axis=1)
        (mu_s, mu_2), *_ = np.linalg.lstsq(form, mu, rcond=None)
        left = float(((form @ np.array([mu_s, mu_2]) - mu) ** 2).sum())
        if left < least:
            best, least = (float(mu_s), float(mu_2), float(i_0)), left
    return best


def rheology(opts: Options, rows: Rows) -> None:
    """mu(I) over the angles."""
    there = steady_parts(rows)
    if len({part.split("-")[0] for part in there}) < 4:
        return
    inertial = np.array([rows.value(part, "inertial number of the bulk") for part in there])
    mu = np.array([rows.value(part, "shear over normal stress, contact + kinetic") for part in there])
    ours = fit_friction(inertial, mu)
    glass = "glass beads, PHYSICS.md I14"
    nan = math.nan
    found = [
        (name, value, reference, nan, glass)
        for name, value, reference in zip(("mu_s", "mu_2", "I_0"), ours, GLASS, strict=True)
    ]
    spread = float(np.sqrt(((friction_law(inertial, *ours) - mu) ** 2).mean()))
    away = float(np.sqrt(((friction_law(inertial, *GLASS) - mu) ** 2).mean()))
    found += [
        ("root mean square of mu about the fitted form", spread, 0.0, 0.005, "form of mu(I)"),
        ("root mean square of mu about that of glass", away, 0.0, nan, glass),
        ("least inertial number", float(inertial.min()), nan, nan, ""),
        ("greatest inertial number", float(inertial.max()), nan, nan, ""),
    ]
    over_parts(rows, "mu_of_i", "I14", found, len(there))
    with figure(opts.out / "mu_of_i", 5.2, 3.6) as axes:
        line = np.linspace(1e-3, 1.3 * inertial.max(), 200)
        axes.plot(line, friction_law(line, *GLASS), color=REFERENCE, linewidth=1.2, label="glass (I14)")
        label = "fit: $\\mu_s$ = {:.3f}, $\\mu_2$ = {:.3f}, $I_0$ = {:.3f}".format(*ours)
        axes.plot(line, friction_law(line, *ours), color=COLOURS[0], linewidth=1, label=label)
        axes.plot(inertial, mu, "o", color=COLOURS[1], markersize=5, label="Sturz, steady flows")
        axes.set_xlabel("inertial number I")
        axes.set_ylabel("shear over normal stress")
        axes.set_title("Friction of the flow over inertial number")
        axes.legend(frameon=False)


def draw(opts: Options, rows: Rows) -> None:
    """Velocity over height, scaled and not, and the solid fraction."""
    there = sorted((part for part in PARTS if rows.has(part)), key=lambda part: tuple(map(int, part.split("-"))))
    if not there:
        return
    with figure(opts.out / "bagnold", 9.6, 3.6, ncols=3) as axes:
        line = np.linspace(0, 1, 100)
        axes[1].plot(1 - (1 - line) ** 1.5, line, color=REFERENCE, linewidth=2.5, label="$1 - (1 - z/h)^{1.5}$")
        for k, part in enumerate(there):
            kept = rows.arrays(part, "profiles")
            z = 0.5 * (kept["edges"][1:] + kept["edges"][:-1])
            inside = z < kept["height"] - 0.5
            slip, rise = kept["fit"]
            colour = COLOURS[k % len(COLOURS)]
            style: dict[str, Any] = {"color": colour, "linewidth": 1, "linestyle": "-" if k < len(COLOURS) else "--"}
            label = "{}°, h = {:.1f} d".format(part.split("-")[0], float(kept["height"]))
            axes[0].plot(kept["velocity"][inside], z[inside], label=label, **style)
            scaled = (kept["velocity"] - slip) / rise
            axes[1].plot(scaled[inside], z[inside] / kept["height"], "o", color=colour, markersize=2.5)
            axes[2].plot(kept["solid_fraction"], z, **style)
        axes[0].set_xlabel("velocity / sqrt(g d)")
        axes[0].set_ylabel("z / d")
        axes[0].set_title("Velocity")
        axes[0].legend(frameon=False, fontsize=7)
        axes[1].set_xlabel("(v - slip) / rise")
        axes[1].set_ylabel("z / h")
        axes[1].set_title("Against Bagnold's profile")
        axes[1].legend(frameon=False)
        axes[2].set_xlabel("solid fraction")
        axes[2].set_xlim(0, 0.7)
        axes[2].set_title("Solid fraction")


def main() -> None:
    """Command line."""
    opts = options(__doc__ or "", "bagnold", PARTS)
    rows = Rows(opts.out / "rows.json")
    for part in PARTS:
        if not opts.wants(part) or rows.has(part):
            continue
        angle, count = (int(each) for each in part.split("-"))
        with launched(opts, part, scene(angle)) as run:
            if not run.resumed:
                pour(run, angle, opts.pick(90, count, 2 * count))
            history = flow(opts, run)
            run.save()
            kept = profiles(opts, run)
            found = measure(run, part, history, kept)
            rows.keep(part, found, profiles=kept | {"history": history})
            portrait(opts, run, f"flow_{part}.png", f"{count} spheres, {angle}°")
        draw(opts, rows)
    scaling(rows)
    rheology(opts, rows)
    draw(opts, rows)


if __name__ == "__main__":
    main()
