//! Shapes for the wire: sent once per epoch, since particles only refer to them.

use sturz_engine::shape::{Shape, ShapeDescription};

use super::vec3;
use crate::columns;
use crate::v1;

/// A shape as `name` of the scene describes and the engine built it.
pub fn shape_to_wire(name: &str, description: &ShapeDescription, shape: &Shape) -> v1::Shape {
    let surface = shape.surface();
    let vertices: Vec<[f64; 3]> = surface.vertices.iter().map(|&vertex| vertex.into()).collect();
    let properties = shape.mass_properties();
    let (rotation, translation) = shape.given_from_body();
    let parameter = |(name, value): (&str, f64)| v1::Parameter { name: name.into(), value };
    v1::Shape {
        name: name.into(),
        kind: description.kind().into(),
        volume_m3: properties.volume,
        bounding_radius_m: shape.bounding_radius(),
        principal_moments_per_density_m5: Some(vec3(properties.principal_inertia.into())),
        given_from_body: Some(v1::Pose {
            position_m: Some(vec3(translation.into())),
            orientation: Some(v1::Quaternion { w: rotation.w, x: rotation.i, y: rotation.j, z: rotation.k }),
        }),
        vertices: Some(columns::rows("vertices", "m", &vertices)),
        triangles: Some(columns::rows("triangles", "", &surface.triangles)),
        parameters: parameters(description).into_iter().map(parameter).collect(),
        parts: shape.parts().len() as u32,
    }
}

/// The numbers of a description, by their keys in scene files.
fn parameters(description: &ShapeDescription) -> Vec<(&'static str, f64)> {
    use ShapeDescription as D;
    match *description {
        D::Sphere { radius_m } => vec![("radius_m", radius_m)],
        D::Spherocylinder { radius_m, total_length_m } => {
            vec![("radius_m", radius_m), ("total_length_m", total_length_m)]
        }
        D::Cylinder { radius_m, length_m } => vec![("radius_m", radius_m), ("length_m", length_m)],
        D::Cube { edge_m } | D::Tetrahedron { edge_m } | D::Octahedron { edge_m } => vec![("edge_m", edge_m)],
        D::Box { size_m: [x, y, z] } => vec![("size_x_m", x), ("size_y_m", y), ("size_z_m", z)],
        D::Pinacoid { length_m, width_m, height_m, alpha_deg } => {
            vec![("length_m", length_m), ("width_m", width_m), ("height_m", height_m), ("alpha_deg", alpha_deg)]
        }
        D::Cross2d { beam_length_m, beam_width_m } | D::Cross3d { beam_length_m, beam_width_m } => {
            vec![("beam_length_m", beam_length_m), ("beam_width_m", beam_width_m)]
        }
        D::RoundedPolyhedron { radius_m, .. } => vec![("radius_m", radius_m)],
        D::ConvexPolyhedron { .. } | D::Composite { .. } => Vec::new(),
    }
}
