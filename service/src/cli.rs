//! The command line as types. What each command does is in [`crate::commands`].

mod recordings;
mod settings;
mod study;
mod watching;

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand};

use crate::journal::{Fsync, Keep};
pub use recordings::{Encoding, Export, ExportPart, Fields, Play, Record, RecordTopic};
pub use settings::{Effective, Source, check_file, parse};
pub use study::Study;
pub use watching::{Inspect, Top};

/// What the exit codes mean, for `--help`.
const EXIT_CODES: &str = "\
Exit codes:
    0  done
    1  something else went wrong
    2  the command line cannot be used
    3  the scene cannot be used
    4  the run failed: a step was refused; a replay: it differs
    5  the daemon cannot listen, or its name is taken
    6  no daemon answers
  130  a run was interrupted";

/// Granular matter of non-spherical particles, as a service on a message bus.
#[derive(Debug, Parser)]
#[command(name = "sturz", version, after_help = EXIT_CODES)]
pub struct Arguments {
    /// What to log, as in `info,zenoh=warn`
    #[arg(long, global = true, env = "STURZ_LOG", default_value = "info,zenoh=error", value_name = "FILTER")]
    pub log: String,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// Commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Serve a scene on the bus until Ctrl-C, SIGTERM or the command `stop`
    Serve(Box<Serve>),
    /// Run a scene to its end without a bus, and report how good it was
    Run(Run),
    /// Run a scene over a grid of settings: error against run time, and the cheapest setting for an error
    Study(Box<Study>),
    /// Run a scene through its stages and write a checkpoint that later scenes start from
    Prepare(Prepare),
    /// Tell what a scene needs, its time scales, and every doubt about it
    Check(Check),
    /// List the bundled scenes, or print one
    Scenes(Scenes),
    /// Make certificates for a lab: an authority, the daemon's, those of clients and their roles
    Certs(Certs),
    /// Show what a running daemon says of itself
    Inspect(Inspect),
    /// Watch a running daemon: time, speed, stages, energy, streams, anew each second
    Top(Top),
    /// Go through a journal again and compare every outcome and every state in it
    Replay(Replay),
    /// Write down what a running daemon says, as an MCAP file
    Record(Record),
    /// Serve a recording on the bus, as if its simulation ran
    Play(Play),
    /// Write a recording, a running daemon or a run as VTK files
    Export(Export),
    /// Compute coarse-grained fields from the states and contacts of a recording
    Fields(Fields),
    /// Print the JSON schema of scene files
    Schema,
}

/// Where a scene comes from.
#[derive(Clone, Debug, Args)]
pub struct SceneArgument {
    /// Name of a bundled scene (see `sturz scenes`) or path of a scene file
    #[arg(value_name = "SCENE")]
    pub scene: String,
}

/// `sturz serve`
#[derive(Debug, Args)]
pub struct Serve {
    /// Name of a bundled scene (see `sturz scenes`) or path of a scene file
    #[arg(value_name = "SCENE", required_unless_present_any = ["resume", "show_settings"], conflicts_with = "resume")]
    pub scene: Option<String>,
    /// A TOML file with settings under the names of these flags; flags and environment win over it
    #[arg(long, env = "STURZ_SETTINGS", value_name = "FILE")]
    pub settings: Option<PathBuf>,
    /// Print the settings in force, each with its source, as such a file, and end
    #[arg(long)]
    pub show_settings: bool,
    /// Name on the bus; that of the scene file when absent
    #[arg(long, env = "STURZ_NAME")]
    pub name: Option<String>,
    /// Endpoint to listen on, such as tcp/127.0.0.1:7447, or `auto` for a free loopback port; may be repeated
    #[arg(long, env = "STURZ_LISTEN", value_name = "ENDPOINT", help_heading = "Bus")]
    pub listen: Vec<String>,
    /// Endpoint of a router or another peer to connect to; may be repeated
    #[arg(long, value_name = "ENDPOINT", help_heading = "Bus")]
    pub connect: Vec<String>,
    /// A zenoh configuration file to start from
    #[arg(long, value_name = "FILE", help_heading = "Bus")]
    pub config: Option<PathBuf>,
    /// Folder of certificates (see `sturz certs`): clients need one, and may do what their role allows
    #[arg(long, env = "STURZ_TLS", value_name = "DIR", help_heading = "Bus")]
    pub tls: Option<PathBuf>,
    /// Allow endpoints that other machines can reach: whoever reaches them can steer
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true", action = ArgAction::Set, value_name = "BOOL", help_heading = "Bus")]
    pub insecure: bool,
    /// Address at which Prometheus finds the report, by HTTP: such as 127.0.0.1:9464; port 0 for a free one
    #[arg(long, env = "STURZ_METRICS", value_name = "ADDRESS")]
    pub metrics: Option<SocketAddr>,
    /// A TOML file with limits on what clients may ask for
    #[arg(long, value_name = "FILE", help_heading = "Bus")]
    pub limits: Option<PathBuf>,
    /// Folder for a journal of the run; made, must hold none. With it the run survives this process: --resume goes on
    #[arg(long, env = "STURZ_JOURNAL", value_name = "DIR", help_heading = "What is kept")]
    pub journal: Option<PathBuf>,
    /// Go on with the run of this journal: newest sound snapshot, then every accepted command behind it
    #[arg(long, value_name = "DIR", conflicts_with_all = ["journal", "checkpoints", "restore"], help_heading = "What is kept")]
    pub resume: Option<PathBuf>,
    /// When the journal is forced to the disk: once a `second` (survives the death of the process) or before each reply to a
    /// `command` (survives the loss of power too)
    #[arg(long, value_enum, default_value_t, value_name = "WHEN", help_heading = "What is kept")]
    pub journal_fsync: Fsync,
    /// Bytes of log from which on what the snapshots do not need is removed, or `all`: keep it whole, for `sturz replay`
    #[arg(long, default_value = "1073741824", value_parser = keep, value_name = "BYTES", help_heading = "What is kept")]
    pub journal_keep: Keep,
    /// Folder for checkpoints on disk; made if need be. Those that are there can be restored. With a journal: that in its folder
    #[arg(
        long,
        env = "STURZ_CHECKPOINTS",
        value_name = "DIR",
        conflicts_with = "journal",
        help_heading = "What is kept"
    )]
    pub checkpoints: Option<PathBuf>,
    /// Save the state in each such interval of wall time, s. With a journal: as a snapshot (60 s unless given). Else in the folder
    /// of --checkpoints; the last two are kept, as `auto-<step>`
    #[arg(long, value_name = "SECONDS", help_heading = "What is kept")]
    pub checkpoint_every: Option<f64>,
    /// Start from the checkpoint of this token instead of at step 0; `newest`: from the one with the most steps
    #[arg(long, value_name = "TOKEN", help_heading = "What is kept")]
    pub restore: Option<String>,
    /// Start with the bed of this file, which `sturz prepare` has written, instead of the scene's `[start]`
    #[arg(long, value_name = "FILE", conflicts_with_all = ["resume", "restore"], help_heading = "What is kept")]
    pub from: Option<PathBuf>,
    /// Threads of the physics
    #[arg(long, env = "STURZ_THREADS", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Wait for commands instead of stepping at once
    #[arg(long, num_args = 0..=1, require_equals = true, default_value_t = false, default_missing_value = "true", action = ArgAction::Set, value_name = "BOOL")]
    pub paused: bool,
    /// End when standard input does: with whoever started this process
    #[arg(long)]
    pub stop_on_stdin_eof: bool,
    /// Print one line `ready {...}` for programs once clients can connect
    #[arg(long)]
    pub json: bool,
    /// All settings, with their sources.
    #[arg(skip)]
    pub effective: Effective,
}

