//! Triangle meshes of other programs: OBJ and STL, from bytes handed in, and the convex parts that they describe.

mod convex;
mod read;
#[cfg(test)]
mod tests;

pub use convex::convex_parts;
pub use read::{MeshFormat, read_mesh};

use thiserror::Error;

/// Triangles over shared vertices, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Of the object in an OBJ file.
    pub name: String,
    /// Positions, in the unit of the file.
    pub vertices: Vec<[f64; 3]>,
    /// Indices of vertices.
    pub triangles: Vec<[u32; 3]>,
}

/// Why a mesh was refused.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MeshFileError {
    /// A file whose name ends otherwise.
    #[error("'{name}' is of no known kind: meshes are .obj or .stl")]
    UnknownFormat {
        /// Of the file.
        name: String,
    },
    /// A line or byte that the format does not allow.
    #[error("{at}: {reason}")]
    Syntax {
        /// Line or triangle.
        at: String,
        /// What is wrong.
        reason: String,
    },
    /// No triangle.
    #[error("has no triangles")]
    Empty,
    /// A coordinate that is NaN or infinite.
    #[error("vertex {vertex} of {mesh} is not finite")]
    NotFinite {
        /// Index.
        vertex: usize,
        /// Its mesh.
        mesh: String,
    },
    /// Corners in a line, or twice the same.
    #[error("triangle {triangle} of {mesh} has no area")]
    Degenerate {
        /// Index.
        triangle: usize,
        /// Its mesh.
        mesh: String,
    },
    /// An edge of one triangle only.
    #[error("{mesh} is open: only one triangle has the edge from {from:?} to {to:?}")]
    Open {
        /// Its mesh.
        mesh: String,
        /// An end.
        from: [f64; 3],
        /// The other.
        to: [f64; 3],
    },
    /// Two triangles that run along an edge in the same direction.
    #[error(
        "{mesh} has an edge from {from:?} to {to:?} that two triangles run along in the same direction: one is turned over, or more than two meet there"
    )]
    TurnedOver {
        /// Its mesh.
        mesh: String,
        /// An end.
        from: [f64; 3],
        /// The other.
        to: [f64; 3],
    },
    /// A closed surface that encloses a negative volume.
    #[error("{mesh} is inside out: its triangles must be counter-clockwise seen from outside")]
    Inverted {
        /// Its mesh.
        mesh: String,
    },
    /// A surface that is not convex.
    #[error(
        "{mesh} is not convex: vertex {vertex} lies {relative:.1e} of the size outside a triangle's plane; give convex parts, as objects of an .obj or as surfaces apart"
    )]
    NotConvex {
        /// Its mesh.
        mesh: String,
        /// Index.
        vertex: usize,
        /// Over the size.
        relative: f64,
    },
}
