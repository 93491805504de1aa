//! The journal against the real daemon: what was acknowledged survives, and the run has the same bits.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use common::{Daemon, SOON, binary};
use sturz_client::v1::{ErrorCode, EventKind, RunState};
use sturz_client::{Amount, ClientError, Insertion, Output, Pace, Placement, Region, Request, Simulation, Window, v1};

/// Balls that fall on each other in a box and roll.
const BOX: &str = r#"
[scene]
name = "box"
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
[[boundary]]
name = "drum"
material = "glass"
geometry = { kind = "cylinder_inside", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], radius_m = 0.012 }
[[insertion]]
shape = "bead"
material = "glass"
placement = { method = "random", count = 20, region = { kind = "box", min_m = [-0.008, -0.01, -0.008], max_m = [0.008, 0.01, 0.008] } }
"#;

const WINDOW_S: f64 = 3.75e-4;

/// A folder of this test's own that is not there yet.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("journal-{name}-{}", std::process::id()));
    drop(fs::remove_dir_all(&folder));
    folder
}

fn journaled(name: &str, journal: &Path, more: &[&str]) -> Daemon {
    let mut arguments = vec!["--journal", journal.to_str().unwrap()];
    arguments.extend(more);
    Daemon::serve(name, BOX, &arguments)
}

fn place(simulation: &Simulation) -> (u64, u64) {
    let info = simulation.info().unwrap();
    (info.step, info.state_hash)
}

/// Somewhere in the drum.
fn bead() -> Insertion {
    let region = Region::Box { min_m: [-0.008, -0.01, -0.008], max_m: [0.008, 0.01, 0.008] };
    Insertion::new("bead", "glass", Placement::random(region, Amount::Count(1)))
}

/// A row of them beside the heap, the `k`th of such rows.
fn row(k: usize) -> Insertion {
    let place = |i: usize| [0.0, 0.1 + 0.005 * (300 * k + i) as f64, 0.0];
    Insertion::new("bead", "glass", Placement::poses((0..300).map(place).collect()))
}

/// What `sturz replay` says, and whether it was content.
fn replay(journal: &Path, threads: &str) -> (bool, String) {
    let replay = Command::new(binary()).arg("replay").arg(journal).args(["--threads", threads]).output().unwrap();
    let said = String::from_utf8_lossy(&replay.stdout) + String::from_utf8_lossy(&replay.stderr);
    (replay.status.success(), said.into_owned())
}

/// A steered run: what each part of it leads to.
fn first_part(simulation: &Simulation) {
    // Nobody waits for its outcome.
    drop(simulation.later(5e-4).set_gravity([3.0, 0.0, -9.0]).unwrap());
    simulation.advance(Window::new(WINDOW_S)).unwrap();
    simulation.checkpoint("early").unwrap();
    simulation.advance(Window::new(WINDOW_S)).unwrap();
    simulation.insert(bead()).unwrap();
    simulation.checkpoint_on_disk("late").unwrap();
    simulation.step(7).unwrap();
}

fn second_part(simulation: &Simulation) -> Vec<(u64, u64)> {
    let mut places = vec![place(simulation)];
    simulation.advance(Window::new(WINDOW_S)).unwrap();
    places.push(place(simulation));
    simulation.restore("early").unwrap();
    places.push(place(simulation));
    simulation.advance(Window::new(3.0 * WINDOW_S)).unwrap();
    places.push(place(simulation));
    simulation.restore("late").unwrap();
    simulation.step(50).unwrap();
    places.push(place(simulation));
    places
}

#[test]
fn a_killed_run_goes_on_with_the_same_bits_on_any_number_of_threads() {
    let undisturbed = Daemon::serve("undisturbed", BOX, &["--checkpoints", folder("files").to_str().unwrap()]);
    let simulation = undisturbed.connect();
    first_part(&simulation);
    let expected = second_part(&simulation);

    let journal = folder("killed");
    let mut daemon = journaled("killed", &journal, &[]);
    first_part(&daemon.connect());
    daemon.kill();
    // Twice, so that what a start adds to the journal is replayed as well.
    let mut daemon = Daemon::resume(&journal, &["--threads", "2"]);
    daemon.kill();
    let mut daemon = Daemon::resume(&journal, &[]);
    assert_eq!(daemon.instance, "killed");
    assert_eq!(second_part(&daemon.connect()), expected);
    daemon.kill();
    for threads in ["1", "2"] {
        let (is_same, said) = replay(&journal, threads);
        assert!(is_same && !said.contains("outcomes       0"), "{said}");
    }
    fs::remove_dir_all(journal).unwrap();
}

