//! Which terms of a pair may matter: a list that is valid while the pair has moved little.

use super::pair::{TermCode, TermKind};
use super::{RoundedPair, Term};
use crate::math::{Similarity, Vec3};
use crate::narrow::segment_segment;

/// Width of the list over the smaller inner diameter: how far a pair moves until it is listed anew.
const WINDOW: f64 = 0.005;
/// Rounding that the bound allows for, over the size of the pair.
const ROUNDING: f64 = 1e-12;

/// The terms of a pair that may overlap within a window of relative motion.
///
/// Every distance of a vertex from a core and of two edges changes by at most
/// mu = |t - t0| + ||R - R0||_F / sqrt(2) reach_b when `b` moves from (R0, t0) to (R, t) in the frame of `a`. So a term
/// that was further than R + window away does not overlap while mu <= window: leaving it out changes no bit.
#[derive(Clone, Debug)]
pub struct ActiveTerms {
    valid: bool,
    window: f64,
    pose: Similarity,
    terms: Vec<TermCode>,
}

impl Default for ActiveTerms {
    fn default() -> Self {
        Self { valid: false, window: 0.0, pose: Similarity::identity(), terms: Vec::new() }
    }
}

/// Buffers of one task.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    heights_a: Vec<f64>,
    heights_b: Vec<f64>,
    vertices_b: Vec<Vec3>,
}

impl ActiveTerms {
    /// Makes the next use list the terms anew.
    pub fn forget(&mut self) {
        self.valid = false;
    }

    /// Whether it holds a list.
    pub fn knows_something(&self) -> bool {
        self.valid
    }

    /// Writes the overlapping terms of the pair into `out`, in the order of their codes.
    #[inline]
    pub fn evaluate(&mut self, pair: &RoundedPair<'_>, scratch: &mut Scratch, out: &mut Vec<Term>) {
        out.clear();
        if !(self.valid && self.motion(pair) <= self.window) {
            self.list(pair, scratch);
        }
        out.extend(self.terms.iter().filter_map(|&code| pair.term(code)));
    }

    /// Listed terms.
    pub fn len(&self) -> usize {
        self.terms.len()
    }

    /// Whether nothing can overlap within the window.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    /// Bound on how far any point of `b` has moved in the frame of `a` since the list was made.
    #[inline]
    fn motion(&self, pair: &RoundedPair<'_>) -> f64 {
        let turned = (pair.b_to_a.rotation - self.pose.rotation).norm_squared();
        let shift = (pair.b_to_a.translation - self.pose.translation).norm();
        shift + (0.5 * turned).sqrt() * (pair.b.reach * pair.b_to_a.scale)
    }

    fn list(&mut self, pair: &RoundedPair<'_>, scratch: &mut Scratch) {
        self.terms.clear();
        self.pose = *pair.b_to_a;
        self.valid = true;
        let scale = pair.b_to_a.scale;
        let rounding = ROUNDING * (pair.a.reach + pair.b.reach * scale + pair.b_to_a.translation.norm());
        let axis = scratch.most_separating(pair);
        let window = WINDOW * pair.a.size.min(pair.b.size * scale);
        // no term is closer than the cores, and these not closer than any axis says
        self.window = window.max(axis.distance - pair.radius()) - rounding;
        if axis.distance > pair.radius() + window {
            return;
        }
        let reach = pair.radius() + window + rounding;
        scratch.set_heights(pair, &axis.direction);
        self.list_vertices(pair, scratch, reach);
        self.list_edges(pair, scratch, reach);
    }

    fn list_vertices(&mut self, pair: &RoundedPair<'_>, scratch: &Scratch, reach: f64) {
        let highest_of_a = scratch.heights_a.iter().copied().fold(f64::MIN, f64::max);
        let lowest_of_b = scratch.heights_b.iter().copied().fold(f64::MAX, f64::min);
        for (v, y) in scratch.vertices_b.iter().enumerate() {
            if scratch.heights_b[v] - highest_of_a <= reach && pair.a.project(y).1 <= reach {
                self.terms.push(TermCode::vertex_of_b(v));
            }
        }
        for (v, x) in pair.a.solid().vertices().iter().enumerate() {
            let near = lowest_of_b - scratch.heights_a[v] <= reach;
            if near && pair.b.project(&pair.b_to_a.inverse_point(x)).1 * pair.b_to_a.scale <= reach {
                self.terms.push(TermCode::vertex_of_a(v));
            }
        }
    }

