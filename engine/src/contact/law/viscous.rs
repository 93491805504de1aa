//! Viscous friction with a Coulomb limit, without a spring.

use super::tangential::{Slide, TangentialForce};
use crate::math::Vec3;

/// f = -min(gamma |u|, mu f_n) u/|u|, u the tangential velocity (m/s), gamma a coefficient (N s/m).
///
/// No spring, hence no static friction: a load t below the limit creeps at t/gamma. Stable up to gamma dt < m_eff, m_eff
/// the effective mass of the tangential motion (2/7 m for a solid sphere at a wall). Source: seed 000, eq. 3.
#[inline(always)]
pub fn viscous(slide: &Slide) -> TangentialForce {
    let trial = slide.velocity * -slide.damping;
    let trial2 = trial.norm_squared();
    let limit = slide.limit;
    let force = if trial2 <= limit * limit { trial } else { trial * (limit / trial2.sqrt()) };
    TangentialForce { force, spring: Vec3::zeros() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viscous_below_the_limit_and_coulomb_above() {
        let at = |speed: f64| {
            viscous(&Slide {
                stiffness: 0.0,
                damping: 2.0,
                limit: 1.0,
                spring: Vec3::zeros(),
                normal: Vec3::z(),
                stretch: Vec3::zeros(),
                velocity: Vec3::x() * speed,
                overlap: 1.0,
                former_overlap: 1.0,
            })
            .force
            .x
        };
        assert_eq!([at(0.0), at(0.25), at(-10.0)], [0.0, -0.5, 1.0]);
    }
}