#[test]
fn a_retry_after_a_crash_is_not_applied_twice() {
    let journal = folder("retry");
    let mut daemon = journaled("retry", &journal, &[]);
    let insert = |id: &str| {
        let header = v1::CommandHeader { client_id: "c".into(), request_id: id.into(), at_time_s: None };
        Request::Insert(bead().into()).with_header(header)
    };
    let before = daemon.connect().command(insert("1"), Some(SOON)).unwrap();
    daemon.kill();
    let daemon = Daemon::resume(&journal, &[]);
    let simulation = daemon.connect();
    let after = simulation.command(insert("1"), Some(SOON)).unwrap();
    assert_eq!(after, v1::Outcome { repeated: true, ..before });
    assert!(!simulation.command(insert("2"), Some(SOON)).unwrap().repeated);
    assert_eq!(simulation.info().unwrap().particles, 22);
    let reused = Request::Pause(v1::PauseRequest::default()).with_header(v1::CommandHeader {
        client_id: "c".into(),
        request_id: "1".into(),
        at_time_s: None,
    });
    let refused = simulation.command(reused, Some(SOON)).unwrap_err();
    assert_eq!(refused.refusal().unwrap().code, ErrorCode::RequestIdReused);
    fs::remove_dir_all(journal).unwrap();
}

/// A window of thousands of steps, which nobody waits for any more, is done to its end.
#[test]
fn a_window_under_way_is_finished_by_the_one_that_takes_over() {
    let journal = folder("window");
    let mut daemon = journaled("window", &journal, &[]);
    let simulation = daemon.connect();
    let header = v1::CommandHeader { client_id: "c".into(), request_id: "long".into(), at_time_s: None };
    let request = Request::Step(v1::StepRequest { header: None, steps: 40_000 }).with_header(header);
    let answer = simulation.command(request.clone(), Some(Duration::from_millis(1)));
    assert!(matches!(answer, Err(ClientError::Timeout { .. })), "{answer:?}");
    // It is accepted when it is seen to be under way.
    while simulation.info().unwrap().state() != RunState::Advancing {}
    simulation.insert(bead()).unwrap();
    daemon.kill();
    let daemon = Daemon::resume(&journal, &[]);
    let outcome = daemon.connect().command(request, Some(SOON)).unwrap();
    let Some(v1::outcome::Result::Stepped(stepped)) = outcome.result else { panic!("{outcome:?}") };
    assert_eq!((stepped.steps_done, stepped.step, stepped.stop_reason()), (40_000, 40_000, v1::StopReason::Complete));
    assert_eq!(daemon.connect().info().unwrap().particles, 21);
    fs::remove_dir_all(journal).unwrap();
}

#[test]
fn what_waits_for_its_time_and_what_is_saved_survive_snapshots() {
    let journal = folder("snapshots");
    let mut daemon = journaled("snapshots", &journal, &["--checkpoint-every", "0.001", "--journal-keep", "0"]);
    let simulation = daemon.connect();
    let later = simulation.later(4e-3).set_gravity([0.0, 0.0, 5.0]).unwrap();
    simulation.checkpoint("start").unwrap();
    let start = place(&simulation);
    simulation.define_field(field("density")).unwrap();
    simulation.define_output(Output::new("contacts").at(Pace::EverySteps(7))).unwrap();
    let outputs = simulation.info().unwrap().outputs;
    let log = journal.join("log");
    let first = log.join("000000000000.log");
    while first.exists() {
        simulation.step(1).unwrap();
    }
    drop(later);
    daemon.kill();
    let mut daemon = Daemon::resume(&journal, &[]);
    let simulation = daemon.connect();
    assert_eq!(simulation.info().unwrap().fields.len(), 1);
    assert_eq!(simulation.info().unwrap().outputs, outputs);
    simulation.advance(Window::new(4e-3)).unwrap();
    assert_eq!(
        simulation.state(&["positions"], sturz_client::FloatType::F64).unwrap().frame().gravity_m_per_s2.unwrap().z,
        5.0
    );
    simulation.restore("start").unwrap();
    assert_eq!(place(&simulation), start);
    daemon.kill();
    let (is_same, said) = replay(&journal, "1");
    assert!(is_same, "{said}");
    fs::remove_dir_all(journal).unwrap();
}

