//! The log as files: `log/<first record>.log`, appended to only, a new one for every start and every snapshot.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `STURZJNL` |
//! | 4 | format, u32 |
//! | 8 | number of its first record, u64 |
//! | 8 | XXH3 of these 20 |
//! | 4 + 8 + 4, repeated | length n of a record, XXH3 of its bytes, lower half of XXH3 of these 12 |
//! | n | the record |
//!
//! Numbers are little-endian. A process that is killed leaves a file that ends in the midst of a record, which was
//! not acknowledged: it is cut off. Anything else that does not fit is damage, and nothing behind it can be trusted.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use prost::Message as _;
use thiserror::Error;
use xxhash_rust::xxh3::xxh3_64;

use crate::archive::sync_folder;
use crate::journal::record::Record;

const MAGIC: &[u8; 8] = b"STURZJNL";
/// Changes with any change of the framing.
const FORMAT: u32 = 1;
const HEAD_BYTES: usize = 28;
const FRAME_BYTES: usize = 16;
/// Ending of a file's name.
const ENDING: &str = ".log";

/// Why a log cannot be read.
#[derive(Debug, Error)]
pub enum LogError {
    /// The disk says no.
    #[error("{}: {source}", path.display())]
    Disk {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Bytes are not what was written.
    #[error("{} is damaged at byte {at}: {what}; what follows cannot be trusted", path.display())]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// Where.
        at: u64,
        /// How it shows.
        what: String,
    },
    /// Of a newer program.
    #[error("{} has format {found}, this program reads {FORMAT}", path.display())]
    OtherFormat {
        /// Which file.
        path: PathBuf,
        /// Its format.
        found: u32,
    },
    /// A file has gone.
    #[error("the log has no record {wanted}: {} begins with {found}", path.display())]
    Gap {
        /// The file behind the gap.
        path: PathBuf,
        /// What should follow.
        wanted: u64,
        /// What does.
        found: u64,
    },
}

/// A file of the log and the number of its first record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Where.
    pub path: PathBuf,
    /// As in its name.
    pub first: u64,
}

/// All files of a log in order.
pub fn segments(folder: &Path) -> io::Result<Vec<Segment>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if let Some(first) = name.strip_suffix(ENDING).and_then(|number| number.parse().ok()) {
            found.push(Segment { path, first });
        }
    }
    found.sort_by_key(|segment| segment.first);
    Ok(found)
}

/// Appends records to one file.
pub struct LogWriter {
    file: File,
    path: PathBuf,
    /// Up to here all is whole.
    length: u64,
    /// Something may be behind that.
    is_torn: bool,
}

impl LogWriter {
    /// Starts a file whose first record has this number.
    pub fn create(folder: &Path, first: u64) -> io::Result<Self> {
        let path = folder.join(format!("{first:012}{ENDING}"));
        // One of that name holds no record: it was begun and nothing came.
        let mut file = OpenOptions::new().create(true).write(true).truncate(true).open(&path)?;
        let mut head = MAGIC.to_vec();
        head.extend_from_slice(&FORMAT.to_le_bytes());
        head.extend_from_slice(&first.to_le_bytes());
        head.extend_from_slice(&xxh3_64(&head).to_le_bytes());
        file.write_all(&head)?;
        file.sync_all()?;
        sync_folder(folder)?;
        Ok(Self { file, path, length: head.len() as u64, is_torn: false })
    }

    /// Appends bytes made by [`frame`]. After an error, none of them count, and it may be tried again.
    pub fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        if self.is_torn {
            // What is left of the last attempt would stand in the way.
            self.file.set_len(self.length)?;
            self.file.seek(SeekFrom::Start(self.length))?;
        }
        self.is_torn = true;
        self.file.write_all(bytes)?;
        self.is_torn = false;
        self.length += bytes.len() as u64;
        Ok(())
    }

    /// Waits until all of it is on the disk.
    pub fn sync(&self) -> io::Result<()> {
        self.file.sync_data()
    }

    /// The file, for a thread that syncs it.
    pub fn handle(&self) -> io::Result<File> {
        self.file.try_clone()
    }

    /// Which file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Puts a record's bytes behind others.
pub fn frame(record: &Record, bytes: &mut Vec<u8>) {
    let start = bytes.len();
    bytes.resize(start + FRAME_BYTES, 0);
    // Writing into a Vec cannot fail.
    let _ = record.encode(bytes);
    let content = &bytes[start + FRAME_BYTES..];
    let (length, checksum) = (content.len() as u32, xxh3_64(content));
    bytes[start..start + 4].copy_from_slice(&length.to_le_bytes());
    bytes[start + 4..start + 12].copy_from_slice(&checksum.to_le_bytes());
    let of_head = xxh3_64(&bytes[start..start + 12]) as u32;
    bytes[start + 12..start + 16].copy_from_slice(&of_head.to_le_bytes());
}

/// The records of one file, read one by one.
pub struct SegmentReader {
    path: PathBuf,
    bytes: Vec<u8>,
    at: usize,
    next: u64,
}

