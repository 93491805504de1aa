"""Stress in layers from the contacts of the particles in them, after Moreau."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..contacts import NO_PARTICLE, Contacts
from ..state import State
from ..status import Domain
from .bodies import Bodies, Floats, minimum_image, rows_of


@dataclass(frozen=True, eq=False)
class LayerStress:
    """Symmetric stress in layers, positive in compression, Pa.

    Attributes:
        edges_m: of the layers, (k + 1,), m.
        contact: of the contact forces, (k, 3, 3).
        rotation: of the accelerations inside of the turning particles, (k, 3, 3): the second term of eq. 12 of
            Descantes 2022, with the Euler tensor.
        kinetic: of the fluctuations of the centres of mass about the mean velocity of their layer, (k, 3, 3).
        kinetic_rotation: of the turning about the centres of mass, (k, 3, 3).
        weight_pa: weight of the particles in and above the middle of a layer over its area, (k,).
        particles: centres of mass in each layer, (k,).
    """

    edges_m: Floats
    contact: Floats
    rotation: Floats
    kinetic: Floats
    kinetic_rotation: Floats
    weight_pa: Floats
    particles: Floats

    @property
    def middles_m(self) -> Floats:
        """Middles of the layers, (k,), m."""
        return 0.5 * (self.edges_m[1:] + self.edges_m[:-1])

    @property
    def total(self) -> Floats:
        """Contact and kinetic stress, (k, 3, 3), Pa: what balances the weight in the mean over time.

        The two rotational terms together are a time derivative, whose mean in a steady state is 0; alone, either would
        be a bias.
        """
        return self.contact + self.kinetic

    @property
    def moreau(self) -> Floats:
        """Eq. 12 of Descantes 2022 as mended, (k, 3, 3), Pa: contact forces and accelerations of rotation."""
        return self.contact + self.rotation


def particle_contact_moments_j(state: State, contacts: Contacts, domain: Domain | None = None) -> Floats:
    """Sum over the contacts of each particle of force times the arm from contact point to centre, (n, 3, 3), J.

    Entry [i, j] has force component i and arm component j: the trace is positive in compression. Where several points
    of a pair touch, their resultant acts at their mean place; the symmetric part of what they have beyond that, of the
    order of the force times the size of the shared face, is not in the network. Both sides of a pair must be nearest
    images of each other: the cell is two diameters wide at least.
    """
    moments = np.zeros((len(state), 3, 3))
    if len(contacts) == 0:
        return moments
    forces = contacts.forces_on_a_n()
    positions = np.asarray(state.positions_m, dtype=float)
    a = rows_of(state.ids, contacts.ids[:, 0])
    arms = minimum_image(positions[a] - contacts.points_m, domain)
    np.add.at(moments, a, forces[:, :, None] * arms[:, None, :])
    pairs = contacts.ids[:, 1] != np.uint64(NO_PARTICLE)
    b = rows_of(state.ids, contacts.ids[pairs, 1])
    arms = minimum_image(positions[b] - contacts.points_m[pairs], domain)
    np.add.at(moments, b, -forces[pairs][:, :, None] * arms[:, None, :])
    return moments


def rotation_moments_j(state: State, bodies: Bodies) -> tuple[Floats, Floats]:
    """Moments of each particle's own turning, (n, 3, 3) each, J: of accelerations and of momentum.

    With W the matrix of the angular velocity and E = tr(I)/2 - I the Euler tensor, the integral of rho r r over the
    body: (W W + dW/dt) E, which holds the particle together, and W E W^T, which its parts carry with them. Their sum is
    d(W E)/dt. The torques give dW/dt; without the column ``torques`` it is taken as that of free rotation.
    """
    rotations = state.rotations()
    moments = bodies.moments_kg_m2
    omega = np.asarray(state.angular_velocities_rad_per_s, dtype=float)
    in_body = np.einsum("nji,nj->ni", rotations, omega)
    torque = np.zeros_like(omega)
    if "torques" in state.columns:
        torque = np.einsum("nji,nj->ni", rotations, np.asarray(state.torques_n_m, dtype=float))
    acceleration_in_body = (torque - np.cross(in_body, moments * in_body)) / moments
    acceleration = np.einsum("nij,nj->ni", rotations, acceleration_in_body)
    euler_in_body = 0.5 * moments.sum(axis=1, keepdims=True) - moments
    euler = np.einsum("nik,nk,njk->nij", rotations, euler_in_body, rotations)
    w, dw = _matrix_of(omega), _matrix_of(acceleration)
    return (w @ w + dw) @ euler, w @ euler @ w.transpose(0, 2, 1)


def _matrix_of(vectors: Floats) -> Floats:
    """Matrices W with W r = vector x r, (n, 3, 3)."""
    matrices = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    matrices[:, 0, 1], matrices[:, 0, 2], matrices[:, 1, 2] = -z, y, -x
    matrices[:, 1, 0], matrices[:, 2, 0], matrices[:, 2, 1] = z, -y, x
    return matrices


def layer_stress(
    state: State,
    contacts: Contacts,
    bodies: Bodies,
    edges_m: ArrayLike,
    *,
    area_m2: float,
    axis: int = 2,
    domain: Domain | None = None,
) -> LayerStress:
    """Stress of layers, each particle's moments counted in the layer of its centre of mass.

    Descantes 2022, eq. 12 (Moreau 1997), with the sign that is positive in compression, and with the Euler tensor in
    the place of the inertia tensor. `LayerStress.kinetic` is not in the paper.

    Args:
        state, contacts: of the same step.
        bodies: of `sturz.measures.bodies`.
        edges_m: of the layers, ascending, (k + 1,), m.
        area_m2: of a layer.
        axis: across the layers; it must not be periodic.
        domain: which axes are periodic; none when absent.
    """
    edges = np.asarray(edges_m, dtype=float)
    heights = np.asarray(state.positions_m, dtype=float)[:, axis]
    layer = np.searchsorted(edges, heights, side="right") - 1
    inside = np.flatnonzero((layer >= 0) & (layer < len(edges) - 1))
    volumes = area_m2 * np.diff(edges)

    def gather(moments: Floats) -> Floats:
        sums = np.zeros((len(volumes), 3, 3))
        np.add.at(sums, layer[inside], moments[inside])
        return 0.5 * (sums + sums.transpose(0, 2, 1)) / volumes[:, None, None]

    count = np.bincount(layer[inside], minlength=len(volumes)).astype(float)
    mass = np.bincount(layer[inside], weights=bodies.mass_kg[inside], minlength=len(volumes))
    velocities = np.asarray(state.velocities_m_per_s, dtype=float)
    momentum = np.zeros((len(volumes), 3))
    np.add.at(momentum, layer[inside], (bodies.mass_kg[:, None] * velocities)[inside])
    mean = momentum / np.maximum(mass, np.finfo(float).tiny)[:, None]
    fluctuations = np.zeros_like(velocities)
    fluctuations[inside] = velocities[inside] - mean[layer[inside]]
    acceleration_moments, momentum_moments = rotation_moments_j(state, bodies)
    middles = 0.5 * (edges[1:] + edges[:-1])
    above = np.array([bodies.mass_kg[heights >= middle].sum() for middle in middles])
    return LayerStress(
        edges_m=edges,
        contact=gather(particle_contact_moments_j(state, contacts, domain)),
        rotation=gather(acceleration_moments),
        kinetic=gather(bodies.mass_kg[:, None, None] * fluctuations[:, :, None] * fluctuations[:, None, :]),
        kinetic_rotation=gather(momentum_moments),
        weight_pa=above * abs(float(state.gravity_m_per_s2[axis])) / area_m2,
        particles=count,
    )
