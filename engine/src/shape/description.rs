//! Shapes as scene files state them: raw numbers, units in the keys, nothing checked yet.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A shape as a scene file states it; `Shape::build` checks it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ShapeDescription {
    /// A ball.
    Sphere {
        /// Radius.
        radius_m: f64,
    },
    /// A cylinder with half-spherical caps, along x.
    Spherocylinder {
        /// Radius of cylinder and caps.
        radius_m: f64,
        /// Length over both caps.
        total_length_m: f64,
    },
    /// A solid cylinder with flat caps, along x.
    Cylinder {
        /// Radius.
        radius_m: f64,
        /// Length, from cap to cap.
        length_m: f64,
    },
    /// A cube, edges along the axes.
    Cube {
        /// Edge.
        edge_m: f64,
    },
    /// A cuboid, edges along the axes.
    Box {
        /// Full lengths of the edges along x, y, z.
        size_m: [f64; 3],
    },
    /// A regular tetrahedron, its vertices on four corners of an axis-aligned cube.
    Tetrahedron {
        /// Edge.
        edge_m: f64,
    },
    /// A regular octahedron, its vertices on the axes.
    Octahedron {
        /// Edge.
        edge_m: f64,
    },
    /// The eight-faced pinacoid of railway ballast: a rectangle in the plane z = 0 and two parallel ridges along x.
    ///
    /// Vertices (+-L/2, +-G/2, 0) and (+-l/2, 0, +-H/2) with l = L - H / tan(alpha).
    Pinacoid {
        /// L, along x.
        length_m: f64,
        /// G, along y.
        width_m: f64,
        /// H, along z; below L tan(alpha).
        height_m: f64,
        /// Slope of the end triangles to the plane z = 0.
        alpha_deg: f64,
    },
    /// The convex hull of points.
    ConvexPolyhedron {
        /// The points; inner ones and duplicates are dropped.
        vertices_m: Vec<[f64; 3]>,
    },
    /// A polyhedron swept by a ball (Minkowski sum). Without edges and faces the convex hull of the points; with them
    /// the skeleton as it stands, which need not be convex or closed.
    RoundedPolyhedron {
        /// Radius of the ball.
        radius_m: f64,
        /// Vertices of the skeleton.
        vertices_m: Vec<[f64; 3]>,
        /// Pairs of vertices; those of the faces when empty.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        edges: Vec<[u32; 2]>,
        /// Convex polygons, as loops of vertices.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        faces: Vec<Vec<u32>>,
        /// Computed from the shape when absent, which a skeleton that is not convex does not allow.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        mass_properties: Option<MassDescription>,
    },
    /// Two square beams along x and y that share their centre.
    #[serde(rename = "cross_2d")]
    Cross2d {
        /// Length of each beam.
        beam_length_m: f64,
        /// Width and height of each beam.
        beam_width_m: f64,
    },
    /// Three square beams along x, y and z that share their centre.
    #[serde(rename = "cross_3d")]
    Cross3d {
        /// Length of each beam.
        beam_length_m: f64,
        /// Width and height of each beam.
        beam_width_m: f64,
    },
    /// A rigid union of convex parts, which may overlap.
    Composite {
        /// The parts.
        parts: Vec<PartDescription>,
        /// Computed from the parts when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        mass_properties: Option<MassDescription>,
    },
    /// Out of a file: `.obj` and `.stl` (each closed surface a convex part) or Rockable's `.shp`. Whoever reads the scene
    /// file puts the shape itself here ([`crate::scene::SceneDescription::read_files`]).
    File {
        /// Relative to the scene file.
        path: String,
        /// Metres per unit of the file; `.shp` files are in metres.
        #[serde(default = "one")]
        scale: f64,
        /// Which of the shapes of a `.shp` file; needed where there are several.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        name: Option<String>,
    },
}

fn one() -> f64 {
    1.0
}

/// Mass properties given instead of computed: the origin is the centre of mass, the axes are principal ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MassDescription {
    /// Volume; times the density it is the mass.
    pub volume_m3: f64,
    /// Principal moments of inertia over the mass.
    pub inertia_over_mass_m2: [f64; 3],
}

/// One convex part of a composite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartDescription {
    /// Any convex shape.
    pub shape: Box<ShapeDescription>,
    /// Of the part's own origin, in the frame of the composite.
    #[serde(default)]
    pub position_m: [f64; 3],
    /// Unit quaternion (w, x, y, z) that turns the part's axes into those of the composite.
    #[serde(default = "identity_wxyz")]
    pub orientation_wxyz: [f64; 4],
}

fn identity_wxyz() -> [f64; 4] {
    [1.0, 0.0, 0.0, 0.0]
}

impl ShapeDescription {
    /// The convex hull of points, swept by a ball.
    pub fn rounded_hull(vertices_m: Vec<[f64; 3]>, radius_m: f64) -> Self {
        Self::RoundedPolyhedron { radius_m, vertices_m, edges: Vec::new(), faces: Vec::new(), mass_properties: None }
    }

    /// The value of `kind` in a scene file.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Spherocylinder { .. } => "spherocylinder",
            Self::Cylinder { .. } => "cylinder",
            Self::Cube { .. } => "cube",
            Self::Box { .. } => "box",
            Self::Tetrahedron { .. } => "tetrahedron",
            Self::Octahedron { .. } => "octahedron",
            Self::Pinacoid { .. } => "pinacoid",
            Self::ConvexPolyhedron { .. } => "convex_polyhedron",
            Self::RoundedPolyhedron { .. } => "rounded_polyhedron",
            Self::Cross2d { .. } => "cross_2d",
            Self::Cross3d { .. } => "cross_3d",
            Self::Composite { .. } => "composite",
            Self::File { .. } => "file",
        }
    }
}

impl ShapeDescription {
    /// Whether some part is a polyhedron with sharp edges.
    pub(crate) fn has_sharp_part(&self) -> bool {
        match self {
            Self::Cube { .. }
            | Self::Box { .. }
            | Self::Tetrahedron { .. }
            | Self::Octahedron { .. }
            | Self::Pinacoid { .. }
            | Self::ConvexPolyhedron { .. }
            | Self::Cross2d { .. }
            | Self::Cross3d { .. } => true,
            Self::Sphere { .. }
            | Self::Spherocylinder { .. }
            | Self::Cylinder { .. }
            | Self::RoundedPolyhedron { .. }
            | Self::File { .. } => false,
            Self::Composite { parts, .. } => parts.iter().any(|part| part.shape.has_sharp_part()),
        }
    }
}
