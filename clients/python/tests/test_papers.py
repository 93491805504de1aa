"""The scripts of the papers' experiments, in their short form: they run, write, and do not do again what is done."""

import json
import math
import subprocess
import sys
from pathlib import Path

import pytest

PAPERS = Path(__file__).resolve().parents[1] / "examples" / "papers"
sys.path.insert(0, str(PAPERS))

SCRIPTS = {
    "porosity": (["cube", "cross_3d"], ["porosity.png", "profiles.svg"]),
    "packing": (["default", "shared"], ["profiles.png"]),
    "silo": (["janssen", "beverloo-28"], ["janssen.png"]),
    "drum": (["sphere-200"], ["speeds.png", "distributions.png"]),
    "chute": (["1.01-24"], ["regimes.png"]),
    "incline": (["default-36"], ["energy.png", "profiles.png"]),
    "bagnold": (["24-260"], ["bagnold.png"]),
    "dice": (["tetrahedron"], ["dice.png"]),
    "reactor": (["single", "cross_3d"], ["heights.png", "single.png"]),
    "glued": (["cylinder", "slices", "spheres", "cube"], ["cylinder.png", "slices.png", "spheres.png", "cube.svg"]),
}


def run(script: str, parts: list[str], out: Path) -> str:
    command = [sys.executable, str(PAPERS / f"{script}.py"), "--short", "--out", str(out), "--only", *parts]
    done = subprocess.run(command, capture_output=True, text=True, timeout=110)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("script", SCRIPTS)
def test_short_forms(script: str, tmp_path: Path) -> None:
    parts, figures = SCRIPTS[script]
    said = run(script, parts, tmp_path)
    rows = json.loads((tmp_path / "rows.json").read_text())
    assert set(parts) <= set(rows)
    for part in parts:
        for row in rows[part]:
            assert set(row) >= {"id", "metric", "value", "uncertainty", "reference", "tolerance", "unit", "verdict"}
            assert row["verdict"] == "short" and row["wall_s"] > 0.0 and row["particle_steps"] > 100
            assert row["id"] in said
    for name in figures:
        assert (tmp_path / name).stat().st_size > 5000
    assert run(script, parts, tmp_path) == ""
    assert json.loads((tmp_path / "rows.json").read_text()) == rows


def test_a_run_goes_on_from_its_checkpoint(tmp_path: Path) -> None:
    from common import Options, launched

    opts = Options(tmp_path, 1, "short", ())
    scene = (PAPERS.parents[3] / "service" / "scenes" / "bouncing-sphere.toml").read_text()
    with launched(opts, "ball", scene) as first:
        first.advance(0.1)
        first.save()
        kept = first.info.state_hash, first.particle_steps
        first.advance(0.1)
        end = first.info.state_hash
    with launched(opts, "ball", scene) as second:
        assert second.resumed and (second.info.state_hash, second.particle_steps) == kept
        second.advance(0.1)
        assert second.info.state_hash == end


def test_verdicts(tmp_path: Path) -> None:
    from common import Options, Rows, launched

    scene = (PAPERS.parents[3] / "service" / "scenes" / "bouncing-sphere.toml").read_text()
    with launched(Options(tmp_path, 1, "scaled", ()), "ball", scene) as run_:
        rows = [
            run_.row("X", "a", 1.05, reference=1.0, tolerance=0.1),
            run_.row("X", "b", 1.2, reference=1.0, tolerance=0.1),
            run_.row("X", "c", math.nan, reference=1.0, tolerance=0.1),
            run_.row("X", "d", 3.0),
        ]
    assert [row.verdict for row in rows] == ["pass", "miss", "miss", "reported"]
    Rows(tmp_path / "rows.json").keep("part", rows)
    again = Rows(tmp_path / "rows.json")
    assert again.has("part") and again.value("part", "b") == 1.2 and math.isnan(again.value("part", "c"))
