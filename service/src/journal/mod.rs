//! What keeps a run beyond its process: a log of all that came from outside, and snapshots to go on from.
//!
//! The engine is deterministic on any number of threads, so that scene + log are the run. A record is written before the
//! command that it is of is answered. A snapshot is the whole state between two records; after a crash the newest sound one is
//! loaded, the records behind it are replayed, and the run has the bits of the one that was never killed.
//!
//! ```text
//! DIR/run.json          what run this is
//! DIR/scene.toml        the scene, files of meshes and shapes included
//! DIR/bed.sturz         the bed that it starts with, where it starts with one
//! DIR/log/*.log         records
//! DIR/snapshots/*       the last two
//! DIR/checkpoints/*     what clients have saved on disk
//! ```

pub mod log;
pub mod record;
mod replay;
pub mod snapshot;
mod state;
mod syncer;
pub mod writer;

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, anyhow, bail};
use serde::{Deserialize, Serialize};
use sturz_engine::scene::{Scene, SceneDescription};
use xxhash_rust::xxh3::xxh3_64;

use crate::archive::{remove_partial, write_whole};
use crate::journal::record::{Entry, Record};
use crate::journal::writer::{Disk, JournalWriter, Message, Replies};
use crate::mailbox::Mailbox;

pub use replay::{Replayed, replay};
pub use state::order_of;

/// When the log is forced to the disk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Fsync {
    /// Once a second, and before each snapshot: survives the death of the process.
    #[default]
    Second,
    /// Before each reply: survives the loss of power too.
    Command,
}

/// How much of the log is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// All of it: the whole run can be replayed.
    All,
    /// What the snapshots need, and as long as it is no larger than this, all of it.
    Bytes(u64),
}

/// What run a folder holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct About {
    /// Of this file and the names beside it.
    format: u32,
    /// Of the program that began it.
    version: String,
    /// Name on the bus.
    pub instance: String,
    /// XXH3 of the scene's file, hexadecimal.
    scene: String,
    /// XXH3 of all before, one behind the other, hexadecimal.
    checksum: String,
}

impl About {
    fn new(instance: &str, scene: &str) -> Self {
        let version = env!("CARGO_PKG_VERSION").into();
        let scene = hexadecimal(scene.as_bytes());
        let about = Self { format: FORMAT, version, instance: instance.into(), scene, checksum: String::new() };
        Self { checksum: about.sum(), ..about }
    }

    fn sum(&self) -> String {
        hexadecimal(format!("{} {} {} {}", self.format, self.version, self.instance, self.scene).as_bytes())
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    format!("{:016x}", xxh3_64(bytes))
}

const FORMAT: u32 = 1;
const ABOUT: &str = "run.json";
const SCENE: &str = "scene.toml";
const BED: &str = "bed.sturz";
const LOCK: &str = "lock";

/// A journal's folder.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// When the log is forced to the disk.
    pub fsync: Fsync,
    /// How much of the log is kept.
    pub keep: Keep,
    /// Held as long as a daemon writes here.
    _lock: Option<File>,
}

impl Folder {
    /// Makes a folder for a new run.
    pub fn create(path: &Path, instance: &str, scene: &Scene) -> anyhow::Result<Self> {
        let context = || format!("the journal {}", path.display());
        fs::create_dir_all(path).with_context(context)?;
        let folder = Self::locked(path)?;
        if path.join(ABOUT).exists() {
            bail!(
                "{} holds a run already: go on with it by --resume {0}, or choose another folder for --journal",
                path.display()
            );
        }
        for inner in [folder.log(), folder.snapshots(), folder.checkpoints()] {
            fs::create_dir_all(&inner).with_context(context)?;
            if fs::read_dir(&inner).with_context(context)?.next().is_some() {
                bail!("{} is not empty: choose another folder for --journal", inner.display());
            }
        }
        let mut written = scene.description().clone();
        if let Some(start) = &mut written.start {
            write_whole(path, BED, &[start.bytes.0.to_vec().into()]).with_context(context)?;
            start.checkpoint = BED.into();
        }
        let text = written.to_toml().map_err(|error| anyhow!("the scene cannot be written: {error}"))?;
        let about = About::new(instance, &text);
        write_whole(path, SCENE, &[text.into()]).with_context(context)?;
        // Last: with it, the folder is a run.
        write_whole(path, ABOUT, &[serde_json::to_vec_pretty(&about)?.into()]).with_context(context)?;
        Ok(folder)
    }

    /// Opens the folder of a run to go on with it.
    pub fn open(path: &Path) -> anyhow::Result<(Self, About)> {
        let about = Self::look(path)?.1;
        let folder = Self::locked(path)?;
        remove_partial(&folder.snapshots()).with_context(|| format!("the journal {}", path.display()))?;
        Ok((folder, about))
    }

