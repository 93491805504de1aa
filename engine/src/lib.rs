//! Synchronous discrete element engine of Sturz.

pub mod command;
pub mod error;
pub mod fields;
pub mod math;
pub mod narrow;
pub mod report;
pub mod scene;
pub mod shape;
pub mod snapshot;
pub mod timing;

pub use command::{Command, Effect};
pub use error::{InvalidInput, InvalidScene, StepError};
pub use report::{EnergyBalance, Report, WarningCounts};
pub use snapshot::{BoundaryState, Snapshot};
pub use timing::{Stage, StageTimer};
