//! Largest stable time step of one contact under this integrator, from stiffness, damping, mass and inertia.

use std::f64::consts::PI;

use crate::contact::law::{OverlapLaw, PairLaw};
use crate::shape::Leverage;

/// What a particle brings into the bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// kg
    pub mass: f64,
    /// What rotation adds at the worst place.
    pub leverage: Leverage,
    /// Largest number of points that its parts have with a wall.
    pub points: u32,
    /// Radius of its roundest part, or of the bounding sphere of a polyhedron, m.
    pub radius: f64,
    /// kg m2
    pub smallest_inertia: f64,
    /// Has parts that meet others of the kind by generalized overlap.
    pub is_rounded: bool,
}

impl Body {
    /// Largest inverse effective mass of a normal force, 1/kg.
    pub(super) fn inverse_normal_mass(&self) -> f64 {
        (1.0 + self.leverage.normal) / self.mass
    }

    /// Largest inverse effective mass of a tangential force, 1/kg.
    pub(super) fn inverse_tangential_mass(&self) -> f64 {
        (1.0 + self.leverage.tangential) / self.mass
    }
}

/// Bounds of one contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactBounds {
    /// Above this step a single contact is unstable, s.
    pub critical_time_step_s: f64,
    /// Duration of a central collision, s.
    pub duration_s: f64,
}

impl ContactBounds {
    /// The stricter of each.
    pub fn min(self, other: Self) -> Self {
        Self {
            critical_time_step_s: self.critical_time_step_s.min(other.critical_time_step_s),
            duration_s: self.duration_s.min(other.duration_s),
        }
    }
}

