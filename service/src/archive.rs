//! Checkpoints as files, written by a thread of their own: the physics waits for no disk.
//!
//! A file is whole or not there: it is written under another name, synced, and renamed, and then the folder is synced.

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, channel, sync_channel};
use std::thread::{self, JoinHandle};

use anyhow::Context as _;
use prost::bytes::Bytes;
use sturz_engine::CheckpointSummary;
use sturz_protocol::keys::check_name;
use sturz_protocol::v1;

use crate::mailbox::Mailbox;

/// Ending of a checkpoint's name, behind its token.
const ENDING: &str = ".checkpoint";
/// Of a file that is not whole yet, behind its name.
const PARTIAL: &str = ".partial";
/// Files that wait to be written; each is in memory as long.
const WAITING: usize = 2;

/// A checkpoint on its way to the disk.
pub struct Job<T> {
    /// What it is.
    pub checkpoint: v1::Checkpoint,
    /// The file.
    pub bytes: Bytes,
    /// Comes back when it is done.
    pub with: T,
}

/// What became of a job.
pub struct Done<T> {
    /// What it is.
    pub checkpoint: v1::Checkpoint,
    /// Why there is no file.
    pub outcome: io::Result<()>,
    /// As in the job.
    pub with: T,
}

/// A folder of checkpoints, and the thread that writes there.
pub struct Archive<T> {
    folder: PathBuf,
    jobs: Option<SyncSender<Job<T>>>,
    done: Receiver<Done<T>>,
    writer: Option<JoinHandle<()>>,
}

impl<T: Send + 'static> Archive<T> {
    /// Makes the folder if need be, and looks what is there. `mailbox` is woken when a file is done.
    pub fn open(folder: &Path, mailbox: Mailbox) -> anyhow::Result<(Self, Vec<v1::Checkpoint>)> {
        let context = || format!("the folder for checkpoints {}", folder.display());
        fs::create_dir_all(folder).with_context(context)?;
        let found = look_around(folder).with_context(context)?;
        let (jobs, waiting) = sync_channel::<Job<T>>(WAITING);
        let (finished, done) = channel();
        let into = folder.to_path_buf();
        let work = move || {
            for Job { checkpoint, bytes, with } in waiting {
                let outcome = write_whole(&into, &format!("{}{ENDING}", checkpoint.token), &[bytes]);
                if finished.send(Done { checkpoint, outcome, with }).is_err() {
                    break;
                }
                mailbox.wake();
            }
        };
        let writer = thread::Builder::new().name("checkpoints".into()).spawn(work)?;
        Ok((Self { folder: folder.into(), jobs: Some(jobs), done, writer: Some(writer) }, found))
    }

    /// Takes a job on, or gives back what came with it when too many wait.
    pub fn write(&self, job: Job<T>) -> Result<(), T> {
        let Some(jobs) = &self.jobs else { return Err(job.with) };
        jobs.try_send(job).map_err(|refused| match refused {
            TrySendError::Full(job) | TrySendError::Disconnected(job) => job.with,
        })
    }

    /// A job that is done, if there is one.
    pub fn next_done(&self) -> Option<Done<T>> {
        self.done.try_recv().ok()
    }

    /// Waits until all jobs are done; no more are taken on.
    pub fn finish(&mut self) {
        drop(self.jobs.take());
        if let Some(writer) = self.writer.take()
            && writer.join().is_err()
        {
            tracing::error!("the thread that writes checkpoints has failed");
        }
    }

    /// The file of a token.
    pub fn read(&self, token: &str) -> io::Result<Vec<u8>> {
        read_file(&self.folder, token)
    }

    /// Removes the file of a token.
    pub fn remove(&self, token: &str) -> io::Result<()> {
        fs::remove_file(self.folder.join(format!("{token}{ENDING}")))
    }
}

/// The file of a token.
pub fn read_file(folder: &Path, token: &str) -> io::Result<Vec<u8>> {
    fs::read(folder.join(format!("{token}{ENDING}")))
}

