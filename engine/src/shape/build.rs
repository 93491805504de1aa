//! From a raw description to parts in the given frame; every check of the numbers is here.

use super::description::{PartDescription, ShapeDescription};
use super::error::ShapeError;
use super::hull::{convex_hull, topology_error};
use super::mass::Moments;
use super::polyhedron::Polyhedron;
use super::rounded_build::{check_mass_properties, given_mass, rounded_polyhedron};
use super::union::{HALVINGS, OrientedBox, aligned_boxes, lattice};
use super::{Part, PartGeometry, solids};
use crate::math::{Mat3, Quat, Similarity, Vec3};
use crate::narrow::{Manifold, PairCache, collide};

/// Volume over the cube of the size below which inertia and contacts are rounding.
const LEAST_VOLUME: f64 = 1e-12;
/// Overlap of parts, over their size, that still counts as touching: rounding of glued faces.
const GLUED: f64 = 1e-9;

/// Parts in the given frame with their moments and the estimated relative error of these.
pub(crate) struct Assembly {
    pub parts: Vec<Part>,
    pub moments: Moments,
    pub relative_error: f64,
}

/// The parts in the given frame, and those of them that are boxes.
pub(crate) fn placed_parts(description: &ShapeDescription) -> Result<(Vec<Part>, Vec<OrientedBox>), ShapeError> {
    let mut parts: Vec<Part> = Vec::new();
    let mut boxes = Vec::new();
    for (p, path) in part_list(description)? {
        let (rotation, position) = pose(&p, &path)?;
        let field = if path.is_empty() { String::new() } else { format!("{path}.shape.") };
        let geometry = convex(&p.shape, &field)?;
        parts.push(Part::new(place(&geometry, &rotation, &position)));
        if let PartGeometry::Polyhedron(solid) = &geometry
            && let ShapeDescription::Cube { .. } | ShapeDescription::Box { .. } = *p.shape
        {
            boxes.push(OrientedBox { half: solid.vertices()[7], center: position, rotation });
        }
    }
    Ok((parts, boxes))
}

pub(crate) fn assemble(description: &ShapeDescription) -> Result<Assembly, ShapeError> {
    let given = given_mass(description)?;
    let (parts, boxes) = placed_parts(description)?;
    if let Some(moments) = given {
        return Ok(Assembly { parts, moments, relative_error: 0.0 });
    }
    check_mass_properties(&parts)?;
    if disjoint(&parts) {
        let mut moments = Moments::zero();
        for p in &parts {
            moments.add(&Moments::of_part(p));
        }
        return Ok(Assembly { parts, moments, relative_error: 0.0 });
    }
    if boxes.len() == parts.len()
        && let Some(moments) = aligned_boxes(&boxes)
    {
        return Ok(Assembly { parts, moments, relative_error: 0.0 });
    }
    let (moments, relative_error) = lattice(&parts, HALVINGS);
    Ok(Assembly { parts, moments, relative_error })
}

/// The parts with their paths; a convex shape is its only part, at the empty path.
fn part_list(description: &ShapeDescription) -> Result<Vec<(PartDescription, String)>, ShapeError> {
    let at_origin = |shape: ShapeDescription| PartDescription {
        shape: Box::new(shape),
        position_m: [0.0; 3],
        orientation_wxyz: [1.0, 0.0, 0.0, 0.0],
    };
    let beams = |axes: usize, length: f64, width: f64| {
        positive("beam_length_m", length)?;
        positive("beam_width_m", width)?;
        if length <= width {
            return Err(ShapeError::BeamTooShort { path: "beam_length_m".into(), length_m: length, width_m: width });
        }
        let beam = |axis: usize| {
            let mut size_m = [width; 3];
            size_m[axis] = length;
            (at_origin(ShapeDescription::Box { size_m }), String::new())
        };
        Ok((0..axes).map(beam).collect())
    };
    match description {
        ShapeDescription::Cross2d { beam_length_m, beam_width_m } => beams(2, *beam_length_m, *beam_width_m),
        ShapeDescription::Cross3d { beam_length_m, beam_width_m } => beams(3, *beam_length_m, *beam_width_m),
        ShapeDescription::Composite { parts, .. } if parts.is_empty() => {
            Err(ShapeError::NoParts { path: "parts".into() })
        }
        ShapeDescription::Composite { parts, .. } => {
            Ok(parts.iter().enumerate().map(|(i, p)| (p.clone(), format!("parts[{i}]"))).collect())
        }
        convex => Ok(vec![(at_origin(convex.clone()), String::new())]),
    }
}

