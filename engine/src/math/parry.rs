//! The one place where parry's types are spoken: it builds hulls and trees of boxes; none of its contact code is used.

use super::Vec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry3d_f64::transformation::try_convex_hull;
use std::collections::HashMap;

/// Boxes by number, found by where they are.
#[derive(Clone)]
pub(crate) struct BoxTree(Bvh);

impl std::fmt::Debug for BoxTree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BoxTree of {}", self.0.leaf_count())
    }
}

impl BoxTree {
    /// Of boxes, each from its lower to its upper corner.
    pub fn new(boxes: impl Iterator<Item = (Vec3, Vec3)>) -> Self {
        let leaves = boxes.map(|(low, high)| aabb(&low, &high)).enumerate();
        Self(Bvh::from_iter(BvhBuildStrategy::Binned, leaves))
    }

    /// Visits the numbers of all boxes that meet a box, in no order.
    pub fn visit(&self, low: &Vec3, high: &Vec3, visit: impl FnMut(u32)) {
        self.0.intersect_aabb(&aabb(low, high)).for_each(visit);
    }

    /// Whether a box that meets a box fits.
    pub fn any(&self, low: &Vec3, high: &Vec3, fits: impl FnMut(u32) -> bool) -> bool {
        self.0.intersect_aabb(&aabb(low, high)).any(fits)
    }
}

fn aabb(low: &Vec3, high: &Vec3) -> Aabb {
    Aabb::new(Vector::new(low.x, low.y, low.z), Vector::new(high.x, high.y, high.z))
}

/// Triangles of the convex hull as indices into `points`, which must be distinct and of unit size.
///
/// Only the connectivity is taken from parry: its tolerances are absolute, so planes are recomputed by the caller.
pub(crate) fn hull_triangles(points: &[Vec3]) -> Result<Vec<[u32; 3]>, String> {
    // adding zero turns -0 into 0, so that equal points have equal bits
    let bits = |v: &Vector| [v.x + 0.0, v.y + 0.0, v.z + 0.0].map(f64::to_bits);
    let given: Vec<Vector> = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    let index: HashMap<[u64; 3], u32> = given.iter().zip(0..).map(|(v, i)| (bits(v), i)).collect();
    let (vertices, triangles) = try_convex_hull(&given).map_err(|e| e.to_string())?;
    let original: Option<Vec<u32>> = vertices.iter().map(|v| index.get(&bits(v)).copied()).collect();
    let original = original.ok_or_else(|| "the hull moved a point".to_string())?;
    Ok(triangles.iter().map(|t| t.map(|v| original[v as usize])).collect())
}

/// parry's own answer for two hulls in one frame, an oracle on generic poses: signed distance, negative when they overlap.
#[cfg(test)]
pub(crate) fn signed_distance(a: &[Vec3], b: &[Vec3]) -> Option<f64> {
    use parry3d_f64::math::Pose;
    use parry3d_f64::shape::ConvexPolyhedron;
    let hull = |points: &[Vec3]| {
        let points: Vec<Vector> = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
        ConvexPolyhedron::from_convex_hull(&points)
    };
    let (a, b) = (hull(a)?, hull(b)?);
    parry3d_f64::query::contact(&Pose::IDENTITY, &a, &Pose::IDENTITY, &b, 1.0).ok()?.map(|c| c.dist)
}
