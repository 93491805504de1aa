//! Every limit against the real daemon: the error names the setting, and what was there stays as it was.

mod common;

use std::fs;

use common::{Daemon, folder, scene};
use sturz_client::v1::{ErrorCode, RunState};
use sturz_client::{ClientError, FieldDefinition, FloatType, Insertion, Placement, Refusal, Simulation, v1};

/// Serves an empty scene with these limits.
fn serve(name: &str, limits: &str) -> (Daemon, Simulation) {
    let path = folder(&format!("{name}-limits")).join("limits.toml");
    fs::write(&path, limits).unwrap();
    let daemon = Daemon::serve(name, scene(), &["--limits", path.to_str().unwrap()]);
    let simulation = daemon.connect();
    (daemon, simulation)
}

/// The refusal, which must name `setting`.
fn meets<T: std::fmt::Debug>(setting: &str, answer: Result<T, ClientError>) -> Refusal {
    let refusal = answer.unwrap_err().refusal().cloned().expect("refused by the daemon");
    assert!(refusal.message.contains(&format!("(limit `{setting}`)")), "{refusal}");
    refusal
}

fn beads(positions_m: Vec<[f64; 3]>) -> Insertion {
    Insertion::new("bead", "glass", Placement::poses(positions_m))
}

fn row(count: usize) -> Insertion {
    beads((0..count).map(|k| [0.01 * k as f64, 0.0, 0.0]).collect())
}

#[test]
fn each_limit_names_its_setting() {
    let limits = "message_bytes = 2000\ninsertion_particles = 20\nparticles = 30\nfields = 1\nfield_cells = 8\n\
                  checkpoints = 1\ncheckpoint_bytes = 100000\n";
    let (_daemon, simulation) = serve("limits", limits);
    let code = |refusal: Refusal| refusal.code;
    assert_eq!(code(meets("message_bytes", simulation.insert(row(500)))), ErrorCode::TooLarge);
    assert_eq!(code(meets("insertion_particles", simulation.insert(row(21)))), ErrorCode::TooLarge);
    simulation.insert(row(20)).unwrap();
    assert_eq!(code(meets("particles", simulation.insert(row(11)))), ErrorCode::TooLarge);

    let field = |name: &str, cells: [u32; 3]| {
        simulation.define_field(FieldDefinition {
            name: name.into(),
            min_m: [0.0; 3],
            max_m: [0.01; 3],
            cells,
            quantities: vec![v1::FieldQuantity::SolidFraction],
            width_m: 0.01,
            ..Default::default()
        })
    };
    meets("field_cells", field("a", [3, 3, 1]));
    field("a", [2, 2, 2]).unwrap();
    meets("fields", field("b", [1, 1, 1]));
    field("a", [1, 2, 2]).unwrap();

    simulation.checkpoint("a").unwrap();
    meets("checkpoints", simulation.checkpoint("b"));
    simulation.checkpoint("a").unwrap();

    let state = simulation.state(&["ids"], FloatType::F64).unwrap();
    assert_eq!(state.ids().unwrap().len(), 20, "what was refused has changed nothing");
    assert_eq!(simulation.features().unwrap().limits.unwrap().message_bytes, 2000);
}

#[test]
fn bytes_of_checkpoints_are_limited() {
    let (_daemon, simulation) = serve("checkpoint-bytes", "checkpoint_bytes = 1000");
    simulation.insert(row(100)).unwrap();
    meets("checkpoint_bytes", simulation.checkpoint("a"));
    assert!(simulation.checkpoints().unwrap().is_empty());
}

/// Commands for later stay unanswered: as many as may be open fill the daemon.
#[test]
fn requests_that_are_open_are_limited() {
    let (_daemon, simulation) = serve("open-requests", "open_requests = 2");
    // On their way in this order, on one connection: both are in before the question is.
    let waiting = [10.0, 20.0].map(|time_s| simulation.later(time_s).set_gravity([0.0; 3]).unwrap());
    assert_eq!(meets("open_requests", simulation.info()).code, ErrorCode::Busy);
    drop(waiting);
}

#[test]
fn a_heap_in_one_place_fails_the_run_before_it_takes_the_memory() {
    let (_daemon, simulation) = serve("pairs", "pairs = 1000");
    simulation.insert(row(45)).unwrap();
    simulation.step(1).unwrap();
    simulation.checkpoint("before").unwrap();
    // 46 more in one place make 1035 pairs among themselves.
    simulation.insert(beads(vec![[0.0, 0.0, 1.0]; 46])).unwrap();
    let error = simulation.step(1).unwrap_err();
    let refusal = error.refusal().cloned().expect("refused by the daemon");
    assert_eq!(refusal.code, ErrorCode::RunFailed);
    assert!(refusal.message.contains("more than 1000 candidate pairs"), "{refusal}");
    assert!(refusal.message.contains("(limit `pairs`)"), "{refusal}");
    assert_eq!(simulation.info().unwrap().state(), RunState::Failed);
    simulation.restore("before").unwrap();
    assert_eq!(simulation.step(1).unwrap().step, 2, "a saved state goes on");
}
