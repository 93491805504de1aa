//! The bytes around the sections: magic, format, length, and a checksum over all of it.
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `STURZCKP` |
//! | 4 | format, u32 |
//! | 8 | length of the whole, u64 |
//! | 4 + 8 + n, repeated | a section: four letters, its length n, its bytes |
//! | 8 | XXH3 (64 bits) of all bytes before |
//!
//! Numbers are little-endian. The format changes with any change of a section: a reader takes its own format only.

use xxhash_rust::xxh3::xxh3_64;

use super::codec::{Pack, Reader};
use super::error::CheckpointError;

const MAGIC: &[u8; 8] = b"STURZCKP";
/// Changes with any change of a section.
pub(super) const FORMAT: u32 = 1;
const HEAD_BYTES: usize = 20;
const CHECKSUM_BYTES: usize = 8;

/// Four letters.
pub(super) type Tag = [u8; 4];

/// Sections on their way into bytes.
pub(super) struct Writer(Vec<u8>);

impl Writer {
    /// Without sections.
    pub fn new() -> Self {
        let mut bytes = MAGIC.to_vec();
        FORMAT.put(&mut bytes);
        0u64.put(&mut bytes);
        Self(bytes)
    }

    /// Appends a section.
    pub fn section(&mut self, tag: Tag, content: &impl Pack) {
        self.0.extend_from_slice(&tag);
        let start = self.0.len() + 8;
        0u64.put(&mut self.0);
        content.put(&mut self.0);
        let bytes = (self.0.len() - start) as u64;
        self.0[start - 8..start].copy_from_slice(&bytes.to_le_bytes());
    }

    /// All of it, with length and checksum.
    pub fn finish(self) -> Vec<u8> {
        let mut bytes = self.0;
        let length = (bytes.len() + CHECKSUM_BYTES) as u64;
        bytes[HEAD_BYTES - 8..HEAD_BYTES].copy_from_slice(&length.to_le_bytes());
        xxh3_64(&bytes).put(&mut bytes);
        bytes
    }
}

/// Sections of bytes that are whole and sound.
pub(super) struct Sections<'a>(Reader<'a>);

impl<'a> Sections<'a> {
    /// Checks everything around the sections.
    pub fn open(bytes: &'a [u8]) -> Result<Self, CheckpointError> {
        let Some(head) = bytes.get(..HEAD_BYTES).filter(|head| head.starts_with(MAGIC)) else {
            return Err(CheckpointError::NoCheckpoint);
        };
        let mut reader = Reader(&head[MAGIC.len()..]);
        let (Ok(format), Ok(length)) = (reader.get::<u32>(), reader.get::<u64>()) else {
            return Err(CheckpointError::NoCheckpoint);
        };
        if format != FORMAT {
            return Err(CheckpointError::OtherFormat { found: format, known: FORMAT });
        }
        if length != bytes.len() as u64 || bytes.len() < HEAD_BYTES + CHECKSUM_BYTES {
            return Err(CheckpointError::WrongLength { found: bytes.len() as u64, wanted: length });
        }
        let (content, checksum) = bytes.split_at(bytes.len() - CHECKSUM_BYTES);
        let wanted = Reader(checksum).get::<u64>().unwrap_or_default();
        let found = xxh3_64(content);
        if found != wanted {
            return Err(CheckpointError::Damaged { found, wanted });
        }
        Ok(Self(Reader(&content[HEAD_BYTES..])))
    }

    /// The next section, which must have this name.
    pub fn section<T: Pack>(&mut self, tag: Tag) -> Result<T, CheckpointError> {
        let error = |problem| CheckpointError::Malformed { section: String::from_utf8_lossy(&tag).into(), problem };
        let name = self.0.take(tag.len()).map_err(|_| error("is missing"))?;
        if name != tag {
            return Err(error("is not where it should be"));
        }
        let length = self.0.get::<u64>().map_err(|malformed| error(malformed.0))?;
        let length = usize::try_from(length).map_err(|_| error("ends early"))?;
        let content = self.0.take(length).map_err(|malformed| error(malformed.0))?;
        Reader(content).get_all().map_err(|malformed| error(malformed.0))
    }

    /// The next section, if it has this name: one that is written only where it says something.
    pub fn optional<T: Pack>(&mut self, tag: Tag) -> Result<Option<T>, CheckpointError> {
        if self.0.0.starts_with(&tag) { self.section(tag).map(Some) } else { Ok(None) }
    }

    /// There must be no more.
    pub fn end(self) -> Result<(), CheckpointError> {
        if self.0.0.is_empty() {
            return Ok(());
        }
        Err(CheckpointError::Malformed { section: "after the last".into(), problem: "is unknown" })
    }
}
