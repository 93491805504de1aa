//! Client of the Sturz daemon, blocking and asynchronous: steer a running simulation of granular matter, and look at it.
//!
//! | module | purpose |
//! |---|---|
//! | `simulation` | the connection, questions, streams |
//! | `command`, `later` | what changes the simulation, at once or at a simulated time |
//! | [`aio`] | the same for asynchronous code |
//! | `call`, `request`, `loads`, `outcome` | what a command asks for, what became of it |
//! | `state`, `contacts`, `field` | particles, their contacts and fields as arrays |
//! | `stream`, `output` | frames as the daemon publishes them, and what they are to hold |
//! | `bus`, `watch`, `queue` | the zenoh session: callbacks enqueue, callers wait |
//! | `target`, `loss` | where the daemon is, certificates, and why it is gone |
//!
//! Units are SI and in the names. Every method of [`Simulation`] may be called from any thread, and blocks until the daemon
//! has answered; those of [`aio::Simulation`] are awaited. What is small
//! and plain comes as the message of the wire ([`v1`]); arrays are decoded.
//!
//! ```no_run
//! use std::time::Duration;
//! use sturz_client::{DEFAULT_ENDPOINT, Insertion, Placement, Simulation, Window};
//!
//! let simulation = Simulation::connect("drum-crosses", DEFAULT_ENDPOINT, Duration::from_secs(5))?;
//! let info = simulation.info()?;
//! simulation.pause()?;
//!
//! let positions_m = vec![[0.0, 0.0, 0.0], [0.02, 0.0, 0.0]];
//! let insertion = Insertion::new(&info.shapes[0], &info.materials[0], Placement::poses(positions_m));
//! let inserted = simulation.insert(insertion)?;
//! assert_eq!(inserted.ids.count(), 2);
//!
//! let window = Window::new(0.01).with_columns(["positions"]);
//! let advanced = simulation.advance(window)?;
//! println!("at {} s: {:?}", advanced.time_reached_s, advanced.state.map(|state| state.positions_m()).transpose()?);
//!
//! for report in simulation.reports()?.take(3) {
//!     println!("largest overlap: {:.1e}", report?.largest_overlap_ratio);
//! }
//! # Ok::<(), sturz_client::ClientError>(())
//! ```

#![deny(missing_docs)]

pub mod aio;
mod bus;
mod call;
mod command;
mod contacts;
mod error;
mod field;
mod fluid;
mod later;
mod loads;
mod loss;
mod outcome;
mod output;
mod queue;
mod request;
mod simulation;
mod state;
mod stream;
mod target;
mod watch;

pub use contacts::{Contacts, NO_BOUNDARY, NO_PARTICLE};
pub use error::{ClientError, Refusal};
pub use field::{Field, FieldDefinition};
pub use fluid::{Exchange, FluidFields};
pub use later::{Later, Pending};
pub use loads::Loads;
pub use loss::Loss;
pub use outcome::{Advanced, Applied, Checkpointed, Inserted, Moment, Removed, Restored, Stepped};
pub use output::{Output, Pace};
pub use request::{Amount, FloatType, Insertion, Motion, Placement, Region, Start, Window};
pub use simulation::{DEFAULT_ENDPOINT, Simulation};
pub use state::State;
pub use stream::{Stream, StreamCounts};
pub use sturz_protocol::{Request, v1};
pub use target::{Target, Tls};