fn pose(part: &PartDescription, path: &str) -> Result<(Mat3, Vec3), ShapeError> {
    for (i, &value) in part.position_m.iter().enumerate() {
        finite(&format!("{path}.position_m[{i}]"), value)?;
    }
    let [w, x, y, z] = part.orientation_wxyz;
    let q = nalgebra::Quaternion::new(w, x, y, z);
    let norm = q.norm();
    if !(norm - 1.0).abs().le(&1e-6) {
        return Err(ShapeError::Orientation { path: format!("{path}.orientation_wxyz"), norm });
    }
    let rotation =
        if [x, y, z] == [0.0; 3] { Mat3::identity() } else { *Quat::from_quaternion(q).to_rotation_matrix().matrix() };
    Ok((rotation, Vec3::from(part.position_m)))
}

fn place(geometry: &PartGeometry, rotation: &Mat3, position: &Vec3) -> PartGeometry {
    let to_given = |x: &Vec3| rotation * x + position;
    match geometry {
        PartGeometry::Sphere { center, radius } => PartGeometry::Sphere { center: to_given(center), radius: *radius },
        PartGeometry::Spherocylinder { ends, radius } => {
            PartGeometry::Spherocylinder { ends: [to_given(&ends[0]), to_given(&ends[1])], radius: *radius }
        }
        PartGeometry::Cylinder { ends, radius } => {
            PartGeometry::Cylinder { ends: [to_given(&ends[0]), to_given(&ends[1])], radius: *radius }
        }
        PartGeometry::Polyhedron(p) => PartGeometry::Polyhedron(p.transformed(rotation, position)),
        PartGeometry::RoundedPolyhedron(p) => {
            PartGeometry::RoundedPolyhedron(Box::new(p.transformed(rotation, position)))
        }
    }
}

/// A convex part in its own frame. `at` is the path of the shape with a final dot, or empty.
fn convex(description: &ShapeDescription, at: &str) -> Result<PartGeometry, ShapeError> {
    use ShapeDescription as D;
    let named = |solid: solids::Solid| polyhedron(solid, at);
    let length = |field: &str, value: f64| positive(&format!("{at}{field}"), value);
    match description {
        D::Sphere { radius_m } => {
            Ok(PartGeometry::Sphere { center: Vec3::zeros(), radius: length("radius_m", *radius_m)? })
        }
        D::Spherocylinder { radius_m, total_length_m } => {
            let (radius, total) = (length("radius_m", *radius_m)?, length("total_length_m", *total_length_m)?);
            let half = 0.5 * total - radius;
            if half < 0.0 {
                let path = format!("{at}total_length_m");
                return Err(ShapeError::TooShort { path, total_length_m: total, least: 2.0 * radius });
            }
            Ok(PartGeometry::Spherocylinder { ends: [Vec3::x() * -half, Vec3::x() * half], radius })
        }
        D::Cylinder { radius_m, length_m } => {
            let (radius, half) = (length("radius_m", *radius_m)?, 0.5 * length("length_m", *length_m)?);
            let cylinder = PartGeometry::Cylinder { ends: [Vec3::x() * -half, Vec3::x() * half], radius };
            large_enough(cylinder, if at.is_empty() { "shape" } else { at.trim_end_matches('.') })
        }
        D::Cube { edge_m } => named(solids::cuboid(&Vec3::repeat(length("edge_m", *edge_m)?))),
        D::Box { size_m } => {
            for (i, &value) in size_m.iter().enumerate() {
                length(&format!("size_m[{i}]"), value)?;
            }
            named(solids::cuboid(&Vec3::from(*size_m)))
        }
        D::Tetrahedron { edge_m } => named(solids::tetrahedron(length("edge_m", *edge_m)?)),
        D::Octahedron { edge_m } => named(solids::octahedron(length("edge_m", *edge_m)?)),
        D::Pinacoid { length_m, width_m, height_m, alpha_deg } => {
            let (l, g) = (length("length_m", *length_m)?, length("width_m", *width_m)?);
            let h = length("height_m", *height_m)?;
            named(solids::pinacoid(l, g, h, ridge(l, h, *alpha_deg, at)?))
        }
        D::ConvexPolyhedron { vertices_m } => {
            let points = points(vertices_m, at)?;
            thick_enough(convex_hull(&points, &format!("{at}vertices_m"))?, &format!("{at}vertices_m"))
        }
        D::RoundedPolyhedron { .. } => rounded_polyhedron(description, at),
        D::File { path, .. } => Err(ShapeError::NotRead { path: format!("{at}path"), file: path.clone() }),
        D::Cross2d { .. } | D::Cross3d { .. } | D::Composite { .. } => {
            Err(ShapeError::PartNotConvex { path: at.trim_end_matches('.').into(), kind: description.kind() })
        }
    }
}

