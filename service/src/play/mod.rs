//! A recording on the bus, as if its simulation ran: viewers need no engine.
//!
//! Messages are published as they were recorded, byte for byte, at the pace of simulated time; queries are answered from what
//! has been played so far. `pause`, `resume` and `stop` act on the playback, every other command is refused.

mod pace;
mod player;
mod server;
mod shown;

pub use pace::{Control, Pace, Speed};
pub use player::{Options, play};
pub use shown::Shown;
