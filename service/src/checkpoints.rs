//! Saved states by their tokens, in memory and as files; bounded.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use prost::bytes::Bytes;
use sturz_engine::{CheckpointError, CheckpointSummary};
use sturz_protocol::v1;

use crate::archive::{Archive, Done, Job, describe, read_file};
use crate::config::Limits;
use crate::order::error;
use crate::ticket::{Moment, Ticket};

/// Who waits for a file, and the state that it holds; `None`: nobody asked for it.
pub type Waiting = Option<(Ticket, Moment)>;

/// All saved states.
pub struct Checkpoints {
    entries: BTreeMap<String, Entry>,
    /// Sum over the entries in memory.
    bytes_in_memory: u64,
    archive: Option<Archive<Waiting>>,
    /// On their way to the disk.
    in_flight: usize,
    /// Where files are, without an archive that writes there.
    folder: Option<PathBuf>,
    made: u64,
    /// Files that were there at the start, until the journal has told which of them there should be.
    found: Vec<v1::Checkpoint>,
    /// A journal is read: files are left alone.
    replaying: bool,
}

struct Entry {
    checkpoint: v1::Checkpoint,
    /// `None`: it is a file.
    bytes: Option<Bytes>,
}

/// All saved states, for a snapshot.
pub struct Saved {
    /// By token.
    pub checkpoints: Vec<v1::Checkpoint>,
    /// Of those in memory, in that order.
    pub bytes: Vec<Bytes>,
    /// Tokens that the daemon has made.
    pub made: u64,
}

impl Checkpoints {
    /// With a folder, and what was found there.
    pub fn new(archive: Option<(Archive<Waiting>, Vec<v1::Checkpoint>)>) -> Self {
        let (archive, found) = archive.map_or((None, Vec::new()), |(archive, found)| (Some(archive), found));
        let mut all = Self {
            entries: BTreeMap::new(),
            bytes_in_memory: 0,
            archive,
            in_flight: 0,
            folder: None,
            made: 0,
            found,
            replaying: false,
        };
        all.note_found();
        all
    }

    /// Those that a journal tells of; files are read, nothing is written.
    pub fn reading(folder: &Path) -> Self {
        Self { folder: Some(folder.into()), ..Self::new(None) }
    }

    /// As before the first record of a journal: with no checkpoints at all.
    pub fn begin_replay(&mut self) {
        self.replaying = true;
        self.found = std::mem::take(&mut self.entries).into_values().map(|entry| entry.checkpoint).collect();
    }

    /// All that there is, for a snapshot.
    pub fn saved(&self) -> Saved {
        let checkpoints = self.list();
        let bytes = self.entries.values().filter(|entry| !entry.checkpoint.on_disk);
        Saved { checkpoints, bytes: bytes.filter_map(|entry| entry.bytes.clone()).collect(), made: self.made }
    }

    /// What a snapshot had.
    pub fn load(&mut self, saved: Saved) {
        let mut blobs = saved.bytes.into_iter();
        for checkpoint in saved.checkpoints {
            let bytes = if checkpoint.on_disk { None } else { blobs.next() };
            self.put(Entry { checkpoint, bytes });
        }
        self.made = saved.made;
    }

    /// Keeps one that a journal tells of as a file, without writing it.
    pub fn keep_replayed(&mut self, token: &str, bytes: Bytes) -> Result<v1::Checkpoint, v1::Error> {
        let checkpoint = described(token, &bytes, true)?;
        self.put(Entry { checkpoint: checkpoint.clone(), bytes: Some(bytes) });
        Ok(checkpoint)
    }

    /// Forgets one that could not be written, as it turned out.
    pub fn forget_replayed(&mut self, token: &str) {
        self.forget(token);
    }

    /// The journal is read. Files that it tells of and that are not there, or are others, are written again.
    pub fn end_replay(&mut self) {
        self.replaying = false;
        let kept = self.entries.iter_mut().filter(|(_, entry)| entry.checkpoint.on_disk);
        let mut missing = Vec::new();
        for (token, entry) in kept {
            let is_there = self.found.contains(&entry.checkpoint);
            match entry.bytes.take() {
                Some(bytes) if !is_there => missing.push((token.clone(), bytes)),
                _ => {}
            }
        }
        for (token, bytes) in missing {
            if let Some((_, error)) = self.send(&token, bytes, None) {
                tracing::warn!("the checkpoint {token:?} is not written again: {}", error.message);
                self.forget(&token);
            }
        }
        self.note_found();
    }

    fn note_found(&mut self) {
        for checkpoint in std::mem::take(&mut self.found) {
            self.entries.entry(checkpoint.token.clone()).or_insert(Entry { checkpoint, bytes: None });
        }
    }

    /// A token that is free.
    pub fn new_token(&mut self, step: u64) -> String {
        loop {
            self.made += 1;
            let token = format!("step-{step}-{}", self.made);
            if !self.entries.contains_key(&token) {
                return token;
            }
        }
    }

