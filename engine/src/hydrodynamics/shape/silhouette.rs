//! The area of a body's shadow along a direction, and its mean over all directions across one.

use super::shadow::Shadow;
use super::table::DirectionTable;
use crate::math::Vec3;
use crate::shape::{Part, PartGeometry, Polyhedron};
use std::f64::consts::{FRAC_1_PI, FRAC_2_PI, PI};

/// Faces or edges up to which the sums of an exact silhouette are cheaper than a table is inexact.
const MOST_FACES: usize = 64;

/// A silhouette, in the body frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Silhouette {
    Sphere {
        area: f64,
    },
    /// pi r^2 + 2 r l sin a.
    Spherocylinder {
        axis: Vec3,
        side: f64,
        caps: f64,
    },
    /// pi r^2 |cos a| + 2 r l sin a.
    Cylinder {
        axis: Vec3,
        side: f64,
        caps: f64,
    },
    /// Convex polyhedron: half the sum of |n.d| A; one area vector for each pair of opposite faces.
    Faces(Vec<Vec3>),
    /// The same swept by a ball: + r (perimeter of the shadow) + pi r^2.
    Rounded(Box<Rounded>),
    /// Scan lines on a grid of directions: [area, mean across].
    Table(Box<DirectionTable>),
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rounded {
    faces: Vec<Vec3>,
    edges: Vec<RoundedEdge>,
    radius: f64,
    mean_across: DirectionTable,
}

/// An edge of the core and the normals of its two faces.
#[derive(Clone, Debug, PartialEq)]
struct RoundedEdge {
    along: Vec3,
    normals: [Vec3; 2],
}

impl Silhouette {
    pub fn of(parts: &[Part]) -> Self {
        if let [part] = parts {
            match &part.geometry {
                PartGeometry::Sphere { radius, .. } => return Self::Sphere { area: PI * radius * radius },
                PartGeometry::Spherocylinder { ends, radius } | PartGeometry::Cylinder { ends, radius } => {
                    let along = ends[1] - ends[0];
                    let length = along.norm();
                    let caps = PI * radius * radius;
                    if length == 0.0 {
                        return Self::Sphere { area: caps };
                    }
                    let (axis, side) = (along / length, 2.0 * radius * length);
                    return match &part.geometry {
                        PartGeometry::Cylinder { .. } => Self::Cylinder { axis, side, caps },
                        _ => Self::Spherocylinder { axis, side, caps },
                    };
                }
                PartGeometry::Polyhedron(p) if p.faces().len() <= MOST_FACES => return Self::Faces(area_vectors(p)),
                PartGeometry::RoundedPolyhedron(p) => {
                    if let Some(solid) = p.solid.as_ref().filter(|s| s.edges().len() <= MOST_FACES) {
                        return Self::Rounded(Box::new(Rounded::of(solid, p.skeleton.radius)));
                    }
                }
                PartGeometry::Polyhedron(_) => {}
            }
        }
        let shadow = Shadow::of(parts);
        let areas = DirectionTable::tabulate(|d| [shadow.area(d), 0.0]);
        Self::Table(Box::new(areas.with_means_across()))
    }

    #[inline]
    pub fn area(&self, d: &Vec3) -> f64 {
        match self {
            Self::Sphere { area } => *area,
            Self::Spherocylinder { axis, side, caps } => caps + side * sine2(axis, d).sqrt(),
            Self::Cylinder { axis, side, caps } => caps * axis.dot(d).abs() + side * sine2(axis, d).sqrt(),
            Self::Faces(faces) => half_sum(faces, d),
            Self::Rounded(body) => body.area(d),
            Self::Table(table) => table.at(d)[0],
        }
    }

