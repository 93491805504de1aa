"""Plots of coarse-grained fields."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.colors import LogNorm, Normalize
from matplotlib.patches import Circle
from numpy.typing import NDArray

from ..field import Field
from ..status import Boundary
from .picture import round_up
from .style import INK, INSIDE, WALL, look, new_figure

_LABELS = {
    "solid_fraction": ("Solid fraction", "solid fraction"),
    "density": ("Density", "density (kg/m³)"),
    "momentum": ("Momentum density", "momentum density (kg/(m² s))"),
    "velocity": ("Velocity", "speed (m/s)"),
    "granular_temperature": ("Granular temperature", "granular temperature (m²/s²)"),
}
_COLOUR_MAPS = {"solid_fraction": "YlGnBu", "density": "YlGnBu", "granular_temperature": "inferno"}


def _plane(field: Field, values: NDArray[Any], normal_axis: int, index: int | None) -> NDArray[Any]:
    """The cut to draw, (n, m) or (n, m, 3): a layer of cells, or the mean over them."""
    if index is None:
        return np.asarray(values.mean(axis=normal_axis))
    return np.asarray(np.take(values, index, axis=normal_axis))


def _occupied(field: Field, normal_axis: int, index: int | None, least: float) -> NDArray[np.bool_]:
    """Where there are enough particles for a mean over them to mean something."""
    for name in ("solid_fraction", "density"):
        if name in field.columns:
            filled = _plane(field, field.columns[name], normal_axis, index)
            return np.asarray(filled > least * filled.max(initial=0.0))
    first = next(iter(field.columns.values()))
    return np.ones(_plane(field, first, normal_axis, index).shape[:2], dtype=bool)


def _normal_axis(field: Field, asked: str | None) -> int:
    if asked is not None:
        return "xyz".index(asked)
    # The homogeneous direction, where there is one.
    return int(np.argmin([field.grid.cells[axis] for axis in (1, 0, 2)])) if field.grid.cells[1] != 1 else 1


def _norm(values: NDArray[Any], limits: tuple[float, float] | None, log: bool) -> Normalize:
    finite = values[np.isfinite(values)]
    if log:
        positive = finite[finite > 0]
        top = float(np.percentile(positive, 99.5)) if len(positive) else 1.0
        low = max(float(np.percentile(positive, 2)), top * 1e-4) if len(positive) else 0.1
        return LogNorm(*(limits or (low, top)))
    top = float(np.percentile(finite, 99.7)) if len(finite) else 1.0
    return Normalize(*(limits or (0.0, round_up(top))))


def _arrows(axes: Any, first_m: Any, second_m: Any, vectors: NDArray[Any], shown: NDArray[np.bool_]) -> None:
    """Arrows over the speed, about twenty-five along the longer side."""
    every = max(int(np.ceil(max(len(first_m), len(second_m)) / 26)), 1)
    start = every // 2
    some = (slice(start, None, every), slice(start, None, every))
    keep = shown[some]
    x, y = np.meshgrid(first_m[some[0]] * 1e3, second_m[some[1]] * 1e3, indexing="ij")
    u, v = vectors[some][..., 0], vectors[some][..., 1]
    speeds = np.hypot(u, v)[keep]
    if not len(speeds) or not speeds.max() > 0:
        return
    spacing = (first_m[1] - first_m[0]) * 1e3 * every if len(first_m) > 1 else 1.0
    # Lengths by the square root of the speed: slow regions show where they go.
    size = np.sqrt(np.hypot(u, v) / np.percentile(speeds, 98)).clip(0, 1.25) / np.maximum(np.hypot(u, v), 1e-30)
    axes.quiver(
        x[keep], y[keep], (u * size)[keep], (v * size)[keep], color="white", edgecolor=INK, linewidth=0.35,
        scale=1 / (0.95 * spacing), scale_units="xy", angles="xy", width=0.0042, headwidth=3.6, headlength=4.2,
        headaxislength=3.8, pivot="mid", zorder=4,
    )  # fmt: skip


def field_plot(
    field: Field,
    quantity: str,
    path: str | os.PathLike[str] | None = None,
    *,
    boundaries: Iterable[Boundary] = (),
    normal: str | None = None,
    index: int | None = None,
    least_filling: float = 0.05,
    limits: tuple[float, float] | None = None,
    log: bool | None = None,
    colour_map: str | None = None,
    title: str | None = None,
    note: str | None = None,
    width_in: float = 6.4,
    dpi: int = 200,
) -> Any:
    """A plot of one quantity of a field on a plane, for a report. Vectors are drawn as arrows over their size.

    Args:
        field: from `Simulation.field`, a stream, or `FieldMean`.
        quantity: such as ``solid_fraction`` or ``velocity``.
        path: of the file to write (png, pdf, svg); none is written when absent.
        boundaries: from `Info.boundaries`; drums are drawn.
        normal: axis that is perpendicular to the plane, ``x``, ``y`` or ``z``; the one with the fewest cells
            when absent.
        index: which layer of cells along it; the mean over all when absent.
        least_filling: cells with a smaller part of the largest solid fraction are left blank: means over nothing.
        limits: of the colour bar.
        log: colours by the logarithm; for the granular temperature when absent.
        colour_map: of matplotlib.
        title: above the plot.
        note: above the plot instead of the time, such as how it was averaged.
        width_in: of the plot, inches.
        dpi: pixels per inch.

    Returns:
        The matplotlib figure.
    """
    boundaries = tuple(boundaries)
    name, label = _LABELS.get(quantity, (quantity.replace("_", " ").capitalize(), quantity.replace("_", " ")))
    axis = _normal_axis(field, normal)
    first, second = (each for each in (0, 1, 2) if each != axis)
    values = _plane(field, field._column(quantity), axis, index)
    shown = _occupied(field, axis, index, least_filling)
    vector = values.ndim == 3
    sizes = np.linalg.norm(values, axis=-1) if vector else values
    masked = np.where(shown, sizes, np.nan)
    use_log = quantity == "granular_temperature" if log is None else log
    if not np.any(masked[np.isfinite(masked)] > 0):
        use_log = False
    colours = matplotlib.colormaps[colour_map or _COLOUR_MAPS.get(quantity, "viridis")]
    colours = colours.with_extremes(bad=(0, 0, 0, 0))
    extent = [field.grid.min_m[first], field.grid.max_m[first], field.grid.min_m[second], field.grid.max_m[second]]
    extent = [value * 1e3 for value in extent]
    aspect = (extent[3] - extent[2]) / (extent[1] - extent[0])
    norm = _norm(masked, limits, use_log)
    if use_log:
        # Zero has no logarithm, and where there is but one particle rounding alone tells it from a tiny number: both
        # have the lowest colour.
        masked = np.where(shown, np.maximum(masked, 0.5 * float(norm.vmin or 0.0)), np.nan)
    with look():
        figure = new_figure(width_in, (width_in - 1.6) * aspect + 0.9, dpi)
        axes = figure.add_subplot()
        clip = None
        for boundary in boundaries:
            if boundary.kind == "cylinder_inside" and abs(boundary.direction[axis]) > 0.999:
                clip = _draw_drum(axes, boundary, first, second)
                shown &= _inside(field, boundary, first, second)
        image = axes.imshow(
            masked.T, origin="lower", extent=extent, cmap=colours, norm=norm,
            interpolation="nearest", zorder=2,
        )  # fmt: skip
        if clip is not None:
            image.set_clip_path(clip)
        if vector:
            some = shown
            for boundary in boundaries:
                if boundary.kind == "cylinder_inside" and abs(boundary.direction[axis]) > 0.999:
                    some = some & _inside(field, boundary, first, second, slack=-1.0)
            _arrows(axes, field.grid.axis_m(first), field.grid.axis_m(second), values[..., [first, second]], some)
        axes.set_aspect("equal")
        reach = 0.04 * (extent[1] - extent[0]) if clip is not None else 0.0
        axes.set_xlim(extent[0] - reach, extent[1] + reach)
        axes.set_ylim(extent[2] - reach, extent[3] + reach)
        axes.set_xlabel(f"{'xyz'[first]} (mm)")
        axes.set_ylabel(f"{'xyz'[second]} (mm)")
        axes.spines[["top", "right"]].set_visible(False)
        axes.set_title(title if title is not None else name)
        axes.set_title(note if note is not None else f"t = {field.time_s:.3f} s", loc="right", fontweight="normal")
        bar = figure.colorbar(image, ax=axes, shrink=0.8, aspect=28, pad=0.02, extend=_extend(masked, image.norm))
        bar.set_label(label)
        bar.outline.set_linewidth(0.5)
        axes.text(
            0.01, 0.01, f"kernel width {field.width_m * 1e3:.3g} mm", transform=axes.transAxes, fontsize=7,
            va="bottom", ha="left", zorder=5,
        )  # fmt: skip
        if path is not None:
            Path(path).parent.mkdir(parents=True, exist_ok=True)
            figure.savefig(path)
    return figure


def _draw_drum(axes: Any, boundary: Boundary, first: int, second: int) -> Any:
    """The wall of the drum; returns its inside, to clip with."""
    centre = (boundary.point_m[first] * 1e3, boundary.point_m[second] * 1e3)
    radius = boundary.radius_m * 1e3
    axes.add_patch(Circle(centre, radius * 1.035, facecolor=WALL, edgecolor=INK, linewidth=0.8, zorder=0))
    inside = Circle(centre, radius, facecolor=INSIDE, edgecolor=INK, linewidth=0.8, zorder=0.1)
    axes.add_patch(inside)
    return inside


def _inside(field: Field, boundary: Boundary, first: int, second: int, slack: float = 1.0) -> NDArray[np.bool_]:
    """Cells with their centre inside of the drum: kernels reach through its wall, particles do not."""
    across = field.grid.axis_m(first)[:, None] - boundary.point_m[first]
    along = field.grid.axis_m(second)[None, :] - boundary.point_m[second]
    # Cut cells are drawn, and clipped: `slack` counts diagonals of cells.
    diagonal = np.hypot(*(np.diff(field.grid.edges_m(axis)[:2])[0] for axis in (first, second)))
    return np.asarray(np.hypot(across, along) < boundary.radius_m + slack * diagonal)


def _extend(values: NDArray[Any], norm: Normalize) -> str:
    finite = values[np.isfinite(values)]
    if not len(finite) or norm.vmin is None or norm.vmax is None:
        return "neither"
    below, above = finite.min() < norm.vmin * (1 - 1e-9), finite.max() > norm.vmax * (1 + 1e-9)
    return "both" if below and above else "min" if below else "max" if above else "neither"
