//! The client against the real daemon, over a real socket.

mod common;

use std::thread;
use std::time::{Duration, Instant};

use common::{Daemon, SOON};
use sturz_client::v1::{ErrorCode, EventKind, FieldQuantity, RunState, StopReason};
use sturz_client::{
    Amount, ClientError, FieldDefinition, FloatType, Insertion, Motion, Placement, Refusal, Region, Request,
    Simulation, Start, Window, v1,
};

const G: f64 = 9.81;

fn beads(positions_m: &[[f64; 3]]) -> Insertion {
    Insertion::new("bead", "glass", Placement::poses(positions_m.to_vec()))
}

fn refusal<T: std::fmt::Debug>(answer: Result<T, ClientError>) -> Refusal {
    answer.unwrap_err().refusal().cloned().expect("refused by the daemon")
}

#[test]
fn a_bead_falls_as_galileo_says() {
    let daemon = Daemon::start("fall");
    let simulation = daemon.connect();
    let inserted = simulation
        .insert(Insertion {
            velocity_m_per_s: [0.5, 0.0, 1.0],
            angular_velocity_rad_per_s: [0.0, 0.0, 3.0],
            ..beads(&[[0.0, 0.0, 1.0], [0.1, 0.0, 2.0]])
        })
        .unwrap();
    assert_eq!(inserted.ids.clone().count(), 2);

    let columns = ["positions", "velocities", "angular_velocities", "scales", "shapes", "materials", "orientations"];
    let advanced = simulation.advance(Window::new(0.1).with_columns(columns)).unwrap();
    assert_eq!((advanced.steps_done, advanced.window_steps), (10_000, 10_000));
    assert_eq!(advanced.stop_reason, StopReason::Complete);
    assert!((advanced.time_reached_s - 0.1).abs() < 1e-15);

    let state = advanced.state.unwrap();
    let t = state.time_s();
    assert_eq!(state.ids().unwrap(), inserted.ids.collect::<Vec<_>>());
    // Velocity Verlet is exact in a uniform field; 1e4 steps round to about 1e4 ulp of 2 m at worst.
    let tolerance = 1e4 * 2.0 * f64::EPSILON;
    for (start, [x, y, z]) in [[0.0, 1.0], [0.1, 2.0]].into_iter().zip(state.positions_m().unwrap()) {
        let fallen = [start[0] + 0.5 * t, 0.0, start[1] + t - G * t * t / 2.0];
        assert!((x - fallen[0]).abs() < tolerance && y == 0.0 && (z - fallen[2]).abs() < tolerance, "{x} {y} {z}");
    }
    for [x, _, z] in state.velocities_m_per_s().unwrap() {
        assert!((x - 0.5).abs() < tolerance && (z - (1.0 - G * t)).abs() < tolerance, "{x} {z}");
    }
    for spin in state.angular_velocities_rad_per_s().unwrap() {
        assert!((spin[2] - 3.0).abs() < tolerance);
    }
    assert_eq!((state.scales().unwrap(), state.shapes().unwrap()), (vec![1.0; 2], vec![0; 2]));
    assert_eq!(state.materials().unwrap(), [0, 0]);
    assert_eq!(state.orientations_wxyz().unwrap().len(), 2);
}

#[test]
fn windows_follow_one_another_and_a_wrong_start_is_refused() {
    let daemon = Daemon::start("windows");
    let simulation = daemon.connect();
    let first = simulation.advance(Window::new(3.3e-5)).unwrap();
    assert_eq!(first.window_steps, 4);
    let second = simulation.advance(Window::new(3.3e-5)).unwrap();
    assert_eq!((second.step, second.at.step, second.at.time_s), (8, 4, first.time_reached_s));
    let third = simulation.advance(Window::new(1e-5).from(Start::Step(8))).unwrap();
    simulation.advance(Window::new(1e-5).from(Start::Time(third.time_reached_s))).unwrap();

    let refused = refusal(simulation.advance(Window::new(1e-5).from(Start::Time(first.time_reached_s))));
    assert_eq!((refused.code, refused.path.as_str()), (ErrorCode::WrongTime, "from_time_s"));
    assert_eq!(refusal(simulation.advance(Window::new(1e-5).from(Start::Step(3)))).path, "from_step");
    assert_eq!(simulation.step(5).unwrap().step, 15);
    assert_eq!(simulation.advance(Window::new(1e-5)).unwrap().step, 16);
}

