//! Two skeletons in a pose, and whether two of their features touch.

use crate::math::{Similarity, Vec3};
use crate::narrow::FeatureKey;
use crate::shape::{Skeleton, SkeletonEdge};

/// Squared sine below which edges count as parallel: their common perpendicular is rounding, their vertices cover them.
const PARALLEL2: f64 = 1e-12;
/// The same for the region of a vertex: it must hold where parallel edges are left to their ends.
pub(super) const PARALLEL: f64 = 1e-6;
/// Feet this close to an end of an edge, over its length, belong to the vertex.
const END: f64 = 1e-9;

/// Two skeletons; lengths in the unit of `a`, everything in its frame.
#[derive(Clone, Copy)]
pub struct FeaturePair<'p> {
    /// Of the particle with the lower id.
    pub a: &'p Skeleton,
    /// Of the other one.
    pub b: &'p Skeleton,
    /// Pose of `b`.
    pub b_to_a: &'p Similarity,
}

/// One touching pair of features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeatureContact {
    /// r_a + r_b - distance, positive.
    pub overlap: f64,
    /// Unit, from `a` to `b`.
    pub normal: Vec3,
    /// Halfway between the surfaces.
    pub position: Vec3,
}

impl FeaturePair<'_> {
    /// R = r_a + r_b.
    #[inline(always)]
    pub fn radius(&self) -> f64 {
        self.a.radius + self.b.radius * self.b_to_a.scale
    }

    /// The contact of a pair of features, if they touch.
    #[inline(always)]
    pub fn contact(&self, feature: FeatureKey) -> Option<FeatureContact> {
        let payload = feature.0 as usize & 0x3fff_ffff;
        let (vertex, face) = (payload >> 15, payload & 0x7fff);
        match feature.kind() {
            1 => self.vertex_of_a_on_face(vertex, face),
            2 => self.vertex_of_b_on_face(vertex, face),
            3 => self.edges(vertex, face),
            _ => {
                let (first, second) = (payload >> 14 & 0x3fff, payload & 0x3fff);
                match payload >> 28 {
                    1 => self.vertex_of_a_at_edge(first, second),
                    2 => self.vertex_of_b_at_edge(first, second),
                    _ => self.vertices(first, second),
                }
            }
        }
    }

    /// From the point `on_a` of the skeleton of `a`, the normal and the distance.
    #[inline(always)]
    fn at(&self, on_a: &Vec3, normal: Vec3, distance: f64) -> FeatureContact {
        let overlap = self.radius() - distance;
        FeatureContact { overlap, normal, position: on_a + normal * (self.a.radius - 0.5 * overlap) }
    }

    #[inline(always)]
    fn vertex_of_b_on_face(&self, vertex: usize, face: usize) -> Option<FeatureContact> {
        let x = self.b_to_a.point(&self.b.vertices()[vertex]);
        let (normal, distance) = above(self.a, face, &x, self.radius())?;
        Some(self.at(&(x - normal * distance), normal, distance))
    }

    #[inline(always)]
    fn vertex_of_a_on_face(&self, vertex: usize, face: usize) -> Option<FeatureContact> {
        let x = self.a.vertices()[vertex];
        let radius = self.radius() / self.b_to_a.scale;
        let (normal, distance) = above(self.b, face, &self.b_to_a.inverse_point(&x), radius)?;
        Some(self.at(&x, -self.b_to_a.direction(&normal), distance * self.b_to_a.scale))
    }

    fn vertex_of_b_at_edge(&self, vertex: usize, edge: usize) -> Option<FeatureContact> {
        let x = self.b_to_a.point(&self.b.vertices()[vertex]);
        let (foot, gap) = beside(self.a, edge, &x, self.radius())?;
        let seen_from_b = -self.b_to_a.inverse_direction(&gap);
        is_nearest_in_its_body(self.b, vertex, &seen_from_b, self.radius()).then(|| self.along(&foot, &gap))
    }

    fn vertex_of_a_at_edge(&self, vertex: usize, edge: usize) -> Option<FeatureContact> {
        let x = self.a.vertices()[vertex];
        let (_, gap) = beside(self.b, edge, &self.b_to_a.inverse_point(&x), self.radius() / self.b_to_a.scale)?;
        let gap = self.b_to_a.direction(&gap) * -self.b_to_a.scale;
        is_nearest_in_its_body(self.a, vertex, &gap, self.radius()).then(|| self.along(&x, &gap))
    }

    /// From a point of `a`, along the vector to one of `b`.
    fn along(&self, on_a: &Vec3, gap: &Vec3) -> FeatureContact {
        let distance = gap.norm();
        // coincident points have no direction of their own: any fixed one separates them
        let normal = if distance > 0.0 { gap / distance } else { Vec3::z() };
        self.at(on_a, normal, distance)
    }

    fn vertices(&self, vertex_a: usize, vertex_b: usize) -> Option<FeatureContact> {
        let x = self.a.vertices()[vertex_a];
        let gap = self.b_to_a.point(&self.b.vertices()[vertex_b]) - x;
        let (radius, scale) = (self.radius(), self.b_to_a.scale);
        if gap.norm_squared() >= radius * radius {
            return None;
        }
        let seen_from_b = self.b_to_a.inverse_direction(&gap) * (-1.0 / scale);
        let nearest = is_vertex_nearest(self.a, vertex_a, &gap, radius)
            && is_vertex_nearest(self.b, vertex_b, &seen_from_b, radius / scale);
        nearest.then(|| self.along(&x, &gap))
    }

    #[inline(always)]
    fn edges(&self, edge_a: usize, edge_b: usize) -> Option<FeatureContact> {
        let (e, f) = (&self.a.edges()[edge_a], &self.b.edges()[edge_b]);
        let start = self.b_to_a.point(&f.start);
        let along = self.b_to_a.direction(&f.along) * self.b_to_a.scale;
        let cross = e.along.cross(&along);
        let den = cross.norm_squared();
        let between = start - e.start;
        let height = between.dot(&cross);
        let radius = self.radius();
        // by triple products: differences of dot products lose digits on nearly parallel lines
        if height * height >= radius * radius * den {
            return None;
        }
        let on_a = between.cross(&along).dot(&cross);
        let on_b = between.cross(&e.along).dot(&cross);
        let (low, high) = (END * den, (1.0 - END) * den);
        if !(on_a > low && on_a < high && on_b > low && on_b < high) {
            return None;
        }
        let lengths2 = e.length2 * f.length2 * (self.b_to_a.scale * self.b_to_a.scale);
        if den <= PARALLEL2 * lengths2 {
            return None;
        }
        let sine = den.sqrt();
        let normal = cross * (height.signum() / sine);
        Some(self.at(&(e.start + e.along * (on_a / den)), normal, height.abs() / sine))
    }
}

