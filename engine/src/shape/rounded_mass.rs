//! Moments of a convex polyhedron swept by a ball, exactly.
//!
//! The Minkowski sum falls into the polyhedron, a prism of height r on each face, a sector of a cylinder at each edge
//! and a sector of a ball at each vertex (the proof of Steiner's formula). With n_f, n_g the normals at an edge, theta
//! the angle between them, integrals over arcs and spherical polygons follow from the divergence theorem on their
//! cones, whose sides are perpendicular to the edges u_e that leave the vertex:
//!
//! - arc: int n = (n_f + n_g) tan(theta/2);
//! - polygon: its area is the angular defect Omega = 2 pi - sum of the face angles (Descartes),
//!   int n = -1/2 sum u_e theta_e, int n n^T = Omega/3 - 1/3 sum u_e ((n_f + n_g) tan(theta_e/2))^T.

use super::mass::Moments;
use super::polyhedron::Polyhedron;
use crate::math::{Mat3, Vec3};
use std::f64::consts::TAU;

/// Moments of what a ball of radius `r` adds to a convex polyhedron.
pub(super) fn swept_layer(p: &Polyhedron, r: f64) -> Moments {
    let mut sum = Moments::zero();
    (0..p.faces().len()).for_each(|f| sum.add(&prism(p, f, r)));
    (0..p.edges().len()).for_each(|e| sum.add(&wedge(p, e, r)));
    (0..p.vertices().len()).for_each(|v| sum.add(&corner(p, v, r)));
    sum
}

fn symmetric(a: &Vec3, b: &Vec3) -> Mat3 {
    a * b.transpose() + b * a.transpose()
}

/// Normals of the faces at an edge, the angle between them, and the integral of n over their arc.
fn arc(p: &Polyhedron, edge: usize) -> (Vec3, Vec3, f64, Vec3) {
    let [f, g] = p.edges()[edge].faces.map(|f| p.faces()[f as usize].normal);
    let theta = f.cross(&g).norm().atan2(f.dot(&g));
    (f, g, theta, (f + g) * (0.5 * theta).tan())
}

fn prism(p: &Polyhedron, face: usize, r: f64) -> Moments {
    let around = p.face_vertices(face);
    let normal = p.faces()[face].normal;
    let at = |k: usize| p.vertices()[around[k] as usize];
    let (mut area, mut first, mut second) = (0.0, Vec3::zeros(), Mat3::zeros());
    for k in 1..around.len() - 1 {
        let (a, b, c) = (at(0), at(k), at(k + 1));
        let part = 0.5 * (b - a).cross(&(c - a)).dot(&normal);
        let sum = a + b + c;
        area += part;
        first += sum * (part / 3.0);
        second += (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose()) * (part / 12.0);
    }
    let height = normal * normal.transpose() * (area * r * r * r / 3.0);
    Moments {
        volume: area * r,
        first: first * r + normal * (0.5 * area * r * r),
        second: second * r + symmetric(&first, &normal) * (0.5 * r * r) + height,
    }
}

fn wedge(p: &Polyhedron, edge: usize, r: f64) -> Moments {
    let (f, g, theta, along_arc) = arc(p, edge);
    let [start, end] = p.edges()[edge].vertices.map(|v| p.vertices()[v as usize]);
    let (middle, along) = ((start + end) * 0.5, end - start);
    let length = along.norm();
    let area = 0.5 * theta * r * r;
    let first = along_arc * (r * r * r / 3.0);
    let bisector = (f + g).normalize();
    let across = bisector.cross(&(along / length));
    let section = (bisector * bisector.transpose() * (theta + theta.sin())
        + across * across.transpose() * (theta - theta.sin()))
        * (r.powi(4) / 8.0);
    let line = middle * middle.transpose() + along * along.transpose() / 12.0;
    Moments {
        volume: area * length,
        first: (middle * area + first) * length,
        second: (line * area + symmetric(&middle, &first) + section) * length,
    }
}

