//! A ball and a spherocylinder.

use super::closest::closest_on_segment;
use super::round::{Ball, across, push};
use super::{Manifold, Sphere, Spherocylinder};
use crate::math::Similarity;

/// At most one point, along the shortest line to the axis; a centre on the axis is pushed out across it.
pub fn sphere_spherocylinder(a: &Sphere, b: &Spherocylinder, b_to_a: &Similarity, out: &mut Manifold) {
    let ends = b.ends.map(|e| b_to_a.point(&e));
    let b = Ball { center: closest_on_segment(&a.center, &ends[0], &ends[1]).0, radius: b.radius * b_to_a.scale };
    push(&Ball { center: a.center, radius: a.radius }, &b, || across(&(ends[1] - ends[0])), out);
}
