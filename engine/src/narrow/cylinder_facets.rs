//! What a cylinder puts into a contact of several points: the cap or the line of its side that faces the other part,
//! and the points that these share with a face, a cap or a line.
//!
//! A cap gives the deepest point of its rim, the opposite one and the two halfway, as at a plane, as far as they lie on
//! the other facet, and the points where its rim leaves that one. Overlaps are gaps between the planes of the two
//! facets along the normal, so that points drop out continuously as a cap tilts, and a rim is left with one.

use super::cylinder::{QUARTERS, Ring, Solid};
use super::{FeatureKey, Manifold, ManifoldPoint};
use crate::math::{Similarity, Vec3};
use crate::shape::{MAX_FACE_VERTICES, Polyhedron};

/// Names of a line of the side where it ends, and of the line and the rims where they leave a face: above those of rims.
const LINE_END: u32 = 32;
const LINE: u32 = 64;
const RIM: u32 = 72;
/// Most corners of a patch: those of a face, its rim points, and two where each side of the face crosses the rim.
const MOST: usize = 3 * MAX_FACE_VERTICES + QUARTERS as usize;

/// The name of the one point where a line of the side or a rim meets an edge or another one.
pub(super) fn crossing_key(edge: u32) -> FeatureKey {
    FeatureKey::edges(LINE + 1, edge)
}

/// A face of a polyhedron in the frame of `a`.
pub(super) struct Face {
    points: [Vec3; MAX_FACE_VERTICES],
    vertices: [u32; MAX_FACE_VERTICES],
    edges: [u32; MAX_FACE_VERTICES],
    len: usize,
    /// Out of the polyhedron.
    pub normal: Vec3,
}

impl Face {
    pub fn new(p: &Polyhedron, face: usize, to_a: &Similarity) -> Self {
        let mut new = Self {
            points: [Vec3::zeros(); MAX_FACE_VERTICES],
            vertices: [0; MAX_FACE_VERTICES],
            edges: [0; MAX_FACE_VERTICES],
            len: p.face_vertices(face).len(),
            normal: to_a.direction(&p.faces()[face].normal),
        };
        for (k, (&v, &e)) in p.face_vertices(face).iter().zip(p.face_edges(face)).enumerate() {
            (new.points[k], new.vertices[k], new.edges[k]) = (to_a.point(&p.vertices()[v as usize]), v, e);
        }
        new
    }

    fn next(&self, k: usize) -> usize {
        if k + 1 == self.len { 0 } else { k + 1 }
    }

    /// Whether `x` lies over the face, seen along a direction that the face looks against, or less than `near` beside it.
    fn holds(&self, x: &Vec3, towards: &Vec3, near: f64) -> bool {
        (0..self.len).all(|k| {
            let inwards = (self.points[self.next(k)] - self.points[k]).cross(towards);
            inwards.dot(&(x - self.points[k])) >= -near * inwards.norm()
        })
    }
}

/// What of a cylinder faces a direction.
pub(super) enum Facing {
    /// A cap.
    Cap(Cap),
    /// A line of the side.
    Line(Line),
}

/// A cap, and the order in which its rim comes along the direction.
pub(super) struct Cap {
    solid: Solid,
    ring: Ring,
    /// 1 for the cap that looks along the axis, -1 for the other.
    sense: f64,
    is_of_a: bool,
    /// All of the rim touches.
    whole_rim: bool,
}

/// A line of the side, from cap to cap.
pub(super) struct Line {
    pub ends: [Vec3; 2],
    is_of_a: bool,
}

impl Facing {
    /// Towards a unit vector: the cap where its far side is nearer to touching than the far end of the line is.
    pub fn new(solid: &Solid, towards: &Vec3, is_of_a: bool) -> Self {
        let ring = solid.ring(towards);
        let cosine = solid.axis.dot(towards);
        if solid.radius * ring.sine <= 2.0 * solid.half * cosine.abs() {
            let sense = 1.0_f64.copysign(cosine);
            return Self::Cap(Cap { solid: *solid, ring, sense, is_of_a, whole_rim: false });
        }
        let out = ring.deepest * solid.radius;
        Self::Line(Line { ends: [solid.cap(-1.0) + out, solid.cap(1.0) + out], is_of_a })
    }
}

/// What the points of one contact have in common.
pub(super) struct Contact {
    /// Unit normal out of the part that the facet is of.
    pub towards: Vec3,
    pub depth: f64,
    /// Points closer than this are one.
    pub near: f64,
    /// Where the contact is if the facets share nothing, and what it is then.
    pub fallback: (Vec3, FeatureKey),
}

