//! Commands that take effect at a simulated time, awaited.

use std::time::Duration;

use sturz_protocol::v1;

use crate::aio::Simulation;
use crate::aio::apart::apart;
use crate::error::ClientError;
use crate::outcome::{Applied, Checkpointed, Inserted, Removed};
use crate::queue::Popped;

/// The twin of [`crate::Later`]: what it sends is on its way when a method returns, without waiting.
pub struct Later<'s> {
    blocking: crate::Later<'s>,
}

/// A command on its way. Dropping it does not withdraw the command.
#[must_use = "a refusal is told by `wait` only"]
pub struct Pending<T> {
    blocking: crate::Pending<T>,
}

impl Simulation {
    /// As [`crate::Simulation::later`].
    pub fn later(&self, at_time_s: f64) -> Later<'_> {
        Later { blocking: self.blocking.later(at_time_s) }
    }
}

impl Later<'_> {
    /// As [`crate::Later::insert`].
    pub fn insert(&self, insertion: impl Into<v1::InsertRequest>) -> Result<Pending<Inserted>, ClientError> {
        self.blocking.insert(insertion).map(Pending::new)
    }

    /// As [`crate::Later::remove`].
    pub fn remove(&self, ids: impl IntoIterator<Item = u64>) -> Result<Pending<Removed>, ClientError> {
        self.blocking.remove(ids).map(Pending::new)
    }

    /// As [`crate::Later::set_gravity`].
    pub fn set_gravity(&self, gravity_m_per_s2: [f64; 3]) -> Result<Pending<Applied>, ClientError> {
        self.blocking.set_gravity(gravity_m_per_s2).map(Pending::new)
    }

    /// As [`crate::Later::set_motion`].
    pub fn set_motion(&self, boundary: &str, motion: impl Into<v1::Motion>) -> Result<Pending<Applied>, ClientError> {
        self.blocking.set_motion(boundary, motion).map(Pending::new)
    }

    /// As [`crate::Later::set_loads`].
    pub fn set_loads(&self, loads: impl Into<v1::Loads>) -> Result<Pending<Applied>, ClientError> {
        self.blocking.set_loads(loads).map(Pending::new)
    }

    /// As [`crate::Later::checkpoint`].
    pub fn checkpoint(&self, token: &str, on_disk: bool) -> Result<Pending<Checkpointed>, ClientError> {
        self.blocking.checkpoint(token, on_disk).map(Pending::new)
    }

    /// As [`crate::Later::define_field`].
    pub fn define_field(&self, definition: impl Into<v1::FieldDefinition>) -> Result<Pending<Applied>, ClientError> {
        self.blocking.define_field(definition).map(Pending::new)
    }

    /// As [`crate::Later::define_output`].
    pub fn define_output(&self, output: impl Into<v1::OutputDefinition>) -> Result<Pending<Applied>, ClientError> {
        self.blocking.define_output(output).map(Pending::new)
    }

    /// As [`crate::Later::drop_field`].
    pub fn drop_field(&self, name: &str) -> Result<Pending<Applied>, ClientError> {
        self.blocking.drop_field(name).map(Pending::new)
    }
}

impl<T> Pending<T> {
    fn new(blocking: crate::Pending<T>) -> Self {
        Self { blocking }
    }

    /// Of the request: what to repeat it with.
    pub fn request_id(&self) -> &str {
        self.blocking.request_id()
    }

    /// Waits until it has taken effect, or was refused, for as long as the daemon lives. Dropped, the wait is given up.
    pub async fn wait(self) -> Result<T, ClientError> {
        let popped = self.blocking.question.answers.popped().await;
        self.read(popped, None).await
    }

    /// The same for at most `patience`; after [`ClientError::Timeout`] it can be asked again.
    pub async fn wait_for(&self, patience: Duration) -> Result<T, ClientError> {
        let answers = self.blocking.question.answers.popped();
        let popped = tokio::time::timeout(patience, answers).await.unwrap_or(Popped::TimedOut);
        self.read(popped, Some(patience)).await.map_err(|error| self.blocking.with_id(error))
    }

    async fn read(&self, popped: Popped<crate::bus::Payload>, patience: Option<Duration>) -> Result<T, ClientError> {
        let (bus, what) = (self.blocking.simulation.bus.clone(), self.blocking.question.what.clone());
        let answer = match popped {
            Popped::Ended => apart(move || bus.read_answer(&what, Popped::Ended, patience)).await?,
            there => bus.read_answer(&what, there, patience),
        };
        self.blocking.read(answer)
    }
}
