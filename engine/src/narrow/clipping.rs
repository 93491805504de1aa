//! The lateral polygon of a face contact: the incident face, clipped by the side planes of the reference face.

use crate::math::Vec3;
use crate::narrow::MAX_POINTS;
use crate::shape::MAX_FACE_VERTICES;

/// A corner of the polygon in the plane of the reference face, and its height above it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Corner {
    pub x: f64,
    pub y: f64,
    pub height: f64,
    /// The polygon side from this corner to the next.
    pub side: Side,
}

/// Where a side of the polygon comes from; indices count within the face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Incident(u8),
    Reference(u8),
}

impl Default for Side {
    fn default() -> Self {
        Self::Incident(0)
    }
}

/// A face as a list of points, without allocation.
#[derive(Clone, Copy)]
pub(super) struct FaceLoop {
    points: [Vec3; MAX_FACE_VERTICES],
    len: usize,
}

impl FaceLoop {
    pub fn new(points: impl Iterator<Item = Vec3>) -> Self {
        let mut new = Self { points: [Vec3::zeros(); MAX_FACE_VERTICES], len: 0 };
        for p in points {
            new.points[new.len] = p;
            new.len += 1;
        }
        new
    }

    pub fn points(&self) -> &[Vec3] {
        &self.points[..self.len]
    }
}

/// Axes in the plane of the reference face, from its first vertex.
pub(super) struct Frame {
    pub origin: Vec3,
    pub normal: Vec3,
    x: Vec3,
    y: Vec3,
}

impl Frame {
    pub fn new(normal: Vec3, points: &[Vec3]) -> Self {
        let x = (points[1] - points[0]).normalize();
        Self { origin: points[0], normal, x, y: normal.cross(&x) }
    }

    pub fn corner(&self, point: &Vec3, side: Side) -> Corner {
        let d = point - self.origin;
        Corner { x: self.x.dot(&d), y: self.y.dot(&d), height: self.normal.dot(&d), side }
    }

    /// The point over a corner at a given height.
    pub fn point(&self, corner: &Corner, height: f64) -> Vec3 {
        self.origin + self.x * corner.x + self.y * corner.y + self.normal * height
    }
}

/// Corners with a fixed buffer; a face of m vertices adds at most m to those of the other.
pub(super) struct Polygon {
    corners: [Corner; MAX_POINTS],
    len: usize,
}

impl Polygon {
    pub fn empty() -> Self {
        Self { corners: [Corner::default(); MAX_POINTS], len: 0 }
    }

    pub fn corners(&self) -> &[Corner] {
        &self.corners[..self.len]
    }

    pub fn push(&mut self, corner: Corner) {
        if self.len < MAX_POINTS {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }
}

/// Clips in place by the sides of a counter-clockwise reference polygon (Sutherland and Hodgman 1974).
pub(super) fn clip(polygon: &mut Polygon, reference: &[Corner]) {
    let mut inside = [0.0; MAX_POINTS];
    for (k, from) in reference.iter().enumerate() {
        let to = &reference[if k + 1 == reference.len() { 0 } else { k + 1 }];
        let (ex, ey) = (to.x - from.x, to.y - from.y);
        let mut all_inside = true;
        for (d, c) in inside.iter_mut().zip(polygon.corners()) {
            *d = ex * (c.y - from.y) - ey * (c.x - from.x);
            all_inside &= *d >= 0.0;
        }
        if all_inside {
            continue;
        }
        clip_by_side(polygon, &inside, Side::Reference(k as u8));
    }
}

fn clip_by_side(polygon: &mut Polygon, inside: &[f64; MAX_POINTS], side: Side) {
    let mut clipped = Polygon::empty();
    for i in 0..polygon.len {
        let j = if i + 1 == polygon.len { 0 } else { i + 1 };
        let (from, to) = (&polygon.corners[i], &polygon.corners[j]);
        if inside[i] >= 0.0 {
            clipped.push(*from);
            if inside[j] < 0.0 {
                clipped.push(crossing(from, to, inside[i], inside[j], side));
            }
        } else if inside[j] >= 0.0 {
            clipped.push(crossing(from, to, inside[i], inside[j], from.side));
        }
    }
    *polygon = clipped;
}

fn crossing(from: &Corner, to: &Corner, inside_from: f64, inside_to: f64, side: Side) -> Corner {
    let s = inside_from / (inside_from - inside_to);
    let mix = |a: f64, b: f64| a + s * (b - a);
    Corner { x: mix(from.x, to.x), y: mix(from.y, to.y), height: mix(from.height, to.height), side }
}
