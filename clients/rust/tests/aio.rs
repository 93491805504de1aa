//! The asynchronous client against the real daemon.

mod common;

use std::time::Duration;

use common::{Daemon, SOON};
use sturz_client::aio::Simulation;
use sturz_client::v1::{ErrorCode, EventKind, RunState, StopReason};
use sturz_client::{ClientError, FloatType, Insertion, Output, Pace, Placement, Start, Window, v1};

async fn connect(daemon: &Daemon) -> Simulation {
    Simulation::connect(&daemon.instance, &daemon.endpoint, SOON).await.unwrap().with_timeout(SOON)
}

fn bead() -> Insertion {
    Insertion::new("bead", "glass", Placement::poses(vec![[0.0, 0.0, 1.0]]))
}

/// On one thread: nothing of the client may block it, nor may zenoh see that it is one.
#[tokio::test]
async fn calls_have_the_outcomes_of_the_blocking_client() {
    let daemon = Daemon::start("aio-calls");
    let simulation = connect(&daemon).await;
    assert_eq!((simulation.instance(), simulation.is_gone()), ("aio-calls", false));
    let inserted = simulation.insert(bead()).await.unwrap();
    assert_eq!(inserted.ids, 0..1);
    simulation.acquire_lease().await.unwrap();
    simulation.set_gravity([0.0, 0.0, -1.0]).await.unwrap();
    simulation.checkpoint("a").await.unwrap();
    let first = simulation.advance(Window::new(0.01).with_columns(["positions"])).await.unwrap();
    simulation.restore("a").await.unwrap();
    let again = simulation.blocking().advance(Window::new(0.01).with_columns(["positions"])).unwrap();
    assert_eq!(
        (first.time_reached_s, first.state.unwrap().positions_m().unwrap()),
        (again.time_reached_s, again.state.unwrap().positions_m().unwrap())
    );
    assert_eq!(simulation.step(5).await.unwrap().step, 1005);
    assert_eq!(simulation.checkpoints().await.unwrap().len(), 1);
    simulation.drop_checkpoint("a").await.unwrap();
    simulation.release_lease().await.unwrap();
    let state = simulation.state(&["velocities"], FloatType::F64).await.unwrap();
    assert_eq!((state.len(), simulation.report().await.unwrap().particles), (1, 1));
    assert_eq!(simulation.shapes().await.unwrap().len(), simulation.info().await.unwrap().shapes.len());
    assert!(simulation.features().await.unwrap().commands.len() >= 19 && !simulation.plan().await.unwrap().is_empty());
    let refused = simulation.advance(Window::new(1e-5).from(Start::Step(3))).await.unwrap_err();
    assert_eq!(refused.refusal().unwrap().code, ErrorCode::WrongTime);
    let reconnected = simulation.reconnect(SOON).await.unwrap();
    assert_eq!(reconnected.remove([0]).await.unwrap().count, 1);
    reconnected.stop().await.unwrap();
    assert!(reconnected.is_gone());
}

/// A window, questions and streams at once on one thread.
#[tokio::test]
async fn streams_and_questions_go_on_beside_a_window() {
    let daemon = Daemon::start("aio-streams");
    let simulation = connect(&daemon).await;
    simulation.insert(bead()).await.unwrap();
    simulation
        .define_output(Output::new("state").with_columns(["positions"]).at(Pace::EveryWallS(1e-3)))
        .await
        .unwrap();
    let (mut states, mut events) = (simulation.states().unwrap().keeping(64), simulation.events().unwrap());
    let (window, seen) = tokio::join!(simulation.step(300_000), async {
        let mut steps = Vec::new();
        while steps.len() < 3 {
            steps.push(states.next().await.unwrap().unwrap().step());
            simulation.info().await.unwrap();
        }
        steps
    });
    assert_eq!(window.unwrap().stop_reason, StopReason::Complete);
    assert!(seen.is_sorted(), "{seen:?}");
    while events.next_within(SOON).await.unwrap().kind() != EventKind::Command {}
    assert!(states.counts().received >= 3);
    let none =
        Simulation::from(simulation.blocking().clone()).fields("none").unwrap().next_within(Duration::ZERO).await;
    assert!(matches!(none, Err(ClientError::Timeout { .. })));
}

/// Nothing goes on behind the back of who gives up waiting.
#[tokio::test]
async fn a_dropped_window_pauses_and_what_follows_comes_behind_the_pause() {
    let daemon = Daemon::start("aio-drop");
    let simulation = connect(&daemon).await;
    simulation.insert(bead()).await.unwrap();
    for k in 0..3 {
        let before = simulation.info().await.unwrap().step;
        let window = simulation.advance(Window::new(1e5));
        assert!(tokio::time::timeout(Duration::from_millis(50), window).await.is_err());
        let info = simulation.info().await.unwrap();
        assert_eq!(info.state(), RunState::Paused, "round {k}");
        assert!(info.step > before, "round {k}");
        // The client knows that it does not know the time.
        let next = simulation.advance(Window::new(1e-5)).await.unwrap();
        assert_eq!(next.step, info.step + 1);
    }
    // A window that was never polled was never sent.
    drop(simulation.advance(Window::new(1e5)));
    let steps = simulation.step(2).await.unwrap();
    assert_eq!(steps.steps_done, 2);
    // Other commands are not taken back.
    let gravity = simulation.set_gravity([0.0, 0.0, -2.0]);
    drop(tokio::time::timeout(Duration::ZERO, gravity).await);
    assert_eq!(simulation.info().await.unwrap().gravity_m_per_s2, Some(v1::Vec3 { x: 0.0, y: 0.0, z: -2.0 }));
}

#[tokio::test]
async fn commands_for_later_are_awaited() {
    let daemon = Daemon::start("aio-later");
    let simulation = connect(&daemon).await;
    let gravity = simulation.later(1e-4).set_gravity([0.0, 0.0, -3.0]).unwrap();
    assert!(!gravity.request_id().is_empty());
    assert!(matches!(gravity.wait_for(Duration::from_millis(20)).await, Err(ClientError::Timeout { .. })));
    let (stepped, applied) = tokio::join!(simulation.step(20), gravity.wait());
    assert_eq!((stepped.unwrap().steps_done, applied.unwrap().at.step), (20, 10));
}

/// A call under way, a stream and a later call all hear of the end.
#[tokio::test]
async fn the_loss_of_the_daemon_is_told_to_all_who_wait() {
    let mut daemon = Daemon::start("aio-loss");
    let simulation = connect(&daemon).await;
    let mut reports = simulation.reports().unwrap();
    while reports.latest().is_some() {}
    let waiting = tokio::spawn({
        let simulation = simulation.clone();
        async move { simulation.step(u64::MAX >> 20).await }
    });
    tokio::time::sleep(Duration::from_millis(100)).await;
    daemon.kill();
    assert!(matches!(waiting.await.unwrap(), Err(ClientError::DaemonGone { .. })));
    while reports.next().await.is_some() {}
    assert!(matches!(reports.next_within(SOON).await, Err(ClientError::DaemonGone { .. })));
    assert!(matches!(simulation.info().await, Err(ClientError::DaemonGone { .. })));
    assert!(matches!(connect_again(&simulation).await, ClientError::NobodyListens { .. }));
}

async fn connect_again(simulation: &Simulation) -> ClientError {
    simulation.reconnect(Duration::from_millis(200)).await.err().unwrap()
}
