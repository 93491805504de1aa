//! What changes the simulation, at once.

use std::sync::PoisonError;
use std::thread;
use std::time::{Duration, Instant};

use sturz_protocol::{Request, v1};

use crate::error::ClientError;
use crate::later::Later;
use crate::outcome::{
    Advanced, Applied, Checkpointed, Checkpoints, Inserted, Removed, Restored, Stepped, accepted, read, time_reached_s,
};
use crate::request::{Start, Window, vec3};
use crate::simulation::{Simulation, decode};

/// Commands. Those that the daemon refuses are [`ClientError::Refused`], and leave its state as it was.
impl Simulation {
    /// Sends any request, and returns its outcome: what all methods below are made of.
    ///
    /// Ids that its header lacks are filled in. After a timeout it is sent once more with the same id, which the
    /// daemon answers from memory: it is applied once. Without a `timeout` it may take as long as the daemon lives.
    pub fn command(&self, request: Request, timeout: Option<Duration>) -> Result<v1::Outcome, ClientError> {
        let request = self.signed(request, None);
        let outcome = match self.try_command(&request, timeout) {
            Err(ClientError::Timeout { .. }) => self.try_command(&request, timeout),
            answered => answered,
        }?;
        if request.header().is_none_or(|header| header.at_time_s.is_none()) {
            self.client.note_time_s(time_reached_s(&outcome));
        }
        Ok(outcome)
    }

    fn try_command(&self, request: &Request, timeout: Option<Duration>) -> Result<v1::Outcome, ClientError> {
        let question = self.bus.send(&self.bus.keys.command(request.verb()), Some(request.encode()), timeout)?;
        let answer = self.bus.answer(&question, timeout).map_err(|error| match error {
            ClientError::Timeout { what, after, .. } => {
                let request_id = request.header().map(|header| header.request_id.clone());
                ClientError::Timeout { what, after, request_id }
            }
            other => other,
        })?;
        accepted(request.verb().name(), decode(&answer)?)
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

    fn quick(&self, request: Request) -> Result<v1::Outcome, ClientError> {
        self.command(request, Some(self.patience))
    }

    /// The same commands, to take effect before the first step that starts at or after a simulated time, s.
    pub fn later(&self, at_time_s: f64) -> Later<'_> {
        Later { simulation: self, at_time_s }
    }

    /// Adds particles: an [`crate::Insertion`], or the message of the wire. Dense random insertion takes its time.
    pub fn insert(&self, insertion: impl Into<v1::InsertRequest>) -> Result<Inserted, ClientError> {
        self.command(Request::Insert(insertion.into()), None).and_then(read)
    }

    /// Removes particles, all or none: every one of `ids` must exist.
    pub fn remove(&self, ids: impl IntoIterator<Item = u64>) -> Result<Removed, ClientError> {
        self.quick(remove(ids)).and_then(read)
    }

    /// Sets the acceleration of gravity, m/s2.
    pub fn set_gravity(&self, gravity_m_per_s2: [f64; 3]) -> Result<Applied, ClientError> {
        self.quick(set_gravity(gravity_m_per_s2)).and_then(read)
    }

    /// Gives a boundary another motion from now on: a [`crate::Motion`], or the message of the wire.
    pub fn set_motion(&self, boundary: &str, motion: impl Into<v1::Motion>) -> Result<Applied, ClientError> {
        self.quick(set_motion(boundary, motion.into())).and_then(read)
    }

    /// Replaces the loads from outside from now on: [`crate::Loads`], or the message of the wire.
    pub fn set_loads(&self, loads: impl Into<v1::Loads>) -> Result<Applied, ClientError> {
        self.quick(set_loads(loads.into())).and_then(read)
    }

    /// Stops stepping, and ends a window in flight early.
    pub fn pause(&self) -> Result<Applied, ClientError> {
        self.quick(Request::Pause(v1::PauseRequest { header: None })).and_then(read)
    }

    /// Lets the simulation step freely, until [`Simulation::pause`].
    pub fn resume(&self) -> Result<Applied, ClientError> {
        self.quick(Request::Resume(v1::ResumeRequest { header: None })).and_then(read)
    }

    /// Does some steps of the nominal time step. The simulation must be paused.
    pub fn step(&self, steps: u64) -> Result<Stepped, ClientError> {
        self.command(Request::Step(v1::StepRequest { header: None, steps }), None).and_then(read)
    }

    /// Advances by exactly one window, and returns what was asked for with it. The simulation must be paused.
    /// [`Simulation::pause`] from another thread ends it early.
    pub fn advance(&self, window: Window) -> Result<Advanced, ClientError> {
        let last_known_s = match (window.start, self.client.last_time_s()) {
            (Start::LastKnown, None) => self.info()?.sim_time_s,
            (_, known) => known.unwrap_or_default(),
        };
        self.command(Request::Advance(window.into_wire(last_known_s)), None).and_then(read)
    }

    /// Defines a field, or replaces the one of that name: a [`crate::FieldDefinition`], or the message of the wire.
    pub fn define_field(&self, definition: impl Into<v1::FieldDefinition>) -> Result<Applied, ClientError> {
        self.quick(define_field(definition.into())).and_then(read)
    }

    /// Forgets a field.
    pub fn drop_field(&self, name: &str) -> Result<Applied, ClientError> {
        self.quick(drop_field(name)).and_then(read)
    }

    /// Sets columns, float type and pace of a stream, for all who subscribe to it: an [`crate::Output`], or the message of
    /// the wire.
    pub fn define_output(&self, output: impl Into<v1::OutputDefinition>) -> Result<Applied, ClientError> {
        self.quick(define_output(output.into())).and_then(read)
    }