fn field(name: &str) -> v1::FieldDefinition {
    let corner = |x| Some(v1::Vec3 { x, y: x, z: x });
    v1::FieldDefinition {
        name: name.into(),
        grid: Some(v1::Grid {
            min_m: corner(-0.01),
            max_m: corner(0.01),
            cells_x: 2,
            cells_y: 2,
            cells_z: 2,
            cylinder: None,
        }),
        quantities: vec![v1::FieldQuantity::Density.into()],
        width_m: 4e-3,
        ..Default::default()
    }
}

#[test]
fn a_run_is_not_begun_twice_and_written_by_one_only() {
    let journal = folder("twice");
    let mut daemon = journaled("twice", &journal, &[]);
    let serve = |arguments: &[&str]| {
        let tried = Command::new(binary()).arg("serve").args(arguments).args(["--listen", "auto"]).output().unwrap();
        assert!(!tried.status.success());
        String::from_utf8_lossy(&tried.stderr).into_owned()
    };
    let path = journal.to_str().unwrap();
    let said = serve(&["--resume", path, "--name", "other"]);
    assert!(said.contains("another daemon writes to"), "{said}");
    daemon.kill();
    let said = serve(&["bouncing-sphere", "--journal", path]);
    assert!(said.contains("holds a run already"), "{said}");
    let said = serve(&["--resume", journal.join("log").to_str().unwrap()]);
    assert!(said.contains("holds no run"), "{said}");
    drop(Daemon::resume(&journal, &[]));
    fs::remove_dir_all(journal).unwrap();
}

/// Requests without an id share a key, and those for later do not end in the order in which they came.
#[test]
fn requests_without_an_id_are_taken_up_too() {
    let journal = folder("nameless");
    let mut daemon = journaled("nameless", &journal, &[]);
    let simulation = daemon.connect();
    let later = |at_time_s| Some(v1::CommandHeader { at_time_s, ..Default::default() });
    let gravity = |x| Some(v1::Vec3 { x, y: 0.0, z: -9.81 });
    let impatient = Some(Duration::from_millis(50));
    for (at, x) in [(2e-3, 2.0), (1e-3, 1.0)] {
        let request = v1::SetGravityRequest { header: later(Some(at)), gravity_m_per_s2: gravity(x) };
        assert!(simulation.command(Request::SetGravity(request), impatient).is_err());
    }
    let request = v1::SetGravityRequest { header: later(None), gravity_m_per_s2: gravity(3.0) };
    simulation.command(Request::SetGravity(request), Some(SOON)).unwrap();
    simulation.step(150).unwrap();
    let expected = place(&simulation);
    daemon.kill();
    let mut daemon = Daemon::resume(&journal, &[]);
    assert_eq!(place(&daemon.connect()), expected);
    daemon.kill();
    let (is_same, said) = replay(&journal, "2");
    assert!(is_same, "{said}");
    fs::remove_dir_all(journal).unwrap();
}

/// A run whose log is damaged within is not gone on with; the damage is named.
#[test]
fn a_damaged_log_is_refused() {
    let journal = folder("damaged");
    let mut daemon = journaled("damaged", &journal, &[]);
    first_part(&daemon.connect());
    daemon.kill();
    let log = journal.join("log/000000000000.log");
    let whole = fs::read(&log).unwrap();
    let mut bytes = whole.clone();
    bytes[200] ^= 4;
    fs::write(&log, bytes).unwrap();
    let resumed =
        Command::new(binary()).args(["serve", "--listen", "auto", "--resume"]).arg(&journal).output().unwrap();
    let said = String::from_utf8_lossy(&resumed.stderr).into_owned();
    assert!(!resumed.status.success() && said.contains("is damaged at byte"), "{said}");
    let (is_same, said) = replay(&journal, "1");
    assert!(!is_same && said.contains("is damaged at byte"), "{said}");
    // Cut in the midst of the last record: it was not acknowledged, and is left out.
    fs::write(&log, &whole[..whole.len() - 3]).unwrap();
    let (is_same, said) = replay(&journal, "1");
    assert!(is_same && said.contains("is left out"), "{said}");
    drop(Daemon::resume(&journal, &[]));
    fs::remove_dir_all(journal).unwrap();
}

