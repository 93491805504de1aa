//! Benchmarks: settled beds of fixed parameters, and the cost and quality of a step on them.
//!
//! `workload` says what is simulated, `settle` brings it to rest (kept by `cache`), `measure` times it, alone or
//! repeated (`tiles`), `left_out` what a scene does not use, `fields` samples of fields, and
//! `coupling` a window with a fluid.

mod cache;
mod coupling;
mod fields;
mod given;
mod left_out;
mod measure;
mod memory;
mod settle;
mod tiles;
mod workload;

pub use coupling::{CouplingCost, coupling_costs};
pub use fields::{FieldCost, field_costs};
pub use left_out::{LeftOut, left_out};
pub use measure::{Measurement, NormalLaw, Plan, measure};
pub use memory::{Memory, memory};
pub use settle::settled;
pub use workload::{Size, Workload};
