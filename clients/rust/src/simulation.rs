//! A connected simulation: the connection, questions and streams.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use prost::Message;
use prost::bytes::Bytes;
use sturz_protocol::keys::check_name;
use sturz_protocol::v1;
use zenoh::liveliness::LivelinessToken;

use crate::bus::Bus;
use crate::contacts::Contacts;
use crate::error::ClientError;
use crate::field::Field;
use crate::fluid::Exchange;
use crate::request::FloatType;
use crate::state::State;
use crate::stream::{Source, Stream};
use crate::target::Target;

/// Where a daemon listens unless told otherwise.
pub const DEFAULT_ENDPOINT: &str = "tcp/127.0.0.1:7447";

/// For the answer to anything that is quick.
const PATIENCE: Duration = Duration::from_secs(10);
/// Frames, and fields, that a stream keeps for a slow reader.
const KEEP_FRAMES: usize = 4;
const KEEP_REPORTS: usize = 16;
const KEEP_EVENTS: usize = 1000;

/// A connected simulation. Clones share the connection; it ends with the last of them and of their streams, and leaves
/// the daemon running.
#[derive(Clone)]
pub struct Simulation {
    pub(crate) bus: Arc<Bus>,
    pub(crate) client: Arc<Client>,
    pub(crate) patience: Duration,
}

/// Who asks.
pub(crate) struct Client {
    /// Unique on the bus.
    pub(crate) id: String,
    requests: AtomicU64,
    time_s: Mutex<Option<f64>>,
    /// What the lease hangs on.
    pub(crate) token: Mutex<Option<LivelinessToken>>,
}

impl Client {
    /// An id that no request of this client has had.
    pub(crate) fn new_request_id(&self) -> String {
        self.requests.fetch_add(1, Relaxed).to_string()
    }

