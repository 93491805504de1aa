"""Velocities: distributions, profiles, granular temperature, inertial number, shares of the energy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..state import State
from ..status import EnergyBalance
from .bodies import Bodies, Floats


@dataclass(frozen=True, eq=False)
class Distribution:
    """Distribution of a number.

    Attributes:
        edges: of the bins, (k + 1,).
        density: probability density, (k,), of the values within the edges and outside together.
        mean, deviation: of the values; NaN of none.
        kurtosis: 3 for a normal distribution.
        n: values.
    """

    edges: Floats
    density: Floats
    mean: float
    deviation: float
    kurtosis: float
    n: int

    @property
    def middles(self) -> Floats:
        """Middles of the bins, (k,)."""
        return 0.5 * (self.edges[1:] + self.edges[:-1])


def distribution(values: ArrayLike, edges: ArrayLike) -> Distribution:
    """Distribution of values, (n,), such as a component of the velocities over the speed of the drum."""
    x, bins = np.asarray(values, dtype=float).ravel(), np.asarray(edges, dtype=float)
    if len(x) == 0:
        nothing = float("nan")
        return Distribution(bins, np.full(len(bins) - 1, np.nan), nothing, nothing, nothing, 0)
    centred = x - x.mean()
    variance = float((centred**2).mean())
    kurtosis = float((centred**4).mean()) / variance**2 if variance > 0.0 else float("nan")
    density = np.histogram(x, bins=bins)[0] / (len(x) * np.diff(bins))
    return Distribution(bins, density, float(x.mean()), float(np.sqrt(variance)), kurtosis, len(x))


@dataclass(frozen=True, eq=False)
class Profile:
    """Motion in layers.

    Attributes:
        edges_m: of the layers, (k + 1,), m.
        particles: samples in each layer, (k,).
        velocity_m_per_s: mean by mass, (k, 3); NaN in empty layers.
        angular_velocity_rad_per_s: mean, (k, 3).
        temperature_m2_per_s2: tensor of the fluctuations about the mean of the layer, (k, 3, 3).
    """

    edges_m: Floats
    particles: NDArray[np.int64]
    velocity_m_per_s: Floats
    angular_velocity_rad_per_s: Floats
    temperature_m2_per_s2: Floats

    @property
    def middles_m(self) -> Floats:
        """Middles of the layers, (k,), m."""
        return 0.5 * (self.edges_m[1:] + self.edges_m[:-1])

    @property
    def granular_temperature_m2_per_s2(self) -> Floats:
        """A third of the trace, (k,). Eq. 13 of Descantes 2022 leaves out the third."""
        temperature: Floats = np.trace(self.temperature_m2_per_s2, axis1=1, axis2=2) / 3.0
        return temperature

    def shear_rate_per_s(self, component: int) -> Floats:
        """Derivative of a component of the velocity along the layers' axis, (k,), 1/s: central differences."""
        rate: Floats = np.gradient(self.velocity_m_per_s[:, component], self.middles_m)
        return rate


def velocity_profile(states: list[State], masses_kg: ArrayLike, edges_m: ArrayLike, *, axis: int = 2) -> Profile:
    """Mean motion in layers over the states of a steady flow.

    Args:
        states: of the same particles; one is enough.
        masses_kg: (n,).
        edges_m: of the layers, ascending, (k + 1,), m.
        axis: across the layers.
    """
    edges, mass = np.asarray(edges_m, dtype=float), np.asarray(masses_kg, dtype=float)
    k = len(edges) - 1
    count = np.zeros(k, dtype=np.int64)
    total, momentum, spin, square = np.zeros(k), np.zeros((k, 3)), np.zeros((k, 3)), np.zeros((k, 3, 3))
    for state in states:
        layer = np.searchsorted(edges, np.asarray(state.positions_m)[:, axis], side="right") - 1
        inside = np.flatnonzero((layer >= 0) & (layer < k))
        at, m = layer[inside], mass[inside]
        v = np.asarray(state.velocities_m_per_s, dtype=float)[inside]
        count += np.bincount(at, minlength=k)
        total += np.bincount(at, weights=m, minlength=k)
        np.add.at(momentum, at, m[:, None] * v)
        np.add.at(spin, at, m[:, None] * np.asarray(state.angular_velocities_rad_per_s, dtype=float)[inside])
        np.add.at(square, at, m[:, None, None] * v[:, :, None] * v[:, None, :])
    with np.errstate(divide="ignore", invalid="ignore"):
        weight = np.where(total > 0.0, 1.0 / total, np.nan)
    mean = momentum * weight[:, None]
    fluctuations = square * weight[:, None, None] - mean[:, :, None] * mean[:, None, :]
    return Profile(edges, count, mean, spin * weight[:, None], fluctuations)


def granular_temperature(velocities_m_per_s: ArrayLike, masses_kg: ArrayLike | None = None) -> float:
    """Granular temperature of a set of particles: a third of the mean square fluctuation about their mean velocity,
    weighted by mass where masses are given, m2/s2; NaN of none."""
    v = np.asarray(velocities_m_per_s, dtype=float).reshape(-1, 3)
    if len(v) == 0:
        return float("nan")
    weights = np.ones(len(v)) if masses_kg is None else np.asarray(masses_kg, dtype=float)
    mean = np.average(v, axis=0, weights=weights)
    return float(np.average(((v - mean) ** 2).sum(axis=1), weights=weights) / 3.0)


def inertial_number(
    shear_rate_per_s: ArrayLike, diameter_m: float, density_kg_per_m3: float, pressure_pa: ArrayLike
) -> Floats:
    """I = shear rate d sqrt(rho / P), with the diameter of the sphere of the same volume and the density of the grains
    (da Cruz et al. 2005); NaN where the pressure is not positive."""
    pressure = np.asarray(pressure_pa, dtype=float)
    root = np.sqrt(density_kg_per_m3 / np.where(pressure > 0.0, pressure, np.nan))
    return np.asarray(np.abs(shear_rate_per_s) * diameter_m * root)


@dataclass(frozen=True)
class EnergyPartition:
    """Energy of a state by kind, J.

    Attributes:
        translation_j: of the centres of mass.
        rotation_j: about them.
        potential_j: in gravity, of the centres of mass over the plane through the origin.
        elastic_j: in the contacts; NaN without a report.
    """

    translation_j: float
    rotation_j: float
    potential_j: float
    elastic_j: float

    @property
    def kinetic_over_potential(self) -> float:
        """Kinetic energy over the potential one."""
        return (self.translation_j + self.rotation_j) / self.potential_j if self.potential_j else float("nan")


def energy_partition(state: State, bodies: Bodies, balance: EnergyBalance | None = None) -> EnergyPartition:
    """Energy of a state by kind; what the contacts store is in the report of the daemon only.

    Args:
        bodies: of `sturz.measures.bodies`.
        balance: `Report.energy` of the same step.
    """
    v = np.asarray(state.velocities_m_per_s, dtype=float)
    spin = np.einsum("nji,nj->ni", state.rotations(), np.asarray(state.angular_velocities_rad_per_s, dtype=float))
    heights = -np.asarray(state.positions_m, dtype=float) @ state.gravity_m_per_s2
    return EnergyPartition(
        translation_j=0.5 * float(bodies.mass_kg @ (v**2).sum(axis=1)),
        rotation_j=0.5 * float((bodies.moments_kg_m2 * spin**2).sum()),
        potential_j=float(bodies.mass_kg @ heights),
        elastic_j=balance.elastic_j if balance is not None else float("nan"),
    )
