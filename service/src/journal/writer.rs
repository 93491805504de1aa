//! The thread that writes the log: what was accepted is written before it is answered, and the physics waits for no
//! disk.

use std::fs;
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::journal::log::{LogWriter, frame, segments};
use crate::journal::record::Record;
use crate::journal::snapshot::{Snapshot, SnapshotWriter, Written};
use crate::journal::syncer::Syncer;
use crate::journal::{Folder, Fsync, Keep};
use crate::mailbox::{Answer, Mailbox, ReplyTo};

/// How long what was written may be in the memory of the system only.
const SYNC_EVERY: Duration = Duration::from_secs(1);
/// How often a disk that refuses is tried again.
const RETRY: Duration = Duration::from_millis(250);
/// How often at the end of the daemon.
const LAST_TRIES: u32 = 4;
/// Bytes that are written at a time, unless one record is larger.
const BATCH_BYTES: usize = 1 << 20;

const FAILED: &str = "the thread that writes the journal has failed";

/// Replies that may leave once what is before them is written.
pub type Replies = Vec<(ReplyTo, Answer)>;

/// What the thread may be told.
pub enum Message {
    /// Write, then reply.
    Entry(Option<Box<Record>>, Replies),
    /// Make the log safe, then the snapshot.
    Snapshot(Box<Snapshot>),
    /// What was written of late could not be made safe.
    Unsafe(io::Error),
    /// A snapshot was written: this record is the first that the oldest one kept needs.
    Needed(u64),
    /// All was told.
    Close,
}

/// How the disk does. Written by the journal's threads, read by the physics.
#[derive(Default)]
pub struct Disk {
    blocked: Mutex<Option<String>>,
    written: Mutex<Option<Written>>,
    changes: AtomicU64,
    closing: AtomicBool,
}

impl Disk {
    /// Another number after every change.
    pub fn changes(&self) -> u64 {
        self.changes.load(Relaxed)
    }

    /// Why nothing can be written; `None` when all is well.
    pub fn blocked(&self) -> Option<String> {
        self.blocked.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// What became of the last snapshot, once.
    pub fn take_written(&self) -> Option<Written> {
        self.written.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    fn set_blocked(&self, reason: Option<String>) -> bool {
        let mut blocked = self.blocked.lock().unwrap_or_else(PoisonError::into_inner);
        let changed = blocked.is_some() != reason.is_some();
        *blocked = reason;
        drop(blocked);
        self.changes.fetch_add(u64::from(changed), Relaxed);
        changed
    }

    fn set_written(&self, written: Written) {
        *self.written.lock().unwrap_or_else(PoisonError::into_inner) = Some(written);
        self.changes.fetch_add(1, Relaxed);
    }
}

/// The physics' end of the thread.
pub struct JournalWriter {
    messages: Sender<Message>,
    disk: Arc<Disk>,
    thread: Option<JoinHandle<()>>,
}

impl JournalWriter {
    /// Begins a file of the log for record `next`. `mailbox` is woken when the disk's state changes.
    pub fn start(folder: &Folder, next: u64, mailbox: Mailbox) -> io::Result<(Self, Arc<Disk>)> {
        let disk = Arc::<Disk>::default();
        let (messages, told) = channel();
        let (noted, needed, wake) = (Arc::clone(&disk), messages.clone(), mailbox.clone());
        let done = move |written: Written| {
            if let Ok(oldest) = written.outcome {
                drop(needed.send(Message::Needed(oldest)));
            }
            noted.set_written(written);
            wake.wake();
        };
        let snapshots = SnapshotWriter::start(folder.snapshots(), done)?;
        let log = LogWriter::create(&folder.log(), next)?;
        let for_syncer = messages.clone();
        let syncer = Syncer::start(move |failure| drop(for_syncer.send(Message::Unsafe(failure))))?;
        let (keep, fsync) = (folder.keep, folder.fsync);
        let writer = Writer {
            folder: folder.log(),
            log,
            syncer,
            snapshots,
            disk: Arc::clone(&disk),
            mailbox,
            keep,
            fsync,
            unsynced: None,
        };
        let thread = thread::Builder::new().name("journal".into()).spawn(move || writer.run(&told))?;
        Ok((Self { messages, disk: Arc::clone(&disk), thread: Some(thread) }, disk))
    }

    /// Tells the thread; never waits.
    pub fn tell(&self, message: Message) {
        // Without it nothing is kept: the run is held, as on a full disk.
        if self.messages.send(message).is_err() && self.disk.set_blocked(Some(FAILED.into())) {
            tracing::error!("{FAILED}");
        }
    }
}

impl Drop for JournalWriter {
    /// Waits until all is written, or the disk has refused several times more.
    fn drop(&mut self) {
        self.disk.closing.store(true, Relaxed);
        self.tell(Message::Close);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("{FAILED}");
        }
    }
}

struct Writer {
    folder: PathBuf,
    log: LogWriter,
    syncer: Syncer,
    snapshots: SnapshotWriter,
    disk: Arc<Disk>,
    mailbox: Mailbox,
    keep: Keep,
    fsync: Fsync,
    /// Since when something is in the memory of the system only.
    unsynced: Option<Instant>,
}

impl Writer {
    fn run(mut self, told: &Receiver<Message>) {
        let mut bytes = Vec::new();
        let mut replies = Replies::new();
        loop {
            let first = match self.unsynced {
                None => told.recv().map_err(|_| RecvTimeoutError::Disconnected),
                Some(since) => told.recv_timeout((since + SYNC_EVERY).saturating_duration_since(Instant::now())),
            };
            let mut next = match first {
                Ok(message) => Some(message),
                Err(RecvTimeoutError::Timeout) => {
                    self.sync_beside();
                    continue;
                }
                Err(RecvTimeoutError::Disconnected) => break,
            };
            // All that waits goes out in one piece.
            let mut after = None;
            while let Some(message) = next {
                match message {
                    Message::Entry(record, answers) => {
                        if let Some(record) = record {
                            frame(&record, &mut bytes);
                        }
                        replies.extend(answers);
                    }
                    other => {
                        after = Some(other);
                        break;
                    }
                }
                next = if bytes.len() < BATCH_BYTES { told.try_recv().ok() } else { None };
            }
            self.write(&mut bytes, &mut replies);
            match after {
                Some(Message::Snapshot(snapshot)) => self.snapshot(*snapshot),
                Some(Message::Unsafe(failure)) => {
                    tracing::warn!("the journal was not synced, and is once more: {failure}");
                    self.unsynced.get_or_insert_with(Instant::now);
                    self.sync();
                }
                Some(Message::Needed(oldest)) => self.drop_unneeded(oldest),
                Some(Message::Close) => break,
                Some(Message::Entry(..)) | None => {}
            }
        }
        self.sync();
    }

