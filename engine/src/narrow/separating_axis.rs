//! The separating-axis test of two convex polyhedra: the direction in which they are deepest apart or least overlapped.
//!
//! Candidates are all face normals, and of the edge pairs those whose arcs cross on the Gauss map: only they are
//! faces of the Minkowski difference. Every candidate of an edge pair is measured again with the full supports, which
//! for any direction give a lower bound of the signed distance. A direction blurred by nearly parallel edges can
//! therefore lose, but never win wrongly.

use crate::math::{Similarity, Vec3};
use crate::shape::{Edge, Polyhedron};

/// An edge axis must beat the faces by this, over the size of the pair: rounding must not turn a face contact, which
/// has several points, into an edge contact, which has one.
const FACE_PREFERENCE: f64 = 1e-12;
/// Edges whose unit directions have a smaller cross product are parallel, and their faces cover them.
const PARALLEL: f64 = 1e-14;
/// Up to this many faces of `b`, the sides of its faces along an edge of `a` are computed once per edge.
const CACHED_FACES: usize = 32;

/// Two polyhedra and the map from the frame of `b` to that of `a`.
#[derive(Clone, Copy)]
pub(super) struct Pair<'p> {
    pub a: &'p Polyhedron,
    pub b: &'p Polyhedron,
    pub b_to_a: &'p Similarity,
}

/// Which features make an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    FaceOfA(usize),
    FaceOfB(usize),
    Edges(usize, usize),
}

/// An axis, the unit normal from `a` to `b` in the frame of `a`, and the separation along it (negative: overlap).
#[derive(Clone, Copy, Debug)]
pub(super) struct Separation {
    pub axis: Axis,
    pub normal: Vec3,
    pub distance: f64,
}

impl Axis {
    const KIND_SHIFT: u32 = 30;

    /// As a hint; never 0, which is "no hint".
    fn code(self) -> u32 {
        match self {
            Self::FaceOfA(f) => (1 << Self::KIND_SHIFT) | f as u32,
            Self::FaceOfB(f) => (2 << Self::KIND_SHIFT) | f as u32,
            Self::Edges(e, f) => (3 << Self::KIND_SHIFT) | ((e as u32) << 15) | f as u32,
        }
    }

    fn from_code(code: u32) -> Option<Self> {
        let index = (code & ((1 << Self::KIND_SHIFT) - 1)) as usize;
        match code >> Self::KIND_SHIFT {
            1 => Some(Self::FaceOfA(index)),
            2 => Some(Self::FaceOfB(index)),
            3 => Some(Self::Edges(index >> 15, index & 0x7fff)),
            _ => None,
        }
    }
}

