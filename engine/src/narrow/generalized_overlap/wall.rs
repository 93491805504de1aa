//! A polyhedron against the two analytic walls: only vertices can be deepest, and their depths are smooth functions of
//! the pose as they are, so that walls meet the sharp polyhedron. Rounding is for polyhedra among each other.

use super::Term;
use crate::math::{Similarity, Vec3};
use crate::shape::Polyhedron;

/// Terms d = -z of the vertices below the plane z = 0, in the frame of the wall; the wall is `b`.
pub fn polyhedron_plane(solid: &Polyhedron, body_to_wall: &Similarity, out: &mut Vec<Term>) {
    out.clear();
    each_vertex(solid, body_to_wall, |x| (x.z < 0.0).then(|| (-x.z, -Vec3::z())), out);
}

/// Terms d = rho - Rc of the vertices outside the cylinder of radius Rc about z, rho their distance from z.
pub fn polyhedron_cylinder(solid: &Polyhedron, body_to_wall: &Similarity, cylinder_radius: f64, out: &mut Vec<Term>) {
    out.clear();
    let touching = |x: &Vec3| {
        let rho = x.x.hypot(x.y);
        // on the axis all directions are equally near: x, so that the answer is finite and repeatable
        let normal = if rho > 0.0 { Vec3::new(x.x / rho, x.y / rho, 0.0) } else { Vec3::x() };
        (rho > cylinder_radius).then_some((rho - cylinder_radius, normal))
    };
    each_vertex(solid, body_to_wall, touching, out);
}

fn each_vertex(
    solid: &Polyhedron,
    to_wall: &Similarity,
    touching: impl Fn(&Vec3) -> Option<(f64, Vec3)>,
    out: &mut Vec<Term>,
) {
    for vertex in solid.vertices() {
        let x = to_wall.point(vertex);
        let Some((overlap, normal)) = touching(&x) else { continue };
        let position = x - normal * (0.5 * overlap);
        out.push(Term { overlap, weight: 1.0, normal, position, weight_gradient: None, is_edges: false });
    }
}
