//! Volume, centre of mass and inertia per unit density: exact integrals where there are any.
//!
//! Polyhedra by signed tetrahedra, round parts and cylinders in closed form, disjoint composites as the sum of
//! their parts, unions of aligned boxes by their cells. What is left goes to the lattice of `lattice.rs`.

use super::polyhedron::Polyhedron;
use super::rounded_mass::swept_layer;
use super::{Part, PartGeometry};
use crate::math::{Mat3, Vec3};
use std::f64::consts::PI;

/// Off-diagonal inertia, over the largest moment, that counts as zero: the given axes are then kept.
const DIAGONAL: f64 = 1e-12;

/// Mass properties per unit density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// In m^3.
    pub volume: f64,
    /// Principal moments of inertia about the centre of mass per unit density, about the body axes, in m^5.
    pub principal_inertia: Vec3,
    /// Estimated relative error of volume and inertia; 0 where the integrals are exact (to rounding).
    pub relative_error: f64,
}

/// Volume, first and second moments (integrals of 1, x, x x^T) about the origin of the given frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moments {
    pub volume: f64,
    pub first: Vec3,
    pub second: Mat3,
}

impl Moments {
    pub const fn zero() -> Self {
        Self {
            volume: 0.0,
            first: Vec3::new(0.0, 0.0, 0.0),
            second: Mat3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        }
    }

    pub fn add(&mut self, other: &Self) {
        self.add_scaled(other, 1.0);
    }

    /// Adds a body of another density.
    pub fn add_scaled(&mut self, other: &Self, density: f64) {
        self.volume += other.volume * density;
        self.first += other.first * density;
        self.second += other.second * density;
    }

    /// Of a body whose own moments are about its centre `at`, with zero first moment.
    fn central(volume: f64, second: Mat3, at: &Vec3) -> Self {
        Self { volume, first: at * volume, second: second + at * at.transpose() * volume }
    }

    /// Of a cuboid with edges along the axes.
    pub fn cuboid(low: &Vec3, high: &Vec3) -> Self {
        let edges = high - low;
        let volume = edges.x * edges.y * edges.z;
        let second = Mat3::from_diagonal(&(edges.component_mul(&edges) * (volume / 12.0)));
        Self::central(volume, second, &((low + high) * 0.5))
    }

    /// Of a part, exactly; zero for a skeleton that is no convex solid.
    pub fn of_part(part: &Part) -> Self {
        match &part.geometry {
            PartGeometry::Sphere { center, radius } => sphere(center, *radius),
            PartGeometry::Spherocylinder { ends, radius } => spherocylinder(ends, *radius),
            PartGeometry::Cylinder { ends, radius } => cylinder(ends, *radius),
            PartGeometry::Polyhedron(p) => polyhedron(p),
            PartGeometry::RoundedPolyhedron(p) => p.solid.as_ref().map_or_else(Self::zero, |solid| {
                let mut moments = polyhedron(solid);
                moments.add(&swept_layer(solid, p.skeleton.radius));
                moments
            }),
        }
    }

    /// Of a body about its centre of mass and principal axes.
    pub fn given(volume: f64, inertia_over_mass: &Vec3) -> Self {
        let second = inertia_over_mass.map(|i| 0.5 * inertia_over_mass.sum() - i) * volume;
        Self { volume, first: Vec3::zeros(), second: Mat3::from_diagonal(&second) }
    }

    /// The same body about the origin of a frame whose axes are the columns of `rotation` and whose origin is `at`.
    pub fn rotated(&self, rotation: &Mat3, at: &Vec3) -> Self {
        let first = rotation * self.first;
        let second = rotation * self.second * rotation.transpose();
        let mixed = first * at.transpose();
        Self {
            volume: self.volume,
            first: first + at * self.volume,
            second: second + mixed + mixed.transpose() + at * at.transpose() * self.volume,
        }
    }
}

fn sphere(center: &Vec3, r: f64) -> Moments {
    let volume = 4.0 / 3.0 * PI * r.powi(3);
    Moments::central(volume, Mat3::identity() * (volume * r * r / 5.0), center)
}

