//! Bounds of one contact under the laws of [`PointLaws`].

use std::f64::consts::PI;

use super::critical_step::{Body, ContactBounds, bound};
use crate::contact::law::{PairLaw, RollingLaw, mindlin_stiffness};
use crate::scene::{PairExtras, PointLaws, PointNormal, Tangential};

/// Bounds of a contact of `a` with `b`, or with a boundary of infinite mass.
///
/// Where springs add, with as many as the parts can have points; with Hertz at the reference overlap. Rolling springs
/// act on the rotation besides the tangential ones: the squares of the frequencies add.
pub fn point_bounds(
    laws: &PointLaws,
    tangential: Tangential,
    (law, extras): (&PairLaw, &PairExtras),
    a: &Body,
    b: Option<&Body>,
) -> ContactBounds {
    let sum = |of: fn(&Body) -> f64| of(a) + b.map_or(0.0, of);
    let inverse_reduced = sum(|body| 1.0 / body.mass);
    let count = if laws.springs_add { most_points(a, b) } else { 1.0 };
    let radius = 1.0 / sum(|body| 1.0 / body.radius);
    let one = laws.reference_stiffness(law, extras, radius);
    let stiffness = count * one;
    let damping = match law.raw_damping {
        Some(c) => count * c,
        // sqrt(5) zeta sqrt(m k) d^(1/4) = 2 sqrt(5/6) zeta sqrt(m dF/dd) with dF/dd = 3/2 k sqrt(d)
        None if laws.normal == PointNormal::Hertz => {
            2.0 * (5.0f64 / 6.0).sqrt() * law.damping_ratio * (stiffness / inverse_reduced).sqrt()
        }
        None => 2.0 * law.damping_ratio * (stiffness / inverse_reduced).sqrt(),
    };
    let mut critical = bound(stiffness, damping, sum(Body::inverse_normal_mass));
    let mut sliding = f64::INFINITY;
    if law.friction > 0.0 {
        let (spring, dashpot) = match tangential {
            Tangential::CoulombHistory => (count * law.tangential_stiffness, law.tangential_damping_ratio * damping),
            Tangential::Mindlin => {
                let overlap = laws.reference_fraction * radius;
                let spring = mindlin_stiffness(extras.hertz.shear_modulus, radius, overlap);
                (spring, law.tangential_damping_ratio * damping)
            }
            Tangential::Viscous => {
                let raw = extras.tangential_damping.map(|c| count * c);
                (0.0, raw.unwrap_or(law.tangential_damping_ratio * damping))
            }
            Tangential::None => (0.0, 0.0),
        };
        sliding = bound(spring, dashpot, sum(Body::inverse_tangential_mass));
    }
    let turning = rolling_bound(&extras.rolling, one, radius, (a, b));
    critical = critical.min(1.0 / (sliding.powi(-2) + turning.powi(-2)).sqrt());
    let duration_s = match laws.normal {
        PointNormal::Linear => {
            let omega = (stiffness * inverse_reduced).sqrt();
            let zeta = 0.5 * damping * inverse_reduced / omega;
            // Beyond critical damping there is no half period; the undamped one is the scale that remains.
            PI / if zeta < 1.0 { omega * (1.0 - zeta * zeta).sqrt() } else { omega }
        }
        // T = 2.9433 d/v of a hit that reaches d, v^2 = 4/5 k d^2.5/m, k d^0.5 = 2/3 dF/dd
        PointNormal::Hertz => 2.943_275 / (8.0 / 15.0 * stiffness * inverse_reduced).sqrt(),
    };
    ContactBounds { critical_time_step_s: critical, duration_s }
}

/// Points that two parts, or a part at a wall, can have: corners of a face, and of the outline that two faces share.
fn most_points(a: &Body, b: Option<&Body>) -> f64 {
    f64::from(match b {
        None => a.points,
        Some(b) if a.points > 2 && b.points > 2 => a.points + b.points,
        Some(b) => a.points.min(b.points),
    })
}

/// Of rolling and twisting, each about its stiffest axis.
fn rolling_bound(law: &RollingLaw, stiffness: f64, radius: f64, (a, b): (&Body, Option<&Body>)) -> f64 {
    let inverse = 1.0 / a.smallest_inertia + b.map_or(0.0, |b| 1.0 / b.smallest_inertia);
    let arm = law.rolling.max(law.twisting) * radius;
    let stiffness = 2.25 * stiffness * arm * arm;
    // The dashpot is critical for the inertia about the contact, at least that about the centre.
    bound(stiffness, 2.0 * law.damping_ratio * (stiffness / inverse).sqrt() * 3.5, inverse)
}
