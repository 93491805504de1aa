//! Coarse-grained fields.

mod definition;

pub use definition::{FieldColumn, FieldDefinition, FieldFrame, FieldQuantity, Grid};
