//! The client for asynchronous code: the same names, awaited.
//!
//! Nothing here blocks a thread of the runtime while it waits for the daemon. It runs in any runtime of tokio (for its clock),
//! of one thread too; what zenoh must do apart, such as opening a session, is done on a thread of its own. Handing a request to
//! zenoh copies it, which takes microseconds, and waits only where a socket has been full for long.
//!
//! ```no_run
//! use std::time::Duration;
//! use sturz_client::{DEFAULT_ENDPOINT, Window, aio};
//!
//! # async fn run() -> Result<(), sturz_client::ClientError> {
//! let simulation = aio::Simulation::connect("drum-crosses", DEFAULT_ENDPOINT, Duration::from_secs(5)).await?;
//! simulation.pause().await?;
//! let mut reports = simulation.reports()?;
//! let (advanced, report) = tokio::join!(simulation.advance(Window::new(0.01)), reports.next());
//! println!("at {} s: {:?}", advanced?.time_reached_s, report.transpose()?.map(|report| report.particles));
//! # Ok(())
//! # }
//! ```
//!
//! # Dropping a future
//! A question that is dropped is forgotten. A command that is dropped before it was first polled is not sent; after that it is
//! on its way and takes effect all the same, but for those that let time go on: dropping [`Simulation::step`] or
//! [`Simulation::advance`] pauses the simulation, so that nothing goes on behind your back. What is asked or sent next comes
//! behind the pause. (Where another client has let the simulation run freely just then, it is paused too.)
//!
//! ```no_run
//! # use std::time::Duration;
//! # use sturz_client::{Window, aio};
//! # async fn run(simulation: aio::Simulation) -> Result<(), sturz_client::ClientError> {
//! // Ten seconds of wall time for a simulated hour, or for the part of it that can be had.
//! if tokio::time::timeout(Duration::from_secs(10), simulation.advance(Window::new(3600.0))).await.is_err() {
//!     println!("paused at {} s", simulation.info().await?.sim_time_s);
//! }
//! # Ok(())
//! # }
//! ```

mod apart;
mod command;
mod later;
mod stream;

use std::sync::Arc;
use std::time::Duration;

use prost::Message;
use prost::bytes::Bytes;
use sturz_protocol::keys::check_name;
use sturz_protocol::v1;

use crate::aio::apart::apart;
use crate::bus::Question;
use crate::contacts::Contacts;
use crate::error::ClientError;
use crate::field::Field;
use crate::fluid::Exchange;
use crate::queue::Popped;
use crate::request::FloatType;
use crate::simulation::{decode, selector};
use crate::state::State;
use crate::target::Target;

pub use later::{Later, Pending};
pub use stream::Stream;

/// A connected simulation; the twin of [`crate::Simulation`]. Clones share the connection.
#[derive(Clone)]
pub struct Simulation {
    blocking: crate::Simulation,
}

impl From<crate::Simulation> for Simulation {
    /// The same connection.
    fn from(blocking: crate::Simulation) -> Self {
        Self { blocking }
    }
}

impl Simulation {
    /// As [`crate::Simulation::connect`].
    pub async fn connect(name: &str, endpoint: &str, timeout: Duration) -> Result<Self, ClientError> {
        Self::connect_to(name, &Target::new(endpoint), timeout).await
    }

    /// As [`crate::Simulation::connect_to`].
    pub async fn connect_to(name: &str, target: &Target, timeout: Duration) -> Result<Self, ClientError> {
        let (name, target) = (name.to_string(), target.clone());
        apart(move || crate::Simulation::connect_to(&name, &target, timeout)).await?.map(Self::from)
    }

    /// As [`crate::Simulation::reconnect`].
    pub async fn reconnect(&self, timeout: Duration) -> Result<Self, ClientError> {
        let blocking = self.blocking.clone();
        apart(move || blocking.reconnect(timeout)).await?.map(Self::from)
    }

    /// The same connection for callers that block.
    pub fn blocking(&self) -> &crate::Simulation {
        &self.blocking
    }

    /// As [`crate::Simulation::with_timeout`].
    pub fn with_timeout(self, timeout: Duration) -> Self {
        Self { blocking: self.blocking.with_timeout(timeout) }
    }

    /// Name on the bus.
    pub fn instance(&self) -> &str {
        self.blocking.instance()
    }

    /// Where the daemon listens.
    pub fn endpoint(&self) -> &str {
        self.blocking.endpoint()
    }

    /// As [`crate::Simulation::is_gone`].
    pub fn is_gone(&self) -> bool {
        self.blocking.is_gone()
    }

