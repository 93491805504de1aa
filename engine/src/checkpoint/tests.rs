//! Damaged, cut, foreign and forged checkpoints: refused with the reason, never a panic, and the engine is as it was.

use proptest::prelude::*;
use proptest::sample::Index;

use super::container::{FORMAT, Sections};
use super::{CheckpointError, CheckpointSummary};
use crate::scene::{Scene, SceneDescription};
use crate::{Command, Engine};

/// A servo presses spheres and a cube onto a floor, in a cell that is periodic along x: every section has something.
const SCENE: &str = r#"
[scene]
name = "press"
gravity_m_per_s2 = [0.1, 0.0, -9.81]
time_step_s = 1e-5
[domain]
min_m = [0.0, 0.0, 0.0]
max_m = [0.08, 0.0, 0.0]
periodic = [true, false, false]
[contact]
normal = "linear"
[[material]]
name = "m"
density_kg_per_m3 = 2500.0
[[material_pair]]
materials = ["m", "m"]
stiffness_n_per_m = 1e5
restitution = 0.5
friction = 0.4
[[shape]]
name = "ball"
geometry = { kind = "sphere", radius_m = 0.005 }
[[shape]]
name = "cube"
geometry = { kind = "cube", edge_m = 0.01 }
[[boundary]]
name = "floor"
material = "m"
geometry = { kind = "plane", point_m = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }
[[boundary]]
name = "lid"
material = "m"
geometry = { kind = "plane", point_m = [0.0, 0.0, 0.01], normal = [0.0, 0.0, -1.0] }
motion = { kind = "servo", direction = [0.0, 0.0, -1.0], force_n = 2.0, gain_m_per_s_per_n = 1e-3, max_velocity_m_per_s = 0.02 }
[[insertion]]
shape = "ball"
material = "m"
velocity_m_per_s = [-0.2, 0.0, 0.0]
placement = { method = "poses", positions_m = [[0.001, 0.0, 0.005], [0.0109, 0.0, 0.005]] }
[[insertion]]
shape = "cube"
material = "m"
placement = { method = "poses", positions_m = [[0.03, 0.0, 0.005]] }
"#;

fn engine(text: &str) -> Engine {
    Engine::new(Scene::validate(SceneDescription::from_toml(text).unwrap()).unwrap_or_else(|error| panic!("{error}")))
}

fn steps(engine: &mut Engine, n: usize) {
    (0..n).for_each(|_| engine.step().unwrap());
}

/// The engine after 300 steps, and a checkpoint of step 200.
fn saved() -> (Engine, Vec<u8>) {
    let mut engine = engine(SCENE);
    steps(&mut engine, 200);
    let saved = engine.checkpoint().unwrap();
    assert!(engine.contacts.springs(&engine.particles).len() >= 4, "springs of spheres, of the cube and at walls");
    steps(&mut engine, 100);
    (engine, saved)
}

#[test]
fn cut_anywhere_it_is_refused() {
    let (mut engine, saved) = saved();
    let before = engine.state_hash();
    for length in 0..saved.len() {
        let error = engine.restore(&saved[..length]).unwrap_err();
        match error {
            CheckpointError::NoCheckpoint => assert!(length < 20),
            CheckpointError::WrongLength { found, wanted } => {
                assert_eq!((found, wanted), (length as u64, saved.len() as u64));
            }
            other => panic!("cut to {length}: {other}"),
        }
        assert!(CheckpointSummary::read(&saved[..length]).is_err());
    }
    let longer = [saved.as_slice(), &[0]].concat();
    assert!(matches!(engine.restore(&longer), Err(CheckpointError::WrongLength { .. })));
    assert_eq!(engine.state_hash(), before);
    engine.restore(&saved).unwrap();
    assert_eq!(engine.clock().step(), 200);
}

#[test]
fn every_flipped_bit_is_noticed() {
    let (mut engine, mut saved) = saved();
    let before = engine.state_hash();
    for at in 0..saved.len() {
        for bit in 0..8 {
            saved[at] ^= 1 << bit;
            let error = engine.restore(&saved).unwrap_err();
            let fits = match error {
                CheckpointError::NoCheckpoint => at < 8,
                CheckpointError::OtherFormat { .. } => (8..12).contains(&at),
                CheckpointError::WrongLength { .. } => (12..20).contains(&at),
                CheckpointError::Damaged { .. } => at >= 20,
                _ => false,
            };
            assert!(fits, "bit {bit} of byte {at}: {error}");
            saved[at] ^= 1 << bit;
        }
    }
    assert_eq!(engine.state_hash(), before);
}

#[test]
fn a_newer_format_is_named() {
    let (mut engine, mut saved) = saved();
    saved[8..12].copy_from_slice(&(FORMAT + 1).to_le_bytes());
    let error = engine.restore(&saved).unwrap_err();
    assert_eq!(error, CheckpointError::OtherFormat { found: FORMAT + 1, known: FORMAT });
    assert!(error.to_string().contains("format 2, this program reads format 1"), "{error}");
}

