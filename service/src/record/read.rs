//! Reads recordings from front to end, in bounded memory, whole or cut.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mcap::records::{MessageHeader, Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError};
use thiserror::Error;

/// Longest record believed: a damaged length must not fill the memory. Frames are far smaller.
const RECORD_BYTES: u64 = 1 << 31;

/// What is believed in a small file, and how many times the file's own length in a larger one: nothing that is worth
/// recording is compressed by more.
const SMALL_RECORD_BYTES: u64 = 1 << 26;
const MOST_COMPRESSED: u64 = 1 << 10;

/// Read at a time.
const READ_BYTES: usize = 1 << 20;

/// Where a message was on the bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Name of the instance that was recorded.
    pub instance: String,
    /// Key below the instance, such as `state/frame`.
    pub tail: String,
    /// Name of the message, such as `Frame`.
    pub message: String,
}

/// A message of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// Where it was on the bus.
    pub topic: Arc<Topic>,
    /// Wall clock when it was recorded, ns since 1970.
    pub log_time_ns: u64,
    /// The message.
    pub payload: Vec<u8>,
}

/// Why a recording cannot be read, or not further.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The file system refuses.
    #[error("{}: {error}", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// As the operating system says.
        error: std::io::Error,
    },
    /// Another kind of file.
    #[error("{} is no MCAP file", .path.display())]
    NotMcap {
        /// The file.
        path: PathBuf,
    },
    /// Of something else.
    #[error("{} holds no message of a Sturz simulation (topics sturz/v1/...)", .path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// Bytes have changed.
    #[error("{} is damaged before byte {byte}: {reason}. What was read before is sound", .path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Bytes read by then.
        byte: u64,
        /// As the reader says.
        reason: String,
    },
}

/// An open recording: a file, or any other bytes.
pub struct Recording<S = File> {
    path: PathBuf,
    source: S,
    reader: LinearReader,
    bytes: u64,
    schemas: HashMap<u16, String>,
    /// `None`: no topic of ours.
    channels: HashMap<u16, Option<Arc<Topic>>>,
    messages: u64,
    finished: bool,
    over: bool,
}

impl Recording {
    /// Opens a file and looks at both ends of it.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let file = File::open(path).map_err(|error| RecordingError::Io { path: path.into(), error })?;
        Self::of(path, file)
    }
}

impl<S: Read + Seek> Recording<S> {
    /// The same of what a file of this path would hold.
    pub fn of(path: &Path, mut source: S) -> Result<Self, RecordingError> {
        let io = |error| RecordingError::Io { path: path.into(), error };
        let mut magic = [0; MAGIC.len()];
        if source.read_exact(&mut magic).is_err() || magic != MAGIC {
            return Err(RecordingError::NotMcap { path: path.into() });
        }
        let tail = source.seek(SeekFrom::End(-(MAGIC.len() as i64))).map_err(io)?;
        source.read_exact(&mut magic).map_err(io)?;
        let finished = tail >= MAGIC.len() as u64 && magic == MAGIC;
        source.rewind().map_err(io)?;
        let longest = tail.saturating_mul(MOST_COMPRESSED).clamp(SMALL_RECORD_BYTES, RECORD_BYTES);
        let options = LinearReaderOptions::default()
            // Before any message of a chunk is believed.
            .with_prevalidate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(longest as usize);
        Ok(Self {
            path: path.into(),
            source,
            reader: LinearReader::new_with_options(options),
            bytes: 0,
            schemas: HashMap::new(),
            channels: HashMap::new(),
            messages: 0,
            finished,
            over: false,
        })
    }

    /// Whether its recorder came to write the end. Otherwise it can be read up to the cut.
    pub fn is_finished(&self) -> bool {
        self.finished
    }