#[test]
fn columns_are_chosen_and_may_be_narrow() {
    let daemon = Daemon::start("columns");
    let simulation = daemon.connect();
    simulation.insert(beads(&[[0.1, 0.2, 0.3]])).unwrap();
    let state = simulation.state(&["positions"], FloatType::F32).unwrap();
    assert_eq!(state.positions_m().unwrap(), [[0.1_f32, 0.2, 0.3].map(f64::from)]);
    assert!(matches!(state.velocities_m_per_s(), Err(ClientError::ColumnMissing { .. })));
    assert_eq!(simulation.state(&["all"], FloatType::F64).unwrap().positions_m().unwrap(), [[0.1, 0.2, 0.3]]);
    let ids = simulation.state(&[], FloatType::F64).unwrap();
    assert_eq!((ids.frame().columns.len(), ids.ids().unwrap().len()), (1, 1));
    let refused = refusal(simulation.state(&["colours"], FloatType::F64));
    assert_eq!((refused.command.as_str(), refused.code), ("state/latest", ErrorCode::NotFound));
    assert_eq!((refused.path.as_str(), refused.step), ("columns", None));
}

#[test]
fn refusals_say_where_and_change_nothing() {
    let daemon = Daemon::start("refusals");
    let simulation = daemon.connect();
    simulation.insert(beads(&[[0.0, 0.0, 1.0]])).unwrap();
    simulation.step(3).unwrap();
    let before = simulation.info().unwrap().state_hash;

    let unknown = refusal(simulation.remove([0, 4711]));
    assert_eq!((unknown.command.as_str(), unknown.code), ("remove", ErrorCode::InvalidInput));
    assert_eq!((unknown.path.as_str(), unknown.step), ("ids[1]", Some(3)));
    assert!(unknown.message.contains("4711"), "{unknown}");
    assert_eq!(refusal(simulation.step(0)).path, "steps");
    assert_eq!(refusal(simulation.set_gravity([0.0, f64::NAN, 0.0])).path, "gravity_m_per_s2.y");
    assert_eq!(refusal(simulation.set_motion("wall", Motion::Fixed)).path, "boundary");
    let nan = refusal(simulation.insert(beads(&[[0.0; 3], [0.0, f64::INFINITY, 0.0]])));
    assert_eq!(nan.path, "placement.poses.positions_m[1][1]");
    assert_eq!(refusal(simulation.field("nothing")).code, ErrorCode::NotFound);
    let refused = refusal(simulation.later(1e-9).set_gravity([0.0; 3]).unwrap().wait());
    assert_eq!((refused.code, refused.path.as_str()), (ErrorCode::WrongTime, "header.at_time_s"));

    assert_eq!(simulation.info().unwrap().state_hash, before);
    assert_eq!(simulation.remove([0]).unwrap().count, 1);
}

#[test]
fn questions_are_answered() {
    let daemon = Daemon::start("questions");
    let simulation = daemon.connect();
    let info = simulation.info().unwrap();
    assert_eq!((info.instance.as_str(), info.scene.as_str(), info.state()), ("questions", "drop", RunState::Paused));
    assert!(simulation.features().unwrap().commands.iter().any(|command| command == "advance"));
    assert!(!simulation.plan().unwrap().is_empty());
    let shapes = simulation.shapes().unwrap();
    assert_eq!((shapes[0].name.as_str(), shapes[0].kind.as_str()), ("bead", "sphere"));
    let placement = Placement::random(Region::Box { min_m: [0.0; 3], max_m: [0.05; 3] }, Amount::Count(40));
    simulation.insert(Insertion::new("bead", "glass", placement)).unwrap();
    assert_eq!(simulation.report().unwrap().particles, 40);
}

