//! Snapshots: the whole state between two records, to go on from after a crash.
//!
//! `snapshots/<record>.snapshot`: where the state stands before that record.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `STURZSNP` |
//! | 4 | format, u32 |
//! | 8, 8 | length of the daemon's state, length of the engine's checkpoint, u64 |
//! | | the daemon's state ([`DaemonState`]), the engine's checkpoint, the checkpoints in memory |
//! | 8 | XXH3 (64 bits) of all bytes before |

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{self, JoinHandle};

use anyhow::{Context as _, bail, ensure};
use prost::Message as _;
use prost::bytes::Bytes;
use sturz_engine::CheckpointSummary;
use xxhash_rust::xxh3::Xxh3Default;

use crate::archive::write_whole;
use crate::journal::record::DaemonState;

const MAGIC: &[u8; 8] = b"STURZSNP";
/// Changes with any change of what is around the parts.
const FORMAT: u32 = 1;
const HEAD_BYTES: usize = 28;
const CHECKSUM_BYTES: usize = 8;
const ENDING: &str = ".snapshot";
/// Kept on disk: the one before the last is there while the last is written, and should that be found damaged.
const KEPT: usize = 2;

/// The whole state between two records.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Of the daemon.
    pub daemon: DaemonState,
    /// Of the engine.
    pub engine: Bytes,
    /// Of the checkpoints in memory.
    pub tokens: Vec<Bytes>,
}

impl Snapshot {
    /// The file in pieces.
    fn parts(&self) -> Vec<Bytes> {
        let daemon = self.daemon.encode_to_vec();
        let mut head = MAGIC.to_vec();
        head.extend_from_slice(&FORMAT.to_le_bytes());
        head.extend_from_slice(&(daemon.len() as u64).to_le_bytes());
        head.extend_from_slice(&(self.engine.len() as u64).to_le_bytes());
        let mut parts = vec![head.into(), daemon.into(), self.engine.clone()];
        parts.extend(self.tokens.iter().cloned());
        let mut hasher = Xxh3Default::new();
        parts.iter().for_each(|part| hasher.update(part));
        parts.push(hasher.digest().to_le_bytes().to_vec().into());
        parts
    }

    /// Reads a file that is whole and sound.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let bytes = Bytes::from(fs::read(path).with_context(|| path.display().to_string())?);
        Self::from_bytes(&bytes).with_context(|| format!("the snapshot {} cannot be used", path.display()))
    }

    /// The same of what such a file holds.
    pub fn from_bytes(bytes: &Bytes) -> anyhow::Result<Self> {
        ensure!(bytes.len() >= HEAD_BYTES + CHECKSUM_BYTES && bytes.starts_with(MAGIC), "it is no snapshot, or cut");
        let number = |at: usize| u64::from_le_bytes(std::array::from_fn(|k| bytes[at + k]));
        let format = u32::from_le_bytes(std::array::from_fn(|k| bytes[8 + k]));
        ensure!(format == FORMAT, "it has format {format}, this program reads {FORMAT}");
        let (content, checksum) = bytes.split_at(bytes.len() - CHECKSUM_BYTES);
        let mut hasher = Xxh3Default::new();
        hasher.update(content);
        ensure!(hasher.digest().to_le_bytes() == checksum, "it is cut or damaged: the checksum differs");
        let mut at = HEAD_BYTES;
        let mut take = |length: u64| {
            let end = usize::try_from(length).ok().and_then(|length| at.checked_add(length));
            let end = end.filter(|&end| end <= content.len());
            let part = end.map(|end| bytes.slice(at..end));
            at = end.unwrap_or(at);
            part.context("a part is longer than the file")
        };
        let daemon = DaemonState::decode(take(number(12))?)?;
        let engine = take(number(20))?;
        let in_memory = daemon.tokens.iter().filter(|token| !token.on_disk);
        let tokens = in_memory.map(|token| take(token.bytes)).collect::<anyhow::Result<_>>()?;
        if at != content.len() {
            bail!("{} bytes are of no part", content.len() - at);
        }
        Ok(Self { daemon, engine, tokens })
    }

    /// What the engine's part is.
    pub fn summary(&self) -> anyhow::Result<CheckpointSummary> {
        CheckpointSummary::read(&self.engine).map_err(|error| anyhow::anyhow!("its engine's part {error}"))
    }
}

/// All snapshots of a folder, newest first: records before which they stand, and files.
pub fn list(folder: &Path) -> io::Result<Vec<(u64, PathBuf)>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if let Some(sequence) = name.strip_suffix(ENDING).and_then(|number| number.parse().ok()) {
            found.push((sequence, path));
        }
    }
    found.sort_by_key(|(sequence, _)| std::cmp::Reverse(*sequence));
    Ok(found)
}

/// The newest one that is sound; those that are not are told in the log.
pub fn newest(folder: &Path) -> io::Result<Option<Snapshot>> {
    for (sequence, path) in list(folder)? {
        match Snapshot::read(&path) {
            Ok(snapshot) if snapshot.daemon.sequence == sequence => return Ok(Some(snapshot)),
            Ok(_) => tracing::warn!("{}: its name and its content tell different records", path.display()),
            Err(error) => tracing::warn!("{error:#}"),
        }
    }
    Ok(None)
}

