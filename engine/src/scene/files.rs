//! Files that a scene names: shapes out of meshes, read by a function that is handed in.

use std::sync::Arc;

use super::{BoundaryGeometry, FileBytes, SceneDescription};
use crate::error::{InvalidInput, InvalidScene};
use crate::mesh_file::{MeshFormat, TriangleMesh, convex_parts, read_mesh};
use crate::shape::{ShapeDescription, rockable_shapes};

impl SceneDescription {
    /// Puts the contents of files where the scene names them; `read` gives the bytes of a path as the scene has it.
    pub fn read_files(&mut self, read: impl Fn(&str) -> std::io::Result<Vec<u8>>) -> Result<(), InvalidScene> {
        let mut errors = Vec::new();
        for (k, shape) in self.shapes.iter_mut().enumerate() {
            read_shape(&mut shape.geometry, &format!("shape[{k}].geometry"), &read, &mut errors);
        }
        for (k, boundary) in self.boundaries.iter_mut().enumerate() {
            let BoundaryGeometry::MeshFile { path, scale } = &boundary.geometry else { continue };
            match triangles_of(read(path), path, *scale) {
                Ok(mesh) => {
                    let TriangleMesh { vertices: vertices_m, triangles, .. } = mesh;
                    boundary.geometry = BoundaryGeometry::Mesh { vertices_m, triangles };
                }
                Err(problem) => {
                    errors
                        .push(InvalidInput::new(format!("boundary[{k}].geometry.path"), format!("'{path}' {problem}")));
                }
            }
        }
        if let Some(start) = &mut self.start {
            match read(&start.checkpoint) {
                Ok(bytes) => start.bytes = FileBytes(Arc::new(bytes)),
                Err(error) => {
                    let problem = format!("'{}' cannot be read: {error}", start.checkpoint);
                    errors.push(InvalidInput::new("start.checkpoint", problem));
                }
            }
        }
        if errors.is_empty() { Ok(()) } else { Err(InvalidScene(errors)) }
    }
}

fn read_shape(
    geometry: &mut ShapeDescription,
    at: &str,
    read: &impl Fn(&str) -> std::io::Result<Vec<u8>>,
    errors: &mut Vec<InvalidInput>,
) {
    match geometry {
        ShapeDescription::Composite { parts, .. } => {
            for (k, part) in parts.iter_mut().enumerate() {
                read_shape(&mut part.shape, &format!("{at}.parts[{k}].shape"), read, errors);
            }
        }
        ShapeDescription::File { path, scale, name } => {
            let bytes = read(path).map_err(|error| format!("cannot be read: {error}"));
            match bytes.and_then(|bytes| shape_of(&bytes, path, *scale, name.as_deref())) {
                Ok(shape) => *geometry = shape,
                Err(problem) => errors.push(InvalidInput::new(format!("{at}.path"), format!("'{path}' {problem}"))),
            }
        }
        _ => {}
    }
}

/// All meshes of a file as one.
fn triangles_of(bytes: std::io::Result<Vec<u8>>, path: &str, scale: f64) -> Result<TriangleMesh, String> {
    let bytes = bytes.map_err(|error| format!("cannot be read: {error}"))?;
    check_scale(scale)?;
    let format = MeshFormat::of(path).map_err(|_| "is of no known kind: boundaries are .obj or .stl".to_owned())?;
    let meshes = read_mesh(&bytes, format, scale).map_err(|error| error.to_string())?;
    Ok(TriangleMesh::joined(&meshes))
}

fn check_scale(scale: f64) -> Result<(), String> {
    if scale > 0.0 && scale.is_finite() {
        Ok(())
    } else {
        Err(format!("has a scale of {scale}: must be positive and finite"))
    }
}

fn shape_of(bytes: &[u8], path: &str, scale: f64, name: Option<&str>) -> Result<ShapeDescription, String> {
    check_scale(scale)?;
    if path.to_ascii_lowercase().ends_with(".shp") {
        return one_of_rockable(bytes, scale, name);
    }
    if let Some(name) = name {
        return Err(format!("has no shapes with names: leave out name = '{name}', which is for .shp files"));
    }
    let format = MeshFormat::of(path).map_err(|_| "is of no known kind: shapes are .obj, .stl or .shp".to_owned())?;
    let meshes = read_mesh(bytes, format, scale).map_err(|error| error.to_string())?;
    convex_parts(&meshes).map_err(|error| error.to_string())
}

fn one_of_rockable(bytes: &[u8], scale: f64, name: Option<&str>) -> Result<ShapeDescription, String> {
    if scale != 1.0 {
        return Err("is in metres: leave out scale".into());
    }
    let text = std::str::from_utf8(bytes).map_err(|error| format!("is not text: {error}"))?;
    let mut shapes = rockable_shapes(text).map_err(|error| error.to_string())?;
    let names = shapes.iter().map(|shape| shape.name.clone()).collect::<Vec<_>>().join(", ");
    match name {
        Some(name) => shapes.retain(|shape| shape.name == name),
        None if shapes.len() > 1 => return Err(format!("has several shapes: give name, one of {names}")),
        None => {}
    }
    let shape = shapes.into_iter().next();
    shape.map(|shape| shape.description).ok_or_else(|| format!("has no shape of this name; it has {names}"))
}
