//! Coarse-grained fields: what may be asked for, and how it is computed. `docs/fields.md` has the formulas.
//!
//! Smearing by a kernel of integral 1 makes fields of particles that satisfy the balances of mass and momentum exactly
//! (Goldhirsch, Granular Matter 12 (2010) 239; Weinhart et al., Granular Matter 14 (2012) 289, for boundaries). `sources`
//! reads a state, `sample` adds up what particles and contacts bring at the points of a `lattice`, `columns` makes
//! quantities of the sums, `averaging` keeps sums over time.

mod averaging;
mod columns;
mod compute;
mod definition;
mod deposit;
mod kernel;
mod lattice;
mod layout;
mod pose;
mod quantity;
mod sample;
mod shape_points;
pub(crate) use shape_points::points_at;
mod sources;
#[cfg(test)]
mod tests;
mod validate;
mod walls;

pub(crate) use averaging::{Average, SavedAverage};
pub use compute::{FieldMean, compute};
pub use definition::{
    AverageWindow, BodyAxis, DEFAULT_CUTOFF_WIDTHS, FieldAverage, FieldColumn, FieldDefinition, FieldFrame, Grid,
    GridCylinder, GridMotion, WidthColumns,
};
pub use kernel::FieldKernel;
pub use quantity::FieldQuantity;
pub use sources::FieldSources;
