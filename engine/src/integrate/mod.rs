//! Velocity Verlet for translation, Omelyan's scheme or a symmetric splitting for rotation.

pub mod critical_step;
mod kick_drift;
mod local_damping;
pub mod omelyan;
mod point_step;
mod present_step;
pub mod splitting;

pub use kick_drift::{drift, kick};
pub use local_damping::{LocalDamping, damp_locally};
pub use point_step::point_bounds;
pub(crate) use present_step::present_critical_step;