fn corner(p: &Polyhedron, vertex: usize, r: f64) -> Moments {
    let x = p.vertices()[vertex];
    let mut defect = TAU;
    for &f in p.vertex_faces(vertex) {
        let around = p.face_vertices(f as usize);
        let k = around.iter().position(|&v| v as usize == vertex).expect("the face is around the vertex");
        let to = |k: usize| p.vertices()[around[k % around.len()] as usize] - x;
        let (u, v) = (to(k + 1), to(k + around.len() - 1));
        defect -= u.cross(&v).norm().atan2(u.dot(&v));
    }
    let (mut first, mut second) = (Vec3::zeros(), Mat3::identity() * (defect / 3.0));
    for (e, edge) in p.edges().iter().enumerate() {
        let leaving = match edge.vertices.map(|v| v as usize == vertex) {
            [true, _] => edge.direction,
            [_, true] => -edge.direction,
            _ => continue,
        };
        let (_, _, theta, along_arc) = arc(p, e);
        first -= leaving * (0.5 * theta);
        second -= symmetric(&leaving, &along_arc) * (0.5 / 3.0);
    }
    let volume = defect * r.powi(3) / 3.0;
    let first = first * (r.powi(4) / 4.0);
    Moments {
        volume,
        first: x * volume + first,
        second: x * x.transpose() * volume + symmetric(&x, &first) + second * (r.powi(5) / 5.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::union::{HALVINGS, lattice};
    use crate::shape::{PartGeometry, Shape, ShapeDescription};
    use std::f64::consts::PI;

    fn rounded(vertices_m: Vec<[f64; 3]>, radius_m: f64) -> Shape {
        Shape::build(&ShapeDescription::rounded_hull(vertices_m, radius_m)).expect("a valid shape")
    }

    /// A box a x b x c swept by r: Steiner's volume, and the moments of a box of zero size tend to those of a ball.
    #[test]
    fn rounded_box_has_its_closed_form() {
        let (half, r) = ([0.5, 0.3, 0.2], 0.1);
        let corner = |k: usize| [0, 1, 2].map(|i| if k >> i & 1 == 1 { half[i] } else { -half[i] });
        let shape = rounded((0..8).map(corner).collect(), r);
        let [a, b, c] = half.map(|h| 2.0 * h);
        let volume =
            a * b * c + 2.0 * r * (a * b + b * c + c * a) + PI * r * r * (a + b + c) + 4.0 / 3.0 * PI * r * r * r;
        let properties = shape.mass_properties();
        assert!((properties.volume - volume).abs() < 1e-14, "{} {volume}", properties.volume);
        assert_eq!(properties.relative_error, 0.0);
        // <x^2> of the sum of the parts, integrated by hand along x: slabs of the rounded rectangle
        let slab = |u: f64| {
            let s = (r * r - u * u).max(0.0).sqrt();
            b * c + 2.0 * s * (b + c) + PI * s * s
        };
        let n = 200_000;
        let cap = (0..n).map(|k| (f64::from(k) + 0.5) * r / f64::from(n));
        let beyond: f64 = cap.map(|u| 2.0 * (0.5 * a + u).powi(2) * slab(u) * r / f64::from(n)).sum();
        let xx = beyond + slab(0.0) * a.powi(3) / 12.0;
        let inertia = properties.principal_inertia;
        let trace_half = 0.5 * inertia.sum();
        assert!((trace_half - inertia.x - xx).abs() < 1e-9 * xx, "{} {xx}", trace_half - inertia.x);
    }

    /// An irregular tetrahedron off the origin: the exact sum against the lattice integral.
    #[test]
    fn irregular_tetrahedron_agrees_with_the_lattice() {
        let points = vec![[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.2, 0.9, 0.1], [0.3, 0.2, 0.7]];
        let shape = rounded(points, 0.15);
        let PartGeometry::RoundedPolyhedron(_) = shape.parts()[0].geometry else { panic!("not rounded") };
        let (moments, error) = lattice(shape.parts(), HALVINGS);
        let properties = shape.mass_properties();
        assert!((moments.volume / properties.volume - 1.0).abs() < error.max(1e-4), "{error}");
        let inertia = Mat3::identity() * moments.second.trace() - moments.second;
        assert!(moments.first.norm() < 1e-3 * properties.volume, "{:?}", moments.first);
        let off = (inertia - Mat3::from_diagonal(&properties.principal_inertia)).norm();
        assert!(off < 1e-3 * inertia.norm(), "{off} {inertia}");
    }
}
