"""How an iterated window comes to its next guess: x is what the particles saw, x + residual what the solver found.

All start afresh with each window: a run that was resumed goes on as one that never stopped.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = NDArray[np.float64]


class Acceleration(Protocol):
    """What `Implicit` needs to find x where the residual H(x) - x is 0."""

    def reset(self) -> None:
        """A new window begins."""

    def next(self, x: ArrayLike, residual: ArrayLike) -> Vector:
        """The next guess, (n,), out of the last one and its residual, both (n,)."""


def _checked(x: ArrayLike, residual: ArrayLike, size: int | None) -> tuple[Vector, Vector]:
    # copies: what is remembered must not change with the caller's arrays
    at, r = np.array(x, dtype=float), np.array(residual, dtype=float)
    if at.ndim != 1 or at.shape != r.shape:
        raise ValueError(f"x and residual have the shapes {at.shape} and {r.shape}; both must be (n,)")
    if size is not None and len(at) != size:
        raise ValueError(f"x has {len(at)} values, {size} in the iteration before: reset() comes between problems")
    for name, values in (("x", at), ("residual", r)):
        if not np.isfinite(values).all():
            k = int(np.argmin(np.isfinite(values)))
            raise ValueError(f"{name}[{k}] is {values[k]}; must be finite")
    return at, r


def _factor(name: str, value: float) -> float:
    if not (np.isfinite(value) and value > 0):
        raise ValueError(f"{name} is {value}; it must be finite and above 0")
    return float(value)


class Relaxation:
    """x + factor residual. Converges where every eigenvalue a of H has ``|1 - factor (1 - a)| < 1``.

    Args:
        factor: 1 is the plain iteration; smaller is steadier and slower.
    """

    def __init__(self, factor: float = 0.5) -> None:
        self.factor = _factor("factor", factor)

    def __repr__(self) -> str:
        return f"Relaxation(factor={self.factor})"

    def reset(self) -> None:
        """Nothing is remembered."""

    def next(self, x: ArrayLike, residual: ArrayLike) -> Vector:
        """The next guess, (n,)."""
        at, r = _checked(x, residual, None)
        return at + self.factor * r


class Aitken:
    """Relaxation whose factor follows from the last two residuals.

    omega_k = -omega_(k-1) r_(k-1) . (r_k - r_(k-1)) / |r_k - r_(k-1)|^2: Irons and Tuck's form of Aitken's method for
    vectors (Kuettler and Wall, Comput. Mech. 43 (2008) 61). Exact after two iterations where x has one value.

    Args:
        first: factor of the first iteration of a window.

    Attributes:
        factor: used last.
    """

    def __init__(self, first: float = 0.5) -> None:
        self.first = _factor("first", first)
        self.factor = self.first
        self._before: Vector | None = None

    def __repr__(self) -> str:
        return f"Aitken(first={self.first})"

    def reset(self) -> None:
        """A new window begins: with `first` again."""
        self.factor, self._before = self.first, None

    def next(self, x: ArrayLike, residual: ArrayLike) -> Vector:
        """The next guess, (n,)."""
        at, r = _checked(x, residual, None if self._before is None else len(self._before))
        if self._before is not None:
            change = r - self._before
            square = float(change @ change)
            # equal residuals say nothing about the factor
            if square > 0:
                self.factor *= -float(self._before @ change) / square
        self._before = r
        return at + self.factor * r


class Iqn:
    """Interface quasi-Newton with the inverse Jacobian from least squares, IQN-ILS (Degroote, Bathe and Vierendeels,
    Comput. Struct. 87 (2009) 793).

    The differences of the residuals V and of what was found W, against those of the latest iteration k, model the
    Jacobian: c minimises ``|V c + r_k|`` and the next guess is x_k + r_k + W c. On a linear problem of n unknowns it is
    exact after n + 1 iterations, and sooner where few directions matter. Also known as Anderson's method.

    Args:
        first: factor of the first iteration of a window, which has no differences yet.
        columns: the latest differences that are kept, 1 at least.
        dependence: a column is left out if less than this part of it is not already in the newer ones (Haelterman et
            al., Comput. Struct. 171 (2016) 9): it carries rounding only.

    Attributes:
        used: columns in the last guess.
    """

    def __init__(self, first: float = 0.5, columns: int = 20, dependence: float = 1e-7) -> None:
        self.first = _factor("first", first)
        if int(columns) != columns or columns < 1:
            raise ValueError(f"columns is {columns}; a whole number of at least 1 is needed")
        if not 0 <= dependence < 1:
            raise ValueError(f"dependence is {dependence}; it must be at least 0 and below 1")
        self.columns = int(columns)
        self.dependence = float(dependence)
        self.used = 0
        self._history: list[tuple[Vector, Vector]] = []

    def __repr__(self) -> str:
        return f"Iqn(first={self.first}, columns={self.columns}, dependence={self.dependence})"

    def reset(self) -> None:
        """A new window begins: the columns are forgotten."""
        self.used = 0
        self._history = []

    def next(self, x: ArrayLike, residual: ArrayLike) -> Vector:
        """The next guess, (n,)."""
        at, r = _checked(x, residual, len(self._history[-1][0]) if self._history else None)
        found = at + r
        self._history = [*self._history[-self.columns :], (r, found)]
        differences = self._independent(r, found)
        self.used = len(differences)
        if not differences:
            return at + self.first * r
        v = np.column_stack([pair[0] for pair in differences])
        w = np.column_stack([pair[1] for pair in differences])
        coefficients = np.linalg.lstsq(v, -r, rcond=None)[0]
        guess: Vector = found + w @ coefficients
        return guess

    def _independent(self, r: Vector, found: Vector) -> list[tuple[Vector, Vector]]:
        """Differences of residual and of what was found, newest first, each of length 1 in the residual."""
        kept: list[tuple[Vector, Vector]] = []
        basis: list[Vector] = []
        for residual, result in reversed(self._history[:-1]):
            length = float(np.linalg.norm(residual - r))
            if length == 0 or len(kept) == len(r):
                continue
            v, w = (residual - r) / length, (result - found) / length
            rest = v.copy()
            # twice: once leaves what rounding brought in
            for _ in range(2):
                for direction in basis:
                    rest -= (direction @ rest) * direction
            size = float(np.linalg.norm(rest))
            if size > self.dependence:
                basis.append(rest / size)
                kept.append((v, w))
        return kept
