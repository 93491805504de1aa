//! The separating-axis test of two convex polyhedra: the direction in which they are deepest apart or least overlapped.
//!
//! Candidates are all face normals, and of the edge pairs those whose arcs cross on the Gauss map: only they are
//! faces of the Minkowski difference. Every candidate of an edge pair is measured again with the full supports, which
//! for any direction give a lower bound of the signed distance. A direction blurred by nearly parallel edges can
//! therefore lose, but never win wrongly.

use crate::math::{Similarity, Vec3};
use crate::shape::{Edge, Parallels, Polyhedron};

/// An edge axis must beat the faces by this, over the size of the pair: rounding must not turn a face contact, which
/// has several points, into an edge contact, which has one.
const FACE_PREFERENCE: f64 = 1e-12;
/// Edges whose unit directions have a smaller cross product are parallel, and their faces cover them.
const PARALLEL: f64 = 1e-14;
/// Up to so many faces (and 64 edges), signs on the Gauss map are kept as bits.
const MOST_FACES: usize = 32;

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

    /// Whether some axis separates the parts by more than `gap`: faces first, they are cheap and mostly enough.
    pub fn separated_by(&self, gap: f64) -> bool {
        (0..self.a.faces().len()).any(|f| self.face_of_a(f) > gap)
            || (0..self.b.faces().len()).any(|f| self.face_of_b(f).1 > gap)
            || (0..self.a.edges().len()).any(|e| {
                let edge = self.edge_of_a(e);
                self.b.edges().iter().any(|other| self.edge_pair(&edge, other, gap).is_some())
            })
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

    fn search_edges(&self, best: Separation, tolerance: f64) -> Separation {
        // beyond zero every axis counts: touching by less than the tolerance must not hide a gap
        let to_beat = (best.distance + tolerance).min(0.0);
        let few = |p: &Polyhedron| p.faces().len() <= MOST_FACES && !p.parallel_edges().is_empty();
        if few(self.a) && few(self.b) {
            self.search_few_edges(best, to_beat)
        } else {
            self.search_all_edges(best, to_beat)
        }
    }

    fn search_all_edges(&self, mut best: Separation, mut to_beat: f64) -> Separation {
        for i in 0..self.a.edges().len() {
            let edge = self.edge_of_a(i);
            for (j, other) in self.b.edges().iter().enumerate() {
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

    /// As above, with the signs of all edges of `b` against a face of `a` in one word, and the other way round.
    fn search_few_edges(&self, mut best: Separation, mut to_beat: f64) -> Separation {
        let mut normals = [Vec3::zeros(); MOST_FACES];
        let mut against = [Signs::default(); MOST_FACES];
        for ((normal, signs), face) in normals.iter_mut().zip(&mut against).zip(self.a.faces()) {
            *normal = self.b_to_a.inverse_direction(&face.normal);
            *signs = Signs::of(self.b.parallel_edges(), normal);
        }
        for set in self.a.parallel_edges() {
            let direction = self.b_to_a.inverse_direction(&set.direction);
            let along = Signs::of(self.b.parallel_faces(), &direction);
            for i in bits(set.along | set.against) {
                let e = &self.a.edges()[i];
                let [f, g] = e.faces.map(|f| f as usize);
                let mut candidates = bits(against[f].opposite(&against[g])).peekable();
                if candidates.peek().is_none() {
                    continue;
                }
                let direction = if set.along >> i & 1 == 1 { direction } else { -direction };
                let edge = self.edge_in_b(e, direction, [normals[f], normals[g]]);
                for j in candidates {
                    let other = &self.b.edges()[j];
                    if !along.differ(other.faces) {
                        continue;
                    }
                    if let Some((normal, distance)) = self.crossing_arcs(&edge, other, to_beat) {
                        best = Separation { axis: Axis::Edges(i, j), normal, distance };
                        if distance > 0.0 {
                            return best;
                        }
                        to_beat = distance;
                    }
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
        let distance =
            lowest(self.a, &outwards) - (outwards.dot(&self.b_to_a.translation) + self.b_to_a.scale * f.offset);
        (outwards, distance)
    }

    fn edge_of_a(&self, edge: usize) -> EdgeInB {
        let e = &self.a.edges()[edge];
        let normals = e.faces.map(|f| self.b_to_a.inverse_direction(&self.a.faces()[f as usize].normal));
        self.edge_in_b(e, self.b_to_a.inverse_direction(&e.direction), normals)
    }

    fn edge_in_b(&self, e: &Edge, direction: Vec3, normals: [Vec3; 2]) -> EdgeInB {
        let start = self.a.vertices()[e.vertices[0] as usize] - self.b_to_a.translation;
        EdgeInB { direction, normals, start: self.b_to_a.inverse_direction(&start) }
    }

    /// Normal (in the frame of `a`) and separation of an edge pair, if it is a face of the Minkowski difference and
    /// separates by more than `to_beat`.
    fn edge_pair(&self, a: &EdgeInB, b: &Edge, to_beat: f64) -> Option<(Vec3, f64)> {
        let along_a = b.faces.map(|f| self.b.faces()[f as usize].normal.dot(&a.direction));
        let along_b = a.normals.map(|n| n.dot(&b.direction));
        let opposite = |[x, y]: [f64; 2]| (x > 0.0 && y < 0.0) || (x < 0.0 && y > 0.0);
        if opposite(along_a) && opposite(along_b) { self.crossing_arcs(a, b, to_beat) } else { None }
    }

    /// The same once each arc is known to cross the great circle of the other one.
    #[inline]
    fn crossing_arcs(&self, a: &EdgeInB, b: &Edge, to_beat: f64) -> Option<(Vec3, f64)> {
        let cross = a.direction.cross(&b.direction);
        let outwards = cross.dot(&(a.normals[0] + a.normals[1]));
        let [c, d] = b.faces.map(|f| &self.b.faces()[f as usize].normal);
        if outwards * cross.dot(&(c + d)) >= 0.0 {
            return None;
        }
        let cross = if outwards > 0.0 { cross } else { -cross };
        let length2 = cross.norm_squared();
        let vertex = &self.b.vertices()[b.vertices[0] as usize];
        let apart = self.b_to_a.scale * cross.dot(vertex) - cross.dot(&a.start);
        // apart / length > to_beat, without the root: most pairs end here
        if length2 <= PARALLEL * PARALLEL || (apart <= 0.0 && apart * apart >= to_beat * to_beat * length2) {
            return None;
        }
        let normal = cross / length2.sqrt();
        let in_a = self.b_to_a.direction(&normal);
        let highest_of_a = -lowest(self.a, &-in_a);
        let distance =
            self.b_to_a.scale * lowest(self.b, &normal) + (in_a.dot(&self.b_to_a.translation) - highest_of_a);
        (distance > to_beat).then_some((in_a, distance))
    }
}

/// Which of up to 64 products are positive and which negative.
#[derive(Clone, Copy, Default)]
struct Signs {
    positive: u64,
    negative: u64,
}

impl Signs {
    /// Of the products of directions with `v`. A direction and its opposite have opposite products to the last bit.
    fn of(directions: &[Parallels], v: &Vec3) -> Self {
        let mut new = Self::default();
        for set in directions {
            let x = set.direction.dot(v);
            if x > 0.0 {
                new.positive |= set.along;
                new.negative |= set.against;
            } else if x < 0.0 {
                new.positive |= set.against;
                new.negative |= set.along;
            }
        }
        new
    }

    /// Places at which the two have opposite signs.
    fn opposite(&self, other: &Self) -> u64 {
        (self.positive & other.negative) | (self.negative & other.positive)
    }

    /// Whether the numbers at two places have opposite signs.
    fn differ(&self, [i, j]: [u32; 2]) -> bool {
        ((self.positive >> i) & (self.negative >> j) | (self.negative >> i) & (self.positive >> j)) & 1 == 1
    }
}

/// An edge of `a` in axes of `b`; lengths stay in the unit of `a`, from the origin of `b`.
struct EdgeInB {
    direction: Vec3,
    normals: [Vec3; 2],
    start: Vec3,
}

/// Places of the bits that are set, in ascending order.
fn bits(mut word: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = (word != 0).then(|| word.trailing_zeros() as usize);
        word &= word.wrapping_sub(1);
        place
    })
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