impl Contact {
    /// The same seen from the other part.
    pub fn reversed(&self) -> Self {
        Self { towards: -self.towards, ..*self }
    }

    fn point(&self, position: Vec3, overlap: f64, share: f64, feature: FeatureKey, is_of_a: bool) -> ManifoldPoint {
        let normal = if is_of_a { self.towards } else { -self.towards };
        ManifoldPoint { position, normal, overlap, share, feature }
    }

    /// The contact as one point, seen from `a`.
    pub fn single(&self) -> ManifoldPoint {
        self.point(self.fallback.0, self.depth, 1.0, self.fallback.1, true)
    }
}

/// Height of `x` behind a plane, along a direction that the plane looks against.
fn gap(x: &Vec3, (point, normal): (&Vec3, &Vec3), towards: &Vec3) -> f64 {
    normal.dot(&(x - point)) / normal.dot(towards)
}

impl Cap {
    /// Outwards.
    pub fn normal(&self) -> Vec3 {
        self.solid.axis * self.sense
    }

    pub fn center(&self) -> Vec3 {
        self.solid.cap(self.sense)
    }

    /// Finds out whether the far side of the rim touches as well, at a plane with this normal, out of the other part.
    fn settle(&mut self, plane: &Vec3, contact: &Contact) {
        let across = self.ring.deepest * (-2.0 * self.solid.radius);
        let rise = across.dot(&contact.towards);
        let of_plane = -plane.dot(&(across - contact.towards * rise)) / plane.dot(&contact.towards);
        self.whole_rim = contact.depth + rise - of_plane > 0.0;
    }

    /// Corners on the rim with their names.
    fn rim_points(&self) -> [(Vec3, FeatureKey); QUARTERS as usize] {
        let (out, side) = (self.ring.deepest * self.solid.radius, self.ring.side * self.solid.radius);
        let rim = if self.sense > 0.0 { QUARTERS } else { 0 };
        let mut k = 0;
        [out, side, -out, -side].map(|from_axis| {
            let slot = rim + self.ring.slot(k, QUARTERS, self.whole_rim);
            k += 1;
            (self.center() + from_axis, self.vertex_key(slot))
        })
    }

    fn vertex_key(&self, slot: u32) -> FeatureKey {
        if self.is_of_a { FeatureKey::vertex_of_a(slot) } else { FeatureKey::vertex_of_b(slot) }
    }

    /// Projected along a direction into the plane of the cap.
    fn projected(&self, x: &Vec3, towards: &Vec3) -> Vec3 {
        x - towards * gap(x, (&self.center(), &self.normal()), towards)
    }

    /// Parameters at which the line through two points of the plane enters and leaves the rim.
    fn crossings(&self, p: &Vec3, q: &Vec3, near: f64) -> Option<[f64; 2]> {
        let (from, step) = (p - self.center(), q - p);
        let square = step.norm_squared();
        let middle = -from.dot(&step) / square;
        let left = (self.solid.radius + near).powi(2) - (from + step * middle).norm_squared();
        let half = (left / square).sqrt();
        (left > 0.0).then_some([middle - half, middle + half])
    }

    /// Adds the points of the cap on a face of a polyhedron.
    pub fn push_on_face(mut self, face: &Face, contact: &Contact, out: &mut Manifold) {
        self.settle(&face.normal, contact);
        let (towards, near) = (&contact.towards, contact.near);
        let mut patch = Patch::new((face.points[0], face.normal), self.is_of_a);
        for (x, key) in self.rim_points() {
            if face.holds(&x, towards, near) {
                patch.add(x, contact, key);
            }
        }
        for k in 0..face.len {
            let [p, q] = [face.points[k], face.points[face.next(k)]].map(|x| self.projected(&x, towards));
            if (p - self.center()).norm() <= self.solid.radius + near {
                let v = face.vertices[k];
                let key = if self.is_of_a { FeatureKey::vertex_of_b(v) } else { FeatureKey::vertex_of_a(v) };
                patch.add(p, contact, key);
            }
            for (t, name) in self.crossings(&p, &q, 0.0).into_iter().flatten().zip([RIM, RIM + 1]) {
                if t > 0.0 && t < 1.0 {
                    let e = face.edges[k];
                    let key = if self.is_of_a { FeatureKey::edges(name, e) } else { FeatureKey::edges(e, name) };
                    patch.add(p + (q - p) * t, contact, key);
                }
            }
        }
        patch.push(contact, out);
    }