    /// Simulated time that was heard of last.
    pub(crate) fn last_time_s(&self) -> Option<f64> {
        *self.time_s.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Simulated time is this.
    pub(crate) fn note_time_s(&self, time_s: f64) {
        *self.time_s.lock().unwrap_or_else(PoisonError::into_inner) = Some(time_s);
    }

    /// Nobody here knows the simulated time: it goes on unheard.
    pub(crate) fn forget_time(&self) {
        *self.time_s.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

impl Simulation {
    /// Connects to the daemon that serves the instance `name` at `endpoint`.
    ///
    /// # Errors
    /// [`ClientError::NobodyListens`] or [`ClientError::NoSuchInstance`], which names those that are alive, when it is
    /// not there within `timeout`; [`ClientError::Silent`] when it hangs.
    pub fn connect(name: &str, endpoint: &str, timeout: Duration) -> Result<Self, ClientError> {
        Self::connect_to(name, &Target::new(endpoint), timeout)
    }

    /// The same with a certificate, or a zenoh configuration of one's own.
    ///
    /// # Errors
    /// Also such for which [`ClientError::is_denial`] holds: [`ClientError::TurnedAway`] without a certificate that the
    /// daemon accepts, [`ClientError::NothingToSee`] when its name has no role.
    pub fn connect_to(name: &str, target: &Target, timeout: Duration) -> Result<Self, ClientError> {
        let bus = Bus::open(name, target, timeout)?;
        let id = format!("rust-{}-{}", std::process::id(), bus.session_id());
        let client = Client { id, requests: AtomicU64::new(1), time_s: Mutex::new(None), token: Mutex::new(None) };
        Ok(Self { bus: Arc::new(bus), client: Arc::new(client), patience: PATIENCE })
    }

    /// Connects anew after [`ClientError::DaemonGone`], as the same client: a request of before the loss, sent again
    /// under its id, is not applied twice if the daemon has lived on. Streams must be opened, and the lease acquired,
    /// again. `info().run_id` tells whether it is still the same run.
    ///
    /// # Errors
    /// Those of [`Simulation::connect_to`]; this connection stays as it is then.
    pub fn reconnect(&self, timeout: Duration) -> Result<Self, ClientError> {
        let bus = Bus::open(self.instance(), &self.bus.target, timeout)?;
        let client = Arc::clone(&self.client);
        self.hide_token();
        client.forget_time();
        Ok(Self { bus: Arc::new(bus), client, patience: self.patience })
    }

    /// The same connection with another limit (10 s unless told otherwise) for answers to anything that is quick.
    /// Insertions, steps and windows may take as long as they need.
    pub fn with_timeout(self, timeout: Duration) -> Self {
        Self { patience: timeout, ..self }
    }

    /// Name on the bus.
    pub fn instance(&self) -> &str {
        self.bus.keys.instance()
    }

    /// Where the daemon listens.
    pub fn endpoint(&self) -> &str {
        &self.bus.target.endpoint
    }

    /// Whether the daemon was lost; nothing but [`ClientError::DaemonGone`] follows.
    pub fn is_gone(&self) -> bool {
        self.bus.watch.is_gone()
    }

    fn ask<M: Message + Default>(&self, selector: &str) -> Result<M, ClientError> {
        let question = self.bus.send(selector, None, Some(self.patience))?;
        decode(self.bus.answer(&question, Some(self.patience))?)
    }

    /// What this simulation is, and where it stands.
    pub fn info(&self) -> Result<v1::Info, ClientError> {
        let info: v1::Info = self.ask(&self.bus.keys.info())?;
        self.client.note_time_s(info.sim_time_s);
        Ok(info)
    }

    /// What the daemon can do.
    pub fn features(&self) -> Result<v1::Features, ClientError> {
        self.ask(&self.bus.keys.features())
    }

    /// What this scene needs, in words.
    pub fn plan(&self) -> Result<Vec<String>, ClientError> {
        Ok(self.ask::<v1::Plan>(&self.bus.keys.plan())?.lines)
    }

    /// Shapes in the order that [`State::shapes`] indexes.
    pub fn shapes(&self) -> Result<Vec<v1::Shape>, ClientError> {
        Ok(self.ask::<v1::Shapes>(&self.bus.keys.shapes_latest())?.shapes)
    }

    /// How good the run is now.
    pub fn report(&self) -> Result<v1::Report, ClientError> {
        self.ask(&self.bus.keys.report_latest())
    }

    /// The particles now: columns such as `positions` (see `Features.columns`), or `all`. Ids are always there.
    pub fn state(&self, columns: &[&str], float_type: FloatType) -> Result<State, ClientError> {
        Ok(State::new(self.ask(&selector(self.bus.keys.state_latest(), columns, float_type))?))
    }

    /// The contact network now: columns such as `points` (see `Features.contact_columns`), or `all`. Ids and boundaries are
    /// always there.
    pub fn contacts(&self, columns: &[&str], float_type: FloatType) -> Result<Contacts, ClientError> {
        Ok(Contacts::new(self.ask(&selector(self.bus.keys.contacts_latest(), columns, float_type))?))
    }

    /// What the fluid gets from the particles, now; refused where there is no fluid with a mesh.
    pub fn exchange(&self) -> Result<Exchange, ClientError> {
        Ok(Exchange::new(self.ask(&self.bus.keys.exchange_latest())?))
    }

    /// A defined field, sampled now.
    pub fn field(&self, name: &str) -> Result<Field, ClientError> {
        check_name(name)?;
        Ok(Field::new(self.ask(&self.bus.keys.field_latest(name))?))
    }

    /// States as the daemon publishes them; the newest 4 are kept for a slow reader.
    pub fn states(&self) -> Result<Stream<State>, ClientError> {
        let decode = |bytes: Bytes| decode(bytes).map(State::new);
        self.stream("state/frame", self.bus.keys.state_frame(), KEEP_FRAMES, decode)
    }

    /// The contact network as the daemon publishes it; the newest 4 frames are kept for a slow reader.
    pub fn contact_networks(&self) -> Result<Stream<Contacts>, ClientError> {
        let decode = |bytes: Bytes| decode(bytes).map(Contacts::new);
        self.stream("contacts/frame", self.bus.keys.contacts_frame(), KEEP_FRAMES, decode)
    }

    /// Samples of a field as the daemon publishes them; the newest 4 are kept for a slow reader.
    pub fn fields(&self, name: &str) -> Result<Stream<Field>, ClientError> {
        check_name(name)?;
        let decode = |bytes: Bytes| decode(bytes).map(Field::new);
        self.stream(&format!("field/{name}"), self.bus.keys.field(name), KEEP_FRAMES, decode)
    }

    /// Reports as the daemon publishes them; the newest 16 are kept for a slow reader.
    pub fn reports(&self) -> Result<Stream<v1::Report>, ClientError> {
        self.stream("report", self.bus.keys.report(), KEEP_REPORTS, decode)
    }

    /// What happened and happens: starts, pauses, outcomes of commands, particles, fields, outputs, warnings, checkpoints,
    /// the lease. Late readers get the recent past as well; the newest 1000 are kept for a slow one.
    pub fn events(&self) -> Result<Stream<v1::Event>, ClientError> {
        let (name, key) = ("event".into(), self.bus.keys.all_events());
        Stream::open(&self.bus, Source { name, key, is_events: true, keep: KEEP_EVENTS, decode })
    }

    fn stream<T>(
        &self,
        name: &str,
        key: String,
        keep: usize,
        decode: fn(Bytes) -> Result<T, ClientError>,
    ) -> Result<Stream<T>, ClientError> {
        Stream::open(&self.bus, Source { name: name.into(), key, is_events: false, keep, decode })
    }
}

/// Of a question for columns.
pub(crate) fn selector(key: String, columns: &[&str], float_type: FloatType) -> String {
    // No columns would mean all of them to the daemon.
    let columns = if columns.is_empty() { "ids".into() } else { columns.join("|") };
    format!("{key}?columns={columns};float={}", float_type.name())
}

/// A message of the wire.
pub(crate) fn decode<M: Message + Default>(bytes: Bytes) -> Result<M, ClientError> {
    let what = std::any::type_name::<M>().rsplit("::").next().unwrap_or_default();
    M::decode(bytes).map_err(|error| ClientError::unreadable(what, error))
}