/// The direction from a face to a point above it, and their distance below `radius`.
///
/// Faces of a closed convex skeleton have an outside, and a point that has got a little inside it is pushed back through
/// the nearest; others are two-sided.
#[inline(always)]
fn above(skeleton: &Skeleton, face: usize, x: &Vec3, radius: f64) -> Option<(Vec3, f64)> {
    let plane = &skeleton.faces()[face];
    let height = plane.normal.dot(x) - plane.offset;
    if height >= radius || height <= if skeleton.is_convex() { -skeleton.depth.min(0.5 * radius) } else { -radius } {
        return None;
    }
    if height < 0.0 && skeleton.is_convex() && skeleton.faces().iter().any(|f| f.normal.dot(x) - f.offset > height) {
        return None;
    }
    let inside = skeleton.sides(face).iter().all(|s| s.inwards.dot(x) - s.offset >= -skeleton.tolerance);
    if !inside {
        return None;
    }
    let behind = height < 0.0 && !skeleton.is_convex();
    Some(if behind { (-plane.normal, -height) } else { (plane.normal, height) })
}

/// The foot of a point on an edge strictly inside it, and the vector from there, if shorter than `radius` and outside
/// the faces that meet in the edge.
fn beside(skeleton: &Skeleton, edge: usize, x: &Vec3, radius: f64) -> Option<(Vec3, Vec3)> {
    let SkeletonEdge { start, along, length2, .. } = &skeleton.edges()[edge];
    let s = (x - start).dot(along) / length2;
    if !(s > END && s < 1.0 - END) {
        return None;
    }
    let foot = start + along * s;
    let gap = x - foot;
    if gap.norm_squared() >= radius * radius {
        return None;
    }
    let outside = skeleton.sides_at_edge(edge).iter().all(|s| s.inwards.dot(x) - s.offset < -skeleton.tolerance);
    outside.then_some((foot, gap))
}

/// Whether the point at `gap` from a vertex is nearer to the vertex than to any of its edges.
fn is_nearest_in_its_body(skeleton: &Skeleton, vertex: usize, gap: &Vec3, radius: f64) -> bool {
    skeleton.directions(vertex).iter().all(|u| u.dot(gap) <= PARALLEL * radius)
}

/// The same for another vertex, which may lie exactly beside the end of an edge, but not above a face.
fn is_vertex_nearest(skeleton: &Skeleton, vertex: usize, gap: &Vec3, radius: f64) -> bool {
    let x = skeleton.vertices()[vertex] + gap;
    skeleton.directions(vertex).iter().all(|u| u.dot(gap) <= skeleton.tolerance)
        && skeleton.faces_at(vertex).iter().all(|&f| above(skeleton, f as usize, &x, radius).is_none())
}
