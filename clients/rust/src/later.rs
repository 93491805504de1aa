//! Commands that take effect at a simulated time.

use std::time::Duration;

use prost::bytes::Bytes;
use sturz_protocol::v1;

use crate::bus::Question;
use crate::call::{self, Call};
use crate::error::ClientError;
use crate::outcome::{Applied, Checkpointed, Inserted, Kind, Removed, accepted};
use crate::simulation::{Simulation, decode};

/// Commands that take effect before the first step that starts at or after a simulated time.
///
/// Each returns as soon as it is on its way, in order with what follows; its [`Pending`] waits for the outcome, which
/// comes when the simulation has got there: do not wait for it on the thread that is to advance a paused simulation.
pub struct Later<'s> {
    pub(crate) simulation: &'s Simulation,
    pub(crate) at_time_s: f64,
}

/// A command on its way. Dropping it does not withdraw the command.
#[must_use = "a refusal is told by `wait` only"]
pub struct Pending<T> {
    pub(crate) simulation: Simulation,
    pub(crate) question: Question,
    command: &'static str,
    request_id: String,
    read: fn(v1::Outcome) -> Result<T, ClientError>,
}

impl Later<'_> {
    fn send<K: Kind>(&self, call: Call<K>) -> Result<Pending<K>, ClientError> {
        let request = self.simulation.signed(call.request, Some(self.at_time_s));
        let question = self.simulation.send_command(&request, None)?;
        let request_id = request.header().map(|header| header.request_id.clone()).unwrap_or_default();
        let command = request.verb().name();
        Ok(Pending { simulation: self.simulation.clone(), question, command, request_id, read: Call::<K>::read })
    }

    /// As [`Simulation::insert`].
    pub fn insert(&self, insertion: impl Into<v1::InsertRequest>) -> Result<Pending<Inserted>, ClientError> {
        self.send(call::insert(insertion.into()))
    }

    /// As [`Simulation::remove`].
    pub fn remove(&self, ids: impl IntoIterator<Item = u64>) -> Result<Pending<Removed>, ClientError> {
        self.send(call::remove(ids))
    }

    /// As [`Simulation::set_gravity`].
    pub fn set_gravity(&self, gravity_m_per_s2: [f64; 3]) -> Result<Pending<Applied>, ClientError> {
        self.send(call::set_gravity(gravity_m_per_s2))
    }

    /// As [`Simulation::set_motion`].
    pub fn set_motion(&self, boundary: &str, motion: impl Into<v1::Motion>) -> Result<Pending<Applied>, ClientError> {
        self.send(call::set_motion(boundary, motion.into()))
    }

    /// As [`Simulation::set_loads`].
    pub fn set_loads(&self, loads: impl Into<v1::Loads>) -> Result<Pending<Applied>, ClientError> {
        self.send(call::set_loads(loads.into()))
    }

    /// As [`Simulation::checkpoint`], and [`Simulation::checkpoint_on_disk`].
    pub fn checkpoint(&self, token: &str, on_disk: bool) -> Result<Pending<Checkpointed>, ClientError> {
        self.send(call::checkpoint(token, on_disk))
    }

    /// As [`Simulation::define_field`].
    pub fn define_field(&self, definition: impl Into<v1::FieldDefinition>) -> Result<Pending<Applied>, ClientError> {
        self.send(call::define_field(definition.into()))
    }

    /// As [`Simulation::define_output`].
    pub fn define_output(&self, output: impl Into<v1::OutputDefinition>) -> Result<Pending<Applied>, ClientError> {
        self.send(call::define_output(output.into()))
    }

    /// As [`Simulation::drop_field`].
    pub fn drop_field(&self, name: &str) -> Result<Pending<Applied>, ClientError> {
        self.send(call::drop_field(name))
    }
}

impl<T> Pending<T> {
    /// Of the request: what to repeat it with.
    pub fn request_id(&self) -> &str {
        &self.request_id
    }

    /// Waits until it has taken effect, or was refused, for as long as the daemon lives.
    pub fn wait(self) -> Result<T, ClientError> {
        self.outcome(None)
    }

    /// The same for at most `patience`; after [`ClientError::Timeout`] it can be asked again.
    pub fn wait_for(&self, patience: Duration) -> Result<T, ClientError> {
        self.outcome(Some(patience)).map_err(|error| self.with_id(error))
    }

    /// A timeout says which request to ask again with.
    pub(crate) fn with_id(&self, error: ClientError) -> ClientError {
        match error {
            ClientError::Timeout { what, after, .. } => {
                ClientError::Timeout { what, after, request_id: Some(self.request_id.clone()) }
            }
            other => other,
        }
    }

    fn outcome(&self, patience: Option<Duration>) -> Result<T, ClientError> {
        self.read(self.simulation.bus.answer(&self.question, patience))
    }

    /// What the answer means. The time is not noted: it may be that of long ago by the time this is read.
    pub(crate) fn read(&self, answer: Result<Bytes, ClientError>) -> Result<T, ClientError> {
        accepted(self.command, decode(answer?)?).and_then(self.read)
    }
}