    /// Fails when the daemon is gone; finding out why takes seconds, on another thread.
    async fn check(&self) -> Result<(), ClientError> {
        if !self.is_gone() {
            return Ok(());
        }
        let bus = Arc::clone(&self.blocking.bus);
        Err(apart(move || bus.gone()).await?)
    }

    async fn answer(&self, question: Question, patience: Option<Duration>) -> Result<Bytes, ClientError> {
        let popped = match patience {
            None => question.answers.popped().await,
            Some(patience) => {
                tokio::time::timeout(patience, question.answers.popped()).await.unwrap_or(Popped::TimedOut)
            }
        };
        let bus = Arc::clone(&self.blocking.bus);
        match popped {
            Popped::Ended => apart(move || bus.read_answer(&question.what, Popped::Ended, patience)).await?,
            there => bus.read_answer(&question.what, there, patience),
        }
    }

    async fn ask<M: Message + Default>(&self, selector: &str) -> Result<M, ClientError> {
        self.check().await?;
        let patience = Some(self.blocking.patience);
        let question = self.blocking.bus.send(selector, None, patience)?;
        decode(self.answer(question, patience).await?)
    }

    /// As [`crate::Simulation::info`].
    pub async fn info(&self) -> Result<v1::Info, ClientError> {
        let info: v1::Info = self.ask(&self.blocking.bus.keys.info()).await?;
        self.blocking.client.note_time_s(info.sim_time_s);
        Ok(info)
    }

    /// As [`crate::Simulation::features`].
    pub async fn features(&self) -> Result<v1::Features, ClientError> {
        self.ask(&self.blocking.bus.keys.features()).await
    }

    /// As [`crate::Simulation::plan`].
    pub async fn plan(&self) -> Result<Vec<String>, ClientError> {
        Ok(self.ask::<v1::Plan>(&self.blocking.bus.keys.plan()).await?.lines)
    }

    /// As [`crate::Simulation::shapes`].
    pub async fn shapes(&self) -> Result<Vec<v1::Shape>, ClientError> {
        Ok(self.ask::<v1::Shapes>(&self.blocking.bus.keys.shapes_latest()).await?.shapes)
    }

    /// As [`crate::Simulation::report`].
    pub async fn report(&self) -> Result<v1::Report, ClientError> {
        self.ask(&self.blocking.bus.keys.report_latest()).await
    }

    /// As [`crate::Simulation::state`].
    pub async fn state(&self, columns: &[&str], float_type: FloatType) -> Result<State, ClientError> {
        let selector = selector(self.blocking.bus.keys.state_latest(), columns, float_type);
        Ok(State::new(self.ask(&selector).await?))
    }

    /// As [`crate::Simulation::contacts`].
    pub async fn contacts(&self, columns: &[&str], float_type: FloatType) -> Result<Contacts, ClientError> {
        let selector = selector(self.blocking.bus.keys.contacts_latest(), columns, float_type);
        Ok(Contacts::new(self.ask(&selector).await?))
    }

    /// As [`crate::Simulation::exchange`].
    pub async fn exchange(&self) -> Result<Exchange, ClientError> {
        Ok(Exchange::new(self.ask(&self.blocking.bus.keys.exchange_latest()).await?))
    }

    /// As [`crate::Simulation::field`].
    pub async fn field(&self, name: &str) -> Result<Field, ClientError> {
        check_name(name)?;
        Ok(Field::new(self.ask(&self.blocking.bus.keys.field_latest(name)).await?))
    }

    /// As [`crate::Simulation::states`]; opening a stream waits for nobody.
    pub fn states(&self) -> Result<Stream<State>, ClientError> {
        self.blocking.states().map(Stream::new)
    }

    /// As [`crate::Simulation::contact_networks`].
    pub fn contact_networks(&self) -> Result<Stream<Contacts>, ClientError> {
        self.blocking.contact_networks().map(Stream::new)
    }

    /// As [`crate::Simulation::fields`].
    pub fn fields(&self, name: &str) -> Result<Stream<Field>, ClientError> {
        self.blocking.fields(name).map(Stream::new)
    }

    /// As [`crate::Simulation::reports`].
    pub fn reports(&self) -> Result<Stream<v1::Report>, ClientError> {
        self.blocking.reports().map(Stream::new)
    }

    /// As [`crate::Simulation::events`].
    pub fn events(&self) -> Result<Stream<v1::Event>, ClientError> {
        self.blocking.events().map(Stream::new)
    }
}
