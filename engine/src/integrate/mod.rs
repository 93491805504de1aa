//! Velocity Verlet for translation, Omelyan's scheme or a symmetric splitting for rotation.

pub mod critical_step;
mod kick_drift;
pub mod omelyan;
pub mod splitting;

pub use kick_drift::{drift, kick};
