//! Triangles for drawing.

use super::{Part, PartGeometry, Skeleton};
use crate::math::Vec3;
use std::f64::consts::{PI, TAU};

/// Meridians and parallels (per half ball) of round surfaces: a silhouette error below 1 % of the radius.
const MERIDIANS: u32 = 24;
const PARALLELS: u32 = 6;

/// A triangulated surface in the body frame; triangles counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMesh {
    /// Points.
    pub vertices: Vec<Vec3>,
    /// Indices into the points.
    pub triangles: Vec<[u32; 3]>,
}

impl SurfaceMesh {
    /// The parts one after the other; where they overlap, inner triangles stay.
    pub(crate) fn of_parts(parts: &[Part]) -> Self {
        let mut mesh = Self::default();
        for part in parts {
            match &part.geometry {
                PartGeometry::Sphere { center, radius } => mesh.add_capsule(&[*center, *center], *radius),
                PartGeometry::Spherocylinder { ends, radius } => mesh.add_capsule(ends, *radius),
                PartGeometry::Cylinder { ends, radius } => mesh.add_cylinder(ends, *radius),
                PartGeometry::RoundedPolyhedron(p) => mesh.add_skeleton(&p.skeleton),
                PartGeometry::Polyhedron(p) => {
                    let base = mesh.vertices.len() as u32;
                    mesh.vertices.extend_from_slice(p.vertices());
                    for f in 0..p.faces().len() {
                        let v = p.face_vertices(f);
                        mesh.triangles.extend(v.windows(2).skip(1).map(|w| [base + v[0], base + w[0], base + w[1]]));
                    }
                }
            }
        }
        mesh
    }

    /// A capsule about each edge, and each face moved outwards to both sides by the radius.
    fn add_skeleton(&mut self, skeleton: &Skeleton) {
        for e in skeleton.edges() {
            self.add_capsule(&[e.start, e.start + e.along], skeleton.radius);
        }
        for (face, polygon) in skeleton.faces().iter().zip(skeleton.loops()) {
            for sense in [1.0, -1.0] {
                if sense < 0.0 && skeleton.is_convex() {
                    continue;
                }
                let base = self.vertices.len() as u32;
                let shift = face.normal * (sense * skeleton.radius);
                self.vertices.extend(polygon.iter().map(|&v| skeleton.vertices()[v as usize] + shift));
                for k in 1..polygon.len() as u32 - 1 {
                    let (p, q) = if sense > 0.0 { (k, k + 1) } else { (k + 1, k) };
                    self.triangles.push([base, base + p, base + q]);
                }
            }
        }
    }

    /// A prism inscribed in the cylinder.
    fn add_cylinder(&mut self, ends: &[Vec3; 2], radius: f64) {
        let axis = (ends[1] - ends[0]).normalize();
        let across = axis.cross(&Vec3::ith(axis.iamin(), 1.0)).normalize();
        let third = axis.cross(&across);
        let base = self.vertices.len() as u32;
        self.vertices.extend_from_slice(ends);
        for m in 0..MERIDIANS {
            let (sin, cos) = (TAU * f64::from(m) / f64::from(MERIDIANS)).sin_cos();
            let outwards = (across * cos + third * sin) * radius;
            self.vertices.extend(ends.map(|end| end + outwards));
        }
        for m in 0..MERIDIANS {
            let [low, high] = [base + 2 + 2 * m, base + 3 + 2 * m];
            let next = base + 2 + 2 * ((m + 1) % MERIDIANS);
            self.triangles.push([base, next, low]);
            self.triangles.push([base + 1, high, next + 1]);
            self.triangles.push([low, next, next + 1]);
            self.triangles.push([low, next + 1, high]);
        }
    }

    fn add_capsule(&mut self, ends: &[Vec3; 2], radius: f64) {
        let axis = (ends[1] - ends[0]).try_normalize(0.0).unwrap_or_else(Vec3::x);
        let across = axis.cross(&Vec3::ith(axis.iamin(), 1.0)).normalize();
        let third = axis.cross(&across);
        let base = self.vertices.len() as u32;
        self.vertices.push(ends[0] - axis * radius);
        let rings = 2 * PARALLELS;
        for ring in 0..rings {
            // the equator is there twice: once at either end of the segment
            let (end, step) = if ring < PARALLELS { (ends[0], ring + 1) } else { (ends[1], ring) };
            let latitude = PI * (f64::from(step) / f64::from(2 * PARALLELS) - 0.5);
            for m in 0..MERIDIANS {
                let (sin, cos) = (TAU * f64::from(m) / f64::from(MERIDIANS)).sin_cos();
                let outwards = axis * latitude.sin() + (across * cos + third * sin) * latitude.cos();
                self.vertices.push(end + outwards * radius);
            }
        }
        let top = self.vertices.len() as u32;
        self.vertices.push(ends[1] + axis * radius);
        for m in 0..MERIDIANS {
            let next = (m + 1) % MERIDIANS;
            let at = |ring: u32, m: u32| base + 1 + ring * MERIDIANS + m;
            self.triangles.push([base, at(0, next), at(0, m)]);
            for ring in 0..rings - 1 {
                self.triangles.push([at(ring, m), at(ring, next), at(ring + 1, next)]);
                self.triangles.push([at(ring, m), at(ring + 1, next), at(ring + 1, m)]);
            }
            self.triangles.push([top, at(rings - 1, m), at(rings - 1, next)]);
        }
    }
}
