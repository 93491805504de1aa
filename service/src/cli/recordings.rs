//! `sturz record`, `sturz play`, `sturz export`, `sturz fields`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::config::DEFAULT_LISTEN;

/// What can be recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RecordTopic {
    /// Particles and boundaries
    State,
    /// Coarse-grained fields
    Fields,
    /// Energy, overlap, costs
    Report,
    /// Commands that were put, state of the run, particles, fields, checkpoints
    Events,
    /// The contact network: each frame of it costs the physics its collection
    Contacts,
}

/// `sturz record`
#[derive(Debug, Args)]
pub struct Record {
    /// Name on the bus; not needed where only one daemon is alive
    pub name: Option<String>,
    /// The recording: an MCAP file, which must not exist yet
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// What to record, separated by commas
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "state,fields,report,events",
        value_name = "TOPICS"
    )]
    pub topics: Vec<RecordTopic>,
    /// End after this wall time, s
    #[arg(long = "for", value_name = "SECONDS")]
    pub duration_s: Option<f64>,
    /// End at this simulated time, s
    #[arg(long, value_name = "SECONDS")]
    pub until_sim: Option<f64>,
    /// Do not compress
    #[arg(long)]
    pub uncompressed: bool,
    /// Messages beyond this many bytes that wait for the disk are left out, MB
    #[arg(long, value_name = "MB", default_value_t = 256)]
    pub queue_mb: u32,
    /// Where the daemon listens
    #[arg(long, env = "STURZ_ENDPOINT", default_value = DEFAULT_LISTEN, value_name = "ENDPOINT")]
    pub endpoint: String,
    /// A zenoh configuration file to start from
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Folder with the certificate of this client, such as LAB/clients/NAME
    #[arg(long, value_name = "DIR")]
    pub tls: Option<PathBuf>,
    /// Print a line `ready {...}` when it listens, and the summary as JSON
    #[arg(long)]
    pub json: bool,
}

/// `sturz play`
#[derive(Debug, Args)]
pub struct Play {
    /// The recording
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Name on the bus; that of the recorded instance when absent
    #[arg(long)]
    pub name: Option<String>,
    /// Simulated seconds per wall second, or `max`
    #[arg(long, default_value = "1", value_name = "X")]
    pub speed: String,
    /// Begin again at the end
    #[arg(long = "loop")]
    pub repeat: bool,
    /// Wait for the command `resume` before the first frame is followed by others
    #[arg(long)]
    pub paused: bool,
    /// End with the recording, instead of going on answering with its last state
    #[arg(long, conflicts_with = "repeat")]
    pub exit_at_end: bool,
    /// Endpoint to listen on, such as tcp/127.0.0.1:7447, or `auto` for a free loopback port; may be repeated
    #[arg(long, value_name = "ENDPOINT", help_heading = "Bus")]
    pub listen: Vec<String>,
    /// Endpoint of a router or another peer to connect to; may be repeated
    #[arg(long, value_name = "ENDPOINT", help_heading = "Bus")]
    pub connect: Vec<String>,
    /// A zenoh configuration file to start from
    #[arg(long, value_name = "FILE", help_heading = "Bus")]
    pub config: Option<PathBuf>,
    /// Allow endpoints that other machines can reach
    #[arg(long, help_heading = "Bus")]
    pub insecure: bool,
    /// End when standard input does: with whoever started this process
    #[arg(long)]
    pub stop_on_stdin_eof: bool,
    /// Print one line `ready {...}` for programs once clients can connect
    #[arg(long)]
    pub json: bool,
}

/// What can be exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ExportPart {
    /// Surfaces of the particles, or points with --glyphs: .vtp
    Particles,
    /// The contact network as lines: .vtp
    Contacts,
    /// Coarse-grained fields: .vti
    Fields,
    /// Walls where they are then: .vtp
    Boundaries,
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Encoding {
    /// Appended, base64, compressed with zlib
    #[default]
    Compressed,
    /// Appended, base64
    Base64,
    /// Text
    Ascii,
}

