//! Frames as the daemon publishes them: a bounded queue that forgets the oldest, and counts what was lost where.

use std::future::poll_fn;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

use prost::Message;
use prost::bytes::Bytes;
use sturz_protocol::v1;

use crate::bus::{Bus, Subscription};
use crate::error::ClientError;
use crate::queue::{End, Popped, Queue};

/// Frames as they come; iterate over it.
///
/// A slow reader loses the oldest frames, never the newest, and slows nobody down. The iteration ends when the daemon
/// is gone; a frame that cannot be read is an `Err`, and others follow. Dropping the stream ends the subscription.
pub struct Stream<T> {
    // First: nothing comes in while the rest is dropped.
    _subscription: Subscription,
    inlet: Arc<Inlet>,
    decode: fn(Bytes) -> Result<T, ClientError>,
    name: String,
    bus: Arc<Bus>,
}

/// Frames of a stream so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StreamCounts {
    /// Reached this process.
    pub received: u64,
    /// Did not reach it, by gaps in their sequence numbers; 0 for events, of which `missed` tells.
    pub lost_on_the_way: u64,
    /// Events that did not come, nor could be had from the daemon's memory: gaps that zenoh has told of.
    pub missed: u64,
    /// Were overwritten in the queue before they were read.
    pub overwritten_here: u64,
}

/// How a stream is set up.
pub(crate) struct Source<T> {
    /// Below the root of the instance.
    pub(crate) name: String,
    /// Whole key.
    pub(crate) key: String,
    /// Recent past first, and sequence numbers that are not counted.
    pub(crate) is_events: bool,
    /// Frames to keep.
    pub(crate) keep: usize,
    /// From bytes.
    pub(crate) decode: fn(Bytes) -> Result<T, ClientError>,
}

impl<T> Stream<T> {
    /// Subscribes.
    pub(crate) fn open(bus: &Arc<Bus>, source: Source<T>) -> Result<Self, ClientError> {
        let inlet = Arc::new(Inlet {
            frames: Queue::new(source.keep),
            sequence: Mutex::default(),
            is_counted: !source.is_events,
            missed: AtomicU64::new(0),
        });
        bus.watch.end_with_daemon(&inlet);
        let receiver = Arc::clone(&inlet);
        let take = move |payload| receiver.take(payload);
        let subscription = if source.is_events {
            let inlet = Arc::clone(&inlet);
            let miss = move |count| {
                inlet.missed.fetch_add(count, Relaxed);
            };
            bus.subscribe_with_history(&source.key, take, miss)?
        } else {
            bus.subscribe(&source.key, take)?
        };
        Ok(Self { _subscription: subscription, inlet, decode: source.decode, name: source.name, bus: Arc::clone(bus) })
    }

    /// Keeps the newest `frames`, at least one, for a reader that is slow.
    pub fn keeping(self, frames: usize) -> Self {
        self.inlet.frames.set_keep(frames);
        self
    }

    /// The oldest frame that was not read; waits for one.
    ///
    /// # Errors
    /// [`ClientError::Timeout`] when none comes within `patience`, [`ClientError::DaemonGone`] when the daemon is gone
    /// and all that came before was read.
    pub fn next_within(&mut self, patience: Duration) -> Result<T, ClientError> {
        self.read(self.inlet.frames.pop(Some(Instant::now() + patience)), patience)
    }

    pub(crate) fn read(&self, popped: Popped<Bytes>, patience: Duration) -> Result<T, ClientError> {
        match popped {
            Popped::Item(payload) => (self.decode)(payload),
            Popped::Ended => Err(self.bus.gone()),
            Popped::TimedOut => {
                Err(ClientError::Timeout { what: self.name.clone(), after: patience, request_id: None })
            }
        }
    }

    /// The oldest frame that was not read, for a task; nothing when the daemon is gone and all was read.
    pub(crate) fn poll_popped(&self, context: &mut Context<'_>) -> Poll<Option<Result<T, ClientError>>> {
        self.inlet.frames.poll_pop(context).map(|payload| payload.map(|payload| (self.decode)(payload)))
    }

    /// The same, awaited.
    pub(crate) async fn popped(&self) -> Option<Result<T, ClientError>> {
        poll_fn(|context| self.poll_popped(context)).await
    }

    /// Where it comes from.
    pub(crate) fn bus(&self) -> Arc<Bus> {
        Arc::clone(&self.bus)
    }

    /// The newest frame that was not read, and none older; `None` when there is none. Never waits.
    pub fn latest(&mut self) -> Option<Result<T, ClientError>> {
        self.inlet.frames.pop_newest().map(|payload| (self.decode)(payload))
    }