/// What there is at a place of a file.
pub enum Next {
    /// A record.
    Record(Box<Record>),
    /// The end, as it was written.
    End,
    /// The end, in the midst of a record or of the head: cut here.
    Torn(u64),
}

impl SegmentReader {
    /// Reads a file, whose head must be whole unless it is torn.
    pub fn open(segment: &Segment) -> Result<Self, LogError> {
        let path = segment.path.clone();
        let bytes = fs::read(&path).map_err(|source| LogError::Disk { path, source })?;
        Self::of(segment, bytes)
    }

    /// The same of what such a file would hold.
    pub fn of(segment: &Segment, bytes: Vec<u8>) -> Result<Self, LogError> {
        let mut reader = Self { path: segment.path.clone(), bytes, at: 0, next: segment.first };
        if reader.bytes.len() >= HEAD_BYTES && !is_zero(&reader.bytes) {
            reader.check_head(segment.first)?;
            reader.at = HEAD_BYTES;
        }
        Ok(reader)
    }

    fn check_head(&self, first: u64) -> Result<(), LogError> {
        let (head, checksum) = (&self.bytes[..HEAD_BYTES - 8], &self.bytes[HEAD_BYTES - 8..HEAD_BYTES]);
        if !head.starts_with(MAGIC) {
            return Err(self.damaged(0, "it is no log"));
        }
        let found = u32_at(head, 8);
        if xxh3_64(head).to_le_bytes() != checksum {
            return Err(self.damaged(0, "the checksum of its head differs"));
        }
        if found != FORMAT {
            return Err(LogError::OtherFormat { path: self.path.clone(), found });
        }
        if u64_at(head, 12) != first {
            return Err(self.damaged(12, "its name and its head tell different records"));
        }
        Ok(())
    }

    /// The next record.
    pub fn next_record(&mut self) -> Result<Next, LogError> {
        if self.at == 0 {
            return Ok(Next::Torn(0));
        }
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return Ok(Next::End);
        }
        // Zeros: the file grew, its content did not reach the disk.
        if rest.len() < FRAME_BYTES || is_zero(rest) {
            return Ok(Next::Torn(self.at as u64));
        }
        let (head, content) = rest.split_at(FRAME_BYTES);
        if xxh3_64(&head[..12]) as u32 != u32_at(head, 12) {
            return Err(self.damaged(self.at, "the checksum of a record's head differs"));
        }
        let Some(content) = content.get(..u32_at(head, 0) as usize) else {
            return Ok(Next::Torn(self.at as u64));
        };
        if xxh3_64(content) != u64_at(head, 4) {
            return Err(self.damaged(self.at, "the checksum of a record differs"));
        }
        let record = Record::decode(content).map_err(|error| self.damaged(self.at, &error.to_string()))?;
        if record.sequence != self.next {
            let text = format!("record {} where {} should be", record.sequence, self.next);
            return Err(self.damaged(self.at, &text));
        }
        self.at += FRAME_BYTES + content.len();
        self.next += 1;
        Ok(Next::Record(Box::new(record)))
    }

    /// Number of the record that would come next.
    pub fn next_sequence(&self) -> u64 {
        self.next
    }

    fn damaged(&self, at: usize, what: &str) -> LogError {
        LogError::Damaged { path: self.path.clone(), at: at as u64, what: what.into() }
    }
}

fn is_zero(bytes: &[u8]) -> bool {
    bytes.iter().all(|&byte| byte == 0)
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(std::array::from_fn(|k| bytes[at + k]))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(std::array::from_fn(|k| bytes[at + k]))
}

/// A log as it was found.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Number of the record to be written next.
    pub next: u64,
    /// What a crash left of a last record: where to cut which file.
    pub torn: Option<(PathBuf, u64)>,
}

