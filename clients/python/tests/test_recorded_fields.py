"""`sturz fields` makes of a recording the very fields that the daemon made live."""

import csv
from pathlib import Path

import numpy as np
from conftest import fill
from recorder import record, sturz_run

import sturz

WINDOWS, WINDOW_S = 4, 2e-2
GRID = "-0.05,-0.012,-0.05:0.05,0.012,0.05:1,1,20"


def define_profile(simulation: sturz.Simulation, average: sturz.FieldAverage | None = None) -> None:
    """The field `p`: a profile of the drum."""
    simulation.define_field(
        name="p",
        min_m=(-0.05, -0.012, -0.05),
        max_m=(0.05, 0.012, 0.05),
        cells=(1, 1, 20),
        quantities=["density", "velocity", "contact_stress", "coordination"],
        width_m=[4e-3, 6e-3],
        average=average,
    )


def rows_of(path: Path) -> list[dict[str, float]]:
    with path.open() as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def recorded(drum: sturz.Simulation, path: Path, *topics: str) -> None:
    fill(drum)
    for stream in ("state", "contacts"):
        drum.define_output(stream, columns=["all"], every_steps=100)
    record(drum, path, WINDOWS, WINDOW_S, *topics)


def test_recorded_states_give_the_live_field_to_the_bit(drum: sturz.Simulation, tmp_path: Path) -> None:
    path, out = tmp_path / "run.mcap", tmp_path / "fields.csv"
    define_profile(drum)
    recorded(drum, path, "--topics", "state,contacts")
    live = drum.field("p")
    made = sturz_run(
        "fields", path, f"--grid={GRID}", "--width", "0.004,0.006", "--out", out,
        "--quantities", "density,velocity,contact_stress,coordination",
    )  # fmt: skip
    assert made.returncode == 0, made.stderr
    rows = rows_of(out)
    times = sorted({row["time_s"] for row in rows})
    assert len(times) > 3
    assert live.contact_stress_pa.any(), "nothing touches"
    assert live.time_s == times[-1]
    for field in (live, *live.more_widths):
        last = [row for row in rows if row["time_s"] == live.time_s and row["width_m"] == field.width_m]
        np.testing.assert_array_equal([row["density"] for row in last], field.density_kg_per_m3[0, 0])
        np.testing.assert_array_equal([row["velocity_z"] for row in last], field.velocity_m_per_s[0, 0, :, 2])
        np.testing.assert_array_equal(
            [row["contact_stress_xz"] for row in last], field.contact_stress_pa[0, 0, :, 0, 2]
        )
        np.testing.assert_array_equal([row["coordination_0"] for row in last], field.coordination[0, 0, :, 0])
        np.testing.assert_allclose([row["z_m"] for row in last], field.z_m, rtol=1e-14)
    mean = sturz_run("fields", path, "--field", "p", "--mean", "2", "--out", out)
    assert mean.returncode == 0, mean.stderr
    (row, *_) = averaged = rows_of(out)
    assert len(averaged) == 40
    assert "density_error" in row
    for k in (5, 10):
        single = [row["density"] for row in rows if row["z_m"] == averaged[k]["z_m"] and row["width_m"] == 4e-3]
        np.testing.assert_allclose(averaged[k]["density"], np.mean(single), rtol=1e-12, atol=1e-300)


def test_without_contacts_their_stress_is_an_error_that_says_so(drum: sturz.Simulation, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    recorded(drum, path, "--topics", "state")
    arguments = ("fields", path, f"--grid={GRID}", "--width", "0.004", "--quantities")
    assert sturz_run(*arguments, "density,kinetic_stress", "--out", tmp_path / "ok.csv").returncode == 0
    refused = sturz_run(*arguments, "density,stress", "--out", tmp_path / "no.csv")
    assert refused.returncode == 1
    assert "stress needs contacts, and the recording has none" in refused.stderr
    unknown = sturz_run(*arguments, "colour")
    assert unknown.returncode == 2
    assert 'there is no "colour", but solid_fraction' in unknown.stderr


def test_a_daemon_takes_means_that_its_checkpoints_hold(drum: sturz.Simulation) -> None:
    fill(drum)
    define_profile(drum, sturz.FieldAverage(every_steps=10, samples_per_block=5, blocks=3))
    drum.advance(window_s=1e-2)
    saved = drum.checkpoint()
    middle = drum.field("p")
    drum.advance(window_s=1e-2)
    end = drum.field("p")
    assert end.samples > middle.samples > 0
    assert end.blocks > 1
    assert end.standard_error("density").shape == (1, 1, 20)
    assert end.standard_error("density").any()
    drum.restore(token=saved.token)
    again = drum.field("p")
    np.testing.assert_array_equal(again.density_kg_per_m3, middle.density_kg_per_m3)
    drum.advance(window_s=1e-2)
    again = drum.field("p")
    assert (again.samples, again.blocks) == (end.samples, end.blocks)
    for name, values in end.columns.items():
        np.testing.assert_array_equal(again.columns[name], values)
        np.testing.assert_array_equal(again.standard_error(name), end.standard_error(name))
