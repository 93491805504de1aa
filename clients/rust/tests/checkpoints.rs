//! Checkpoints against the real daemon: in memory for implicit coupling, on disk for restarts.

mod common;

use std::path::{Path, PathBuf};
use std::time::Instant;
use std::{fs, thread};

use common::{Daemon, SOON};
use sturz_client::v1::{ErrorCode, EventKind, RunState};
use sturz_client::{ClientError, Refusal, Request, Simulation, Window, v1};

/// A heap of balls and cubes that slide, stick and roll on a turning drum's wall.
const HEAP: &str = r#"
[scene]
name = "heap"
gravity_m_per_s2 = [0.0, 0.0, -9.81]
time_step_s = 1e-5
seed = 4
[[material]]
name = "glass"
density_kg_per_m3 = 2500.0
[[material_pair]]
materials = ["glass", "glass"]
stiffness_n_per_m = 1e4
restitution = 0.5
friction = 0.4
[[shape]]
name = "bead"
geometry = { kind = "sphere", radius_m = 2e-3 }
[[shape]]
name = "cube"
geometry = { kind = "cube", edge_m = 4e-3 }
[[boundary]]
name = "drum"
material = "glass"
geometry = { kind = "cylinder_inside", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], radius_m = 0.02 }
motion = { kind = "rotation", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], angular_velocity = { kind = "constant", rad_per_s = 5.0 } }
[[insertion]]
shape = "bead"
material = "glass"
placement = { method = "random", count = 20, region = { kind = "box", min_m = [-0.012, -0.01, -0.012], max_m = [0.012, 0.01, 0.0] } }
[[insertion]]
shape = "cube"
material = "glass"
placement = { method = "random", count = 12, region = { kind = "box", min_m = [-0.012, -0.01, 0.0], max_m = [0.012, 0.01, 0.014] } }
"#;

/// Windows of 37 time steps and a bit: they have a time step of their own.
const WINDOW_S: f64 = 3.75e-4;

fn refusal<T: std::fmt::Debug>(answer: Result<T, ClientError>) -> Refusal {
    answer.unwrap_err().refusal().cloned().expect("refused by the daemon")
}

fn hash(simulation: &Simulation) -> u64 {
    simulation.info().unwrap().state_hash
}

/// State hash after each of some windows.
fn windows(simulation: &Simulation, n: usize) -> Vec<u64> {
    (0..n)
        .map(|_| {
            simulation.advance(Window::new(WINDOW_S)).unwrap();
            hash(simulation)
        })
        .collect()
}

/// A folder of this test's own, empty.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("checkpoints-{name}-{}", std::process::id()));
    drop(fs::remove_dir_all(&folder));
    fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn windows_are_repeated_bit_for_bit_as_often_as_wanted() {
    let daemon = Daemon::serve("implicit", HEAP, &[]);
    let simulation = daemon.connect();
    simulation.step(16_000).unwrap();
    let report = simulation.report().unwrap();
    assert!(
        report.touching_pairs > 3 && report.energy.unwrap().dissipated_friction_j > 0.0,
        "there are springs to save"
    );
    let saved = simulation.checkpoint("window").unwrap();
    assert_eq!((saved.at.step, saved.checkpoint.step, saved.checkpoint.particles), (16_000, 16_000, 32));
    assert_eq!(saved.checkpoint.state_hash, hash(&simulation));
    assert!(!saved.checkpoint.on_disk && saved.checkpoint.bytes > 32 * 200);

    let first = windows(&simulation, 4);
    for _ in 0..3 {
        let restored = simulation.restore("window").unwrap();
        assert_eq!((restored.at.step, restored.at.time_s.to_bits()), (16_000, saved.at.time_s.to_bits()));
        assert_eq!(hash(&simulation), saved.checkpoint.state_hash);
        // the client knows that time went back: the start of the next window is checked to the bit
        assert_eq!(windows(&simulation, 4), first);
    }
    // a window that is asked for again after going back is answered without the state of another one
    let asked = |request_id: &str, from_step: u64| {
        let header = v1::CommandHeader { client_id: "c".into(), request_id: request_id.into(), at_time_s: None };
        let outputs = Some(v1::Outputs { columns: vec!["positions".into()], ..Default::default() });
        let from = Some(v1::advance_request::From::FromStep(from_step));
        let window =
            v1::AdvanceRequest { header: Some(header), from, window_s: WINDOW_S, outputs, loads: None, fluid: None };
        let outcome = simulation.command(Request::Advance(window), Some(SOON)).unwrap();
        let Some(v1::outcome::Result::Advanced(advanced)) = outcome.result else { panic!("{outcome:?}") };
        (outcome.repeated, advanced.frame.is_some())
    };
    simulation.restore("window").unwrap();
    assert_eq!((asked("1", 16_000), asked("1", 16_000)), ((false, true), (true, true)));
    simulation.restore("window").unwrap();
    simulation.set_gravity([1.0, 0.0, -9.0]).unwrap();
    assert_eq!((asked("2", 16_000), asked("1", 16_000)), ((false, true), (true, false)));
    simulation.restore("window").unwrap();
    windows(&simulation, 4);
    // a token is replaced by its name, and steering after it is forgotten
    simulation.checkpoint("window").unwrap();
    simulation.set_gravity([0.0, 0.0, 9.81]).unwrap();
    simulation.remove([3, 25]).unwrap();
    let other = windows(&simulation, 2);
    simulation.restore("window").unwrap();
    let info = simulation.info().unwrap();
    assert_eq!((info.particles, info.topology_epoch, info.gravity_m_per_s2.unwrap().z), (32, 0, -9.81));
    assert_eq!(info.state_hash, first[3]);
    assert_ne!(windows(&simulation, 2), other);
}

