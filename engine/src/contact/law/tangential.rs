//! Coulomb friction with a tangential spring kept in the cone.

use crate::math::Vec3;

/// Tangential force of one point on `a`, and the spring after the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentialForce {
    /// N.
    pub force: Vec3,
    /// Stretch after truncation to the cone, m.
    pub spring: Vec3,
}

/// What the tangential laws read of one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slide {
    /// Tangential stiffness, N/m.
    pub stiffness: f64,
    /// Tangential dashpot, N s/m.
    pub damping: f64,
    /// mu f_n, N.
    pub limit: f64,
    /// Of the last step, m.
    pub spring: Vec3,
    /// From `a` to `b`.
    pub normal: Vec3,
    /// Tangential displacement of `a` against `b` over the step, m.
    pub stretch: Vec3,
    /// Tangential velocity of `a` against `b` now, m/s.
    pub velocity: Vec3,
    /// m
    pub overlap: f64,
    /// Overlap of the last step, m.
    pub former_overlap: f64,
}

/// Turns the spring of the last step into the present tangent plane, keeping its length.
#[inline(always)]
pub(super) fn carried(spring: &Vec3, normal: &Vec3) -> Vec3 {
    let length2 = spring.norm_squared();
    let in_plane = spring - normal * spring.dot(normal);
    let in_plane2 = in_plane.norm_squared();
    if in_plane2 > 1e-30 * length2 { in_plane * (length2 / in_plane2).sqrt() } else { Vec3::zeros() }
}

/// Force of a torsion spring, and the spring after the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorsionForce {
    /// At the arm of the contact, about the normal of `a`, N.
    pub force: f64,
    /// Stretch as an arc after truncation, m.
    pub spring: f64,
}

/// f = -(kt tau + ct v), truncated to |f| <= mu f_n, for the arc tau = sum of arm x turn of `a` against `b`.
///
/// The torque is f times the present arm of the contact, its mean distance of the points from their centre. Keeping
/// the arc, not the angle, makes kt tau^2 / 2 the energy even while the arm changes.
#[inline]
pub fn torsion_history(
    [stiffness, damping]: [f64; 2],
    limit: f64,
    spring: f64,
    stretch: f64,
    velocity: f64,
) -> TorsionForce {
    let stretched = spring + stretch;
    let trial = -(stretched * stiffness + velocity * damping);
    if trial.abs() <= limit {
        return TorsionForce { force: trial, spring: stretched };
    }
    let force = trial.clamp(-limit, limit);
    let longest = limit / stiffness.max(f64::MIN_POSITIVE);
    let relaxed = -(force + velocity * damping) / stiffness.max(f64::MIN_POSITIVE);
    TorsionForce { force, spring: if stiffness > 0.0 { relaxed.clamp(-longest, longest) } else { 0.0 } }
}

/// f = -(kt xi + ct v), truncated to |f| <= mu f_n; beyond it the spring keeps the length that gives the limit.
///
/// `spring` xi (m) is that of the last step, `stretch` (m) the tangential displacement of `a` against `b` since,
/// `velocity` (m/s) the tangential velocity now. Energy of the spring kt xi^2 / 2. Source: Cundall and Strack (1979).
#[inline(always)]
pub fn coulomb_history(
    [stiffness, damping]: [f64; 2],
    limit: f64,
    spring: &Vec3,
    normal: &Vec3,
    stretch: &Vec3,
    velocity: &Vec3,
) -> TangentialForce {
    let stretched = carried(spring, normal) + stretch;
    let trial = -(stretched * stiffness + velocity * damping);
    let trial2 = trial.norm_squared();
    if trial2 <= limit * limit {
        return TangentialForce { force: trial, spring: stretched };
    }
    let force = trial * (limit / trial2.sqrt());
    let spring = if stiffness > 0.0 { -(force + velocity * damping) / stiffness } else { Vec3::zeros() };
    // A dashpot beyond the cone would otherwise wind the spring up against the sliding direction.
    let spring = if spring.norm_squared() * stiffness * stiffness > limit * limit {
        -force / stiffness.max(f64::MIN_POSITIVE)
    } else {
        spring
    };
    TangentialForce { force, spring }
}
