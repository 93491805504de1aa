//! Fifty listeners, of which ten are stopped, ten are killed and ten come and go: what the physics notices of them.

use std::io::{BufRead as _, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs, thread};

use anyhow::{Context as _, ensure};
use sturz_client::Simulation;

use crate::cases::Checks;
use crate::faults::Size;
use crate::faults::daemon::{Daemon, Folder, SOON};
use crate::faults::script::HEAP;

/// Streams of the scene: what the issue caps them at.
const OUTPUT: &str = "[output]\nstate_rate_hz = 10.0\nreport_rate_hz = 10.0\n";
/// Memory that listeners may cost the daemon.
const MEMORY_BYTES: u64 = 512 << 20;

/// Steps with and without listeners, in turn; in the long form for an hour.
pub fn check(checks: &mut Checks, size: Size) -> anyhow::Result<()> {
    let folder = Folder::new("listeners")?;
    let scene = folder.join("scene.toml");
    fs::write(&scene, format!("{HEAP}{OUTPUT}"))?;
    let [with, without] = [0, 1].map(|_| Daemon::serve([&*scene, "--name", "crowd", "--paused"]));
    let (crowded, alone) = (with?, without?);
    let (simulation, twin) = (crowded.connect()?, alone.connect()?);
    let memory_before = crowded.peak_bytes()?;
    let (listeners, steps, soak) = match size {
        Size::Short => (10, 3_000, Duration::ZERO),
        Size::Full { soak } => (50, 100_000, soak),
    };
    let begin = Instant::now();
    let mut ratios = Vec::new();
    let mut longest_s = 0.0f64;
    while ratios.is_empty() || begin.elapsed() < soak {
        let quiet = block(&crowded, &simulation, steps)?;
        let mut crowd = Crowd::start(&crowded, listeners)?;
        crowd.trouble()?;
        let loud = block(&crowded, &simulation, steps)?;
        longest_s = longest_s.max(simulation.report()?.longest_pause_s);
        ratios.push(loud / quiet);
        drop(crowd);
        ensure!(simulation.info().is_ok(), "the daemon does not answer");
    }
    twin.step(2 * steps * ratios.len() as u64)?;
    checks.holds(
        "the state is that of the run without listeners",
        twin.info()?.state_hash == simulation.info()?.state_hash,
    );
    let grown = crowded.peak_bytes()?.saturating_sub(memory_before);
    checks.near("growth of the daemon's memory", grown as f64, 0.0, MEMORY_BYTES as f64, "byte");
    ratios.sort_by(f64::total_cmp);
    checks.shows(format!("pairs of blocks of {steps} steps"), ratios.len() as f64, "-");
    checks.shows("CPU time of the physics per step, with over without, median", ratios[ratios.len() / 2], "-");
    checks.shows("longest pause between two steps with listeners", 1e3 * longest_s, "ms");
    checks.shows("soak", begin.elapsed().as_secs_f64(), "s");
    Ok(())
}

/// CPU time of the physics' threads for some steps, ns.
fn block(daemon: &Daemon, simulation: &Simulation, steps: u64) -> anyhow::Result<f64> {
    let before = physics_ns(daemon)?;
    simulation.step(steps)?;
    Ok((physics_ns(daemon)? - before) as f64)
}

/// CPU time of the threads that step, from their scheduler statistics, ns.
fn physics_ns(daemon: &Daemon) -> anyhow::Result<u64> {
    let mut sum = 0;
    for entry in fs::read_dir(format!("/proc/{}/task", daemon.pid()))? {
        let task = entry?.path();
        if fs::read_to_string(task.join("comm"))?.starts_with("physics") {
            let statistics = fs::read_to_string(task.join("schedstat"))?;
            let on_cpu = statistics.split(' ').next().context("schedstat has the time on the CPU")?;
            sum += on_cpu.parse::<u64>()?;
        }
    }
    ensure!(sum > 0, "no thread of the physics has run");
    Ok(sum)
}

/// Processes that listen.
struct Crowd {
    processes: Vec<Child>,
    daemon: (String, String),
}

impl Crowd {
    fn start(daemon: &Daemon, listeners: usize) -> anyhow::Result<Self> {
        let mut crowd = Self { processes: Vec::new(), daemon: (daemon.endpoint.clone(), daemon.instance.clone()) };
        for _ in 0..listeners {
            crowd.come()?;
        }
        Ok(crowd)
    }

    /// One more, which listens when this returns.
    fn come(&mut self) -> anyhow::Result<()> {
        let (endpoint, instance) = &self.daemon;
        let mut process = Command::new(program()?)
            .args(["--listen", endpoint, instance])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let mut line = String::new();
        BufReader::new(process.stdout.take().context("its standard output is a pipe")?).read_line(&mut line)?;
        self.processes.push(process);
        ensure!(line == "listens\n", "a listener could not connect");
        Ok(())
    }

    /// A fifth is stopped, a fifth is killed, a fifth goes and comes again.
    fn trouble(&mut self) -> anyhow::Result<()> {
        let fifth = self.processes.len() / 5;
        for process in &self.processes[..fifth] {
            let pid = process.id().to_string();
            ensure!(Command::new("kill").args(["-STOP", &pid]).status()?.success(), "SIGSTOP");
        }
        for process in &mut self.processes[fifth..2 * fifth] {
            process.kill()?;
        }
        for k in 2 * fifth..3 * fifth {
            drop(self.processes[k].stdin.take());
            self.processes[k].wait()?;
            self.come()?;
        }
        Ok(())
    }
}

impl Drop for Crowd {
    fn drop(&mut self) {
        for process in &mut self.processes {
            drop(process.kill());
            drop(process.wait());
        }
    }
}

/// The program `faults`, which can listen too.
fn program() -> anyhow::Result<PathBuf> {
    let here = env::current_exe()?;
    let beside = here.ancestors().skip(1).take(2).map(|folder| folder.join("faults")).find(|path| path.is_file());
    beside.context("the program `faults` is not beside this one: build it")
}

/// Listens to the state until standard input ends.
pub fn listen(endpoint: &str, instance: &str) -> anyhow::Result<()> {
    let simulation = Simulation::connect(instance, endpoint, SOON)?;
    let states = simulation.states()?;
    println!("listens");
    thread::spawn(move || states.for_each(drop));
    std::io::copy(&mut std::io::stdin(), &mut std::io::sink())?;
    Ok(())
}
