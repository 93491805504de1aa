//! Forces and torques of a fluid on a particle: pure functions of shape, size, orientation and local flow.
//!
//! | file | law |
//! |---|---|
//! | `drag/` | one particle: Stokes, Schiller and Naumann, Haider and Levenspiel, Ganser, Hölzer and Sommerfeld |
//! | `swarm/` | in a swarm: Di Felice, Gidaspow, Tenneti, Beetstra; the convention of model A is stated there |
//! | `lift/` | Saffman and Mei, cross-flow |
//! | `rotation/` | pitching torque (Rosendahl), drag of the rotation (Stokes, Dennis) |
//! | `shape/` | what the laws need of a shape: surface area, sphericity, silhouettes |
//!
//! Non-spherical bodies enter by the diameter d of the sphere of the same volume (every Reynolds number is of it), by
//! their sphericity psi = pi d^2 / A, by the areas that they show to the flow, and by their longest axis. Lengths scale
//! with the particle, ratios do not.

mod drag;
mod lift;
mod rotation;
mod shape;
mod swarm;
#[cfg(test)]
mod tests;

pub use drag::DragLaw;
pub use lift::LiftLaw;
pub use rotation::{PitchingLaw, RotationalDragLaw};
pub use shape::HydroShape;
pub use swarm::{LEAST_VOID_FRACTION, VoidageLaw};

use crate::math::{Mat3, Vec3};

/// Stokes' drag of a sphere over mu d.
pub(crate) const STOKES: f64 = 3.0 * std::f64::consts::PI;

/// The laws of one material or scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HydrodynamicLaws {
    /// Of one particle.
    pub drag: DragLaw,
    /// Of its neighbours on it.
    pub voidage: VoidageLaw,
    /// Across the flow.
    pub lift: LiftLaw,
    /// About the centre of mass, in a uniform flow.
    pub pitching: PitchingLaw,
    /// Against rotation.
    pub rotational_drag: RotationalDragLaw,
    /// C in the force C rho V (Du/Dt - dv/dt), which [`response`] leaves to its caller; 1/2 for a sphere, 0: none.
    pub added_mass_coefficient: f64,
}

/// The flow at a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// u - v, m/s, world; u is the interstitial velocity of the fluid, v that of the centre of mass.
    pub relative_velocity: Vec3,
    /// (curl u)/2 - omega, rad/s, world.
    pub relative_angular_velocity: Vec3,
    /// curl u, rad/s, world; only [`LiftLaw::SaffmanMei`] reads it.
    pub vorticity: Vec3,
    /// Volume fraction of the fluid, 0 to 1; [`VoidageLaw`] other than `None` raise it to [`LEAST_VOID_FRACTION`].
    pub void_fraction: f64,
    /// Of the fluid, kg/m3; positive.
    pub density: f64,
    /// Dynamic, Pa s; positive.
    pub viscosity: f64,
}

/// What the fluid does to a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// K >= 0, N s/m: the drag is K (u - v). At rest it is finite.
    pub drag_n_s_per_m: f64,
    /// Lift, N, world. Neither drag nor pressure gradient is in it.
    pub force_n: Vec3,
    /// Pitching torque about the centre of mass, N m, world.
    pub torque_n_m: Vec3,
    /// K_r >= 0, N m s: the torque against rotation is K_r ((curl u)/2 - omega).
    pub rotational_drag_n_m_s: f64,
}

/// The laws at one particle: `shape` times `scale`, turned by `rotation` (world from body), in `flow`.
///
/// Numbers are taken as they are: density, viscosity and scale must be positive and all finite.
pub fn response(laws: &HydrodynamicLaws, shape: &HydroShape, scale: f64, rotation: &Mat3, flow: &Flow) -> Response {
    let w = &flow.relative_velocity;
    let speed = w.norm();
    let diameter = shape.equivalent_diameter_m() * scale;
    // at rest any direction does: K has a limit at Re = 0, but one that depends on the direction
    let along = if speed > 0.0 { w / speed } else { rotation * shape.axis() };
    let in_body = if laws.drag.depends_on_orientation() { rotation.tr_mul(&along) } else { Vec3::zeros() };
    let reynolds = flow.density * speed * diameter / flow.viscosity;
    let factor = laws.voidage.factor(laws.drag, shape, &in_body, flow.void_fraction, reynolds);
    let drag = STOKES * flow.viscosity * diameter * factor;
    let elongated = shape.elongation() > 0.0 && speed > 0.0;
    let axis = if elongated { rotation * shape.axis() } else { Vec3::zeros() };
    let lift = match laws.lift {
        LiftLaw::None => Vec3::zeros(),
        LiftLaw::SaffmanMei => lift::saffman_mei(diameter, flow.density, flow.viscosity, w, &flow.vorticity),
        LiftLaw::CrossFlow if elongated => lift::cross_flow(drag * speed, &along, &axis, shape.elongation()),
        LiftLaw::CrossFlow => Vec3::zeros(),
    };
    let torque = match laws.pitching {
        PitchingLaw::Rosendahl if elongated => {
            let length = shape.length_m() * scale;
            rotation::pitching_torque(&(w * drag + lift), &along, &axis, length, shape.elongation())
        }
        PitchingLaw::Rosendahl | PitchingLaw::None => Vec3::zeros(),
    };
    let spin =
        if laws.rotational_drag == RotationalDragLaw::Dennis { flow.relative_angular_velocity.norm() } else { 0.0 };
    Response {
        drag_n_s_per_m: drag,
        force_n: lift,
        torque_n_m: torque,
        rotational_drag_n_m_s: laws.rotational_drag.coefficient(diameter, flow.density, flow.viscosity, spin),
    }
}
