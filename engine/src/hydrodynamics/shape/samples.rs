//! Points on the surface of a part, each with the piece of area about it.

use super::table::basis;
use crate::math::Vec3;
use crate::narrow::closest_on_segment;
use crate::shape::{Part, PartGeometry, Polyhedron, Skeleton};
use std::f64::consts::{PI, TAU};

/// Points on a part, roughly.
const POINTS: f64 = 30_000.0;

/// A point.
pub(super) struct Sample {
    pub point: Vec3,
    /// Outwards.
    pub normal: Vec3,
    pub area: f64,
}

/// Makes samples a given distance apart.
struct Sampler {
    spacing: f64,
    samples: Vec<Sample>,
}

/// Points of a part, about [`POINTS`] of them.
pub(super) fn samples_of(part: &Part) -> Vec<Sample> {
    let area = 4.0 * PI * part.radius * part.radius;
    let mut sampler = Sampler { spacing: (area / POINTS).sqrt(), samples: Vec::new() };
    match &part.geometry {
        PartGeometry::Sphere { center, radius } => sampler.ball(center, *radius, |_| true),
        PartGeometry::Spherocylinder { ends, radius } => {
            let axis = ends[1] - ends[0];
            sampler.tube(ends, *radius, None);
            sampler.ball(&ends[0], *radius, |n| n.dot(&axis) < 0.0);
            sampler.ball(&ends[1], *radius, |n| n.dot(&axis) >= 0.0);
        }
        PartGeometry::Cylinder { ends, radius } => {
            let axis = (ends[1] - ends[0]).normalize();
            sampler.tube(ends, *radius, None);
            sampler.disc(&ends[0], &-axis, *radius);
            sampler.disc(&ends[1], &axis, *radius);
        }
        PartGeometry::Polyhedron(p) => sampler.faces(p, 0.0),
        PartGeometry::RoundedPolyhedron(p) => match &p.solid {
            Some(solid) => sampler.rounded(solid, p.skeleton.radius),
            None => sampler.skeleton(&p.skeleton),
        },
    }
    sampler.samples
}

/// Depth below the surface of a swept skeleton, by the nearest of its features; exact outside and inside.
pub(super) fn skeleton_depth(skeleton: &Skeleton, x: &Vec3) -> f64 {
    let segment = |a: &Vec3, b: &Vec3| (x - closest_on_segment(x, a, b).0).norm();
    let mut nearest = skeleton.vertices().iter().map(|v| (x - v).norm()).fold(f64::MAX, f64::min);
    for e in skeleton.edges() {
        nearest = nearest.min(segment(&e.start, &(e.start + e.along)));
    }
    for (f, (face, polygon)) in skeleton.faces().iter().zip(skeleton.loops()).enumerate() {
        if skeleton.sides(f).iter().all(|s| s.inwards.dot(x) >= s.offset) {
            nearest = nearest.min((face.normal.dot(x) - face.offset).abs());
        }
        for (k, &v) in polygon.iter().enumerate() {
            let next = polygon[(k + 1) % polygon.len()];
            nearest = nearest.min(segment(&skeleton.vertices()[v as usize], &skeleton.vertices()[next as usize]));
        }
    }
    skeleton.radius - nearest
}

impl Sampler {
    fn count(&self, length: f64) -> usize {
        ((length / self.spacing).ceil() as usize).max(4)
    }

    /// Rings of equal height have equal areas (Archimedes).
    fn ball(&mut self, center: &Vec3, radius: f64, keep: impl Fn(&Vec3) -> bool) {
        let rings = self.count(2.0 * radius);
        let around = self.count(TAU * radius);
        let area = 4.0 * PI * radius * radius / (rings * around) as f64;
        for i in 0..rings {
            let z = 2.0 * (i as f64 + 0.5) / rings as f64 - 1.0;
            let r = (1.0 - z * z).sqrt();
            for j in 0..around {
                let (sine, cosine) = (TAU * (j as f64 + 0.5) / around as f64).sin_cos();
                let normal = Vec3::new(r * cosine, r * sine, z);
                if keep(&normal) {
                    self.samples.push(Sample { point: center + normal * radius, normal, area });
                }
            }
        }
    }