/// `sturz export`
#[derive(Debug, Args)]
pub struct Export {
    /// A recording (.mcap), the name of a running daemon, or with --time or --checkpoint a scene: run here, without a bus
    #[arg(value_name = "SOURCE")]
    pub source: String,
    /// Folder to write to; made if need be
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// What to write, separated by commas; all that there is when absent
    #[arg(long, value_enum, value_delimiter = ',')]
    pub what: Vec<ExportPart>,
    /// Least simulated time between two frames, s; of a scene that is run, the time between two frames
    #[arg(long, value_name = "SECONDS")]
    pub every: Option<f64>,
    /// Only each N-th frame of a recording or daemon
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..), conflicts_with = "every")]
    pub stride: Option<u64>,
    /// The first frame at or after each of these simulated times, s, separated by commas
    #[arg(long, value_delimiter = ',', value_name = "SECONDS", conflicts_with_all = ["every", "stride"])]
    pub times: Vec<f64>,
    /// Particles as points with orientation and radius, to draw as glyphs, instead of their surfaces
    #[arg(long)]
    pub glyphs: bool,
    /// How numbers are written
    #[arg(long, value_enum, default_value_t)]
    pub encoding: Encoding,
    /// Floats of 64 bits instead of 32
    #[arg(long)]
    pub f64: bool,
    /// Run the scene to this simulated time, s
    #[arg(long, value_name = "SECONDS", help_heading = "Scene")]
    pub time: Option<f64>,
    /// Start the scene from this checkpoint file
    #[arg(long, value_name = "FILE", help_heading = "Scene")]
    pub checkpoint: Option<PathBuf>,
    /// Threads of the physics
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024), help_heading = "Scene")]
    pub threads: u16,
    /// Write each frame that the daemon publishes until it ends, or Ctrl-C, instead of the state of now
    #[arg(long, help_heading = "Daemon")]
    pub follow: bool,
    /// Where the daemon listens
    #[arg(long, env = "STURZ_ENDPOINT", default_value = DEFAULT_LISTEN, value_name = "ENDPOINT", help_heading = "Daemon")]
    pub endpoint: String,
    /// A zenoh configuration file to start from
    #[arg(long, value_name = "FILE", help_heading = "Daemon")]
    pub config: Option<PathBuf>,
    /// Folder with the certificate of this client, such as LAB/clients/NAME
    #[arg(long, value_name = "DIR")]
    pub tls: Option<PathBuf>,
    /// Print what was written as JSON
    #[arg(long)]
    pub json: bool,
}

/// `sturz fields`
#[derive(Debug, Args)]
pub struct Fields {
    /// The recording
    #[arg(value_name = "RECORDING")]
    pub recording: PathBuf,
    /// CSV file to write, a row per cell, width and time; standard output when absent
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Grid as MIN:MAX:CELLS, such as 0,0,0:0.1,0.1,0.2:1,1,40; one cell along an axis averages over it
    #[arg(long, value_name = "GRID", allow_hyphen_values = true, required_unless_present_any = ["define", "field"])]
    pub grid: Option<String>,
    /// Names of quantities, separated by commas: density, velocity, contact_stress, ...
    #[arg(long, value_delimiter = ',', value_name = "NAMES", requires = "grid")]
    pub quantities: Vec<String>,
    /// Width of the kernel, m; several, separated by commas, are sampled in one pass
    #[arg(long, value_delimiter = ',', value_name = "METRES", requires = "grid")]
    pub width: Vec<f64>,
    /// gaussian, lucy or heaviside
    #[arg(long, default_value = "gaussian", value_name = "KERNEL", requires = "grid")]
    pub kernel: String,
    /// Support of the kernel over its width
    #[arg(long, default_value_t = 4.0, value_name = "X", requires = "grid")]
    pub cutoff_widths: f64,
    /// Give what plane walls cut off a kernel back to its part in front of them
    #[arg(long, requires = "grid")]
    pub wall_correction: bool,
    /// A definition as in a `[[field]]` of a scene file, instead of --grid: a TOML file without that heading
    #[arg(long, value_name = "FILE", conflicts_with_all = ["grid", "field"])]
    pub define: Option<PathBuf>,
    /// A field that was defined in the recorded simulation, instead of --grid
    #[arg(long, value_name = "NAME", conflicts_with = "grid")]
    pub field: Option<String>,
    /// From this simulated time on, s
    #[arg(long, default_value_t = f64::NEG_INFINITY, value_name = "SECONDS", hide_default_value = true)]
    pub from: f64,
    /// To this simulated time, s
    #[arg(long, default_value_t = f64::INFINITY, value_name = "SECONDS", hide_default_value = true)]
    pub to: f64,
    /// The mean over all states instead of each, with standard errors from this many blocks
    #[arg(long, value_name = "BLOCKS", value_parser = clap::value_parser!(u32).range(2..=1000))]
    pub mean: Option<u32>,
}