/// Finite points.
pub(super) fn points(vertices_m: &[[f64; 3]], at: &str) -> Result<Vec<Vec3>, ShapeError> {
    for (i, v) in vertices_m.iter().enumerate() {
        for (k, &value) in v.iter().enumerate() {
            finite(&format!("{at}vertices_m[{i}][{k}]"), value)?;
        }
    }
    Ok(vertices_m.iter().map(|v| Vec3::from(*v)).collect())
}

fn ridge(l: f64, h: f64, alpha_deg: f64, at: &str) -> Result<f64, ShapeError> {
    if !(alpha_deg > 0.0 && alpha_deg < 90.0) {
        let path = format!("{at}alpha_deg");
        return Err(ShapeError::Angle { path, value: alpha_deg, low: 0.0, high: 90.0 });
    }
    let tangent = alpha_deg.to_radians().tan();
    let ridge = l - h / tangent;
    if ridge <= GLUED * l {
        return Err(ShapeError::RidgeVanishes { path: format!("{at}height_m"), height_m: h, limit: l * tangent });
    }
    Ok(ridge)
}

fn polyhedron((vertices, loops): solids::Solid, at: &str) -> Result<PartGeometry, ShapeError> {
    let path = if at.is_empty() { "shape" } else { at.trim_end_matches('.') };
    let solid = Polyhedron::from_faces(vertices, loops).map_err(|e| topology_error(e, path))?;
    thick_enough(solid, path)
}

pub(super) fn thick_enough(solid: Polyhedron, path: &str) -> Result<PartGeometry, ShapeError> {
    large_enough(PartGeometry::Polyhedron(solid), path)
}

/// The geometry, if its volume and inertia are more than rounding.
fn large_enough(geometry: PartGeometry, path: &str) -> Result<PartGeometry, ShapeError> {
    let part = Part::new(geometry);
    let size_m = match &part.geometry {
        PartGeometry::Polyhedron(solid) => solid.size(),
        _ => 2.0 * part.radius,
    };
    let volume_m3 = Moments::of_part(&part).volume;
    // the second moment is a fifth power: it must not underflow either
    if !(volume_m3 > LEAST_VOLUME * size_m.powi(3) && size_m.powi(5) > f64::MIN_POSITIVE / f64::EPSILON) {
        return Err(ShapeError::Volume { path: path.into(), volume_m3, size_m });
    }
    Ok(part.geometry)
}

fn disjoint(parts: &[Part]) -> bool {
    let mut manifold = Manifold::default();
    for (i, a) in parts.iter().enumerate() {
        for b in &parts[i + 1..] {
            if a.is_rounded_polyhedron() || b.is_rounded_polyhedron() {
                if (b.center - a.center).norm() < a.radius + b.radius {
                    return false;
                }
                continue;
            }
            manifold.clear();
            collide(a, b, &Similarity::identity(), &mut PairCache::default(), &mut manifold);
            let limit = GLUED * a.radius.min(b.radius);
            if manifold.points().iter().any(|p| p.overlap > limit) {
                return false;
            }
        }
    }
    true
}

pub(super) fn positive(path: &str, value: f64) -> Result<f64, ShapeError> {
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err(ShapeError::NotPositive { path: path.into(), value }) }
}

fn finite(path: &str, value: f64) -> Result<(), ShapeError> {
    if value.is_finite() { Ok(()) } else { Err(ShapeError::NotFinite { path: path.into(), value }) }
}