/// The limit on the size of files stands for a full disk: nothing is acknowledged that is not in the journal, the run is
/// held, and goes on by itself when there is room. The daemon's own log is on a disk that is full for good.
#[test]
fn a_full_disk_holds_the_run_and_loses_nothing() {
    let journal = folder("full");
    let scene = journal.with_extension("toml");
    fs::write(&scene, BOX).unwrap();
    let serve = format!(
        "trap '' XFSZ; ulimit -S -f 64; exec {} serve {} --name full --paused --journal {} \"$@\"",
        binary().display(),
        scene.display(),
        journal.display()
    );
    let mut shell = Command::new("bash");
    shell.args(["-c", &serve, "sturz"]).stderr(fs::File::options().write(true).open("/dev/full").unwrap());
    let mut daemon = Daemon::spawn(shell, journal.with_extension("folder"));
    let simulation = daemon.connect();
    let mut events = simulation.events().unwrap();
    // Some 7 kB each: the ninth does not fit.
    let mut inserted = 20;
    let mut rows = 0..30;
    let refusal = loop {
        let k = rows.next().expect("the limit is 64 kB");
        let header = v1::CommandHeader { client_id: "c".into(), request_id: k.to_string(), at_time_s: None };
        let request = Request::Insert(row(k).into()).with_header(header);
        match simulation.command(request, Some(Duration::from_millis(500))) {
            // The first one that does not fit waits; the next ones are refused.
            Ok(_) | Err(ClientError::Timeout { .. }) => inserted += 300,
            Err(other) => break other.refusal().cloned().expect("refused by the daemon"),
        }
    };
    assert_eq!(refusal.code, ErrorCode::Disk);
    assert!(refusal.message.contains("nothing was changed"), "{}", refusal.message);
    while events.next_within(SOON).unwrap().kind() != EventKind::Journal {}
    assert!(simulation.step(1).unwrap_err().refusal().is_some());
    let pid = daemon.pid().to_string();
    assert!(Command::new("prlimit").args(["--pid", &pid, "--fsize=unlimited:unlimited"]).status().unwrap().success());
    while events.next_within(SOON).unwrap().kind() != EventKind::Journal {}
    simulation.step(1).unwrap();
    let here = place(&simulation);
    assert_eq!(simulation.info().unwrap().particles, inserted);
    daemon.kill();
    let daemon = Daemon::resume(&journal, &[]);
    assert_eq!(place(&daemon.connect()), here);
    fs::remove_file(scene).unwrap();
    fs::remove_dir_all(journal).unwrap();
}

/// The log holds no copies of files that came from elsewhere: a replay says which one is not that of then.
#[test]
fn a_replay_names_the_checkpoint_file_that_was_written_over() {
    let files = folder("rewritten-files");
    let other = Daemon::serve("elsewhere", BOX, &["--checkpoints", files.to_str().unwrap()]);
    let elsewhere = other.connect();
    for token in ["a", "b"] {
        elsewhere.step(20).unwrap();
        elsewhere.checkpoint_on_disk(token).unwrap();
    }
    let journal = folder("rewritten");
    let mut daemon = journaled("rewritten", &journal, &[]);
    let file = journal.join("checkpoints").join("a.checkpoint");
    let put = |token: &str| assert!(fs::copy(files.join(format!("{token}.checkpoint")), &file).unwrap() > 0);
    put("a");
    let simulation = daemon.connect();
    simulation.restore("a").unwrap();
    simulation.step(30).unwrap();
    daemon.kill();
    put("b");
    let (is_content, said) = replay(&journal, "1");
    assert!(!is_content && said.contains("\"a\", which has been written over since: it holds step 40"), "{said}");
    fs::remove_file(&file).unwrap();
    let (is_content, said) = replay(&journal, "1");
    assert!(!is_content && said.contains("\"a\", which is no more there"), "{said}");
    put("a");
    let (is_content, said) = replay(&journal, "1");
    assert!(is_content, "{said}");
    [journal, files].iter().for_each(|folder| fs::remove_dir_all(folder).unwrap());
}
