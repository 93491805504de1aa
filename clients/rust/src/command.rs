//! What changes the simulation, at once.

use std::sync::PoisonError;
use std::thread;
use std::time::{Duration, Instant};

use prost::bytes::Bytes;
use sturz_protocol::{Request, v1};

use crate::bus::Question;
use crate::call::{self, Call};
use crate::error::ClientError;
use crate::fluid::FluidFields;
use crate::later::Later;
use crate::outcome::{
    Advanced, Applied, Checkpointed, Checkpoints, Inserted, Kind, Removed, Restored, Stepped, accepted, time_reached_s,
};
use crate::request::{Start, Window};
use crate::simulation::{Simulation, decode};

/// Commands. Those that the daemon refuses are [`ClientError::Refused`], and leave its state as it was.
impl Simulation {
    /// Sends any request, and returns its outcome: what all methods below are made of.
    ///
    /// Ids that its header lacks are filled in. After a timeout it is sent once more with the same id, which the
    /// daemon answers from memory: it is applied once. Without a `timeout` it may take as long as the daemon lives.
    pub fn command(&self, request: Request, timeout: Option<Duration>) -> Result<v1::Outcome, ClientError> {
        let request = self.signed(request, None);
        match self.try_command(&request, timeout) {
            Err(ClientError::Timeout { .. }) => self.try_command(&request, timeout),
            answered => answered,
        }
    }

    fn try_command(&self, request: &Request, timeout: Option<Duration>) -> Result<v1::Outcome, ClientError> {
        let question = self.send_command(request, timeout)?;
        self.outcome_of(request, self.bus.answer(&question, timeout))
    }

    /// Sends a signed request; it is on its way when this returns.
    pub(crate) fn send_command(&self, request: &Request, timeout: Option<Duration>) -> Result<Question, ClientError> {
        self.bus.send(&self.bus.keys.command(request.verb()), Some(request.encode()), timeout)
    }

    /// What an answer to a request means; notes the time that it tells.
    pub(crate) fn outcome_of(
        &self,
        request: &Request,
        answer: Result<Bytes, ClientError>,
    ) -> Result<v1::Outcome, ClientError> {
        let answer = answer.map_err(|error| match error {
            ClientError::Timeout { what, after, .. } => {
                let request_id = request.header().map(|header| header.request_id.clone());
                ClientError::Timeout { what, after, request_id }
            }
            other => other,
        })?;
        let outcome = accepted(request.verb().name(), decode(answer)?)?;
        if request.header().is_none_or(|header| header.at_time_s.is_none()) {
            self.client.note_time_s(time_reached_s(&outcome));
        }
        Ok(outcome)
    }

    /// With a header that says who asks.
    pub(crate) fn signed(&self, request: Request, at_time_s: Option<f64>) -> Request {
        let mut header = request.header().cloned().unwrap_or_default();
        if header.client_id.is_empty() {
            header.client_id = self.client.id.clone();
        }
        if header.request_id.is_empty() {
            header.request_id = self.client.new_request_id();
        }
        header.at_time_s = at_time_s.or(header.at_time_s);
        request.with_header(header)
    }

    fn call<K: Kind>(&self, call: Call<K>) -> Result<K, ClientError> {
        let timeout = self.timeout_of(&call);
        self.command(call.request, timeout).and_then(Call::<K>::read)
    }

    /// How long the answer may take.
    pub(crate) fn timeout_of<K>(&self, call: &Call<K>) -> Option<Duration> {
        call.is_quick.then_some(self.patience)
    }

