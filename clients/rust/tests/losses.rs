//! Daemons and clients that vanish or stop, each as seen by the other side; all with the real daemon.

mod common;

use std::env;
use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use common::{Daemon, SOON, folder, scene, short_lease, signal};
use sturz_client::v1::{ErrorCode, EventKind, RunState, Severity};
use sturz_client::{ClientError, Loss, Simulation, Target, Window};

fn wait_for(simulation: &Simulation, state: RunState) {
    let deadline = Instant::now() + SOON;
    while simulation.info().unwrap().state() != state {
        assert!(Instant::now() < deadline, "{state:?} never came");
        thread::sleep(Duration::from_millis(5));
    }
}

fn loss<T: std::fmt::Debug>(answer: Result<T, ClientError>) -> Loss {
    match answer {
        Err(ClientError::DaemonGone { loss, .. }) => loss,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_killed_daemon_has_died_and_the_same_client_goes_on_with_the_next() {
    let mut daemon = Daemon::start("died");
    let (endpoint, simulation) = (daemon.endpoint.clone(), daemon.connect());
    let first = simulation.info().unwrap();
    let waiting = simulation.clone();
    let window = thread::spawn(move || waiting.advance(Window::new(1e4)));
    wait_for(&simulation, RunState::Advancing);
    daemon.kill();
    assert_eq!(loss(window.join().unwrap()), Loss::Died);
    let error = simulation.info().unwrap_err();
    assert!(error.to_string().contains("has ended or was killed"), "{error}");
    assert!(matches!(simulation.reconnect(Duration::ZERO), Err(ClientError::NobodyListens { .. })));
    drop(daemon);

    let next = Daemon::serve_at("died", &endpoint, scene(), &[]);
    let again = simulation.reconnect(SOON).unwrap();
    let info = again.info().unwrap();
    assert_eq!(info.pid, next.pid());
    assert_ne!(info.run_id, first.run_id, "another run, and the client can tell");
    again.acquire_lease().unwrap();
    assert_eq!(again.step(1).unwrap().step, 1);
    assert_eq!(loss(simulation.info()), Loss::Died, "the old connection stays what it is");
}

#[test]
fn a_stopped_daemon_hangs_and_after_it_goes_on_so_does_the_client() {
    let config = short_lease(&folder("hung-config"));
    let daemon = Daemon::serve("hung", scene(), &["--config", config.to_str().unwrap()]);
    let simulation = daemon.connect();
    simulation.acquire_lease().unwrap();
    let run_id = simulation.info().unwrap().run_id;
    let mut events = simulation.events().unwrap();
    let (waiting, asking) = (simulation.clone(), simulation.clone());
    let window = thread::spawn(move || waiting.advance(Window::new(1e4)));
    wait_for(&simulation, RunState::Advancing);
    signal(daemon.pid(), "STOP");
    // Whoever waits is told, without a time limit of its own; and whoever asks now.
    let question = thread::spawn(move || asking.with_timeout(Duration::from_secs(3600)).info());
    assert_eq!(loss(window.join().unwrap()), Loss::Hung);
    assert_eq!(loss(question.join().unwrap()), Loss::Hung);
    let ended = loop {
        match events.next_within(SOON) {
            Ok(_) => {}
            Err(error) => break error,
        }
    };
    assert!(ended.to_string().contains("answers nothing"), "{ended}");
    assert!(matches!(simulation.reconnect(Duration::ZERO), Err(ClientError::Silent { .. })));

    signal(daemon.pid(), "CONT");
    let again = simulation.reconnect(SOON).unwrap();
    // The daemon takes the silence of the client that gave it up for its end: the lease is lost, and the run waits.
    wait_for(&again, RunState::Paused);
    let info = again.info().unwrap();
    assert_eq!((info.run_id, info.lease_holder.as_str()), (run_id, ""));
    again.acquire_lease().unwrap();
    assert_eq!(again.step(1).unwrap().step, info.step + 1);
}

/// Set for the process that [`a_stopped_holder_pauses_the_run_and_comes_back`] starts.
const HOLD: &str = "STURZ_TEST_HOLD_LEASE_AND_RETURN";

/// A process with a lease of its own, and what it prints.
struct Holder {
    process: Child,
    lines: mpsc::Receiver<String>,
}

impl Holder {
    fn start(daemon: &Daemon, config: &str) -> Self {
        let mut process = Command::new(env::current_exe().unwrap())
            .args(["--exact", "--nocapture", "a_stopped_holder_pauses_the_run_and_comes_back"])
            .env(HOLD, format!("{} {} {config}", daemon.instance, daemon.endpoint))
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let stdout = BufReader::new(process.stdout.take().unwrap());
        let (sender, lines) = mpsc::channel();
        thread::spawn(move || stdout.lines().map_while(Result::ok).for_each(|line| drop(sender.send(line))));
        Self { process, lines }
    }

    fn wait_for(&self, text: &str) {
        while !self.lines.recv_timeout(SOON).expect("the holder says it in time").contains(text) {}
    }
}

impl Drop for Holder {
    fn drop(&mut self) {
        drop(self.process.kill());
        drop(self.process.wait());
    }
}

/// Holds the lease and lets time go on until the connection is lost; then comes back.
fn hold(target: &str) {
    let words: Vec<&str> = target.split(' ').collect();
    let target = Target::new(words[1]).with_config(words[2]);
    let simulation = Simulation::connect_to(words[0], &target, SOON).unwrap();
    simulation.acquire_lease().unwrap();
    simulation.resume().unwrap();
    println!("holding");
    while simulation.info().is_ok() {
        thread::sleep(Duration::from_millis(5));
    }
    assert!(matches!(simulation.info(), Err(ClientError::DaemonGone { .. })));
    let again = simulation.reconnect(SOON).unwrap();
    again.acquire_lease().unwrap();
    println!("back at step {}", again.step(1).unwrap().step);
}

#[test]
fn a_stopped_holder_pauses_the_run_and_comes_back() {
    if let Ok(target) = env::var(HOLD) {
        return hold(&target);
    }
    let config = short_lease(&folder("stopped-config"));
    let daemon = Daemon::start("stopped-client");
    let other = daemon.connect();
    let mut events = other.events().unwrap();
    let holder = Holder::start(&daemon, config.to_str().unwrap());
    holder.wait_for("holding");
    assert_eq!(other.step(1).unwrap_err().refusal().unwrap().code, ErrorCode::Lease);
    signal(holder.process.id(), "STOP");
    wait_for(&other, RunState::Paused);
    let lost = loop {
        let event = events.next_within(SOON).unwrap();
        if event.kind() == EventKind::Lease && event.severity() == Severity::Warning {
            break event;
        }
    };
    assert!(lost.message.contains("was lost") && lost.name.starts_with("rust-"), "{lost:?}");
    // Meanwhile others may go on.
    other.step(1).unwrap();
    signal(holder.process.id(), "CONT");
    holder.wait_for("back at step");
}