    /// Opens the folder of a run to read it.
    pub fn look(path: &Path) -> anyhow::Result<(Self, About)> {
        let bytes = fs::read(path.join(ABOUT))
            .with_context(|| format!("{} holds no run: it has no readable {ABOUT}", path.display()))?;
        let about: About = serde_json::from_slice(&bytes).with_context(|| format!("{}", path.join(ABOUT).display()))?;
        if about.format != FORMAT {
            bail!("{} has format {}, this program reads {FORMAT}", path.display(), about.format);
        }
        if about.checksum != about.sum() {
            bail!("{} is damaged: its checksum differs", path.join(ABOUT).display());
        }
        Ok((Self { path: path.into(), fsync: Fsync::default(), keep: Keep::All, _lock: None }, about))
    }

    fn locked(path: &Path) -> anyhow::Result<Self> {
        let lock = File::create(path.join(LOCK)).with_context(|| format!("the journal {}", path.display()))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(fs::TryLockError::WouldBlock) => bail!("another daemon writes to {}", path.display()),
            Err(fs::TryLockError::Error(error)) => return Err(error).context("the journal's lock"),
        }
        Ok(Self { path: path.into(), fsync: Fsync::default(), keep: Keep::All, _lock: Some(lock) })
    }

    /// The same, written to and kept in another way.
    pub fn kept_as(self, fsync: Fsync, keep: Keep) -> Self {
        Self { fsync, keep, ..self }
    }

    /// The scene of the run.
    pub fn scene(&self) -> anyhow::Result<Scene> {
        let path = self.path.join(SCENE);
        let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        if hexadecimal(text.as_bytes()) != Self::look(&self.path)?.1.scene {
            bail!("{} is not the scene that the run began with: its checksum differs", path.display());
        }
        let mut described =
            SceneDescription::from_toml(&text).map_err(|error| anyhow!("{}: {error}", path.display()))?;
        let files = described.read_files(|name| fs::read(self.path.join(name)));
        files.map_err(|problems| anyhow!("{} cannot be used:\n{problems}", path.display()))?;
        Scene::validate(described).map_err(|problems| anyhow!("{} cannot be used:\n{problems}", path.display()))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Of the log.
    pub fn log(&self) -> PathBuf {
        self.path.join("log")
    }

    /// Of the snapshots.
    pub fn snapshots(&self) -> PathBuf {
        self.path.join("snapshots")
    }

    /// Of what clients have saved.
    pub fn checkpoints(&self) -> PathBuf {
        self.path.join("checkpoints")
    }
}

/// The physics' side of the journal: numbers records, and sends replies behind them.
#[derive(Default)]
pub struct Journal {
    mode: Mode,
    next: u64,
    seen_changes: u64,
}

#[derive(Default)]
enum Mode {
    /// There is none.
    #[default]
    Off,
    /// It is read, not written.
    Replaying,
    /// It is written.
    Writing(JournalWriter, Arc<Disk>),
}

impl Journal {
    /// One that is read.
    pub fn replaying() -> Self {
        Self { mode: Mode::Replaying, ..Self::default() }
    }

    /// Begins to write, from record `next` on.
    pub fn begin(&mut self, folder: &Folder, next: u64, mailbox: Mailbox) -> io::Result<()> {
        let (writer, disk) = JournalWriter::start(folder, next, mailbox)?;
        *self = Self { mode: Mode::Writing(writer, disk), next, seen_changes: 0 };
        Ok(())
    }

    /// Whether it is read.
    pub fn is_replaying(&self) -> bool {
        matches!(self.mode, Mode::Replaying)
    }

    /// Whether it is written.
    pub fn is_writing(&self) -> bool {
        matches!(self.mode, Mode::Writing(..))
    }

    /// Number of the next record.
    pub fn next_sequence(&self) -> u64 {
        self.next
    }

    /// Puts a record into the log, and lets the replies go once it is there.
    pub fn post(&mut self, step: u64, entry: Option<Entry>, replies: Replies) {
        match &self.mode {
            Mode::Off | Mode::Replaying => {
                for (reply, answer) in replies {
                    // A client that has gone no longer wants to know.
                    drop(reply.send(answer));
                }
            }
            Mode::Writing(writer, _) => {
                let record = entry.map(|entry| {
                    let sequence = self.next;
                    self.next += 1;
                    Box::new(Record { sequence, step, entry: Some(entry) })
                });
                writer.tell(Message::Entry(record, replies));
            }
        }
    }

    /// Sends a snapshot on its way.
    pub fn save(&self, snapshot: snapshot::Snapshot) {
        if let Mode::Writing(writer, _) = &self.mode {
            writer.tell(Message::Snapshot(Box::new(snapshot)));
        }
    }

    /// Whether the disk's state has changed since the last call.
    pub fn disk_has_changed(&mut self) -> bool {
        let Mode::Writing(_, disk) = &self.mode else { return false };
        let changes = disk.changes();
        std::mem::replace(&mut self.seen_changes, changes) != changes
    }

    /// How the disk does; `None` where nothing is written.
    pub fn disk(&self) -> Option<&Disk> {
        match &self.mode {
            Mode::Writing(_, disk) => Some(disk),
            Mode::Off | Mode::Replaying => None,
        }
    }

    /// Waits until all is written.
    pub fn finish(&mut self) {
        self.mode = Mode::Off;
    }
}