    /// Saves the whole state in the daemon's memory, to go back to by [`Simulation::restore`]; one of that token is
    /// replaced. With an empty token the daemon makes one.
    pub fn checkpoint(&self, token: &str) -> Result<Checkpointed, ClientError> {
        self.command(checkpoint(token, false), None).and_then(read)
    }

    /// The same as a file that outlives the daemon, in its folder for checkpoints; returns when the file is safe.
    pub fn checkpoint_on_disk(&self, token: &str) -> Result<Checkpointed, ClientError> {
        self.command(checkpoint(token, true), None).and_then(read)
    }

    /// Goes back, or ahead, to a saved state, bit for bit; a run that has failed is paused by it. Windows that follow
    /// start there.
    pub fn restore(&self, token: &str) -> Result<Restored, ClientError> {
        let request = v1::RestoreRequest { header: None, token: token.into() };
        self.command(Request::Restore(request), None).and_then(read)
    }

    /// The saved states, by token.
    pub fn checkpoints(&self) -> Result<Vec<v1::Checkpoint>, ClientError> {
        let request = Request::ListCheckpoints(v1::ListCheckpointsRequest { header: None });
        self.quick(request).and_then(read).map(|Checkpoints(all)| all)
    }

    /// Forgets a saved state, its file included.
    pub fn drop_checkpoint(&self, token: &str) -> Result<Applied, ClientError> {
        let request = v1::DropCheckpointRequest { header: None, token: token.into() };
        self.quick(Request::DropCheckpoint(request)).and_then(read)
    }

    /// Makes this client, and its clones, the only one that may step, advance, resume, restore and set loads. When its
    /// connection is lost, or its last clone dropped, the run is paused.
    pub fn acquire_lease(&self) -> Result<Applied, ClientError> {
        let mut token = self.client.token.lock().unwrap_or_else(PoisonError::into_inner);
        let had_one = token.is_some();
        if !had_one {
            *token = Some(self.bus.declare_token(&self.bus.keys.client(&self.client.id))?);
        }
        let deadline = Instant::now() + TOKEN_SEEN;
        loop {
            let request = Request::AcquireLease(v1::AcquireLeaseRequest { header: None });
            match self.quick(request).and_then(read) {
                // The token may still be on its way.
                Err(error) if is_token_unseen(&error) && Instant::now() < deadline => thread::sleep(TOKEN_RETRY),
                Err(error) => {
                    if !had_one {
                        *token = None;
                    }
                    return Err(error);
                }
                acquired => return acquired,
            }
        }
    }

    /// Lets others advance again; the run goes on.
    pub fn release_lease(&self) -> Result<Applied, ClientError> {
        let request = Request::ReleaseLease(v1::ReleaseLeaseRequest { header: None });
        let released = self.quick(request).and_then(read)?;
        *self.client.token.lock().unwrap_or_else(PoisonError::into_inner) = None;
        Ok(released)
    }

    /// Ends the daemon, and waits until it is gone.
    pub fn stop(&self) -> Result<(), ClientError> {
        match self.quick(Request::Stop(v1::StopRequest { header: None })) {
            // It may be gone before its answer is here, or on its way for another reason.
            Ok(_) | Err(ClientError::DaemonGone { .. }) => {}
            Err(ClientError::Refused(refusal)) if refusal.code == v1::ErrorCode::Stopping => {}
            Err(error) => return Err(error),
        }
        if self.bus.watch.wait_until_gone(self.patience) {
            Ok(())
        } else {
            Err(ClientError::Timeout { what: "the end of the daemon".into(), after: self.patience, request_id: None })
        }
    }
}

/// How long the daemon may take to see a token, and when to look again.
const TOKEN_SEEN: Duration = Duration::from_secs(2);
const TOKEN_RETRY: Duration = Duration::from_millis(20);

fn is_token_unseen(error: &ClientError) -> bool {
    error.refusal().is_some_and(|no| no.code == v1::ErrorCode::Lease && no.path == "header.client_id")
}

pub(crate) fn remove(ids: impl IntoIterator<Item = u64>) -> Request {
    Request::Remove(v1::RemoveRequest { header: None, ids: ids.into_iter().collect() })
}

pub(crate) fn set_gravity(gravity_m_per_s2: [f64; 3]) -> Request {
    Request::SetGravity(v1::SetGravityRequest { header: None, gravity_m_per_s2: Some(vec3(gravity_m_per_s2)) })
}

pub(crate) fn set_motion(boundary: &str, motion: v1::Motion) -> Request {
    Request::SetMotion(v1::SetMotionRequest { header: None, boundary: boundary.into(), motion: Some(motion) })
}

pub(crate) fn set_loads(loads: v1::Loads) -> Request {
    Request::SetLoads(v1::SetLoadsRequest { header: None, loads: Some(loads) })
}

pub(crate) fn checkpoint(token: &str, on_disk: bool) -> Request {
    Request::Checkpoint(v1::CheckpointRequest { header: None, token: token.into(), on_disk })
}

pub(crate) fn define_field(definition: v1::FieldDefinition) -> Request {
    Request::DefineField(v1::DefineFieldRequest { header: None, field: Some(definition) })
}

pub(crate) fn define_output(output: v1::OutputDefinition) -> Request {
    Request::DefineOutput(v1::DefineOutputRequest { header: None, output: Some(output) })
}

pub(crate) fn drop_field(name: &str) -> Request {
    Request::DropField(v1::DropFieldRequest { header: None, name: name.into() })
}
