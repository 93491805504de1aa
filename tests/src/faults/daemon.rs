//! A daemon that is started, killed and taken up again.

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::Duration;
use std::{env, fs, thread};

use anyhow::{Context as _, ensure};
use sturz_client::Simulation;

/// For anything that a daemon should do at once, on a busy machine.
pub const SOON: Duration = Duration::from_secs(60);

/// Ends with the value.
pub struct Daemon {
    process: Child,
    /// Where it listens.
    pub endpoint: String,
    /// Its name.
    pub instance: String,
}

/// The program: `STURZ_BINARY`, or the one beside this one.
pub fn binary() -> anyhow::Result<PathBuf> {
    let here = env::current_exe()?;
    // A program lies beside it, a test in the folder below.
    let beside = here.ancestors().skip(1).take(2).map(|folder| folder.join("sturz")).find(|path| path.is_file());
    let path = env::var_os("STURZ_BINARY").map(PathBuf::from).or(beside);
    path.context("there is no daemon: build it with `cargo build --release --locked --workspace`, or set STURZ_BINARY")
}

impl Daemon {
    /// Runs `sturz serve` with these arguments, and waits until it serves.
    pub fn serve<S: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = S>) -> anyhow::Result<Self> {
        let mut process = Command::new(binary()?)
            .arg("serve")
            .args(arguments)
            .args(["--listen", "tcp/127.0.0.1:0", "--stop-on-stdin-eof", "--json", "--log", "error"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let stdout = BufReader::new(process.stdout.take().context("its standard output is a pipe")?);
        let (sender, lines) = mpsc::channel();
        // Reads to the end: a full pipe would block the daemon.
        thread::spawn(move || stdout.lines().map_while(Result::ok).for_each(|line| drop(sender.send(line))));
        let mut daemon = Self { process, endpoint: String::new(), instance: String::new() };
        let line = lines.recv_timeout(SOON).context("the daemon does not serve; its messages are above")?;
        let json = line.strip_prefix("ready ").context("the first line is `ready`")?;
        let ready: serde_json::Value = serde_json::from_str(json)?;
        let text = |name: &str| ready[name].as_str().map(String::from).with_context(|| format!("ready has no {name}"));
        (daemon.endpoint, daemon.instance) = (text("endpoint")?, text("instance")?);
        Ok(daemon)
    }

    /// A connection to it.
    pub fn connect(&self) -> anyhow::Result<Simulation> {
        Ok(Simulation::connect(&self.instance, &self.endpoint, SOON)?.with_timeout(SOON))
    }

    /// `SIGKILL`.
    pub fn kill(&mut self) -> anyhow::Result<()> {
        self.process.kill()?;
        self.process.wait()?;
        Ok(())
    }

    /// Of the process.
    pub fn pid(&self) -> u32 {
        self.process.id()
    }

    /// CPU time of all its threads so far, s.
    pub fn cpu_s(&self) -> anyhow::Result<f64> {
        cpu_s(&self.pid().to_string())
    }

    /// Largest memory that the process has had, bytes.
    pub fn peak_bytes(&self) -> anyhow::Result<u64> {
        let status = fs::read_to_string(format!("/proc/{}/status", self.pid()))?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).context("VmHWM")?;
        let kilobytes: u64 = line.trim().trim_end_matches(" kB").parse()?;
        Ok(1024 * kilobytes)
    }
}

/// CPU time of all threads of this process so far, s.
pub fn own_cpu_s() -> anyhow::Result<f64> {
    cpu_s("self")
}

/// Threads that have ended included; in hundredths of a second, as the kernel tells it.
fn cpu_s(process: &str) -> anyhow::Result<f64> {
    let text = fs::read_to_string(format!("/proc/{process}/stat"))?;
    // The second field is the program's name in brackets, which may hold blanks; user and system time are 14 and 15.
    let fields = text.rsplit_once(')').context("stat has a name")?.1.split_whitespace();
    let ticks: f64 = fields.skip(11).take(2).map(|field| field.parse::<f64>().unwrap_or(f64::NAN)).sum();
    Ok(ticks / 100.0)
}

impl Drop for Daemon {
    fn drop(&mut self) {
        drop(self.process.kill());
        drop(self.process.wait());
    }
}

/// A folder that is removed with the value.
pub struct Folder(PathBuf);

impl Folder {
    /// Empty, under the folder for temporary files.
    pub fn new(name: &str) -> anyhow::Result<Self> {
        let path = env::temp_dir().join(format!("sturz-faults-{name}-{}", std::process::id()));
        drop(fs::remove_dir_all(&path));
        fs::create_dir_all(&path)?;
        Ok(Self(path))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Something in it, as an argument.
    pub fn join(&self, name: &str) -> String {
        self.0.join(name).to_string_lossy().into_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        drop(fs::remove_dir_all(&self.0));
    }
}

/// What `sturz replay` says of a journal; an error when it is not content.
pub fn replay(journal: &Path, threads: u32) -> anyhow::Result<serde_json::Value> {
    let threads = threads.to_string();
    let output = Command::new(binary()?).arg("replay").arg(journal).args(["--json", "--threads", &threads]).output()?;
    ensure!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr).trim());
    Ok(serde_json::from_slice(&output.stdout)?)
}
