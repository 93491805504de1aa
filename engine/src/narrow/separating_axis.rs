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

impl Pair<'_> {
    /// Whether the normal of some face separates the parts by more than `gap`. Edges would find a little more, at ten
    /// times the cost.
    pub fn separated_by(&self, gap: f64) -> bool {
        (0..self.a.faces().len()).any(|f| self.face_of_a(f) > gap)
            || (0..self.b.faces().len()).any(|f| self.face_of_b(f).1 > gap)
    }

    /// The deepest axis, or the first that separates.
    pub fn search(&self, size: f64) -> Separation {
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

    /// The same among some faces (bits) and edge pairs (edge of `a` times 256 plus edge of `b`) in the order of the full
    /// search: the same arithmetic, hence the same bits, if the deepest axis is among them.
    pub fn search_among(&self, faces_a: u32, faces_b: u32, edge_pairs: &[u16], size: f64) -> Separation {
        let mut best = Separation { axis: Axis::FaceOfA(0), normal: Vec3::zeros(), distance: f64::MIN };
        for f in bits(faces_a.into()) {
            let distance = self.face_of_a(f);
            if distance > best.distance {
                best = Separation { axis: Axis::FaceOfA(f), normal: self.a.faces()[f].normal, distance };
            }
        }
        let tolerance = FACE_PREFERENCE * size;
        let mut to_beat = best.distance + tolerance;
        for f in bits(faces_b.into()) {
            let (outwards, distance) = self.face_of_b(f);
            if distance > to_beat {
                best = Separation { axis: Axis::FaceOfB(f), normal: -outwards, distance };
                to_beat = distance;
            }
        }
        if best.distance > 0.0 {
            return best;
        }
        let mut to_beat = (best.distance + tolerance).min(0.0);
        let mut edge = None;
        for &code in edge_pairs {
            let (i, j) = (usize::from(code >> 8), usize::from(code & 0xff));
            let of_a = match &edge {
                Some((known, of_a)) if *known == i => of_a,
                _ => &edge.insert((i, self.edge_of_a(i))).1,
            };
            if let Some((normal, distance)) = self.edge_pair(of_a, &self.b.edges()[j], to_beat) {
                best = Separation { axis: Axis::Edges(i, j), normal, distance };
                if distance > 0.0 {
                    return best;
                }
                to_beat = distance;
            }
        }
        best
    }

    /// Edges of `a` in the order of the full search.
    pub fn edges_of_a_in_order(&self) -> impl Iterator<Item = usize> {
        let in_sets = self.has_few_edges();
        let sets =
            self.a.parallel_edges().iter().filter(move |_| in_sets).flat_map(|set| bits(set.along | set.against));
        sets.chain((0..self.a.edges().len()).filter(move |_| !in_sets))
    }

    fn has_few_edges(&self) -> bool {
        let few = |p: &Polyhedron| p.faces().len() <= MOST_FACES && !p.parallel_edges().is_empty();
        few(self.a) && few(self.b)
    }

    fn search_edges(&self, best: Separation, tolerance: f64) -> Separation {
        // beyond zero every axis counts: touching by less than the tolerance must not hide a gap
        let to_beat = (best.distance + tolerance).min(0.0);
        if self.has_few_edges() { self.search_few_edges(best, to_beat) } else { self.search_all_edges(best, to_beat) }
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
    pub fn face_of_a(&self, face: usize) -> f64 {
        let f = &self.a.faces()[face];
        let along = self.b_to_a.inverse_direction(&f.normal);
        self.b_to_a.scale * lowest(self.b, &along) + (f.normal.dot(&self.b_to_a.translation) - f.offset)
    }

    /// Outward normal in the frame of `a`, and separation along it.
    #[inline]
    pub fn face_of_b(&self, face: usize) -> (Vec3, f64) {
        let f = &self.b.faces()[face];
        let outwards = self.b_to_a.direction(&f.normal);
        let distance =
            lowest(self.a, &outwards) - (outwards.dot(&self.b_to_a.translation) + self.b_to_a.scale * f.offset);
        (outwards, distance)
    }

    pub fn edge_of_a(&self, edge: usize) -> EdgeInB {
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
pub(super) struct EdgeInB {
    pub direction: Vec3,
    pub normals: [Vec3; 2],
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
