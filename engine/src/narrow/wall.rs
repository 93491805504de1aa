//! Parts against the two analytic walls, in the frame of the wall: a half-space, and the inside of a cylinder.
//!
//! The part is `a` and the wall is `b`: normals point from the particle into the wall. Every vertex behind the wall
//! counts with share 1, as the stiffness per vertex of a wall law does not depend on the others.

use super::cylinder::Solid;
use super::cylinder_wall::{cylinder_in_cylinder, cylinder_plane};
use super::{FeatureKey, Manifold, ManifoldPoint};
use crate::math::{Similarity, Vec3};
use crate::shape::{Part, PartGeometry};

/// Contacts with the plane z = 0, free where z > 0.
pub fn part_plane(part: &Part, body_to_wall: &Similarity, out: &mut Manifold) {
    if body_to_wall.point(&part.center).z > part.radius * body_to_wall.scale {
        return;
    }
    if let PartGeometry::Cylinder { ends, radius } = &part.geometry {
        return cylinder_plane(&Solid::new(ends, *radius).mapped(body_to_wall), |point| out.push_deepest(point));
    }
    each_ball(part, body_to_wall, |center, radius, feature| {
        let overlap = radius - center.z;
        if overlap > 0.0 {
            // its lowest point is at -overlap, the plane at 0
            let position = Vec3::new(center.x, center.y, -0.5 * overlap);
            out.push_deepest(ManifoldPoint { position, normal: -Vec3::z(), overlap, share: 1.0, feature });
        }
    });
}

/// Contacts with the inside of the cylinder about z, free where the distance from z is below `cylinder_radius`.
pub fn part_cylinder(part: &Part, body_to_wall: &Similarity, cylinder_radius: f64, out: &mut Manifold) {
    let center = body_to_wall.point(&part.center);
    if (center.x * center.x + center.y * center.y).sqrt() + part.radius * body_to_wall.scale < cylinder_radius {
        return;
    }
    if let PartGeometry::Cylinder { ends, radius } = &part.geometry {
        let solid = Solid::new(ends, *radius).mapped(body_to_wall);
        return cylinder_in_cylinder(&solid, cylinder_radius, |point| out.push_deepest(point));
    }
    each_ball(part, body_to_wall, |center, radius, feature| {
        let rho = (center.x * center.x + center.y * center.y).sqrt();
        let overlap = rho + radius - cylinder_radius;
        if overlap > 0.0 {
            // on the axis all directions are equally near: x, so that the answer is finite and repeatable
            let normal = if rho > 0.0 { Vec3::new(center.x / rho, center.y / rho, 0.0) } else { Vec3::x() };
            let position = normal * (cylinder_radius + 0.5 * overlap) + Vec3::z() * center.z;
            out.push_deepest(ManifoldPoint { position, normal, overlap, share: 1.0, feature });
        }
    });
}

/// The points that reach farthest: the vertices of a polyhedron as balls (of radius 0 if it is sharp), the ends of a
/// spherocylinder. None of a cylinder.
fn each_ball(part: &Part, to_wall: &Similarity, mut visit: impl FnMut(Vec3, f64, FeatureKey)) {
    match &part.geometry {
        PartGeometry::Sphere { center, radius } => {
            visit(to_wall.point(center), radius * to_wall.scale, FeatureKey::point(0));
        }
        PartGeometry::Spherocylinder { ends, radius } => {
            for (k, end) in (0..).zip(ends) {
                visit(to_wall.point(end), radius * to_wall.scale, FeatureKey::point(k));
            }
        }
        // its rims are circles, which the callers ask themselves
        PartGeometry::Cylinder { .. } => {}
        PartGeometry::Polyhedron(p) => {
            for (v, vertex) in (0..).zip(p.vertices()) {
                visit(to_wall.point(vertex), 0.0, FeatureKey::vertex_of_a(v));
            }
        }
        PartGeometry::RoundedPolyhedron(p) => {
            let radius = p.skeleton.radius * to_wall.scale;
            for (v, vertex) in (0..).zip(p.skeleton.vertices()) {
                visit(to_wall.point(vertex), radius, FeatureKey::vertex_of_a(v));
            }
        }
    }
}
