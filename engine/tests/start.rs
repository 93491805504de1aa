//! Scenes that start with the bed of another one.

mod common;

use std::sync::Arc;

use common::{engine, header, plane, shape, steps};
use sturz_engine::scene::{FileBytes, Scene, SceneDescription, StartSection};
use sturz_engine::{Command, Engine, Snapshot};

const PAIR: &str = "stiffness_n_per_m = 1e4\nrestitution = 0.5\nfriction = 0.5";

fn snapshot(engine: &Engine) -> Snapshot {
    let mut snapshot = Snapshot::default();
    engine.snapshot(&mut snapshot);
    engine.snapshot_forces(&mut snapshot);
    snapshot
}

/// Cubes on a floor, the lowest of them frozen.
fn cubes(insertions: bool) -> String {
    let mut text = header([0.0, 0.0, -9.81], 1e-5, "", PAIR);
    text += "[domain]\nmin_m = [0.0, 0.0, 0.0]\nmax_m = [0.08, 0.08, 0.0]\nperiodic = [true, true, false]\n";
    text += &shape("kind = \"box\", size_m = [0.01, 0.01, 0.01]");
    text += &plane("floor", [0.0; 3], [0.0, 0.0, 1.0]);
    if insertions {
        text += "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nfrozen = true\nplacement = { method = \"lattice\", origin_m = [0.01, 0.01, 0.006], spacing_m = [0.02, 0.02, 0.0], counts = [4, 4, 1], random_orientation = true }\n";
        text += "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nscale = { min = 0.9, max = 1.1 }\nplacement = { method = \"lattice\", origin_m = [0.01, 0.01, 0.025], spacing_m = [0.02, 0.02, 0.018], counts = [4, 4, 2], random_orientation = true }\n";
    }
    text
}

fn started(text: &str, bytes: &[u8]) -> Result<Scene, String> {
    let mut description = SceneDescription::from_toml(text).unwrap();
    description.start =
        Some(StartSection { checkpoint: "bed.sturz".into(), bytes: FileBytes(Arc::new(bytes.to_vec())) });
    Scene::validate(description).map_err(|error| error.to_string())
}

fn prepared() -> (Engine, Vec<u8>) {
    let mut engine = engine(&cubes(true));
    engine.apply(&Command::Remove(vec![3, 20, 21])).unwrap();
    steps(&mut engine, 14_000);
    assert!(engine.report().contact_points > 20);
    let bytes = engine.prepared().unwrap();
    (engine, bytes)
}

fn line(scene: &Scene) -> String {
    scene.plan().lines.iter().find(|line| line.starts_with("start: ")).cloned().unwrap_or_default()
}

/// The same scene goes on from the bed as from its checkpoint: the same state, and the same forces but for the velocities
/// that the checkpoint's were found with.
#[test]
fn the_same_scene_goes_on() {
    let (before, bytes) = prepared();
    let scene = started(&cubes(false), &bytes).unwrap();
    assert!(
        line(&scene).contains("45 particles of 'test' at 0.14 s, from bed.sturz; contact history kept"),
        "{}",
        line(&scene)
    );
    let mut after = Engine::new(scene);
    let (old, new) = (snapshot(&before), snapshot(&after));
    assert_eq!((new.step, new.time_s, new.ids.clone()), (0, 0.0, (0..45).collect::<Vec<u64>>()));
    assert_eq!(
        (&new.positions, &new.orientations, &new.velocities),
        (&old.positions, &old.orientations, &old.velocities)
    );
    assert_eq!((&new.scales, &new.frozen), (&old.scales, &old.frozen));
    let size = old.forces.iter().flatten().fold(0.0f64, |most, f| most.max(f.abs()));
    for (a, b) in old.forces.iter().zip(&new.forces) {
        // dashpots see the velocity of another half step
        assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-2 * size), "{a:?} {b:?}");
    }
    // sliding contacts cut their springs by a force that has the dashpot in it
    let kept = after.report().energy.elastic_j / before.report().energy.elastic_j;
    assert!((kept - 1.0).abs() < 0.01, "{kept}");
    // a particle that is inserted later has an id of its own
    steps(&mut after, 100);
    let mut twin = Engine::new(started(&cubes(false), &bytes).unwrap());
    twin.set_threads(3);
    steps(&mut twin, 100);
    assert_eq!(after.state_hash(), twin.state_hash());
    let saved = after.checkpoint().unwrap();
    let mut third = Engine::new(started(&cubes(false), &bytes).unwrap());
    third.restore(&saved).unwrap();
    steps(&mut third, 50);
    steps(&mut twin, 50);
    assert_eq!(third.state_hash(), twin.state_hash());
}

