//! What a client asks for when it defines a field, and what it gets.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::kernel::FieldKernel;
use super::quantity::FieldQuantity;

/// Grid of sample points at cell centres: cartesian, or cylindrical where `cylinder` is given.
///
/// One cell along an axis means that this direction is homogeneous: the field is averaged over the whole extent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Lower corner; of a cylindrical grid radius (m), angle (rad) and height (m).
    pub min_m: [f64; 3],
    /// Upper corner.
    pub max_m: [f64; 3],
    /// Cells along each axis, at least 1.
    pub cells: [u32; 3],
    /// Makes the axes of the grid radius, angle and height, and those of vectors the local ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cylinder: Option<GridCylinder>,
}

/// The axis of a cylindrical grid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GridCylinder {
    /// Height 0 on the axis.
    pub point_m: [f64; 3],
    /// Direction of the axis; need not be a unit vector.
    pub axis: [f64; 3],
    /// Where the angle is 0, as far as it is at right angles to the axis; x when absent, y where the axis is near x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zero: Option<[f64; 3]>,
}

/// What a grid moves with. Vectors and tensors have the axes of the moved grid; velocities stay those of the resting
/// frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum GridMotion {
    /// At a constant velocity, from where it is given at time 0.
    Translation {
        /// m/s
        velocity_m_per_s: [f64; 3],
    },
    /// With a boundary, from where it is given while the boundary is where the scene has it.
    Boundary {
        /// Of the boundary.
        name: String,
    },
}

/// An axis of the body frame (principal axes, as in orientations).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BodyAxis {
    /// That of the smallest moment of inertia of each shape, the first of equal ones.
    #[default]
    Longest,
    /// That of the largest moment of inertia, the first of equal ones.
    Shortest,
    /// First.
    X,
    /// Second.
    Y,
    /// Third.
    Z,
}

/// Which samples a mean is over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AverageWindow {
    /// All since the beginning. When there are twice as many blocks as asked for, each two become one.
    #[default]
    Growing,
    /// The last so many blocks, and the one that is being filled.
    Sliding,
}

/// Mean over time, with standard errors from the scatter of blocks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldAverage {
    /// Steps from one sample to the next: those whose number is a multiple.
    pub every_steps: u64,
    /// Samples of a block: long enough that blocks know nothing of each other.
    pub samples_per_block: u64,
    /// Blocks.
    #[serde(default = "default_blocks")]
    pub blocks: u32,
    /// Which of them.
    #[serde(default)]
    pub window: AverageWindow,
    /// Nothing is sampled before this simulated time.
    #[serde(default)]
    pub from_time_s: f64,
}

fn default_blocks() -> u32 {
    20
}

/// A field that can be asked for by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldDefinition {
    /// Name: letters, digits, `_` and `-`.
    pub name: String,
    /// What is sampled.
    pub quantities: Vec<FieldQuantity>,
    /// Coarse-graining width w of the kernel exp(-R^2 / (2 w^2)).
    pub width_m: f64,
    /// Kernel support over the width.
    #[serde(default = "default_cutoff")]
    pub cutoff_widths: f64,
    /// Further widths, sampled in the same pass.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub more_widths_m: Vec<f64>,
    /// Form of the kernel.
    #[serde(default)]
    pub kernel: FieldKernel,
    /// Gives what plane walls cut off a kernel back to its part in front of them.
    #[serde(default)]
    pub wall_correction: bool,
    /// Axis whose orientation is sampled.
    #[serde(default)]
    pub body_axis: BodyAxis,
    /// Where it is sampled.
    pub grid: Grid,
    /// Mean over time instead of the state of now.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub average: Option<FieldAverage>,
    /// What the grid moves with; it rests when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<GridMotion>,
}

/// Support over width where nothing is said.
pub const DEFAULT_CUTOFF_WIDTHS: f64 = 4.0;

fn default_cutoff() -> f64 {
    DEFAULT_CUTOFF_WIDTHS
}

impl FieldDefinition {
    /// Of a truncated Gaussian at rest, of the state of now.
    pub fn new(name: impl Into<String>, grid: Grid, quantities: &[FieldQuantity], width_m: f64) -> Self {
        Self {
            name: name.into(),
            grid,
            quantities: quantities.to_vec(),
            width_m,
            cutoff_widths: DEFAULT_CUTOFF_WIDTHS,
            ..Self::default()
        }
    }

    /// All widths, the main one first.
    pub fn widths_m(&self) -> impl Iterator<Item = f64> + '_ {
        std::iter::once(self.width_m).chain(self.more_widths_m.iter().copied())
    }

    /// Whether any of its quantities takes contacts.
    pub fn needs_contacts(&self) -> bool {
        self.quantities.iter().any(|quantity| quantity.needs_contacts())
    }
}

/// One quantity on the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldColumn {
    /// Which.
    pub quantity: FieldQuantity,
    /// Components per cell.
    pub components: usize,
    /// Shape (nx, ny, nz, components), row-major: x slowest.
    pub data: Vec<f64>,
    /// Standard error of the mean, of the same shape; of a mean over two blocks or more.
    pub standard_error: Option<Vec<f64>>,
}

/// The columns of a further width.
#[derive(Clone, Debug, PartialEq)]
pub struct WidthColumns {
    /// Width of the kernel.
    pub width_m: f64,
    /// In the order asked for.
    pub columns: Vec<FieldColumn>,
}

/// A sampled field.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldFrame {
    /// Name of the definition.
    pub name: String,
    /// Step of the state that was sampled, last if there are several.
    pub step: u64,
    /// Its time.
    pub time_s: f64,
    /// Where it was sampled, before any motion.
    pub grid: Grid,
    /// Origin of the moved grid's frame, m; 0 at rest.
    pub grid_origin_m: [f64; 3],
    /// World from the axes of the moved grid (w, x, y, z), the cylinder's own axes apart.
    pub grid_orientation_wxyz: [f64; 4],
    /// Form of the kernel.
    pub kernel: FieldKernel,
    /// Width of the kernel.
    pub width_m: f64,
    /// Support of the kernel over the width.
    pub cutoff_widths: f64,
    /// In the order asked for.
    pub columns: Vec<FieldColumn>,
    /// Of the further widths.
    pub more_widths: Vec<WidthColumns>,
    /// Mass of all particles, kg: what the integral of the density is checked against.
    pub total_mass_kg: f64,
    /// Momentum of all particles, kg m/s.
    pub total_momentum_kg_m_per_s: [f64; 3],
    /// Samples that the mean is over; 1 for the state of now, 0 before the first.
    pub samples: u64,
    /// Complete blocks that the errors are from; 0 for the state of now.
    pub blocks: u64,
    /// Time of the first sample.
    pub from_time_s: f64,
}
