"""The particles, with their true shapes, in their boundaries."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.patches import Circle, FancyArrowPatch, Polygon
from numpy.typing import ArrayLike, NDArray

from ..state import BoundaryState, Shape, State
from ..status import Boundary, Domain
from . import render
from .render import View
from .style import FAINT, INK, INSIDE, SPEEDS, WALL, look, new_figure

_OVERSAMPLING = 2
_MARGIN = 0.035


def _values(state: State, colour_by: str | ArrayLike) -> tuple[NDArray[np.float64], str]:
    """One number per particle, and what it is."""
    if not isinstance(colour_by, str):
        values = np.asarray(colour_by, dtype=float)
        if values.shape != (len(state),):
            raise ValueError(f"colour_by has the shape {values.shape}; ({len(state)},) is needed")
        return values, ""
    if colour_by == "speed":
        return np.asarray(state.speeds_m_per_s, dtype=float), "speed (m/s)"
    if colour_by == "angular_speed":
        spins = np.linalg.norm(np.asarray(state.angular_velocities_rad_per_s, dtype=float), axis=1)
        return spins, "angular speed (rad/s)"
    raise ValueError(f"colour_by is {colour_by!r}; 'speed', 'angular_speed' or an array of one number per particle")


def _extent(
    state: State, shapes: tuple[Shape, ...], boundaries: tuple[Boundary, ...], domain: Domain | None, view: View
) -> tuple[float, float, float, float]:
    """Left, right, bottom, top of all that is drawn, m."""
    radii = np.array([shape.bounding_radius_m for shape in shapes])
    points = []
    if len(state):
        reach = radii[state.shapes] * np.asarray(state.columns.get("scales", np.ones(len(state))), dtype=float)
        centres = render.project(state.positions_m, view)[:, :2]
        points += [centres - reach[:, None], centres + reach[:, None]]
    for boundary in boundaries:
        if boundary.kind in ("cylinder_inside", "cylinder_outside"):
            points += [ring[:, :2] for ring in _rims(boundary, state, domain, view)]
        elif boundary.kind == "mesh":
            now = next((each for each in state.boundaries if each.name == boundary.name), None)
            points.append(_mesh_edges(boundary, now, view).reshape(-1, 2))
    if not points:
        raise ValueError("there is nothing to draw: neither particles nor a drum")
    every = np.concatenate(points)
    (left, bottom), (right, top) = every.min(axis=0), every.max(axis=0)
    margin = _MARGIN * max(right - left, top - bottom)
    return left - margin, right + margin, bottom - margin, top + margin


def _rims(boundary: Boundary, state: State, domain: Domain | None, view: View) -> list[NDArray[np.float64]]:
    """The two ends of a drum in view coordinates, the farther one first, (k, 3) each."""
    axis = boundary.direction / np.linalg.norm(boundary.direction)
    along = np.zeros((0,))
    if domain is not None and any(domain.periodic):
        periodic = np.where(domain.periodic, 1.0, 0.0)
        along = np.array([(domain.min_m * periodic) @ axis, (domain.max_m * periodic) @ axis])
    elif len(state):
        along = np.asarray(state.positions_m, dtype=float) @ axis
    along = along - boundary.point_m @ axis if len(along) else np.zeros(2)
    first = np.cross(axis, (0.0, 0.0, 1.0) if abs(axis[2]) < 0.9 else (1.0, 0.0, 0.0))
    first /= np.linalg.norm(first)
    angle = np.linspace(0, 2 * np.pi, 361)[:, None]
    ring = boundary.radius_m * (np.cos(angle) * first + np.sin(angle) * np.cross(axis, first))
    ends = [boundary.point_m + ring + axis * place for place in (along.min(), along.max())]
    rings = [np.asarray(render.project(end, view)) for end in ends]
    return sorted(rings, key=lambda each: float(each[:, 2].mean()))


def _draw_drum(
    axes: Any, boundary: Boundary, now: BoundaryState | None, state: State, domain: Domain | None, view: View
) -> None:
    """The drum: far end filled, wall, near end as a line, and how it turns."""
    far, near = (ring[:, :2] * 1e3 for ring in _rims(boundary, state, domain, view))
    radius = boundary.radius_m * 1e3
    axis = render.project(boundary.direction / np.linalg.norm(boundary.direction), view)
    if abs(axis[2]) < 0.999:
        axes.add_patch(Polygon(far, closed=True, facecolor=INSIDE, edgecolor=FAINT, linewidth=1.2, zorder=0))
        axes.add_patch(Polygon(near, closed=True, fill=False, edgecolor=INK, linewidth=1.8, zorder=4))
        return
    centre = near[:-1].mean(axis=0)
    thick = 0.035 * radius
    axes.add_patch(Circle(centre, radius + thick, facecolor=WALL, edgecolor=INK, linewidth=0.8, zorder=0))
    axes.add_patch(Circle(centre, radius, facecolor=INSIDE, edgecolor=INK, linewidth=0.8, zorder=0.1))
    if now is None:
        return
    # Marks on the wall turn with it. Seen along +axis a positive rotation is clockwise, against it counter-clockwise.
    sense = 1.0 if axis[2] > 0 else -1.0
    for mark in np.arange(24) * np.pi / 12 + sense * now.angle_rad:
        direction = np.array([np.cos(mark), np.sin(mark)])
        ends = centre + np.outer((radius + 0.15 * thick, radius + 0.85 * thick), direction)
        axes.plot(*ends.T, color=INK, linewidth=0.7, zorder=0.2, solid_capstyle="butt")
    if now.angular_velocity_rad_per_s != 0.0:
        _draw_turn(axes, centre, radius, sense * now.angular_velocity_rad_per_s)


def _draw_roller(axes: Any, boundary: Boundary, state: State, domain: Domain | None, view: View) -> None:
    """The roller, filled from end to end."""
    for ring in _rims(boundary, state, domain, view):
        axes.add_patch(Polygon(ring[:, :2] * 1e3, closed=True, facecolor=WALL, edgecolor=INK, linewidth=0.8, zorder=0))


def _mesh_edges(boundary: Boundary, now: BoundaryState | None, view: View) -> NDArray[np.float64]:
    """Edges of a mesh where its surface bends or ends, in view coordinates, (k, 2, 2)."""
    assert boundary.vertices_m is not None and boundary.triangles is not None
    vertices, triangles = boundary.vertices_m, np.asarray(boundary.triangles, dtype=np.int64)
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    beside: dict[tuple[int, int], list[int]] = {}
    for number, (a, b, c) in enumerate(triangles.tolist()):
        for pair in ((a, b), (b, c), (c, a)):
            beside.setdefault((min(pair), max(pair)), []).append(number)
    bent = [pair for pair, of in beside.items() if len(of) == 1 or normals[of[0]] @ normals[of[1]] < 1 - 1e-6]
    if now is not None and now.orientation_wxyz.any():
        w, axis = now.orientation_wxyz[0], now.orientation_wxyz[1:]
        across = 2.0 * np.cross(axis, vertices)
        vertices = now.point_m + vertices + w * across + np.cross(axis, across)
    ends = vertices[np.array(bent, dtype=np.int64).reshape(-1, 2)]
    return np.asarray(render.project(ends.reshape(-1, 3), view))[:, :2].reshape(-1, 2, 2)


def _draw_mesh(axes: Any, boundary: Boundary, now: BoundaryState | None, view: View) -> None:
    """A mesh by its edges."""
    edges = list(_mesh_edges(boundary, now, view) * 1e3)
    axes.add_collection(LineCollection(edges, colors=INK, linewidths=0.7, zorder=0.2))


def _draw_turn(axes: Any, centre: NDArray[np.float64], radius: float, rad_per_s: float) -> None:
    """An arc with an arrow inside of the top of the drum, and the revolutions per minute below it."""
    reach = 0.88 * radius
    angles = np.deg2rad(np.linspace(108, 72, 40))
    if rad_per_s > 0:
        angles = angles[::-1]
    arc = centre + reach * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    axes.plot(*arc[:-2].T, color=INK, linewidth=1.1, zorder=5)
    arrow = FancyArrowPatch(arc[-4], arc[-1], arrowstyle="-|>", mutation_scale=10, color=INK, linewidth=1.1, zorder=5)
    axes.add_patch(arrow)
    rpm = abs(rad_per_s) * 60 / (2 * np.pi)
    axes.text(centre[0], centre[1] + 0.80 * radius, f"{rpm:.3g} rpm", ha="center", va="top", fontsize=9, zorder=5)


def _draw_gravity(axes: Any, gravity_m_per_s2: NDArray[np.float64], view: View, place: tuple[float, float]) -> None:
    """An arrow with a plumb line beside it when gravity is tilted."""
    right, up, _ = render.project(gravity_m_per_s2, view)
    size = np.linalg.norm(gravity_m_per_s2)
    if size == 0.0 or np.hypot(right, up) < 0.05 * size:
        return
    length = 0.1
    start = np.array(place)
    end = start + length * np.array([right, up]) / size
    if abs(right) > 1e-9 * size:
        axes.plot(
            [start[0]] * 2,
            [start[1], start[1] - length],
            color=FAINT,
            linewidth=0.8,
            linestyle=(0, (3, 2)),
            transform=axes.transAxes,
            zorder=5,
        )
    axes.annotate(
        "",
        xy=end,
        xytext=start,
        xycoords="axes fraction",
        zorder=6,
        arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.1, "shrinkA": 0, "shrinkB": 0},
    )
    tilt = np.rad2deg(np.arctan2(abs(right), -up))
    label = r"$g$" if tilt < 0.05 else rf"$g$, {tilt:.3g}°"
    axes.text(start[0], start[1] + 0.012, label, transform=axes.transAxes, ha="center", va="bottom", fontsize=9)


def picture(
    state: State,
    shapes: Iterable[Shape],
    boundaries: Iterable[Boundary] = (),
    path: str | os.PathLike[str] | None = None,
    *,
    domain: Domain | None = None,
    colour_by: str | ArrayLike = "speed",
    label: str | None = None,
    limits: tuple[float, float] | None = None,
    colour_map: str | None = None,
    view: View | None = None,
    title: str | None = None,
    width_in: float = 7.2,
    dpi: int = 200,
) -> Any:
    """A picture of the particles with their true shapes, for a report.

    Args:
        state: with the columns shapes, positions, orientations, and what `colour_by` needs.
        shapes: from `Simulation.shapes`.
        boundaries: from `Info.boundaries`; drums, rollers and meshes are drawn.
        path: of the file to write (png, pdf, svg); none is written when absent.
        domain: from `Info.domain`: how long a drum along a periodic axis is.
        colour_by: ``speed``, ``angular_speed``, or one number per particle, (n,).
        label: of the colour bar, with its unit.
        limits: of the colour bar; from 0 to a round number above the 99th percentile when absent.
        colour_map: of matplotlib; one that leaves room for shading when absent.
        view: from where; along +y with z up when absent.
        title: above the picture.
        width_in: of the picture, inches.
        dpi: pixels per inch.

    Returns:
        The matplotlib figure.
    """
    view = view or View()
    shapes, boundaries = tuple(shapes), tuple(boundaries)
    values, meaning = _values(state, colour_by)
    norm = Normalize(*(limits or _round_limits(values)))
    chosen = matplotlib.colormaps[colour_map] if colour_map is not None else SPEEDS
    colours = chosen(norm(values))[:, :3] if len(values) else np.zeros((0, 3))
    left, right, bottom, top = _extent(state, shapes, boundaries, domain, view)
    drawing_in = width_in - 1.6
    pixel_m = (right - left) / (drawing_in * dpi * _OVERSAMPLING)
    width = int(np.ceil((right - left) / pixel_m / _OVERSAMPLING)) * _OVERSAMPLING
    height = int(np.ceil((top - bottom) / pixel_m / _OVERSAMPLING)) * _OVERSAMPLING
    triangles = render.mesh(state, shapes, view, np.arange(len(state)))
    buffer = render.rasterise(triangles, left_m=left, bottom_m=bottom, pixel_m=pixel_m, width=width, height=height)
    size_m = 2 * min((shape.bounding_radius_m for shape in shapes), default=1.0)
    pixels = render.reduced(render.shade(buffer, colours, size_m=size_m, pixel_m=pixel_m), _OVERSAMPLING)
    with look():
        figure = new_figure(width_in, drawing_in * (top - bottom) / (right - left) + 0.8, dpi)
        axes = figure.add_subplot()
        by_name = {boundary.name: boundary for boundary in state.boundaries}
        for boundary in boundaries:
            if boundary.kind == "cylinder_inside":
                _draw_drum(axes, boundary, by_name.get(boundary.name), state, domain, view)
            elif boundary.kind == "cylinder_outside":
                _draw_roller(axes, boundary, state, domain, view)
            elif boundary.kind == "mesh":
                _draw_mesh(axes, boundary, by_name.get(boundary.name), view)
        far_right, far_top = left + width * pixel_m, bottom + height * pixel_m
        extent = [left * 1e3, far_right * 1e3, bottom * 1e3, far_top * 1e3]
        axes.imshow(pixels, origin="lower", extent=extent, interpolation="antialiased", zorder=3)
        axes.set_xlim(left * 1e3, right * 1e3)
        axes.set_ylim(bottom * 1e3, top * 1e3)
        axes.set_aspect("equal")
        axes.set_xlabel(f"{_axis_name(view.axes()[0])} (mm)")
        axes.set_ylabel(f"{_axis_name(view.axes()[1])} (mm)")
        axes.spines[["top", "right"]].set_visible(False)
        _draw_gravity(axes, state.gravity_m_per_s2, view, (0.07, 0.93))
        axes.set_title(title if title is not None else f"{len(state)} particles")
        axes.set_title(f"t = {state.time_s:.3f} s", loc="right", fontweight="normal")
        mappable = matplotlib.cm.ScalarMappable(norm, chosen)
        above = bool(len(values)) and values.max() > norm.vmax
        bar = figure.colorbar(mappable, ax=axes, shrink=0.72, aspect=28, pad=0.02, extend="max" if above else "neither")
        bar.set_label(label if label is not None else meaning)
        bar.outline.set_linewidth(0.5)
        if path is not None:
            Path(path).parent.mkdir(parents=True, exist_ok=True)
            figure.savefig(path)
    return figure


def _axis_name(axis: NDArray[np.float64]) -> str:
    """``x`` for a view along the others, else what the picture's axis is made of."""
    for index, name in enumerate("xyz"):
        if abs(abs(axis[index]) - 1) < 1e-9:
            return name if axis[index] > 0 else f"−{name}"
    return "distance in the picture"


def _round_limits(values: NDArray[np.float64]) -> tuple[float, float]:
    """Zero, and a round number above nearly all values: a single fast particle must not take all colours."""
    top = float(np.percentile(values, 99)) if len(values) else 1.0
    return 0.0, round_up(top)


def round_up(value: float) -> float:
    """The next number of 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten; 1 for zero."""
    if not value > 0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(value))
    steps = np.array([1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10]) * power
    return float(steps[np.searchsorted(steps, value * (1 - 1e-9))])