/// Hands out all records from number `from` on, in order; files before it are not looked at.
pub fn read(folder: &Path, from: u64, mut each: impl FnMut(Record) -> anyhow::Result<()>) -> anyhow::Result<Found> {
    let all = segments(folder).map_err(|source| LogError::Disk { path: folder.into(), source })?;
    let start = all.partition_point(|segment| segment.first <= from).saturating_sub(1);
    let mut found = Found { next: from, torn: None };
    let Some(first) = all.get(start) else { return Ok(found) };
    // The first file may begin before the wanted record, not behind it.
    let mut next = first.first.min(from);
    for (k, segment) in all.iter().enumerate().skip(start) {
        if segment.first != next {
            Err(LogError::Gap { path: segment.path.clone(), wanted: next, found: segment.first })?;
        }
        let mut reader = SegmentReader::open(segment)?;
        loop {
            match reader.next_record()? {
                Next::Record(record) if record.sequence >= from => each(*record)?,
                Next::Record(_) => {}
                Next::End => break,
                // A file that others follow may be torn where a crash was: its successor begins at that record.
                Next::Torn(at) => {
                    found.torn = Some((segment.path.clone(), at)).filter(|_| k + 1 == all.len());
                    break;
                }
            }
        }
        next = reader.next_sequence();
    }
    found.next = next.max(from);
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::journal::record::{Accepted, Entry};

    fn record(sequence: u64) -> Record {
        let request = vec![sequence as u8; 3 * sequence as usize].into();
        let accepted = Accepted { verb: "insert".into(), request, outcome: None };
        Record { sequence, step: 10 * sequence, entry: Some(Entry::Command(accepted)) }
    }

    /// Two files of three and two records.
    fn written(folder: &Path) -> Vec<PathBuf> {
        [0..3, 3..5]
            .map(|range| {
                let mut writer = LogWriter::create(folder, range.start).unwrap();
                for sequence in range {
                    let mut bytes = Vec::new();
                    frame(&record(sequence), &mut bytes);
                    writer.append(&bytes).unwrap();
                }
                writer.sync().unwrap();
                writer.path().to_path_buf()
            })
            .to_vec()
    }

    fn read_all(folder: &Path, from: u64) -> anyhow::Result<(Vec<u64>, Found)> {
        let mut sequences = Vec::new();
        let found = read(folder, from, |found| {
            assert_eq!(found, record(found.sequence));
            sequences.push(found.sequence);
            Ok(())
        })?;
        Ok((sequences, found))
    }

    #[test]
    fn what_was_written_is_read_from_anywhere() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(read_all(folder.path(), 0).unwrap(), (vec![], Found::default()));
        written(folder.path());
        for from in 0..=5 {
            let found = Found { next: 5, torn: None };
            assert_eq!(read_all(folder.path(), from).unwrap(), ((from..5).collect(), found));
        }
        // A snapshot may be ahead of what a power loss left of the log.
        assert_eq!(read_all(folder.path(), 9).unwrap(), (vec![], Found { next: 9, torn: None }));
    }

    /// A cut of the last file loses the records behind it and says where it is, whatever the place.
    #[test]
    fn every_cut_of_the_last_file_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let last = written(folder.path()).pop().unwrap();
        let whole = fs::read(&last).unwrap();
        let ends: Vec<usize> = {
            let mut bytes = Vec::new();
            let mut ends = vec![HEAD_BYTES];
            for sequence in 3..5 {
                frame(&record(sequence), &mut bytes);
                ends.push(HEAD_BYTES + bytes.len());
            }
            ends
        };
        for cut in 0..whole.len() {
            fs::write(&last, &whole[..cut]).unwrap();
            let (sequences, found) = read_all(folder.path(), 0).unwrap();
            let whole_records = ends.iter().filter(|&&end| end <= cut).count().saturating_sub(1);
            assert_eq!(sequences, (0..3 + whole_records as u64).collect::<Vec<_>>(), "cut at {cut}");
            let sound = if cut < HEAD_BYTES { 0 } else { ends[whole_records] };
            assert_eq!(
                found.torn.map(|(_, at)| at),
                (cut != sound || cut == 0).then_some(sound as u64),
                "cut at {cut}"
            );
            // What a power loss may leave: the length of the file without its content.
            let mut zeros = whole[..sound].to_vec();
            zeros.resize(whole.len(), 0);
            fs::write(&last, zeros).unwrap();
            assert_eq!(read_all(folder.path(), 0).unwrap().0, sequences, "zeros from {sound}");
        }
    }

    #[test]
    fn a_flipped_bit_anywhere_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        for path in written(folder.path()) {
            let whole = fs::read(&path).unwrap();
            for at in 0..whole.len() {
                for bit in 0..8 {
                    let mut bytes = whole.clone();
                    bytes[at] ^= 1 << bit;
                    fs::write(&path, bytes).unwrap();
                    let refused = read_all(folder.path(), 0).unwrap_err();
                    assert!(refused.downcast_ref::<LogError>().is_some(), "byte {at}: {refused}");
                }
            }
            fs::write(&path, whole).unwrap();
        }
    }

    #[test]
    fn files_that_have_gone_or_were_cut_within_are_missed() {
        let folder = tempfile::tempdir().unwrap();
        let paths = written(folder.path());
        let whole = fs::read(&paths[0]).unwrap();
        fs::write(&paths[0], &whole[..whole.len() - 1]).unwrap();
        let refused = read_all(folder.path(), 0).unwrap_err().to_string();
        assert!(refused.contains("no record 2"), "{refused}");
        fs::remove_file(&paths[0]).unwrap();
        assert!(read_all(folder.path(), 0).unwrap_err().to_string().contains("no record 0"));
        assert_eq!(read_all(folder.path(), 3).unwrap().0, [3, 4]);
    }

    /// After a crash its successor begins with the record that was torn.
    #[test]
    fn a_torn_file_may_have_a_successor() {
        let folder = tempfile::tempdir().unwrap();
        let paths = written(folder.path());
        fs::remove_file(&paths[1]).unwrap();
        let whole = fs::read(&paths[0]).unwrap();
        fs::write(&paths[0], &whole[..whole.len() - 1]).unwrap();
        assert_eq!(read_all(folder.path(), 0).unwrap().1.next, 2);
        let mut writer = LogWriter::create(folder.path(), 2).unwrap();
        let mut bytes = Vec::new();
        frame(&record(2), &mut bytes);
        writer.append(&bytes).unwrap();
        assert_eq!(read_all(folder.path(), 0).unwrap(), (vec![0, 1, 2], Found { next: 3, torn: None }));
    }
}