/// It is a checkpoint, too.
#[test]
fn what_is_prepared_can_be_restored() {
    let (mut before, bytes) = prepared();
    let mut other = engine(&cubes(true));
    other.restore(&bytes).unwrap();
    assert_eq!(other.state_hash(), before.state_hash());
    steps(&mut before, 20);
    steps(&mut other, 20);
    assert_eq!(other.state_hash(), before.state_hash());
}

/// Other laws, another gravity, no floor, another order of shapes and materials, new particles on top.
#[test]
fn another_scene_takes_the_bed() {
    let (before, bytes) = prepared();
    let other = cubes(false)
        .replace("[0.0, 0.0, -9.81]", "[1.0, 0.0, -9.0]")
        .replace("friction = 0.5", "friction = 0.4")
        .replace("density_kg_per_m3 = 2500.0", "density_kg_per_m3 = 5000.0")
        .replace(
            "[[shape]]",
            "[[shape]]\nname = \"ball\"\ngeometry = { kind = \"sphere\", radius_m = 4e-3 }\n[[shape]]",
        )
        .replace("[[material]]\nname = \"m\"", "[[material]]\nname = \"x\"\n[[material]]\nname = \"m\"");
    let floor = other.find("[[boundary]]").unwrap();
    let text = other[..floor].to_string()
        + "[[insertion]]\nshape = \"ball\"\nmaterial = \"m\"\nplacement = { method = \"deposition\", count = 5, region = { kind = \"box\", min_m = [0.0, 0.0, 0.0], max_m = [0.08, 0.08, 1.0] } }\n";
    let scene = started(&text, &bytes).unwrap();
    assert!(line(&scene).ends_with("contact history dropped: [[material_pair]] differs"), "{}", line(&scene));
    let mut after = Engine::new(scene);
    let (old, new) = (snapshot(&before), snapshot(&after));
    assert_eq!(new.ids.len(), 50);
    assert_eq!(new.positions[..45], old.positions);
    assert_eq!(new.shapes, [vec![1; 45], vec![0; 5]].concat());
    assert_eq!(new.materials, vec![1; 50]);
    assert_eq!(after.report().touching_boundary_pairs, 0);
    let kinetic = |engine: &Engine| {
        let energy = engine.report().energy;
        energy.kinetic_translation_j + energy.kinetic_rotation_j
    };
    assert!((kinetic(&after) / kinetic(&before) - 2.0).abs() < 1e-9, "twice the density");
    steps(&mut after, 10);
}

/// Walls that differ take their own springs with them, and no others.
#[test]
fn springs_at_other_walls_are_dropped() {
    let (_, bytes) = prepared();
    let text = cubes(false) + &plane("lid", [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
    let scene = started(&text, &bytes).unwrap();
    assert!(
        line(&scene).ends_with("contact history kept, but for that at boundaries: [[boundary]] differs"),
        "{}",
        line(&scene)
    );
    let turning = cubes(false).replace(
        "normal = [0.0, 0.0, 1.0] }",
        "normal = [0.0, 0.0, 1.0] }\nmotion = { kind = \"translation\", velocity_m_per_s = [0.1, 0.0, 0.0] }",
    );
    let scene = started(&turning, &bytes).unwrap();
    assert!(line(&scene).ends_with("contact history kept"), "{}", line(&scene));
}

#[test]
fn what_cannot_be_taken_is_refused_with_the_reason() {
    let (engine, bytes) = prepared();
    let refused = |text: &str, bytes: &[u8]| started(text, bytes).err().unwrap_or_default();
    for (from, to, told) in [
        (
            "size_m = [0.01, 0.01, 0.01]",
            "size_m = [0.01, 0.01, 0.011]",
            "particles of the shape 's', which the scene does not have",
        ),
        ("name = \"s\"", "name = \"t\"", "particles of the shape 's', which the scene does not have"),
        ("max_m = [0.08, 0.08, 0.0]", "max_m = [0.08, 0.09, 0.0]", "differs along y"),
        ("periodic = [true, true, false]", "periodic = [true, false, false]", "differs along y"),
    ] {
        let text = cubes(false).replace(from, to);
        assert!(refused(&text, &bytes).contains(told), "{to}: {}", refused(&text, &bytes));
    }
    let plain = engine.checkpoint().unwrap();
    assert!(refused(&cubes(false), &plain).contains("has no scene in it: only what `sturz prepare`"));
    assert!(refused(&cubes(false), &bytes[..bytes.len() - 1]).contains("cut short"));
    assert!(refused(&cubes(false), &[]).contains("start.checkpoint: 'bed.sturz' was not read"));
    let mut broken = bytes.clone();
    broken[100] ^= 1;
    assert!(refused(&cubes(false), &broken).contains("is damaged"));
}
