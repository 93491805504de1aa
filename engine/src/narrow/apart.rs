//! A cheap proof that two parts are further apart than a gap: what the neighbour list leaves out.

use super::features::FeaturePair;
use super::separating_axis::Pair;
use crate::math::Similarity;
use crate::shape::{Part, PartGeometry};

/// Whether the parts are provably more than `gap` apart (in the unit of `a`). False means nothing.
pub fn apart_by(a: &Part, b: &Part, b_to_a: &Similarity, gap: f64) -> bool {
    let reach = a.radius + b.radius * b_to_a.scale + gap;
    if (b_to_a.point(&b.center) - a.center).norm_squared() >= reach * reach {
        return true;
    }
    if a.is_rounded_polyhedron() || b.is_rounded_polyhedron() {
        let (Some(a), Some(b)) = (&a.skeleton, &b.skeleton) else { return false };
        return FeaturePair { a, b, b_to_a }.apart_by(gap);
    }
    match (&a.geometry, &b.geometry) {
        (PartGeometry::Polyhedron(a), PartGeometry::Polyhedron(b)) => Pair { a, b, b_to_a }.separated_by(gap),
        (round_a, round_b) => match (segment(round_a), segment(round_b)) {
            (Some((ends_a, radius_a)), Some((ends_b, radius_b))) => {
                let (x, y) = super::segment_segment(&ends_a, &ends_b.map(|x| b_to_a.point(&x)));
                (y - x).norm() > radius_a + radius_b * b_to_a.scale + gap
            }
            _ => false,
        },
    }
}

/// Core segment and radius of a round part.
fn segment(part: &PartGeometry) -> Option<([crate::math::Vec3; 2], f64)> {
    match part {
        PartGeometry::Sphere { center, radius } => Some(([*center; 2], *radius)),
        PartGeometry::Spherocylinder { ends, radius } => Some((*ends, *radius)),
        PartGeometry::Cylinder { .. } | PartGeometry::Polyhedron(_) | PartGeometry::RoundedPolyhedron(_) => None,
    }
}
