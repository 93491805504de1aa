//! The only way to the physics thread: a bounded queue of letters, read between two steps.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::time::Instant;

use sturz_engine::fields::FieldFrame;
use sturz_engine::{ContactNetwork, Exchange, Report, Snapshot};
use sturz_protocol::v1;
use tokio::sync::oneshot;

use crate::order::{Order, Outputs};

/// What the physics thread may be asked.
pub enum Letter {
    /// A command.
    Command(Box<Order>, ReplyTo),
    /// A question about the state.
    Read(Read, oneshot::Sender<ReadAnswer>),
    /// Somebody began to listen, or the daemon is to end: look around.
    Wake,
}

/// Where the answer to a command goes. It may be sent from any thread, and never waits.
pub type ReplyTo = oneshot::Sender<Answer>;

/// Outcome of a command, and the data that the I/O side shall encode into it.
#[derive(Clone)]
pub struct Answer {
    /// Without the data.
    pub outcome: v1::Outcome,
    /// The data.
    pub capture: Option<Arc<Capture>>,
}

/// State and fields of one moment, copied for one client.
pub struct Capture {
    /// What was asked for.
    pub outputs: Outputs,
    /// Present when columns were asked for.
    pub snapshot: Option<Snapshot>,
    /// In the order asked for.
    pub fields: Vec<FieldFrame>,
    /// Present when it was asked for.
    pub contacts: Option<ContactNetwork>,
    /// Present when it was asked for and there is a fluid with a mesh.
    pub exchange: Option<Exchange>,
}

/// A question about the state.
pub enum Read {
    /// For `info`.
    Status,
    /// For `report/latest`.
    Report,
    /// For `state/latest`.
    State {
        /// Forces and torques too.
        forces: bool,
    },
    /// For `contacts/latest`.
    Contacts,
    /// For `exchange/latest`.
    Exchange,
    /// For `field/<name>/latest`.
    Field(String),
}

/// The answer to a question about the state.
pub enum ReadAnswer {
    /// For `info`.
    Status(Box<Status>),
    /// For `report/latest`.
    Report(Box<ReportSample>),
    /// For `state/latest`.
    State(Box<Snapshot>),
    /// For `contacts/latest`.
    Contacts(Box<ContactNetwork>),
    /// For `exchange/latest`.
    Exchange(Box<Exchange>),
    /// For `field/<name>/latest`.
    Field(Box<FieldFrame>),
    /// There is no such thing.
    Refused(v1::Error),
}

/// What changes of `info`.
#[derive(Clone, Debug)]
pub struct Status {
    /// Whether it steps.
    pub state: v1::RunState,
    /// Why it failed; empty otherwise.
    pub failure: String,
    /// Steps done.
    pub step: u64,
    /// Simulated time.
    pub time_s: f64,
    /// Time step in use.
    pub time_step_s: f64,
    /// Particles present.
    pub particles: u64,
    /// Counts insertions and removals.
    pub topology_epoch: u64,
    /// Of the whole state.
    pub state_hash: u64,
    /// Acceleration of gravity.
    pub gravity_m_per_s2: [f64; 3],
    /// Defined fields.
    pub fields: Vec<v1::FieldDefinition>,
    /// Empty when nobody holds the lease.
    pub lease_holder: String,
    /// What each stream holds, and when.
    pub outputs: Vec<v1::OutputDefinition>,
}

/// A report with what only the daemon knows.
#[derive(Clone, Debug, Default)]
pub struct ReportSample {
    /// The engine's part.
    pub engine: Report,
    /// Counts insertions and removals.
    pub topology_epoch: u64,
    /// Of the whole state.
    pub state_hash: u64,
    /// Whether it steps.
    pub state: v1::RunState,
    /// The window under way.
    pub progress: Option<v1::Progress>,
    /// Cost of each stage since the report before.
    pub stages: Vec<v1::StageCost>,
    /// Simulated seconds per wall second since the report before.
    pub sim_s_per_wall_s: f64,
    /// Since the report before.
    pub steps_per_wall_s: f64,
    /// Longest wall time from the end of a step to that of the next one, since the report before.
    pub longest_pause_s: f64,
    /// Frames of each stream.
    pub streams: Vec<v1::StreamCounts>,
    /// Wall seconds since the start.
    pub wall_s: f64,
}

/// The writing end; cheap to clone.
#[derive(Clone)]
pub struct Mailbox {
    letters: SyncSender<Letter>,
}

/// Why a letter was not taken; the letter comes back.
pub enum Undelivered {
    /// The queue is full: the sender may try again.
    Full(Letter),
    /// The physics has ended.
    Closed(Letter),
}

/// The reading end, owned by the physics thread.
pub struct Inbox {
    letters: Receiver<Letter>,
    /// What ended a wait, to be read first.
    first: Option<Letter>,
}

/// A mailbox that holds at most `capacity` letters.
pub fn mailbox(capacity: usize) -> (Mailbox, Inbox) {
    let (sender, receiver) = sync_channel(capacity);
    (Mailbox { letters: sender }, Inbox { letters: receiver, first: None })
}

impl Mailbox {
    /// Delivers, or says at once that it cannot.
    pub fn deliver(&self, letter: Letter) -> Result<(), Undelivered> {
        self.letters.try_send(letter).map_err(|error| match error {
            TrySendError::Full(letter) => Undelivered::Full(letter),
            TrySendError::Disconnected(letter) => Undelivered::Closed(letter),
        })
    }

    /// Ends a wait of the physics thread. A full mailbox does that too, hence no error.
    pub fn wake(&self) {
        drop(self.letters.try_send(Letter::Wake));
    }
}

impl Inbox {
    /// The next letter, if there is one.
    pub fn take(&mut self) -> Option<Letter> {
        self.first.take().or_else(|| self.letters.try_recv().ok())
    }

    /// Sleeps until there is a letter, or until `deadline`. `false` when there will never be one.
    pub fn wait(&mut self, deadline: Option<Instant>) -> bool {
        if self.first.is_some() {
            return true;
        }
        let received = match deadline {
            None => self.letters.recv().map_err(|_| RecvTimeoutError::Disconnected),
            Some(deadline) => self.letters.recv_timeout(deadline.saturating_duration_since(Instant::now())),
        };
        match received {
            Ok(letter) => self.first = Some(letter),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return false,
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_full_mailbox_gives_the_letter_back_and_never_waits() {
        let (mailbox, mut inbox) = mailbox(2);
        assert!(mailbox.deliver(Letter::Wake).is_ok());
        assert!(mailbox.deliver(Letter::Wake).is_ok());
        assert!(matches!(mailbox.deliver(Letter::Wake), Err(Undelivered::Full(Letter::Wake))));
        mailbox.wake();
        assert!(inbox.take().is_some() && inbox.take().is_some() && inbox.take().is_none());
        drop(inbox);
        assert!(matches!(mailbox.deliver(Letter::Wake), Err(Undelivered::Closed(_))));
    }

    #[test]
    fn a_wait_loses_no_letter_and_ends_in_time() {
        let (mailbox, mut inbox) = mailbox(2);
        mailbox.wake();
        assert!(inbox.wait(None));
        assert!(inbox.take().is_some());
        assert!(inbox.wait(Some(Instant::now() + Duration::from_millis(1))));
        assert!(inbox.take().is_none());
        drop(mailbox);
        assert!(!inbox.wait(None));
    }
}
