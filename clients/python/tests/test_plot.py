"""Pictures show what is there: areas, hidden surfaces, colours, and no blank paper."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from matplotlib import image

import sturz
from sturz import columns
from sturz._proto.sturz.v1 import data_pb2 as pb
from sturz._proto.sturz.v1 import status_pb2 as status_pb
from sturz.plot import View, field_plot, picture, render
from sturz.plot.picture import _mesh_edges

CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
# Two triangles a side, counter-clockwise seen from outside.
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = np.array([corner for a, b, c, d in SIDES for corner in ((a, b, c), (a, c, d))], dtype=np.uint32)
CUBE = sturz.Shape("cube", "cube", 1.0, np.sqrt(0.75), np.full(3, 1 / 6), CORNERS, TRIANGLES, {"edge_m": 1.0}, 1)
NO_TURN = (1.0, 0.0, 0.0, 0.0)
# By 45 degrees about z.
TURNED = (float(np.cos(np.pi / 8)), 0.0, 0.0, float(np.sin(np.pi / 8)))
DRUM = sturz.Boundary("drum", "steel", "cylinder_inside", np.zeros(3), np.array([0.0, 1.0, 0.0]), 4.0)


def state_of(
    positions: Sequence[Sequence[float]],
    orientations: Sequence[Sequence[float]] | None = None,
    speeds: Sequence[float] | None = None,
    turning: bool = False,
) -> sturz.State:
    """Cubes of edge 1 m."""
    n = len(positions)
    message = pb.Frame(n=n)
    message.gravity_m_per_s2.z = -9.81
    velocities = [(speed, 0.0, 0.0) for speed in (speeds or [0.0] * n)]
    for name, values, components in (
        ("positions", positions, 3),
        ("orientations", orientations or [NO_TURN] * n, 4),
        ("velocities", velocities, 3),
        ("scales", np.ones(n), 1),
    ):
        message.columns.append(columns.encode(name, values, components=components))
    message.columns.append(columns.encode("ids", np.arange(n), components=1, dtype=pb.DATA_TYPE_U64))
    message.columns.append(columns.encode("shapes", np.zeros(n), components=1, dtype=pb.DATA_TYPE_U32))
    if turning:
        message.boundaries.add(name="drum", angle_rad=0.3, angular_velocity_rad_per_s=2.0)
    return sturz.State.from_message(message)


def rastered(state: sturz.State, view: View | None = None, pixel_m: float = 0.01) -> render.Buffer:
    """What is seen of a square of 4 m around the origin."""
    mesh = render.mesh(state, (CUBE,), view or View(), np.arange(len(state)))
    size = round(4 / pixel_m)
    return render.rasterise(mesh, left_m=-2.0, bottom_m=-2.0, pixel_m=pixel_m, width=size, height=size)


def area_m2(buffer: render.Buffer, pixel_m: float = 0.01) -> float:
    """Of all covered pixels."""
    return float((buffer.particle >= 0).sum()) * pixel_m**2


@pytest.mark.parametrize(
    ("orientation", "view", "expected_m2"),
    [
        (NO_TURN, View(), 1.0),
        (TURNED, View(), np.sqrt(2)),
        (TURNED, View(towards=(0, 0, -1), up=(0, 1, 0)), 1.0),
        # Along a space diagonal a unit cube is a hexagon of area sqrt(3).
        (NO_TURN, View(towards=(1, 1, 1)), np.sqrt(3)),
    ],
)
def test_the_shadow_of_a_cube_has_its_area(orientation: tuple[float, ...], view: View, expected_m2: float) -> None:
    # Borders of 4 to 6 m cut pixels of 1 cm2 in halves: less than 1 %.
    assert area_m2(rastered(state_of([[0, 0, 0]], [orientation]), view)) == pytest.approx(expected_m2, rel=0.01)


def test_the_nearer_particle_hides_the_farther_one_whatever_their_order() -> None:
    # One looks along +y: smaller y is nearer.
    for positions in ([[0.0, -1.0, 0.0], [0.2, 1.0, 0.0]], [[0.2, 1.0, 0.0], [0.0, -1.0, 0.0]]):
        buffer = rastered(state_of(positions))
        near = next(row for row, position in enumerate(positions) if position[1] == -1)
        assert buffer.particle[200, 200] == near
        assert (buffer.particle == near).sum() == pytest.approx(1e4, rel=0.01)
        assert (buffer.particle == 1 - near).sum() == pytest.approx(0.2e4, rel=0.05)


def test_faces_are_lit_and_their_normals_point_to_the_viewer() -> None:
    buffer = rastered(state_of([[0, 0, 0]], [TURNED]))
    seen = buffer.normal[buffer.particle >= 0]
    np.testing.assert_allclose(np.abs(seen @ [1, 0, 0]), np.sqrt(0.5), atol=1e-9)
    assert (seen[:, 2] > 0).all()


def test_the_view_and_what_it_refuses() -> None:
    np.testing.assert_allclose(View().axes(), [[1, 0, 0], [0, 0, 1], [0, -1, 0]], atol=1e-15)
    with pytest.raises(ValueError, match="parallel or zero"):
        View(towards=(0, 0, 1)).axes()


def ink(path: Path) -> np.ndarray:
    """RGB of a written picture, (h, w, 3)."""
    pixels = np.asarray(image.imread(path), dtype=float)[..., :3]
    assert pixels.std() > 0.03, "the picture is blank"
    return pixels


def share_near(pixels: np.ndarray, colour: Sequence[float], within: float = 0.25) -> float:
    """Part of the pixels whose hue is about that of `colour`: directions in RGB, so that shading does not count."""
    flat = pixels.reshape(-1, 3)
    saturated = np.ptp(flat, axis=1) > 0.12
    directions = flat - flat.mean(axis=1, keepdims=True)
    wanted = np.asarray(colour) - np.mean(colour)
    cosine = directions @ wanted / np.maximum(np.linalg.norm(directions, axis=1) * np.linalg.norm(wanted), 1e-12)
    return float((saturated & (cosine > 1 - within**2 / 2)).mean())


def test_a_picture_of_a_drum_shows_slow_and_fast_particles_in_their_colours(tmp_path: Path) -> None:
    state = state_of([[-1.5, 0, 0], [1.5, 0, 0]], [NO_TURN, TURNED], speeds=[0.0, 1.0], turning=True)
    path = tmp_path / "new folder" / "drum.png"
    figure = picture(state, (CUBE,), (DRUM,), path, limits=(0, 1), colour_map="coolwarm", title="Two cubes", dpi=100)
    pixels = ink(path)
    half = pixels.shape[1] // 2
    left, right = pixels[:, : int(0.85 * half)], pixels[:, int(0.5 * half) : int(1.5 * half)]
    blue, red = (0.23, 0.30, 0.75), (0.71, 0.02, 0.15)
    assert share_near(left, blue) > 0.01
    assert share_near(left, red) == 0.0
    assert share_near(right, red) > 0.01
    axes, bar = figure.axes
    assert (axes.get_title("left"), axes.get_title("right")) == ("Two cubes", "t = 0.000 s")
    assert (axes.get_xlabel(), axes.get_ylabel(), bar.get_ylabel()) == ("x (mm)", "z (mm)", "speed (m/s)")
    assert any("19.1 rpm" in text.get_text() for text in axes.texts)


def test_a_drum_is_drawn_without_particles_and_nothing_at_all_is_an_error(tmp_path: Path) -> None:
    picture(state_of([]), (CUBE,), (DRUM,), tmp_path / "empty.png", dpi=80)
    ink(tmp_path / "empty.png")
    with pytest.raises(ValueError, match="nothing to draw"):
        picture(state_of([]), (CUBE,))


def test_particles_are_coloured_by_any_number_of_ones_own(tmp_path: Path) -> None:
    state = state_of([[-1.5, 0, 0], [1.5, 0, 0]])
    picture(state, (CUBE,), path=tmp_path / "mine.png", colour_by=[1.0, 2.0], label="size (mm)", dpi=80)
    ink(tmp_path / "mine.png")
    with pytest.raises(ValueError, match=r"shape \(3,\); \(2,\) is needed"):
        picture(state, (CUBE,), colour_by=[1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match="colour_by is 'size'"):
        picture(state, (CUBE,), colour_by="size")


def field_of(width: int = 40) -> sturz.Field:
    """A half-filled drum of radius 4 m that turns like a rigid body, on width x 1 x width cells."""
    grid = sturz.Grid((-4.0, 0.0, -4.0), (4.0, 1.0, 4.0), (width, 1, width))
    x, z = np.meshgrid(grid.axis_m(0), grid.axis_m(2), indexing="ij")
    filled = ((x**2 + z**2 < 16) & (z < 0)).astype(float)
    velocity = np.stack([z * filled, 0 * x, -x * filled], axis=-1)
    arrays = {
        "solid_fraction": 0.6 * filled,
        "velocity": velocity,
        "granular_temperature": filled * np.exp(z),
    }
    header = sturz.Header("run", 0, 10, 1.25, 0, 1)
    values = {name: array[:, None] for name, array in arrays.items()}
    return sturz.Field(header, "drum", grid, values, "truncated_gaussian", 0.3, 4.0, 1.0, np.zeros(3))


@pytest.mark.parametrize(
    ("quantity", "title", "label"),
    [
        ("solid_fraction", "Solid fraction", "solid fraction"),
        ("velocity", "Velocity", "speed (m/s)"),
        ("granular_temperature", "Granular temperature", "granular temperature (m²/s²)"),
    ],
)
def test_a_plot_of_a_field_shows_the_filled_half(tmp_path: Path, quantity: str, title: str, label: str) -> None:
    path = tmp_path / "field.png"
    figure = field_plot(field_of(), quantity, path, boundaries=(DRUM,), dpi=100)
    axes, bar = figure.axes[:2]
    assert (axes.get_title("left"), axes.get_title("right")) == (title, "t = 1.250 s")
    assert (axes.get_xlabel(), axes.get_ylabel(), bar.get_ylabel()) == ("x (mm)", "z (mm)", label)
    shown = np.ma.masked_invalid(axes.images[0].get_array())
    assert shown[:20].count() == pytest.approx(np.pi * 8 / 0.04, rel=0.05), "half a circle, in cells of 0.2 m"
    assert shown[20:].count() == 0
    ink(path)


def test_zero_and_rounding_noise_have_the_lowest_colour_of_a_logarithmic_plot() -> None:
    field = field_of()
    temperature = field.columns["granular_temperature"]
    temperature[:10] = 0.0
    temperature[10:12] = 1e-20
    figure = field_plot(field, "granular_temperature", boundaries=(DRUM,), dpi=60, note="mean of 3 frames")
    picture_of = figure.axes[0].images[0]
    low = np.ma.masked_invalid(picture_of.get_array())[:20, :12]
    assert low.count() > 50, "they are not blank"
    assert (low.compressed() < picture_of.norm.vmin).all()
    assert figure.axes[0].get_title("right") == "mean of 3 frames"


def test_a_field_of_nothing_is_plotted_too(tmp_path: Path) -> None:
    field = field_of()
    empty = {name: np.zeros_like(values) for name, values in field.columns.items()}
    still = sturz.Field(field.header, "drum", field.grid, empty, "k", 0.3, 4.0, 0.0, np.zeros(3))
    for quantity in empty:
        field_plot(still, quantity, tmp_path / f"{quantity}.png", boundaries=(DRUM,), dpi=60)
        assert (tmp_path / f"{quantity}.png").stat().st_size > 1000


def test_a_layer_of_a_field_is_drawn_along_the_axis_asked_for() -> None:
    grid = sturz.Grid((0.0, 0.0, 0.0), (2.0, 3.0, 4.0), (2, 3, 4))
    density = np.arange(24.0).reshape(2, 3, 4)
    header = sturz.Header("run", 0, 0, 0.0, 0, 0)
    field = sturz.Field(header, "f", grid, {"density": density}, "k", 0.3, 4.0, 1.0, np.zeros(3))
    figure = field_plot(field, "density", normal="z", index=3, least_filling=0.0, dpi=60)
    np.testing.assert_array_equal(figure.axes[0].images[0].get_array(), density[:, :, 3].T)
    assert (figure.axes[0].get_xlabel(), figure.axes[0].get_ylabel()) == ("x (mm)", "y (mm)")


def test_rollers_and_meshes_are_read_and_drawn_where_they_are(tmp_path: Path) -> None:
    info = status_pb.BoundaryInfo(name="block", material="steel")
    info.mesh.vertices.CopyFrom(columns.encode("vertices", CORNERS, components=3, unit="m"))
    triangles = columns.encode("triangles", TRIANGLES, components=3, dtype=pb.DATA_TYPE_U32)
    info.mesh.triangles.CopyFrom(triangles)
    block = sturz.Boundary.from_message(info)
    assert block.kind == "mesh" and block.vertices_m is not None
    np.testing.assert_array_equal(block.vertices_m, CORNERS)
    np.testing.assert_array_equal(block.triangles, TRIANGLES)
    message = pb.BoundaryState(name="block", point_m=pb.Vec3(x=3.0))
    message.orientation.w, message.orientation.z = TURNED[0], TURNED[3]
    now = sturz.BoundaryState.from_message(message)
    edges = _mesh_edges(block, now, View())
    assert edges.shape == (12, 2, 2), "diagonals of faces are not edges"
    np.testing.assert_allclose(edges[..., 0].min(), 3.0 - np.sqrt(0.5), atol=1e-12)
    roller = sturz.Boundary("roller", "steel", "cylinder_outside", np.zeros(3), np.array([0.0, 1.0, 0.0]), 1.0)
    path = tmp_path / "boundaries.png"
    figure = picture(state_of([(0.0, 0.0, 1.5)]), (CUBE,), (roller, block), path, dpi=60)
    assert len(figure.axes[0].collections) == 1 and len(figure.axes[0].patches) >= 2
    ink(path)