    fn list_edges(&mut self, pair: &RoundedPair<'_>, scratch: &Scratch, reach: f64) {
        for (e, edge_a) in pair.a.solid().edges().iter().enumerate() {
            let highest = edge_a.vertices.map(|v| scratch.heights_a[v as usize]);
            let highest = highest[0].max(highest[1]);
            let ends_a = pair.a.edge(e);
            for (f, edge_b) in pair.b.solid().edges().iter().enumerate() {
                let [low, other] = edge_b.vertices.map(|v| scratch.heights_b[v as usize]);
                if low.min(other) - highest > reach {
                    continue;
                }
                let ends_b = edge_b.vertices.map(|v| scratch.vertices_b[v as usize]);
                let (x, y) = segment_segment(&ends_a, &ends_b);
                if (y - x).norm_squared() <= reach * reach {
                    self.terms.push(TermCode::edges(e, f));
                }
            }
        }
    }
}

/// A direction from `a` to `b` and how far it separates the cores: a lower bound of their distance.
struct SeparatingAxis {
    direction: Vec3,
    distance: f64,
}

impl Scratch {
    /// The best of all face normals; leaves the vertices of `b` in the frame of `a` behind.
    fn most_separating(&mut self, pair: &RoundedPair<'_>) -> SeparatingAxis {
        self.vertices_b.clear();
        self.vertices_b.extend(pair.b.solid().vertices().iter().map(|v| pair.b_to_a.point(v)));
        let mut best = SeparatingAxis { direction: Vec3::x(), distance: f64::MIN };
        let lowest = |points: &[Vec3], along: &Vec3| points.iter().map(|x| along.dot(x)).fold(f64::MAX, f64::min);
        for face in pair.a.solid().faces() {
            let distance = lowest(&self.vertices_b, &face.normal) - face.offset;
            if distance > best.distance {
                best = SeparatingAxis { direction: face.normal, distance };
            }
        }
        for face in pair.b.solid().faces() {
            let outwards = pair.b_to_a.direction(&face.normal);
            let offset = outwards.dot(&pair.b_to_a.translation) + pair.b_to_a.scale * face.offset;
            let distance = lowest(pair.a.solid().vertices(), &outwards) - offset;
            if distance > best.distance {
                best = SeparatingAxis { direction: -outwards, distance };
            }
        }
        best
    }

    fn set_heights(&mut self, pair: &RoundedPair<'_>, axis: &Vec3) {
        self.heights_a.clear();
        self.heights_a.extend(pair.a.solid().vertices().iter().map(|x| axis.dot(x)));
        self.heights_b.clear();
        self.heights_b.extend(self.vertices_b.iter().map(|x| axis.dot(x)));
    }
}

impl RoundedPair<'_> {
    /// All overlapping terms without any list: what the list must reproduce.
    pub fn all_terms(&self, out: &mut Vec<Term>) {
        out.clear();
        let (vertices_a, vertices_b) = (self.a.solid().vertices().len(), self.b.solid().vertices().len());
        let (edges_a, edges_b) = (self.a.solid().edges().len(), self.b.solid().edges().len());
        out.extend((0..vertices_b).filter_map(|v| self.term(TermCode::vertex_of_b(v))));
        out.extend((0..vertices_a).filter_map(|v| self.term(TermCode::vertex_of_a(v))));
        for e in 0..edges_a {
            out.extend((0..edges_b).filter_map(|f| self.term(TermCode::edges(e, f))));
        }
        debug_assert!(matches!(TermCode::edges(1, 2).kind(), TermKind::Edges(1, 2)));
    }
}
