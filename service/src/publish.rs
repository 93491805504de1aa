//! What goes out to the bus: one task per stream, which takes the latest frame from its slot, encodes and publishes
//! it; one task for events, in order.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use anyhow::anyhow;
use prost::Message;
use sturz_engine::Snapshot;
use sturz_engine::fields::FieldFrame;
use sturz_protocol::convert::{FloatType, ParticleColumn, field_to_wire, frame_to_wire};
use sturz_protocol::v1;
use tokio::sync::{mpsc, oneshot};
use tokio::task::{AbortHandle, JoinHandle, block_in_place};
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::{Session, Wait};
use zenoh_ext::{AdvancedPublisher, AdvancedPublisherBuilderExt, CacheConfig, MissDetectionConfig};

use crate::intake::{Io, encoding};
use crate::mailbox::ReportSample;
use crate::outbox::{Notice, Slot};
use crate::reply::Identity;
use crate::ticket::Moment;

/// How late a lost event is noticed by its subscribers.
pub(crate) const EVENT_HEARTBEAT: Duration = Duration::from_millis(500);

/// A frame that becomes bytes.
pub trait Publish: Send + Sync + 'static {
    /// Name of its message.
    const MESSAGE: &'static str;
    /// Its bytes.
    fn encode(&self, identity: &Identity, seq: u64) -> Vec<u8>;
}

impl Publish for Snapshot {
    const MESSAGE: &'static str = "Frame";
    fn encode(&self, identity: &Identity, seq: u64) -> Vec<u8> {
        let header = identity.blank_header(self.topology_epoch, seq);
        frame_to_wire(self, &ParticleColumn::all(), FloatType::F64, header).encode_to_vec()
    }
}

impl Publish for FieldFrame {
    const MESSAGE: &'static str = "FieldFrame";
    fn encode(&self, identity: &Identity, seq: u64) -> Vec<u8> {
        field_to_wire(self, identity.blank_header(0, seq)).encode_to_vec()
    }
}

impl Publish for ReportSample {
    const MESSAGE: &'static str = "Report";
    fn encode(&self, identity: &Identity, seq: u64) -> Vec<u8> {
        identity.report(self, seq).encode_to_vec()
    }
}

/// Publishes what a slot gets under `key`, while anybody subscribes; until the task is aborted.
pub async fn stream<T: Publish>(
    session: &Session,
    io: Arc<Io>,
    key: String,
    slot: Arc<Slot<T>>,
) -> anyhow::Result<AbortHandle> {
    let publisher = session
        .declare_publisher(key.clone())
        .congestion_control(CongestionControl::Drop)
        .priority(Priority::DataLow)
        .encoding(encoding(T::MESSAGE))
        .await
        .map_err(|error| anyhow!("cannot declare {key}: {error}"))?;
    let (watched, mailbox) = (Arc::clone(&slot), io.mailbox.clone());
    let watch = move |status: zenoh::matching::MatchingStatus| {
        watched.set_wanted(status.matching());
        // A paused simulation must look up to hand out the state of now.
        mailbox.wake();
    };
    let listener = publisher.matching_listener().callback(watch).background().await;
    listener.map_err(|error| anyhow!("cannot watch {key}: {error}"))?;
    Ok(tokio::spawn(pump(publisher, io, slot)).abort_handle())
}

async fn pump<T: Publish>(publisher: Publisher<'static>, io: Arc<Io>, slot: Arc<Slot<T>>) {
    for seq in 0.. {
        let frame = slot.latest().await;
        // Encoding takes milliseconds, and the bus may wait: not on a thread that others need.
        let sent = block_in_place(|| publisher.put(frame.encode(&io.identity, seq)).wait());
        if let Err(error) = sent {
            tracing::warn!("cannot publish {}: {error}", publisher.key_expr());
        }
        slot.published(frame);
    }
}

/// Event topics, each with a history of its own, so that many commands do not push out the start of the run.
pub(crate) const TOPICS: [&str; 5] = ["command", "run", "particles", "field", "checkpoint"];

fn topic(kind: v1::EventKind) -> &'static str {
    match kind {
        v1::EventKind::Command => "command",
        v1::EventKind::Particles => "particles",
        v1::EventKind::Field => "field",
        v1::EventKind::Checkpoint | v1::EventKind::Restored => "checkpoint",
        _ => "run",
    }
}

