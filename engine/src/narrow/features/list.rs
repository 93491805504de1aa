//! Which pairs of features may touch: a list that is valid while the pair has moved little.

use super::pair::PARALLEL;
use super::{FeatureContact, FeaturePair};
use crate::math::{Mat3, Vec3};
use crate::narrow::{FeatureKey, segment_segment};
use crate::shape::{Skeleton, SkeletonEdge};

/// Width of the list over the smaller reach: how far a pair moves until it is listed anew.
const WINDOW: f64 = 0.005;
/// Rounding that the bound allows for, over the size of the pair.
const ROUNDING: f64 = 1e-12;

/// The pairs of features that may touch within a window of relative motion.
///
/// When `b` moves from (R0, t0) to (R, t) in the frame of `a`, each of its points within `lever` of its origin moves by
/// at most mu = |t - t0| + ||R - R0||_F / sqrt(2) lever there, and so does a point of `a` that near in the frame of `b`.
/// Points that touch are within the reach of `b` and R of its origin. So distances, heights above faces and from their
/// sides change by at most mu: features that were further apart than R + window, or further outside each other's
/// regions than the window, do not touch while mu <= window, and leaving them out changes no bit. Feet on edges move
/// further, by [`Near::foot`].
#[derive(Clone, Debug)]
pub struct FeatureList {
    valid: bool,
    window: f64,
    lever: f64,
    /// Lower bound of the distance of the surfaces at the pose of the list.
    gap: f64,
    rotation: Mat3,
    translation: Vec3,
    features: Vec<FeatureKey>,
}

impl Default for FeatureList {
    fn default() -> Self {
        let (rotation, translation) = (Mat3::zeros(), Vec3::zeros());
        Self { valid: false, window: 0.0, lever: 0.0, gap: 0.0, rotation, translation, features: Vec::new() }
    }
}

/// Buffers of one task.
#[derive(Clone, Debug, Default)]
pub struct FeatureScratch {
    pub(super) heights_a: Vec<f64>,
    pub(super) heights_b: Vec<f64>,
    pub(super) vertices_b: Vec<Vec3>,
}

impl FeatureList {
    /// Makes the next use list the pairs anew.
    pub fn forget(&mut self) {
        self.valid = false;
    }

    /// Whether there is anything to carry over a rebuild of the neighbour list.
    pub fn knows_something(&self) -> bool {
        self.valid
    }

    /// Listed pairs.
    pub fn features(&self) -> &[FeatureKey] {
        &self.features
    }

    /// Makes the list valid for the present pose. Returns a lower bound of the distance of the surfaces there: while
    /// they have not moved by more against each other, nothing touches.
    #[inline]
    pub fn update(&mut self, pair: &FeaturePair<'_>, scratch: &mut FeatureScratch) -> f64 {
        if self.valid {
            let moved = self.motion(pair);
            if moved <= self.window {
                return self.gap - moved;
            }
        }
        self.renew(pair, scratch);
        self.gap
    }

    /// The touching ones among the listed pairs, in their order.
    #[inline]
    pub fn contacts<'s>(
        &'s self,
        pair: &'s FeaturePair<'_>,
    ) -> impl Iterator<Item = (FeatureKey, FeatureContact)> + 's {
        self.features.iter().filter_map(|&feature| Some((feature, pair.contact(feature)?)))
    }

    /// Bound on how far any point of `b` that matters has moved in the frame of `a` since the list was made.
    #[inline(always)]
    fn motion(&self, pair: &FeaturePair<'_>) -> f64 {
        let turned = (pair.b_to_a.rotation - self.rotation).norm_squared();
        let shift = (pair.b_to_a.translation - self.translation).norm_squared();
        shift.sqrt() + (0.5 * turned).sqrt() * self.lever
    }

    fn renew(&mut self, pair: &FeaturePair<'_>, scratch: &mut FeatureScratch) {
        self.features.clear();
        self.rotation = pair.b_to_a.rotation;
        self.translation = pair.b_to_a.translation;
        self.valid = true;
        let (radius, reach_b) = (pair.radius(), pair.b.reach * pair.b_to_a.scale);
        self.lever = reach_b + radius;
        let rounding = ROUNDING * (pair.a.reach + reach_b + radius + self.translation.norm());
        let window = WINDOW * (pair.a.reach + pair.a.radius).min(reach_b + pair.b.radius * pair.b_to_a.scale);
        scratch.place(pair);
        let axis = pair.most_separating();
        // no two features are closer than any axis says
        self.gap = axis.distance - radius - rounding;
        self.window = window.max(axis.distance - radius) - rounding;
        if axis.distance > radius + window {
            return;
        }
        scratch.set_heights(pair, &axis.direction);
        let near = Near { radius, window: window + rounding, lever: self.lever };
        near.list_vertices_of_b(pair, scratch, &mut self.features);
        near.list_vertices_of_a(pair, scratch, &mut self.features);
        near.list_vertex_pairs(pair, scratch, &mut self.features);
        near.list_edges(pair, scratch, &mut self.features);
        self.features.sort_unstable();
    }
}

