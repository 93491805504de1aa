//! Hertz's contact of two spheres, with a dashpot calibrated for the restitution.

use super::{OverlapSpring, PairLaw};

/// Elastic constants of one material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// E, Pa.
    pub youngs_modulus_pa: f64,
    /// nu.
    pub poissons_ratio: f64,
}

/// Effective moduli of a pair of materials.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HertzPair {
    /// E*, Pa: 1/E* = sum (1 - nu^2)/E.
    pub modulus: f64,
    /// G*, Pa: 1/G* = sum (2 - nu)/G, G = E/(2 (1 + nu)).
    pub shear_modulus: f64,
}

impl HertzPair {
    /// Of the materials that give way: one of them may be rigid and is left out.
    pub fn of(materials: impl Iterator<Item = Elastic>) -> Self {
        let (mut normal, mut shear) = (0.0, 0.0);
        for Elastic { youngs_modulus_pa, poissons_ratio: nu } in materials {
            normal += (1.0 - nu * nu) / youngs_modulus_pa;
            shear += 2.0 * (2.0 - nu) * (1.0 + nu) / youngs_modulus_pa;
        }
        Self { modulus: 1.0 / normal, shear_modulus: 1.0 / shear }
    }

    /// F = 4/3 E* sqrt(R) d^1.5, W = 2/5 F d, with the dashpot c = sqrt(5) zeta sqrt(m k) d^(1/4), k = 4/3 E* sqrt(R).
    ///
    /// `radius` R (m): 1/R = 1/r_a + 1/r_b, a wall flat; `overlap` d (m); `mass` the effective one (kg). For small
    /// overlaps, d << R, smooth spheres and normal loads. The dashpot is that of Tsuji et al. (1992) in the form
    /// 2 sqrt(5/6) zeta sqrt(m 2 E* sqrt(R d)); after the transformation of Antypov and Elliott (2011) u = d^(5/4)
    /// moves as a linear damped oscillator of ratio zeta, so zeta from [`super::damping_ratio`] gives the restitution
    /// exactly, at any speed and under both rules of contact end. A raw coefficient is taken as it is.
    #[inline(always)]
    pub fn spring(&self, law: &PairLaw, radius: f64, overlap: f64, mass: f64) -> OverlapSpring {
        let k = 4.0 / 3.0 * self.modulus * radius.sqrt();
        let root = overlap.sqrt();
        let force = k * overlap * root;
        let damping = law.raw_damping.unwrap_or_else(|| law.damping_ratio * (5.0 * mass * k * root).sqrt());
        OverlapSpring { force, energy: 0.4 * force * overlap, damping }
    }

    /// dF/dd = 2 E* sqrt(R d) at d = `fraction` R, N/m.
    pub fn stiffness_at(&self, fraction: f64, radius: f64) -> f64 {
        2.0 * self.modulus * radius * fraction.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::law::damping_ratio;
    use crate::scene::ContactEnd;

    fn law(zeta: f64) -> PairLaw {
        PairLaw {
            stiffness: 0.0,
            damping_ratio: zeta,
            raw_damping: None,
            friction: 0.0,
            tangential_stiffness: 0.0,
            tangential_damping_ratio: 0.0,
        }
    }

    /// The force is dW/dd, d the overlap; central differences, relative error of order (h/d)^2 = 1e-8.
    #[test]
    fn force_is_the_gradient_of_the_energy() {
        let pair = HertzPair { modulus: 2e9, shear_modulus: 1e9 };
        for d in [1e-7, 1e-5, 1e-3] {
            let energy = |d: f64| pair.spring(&law(0.0), 0.01, d, 1.0).energy;
            let h = 1e-4 * d;
            let slope = (energy(d + h) - energy(d - h)) / (2.0 * h);
            let force = pair.spring(&law(0.0), 0.01, d, 1.0).force;
            assert!((slope / force - 1.0).abs() < 1e-7, "{d}: {slope} {force}");
        }
    }

    /// A rigid partner drops out; two equal materials halve the modulus of one.
    #[test]
    fn moduli_of_a_pair() {
        let glass = Elastic { youngs_modulus_pa: 4.8e10, poissons_ratio: 0.2 };
        let wall = HertzPair::of([glass].into_iter());
        let pair = HertzPair::of([glass; 2].into_iter());
        assert!((wall.modulus / (4.8e10 / 0.96) - 1.0).abs() < 1e-14);
        assert!((wall.shear_modulus / (2e10 / 1.8) - 1.0).abs() < 1e-14);
        assert!((pair.modulus / wall.modulus - 0.5).abs() < 1e-14);
    }

    /// Restitution as asked within 1e-3 (explicit steps), whatever the speed and the rule.
    #[test]
    fn restitution_does_not_depend_on_the_speed() {
        let pair = HertzPair { modulus: 0.75, shear_modulus: 1.0 };
        for (end, e, speed) in [
            (ContactEnd::Tension, 0.5, 0.3),
            (ContactEnd::Tension, 0.5, 3.0),
            (ContactEnd::Clip, 0.5, 0.3),
            (ContactEnd::Clip, 0.2, 3.0),
        ] {
            let law = law(damping_ratio(e, end));
            let (mut d, mut rate, dt) = (1e-9, speed, 1e-4);
            while d > 0.0 {
                let force = pair.spring(&law, 1.0, d, 1.0).scalar_force(rate, end).force;
                if end == ContactEnd::Clip && force <= 0.0 && rate < 0.0 {
                    break;
                }
                rate -= force * dt;
                d += rate * dt;
            }
            assert!((-rate / speed - e).abs() < 1e-3, "{end:?} {e}: {}", -rate / speed);
        }
    }
}
