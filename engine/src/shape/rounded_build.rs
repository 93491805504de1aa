//! From the raw description of a rounded polyhedron to its skeleton, and mass properties that were given.

use super::build::{points, positive, thick_enough};
use super::description::{MassDescription, ShapeDescription};
use super::error::ShapeError;
use super::hull::convex_hull;
use super::mass::Moments;
use super::polyhedron::Polyhedron;
use super::skeleton::Skeleton;
use super::{Part, PartGeometry, RoundedPolyhedron};
use crate::math::Vec3;

/// The geometry; `at` as for every convex shape.
pub(super) fn rounded_polyhedron(description: &ShapeDescription, at: &str) -> Result<PartGeometry, ShapeError> {
    let ShapeDescription::RoundedPolyhedron { radius_m, vertices_m, edges, faces, mass_properties } = description
    else {
        unreachable!("called for this kind only");
    };
    if !at.is_empty() && mass_properties.is_some() {
        let reason = "belongs to the composite, not to one of its parts".into();
        return Err(ShapeError::Mass { path: format!("{at}mass_properties"), reason });
    }
    let radius = positive(&format!("{at}radius_m"), *radius_m)?;
    let vertices = points(vertices_m, at)?;
    let path = format!("{at}vertices_m");
    if edges.is_empty() && faces.is_empty() {
        let PartGeometry::Polyhedron(solid) = thick_enough(convex_hull(&vertices, &path)?, &path)? else {
            unreachable!("the hull is a polyhedron");
        };
        let edges: Vec<[u32; 2]> = solid.edges().iter().map(|e| e.vertices).collect();
        let loops: Vec<Vec<u32>> = (0..solid.faces().len()).map(|f| solid.face_vertices(f).to_vec()).collect();
        let skeleton = Skeleton::new(solid.vertices().to_vec(), &edges, &loops, radius, &path)?;
        return Ok(PartGeometry::RoundedPolyhedron(Box::new(RoundedPolyhedron { skeleton, solid: Some(solid) })));
    }
    check_indices(vertices.len(), edges, faces, at)?;
    let skeleton = Skeleton::new(vertices.clone(), edges, faces, radius, &format!("{at}faces"))?;
    let solid = skeleton.is_convex().then(|| Polyhedron::from_faces(vertices, faces.clone()).ok()).flatten();
    Ok(PartGeometry::RoundedPolyhedron(Box::new(RoundedPolyhedron { skeleton, solid })))
}

fn check_indices(vertices: usize, edges: &[[u32; 2]], faces: &[Vec<u32>], at: &str) -> Result<(), ShapeError> {
    let wrong = |path: String, reason: String| Err(ShapeError::Skeleton { path, reason });
    if vertices == 0 {
        return wrong(format!("{at}vertices_m"), "is empty: a skeleton needs at least one vertex".into());
    }
    for (k, [p, q]) in edges.iter().enumerate() {
        if p == q || p.max(q) >= &(vertices as u32) {
            return wrong(format!("{at}edges[{k}]"), format!("is {p}, {q}: two different vertices below {vertices}"));
        }
    }
    for (k, polygon) in faces.iter().enumerate() {
        let twice = polygon.iter().enumerate().any(|(i, v)| polygon[..i].contains(v));
        if polygon.len() < 3 || twice || polygon.iter().any(|&v| v as usize >= vertices) {
            let reason = format!("is {polygon:?}: at least three different vertices below {vertices}");
            return wrong(format!("{at}faces[{k}]"), reason);
        }
    }
    Ok(())
}

/// Moments of a description that gives them.
pub(super) fn given_mass(description: &ShapeDescription) -> Result<Option<Moments>, ShapeError> {
    let (ShapeDescription::RoundedPolyhedron { mass_properties: Some(given), .. }
    | ShapeDescription::Composite { mass_properties: Some(given), .. }) = description
    else {
        return Ok(None);
    };
    let MassDescription { volume_m3, inertia_over_mass_m2 } = given;
    positive("mass_properties.volume_m3", *volume_m3)?;
    for (k, &value) in inertia_over_mass_m2.iter().enumerate() {
        positive(&format!("mass_properties.inertia_over_mass_m2[{k}]"), value)?;
    }
    let inertia = Vec3::from(*inertia_over_mass_m2);
    if inertia.max() > 0.5 * inertia.sum() * (1.0 + 1e-9) {
        let reason = format!("is {inertia_over_mass_m2:?}: no moment may exceed the sum of the other two");
        return Err(ShapeError::Mass { path: "mass_properties.inertia_over_mass_m2".into(), reason });
    }
    Ok(Some(Moments::given(*volume_m3, &inertia)))
}

/// Every part must have a volume of its own where none is given.
pub(super) fn check_mass_properties(parts: &[Part]) -> Result<(), ShapeError> {
    let hollow = |part: &Part| matches!(&part.geometry, PartGeometry::RoundedPolyhedron(p) if p.solid.is_none());
    if parts.iter().any(hollow) {
        let reason = "are needed: a skeleton that is not closed, flat-faced and convex has none of its own".into();
        return Err(ShapeError::Mass { path: "mass_properties".into(), reason });
    }
    Ok(())
}
