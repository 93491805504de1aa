//! A cheap proof that two parts are further apart than a gap: what the neighbour list leaves out.

use super::cylinder::Solid;
use super::features::FeaturePair;
use super::segments::SegmentPair;
use super::separating_axis::Pair;
use crate::math::Similarity;
use crate::shape::{Part, PartGeometry, Spine};

/// Whether the parts are provably more than `gap` apart (in the unit of `a`). False means nothing.
pub fn apart_by(a: &Part, b: &Part, b_to_a: &Similarity, gap: f64) -> bool {
    let reach = a.radius + b.radius * b_to_a.scale + gap;
    if (b_to_a.point(&b.center) - a.center).norm_squared() >= reach * reach {
        return true;
    }
    if (a.spine.is_some() || b.spine.is_some()) && spines_are_apart(a, b, b_to_a, gap) {
        return true;
    }
    if let Some(cylinder) = cylinder(a) {
        return apart_from(&cylinder, b, b_to_a, gap);
    }
    if let Some(cylinder) = cylinder(b) {
        return apart_from(&cylinder, a, &b_to_a.inverse(), gap / b_to_a.scale);
    }
    if a.is_rounded_polyhedron() || b.is_rounded_polyhedron() {
        let (Some(a), Some(b)) = (&a.skeleton, &b.skeleton) else { return false };
        return FeaturePair { a, b, b_to_a }.apart_by(gap);
    }
    match (&a.geometry, &b.geometry) {
        (PartGeometry::Polyhedron(a), PartGeometry::Polyhedron(b)) => Pair { a, b, b_to_a }.separated_by(gap),
        // round parts are their spines or balls
        _ => false,
    }
}

/// By bounding spherocylinders, those without by their bounding balls.
fn spines_are_apart(a: &Part, b: &Part, b_to_a: &Similarity, gap: f64) -> bool {
    let spine = |part: &Part| part.spine.unwrap_or(Spine { ends: [part.center; 2], radius: part.radius });
    let (a, b) = (spine(a), spine(b));
    let reach = a.radius + b.radius * b_to_a.scale + gap;
    let axes = SegmentPair::new(&a.ends, &b.ends.map(|x| b_to_a.point(&x)));
    if axes.lines_are_apart(reach) {
        return true;
    }
    let (s, t) = axes.closest();
    (axes.on_p(s) - axes.on_q(t)).norm_squared() > reach * reach
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