#[test]
fn a_killed_daemon_goes_on_from_its_file_on_another_number_of_threads() {
    let folder = folder("kill");
    let arguments = ["--checkpoints", folder.to_str().unwrap()];
    let mut daemon = Daemon::serve("killed", HEAP, &arguments);
    let simulation = daemon.connect();
    simulation.step(16_000).unwrap();
    let saved = simulation.checkpoint_on_disk("safe").unwrap().checkpoint;
    assert!(saved.on_disk);
    simulation.checkpoint("lost").unwrap();
    let hashes = windows(&simulation, 5);
    daemon.kill();
    drop(daemon);
    assert_eq!(fs::metadata(folder.join("safe.checkpoint")).unwrap().len(), saved.bytes);

    let again = Daemon::serve("killed", HEAP, &[&arguments[..], &["--threads", "3"]].concat());
    let simulation = again.connect();
    assert_eq!(simulation.checkpoints().unwrap(), std::slice::from_ref(&saved));
    let restored = simulation.restore("safe").unwrap();
    assert_eq!(restored.checkpoint, saved);
    assert_eq!(hash(&simulation), saved.state_hash);
    assert_eq!(windows(&simulation, 5), hashes);
    let missing = refusal(simulation.restore("lost"));
    assert_eq!((missing.code, missing.path.as_str()), (ErrorCode::NotFound, "token"));
    assert!(missing.message.contains("safe"), "{missing}");
    simulation.drop_checkpoint("safe").unwrap();
    assert!(!folder.join("safe.checkpoint").exists() && simulation.checkpoints().unwrap().is_empty());
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn damaged_cut_and_foreign_files_are_refused_with_the_reason() {
    let folder = folder("damage");
    let arguments = ["--checkpoints", folder.to_str().unwrap()];
    let daemon = Daemon::serve("damage", HEAP, &arguments);
    let simulation = daemon.connect();
    simulation.step(100).unwrap();
    simulation.checkpoint_on_disk("good").unwrap();
    simulation.step(100).unwrap();
    let before = hash(&simulation);
    let good = fs::read(folder.join("good.checkpoint")).unwrap();
    let refused = |name: &str, bytes: &[u8]| {
        fs::write(folder.join(format!("{name}.checkpoint")), bytes).unwrap();
        let refused = refusal(simulation.restore(name));
        assert_eq!((refused.code, refused.path.as_str()), (ErrorCode::UnusableCheckpoint, "token"), "{refused}");
        assert_eq!(hash(&simulation), before);
        refused.message
    };
    let mut flipped = good.clone();
    flipped[good.len() / 2] ^= 4;
    assert!(refused("flipped", &flipped).contains("is damaged"));
    assert!(refused("cut", &good[..good.len() - 100]).contains("cut short"));
    assert!(refused("empty", &[]).contains("is no checkpoint"));
    let mut newer = good.clone();
    newer[8] += 1;
    assert!(refused("newer", &newer).contains("use the version of Sturz that wrote it"));

    let other = Daemon::serve("other", &HEAP.replace("friction = 0.4", "friction = 0.5"), &arguments);
    let foreign = refusal(other.connect().restore("good"));
    assert!(foreign.message.contains("of another scene: [material_pair] differ"), "{foreign}");
    simulation.restore("good").unwrap();
    assert_eq!(simulation.info().unwrap().step, 100);
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn limits_and_bad_requests_are_refused_by_name() {
    let folder = folder("limits");
    let limits = folder.join("limits.toml");
    fs::write(&limits, "checkpoints = 2\n").unwrap();
    let daemon = Daemon::serve("limits", HEAP, &["--limits", limits.to_str().unwrap()]);
    let simulation = daemon.connect();
    let made = simulation.checkpoint("").unwrap().checkpoint.token;
    assert_eq!(made, "step-0-1");
    simulation.checkpoint("b").unwrap();
    let full = refusal(simulation.checkpoint("c"));
    assert_eq!((full.code, full.path.as_str()), (ErrorCode::TooLarge, "token"));
    assert!(full.message.contains("limit `checkpoints`"), "{full}");
    simulation.checkpoint("b").unwrap();
    simulation.drop_checkpoint(&made).unwrap();
    simulation.checkpoint("c").unwrap();
    assert_eq!(refusal(simulation.checkpoint("../c")).path, "token");
    assert_eq!(refusal(simulation.restore("")).path, "token");
    let nowhere = refusal(simulation.checkpoint_on_disk("d"));
    assert!(nowhere.path == "on_disk" && nowhere.message.contains("--checkpoints DIR"), "{nowhere}");
    let tokens: Vec<String> = simulation.checkpoints().unwrap().into_iter().map(|known| known.token).collect();
    assert_eq!(tokens, ["b", "c"]);
    assert_eq!(simulation.features().unwrap().limits.unwrap().checkpoints, 2);
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn windows_under_way_may_be_saved_and_not_be_pulled_away() {
    let daemon = Daemon::serve("under-way", HEAP, &[]);
    let simulation = daemon.connect();
    let other = simulation.clone();
    let window = thread::spawn(move || other.advance(Window::new(1e4)));
    while simulation.info().unwrap().step < 100 {
        thread::yield_now();
    }
    let saved = simulation.checkpoint("within").unwrap();
    assert_eq!(refusal(simulation.restore("within")).code, ErrorCode::WindowInFlight);
    simulation.pause().unwrap();
    assert!(window.join().unwrap().unwrap().steps_done >= saved.at.step);
    let now = simulation.info().unwrap().sim_time_s;
    let later = simulation.later(now + 1e-3).checkpoint("then", false).unwrap();
    simulation.step(200).unwrap();
    assert!((later.wait().unwrap().at.time_s - now - 1e-3).abs() < 2e-5);
    simulation.restore("within").unwrap();
    let first = windows(&simulation, 2);
    simulation.restore("within").unwrap();
    assert_eq!(windows(&simulation, 2), first);
}

#[test]
fn a_failed_run_is_paused_where_it_was_sound_and_listeners_hear_of_it() {
    let daemon = Daemon::serve("failed", HEAP, &[]);
    let simulation = daemon.connect();
    let mut events = simulation.events().unwrap();
    simulation.step(50).unwrap();
    simulation.checkpoint("sound").unwrap();
    simulation.set_gravity([0.0, 0.0, -1e9]).unwrap();
    assert_eq!(refusal(simulation.step(10_000)).code, ErrorCode::RunFailed);
    assert_eq!(refusal(simulation.checkpoint("broken")).code, ErrorCode::RunFailed);
    assert_eq!(simulation.info().unwrap().state(), RunState::Failed);
    simulation.restore("sound").unwrap();
    assert_eq!(simulation.info().unwrap().state(), RunState::Paused);
    assert_eq!(simulation.step(50).unwrap().step, 100);
    let mut heard = Vec::new();
    while heard.last() != Some(&(EventKind::Restored, "sound".to_string())) {
        let event = events.next_within(SOON).unwrap();
        heard.push((event.kind(), event.name));
    }
    assert!(heard.contains(&(EventKind::Checkpoint, "sound".to_string())));
    simulation.resume().unwrap();
    simulation.restore("sound").unwrap();
    assert_eq!(simulation.info().unwrap().state(), RunState::Running);
}

/// Nobody asks for checkpoints; the daemon is killed, and another one starts from the newest that there is.
#[test]
fn a_killed_daemon_has_saved_itself_from_time_to_time() {
    let folder = folder("auto");
    let arguments = ["--checkpoints", folder.to_str().unwrap(), "--checkpoint-every", "0.05"];
    let mut daemon = Daemon::serve("auto", HEAP, &arguments);
    let simulation = daemon.connect();
    simulation.resume().unwrap();
    let autos = |simulation: &Simulation| -> Vec<u64> {
        let mut steps: Vec<u64> = simulation.checkpoints().unwrap().into_iter().map(|saved| saved.step).collect();
        steps.sort_unstable();
        steps
    };
    let deadline = Instant::now() + SOON;
    let first = loop {
        let steps = autos(&simulation);
        assert!(steps.len() <= 2 && Instant::now() < deadline, "{steps:?}");
        if steps.len() == 2 {
            break steps[0];
        }
    };
    while autos(&simulation).contains(&first) {
        assert!(Instant::now() < deadline, "the oldest is never removed");
    }
    daemon.kill();
    drop(daemon);
    drop(simulation);

    let again = Daemon::serve("auto", HEAP, &["--checkpoints", arguments[1], "--restore", "newest", "--threads", "2"]);
    let simulation = again.connect();
    let newest = simulation.checkpoints().unwrap().into_iter().max_by_key(|saved| saved.step).unwrap();
    let info = simulation.info().unwrap();
    assert_eq!((info.step, info.state_hash), (newest.step, newest.state_hash));
    // the same bits as a run that has never been stopped
    let undisturbed = Daemon::serve("undisturbed", HEAP, &[]);
    let other = undisturbed.connect();
    other.step(newest.step).unwrap();
    assert_eq!(hash(&other), newest.state_hash);
    assert_eq!(windows(&simulation, 3), windows(&other, 3));
    fs::remove_dir_all(&folder).unwrap();
}