    /// Writes, then replies. Without the one there is not the other.
    fn write(&mut self, bytes: &mut Vec<u8>, replies: &mut Replies) {
        let is_written = bytes.is_empty() || self.until_done(|log| log.append(bytes));
        if is_written && !bytes.is_empty() {
            self.unsynced.get_or_insert_with(Instant::now);
            if self.fsync == Fsync::Command {
                self.sync();
            }
        }
        bytes.clear();
        for (reply, answer) in replies.drain(..) {
            if is_written {
                // A client that has gone no longer wants to know.
                drop(reply.send(answer));
            }
        }
    }

    /// Has what was written made safe by another thread.
    fn sync_beside(&mut self) {
        let is_begun = self.log.handle().is_ok_and(|file| self.syncer.begin(file));
        // Where the disk is not done with the last second, this one waits a second more.
        self.unsynced = (!is_begun).then(Instant::now);
    }

    /// Waits until what was written is safe.
    fn sync(&mut self) {
        if self.unsynced.take().is_some() {
            self.until_done(|log| log.sync());
        }
    }

    /// Tries until the disk takes it; `false` when the daemon is to end before.
    fn until_done(&mut self, mut attempt: impl FnMut(&mut LogWriter) -> io::Result<()>) -> bool {
        let mut last_tries = LAST_TRIES;
        loop {
            match attempt(&mut self.log) {
                Ok(()) => {
                    if self.disk.set_blocked(None) {
                        tracing::info!("the journal goes on");
                        self.mailbox.wake();
                    }
                    return true;
                }
                Err(failure) => {
                    let text = format!("{}: {failure}", self.log.path().display());
                    if self.disk.set_blocked(Some(text.clone())) {
                        tracing::error!("the journal cannot be written: {text}");
                        self.mailbox.wake();
                    }
                    if self.disk.closing.load(Relaxed) {
                        last_tries -= 1;
                        if last_tries == 0 {
                            tracing::error!("what was accepted last is not in the journal, and was not acknowledged");
                            return false;
                        }
                    }
                    thread::sleep(RETRY);
                }
            }
        }
    }

    /// The log is safe before its snapshot, so that no snapshot is ahead of it.
    fn snapshot(&mut self, snapshot: Snapshot) {
        let next = snapshot.daemon.sequence;
        self.unsynced.get_or_insert_with(Instant::now);
        self.sync();
        match LogWriter::create(&self.folder, next) {
            Ok(log) => self.log = log,
            Err(failure) => tracing::warn!("the log goes on in its old file: {failure}"),
        }
        if !self.snapshots.write(snapshot) {
            self.disk.set_written(Written {
                sequence: next,
                outcome: Err(io::Error::other("the disk has not taken the one before yet")),
            });
        }
    }

    /// Removes what is older than all snapshots, once the log is larger than it shall be.
    fn drop_unneeded(&self, oldest: u64) {
        let Keep::Bytes(most) = self.keep else { return };
        let removed = (|| {
            let all = segments(&self.folder)?;
            let sizes = all.iter().map(|segment| fs::metadata(&segment.path).map(|about| about.len()));
            if sizes.sum::<io::Result<u64>>()? <= most {
                return Ok(());
            }
            let needed = all.partition_point(|segment| segment.first <= oldest).saturating_sub(1);
            all[..needed].iter().try_for_each(|segment| fs::remove_file(&segment.path))
        })();
        if let Err(failure) = removed {
            tracing::warn!("old files of the journal were not removed: {failure}");
        }
    }
}