    /// The side of a cylinder, all around or between two normals.
    fn tube(&mut self, ends: &[Vec3; 2], radius: f64, between: Option<[Vec3; 2]>) {
        let axis = ends[1] - ends[0];
        let length = axis.norm();
        if length == 0.0 {
            return;
        }
        let (p, q, angle) = match between {
            None => {
                let (p, q) = basis(&(axis / length));
                (p, q, TAU)
            }
            Some([m, n]) => {
                let across = n - m * m.dot(&n);
                let sine = across.norm();
                if sine == 0.0 {
                    return;
                }
                (m, across / sine, sine.atan2(m.dot(&n)))
            }
        };
        let (along, around) = (self.count(length), self.count(angle * radius));
        let area = angle * radius * length / (along * around) as f64;
        for j in 0..around {
            let (sine, cosine) = (angle * (j as f64 + 0.5) / around as f64).sin_cos();
            let normal = p * cosine + q * sine;
            for i in 0..along {
                let point = ends[0] + axis * ((i as f64 + 0.5) / along as f64) + normal * radius;
                self.samples.push(Sample { point, normal, area });
            }
        }
    }

    fn disc(&mut self, center: &Vec3, normal: &Vec3, radius: f64) {
        let (p, q) = basis(normal);
        let (rings, around) = (self.count(radius), self.count(PI * radius));
        let area = PI * radius * radius / (rings * around) as f64;
        for i in 0..rings {
            let r = radius * ((i as f64 + 0.5) / rings as f64).sqrt();
            for j in 0..around {
                let (sine, cosine) = (TAU * (j as f64 + 0.5) / around as f64).sin_cos();
                let point = center + (p * cosine + q * sine) * r;
                self.samples.push(Sample { point, normal: *normal, area });
            }
        }
    }

    /// A convex polygon, moved along its normal: triangles about its first corner, each halved along its sides.
    fn polygon(&mut self, corners: &[Vec3], normal: &Vec3, shift: f64) {
        for w in corners.windows(2).skip(1) {
            let (a, u, v) = (corners[0] + normal * shift, w[0] - corners[0], w[1] - corners[0]);
            let n = self.count(u.norm().max(v.norm()).max((v - u).norm()));
            let area = 0.5 * u.cross(&v).norm() / (n * n) as f64;
            for i in 0..n {
                for j in 0..2 * (n - i) - 1 {
                    // upright triangles at even j, the others point down
                    let (row, third) = (j / 2, if j % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 });
                    let point = a + u * ((i as f64 + third) / n as f64) + v * ((row as f64 + third) / n as f64);
                    self.samples.push(Sample { point, normal: *normal, area });
                }
            }
        }
    }

    fn faces(&mut self, solid: &Polyhedron, shift: f64) {
        for (f, face) in solid.faces().iter().enumerate() {
            let corners: Vec<Vec3> = solid.face_vertices(f).iter().map(|&v| solid.vertices()[v as usize]).collect();
            self.polygon(&corners, &face.normal, shift);
        }
    }

    fn rounded(&mut self, solid: &Polyhedron, radius: f64) {
        self.faces(solid, radius);
        let at = |v: u32| solid.vertices()[v as usize];
        for e in solid.edges() {
            let normals = e.faces.map(|f| solid.faces()[f as usize].normal);
            self.tube(&e.vertices.map(at), radius, Some(normals));
        }
        for v in 0..solid.vertices().len() as u32 {
            let leaving: Vec<Vec3> = solid
                .edges()
                .iter()
                .filter(|e| e.vertices.contains(&v))
                .map(|e| at(e.vertices[0]) + at(e.vertices[1]) - at(v) * 2.0)
                .collect();
            self.ball(&at(v), radius, |n| leaving.iter().all(|e| n.dot(e) < 0.0));
        }
    }

    fn skeleton(&mut self, skeleton: &Skeleton) {
        let radius = skeleton.radius;
        for (face, polygon) in skeleton.faces().iter().zip(skeleton.loops()) {
            let corners: Vec<Vec3> = polygon.iter().map(|&v| skeleton.vertices()[v as usize]).collect();
            self.polygon(&corners, &face.normal, radius);
            self.polygon(&corners, &-face.normal, radius);
        }
        for e in skeleton.edges() {
            self.tube(&[e.start, e.start + e.along], radius, None);
        }
        for v in skeleton.vertices() {
            self.ball(v, radius, |_| true);
        }
    }
}