/// The oldest sound one that stands before record `from` or behind it.
pub fn oldest_from(folder: &Path, from: u64) -> anyhow::Result<Snapshot> {
    for (_, path) in list(folder)?.into_iter().rev().filter(|(sequence, _)| *sequence >= from) {
        match Snapshot::read(&path) {
            Ok(snapshot) => return Ok(snapshot),
            Err(error) => tracing::warn!("{error:#}"),
        }
    }
    bail!("the log begins with record {from}, and no sound snapshot stands there or behind it")
}

/// What became of a snapshot.
pub struct Written {
    /// Before which record it stands.
    pub sequence: u64,
    /// Number of the oldest that is kept, or why there is no new one.
    pub outcome: io::Result<u64>,
}

/// A thread that writes snapshots and removes old ones: neither physics nor journal wait for it.
pub struct SnapshotWriter {
    jobs: Option<SyncSender<Snapshot>>,
    thread: Option<JoinHandle<()>>,
}

impl SnapshotWriter {
    /// `done` hears of every one.
    pub fn start(folder: PathBuf, done: impl Fn(Written) + Send + 'static) -> io::Result<Self> {
        let (jobs, waiting) = sync_channel::<Snapshot>(1);
        let work = move || {
            for snapshot in waiting {
                let sequence = snapshot.daemon.sequence;
                let name = format!("{sequence:012}{ENDING}");
                let written = write_whole(&folder, &name, &snapshot.parts());
                drop(snapshot);
                done(Written { sequence, outcome: written.and_then(|()| prune(&folder)) });
            }
        };
        let thread = thread::Builder::new().name("snapshots".into()).spawn(work)?;
        Ok(Self { jobs: Some(jobs), thread: Some(thread) })
    }

    /// Takes one on; `false`, and it is dropped, while another one waits.
    pub fn write(&self, snapshot: Snapshot) -> bool {
        self.jobs.as_ref().is_some_and(|jobs| jobs.try_send(snapshot).is_ok())
    }
}

impl Drop for SnapshotWriter {
    /// Waits until all are written.
    fn drop(&mut self) {
        drop(self.jobs.take());
        if let Some(thread) = self.thread.take() {
            drop(thread.join());
        }
    }
}

/// Removes all but the newest ones; the number of the oldest that is left.
fn prune(folder: &Path) -> io::Result<u64> {
    let mut all = list(folder)?;
    let old = all.split_off(all.len().min(KEPT));
    for (_, path) in old {
        fs::remove_file(path)?;
    }
    Ok(all.last().map_or(0, |(sequence, _)| *sequence))
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use sturz_protocol::v1;

    use super::*;

    fn snapshot(sequence: u64) -> Snapshot {
        let token = v1::Checkpoint { token: "a".into(), bytes: 5, ..Default::default() };
        let daemon = DaemonState { sequence, tokens: vec![token], running: true, ..Default::default() };
        Snapshot { daemon, engine: vec![7; 100].into(), tokens: vec![vec![9; 5].into()] }
    }

    #[test]
    fn the_newest_sound_one_is_found_and_old_ones_go() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(newest(folder.path()).unwrap(), None);
        let (sender, done) = channel();
        let writer = SnapshotWriter::start(folder.path().into(), move |written| sender.send(written).unwrap()).unwrap();
        for sequence in [0, 5, 9] {
            assert!(writer.write(snapshot(sequence)));
            let written = done.recv().unwrap();
            assert_eq!(written.sequence, sequence);
            assert_eq!(written.outcome.unwrap(), if sequence == 9 { 5 } else { 0 });
        }
        drop(writer);
        assert_eq!(newest(folder.path()).unwrap(), Some(snapshot(9)));
        let (_, path) = list(folder.path()).unwrap().remove(0);
        fs::write(&path, &fs::read(&path).unwrap()[..50]).unwrap();
        assert_eq!(newest(folder.path()).unwrap(), Some(snapshot(5)));
        fs::rename(list(folder.path()).unwrap()[1].1.clone(), path).unwrap();
        assert_eq!(newest(folder.path()).unwrap(), None, "a file of another name is not what it says");
    }

    #[test]
    fn every_cut_and_every_flipped_bit_is_refused() {
        let whole: Vec<u8> = snapshot(3).parts().concat();
        assert_eq!(Snapshot::from_bytes(&whole.clone().into()).unwrap(), snapshot(3));
        for at in 0..whole.len() {
            assert!(Snapshot::from_bytes(&Bytes::copy_from_slice(&whole[..at])).is_err(), "cut at {at}");
            for bit in 0..8 {
                let mut bytes = whole.clone();
                bytes[at] ^= 1 << bit;
                assert!(Snapshot::from_bytes(&bytes.into()).is_err(), "bit {bit} of byte {at}");
            }
        }
    }
}
