//! A spherocylinder and a convex polyhedron.
//!
//! The deepest point is exact: outside, the closest points of axis and surface; inside, the separating-axis test of
//! the axis. Beside it come both ends of the stretch of the axis that lies over the face (or along the edge) in
//! contact, each as a ball of its own; shares as for two spherocylinders.

use super::closest::{Nearest, closest_on_segment, point_polyhedron, segment_segment};
use super::sphere_polyhedron::{ON_SURFACE, ball_contact};
use super::spherocylinder_spherocylinder::push_shared;
use super::{FeatureKey, Manifold, ManifoldPoint, Sphere, Spherocylinder};
use crate::math::{Similarity, Vec3};
use crate::shape::Polyhedron;

/// At most three points.
pub fn spherocylinder_polyhedron(a: &Spherocylinder, b: &Polyhedron, b_to_a: &Similarity, out: &mut Manifold) {
    let a_to_b = b_to_a.inverse();
    let first = out.len();
    let capsule = Spherocylinder { ends: a.ends.map(|e| a_to_b.point(&e)), radius: a.radius * a_to_b.scale };
    capsule_contacts(&capsule, b, out);
    out.map_from(first, b_to_a);
}

/// Signed distance between axis and surface, outward direction, point of the axis, and the feature in contact.
struct Deepest {
    distance: f64,
    outwards: Vec3,
    on_axis: Vec3,
    nearest: Nearest,
}

/// All contacts in the polyhedron's frame, normals from the spherocylinder inwards.
fn capsule_contacts(capsule: &Spherocylinder, b: &Polyhedron, out: &mut Manifold) {
    let Some(deepest) = deepest_point(capsule, b) else { return };
    let overlap = capsule.radius - deepest.distance;
    if overlap <= 0.0 {
        return;
    }
    let mut point = ManifoldPoint {
        position: deepest.on_axis - deepest.outwards * (0.5 * (capsule.radius + deepest.distance)),
        normal: -deepest.outwards,
        overlap,
        share: 1.0,
        feature: FeatureKey::point(2),
    };
    let Some(stretch) = stretch_beside(capsule, b, &deepest) else { return out.push(point) };
    let length = (stretch[1] - stretch[0]).norm();
    if length <= ON_SURFACE * capsule.radius {
        return out.push(point);
    }
    let end = |k: usize| end_contact(capsule, b, &deepest, &stretch[k], FeatureKey::point(k as u32));
    push_shared(&mut point, [end(0), end(1)], length, out);
}

/// The ball of the axis at `x`. Over a face its height counts, also below: a deep end must not leave sideways.
fn end_contact(capsule: &Spherocylinder, b: &Polyhedron, deepest: &Deepest, x: &Vec3, feature: FeatureKey) -> Option<ManifoldPoint> {
    let radius = capsule.radius;
    if let Nearest::Face(f) = deepest.nearest {
        let face = &b.faces()[f];
        let height = face.normal.dot(x) - face.offset;
        let position = x - face.normal * (0.5 * (radius + height));
        let point = ManifoldPoint { position, normal: -face.normal, overlap: radius - height, share: 0.0, feature };
        return (point.overlap > 0.0).then_some(point);
    }
    let mut point = ball_contact(&Sphere { center: *x, radius }, b)?;
    point.feature = feature;
    Some(point)
}

fn deepest_point(capsule: &Spherocylinder, b: &Polyhedron) -> Option<Deepest> {
    let [p, q] = &capsule.ends;
    let mut highest = f64::MIN;
    for f in b.faces() {
        highest = highest.max(f.normal.dot(p).min(f.normal.dot(q)) - f.offset);
    }
    if highest >= capsule.radius {
        return None;
    }
    if !pierces(p, q, b) {
        let outside = closest_outside(capsule, b);
        if outside.distance > ON_SURFACE * capsule.radius {
            return Some(outside);
        }
    }
    Some(least_depth(p, q, b))
}

/// Whether some of the segment lies inside the polyhedron.
fn pierces(p: &Vec3, q: &Vec3, b: &Polyhedron) -> bool {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for f in b.faces() {
        let (hp, hq) = (f.normal.dot(p) - f.offset, f.normal.dot(q) - f.offset);
        if hp > 0.0 && hq > 0.0 {
            return false;
        }
        if hp > 0.0 {
            enter = enter.max(hp / (hp - hq));
        } else if hq > 0.0 {
            leave = leave.min(hp / (hp - hq));
        }
    }
    enter <= leave
}

fn closest_outside(capsule: &Spherocylinder, b: &Polyhedron) -> Deepest {
    let mut best = Deepest { distance: f64::MAX, outwards: Vec3::x(), on_axis: capsule.ends[0], nearest: Nearest::Edge(0) };
    let mut offer = |x: Vec3, y: Vec3, nearest: Nearest| {
        let distance = (x - y).norm();
        if distance < best.distance {
            let outwards = match nearest {
                Nearest::Face(f) => b.faces()[f].normal,
                Nearest::Edge(_) => (x - y) / distance.max(f64::MIN_POSITIVE),
            };
            best = Deepest { distance, outwards, on_axis: x, nearest };
        }
    };
    for x in &capsule.ends {
        let outside = b.faces().iter().any(|f| f.normal.dot(x) > f.offset);
        if outside {
            let (y, nearest) = point_polyhedron(b, x);
            offer(*x, y, nearest);
        }
    }
    for (i, e) in b.edges().iter().enumerate() {
        let edge = e.vertices.map(|v| b.vertices()[v as usize]);
        let (x, y) = segment_segment(&capsule.ends, &edge);
        offer(x, y, Nearest::Edge(i));
    }
    best
}

