//! What changes the simulation, at once, awaited.

use std::sync::Arc;
use std::time::Duration;

use sturz_protocol::{Request, v1};
use tokio::time::{Instant, sleep, timeout};

use crate::aio::Simulation;
use crate::call::{self, Call};
use crate::command::{TOKEN_RETRY, TOKEN_SEEN, is_going, is_token_unseen, still_there};
use crate::error::ClientError;
use crate::fluid::FluidFields;
use crate::outcome::{Advanced, Applied, Checkpointed, Checkpoints, Inserted, Kind, Removed, Restored, Stepped};
use crate::queue::Queue;
use crate::request::{Start, Window};

/// Pauses the simulation when it is dropped before its window has been answered.
struct Guard<'s> {
    simulation: &'s Simulation,
    is_armed: bool,
}

impl Drop for Guard<'_> {
    fn drop(&mut self) {
        if self.is_armed && !self.simulation.is_gone() {
            let blocking = &self.simulation.blocking;
            let request = blocking.signed(call::pause().request, None);
            // Its answer is nobody's.
            drop(blocking.send_command(&request, Some(blocking.patience)));
            blocking.client.forget_time();
        }
    }
}

/// Commands. Those that the daemon refuses are [`ClientError::Refused`], and leave its state as it was.
impl Simulation {
    /// As [`crate::Simulation::command`]. Dropping it neither withdraws the request nor pauses.
    pub async fn command(&self, request: Request, timeout: Option<Duration>) -> Result<v1::Outcome, ClientError> {
        let request = self.blocking.signed(request, None);
        match self.try_command(&request, timeout).await {
            Err(ClientError::Timeout { .. }) => self.try_command(&request, timeout).await,
            answered => answered,
        }
    }

    async fn try_command(&self, request: &Request, timeout: Option<Duration>) -> Result<v1::Outcome, ClientError> {
        self.check().await?;
        let question = self.blocking.send_command(request, timeout)?;
        let answer = self.answer(question, timeout).await;
        self.blocking.outcome_of(request, answer)
    }

    async fn call<K: Kind>(&self, call: Call<K>) -> Result<K, ClientError> {
        let timeout = self.blocking.timeout_of(&call);
        self.command(call.request, timeout).await.and_then(Call::<K>::read)
    }

    /// What lets time go on: dropped, it pauses the simulation.
    async fn window<K: Kind>(&self, call: Call<K>) -> Result<K, ClientError> {
        let mut guard = Guard { simulation: self, is_armed: true };
        let done = self.call(call).await;
        guard.is_armed = false;
        done
    }

    /// As [`crate::Simulation::insert`].
    pub async fn insert(&self, insertion: impl Into<v1::InsertRequest>) -> Result<Inserted, ClientError> {
        self.call(call::insert(insertion.into())).await
    }

    /// As [`crate::Simulation::remove`].
    pub async fn remove(&self, ids: impl IntoIterator<Item = u64>) -> Result<Removed, ClientError> {
        self.call(call::remove(ids)).await
    }

    /// As [`crate::Simulation::set_gravity`].
    pub async fn set_gravity(&self, gravity_m_per_s2: [f64; 3]) -> Result<Applied, ClientError> {
        self.call(call::set_gravity(gravity_m_per_s2)).await
    }

    /// As [`crate::Simulation::set_motion`].
    pub async fn set_motion(&self, boundary: &str, motion: impl Into<v1::Motion>) -> Result<Applied, ClientError> {
        self.call(call::set_motion(boundary, motion.into())).await
    }

    /// As [`crate::Simulation::set_loads`].
    pub async fn set_loads(&self, loads: impl Into<v1::Loads>) -> Result<Applied, ClientError> {
        self.call(call::set_loads(loads.into())).await
    }

    /// As [`crate::Simulation::set_fluid`].
    pub async fn set_fluid(
        &self,
        fluid: Option<v1::FluidDefinition>,
        fields: Option<FluidFields>,
    ) -> Result<Applied, ClientError> {
        self.call(call::set_fluid(fluid, fields.map(Into::into))).await
    }

