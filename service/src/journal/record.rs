//! What the journal says: one record for each thing that came from outside and decides the future of the run.
//!
//! Protobuf, so that old logs can be read by newer programs: numbers are never used again.

use prost::bytes::Bytes;
use prost::{Message, Oneof};
use sturz_protocol::v1;

/// One entry of the log.
#[derive(Clone, PartialEq, Message)]
pub struct Record {
    /// 0, 1, 2, ... without gaps.
    #[prost(uint64, tag = "1")]
    pub sequence: u64,
    /// Steps done by the engine when it happened.
    #[prost(uint64, tag = "2")]
    pub step: u64,
    /// What happened.
    #[prost(oneof = "Entry", tags = "3, 4, 5, 6, 7, 8, 9")]
    pub entry: Option<Entry>,
}

/// What happened.
#[derive(Clone, PartialEq, Oneof)]
pub enum Entry {
    /// A daemon began to serve.
    #[prost(message, tag = "3")]
    Start(Start),
    /// A command was accepted.
    #[prost(message, tag = "4")]
    Command(Accepted),
    /// A command that had been accepted before came to its end.
    #[prost(message, tag = "5")]
    Settled(v1::Outcome),
    /// A command that had waited for its simulated time took effect.
    #[prost(message, tag = "6")]
    Due(Due),
    /// The holder of the lease was lost.
    #[prost(message, tag = "7")]
    LeaseLost(LeaseLost),
    /// The state here, to be checked against.
    #[prost(message, tag = "8")]
    Mark(Mark),
    /// The daemon ended in good order.
    #[prost(message, tag = "9")]
    End(Mark),
}

/// A daemon began to serve.
#[derive(Clone, PartialEq, Message)]
pub struct Start {
    /// Of the program.
    #[prost(string, tag = "1")]
    pub version: String,
    /// Of this start.
    #[prost(string, tag = "2")]
    pub run_id: String,
    /// Nanoseconds since 1970.
    #[prost(uint64, tag = "3")]
    pub wall_time_ns: u64,
    /// It waits for commands, whatever it did before.
    #[prost(bool, tag = "4")]
    pub paused: bool,
    /// Of the physics.
    #[prost(uint32, tag = "5")]
    pub threads: u32,
    /// Of the run: unless it is paused, it steps.
    #[prost(bool, tag = "6")]
    pub is_first: bool,
}

/// A command that was accepted.
#[derive(Clone, PartialEq, Message)]
pub struct Accepted {
    /// Such as `set_gravity`.
    #[prost(string, tag = "1")]
    pub verb: String,
    /// As it came.
    #[prost(bytes = "bytes", tag = "2")]
    pub request: Bytes,
    /// Absent: a `Settled` or a `Due` follows.
    #[prost(message, optional, tag = "3")]
    pub outcome: Option<v1::Outcome>,
}

/// The next of the commands that wait for their simulated time took effect.
#[derive(Clone, PartialEq, Message)]
pub struct Due {
    /// Absent: a `Settled` follows.
    #[prost(message, optional, tag = "1")]
    pub outcome: Option<v1::Outcome>,
}

/// The holder of the lease was lost.
#[derive(Clone, PartialEq, Message)]
pub struct LeaseLost {
    /// Its client id.
    #[prost(string, tag = "1")]
    pub holder: String,
}

/// The state at a record.
#[derive(Clone, Copy, PartialEq, Message)]
pub struct Mark {
    /// As in reports.
    #[prost(fixed64, tag = "1")]
    pub state_hash: u64,
    /// Simulated time, s.
    #[prost(double, tag = "2")]
    pub time_s: f64,
}

/// What a snapshot says beside the engine's checkpoint: the state of the daemon between two records.
#[derive(Clone, PartialEq, Message)]
pub struct DaemonState {
    /// Of the first record after it.
    #[prost(uint64, tag = "1")]
    pub sequence: u64,
    /// It steps freely.
    #[prost(bool, tag = "2")]
    pub running: bool,
    /// Where it pauses, s.
    #[prost(double, optional, tag = "3")]
    pub stop_time_s: Option<f64>,
    /// Defined fields.
    #[prost(message, repeated, tag = "4")]
    pub fields: Vec<v1::FieldDefinition>,
    /// Outcomes, oldest first.
    #[prost(message, repeated, tag = "5")]
    pub remembered: Vec<Remembered>,
    /// Commands that wait for their simulated time, next first.
    #[prost(message, repeated, tag = "6")]
    pub scheduled: Vec<Accepted>,
    /// The step command or window under way.
    #[prost(message, optional, tag = "7")]
    pub window: Option<WindowState>,
    /// The last window that has led to where the engine is.
    #[prost(message, optional, tag = "8")]
    pub last_window: Option<Key>,
    /// Tokens that the daemon has made.
    #[prost(uint64, tag = "9")]
    pub tokens_made: u64,
    /// Checkpoints; the bytes of those in memory follow in this order.
    #[prost(message, repeated, tag = "10")]
    pub tokens: Vec<v1::Checkpoint>,
    /// Empty when nobody holds the lease.
    #[prost(string, tag = "11")]
    pub lease_holder: String,
    /// What streams hold, and when.
    #[prost(message, repeated, tag = "20")]
    pub outputs: Vec<v1::OutputDefinition>,
}

/// Which request of which client.
#[derive(Clone, PartialEq, Eq, Message)]
pub struct Key {
    /// As the client calls itself.
    #[prost(string, tag = "1")]
    pub client_id: String,
    /// As the client calls it.
    #[prost(string, tag = "2")]
    pub request_id: String,
}

/// A settled request.
#[derive(Clone, PartialEq, Message)]
pub struct Remembered {
    /// Of its command and payload.
    #[prost(fixed64, tag = "1")]
    pub fingerprint: u64,
    /// What became of it, with its key.
    #[prost(message, optional, tag = "2")]
    pub outcome: Option<v1::Outcome>,
}

/// A step command or window under way.
#[derive(Clone, PartialEq, Message)]
pub struct WindowState {
    /// Its command.
    #[prost(message, optional, tag = "1")]
    pub command: Option<Accepted>,
    /// Steps done at its start.
    #[prost(uint64, tag = "2")]
    pub begun_step: u64,
    /// Simulated time at its start, s.
    #[prost(double, tag = "3")]
    pub begun_time_s: f64,
    /// Simulated time at its end, s.
    #[prost(double, tag = "4")]
    pub to_time_s: f64,
    /// Steps that it was cut into.
    #[prost(uint64, tag = "5")]
    pub steps_total: u64,
    /// Of these, done.
    #[prost(uint64, tag = "6")]
    pub steps_done: u64,
}