    /// The same commands, to take effect before the first step that starts at or after a simulated time, s.
    pub fn later(&self, at_time_s: f64) -> Later<'_> {
        Later { simulation: self, at_time_s }
    }

    /// Adds particles: an [`crate::Insertion`], or the message of the wire. Dense random insertion takes its time.
    pub fn insert(&self, insertion: impl Into<v1::InsertRequest>) -> Result<Inserted, ClientError> {
        self.call(call::insert(insertion.into()))
    }

    /// Removes particles, all or none: every one of `ids` must exist.
    pub fn remove(&self, ids: impl IntoIterator<Item = u64>) -> Result<Removed, ClientError> {
        self.call(call::remove(ids))
    }

    /// Sets the acceleration of gravity, m/s2.
    pub fn set_gravity(&self, gravity_m_per_s2: [f64; 3]) -> Result<Applied, ClientError> {
        self.call(call::set_gravity(gravity_m_per_s2))
    }

    /// Gives a boundary another motion from now on: a [`crate::Motion`], or the message of the wire.
    pub fn set_motion(&self, boundary: &str, motion: impl Into<v1::Motion>) -> Result<Applied, ClientError> {
        self.call(call::set_motion(boundary, motion.into()))
    }

    /// Replaces the loads from outside from now on: [`crate::Loads`], or the message of the wire.
    pub fn set_loads(&self, loads: impl Into<v1::Loads>) -> Result<Applied, ClientError> {
        self.call(call::set_loads(loads.into()))
    }

    /// Puts a fluid around the particles, instead of the one before, with fields on its mesh, or takes it away: see
    /// `docs/coupling.md`.
    pub fn set_fluid(
        &self,
        fluid: Option<v1::FluidDefinition>,
        fields: Option<FluidFields>,
    ) -> Result<Applied, ClientError> {
        self.call(call::set_fluid(fluid, fields.map(Into::into)))
    }

    /// Stops stepping, and ends a window in flight early.
    pub fn pause(&self) -> Result<Applied, ClientError> {
        self.call(call::pause())
    }

    /// Lets the simulation step freely, until [`Simulation::pause`].
    pub fn resume(&self) -> Result<Applied, ClientError> {
        self.call(call::resume())
    }

    /// Does some steps of the nominal time step. The simulation must be paused.
    pub fn step(&self, steps: u64) -> Result<Stepped, ClientError> {
        self.call(call::step(steps))
    }

    /// Advances by exactly one window, and returns what was asked for with it. The simulation must be paused.
    /// [`Simulation::pause`] from another thread ends it early.
    pub fn advance(&self, window: Window) -> Result<Advanced, ClientError> {
        let last_known_s = match (window.start, self.client.last_time_s()) {
            (Start::LastKnown, None) => self.info()?.sim_time_s,
            (_, known) => known.unwrap_or_default(),
        };
        self.call(Call::long(Request::Advance(window.into_wire(last_known_s))))
    }

    /// Defines a field, or replaces the one of that name: a [`crate::FieldDefinition`], or the message of the wire.
    pub fn define_field(&self, definition: impl Into<v1::FieldDefinition>) -> Result<Applied, ClientError> {
        self.call(call::define_field(definition.into()))
    }

    /// Forgets a field.
    pub fn drop_field(&self, name: &str) -> Result<Applied, ClientError> {
        self.call(call::drop_field(name))
    }

    /// Sets columns, float type and pace of a stream, for all who subscribe to it: an [`crate::Output`], or the message of
    /// the wire.
    pub fn define_output(&self, output: impl Into<v1::OutputDefinition>) -> Result<Applied, ClientError> {
        self.call(call::define_output(output.into()))
    }

    /// Saves the whole state in the daemon's memory, to go back to by [`Simulation::restore`]; one of that token is
    /// replaced. With an empty token the daemon makes one.
    pub fn checkpoint(&self, token: &str) -> Result<Checkpointed, ClientError> {
        self.call(call::checkpoint(token, false))
    }

    /// The same as a file that outlives the daemon, in its folder for checkpoints; returns when the file is safe.
    pub fn checkpoint_on_disk(&self, token: &str) -> Result<Checkpointed, ClientError> {
        self.call(call::checkpoint(token, true))
    }

    /// Goes back, or ahead, to a saved state, bit for bit; a run that has failed is paused by it. Windows that follow
    /// start there.
    pub fn restore(&self, token: &str) -> Result<Restored, ClientError> {
        self.call(call::restore(token))
    }

    /// The saved states, by token.
    pub fn checkpoints(&self) -> Result<Vec<v1::Checkpoint>, ClientError> {
        self.call(call::list_checkpoints()).map(|Checkpoints(all)| all)
    }

    /// Forgets a saved state, its file included.
    pub fn drop_checkpoint(&self, token: &str) -> Result<Applied, ClientError> {
        self.call(call::drop_checkpoint(token))
    }

    /// Makes this client, and its clones, the only one that may step, advance, resume, restore and set loads. When its
    /// connection is lost, or its last clone dropped, the run is paused.
    pub fn acquire_lease(&self) -> Result<Applied, ClientError> {
        let had_one = self.show_token()?;
        let deadline = Instant::now() + TOKEN_SEEN;
        loop {
            match self.call(call::acquire_lease()) {
                // The token may still be on its way.
                Err(error) if is_token_unseen(&error) && Instant::now() < deadline => thread::sleep(TOKEN_RETRY),
                acquired => {
                    if acquired.is_err() && !had_one {
                        self.hide_token();
                    }
                    return acquired;
                }
            }
        }
    }

    /// Lets others advance again; the run goes on.
    pub fn release_lease(&self) -> Result<Applied, ClientError> {
        let released = self.call(call::release_lease())?;
        self.hide_token();
        Ok(released)
    }

    /// Declares the token that the lease hangs on; whether it was there already.
    pub(crate) fn show_token(&self) -> Result<bool, ClientError> {
        let mut token = self.client.token.lock().unwrap_or_else(PoisonError::into_inner);
        let had_one = token.is_some();
        if !had_one {
            *token = Some(self.bus.declare_token(&self.bus.keys.client(&self.client.id))?);
        }
        Ok(had_one)
    }

    pub(crate) fn hide_token(&self) {
        *self.client.token.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Ends the daemon, and waits until it is gone.
    pub fn stop(&self) -> Result<(), ClientError> {
        is_going(self.call(call::stop()))?;
        if self.bus.watch.wait_until_gone(self.patience) { Ok(()) } else { Err(still_there(self.patience)) }
    }
}

/// How long the daemon may take to see a token, and when to look again.
pub(crate) const TOKEN_SEEN: Duration = Duration::from_secs(2);
pub(crate) const TOKEN_RETRY: Duration = Duration::from_millis(20);

/// Whether the answer to `stop` means that the daemon goes.
pub(crate) fn is_going(answer: Result<Applied, ClientError>) -> Result<(), ClientError> {
    match answer {
        // It may be gone before its answer is here, or on its way for another reason.
        Ok(_) | Err(ClientError::DaemonGone { .. }) => Ok(()),
        Err(ClientError::Refused(refusal)) if refusal.code == v1::ErrorCode::Stopping => Ok(()),
        Err(error) => Err(error),
    }
}

/// What to say of a daemon that was to stop, and has not.
pub(crate) fn still_there(after: Duration) -> ClientError {
    ClientError::Timeout { what: "the end of the daemon".into(), after, request_id: None }
}

pub(crate) fn is_token_unseen(error: &ClientError) -> bool {
    error.refusal().is_some_and(|no| no.code == v1::ErrorCode::Lease && no.path == "header.client_id")
}
