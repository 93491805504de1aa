//! How much easier a body gives way to a force off its centre of mass: for the critical time step.

use crate::math::{Mat3, Vec3};
use crate::shape::{MassProperties, Part, PartGeometry};
use std::f64::consts::{PI, TAU};

/// m (r x n) . I^-1 (r x n), the largest over the surface: a contact there has 1/m_eff = (1 + leverage) / m.
///
/// Pure numbers, the same for every size and density. Bounds from above: the direction n is free at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leverage {
    /// Of normal forces: those on a rounded surface pass through its core.
    pub normal: f64,
    /// Of tangential forces.
    pub tangential: f64,
}

impl Leverage {
    /// Of a shape with principal axes; `parts` in the body frame.
    pub fn of(parts: &[Part], properties: &MassProperties) -> Self {
        let inertia_over_mass = properties.principal_inertia / properties.volume;
        // Of a force at r in the worst direction: the largest eigenvalue of [r]^T I^-1 [r].
        let worst = |r: &Vec3| {
            let cross = r.cross_matrix();
            let compliance: Mat3 = cross.transpose() * Mat3::from_diagonal(&inertia_over_mass.map(f64::recip)) * cross;
            compliance.symmetric_eigenvalues().max().max(0.0)
        };
        let of_core = |points: &[Vec3]| points.iter().map(worst).fold(0.0, f64::max);
        let mut all = Self { normal: 0.0, tangential: 0.0 };
        for part in parts {
            let (core, radius) = match &part.geometry {
                PartGeometry::Sphere { center, radius } => (of_core(&[*center]), *radius),
                PartGeometry::Spherocylinder { ends, radius } => (of_core(ends), *radius),
                PartGeometry::Cylinder { ends, radius } => (of_core(&around_rims(ends, *radius)), 0.0),
                PartGeometry::Polyhedron(polyhedron) => (of_core(polyhedron.vertices()), 0.0),
                PartGeometry::RoundedPolyhedron(p) => (of_core(p.skeleton.vertices()), p.skeleton.radius),
            };
            // Triangle inequality in the norm of I^-1, for the surface point core + radius.
            let surface = core.sqrt() + radius / inertia_over_mass.min().sqrt();
            all.normal = all.normal.max(core);
            all.tangential = all.tangential.max(surface * surface);
        }
        all
    }
}

/// Corners of polygons about both rims: the leverage is convex in the point, so theirs bounds that of the rims, by 0.5 %
/// at most.
fn around_rims(ends: &[Vec3; 2], radius: f64) -> Vec<Vec3> {
    const CORNERS: u32 = 32;
    let axis = (ends[1] - ends[0]).normalize();
    let across = axis.cross(&Vec3::ith(axis.iamin(), 1.0)).normalize();
    let third = axis.cross(&across);
    let reach = radius / (PI / f64::from(CORNERS)).cos();
    let outwards = (0..CORNERS).map(|k| {
        let (sin, cos) = (TAU * f64::from(k) / f64::from(CORNERS)).sin_cos();
        (across * cos + third * sin) * reach
    });
    outwards.flat_map(|out| ends.map(|end| end + out)).collect()
}

#[cfg(test)]
mod tests {
    use crate::shape::{Shape, ShapeDescription};

    fn leverage(description: ShapeDescription) -> [f64; 2] {
        let leverage = Shape::build(&description).unwrap().leverage();
        [leverage.normal, leverage.tangential]
    }

    #[test]
    fn closed_forms() {
        let near = |[a, b]: [f64; 2], [c, d]: [f64; 2]| {
            assert!((a - c).abs() < 1e-12 && (b - d).abs() < 1e-12 * d, "{a} {b}, not {c} {d}");
        };
        near(leverage(ShapeDescription::Sphere { radius_m: 0.3 }), [0.0, 2.5]);
        // r^2 = 3/4 a^2, I = m a^2 / 6
        near(leverage(ShapeDescription::Cube { edge_m: 2.0 }), [4.5, 4.5]);
        // A rod: the end of the core, 1 m off, with the inertia across the axis; then the surface, bound from above.
        let rod = ShapeDescription::Spherocylinder { radius_m: 0.5, total_length_m: 3.0 };
        let shape = Shape::build(&rod).unwrap();
        let properties = shape.mass_properties();
        let (across, along) = (
            properties.principal_inertia.max() / properties.volume,
            properties.principal_inertia.min() / properties.volume,
        );
        near(leverage(rod), [1.0 / across, (across.sqrt().recip() + 0.5 / along.sqrt()).powi(2)]);
    }
}
