//! What a narrow-phase test answers: contact points with their own normals, in the frame of `a`.

use crate::math::{Similarity, Vec3};

/// Most points that one pair of parts may have; shapes with larger faces are refused when they are built.
pub const MAX_POINTS: usize = 64;

/// Names the pair of features that a contact point lies on, the same whichever part was the reference.
///
/// Kept from step to step, it is what the tangential spring is carried by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct FeatureKey(pub u32);

impl FeatureKey {
    const KIND_SHIFT: u32 = 30;

    /// The one point of a pair of smooth parts (or the k-th of several).
    pub const fn point(k: u32) -> Self {
        Self(k)
    }

    /// A vertex of `a` on a face of `b`.
    pub const fn vertex_of_a(vertex: u32) -> Self {
        Self((1 << Self::KIND_SHIFT) | vertex)
    }

    /// A vertex of `b` on a face of `a`.
    pub const fn vertex_of_b(vertex: u32) -> Self {
        Self((2 << Self::KIND_SHIFT) | vertex)
    }

    /// An edge of `a` crossing an edge of `b` (both below 2^15).
    pub const fn edges(edge_a: u32, edge_b: u32) -> Self {
        Self((3 << Self::KIND_SHIFT) | (edge_a << 15) | edge_b)
    }

    /// A vertex of `a` on a face of `b` (both below 2^14), where a vertex may touch several faces.
    pub const fn vertex_of_a_on_face(vertex: u32, face: u32) -> Self {
        Self::vertex_of_a((vertex << 15) | face)
    }

    /// A vertex of `b` on a face of `a`.
    pub const fn vertex_of_b_on_face(vertex: u32, face: u32) -> Self {
        Self::vertex_of_b((vertex << 15) | face)
    }

    /// Two vertices (both below 2^14).
    pub const fn vertices(vertex_a: u32, vertex_b: u32) -> Self {
        Self((vertex_a << 14) | vertex_b)
    }

    /// A vertex of `a` at an edge of `b` (both below 2^14).
    pub const fn vertex_of_a_at_edge(vertex: u32, edge: u32) -> Self {
        Self((1 << 28) | (vertex << 14) | edge)
    }

    /// A vertex of `b` at an edge of `a`.
    pub const fn vertex_of_b_at_edge(vertex: u32, edge: u32) -> Self {
        Self((2 << 28) | (vertex << 14) | edge)
    }

    /// The same pair of features when the parts change their roles.
    pub const fn swapped(self) -> Self {
        let payload = self.0 & ((1 << Self::KIND_SHIFT) - 1);
        match self.kind() {
            1 => Self::vertex_of_b(payload),
            2 => Self::vertex_of_a(payload),
            3 => Self::edges(payload & 0x7fff, payload >> 15),
            _ => self,
        }
    }

    /// 0 point, 1 vertex of a, 2 vertex of b, 3 edge pair.
    pub const fn kind(self) -> u32 {
        self.0 >> Self::KIND_SHIFT
    }
}

/// One contact point. Lengths in the unit of the frame of `a`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldPoint {
    /// Halfway between the two surfaces, in the frame of `a`.
    pub position: Vec3,
    /// Unit normal from `a` to `b`, in the frame of `a`.
    pub normal: Vec3,
    /// Positive when touching.
    pub overlap: f64,
    /// Tributary length (or 1 where there is none): a face contact's points share by it, continuous in the pose.
    pub share: f64,
    /// Which features touch.
    pub feature: FeatureKey,
}

/// The points of one pair of parts; a fixed buffer, reused without allocation.
#[derive(Clone, Debug)]
pub struct Manifold {
    points: [ManifoldPoint; MAX_POINTS],
    len: usize,
}

impl Default for Manifold {
    fn default() -> Self {
        let empty = ManifoldPoint {
            position: Vec3::zeros(),
            normal: Vec3::zeros(),
            overlap: 0.0,
            share: 0.0,
            feature: FeatureKey(0),
        };
        Self { points: [empty; MAX_POINTS], len: 0 }
    }
}

impl Manifold {
    /// Forgets all points.
    #[inline]
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// The points.
    #[inline]
    pub fn points(&self) -> &[ManifoldPoint] {
        &self.points[..self.len]
    }

    /// The points, to be changed in place.
    #[inline]
    pub fn points_mut(&mut self) -> &mut [ManifoldPoint] {
        &mut self.points[..self.len]
    }

    /// Number of points.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether nothing touches.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Drops those of the points from index `first` on that do not fit.
    pub(crate) fn retain_from(&mut self, first: usize, fits: impl Fn(&ManifoldPoint) -> bool) {
        let mut kept = first;
        for k in first..self.len {
            if fits(&self.points[k]) {
                self.points[kept] = self.points[k];
                kept += 1;
            }
        }
        self.len = kept;
    }

    /// Carries the points from index `first` on into another frame.
    pub(crate) fn map_from(&mut self, first: usize, to: &Similarity) {
        for p in &mut self.points[first..self.len] {
            p.position = to.point(&p.position);
            p.normal = to.direction(&p.normal);
            p.overlap *= to.scale;
            p.share *= to.scale;
        }
    }

    /// Changes the roles of `a` and `b` for the points from index `first` on.
    pub(crate) fn flip_from(&mut self, first: usize) {
        for p in &mut self.points[first..self.len] {
            p.normal = -p.normal;
            p.feature = p.feature.swapped();
        }
    }

    /// Adds a point; in a full buffer it takes the place of the shallowest point if it is deeper.
    ///
    /// For walls, where any number of vertices of a finely faceted part may touch at once.
    pub fn push_deepest(&mut self, point: ManifoldPoint) {
        if self.len < MAX_POINTS {
            return self.push(point);
        }
        let mut shallowest = 0;
        for (i, p) in self.points.iter().enumerate() {
            if p.overlap < self.points[shallowest].overlap {
                shallowest = i;
            }
        }
        if point.overlap > self.points[shallowest].overlap {
            self.points[shallowest] = point;
        }
    }

    /// Adds a point; beyond [`MAX_POINTS`] (which shapes exclude) it is dropped.
    #[inline]
    pub fn push(&mut self, point: ManifoldPoint) {
        if self.len < MAX_POINTS {
            self.points[self.len] = point;
            self.len += 1;
        }
    }
}
