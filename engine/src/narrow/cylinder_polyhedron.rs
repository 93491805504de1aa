//! A cylinder with flat caps and a convex polyhedron: separating-axis test, then the points that their faces share.
//!
//! Where two convex bodies overlap, the nearest way out of their Minkowski difference leads to a smooth point of its
//! surface. Its smooth pieces are: faces of the polyhedron, caps, and of the other features of the two an edge against a
//! line of the side, a vertex against the side, an edge against a rim. Each has its nearest points in closed form or in
//! a bracket, and each of these directions is measured with the full supports: one that does not apply loses. Bodies
//! that are apart are apart along one of the same directions.

use super::closest::segment_segment;
use super::cylinder::Solid;
use super::cylinder_facets::{Contact, Face, Facing, crossing_key};
use super::face_contact::{COINCIDENT, EQUALLY_DEEP, incident_face};
use super::outline::Outline;
use super::{Cylinder, FeatureKey, Manifold};
use crate::math::{Similarity, Vec3};
use crate::shape::{Edge, Part, Polyhedron};

/// Any other direction must beat those of faces and caps by this, over the size of the pair: rounding must not turn a
/// contact of several points into one of a single point.
const FACE_PREFERENCE: f64 = 1e-12;
/// Sine of the angle between axis and edge below which they are parallel to rounding.
const PARALLEL: f64 = 1e-14;

/// Slack of distances that are compared to leave features out, over the size of the pair: far above rounding.
const SLACK: f64 = 1e-9;

/// The points of a contact with a cap or along the side, or a single one; nothing if the parts are apart. The answer is how
/// far they are apart at least, or minus the depth. `apart` is the most that they can be apart, infinite where it is not
/// known.
pub fn cylinder_polyhedron(
    (part_a, a): (&Part, &Cylinder),
    (part_b, b): (&Part, &Polyhedron),
    (b_to_a, apart): (&Similarity, f64),
    out: &mut Manifold,
) -> f64 {
    let solid = Solid::of(a);
    let (size_a, size_b) = (part_a.radius, part_b.radius * b_to_a.scale);
    let in_b = solid.mapped(&b_to_a.inverse());
    let found = match Search::run(&in_b, b, [(size_a + size_b) / b_to_a.scale, apart / b_to_a.scale]) {
        Ok(found) => found,
        Err(gap) => return gap * b_to_a.scale,
    };
    let (face, _) = incident_face(b, &-found.outwards, EQUALLY_DEEP * part_b.radius);
    let face = Face::new(b, face, b_to_a);
    let contact = Contact {
        towards: -b_to_a.direction(&found.outwards),
        depth: -found.distance * b_to_a.scale,
        near: COINCIDENT * size_a.min(size_b),
        fallback: (b_to_a.point(&found.middle), found.feature),
    };
    match Facing::new(&solid, &contact.towards, true) {
        Facing::Cap(cap) => cap.push_on_face(&face, &contact, out),
        Facing::Line(line) => line.push_on_face(&face, &contact, out),
    }
    -contact.depth
}

/// A direction out of the polyhedron, the separation along it, and where the parts meet in the middle.
struct Found {
    outwards: Vec3,
    distance: f64,
    middle: Vec3,
    feature: FeatureKey,
}

/// The search in the frame of the polyhedron.
struct Search<'s> {
    solid: &'s Solid,
    b: &'s Polyhedron,
    best: Found,
    to_beat: f64,
    /// The most that the parts can be apart, and the slack of distances.
    apart: f64,
    slack: f64,
}

impl<'s> Search<'s> {
    /// The deepest direction, or the gap along one that separates.
    fn run(solid: &'s Solid, b: &'s Polyhedron, [size, apart]: [f64; 2]) -> Result<Found, f64> {
        let nothing =
            Found { outwards: solid.axis, distance: f64::MIN, middle: solid.center, feature: FeatureKey::point(0) };
        let mut search = Self { solid, b, best: nothing, to_beat: f64::MIN, apart, slack: SLACK * size };
        search.faces();
        search.caps();
        // beyond zero every direction counts: touching by less than the tolerance must not hide a gap
        search.to_beat = (search.best.distance + FACE_PREFERENCE * size).min(0.0);
        if search.best.distance < 0.0 {
            search.vertices();
            search.edges();
        }
        if search.best.distance < 0.0 { Ok(search.best) } else { Err(search.best.distance) }
    }

    fn offer(&mut self, outwards: Vec3, distance: f64, middle: Vec3, feature: FeatureKey) {
        if distance > self.to_beat {
            (self.best, self.to_beat) = (Found { outwards, distance, middle, feature }, distance);
        }
    }

    fn faces(&mut self) {
        for f in self.b.faces() {
            let distance = f.normal.dot(&self.solid.center) - f.offset - self.solid.reach_along(&f.normal);
            if distance > self.to_beat {
                let ring = self.solid.ring(&-f.normal);
                let sense = -1.0_f64.copysign(f.normal.dot(&self.solid.axis));
                let lowest = self.solid.cap(sense) + ring.deepest * self.solid.radius;
                self.offer(f.normal, distance, lowest - f.normal * (0.5 * distance), FeatureKey::vertex_of_a(0));
            }
        }
    }

