//! Two balls.

use super::round::{Ball, push};
use super::{Manifold, Sphere};
use crate::math::{Similarity, Vec3};

/// At most one point, along the line of centres; coincident centres push apart along x.
pub fn sphere_sphere(a: &Sphere, b: &Sphere, b_to_a: &Similarity, out: &mut Manifold) {
    let b = Ball { center: b_to_a.point(&b.center), radius: b.radius * b_to_a.scale };
    push(&Ball { center: a.center, radius: a.radius }, &b, Vec3::x, out);
}