    /// Where the rims of two caps cross, seen along a direction: as if both were circles there, and on from that by
    /// Newton's method along the rim of this one.
    fn rim_crossings(&self, other: &Self, towards: &Vec3) -> [Option<Vec3>; 2] {
        let between = other.center() - self.center();
        let lateral = between - towards * between.dot(towards);
        let distance2 = lateral.norm_squared();
        let (ra, rb) = (self.solid.radius, other.solid.radius);
        if distance2 <= (ra - rb).powi(2) || distance2 >= (ra + rb).powi(2) {
            return [None; 2];
        }
        let foot = 0.5 * (distance2 + ra * ra - rb * rb) / distance2;
        let height = (ra * ra / distance2 - foot * foot).max(0.0).sqrt();
        let (e1, e2) = (self.ring.deepest, self.ring.side);
        let to_other = |x: &Vec3| x - towards * (other.normal().dot(x) / other.normal().dot(towards));
        [height, -height].map(|height| {
            let start = self.projected(&(self.center() + lateral * foot + towards.cross(&lateral) * height), towards);
            let mut angle = e2.dot(&(start - self.center())).atan2(e1.dot(&(start - self.center())));
            let mut left = f64::MAX;
            for _ in 0..8 {
                let (sin, cos) = angle.sin_cos();
                let from = to_other(&((e1 * cos + e2 * sin) * ra - between));
                left = from.norm_squared() - rb * rb;
                let slope = 2.0 * from.dot(&to_other(&((e2 * cos - e1 * sin) * ra)));
                if left.abs() <= 1e-14 * rb * rb || slope == 0.0 {
                    break;
                }
                angle -= (left / slope).clamp(-0.5, 0.5);
            }
            let (sin, cos) = angle.sin_cos();
            (left.abs() <= 1e-12 * rb * rb).then(|| self.center() + (e1 * cos + e2 * sin) * ra)
        })
    }

    /// Adds the points of two caps, this one of `a`: rim points of either on the other, and where the rims cross.
    pub fn push_on_cap(mut self, mut other: Self, contact: &Contact, out: &mut Manifold) {
        let reversed = contact.reversed();
        self.settle(&other.normal(), contact);
        other.settle(&self.normal(), &reversed);
        let (towards, near) = (&contact.towards, contact.near);
        let mut patch = Patch::new((other.center(), other.normal()), true);
        for (x, key) in self.rim_points() {
            if (other.projected(&x, &reversed.towards) - other.center()).norm() <= other.solid.radius + near {
                patch.add(x, contact, key);
            }
        }
        for (x, key) in other.rim_points() {
            let x = self.projected(&x, towards);
            if (x - self.center()).norm() <= self.solid.radius + near {
                patch.add(x, contact, key);
            }
        }
        for (k, x) in (1..).zip(self.rim_crossings(&other, towards)) {
            if let Some(x) = x {
                patch.add(x, contact, crossing_key(k));
            }
        }
        if contact.fallback.1 == crossing_key(0) {
            patch.add(self.projected(&contact.fallback.0, towards), contact, crossing_key(0));
        }
        patch.push(contact, out);
    }
}

/// The corners of what two facets share, in the plane of the first.
struct Patch {
    corners: [(Vec3, f64, FeatureKey); MOST],
    len: usize,
    /// Of the second facet: point and outward normal.
    plane: (Vec3, Vec3),
    is_of_a: bool,
}

impl Patch {
    fn new(plane: (Vec3, Vec3), is_of_a: bool) -> Self {
        Self { corners: [(Vec3::zeros(), 0.0, FeatureKey(0)); MOST], len: 0, plane, is_of_a }
    }

    /// Adds a corner; of two that coincide the first stays, under the lower name.
    fn add(&mut self, x: Vec3, contact: &Contact, key: FeatureKey) {
        let near2 = contact.near * contact.near;
        let known = self.corners[..self.len].iter_mut().find(|(y, _, _)| (x - *y).norm_squared() <= near2);
        if let Some((_, _, name)) = known {
            *name = key.min(*name);
        } else if self.len < MOST {
            self.corners[self.len] = (x, 0.0, key);
            self.len += 1;
        }
    }

