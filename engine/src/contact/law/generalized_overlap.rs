//! From the generalized overlap to the forces: spring, dashpot on D, and dashpots against rocking.

use super::{NormalForce, PairLaw};
use crate::scene::ContactEnd;

/// Exponent of the spring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exponent {
    /// s = k D, W = k D^2 / 2.
    One,
    /// s = k D sqrt(D / D0), W = 2/5 k D^2 sqrt(D / D0).
    ThreeHalves,
}

/// Parameters of the law that are not those of the materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlapLaw {
    /// Exponent of the spring.
    pub exponent: Exponent,
    /// D0 over the sum of the rounding radii.
    pub reference_fraction: f64,
    /// beta.
    pub rocking: f64,
}

/// A spring at its present overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlapSpring {
    /// N.
    pub force: f64,
    /// J.
    pub energy: f64,
    /// Coefficient of the dashpot, N s/m.
    pub damping: f64,
}

impl OverlapLaw {
    /// Spring and dashpot at the overlap D (m); `radius_sum` is r_a + r_b (m), `effective_mass` that of grad D (kg).
    ///
    /// Dashpot: c = 2 zeta sqrt(m_eff k), and for the exponent 1.5 c = 2 sqrt(5/6) zeta sqrt(m_eff dF/dD) =
    /// sqrt(5) zeta sqrt(m_eff k) (D/D0)^(1/4). The latter gives the restitution of the linear oscillator with the
    /// same zeta under both rules of contact end: with u = D^(5/4), m v dv/du = -(4/5)(c1 v + k1 u), and the force
    /// vanishes where c1 v + k1 u does. Source: CONTACT_LAW.md sections 2 and 4; transformation after Antypov and
    /// Elliott (2011). A raw coefficient is taken as it is.
    #[inline]
    pub fn spring(&self, law: &PairLaw, overlap: f64, radius_sum: f64, effective_mass: f64) -> OverlapSpring {
        let k = law.stiffness;
        let viscous = law.damping(effective_mass);
        match self.exponent {
            Exponent::One => {
                let force = k * overlap;
                OverlapSpring { force, energy: 0.5 * force * overlap, damping: viscous }
            }
            Exponent::ThreeHalves => {
                let root = (overlap / (self.reference_fraction * radius_sum)).sqrt();
                let force = k * overlap * root;
                let damping = law.raw_damping.unwrap_or_else(|| viscous * (1.25 * root).sqrt());
                OverlapSpring { force, energy: 0.4 * force * overlap, damping }
            }
        }
    }

    /// dF/dD over k at an overlap D (m); `radius_sum` as in [`OverlapLaw::spring`].
    pub fn present_stiffening(&self, overlap: f64, radius_sum: f64) -> f64 {
        match self.exponent {
            Exponent::One => 1.0,
            Exponent::ThreeHalves => 1.5 * (overlap / (self.reference_fraction * radius_sum)).sqrt(),
        }
    }

    /// dF/dD over k at the reference overlap D0. With the exponent 1.5 deeper contacts are stiffer, by sqrt(D / D0):
    /// D0 should be the deepest overlap that the scene reaches.
    pub fn reference_stiffening(&self) -> f64 {
        match self.exponent {
            Exponent::One => 1.0,
            Exponent::ThreeHalves => 1.5,
        }
    }
}

impl OverlapSpring {
    /// s = spring + c dD/dt, with [`ContactEnd::Clip`] never below 0.
    #[inline]
    pub fn scalar_force(&self, rate: f64, end: ContactEnd) -> NormalForce {
        let damped = self.force + self.damping * rate;
        let force = match end {
            ContactEnd::Clip => damped.max(0.0),
            ContactEnd::Tension => damped,
        };
        NormalForce { force, dissipated_power: (force - self.force) * rate }
    }
}

/// Dashpot of one point against rocking, N along its normal: Q = beta c (w rho^(p-2) u - g U).
///
/// `rate` u is the point's approach speed, `mean_rate` U = sum g u, `rocking` w rho^(p-2), `share` g = w rho^(p-1).
/// Sum Q u >= 0 by Cauchy-Schwarz, 0 when all points keep their part of D (u = rho U): it leaves the restitution of a
/// clean hit alone. With clip Q >= -s g, s the scalar force: no point attracts. Source: CONTACT_LAW.md section 2.
#[inline]
pub fn rocking_force(
    damping: f64,
    [share, rocking]: [f64; 2],
    [rate, mean_rate]: [f64; 2],
    scalar: f64,
    end: ContactEnd,
) -> f64 {
    let force = damping * (rocking * rate - share * mean_rate);
    match end {
        ContactEnd::Clip => force.max(-scalar * share),
        ContactEnd::Tension => force,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::law::damping_ratio;

    /// Central hits of both exponents under both rules, by small explicit steps: restitution as asked within 1e-3.
    #[test]
    fn restitution_is_as_asked_for_both_exponents() {
        for exponent in [Exponent::One, Exponent::ThreeHalves] {
            for end in [ContactEnd::Tension, ContactEnd::Clip] {
                for e in [0.9, 0.5, 0.2] {
                    let law = PairLaw {
                        stiffness: 1.0,
                        damping_ratio: damping_ratio(e, end),
                        raw_damping: None,
                        friction: 0.0,
                        tangential_stiffness: 0.0,
                        tangential_damping_ratio: 0.0,
                    };
                    let overlap_law = OverlapLaw { exponent, reference_fraction: 0.8, rocking: 0.0 };
                    let (mut d, mut rate, dt) = (1e-9, 0.3, 1e-4);
                    while d > 0.0 {
                        let force = overlap_law.spring(&law, d, 1.0, 1.0).scalar_force(rate, end).force;
                        if end == ContactEnd::Clip && force <= 0.0 && rate < 0.0 {
                            break;
                        }
                        rate -= force * dt;
                        d += rate * dt;
                    }
                    assert!((-rate / 0.3 - e).abs() < 1e-3, "{exponent:?} {end:?} {e}: {}", -rate / 0.3);
                }
            }
        }
    }
}
