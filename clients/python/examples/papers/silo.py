"""I12 and I13: stress in a silo (Janssen) and discharge through an orifice (Beverloo), with spheres.

Part `janssen` fills a silo of ten diameters by rain, lowers its floor by 3 mm so that the wall's friction is mobilised,
and fits p = p_inf (1 - exp(-z / lambda)). Parts `beverloo-<mm>` let balls flow through orifices of that width. Writes
rows.json, janssen.png, beverloo.png.
"""

from __future__ import annotations

import re

import numpy as np
from common import COLOURS, REFERENCE, SCENES, Options, Row, Rows, figure, launched, options, settle

from sturz import measures

G = 9.81
ORIFICES_MM = (20, 24, 28, 32)
PARTS = ("janssen", *(f"beverloo-{mm}" for mm in ORIFICES_MM))
SIDES = 36


def janssen_fit(depth_m: np.ndarray, pressure_pa: np.ndarray) -> tuple[float, float, float]:
    """p_inf, lambda and R^2 of the best p_inf (1 - exp(-z / lambda))."""
    best = (np.nan, np.nan, -np.inf)
    total = float(((pressure_pa - pressure_pa.mean()) ** 2).sum())
    if total == 0.0:
        return np.nan, np.nan, np.nan
    for length in np.geomspace(0.01, 2.0, 800):
        form = 1.0 - np.exp(-depth_m / length)
        scale = float(form @ pressure_pa / (form @ form))
        rest = float(((pressure_pa - scale * form) ** 2).sum())
        if 1.0 - rest / total > best[2]:
            best = (scale, float(length), 1.0 - rest / total)
    return best


def janssen(opts: Options, rows: Rows) -> None:
    """Stress over depth."""
    text = (SCENES / "silo-janssen.toml").read_text()
    if opts.size == "short":
        text = text.replace("count = 3800", "count = 500").replace("length_m = 1.2", "length_m = 0.17")
    diameter, friction, area = 0.1, 0.5, np.pi * 0.05**2
    with launched(opts, "janssen", text) as run:
        settle(run, window_s=0.05, longest_s=opts.pick(0.1, 0.8, 3.0), size_m=0.01)
        run.save()
        run.simulation.set_translation(boundary="floor", velocity_m_per_s=(0, 0, -0.01))
        run.advance(opts.pick(0.02, 0.15, 0.5))
        frames = []
        for _ in range(opts.pick(2, 20, 50)):
            run.advance(0.005)
            state, contacts, heavy = run.seen()
            edges = np.arange(0.02, float(state.positions_m[:, 2].max()) + 0.01, 0.01)
            stress = measures.layer_stress(state, contacts, heavy, edges, area_m2=area)
            profile = measures.solid_fraction_profile(state, run.shapes, edges, area_m2=area)
            filled = np.flatnonzero(profile.solid_fraction > 0.5 * profile.solid_fraction.max())
            surface = float(edges[filled[-1] + 1])
            floor = next(each for each in state.boundaries if each.name == "floor").force_n[2]
            frames.append((surface, stress, float(np.median(profile.solid_fraction[filled])), -floor / area))
        count = min(len(frame[1].middles_m) for frame in frames)
        tensor = np.mean([frame[1].contact[:count] for frame in frames], axis=0)
        surface = float(np.mean([frame[0] for frame in frames]))
        depth = surface - frames[0][1].middles_m[:count]
        inside = depth > 0.0
        depth, tensor = depth[inside], tensor[inside]
        pressure = tensor[:, 2, 2]
        p_inf, length, quality = janssen_fit(depth, pressure)
        bulk = 2500.0 * float(np.mean([frame[2] for frame in frames]))
        deep = depth > diameter
        ratio = (
            float(np.mean(0.5 * (tensor[deep, 0, 0] + tensor[deep, 1, 1])) / np.mean(pressure[deep]))
            if deep.any()
            else np.nan
        )
        found = [
            run.row("I12", "R^2 of Janssen's form", quality, reference=1.0, tolerance=0.02, source="Janssen 1895"),
            run.row(
                "I12", "K from the fitted depth", diameter / (4 * friction * length), reference=0.5, source="example"
            ),
            run.row("I12", "K, horizontal over vertical stress", ratio),
            run.row("I12", "p_inf", p_inf, unit="Pa"),
            run.row("I12", "p_inf over rho_b g lambda", p_inf / (bulk * G * length), reference=1.0, source="balance"),
            run.row("I12", "pressure on the floor over p_inf", float(np.mean([frame[3] for frame in frames])) / p_inf),
            run.row("I12", "filling height over diameter", surface / diameter),
        ]
        for times in (1, 2, 4):
            if depth.max() > times * diameter:
                value = float(np.interp(times * diameter, depth[::-1], pressure[::-1])) / p_inf
                law = 1.0 - np.exp(-times * diameter / length)
                found.append(run.row("I12", f"p / p_inf at z = {times} D", value, reference=law, source="the fit"))
        rows.keep(
            "janssen",
            found,
            profile={
                "depth_m": depth,
                "pressure_pa": pressure,
                "fit": np.array([p_inf, length, bulk]),
                "horizontal_pa": 0.5 * (tensor[:, 0, 0] + tensor[:, 1, 1]),
            },
        )


