//! Tangential force of spheres that do not slip, kept in the Coulomb cone.

use super::tangential::{Slide, TangentialForce, coulomb_history};

/// kt = 8 G* a, a = sqrt(R d): tangential stiffness of a Hertz contact without slip, N/m.
///
/// `shear_modulus` G* (Pa) of [`super::HertzPair`], `radius` R and `overlap` d (m). Source: Mindlin (1949).
#[inline(always)]
pub fn mindlin_stiffness(shear_modulus: f64, radius: f64, overlap: f64) -> f64 {
    8.0 * shear_modulus * (radius * overlap).sqrt()
}

/// Incremental force f <- f (a/a_old if the contact unloads) - kt(d) du - ct v, truncated to |f| <= mu f_n.
///
/// The spring is kept as a length xi with f = -kt(d) xi. While the normal load grows the force is kept, so xi shrinks
/// by a_old/a; while it falls xi is kept, so f falls with the radius of contact. Keeping f then would give back more
/// than was put in (Elata and Berryman 1996; the rule is that of Thornton, Cummins and Cleary 2013). Energy kt xi^2/2:
/// both rules lower it or leave it, and the difference is booked as friction. Without partial slip: the annulus that
/// Mindlin and Deresiewicz (1953) let slip is left out.
#[inline(always)]
pub fn mindlin(slide: &Slide) -> TangentialForce {
    let spring = if slide.former_overlap < slide.overlap {
        slide.spring * (slide.former_overlap.max(0.0) / slide.overlap).sqrt()
    } else {
        slide.spring
    };
    let coefficients = [slide.stiffness, slide.damping];
    coulomb_history(coefficients, slide.limit, &spring, &slide.normal, &slide.stretch, &slide.velocity)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    /// A closed loop of normal and tangential displacement, with infinite friction: the work done on the contact is
    /// never negative, whichever way round. (Keeping the force while unloading gives energy away on one of the ways.)
    #[test]
    fn a_closed_loop_takes_energy() {
        for (first, second) in [(0, 1), (1, 0)] {
            let (mut spring, mut work) = (Vec3::zeros(), 0.0);
            let mut overlap = 0.5;
            // (overlap, slip) per leg: four sides of a rectangle
            let legs = [[0.5, 0.0], [0.0, 1.0], [-0.5, 0.0], [0.0, -1.0]];
            let order = if first < second { [0, 1, 2, 3] } else { [1, 0, 3, 2] };
            for leg in order {
                for _ in 0..1000 {
                    let [load, slip] = legs[leg].map(|x| x / 1000.0);
                    let former_overlap = overlap;
                    overlap += load;
                    let stretch = Vec3::x() * slip;
                    let slide = Slide {
                        stiffness: mindlin_stiffness(1.0, 1.0, overlap),
                        damping: 0.0,
                        limit: f64::INFINITY,
                        spring,
                        normal: Vec3::z(),
                        stretch,
                        velocity: Vec3::zeros(),
                        overlap,
                        former_overlap,
                    };
                    let after = mindlin(&slide);
                    let before = -spring * mindlin_stiffness(1.0, 1.0, former_overlap);
                    work -= 0.5 * (before + after.force).dot(&stretch);
                    spring = after.spring;
                }
            }
            assert!(work > -1e-3, "order {order:?}: work {work}");
        }
    }

    /// At constant overlap the force is the negative gradient of kt xi^2/2.
    #[test]
    fn force_is_the_gradient_of_the_energy() {
        let stiffness = mindlin_stiffness(2.0, 1.0, 0.01);
        let of = |x: f64| {
            mindlin(&Slide {
                stiffness,
                damping: 0.0,
                limit: f64::INFINITY,
                spring: Vec3::x() * x,
                normal: Vec3::z(),
                stretch: Vec3::zeros(),
                velocity: Vec3::zeros(),
                overlap: 0.01,
                former_overlap: 0.01,
            })
        };
        let energy = |x: f64| 0.5 * stiffness * of(x).spring.norm_squared();
        let slope = (energy(0.2 + 1e-5) - energy(0.2 - 1e-5)) / 2e-5;
        assert!((of(0.2).force.x + slope).abs() < 1e-9 * slope);
    }
}
