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

impl FeatureScratch {
    /// Puts the vertices of `b` into the frame of `a`.
    pub(super) fn place(&mut self, pair: &FeaturePair<'_>) {
        self.vertices_b.clear();
        self.vertices_b.extend(pair.b.vertices().iter().map(|v| pair.b_to_a.point(v)));
    }

    pub(super) fn set_heights(&mut self, pair: &FeaturePair<'_>, axis: &Vec3) {
        self.heights_a.clear();
        self.heights_a.extend(pair.a.vertices().iter().map(|x| axis.dot(x)));
        self.heights_b.clear();
        self.heights_b.extend(self.vertices_b.iter().map(|x| axis.dot(x)));
    }
}

impl FeaturePair<'_> {
    /// How far a direction separates the skeletons: directions are turned, not vertices placed.
    #[inline]
    fn gap(&self, along: &Vec3) -> f64 {
        let seen_from_b = self.b_to_a.inverse_direction(along);
        let lowest_of_b =
            along.dot(&self.b_to_a.translation) + self.b_to_a.scale * lowest(self.b.vertices(), &seen_from_b);
        lowest_of_b + lowest(self.a.vertices(), &-along)
    }

    /// The best of the line of centres and all face normals, in both senses where faces have no outside.
    pub(super) fn most_separating(&self) -> SeparatingAxis {
        let mut best = SeparatingAxis { direction: Vec3::x(), distance: f64::MIN };
        let mut offer = |direction: Vec3| {
            let distance = self.gap(&direction);
            if distance > best.distance {
                best = SeparatingAxis { direction, distance };
            }
        };
        if let Some(along) = self.between().try_normalize(0.0) {
            offer(along);
        }
        for face in self.a.faces() {
            offer(face.normal);
            if !self.a.is_convex() {
                offer(-face.normal);
            }
        }
        for face in self.b.faces() {
            let along = self.b_to_a.direction(&face.normal);
            offer(-along);
            if !self.b.is_convex() {
                offer(along);
            }
        }
        best
    }

    /// From the middle of `a` to that of `b`.
    #[inline]
    fn between(&self) -> Vec3 {
        self.b_to_a.point(&self.b.middle) - self.a.middle
    }

    /// Whether the surfaces are provably more than `gap` apart. False means nothing: of the axes only those are asked
    /// that promise something.
    pub fn apart_by(&self, gap: f64) -> bool {
        let enough = self.radius() + gap;
        let between = self.between();
        if !self.a.is_convex() || !self.b.is_convex() {
            return self.most_separating().distance > enough;
        }
        let (to_a, scale) = (self.b_to_a, self.b_to_a.scale);
        let by_a = self.a.faces().iter().filter(|face| face.normal.dot(&between) > 0.0).any(|face| {
            let lowest_of_b = scale * lowest(self.b.vertices(), &to_a.inverse_direction(&face.normal));
            face.normal.dot(&to_a.translation) + lowest_of_b - face.offset > enough
        });
        let (seen_from_b, origin_of_a) = (-to_a.inverse_direction(&between), to_a.inverse_point(&Vec3::zeros()));
        by_a || self.b.faces().iter().filter(|face| face.normal.dot(&seen_from_b) > 0.0).any(|face| {
            let lowest_of_a = lowest(self.a.vertices(), &to_a.direction(&face.normal)) / scale;
            scale * (face.normal.dot(&origin_of_a) + lowest_of_a - face.offset) > enough
        })
    }
}