    /// Refuses where there is no room for one more, before it is made.
    pub fn check_room(&self, token: &str, on_disk: bool, limits: &Limits) -> Result<(), v1::Error> {
        if on_disk && self.archive.is_none() && !self.replaying {
            return Err(no_folder());
        }
        let (limit, setting) = match on_disk {
            true => (limits.checkpoint_files, "checkpoint_files"),
            false => (limits.checkpoints, "checkpoints"),
        };
        let others = self.entries.iter().filter(|(name, entry)| *name != token && entry.checkpoint.on_disk == on_disk);
        let others = others.count();
        if others >= limit {
            let place = if on_disk { "on disk" } else { "in memory" };
            let text = format!(
                "{others} checkpoints are {place}, at most {limit} are allowed (limit `{setting}`): drop one, or replace one by its token"
            );
            return Err(error(v1::ErrorCode::TooLarge, "token", text));
        }
        Ok(())
    }

    /// Keeps one in memory.
    pub fn keep(&mut self, token: &str, bytes: Bytes, limits: &Limits) -> Result<v1::Checkpoint, v1::Error> {
        let new = bytes.len() as u64;
        let replaced = self.entries.get(token).map_or(0, Entry::bytes_in_memory);
        let total = self.bytes_in_memory - replaced + new;
        if total > limits.checkpoint_bytes {
            let text = format!(
                "takes {new} bytes, which makes {total} in memory; at most {} are allowed (limit `checkpoint_bytes`): drop others, or save it on disk",
                limits.checkpoint_bytes
            );
            return Err(error(v1::ErrorCode::TooLarge, "token", text));
        }
        let checkpoint = described(token, &bytes, false)?;
        self.put(Entry { checkpoint: checkpoint.clone(), bytes: Some(bytes) });
        Ok(checkpoint)
    }

    /// Sends one to the disk. When it is not taken on, who waits for it comes back, with the reason.
    pub fn send(&mut self, token: &str, bytes: Bytes, waiting: Waiting) -> Option<(Waiting, v1::Error)> {
        let Some(archive) = &self.archive else {
            return Some((waiting, no_folder()));
        };
        let checkpoint = match described(token, &bytes, true) {
            Ok(checkpoint) => checkpoint,
            Err(error) => return Some((waiting, error)),
        };
        match archive.write(Job { checkpoint, bytes, with: waiting }) {
            Ok(()) => {
                self.in_flight += 1;
                None
            }
            Err(waiting) => {
                let text = "the disk has not taken the checkpoints before this one yet: try again";
                Some((waiting, error(v1::ErrorCode::Busy, "on_disk", text)))
            }
        }
    }

    /// Whether any is on its way to the disk.
    pub fn is_writing(&self) -> bool {
        self.in_flight > 0
    }

    /// The next file that is done, noted if it is there.
    pub fn next_done(&mut self) -> Option<(Waiting, Result<v1::Checkpoint, v1::Error>)> {
        let Done { checkpoint, outcome, with } = self.archive.as_ref()?.next_done()?;
        self.in_flight -= 1;
        match outcome {
            Ok(()) => {
                self.put(Entry { checkpoint: checkpoint.clone(), bytes: None });
                Some((with, Ok(checkpoint)))
            }
            Err(failure) => {
                let text = format!("the checkpoint {:?} could not be written: {failure}", checkpoint.token);
                Some((with, Err(error(v1::ErrorCode::Disk, "on_disk", text))))
            }
        }
    }

    /// Waits for the files that are on their way.
    pub fn finish(&mut self) {
        if let Some(archive) = &mut self.archive {
            archive.finish();
        }
    }

    /// The bytes of a token: in memory, else on disk, be it known or put there by somebody meanwhile.
    pub fn bytes(&self, token: &str) -> Result<Bytes, v1::Error> {
        if let Some(Entry { bytes: Some(bytes), .. }) = self.entries.get(token) {
            return Ok(bytes.clone());
        }
        let read = match &self.archive {
            Some(archive) => Some(archive.read(token)),
            None => self.folder.as_ref().map(|folder| read_file(folder, token)),
        };
        match read {
            Some(Ok(bytes)) => Ok(bytes.into()),
            Some(Err(failure)) if failure.kind() != io::ErrorKind::NotFound => {
                let text = format!("the file of {token:?} cannot be read: {failure}");
                Err(error(v1::ErrorCode::Disk, "token", text))
            }
            _ => Err(self.unknown(token)),
        }
    }

    /// What `bytes` are, as the checkpoint of a token.
    pub fn described(&self, token: &str, bytes: &[u8]) -> Result<v1::Checkpoint, CheckpointError> {
        let on_disk = self.entries.get(token).is_none_or(|entry| entry.checkpoint.on_disk);
        Ok(describe(token, &CheckpointSummary::read(bytes)?, bytes.len(), on_disk))
    }