fn spherocylinder(ends: &[Vec3; 2], r: f64) -> Moments {
    let axis = ends[1] - ends[0];
    let l = axis.norm();
    let (cylinder, caps) = (PI * r * r * l, 4.0 / 3.0 * PI * r.powi(3));
    let across = cylinder * r * r / 4.0 + caps * r * r / 5.0;
    // the half balls have their centres 3/8 r beyond the ends
    let along = cylinder * l * l / 12.0 + caps * (r * r / 5.0 + l * l / 4.0 + 3.0 / 8.0 * l * r);
    let direction = if l > 0.0 { axis / l } else { Vec3::x() };
    let second = Mat3::identity() * across + direction * direction.transpose() * (along - across);
    Moments::central(cylinder + caps, second, &((ends[0] + ends[1]) * 0.5))
}

/// V = pi R^2 L; second moments V L^2 / 12 along the axis, V R^2 / 4 across it.
fn cylinder(ends: &[Vec3; 2], r: f64) -> Moments {
    let axis = ends[1] - ends[0];
    let l = axis.norm();
    let volume = PI * r * r * l;
    let (along, across) = (volume * l * l / 12.0, volume * r * r / 4.0);
    let direction = axis / l;
    let second = Mat3::identity() * across + direction * direction.transpose() * (along - across);
    Moments::central(volume, second, &((ends[0] + ends[1]) * 0.5))
}

fn polyhedron(p: &Polyhedron) -> Moments {
    // about an inner point: far from the origin the signed tetrahedra would cancel
    let inner = p.vertices().iter().sum::<Vec3>() / p.vertices().len() as f64;
    let mut m = Moments::zero();
    for f in 0..p.faces().len() {
        let at = |k: usize| p.vertices()[p.face_vertices(f)[k] as usize] - inner;
        for k in 1..p.face_vertices(f).len() - 1 {
            let (a, b, c) = (at(0), at(k), at(k + 1));
            let (det, sum) = (a.dot(&b.cross(&c)), a + b + c);
            m.volume += det / 6.0;
            m.first += sum * (det / 24.0);
            let squares = a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose();
            m.second += squares * (det / 120.0);
        }
    }
    m.rotated(&Mat3::identity(), &inner)
}

/// Centre of mass, principal axes (columns, right-handed) and mass properties.
pub(crate) fn principal(m: &Moments, size: f64, relative_error: f64) -> (Vec3, Mat3, MassProperties) {
    let mut center = m.first / m.volume;
    // a centre that is only rounding away from the given origin must not blur the given coordinates
    for c in center.iter_mut() {
        if c.abs() <= 1e-14 * size {
            *c = 0.0;
        }
    }
    let central = m.second - center * center.transpose() * m.volume;
    let inertia = Mat3::identity() * central.trace() - central;
    let (axes, principal_inertia) = jacobi(inertia);
    (center, axes, MassProperties { volume: m.volume, principal_inertia, relative_error })
}

/// Eigenvectors (columns) and eigenvalues by cyclic Jacobi rotations of at most 45 degrees.
///
/// Entries below the tolerance are not rotated away: equal moments keep the given axes instead of random ones.
fn jacobi(mut m: Mat3) -> (Mat3, Vec3) {
    let mut axes = Mat3::identity();
    let zero = DIAGONAL * m.diagonal().amax();
    for _ in 0..32 {
        let mut rotated = false;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[(p, q)].abs() <= zero {
                continue;
            }
            rotated = true;
            let theta = (m[(q, q)] - m[(p, p)]) / (2.0 * m[(p, q)]);
            let t = if theta >= 0.0 { 1.0 } else { -1.0 } / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let mut turn = Mat3::identity();
            turn[(p, p)] = c;
            turn[(q, q)] = c;
            turn[(p, q)] = t * c;
            turn[(q, p)] = -t * c;
            m = turn.transpose() * m * turn;
            axes *= turn;
        }
        if !rotated {
            break;
        }
    }
    (axes, m.diagonal())
}
