"""A bar for long windows: simulated time, speed (simulated over wall seconds), time left."""

from __future__ import annotations

import sys
import time
from typing import Any

from tqdm import tqdm

from .status import Report


class ProgressBar:
    """Shows how far the window under way is, from the reports that the daemon publishes. Writes to stderr."""

    def __init__(self, *, from_time_s: float, to_time_s: float, label: str) -> None:
        self._from = from_time_s
        self._length = to_time_s - from_time_s
        self._started = time.monotonic()
        self._bar: Any = tqdm(
            total=self._length,
            desc=label,
            file=sys.stderr,
            bar_format=self._format(""),
            leave=True,
        )
        self._show(from_time_s, "")

    @staticmethod
    def _format(text: str) -> str:
        return f"{{desc}} {{percentage:3.0f}}% |{{bar:30}}| {text} [{{elapsed}}<{{remaining}}]"

    def _show(self, time_s: float, more: str) -> None:
        done = min(max(time_s - self._from, 0.0), self._length)
        self._bar.n = done
        speed = done / max(time.monotonic() - self._started, 1e-9)
        self._bar.bar_format = self._format(f"t = {time_s:.4f} s, {speed:.3g} s/s{more}")
        self._bar.refresh()

    def update(self, report: Report) -> None:
        """Shows one report of the daemon; those of another window are left out."""
        if report.progress is not None and report.progress.from_time_s >= self._from:
            self._show(report.time_s, f", {report.steps_per_wall_s:.3g} steps/s")

    def close(self, time_s: float) -> None:
        """Shows the end."""
        self._show(time_s, "")
        self._bar.close()


def wanted(progress: bool | None) -> bool:
    """Whether to show a bar: asked for, or on a terminal when nothing was said."""
    return sys.stderr.isatty() if progress is None else progress
