//! The verbs of a coupled run for C: the blocking client behind a plain C interface, for solvers that are linked with it.
//!
//! | module | purpose |
//! |---|---|
//! | `code` | what every call returns |
//! | `failure` | why the last call of a thread failed; nothing unwinds into C |
//! | `border` | pointers and lengths of the caller, checked |
//! | `simulation` | the connection, what it is, the lease, checkpoints, pause and stop |
//! | `state` | particles into arrays of the caller |
//! | `fluid`, `exchange` | the fluid around them, and what it gets from them |
//! | `loads` | forces on single particles |
//! | `window` | advance by a window |
//! | `participant` | the same in the verbs of preCICE |
//!
//! `include/sturz.h` is made of these files by cbindgen (`tests/header.rs`), comments included. Nothing here decides what is
//! sound: that is left to the daemon, but for what would make this side read or write beyond an array.

#![deny(missing_docs)]
// Pointers cross here, and nowhere else. Types have the names that they have in C.
#![allow(unsafe_code, non_camel_case_types)]
// The rules are the same for all functions; the head of the header has them.
#![allow(clippy::missing_safety_doc)]

mod border;
mod code;
mod exchange;
mod failure;
mod fluid;
mod loads;
mod participant;
mod simulation;
mod state;
mod window;

pub use code::*;
pub use exchange::*;
pub use failure::{sturz_last_error_code, sturz_last_error_message, sturz_last_error_path};
pub use fluid::*;
pub use loads::*;
pub use participant::*;
pub use simulation::*;
pub use state::*;
pub use window::*;
