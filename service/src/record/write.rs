//! Writes recordings.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use anyhow::Context as _;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions, Writer};
use sturz_protocol::DESCRIPTOR_SET;

/// Uncompressed bytes of a chunk: what a reader must hold, and what a crash may cost apart from the last second.
const CHUNK_BYTES: u64 = 4 << 20;

/// An open recording. It must be ended by [`RecordingWriter::finish`].
pub struct RecordingWriter {
    mcap: Option<Writer<BufWriter<File>>>,
    channels: HashMap<String, u16>,
}

impl RecordingWriter {
    /// Makes the file; one that exists is not overwritten.
    pub fn create(path: &Path, compressed: bool, facts: BTreeMap<String, String>) -> anyhow::Result<Self> {
        let file = File::create_new(path).map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => anyhow::anyhow!("{} exists: choose another --out", path.display()),
            _ => anyhow::Error::new(error).context(format!("cannot create {}", path.display())),
        })?;
        let options = WriteOptions::new()
            .library(format!("sturz {} {}", env!("CARGO_PKG_VERSION"), mcap::LIBRARY_IDENTIFIER))
            .chunk_size(Some(CHUNK_BYTES))
            .compression(compressed.then_some(Compression::Zstd))
            .compression_level(1)
            // Otherwise a chunk in the making lies in the file with a length that no reader believes: after a kill it stays.
            .disable_seeking(true)
            // On the recorder's own thread: the physics needs the others.
            .compression_threads(0);
        let mut mcap = options.create(BufWriter::new(file)).context("cannot begin the recording")?;
        mcap.write_metadata(&Metadata { name: "sturz".into(), metadata: facts })?;
        Ok(Self { mcap: Some(mcap), channels: HashMap::new() })
    }

    /// Appends a message of the schema (such as `Frame`).
    pub fn write(&mut self, key: &str, message: &str, times: MessageTimes, payload: &[u8]) -> anyhow::Result<()> {
        let mcap = self.mcap.as_mut().context("the recording has ended")?;
        let channel_id = match self.channels.get(key) {
            Some(&id) => id,
            None => {
                let schema = mcap.add_schema(&format!("sturz.v1.{message}"), "protobuf", DESCRIPTOR_SET)?;
                let id = mcap.add_channel(schema, key, "protobuf", &channel_facts(message))?;
                self.channels.insert(key.into(), id);
                id
            }
        };
        let MessageTimes { sequence, log_time_ns, publish_time_ns } = times;
        let header = MessageHeader { channel_id, sequence, log_time: log_time_ns, publish_time: publish_time_ns };
        Ok(mcap.write_to_known_channel(&header, payload)?)
    }

    /// Closes the chunk and hands all to the operating system: from here on a killed recorder loses nothing of it.
    pub fn flush(&mut self) -> anyhow::Result<()> {
        Ok(self.mcap.as_mut().context("the recording has ended")?.flush()?)
    }

    /// Writes the index, so that readers may seek, and closes the file.
    pub fn finish(mut self) -> anyhow::Result<()> {
        let mut mcap = self.mcap.take().context("the recording has ended")?;
        let finished = mcap.finish();
        let file = mcap.into_inner();
        finished?;
        file.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()?;
        Ok(())
    }
}

impl Drop for RecordingWriter {
    fn drop(&mut self) {
        // The crate's own drop would write on, and panic on a full disk.
        if let Some(mcap) = self.mcap.take() {
            drop(mcap.into_inner());
        }
    }
}

/// When a message was, and its place in its stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MessageTimes {
    /// `Header.seq`, its low 32 bits.
    pub sequence: u32,
    /// Wall clock when it came in, ns since 1970.
    pub log_time_ns: u64,
    /// Wall clock when it was made, ns since 1970.
    pub publish_time_ns: u64,
}

/// What tools that do not know Sturz may want to know of a channel.
fn channel_facts(message: &str) -> BTreeMap<String, String> {
    match message {
        "Info" | "Features" | "Plan" | "Shapes" => BTreeMap::new(),
        _ => BTreeMap::from([("simulated_time_s".into(), "header.sim_time_s".into())]),
    }
}
