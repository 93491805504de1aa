//! Benchmarks: settled beds of fixed parameters, and the cost and quality of a step on them.
//!
//! `workload` says what is simulated, `settle` brings it to rest (kept by `cache`), `measure` times it.

mod cache;
mod given;
mod measure;
mod settle;
mod workload;

pub use measure::{Measurement, NormalLaw, Plan, measure};
pub use settle::settled;
pub use workload::{Size, Workload};
