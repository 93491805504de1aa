//! Surface area: in closed form for one part, by clipping for polyhedra, by points on the surfaces for all other unions.

use super::clipping::{polygon_area, union_area};
use super::samples::{Sample, samples_of, skeleton_depth};
use crate::math::Vec3;
use crate::shape::{Part, PartGeometry, Polyhedron};
use std::f64::consts::PI;

/// How near two surfaces are one, over the size.
const ONE_SURFACE: f64 = 1e-7;

/// Area of the surface of the union.
pub(super) fn surface_area(parts: &[Part]) -> f64 {
    if let [part] = parts {
        return part_area(part);
    }
    let solids: Vec<&Polyhedron> = parts
        .iter()
        .filter_map(|part| if let PartGeometry::Polyhedron(p) = &part.geometry { Some(p) } else { None })
        .collect();
    if solids.len() == parts.len() {
        return union_area(&solids);
    }
    (0..parts.len()).map(|i| part_area(&parts[i]) * exposed(parts, i)).sum()
}

/// Of a part by itself.
fn part_area(part: &Part) -> f64 {
    match &part.geometry {
        PartGeometry::Sphere { radius, .. } => 4.0 * PI * radius * radius,
        PartGeometry::Spherocylinder { ends, radius } => {
            2.0 * PI * radius * ((ends[1] - ends[0]).norm() + 2.0 * radius)
        }
        PartGeometry::Cylinder { ends, radius } => 2.0 * PI * radius * ((ends[1] - ends[0]).norm() + radius),
        PartGeometry::Polyhedron(p) => polyhedron_area(p),
        PartGeometry::RoundedPolyhedron(p) => {
            let r = p.skeleton.radius;
            let Some(solid) = &p.solid else { return skeleton_area(part) };
            // Steiner: faces, a piece of cylinder at each edge, one ball in all at the vertices
            let edges = solid.edges().iter().map(|e| {
                let [a, b] = e.vertices.map(|v| solid.vertices()[v as usize]);
                let [m, n] = e.faces.map(|f| solid.faces()[f as usize].normal);
                (b - a).norm() * m.cross(&n).norm().atan2(m.dot(&n))
            });
            polyhedron_area(solid) + r * edges.sum::<f64>() + 4.0 * PI * r * r
        }
    }
}

fn polyhedron_area(p: &Polyhedron) -> f64 {
    let face = |f| p.face_vertices(f).iter().map(|&v| p.vertices()[v as usize]).collect::<Vec<Vec3>>();
    (0..p.faces().len()).map(|f| polygon_area(&face(f))).sum()
}

/// Of a swept skeleton that is no convex solid: points on the pieces about each of its features, less those that another
/// feature covers.
fn skeleton_area(part: &Part) -> f64 {
    let least = 1e-9 * part.radius;
    samples_of(part).iter().filter(|s| depth(part, &s.point) < least).map(|s| s.area).sum()
}

/// The fraction of the surface of part `i` that is outside of all others.
fn exposed(parts: &[Part], i: usize) -> f64 {
    let samples = samples_of(&parts[i]);
    let own = |s: &Sample| {
        let part = &parts[i];
        matches!(&part.geometry, PartGeometry::RoundedPolyhedron(p) if p.solid.is_none())
            && depth(part, &s.point) >= 1e-9 * part.radius
    };
    let (mut seen, mut all) = (0.0, 0.0);
    for s in samples.iter().filter(|s| !own(s)) {
        if (0..parts.len()).all(|j| j == i || visible(s, &parts[j], j < i)) {
            seen += s.area;
        }
        all += s.area;
    }
    if all > 0.0 { seen / all } else { 1.0 }
}

/// Whether a point of a surface is outside of another part. Points count wholly or not at all: a smooth transition would
/// be wrong where surfaces touch along a line, as a cylinder and the balls at its ends.
fn visible(sample: &Sample, other: &Part, earlier: bool) -> bool {
    if (sample.point - other.center).norm_squared() > other.radius * other.radius {
        return true;
    }
    let inside = depth(other, &sample.point);
    let step = ONE_SURFACE * other.radius;
    if inside.abs() < step {
        // one surface: the depth outwards tells whether the two look at each other
        let at = |sign: f64| depth(other, &(sample.point + sample.normal * (sign * step)));
        let slope = at(1.0) - at(-1.0);
        if slope.abs() > 1.9 * step {
            return slope < 0.0 && !earlier;
        }
    }
    inside <= 0.0
}

/// Distance to the surface, positive inside.
fn depth(part: &Part, x: &Vec3) -> f64 {
    match &part.geometry {
        PartGeometry::RoundedPolyhedron(p) if p.solid.is_none() => skeleton_depth(&p.skeleton, x),
        _ => part.depth_inside(x),
    }
}
