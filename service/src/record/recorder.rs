//! A bus client that writes down what it hears.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::time::Duration;

use anyhow::anyhow;
use prost::Message as _;
use serde::Serialize;
use sturz_protocol::keys::Keys;
use sturz_protocol::v1;
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep, sleep_until};
use zenoh::Session;
use zenoh::pubsub::Subscriber;
use zenoh::sample::{Sample, SampleKind};
use zenoh_ext::{AdvancedSubscriber, AdvancedSubscriberBuilderExt, HistoryConfig, RecoveryConfig};

use super::disk::{Disk, EndReason, Queue, StreamTally, Until};
use super::headed::message_of;
use super::write::RecordingWriter;
use crate::commands::ask;

/// Least wall time between two queries for `info`: answering it costs the physics a state hash.
const INFO_PERIOD: Duration = Duration::from_secs(1);

/// How long to listen after the daemon's liveliness is lost.
const LAST_WORDS: Duration = Duration::from_millis(300);

/// How long to wait for the other streams when one has reached the simulated time asked for: their frames come later, or
/// never where the scene gives them no rate.
const STRAGGLERS: Duration = Duration::from_secs(10);

/// What to record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Streams {
    /// `state/frame`
    pub state: bool,
    /// `field/*`
    pub fields: bool,
    /// `report`
    pub report: bool,
    /// `event/**`
    pub events: bool,
    /// `contacts/*`: as long as somebody listens, the daemon collects the contacts of each frame.
    pub contacts: bool,
}

/// How to record.
pub struct Options {
    /// Where to.
    pub out: PathBuf,
    /// What.
    pub streams: Streams,
    /// With zstd.
    pub compressed: bool,
    /// Bytes that may wait for the disk.
    pub queue_bytes: u64,
    /// End after this wall time.
    pub duration: Option<Duration>,
    /// End with the first message of this simulated time or later, s.
    pub until_sim_s: Option<f64>,
}

/// What was recorded.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// Name on the bus.
    pub instance: String,
    /// The file.
    pub file: PathBuf,
    /// Of the file.
    pub bytes: u64,
    /// Why it ended: `asked`, `duration`, `sim_time` or `daemon_ended`.
    pub ended_by: &'static str,
    /// Simulated time of the first and the last message that has one, s.
    pub sim_time_s: Option<[f64; 2]>,
    /// By key below the instance.
    pub streams: BTreeMap<String, StreamTally>,
    /// Messages that came while too many waited for the disk; they are among those lost.
    pub dropped_at_disk: u64,
}

/// Records until `end` resolves, the daemon ends or the options say so. `ready` is called when it listens.
pub async fn record(
    session: &Session,
    keys: &Keys,
    options: &Options,
    end: impl Future<Output = ()>,
    ready: impl FnOnce(),
) -> anyhow::Result<Summary> {
    let facts = BTreeMap::from([
        ("instance".to_string(), keys.instance().to_string()),
        ("publish_time".into(), "Header.wall_time_ns: wall clock when the message was made".into()),
        ("log_time".into(), "wall clock when the message came in".into()),
    ]);
    let info = v1::Info::decode(ask(session, keys.info()).await?.as_slice())?;
    let writer = RecordingWriter::create(&options.out, options.compressed, facts)?;
    let (found, mut heard) = mpsc::channel(64);
    let until = options.until_sim_s.map(|sim_time_s| Until { sim_time_s, streams: expected(options.streams, &info) });
    let (queue, disk) = Disk::start(writer, keys.instance(), options.queue_bytes, until, found)?;
    let (gone, mut vanished) = mpsc::channel(1);
    let watch = watch(session, keys, gone).await?;
    let mut facts = Facts { session, keys, queue: queue.clone(), shapes: None };
    facts.all().await?;
    let ears = listen(session, keys, options.streams, &queue).await?;
    drop(queue);
    ready();

    let ended_by = listen_until(options.duration, &mut facts, &mut heard, &mut vanished, end).await;
    match ended_by {
        // The loss overtakes the last messages of a daemon that ends in good order.
        "daemon_ended" => sleep(LAST_WORDS).await,
        _ => drop(facts.info().await),
    }
    drop((ears, watch));
    // The last sender: the disk ends when all that waits is written.
    drop(facts);
    let (tally, dropped_at_disk) = tokio::task::spawn_blocking(move || disk.join()).await??;
    Ok(Summary {
        instance: keys.instance().into(),
        file: options.out.clone(),
        bytes: std::fs::metadata(&options.out)?.len(),
        ended_by,
        sim_time_s: tally.sim_time_s,
        streams: tally.streams,
        dropped_at_disk,
    })
}

