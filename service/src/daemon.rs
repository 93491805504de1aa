//! A simulation on the bus: wiring, start and end.

use std::io::Read as _;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::thread;
use std::time::Duration;

use anyhow::anyhow;
use sturz_engine::Engine;
use sturz_engine::scene::Scene;
use sturz_protocol::keys::Keys;
use thiserror::Error;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::{Semaphore, mpsc, oneshot};
use tokio::task::AbortHandle;
use zenoh::Session;

use crate::archive::Archive;
use crate::autosave::Autosave;
use crate::checkpoints::Checkpoints;
use crate::config::{Bus, Limits};
use crate::intake::{self, Io};
use crate::journal::Folder;
use crate::journal::record::Start;
use crate::mailbox::{Inbox, Mailbox, mailbox};
use crate::meter::Meter;
use crate::metrics::Endpoint;
use crate::outbox::Outbox;
use crate::publish::{self, Notices};
use crate::reply::{Identity, wall_time_ns};
use crate::runner::{Phase, Runner, Shared};
use crate::security::door::Door;
use crate::stages::StageTotals;

/// Notices of the physics that wait for the bus.
const NOTICES: usize = 1024;
/// Events that wait for the bus.
const EVENTS: usize = 256;
/// How long the last replies may take at the end.
const LAST_REPLIES: Duration = Duration::from_secs(2);
/// How long to look for another daemon of the same name.
const NAME_SEARCH: Duration = Duration::from_millis(500);

/// How to serve.
pub struct Options {
    /// Name on the bus.
    pub instance: String,
    /// Where on the bus.
    pub bus: Bus,
    /// What to refuse.
    pub limits: Limits,
    /// Threads of the physics.
    pub threads: usize,
    /// Wait for commands at the start.
    pub paused: bool,
    /// Folder for checkpoints on disk.
    pub checkpoints: Option<PathBuf>,
    /// Wall time between checkpoints that nobody asks for.
    pub checkpoint_every: Option<Duration>,
    /// Where to start, instead of at step 0.
    pub restore: Option<Restore>,
    /// What keeps the run beyond this process.
    pub journal: Option<KeptRun>,
    /// End when standard input does: with whoever started this process.
    pub stop_on_stdin_eof: bool,
    /// Where Prometheus finds the report.
    pub metrics: Option<SocketAddr>,
}

/// A run with a journal.
pub struct KeptRun {
    /// Its folder.
    pub folder: Folder,
    /// It has been there before: go on where it was.
    pub resumes: bool,
}

/// A checkpoint to start from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Restore {
    /// The one of the folder with the most steps.
    Newest,
    /// The one of this token.
    Token(String),
}

/// What a launcher must know, once clients can connect.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Ready {
    /// The first of `endpoints`.
    pub endpoint: String,
    /// What the daemon listens on, ports resolved.
    pub endpoints: Vec<String>,
    /// Name on the bus.
    pub instance: String,
    /// Another one for every start.
    pub run_id: String,
    /// Of this process.
    pub pid: u32,
    /// Of the metrics, where they are served.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metrics: Option<String>,
}

/// Why there is no service.
#[derive(Debug, Error)]
pub enum ServeError {
    /// The bus does not let us in.
    #[error(
        "cannot listen on {endpoints:?}: {reason}. Is another daemon there? Choose another --listen, such as `auto`"
    )]
    Bus {
        /// Where.
        endpoints: Vec<String>,
        /// As zenoh says.
        reason: String,
    },
    /// Two daemons of one name would answer at random.
    #[error("an instance {instance:?} is alive on this bus: choose another --name")]
    NameTaken {
        /// The name.
        instance: String,
    },
    /// The metrics have no place.
    #[error("--metrics: cannot listen on {address}: {reason}")]
    Metrics {
        /// Where.
        address: SocketAddr,
        /// As the system says.
        reason: std::io::Error,
    },
    /// Something else.
    #[error(transparent)]
    Other(#[from] anyhow::Error),
}

