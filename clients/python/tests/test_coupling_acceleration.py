"""Relaxation, Aitken and IQN-ILS on fixed points that the plain iteration runs away from."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from sturz.coupling.acceleration import Acceleration, Aitken, Iqn, Relaxation

Vector = NDArray[np.float64]


def linear(eigenvalues: Vector, seed: int = 3) -> tuple[Callable[[Vector], Vector], Vector]:
    """H(x) = A x + b with these eigenvalues and skew eigenvectors, and its fixed point."""
    random = np.random.default_rng(seed)
    n = len(eigenvalues)
    vectors = np.eye(n) + 0.3 * random.standard_normal((n, n)) / np.sqrt(n)
    a = vectors @ np.diag(eigenvalues) @ np.linalg.inv(vectors)
    point = random.standard_normal(n)
    b = point - a @ point
    return (lambda x: a @ x + b), point


def iterations(
    method: Acceleration, function: Callable[[Vector], Vector], point: Vector, most: int = 400, tolerance: float = 1e-10
) -> int:
    """Evaluations of `function` from 0 until its residual is small; that it then is at the fixed point is checked."""
    method.reset()
    x = np.zeros_like(point)
    first = 0.0
    for count in range(1, most + 1):
        residual = function(x) - x
        size = float(np.linalg.norm(residual))
        first = first or size
        if size <= tolerance * first:
            assert np.linalg.norm(x - point) <= 1e3 * tolerance * np.linalg.norm(point)
            return count
        if not size < 1e12 * first:
            raise OverflowError(f"ran away after {count} iterations")
        x = method.next(x, residual)
    raise TimeoutError(f"not converged in {most} iterations")


# A fluid that is denser than what moves in it: the added mass makes H overshoot.
HEAVY = np.array([-3.0, -2.0, -1.2, -0.5, 0.2, 0.4])


def test_the_plain_iteration_runs_away_and_a_small_factor_crawls() -> None:
    function, point = linear(HEAVY)
    with pytest.raises(OverflowError):
        iterations(Relaxation(1.0), function, point)
    # |1 - 0.4 (1 + 3)| = 0.6 and |1 - 0.4 (1 - 0.4)| = 0.76: 23 / -ln(0.76) = 84 iterations for 10 decades
    assert 60 <= iterations(Relaxation(0.4), function, point) <= 100


def test_aitken_is_exact_for_one_unknown_and_converges_for_six() -> None:
    function, point = linear(np.array([-3.0]))
    assert iterations(Aitken(1.0), function, point) == 3
    assert iterations(Aitken(0.1), function, point) == 3
    function, point = linear(HEAVY)
    count = iterations(Aitken(0.5), function, point)
    assert count < iterations(Relaxation(0.4), function, point)


@pytest.mark.parametrize("first", [0.05, 0.5, 1.0])
def test_quasi_newton_is_exact_after_as_many_iterations_as_unknowns(first: float) -> None:
    function, point = linear(HEAVY)
    # n differences need n + 1 residuals; the next guess is the fixed point, which one more evaluation shows
    assert iterations(Iqn(first), function, point) <= len(HEAVY) + 2
    assert iterations(Iqn(first), *linear(np.array([-30.0]))) == 3


def test_quasi_newton_needs_as_many_iterations_as_there_are_strong_directions() -> None:
    eigenvalues = np.zeros(300)
    eigenvalues[:3] = [-4.0, -2.5, -1.5]
    assert iterations(Iqn(0.5), *linear(eigenvalues)) <= 6
    with pytest.raises(OverflowError):
        iterations(Relaxation(1.0), *linear(eigenvalues))


def test_few_columns_still_converge() -> None:
    method = Iqn(0.3, columns=3)
    assert iterations(method, *linear(HEAVY)) <= 60
    assert method.used <= 3


def test_quasi_newton_on_a_nonlinear_problem() -> None:
    # x_i = 1 - x_i^3 - 2 mean(x): slope at the root below -1
    def function(x: Vector) -> Vector:
        value: Vector = 1.0 - x**3 - 2.0 * x.mean() + 0.1 * np.arange(len(x)) / len(x)
        return value

    x = np.full(40, 0.3)
    for _ in range(200):
        jacobian = -np.diag(3 * x**2) - 2.0 / len(x) - np.eye(len(x))
        x = x - np.linalg.solve(jacobian, function(x) - x)
    assert iterations(Iqn(0.3), function, x) <= 16
    with pytest.raises(OverflowError):
        iterations(Relaxation(1.0), function, x)


def test_dependent_columns_are_left_out() -> None:
    method = Iqn(0.5)
    x, r = np.zeros(3), np.array([1.0, 2.0, 3.0])
    for _ in range(4):
        # residuals on one line: one direction only
        x, r = method.next(x, r), 0.5 * r
    assert method.used == 1
    assert np.isfinite(x).all()
    # equal residuals twice: nothing to learn, the relaxed step stays
    method.reset()
    method.next(np.zeros(2), np.ones(2))
    assert np.allclose(method.next(np.zeros(2), np.ones(2)), 0.5)
    assert method.used == 0


@pytest.mark.parametrize("method", [Relaxation(0.3), Aitken(0.3), Iqn(0.3, columns=3)])
def test_a_reset_forgets_everything(method: Acceleration) -> None:
    function, point = linear(HEAVY)

    def guesses() -> list[Vector]:
        method.reset()
        x, made = np.zeros_like(point), []
        for _ in range(5):
            x = method.next(x, function(x) - x)
            made.append(x)
        return made

    assert all(np.array_equal(a, b) for a, b in zip(guesses(), guesses(), strict=True))
    method.reset()
    assert np.allclose(method.next(np.zeros(2), np.ones(2)), 0.3), "another number of unknowns after a reset"


def test_bad_input_is_named() -> None:
    for make, word in (
        (lambda: Relaxation(0.0), "factor is 0"),
        (lambda: Aitken(-1.0), "first is -1"),
        (lambda: Iqn(columns=0), "columns is 0"),
        (lambda: Iqn(dependence=1.0), "dependence is 1"),
        (lambda: Iqn().next(np.zeros(2), np.zeros(3)), "shapes"),
        (lambda: Aitken().next(np.zeros(2), np.array([0.0, np.nan])), r"residual\[1\] is nan"),
    ):
        with pytest.raises(ValueError, match=word):
            make()
    method = Iqn()
    method.next(np.zeros(2), np.ones(2))
    with pytest.raises(ValueError, match="reset"):
        method.next(np.zeros(3), np.ones(3))
