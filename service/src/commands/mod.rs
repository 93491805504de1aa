//! What each command of `sturz` does.

mod certs;
mod check;
mod export;
mod fields;
mod inspect;
mod play;
mod prepare;
mod record;
mod replay;
mod run;
mod scenes;
mod serve;
mod study;
mod table;
mod top;

use thiserror::Error;

pub use certs::certs;
pub use check::check;
pub use export::export;
pub use fields::fields;
pub use inspect::inspect;
pub(crate) use inspect::{Place, ask, connect};
pub use play::play;
pub use prepare::prepare;
pub use record::record;
pub use replay::replay;
pub use run::run;
pub use scenes::{scenes, schema};
pub use serve::serve;
pub use study::study;
pub use top::top;

/// Why a command did not do what was asked.
#[derive(Debug, Error)]
pub enum Failure {
    /// The command line asks for what cannot be.
    #[error("{0}")]
    Usage(String),
    /// The scene cannot be used.
    #[error("{0}")]
    Scene(String),
    /// The daemon cannot be there.
    #[error("{0}")]
    Bus(String),
    /// Nobody answers.
    #[error("{0}")]
    NoDaemon(String),
    /// The report on standard output has said it all; the exit code remains.
    #[error("see the report")]
    Reported(u8),
    /// Something else.
    #[error("{0:#}")]
    Other(#[from] anyhow::Error),
}

impl Failure {
    /// The failure that an error of another kind hides, where it does.
    fn from_any(error: anyhow::Error) -> Self {
        error.downcast().unwrap_or_else(Failure::Other)
    }

    /// As in `sturz --help`.
    pub fn exit_code(&self) -> u8 {
        match self {
            Failure::Other(_) => 1,
            Failure::Usage(_) => 2,
            Failure::Scene(_) => 3,
            Failure::Bus(_) => 5,
            Failure::NoDaemon(_) => 6,
            Failure::Reported(code) => *code,
        }
    }
}

/// Prints a value as JSON on standard output.
fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(anyhow::Error::from)?;
    println!("{text}");
    Ok(())
}

/// The runtime that zenoh needs.
fn runtime() -> Result<tokio::runtime::Runtime, Failure> {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
    Ok(runtime.map_err(anyhow::Error::from)?)
}
