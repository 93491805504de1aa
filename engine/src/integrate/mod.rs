//! Velocity Verlet for translation, Omelyan's scheme for rotation.

pub mod critical_step;
mod kick_drift;
pub mod omelyan;

pub use kick_drift::{drift, kick};
