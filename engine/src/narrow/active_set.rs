//! What the separating-axis test may skip, and why: the features that can matter while a pair has moved little.
//!
//! At a full test the cache stores the relative pose and either a separation s0, or all features that may decide any
//! pose within half a window w of motion. With the bound mu on the motion since (every point of `b` in the frame of `a`,
//! and every plane of either on the other, has moved by at most mu):
//!
//! - **Separated**: while mu < s0 nothing touches.
//! - **Active**: while 2 mu <= w, the deepest axis is among the faces with s >= s0 - w and the edge pairs whose segments
//!   are at most w + max(-s0, d0) apart, d0 >= the distance of the parts if they were apart. For the deepest axis of
//!   touching parts meets the Minkowski difference inside its face: an edge pair's segments are just as far apart as it
//!   is deep. And parts that have come apart by d have a separating axis among the features next to their closest
//!   points, whose segments are d apart. Edge pairs whose arcs cannot cross on the Gauss map after so small a turn are
//!   left out as well.
//!
//! Of pairs with a cylinder it keeps the gap, or that they touched and how deep: then mu tells how far they can have come
//! apart, and features that are farther from each other than that and than the depth need not be looked at.
//!
//! The active features go through the arithmetic of the full test in its order, so the answer is the same to the bit
//! (PHYSICS.md A.1; the tests drop caches at random).

use super::closest::segment_segment;
use super::separating_axis::{EdgeInB, Pair, Separation};
use crate::math::{Mat3, Similarity, Vec3};
use crate::shape::Part;

/// Window over the radius of the smaller part. Wider: fewer full tests, more active features.
const WINDOW: f64 = 0.04;
/// Edge pairs kept; with more of them all are tested.
const MOST_EDGE_PAIRS: usize = 32;
/// Faces kept as bits, edges in a byte.
const MOST_FACES: usize = 32;
const MOST_EDGES: usize = 256;
/// Relative slack of all comparisons, far above rounding and far below any window.
const SLACK: f64 = 1e-9;

/// What a cache knows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Knowledge {
    /// Nothing.
    #[default]
    Nothing,
    /// The parts were `separation` apart.
    Separated,
    /// Parts of other kinds touched, `-separation` deep.
    Touching,
    /// The features listed decide.
    Active,
    /// Too many features for a list: all are tested.
    TooMany,
}

/// Kept per pair of polyhedra or cylinders from step to step; start with the default.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairCache {
    rotation: Mat3,
    translation: Vec3,
    /// Lever of rotations, s0, and w, in the unit of `a`.
    reach: f64,
    separation: f64,
    window: f64,
    faces_a: u32,
    faces_b: u32,
    /// Edge of `a` times 256 plus edge of `b`, in the order of the full test.
    edge_pairs: [u16; MOST_EDGE_PAIRS],
    edge_pair_count: u8,
    knowledge: Knowledge,
}

/// Sizes of a pair in the unit of `a`.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairSize {
    /// Radius of the smaller part.
    pub smaller: f64,
    /// Sum of the radii.
    pub sum: f64,
    /// Farthest point of each part from the origin of its body.
    pub reach_a: f64,
    pub reach_b: f64,
}

impl PairCache {
    /// Whether there is anything to carry over a rebuild of the neighbour list.
    pub fn knows_something(&self) -> bool {
        self.knowledge != Knowledge::Nothing
    }

    /// Bound on the motion since the full test.
    fn motion(&self, b_to_a: &Similarity) -> f64 {
        let turned = (b_to_a.rotation - self.rotation).norm_squared() * 0.5;
        (b_to_a.translation - self.translation).norm() + turned.sqrt() * self.reach
    }

    /// Whether the parts have been found so far apart that their motion since cannot have closed the gap: for parts of
    /// any kind.
    pub(super) fn are_apart(&self, b_to_a: &Similarity) -> bool {
        self.knowledge == Knowledge::Separated && self.motion(b_to_a) * (1.0 + SLACK) < self.separation * (1.0 - SLACK)
    }

    /// How far parts of any kind can be apart, in the unit of `a`: parts that touched were so deep in each other that they
    /// cannot have come apart by more than what their motion since leaves of it. Infinite where nothing is known.
    pub(super) fn apart_at_most(&self, b_to_a: &Similarity) -> f64 {
        if self.knowledge != Knowledge::Touching {
            return f64::INFINITY;
        }
        (self.motion(b_to_a) * (1.0 + SLACK) + self.separation).max(0.0)
    }

    /// Remembers what a full test has found of parts of any kind: a gap, or minus the depth of parts that touch, in the unit
    /// of `a`.
    pub(super) fn learn(&mut self, separation: f64, (a, b): (&Part, &Part), b_to_a: &Similarity) {
        // as long as what is known proves that they touch there is nothing to be gained
        if separation < 0.0 && self.apart_at_most(b_to_a) == 0.0 {
            return;
        }
        let reach = |part: &Part| part.center.norm() + part.radius;
        self.rotation = b_to_a.rotation;
        self.translation = b_to_a.translation;
        self.reach = (reach(b) * b_to_a.scale).max(reach(a) + self.translation.norm());
        let slack = SLACK * self.reach;
        if separation < 0.0 {
            self.separation = (separation + slack).min(0.0);
            self.knowledge = Knowledge::Touching;
        } else {
            self.separation = separation - slack;
            self.knowledge = Knowledge::Separated;
        }
    }