#[test]
fn another_scene_is_refused_and_what_differs_is_named() {
    let (_, saved) = saved();
    let refusal = |from: &str, to: &str| {
        let mut other = engine(&SCENE.replacen(from, to, 1));
        let before = other.state_hash();
        let refused = other.restore(&saved);
        assert_eq!(other.state_hash() == before, refused.is_err());
        refused
    };
    let differing = |sections: &[&'static str]| Err(CheckpointError::OtherScene { differing: sections.to_vec() });
    assert_eq!(refusal("friction = 0.4", "friction = 0.41"), differing(&["material_pair"]));
    assert_eq!(refusal("edge_m = 0.01", "edge_m = 0.0100001"), differing(&["shape"]));
    assert_eq!(refusal("time_step_s = 1e-5", "time_step_s = 1e-6"), differing(&["scene"]));
    assert_eq!(refusal("max_m = [0.08", "max_m = [0.09"), differing(&["domain"]));
    assert_eq!(refusal("point_m = [0.0, 0.0, 0.01]", "point_m = [0.0, 0.0, 0.02]"), differing(&["boundary"]));
    let text = refusal("friction = 0.4", "friction = 0.3").unwrap_err().to_string();
    assert!(text.contains("[material_pair] differ"), "{text}");
    // what is state, or only a name, may differ
    assert_eq!(refusal("[0.1, 0.0, -9.81]", "[0.0, 0.0, 0.0]"), Ok(()));
    assert_eq!(refusal("name = \"press\"", "name = \"another\""), Ok(()));
    assert_eq!(refusal("force_n = 2.0", "force_n = 3.0"), Ok(()));
}

#[test]
fn a_failed_run_is_not_saved_and_may_go_back() {
    let (mut engine, saved) = saved();
    let steps_done = engine.clock().step();
    engine.apply(&Command::SetGravity([0.0, 0.0, -1e9])).unwrap();
    while engine.step().is_ok() {}
    assert!(matches!(engine.checkpoint(), Err(CheckpointError::RunFailed { .. })));
    engine.restore(&saved).unwrap();
    steps(&mut engine, 100);
    assert_eq!(engine.clock().step(), steps_done);
}

/// With another content, and a checksum that fits it.
fn forged(saved: &[u8], change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut content = saved[..saved.len() - 8].to_vec();
    change(&mut content);
    let length = content.len() as u64 + 8;
    content[12..20].copy_from_slice(&length.to_le_bytes());
    let checksum = xxhash_rust::xxh3::xxh3_64(&content);
    content.extend_from_slice(&checksum.to_le_bytes());
    assert!(Sections::open(&content).is_ok());
    content
}

/// Where the content of a section begins.
fn content_of(saved: &[u8], tag: &[u8; 4]) -> usize {
    saved.windows(4).position(|window| window == tag).unwrap() + 12
}

#[test]
fn impossible_values_are_refused_with_their_place() {
    let (mut engine, saved) = saved();
    let first_row = content_of(&saved, b"PART") + 8;
    let mut refusal = |at: usize, bytes: &[u8]| {
        let forged = forged(&saved, |content| content[at..at + bytes.len()].copy_from_slice(bytes));
        engine.restore(&forged).unwrap_err().to_string()
    };
    let row_bytes = 8 + 4 + 4 + 8 + 8 + 24 + 8 + 24 + 32 + 24 + 24 + 24 + 24 + 12;
    assert!(refusal(first_row, &u64::MAX.to_le_bytes()).contains("particles[0]: has an id"), "id");
    assert!(refusal(first_row + row_bytes + 8, &7u32.to_le_bytes()).contains("particles[1]: has a shape"));
    assert!(refusal(first_row + 16, &f64::NAN.to_le_bytes()).contains("particles[0]: has a scale"));
    assert!(refusal(first_row + 64, &1e300f64.to_le_bytes()).contains("outside of the periodic cell"));
    assert!(refusal(first_row + 88, &9.0f64.to_le_bytes()).contains("no unit quaternion"));
    assert!(refusal(first_row - 8, &u64::MAX.to_le_bytes()).contains("section PART counts more rows than it has"));
    // a value that is possible, and not the one that was saved
    assert!(refusal(first_row + 64, &0.0011f64.to_le_bytes()).contains("gives a state of hash"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Whatever the bytes between head and checksum are: a refusal that changes nothing, or a state that can step.
    #[test]
    fn forged_content_never_panics(
        edits in prop::collection::vec((any::<Index>(), any::<u8>()), 1..4),
        cut in prop::option::of(any::<Index>()),
    ) {
        let (mut engine, saved) = saved();
        let before = engine.state_hash();
        let forged = forged(&saved, |content| {
            for (at, byte) in &edits {
                let at = 20 + at.index(content.len() - 20);
                content[at] = *byte;
            }
            if let Some(cut) = cut {
                content.truncate(20 + cut.index(content.len() - 20));
            }
        });
        match engine.restore(&forged) {
            Err(_) => prop_assert_eq!(engine.state_hash(), before),
            Ok(()) => drop(engine.step()),
        }
    }
}
