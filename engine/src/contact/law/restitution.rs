//! Damping ratio from the coefficient of restitution, for both rules of how a contact ends.

use crate::scene::ContactEnd;

/// Lowest restitution that a clipped linear contact reaches with a damping ratio up to [`LARGEST_RATIO`].
const LARGEST_RATIO: f64 = 50.0;

/// Restitution of a linear spring and dashpot of damping ratio `zeta` (coefficient c = 2 zeta sqrt(k m)).
///
/// Tension (the contact ends at zero overlap): e = exp(-pi zeta / S), S = sqrt(1 - zeta^2); 0 from zeta = 1 on.
/// Clip (it ends at zero force; Schwager and Poeschel 2007): e = exp(-(zeta/S) atan2(2 zeta S, 2 zeta^2 - 1)), and
/// beyond critical damping e = exp(-2 zeta acosh(zeta) / sqrt(zeta^2 - 1)); e = exp(-2) at zeta = 1.
pub fn restitution(zeta: f64, end: ContactEnd) -> f64 {
    let s = (1.0 - zeta * zeta).abs().sqrt();
    match end {
        ContactEnd::Tension if zeta >= 1.0 => 0.0,
        ContactEnd::Tension => (-std::f64::consts::PI * zeta / s).exp(),
        ContactEnd::Clip if s < 1e-7 => (-2.0f64).exp(),
        ContactEnd::Clip if zeta < 1.0 => (-(zeta / s) * (2.0 * zeta * s).atan2(2.0 * zeta * zeta - 1.0)).exp(),
        ContactEnd::Clip => (-2.0 * zeta * zeta.acosh() / s).exp(),
    }
}

/// Least restitution that a scene may ask for under the rule.
pub fn least_restitution(end: ContactEnd) -> f64 {
    match end {
        ContactEnd::Tension => 0.0,
        ContactEnd::Clip => restitution(LARGEST_RATIO, end),
    }
}

/// Damping ratio that gives the restitution `e` in [least, 1] under the rule, by bisection to the last bits.
pub fn damping_ratio(e: f64, end: ContactEnd) -> f64 {
    if e >= 1.0 {
        return 0.0;
    }
    if e <= 0.0 {
        return 1.0;
    }
    let (mut low, mut high) = (0.0, if end == ContactEnd::Tension { 1.0 } else { LARGEST_RATIO });
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if restitution(middle, end) > e {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// PHYSICS.md A.3: the damping that gives 0.85, 0.5, 0.1 and 0 with tension gives these when clipped.
    #[test]
    fn clipped_restitution_of_a_tension_calibration() {
        for (nominal, clipped) in [(0.85, 0.8546), (0.5, 0.5503), (0.1, 0.2527), (0.0, 0.1353)] {
            let zeta = damping_ratio(nominal, ContactEnd::Tension);
            assert!((restitution(zeta, ContactEnd::Clip) - clipped).abs() < 5e-5, "{nominal}");
        }
    }

    #[test]
    fn calibration_inverts_restitution() {
        for end in [ContactEnd::Clip, ContactEnd::Tension] {
            for e in [0.05, 0.1, 0.13, 0.14, 0.3, 0.73, 0.9, 0.999] {
                assert!((restitution(damping_ratio(e, end), end) - e).abs() < 1e-9, "{e} {end:?}");
            }
        }
    }
}
