"""Means of correlated series, with honest errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Mean:
    """Mean of a correlated series.

    Attributes:
        value: mean of all samples; NaN of none.
        standard_error: of the mean, from the scatter of block means; NaN below two blocks.
        autocorrelation: integrated autocorrelation time, in samples: 0.5 for independent ones.
        samples: how many.
        blocks: how many blocks of equal length the error comes from.
    """

    value: float
    standard_error: float
    autocorrelation: float
    samples: int
    blocks: int

    @property
    def effective_samples(self) -> float:
        """Number of independent samples that would have the same error."""
        return self.samples / (2.0 * self.autocorrelation) if self.samples else 0.0

    def __format__(self, form: str) -> str:
        form = form or ".4g"
        return f"{self.value:{form}} ± {self.standard_error:{form}}"


def autocorrelation_function(series: ArrayLike) -> NDArray[np.float64]:
    """Autocorrelation at lags 0, 1, ..., n - 1, (n,), 1 at lag 0; of a constant series 1 at lag 0, 0 beyond."""
    values = np.asarray(series, dtype=float)
    n = len(values)
    if n == 0:
        return np.zeros(0)
    centred = values - values.mean()
    # An FFT of twice the length: the plain one would wrap around.
    spectrum = np.fft.rfft(centred, 2 * n)
    covariance = np.fft.irfft(spectrum * spectrum.conj(), 2 * n)[:n] / n
    result = np.zeros(n)
    result[0] = 1.0
    scale = np.abs(values).max()
    if covariance[0] > (1e-14 * scale) ** 2:
        result = covariance / covariance[0]
    return result


def integrated_autocorrelation(series: ArrayLike, *, window: float = 5.0) -> float:
    """Integrated autocorrelation time 1/2 + sum of the autocorrelations, in samples; 0.5 for white noise.

    The sum ends at the first lag that is `window` times the time found so far (Sokal 1997, Monte Carlo methods in
    statistical mechanics, section 3): beyond it there is only noise. Never below 0.5, which anticorrelated series
    would give: their errors are then too large rather than too small.
    """
    correlation = autocorrelation_function(series)
    if len(correlation) < 2:
        return 0.5
    times = 0.5 + np.cumsum(correlation[1:])
    ends = np.flatnonzero(np.arange(1, len(times) + 1) >= window * times)
    return max(float(times[ends[0] if len(ends) else -1]), 0.5)


def block_mean(series: ArrayLike, *, most_blocks: int = 32) -> Mean:
    """Mean of a correlated series with the standard error of block averaging (Flyvbjerg and Petersen 1989).

    Blocks are at least ten integrated autocorrelation times long, but there are never fewer than four (of eight
    samples or more): a series too short for that has `Mean.effective_samples` below 20, and its error is a guess.

    Args:
        series: samples at equal intervals, (n,). Samples at the front that do not fill a block are in the mean alone.
        most_blocks: upper limit of blocks.
    """
    values = np.asarray(series, dtype=float)
    if values.ndim != 1:
        raise ValueError(f"the series has the shape {values.shape}; (n,) is needed")
    n = len(values)
    if n == 0:
        return Mean(float("nan"), float("nan"), 0.5, 0, 0)
    time = integrated_autocorrelation(values)
    blocks = int(min(max(n // int(np.ceil(10.0 * time)), 4), most_blocks, n))
    if n < 8:
        blocks = n
    length = n // blocks
    means = values[n - blocks * length :].reshape(blocks, length).mean(axis=1)
    error = float(means.std(ddof=1) / np.sqrt(blocks)) if blocks > 1 else float("nan")
    return Mean(float(values.mean()), error, time, n, blocks)