/// The outcome of a command that was put.
pub fn command_event(identity: &Identity, outcome: &[u8]) -> v1::Event {
    let outcome = v1::Outcome::decode(outcome).unwrap_or_default();
    let moment = Moment { step: outcome.step, time_s: outcome.sim_time_s };
    outcome_event(identity.header(moment, 0, 0), outcome)
}

/// The same with a header of one's own.
pub(crate) fn outcome_event(header: v1::Header, outcome: v1::Outcome) -> v1::Event {
    let (severity, message) = match &outcome.result {
        Some(v1::outcome::Result::Error(error)) => (v1::Severity::Warning, error.message.clone()),
        _ => (v1::Severity::Info, format!("{} is done", outcome.command)),
    };
    v1::Event {
        header: Some(header),
        kind: v1::EventKind::Command.into(),
        severity: severity.into(),
        message,
        outcome: Some(outcome),
        name: String::new(),
    }
}

/// Publishes events, and starts and ends the streams of fields.
pub struct Notices {
    session: Session,
    io: Arc<Io>,
    publishers: HashMap<&'static str, AdvancedPublisher<'static>>,
    fields: HashMap<String, AbortHandle>,
    seq: u64,
}

impl Notices {
    /// Declares the event topics.
    pub async fn open(session: &Session, io: Arc<Io>) -> anyhow::Result<Self> {
        let mut publishers = HashMap::new();
        for topic in TOPICS {
            let key = io.keys.event(topic);
            let publisher = session
                .declare_publisher(key.clone())
                .congestion_control(CongestionControl::Block)
                .encoding(encoding("Event"))
                .cache(CacheConfig::default().max_samples(io.limits.remembered_events))
                .sample_miss_detection(MissDetectionConfig::default().sporadic_heartbeat(EVENT_HEARTBEAT))
                .publisher_detection()
                .await
                .map_err(|error| anyhow!("cannot declare {key}: {error}"))?;
            publishers.insert(topic, publisher);
        }
        Ok(Self { session: session.clone(), io, publishers, fields: HashMap::new(), seq: 0 })
    }

    /// Goes on until `last` resolves, and all that was sent before has been published.
    pub fn spawn(
        mut self,
        mut notices: mpsc::Receiver<Notice>,
        mut events: mpsc::Receiver<v1::Event>,
        mut last: oneshot::Receiver<()>,
    ) -> JoinHandle<()> {
        tokio::spawn(async move {
            loop {
                tokio::select! {
                    // In this order: the end comes when nothing waits any more. The queues do not close by themselves,
                    // since this task shares the senders.
                    biased;
                    Some(notice) = notices.recv() => self.hear(notice).await,
                    Some(event) = events.recv() => self.publish(event),
                    _ = &mut last => break,
                }
            }
            self.fields.values().for_each(AbortHandle::abort);
        })
    }

    async fn hear(&mut self, notice: Notice) {
        match notice {
            Notice::Event { kind, severity, message, name, moment, topology_epoch } => {
                let header = self.io.identity.header(moment, topology_epoch, 0);
                self.publish(v1::Event {
                    header: Some(header),
                    kind: kind.into(),
                    severity: severity.into(),
                    message,
                    outcome: None,
                    name,
                });
            }
            Notice::FieldDefined(name, slot) => {
                let key = self.io.keys.field(&name);
                match stream(&self.session, Arc::clone(&self.io), key, slot).await {
                    Ok(task) => drop(self.fields.insert(name, task)),
                    Err(error) => tracing::error!("{error}"),
                }
            }
            Notice::FieldDropped(name) => {
                if let Some(task) = self.fields.remove(&name) {
                    task.abort();
                }
            }
        }
    }

    fn publish(&mut self, mut event: v1::Event) {
        if let Some(header) = &mut event.header {
            header.seq = self.seq;
        }
        self.seq += 1;
        let Some(publisher) = self.publishers.get(topic(event.kind())) else {
            return;
        };
        if let Err(error) = block_in_place(|| publisher.put(event.encode_to_vec()).wait()) {
            tracing::warn!("cannot publish an event: {error}");
        }
    }
}