/// Serves a scene until a signal, a command or the end of standard input.
pub async fn serve(scene: Scene, options: Options, ready: impl FnOnce(&Ready)) -> Result<(), ServeError> {
    let keys = Keys::new(&options.instance).map_err(|error| anyhow!(error))?;
    let endpoint = open_metrics(options.metrics).await?;
    let session = open_session(&options.bus).await?;
    refuse_twin(&session, &keys).await?;
    Door::watch(&session, &options.bus, options.limits.clients).await?;

    let run_id: String = session.zid().to_string().chars().take(16).collect();
    let identity = identify(&options, &scene, run_id.clone());
    let (letters, inbox) = mailbox(options.limits.queue_length);
    let (notices, notices_heard) = mpsc::channel(NOTICES);
    let (events, events_heard) = mpsc::channel(EVENTS);
    let shared = Arc::new(Shared::default());
    let outbox = Outbox::new(&scene.description().output, notices);
    let (limits, open) = (options.limits.clone(), Arc::new(Semaphore::new(options.limits.open_requests)));
    let (for_io, by_io) = (letters.clone(), Arc::clone(&shared));
    let io = Arc::new(Io { keys: keys.clone(), identity, limits, mailbox: for_io, shared: by_io, events, open });

    let state = publish::stream(&session, Arc::clone(&io), keys.state_frame(), outbox.state.slot()).await?;
    let contacts = publish::stream(&session, Arc::clone(&io), keys.contacts_frame(), outbox.contacts.slot()).await?;
    let report = publish::stream(&session, Arc::clone(&io), keys.report(), outbox.report.slot()).await?;
    let (more_events, last) = oneshot::channel::<()>();
    let publishing = Notices::open(&session, Arc::clone(&io)).await?.spawn(notices_heard, events_heard, last);
    // Before anybody can know that there is something to end.
    let asked = asked_to_end(options.stop_on_stdin_eof)?;
    let (engine, checkpoints) = start_state(scene, &options, letters.clone())?;
    let started = start_physics(
        engine,
        options,
        (letters.clone(), inbox, outbox),
        checkpoints,
        (run_id.clone(), Arc::clone(&shared)),
    )?;
    let (taken_up, mut ended) = started;
    // Nobody is let in before all that was accepted is there again.
    taken_up.await.map_err(|_| anyhow!("the physics has failed at its start"))??;
    let intake = intake::open(&session, Arc::clone(&io)).await?;
    let watch = watch_clients(&session, Arc::clone(&io)).await?;
    let token = session.liveliness().declare_token(keys.alive()).await.map_err(|error| anyhow!(error))?;
    let metrics = endpoint.as_ref().map(|endpoint| format!("http://{}/metrics", endpoint.address));
    let scraped = endpoint.map(|endpoint| endpoint.spawn(Arc::clone(&io)));
    ready(&Ready { metrics, ..describe(&session, &keys, run_id).await });

    tokio::select! {
        _ = &mut ended => {}
        () = asked => {
            shared.stop.store(true, Relaxed);
            letters.wake();
            drop(ended.await);
        }
    }
    tracing::info!("ending");
    let all = io.limits.open_requests as u32;
    drop(tokio::time::timeout(LAST_REPLIES, io.open.acquire_many(all)).await);
    drop((intake, watch));
    [Some(state), Some(contacts), Some(report), scraped].iter().flatten().for_each(AbortHandle::abort);
    drop(more_events);
    if tokio::time::timeout(LAST_REPLIES, publishing).await.is_err() {
        tracing::debug!("the last events were not all sent");
    }
    // Last: clients take the loss of the token for the end of all answers.
    drop(token.undeclare().await);
    session.close().await.map_err(|error| anyhow!(error))?;
    Ok(())
}

async fn open_metrics(address: Option<SocketAddr>) -> Result<Option<Endpoint>, ServeError> {
    let Some(address) = address else {
        return Ok(None);
    };
    let opened = Endpoint::open(address).await;
    opened.map(Some).map_err(|reason| ServeError::Metrics { address, reason })
}

fn identify(options: &Options, scene: &Scene, run_id: String) -> Identity {
    let mut identity = Identity::new(&options.instance, run_id, scene, options.threads, &options.limits);
    if options.bus.controls_access() {
        identity.features.capabilities.push("access_control".into());
    }
    identity
}

/// Notes which clients are there. The callback only notes, and wakes the physics.
async fn watch_clients(session: &Session, io: Arc<Io>) -> anyhow::Result<zenoh::pubsub::Subscriber<()>> {
    let key = io.keys.all_clients();
    let note = move |sample: zenoh::sample::Sample| {
        let name = sample.key_expr().as_str().rsplit('/').next().unwrap_or_default();
        io.shared.clients.note(name, sample.kind() == zenoh::sample::SampleKind::Put, io.limits.clients);
        io.mailbox.wake();
    };
    let declared = session.liveliness().declare_subscriber(&key).history(true).callback(note).await;
    declared.map_err(|error| anyhow!("cannot watch {key}: {error}"))
}

pub(crate) async fn open_session(bus: &Bus) -> Result<Session, ServeError> {
    let config = bus.daemon_config()?;
    zenoh::open(config)
        .await
        .map_err(|error| ServeError::Bus { endpoints: bus.listen.clone(), reason: error.to_string() })
}

pub(crate) async fn refuse_twin(session: &Session, keys: &Keys) -> Result<(), ServeError> {
    let replies = session.liveliness().get(keys.alive()).timeout(NAME_SEARCH).await;
    let replies = replies.map_err(|error| anyhow!(error))?;
    while let Ok(reply) = replies.recv_async().await {
        if reply.result().is_ok() {
            return Err(ServeError::NameTaken { instance: keys.instance().into() });
        }
    }
    Ok(())
}

