"""`sturz export`: the files hold what the simulation says, read with Python's own XML parser."""

import json
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import vtk_xml
from conftest import DRUM, SPACE, fill, wait_until
from recorder import PATIENCE_S, record, sturz_run

import sturz
from sturz.daemon import find_binary

# Polyhedra whose surfaces are exact, and a ball, in a box with a moving lid.
BOX = (
    SPACE.replace("time_step_s = 1e-5", "time_step_s = 2e-6")
    + """
[[shape]]
name = "tetrahedron"
geometry = { kind = "tetrahedron", edge_m = 3e-3 }
[[shape]]
name = "pinacoid"
geometry = { kind = "pinacoid", length_m = 3e-3, width_m = 2e-3, height_m = 1e-3, alpha_deg = 60.0 }
[[boundary]]
name = "floor"
material = "glass"
geometry = { kind = "plane", point_m = [0.0, 0.0, -0.01], normal = [0.0, 0.0, 1.0] }
[[boundary]]
name = "wall"
material = "glass"
geometry = { kind = "plane", point_m = [-0.01, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }
[[boundary]]
name = "paddle"
material = "glass"
geometry = { kind = "mesh", vertices_m = [[0, 0, 0.009], [1e-3, 0, 0.009], [0, 1e-3, 0.009]], triangles = [[0, 1, 2]] }
motion = { kind = "translation", velocity_m_per_s = [1.0, 0.0, 0.0] }
[[field]]
name = "cloud"
quantities = ["density", "velocity"]
grid = { min_m = [-0.01, -0.01, -0.01], max_m = [0.01, 0.01, 0.01], cells = [5, 4, 3] }
width_m = 3e-3
"""
    + "".join(
        f"""
[[insertion]]
shape = "{shape}"
material = "glass"
velocity_m_per_s = [0.1, 0.2, 0.3]
scale = {{ min = 0.5, max = 1.5 }}
[insertion.placement]
method = "lattice"
origin_m = [-0.005, {y}, 0.0]
spacing_m = [5e-3, 5e-3, 5e-3]
counts = [3, 1, 1]
random_orientation = true
"""
        for shape, y in (("bead", -0.005), ("cube", 0.0), ("tetrahedron", 0.005), ("pinacoid", 0.01))
    )
)


@pytest.fixture
def box(tmp_path: Path) -> Path:
    """The scene as a file."""
    path = tmp_path / "box.toml"
    path.write_text(BOX)
    return path


def export(*arguments: object) -> dict[str, object]:
    """Runs it; what it says it wrote."""
    done = sturz_run("export", *map(str, arguments), "--json")
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


@pytest.mark.parametrize("encoding", ["compressed", "base64", "ascii"])
def test_surfaces_have_the_volumes_of_their_shapes(box: Path, tmp_path: Path, encoding: str) -> None:
    out = tmp_path / "out"
    written = export(box, "--time", 2e-4, "--every", 1e-4, "--out", out, "--f64", "--encoding", encoding)
    assert written["files"] == {"boundaries": 3, "contacts": 3, "field_cloud": 3, "particles": 3}
    files = vtk_xml.series(out / "particles.pvd")
    assert list(files) == pytest.approx([0.0, 1e-4, 2e-4], abs=1.5e-5)
    with sturz.launch(box) as simulation:
        shapes, state = simulation.shapes(), simulation.state()
    first = next(iter(files.values()))
    data = first.sections["PointData"]
    for row, number in enumerate(state.ids):
        shape = shapes[state.shapes[row]]
        triangles = first.triangles_of("id", int(number))
        assert len(triangles) == len(shape.triangles)
        exact = shape.volume_m3 * state.scales[row] ** 3
        if shape.kind == "sphere":
            # Inscribed: 24 meridians and 12 parallels take 3 % off.
            assert 0.95 * exact < vtk_xml.volume(triangles) < exact
        else:
            assert vtk_xml.volume(triangles) == pytest.approx(exact, rel=1e-12)
        of_it = data["id"] == number
        assert np.all(data["shape"][of_it] == state.shapes[row])
        np.testing.assert_allclose(data["velocity"][of_it], np.tile(state.velocities_m_per_s[row], (of_it.sum(), 1)))
        np.testing.assert_allclose(data["speed"][of_it], np.linalg.norm(state.velocities_m_per_s[row]), rtol=1e-14)
    assert json.loads((out / "names.json").read_text())["shapes"][0] == "bead"


