//! To and from the engine's types (feature `engine`).
//!
//! Whatever comes in is checked here for what only the wire can get wrong: missing parts, numbers that are not
//! finite, columns of another length or type, unknown enum values. What a value means, and whether it is allowed,
//! is checked by the engine. Both say where: [`InvalidInput::path`] leads into the request.

mod command;
mod contacts;
mod field;
mod fluid;
mod frame;
mod loads;
mod output;
mod recorded;
mod shapes;
mod status;

pub use command::{
    Start, advance_start, gravity_from_wire, insertion_from_wire, insertion_to_wire, motion_from_wire, motion_to_wire,
};
pub use contacts::{NO_BOUNDARY, NO_PARTICLE, contacts_to_wire};
pub use field::{field_definition_from_wire, field_definition_to_wire, field_to_wire, quantity_name};
pub use fluid::{exchange_to_wire, fluid_fields_from_wire, fluid_from_wire};
pub use frame::{float_from_wire, float_to_wire, frame_to_wire};
pub use loads::loads_from_wire;
pub use output::{pace_from_wire, pace_to_wire};
pub use recorded::{contacts_from_wire, snapshot_from_wire};
pub use shapes::shape_to_wire;
pub use status::{boundary_to_wire, domain_to_wire, report_to_wire};

use sturz_engine::InvalidInput;

use crate::v1;

/// `value`, unless it was left out.
fn need<'a, T>(value: &'a Option<T>, path: &str) -> Result<&'a T, InvalidInput> {
    value.as_ref().ok_or_else(|| InvalidInput::new(path, "is missing"))
}

fn finite(value: f64, path: &str) -> Result<f64, InvalidInput> {
    if value.is_finite() { Ok(value) } else { Err(InvalidInput::new(path, format!("is {value}, must be finite"))) }
}

fn vector(value: &v1::Vec3, path: &str) -> Result<[f64; 3], InvalidInput> {
    let component = |value, axis| finite(value, &format!("{path}.{axis}"));
    Ok([component(value.x, "x")?, component(value.y, "y")?, component(value.z, "z")?])
}

fn needed_vector(value: &Option<v1::Vec3>, path: &str) -> Result<[f64; 3], InvalidInput> {
    vector(need(value, path)?, path)
}

/// Zero when it was left out.
fn optional_vector(value: &Option<v1::Vec3>, path: &str) -> Result<[f64; 3], InvalidInput> {
    value.as_ref().map_or(Ok([0.0; 3]), |value| vector(value, path))
}

/// Three components for the wire.
pub fn vec3([x, y, z]: [f64; 3]) -> v1::Vec3 {
    v1::Vec3 { x, y, z }
}