def with_orifice(text: str, diameter_m: float) -> str:
    """The discharge scene with another orifice: a polygon of the same area."""
    inner = 0.5 * diameter_m * np.sqrt(2 * np.pi / (SIDES * np.sin(2 * np.pi / SIDES)))
    angles = 2 * np.pi * np.arange(SIDES) / SIDES
    rings = [(r * np.cos(a), r * np.sin(a)) for a in angles for r in (inner, 0.046)]
    vertices = ", ".join(f"[{x:.7f}, {y:.7f}, 0.0]" for x, y in rings)
    return re.sub(r"^vertices_m = .*$", f"vertices_m = [{vertices}]", text, flags=re.MULTILINE)


def beverloo(opts: Options, rows: Rows, part: str) -> None:
    """Mass rate through one orifice."""
    orifice = float(part.split("-")[1]) * 1e-3
    text = with_orifice((SCENES / "silo-discharge.toml").read_text(), orifice)
    if opts.size == "short":
        text = text.replace("count = 4500", "count = 600").replace("length_m = 0.17", "length_m = 0.03")
    area = np.pi * 0.04**2
    with launched(opts, part, text) as run:
        settle(run, window_s=0.02, longest_s=opts.pick(0.06, 0.35, 0.8), size_m=4e-3, quiet=1e-4)
        state, _, heavy = run.seen()
        top = float(state.positions_m[:, 2].max())
        edges = np.array([4e-3, max(top - 8e-3, 8e-3)])
        fraction = float(measures.solid_fraction_profile(state, run.shapes, edges, area_m2=area).solid_fraction[0])
        run.simulation.set_translation(boundary="plug", velocity_m_per_s=(0, 0, -4.0))
        window, out, times, heights = 0.01, [], [], []
        for _ in range(opts.pick(4, 45, 150)):
            run.advance(window)
            state, _, heavy = run.seen()
            gone = state.positions_m[:, 2] < -2e-3
            out.append(float(heavy.mass_kg[gone].sum()) / window)
            times.append(run.time_s)
            heights.append(float(heavy.mass_kg[~gone].sum()) / (2500.0 * fraction * area))
            if gone.any():
                run.simulation.remove(ids=state.ids[gone])
        # The flow starts within 0.1 s, and ends to be Beverloo's when the bed is as low as the orifice is wide.
        rate, height = np.array(out), np.array(heights)
        steady = np.flatnonzero((np.arange(len(rate)) >= len(rate) // 6) & (height > max(orifice, 0.02)))
        mean = measures.block_mean(rate[steady] if len(steady) else rate)
        halves = (
            [measures.block_mean(half) for half in np.array_split(rate[steady], 2)] if len(steady) > 8 else [mean, mean]
        )
        name = f"I13-{part.split('-')[1]}mm"
        bulk = 2500.0 * fraction
        law = 0.58 * bulk * np.sqrt(G) * (orifice - 1.4 * 4e-3) ** 2.5
        found = [
            run.row(
                name,
                "mass rate",
                mean.value,
                uncertainty=mean.standard_error,
                reference=law,
                tolerance=0.1 * law,
                unit="kg/s",
                source="Beverloo 1961, C = 0.58, k = 1.4",
            ),
            run.row(
                name,
                "rate of the second half over the first",
                halves[1].value / halves[0].value,
                uncertainty=float(np.hypot(halves[0].standard_error, halves[1].standard_error) / halves[0].value),
                reference=1.0,
                source="independent of the filling height",
            ),
            run.row(name, "bulk density", bulk, unit="kg/m3"),
            run.row(name, "filling height at the end", float(height[steady[-1]] if len(steady) else np.nan), unit="m"),
        ]
        rows.keep(part, found, series={"time_s": np.array(times), "rate_kg_per_s": rate, "height_m": height})


def power(d0: np.ndarray, rate: np.ndarray, k: float) -> float:
    """Exponent that fits with this k."""
    return float(np.polyfit(np.log(d0 - k * 4e-3), np.log(rate), 1)[0])


def exponent(rows: Rows) -> tuple[np.ndarray, np.ndarray, float, float, float]:
    """Orifices, rates, k and C of the law with 2.5, and the exponent that fits with this k: not far from 2.5, since k
    was found with it. With another k it is another; four orifices do not tell both."""
    there = [mm for mm in ORIFICES_MM if rows.has(f"beverloo-{mm}")]
    d0 = np.array(there) * 1e-3
    rate = np.array([rows.value(f"beverloo-{mm}", "mass rate") for mm in there])
    bulk = float(np.mean([rows.value(f"beverloo-{mm}", "bulk density") for mm in there]))
    slope, offset = np.polyfit(d0, rate**0.4, 1)
    k = -offset / slope / 4e-3
    c = slope**2.5 / (bulk * np.sqrt(G))
    return d0, rate, float(k), float(c), power(d0, rate, k)


def fit(rows: Rows) -> None:
    """Rows of Beverloo's law once there are four orifices or more."""
    if sum(rows.has(f"beverloo-{mm}") for mm in ORIFICES_MM) >= 4:
        d0, rate, k, c, found = exponent(rows)
        cost = [rows.parts[f"beverloo-{round(1e3 * d)}"][0] for d in d0]
        wall, steps = sum(each["wall_s"] for each in cost), sum(each["particle_steps"] for each in cost)

        def row(metric: str, value: float, reference: float, tolerance: float) -> Row:
            verdict = "reported" if np.isnan(tolerance) else "pass" if abs(value - reference) <= tolerance else "miss"
            return Row("I13", metric, value, np.nan, reference, tolerance, "1", verdict, wall, steps, "Beverloo 1961")

        rows.keep(
            "beverloo",
            [
                row("exponent after fitting k", found, 2.5, 0.1),
                row("exponent with k = 1.4", power(d0, rate, 1.4), 2.5, np.nan),
                row("k", k, 1.4, np.nan),
                row("C", c, 0.58, np.nan),
            ],
        )


def draw(opts: Options, rows: Rows) -> None:
    """Figures of what is there."""
    if rows.has("janssen"):
        kept = rows.arrays("janssen", "profile")
        p_inf, length, bulk = kept["fit"]
        with figure(opts.out / "janssen", 5.2, 3.8) as axes:
            z = np.linspace(0, kept["depth_m"].max(), 100)
            axes.plot(z / 0.1, bulk * G * z, color=REFERENCE, linestyle="--", label="without walls")
            axes.plot(z / 0.1, p_inf * (1 - np.exp(-z / length)), color=COLOURS[1], label="Janssen, fitted")
            axes.plot(
                kept["depth_m"] / 0.1, kept["pressure_pa"], "o", markersize=3, color=COLOURS[0], label="vertical stress"
            )
            axes.plot(
                kept["depth_m"] / 0.1,
                kept["horizontal_pa"],
                "o",
                markersize=2,
                color=COLOURS[2],
                label="horizontal stress",
            )
            axes.set_ylim(0, 2.2 * p_inf if p_inf > 0 else None)
            axes.set_xlabel("depth / diameter of the silo")
            axes.set_ylabel("Pa")
            axes.set_title("Stress in a silo")
            axes.legend(frameon=False)
    there = [mm for mm in ORIFICES_MM if rows.has(f"beverloo-{mm}")]
    if len(there) >= 3:
        d0, rate, k, c, _ = exponent(rows)
        with figure(opts.out / "beverloo", 8.6, 3.6, ncols=2) as axes:
            bulk = rows.value(f"beverloo-{there[0]}", "bulk density")
            x = np.linspace(0.012, 0.034, 100)
            axes[0].plot(
                1e3 * x, 0.58 * bulk * np.sqrt(G) * (x - 1.4 * 4e-3) ** 2.5, color=REFERENCE, label="C = 0.58, k = 1.4"
            )
            axes[0].plot(
                1e3 * x,
                c * bulk * np.sqrt(G) * np.maximum(x - k * 4e-3, 0) ** 2.5,
                color=COLOURS[1],
                label=f"fit: C = {c:.2f}, k = {k:.2f}",
            )
            axes[0].plot(1e3 * d0, rate, "o", color=COLOURS[0], label="Sturz")
            axes[0].set_xlabel("orifice, mm")
            axes[0].set_ylabel("kg/s")
            axes[0].set_title("Discharge (Beverloo)")
            axes[0].legend(frameon=False)
            for colour, mm in zip(COLOURS, there, strict=False):
                kept = rows.arrays(f"beverloo-{mm}", "series")
                axes[1].plot(
                    kept["time_s"] - kept["time_s"][0],
                    kept["rate_kg_per_s"],
                    color=colour,
                    linewidth=0.9,
                    label=f"{mm} mm",
                )
            axes[1].set_xlabel("time, s")
            axes[1].set_title("Rate over time")
            axes[1].set_ylim(top=1.3 * rate.max())
            axes[1].legend(frameon=False, ncols=4, fontsize=8, loc="upper center")


def main() -> None:
    """Command line."""
    opts = options(__doc__ or "", "silo", PARTS)
    rows = Rows(opts.out / "rows.json")
    for part in PARTS:
        if opts.wants(part) and not rows.has(part):
            janssen(opts, rows) if part == "janssen" else beverloo(opts, rows, part)
            draw(opts, rows)
    fit(rows)
    draw(opts, rows)


if __name__ == "__main__":
    main()
