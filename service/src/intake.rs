//! What comes in from the bus. Callbacks of zenoh only enqueue; one task decodes, in order of arrival, and puts
//! letters into the mailbox; one short task per request waits for the answer and sends it.

use std::sync::Arc;

use anyhow::anyhow;
use prost::Message;
use sturz_engine::{ContactColumn, FloatType, ParticleColumn};
use sturz_protocol::convert::{contacts_to_wire, exchange_to_wire, field_to_wire, frame_to_wire};
use sturz_protocol::keys::{Keys, Verb};
use sturz_protocol::v1::{self, outcome::Result as Wire};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc, oneshot};
use zenoh::bytes::{Encoding, ZBytes};
use zenoh::query::{Query, Queryable};
use zenoh::{Session, Wait};

use crate::config::Limits;
use crate::events::command_event;
use crate::mailbox::{Answer, Letter, Mailbox, Read, ReadAnswer, Undelivered};
use crate::order::{Order, RequestKey, error};
use crate::output::{Chosen, choose};
use crate::reply::Identity;
use crate::runner::Shared;
use crate::ticket::outcome;

/// Refusals of a full queue that wait to be sent; what comes on top of these gets an empty reply.
const REFUSALS: usize = 256;

/// What the I/O side shares.
pub struct Io {
    /// Where everything is.
    pub keys: Keys,
    /// Who signs.
    pub identity: Identity,
    /// What is refused.
    pub limits: Limits,
    /// To the physics.
    pub mailbox: Mailbox,
    /// Of the physics.
    pub shared: Arc<Shared>,
    /// To the publisher of events.
    pub events: mpsc::Sender<v1::Event>,
    /// One permit per request that is not answered yet.
    pub open: Arc<Semaphore>,
}

/// What a query is about.
enum Topic {
    Command(String),
    Info,
    Features,
    Plan,
    Shapes(String),
    Report,
    State,
    Contacts,
    Exchange,
    Field(String),
}

/// Something that came in.
struct Raw {
    topic: Topic,
    payload: ZBytes,
    /// `None`: it was put, and the outcome is an event.
    query: Option<Query>,
}

impl Raw {
    /// Parameters of a query such as `state/latest?columns=a|b;float=f32`.
    fn parameters(&self) -> [Option<&str>; 2] {
        let parameters = self.query.as_ref().map(Query::parameters);
        ["columns", "float"].map(|name| parameters.and_then(|all| all.get(name)))
    }

    fn state_columns(&self) -> Result<Chosen<ParticleColumn>, v1::Error> {
        choose(self.parameters(), |names| ParticleColumn::select(names), ParticleColumn::usual)
    }

    fn contact_columns(&self) -> Result<Chosen<ContactColumn>, v1::Error> {
        choose(self.parameters(), |names| ContactColumn::select(names), ContactColumn::usual)
    }
}

/// The declared keys; dropping it ends the intake.
pub struct Intake {
    _queryables: Vec<Queryable<()>>,
    _puts: zenoh::pubsub::Subscriber<()>,
}

/// Declares all keys that clients may ask at, and starts the task that reads what comes in.
pub async fn open(session: &Session, io: Arc<Io>) -> anyhow::Result<Intake> {
    let (sender, receiver) = mpsc::channel(2 * io.limits.queue_length);
    let (refuse, refused) = mpsc::channel(REFUSALS);
    tokio::spawn(read_all(Arc::clone(&io), receiver));
    tokio::spawn(refuse_all(Arc::clone(&io), refused));
    let queue = Queue { sender, refuse, kept_for_queries: io.limits.queue_length };

    let keys = &io.keys;
    let commands = format!("sturz/v1/{}/cmd/*", keys.instance());
    let mut queryables = Vec::new();
    for key in [
        commands.clone(),
        keys.info(),
        keys.features(),
        keys.plan(),
        keys.report_latest(),
        keys.state_latest(),
        keys.contacts_latest(),
        keys.exchange_latest(),
        keys.all_shapes(),
        keys.all_fields_latest(),
    ] {
        let queue = queue.clone();
        let prefix = format!("sturz/v1/{}/", keys.instance());
        let take = move |query: Query| {
            if let Some(topic) = topic(query.key_expr().as_str().strip_prefix(&prefix)) {
                let payload = query.payload().cloned().unwrap_or_default();
                queue.add(Raw { topic, payload, query: Some(query) });
            }
        };
        let declared = session.declare_queryable(&key).complete(true).callback(take).await;
        queryables.push(declared.map_err(|error| anyhow!("cannot declare {key}: {error}"))?);
    }
    let take = move |sample: zenoh::sample::Sample| {
        let verb = sample.key_expr().as_str().rsplit('/').next().unwrap_or_default();
        queue.add(Raw { topic: Topic::Command(verb.into()), payload: sample.payload().clone(), query: None });
    };
    let puts = session.declare_subscriber(&commands).callback(take).await;
    let puts = puts.map_err(|error| anyhow!("cannot declare {commands}: {error}"))?;
    Ok(Intake { _queryables: queryables, _puts: puts })
}

