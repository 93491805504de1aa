//! A cheap proof that two parts are further apart than a gap: what the neighbour list leaves out.

use super::cylinder::Solid;
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
    if let Some(cylinder) = cylinder(a) {
        return apart_from(&cylinder, b, b_to_a, gap);
    }
    if let Some(cylinder) = cylinder(b) {
        return apart_from(&cylinder, a, &b_to_a.inverse(), gap / b_to_a.scale);
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

fn cylinder(part: &Part) -> Option<Solid> {
    let PartGeometry::Cylinder { ends, radius } = &part.geometry else { return None };
    Some(Solid::new(ends, *radius))
}

/// Along the axis, across it, and to the other's middle.
fn apart_from(a: &Solid, b: &Part, b_to_a: &Similarity, gap: f64) -> bool {
    let middle = b_to_a.point(&b.center);
    let cap = a.axis * 1.0_f64.copysign(a.axis.dot(&(middle - a.center)));
    [cap, a.outwards(&middle), (middle - a.center).try_normalize(0.0).unwrap_or(cap)].iter().any(|n| {
        let lowest = n.dot(&b_to_a.translation) - b_to_a.scale * b.reach_along(&b_to_a.inverse_direction(&-n));
        lowest - n.dot(&a.center) - a.reach_along(n) > gap
    })
}

/// Core segment and radius of a round part.
fn segment(part: &PartGeometry) -> Option<([crate::math::Vec3; 2], f64)> {
    match part {
        PartGeometry::Sphere { center, radius } => Some(([*center; 2], *radius)),
        PartGeometry::Spherocylinder { ends, radius } => Some((*ends, *radius)),
        PartGeometry::Cylinder { .. } | PartGeometry::Polyhedron(_) | PartGeometry::RoundedPolyhedron(_) => None,
    }
}
