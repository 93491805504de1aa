//! Why triangles do not make a boundary.

use thiserror::Error;

/// What is wrong with a mesh; `path` is within its geometry.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MeshError {
    /// Nothing there.
    #[error("has no triangles")]
    Empty,
    /// Not a number, or infinite.
    #[error("vertex {vertex} is not finite")]
    NonFinite {
        /// Index of the vertex.
        vertex: usize,
    },
    /// An index beyond the vertices.
    #[error("triangle {triangle} names vertex {vertex}; there are {vertices}")]
    NoSuchVertex {
        /// Index of the triangle.
        triangle: usize,
        /// What it names.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A triangle without area.
    #[error("triangle {triangle} has no area: leave it out")]
    Degenerate {
        /// Index of the triangle.
        triangle: usize,
    },
    /// Two triangles traverse their common edge in the same direction.
    #[error(
        "triangles {first} and {second} are oriented against each other: both run from vertex {from} to vertex {to}; reverse one"
    )]
    InconsistentOrientation {
        /// Index of a triangle.
        first: usize,
        /// Index of the other.
        second: usize,
        /// Start of the edge.
        from: u32,
        /// Its end.
        to: u32,
    },
    /// More than two triangles on an edge.
    #[error(
        "the edge between the vertices {from} and {to} has more than two triangles ({first}, {second} and {third}): give surfaces that meet there vertices of their own"
    )]
    NotASurface {
        /// One end.
        from: u32,
        /// The other end.
        to: u32,
        /// Index of a triangle.
        first: usize,
        /// Of another.
        second: usize,
        /// Of a third.
        third: usize,
    },
    /// More elements than slots can name.
    #[error("has too many elements")]
    TooLarge,
}

impl MeshError {
    /// Key of the geometry that the error is about.
    pub fn key(&self) -> &'static str {
        match self {
            Self::NonFinite { .. } => "vertices_m",
            _ => "triangles",
        }
    }
}
