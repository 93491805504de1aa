"""K2: dense flow of frictional pinacoids down a rough incline, as Descantes 2022 (Powder Technology 401, 117295), 3.2.

Scaled (K2s): 5 x 5 circumscribed diameters. Parts are law and angle: `default` (generalized overlap, friction with
history) or `shared` (the paper's eq. 3: largest overlap shared, viscous friction, critical damping). Starts at 50
degrees, then the angle of the part. Writes rows.json, energy.png (fig. 11b) and profiles.png (figs. 12 to 14, 16).
"""

from __future__ import annotations

import math

import numpy as np
from common import COLOURS, REFERENCE, SCENES, Options, Row, Rows, Run, figure, launched, options, portrait

import sturz
from sturz import measures

SOURCE = "Descantes 2022, section 3.2"
D_EQ, T_INERTIA = 0.648433, 0.805254
ANGLES = (30, 36, 37, 39, 42, 45)
PARTS = tuple(f"{law}-{angle}" for law in ("default", "shared") for angle in ANGLES)
DEFAULT_PARTS = ("default-36", "default-30", "default-39", "default-45", "shared-36", "shared-39")
REGIMES = {30: "stopping", 36: "steady", 37: "steady", 39: "steady", 42: "accelerating", 45: "accelerating"}
SHARED = """normal = "linear"
sharing = "max_overlap_shared"
tangential = "viscous"
"""


def scene(opts: Options, law: str) -> str:
    """The bundled scene with the law of the part; cell and time step of the paper in full."""
    text = (SCENES / "incline-pinacoids.toml").read_text()
    if law == "shared":
        text = text.replace("generalized_overlap = { rounding_fraction = 0.05 }\n", SHARED)
        text = text.replace("restitution = 0.2", "damping_n_s_per_m = 35.46\ntangential_damping_n_s_per_m = 35.46")
    if opts.size == "short":
        text = text.replace("[5.0, 5.0, 0.0]", "[2.6, 2.6, 0.0]")
    if opts.size == "full":
        text = text.replace("[5.0, 5.0, 0.0]", "[26.0, 30.0, 0.0]").replace("2.0131e-4", "1.0066e-5")
        text = text.replace("4403.1", "70449.7").replace("35.46", "141.83")
    return text