/// Largest omega dt for which the damped oscillator stays bounded under velocity Verlet with the dashpot velocity
/// predicted at the full step, v_n+1 = v_n + a_n dt.
///
/// Found by bisection with Jury's criterion on the 3 x 3 map of (x, v dt, a dt^2); 2 at zeta = 0.
pub fn largest_stable_product(zeta: f64) -> f64 {
    let (mut low, mut high) = (0.0, 2.0 + 1e-9);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if is_stable(middle, zeta) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Jury's criterion for the 3 x 3 map of one step.
fn is_stable(omega_dt: f64, zeta: f64) -> bool {
    let (k, c) = (omega_dt * omega_dt, 2.0 * zeta * omega_dt);
    // x' = x + v + a/2; a' = -k x' - c (v + a); v' = v + (a + a')/2
    let row_a = [-k, -k - c, -0.5 * k - c];
    let m = [[1.0, 1.0, 0.5], [0.5 * row_a[0], 1.0 + 0.5 * row_a[1], 0.5 + 0.5 * row_a[2]], row_a];
    let minor = |i: usize, j: usize| m[i][i] * m[j][j] - m[i][j] * m[j][i];
    let c2 = -(m[0][0] + m[1][1] + m[2][2]);
    let c1 = minor(0, 1) + minor(0, 2) + minor(1, 2);
    let c0 = -nalgebra::Matrix3::from_fn(|i, j| m[i][j]).determinant();
    // Undamped motion lies on the unit circle: allow rounding there.
    let slack = 1e-12;
    1.0 + c2 + c1 + c0 >= -slack
        && 1.0 - c2 + c1 - c0 >= -slack
        && c0.abs() <= 1.0 + slack
        && (c1 - c0 * c2).abs() <= 1.0 - c0 * c0 + slack
}

/// Largest stable step of a damped oscillator, s.
pub(super) fn bound(stiffness: f64, damping: f64, inverse_mass: f64) -> f64 {
    let omega = (stiffness * inverse_mass).sqrt();
    if omega > 0.0 {
        largest_stable_product(0.5 * damping * inverse_mass / omega) / omega
    } else if damping > 0.0 {
        // the limit of the product above for ever larger zeta
        1.0 / (damping * inverse_mass)
    } else {
        f64::INFINITY
    }
}

/// Largest local frequency of a contact by generalized overlap over that of a central point contact: 5.0 cubes, 6.4
/// pinacoids, 7.7 tetrahedra at p = 8 (CONTACT_LAW.md section 3; rare poses of nearly parallel edges exceed it).
const ROUNDED_FREQUENCY: f64 = 8.0;

/// Largest stable step of a contact of two rounded polyhedra, or of one with a wall, s.
///
/// Its damping scales with the contact's own effective mass, so that the damping ratio is that of the law whatever
/// touches (with the exponent 1.5: up to the reference overlap); a raw coefficient meets the lightest effective mass. Elongated bodies, whose lever alone makes a contact
/// stiffer than the measured shapes', take the larger of both estimates.
pub fn rounded_critical_step(law: &PairLaw, overlap: &OverlapLaw, a: &Body, b: Option<&Body>) -> f64 {
    let inverse_reduced = 1.0 / a.mass + b.map_or(0.0, |b| 1.0 / b.mass);
    let inverse_normal = a.inverse_normal_mass() + b.map_or(0.0, Body::inverse_normal_mass);
    let inverse_mass = (ROUNDED_FREQUENCY * ROUNDED_FREQUENCY * inverse_reduced).max(2.0 * inverse_normal);
    let stiffness = law.stiffness * overlap.reference_stiffening();
    match law.raw_damping {
        Some(damping) => bound(stiffness, damping, inverse_mass),
        None => largest_stable_product(law.damping_ratio) / (stiffness * inverse_mass).sqrt(),
    }
}

/// Bounds of a contact of `a` with `b`, or with a boundary of infinite mass.
pub fn contact_bounds(law: &PairLaw, a: &Body, b: Option<&Body>) -> ContactBounds {
    let inverse_reduced = 1.0 / a.mass + b.map_or(0.0, |b| 1.0 / b.mass);
    let damping = law.damping(1.0 / inverse_reduced);
    let inverse_normal = a.inverse_normal_mass() + b.map_or(0.0, Body::inverse_normal_mass);
    let mut critical = bound(law.stiffness, damping, inverse_normal);
    if law.friction > 0.0 {
        let inverse_tangential = a.inverse_tangential_mass() + b.map_or(0.0, Body::inverse_tangential_mass);
        let tangential_damping = law.tangential_damping_ratio * damping;
        critical = critical.min(bound(law.tangential_stiffness, tangential_damping, inverse_tangential));
    }
    let omega = (law.stiffness * inverse_reduced).sqrt();
    let zeta = 0.5 * damping * inverse_reduced / omega;
    // Beyond critical damping there is no half period; the undamped one is the scale that remains.
    let damped = if zeta < 1.0 { omega * (1.0 - zeta * zeta).sqrt() } else { omega };
    ContactBounds { critical_time_step_s: critical, duration_s: PI / damped }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest |x| after many steps of the same recursion as the engine's, from x = 1.
    fn amplitude(omega_dt: f64, zeta: f64) -> f64 {
        let (mut x, mut v) = (1.0, 0.0);
        let mut a = -omega_dt * omega_dt * x;
        let mut largest = 0.0f64;
        for _ in 0..4000 {
            let half = v + 0.5 * a;
            x += half;
            let predicted = half + 0.5 * a;
            a = -omega_dt * omega_dt * x - 2.0 * zeta * omega_dt * predicted;
            v = half + 0.5 * a;
            largest = largest.max(x.abs());
            if !largest.is_finite() || largest > 1e12 {
                return f64::INFINITY;
            }
        }
        largest
    }

    #[test]
    fn limit_separates_bounded_from_growing_motion() {
        assert!((largest_stable_product(0.0) - 2.0).abs() < 1e-5);
        // c dt/m = 2 zeta omega dt at most 1 for a dashpot alone
        assert!((largest_stable_product(1e4) * 2e4 - 1.0).abs() < 1e-3);
        for zeta in [0.02, 0.05, 0.2, 0.5, 1.0, 2.0] {
            let limit = largest_stable_product(zeta);
            assert!(amplitude(0.995 * limit, zeta) < 100.0, "zeta {zeta} limit {limit}");
            assert!(amplitude(1.005 * limit, zeta) > 1e3, "zeta {zeta} limit {limit}");
        }
    }
}