impl Pair<'_> {
    /// The axis of largest separation, or `None` if some axis separates the parts (which `hint` then remembers).
    ///
    /// The hint is tried first with the very same arithmetic, so it saves time and never changes an answer.
    pub fn deepest(&self, size: f64, hint: &mut u32) -> Option<Separation> {
        if self.separated_by_hint(*hint) {
            return None;
        }
        let found = self.search(size);
        *hint = if found.distance > 0.0 { found.axis.code() } else { 0 };
        (found.distance <= 0.0).then_some(found)
    }

    fn separated_by_hint(&self, hint: u32) -> bool {
        match Axis::from_code(hint) {
            Some(Axis::FaceOfA(f)) => f < self.a.faces().len() && self.face_of_a(f) > 0.0,
            Some(Axis::FaceOfB(f)) => f < self.b.faces().len() && self.face_of_b(f).1 > 0.0,
            Some(Axis::Edges(e, f)) => {
                let known = e < self.a.edges().len() && f < self.b.edges().len();
                known && self.edge_pair(&self.edge_of_a(e), &self.b.edges()[f], 0.0).is_some()
            }
            None => false,
        }
    }

    /// The deepest axis, or the first that separates.
    fn search(&self, size: f64) -> Separation {
        let mut of_a = (0, f64::MIN);
        for f in 0..self.a.faces().len() {
            let distance = self.face_of_a(f);
            if distance > of_a.1 {
                of_a = (f, distance);
                if distance > 0.0 {
                    break;
                }
            }
        }
        let normal = self.a.faces()[of_a.0].normal;
        let mut best = Separation { axis: Axis::FaceOfA(of_a.0), normal, distance: of_a.1 };
        if best.distance > 0.0 {
            return best;
        }
        let tolerance = FACE_PREFERENCE * size;
        let mut to_beat = best.distance + tolerance;
        for f in 0..self.b.faces().len() {
            let (outwards, distance) = self.face_of_b(f);
            if distance > to_beat || distance > 0.0 {
                best = Separation { axis: Axis::FaceOfB(f), normal: -outwards, distance };
                if distance > 0.0 {
                    return best;
                }
                to_beat = distance;
            }
        }
        self.search_edges(best, tolerance)
    }

    fn search_edges(&self, mut best: Separation, tolerance: f64) -> Separation {
        // beyond zero every axis counts: touching by less than the tolerance must not hide a gap
        let mut to_beat = (best.distance + tolerance).min(0.0);
        let mut sides = [0.0; CACHED_FACES];
        let cached = self.b.faces().len() <= CACHED_FACES;
        for i in 0..self.a.edges().len() {
            let edge = self.edge_of_a(i);
            if cached {
                for (side, f) in sides.iter_mut().zip(self.b.faces()) {
                    *side = f.normal.dot(&edge.direction);
                }
            }
            for (j, other) in self.b.edges().iter().enumerate() {
                // most pairs end here: the edge of b is not on the outline seen along the edge of a
                if cached && sides[other.faces[0] as usize] * sides[other.faces[1] as usize] >= 0.0 {
                    continue;
                }
                if let Some((normal, distance)) = self.edge_pair(&edge, other, to_beat) {
                    best = Separation { axis: Axis::Edges(i, j), normal, distance };
                    if distance > 0.0 {
                        return best;
                    }
                    to_beat = distance;
                }
            }
        }
        best
    }

    #[inline]
    fn face_of_a(&self, face: usize) -> f64 {
        let f = &self.a.faces()[face];
        let along = self.b_to_a.inverse_direction(&f.normal);
        self.b_to_a.scale * lowest(self.b, &along) + (f.normal.dot(&self.b_to_a.translation) - f.offset)
    }

    /// Outward normal in the frame of `a`, and separation along it.
    #[inline]
    fn face_of_b(&self, face: usize) -> (Vec3, f64) {
        let f = &self.b.faces()[face];
        let outwards = self.b_to_a.direction(&f.normal);
        let distance = lowest(self.a, &outwards) - (outwards.dot(&self.b_to_a.translation) + self.b_to_a.scale * f.offset);
        (outwards, distance)
    }

    fn edge_of_a(&self, edge: usize) -> EdgeInB {
        let e = &self.a.edges()[edge];
        let start = self.a.vertices()[e.vertices[0] as usize] - self.b_to_a.translation;
        EdgeInB {
            direction: self.b_to_a.inverse_direction(&e.direction),
            normals: e.faces.map(|f| self.b_to_a.inverse_direction(&self.a.faces()[f as usize].normal)),
            start: self.b_to_a.inverse_direction(&start),
        }
    }

    /// Normal (in the frame of `a`) and separation of an edge pair, if it is a face of the Minkowski difference and
    /// separates by more than `to_beat`.
    #[inline]
    fn edge_pair(&self, a: &EdgeInB, b: &Edge, to_beat: f64) -> Option<(Vec3, f64)> {
        let faces = self.b.faces();
        let [c, d] = b.faces.map(|f| &faces[f as usize].normal);
        if c.dot(&a.direction) * d.dot(&a.direction) >= 0.0 {
            return None;
        }
        if a.normals[0].dot(&b.direction) * a.normals[1].dot(&b.direction) >= 0.0 {
            return None;
        }
        // each arc crosses the great circle of the other one; on the same side of the sphere?
        let cross = a.direction.cross(&b.direction);
        let outwards = cross.dot(&(a.normals[0] + a.normals[1]));
        if outwards * cross.dot(&(c + d)) >= 0.0 {
            return None;
        }
        let length = cross.norm();
        if length <= PARALLEL {
            return None;
        }
        let normal = cross * (if outwards > 0.0 { 1.0 } else { -1.0 } / length);
        let vertex = &self.b.vertices()[b.vertices[0] as usize];
        if self.b_to_a.scale * normal.dot(vertex) - normal.dot(&a.start) <= to_beat {
            return None;
        }
        let in_a = self.b_to_a.direction(&normal);
        let highest_of_a = -lowest(self.a, &-in_a);
        let distance = self.b_to_a.scale * lowest(self.b, &normal) + (in_a.dot(&self.b_to_a.translation) - highest_of_a);
        (distance > to_beat).then_some((in_a, distance))
    }
}

/// An edge of `a` in axes of `b`; lengths stay in the unit of `a`, from the origin of `b`.
struct EdgeInB {
    direction: Vec3,
    normals: [Vec3; 2],
    start: Vec3,
}

/// Least height of a polyhedron along a direction.
#[inline]
fn lowest(p: &Polyhedron, along: &Vec3) -> f64 {
    let mut least = f64::MAX;
    for v in p.vertices() {
        let height = along.dot(v);
        least = if height < least { height } else { least };
    }
    least
}