/// What counts as near when a list is made.
struct Near {
    radius: f64,
    window: f64,
    lever: f64,
}

fn highest(heights: &[f64]) -> f64 {
    heights.iter().copied().fold(f64::MIN, f64::max)
}

impl Near {
    fn reach(&self) -> f64 {
        self.radius + self.window
    }

    /// Largest turn of `b` within the window.
    fn turn(&self) -> f64 {
        // 2 asin(x / 2) < 1.001 x for every x that occurs
        1.001 * self.window / self.lever
    }

    /// How far the foot of a point on a line, `distance` away, may move within the window.
    ///
    /// The gap g becomes g + delta less its component along the new direction: |delta| <= mu, and |(g + delta) . d'|
    /// <= |g| phi + mu.
    fn foot(&self, distance: f64) -> f64 {
        2.0 * self.window + distance * self.turn()
    }

    /// How far the feet of the common perpendicular of two lines, `distance` long, may move within the window: with
    /// unit directions the new foot lies (w . d1 - (w . d2)(d1 . d2)) / sin^2 from the old one, |w . d1| <= mu,
    /// |w . d2| <= distance phi + mu. Feet beyond the lever move further in proportion.
    fn feet(&self, distance: f64, sine: f64, farthest: f64) -> f64 {
        let least_sine = sine - self.turn();
        if least_sine <= 0.0 {
            return f64::INFINITY;
        }
        let moved = self.window * (farthest / self.lever).max(1.0);
        (2.0 * moved + distance * self.turn()) / (least_sine * least_sine)
    }

    fn list_vertices_of_b(&self, pair: &FeaturePair<'_>, scratch: &FeatureScratch, out: &mut Vec<FeatureKey>) {
        let top = highest(&scratch.heights_a);
        for (v, y) in scratch.vertices_b.iter().enumerate() {
            if scratch.heights_b[v] - top > self.reach() {
                continue;
            }
            self.faces_near(pair.a, y, |f| out.push(FeatureKey::vertex_of_b_on_face(v as u32, f)));
            self.edges_near(pair.a, y, |e, gap| {
                let seen_from_b = -pair.b_to_a.inverse_direction(gap);
                if self.may_be_nearest(pair.b, v, &seen_from_b) {
                    out.push(FeatureKey::vertex_of_b_at_edge(v as u32, e));
                }
            });
        }
    }

    fn list_vertices_of_a(&self, pair: &FeaturePair<'_>, scratch: &FeatureScratch, out: &mut Vec<FeatureKey>) {
        let scale = pair.b_to_a.scale;
        let in_b = Self { radius: self.radius / scale, window: self.window / scale, lever: self.lever / scale };
        let bottom = scratch.heights_b.iter().copied().fold(f64::MAX, f64::min);
        for (v, x) in pair.a.vertices().iter().enumerate() {
            if bottom - scratch.heights_a[v] > self.reach() {
                continue;
            }
            let x = pair.b_to_a.inverse_point(x);
            in_b.faces_near(pair.b, &x, |f| out.push(FeatureKey::vertex_of_a_on_face(v as u32, f)));
            in_b.edges_near(pair.b, &x, |e, gap| {
                if self.may_be_nearest(pair.a, v, &(pair.b_to_a.direction(gap) * -scale)) {
                    out.push(FeatureKey::vertex_of_a_at_edge(v as u32, e));
                }
            });
        }
    }

    fn faces_near(&self, skeleton: &Skeleton, x: &Vec3, mut found: impl FnMut(u32)) {
        let behind = if skeleton.is_convex() { skeleton.depth.min(0.5 * self.radius) } else { self.radius };
        let beyond = self.window + skeleton.tolerance;
        for (f, plane) in skeleton.faces().iter().enumerate() {
            let height = plane.normal.dot(x) - plane.offset;
            if height > self.reach() || height < -behind - self.window {
                continue;
            }
            if skeleton.sides(f).iter().all(|s| s.inwards.dot(x) - s.offset >= -beyond) {
                found(f as u32);
            }
        }
    }

    /// Whether a point at `gap` from a vertex may come into the region nearest to it among the edges of its body.
    fn may_be_nearest(&self, skeleton: &Skeleton, vertex: usize, gap: &Vec3) -> bool {
        let beyond = self.foot(gap.norm()) + PARALLEL * self.radius;
        skeleton.directions(vertex).iter().all(|u| u.dot(gap) <= beyond)
    }