    /// Forgets one, its file included.
    pub fn drop_one(&mut self, token: &str) -> Result<(), v1::Error> {
        let Some(entry) = self.entries.get(token) else { return Err(self.unknown(token)) };
        if entry.checkpoint.on_disk
            && !self.replaying
            && let Some(archive) = &self.archive
        {
            match archive.remove(token) {
                Err(failure) if failure.kind() != io::ErrorKind::NotFound => {
                    let text = format!("the file of {token:?} cannot be removed: {failure}");
                    return Err(error(v1::ErrorCode::Disk, "token", text));
                }
                Ok(()) | Err(_) => {}
            }
        }
        self.forget(token);
        Ok(())
    }

    /// All of them, by token.
    pub fn list(&self) -> Vec<v1::Checkpoint> {
        self.entries.values().map(|entry| entry.checkpoint.clone()).collect()
    }

    fn put(&mut self, entry: Entry) {
        let token = entry.checkpoint.token.clone();
        self.forget(&token);
        self.bytes_in_memory += entry.bytes_in_memory();
        self.entries.insert(token, entry);
    }

    fn forget(&mut self, token: &str) {
        if let Some(entry) = self.entries.remove(token) {
            self.bytes_in_memory -= entry.bytes_in_memory();
        }
    }

    fn unknown(&self, token: &str) -> v1::Error {
        let known: Vec<&String> = self.entries.keys().collect();
        error(v1::ErrorCode::NotFound, "token", format!("there is no checkpoint {token:?}; there are {known:?}"))
    }
}

impl Entry {
    fn bytes_in_memory(&self) -> u64 {
        let in_memory = self.bytes.as_ref().filter(|_| !self.checkpoint.on_disk);
        in_memory.map_or(0, |bytes| bytes.len() as u64)
    }
}

fn no_folder() -> v1::Error {
    let text = "the daemon has no folder for checkpoints: start it with --checkpoints DIR";
    error(v1::ErrorCode::NotFound, "on_disk", text)
}

fn described(token: &str, bytes: &[u8], on_disk: bool) -> Result<v1::Checkpoint, v1::Error> {
    let summary = CheckpointSummary::read(bytes);
    let summary =
        summary.map_err(|failure| error(v1::ErrorCode::Internal, "", format!("a new checkpoint {failure}")))?;
    Ok(describe(token, &summary, bytes.len(), on_disk))
}

#[cfg(test)]
mod tests {
    use sturz_engine::Engine;
    use sturz_engine::scene::{Scene, SceneDescription};

    use super::*;

    fn saved() -> Bytes {
        let text = "[scene]\nname = \"empty\"\ntime_step_s = 1e-5";
        let scene = Scene::validate(SceneDescription::from_toml(text).unwrap()).unwrap();
        Engine::new(scene).checkpoint().unwrap().into()
    }

    #[test]
    fn limits_name_their_settings_and_replacing_needs_no_room() {
        let bytes = saved();
        let two = 2 * bytes.len() as u64;
        let limits = Limits { checkpoints: 3, checkpoint_bytes: two, ..Limits::default() };
        let mut all = Checkpoints::new(None);
        for token in ["a", "b"] {
            all.check_room(token, false, &limits).unwrap();
            assert_eq!(all.keep(token, bytes.clone(), &limits).unwrap().token, token);
        }
        let refused = all.keep("c", bytes.clone(), &limits).unwrap_err();
        assert!(refused.message.contains("limit `checkpoint_bytes`"), "{}", refused.message);
        all.keep("a", bytes.clone(), &limits).unwrap();
        let limits = Limits { checkpoints: 2, ..limits };
        all.check_room("b", false, &limits).unwrap();
        let refused = all.check_room("c", false, &limits).unwrap_err();
        assert_eq!(refused.code(), v1::ErrorCode::TooLarge);
        assert!(refused.message.contains("at most 2 are allowed (limit `checkpoints`)"), "{}", refused.message);
        assert_eq!(all.check_room("c", true, &limits).unwrap_err().path, "on_disk");
        all.drop_one("a").unwrap();
        assert_eq!(all.drop_one("a").unwrap_err().code(), v1::ErrorCode::NotFound);
        all.keep("c", bytes, &limits).unwrap();
        let tokens: Vec<String> = all.list().into_iter().map(|checkpoint| checkpoint.token).collect();
        assert_eq!(tokens, ["b", "c"]);
        assert_eq!(all.bytes_in_memory, two);
    }

    #[test]
    fn made_tokens_are_free() {
        let mut all = Checkpoints::new(None);
        all.keep("step-4-1", saved(), &Limits::default()).unwrap();
        assert_eq!(all.new_token(4), "step-4-2");
        assert!(all.bytes("elsewhere").unwrap_err().message.contains("step-4-1"));
    }
}
