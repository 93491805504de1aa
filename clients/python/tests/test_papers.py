"""The scripts of the papers' experiments, in their short form: they run, write, and do not do again what is done."""

import json
import math
import subprocess
import sys
from pathlib import Path
from types import MethodType, SimpleNamespace

import numpy as np
import pytest

PAPERS = Path(__file__).resolve().parents[1] / "examples" / "papers"
sys.path.insert(0, str(PAPERS))

SCRIPTS = {
    "porosity": (["cube", "cross_3d", "match-4"], ["porosity.png", "profiles.svg"]),
    "packing": (["shared", "deposited", "undamped"], ["profiles.png"]),
    "silo": (["janssen", "beverloo-28"], ["janssen.png"]),
    "drum": (["sphere-200", "sphere-250"], ["speeds.png", "distributions.png", "map.png"]),
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


def test_stress_of_an_accelerating_slope_is_balanced() -> None:
    import incline
    from common import Run

    # Layers with known mass above them, all accelerating alike: gravity 1, area 1.
    theta, acceleration = np.deg2rad(45.0), 0.2
    mass, times = np.array([4.0, 3.0, 2.0, 1.0]), np.linspace(0.0, 2.0, 40)
    momentum = mass * (1.0 + acceleration * times[:, None])
    contact = np.zeros((40, 4, 3, 3))
    contact[:, :, 2, 2] = mass * np.cos(theta)
    contact[:, :, 1, 2] = contact[:, :, 2, 1] = -mass * (np.sin(theta) - acceleration)
    arrays = {
        "contact": contact.mean(axis=0),
        "contact_frames": contact,
        "kinetic": np.zeros((4, 3, 3)),
        "momentum_frames": np.stack([np.broadcast_to(mass, (40, 4)), momentum], axis=1),
        "times": times,
        "velocity": np.ones((4, 3)),
    }
    bulk = np.array([False, True, True, False])
    run_ = SimpleNamespace(judged=True, wall_s=1.0, particle_steps=1.0)
    run_.row = MethodType(Run.row, run_)
    for expected, verdict in (("accelerating", "pass"), ("steady", "miss")):
        rows = {row.metric: row for row in incline.balance(run_, "K2s", theta, expected, arrays, bulk)}
        assert rows["mean acceleration over g"].value == pytest.approx(acceleration, rel=1e-9)
        assert rows["shear over normal stress in the bulk"].verdict == verdict
        own = rows["the same over what the bulk's own acceleration leaves of tan(theta)"]
        assert own.value == pytest.approx(1.0, rel=1e-9)


def test_the_base_does_not_hide_a_slip() -> None:
    import incline

    frame = (np.array([[0.0, 0.0, 0.2], [0.0, 0.0, 0.7]]), np.array([[0.0, 2.0, 0.0], [0.0, 6.0, 0.0]]), np.ones(2))
    count, velocity = incline.of_flowing([frame, frame], np.array([0.0, 0.5, 1.0]))
    assert count.tolist() == [1.0, 1.0] and velocity.tolist() == [2.0, 6.0]


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
