//! A playback's side of the bus: answers queries, refuses commands, publishes.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::anyhow;
use prost::Message as _;
use sturz_protocol::keys::{Keys, Verb};
use sturz_protocol::v1::{self, outcome::Result as Wire};
use tokio::sync::{Semaphore, mpsc};
use tokio::task::JoinHandle;
use zenoh::bytes::ZBytes;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{Query, Queryable};
use zenoh::sample::Sample;
use zenoh::{Session, Wait};
use zenoh_ext::{AdvancedPublisher, AdvancedPublisherBuilderExt, CacheConfig, MissDetectionConfig};

use super::pace::{Mode, Speed};
use super::player::Stage;
use crate::events::{TOPICS, outcome_event};
use crate::intake::encoding;
use crate::order::{RequestKey, error};
use crate::publish::EVENT_HEARTBEAT;
use crate::ticket::outcome;

/// Requests that wait to be read; more get an empty reply.
const REQUESTS: usize = 256;
/// Answers on their way at a time.
const ANSWERS: usize = 64;
/// Events kept for those who come late.
const EVENTS: usize = 256;

/// What is published, and where.
pub(super) struct Voice {
    session: Session,
    root: String,
    congestion: CongestionControl,
    streams: Mutex<HashMap<String, Publisher<'static>>>,
    events: HashMap<String, AdvancedPublisher<'static>>,
}

impl Voice {
    pub async fn open(session: &Session, keys: &Keys, speed: Speed) -> anyhow::Result<Self> {
        let mut events = HashMap::new();
        for topic in TOPICS {
            let key = keys.event(topic);
            let publisher = session
                .declare_publisher(key.clone())
                .congestion_control(CongestionControl::Block)
                .encoding(encoding("Event"))
                .cache(CacheConfig::default().max_samples(EVENTS))
                .sample_miss_detection(MissDetectionConfig::default().sporadic_heartbeat(EVENT_HEARTBEAT))
                .publisher_detection()
                .await
                .map_err(|error| anyhow!("cannot declare {key}: {error}"))?;
            events.insert(format!("event/{topic}"), publisher);
        }
        // Nobody is held up but the playback itself: at full speed it waits for its listeners.
        let congestion = if speed == Speed::Max { CongestionControl::Block } else { CongestionControl::Drop };
        let root = format!("sturz/v1/{}", keys.instance());
        Ok(Self { session: session.clone(), root, congestion, streams: Mutex::default(), events })
    }

    /// Publishes a message of a stream or an event; answers to queries are not published. May wait for the bus.
    pub fn publish(&self, tail: &str, message: &str, payload: ZBytes) {
        if matches!(message, "Info" | "Features" | "Plan" | "Shapes") {
            return;
        }
        let sent = match self.events.get(tail) {
            Some(publisher) => publisher.put(payload).wait(),
            None => self.put(tail, message, payload),
        };
        if let Err(error) = sent {
            tracing::warn!("cannot publish {tail}: {error}");
        }
    }

    fn put(&self, tail: &str, message: &str, payload: ZBytes) -> zenoh::Result<()> {
        let mut streams = self.streams.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(publisher) = streams.get(tail) {
            return publisher.put(payload).wait();
        }
        let declared = self
            .session
            .declare_publisher(format!("{}/{tail}", self.root))
            .congestion_control(self.congestion)
            .priority(Priority::DataLow)
            .encoding(encoding(message))
            .wait()?;
        let sent = declared.put(payload).wait();
        streams.insert(tail.into(), declared);
        sent
    }
}

/// Something that came in.
struct Raw {
    tail: String,
    payload: ZBytes,
    /// `None`: it was put, and the outcome is an event.
    query: Option<Query>,
}

/// The declared keys.
pub(super) struct Server {
    queryables: Vec<Queryable<()>>,
    puts: Subscriber<()>,
    answering: JoinHandle<()>,
}

impl Server {
    pub async fn open(session: &Session, keys: &Keys, stage: &Arc<Stage>, voice: &Arc<Voice>) -> anyhow::Result<Self> {
        let (sender, receiver) = mpsc::channel(REQUESTS);
        let root = format!("sturz/v1/{}/", keys.instance());
        let commands = format!("{root}cmd/*");
        let mut queryables = Vec::new();
        for key in [
            commands.clone(),
            keys.info(),
            keys.features(),
            keys.plan(),
            keys.report_latest(),
            keys.state_latest(),
            format!("{root}contacts/latest"),
            keys.all_shapes(),
            keys.all_fields_latest(),
        ] {
            let (sender, root) = (sender.clone(), root.clone());
            let take = move |query: Query| {
                // Keys with wildcards have no single answer.
                let tail = query.key_expr().as_str().strip_prefix(&root).filter(|tail| !tail.contains('*'));
                if let Some(tail) = tail.map(String::from) {
                    let payload = query.payload().cloned().unwrap_or_default();
                    drop(sender.try_send(Raw { tail, payload, query: Some(query) }));
                }
            };
            let declared = session.declare_queryable(&key).complete(true).callback(take).await;
            queryables.push(declared.map_err(|error| anyhow!("cannot declare {key}: {error}"))?);
        }
        let take = move |sample: Sample| {
            let tail = sample.key_expr().as_str().strip_prefix(&root).unwrap_or_default().to_string();
            drop(sender.try_send(Raw { tail, payload: sample.payload().clone(), query: None }));
        };
        let puts = session.declare_subscriber(&commands).callback(take).await;
        let puts = puts.map_err(|error| anyhow!("cannot declare {commands}: {error}"))?;
        let answering = tokio::spawn(answer_all(receiver, Arc::clone(stage), Arc::clone(voice)));
        Ok(Self { queryables, puts, answering })
    }