    /// As [`crate::Simulation::pause`].
    pub async fn pause(&self) -> Result<Applied, ClientError> {
        self.call(call::pause()).await
    }

    /// As [`crate::Simulation::resume`].
    pub async fn resume(&self) -> Result<Applied, ClientError> {
        self.call(call::resume()).await
    }

    /// As [`crate::Simulation::step`]. Dropped before it is done, it pauses the simulation.
    pub async fn step(&self, steps: u64) -> Result<Stepped, ClientError> {
        self.window(call::step(steps)).await
    }

    /// As [`crate::Simulation::advance`]. Dropped before it is done, it pauses the simulation.
    pub async fn advance(&self, window: Window) -> Result<Advanced, ClientError> {
        let last_known_s = match (window.start, self.blocking.client.last_time_s()) {
            (Start::LastKnown, None) => self.info().await?.sim_time_s,
            (_, known) => known.unwrap_or_default(),
        };
        self.window(Call::long(Request::Advance(window.into_wire(last_known_s)))).await
    }

    /// As [`crate::Simulation::define_field`].
    pub async fn define_field(&self, definition: impl Into<v1::FieldDefinition>) -> Result<Applied, ClientError> {
        self.call(call::define_field(definition.into())).await
    }

    /// As [`crate::Simulation::drop_field`].
    pub async fn drop_field(&self, name: &str) -> Result<Applied, ClientError> {
        self.call(call::drop_field(name)).await
    }

    /// As [`crate::Simulation::define_output`].
    pub async fn define_output(&self, output: impl Into<v1::OutputDefinition>) -> Result<Applied, ClientError> {
        self.call(call::define_output(output.into())).await
    }

    /// As [`crate::Simulation::checkpoint`].
    pub async fn checkpoint(&self, token: &str) -> Result<Checkpointed, ClientError> {
        self.call(call::checkpoint(token, false)).await
    }

    /// As [`crate::Simulation::checkpoint_on_disk`].
    pub async fn checkpoint_on_disk(&self, token: &str) -> Result<Checkpointed, ClientError> {
        self.call(call::checkpoint(token, true)).await
    }

    /// As [`crate::Simulation::restore`].
    pub async fn restore(&self, token: &str) -> Result<Restored, ClientError> {
        self.call(call::restore(token)).await
    }

    /// As [`crate::Simulation::checkpoints`].
    pub async fn checkpoints(&self) -> Result<Vec<v1::Checkpoint>, ClientError> {
        self.call(call::list_checkpoints()).await.map(|Checkpoints(all)| all)
    }

    /// As [`crate::Simulation::drop_checkpoint`].
    pub async fn drop_checkpoint(&self, token: &str) -> Result<Applied, ClientError> {
        self.call(call::drop_checkpoint(token)).await
    }

    /// As [`crate::Simulation::acquire_lease`].
    pub async fn acquire_lease(&self) -> Result<Applied, ClientError> {
        self.check().await?;
        let had_one = self.blocking.show_token()?;
        let deadline = Instant::now() + TOKEN_SEEN;
        loop {
            match self.call(call::acquire_lease()).await {
                // The token may still be on its way.
                Err(error) if is_token_unseen(&error) && Instant::now() < deadline => sleep(TOKEN_RETRY).await,
                acquired => {
                    if acquired.is_err() && !had_one {
                        self.blocking.hide_token();
                    }
                    return acquired;
                }
            }
        }
    }

    /// As [`crate::Simulation::release_lease`].
    pub async fn release_lease(&self) -> Result<Applied, ClientError> {
        let released = self.call(call::release_lease()).await?;
        self.blocking.hide_token();
        Ok(released)
    }

    /// As [`crate::Simulation::stop`].
    pub async fn stop(&self) -> Result<(), ClientError> {
        is_going(self.call(call::stop()).await)?;
        let gone = Arc::new(Queue::<()>::new(1));
        self.blocking.bus.watch.end_with_daemon(&gone);
        let patience = self.blocking.patience;
        timeout(patience, gone.popped()).await.map(drop).map_err(|_| still_there(patience))
    }
}