def lay_base(opts: Options, law: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, orientations and sizes of pinacoids that have settled on the floor, two layers or so."""
    with launched(opts, f"base-{law}", scene(opts, law)) as run:
        if not run.resumed:
            insert(run, "stone", 3.44, 0.0, 3.0)
            run.advance(opts.pick(1.0, 12.0, 12.0) * T_INERTIA)
            run.save()
        state = run.simulation.state()
    return state.positions_m, state.orientations_wxyz, state.scales


def insert(run: Run, material: str, per_area: float, low: float, high: float) -> None:
    """A random cloud with so many particles per square diameter of base."""
    size = run.info.domain.max_m
    count = int(per_area * size[0] * size[1])
    region = sturz.Box((-0.6, -0.6, low), (size[0] + 0.6, size[1] + 0.6, high))
    run.simulation.insert_random(
        shape="pinacoid", material=material, region=region, count=count, attempts=50_000, scale=(0.9, 1.1)
    )


def tilt(run: Run, degrees: float) -> None:
    """Sets gravity for a slope."""
    theta = np.deg2rad(degrees)
    run.simulation.set_gravity(gravity_m_per_s2=(0.0, np.sin(theta), -np.cos(theta)))


def prepare(opts: Options, run: Run, law: str) -> None:
    """Base, cloud over it, slope."""
    for position, orientation, size in zip(*lay_base(opts, law), strict=True):
        run.simulation.insert_poses(
            shape="pinacoid",
            material="base",
            positions_m=[position],
            orientations_wxyz=[orientation],
            scale=float(size),
            frozen=True,
        )
    run.info = run.simulation.info()
    top = float(run.simulation.state().positions_m[:, 2].max())
    flowing = opts.pick(1.5, 25.64, 25.64)
    insert(run, "stone", flowing, top + 0.6, top + 1.8 + flowing / 1.4)
    tilt(run, 50.0)


def flow(opts: Options, run: Run, angle: int) -> np.ndarray:
    """Ten inertial times at 50 degrees, then fifty at the angle; time, kinetic energy and mean velocity."""
    history = run.notes.setdefault("history", [])
    steep, whole = opts.pick((1, 2), (10, 60), (10, 60))
    if REGIMES[angle] == "accelerating" and opts.size == "scaled":  # there is no steady state to wait for
        whole = 30
    while len(history) < whole:
        if len(history) == steep:
            tilt(run, angle)
        run.advance(T_INERTIA)
        state, _, heavy = run.seen()
        rocks = state.materials == run.info.materials.index("stone")
        speeds = (state.velocities_m_per_s[rocks] ** 2).sum(axis=1)
        kinetic = 0.5 * float(heavy.mass_kg[rocks] @ speeds)
        history.append([len(history), kinetic, float(state.velocities_m_per_s[rocks, 1].mean())])
        if len(history) % 10 == 0:
            run.save()
        if len(history) > steep + 5 and kinetic < 1e-6 * history[steep][1]:
            break
    return np.array(history)


def average(opts: Options, run: Run) -> dict[str, np.ndarray]:
    """Profiles over twenty inertial times more.

    Fluctuations are those about the mean velocity of a layer over all frames: the mean of one frame follows its few
    grains, and would take their share of the kinetic stress away.
    """
    area = float(np.prod(run.info.domain.max_m[:2]))
    states, flowing, frames, momentum = [], [], [], []
    edges = np.arange(0.0, 2.0 + float(run.simulation.state().positions_m[:, 2].max()), 0.5 * D_EQ)
    layers = len(edges) - 1
    for _ in range(opts.pick(2, 100, 100)):
        run.advance(0.2 * T_INERTIA)
        state, contacts, heavy = run.seen()
        rocks = state.materials == run.info.materials.index("stone")
        states.append(state)
        flowing.append((state.positions_m[rocks], state.velocities_m_per_s[rocks], heavy.mass_kg[rocks]))
        stress = measures.layer_stress(state, contacts, heavy, edges, area_m2=area, domain=run.info.domain)
        fraction = measures.solid_fraction_profile(state, run.shapes, edges, area_m2=area)
        touching = measures.coordination(state, contacts).per_particle
        layer = np.searchsorted(edges, state.positions_m[:, 2], side="right") - 1
        # What flows above the middle of each layer: mass and momentum along the slope.
        above = state.positions_m[rocks, 2] >= stress.middles_m[:, None]
        mass, along = heavy.mass_kg[rocks], state.velocities_m_per_s[rocks, 1]
        momentum.append(np.stack([above @ mass, above @ (mass * along)]))
        of_layers = {
            "neighbours": touching,
            "particles": np.ones(len(state)),
            "mass": heavy.mass_kg,
            "turning": state.angular_velocities_rad_per_s[:, 0],
            "along": state.velocities_m_per_s[:, 1],
        }
        found = {
            name: np.bincount(layer, weights=values, minlength=layers)[:layers] for name, values in of_layers.items()
        }
        frames.append(found | {"contact": stress.contact, "weight": stress.weight_pa, "nu": fraction.solid_fraction})
    kept = {f"{name}_frames": np.array([frame[name] for frame in frames]) for name in frames[0]}
    sums = {name: kept[f"{name}_frames"].mean(axis=0) for name in ("contact", "weight", "nu", *of_layers)}
    profile = measures.velocity_profile(states, heavy.mass_kg, edges)
    sums["z"] = sums["neighbours"] / np.maximum(sums["particles"], 1e-9)
    density = sums["mass"] / (area * np.diff(edges))
    sums |= kept | {
        "edges_m": edges,
        "velocity": profile.velocity_m_per_s,
        "spin": profile.angular_velocity_rad_per_s,
        "temperature": profile.granular_temperature_m2_per_s2,
        "rate": np.nan_to_num(profile.shear_rate_per_s(1)),
        "kinetic": np.nan_to_num(density[:, None, None] * profile.temperature_m2_per_s2),
        "momentum_frames": np.array(momentum),
        "times": np.arange(len(frames)) * 0.2 * T_INERTIA,
    }
    sums["flowing"], sums["flowing_velocity"] = of_flowing(flowing, edges)
    total = sums["contact"] + sums["kinetic"]
    sums["inertial"] = measures.inertial_number(sums["rate"], D_EQ, 1.0, total[:, 2, 2])
    return sums


def of_flowing(frames: list[tuple[np.ndarray, np.ndarray, np.ndarray]], edges: np.ndarray) -> tuple[np.ndarray, ...]:
    """Grains of each layer per frame, and their mean velocity down the slope, without the base."""
    z = np.concatenate([positions[:, 2] for positions, _, _ in frames])
    v = np.concatenate([velocities[:, 1] for _, velocities, _ in frames])
    count = np.histogram(z, bins=edges)[0]
    with np.errstate(invalid="ignore"):
        return count / len(frames), np.histogram(z, bins=edges, weights=v)[0] / count


def rows_of(run: Run, part: str, history: np.ndarray, m: dict[str, np.ndarray]) -> list[Row]:
    """Regime, fits, balances."""
    angle = part.split("-")[1]
    theta = np.deg2rad(float(angle))
    middles = 0.5 * (m["edges_m"][1:] + m["edges_m"][:-1])
    full = np.flatnonzero(m["nu"] > 0.25)
    top = middles[full[-1]] if len(full) else 0.0
    bulk = (middles > 5 * D_EQ) & (middles < top - 2 * D_EQ)
    if not bulk.any():
        bulk = m["nu"] > 0.25
    last = history[-max(len(history) // 3, 3) :]
    slope = float(np.polyfit(last[:, 0], last[:, 2], 1)[0]) / T_INERTIA
    change = slope * (last[-1, 0] - last[0, 0]) * T_INERTIA / max(abs(last[:, 2].mean()), 1e-12)
    energy = (
        float(np.polyfit(last[:, 0], last[:, 1], 1)[0]) * (last[-1, 0] - last[0, 0]) / max(last[:, 1].mean(), 1e-300)
    )
    at_rest = last[-1, 1] < 1e-3 * history[:, 1].max()
    regime = "stopping" if at_rest or change < -0.2 else "accelerating" if change > 0.1 else "steady"
    expected = REGIMES[int(angle)]
    name = f"K2s-{part}"
    rows = [
        run.row(
            name,
            f"regime: {regime} (paper: {expected})",
            float(regime == expected),
            reference=1.0,
            tolerance=0.0,
            source=SOURCE,
        ),
        run.row(name, "change of the kinetic energy over the last third", energy),
        run.row(name, "fastest layer over sqrt(g d_eq)", float(np.nanmax(m["velocity"][:, 1])) / math.sqrt(D_EQ)),
        *balance(run, name, theta, expected, m, bulk),
        run.row(name, "height of the flow over d_eq", top / D_EQ),
    ]
    if regime == "stopping":
        return rows
    weights = m["nu"][bulk]
    inertial, nu, z = (float(np.average(m[key][bulk], weights=weights)) for key in ("inertial", "nu", "z"))
    grains = m["particles_frames"][:, bulk]
    counted = grains.sum(axis=1)
    # Against half of the slope of the velocity over the whole bulk.
    speeds = m["along_frames"][:, bulk] / np.maximum(grains, 1)
    rates = np.polyfit(middles[bulk], speeds.T, 1)[0]
    turning = measures.block_mean(-2.0 * m["turning_frames"][:, bulk].sum(axis=1) / counted / rates)
    nu_error = measures.block_mean(m["nu_frames"][:, bulk].mean(axis=1)).standard_error
    z_error = measures.block_mean(m["neighbours_frames"][:, bulk].sum(axis=1) / counted).standard_error
    judged = regime == "steady"

    def fit(metric: str, value: float, error: float, reference: float, tolerance: float, source: str) -> Row:
        """Judged where the flow is steady."""
        return run.row(
            name,
            metric,
            value,
            uncertainty=error,
            reference=reference,
            tolerance=tolerance if judged else math.nan,
            source=source,
        )

    rows += [
        run.row(name, "inertial number of the bulk", inertial),
        fit("solid fraction of the bulk", nu, nu_error, 0.50 - 0.07 * inertial, 0.02, f"{SOURCE}: 0.50 - 0.07 I"),
        fit(
            "coordination number of the bulk",
            z,
            z_error,
            4.5 - 3.62 * math.sqrt(inertial),
            0.25,
            f"{SOURCE}: 4.5 - 3.62 sqrt(I)",
        ),
        fit("angular velocity over -shear rate / 2", turning.value, turning.standard_error, 1.0, 0.1, SOURCE),
    ]
    # The lowest layer that has a fiftieth of the grains of a full one: those in the hollows of the base.
    low = np.flatnonzero(m["flowing"] > 0.02 * m["flowing"].max())[0]
    slip = abs(float(m["flowing_velocity"][low])) / float(np.nanmax(m["flowing_velocity"]))
    rows.append(fit("lowest flowing layer over the fastest", slip, math.nan, 0.0, 0.05, SOURCE))
    return rows


def balance(run: Run, name: str, theta: float, expected: str, m: dict[str, np.ndarray], bulk: np.ndarray) -> list[Row]:
    """Shear over normal stress of the bulk beside what the slope, and the acceleration in the same frames, ask for."""
    total = m["contact"] + m["kinetic"]
    ratio = -total[bulk, 1, 2].sum() / total[bulk, 2, 2].sum()
    frames = m["contact_frames"][:, bulk].sum(axis=1)
    kinetic = m["kinetic"][bulk].sum(axis=0)
    each = -(frames[:, 1, 2] + kinetic[1, 2]) / (frames[:, 2, 2] + kinetic[2, 2])
    error = measures.block_mean(each).standard_error
    mass, momentum = m["momentum_frames"].transpose(1, 0, 2)
    mean = momentum[:, 0] / mass[:, 0]
    acceleration = float(np.polyfit(m["times"], mean, 1)[0])
    # What is above a layer's middle gains momentum by weight and shear stress, and with the mass that rises into it.
    gain = np.polyfit(m["times"], momentum[:, bulk], 1)[0]
    rising = np.polyfit(m["times"], mass[:, bulk], 1)[0]
    change = (gain - m["velocity"][bulk, 1] * rising).sum()
    weight = mass[:, bulk].sum(axis=1).mean()
    exact = math.tan(theta) - change / (weight * math.cos(theta))
    asked = math.tan(theta)
    tolerance = 0.01
    if expected == "accelerating":
        asked -= acceleration / math.cos(theta)
        tolerance = 0.02
    source = "balance of momentum" + (", with the mean acceleration" if expected == "accelerating" else "")
    return [
        run.row(name, "mean acceleration over g", acceleration),
        run.row(
            name,
            "shear over normal stress in the bulk",
            ratio,
            uncertainty=error,
            reference=asked,
            tolerance=tolerance * asked,
            source=source,
        ),
        run.row(
            name,
            "the same over what the bulk's own acceleration leaves of tan(theta)",
            ratio / exact,
            uncertainty=error / exact,
            reference=1.0,
            source="balance of momentum above each layer",
        ),
        run.row(
            name, "the same from contact stress alone", -m["contact"][bulk, 1, 2].sum() / m["contact"][bulk, 2, 2].sum()
        ),
    ]


def draw(opts: Options, rows: Rows) -> None:
    """Figures of what is there."""
    there = [part for part in PARTS if rows.has(part)]
    if not there:
        return
    with figure(opts.out / "energy", 6.4, 3.4) as axes:
        for colour, part in zip(COLOURS, there, strict=False):
            history = rows.arrays(part, "profiles")["history"]
            axes.plot(history[:, 0], history[:, 1], color=colour, label=part.replace("-", ", ") + "°")
        axes.set_xlabel("time / sqrt(d_eq / g)")
        axes.set_ylabel("kinetic energy (fig. 11b)")
        axes.set_yscale("log")
        axes.legend(frameon=False)
    with figure(opts.out / "profiles", 10.4, 6.0, nrows=2, ncols=3) as axes:
        for colour, part in zip(COLOURS, there, strict=False):
            m = rows.arrays(part, "profiles")
            z = 0.5 * (m["edges_m"][1:] + m["edges_m"][:-1]) / D_EQ
            shown = m["nu"] > 0.1
            total = m["contact"] + m["kinetic"]
            with np.errstate(divide="ignore", invalid="ignore"):
                ratio = -total[:, 1, 2] / total[:, 2, 2]
            for each, value, title in zip(
                np.ravel(axes),
                (m["nu"], m["z"], m["velocity"][:, 1] / np.sqrt(D_EQ), -m["spin"][:, 0], ratio, m["inertial"]),
                (
                    "solid fraction",
                    "coordination",
                    "velocity / sqrt(g d_eq)",
                    "-ω (dotted: shear rate / 2)",
                    "σyz / σzz",
                    "I",
                ),
                strict=True,
            ):
                each.plot(value[shown], z[shown], color=colour, linewidth=1.1, label=part.replace("-", ", ") + "°")
                each.set_xlabel(title)
            axes[1, 0].plot(0.5 * m["rate"][shown], z[shown], ":", color=colour)
            axes[1, 1].axvline(np.tan(np.deg2rad(float(part.split("-")[1]))), color=REFERENCE, zorder=0)
        axes[0, 0].set_ylabel("z / d_eq")
        axes[1, 0].set_ylabel("z / d_eq")
        axes[1, 1].set_xlim(0, 1.3)
        axes[0, 2].legend(frameon=False)


def main() -> None:
    """Command line."""
    opts = options(__doc__ or "", "incline", PARTS)
    rows = Rows(opts.out / "rows.json")
    for part in PARTS:
        if not (opts.wants(part) if opts.only else part in DEFAULT_PARTS) or rows.has(part):
            continue
        law, angle = part.split("-")
        with launched(opts, part, scene(opts, law)) as run:
            if not run.resumed:
                prepare(opts, run, law)
            history = flow(opts, run, int(angle))
            run.save()
            m = average(opts, run)
            m["history"] = history
            rows.keep(part, rows_of(run, part, history, m), profiles=m)
            state = run.simulation.state()
            portrait(opts, run, f"incline_{part}.png", f"{len(state)} pinacoids, {angle}°, {law}")
        draw(opts, rows)
    draw(opts, rows)


if __name__ == "__main__":
    main()
