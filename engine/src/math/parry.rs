//! The one place where parry's types are spoken: it builds hulls, and nothing of its contact code is used.

use super::Vec3;
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::try_convex_hull;
use std::collections::HashMap;

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
