"""The look that all pictures share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, cast

import matplotlib
from matplotlib.colors import LinearSegmentedColormap

INK = "#22303c"
FAINT = "#7a8791"
PAPER = "#ffffff"
INSIDE = "#f3f5f6"
WALL = "#c3cad0"

# From slow to fast, ever lighter; no colour so dark that shading would not show.
SPEEDS = LinearSegmentedColormap.from_list(
    "sturz", ["#3d4f96", "#3a7fb8", "#3fb0ac", "#8fd07c", "#e9e163", "#fff6b3"], N=512
)

_SETTINGS: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": FAINT,
    "axes.linewidth": 0.7,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "text.color": INK,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "figure.facecolor": PAPER,
    "savefig.facecolor": PAPER,
}


@contextmanager
def look() -> Iterator[None]:
    """Draws with these settings, and leaves the user's as they were."""
    with matplotlib.rc_context(cast(Any, _SETTINGS)):
        yield


def new_figure(width_in: float, height_in: float, dpi: int) -> Any:
    """A figure that no window and no global list of figures knows of."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in), dpi=dpi, layout="constrained")
    FigureCanvasAgg(figure)
    return figure
