//! Synchronous discrete element engine of Sturz.

pub mod math;
pub mod narrow;
pub mod shape;
