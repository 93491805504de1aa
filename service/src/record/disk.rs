//! The thread that writes a recording, and the bounded queue before it: a slow disk never holds up the bus.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::anyhow;
use sturz_protocol::v1;
use tokio::sync::mpsc;
use zenoh::bytes::ZBytes;

use super::headed::{Headed, wall_time_ns};
use super::write::{MessageTimes, RecordingWriter};

/// Messages that wait for the disk.
const QUEUE_MESSAGES: usize = 4096;
/// What a killed recorder may lose.
const FLUSH: Duration = Duration::from_secs(1);

/// A message on its way to the disk.
struct Letter {
    tail: String,
    message: String,
    payload: ZBytes,
    log_time_ns: u64,
}

/// Bus side of the queue; never waits.
#[derive(Clone)]
pub struct Queue {
    sender: SyncSender<Letter>,
    waiting: Arc<AtomicU64>,
    dropped: Arc<AtomicU64>,
    limit_bytes: u64,
}

impl Queue {
    /// Takes a message published under `tail`, unless too many bytes wait.
    pub fn add(&self, tail: &str, message: &str, payload: ZBytes) {
        let bytes = payload.len() as u64;
        let letter = Letter { tail: tail.into(), message: message.into(), payload, log_time_ns: wall_time_ns() };
        if self.waiting.load(Relaxed) + bytes > self.limit_bytes {
            self.dropped.fetch_add(1, Relaxed);
            return;
        }
        self.waiting.fetch_add(bytes, Relaxed);
        if let Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) = self.sender.try_send(letter) {
            self.waiting.fetch_sub(bytes, Relaxed);
            self.dropped.fetch_add(1, Relaxed);
        }
    }
}

/// When the recording is complete.
#[derive(Clone, Debug)]
pub struct Until {
    /// s
    pub sim_time_s: f64,
    /// Keys below the instance: streams that have not reached it.
    pub streams: BTreeSet<String>,
}

/// What the disk has found out while it wrote.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndReason {
    /// A stream has reached the simulated time asked for.
    TimeNear,
    /// All streams have.
    TimeReached,
    /// It cannot write any more; joining it says why.
    Failed,
    /// `info` has changed.
    InfoChanged,
}

/// Of one stream.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct StreamTally {
    /// Messages written.
    pub messages: u64,
    /// Their bytes, before compression.
    pub bytes: u64,
    /// Messages that the sequence numbers say are missing.
    pub lost: u64,
    #[serde(skip)]
    last: Option<(String, u64)>,
}

impl StreamTally {
    fn count(&mut self, header: Option<&v1::Header>, bytes: u64) {
        self.messages += 1;
        self.bytes += bytes;
        let Some(header) = header else { return };
        if let Some((run, seq)) = &self.last {
            // A restarted run or stream is no gap.
            if *run == header.run_id && header.seq > *seq {
                self.lost += header.seq - seq - 1;
            }
        }
        self.last = Some((header.run_id.clone(), header.seq));
    }
}

/// What is in the file.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// By key below the instance.
    pub streams: BTreeMap<String, StreamTally>,
    /// Simulated time of the first and the last message that has one, s.
    pub sim_time_s: Option<[f64; 2]>,
}

/// The writing thread.
pub struct Disk {
    thread: JoinHandle<anyhow::Result<Tally>>,
    dropped: Arc<AtomicU64>,
}

impl Disk {
    /// Starts writing what comes for `instance`; at most `limit_bytes` wait. What it finds out goes to `found`.
    pub fn start(
        writer: RecordingWriter,
        instance: &str,
        limit_bytes: u64,
        until: Option<Until>,
        found: mpsc::Sender<EndReason>,
    ) -> anyhow::Result<(Queue, Self)> {
        let (sender, receiver) = sync_channel(QUEUE_MESSAGES);
        let (waiting, dropped) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicU64::new(0)));
        let queue = Queue { sender, waiting: Arc::clone(&waiting), dropped: Arc::clone(&dropped), limit_bytes };
        let root = format!("sturz/v1/{instance}/");
        let press = Press { writer, root, tally: Tally::default(), until, found, epoch: None };
        let thread = thread::Builder::new().name("recorder".into()).spawn(move || press.run(&receiver, &waiting))?;
        Ok((queue, Self { thread, dropped }))
    }

    /// Waits until all is written, after the last [`Queue`] is gone; tells what is in the file and how many messages the
    /// disk was too slow for.
    pub fn join(self) -> anyhow::Result<(Tally, u64)> {
        let tally = self.thread.join().map_err(|_| anyhow!("the recorder's thread has panicked"))??;
        Ok((tally, self.dropped.load(Relaxed)))
    }
}

struct Press {
    writer: RecordingWriter,
    root: String,
    tally: Tally,
    until: Option<Until>,
    found: mpsc::Sender<EndReason>,
    epoch: Option<u64>,
}

impl Press {
    fn run(mut self, receiver: &Receiver<Letter>, waiting: &AtomicU64) -> anyhow::Result<Tally> {
        let written = self.write_all(receiver, waiting);
        if written.is_err() {
            self.tell(EndReason::Failed);
        }
        written?;
        self.writer.finish()?;
        Ok(self.tally)
    }

