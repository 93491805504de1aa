//! Where the messages come from: a recording, a daemon, or a run without a bus.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

use anyhow::{Context as _, anyhow};
use prost::Message as _;
use sturz_engine::fields::FieldDefinition;
use sturz_engine::scene::Scene;
use sturz_engine::{ContactColumn, ContactNetwork, Engine, FloatType, ParticleColumn, Snapshot, StepError};
use sturz_protocol::convert::{contacts_to_wire, field_to_wire, frame_to_wire};
use sturz_protocol::keys::Keys;
use sturz_protocol::v1;
use tokio::sync::mpsc;
use zenoh::Session;
use zenoh::bytes::ZBytes;
use zenoh::sample::{Sample, SampleKind};

use super::exporter::Exporter;
use super::series::{next_multiple, reached};
use crate::commands::ask;
use crate::config::Limits;
use crate::record::{Recording, message_of};
use crate::reply::Identity;

/// Messages of a followed daemon that wait to be written.
const QUEUE: usize = 16;
/// How long the engine steps before the progress bar is looked after.
const SLICE: Duration = Duration::from_millis(100);

impl Exporter {
    /// Takes a message by its name; others than states, contacts, fields and what they refer to are passed over.
    pub fn message(&mut self, name: &str, payload: &[u8]) -> anyhow::Result<()> {
        match name {
            "Info" => self.info(v1::Info::decode(payload)?)?,
            "Shapes" => self.shapes(v1::Shapes::decode(payload)?)?,
            "Frame" => self.frame(&v1::Frame::decode(payload)?)?,
            "FieldFrame" => self.field(&v1::FieldFrame::decode(payload)?)?,
            "ContactFrame" => self.contacts(&v1::Frame::decode(payload)?)?,
            _ => {}
        }
        Ok(())
    }
}

/// All of a recording, up to its end or its cut.
pub fn export_recording(path: &Path, exporter: &mut Exporter) -> anyhow::Result<()> {
    let mut recording = Recording::open(path)?;
    if !recording.is_finished() {
        tracing::warn!("{}", recording.warning_of_cut());
    }
    while let Some(message) = recording.read()? {
        exporter.message(&message.topic.message, &message.payload)?;
    }
    Ok(())
}

/// The state of now of a daemon, or with `follow` all that it publishes, until `end` resolves or it ends.
pub async fn export_daemon(
    session: &Session,
    keys: &Keys,
    mut exporter: Exporter,
    follow: bool,
    end: impl Future<Output = ()>,
) -> anyhow::Result<Exporter> {
    let info = ask(session, keys.info()).await?;
    let fields = v1::Info::decode(info.as_slice())?.fields;
    exporter.message("Info", &info)?;
    exporter.message("Shapes", &ask(session, keys.shapes_latest()).await?)?;
    if follow {
        return follow_daemon(session, keys, exporter, end).await;
    }
    exporter.message("Frame", &ask(session, keys.state_latest()).await?)?;
    if exporter.options().contacts {
        // Daemons without the contact network do not know the key.
        if let Ok(contacts) = ask(session, format!("sturz/v1/{}/contacts/latest", keys.instance())).await {
            exporter.message("ContactFrame", &contacts)?;
        }
    }
    if exporter.options().fields {
        for field in fields {
            exporter.message("FieldFrame", &ask(session, keys.field_latest(&field.name)).await?)?;
        }
    }
    Ok(exporter)
}

async fn follow_daemon(
    session: &Session,
    keys: &Keys,
    mut exporter: Exporter,
    end: impl Future<Output = ()>,
) -> anyhow::Result<Exporter> {
    let (sender, mut receiver) = mpsc::channel::<(String, ZBytes)>(QUEUE);
    let lost = Arc::new(AtomicU64::new(0));
    let mut subscribers = Vec::new();
    let options = exporter.options();
    let chosen = [
        (options.particles || options.boundaries || options.contacts, keys.state_frame()),
        (options.fields, keys.field("*")),
        (options.contacts, format!("sturz/v1/{}/contacts/*", keys.instance())),
    ];
    for (_, key) in chosen.into_iter().filter(|(wanted, _)| *wanted) {
        let (sender, lost) = (sender.clone(), Arc::clone(&lost));
        let root = format!("sturz/v1/{}/", keys.instance());
        let take = move |sample: Sample| {
            let tail = sample.key_expr().as_str().strip_prefix(&root).unwrap_or_default();
            let encoding = sample.encoding().to_string();
            let message = encoding.rsplit_once("sturz.v1.").map_or_else(|| message_of(tail), |(_, name)| name);
            if sender.try_send((message.into(), sample.payload().clone())).is_err() {
                lost.fetch_add(1, Relaxed);
            }
        };
        let declared = session.declare_subscriber(&key).callback(take).await;
        subscribers.push(declared.map_err(|error| anyhow!("cannot subscribe to {key}: {error}"))?);
    }
    drop(sender);
    let (gone, mut vanished) = mpsc::channel(1);
    let note = move |sample: Sample| {
        if sample.kind() == SampleKind::Delete {
            let _ = gone.try_send(());
        }
    };
    let watch = session.liveliness().declare_subscriber(keys.alive()).history(true).callback(note).await;
    let watch = watch.map_err(|error| anyhow!("cannot watch {}: {error}", keys.alive()))?;
    let writing = tokio::task::spawn_blocking(move || {
        while let Some((message, payload)) = receiver.blocking_recv() {
            exporter.message(&message, &payload.to_bytes())?;
        }
        Ok::<_, anyhow::Error>(exporter)
    });
    tokio::pin!(end, writing);
    tokio::select! {
        () = &mut end => {}
        _ = vanished.recv() => {}
        // Ends by itself only when it cannot write.
        failed = &mut writing => return failed?,
    }
    drop((subscribers, watch));
    let exporter = writing.await??;
    match lost.load(Relaxed) {
        0 => {}
        lost => tracing::warn!("{lost} messages were left out: the disk was not keeping up"),
    }
    Ok(exporter)
}