    /// Adds the corners that overlap, each with half of the overlapping outline to its neighbours as share; never nothing.
    fn push(&mut self, contact: &Contact, out: &mut Manifold) {
        let first = out.len();
        let corners = &mut self.corners[..self.len];
        let middle = corners.iter().map(|c| c.0).sum::<Vec3>() / corners.len().max(1) as f64;
        let e1 = super::round::across(&contact.towards);
        let e2 = contact.towards.cross(&e1);
        for (x, angle, _) in corners.iter_mut() {
            *angle = e2.dot(&(*x - middle)).atan2(e1.dot(&(*x - middle)));
        }
        corners.sort_unstable_by(|p, q| p.1.total_cmp(&q.1).then(p.2.cmp(&q.2)));
        // the planes go on beyond the facets, but nothing is deeper than the deepest point
        let overlap = |x: &Vec3| gap(x, (&self.plane.0, &self.plane.1), &contact.towards).min(contact.depth);
        let n = corners.len();
        for (k, (x, _, key)) in corners.iter().enumerate() {
            let own = overlap(x);
            if own > 0.0 {
                // as far as the outline overlaps: which facet it belongs to must not show where two meet at an edge
                let beside = |(y, _, _): &(Vec3, f64, FeatureKey)| {
                    let other = overlap(y);
                    (y - x).norm() * if other < 0.0 { own / (own - other) } else { 1.0 }
                };
                let share = 0.5 * (beside(&corners[(k + 1) % n]) + beside(&corners[(k + n - 1) % n])) + contact.near;
                let position = x - contact.towards * (0.5 * own);
                out.push(contact.point(position, own, share, *key, self.is_of_a));
            }
        }
        if out.len() == first {
            out.push(contact.point(contact.fallback.0, contact.depth, 1.0, contact.fallback.1, self.is_of_a));
        }
    }
}

/// The stretch of a line that lies over a facet: parameters in [0, 1], and what cuts it off.
struct Stretch {
    range: [f64; 2],
    cut: [Option<u32>; 2],
}

impl Line {
    /// Adds the ends of the stretch over a face of a polyhedron.
    pub fn push_on_face(&self, face: &Face, contact: &Contact, out: &mut Manifold) {
        let stretch = self.over_face(face, contact);
        self.push_ends(stretch, (&face.points[0], &face.normal), contact, out);
    }

    /// Adds the ends of the stretch over a cap.
    pub fn push_on_cap(&self, cap: &Cap, contact: &Contact, out: &mut Manifold) {
        let [p, q] = self.ends.each_ref().map(|x| cap.projected(x, &-contact.towards));
        let stretch = cap.crossings(&p, &q, contact.near).and_then(|[enter, leave]| {
            let range = [enter.max(0.0), leave.min(1.0)];
            let cut = [(enter > 0.0).then_some(RIM), (leave < 1.0).then_some(RIM + 1)];
            (range[0] < range[1]).then_some(Stretch { range, cut })
        });
        self.push_ends(stretch, (&cap.center(), &cap.normal()), contact, out);
    }

    fn over_face(&self, face: &Face, contact: &Contact) -> Option<Stretch> {
        let mut stretch = Stretch { range: [0.0, 1.0], cut: [None; 2] };
        for k in 0..face.len {
            // the face looks against `towards`
            let inwards = (face.points[face.next(k)] - face.points[k]).cross(&contact.towards);
            let [p, q] = self.ends.map(|x| inwards.dot(&(x - face.points[k])));
            let outside = -contact.near * inwards.norm();
            if p < outside && q < outside {
                return None;
            }
            let crossing = p / (p - q);
            if p < outside && crossing > stretch.range[0] {
                (stretch.range[0], stretch.cut[0]) = (crossing, Some(face.edges[k]));
            } else if q < outside && crossing < stretch.range[1] {
                (stretch.range[1], stretch.cut[1]) = (crossing, Some(face.edges[k]));
            }
        }
        (stretch.range[0] < stretch.range[1]).then_some(stretch)
    }

    fn push_ends(&self, stretch: Option<Stretch>, plane: (&Vec3, &Vec3), contact: &Contact, out: &mut Manifold) {
        let first = out.len();
        if let Some(Stretch { range, cut }) = stretch {
            let ends = range.map(|t| self.ends[0] + (self.ends[1] - self.ends[0]) * t);
            let length = (ends[1] - ends[0]).norm();
            for (k, (x, cut)) in (0..).zip(ends.into_iter().zip(cut)).filter(|_| length > contact.near) {
                let overlap = gap(&x, plane, &contact.towards).min(contact.depth);
                if overlap > 0.0 {
                    let feature = self.key(k, cut);
                    let position = x - contact.towards * (0.5 * overlap);
                    out.push(contact.point(position, overlap, 0.5 * length, feature, self.is_of_a));
                }
            }
        }
        if out.len() == first {
            out.push(contact.point(contact.fallback.0, contact.depth, 1.0, contact.fallback.1, self.is_of_a));
        }
    }

    fn key(&self, end: u32, cut: Option<u32>) -> FeatureKey {
        match (cut, self.is_of_a) {
            (None, true) => FeatureKey::vertex_of_a(LINE_END + end),
            (None, false) => FeatureKey::vertex_of_b(LINE_END + end),
            (Some(side), true) => FeatureKey::edges(LINE, side),
            (Some(side), false) => FeatureKey::edges(side, LINE),
        }
    }
}