#[test]
fn a_field_holds_the_mass_of_its_particles() {
    let daemon = Daemon::start("field");
    let simulation = daemon.connect();
    simulation.insert(beads(&[[0.0; 3], [0.002, 0.001, 0.0]])).unwrap();
    let definition = FieldDefinition {
        name: "box".into(),
        min_m: [-0.02; 3],
        max_m: [0.02; 3],
        cells: [40; 3],
        quantities: vec![FieldQuantity::Density, FieldQuantity::Velocity],
        width_m: 1.5e-3,
        ..Default::default()
    };
    simulation.define_field(definition).unwrap();
    let field = simulation.field("box").unwrap();
    let cell_m3 = 1e-9;
    let mass = field.scalars("density").unwrap().iter().sum::<f64>() * cell_m3;
    let beads = 2.0 * 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-9;
    assert!((field.frame().total_mass_kg / beads - 1.0).abs() < 1e-12);
    // Midpoint sums of a Gaussian of 1.5 cells are exact to 1e-9; its cut at 4 widths leaves steps of 3e-4.
    assert!((mass / beads - 1.0).abs() < 1e-3, "{mass} instead of {beads}");

    let advanced = simulation.advance(Window::new(1e-3).with_fields(["box"])).unwrap();
    assert_eq!((advanced.state, advanced.fields[0].name()), (None, "box"));
    let velocities = advanced.fields[0].vectors("velocity").unwrap();
    let slowest = velocities.iter().map(|v| v[2]).fold(0.0, f64::min);
    assert!((slowest + G * 1e-3).abs() < 1e-9, "{slowest}");
    let sample = simulation.fields("box").unwrap().next_within(SOON).unwrap();
    assert_eq!((sample.cells(), sample.time_s()), ([40; 3], advanced.time_reached_s));
    simulation.drop_field("box").unwrap();
    assert_eq!(refusal(simulation.drop_field("box")).code, ErrorCode::NotFound);
}

#[test]
fn a_command_for_later_takes_effect_then() {
    let daemon = Daemon::start("later");
    let simulation = daemon.connect();
    simulation.insert(beads(&[[0.0; 3]])).unwrap();
    let pending = simulation.later(0.01).set_gravity([0.0; 3]).unwrap();
    let early = pending.wait_for(Duration::from_millis(50));
    assert!(matches!(early, Err(ClientError::Timeout { request_id: Some(_), .. })), "{early:?}");
    let state = simulation.advance(Window::new(0.02).with_columns(["velocities"])).unwrap().state.unwrap();
    let at = pending.wait().unwrap().at;
    assert!((at.time_s - 0.01).abs() < 1.5e-5 && at.time_s >= 0.01, "{at:?}");
    // Half a kick of either gravity at the seam: one step at most.
    let [_, _, speed] = state.velocities_m_per_s().unwrap()[0];
    assert!((speed + G * at.time_s).abs() <= G * 1e-5, "{speed}");
}

#[test]
fn a_retry_after_a_timeout_is_applied_once() {
    let daemon = Daemon::start("retry");
    let simulation = daemon.connect();
    // It waits for its simulated time, so that the timeout comes first on any machine.
    let header = v1::CommandHeader { client_id: "c".into(), request_id: "mine".into(), at_time_s: Some(1e-3) };
    let request = Request::Insert(beads(&[[0.0; 3]]).into()).with_header(header);
    match simulation.command(request.clone(), Some(Duration::from_millis(50))) {
        Err(ClientError::Timeout { request_id, .. }) => assert_eq!(request_id.as_deref(), Some("mine")),
        other => panic!("{other:?}"),
    }
    simulation.advance(Window::new(2e-3)).unwrap();
    assert!(simulation.command(request, Some(SOON)).unwrap().repeated);
    assert_eq!(simulation.info().unwrap().particles, 1);
}

#[test]
fn late_listeners_hear_what_happened() {
    let daemon = Daemon::start("events");
    daemon.connect().insert(beads(&[[0.0; 3]])).unwrap();
    let simulation = daemon.connect();
    let mut events = simulation.events().unwrap();
    let mut heard = Vec::new();
    while !(heard.contains(&EventKind::Started) && heard.contains(&EventKind::Particles)) {
        heard.push(events.next_within(SOON).unwrap().kind());
    }
    simulation.resume().unwrap();
    while events.next_within(SOON).unwrap().kind() != EventKind::Resumed {}
    simulation.pause().unwrap();
}