    /// Edges that a point may come to lie beside, with the vector from the foot of the point to it.
    fn edges_near(&self, skeleton: &Skeleton, x: &Vec3, mut found: impl FnMut(u32, &Vec3)) {
        for (e, edge) in skeleton.edges().iter().enumerate() {
            let outside = skeleton.sides_at_edge(e).iter().all(|s| s.inwards.dot(x) - s.offset <= self.window);
            if !outside {
                continue;
            }
            let along = (x - edge.start).dot(&edge.along);
            let gap = x - (edge.start + edge.along * (along / edge.length2));
            let distance = gap.norm();
            let beyond = self.foot(distance) * edge.length2.sqrt();
            if distance <= self.reach() && along >= -beyond && along <= edge.length2 + beyond {
                found(e as u32, &gap);
            }
        }
    }

    /// Vertices that are near and may come into each other's regions.
    fn list_vertex_pairs(&self, pair: &FeaturePair<'_>, scratch: &FeatureScratch, out: &mut Vec<FeatureKey>) {
        let (scale, reach2) = (pair.b_to_a.scale, self.reach() * self.reach());
        for (v, x) in pair.a.vertices().iter().enumerate() {
            for (w, y) in scratch.vertices_b.iter().enumerate() {
                let gap = y - x;
                if gap.norm_squared() > reach2 {
                    continue;
                }
                let from_b = pair.b_to_a.inverse_direction(&gap) * (-1.0 / scale);
                let may_be = |skeleton: &Skeleton, vertex: usize, gap: &Vec3, window: f64| {
                    let beyond = window + skeleton.tolerance;
                    skeleton.directions(vertex).iter().all(|u| u.dot(gap) <= beyond)
                };
                if may_be(pair.a, v, &gap, self.window) && may_be(pair.b, w, &from_b, self.window / scale) {
                    out.push(FeatureKey::vertices(v as u32, w as u32));
                }
            }
        }
    }

    /// Whether the feet of the common perpendicular may come to lie inside both edges.
    fn may_cross(&self, e: &SkeletonEdge, ends: &[Vec3; 2], centre_of_b: &Vec3) -> bool {
        let (along, between) = (ends[1] - ends[0], ends[0] - e.start);
        let cross = e.along.cross(&along);
        let den = cross.norm_squared();
        let (length_a, length_b) = (e.length2.sqrt(), along.norm());
        let sine = den.sqrt() / (length_a * length_b);
        if sine <= 2.0 * self.turn() {
            return true;
        }
        let on_a = between.cross(&along).dot(&cross) / den;
        let on_b = between.cross(&e.along).dot(&cross) / den;
        let (x, y) = (e.start + e.along * on_a, ends[0] + along * on_b);
        let farthest = (x - centre_of_b).norm().max((y - centre_of_b).norm());
        let distance = (y - x).norm();
        let beyond = self.feet(distance, sine, farthest);
        let inside = |s: f64, length: f64| s * length >= -beyond && (s - 1.0) * length <= beyond;
        distance <= self.reach() + beyond && inside(on_a, length_a) && inside(on_b, length_b)
    }

    fn list_edges(&self, pair: &FeaturePair<'_>, scratch: &FeatureScratch, out: &mut Vec<FeatureKey>) {
        let reach = self.reach();
        for (f, edge_b) in pair.b.edges().iter().enumerate() {
            let [low, other] = edge_b.vertices.map(|v| scratch.heights_b[v as usize]);
            let low = low.min(other);
            let ends_b = edge_b.vertices.map(|v| scratch.vertices_b[v as usize]);
            for (e, edge_a) in pair.a.edges().iter().enumerate() {
                let [high, other] = edge_a.vertices.map(|v| scratch.heights_a[v as usize]);
                if low - high.max(other) > reach || !self.may_cross(edge_a, &ends_b, &pair.b_to_a.translation) {
                    continue;
                }
                let (x, y) = segment_segment(&[edge_a.start, edge_a.start + edge_a.along], &ends_b);
                if (y - x).norm_squared() <= reach * reach {
                    out.push(FeatureKey::edges(e as u32, f as u32));
                }
            }
        }
    }
}

impl FeaturePair<'_> {
    /// Lists every pair of features: what a list must not change the answer of.
    pub fn all_candidates(&self, list: &mut FeatureList) {
        let count = |skeleton: &Skeleton| {
            [skeleton.vertices().len(), skeleton.edges().len(), skeleton.faces().len()].map(|n| n as u32)
        };
        let ([va, ea, fa], [vb, eb, fb]) = (count(self.a), count(self.b));
        let mut cross = |n: u32, m: u32, key: fn(u32, u32) -> FeatureKey| {
            list.features.extend((0..n).flat_map(|i| (0..m).map(move |j| key(i, j))));
        };
        cross(va, vb, FeatureKey::vertices);
        cross(va, eb, FeatureKey::vertex_of_a_at_edge);
        cross(vb, ea, FeatureKey::vertex_of_b_at_edge);
        cross(va, fb, FeatureKey::vertex_of_a_on_face);
        cross(vb, fa, FeatureKey::vertex_of_b_on_face);
        cross(ea, eb, FeatureKey::edges);
    }
}
