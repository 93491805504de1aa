//! A daemon of a test's own: the real binary, on a free port, with a scene in a temporary folder.
#![allow(dead_code)]

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};
use std::{env, fs, thread};

use sturz_client::Simulation;

/// For anything that a daemon should do at once, on a busy machine.
pub const SOON: Duration = Duration::from_secs(30);

/// A bead in free fall: no walls, no contacts.
const SCENE: &str = r#"
[scene]
name = "drop"
gravity_m_per_s2 = [0.0, 0.0, -9.81]
time_step_s = 1e-5

[[material]]
name = "glass"
density_kg_per_m3 = 2500.0

[[shape]]
name = "bead"
geometry = { kind = "sphere", radius_m = 1e-3 }

[[material_pair]]
materials = ["glass", "glass"]
stiffness_n_per_m = 1e4
restitution = 0.8
"#;

/// Ends with the test.
pub struct Daemon {
    process: Child,
    folder: PathBuf,
    pub endpoint: String,
    pub instance: String,
}

/// An empty scene.
pub fn scene() -> &'static str {
    SCENE
}

/// A fresh folder of a test's own.
pub fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}", std::process::id()));
    drop(fs::remove_dir_all(&folder));
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Sends a process a signal such as `STOP`.
pub fn signal(pid: u32, name: &str) {
    let status = Command::new("kill").args([&format!("-{name}"), &pid.to_string()]).status().unwrap();
    assert!(status.success(), "kill -{name} {pid}");
}

/// A zenoh configuration file by which the other side gives this one up after a second of silence.
pub fn short_lease(folder: &Path) -> PathBuf {
    let path = folder.join("lease.json5");
    fs::write(&path, "{ transport: { link: { tx: { lease: 1000 } } } }").unwrap();
    path
}

/// Runs `sturz` to its end.
pub fn sturz(arguments: &[&str]) -> std::process::Output {
    Command::new(binary()).args(arguments).stdin(Stdio::null()).output().unwrap()
}

/// The program.
pub fn binary() -> PathBuf {
    let built = concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/release/sturz");
    let path = env::var_os("STURZ_BINARY").map_or_else(|| PathBuf::from(built), PathBuf::from);
    assert!(
        path.is_file(),
        "there is no daemon at {}: build it with `cargo build --release -p sturz-service`, or set STURZ_BINARY",
        path.display()
    );
    path
}

impl Daemon {
    /// Serves an empty scene, paused, under this name.
    pub fn start(name: &str) -> Self {
        Self::serve(name, SCENE, &[])
    }

    /// Serves a scene, paused, under this name; `more` goes to the command line.
    pub fn serve(name: &str, scene_text: &str, more: &[&str]) -> Self {
        Self::serve_at(name, "tcp/127.0.0.1:0", scene_text, more)
    }

    /// The same at this endpoint.
    pub fn serve_at(name: &str, listen: &str, scene_text: &str, more: &[&str]) -> Self {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let scene = folder.join("scene.toml");
        fs::write(&scene, scene_text).unwrap();
        let mut command = Command::new(binary());
        command.arg("serve").arg(&scene).args(["--name", name, "--paused"]).args(more);
        Self::spawn_at(command, listen, folder)
    }

    /// Goes on with the run of a journal.
    pub fn resume(journal: &Path, more: &[&str]) -> Self {
        let folder = env::temp_dir().join("sturz-resumed-has-no-folder");
        let mut command = Command::new(binary());
        command.arg("serve").arg("--resume").arg(journal).args(more);
        Self::spawn(command, folder)
    }

    /// Starts what serves, and waits until it does.
    pub fn spawn(command: Command, folder: PathBuf) -> Self {
        Self::spawn_at(command, "tcp/127.0.0.1:0", folder)
    }

    /// The same at this endpoint.
    pub fn spawn_at(mut command: Command, listen: &str, folder: PathBuf) -> Self {
        let mut process = command
            .args(["--listen", listen, "--stop-on-stdin-eof", "--json"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let stdout = BufReader::new(process.stdout.take().unwrap());
        let (sender, lines) = mpsc::channel();
        // Reads to the end: a full pipe would block the daemon.
        thread::spawn(move || stdout.lines().map_while(Result::ok).for_each(|line| drop(sender.send(line))));
        let mut daemon = Self { process, folder, endpoint: String::new(), instance: String::new() };
        loop {
            let line = lines.recv_timeout(SOON).expect("the daemon is ready in time; its stderr says why it is not");
            if let Some(json) = line.strip_prefix("ready ") {
                let ready: serde_json::Value = serde_json::from_str(json).unwrap();
                daemon.endpoint = ready["endpoint"].as_str().unwrap().into();
                daemon.instance = ready["instance"].as_str().unwrap().into();
                return daemon;
            }
        }
    }

    /// A connection to it.
    pub fn connect(&self) -> Simulation {
        Simulation::connect(&self.instance, &self.endpoint, SOON).unwrap().with_timeout(SOON)
    }

    /// Ends it without a chance to say so.
    pub fn kill(&mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }

    /// Of the process.
    pub fn pid(&self) -> u32 {
        self.process.id()
    }

    /// Waits until the process has ended of itself, and tells whether it was content.
    pub fn ended_well(&mut self) -> bool {
        let deadline = Instant::now() + SOON;
        while Instant::now() < deadline {
            if let Some(status) = self.process.try_wait().unwrap() {
                return status.success();
            }
            thread::sleep(Duration::from_millis(10));
        }
        panic!("the daemon does not end");
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        drop(self.process.kill());
        drop(self.process.wait());
        drop(fs::remove_dir_all(&self.folder));
    }
}
