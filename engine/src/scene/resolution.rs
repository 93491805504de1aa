//! What is left of an overlap where coordinates are large: positions are doubles, relative to `domain.origin_m`.

use super::{NormalLaw, Scene};
use crate::error::InvalidInput;
use crate::math::Vec3;

/// Relative error of the smallest overlap from which `sturz check` warns, and from which a scene is refused.
const WARNS: f64 = 1e-6;
const REFUSES: f64 = 1e-2;
/// Roundings of a position between two evaluations of an overlap (PHYSICS.md E, S13).
const ROUNDINGS: f64 = 10.0;
/// Overlap over the bounding radius that counts where nothing has weight.
const WEIGHTLESS_OVERLAP: f64 = 1e-4;

/// Largest coordinate, and the error that it leaves in the smallest overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Resolution {
    largest_m: f64,
    relative_error: f64,
}

impl Resolution {
    fn sentence(&self) -> String {
        format!(
            "coordinates reach {:e} m, which leaves an error of {:.1e} in the overlap of a particle at rest: give domain.origin_m and all coordinates relative to it",
            self.largest_m, self.relative_error
        )
    }

    /// For `sturz check`.
    pub(super) fn warning(&self) -> Option<String> {
        (self.relative_error > WARNS).then(|| self.sentence())
    }

    /// For a scene that cannot give a result.
    pub(super) fn refusal(&self) -> Option<InvalidInput> {
        (self.relative_error > REFUSES).then(|| InvalidInput::new("domain.origin_m", self.sentence()))
    }
}

impl Scene {
    /// Of the particles present; `None` without any.
    pub(super) fn resolution(&self) -> Option<Resolution> {
        let coordinates = self.particles().iter().flat_map(|p| p.position.iter().copied());
        let largest_m = coordinates.map(f64::abs).reduce(f64::max)?;
        let gravity = Vec3::from(self.description().scene.gravity_m_per_s2).norm();
        let has_weight = gravity > 0.0 && self.description().normal_law() != NormalLaw::Hertz;
        let overlap = |material: usize, mass: f64, radius: f64| {
            let walls = self.boundaries().iter().map(|boundary| boundary.material as usize);
            let stiffnesses = walls.chain([material]).filter_map(|other| self.pairs().get(material, other));
            let stiffest = stiffnesses.map(|law| law.stiffness).fold(0.0, f64::max);
            if has_weight && stiffest > 0.0 { mass * gravity / stiffest } else { WEIGHTLESS_OVERLAP * radius }
        };
        let least = self.particles().iter().map(|p| overlap(p.material as usize, p.mass, p.radius)).reduce(f64::min)?;
        Some(Resolution { largest_m, relative_error: ROUNDINGS * (largest_m.next_up() - largest_m) / least })
    }
}