def test_glyphs_are_points_with_orientation(box: Path, tmp_path: Path) -> None:
    export(box, "--time", 1e-5, "--out", tmp_path / "out", "--glyphs", "--what", "particles", "--f64")
    with sturz.launch(box) as simulation:
        state = simulation.state()
    (first, *_) = vtk_xml.series(tmp_path / "out" / "glyphs.pvd").values()
    np.testing.assert_array_equal(first.sections["Points"]["Points"], state.positions_m)
    np.testing.assert_array_equal(first.sections["PointData"]["orientation"], state.orientations_wxyz)
    np.testing.assert_array_equal(first.sections["PointData"]["scale"], state.scales)
    assert first.attributes["NumberOfVerts"] == str(len(state))


def test_boundaries_are_where_they_are_then(box: Path, tmp_path: Path) -> None:
    export(box, "--time", 1e-3, "--every", 5e-4, "--out", tmp_path / "out", "--what", "boundaries", "--f64")
    for time_s, file in vtk_xml.series(tmp_path / "out" / "boundaries.pvd").items():
        points = file.sections["Points"]["Points"]
        offsets, corners = file.sections["Polys"]["offsets"], file.sections["Polys"]["connectivity"]
        cells = np.split(points[corners], offsets[:-1])
        names = file.sections["CellData"]["boundary"]
        assert set(names) == {0, 1, 2}
        (floor,) = (cell for cell, name in zip(cells, names, strict=True) if name == 0)
        np.testing.assert_allclose(floor[:, 2], -0.01, atol=1e-15)
        assert floor[:, 0].min() == pytest.approx(-0.01, abs=1e-15), "it ends at the wall"
        (paddle,) = (cell for cell, name in zip(cells, names, strict=True) if name == 2)
        np.testing.assert_allclose(paddle[0], [time_s, 0.0, 0.009], atol=1e-12)


def test_a_daemon_and_its_recording_give_the_same_files(tmp_path: Path) -> None:
    with sturz.launch(scene_text=DRUM) as drum:
        fill(drum)
        low, high = (-0.02, 0, -0.02), (0.02, 0.012, 0.02)
        quantities = ["density", "velocity"]
        drum.define_field(name="f", min_m=low, max_m=high, cells=(8, 1, 6), quantities=quantities, width_m=4e-3)
        record(drum, tmp_path / "a.mcap", 4, 2e-3)
        live, recorded = tmp_path / "live", tmp_path / "recorded"
        export(drum.instance, "--endpoint", drum.endpoint, "--out", live, "--f64")
        export(tmp_path / "a.mcap", "--out", recorded, "--f64")
        state, field = drum.state(), drum.field("f")
    (now,) = vtk_xml.series(live / "particles.pvd").values()
    *_, last = vtk_xml.series(recorded / "particles.pvd").values()
    assert now.time_s == last.time_s == state.time_s
    for section in ("Points", "PointData", "Polys"):
        for name, array in now.sections[section].items():
            np.testing.assert_array_equal(array, last.sections[section][name], err_msg=name)
    (image,) = vtk_xml.series(live / "field_f.pvd").values()
    assert [float(word) for word in image.attributes["Origin"].split()] == [-0.02, 0, -0.02]
    assert [float(word) for word in image.attributes["Spacing"].split()] == pytest.approx([0.005, 0.012, 0.04 / 6])
    density = image.sections["CellData"]["density"].reshape(6, 1, 8).transpose(2, 1, 0)
    np.testing.assert_array_equal(density, field.density_kg_per_m3)
    velocity = image.sections["CellData"]["velocity"].reshape(6, 1, 8, 3).transpose(2, 1, 0, 3)
    np.testing.assert_array_equal(velocity, field.velocity_m_per_s)


def test_frames_of_a_recording_are_chosen(tmp_path: Path) -> None:
    with sturz.launch(scene_text=DRUM) as drum:
        fill(drum, beads=2, crosses=0)
        record(drum, tmp_path / "a.mcap", 4, 2e-3, "--topics", "state")
    export(tmp_path / "a.mcap", "--out", tmp_path / "all", "--glyphs")
    times = list(vtk_xml.series(tmp_path / "all" / "glyphs.pvd"))
    export(tmp_path / "a.mcap", "--out", tmp_path / "some", "--glyphs", "--stride", 2)
    assert list(vtk_xml.series(tmp_path / "some" / "glyphs.pvd")) == times[::2]
    written = export(tmp_path / "a.mcap", "--out", tmp_path / "one", "--glyphs", "--times", f"{times[-1]},9")
    assert list(vtk_xml.series(tmp_path / "one" / "glyphs.pvd")) == times[-1:]
    assert written["times_missed"] == [9.0]