/// A run without a bus.
pub struct SceneRun<'a> {
    /// What is run.
    pub scene: Scene,
    /// Where it starts, instead of at step 0.
    pub checkpoint: Option<&'a Path>,
    /// Simulated time at which to end, s; where it starts when absent.
    pub stop_s: Option<f64>,
    /// Simulated time between two frames, s; the start and the end only when absent.
    pub every_s: Option<f64>,
    /// Of the physics.
    pub threads: usize,
}

/// Runs a scene and writes its states; `Ok(Some)` tells why a step was refused after the last one written.
pub fn export_scene(
    run: SceneRun<'_>,
    exporter: &mut Exporter,
    interrupted: &AtomicBool,
    progress: impl Fn(&Engine),
) -> anyhow::Result<Option<StepError>> {
    let identity = Identity::new("export", String::new(), &run.scene, run.threads, &Limits::default());
    exporter.info(identity.scene_info())?;
    exporter.shapes(identity.shapes.clone())?;
    let fields = run.scene.description().fields.clone();
    let mut engine = Engine::new(run.scene);
    engine.set_threads(run.threads);
    if let Some(path) = run.checkpoint {
        let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
        engine.restore(&bytes).map_err(|failure| anyhow!("the checkpoint {} {failure}", path.display()))?;
        engine.end_window();
    }
    let mut snapshot = Snapshot::default();
    write_state(&mut engine, &mut snapshot, &fields, exporter)?;
    let stop_s = run.stop_s.unwrap_or(f64::NEG_INFINITY);
    let mut next_s = next_time(engine.clock().time_s(), run.every_s);
    while !reached(engine.clock().time_s(), stop_s) && !interrupted.load(Relaxed) {
        let until_s = next_s.min(stop_s);
        if let Err(failure) = engine.in_pool(|engine| step_until(engine, until_s, interrupted)) {
            write_state(&mut engine, &mut snapshot, &fields, exporter)?;
            return Ok(Some(failure));
        }
        progress(&engine);
        if reached(engine.clock().time_s(), until_s) {
            write_state(&mut engine, &mut snapshot, &fields, exporter)?;
            next_s = next_time(engine.clock().time_s(), run.every_s);
        }
    }
    Ok(None)
}

/// Without an interval, never.
fn next_time(time_s: f64, every_s: Option<f64>) -> f64 {
    every_s.map_or(f64::INFINITY, |every_s| next_multiple(time_s, every_s))
}

/// Steps up to a time, or for a slice of wall time.
fn step_until(engine: &mut Engine, until_s: f64, interrupted: &AtomicBool) -> Result<(), StepError> {
    let begin = Instant::now();
    let is_there = |engine: &Engine| reached(engine.clock().time_s(), until_s);
    while !is_there(engine) && !interrupted.load(Relaxed) && begin.elapsed() < SLICE {
        engine.step()?;
    }
    Ok(())
}

fn write_state(
    engine: &mut Engine,
    snapshot: &mut Snapshot,
    fields: &[FieldDefinition],
    exporter: &mut Exporter,
) -> anyhow::Result<()> {
    engine.snapshot(snapshot);
    exporter.frame(&frame_to_wire(snapshot, &ParticleColumn::usual(), FloatType::F64, v1::Header::default()))?;
    if exporter.options().fields {
        for definition in fields {
            let field = engine.compute_field(definition);
            exporter.field(&field_to_wire(&field, &definition.quantities, FloatType::F64, v1::Header::default()))?;
        }
    }
    if exporter.options().contacts {
        let mut network = ContactNetwork::default();
        engine.contact_network(&mut network);
        let v1::ContactFrame { header, n, columns } =
            contacts_to_wire(&network, &ContactColumn::usual(), FloatType::F64, v1::Header::default());
        exporter.contacts(&v1::Frame { header, n, columns, ..v1::Frame::default() })?;
    }
    Ok(())
}
