//! Everything that reads bytes from outside, each as a target for fuzzers: whatever the bytes, there is a value or an error,
//! never a panic, and no more memory than the bytes and the limits are worth.
//!
//! `cargo fuzz` feeds them (`tests/fuzz`, `make fuzz`), and [`mutate`] does in `make test`, without a fuzzer. Where a format has
//! checksums, a target looks at the bytes as they are, and then with checksums that fit: fuzzers find what is behind them.

mod files;
mod mutate;
mod requests;
mod states;
mod texts;
mod world;

pub use mutate::{Tried, mutate};

/// A decoder, and what it usually gets.
pub struct Target {
    /// Of the program in `tests/fuzz` too.
    pub name: &'static str,
    /// What it reads.
    pub title: &'static str,
    read: fn(&[u8]),
    seeds: fn() -> anyhow::Result<Vec<Vec<u8>>>,
}

impl Target {
    /// Reads bytes; panics where the decoder does, and where what it lets through cannot be used.
    pub fn read(&self, bytes: &[u8]) {
        (self.read)(bytes);
    }

    /// Sound inputs, to begin with.
    pub fn seeds(&self) -> anyhow::Result<Vec<Vec<u8>>> {
        (self.seeds)()
    }
}

/// All targets.
pub fn registry() -> Vec<Target> {
    vec![
        Target {
            name: "request",
            title: "a command's number and its request, taken on as in the daemon, and one step",
            read: requests::read,
            seeds: requests::seeds,
        },
        Target {
            name: "checkpoint",
            title: "a checkpoint, restored into an engine, and two steps",
            read: states::read_checkpoint,
            seeds: states::checkpoints,
        },
        Target {
            name: "bed",
            title: "a prepared checkpoint, with which another scene starts",
            read: states::read_bed,
            seeds: states::beds,
        },
        Target {
            name: "journal_log",
            title: "a file of a journal's log, and the orders of its records",
            read: states::read_log,
            seeds: states::logs,
        },
        Target {
            name: "snapshot",
            title: "a journal's snapshot, loaded into a daemon's physics, and one step",
            read: states::read_snapshot,
            seeds: states::snapshots,
        },
        Target {
            name: "recording",
            title: "an MCAP file, played and exported",
            read: files::read_recording,
            seeds: files::recordings,
        },
        Target {
            name: "settings",
            title: "files of settings and of limits",
            read: texts::read_settings,
            seeds: texts::settings,
        },
        Target { name: "scene", title: "a scene file", read: texts::read_scene, seeds: texts::scenes },
        Target { name: "mesh", title: "OBJ and STL files", read: files::read_mesh, seeds: files::meshes },
        Target {
            name: "rockable",
            title: "a Rockable shape file",
            read: texts::read_rockable,
            seeds: texts::rockables,
        },
    ]
}

/// Reads bytes by the target of that name: what a fuzzer calls.
pub fn read(name: &str, bytes: &[u8]) {
    match registry().iter().find(|target| target.name == name) {
        Some(target) => target.read(bytes),
        None => panic!("there is no target {name:?}"),
    }
}
