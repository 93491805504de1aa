//! How far face normals and the line of centres separate two skeletons: a lower bound of their distance.

use super::{FeaturePair, FeatureScratch};
use crate::math::Vec3;

/// A direction from `a` to `b` and how far it separates the skeletons.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeparatingAxis {
    pub direction: Vec3,
    pub distance: f64,
}

fn lowest(points: &[Vec3], along: &Vec3) -> f64 {
    points.iter().map(|x| along.dot(x)).fold(f64::MAX, f64::min)
}

fn middle(points: &[Vec3]) -> Vec3 {
    points.iter().sum::<Vec3>() / points.len() as f64
}

impl FeatureScratch {
    /// Puts the vertices of `b` into the frame of `a`.
    pub(super) fn place(&mut self, pair: &FeaturePair<'_>) {
        self.vertices_b.clear();
        self.vertices_b.extend(pair.b.vertices().iter().map(|v| pair.b_to_a.point(v)));
    }

    /// The best of the line of centres and all face normals, in both senses where faces have no outside. Stops at the
    /// first that separates by more than `enough`.
    pub(super) fn most_separating(&self, pair: &FeaturePair<'_>, enough: f64) -> SeparatingAxis {
        let vertices_a = pair.a.vertices();
        let mut best = SeparatingAxis { direction: Vec3::x(), distance: f64::MIN };
        let mut offer = |direction: Vec3, distance: f64| {
            if distance > best.distance {
                best = SeparatingAxis { direction, distance };
            }
            best.distance > enough
        };
        let gap = |along: &Vec3| lowest(&self.vertices_b, along) + lowest(vertices_a, &-along);
        let between = middle(&self.vertices_b) - middle(vertices_a);
        if let Some(along) = between.try_normalize(0.0)
            && offer(along, gap(&along))
        {
            return best;
        }
        for face in pair.a.faces() {
            let done = if pair.a.is_convex() {
                offer(face.normal, lowest(&self.vertices_b, &face.normal) - face.offset - pair.a.tolerance)
            } else {
                offer(face.normal, gap(&face.normal)) || offer(-face.normal, gap(&-face.normal))
            };
            if done {
                return best;
            }
        }
        for face in pair.b.faces() {
            let along = pair.b_to_a.direction(&face.normal);
            let done = offer(-along, gap(&-along)) || (!pair.b.is_convex() && offer(along, gap(&along)));
            if done {
                return best;
            }
        }
        best
    }

    pub(super) fn set_heights(&mut self, pair: &FeaturePair<'_>, axis: &Vec3) {
        self.heights_a.clear();
        self.heights_a.extend(pair.a.vertices().iter().map(|x| axis.dot(x)));
        self.heights_b.clear();
        self.heights_b.extend(self.vertices_b.iter().map(|x| axis.dot(x)));
    }
}

impl FeaturePair<'_> {
    /// Whether the surfaces are provably more than `gap` apart. False means nothing.
    pub fn apart_by(&self, gap: f64) -> bool {
        let mut scratch = FeatureScratch::default();
        scratch.place(self);
        let enough = self.radius() + gap;
        scratch.most_separating(self, enough).distance > enough
    }
}