/// Separating-axis test of a segment: the direction in which it leaves the polyhedron soonest.
fn least_depth(p: &Vec3, q: &Vec3, b: &Polyhedron) -> Deepest {
    let mut best = Deepest { distance: f64::MIN, outwards: Vec3::x(), on_axis: *p, nearest: Nearest::Face(0) };
    for (i, f) in b.faces().iter().enumerate() {
        let (hp, hq) = (f.normal.dot(p) - f.offset, f.normal.dot(q) - f.offset);
        if hp.min(hq) > best.distance {
            let on_axis = if hp <= hq { *p } else { *q };
            best = Deepest { distance: hp.min(hq), outwards: f.normal, on_axis, nearest: Nearest::Face(i) };
        }
    }
    let preferred = best.distance + ON_SURFACE * b.faces().iter().map(|f| f.offset.abs()).fold(0.0, f64::max);
    let axis = q - p;
    for (i, e) in b.edges().iter().enumerate() {
        let [n0, n1] = e.faces.map(|f| &b.faces()[f as usize].normal);
        if n0.dot(&axis) * n1.dot(&axis) >= 0.0 {
            continue;
        }
        let cross = e.direction.cross(&axis);
        let length = cross.norm();
        if length <= 1e-14 * axis.norm() {
            continue;
        }
        let normal = cross * (if cross.dot(&(n0 + n1)) > 0.0 { 1.0 } else { -1.0 } / length);
        let vertex = b.vertices()[e.vertices[0] as usize];
        let distance = normal.dot(&(p - vertex));
        if distance > best.distance.max(preferred) {
            let edge = e.vertices.map(|v| b.vertices()[v as usize]);
            let on_axis = crossing(&[*p, *q], &edge);
            best = Deepest { distance, outwards: normal, on_axis, nearest: Nearest::Edge(i) };
        }
    }
    best
}

/// The point of the segment `p` closest to the line through `q`: the lines pass each other inside both segments.
fn crossing(p: &[Vec3; 2], q: &[Vec3; 2]) -> Vec3 {
    let (u, v, w) = (p[1] - p[0], q[1] - q[0], p[0] - q[0]);
    let (a, b, c) = (u.norm_squared(), u.dot(&v), v.norm_squared());
    let s = (b * v.dot(&w) - c * u.dot(&w)) / (a * c - b * b);
    p[0] + u * s.clamp(0.0, 1.0)
}

/// Ends of the stretch of the axis over the face in contact, or else along the edge in contact.
fn stretch_beside(capsule: &Spherocylinder, b: &Polyhedron, deepest: &Deepest) -> Option<[Vec3; 2]> {
    let face = match deepest.nearest {
        Nearest::Face(f) => f,
        Nearest::Edge(e) => {
            let [f, g] = b.edges()[e].faces.map(|f| f as usize);
            let rise = |f: usize| b.faces()[f].normal.dot(&deepest.outwards);
            if rise(g) > rise(f) { g } else { f }
        }
    };
    if let Some(stretch) = clip_to_face(capsule, b, face) {
        return Some(stretch);
    }
    let Nearest::Edge(e) = deepest.nearest else { return None };
    clip_to_edge(capsule, &b.edges()[e].vertices.map(|v| b.vertices()[v as usize]))
}

fn clip_to_face(capsule: &Spherocylinder, b: &Polyhedron, face: usize) -> Option<[Vec3; 2]> {
    let [p, q] = capsule.ends;
    let normal = &b.faces()[face].normal;
    let around = b.face_vertices(face);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (k, &v) in around.iter().enumerate() {
        let from = b.vertices()[v as usize];
        let to = b.vertices()[around[(k + 1) % around.len()] as usize];
        let inwards = normal.cross(&(to - from));
        let (hp, hq) = (inwards.dot(&(p - from)), inwards.dot(&(q - from)));
        if hp < 0.0 && hq < 0.0 {
            return None;
        }
        if hp < 0.0 {
            enter = enter.max(hp / (hp - hq));
        } else if hq < 0.0 {
            leave = leave.min(hp / (hp - hq));
        }
    }
    (enter < leave).then(|| [p + (q - p) * enter, p + (q - p) * leave])
}

/// The stretch of the axis whose feet on the line of the edge lie on the edge.
fn clip_to_edge(capsule: &Spherocylinder, edge: &[Vec3; 2]) -> Option<[Vec3; 2]> {
    let [p, q] = capsule.ends;
    let feet = edge.map(|v| closest_on_segment(&v, &p, &q).0);
    ((feet[0] - feet[1]).norm() > 0.0).then(|| if (feet[1] - feet[0]).dot(&(q - p)) >= 0.0 { feet } else { [feet[1], feet[0]] })
}