pub(crate) async fn describe(session: &Session, keys: &Keys, run_id: String) -> Ready {
    let endpoints: Vec<String> = session.info().locators().await.iter().map(ToString::to_string).collect();
    Ready {
        endpoint: endpoints.first().cloned().unwrap_or_default(),
        endpoints,
        instance: keys.instance().into(),
        run_id,
        pid: std::process::id(),
        metrics: None,
    }
}

/// The engine where it is to start, and what is saved.
fn start_state(scene: Scene, options: &Options, letters: Mailbox) -> anyhow::Result<(Engine, Checkpoints)> {
    let kept = options.journal.as_ref().map(|kept| kept.folder.checkpoints());
    let files = options.checkpoints.clone().or(kept);
    let archive = files.as_deref().map(|folder| Archive::open(folder, letters)).transpose()?;
    let checkpoints = Checkpoints::new(archive);
    let mut engine = Engine::new(scene);
    if let Some(restore) = &options.restore {
        go_to(&mut engine, &checkpoints, restore)?;
    }
    Ok((engine, checkpoints))
}

/// Brings a new engine to a saved state.
fn go_to(engine: &mut Engine, checkpoints: &Checkpoints, restore: &Restore) -> anyhow::Result<()> {
    let token = match restore {
        Restore::Token(token) => token.clone(),
        Restore::Newest => {
            let newest = checkpoints.list().into_iter().max_by_key(|checkpoint| checkpoint.step);
            newest
                .ok_or_else(|| anyhow!("--restore newest: the folder of --checkpoints has no sound checkpoint"))?
                .token
        }
    };
    let bytes = checkpoints.bytes(&token).map_err(|error| anyhow!("--restore: {}", error.message))?;
    engine.restore(&bytes).map_err(|failure| anyhow!("--restore: the checkpoint {token:?} {failure}"))?;
    if engine.clock().is_in_window() {
        engine.end_window();
    }
    tracing::info!("starts from the checkpoint {token:?} of step {}", engine.clock().step());
    Ok(())
}

/// Hears whether the run could be taken up, and when it has ended.
type Started = (oneshot::Receiver<anyhow::Result<()>>, oneshot::Receiver<()>);

/// Starts the physics on its own thread.
fn start_physics(
    mut engine: Engine,
    options: Options,
    (letters, inbox, outbox): (Mailbox, Inbox, Outbox),
    checkpoints: Checkpoints,
    (run_id, shared): (String, Arc<Shared>),
) -> anyhow::Result<Started> {
    let (ending, ended) = oneshot::channel();
    let (taking_up, taken_up) = oneshot::channel();
    let body = move || {
        let totals = StageTotals::default();
        engine.set_threads(options.threads);
        engine.set_most_pairs(options.limits.pairs);
        engine.set_timer(Some(totals.timer()));
        // All of the loop inside the pool: a hand-over per step costs more than a small step.
        engine.in_pool(|engine| {
            let mut runner = Runner::new(engine, inbox, outbox, shared, options.limits);
            runner.phase = if options.paused { Phase::Paused } else { Phase::Running };
            runner.checkpoints = checkpoints;
            runner.autosave = options.checkpoint_every.map(Autosave::new);
            runner.meter = Meter::new(totals);
            let start = Start {
                version: env!("CARGO_PKG_VERSION").into(),
                run_id,
                wall_time_ns: wall_time_ns(),
                paused: options.paused,
                threads: options.threads as u32,
                is_first: false,
            };
            let kept = options.journal.as_ref();
            let is_up = kept.map_or(Ok(()), |kept| runner.take_up(&kept.folder, kept.resumes, start, letters));
            let goes_on = is_up.is_ok();
            drop(taking_up.send(is_up));
            if goes_on {
                runner.run();
            }
        });
        // Nobody may be waiting any more.
        let _ = ending.send(());
    };
    thread::Builder::new().name("physics".into()).spawn(body)?;
    Ok((taken_up, ended))
}

/// Resolves at Ctrl-C, SIGTERM, and the end of standard input when that counts.
pub(crate) fn asked_to_end(stop_on_stdin_eof: bool) -> anyhow::Result<impl Future<Output = ()>> {
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut terminate = signal(SignalKind::terminate())?;
    let (closed, stdin_closed) = oneshot::channel::<()>();
    if stop_on_stdin_eof {
        thread::Builder::new().name("stdin".into()).spawn(move || {
            let mut ignored = [0; 256];
            while matches!(std::io::stdin().read(&mut ignored), Ok(1..)) {}
            drop(closed);
        })?;
    } else {
        // Never resolves: the sender lives as long as the process.
        std::mem::forget(closed);
    }
    Ok(async move {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
            _ = stdin_closed => {}
        }
    })
}
