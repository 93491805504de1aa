//! What goes out to the bus: one task per stream, which takes the latest frame from its slot, encodes and publishes
//! it; one task for events, in order.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use anyhow::anyhow;
use prost::Message;
use sturz_protocol::convert::field_to_wire;
use sturz_protocol::v1;
use tokio::sync::{mpsc, oneshot};
use tokio::task::{AbortHandle, JoinHandle, block_in_place};
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::{Session, Wait};
use zenoh_ext::{AdvancedPublisher, AdvancedPublisherBuilderExt, CacheConfig, MissDetectionConfig};

use crate::events;
use crate::intake::{Io, encoding};
use crate::mailbox::ReportSample;
use crate::outbox::{FieldSample, Notice, Slot};
use crate::output::{Choice, ContactSample, StateSample, encode_contacts, encode_state};
use crate::reply::Identity;

/// How late a lost event is noticed by its subscribers.
pub(crate) const EVENT_HEARTBEAT: Duration = Duration::from_millis(500);

/// A frame that becomes bytes.
pub trait Publish: Send + Sync + 'static {
    /// Name of its message.
    const MESSAGE: &'static str;
    /// Its bytes.
    fn encode(&self, identity: &Identity, seq: u64) -> Vec<u8>;
}

impl Publish for StateSample {
    const MESSAGE: &'static str = "Frame";
    fn encode(&self, identity: &Identity, seq: u64) -> Vec<u8> {
        encode_state(self, identity.blank_header(0, seq)).encode_to_vec()
    }
}

impl Publish for ContactSample {
    const MESSAGE: &'static str = "ContactFrame";
    fn encode(&self, identity: &Identity, seq: u64) -> Vec<u8> {
        encode_contacts(self, identity.blank_header(0, seq)).encode_to_vec()
    }
}

impl Publish for FieldSample {
    const MESSAGE: &'static str = "FieldFrame";
    fn encode(&self, identity: &Identity, seq: u64) -> Vec<u8> {
        let Choice { columns, float } = &self.choice;
        field_to_wire(&self.data, columns, *float, identity.blank_header(0, seq)).encode_to_vec()
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
    loop {
        let (seq, frame) = slot.latest().await;
        // Encoding takes milliseconds, and the bus may wait: not on a thread that others need.
        let sent = block_in_place(|| publisher.put(frame.encode(&io.identity, seq)).wait());
        if let Err(error) = sent {
            tracing::warn!("cannot publish {}: {error}", publisher.key_expr());
        }
        slot.published(frame);
    }
}

/// Publishes events, and starts and ends the streams of fields.
pub struct Notices {
    session: Session,
    io: Arc<Io>,
    /// By topic; with the number of messages so far.
    publishers: HashMap<&'static str, (AdvancedPublisher<'static>, u64)>,
    fields: HashMap<String, AbortHandle>,
}

impl Notices {
    /// Declares the event topics.
    pub async fn open(session: &Session, io: Arc<Io>) -> anyhow::Result<Self> {
        let mut publishers = HashMap::new();
        for topic in events::TOPICS {
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
            publishers.insert(topic, (publisher, 0));
        }
        Ok(Self { session: session.clone(), io, publishers, fields: HashMap::new() })
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
            Notice::Event { mut event, moment, topology_epoch } => {
                event.header = Some(self.io.identity.header(moment, topology_epoch, 0));
                self.publish(*event);
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
        let Some((publisher, seq)) = self.publishers.get_mut(events::topic(event.kind())) else {
            return;
        };
        if let Some(header) = &mut event.header {
            header.seq = *seq;
        }
        *seq += 1;
        if let Err(error) = block_in_place(|| publisher.put(event.encode_to_vec()).wait()) {
            tracing::warn!("cannot publish an event: {error}");
        }
    }
}
