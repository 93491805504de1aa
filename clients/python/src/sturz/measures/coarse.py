"""Coarse-grained profiles of a flow that is uniform across two axes, and what of its kinetic stress the width makes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..state import State
from .bodies import Floats


@dataclass(frozen=True, eq=False)
class CoarseProfile:
    """Fields along one axis, averaged over the other two and over the states.

    Attributes:
        places_m: where, (k,), m.
        width_m: w of the kernel exp(-R^2 / (2 w^2)), m.
        density_kg_per_m3: (k,).
        velocity_m_per_s: mean by mass, (k, 3).
        shear_rate_per_s: derivative of that along the axis, (k, 3), 1/s.
        kinetic_stress_pa: of the fluctuations about the velocity at the place, (k, 3, 3): grows with the width.
        gradient_stress_pa: what the velocity gradient within the kernel makes of it, rho w^2 dV dV, (k, 3, 3).
    """

    places_m: Floats
    width_m: float
    density_kg_per_m3: Floats
    velocity_m_per_s: Floats
    shear_rate_per_s: Floats
    kinetic_stress_pa: Floats
    gradient_stress_pa: Floats

    @property
    def scale_free_stress_pa(self) -> Floats:
        """Kinetic stress without the part that the width makes (Artoni and Richard), (k, 3, 3), Pa."""
        return self.kinetic_stress_pa - self.gradient_stress_pa


def coarse_profile(
    states: list[State],
    masses_kg: ArrayLike,
    places_m: ArrayLike,
    *,
    width_m: float,
    area_m2: float,
    axis: int = 2,
    selected: ArrayLike | None = None,
) -> CoarseProfile:
    """Density, velocity and kinetic stress with a Gaussian of standard deviation `width_m`.

    The velocity is that of all states together, and fluctuations are about it. With this kernel the second moment D of
    Artoni and Richard is w^2; the kernel printed in seed 003, exp(-(R / 2 w)^2), would have 2 w^2.

    Args:
        states: of a steady flow, with the same particles.
        masses_kg: (n,).
        places_m: along the axis, (k,), m.
        width_m: above 0.
        area_m2: of the cell across the axis.
        axis: of the profile; it must not be periodic.
        selected: particles that count, (n,); all when absent.
    """
    y, w = np.asarray(places_m, dtype=float), float(width_m)
    chosen = slice(None) if selected is None else np.asarray(selected, dtype=bool)
    mass = np.asarray(masses_kg, dtype=float)[chosen]
    frames = len(states)
    density, slope = np.zeros(len(y)), np.zeros(len(y))
    momentum, momentum_slope = np.zeros((len(y), 3)), np.zeros((len(y), 3))
    square = np.zeros((len(y), 3, 3))
    for state in states:
        v = np.asarray(state.velocities_m_per_s, dtype=float)[chosen]
        offset = y[:, None] - np.asarray(state.positions_m, dtype=float)[chosen][None, :, axis]
        kernel = mass * np.exp(-0.5 * (offset / w) ** 2) / (np.sqrt(2.0 * np.pi) * w * area_m2 * frames)
        density += kernel.sum(axis=1)
        momentum += kernel @ v
        square += np.einsum("kn,ni,nj->kij", kernel, v, v, optimize=True)
        steep = -kernel * offset / w**2
        slope += steep.sum(axis=1)
        momentum_slope += steep @ v
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = np.where(density > 0.0, 1.0 / density, np.nan)
    velocity = momentum * inverse[:, None]
    rate = (momentum_slope - velocity * slope[:, None]) * inverse[:, None]
    kinetic = square - density[:, None, None] * velocity[:, :, None] * velocity[:, None, :]
    gradient = density[:, None, None] * w**2 * rate[:, :, None] * rate[:, None, :]
    return CoarseProfile(y, w, density, velocity, rate, kinetic, gradient)
