//! The surface of a union of convex polyhedra, exactly: each face less what lies in the other polyhedra.

use crate::math::Vec3;
use crate::shape::Polyhedron;

/// Width of planes over the size: rounding of glued faces.
const GLUED: f64 = 1e-9;

/// Area of the surface of the union.
pub(super) fn union_area(solids: &[&Polyhedron]) -> f64 {
    let size = solids.iter().flat_map(|s| s.vertices()).map(|v| v.norm()).fold(0.0, f64::max);
    let mut sum = 0.0;
    for (i, solid) in solids.iter().enumerate() {
        for (f, face) in solid.faces().iter().enumerate() {
            let polygon = solid.face_vertices(f).iter().map(|&v| solid.vertices()[v as usize]).collect();
            let mut rest = vec![polygon];
            for (j, other) in solids.iter().enumerate().filter(|(j, _)| *j != i) {
                rest = rest.into_iter().flat_map(|p| outside(p, &face.normal, other, j < i, GLUED * size)).collect();
            }
            sum += rest.iter().map(|p| polygon_area(p)).sum::<f64>();
        }
    }
    sum
}

/// What of a convex polygon lies outside a polyhedron, as convex polygons. Of two faces in one plane that look the same
/// way, the earlier solid's counts; if they look at each other, neither.
fn outside(polygon: Vec<Vec3>, normal: &Vec3, solid: &Polyhedron, earlier: bool, width: f64) -> Vec<Vec<Vec3>> {
    let mut kept = Vec::new();
    let mut rest = polygon;
    for face in solid.faces() {
        let heights: Vec<f64> = rest.iter().map(|v| face.normal.dot(v) - face.offset).collect();
        if heights.iter().all(|h| h.abs() <= width) {
            if face.normal.dot(normal) > 0.0 && !earlier {
                kept.push(rest);
                return kept;
            }
            continue;
        }
        let (above, below) = split(&rest, &heights, width);
        kept.extend(above);
        match below {
            Some(below) => rest = below,
            None => return kept,
        }
    }
    kept
}

/// The parts of a convex polygon above and below a plane.
fn split(polygon: &[Vec3], heights: &[f64], width: f64) -> (Option<Vec<Vec3>>, Option<Vec<Vec3>>) {
    if heights.iter().all(|h| *h <= width) {
        return (None, Some(polygon.to_vec()));
    }
    if heights.iter().all(|h| *h >= -width) {
        return (Some(polygon.to_vec()), None);
    }
    let (mut above, mut below) = (Vec::new(), Vec::new());
    for (k, (a, ha)) in polygon.iter().zip(heights).enumerate() {
        let next = (k + 1) % polygon.len();
        let (b, hb) = (&polygon[next], heights[next]);
        if *ha >= 0.0 {
            above.push(*a);
        }
        if *ha <= 0.0 {
            below.push(*a);
        }
        if ha * hb < 0.0 {
            let x = a + (b - a) * (ha / (ha - hb));
            above.push(x);
            below.push(x);
        }
    }
    (Some(above), Some(below))
}

pub(super) fn polygon_area(polygon: &[Vec3]) -> f64 {
    let fan = polygon.windows(2).skip(1).map(|w| (w[0] - polygon[0]).cross(&(w[1] - polygon[0])));
    0.5 * fan.sum::<Vec3>().norm()
}
