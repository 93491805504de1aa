//! The common outline of two faces seen along the contact normal: one face clipped by the sides of the other.

use crate::math::Vec3;

/// A corner of a polygon across the normal, and its height along it.
#[derive(Clone, Copy, Debug, PartialEq)]
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

impl Corner {
    /// Squared distance across the normal.
    pub fn lateral2(&self, other: &Self) -> f64 {
        let (x, y) = (self.x - other.x, self.y - other.y);
        x * x + y * y
    }

    /// Squared distance in space.
    pub fn distance2(&self, other: &Self) -> f64 {
        let height = self.height - other.height;
        self.lateral2(other) + height * height
    }
}

/// Axes across the contact normal, from the first vertex of the reference face.
pub(super) struct Frame {
    pub normal: Vec3,
    origin: Vec3,
    x: Vec3,
    y: Vec3,
    /// How the reference face rises along x and y; zero if the normal is its own.
    slope: [f64; 2],
}

impl Frame {
    /// `x` is a unit vector across the normal.
    pub fn new(normal: Vec3, origin: Vec3, x: Vec3) -> Self {
        Self { normal, origin, x, y: normal.cross(&x), slope: [0.0; 2] }
    }

    /// With a reference face of another normal than the contact.
    pub fn sloping(mut self, face_normal: &Vec3) -> Self {
        let rise = -1.0 / face_normal.dot(&self.normal);
        self.slope = [face_normal.dot(&self.x) * rise, face_normal.dot(&self.y) * rise];
        self
    }

    pub fn corner(&self, point: &Vec3, side: Side) -> Corner {
        let d = point - self.origin;
        Corner { x: self.x.dot(&d), y: self.y.dot(&d), height: self.normal.dot(&d), side }
    }

    /// How far a corner lies below the plane of the reference face, along the normal.
    pub fn overlap(&self, corner: &Corner) -> f64 {
        self.slope[0] * corner.x + self.slope[1] * corner.y - corner.height
    }

    /// The point over a corner at a given height.
    pub fn point(&self, corner: &Corner, height: f64) -> Vec3 {
        self.origin + self.x * corner.x + self.y * corner.y + self.normal * height
    }
}

/// Corners in a fixed buffer. A face clipped by one of m vertices gains at most m.
#[derive(Clone)]
pub(super) struct Polygon<const N: usize> {
    corners: [Corner; N],
    len: usize,
}

impl<const N: usize> Polygon<N> {
    pub fn new(corners: impl Iterator<Item = Corner>) -> Self {
        let blank = Corner { x: 0.0, y: 0.0, height: 0.0, side: Side::Incident(0) };
        let mut new = Self { corners: [blank; N], len: 0 };
        for c in corners {
            new.push(c);
        }
        new
    }

    pub fn corners(&self) -> &[Corner] {
        &self.corners[..self.len]
    }

    fn push(&mut self, corner: Corner) {
        if self.len < N {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }
}

/// Clips by the sides of a counter-clockwise reference polygon (Sutherland and Hodgman 1974).
///
/// A corner outside by at most `near` stays: sides that coincide but for rounding would otherwise cross anywhere.
pub(super) fn clip<const N: usize>(incident: &Polygon<N>, reference: &[Corner], near: f64) -> Polygon<N> {
    let mut polygon = incident.clone();
    let mut clipped = incident.clone();
    let mut inside = [0.0; N];
    for (k, from) in reference.iter().enumerate() {
        let to = &reference[if k + 1 == reference.len() { 0 } else { k + 1 }];
        let (ex, ey) = (to.x - from.x, to.y - from.y);
        let slack = near * (ex * ex + ey * ey).sqrt();
        let mut all_inside = true;
        for (d, c) in inside.iter_mut().zip(polygon.corners()) {
            *d = ex * (c.y - from.y) - ey * (c.x - from.x);
            if *d < 0.0 && *d >= -slack {
                *d = 0.0;
            }
            all_inside &= *d >= 0.0;
        }
        if !all_inside {
            clip_by_side(&polygon, &inside, Side::Reference(k as u8), &mut clipped);
            std::mem::swap(&mut polygon, &mut clipped);
        }
    }
    polygon
}

fn clip_by_side<const N: usize>(polygon: &Polygon<N>, inside: &[f64; N], side: Side, clipped: &mut Polygon<N>) {
    clipped.len = 0;
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
}

fn crossing(from: &Corner, to: &Corner, inside_from: f64, inside_to: f64, side: Side) -> Corner {
    let s = inside_from / (inside_from - inside_to);
    let mix = |a: f64, b: f64| a + s * (b - a);
    Corner { x: mix(from.x, to.x), y: mix(from.y, to.y), height: mix(from.height, to.height), side }
}