    fn caps(&mut self) {
        for outwards in [self.solid.axis, -self.solid.axis] {
            let (top, vertex) = self.highest(&outwards);
            let distance = outwards.dot(&self.solid.center) - self.solid.half - top;
            let middle = self.b.vertices()[vertex] + outwards * (0.5 * distance);
            self.offer(outwards, distance, middle, FeatureKey::vertex_of_b(vertex as u32));
        }
    }

    /// Vertices against the side.
    fn vertices(&mut self) {
        for (k, v) in self.b.vertices().iter().enumerate() {
            let d = self.solid.center - v;
            let across = d - self.solid.axis * self.solid.axis.dot(&d);
            let distance = across.norm();
            if distance - self.solid.radius > self.to_beat {
                // on the axis any direction across is as good
                let outwards =
                    if distance > 0.0 { across / distance } else { self.solid.ring(&self.solid.axis).deepest };
                self.measure(outwards, *v, FeatureKey::vertex_of_b(k as u32));
            }
        }
    }

    fn edges(&mut self) {
        for (k, e) in self.b.edges().iter().enumerate() {
            let key = crossing_key(k as u32);
            self.edge_at_side(e, key);
            let ends = e.vertices.map(|v| &self.b.vertices()[v as usize]);
            let most = (-self.to_beat).max(self.apart) + self.slack;
            let near = [1.0, -1.0].map(|sense| self.is_near(ends, &e.direction, sense, most));
            if near == [false; 2] {
                continue;
            }
            let x = *ends[0];
            let outline = Outline::new(self.solid, &e.direction);
            for (sense, _) in [1.0, -1.0].into_iter().zip(near).filter(|(_, near)| *near) {
                if outline.is_deeper(sense, &x, -self.to_beat) {
                    continue;
                }
                outline.feet(sense, &x, |foot| {
                    let outwards = -foot.outwards;
                    let bound = outwards.dot(&(self.solid.center - x)) - self.solid.reach_along(&outwards);
                    if bound <= self.to_beat {
                        return;
                    }
                    let distance = self.separation(&outwards);
                    // by the same rule as above, so that what is known of a pair does not show in ties
                    let most = distance.abs() + 0.5 * self.slack;
                    if distance > self.to_beat && self.is_near(ends, &e.direction, sense, most) {
                        self.offer(outwards, distance, foot.on_rim - outwards * (0.5 * distance), key);
                    }
                });
            }
        }
    }

    /// Whether an edge may be no farther from the rim of a cap than `most`. Where the nearest way out of touching parts is
    /// that of an edge and a rim they are as far from each other as the parts are deep, and where parts are apart the
    /// features next to their closest points are as far from each other as they are.
    fn is_near(&self, [p, q]: [&Vec3; 2], direction: &Vec3, sense: f64, most: f64) -> bool {
        let cap = self.solid.cap(sense);
        let [u, v] = [p - cap, q - cap];
        let [above, beyond] = [self.solid.axis.dot(&u), self.solid.axis.dot(&v)];
        if (above > most && beyond > most) || (above < -most && beyond < -most) {
            return false;
        }
        let inner = self.solid.radius - most;
        if inner > 0.0 && u.norm_squared().max(v.norm_squared()) < inner * inner {
            return false;
        }
        let along = (-direction.dot(&u)).clamp(0.0, direction.dot(&(q - p)).max(0.0));
        let outer = self.solid.radius + most;
        (u + direction * along).norm_squared() <= outer * outer
    }

    fn edge_at_side(&mut self, e: &Edge, key: FeatureKey) {
        let [n0, n1] = e.faces.map(|f| &self.b.faces()[f as usize].normal);
        if n0.dot(&self.solid.axis) * n1.dot(&self.solid.axis) >= 0.0 {
            return;
        }
        let cross = e.direction.cross(&self.solid.axis);
        let length = cross.norm();
        if length <= PARALLEL {
            return;
        }
        let outwards = cross * (if cross.dot(&(n0 + n1)) > 0.0 { 1.0 } else { -1.0 } / length);
        let edge = e.vertices.map(|v| self.b.vertices()[v as usize]);
        if outwards.dot(&(self.solid.center - edge[0])) - self.solid.radius > self.to_beat {
            let crossing = segment_segment(&edge, &[self.solid.cap(-1.0), self.solid.cap(1.0)]).0;
            self.measure(outwards, crossing, key);
        }
    }

    /// Measures a direction with the full supports; the parts meet at a point of the polyhedron.
    fn measure(&mut self, outwards: Vec3, on_b: Vec3, feature: FeatureKey) {
        let distance = self.separation(&outwards);
        self.offer(outwards, distance, on_b + outwards * (0.5 * distance), feature);
    }

    fn separation(&self, outwards: &Vec3) -> f64 {
        outwards.dot(&self.solid.center) - self.solid.reach_along(outwards) - self.highest(outwards).0
    }

    fn highest(&self, along: &Vec3) -> (f64, usize) {
        let mut best = (f64::MIN, 0);
        for (k, v) in self.b.vertices().iter().enumerate() {
            let height = along.dot(v);
            if height > best.0 {
                best = (height, k);
            }
        }
        best
    }
}