/// Of the part of a key behind the instance; `None` for keys with wildcards, which have no single answer.
fn topic(tail: Option<&str>) -> Option<Topic> {
    let tail = tail.filter(|tail| !tail.contains('*'))?;
    match tail.split('/').collect::<Vec<_>>()[..] {
        ["cmd", verb] => Some(Topic::Command(verb.into())),
        ["info"] => Some(Topic::Info),
        ["features"] => Some(Topic::Features),
        ["plan"] => Some(Topic::Plan),
        ["shapes", epoch] => Some(Topic::Shapes(epoch.into())),
        ["report", "latest"] => Some(Topic::Report),
        ["state", "latest"] => Some(Topic::State),
        ["contacts", "latest"] => Some(Topic::Contacts),
        ["exchange", "latest"] => Some(Topic::Exchange),
        ["field", name, "latest"] => Some(Topic::Field(name.into())),
        _ => None,
    }
}

/// Bounded on every side: a callback must never wait.
#[derive(Clone)]
struct Queue {
    sender: mpsc::Sender<Raw>,
    refuse: mpsc::Sender<Raw>,
    /// Places that no put may take: a flood of puts, which cost their sender nothing, must not shut queries out.
    kept_for_queries: usize,
}

impl Queue {
    fn add(&self, raw: Raw) {
        if raw.query.is_none() && self.sender.capacity() <= self.kept_for_queries {
            drop(self.refuse.try_send(raw));
        } else if let Err(mpsc::error::TrySendError::Full(raw)) = self.sender.try_send(raw) {
            // Where even refusals wait, the query ends without a reply when it is dropped here.
            drop(self.refuse.try_send(raw));
        }
    }
}

async fn refuse_all(io: Arc<Io>, mut refused: mpsc::Receiver<Raw>) {
    while let Some(raw) = refused.recv().await {
        let io = Arc::clone(&io);
        let send = tokio::task::spawn_blocking(move || io.refuse(raw, busy("queue_length")));
        drop(send.await);
    }
}

async fn read_all(io: Arc<Io>, mut receiver: mpsc::Receiver<Raw>) {
    while let Some(raw) = receiver.recv().await {
        match Arc::clone(&io.open).try_acquire_owned() {
            Ok(permit) => io.take(raw, permit),
            Err(_) if raw.query.is_none() => {
                let Topic::Command(name) = &raw.topic else { continue };
                io.announce_refusal(io.refusal(&RequestKey::default(), name, busy("open_requests")));
            }
            Err(_) => {
                let io = Arc::clone(&io);
                drop(tokio::task::spawn_blocking(move || io.refuse(raw, busy("open_requests"))).await);
            }
        }
    }
}

/// The limit that is met, by its setting.
fn busy(setting: &str) -> v1::Error {
    error(v1::ErrorCode::Busy, "", format!("too many requests are waiting (limit `{setting}`): try again"))
}

fn stopping() -> v1::Error {
    error(v1::ErrorCode::Stopping, "", "the daemon is ending")
}