/// Writes a file of these pieces: it is whole or not there, and after the return it is on the disk.
pub fn write_whole(folder: &Path, name: &str, parts: &[Bytes]) -> io::Result<()> {
    let partial = folder.join(format!("{name}{PARTIAL}"));
    let written = (|| {
        let mut file = File::create(&partial)?;
        parts.iter().try_for_each(|part| file.write_all(part))?;
        file.sync_all()?;
        fs::rename(&partial, folder.join(name))?;
        sync_folder(folder)
    })();
    if written.is_err() {
        // What is left of it would only take room.
        drop(fs::remove_file(&partial));
    }
    written
}

/// Removes what a crash has left half written.
pub fn remove_partial(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.to_string_lossy().ends_with(PARTIAL) {
            fs::remove_file(path)?;
        }
    }
    Ok(())
}

/// Makes names in a folder safe.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

/// Checkpoints that are whole and sound; what was cut off by a crash is removed.
fn look_around(folder: &Path) -> io::Result<Vec<v1::Checkpoint>> {
    let mut found = Vec::new();
    remove_partial(folder)?;
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let Some(token) = name.strip_suffix(ENDING).filter(|token| check_name(token).is_ok()) else { continue };
        let bytes = fs::read(&path)?;
        match CheckpointSummary::read(&bytes) {
            Ok(summary) => found.push(describe(token, &summary, bytes.len(), true)),
            Err(error) => tracing::warn!("{} {error}", path.display()),
        }
    }
    Ok(found)
}

/// For the wire.
pub fn describe(token: &str, summary: &CheckpointSummary, bytes: usize, on_disk: bool) -> v1::Checkpoint {
    v1::Checkpoint {
        token: token.into(),
        step: summary.step,
        sim_time_s: summary.time_s,
        particles: summary.particles,
        topology_epoch: summary.topology_epoch,
        state_hash: summary.state_hash,
        bytes: bytes as u64,
        on_disk,
    }
}

#[cfg(test)]
mod tests {
    use sturz_engine::Engine;
    use sturz_engine::scene::{Scene, SceneDescription};

    use super::*;
    use crate::mailbox::mailbox;

    fn saved() -> (v1::Checkpoint, Bytes) {
        let text = "[scene]\nname = \"empty\"\ntime_step_s = 1e-5";
        let scene = Scene::validate(SceneDescription::from_toml(text).unwrap()).unwrap();
        let bytes = Engine::new(scene).checkpoint().unwrap();
        (describe("a", &CheckpointSummary::read(&bytes).unwrap(), bytes.len(), true), bytes.into())
    }

    #[test]
    fn files_are_whole_or_not_there_and_found_again() {
        let folder = tempfile::tempdir().unwrap();
        let (checkpoint, bytes) = saved();
        let (mut archive, found) = Archive::open(folder.path(), mailbox(4).0).unwrap();
        assert!(found.is_empty());
        assert!(archive.write(Job { checkpoint: checkpoint.clone(), bytes: bytes.clone(), with: 7 }).is_ok());
        archive.finish();
        let done = archive.next_done().unwrap();
        assert!(done.outcome.is_ok() && done.with == 7);
        assert_eq!(archive.write(Job { checkpoint: checkpoint.clone(), bytes: bytes.clone(), with: 8 }), Err(8));
        assert_eq!(archive.read("a").unwrap(), bytes);

        // a crash in the midst of writing, damage, and a stranger
        fs::write(folder.path().join("b.checkpoint.partial"), &bytes[..9]).unwrap();
        fs::write(folder.path().join("c.checkpoint"), &bytes[..bytes.len() - 1]).unwrap();
        fs::write(folder.path().join("notes.txt"), "mine").unwrap();
        let (archive, found) = Archive::<u8>::open(folder.path(), mailbox(4).0).unwrap();
        assert_eq!(found, [checkpoint]);
        assert!(!folder.path().join("b.checkpoint.partial").exists());
        assert!(folder.path().join("notes.txt").exists());
        archive.remove("a").unwrap();
        assert_eq!(archive.read("a").unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[test]
    fn a_folder_that_has_gone_is_told_and_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let (checkpoint, bytes) = saved();
        let (mut archive, _) = Archive::open(folder.path(), mailbox(4).0).unwrap();
        drop(folder);
        assert!(archive.write(Job { checkpoint, bytes, with: () }).is_ok());
        archive.finish();
        assert!(archive.next_done().unwrap().outcome.is_err());
    }
}
