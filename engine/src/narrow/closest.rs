//! Closest points of points, segments and polyhedra; no tolerance that is not relative to the lengths handed in.

use super::segments::SegmentPair;
use crate::math::Vec3;
use crate::shape::Polyhedron;

/// The point of the segment `p q` that is closest to `x`, and its parameter in [0, 1].
#[inline]
pub fn closest_on_segment(x: &Vec3, p: &Vec3, q: &Vec3) -> (Vec3, f64) {
    let d = q - p;
    let length2 = d.norm_squared();
    if length2 == 0.0 {
        return (*p, 0.0);
    }
    let s = (d.dot(&(x - p)) / length2).clamp(0.0, 1.0);
    (p + d * s, s)
}

/// Closest points of two segments, on `p` and on `q`. Either may be a point; parallel ones give one of their pairs.
pub fn segment_segment(p: &[Vec3; 2], q: &[Vec3; 2]) -> (Vec3, Vec3) {
    let pair = SegmentPair::new(p, q);
    let (s, t) = pair.closest();
    (pair.on_p(s), pair.on_q(t))
}

/// The face whose plane `x` is farthest outside of (or least deep below), and that signed distance.
pub fn farthest_face(polyhedron: &Polyhedron, x: &Vec3) -> (usize, f64) {
    let mut best = (0, f64::MIN);
    for (i, f) in polyhedron.faces().iter().enumerate() {
        let height = f.normal.dot(x) - f.offset;
        if height > best.1 {
            best = (i, height);
        }
    }
    best
}

/// Whether `x` projects into a face along its normal.
pub fn above_face(polyhedron: &Polyhedron, face: usize, x: &Vec3) -> bool {
    let normal = &polyhedron.faces()[face].normal;
    let around = polyhedron.face_vertices(face);
    let mut from = &polyhedron.vertices()[around[around.len() - 1] as usize];
    for &v in around {
        let to = &polyhedron.vertices()[v as usize];
        if normal.cross(&(to - from)).dot(&(x - from)) < 0.0 {
            return false;
        }
        from = to;
    }
    true
}

/// The feature of a polyhedron that is closest to a point outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nearest {
    /// Inside a face.
    Face(usize),
    /// On an edge or at its ends.
    Edge(usize),
}

/// Closest point of the surface of a polyhedron to a point outside it.
pub fn point_polyhedron(polyhedron: &Polyhedron, x: &Vec3) -> (Vec3, Nearest) {
    for (i, f) in polyhedron.faces().iter().enumerate() {
        let height = f.normal.dot(x) - f.offset;
        if height > 0.0 && above_face(polyhedron, i, x) {
            return (x - f.normal * height, Nearest::Face(i));
        }
    }
    let mut best = (*x, Nearest::Edge(0));
    let mut least = f64::MAX;
    for (i, e) in polyhedron.edges().iter().enumerate() {
        let [p, q] = e.vertices.map(|v| &polyhedron.vertices()[v as usize]);
        let y = closest_on_segment(x, p, q).0;
        let distance = (x - y).norm_squared();
        if distance < least {
            least = distance;
            best = (y, Nearest::Edge(i));
        }
    }
    best
}
