//! A ball and a cylinder with flat caps.

use super::cylinder::Solid;
use super::{Cylinder, FeatureKey, Manifold, ManifoldPoint, Sphere};
use crate::math::{Similarity, Vec3};

/// At most one point, along the shortest line to the surface; a centre inside leaves through the nearer of cap and side.
pub fn sphere_cylinder(a: &Sphere, b: &Cylinder, b_to_a: &Similarity, out: &mut Manifold) {
    let solid = Solid::of(b).mapped(b_to_a);
    if let Some(point) = ball_point(&a.center, a.radius, &solid.distance(&a.center), FeatureKey::point(0)) {
        out.push(point);
    }
}

/// The contact of a ball at `x` whose centre has this signed distance from the surface, with the outward direction there.
pub(super) fn ball_point(
    x: &Vec3,
    radius: f64,
    (distance, outwards): &(f64, Vec3),
    feature: FeatureKey,
) -> Option<ManifoldPoint> {
    let overlap = radius - distance;
    let position = x - outwards * (0.5 * (radius + distance));
    (overlap > 0.0).then_some(ManifoldPoint { position, normal: -outwards, overlap, share: 1.0, feature })
}
