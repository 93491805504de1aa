//! A ball and a convex polyhedron.

use super::closest::{farthest_face, point_polyhedron};
use super::{FeatureKey, Manifold, ManifoldPoint, Sphere};
use crate::math::{Similarity, Vec3};
use crate::shape::Polyhedron;

/// Below this distance over the radius, the direction to the closest point is rounding: the face normal serves.
pub(super) const ON_SURFACE: f64 = 1e-12;

/// At most one point, along the shortest line to the surface; a centre inside leaves through the nearest face.
pub fn sphere_polyhedron(a: &Sphere, b: &Polyhedron, b_to_a: &Similarity, out: &mut Manifold) {
    let a_to_b = b_to_a.inverse();
    let first = out.len();
    let ball = Sphere { center: a_to_b.point(&a.center), radius: a.radius * a_to_b.scale };
    if let Some(point) = ball_contact(&ball, b) {
        out.push(point);
    }
    out.map_from(first, b_to_a);
}

/// The contact of a ball with a polyhedron, in the polyhedron's frame; the normal points from the ball inwards.
pub(super) fn ball_contact(ball: &Sphere, b: &Polyhedron) -> Option<ManifoldPoint> {
    let (distance, outwards) = signed_distance(&ball.center, ball.radius, b);
    let overlap = ball.radius - distance;
    let position = ball.center - outwards * (0.5 * (ball.radius + distance));
    let point = ManifoldPoint { position, normal: -outwards, overlap, share: 1.0, feature: FeatureKey::point(0) };
    (overlap > 0.0).then_some(point)
}

/// Signed distance of `x` from the surface and the outward direction to it. Beyond `reach` only a lower bound.
pub(super) fn signed_distance(x: &Vec3, reach: f64, b: &Polyhedron) -> (f64, Vec3) {
    let (face, height) = farthest_face(b, x);
    let normal = b.faces()[face].normal;
    if height <= 0.0 || height >= reach {
        return (height, normal);
    }
    let (y, nearest) = point_polyhedron(b, x);
    if let super::closest::Nearest::Face(f) = nearest {
        let face = &b.faces()[f];
        return (face.normal.dot(x) - face.offset, face.normal);
    }
    let distance = (x - y).norm();
    if distance <= ON_SURFACE * reach { (height, normal) } else { (distance, (x - y) / distance) }
}
