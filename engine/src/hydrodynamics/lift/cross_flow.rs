//! C_L / C_D = sin^2 a |cos a|, with a the angle of the longest axis e to the relative velocity w.
//!
//! Hoerner's cross-flow principle: only the part of the flow across an inclined body matters. The lift lies in the plane
//! of e and w, on the side of sgn(e.w) (e x w) x w. As a vector, with t = w/|w| and c = e.t:
//! F = -K |w| sin a c (e - c t), smooth in the orientation.
//! Times the elongation of the shape (see [`HydroShape::elongation`](super::super::HydroShape::elongation); our own
//! transition, 1 for slender bodies): the law is for cylinders, and bodies without a longest axis have none of it.

use crate::math::Vec3;

pub(crate) const SOURCE: &str = "Hoerner 1965, Fluid-Dynamic Drag, ch. 3; Yin et al. 2003, Chem. Eng. Sci. 58, 2931";
pub(crate) const RANGE: &str = "elongated bodies where pressure dominates the drag, Re above about 1000; rough below";

/// Lift (N), from the drag |F_D| along the unit vector `along`, and the unit axis.
pub(crate) fn cross_flow(drag: f64, along: &Vec3, axis: &Vec3, elongation: f64) -> Vec3 {
    let cosine = axis.dot(along);
    let across = axis - along * cosine;
    across * (-elongation * drag * across.norm() * cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_an_inclined_cylinder() {
        for degrees in [0.0f64, 30.0, 54.735_610_317_245_35, 90.0, 120.0] {
            let a = degrees.to_radians();
            let axis = Vec3::new(a.cos(), a.sin(), 0.0);
            let lift = cross_flow(2.0, &Vec3::x(), &axis, 1.0);
            assert!((lift.norm() - 2.0 * a.sin().powi(2) * a.cos().abs()).abs() < 1e-15);
            assert!(lift.x.abs() < 1e-15 && (lift - cross_flow(2.0, &Vec3::x(), &-axis, 1.0)).norm() < 1e-15);
            // the force of a flow across the axis: below the axis that points up and downstream
            assert!(lift.y * a.cos() <= 0.0);
        }
    }
}