    /// What to say of a recording that is not finished.
    pub fn warning_of_cut(&self) -> String {
        format!("{} has no end: it was cut, or its recorder was killed. It is read up to there", self.path.display())
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Messages given out so far.
    pub fn messages(&self) -> u64 {
        self.messages
    }

    /// The next message; `None` at the end, or at the cut of an unfinished file.
    pub fn read(&mut self) -> Result<Option<Recorded>, RecordingError> {
        while !self.over {
            let parsed = match self.reader.next_event() {
                None => break,
                Some(Err(McapError::UnexpectedEof)) if !self.finished => break,
                Some(Err(error)) => return Err(self.fail(&error)),
                Some(Ok(LinearReadEvent::ReadRequest(wanted))) => {
                    // A damaged length asks for any number of bytes.
                    let read = self.source.read(self.reader.insert(wanted.min(READ_BYTES)));
                    let read = read.map_err(|error| RecordingError::Io { path: self.path.clone(), error })?;
                    self.reader.notify_read(read);
                    self.bytes += read as u64;
                    continue;
                }
                Some(Ok(LinearReadEvent::Record { opcode, data })) => match opcode {
                    op::SCHEMA | op::CHANNEL if !texts_fit(opcode, data) => Err(McapError::UnexpectedEoc),
                    op::SCHEMA | op::CHANNEL | op::MESSAGE => mcap::parse_record(opcode, data).map(Record::into_owned),
                    // What surrounds and follows the messages repeats what they say.
                    op::HEADER..=op::DATA_END => continue,
                    opcode => Ok(Record::Unknown { opcode, data: Cow::Owned(Vec::new()) }),
                },
            };
            match parsed {
                Err(error) => return Err(self.fail(&error)),
                Ok(record) => {
                    if let Some(message) = self.take(record)? {
                        self.messages += 1;
                        return Ok(Some(message));
                    }
                }
            }
        }
        self.over = true;
        if self.messages == 0 { Err(RecordingError::Foreign { path: self.path.clone() }) } else { Ok(None) }
    }

    fn fail(&mut self, error: &McapError) -> RecordingError {
        self.over = true;
        RecordingError::Damaged { path: self.path.clone(), byte: self.bytes, reason: error.to_string() }
    }

    fn take(&mut self, record: Record<'_>) -> Result<Option<Recorded>, RecordingError> {
        match record {
            Record::Schema { header, .. } => {
                let name = header.name.strip_prefix("sturz.v1.").unwrap_or_default();
                self.schemas.insert(header.id, name.into());
            }
            Record::Channel(channel) => {
                let message = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let topic = split(&channel.topic).filter(|_| !message.is_empty());
                let topic = topic
                    .map(|(instance, tail)| Arc::new(Topic { instance: instance.into(), tail: tail.into(), message }));
                self.channels.insert(channel.id, topic);
            }
            Record::Message { header: MessageHeader { channel_id, log_time, sequence, .. }, data } => {
                let Some(topic) = self.channels.get(&channel_id).cloned() else {
                    return Err(self.fail(&McapError::UnknownChannel(sequence, channel_id)));
                };
                return Ok(topic.map(|topic| Recorded { topic, log_time_ns: log_time, payload: data.into_owned() }));
            }
            // Ours have none: what is unknown was something else, a whole chunk perhaps.
            Record::Unknown { opcode, .. } => {
                self.over = true;
                let reason = format!("a record of the unknown kind {opcode:#04x}");
                return Err(RecordingError::Damaged { path: self.path.clone(), byte: self.bytes, reason });
            }
            // Not handed on by `read`.
            _ => {}
        }
        Ok(None)
    }
}

/// Whether the texts of a schema or a channel end within it: the `mcap` crate makes room for them before it looks.
fn texts_fit(opcode: u8, data: &[u8]) -> bool {
    /// What follows a text.
    fn behind(data: &[u8]) -> Option<&[u8]> {
        let (length, rest) = data.split_first_chunk()?;
        rest.get(u32::from_le_bytes(*length) as usize..)
    }
    // the id of a schema; the ids of a channel and its schema
    let ids = if opcode == op::SCHEMA { 2 } else { 4 };
    let Some(rest) = data.get(ids..).and_then(behind).and_then(behind) else { return false };
    if opcode == op::SCHEMA {
        return behind(rest).is_some();
    }
    // a map: its length in bytes, then names and values
    let Some(mut entries) = rest.get(4..) else { return false };
    while !entries.is_empty() {
        match behind(entries).and_then(behind) {
            Some(rest) => entries = rest,
            None => return false,
        }
    }
    true
}

/// Instance and the rest of `sturz/v1/<instance>/<tail>`.
fn split(key: &str) -> Option<(&str, &str)> {
    key.strip_prefix("sturz/v1/")?.split_once('/')
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use prost::Message as _;
    use sturz_protocol::v1;

    use super::*;
    use crate::record::RecordingWriter;

    /// Three chunks of a frame each.
    fn small(folder: &Path) -> (Vec<u8>, Vec<Vec<u8>>) {
        let path = folder.join("small.mcap");
        let mut writer = RecordingWriter::create(&path, true, BTreeMap::new()).unwrap();
        let frames: Vec<Vec<u8>> = (0..3)
            .map(|seq| v1::Frame { header: Some(v1::Header { seq, ..Default::default() }), n: 7, ..Default::default() })
            .map(|frame| frame.encode_to_vec())
            .collect();
        for frame in &frames {
            writer.write("sturz/v1/drum/state/frame", "Frame", Default::default(), frame).unwrap();
            writer.flush().unwrap();
        }
        writer.finish().unwrap();
        (std::fs::read(path).unwrap(), frames)
    }

    /// Messages up to the end or an error.
    fn read_all(folder: &Path, bytes: &[u8]) -> (Vec<Vec<u8>>, Result<(), RecordingError>) {
        let path = folder.join("changed.mcap");
        std::fs::write(&path, bytes).unwrap();
        let mut messages = Vec::new();
        let mut read = || {
            let mut recording = Recording::open(&path)?;
            while let Some(message) = recording.read()? {
                messages.push(message.payload);
            }
            Ok(())
        };
        let outcome = read();
        (messages, outcome)
    }

    #[test]
    fn a_file_cut_anywhere_is_read_to_the_cut() {
        let folder = tempfile::tempdir().unwrap();
        let (whole, frames) = small(folder.path());
        let mut last = 0;
        for length in (0..=whole.len()).rev().step_by(7).collect::<Vec<_>>().into_iter().rev() {
            let (messages, outcome) = read_all(folder.path(), &whole[..length]);
            assert!(messages.len() >= last && frames.starts_with(&messages), "cut at {length}");
            last = messages.len();
            match outcome {
                Ok(()) => assert!(last > 0),
                Err(RecordingError::NotMcap { .. }) => assert!(length < MAGIC.len()),
                Err(RecordingError::Foreign { .. }) => assert!(last == 0),
                Err(other) => panic!("cut at {length}: {other}"),
            }
        }
        assert_eq!(last, 3);
    }

    /// Found by the target `recording`: 4 GB were asked for.
    #[test]
    fn texts_that_are_longer_than_their_record_are_seen() {
        let text = |length: u32, text: &str| [&length.to_le_bytes()[..], text.as_bytes()].concat();
        let schema = [&[1, 0][..], &text(5, "Frame"), &text(8, "protobuf"), &text(2, "ab")].concat();
        assert!(texts_fit(op::SCHEMA, &schema));
        let entry = [text(1, "k"), text(1, "v")].concat();
        let map = [&(entry.len() as u32).to_le_bytes()[..], &entry].concat();
        let channel = [&[1, 0, 1, 0][..], &text(3, "a/b"), &text(8, "protobuf"), &map].concat();
        assert!(texts_fit(op::CHANNEL, &channel));
        for (opcode, record) in [(op::SCHEMA, schema), (op::CHANNEL, channel)] {
            (0..record.len())
                .for_each(|cut| assert!(cut == record.len() - entry.len() || !texts_fit(opcode, &record[..cut])));
            let mut long = record.clone();
            long[if opcode == op::SCHEMA { 5 } else { 7 }] = 0xff;
            assert!(!texts_fit(opcode, &long));
        }
    }

    #[test]
    fn a_changed_byte_gives_no_wrong_message() {
        let folder = tempfile::tempdir().unwrap();
        let (whole, frames) = small(folder.path());
        let mut damaged = 0;
        for at in (0..whole.len()).step_by(7) {
            let mut changed = whole.clone();
            changed[at] ^= 0x10;
            let (messages, outcome) = read_all(folder.path(), &changed);
            assert!(frames.starts_with(&messages), "byte {at}");
            match outcome {
                Err(RecordingError::Damaged { byte, .. }) => {
                    assert!(byte <= whole.len() as u64);
                    damaged += 1;
                }
                Err(RecordingError::NotMcap { .. }) => assert!(at < MAGIC.len()),
                Err(other) => panic!("byte {at}: {other}"),
                // Of the last magic bytes: it is taken for a file without an end.
                Ok(()) => assert!(messages == frames && at >= whole.len() - MAGIC.len(), "byte {at}"),
            }
        }
        assert!(damaged > whole.len() / 14);
    }
}
