"""Means of correlated series: closed forms of white noise and of the autoregressive process."""

import numpy as np
import pytest

from sturz.measures import autocorrelation_function, block_mean, integrated_autocorrelation


def autoregressive(random: np.random.Generator, n: int, phi: float) -> np.ndarray:
    """x_k = phi x_(k-1) + noise, stationary, variance 1."""
    noise = random.standard_normal(n) * np.sqrt(1.0 - phi**2)
    x = np.empty(n)
    x[0] = random.standard_normal()
    for k in range(1, n):
        x[k] = phi * x[k - 1] + noise[k]
    return x


def test_the_autocorrelation_is_that_of_the_sum() -> None:
    x = np.random.default_rng(1).standard_normal(37)
    c = x - x.mean()
    expected = [(c[: 37 - lag] * c[lag:]).sum() / (c**2).sum() for lag in range(37)]
    assert np.allclose(autocorrelation_function(x), expected, atol=1e-12)


def test_a_constant_series_has_no_error() -> None:
    mean = block_mean(np.full(50, 0.1))
    assert mean.value == pytest.approx(0.1, abs=1e-16)
    assert mean.standard_error < 1e-16 and mean.autocorrelation == 0.5


def test_white_noise() -> None:
    x = np.random.default_rng(2).standard_normal(20000)
    assert integrated_autocorrelation(x) == pytest.approx(0.5, abs=0.06)
    assert block_mean(x).standard_error == pytest.approx(1.0 / np.sqrt(20000), rel=0.4)


def test_an_autoregressive_process_has_the_time_of_its_closed_form() -> None:
    phi = 0.9
    x = autoregressive(np.random.default_rng(3), 200_000, phi)
    # 1/2 + phi / (1 - phi) = 9.5; the error of the estimate is sqrt(2 (2 w + 1) / n) relative, w the window of 50 lags.
    assert integrated_autocorrelation(x) == pytest.approx(9.5, rel=0.1)


def test_the_error_is_what_repetitions_scatter_by() -> None:
    random = np.random.default_rng(4)
    means = [block_mean(autoregressive(random, 3000, 0.8)) for _ in range(200)]
    values = np.array([mean.value for mean in means])
    claimed = np.sqrt(np.mean([mean.standard_error**2 for mean in means]))
    # Exactly sqrt(2 tau / n) with tau = 4.5; 200 repetitions know their scatter to 5 %, and blocks of 10 tau lose 5 %.
    assert np.sqrt(9.0 / 3000) == pytest.approx(values.std(), rel=0.15)
    assert claimed == pytest.approx(values.std(), rel=0.2)
    naive = 1.0 / np.sqrt(3000)
    assert claimed > 2.0 * naive


def test_short_and_empty_series() -> None:
    assert np.isnan(block_mean([]).value) and block_mean([]).samples == 0
    one = block_mean([3.0])
    assert one.value == 3.0 and np.isnan(one.standard_error)
    assert block_mean([1.0, 3.0]).standard_error == pytest.approx(1.0)
    with pytest.raises(ValueError, match=r"\(n,\) is needed"):
        block_mean(np.zeros((3, 2)))