#[test]
fn streams_hand_out_what_is_published_and_the_newest_to_the_slow() {
    let daemon = Daemon::start("streams");
    let simulation = daemon.connect();
    simulation.insert(beads(&[[0.0; 3]])).unwrap();
    let states = simulation.states().unwrap();
    let mut slow = simulation.states().unwrap().keeping(1);
    let mut reports = simulation.reports().unwrap();
    simulation.resume().unwrap();
    let steps: Vec<u64> = states.take(5).map(|state| state.unwrap().step()).collect();
    assert!(steps.is_sorted_by(|a, b| a < b), "{steps:?}");
    assert_eq!(reports.next_within(SOON).unwrap().particles, 1);
    simulation.pause().unwrap();

    let counts = slow.counts();
    assert!(counts.received >= 4 && counts.overwritten_here == counts.received - 1, "{counts:?}");
    assert!(slow.latest().unwrap().unwrap().step() >= *steps.last().unwrap());
    assert!(slow.latest().is_none());
}

#[test]
fn a_pause_from_another_thread_ends_a_window_early() {
    let daemon = Daemon::start("pause");
    let simulation = daemon.connect();
    let other = simulation.clone();
    let window = thread::spawn(move || other.advance(Window::new(1e4)));
    while simulation.info().unwrap().state() != RunState::Advancing {
        thread::sleep(Duration::from_millis(5));
    }
    simulation.pause().unwrap();
    let advanced = window.join().unwrap().unwrap();
    assert_eq!(advanced.stop_reason, StopReason::Paused);
    assert!(advanced.steps_done < advanced.window_steps);
    assert_eq!(simulation.step(1).unwrap().steps_done, 1);
}

#[test]
fn who_is_alive_is_told_to_those_who_ask_for_another() {
    let daemon = Daemon::start("here");
    match Simulation::connect("there", &daemon.endpoint, Duration::from_millis(500)).err().unwrap() {
        ClientError::NoSuchInstance { instance, alive, .. } => {
            assert_eq!((instance.as_str(), alive), ("there", vec!["here".to_string()]));
        }
        other => panic!("{other}"),
    }
}

#[test]
fn a_stopped_daemon_is_gone() {
    let mut daemon = Daemon::start("stop");
    let simulation = daemon.connect();
    let observer = daemon.connect();
    let states = observer.states().unwrap();
    let reader = thread::spawn(move || states.map(Result::unwrap).count());
    simulation.stop().unwrap();
    assert!(daemon.ended_well());
    reader.join().unwrap();
    assert!(matches!(simulation.info(), Err(ClientError::DaemonGone { .. })));
    assert!(matches!(simulation.states().err(), Some(ClientError::DaemonGone { .. })));
    simulation.stop().unwrap();

    let deadline = Instant::now() + SOON;
    while !observer.is_gone() && Instant::now() < deadline {
        thread::sleep(Duration::from_millis(5));
    }
    let text = observer.pause().unwrap_err().to_string();
    assert!(text.starts_with("the daemon of \"stop\" at") && text.contains("has ended"), "{text}");
}

#[test]
fn a_killed_daemon_releases_all_who_wait() {
    let mut daemon = Daemon::start("kill");
    let simulation = daemon.connect();
    let mut events = simulation.events().unwrap();
    let waiting = simulation.later(1e6).set_gravity([0.0; 3]).unwrap();
    let other = simulation.clone();
    let window = thread::spawn(move || other.advance(Window::new(1e4)));
    while simulation.info().unwrap().state() != RunState::Advancing {
        thread::sleep(Duration::from_millis(5));
    }
    daemon.kill();
    assert!(matches!(window.join().unwrap(), Err(ClientError::DaemonGone { .. })));
    assert!(matches!(waiting.wait(), Err(ClientError::DaemonGone { .. })));
    events.by_ref().for_each(drop);
    assert!(matches!(events.next_within(SOON), Err(ClientError::DaemonGone { .. })));
}