/// Why it ends.
async fn listen_until(
    duration: Option<Duration>,
    facts: &mut Facts<'_>,
    heard: &mut mpsc::Receiver<EndReason>,
    vanished: &mut mpsc::Receiver<()>,
    end: impl Future<Output = ()>,
) -> &'static str {
    let deadline = duration.map(|duration| Instant::now() + duration);
    let mut asked_at = Instant::now();
    let mut info_is_stale = false;
    let mut near = None;
    tokio::pin!(end);
    loop {
        tokio::select! {
            () = &mut end => break "asked",
            () = at(deadline) => break "duration",
            () = at(near) => break "sim_time",
            _ = vanished.recv() => break "daemon_ended",
            Some(reason) = heard.recv() => match reason {
                EndReason::TimeReached => break "sim_time",
                EndReason::TimeNear => {
                    let last = Instant::now() + STRAGGLERS;
                    near = Some(near.unwrap_or(last).min(last));
                }
                EndReason::Failed => break "asked",
                EndReason::InfoChanged => info_is_stale = true,
            },
            () = at(info_is_stale.then(|| asked_at + INFO_PERIOD)) => {
                (asked_at, info_is_stale) = (Instant::now(), false);
                // A daemon that is ending answers no more; its token tells.
                drop(facts.info().await);
            }
        }
    }
}

/// Streams that a complete recording has up to its end.
fn expected(streams: Streams, info: &v1::Info) -> BTreeSet<String> {
    let fields = info.fields.iter().filter(|_| streams.fields).map(|field| format!("field/{}", field.name));
    let others = [(streams.state, "state/frame"), (streams.report, "report"), (streams.contacts, "contacts/frame")];
    let others = others.into_iter().filter(|(wanted, _)| *wanted).map(|(_, tail)| tail.to_string());
    fields.chain(others).collect()
}

/// Never, without an instant.
async fn at(instant: Option<Instant>) {
    match instant {
        Some(instant) => sleep_until(instant).await,
        None => std::future::pending().await,
    }
}

/// What is asked for rather than heard.
struct Facts<'a> {
    session: &'a Session,
    keys: &'a Keys,
    queue: Queue,
    /// Names of the shapes last written.
    shapes: Option<Vec<String>>,
}

impl Facts<'_> {
    async fn all(&mut self) -> anyhow::Result<()> {
        for (key, tail) in [(self.keys.features(), "features"), (self.keys.plan(), "plan")] {
            let payload = ask(self.session, key).await?;
            self.queue.add(tail, message_of(tail), payload.into());
        }
        self.info().await
    }

    /// `info`, and the shapes where they are not those written last.
    async fn info(&mut self) -> anyhow::Result<()> {
        let payload = ask(self.session, self.keys.info()).await?;
        let names = v1::Info::decode(payload.as_slice())?.shapes;
        self.queue.add("info", "Info", payload.into());
        if self.shapes.as_ref() != Some(&names) {
            let payload = ask(self.session, self.keys.shapes_latest()).await?;
            self.queue.add("shapes/latest", "Shapes", payload.into());
            self.shapes = Some(names);
        }
        Ok(())
    }
}

/// Subscriptions; dropping them ends them.
struct Ears {
    _live: Vec<Subscriber<()>>,
    _events: Option<AdvancedSubscriber<()>>,
}

async fn listen(session: &Session, keys: &Keys, streams: Streams, queue: &Queue) -> anyhow::Result<Ears> {
    let take = || {
        let (queue, root) = (queue.clone(), format!("sturz/v1/{}/", keys.instance()));
        move |sample: Sample| {
            let tail = sample.key_expr().as_str().strip_prefix(&root).unwrap_or_default();
            let encoding = sample.encoding().to_string();
            let message = encoding.rsplit_once("sturz.v1.").map_or_else(|| message_of(tail), |(_, name)| name);
            queue.add(tail, message, sample.payload().clone());
        }
    };
    let chosen = [
        (streams.state, keys.state_frame()),
        (streams.fields, keys.field("*")),
        (streams.report, keys.report()),
        (streams.contacts, format!("sturz/v1/{}/contacts/*", keys.instance())),
    ];
    let mut live = Vec::new();
    for (_, key) in chosen.into_iter().filter(|(wanted, _)| *wanted) {
        let declared = session.declare_subscriber(&key).callback(take()).await;
        live.push(declared.map_err(|error| anyhow!("cannot subscribe to {key}: {error}"))?);
    }
    let events = if streams.events {
        let history = HistoryConfig::default().detect_late_publishers();
        let recovery = RecoveryConfig::default().heartbeat();
        let builder = session.declare_subscriber(keys.all_events()).callback(take());
        let declared = builder.history(history).recovery(recovery).await;
        Some(declared.map_err(|error| anyhow!("cannot subscribe to {}: {error}", keys.all_events()))?)
    } else {
        None
    };
    Ok(Ears { _live: live, _events: events })
}

/// Tells of the end of the daemon.
async fn watch(session: &Session, keys: &Keys, gone: mpsc::Sender<()>) -> anyhow::Result<Subscriber<()>> {
    let note = move |sample: Sample| {
        if sample.kind() == SampleKind::Delete {
            let _ = gone.try_send(());
        }
    };
    let declared = session.liveliness().declare_subscriber(keys.alive()).history(true).callback(note).await;
    declared.map_err(|error| anyhow!("cannot watch {}: {error}", keys.alive()))
}