def test_a_followed_daemon_is_written_until_it_ends(tmp_path: Path) -> None:
    out = tmp_path / "out"

    def times() -> list[float]:
        try:
            return list(vtk_xml.series(out / "glyphs.pvd"))
        except (FileNotFoundError, ElementTree.ParseError):
            return []  # not yet, or in the midst of a write

    with sturz.launch(scene_text=DRUM) as drum:
        fill(drum, beads=3, crosses=0)
        where = [drum.instance, "--endpoint", drum.endpoint, "--out", str(out)]
        command = [str(find_binary()), "export", *where, "--follow", "--glyphs", "--what", "particles"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as follower:
            wait_until(lambda: times() == [0.0], what="the first frame")
            reached_s = drum.advance(window_s=2e-3).time_reached_s
            wait_until(lambda: times()[-1:] == [reached_s], what="the last frame")
            drum.stop()
            follower.communicate(timeout=PATIENCE_S)
    assert follower.returncode == 0


def test_a_checkpoint_is_exported_without_a_run(box: Path, tmp_path: Path) -> None:
    with sturz.launch(box, checkpoints=tmp_path / "saved") as simulation:
        simulation.advance(window_s=1e-4)
        simulation.checkpoint(token="a", on_disk=True)
        state = simulation.state()
    saved = tmp_path / "saved" / "a.checkpoint"
    export(box, "--checkpoint", saved, "--out", tmp_path / "out", "--glyphs", "--f64")
    ((time_s, file),) = vtk_xml.series(tmp_path / "out" / "glyphs.pvd").items()
    assert time_s == state.time_s
    np.testing.assert_array_equal(file.sections["Points"]["Points"], state.positions_m)
    saved.write_bytes(saved.read_bytes()[:-10])
    refused = sturz_run("export", str(box), "--checkpoint", str(saved), "--out", str(tmp_path / "cut"))
    assert refused.returncode == 1
    assert "a.checkpoint" in refused.stderr


def test_a_run_that_fails_says_so_and_leaves_the_refused_state(box: Path, tmp_path: Path) -> None:
    # The paddle through the middle of a cube.
    box.write_text(BOX.replace("0.009]", "0.0]"))
    failed = sturz_run("export", str(box), "--time", "1e-3", "--out", str(tmp_path / "out"), "--glyphs")
    assert failed.returncode == 4
    assert "paddle" in failed.stderr
    assert len(vtk_xml.series(tmp_path / "out" / "glyphs.pvd")) == 2


def test_what_cannot_be_exported_is_refused_with_the_remedy(box: Path, tmp_path: Path) -> None:
    for arguments, code, words in [
        ([box], 2, "--time"),
        (["drum-crosses", "--endpoint", "tcp/127.0.0.1:1"], 6, "--time"),
        ([box, "--time", "1e-3", "--every", "0"], 2, "--every is 0"),
        ([box, "--time", "1e-3", "--times", "1"], 2, "--every"),
        ([box, "--time", "nan"], 2, "--time"),
        (["no.mcap"], 1, "no.mcap"),
    ]:
        refused = sturz_run("export", *map(str, arguments), "--out", str(tmp_path / "out"))
        assert refused.returncode == code, refused.stderr
        assert words in refused.stderr
    at_file = sturz_run("export", str(box), "--time", "1e-4", "--out", str(box))
    assert at_file.returncode == 1
    assert str(box) in at_file.stderr


def test_contacts_are_those_of_the_run(tmp_path: Path) -> None:
    export("cube-tower", "--time", 1e-3, "--out", tmp_path / "out", "--what", "contacts", "--f64")
    *_, last = vtk_xml.series(tmp_path / "out" / "contacts.pvd").values()
    cells = last.sections["CellData"]
    with sturz.launch("cube-tower") as simulation:
        while simulation.info().time_s < 1e-3:
            simulation.step(steps=1)
        contacts = simulation.contacts()
    np.testing.assert_array_equal(cells["id_a"], contacts.ids[:, 0])
    np.testing.assert_array_equal(cells["normal_force"], contacts.normal_forces_n)
    np.testing.assert_array_equal(cells["point"], contacts.points_m)
    assert last.attributes["NumberOfLines"] == str(len(contacts.ids)) == "10"
