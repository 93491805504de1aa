//! Cohesion: attraction of bodies that touch.

use super::Jkr;

/// Law of a pair of materials.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CohesionLaw {
    /// None.
    #[default]
    None,
    /// F_c = const while d > 0, W = -F_c d; N.
    Constant(f64),
    /// F_c = kappa 2 pi R d, W = -kappa pi R d^2; kappa in J/m3.
    Sjkr(f64),
    /// See [`Jkr`], in place of Hertz's spring.
    Jkr {
        /// w, J/m2.
        work_of_adhesion: f64,
        /// E*, Pa.
        modulus: f64,
    },
}

impl CohesionLaw {
    /// Attraction (N) and energy (J) at the overlap d (m) of bodies with 1/R = 1/r_a + 1/r_b (R in m).
    ///
    /// `Constant`: a bond that breaks at d = 0; pull-off force F_c. `Sjkr` ("simplified JKR", as LIGGGHTS names it):
    /// energy density kappa times the area of contact, of which 2 pi R d is the leading order for two spheres and for a
    /// sphere at a plane. With a linear law of stiffness k it needs 2 pi R kappa < k, else nothing separates the two.
    /// `Jkr`: what is missing from Hertz's spring to the law of Johnson, Kendall and Roberts, also at the negative overlaps
    /// of a contact that is held. All act besides the spring and the dashpot, whose force alone limits the friction.
    #[inline(always)]
    pub fn at(&self, radius: f64, overlap: f64) -> (f64, f64) {
        match *self {
            Self::None => (0.0, 0.0),
            Self::Constant(force) => (force, -force * overlap),
            Self::Sjkr(density) => {
                let force = 2.0 * std::f64::consts::PI * density * radius * overlap;
                (force, -0.5 * force * overlap)
            }
            Self::Jkr { work_of_adhesion, modulus } => {
                let (force, energy) = Jkr::new(work_of_adhesion, modulus, radius).at(overlap);
                let pressed = overlap.max(0.0);
                let hertz = 4.0 / 3.0 * modulus * (radius * pressed).sqrt() * pressed;
                (hertz - force, energy - 0.4 * hertz * pressed)
            }
        }
    }

    /// The bond of parts with the effective radius R (m) that holds beyond the touch, if the law has one.
    pub fn bond(&self, radius: f64) -> Option<Jkr> {
        match *self {
            Self::Jkr { work_of_adhesion, modulus } if work_of_adhesion > 0.0 => {
                Some(Jkr::new(work_of_adhesion, modulus, radius))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The attraction is -dW/dd.
    #[test]
    fn force_is_the_gradient_of_the_energy() {
        let jkr = CohesionLaw::Jkr { work_of_adhesion: 0.1, modulus: 10.0 };
        for law in [CohesionLaw::None, CohesionLaw::Constant(2.0), CohesionLaw::Sjkr(30.0), jkr] {
            let (d, h) = (1e-2, 1e-6);
            let slope = (law.at(0.5, d + h).1 - law.at(0.5, d - h).1) / (2.0 * h);
            let force = law.at(0.5, d).0;
            assert!((force + slope).abs() <= 1e-8 * force, "{law:?}: {force} {slope}");
        }
    }
}
