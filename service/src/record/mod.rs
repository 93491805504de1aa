//! Recordings: what a simulation says on the bus, in an MCAP file.
//!
//! Topics are the keys of the bus, messages those of the wire (protobuf, with the whole schema in the file), so the ordinary
//! MCAP tools read them. `log_time` is the wall clock when a message came in, `publish_time` that when it was made
//! (`Header.wall_time_ns`); simulated time is in each message's header. Answers to `info`, `features`, `plan` and `shapes`
//! are written as messages under their keys, before all others, and again when they have changed.

mod disk;
mod headed;
mod read;
mod recorder;
mod write;

pub use disk::{Disk, EndReason, Queue, StreamTally, Tally, Until};
pub use headed::{Headed, message_of};
pub use read::{Recorded, Recording, RecordingError, Topic};
pub use recorder::{Options, Streams, Summary, record};
pub use write::{MessageTimes, RecordingWriter};