impl Io {
    fn take(self: &Arc<Self>, raw: Raw, permit: OwnedSemaphorePermit) {
        let question = match &raw.topic {
            Topic::Command(name) => {
                return match Verb::ALL.iter().find(|verb| verb.name() == name) {
                    Some(&verb) => self.take_command(verb, raw, permit),
                    None => self.refuse_later(raw, no_such("command"), permit),
                };
            }
            Topic::Features => return self.reply_later(raw, self.identity.features.encode_to_vec(), permit),
            Topic::Plan => return self.reply_later(raw, self.identity.plan.encode_to_vec(), permit),
            Topic::Shapes(epoch) if epoch == "latest" || *epoch == self.identity.shapes.epoch.to_string() => {
                return self.reply_later(raw, self.identity.shapes.encode_to_vec(), permit);
            }
            Topic::Shapes(_) => return self.refuse_later(raw, no_such("epoch of shapes"), permit),
            Topic::Info => Read::Status,
            Topic::Report => Read::Report,
            Topic::State => match raw.state_columns() {
                Ok(chosen) => Read::State { forces: chosen.columns.iter().any(|column| column.is_force()) },
                Err(error) => return self.refuse_later(raw, error, permit),
            },
            Topic::Contacts => match raw.contact_columns() {
                Ok(_) => Read::Contacts,
                Err(error) => return self.refuse_later(raw, error, permit),
            },
            Topic::Exchange => Read::Exchange,
            Topic::Field(name) => Read::Field(name.clone()),
        };
        let (sender, receiver) = oneshot::channel();
        match self.mailbox.deliver(Letter::Read(question, sender)) {
            Ok(()) => drop(tokio::spawn(Arc::clone(self).answer_read(raw, receiver, permit))),
            Err(Undelivered::Full(_)) => self.refuse_later(raw, busy("queue_length"), permit),
            Err(Undelivered::Closed(_)) => self.refuse_later(raw, stopping(), permit),
        }
    }

    fn take_command(self: &Arc<Self>, verb: Verb, raw: Raw, permit: OwnedSemaphorePermit) {
        let order = match Order::read(verb, raw.payload.to_bytes().into_owned().into(), &self.limits) {
            Ok(order) => order,
            Err(refusal) => {
                return self.refuse_command_later(raw, (&refusal.key, verb), refusal.error, permit);
            }
        };
        let key = order.key.clone();
        let (sender, receiver) = oneshot::channel();
        match self.mailbox.deliver(Letter::Command(Box::new(order), sender)) {
            Ok(()) => drop(tokio::spawn(Arc::clone(self).answer_command(raw, (key, verb), receiver, permit))),
            Err(Undelivered::Full(_)) => self.refuse_command_later(raw, (&key, verb), busy("queue_length"), permit),
            Err(Undelivered::Closed(_)) => self.refuse_command_later(raw, (&key, verb), stopping(), permit),
        }
    }

    async fn answer_command(
        self: Arc<Self>,
        raw: Raw,
        (key, verb): (RequestKey, Verb),
        receiver: oneshot::Receiver<Answer>,
        permit: OwnedSemaphorePermit,
    ) {
        let answer = receiver.await.unwrap_or_else(|_| Answer {
            outcome: outcome(&key, verb, self.shared.moment(), Wire::Error(stopping())),
            capture: None,
        });
        // What came by `put` has no other answer; a repeated one was told before.
        let told = (raw.query.is_none() || !answer.outcome.repeated).then(|| answer.outcome.clone());
        // Before the reply, where there is room: who has it may ask for more, whose outcome must not be told first.
        let late = told.and_then(|outcome| self.events.try_send(command_event(&self.identity, outcome)).err());
        let io = Arc::clone(&self);
        let send = move || {
            if raw.query.is_some() {
                io.finish(raw, io.identity.outcome(answer));
            }
        };
        drop(tokio::task::spawn_blocking(send).await);
        // The permit is held meanwhile: who listens to events and does not read them cannot make outcomes pile up.
        if let Some(event) = late.map(mpsc::error::TrySendError::into_inner)
            && self.events.send(event).await.is_err()
        {
            tracing::debug!("an outcome came after the end of the bus");
        }
        drop(permit);
    }

    async fn answer_read(
        self: Arc<Self>,
        raw: Raw,
        receiver: oneshot::Receiver<ReadAnswer>,
        permit: OwnedSemaphorePermit,
    ) {
        let answer = receiver.await.unwrap_or_else(|_| ReadAnswer::Refused(stopping()));
        let send = move || {
            match self.encode_read(&raw, answer) {
                Ok(bytes) => self.finish(raw, bytes),
                Err(error) => self.refuse(raw, error),
            }
            drop(permit);
        };
        drop(tokio::task::spawn_blocking(send).await);
    }

    fn encode_read(&self, raw: &Raw, answer: ReadAnswer) -> Result<Vec<u8>, v1::Error> {
        match answer {
            ReadAnswer::Status(status) => Ok(self.identity.info(&status).encode_to_vec()),
            ReadAnswer::Report(sample) => Ok(self.identity.report(&sample, 0).encode_to_vec()),
            ReadAnswer::Field(field) => {
                let header = self.identity.blank_header(0, 0);
                Ok(field_to_wire(&field, &[], FloatType::F64, header).encode_to_vec())
            }
            ReadAnswer::State(snapshot) => {
                let Chosen { columns, float } = raw.state_columns()?;
                Ok(frame_to_wire(&snapshot, &columns, float, self.identity.blank_header(0, 0)).encode_to_vec())
            }
            ReadAnswer::Contacts(network) => {
                let Chosen { columns, float } = raw.contact_columns()?;
                Ok(contacts_to_wire(&network, &columns, float, self.identity.blank_header(0, 0)).encode_to_vec())
            }
            ReadAnswer::Exchange(exchange) => {
                Ok(exchange_to_wire(&exchange, self.identity.blank_header(0, 0)).encode_to_vec())
            }
            ReadAnswer::Refused(error) => Err(error),
        }
    }