    fn write_all(&mut self, receiver: &Receiver<Letter>, waiting: &AtomicU64) -> anyhow::Result<()> {
        let mut flushed = Instant::now();
        let mut unflushed = false;
        loop {
            let patience = if unflushed { FLUSH.saturating_sub(flushed.elapsed()) } else { FLUSH };
            match receiver.recv_timeout(patience) {
                Ok(letter) => {
                    let written = self.write(&letter);
                    waiting.fetch_sub(letter.payload.len() as u64, Relaxed);
                    written?;
                    if !unflushed {
                        (flushed, unflushed) = (Instant::now(), true);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            if unflushed && flushed.elapsed() >= FLUSH {
                self.writer.flush()?;
                unflushed = false;
            }
        }
    }

    fn write(&mut self, letter: &Letter) -> anyhow::Result<()> {
        let payload = letter.payload.to_bytes();
        let header = match letter.message.as_str() {
            "Info" | "Features" | "Plan" | "Shapes" => None,
            _ => Headed::read(&payload),
        };
        let times = MessageTimes {
            sequence: header.as_ref().map_or(0, |header| header.seq as u32),
            log_time_ns: letter.log_time_ns,
            publish_time_ns: header.as_ref().map_or(letter.log_time_ns, |header| header.wall_time_ns),
        };
        self.writer.write(&format!("{}{}", self.root, letter.tail), &letter.message, times, &payload)?;
        let stream = self.tally.streams.entry(letter.tail.clone()).or_default();
        stream.count(header.as_ref(), payload.len() as u64);
        if let Some(header) = &header {
            self.look_at(letter, header);
        }
        Ok(())
    }

    fn look_at(&mut self, letter: &Letter, header: &v1::Header) {
        // Events that are remembered are older than the recording.
        if letter.message == "Event" {
            if !letter.tail.ends_with("/command") {
                self.tell(EndReason::InfoChanged);
            }
            return;
        }
        let time_s = header.sim_time_s;
        let [first, last] = self.tally.sim_time_s.get_or_insert([time_s, time_s]);
        (*first, *last) = (first.min(time_s), last.max(time_s));
        if let Some(until) = self.until.as_mut().filter(|until| time_s >= until.sim_time_s) {
            let news = until.streams.remove(&letter.tail);
            let reason = if until.streams.is_empty() { EndReason::TimeReached } else { EndReason::TimeNear };
            if news {
                self.tell(reason);
            }
        }
        if letter.message == "Frame" && self.epoch.replace(header.topology_epoch) != Some(header.topology_epoch) {
            self.tell(EndReason::InfoChanged);
        }
    }

    /// With many untold, one of the same kind has been told.
    fn tell(&self, reason: EndReason) {
        let _ = self.found.try_send(reason);
    }
}

#[cfg(test)]
mod tests {
    use prost::Message as _;

    use super::*;
    use crate::record::Recording;

    fn frame(run: &str, seq: u64, sim_time_s: f64) -> Vec<u8> {
        let header = v1::Header { run_id: run.into(), seq, sim_time_s, wall_time_ns: 5 + seq, ..Default::default() };
        v1::Frame { header: Some(header), ..Default::default() }.encode_to_vec()
    }

    fn start(folder: &tempfile::TempDir, limit_bytes: u64) -> (Queue, Disk, mpsc::Receiver<EndReason>) {
        let writer = RecordingWriter::create(&folder.path().join("a.mcap"), true, BTreeMap::new()).unwrap();
        let (found, heard) = mpsc::channel(8);
        let streams = BTreeSet::from(["state/frame".to_string(), "report".to_string()]);
        let until = Until { sim_time_s: 0.5, streams };
        let (queue, disk) = Disk::start(writer, "drum", limit_bytes, Some(until), found).unwrap();
        (queue, disk, heard)
    }

    #[test]
    fn what_is_queued_is_read_again_and_gaps_are_counted() {
        let folder = tempfile::tempdir().unwrap();
        let (queue, disk, mut found) = start(&folder, 1 << 20);
        let frames = [frame("a", 7, 0.1), frame("a", 8, 0.2), frame("a", 11, 0.6), frame("b", 0, 0.7)];
        for payload in &frames {
            queue.add("state/frame", "Frame", payload.clone().into());
        }
        queue.add("report", "Report", frame("b", 0, 0.7).into());
        drop(queue);
        let (tally, dropped) = disk.join().unwrap();
        assert_eq!((dropped, tally.sim_time_s), (0, Some([0.1, 0.7])));
        let stream = &tally.streams["state/frame"];
        assert_eq!((stream.messages, stream.lost), (4, 2));
        assert_eq!(found.try_recv(), Ok(EndReason::InfoChanged));
        assert_eq!(found.try_recv(), Ok(EndReason::TimeNear));
        assert_eq!(found.try_recv(), Ok(EndReason::TimeReached));

        let mut recording = Recording::open(&folder.path().join("a.mcap")).unwrap();
        assert!(recording.is_finished());
        for payload in &frames {
            let read = recording.read().unwrap().unwrap();
            assert_eq!(
                (&read.payload, read.topic.tail.as_str(), read.topic.message.as_str()),
                (payload, "state/frame", "Frame")
            );
        }
        assert_eq!(recording.read().unwrap().unwrap().topic.message, "Report");
        assert!(recording.read().unwrap().is_none());
    }

    #[test]
    fn what_the_disk_is_too_slow_for_is_dropped_and_counted() {
        let folder = tempfile::tempdir().unwrap();
        let payload = frame("a", 0, 0.0);
        let (queue, disk, _found) = start(&folder, payload.len() as u64 - 1);
        queue.add("state/frame", "Frame", payload.into());
        drop(queue);
        let (tally, dropped) = disk.join().unwrap();
        assert_eq!((dropped, tally.streams.len()), (1, 0));
    }
}
