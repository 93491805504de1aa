//! Why a checkpoint is not written or not taken.

use thiserror::Error;

use crate::error::InvalidInput;

/// Why a checkpoint was refused; the engine is as it was.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum CheckpointError {
    /// The run has failed: its state leads nowhere.
    #[error("the run has failed and cannot go on, nor be saved: restore an earlier checkpoint ({reason})")]
    RunFailed {
        /// Why it failed.
        reason: String,
    },
    /// Something else.
    #[error("is no checkpoint: it does not begin as one")]
    NoCheckpoint,
    /// Of a later version of this program.
    #[error(
        "has format {found}, this program reads format {known}: use the version of Sturz that wrote it, or a newer one"
    )]
    OtherFormat {
        /// As written.
        found: u32,
        /// As read here.
        known: u32,
    },
    /// Cut short, or with something behind its end.
    #[error("has {found} bytes, and {wanted} were written: it was cut short or added to")]
    WrongLength {
        /// Bytes there.
        found: u64,
        /// Bytes written.
        wanted: u64,
    },
    /// Some byte is another one than was written.
    #[error("is damaged: its checksum is {found:016x} instead of {wanted:016x}")]
    Damaged {
        /// Of the bytes there.
        found: u64,
        /// As written.
        wanted: u64,
    },
    /// The bytes are as written, and still make no sense.
    #[error("its section {section} {problem}")]
    Malformed {
        /// Four letters.
        section: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// It belongs to another scene.
    #[error(
        "is of another scene: {} differ; start the scene that it was written from",
        .differing.iter().map(|part| format!("[{part}]")).collect::<Vec<_>>().join(", ")
    )]
    OtherScene {
        /// Sections of the scene file that are not the same.
        differing: Vec<&'static str>,
    },
    /// A value that no engine can have.
    #[error("cannot be a state of this scene: {0}")]
    Impossible(#[from] InvalidInput),
    /// What was put together is not what was taken apart.
    #[error(
        "gives a state of hash {found:016x} instead of {wanted:016x}: it was written by another version of the engine"
    )]
    OtherState {
        /// Of the state that it gives.
        found: u64,
        /// Of the state that was saved.
        wanted: u64,
    },
}
