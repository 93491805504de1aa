//! Centre of pressure on the longest axis, x_cp = (L/4) (1 - sin^3 a) upstream of the centre of mass: a quarter of the
//! length for a body along the flow (as of thin aerofoils), at the centre for one across it. T = x_cp x (F_D + F_L).
//!
//! L is the body's extent along its longest axis e, a the angle of e to the relative velocity. The torque turns the body
//! broadside to the flow; it vanishes at a = 0 and 90 degrees and is smooth in between. Times the elongation of the shape
//! (see [`HydroShape::elongation`](super::super::HydroShape::elongation); our own transition, 1 for slender bodies): the
//! law is for cylinders and prolate superellipsoids. Flat bodies get no torque.

use crate::math::Vec3;

pub(crate) const SOURCE: &str = "Rosendahl 2000, Appl. Math. Model. 24, 11; Yin et al. 2003, Chem. Eng. Sci. 58, 2931";
pub(crate) const RANGE: &str =
    "elongated bodies at Re well above 1 (creeping flow exerts no torque); not for flat ones";

/// Torque (N m) of the force (N) in a flow along the unit vector `along`; the axis is a unit vector, the length in m.
pub(crate) fn pitching_torque(force: &Vec3, along: &Vec3, axis: &Vec3, length: f64, elongation: f64) -> Vec3 {
    let cosine = axis.dot(along).clamp(-1.0, 1.0);
    let sine2 = 1.0 - cosine * cosine;
    let offset = 0.25 * length * elongation * (1.0 - sine2 * sine2.sqrt());
    // upstream is where the flow comes from; at cosine 0 the offset is 0
    axis.cross(force) * (-offset * cosine.signum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_broadside() {
        for degrees in [10.0f64, 45.0, 80.0] {
            let a = degrees.to_radians();
            let axis = Vec3::new(a.cos(), a.sin(), 0.0);
            let torque = pitching_torque(&Vec3::x(), &Vec3::x(), &axis, 4.0, 1.0);
            // about +z the angle grows towards 90 degrees
            let expected = (1.0 - a.sin().powi(3)) * a.sin();
            assert!((torque - Vec3::z() * expected).norm() < 1e-15, "{degrees}: {torque:?}");
            assert!((torque - pitching_torque(&Vec3::x(), &Vec3::x(), &-axis, 4.0, 1.0)).norm() < 1e-15);
        }
        for axis in [Vec3::x(), Vec3::y()] {
            assert!(pitching_torque(&Vec3::x(), &Vec3::x(), &axis, 4.0, 1.0).norm() < 1e-15);
        }
    }
}
