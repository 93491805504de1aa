//! Coarse-grained fields: what may be asked for, and how it is computed.

mod compute;
mod definition;

pub use compute::{FieldSample, compute};
pub use definition::{FieldColumn, FieldDefinition, FieldFrame, FieldQuantity, Grid};