    /// The deepest axis, or `None` if some axis separates the parts: that of the full test, to the bit.
    pub(super) fn deepest(&mut self, pair: &Pair<'_>, size: &PairSize) -> Option<Separation> {
        let touching = |found: Separation| (found.distance <= 0.0).then_some(found);
        let moved = self.motion(pair.b_to_a) * (1.0 + SLACK) + SLACK * self.window;
        let in_window = 2.0 * moved <= self.window;
        match self.knowledge {
            Knowledge::Separated if moved < self.separation => return None,
            Knowledge::Active if in_window => {
                let edge_pairs = &self.edge_pairs[..self.edge_pair_count as usize];
                return touching(pair.search_among(self.faces_a, self.faces_b, edge_pairs, size.sum));
            }
            Knowledge::TooMany if in_window => return touching(pair.search(size.sum)),
            _ => {}
        }
        let found = pair.search(size.sum);
        self.renew(pair, found.distance, size);
        touching(found)
    }

    /// Learns from a full test that found an axis of this separation.
    fn renew(&mut self, pair: &Pair<'_>, found: f64, size: &PairSize) {
        self.rotation = pair.b_to_a.rotation;
        self.translation = pair.b_to_a.translation;
        self.window = WINDOW * size.smaller;
        self.reach = size.reach_b.max(size.reach_a + self.translation.norm());
        let (n_a, n_b) = (pair.a.faces().len(), pair.b.faces().len());
        let few = n_a.max(n_b) <= MOST_FACES && pair.a.edges().len().max(pair.b.edges().len()) <= MOST_EDGES;
        if !few {
            self.separation = found;
            self.knowledge = if found > 0.0 { Knowledge::Separated } else { Knowledge::TooMany };
            return;
        }
        let mut of_a = [0.0; MOST_FACES];
        let mut of_b = [0.0; MOST_FACES];
        let mut best = found;
        for (face, distance) in of_a[..n_a].iter_mut().enumerate() {
            *distance = pair.face_of_a(face);
            best = best.max(*distance);
        }
        for (face, distance) in of_b[..n_b].iter_mut().enumerate() {
            *distance = pair.face_of_b(face).1;
            best = best.max(*distance);
        }
        self.separation = best;
        if best > 0.5 * self.window {
            self.knowledge = Knowledge::Separated;
            return;
        }
        let least = best - self.window * (1.0 + SLACK);
        let among = |distances: &[f64]| {
            distances.iter().enumerate().fold(0, |bits, (face, &d)| bits | u32::from(d >= least) << face)
        };
        self.faces_a = among(&of_a[..n_a]);
        self.faces_b = among(&of_b[..n_b]);
        self.list_edge_pairs(pair);
    }

    fn list_edge_pairs(&mut self, pair: &Pair<'_>) {
        // The largest turn within half a window.
        let turn = 0.5 * self.window / self.reach * (1.0 + SLACK) + SLACK * SLACK;
        let mut near = [(0u16, 0.0f64); 4 * MOST_EDGE_PAIRS];
        let mut count = 0;
        let mut closest = f64::INFINITY;
        for i in pair.edges_of_a_in_order() {
            let edge = pair.edge_of_a(i);
            let ends = pair.segment_of_a(i);
            let (middle, half) = middle_and_half(&ends);
            for (j, other) in pair.b.edges().iter().enumerate() {
                if !pair.may_cross(&edge, other, turn) {
                    continue;
                }
                let other = pair.segment_of_b(other);
                let (other_middle, other_half) = middle_and_half(&other);
                let beyond = closest + self.window * (1.0 + SLACK) - self.separation.min(0.0);
                if (other_middle - middle).norm() - half - other_half > beyond / pair.b_to_a.scale {
                    continue;
                }
                let (x, y) = segment_segment(&ends, &other);
                let distance = (y - x).norm() * pair.b_to_a.scale;
                closest = closest.min(distance);
                if distance > beyond {
                    // Beyond the bound below, whichever it will be.
                    continue;
                }
                if count == near.len() {
                    self.knowledge = Knowledge::TooMany;
                    return;
                }
                near[count] = ((i << 8 | j) as u16, distance);
                count += 1;
            }
        }
        let apart = if self.separation > 0.0 { closest } else { -self.separation };
        let farthest = apart + self.window * (1.0 + SLACK);
        self.edge_pair_count = 0;
        for &(code, _) in near[..count].iter().filter(|(_, distance)| *distance <= farthest) {
            if self.edge_pair_count as usize == MOST_EDGE_PAIRS {
                self.knowledge = Knowledge::TooMany;
                return;
            }
            self.edge_pairs[self.edge_pair_count as usize] = code;
            self.edge_pair_count += 1;
        }
        self.knowledge = Knowledge::Active;
    }
}

fn middle_and_half(ends: &[Vec3; 2]) -> (Vec3, f64) {
    ((ends[0] + ends[1]) * 0.5, 0.5 * (ends[1] - ends[0]).norm())
}

impl Pair<'_> {
    /// Ends of an edge of `a`, in the axes and unit of `b`.
    fn segment_of_a(&self, edge: usize) -> [Vec3; 2] {
        self.a.edges()[edge].vertices.map(|v| self.b_to_a.inverse_point(&self.a.vertices()[v as usize]))
    }

    fn segment_of_b(&self, edge: &crate::shape::Edge) -> [Vec3; 2] {
        edge.vertices.map(|v| self.b.vertices()[v as usize])
    }

    /// Whether the arcs of two edges may cross on the Gauss map once the parts have turned by less than `turn`.
    fn may_cross(&self, a: &EdgeInB, b: &crate::shape::Edge, turn: f64) -> bool {
        let may_be_opposite = |x: f64, y: f64| !((x > turn && y > turn) || (x < -turn && y < -turn));
        let [x, y] = a.normals.map(|n| n.dot(&b.direction));
        if !may_be_opposite(x, y) {
            return false;
        }
        let [x, y] = b.faces.map(|f| self.b.faces()[f as usize].normal.dot(&a.direction));
        may_be_opposite(x, y)
    }
}
