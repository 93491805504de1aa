//! From what a user wrote to what the engine can run.

mod description;

pub use description::*;
