//! Reads a recording at the pace of its simulated time, and hands it to the bus.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

use anyhow::anyhow;
use sturz_protocol::keys::Keys;
use tokio::sync::oneshot;
use zenoh::bytes::ZBytes;

use super::pace::{Control, Mode, Pace, Speed};
use super::server::{Server, Voice};
use super::shown::Shown;
use crate::config::Bus;
use crate::daemon::{Ready, ServeError, asked_to_end, describe, open_session, refuse_twin};
use crate::record::{Headed, Recorded, Recording};

/// How to play.
pub struct Options {
    /// The recording.
    pub file: PathBuf,
    /// Name on the bus; that of the recorded instance when absent.
    pub instance: Option<String>,
    /// Where on the bus.
    pub bus: Bus,
    /// Simulated seconds per wall second.
    pub speed: Speed,
    /// Begin again at the end.
    pub repeat: bool,
    /// Wait for `resume`.
    pub paused: bool,
    /// End with the recording.
    pub exit_at_end: bool,
    /// End when standard input does.
    pub stop_on_stdin_eof: bool,
}

/// What the player and those who answer share.
pub(super) struct Stage {
    pub control: Control,
    shown: Mutex<Shown>,
}

impl Stage {
    pub fn shown(&self) -> MutexGuard<'_, Shown> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Plays a recording on the bus until it is told to end.
pub async fn play(options: Options, ready: impl FnOnce(&Ready)) -> Result<(), ServeError> {
    let (instance, shown) = first_look(&options)?;
    let keys = Keys::new(&instance).map_err(|error| anyhow!(error))?;
    let session = open_session(&options.bus).await?;
    refuse_twin(&session, &keys).await?;
    let stage = Arc::new(Stage { control: Control::new(options.paused), shown: Mutex::new(shown) });
    let voice = Arc::new(Voice::open(&session, &keys, options.speed).await?);
    let server = Server::open(&session, &keys, &stage, &voice).await?;
    let stop_on_stdin_eof = options.stop_on_stdin_eof;
    let recording = Recording::open(&options.file).map_err(anyhow::Error::from)?;
    let mut player = Player { recording, options, stage: Arc::clone(&stage), voice };
    let (ending, mut ended) = oneshot::channel();
    let body = move || drop(ending.send(player.play()));
    thread::Builder::new().name("player".into()).spawn(body).map_err(anyhow::Error::from)?;
    let token = session.liveliness().declare_token(keys.alive()).await.map_err(|error| anyhow!(error))?;
    let run_id: String = session.zid().to_string().chars().take(16).collect();
    let asked = asked_to_end(stop_on_stdin_eof)?;
    ready(&describe(&session, &keys, run_id).await);

    let outcome = tokio::select! {
        outcome = &mut ended => outcome,
        () = asked => {
            stage.control.set(Mode::Stopping);
            ended.await
        }
    };
    server.close().await;
    drop(token.undeclare().await);
    session.close().await.map_err(|error| anyhow!(error))?;
    outcome.map_err(|_| anyhow!("the player's thread has panicked"))??;
    Ok(())
}

/// Name on the bus, and what can be answered before the first message is played.
fn first_look(options: &Options) -> anyhow::Result<(String, Shown)> {
    let mut recording = Recording::open(&options.file)?;
    if !recording.is_finished() {
        tracing::warn!("{}", recording.warning_of_cut());
    }
    let mut instance = options.instance.clone();
    let mut shown: Option<Shown> = None;
    while let Some(message) = recording.read()? {
        let name = instance.get_or_insert_with(|| message.topic.instance.clone());
        let shown = shown.get_or_insert_with(|| Shown::new(name));
        shown.take(&message, &message.payload.clone().into())?;
        if shown.is_known() && shown.has_state() {
            break;
        }
    }
    match (instance, shown.filter(Shown::is_known)) {
        (Some(instance), Some(shown)) => Ok((instance, shown)),
        _ => Err(anyhow!("{} has no `info`: it is cut before that, or not of `sturz record`", options.file.display())),
    }
}

struct Player {
    recording: Recording,
    options: Options,
    stage: Arc<Stage>,
    voice: Arc<Voice>,
}

impl Player {
    fn play(&mut self) -> anyhow::Result<()> {
        let mut pace = Pace::new(self.options.speed);
        loop {
            while let Some(message) = self.recording.read()? {
                if !self.show(&message, &mut pace)? {
                    return Ok(());
                }
            }
            tracing::info!("the end, after {} messages", self.recording.messages());
            if self.options.exit_at_end {
                return Ok(());
            }
            // Without anything that takes its time, repeating would never rest.
            if !self.options.repeat || !self.stage.shown().is_moving() {
                self.stage.control.set(Mode::Paused);
            }
            // Also after the end `resume` plays it again.
            pace.restart();
            if !self.wait(&mut Pace::new(Speed::Max), 0.0) {
                return Ok(());
            }
            self.recording = Recording::open(self.recording.path())?;
        }
    }

    /// Publishes a message when it is due; `false` when the playback is to end.
    fn show(&self, message: &Recorded, pace: &mut Pace) -> anyhow::Result<bool> {
        let paced = matches!(message.topic.message.as_str(), "Frame" | "FieldFrame" | "Report");
        let header = if paced { Headed::read(&message.payload) } else { None };
        // Events remembered from before the recording would hold up its start.
        let goes_on = match header {
            Some(header) => self.wait(pace, header.sim_time_s),
            None => self.stage.control.mode() != Mode::Stopping,
        };
        if !goes_on {
            return Ok(false);
        }
        let payload = ZBytes::from(message.payload.clone());
        self.stage.shown().take(message, &payload)?;
        self.voice.publish(&message.topic.tail, &message.topic.message, payload);
        Ok(true)
    }

    fn wait(&self, pace: &mut Pace, time_s: f64) -> bool {
        self.stage.control.wait(pace, time_s, || {
            let streams = self.stage.shown().streams();
            for (tail, payload) in streams {
                self.voice.publish(&tail, crate::record::message_of(&tail), payload);
            }
        })
    }
}