fn keep(text: &str) -> Result<Keep, String> {
    if text == "all" {
        return Ok(Keep::All);
    }
    text.parse().map(Keep::Bytes).map_err(|_| "a number of bytes, or `all`".into())
}

/// `sturz replay`
#[derive(Debug, Args)]
pub struct Replay {
    /// Folder of the journal
    #[arg(value_name = "DIR")]
    pub journal: PathBuf,
    /// Threads of the physics
    #[arg(long, env = "STURZ_THREADS", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `sturz run`
#[derive(Debug, Args)]
pub struct Run {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Simulated time at which to end, s; the scene's `[stop] time_s` when absent
    #[arg(long, value_name = "SECONDS")]
    pub time: Option<f64>,
    /// Start with the bed of this file, which `sturz prepare` has written, instead of the scene's `[start]`
    #[arg(long, value_name = "FILE")]
    pub from: Option<PathBuf>,
    /// Threads of the physics
    #[arg(long, env = "STURZ_THREADS", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Print the report as JSON, and no progress
    #[arg(long)]
    pub json: bool,
}

/// `sturz prepare`
#[derive(Debug, Args)]
pub struct Prepare {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgument,
    /// File to write; replaced if it is there
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Simulated time at which to end, s, if the stages are not over before; the scene's `[stop] time_s` when absent
    #[arg(long, value_name = "SECONDS")]
    pub until: Option<f64>,
    /// Start with the bed of this file, which `sturz prepare` has written, instead of the scene's `[start]`
    #[arg(long, value_name = "FILE")]
    pub from: Option<PathBuf>,
    /// Threads of the physics
    #[arg(long, env = "STURZ_THREADS", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: u16,
    /// Print what was written as JSON, and no progress
    #[arg(long)]
    pub json: bool,
}

/// `sturz check`
#[derive(Debug, Args)]
pub struct Check {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `sturz scenes`
#[derive(Debug, Args)]
pub struct Scenes {
    /// Print this one instead of the list
    pub name: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `sturz certs`
#[derive(Debug, Args)]
pub struct Certs {
    /// Folder of the authority; made if need be, else added to
    pub folder: PathBuf,
    /// Name of the lab, for the authority's certificate
    #[arg(long, default_value = "lab", value_name = "NAME")]
    pub name: String,
    /// Name or address by which clients reach the daemon, apart from localhost; may be repeated
    #[arg(long, value_name = "HOST")]
    pub host: Vec<String>,
    /// A client and its role (view, steer or admin), such as alice:steer; may be repeated
    #[arg(long, value_name = "NAME:ROLE")]
    pub client: Vec<String>,
    /// Take the role from a client; may be repeated. A daemon must be started again to know
    #[arg(long, value_name = "NAME")]
    pub revoke: Vec<String>,
    /// How long the certificates hold, days
    #[arg(long, default_value_t = 365, value_parser = clap::value_parser!(u32).range(1..=36500))]
    pub days: u32,
    /// Replace the certificates of the clients named, and with --host the daemon's; never the authority's
    #[arg(long)]
    pub force: bool,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }
}