    /// By Cauchy's formula: over the directions across d, |n.e| is 2/pi sin(n, d) in the mean. The side of a cylinder gives
    /// an elliptic integral.
    #[inline]
    pub fn mean_across(&self, d: &Vec3) -> f64 {
        match self {
            Self::Sphere { area } => *area,
            Self::Spherocylinder { axis, side, caps } => caps + side * FRAC_2_PI * elliptic_e(sine2(axis, d)),
            Self::Cylinder { axis, side, caps } => {
                let sine2 = sine2(axis, d);
                caps * FRAC_2_PI * sine2.sqrt() + side * FRAC_2_PI * elliptic_e(sine2)
            }
            Self::Faces(faces) => mean_half_sum(faces, d),
            Self::Rounded(body) => body.mean_across.at(d)[1],
            Self::Table(table) => table.at(d)[1],
        }
    }
}

impl Rounded {
    fn of(solid: &Polyhedron, radius: f64) -> Self {
        let edge = |e: &crate::shape::Edge| {
            let [from, to] = e.vertices.map(|v| solid.vertices()[v as usize]);
            RoundedEdge { along: to - from, normals: e.faces.map(|f| solid.faces()[f as usize].normal) }
        };
        let mut body = Self {
            faces: area_vectors(solid),
            edges: solid.edges().iter().map(edge).collect(),
            radius,
            mean_across: DirectionTable::tabulate(|_| [0.0; 2]),
        };
        body.mean_across = DirectionTable::tabulate(|d| [0.0, super::table::mean_across(d, |e| body.area(e))]);
        body
    }

    fn area(&self, d: &Vec3) -> f64 {
        let outline = |e: &&RoundedEdge| (e.normals[0].dot(d) > 0.0) != (e.normals[1].dot(d) > 0.0);
        let perimeter: f64 = self.edges.iter().filter(outline).map(|e| e.along.cross(d).norm()).sum();
        half_sum(&self.faces, d) + self.radius * perimeter + PI * self.radius * self.radius
    }
}

/// Normal times area of each face; of two opposite faces the sum of both, along the first.
fn area_vectors(p: &Polyhedron) -> Vec<Vec3> {
    let mut vectors: Vec<Vec3> = Vec::new();
    for (f, face) in p.faces().iter().enumerate() {
        let vector = face.normal * p.face_area(f);
        let opposite = |v: &&mut Vec3| (v.normalize() + face.normal).norm() < 1e-12;
        match vectors.iter_mut().find(opposite) {
            Some(v) => *v -= vector,
            None => vectors.push(vector),
        }
    }
    vectors
}

#[inline]
fn half_sum(faces: &[Vec3], d: &Vec3) -> f64 {
    0.5 * faces.iter().map(|s| s.dot(d).abs()).sum::<f64>()
}

#[inline]
fn mean_half_sum(faces: &[Vec3], d: &Vec3) -> f64 {
    FRAC_1_PI * faces.iter().map(|s| s.cross(d).norm()).sum::<f64>()
}

#[inline]
fn sine2(axis: &Vec3, d: &Vec3) -> f64 {
    (1.0 - axis.dot(d).powi(2)).clamp(0.0, 1.0)
}

/// Complete elliptic integral of the second kind E(m), to 2e-8 (Abramowitz and Stegun 1964, eq. 17.3.36).
fn elliptic_e(m: f64) -> f64 {
    let x = 1.0 - m;
    if x <= 0.0 {
        return 1.0;
    }
    let a = x * (0.443_251_414_63 + x * (0.062_606_012_20 + x * (0.047_573_835_46 + x * 0.017_365_064_51)));
    let b = x * (0.249_983_683_10 + x * (0.092_001_800_37 + x * (0.040_696_975_26 + x * 0.005_264_496_39)));
    1.0 + a - b * x.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elliptic_integrals() {
        // E(0) = pi/2, E(1/2) = 1.350643881047675, E(1) = 1
        for (m, expected) in [(0.0, PI / 2.0), (0.5, 1.350_643_881_047_675), (1.0, 1.0)] {
            assert!((elliptic_e(m) - expected).abs() < 2e-8, "{m}");
        }
    }
}