    /// An outcome that says no.
    fn refusal(&self, key: &RequestKey, command: &str, error: v1::Error) -> v1::Outcome {
        let refusal = outcome(key, Verb::Stop, self.shared.moment(), Wire::Error(error));
        v1::Outcome { command: command.into(), ..refusal }
    }

    /// Tells of a command that did not get as far as the physics. Never waits: in a flood of rubbish some refusals are left
    /// out rather than anybody held up.
    fn announce_refusal(&self, outcome: v1::Outcome) {
        if self.events.try_send(command_event(&self.identity, outcome)).is_err() {
            tracing::debug!("a refusal was left out: too many of them");
        }
    }

    fn refuse_command_later(
        self: &Arc<Self>,
        raw: Raw,
        (key, verb): (&RequestKey, Verb),
        error: v1::Error,
        permit: OwnedSemaphorePermit,
    ) {
        let refusal = self.refusal(key, verb.name(), error);
        if raw.query.is_some() {
            self.finish_later(raw, refusal.encode_to_vec(), permit);
        }
        self.announce_refusal(refusal);
    }

    fn finish_later(self: &Arc<Self>, raw: Raw, bytes: Vec<u8>, permit: OwnedSemaphorePermit) {
        let io = Arc::clone(self);
        tokio::task::spawn_blocking(move || {
            io.finish(raw, bytes);
            drop(permit);
        });
    }

    fn reply_later(self: &Arc<Self>, raw: Raw, bytes: Vec<u8>, permit: OwnedSemaphorePermit) {
        self.finish_later(raw, bytes, permit);
    }

    fn refuse_later(self: &Arc<Self>, raw: Raw, error: v1::Error, permit: OwnedSemaphorePermit) {
        let io = Arc::clone(self);
        tokio::task::spawn_blocking(move || {
            io.refuse(raw, error);
            drop(permit);
        });
    }

    /// Says no: to a command by an outcome, to any other query by an error.
    fn refuse(&self, raw: Raw, error: v1::Error) {
        match (&raw.topic, &raw.query) {
            (Topic::Command(name), _) => {
                let key = RequestKey::default();
                let refusal = self.refusal(&key, name, error);
                if raw.query.is_some() {
                    self.finish(raw, refusal.encode_to_vec());
                }
                self.announce_refusal(refusal);
            }
            (_, Some(query)) => {
                let sent = query.reply_err(error.encode_to_vec()).encoding(encoding("Error")).wait();
                log_unsent(sent);
            }
            (_, None) => {}
        }
    }

    /// Sends an answer. May wait for the bus, so never call it from a callback or an asynchronous task.
    fn finish(&self, raw: Raw, bytes: Vec<u8>) {
        let Some(query) = raw.query else { return };
        let encoding = encoding(raw.topic.message());
        log_unsent(query.reply(query.key_expr().clone(), bytes).encoding(encoding).wait());
    }
}

impl Topic {
    /// Message that answers it.
    fn message(&self) -> &'static str {
        match self {
            Topic::Command(_) => "Outcome",
            Topic::Info => "Info",
            Topic::Features => "Features",
            Topic::Plan => "Plan",
            Topic::Shapes(_) => "Shapes",
            Topic::Report => "Report",
            Topic::State => "Frame",
            Topic::Contacts => "ContactFrame",
            Topic::Exchange => "ExchangeFrame",
            Topic::Field(_) => "FieldFrame",
        }
    }
}

/// Of a message of this schema.
pub fn encoding(message: &str) -> Encoding {
    Encoding::APPLICATION_PROTOBUF.with_schema(format!("sturz.v1.{message}"))
}

fn no_such(what: &str) -> v1::Error {
    error(v1::ErrorCode::NotFound, "", format!("there is no such {what}"))
}

/// A client that has gone is no trouble of the daemon.
fn log_unsent(sent: zenoh::Result<()>) {
    if let Err(error) = sent {
        tracing::debug!("a reply could not be sent: {error}");
    }
}
