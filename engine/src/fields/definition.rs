//! What a client asks for when it defines a field, and what it gets.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A coarse-grained quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FieldQuantity {
    /// Volume of the particles per volume (point mass form), 1 component.
    SolidFraction,
    /// kg/m3, 1 component.
    Density,
    /// kg/(m2 s), 3 components.
    Momentum,
    /// Momentum over density, m/s, 3 components; 0 where the density is 0.
    Velocity,
    /// tr(kinetic stress) / (3 density), m2/s2, 1 component; 0 where the density is 0.
    GranularTemperature,
}

/// Cartesian grid of sample points at cell centres.
///
/// One cell along an axis means that this direction is homogeneous: the field is averaged over the whole extent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Lower corner.
    pub min_m: [f64; 3],
    /// Upper corner.
    pub max_m: [f64; 3],
    /// Cells along each axis, at least 1.
    pub cells: [u32; 3],
}

/// A field that can be asked for by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldDefinition {
    /// Name: letters, digits, `_` and `-`.
    pub name: String,
    /// Where it is sampled.
    pub grid: Grid,
    /// What is sampled.
    pub quantities: Vec<FieldQuantity>,
    /// Coarse-graining width w of the kernel exp(-R^2 / (2 w^2)).
    pub width_m: f64,
    /// Kernel support over the width.
    #[serde(default = "default_cutoff")]
    pub cutoff_widths: f64,
}

fn default_cutoff() -> f64 {
    4.0
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
}

/// A sampled field.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldFrame {
    /// Name of the definition.
    pub name: String,
    /// Step of the state that was sampled.
    pub step: u64,
    /// Its time.
    pub time_s: f64,
    /// Where it was sampled.
    pub grid: Grid,
    /// Width of the kernel.
    pub width_m: f64,
    /// Support of the kernel over the width.
    pub cutoff_widths: f64,
    /// In the order asked for.
    pub columns: Vec<FieldColumn>,
    /// Mass of all particles, kg: what the integral of the density is checked against.
    pub total_mass_kg: f64,
    /// Momentum of all particles, kg m/s.
    pub total_momentum_kg_m_per_s: [f64; 3],
}