    /// What came and what did not.
    pub fn counts(&self) -> StreamCounts {
        let sequence = self.inlet.sequence();
        StreamCounts {
            received: sequence.received,
            lost_on_the_way: sequence.lost,
            missed: self.inlet.missed.load(Relaxed),
            overwritten_here: self.inlet.frames.overwritten(),
        }
    }
}

impl<T> Iterator for Stream<T> {
    type Item = Result<T, ClientError>;

    fn next(&mut self) -> Option<Self::Item> {
        match self.inlet.frames.pop(None) {
            Popped::Item(payload) => Some((self.decode)(payload)),
            Popped::Ended | Popped::TimedOut => None,
        }
    }
}

/// Where the bus puts what comes in.
struct Inlet {
    frames: Queue<Bytes>,
    sequence: Mutex<Sequence>,
    is_counted: bool,
    missed: AtomicU64,
}

impl Inlet {
    fn sequence(&self) -> MutexGuard<'_, Sequence> {
        self.sequence.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Called by the bus, on its threads: reads no more than the header, and enqueues.
    fn take(&self, payload: Bytes) {
        let header = Headed::decode(payload.clone()).ok().and_then(|message| message.header);
        let mut sequence = self.sequence();
        sequence.received += 1;
        if let (Some(header), true) = (header, self.is_counted) {
            sequence.note(header.run_id, header.seq);
        }
        drop(sequence);
        self.frames.push(payload);
    }
}

impl End for Inlet {
    fn end(&self) {
        self.frames.end();
    }
}

/// What every published message begins with. Decoding this skips the columns without a copy.
#[derive(Clone, PartialEq, Message)]
struct Headed {
    #[prost(message, optional, tag = "1")]
    header: Option<v1::Header>,
}

/// Counts messages, and those that never came.
#[derive(Default)]
struct Sequence {
    received: u64,
    lost: u64,
    last: Option<(String, u64)>,
}

impl Sequence {
    /// A lower number than the last is a stream that began anew, such as that of a field that was defined again.
    fn note(&mut self, run_id: String, seq: u64) {
        if let Some((last_run, last)) = &self.last
            && *last_run == run_id
            && seq > *last
        {
            self.lost += seq - last - 1;
        }
        self.last = Some((run_id, seq));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lost(numbers: &[(&str, u64)]) -> u64 {
        let mut sequence = Sequence::default();
        numbers.iter().for_each(|&(run, seq)| sequence.note(run.into(), seq));
        sequence.lost
    }

    #[test]
    fn gaps_in_the_sequence_are_counted() {
        assert_eq!(lost(&[("r", 5), ("r", 6), ("r", 7)]), 0, "the first one that is seen may have any number");
        assert_eq!(lost(&[("r", 0), ("r", 3), ("r", 4), ("r", 6)]), 3);
    }

    #[test]
    fn a_stream_that_begins_anew_has_lost_nothing() {
        assert_eq!(lost(&[("r", 9), ("r", 0), ("r", 1)]), 0);
        assert_eq!(lost(&[("r", 9), ("s", 50), ("s", 52)]), 1);
    }

    fn frame(seq: u64) -> Vec<u8> {
        let header = v1::Header { run_id: "r".into(), seq, ..Default::default() };
        let column = v1::Column { name: "ids".into(), data: vec![0; 80].into(), ..Default::default() };
        v1::Frame { header: Some(header), n: 10, columns: vec![column], ..Default::default() }.encode_to_vec()
    }

    #[test]
    fn losses_are_counted_where_they_happen() {
        let inlet =
            Inlet { frames: Queue::new(2), sequence: Mutex::default(), is_counted: true, missed: AtomicU64::new(0) };
        [0, 1, 4, 5].into_iter().for_each(|seq| inlet.take(frame(seq).into()));
        inlet.take(Bytes::from_static(b"no message"));
        let sequence = inlet.sequence();
        assert_eq!((sequence.received, sequence.lost, inlet.frames.overwritten()), (5, 2, 3));
    }

    #[test]
    fn every_published_message_begins_with_its_header() {
        let header = Some(v1::Header { seq: 3, ..Default::default() });
        let messages = [
            v1::Frame { header: header.clone(), ..Default::default() }.encode_to_vec(),
            v1::ContactFrame { header: header.clone(), ..Default::default() }.encode_to_vec(),
            v1::FieldFrame { header: header.clone(), ..Default::default() }.encode_to_vec(),
            v1::Report { header: header.clone(), ..Default::default() }.encode_to_vec(),
            v1::Event { header: header.clone(), ..Default::default() }.encode_to_vec(),
        ];
        for message in messages {
            assert_eq!(Headed::decode(message.as_slice()).unwrap().header, header);
        }
    }
}
