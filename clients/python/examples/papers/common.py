"""What the scripts of this folder share: options, runs that go on where they stopped, rows of results, figures."""

from __future__ import annotations

import argparse
import json
import math
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

import sturz
from sturz import measures
from sturz.plot import picture
from sturz.plot.style import FAINT, look, new_figure

SCENES = Path(__file__).resolve().parents[4] / "service" / "scenes"
COLOURS = ("#3d4f96", "#c8553d", "#3fb0ac", "#e0a030", "#7a4f9a", "#5f7f3f", "#22303c")
REFERENCE = "#9aa5ad"


@dataclass(frozen=True)
class Options:
    """What the command line says.

    Attributes:
        out: folder for rows, figures and checkpoints.
        threads: of the physics.
        size: ``short`` (seconds: does it work?), ``scaled`` (minutes) or ``full`` (the paper's own size).
        only: parts to run; all when empty.
    """

    out: Path
    threads: int
    size: str
    only: tuple[str, ...]

    def pick(self, short: Any, scaled: Any, full: Any) -> Any:
        """The value for this size."""
        return {"short": short, "scaled": scaled, "full": full}[self.size]

    def wants(self, part: str) -> bool:
        """Whether a part is to be run."""
        return not self.only or part in self.only


def options(description: str, default_out: str, parts: tuple[str, ...]) -> Options:
    """Reads the command line."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/papers") / default_out, help="folder for what is written")
    parser.add_argument("--threads", type=int, default=1, help="of the physics")
    parser.add_argument("--only", nargs="*", choices=parts, default=(), help="parts to run")
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--full", action="store_const", dest="size", const="full", help="the paper's own size: hours")
    size.add_argument("--short", action="store_const", dest="size", const="short", help="seconds: does it work?")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    return Options(given.out, given.threads, given.size or "scaled", tuple(given.only))


@dataclass(frozen=True)
class Row:
    """One number beside its reference.

    Attributes:
        id: case of PHYSICS.md, and which part of it.
        metric: what was measured.
        value, uncertainty: uncertainty NaN where none is known.
        reference, tolerance: NaN where there are none.
        unit: 1 for pure numbers.
        verdict: ``pass``, ``miss``, ``reported`` (no tolerance) or ``short`` (a short form proves nothing).
        wall_s, particle_steps: of the run that it comes from.
        source: of the reference.
    """

    id: str
    metric: str
    value: float
    uncertainty: float
    reference: float
    tolerance: float
    unit: str
    verdict: str
    wall_s: float
    particle_steps: float
    source: str


class Rows:
    """Rows of a script, kept in a file so that what is done is not done again."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.parts: dict[str, list[dict[str, Any]]] = json.loads(path.read_text()) if path.exists() else {}

    def has(self, part: str) -> bool:
        """Whether this part is done."""
        return part in self.parts

    def keep(self, part: str, rows: list[Row], **more: Any) -> None:
        """Writes the rows of a part, and tells of them."""
        self.parts[part] = [{key: plain(value) for key, value in asdict(row).items()} for row in rows]
        for name, value in more.items():
            np.savez_compressed(self.path.parent / f"{part}-{name}.npz", **value)
        self.path.write_text(json.dumps(self.parts, indent=1, allow_nan=False) + "\n")
        for row in rows:
            reference = "" if math.isnan(row.reference) else f"  (reference {row.reference:g})"
            print(f"{row.id:24s} {row.metric:48s} {row.value:12.5g} {row.unit:8s} {row.verdict}{reference}", flush=True)

    def value(self, part: str, metric: str) -> float:
        """A number that is there; NaN where it is not."""
        for row in self.parts.get(part, []):
            if row["metric"] == metric:
                return float("nan") if row["value"] is None else float(row["value"])
        return float("nan")

    def arrays(self, part: str, name: str) -> dict[str, np.ndarray]:
        """Arrays that were kept with a part."""
        with np.load(self.path.parent / f"{part}-{name}.npz") as kept:
            return {key: kept[key] for key in kept.files}


def plain(value: Any) -> Any:
    """For JSON, which has no NaN."""
    if isinstance(value, float | np.floating):
        return None if not math.isfinite(value) else float(value)
    return value


