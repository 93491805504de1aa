//! A rounded polyhedron against the two analytic walls: only vertices of the core can be deepest.

use super::{Core, Term};
use crate::math::{Similarity, Vec3};

/// Terms d = r - z of the vertices over the plane z = 0, in the frame of the wall; the wall is `b`.
pub fn core_plane(core: &Core, body_to_wall: &Similarity, out: &mut Vec<Term>) {
    out.clear();
    let radius = core.radius * body_to_wall.scale;
    each_vertex(core, body_to_wall, |x| (x.z < radius).then(|| (radius - x.z, -Vec3::z())), out);
}

/// Terms d = rho - (Rc - r) of the vertices inside the cylinder of radius Rc about z, rho their distance from z.
pub fn core_cylinder(core: &Core, body_to_wall: &Similarity, cylinder_radius: f64, out: &mut Vec<Term>) {
    out.clear();
    let free = cylinder_radius - core.radius * body_to_wall.scale;
    let touching = |x: &Vec3| {
        let rho = x.x.hypot(x.y);
        // on the axis all directions are equally near: x, so that the answer is finite and repeatable
        let normal = if rho > 0.0 { Vec3::new(x.x / rho, x.y / rho, 0.0) } else { Vec3::x() };
        (rho > free).then_some((rho - free, normal))
    };
    each_vertex(core, body_to_wall, touching, out);
}

fn each_vertex(
    core: &Core,
    to_wall: &Similarity,
    touching: impl Fn(&Vec3) -> Option<(f64, Vec3)>,
    out: &mut Vec<Term>,
) {
    let radius = core.radius * to_wall.scale;
    for vertex in core.solid().vertices() {
        let x = to_wall.point(vertex);
        let Some((overlap, normal)) = touching(&x) else { continue };
        let position = x + normal * (radius - 0.5 * overlap);
        out.push(Term { overlap, weight: 1.0, normal, position, weight_gradient: None, is_edges: false });
    }
}
