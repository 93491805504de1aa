//! Bounding spherocylinders of elongated parts: a ball about a needle is mostly empty.

use nalgebra::SymmetricEigen;

use super::PartGeometry;
use crate::math::{Mat3, Vec3};

/// Only what is slimmer than this part of the bounding ball's radius pays for its test.
const SLIM: f64 = 0.7;

/// The part lies within `radius` of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spine {
    /// Ends of the segment.
    pub ends: [Vec3; 2],
    /// Includes the rounding of the part.
    pub radius: f64,
}

impl Spine {
    /// Of a part within a ball of radius `ball`; `None` where it would not be much slimmer.
    pub(super) fn of(geometry: &PartGeometry, ball: f64) -> Option<Self> {
        let spine = match geometry {
            PartGeometry::Sphere { .. } => return None,
            // the part itself
            PartGeometry::Spherocylinder { ends, radius } => return Some(Self { ends: *ends, radius: *radius }),
            PartGeometry::Cylinder { ends, radius } => Self { ends: *ends, radius: *radius },
            PartGeometry::Polyhedron(p) => Self::around(p.vertices(), 0.0),
            PartGeometry::RoundedPolyhedron(p) => Self::around(p.skeleton.vertices(), p.skeleton.radius),
        };
        // a little more than measured, so that rounding cannot leave a corner outside
        let radius = spine.radius * (1.0 + 1e-12) + 1e-14 * ball;
        (radius < SLIM * ball).then_some(Self { radius, ..spine })
    }

    /// Along the direction in which points scatter most.
    fn around(points: &[Vec3], rounding: f64) -> Self {
        let n = points.len() as f64;
        let mean = points.iter().sum::<Vec3>() / n;
        let covariance: Mat3 = points.iter().map(|x| (x - mean) * (x - mean).transpose()).sum();
        let eigen = SymmetricEigen::new(covariance);
        let axes = [0, 1, 2].map(|k| eigen.eigenvectors.column(k).into_owned());
        let longest = eigen.eigenvalues.imax();
        let middle: Vec3 = axes
            .iter()
            .map(|axis| {
                let heights = points.iter().map(|x| axis.dot(x));
                let (low, high) = heights.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
                axis * (0.5 * (low + high))
            })
            .sum();
        let axis = &axes[longest];
        let off = |x: &Vec3| (x - middle).cross(axis).norm();
        let radius = points.iter().map(off).fold(0.0, f64::max);
        // the caps hold what lies nearer to the axis than the farthest point
        let reach = |x: &Vec3| (x - middle).dot(axis).abs() - (radius * radius - off(x).powi(2)).max(0.0).sqrt();
        let half = points.iter().map(reach).fold(0.0, f64::max);
        Self { ends: [middle - axis * half, middle + axis * half], radius: radius + rounding }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Part;
    use crate::shape::hull::convex_hull;

    fn distance(spine: &Spine, x: &Vec3) -> f64 {
        (crate::narrow::closest_on_segment(x, &spine.ends[0], &spine.ends[1]).0 - x).norm()
    }

    #[test]
    fn beam_is_held_by_a_slim_spine_wherever_it_points() {
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 0.7);
        let corners: Vec<Vec3> = (0..8)
            .map(|k| Vec3::new((k & 1) as f64 - 0.2, 0.2 * (k >> 1 & 1) as f64, 0.2 * (k >> 2) as f64))
            .map(|x| turn * x + Vec3::new(4.0, 5.0, 6.0))
            .collect();
        let beam = convex_hull(&corners, "points").unwrap();
        let spine = Part::new(PartGeometry::Polyhedron(beam)).spine.unwrap();
        assert!((spine.radius - 0.02f64.sqrt()).abs() < 1e-11, "{spine:?}");
        assert!(((spine.ends[1] - spine.ends[0]).norm() - 1.0).abs() < 1e-9, "{spine:?}");
        assert!(corners.iter().all(|x| distance(&spine, x) <= spine.radius));
    }

    #[test]
    fn cubes_have_none() {
        let corners: Vec<Vec3> =
            (0..8).map(|k| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64)).collect();
        let cube = convex_hull(&corners, "points").unwrap();
        assert_eq!(Part::new(PartGeometry::Polyhedron(cube)).spine, None);
    }
}