    /// Answers what has come in, and nothing more.
    pub async fn close(self) {
        // With them go all senders: the task ends when the queue is empty.
        drop((self.queryables, self.puts));
        drop(tokio::time::timeout(std::time::Duration::from_secs(2), self.answering).await);
    }
}

async fn answer_all(mut receiver: mpsc::Receiver<Raw>, stage: Arc<Stage>, voice: Arc<Voice>) {
    let permits = Arc::new(Semaphore::new(ANSWERS));
    while let Some(raw) = receiver.recv().await {
        let Ok(permit) = Arc::clone(&permits).acquire_owned().await else { return };
        let (stage, voice) = (Arc::clone(&stage), Arc::clone(&voice));
        tokio::task::spawn_blocking(move || {
            answer(raw, &stage, &voice);
            drop(permit);
        });
    }
    drop(permits.acquire_many(ANSWERS as u32).await);
}

/// Sends an answer; may wait for the bus.
fn answer(raw: Raw, stage: &Stage, voice: &Voice) {
    let sent = match (raw.tail.strip_prefix("cmd/"), &raw.query) {
        (Some(name), query) => {
            let outcome = obey(name, &raw.payload, stage);
            match query {
                Some(query) => {
                    query.reply(query.key_expr().clone(), outcome.encode_to_vec()).encoding(encoding("Outcome")).wait()
                }
                None => {
                    let event = outcome_event(v1::Header::default(), outcome);
                    voice.publish("event/command", "Event", event.encode_to_vec().into());
                    Ok(())
                }
            }
        }
        (None, Some(query)) => {
            let parameters = query.parameters();
            let state = match stage.control.mode() {
                Mode::Playing => v1::RunState::Running,
                Mode::Paused => v1::RunState::Paused,
                Mode::Stopping => v1::RunState::Ended,
            };
            let found = stage.shown().answer(&raw.tail, state, [parameters.get("columns"), parameters.get("float")]);
            match found {
                Ok((name, bytes)) => query.reply(query.key_expr().clone(), bytes).encoding(encoding(name)).wait(),
                Err(error) => query.reply_err(error.encode_to_vec()).encoding(encoding("Error")).wait(),
            }
        }
        (None, None) => Ok(()),
    };
    if let Err(error) = sent {
        tracing::debug!("a reply could not be sent: {error}");
    }
}

/// What every request begins with.
#[derive(Clone, PartialEq, prost::Message)]
struct Request {
    #[prost(message, optional, tag = "1")]
    header: Option<v1::CommandHeader>,
}

/// Pauses, resumes and stops; refuses all else.
fn obey(name: &str, payload: &ZBytes, stage: &Stage) -> v1::Outcome {
    let request = Request::decode(payload.to_bytes().as_ref());
    let header = request.clone().ok().and_then(|request| request.header).unwrap_or_default();
    let key = RequestKey { client_id: header.client_id, request_id: header.request_id };
    let mode = match name {
        "pause" => Some(Mode::Paused),
        "resume" => Some(Mode::Playing),
        "stop" => Some(Mode::Stopping),
        _ => None,
    };
    let known = Verb::ALL.iter().find(|verb| verb.name() == name);
    let result = match (mode, known, request) {
        (_, None, _) => Wire::Error(error(v1::ErrorCode::NotFound, "", "there is no such command")),
        (_, _, Err(reason)) => Wire::Error(error(v1::ErrorCode::Undecodable, "", reason.to_string())),
        (Some(mode), ..) => {
            stage.control.set(mode);
            Wire::Applied(v1::Applied {})
        }
        (None, ..) => {
            let text =
                "this is a recording that is played: it can be looked at, paused, resumed and stopped, not steered";
            Wire::Error(error(v1::ErrorCode::Recording, "", text))
        }
    };
    let mut outcome = outcome(&key, Verb::Stop, stage.shown().moment(), result);
    outcome.command = name.into();
    outcome
}
