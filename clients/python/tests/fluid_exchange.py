"""Exchanges made by hand, for solvers without particles."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sturz.coupling import Exchange, StructuredMesh

# Water, and particles of 1 mm that fill three fifths.
DENSITY, VISCOSITY, DIAMETER, VOID = 1000.0, 1e-3, 1e-3, 0.4
# Superficial velocity, m/s, and Ergun's pressure drop, Pa/m (Chem. Eng. Prog. 48 (1952) 89):
# 150 mu (1 - e)^2 U / (e^3 d^2) + 1.75 rho (1 - e) U^2 / (e^3 d).
ERGUN = ((1e-3, 860.15625), (5e-3, 4628.90625), (10e-3, 10078.125), (20e-3, 23437.5))


def ergun_beta(superficial_m_per_s: float, void: float = VOID) -> float:
    """Drag on the fluid per volume and velocity u = U / e of particles at rest, kg/m3/s: e dp/dz = beta u."""
    solid = 1.0 - void
    viscous = 150.0 * VISCOSITY * solid**2 / (void * DIAMETER**2)
    return viscous + 1.75 * DENSITY * solid * superficial_m_per_s / (void * DIAMETER)


def exchange(
    mesh: StructuredMesh,
    from_time_s: float,
    time_s: float,
    *,
    void: ArrayLike = 1.0,
    solid_m_per_s: ArrayLike = 0.0,
    push: ArrayLike = 0.0,
    drag: ArrayLike = 0.0,
    seen: NDArray[np.float64] | None = None,
) -> Exchange:
    """What is not given is 0; numbers hold everywhere."""
    vectors = (mesh.n, 3)
    return Exchange(
        from_time_s=from_time_s,
        time_s=time_s,
        void_fraction=np.array(np.broadcast_to(np.asarray(void, float), (mesh.n,))),
        solid_velocity_m_per_s=np.array(np.broadcast_to(np.asarray(solid_m_per_s, float), vectors)),
        interaction_n_per_m3=np.array(np.broadcast_to(np.asarray(push, float), vectors)),
        pressure_force_n_per_m3=np.zeros(vectors),
        drag_kg_per_m3_s=np.array(np.broadcast_to(np.asarray(drag, float), (mesh.n,))),
        seen_velocity_m_per_s=seen,
    )


def fixed_bed(
    mesh: StructuredMesh,
    from_time_s: float,
    time_s: float,
    *,
    void: ArrayLike,
    drag: ArrayLike,
    seen: NDArray[np.float64],
) -> Exchange:
    """Particles that do not move: interaction = -drag u_seen."""
    beta = np.broadcast_to(np.asarray(drag, float), (mesh.n,))
    return exchange(mesh, from_time_s, time_s, void=void, push=-beta[:, None] * seen, drag=beta, seen=seen)
