"""Avalanches in a signal over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .bodies import Floats


@dataclass(frozen=True, eq=False)
class Avalanches:
    """Events, in the order of time.

    Attributes:
        start_s, end_s: of each, (k,), s.
        size: of each, (k,): what the signal loses in a drop, or its integral over the threshold times seconds.
        waiting_s: from the end of each to the start of the next, (k - 1,), s.
    """

    start_s: Floats
    end_s: Floats
    size: Floats

    @property
    def waiting_s(self) -> Floats:
        """From the end of each to the start of the next, (k - 1,), s."""
        return self.start_s[1:] - self.end_s[:-1]

    @property
    def duration_s(self) -> Floats:
        """Of each, (k,), s."""
        return self.end_s - self.start_s

    def __len__(self) -> int:
        return len(self.size)


def drops(times_s: ArrayLike, signal: ArrayLike, *, least_drop: float) -> Avalanches:
    """Falls of a saw-tooth signal, such as the angle of the surface in a slow drum: from a peak to a trough.

    A trough ends a fall only when the signal has risen from it by `least_drop`, and a fall counts only when it is as
    large as that: noise below it makes no events, and does not cut one in two.

    Args:
        times_s: ascending, (n,), s.
        signal: (n,).
        least_drop: above 0, in units of the signal.
    """
    times, values = np.asarray(times_s, dtype=float), np.asarray(signal, dtype=float)
    if least_drop <= 0.0:
        raise ValueError(f"least_drop is {least_drop}; above 0 is needed")
    events: list[tuple[int, int]] = []
    peak = trough = 0
    falling = False
    for k in range(len(values)):
        if not falling:
            if values[k] >= values[peak]:
                peak = k
            elif values[peak] - values[k] >= least_drop:
                falling, trough = True, k
        elif values[k] < values[trough]:
            trough = k
        elif values[k] - values[trough] >= least_drop:
            events.append((peak, trough))
            falling, peak = False, k
    if falling:
        events.append((peak, trough))
    return _events(times, events, np.array([values[a] - values[b] for a, b in events]))


def bursts(times_s: ArrayLike, signal: ArrayLike, *, threshold: float) -> Avalanches:
    """Times during which a signal, such as the kinetic energy, is above a threshold; size: its integral above it.

    Crossings lie between samples, where the line between them has the threshold. A burst that is cut off by the begin
    or end of the series starts or ends there.

    Args:
        times_s: ascending, (n,), s.
        signal: (n,).
        threshold: in units of the signal.
    """
    times, over = np.asarray(times_s, dtype=float), np.asarray(signal, dtype=float) - threshold
    above = over > 0.0
    starts, ends, sizes = [], [], []
    for first, last in _runs(above):
        t, y = times[first : last + 1], over[first : last + 1]
        if first > 0:
            crossing = times[first - 1] + (times[first] - times[first - 1]) * over[first - 1] / (
                over[first - 1] - over[first]
            )
            t, y = np.insert(t, 0, crossing), np.insert(y, 0, 0.0)
        if last < len(times) - 1:
            crossing = times[last] + (times[last + 1] - times[last]) * over[last] / (over[last] - over[last + 1])
            t, y = np.append(t, crossing), np.append(y, 0.0)
        starts.append(t[0])
        ends.append(t[-1])
        sizes.append(float((0.5 * (y[1:] + y[:-1]) * np.diff(t)).sum()))
    return Avalanches(np.array(starts, dtype=float), np.array(ends, dtype=float), np.array(sizes, dtype=float))


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of each run of true."""
    steps = np.diff(np.concatenate([[0], flags.astype(int), [0]]))
    return list(zip(np.flatnonzero(steps == 1), np.flatnonzero(steps == -1) - 1, strict=True))


def _events(times: Floats, events: list[tuple[int, int]], sizes: Floats) -> Avalanches:
    starts = np.array([times[a] for a, _ in events], dtype=float)
    ends = np.array([times[b] for _, b in events], dtype=float)
    return Avalanches(starts, ends, np.asarray(sizes, dtype=float))