class Run:
    """A simulation that counts what it costs and goes on from its last checkpoint.

    Args:
        simulation: paused.
        folder: of its checkpoints.
        judged: whether its rows get verdicts: not in the short form.
    """

    def __init__(self, simulation: sturz.Simulation, folder: Path, judged: bool) -> None:
        self.simulation = simulation
        self.judged = judged
        self.info = simulation.info()
        self.shapes = simulation.shapes()
        self.densities = measures.densities_kg_per_m3(self.info)
        self.notes: dict[str, Any] = {"wall_s": 0.0, "particle_steps": 0.0}
        self._notes_file = folder / "notes.json"
        self.resumed = any(each.token == "latest" for each in simulation.checkpoints())
        if self.resumed:
            simulation.restore(token="latest")
            self.notes = json.loads(self._notes_file.read_text())
            self.info = simulation.info()

    @property
    def time_s(self) -> float:
        """Simulated time, s."""
        return self.info.time_s

    @property
    def wall_s(self) -> float:
        """Wall time of all windows so far, s."""
        return float(self.notes["wall_s"])

    @property
    def particle_steps(self) -> float:
        """Particles times steps of all windows so far."""
        return float(self.notes["particle_steps"])

    def advance(self, window_s: float, **asked: Any) -> sturz.Advanced:
        """One window, counted."""
        start = time.monotonic()
        done = self.simulation.advance(window_s=window_s, **asked)
        self.notes["wall_s"] += time.monotonic() - start
        self.info = self.simulation.info()
        self.notes["particle_steps"] += float(done.steps_done) * self.info.particles
        return done

    def save(self) -> None:
        """A checkpoint to go on from."""
        self.simulation.checkpoint(token="latest", on_disk=True)
        self._notes_file.write_text(json.dumps(self.notes))

    def seen(self) -> tuple[sturz.State, sturz.Contacts, measures.Bodies]:
        """State with torques, contacts and masses, of one step."""
        columns = self.simulation.features().columns
        state = self.simulation.state(columns=[name for name in columns if name != "ids"])
        return state, self.simulation.contacts(), measures.bodies(state, self.shapes, self.densities)

    def row(
        self,
        id: str,
        metric: str,
        value: float,
        *,
        uncertainty: float = math.nan,
        reference: float = math.nan,
        tolerance: float = math.nan,
        unit: str = "1",
        source: str = "",
    ) -> Row:
        """A row with what the run has cost so far, judged where there is a tolerance."""
        verdict = "reported"
        if not self.judged:
            verdict = "short"
        elif not math.isnan(tolerance):
            verdict = "pass" if abs(value - reference) <= tolerance else "miss"
        return Row(
            id,
            metric,
            value,
            uncertainty,
            reference,
            tolerance,
            unit,
            verdict,
            self.wall_s,
            self.particle_steps,
            source,
        )


@contextmanager
def launched(opts: Options, name: str, scene: Path | str) -> Iterator[Run]:
    """A run of a scene file or of a scene's text, with checkpoints under the name."""
    folder = opts.out / "checkpoints" / name
    folder.mkdir(parents=True, exist_ok=True)
    given: dict[str, Any] = {"scene": scene} if isinstance(scene, Path) else {"scene_text": scene, "name": None}
    with sturz.launch(**given, threads=opts.threads, checkpoints=folder) as simulation:
        yield Run(simulation, folder, opts.size != "short")


def settle(
    run: Run,
    *,
    window_s: float,
    longest_s: float,
    size_m: float,
    quiet: float = 1e-6,
    each: Callable[[Run, sturz.Report], None] | None = None,
    save_every: int = 10,
) -> bool:
    """Goes on until the kinetic energy per particle is below `quiet` times m g size, or for `longest_s`; whether it is.

    Args:
        each: is told of every window.
        save_every: windows between checkpoints.
    """
    state, _, heavy = run.seen()
    mass = float(heavy.mass_kg.mean()) if len(state) else 0.0
    gravity = float(np.linalg.norm(state.gravity_m_per_s2))
    windows = 0
    while run.time_s < longest_s * (1.0 - 1e-9):
        run.advance(min(window_s, longest_s - run.time_s))
        windows += 1
        report = run.simulation.report()
        energy = report.energy.kinetic_translation_j + report.energy.kinetic_rotation_j
        if each is not None:
            each(run, report)
        if windows % save_every == 0:
            run.save()
        if energy < quiet * run.info.particles * mass * gravity * size_m:
            return True
    return False


@contextmanager
def figure(path: Path, width_in: float = 6.4, height_in: float = 3.6, **grid: Any) -> Iterator[Any]:
    """Axes of a figure that is written as PNG and SVG: `figure(path, ncols=2)` gives an array of them."""
    with look(), matplotlib.rc_context({"svg.fonttype": "none"}):
        drawing = new_figure(width_in, height_in, 150)
        axes = drawing.subplots(**grid)
        for each in np.ravel(axes):
            each.spines[["top", "right"]].set_visible(False)
            each.grid(True, color=FAINT, alpha=0.18, linewidth=0.5)
        yield axes
        drawing.savefig(path.with_suffix(".png"))
        drawing.savefig(path.with_suffix(".svg"), metadata={"Date": None})
    slim(path.with_suffix(".svg"))


def slim(path: Path) -> None:
    """Shortens the paths of an SVG to tenths of a point, for the report that holds all of them."""
    text = re.sub(r"<metadata>.*?</metadata>", "", path.read_text(), flags=re.DOTALL)
    short = re.compile(r"(\.\d)\d+")
    text = re.sub(r'\b(d|x|y|transform)="[^"]*"', lambda d: " ".join(short.sub(r"\1", d[0]).split()), text)
    text = re.sub(r'style="[^"]*"', lambda style: style[0].replace(": ", ":").replace("; ", ";"), text)
    # names of groups, which nothing refers to
    text = re.sub(r'<g id="[^"]*"', "<g", re.sub(r"<!--.*?-->", "", text))
    path.write_text(re.sub(r"\n\s*", "\n", text))


def portrait(opts: Options, run: Run, name: str, title: str) -> None:
    """A picture of the particles as they are; none in the short form, which it would take longer than all the rest."""
    if opts.size != "short":
        state = run.simulation.state()
        boundaries = [each for each in run.info.boundaries if each.kind != "mesh"]
        picture(state, run.shapes, boundaries, opts.out / name, domain=run.info.domain, title=title)
