//! The lease against the real daemon: one client lets time go on, others observe, and its loss pauses the run.

mod common;

use std::env;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{Daemon, SOON};
use sturz_client::v1::{ErrorCode, EventKind, RunState};
use sturz_client::{ClientError, Loads, Refusal, Simulation, Window, v1};

fn refusal<T: std::fmt::Debug>(answer: Result<T, ClientError>) -> Refusal {
    answer.unwrap_err().refusal().cloned().expect("refused by the daemon")
}

fn wait_for(simulation: &Simulation, state: RunState) {
    let deadline = Instant::now() + SOON;
    while simulation.info().unwrap().state() != state {
        assert!(Instant::now() < deadline, "{state:?} never came");
        thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn others_observe_and_may_stop_it_but_not_let_time_go_on() {
    let daemon = Daemon::start("lease");
    let (holder, other) = (daemon.connect(), daemon.connect());
    other.step(1).unwrap();
    other.checkpoint("a").unwrap();
    holder.acquire_lease().unwrap();
    holder.acquire_lease().unwrap();
    let name = other.info().unwrap().lease_holder;
    assert!(name.starts_with("rust-"), "{name}");

    let held = |refused: Refusal| {
        assert_eq!(refused.code, ErrorCode::Lease);
        assert!(refused.message.contains(&name), "{refused}");
    };
    held(refusal(other.step(1)));
    held(refusal(other.advance(Window::new(1e-4))));
    held(refusal(other.resume()));
    held(refusal(other.restore("a")));
    held(refusal(other.set_loads(Loads::default())));
    held(refusal(other.acquire_lease()));
    held(refusal(other.release_lease()));
    assert_eq!(other.info().unwrap().step, 1);
    other.set_gravity([0.0, 0.0, -1.0]).unwrap();

    holder.clone().step(1).unwrap();
    holder.resume().unwrap();
    wait_for(&other, RunState::Running);
    other.pause().unwrap();
    holder.release_lease().unwrap();
    assert_eq!(refusal(holder.release_lease()).code, ErrorCode::Lease);
    other.step(1).unwrap();
    other.acquire_lease().unwrap();
    held_by_other(&holder);
}

fn held_by_other(simulation: &Simulation) {
    assert_eq!(refusal(simulation.step(1)).code, ErrorCode::Lease);
}

#[test]
fn a_holder_that_leaves_pauses_the_run_and_another_may_go_on() {
    let daemon = Daemon::start("lease-lost");
    let (holder, other) = (daemon.connect(), daemon.connect());
    let mut events = other.events().unwrap();
    holder.acquire_lease().unwrap();
    holder.resume().unwrap();
    wait_for(&other, RunState::Running);
    drop(holder);
    wait_for(&other, RunState::Paused);
    assert_eq!(other.info().unwrap().lease_holder, "");
    let mut lost = None;
    while lost.is_none() {
        let event = events.next_within(SOON).unwrap();
        lost = (event.kind() == EventKind::Lease && event.severity() == v1::Severity::Warning).then_some(event);
    }
    let lost = lost.unwrap();
    assert!(lost.message.contains("was lost") && lost.name.starts_with("rust-"), "{lost:?}");
    assert_eq!(events.next_within(SOON).unwrap().kind(), EventKind::Paused);
    other.acquire_lease().unwrap();
    other.step(1).unwrap();
}

/// Set for the process that [`a_killed_holder_ends_its_window`] starts.
const HOLD: &str = "STURZ_TEST_HOLD_LEASE";

/// A process of its own that is killed in the midst of its window: what it asked for ends, and says why.
#[test]
fn a_killed_holder_ends_its_window() {
    if let Ok(target) = env::var(HOLD) {
        let (instance, endpoint) = target.split_once(' ').unwrap();
        let simulation = Simulation::connect(instance, endpoint, SOON).unwrap();
        simulation.acquire_lease().unwrap();
        drop(simulation.advance(Window::new(1e4)));
        return;
    }
    let daemon = Daemon::start("lease-killed");
    let other = daemon.connect();
    let mut holder = Command::new(env::current_exe().unwrap())
        .args(["--exact", "a_killed_holder_ends_its_window"])
        .env(HOLD, format!("{} {}", daemon.instance, daemon.endpoint))
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    wait_for(&other, RunState::Advancing);
    assert_eq!(refusal(other.step(1)).code, ErrorCode::Lease);
    holder.kill().unwrap();
    holder.wait().unwrap();
    wait_for(&other, RunState::Paused);
    assert!(other.info().unwrap().step > 0);
    other.step(1).unwrap();
}

#[test]
fn a_client_without_a_token_gets_no_lease() {
    let daemon = Daemon::start("lease-token");
    let simulation = daemon.connect();
    let acquire = |client_id: &str| {
        let header = v1::CommandHeader { client_id: client_id.into(), ..Default::default() };
        let request = sturz_client::Request::AcquireLease(v1::AcquireLeaseRequest { header: Some(header) });
        refusal(simulation.command(request, Some(SOON)))
    };
    let unseen = acquire("somebody");
    assert_eq!((unseen.code, unseen.path.as_str()), (ErrorCode::Lease, "header.client_id"));
    assert!(unseen.message.contains("liveliness token"), "{unseen}");
    assert_eq!(acquire("a/b").code, ErrorCode::InvalidInput);
}
