//! Stages: laws that change on the way.

mod common;

use common::{engine, header, plane, shape, steps};
use sturz_engine::scene::{Scene, SceneDescription};
use sturz_engine::{Command, Engine, Happening, Snapshot};

const PAIR: &str = "stiffness_n_per_m = 1e4\nrestitution = 0.6\nfriction = 0.5";

fn snapshot(engine: &Engine) -> Snapshot {
    let mut snapshot = Snapshot::default();
    engine.snapshot(&mut snapshot);
    engine.snapshot_forces(&mut snapshot);
    snapshot
}

/// One sphere on a floor, in it by its weight's overlap at unit factors.
fn resting(stages: &str) -> String {
    let overlap = mass() * 9.81 / 1e4;
    header([0.0, 0.0, -9.81], 1e-5, "", PAIR)
        + &shape("kind = \"sphere\", radius_m = 5e-3")
        + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
        + &common::particle([0.0, 0.0, 5e-3 - overlap], [0.0; 3], [0.0; 3])
        + stages
}

/// kg
fn mass() -> f64 {
    2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 5e-3f64.powi(3)
}

/// Force of the floor at the start of each stage: spring times factor, at the same place.
#[test]
fn factors_act_from_the_first_step_of_a_stage() {
    let stages = "[[stage]]\nname = \"a\"\nsteps = 3\nstiffness_factor = 2.0\n[[stage]]\nname = \"b\"\ntime_s = 4e-5\ngravity_factor = 0.5\n[[stage]]\nsteps = 2\nstiffness_factor = 0.25\n";
    // without dashpots, which see the velocity that a stage leaves
    let mut engine = engine(&resting(stages).replace("restitution = 0.6", "restitution = 1.0"));
    let weight = mass() * 9.81;
    let force = |engine: &Engine| snapshot(engine).forces[0][2] / weight;
    let gravity = |engine: &Engine| snapshot(engine).gravity_m_per_s2[2];
    assert_eq!(engine.stage().map(|(index, stage)| (index, stage.name.as_str())), Some((0, "a")));
    assert!((force(&engine) - 2.0).abs() < 1e-12);
    steps(&mut engine, 3);
    // a few steps move it by little: the spring of the new stage acts at once
    assert_eq!(engine.stage().map(|(index, _)| index), Some(1));
    assert!((force(&engine) - 1.0).abs() < 0.02 && gravity(&engine) == -4.905, "{}", force(&engine));
    steps(&mut engine, 4);
    assert_eq!(engine.stage().map(|(index, _)| index), Some(2));
    assert!((force(&engine) - 0.25).abs() < 0.02 && gravity(&engine) == -9.81);
    engine.apply(&Command::SetGravity([0.0, 0.0, -3.0])).unwrap();
    steps(&mut engine, 2);
    assert!(engine.stage().is_none() && !engine.has_stages_ahead());
    assert!(
        (force(&engine) - 1.0).abs() < 0.1 && gravity(&engine) == -3.0,
        "behind the last one the scene's own laws hold"
    );
    let told = engine.take_happenings();
    let began = |index: usize, name: &str| Happening::StageBegan { index, name: name.into() };
    assert_eq!(told, [began(0, "a"), began(1, "b"), began(2, ""), Happening::StagesOver]);
    let energy = engine.report().energy;
    // what the factors bring in is booked; the rest is the integrator's, of a motion that has hardly begun
    assert!(energy.residual_j.abs() < 1e-3 * energy.work_commands_j.abs(), "{energy:?}");
}

/// A stage with factors is, to the bit, a run of the scene that has the products.
#[test]
fn a_stage_is_the_scene_with_other_numbers() {
    let bed = |pair: &str, rest: &str| {
        header([0.0, 0.0, -9.81], 1e-5, "", pair)
            + &shape("kind = \"box\", size_m = [0.01, 0.01, 0.01]")
            + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
            + "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nplacement = { method = \"lattice\", origin_m = [0.0, 0.0, 0.01], spacing_m = [0.0, 0.0, 0.02], counts = [1, 1, 3], random_orientation = true }\n"
            + rest
    };
    let staged = bed(
        "stiffness_n_per_m = 1e4\nrestitution = 0.6\nfriction = 0.5",
        "[[stage]]\nstiffness_factor = 0.5\nfriction_factor = 0.5\nrestitution = 0.25\nlocal_damping = 0.25\ngravity_factor = 2.0\n",
    );
    let plain =
        bed("stiffness_n_per_m = 5e3\nrestitution = 0.25\nfriction = 0.25", "[integrator]\nlocal_damping = 0.25\n")
            .replace("[0.0, 0.0, -9.81]", "[0.0, 0.0, -19.62]");
    let (mut staged, mut plain) = (engine(&staged), engine(&plain));
    steps(&mut staged, 12_000);
    steps(&mut plain, 12_000);
    assert!(staged.report().contact_points > 0);
    assert_eq!(snapshot(&staged), snapshot(&plain));
}

/// Rest is found where motion has died out, and not in free fall, nor at the top of a bounce.
#[test]
fn a_stage_ends_at_rest() {
    let fall = |limit: &str| {
        resting(&format!("[[stage]]\nname = \"fall\"\n{limit}\n[[stage]]\nname = \"after\"\n"))
            .replace(&format!("{:?}", 5e-3 - mass() * 9.81 / 1e4), "0.007")
            + &common::particle([0.1, 0.0, 0.02], [0.0; 3], [0.0; 3])
    };
    for limit in [
        "kinetic_over_potential = 1e-6",
        "kinetic_over_elastic = 1e-6",
        "kinetic_over_elastic = 1e-6\nkinetic_over_potential = 1e-3",
    ] {
        let text = fall(limit).replace("[[boundary]]", "[[boundary]]\nname = \"step\"\nmaterial = \"w\"\ngeometry = { kind = \"mesh\", vertices_m = [[0.05, -1.0, 0.004], [1.0, -1.0, 0.004], [1.0, 1.0, 0.004], [0.05, 1.0, 0.004]], triangles = [[0, 1, 2], [0, 2, 3]] }\n[[boundary]]");
        let mut engine = engine(&text);
        while engine.stage().map(|(index, _)| index) == Some(0) {
            steps(&mut engine, 100);
            assert!(engine.clock().step() < 400_000, "{limit}: never at rest");
        }
        let energy = engine.report().energy;
        let kinetic = energy.kinetic_translation_j + energy.kinetic_rotation_j;
        assert!(kinetic < 1e-6 * mass() * 9.81 * 0.004 || kinetic < 1e-6 * energy.elastic_j, "{limit}: {kinetic}");
        let heights: Vec<f64> = snapshot(&engine).positions.iter().map(|x| x[2]).collect();
        assert!((heights[0] - 5e-3).abs() < 1e-4 && (heights[1] - 9e-3).abs() < 1e-4, "{limit}: {heights:?}");
    }
}

/// A checkpoint in the middle of a stage, and one at the very step of a change.
#[test]
fn checkpoints_know_the_stage() {
    let text = resting(
        "[[stage]]\nsteps = 50\nstiffness_factor = 0.5\nfriction_factor = 0.0\n[[stage]]\nsteps = 50\nlocal_damping = 0.7\n[[stage]]\ntime_s = 1e-3\nrestitution = 0.3\n",
    );
    for before in [20, 50, 77, 100, 230] {
        let mut run = engine(&text);
        steps(&mut run, before);
        let saved = run.checkpoint().unwrap();
        let mut other = engine(&text);
        other.set_threads(2);
        other.restore(&saved).unwrap();
        assert_eq!(other.stage().map(|(index, _)| index), run.stage().map(|(index, _)| index));
        assert_eq!(other.state_hash(), run.state_hash(), "{before}");
        steps(&mut run, 150);
        steps(&mut other, 150);
        assert_eq!(other.state_hash(), run.state_hash(), "{before}");
        // and back again, into the stage that it was in
        run.restore(&saved).unwrap();
        steps(&mut run, 150);
        assert_eq!(other.state_hash(), run.state_hash(), "{before}: after going back");
    }
    let saved = engine(&text).checkpoint().unwrap();
    let refused = engine(&resting("")).restore(&saved).unwrap_err().to_string();
    assert!(refused.contains("[stage]"), "{refused}");
}

#[test]
fn bad_stages_are_refused_by_name() {
    let refusal = |stages: &str| {
        let scene = Scene::validate(SceneDescription::from_toml(&resting(stages)).unwrap());
        scene.err().map(|error| error.to_string()).unwrap_or_default()
    };
    for (stages, told) in [
        (
            "[[stage]]\nname = \"stiff\"\nsteps = 5\nstiffness_factor = 1e6\n",
            "above the critical one of a single contact in stage 'stiff'",
        ),
        ("[[stage]]\n[[stage]]\nsteps = 5\n", "stage[0]: has no end, and a stage follows"),
        ("[[stage]]\nsteps = 5\nstiffness_factor = 0.0\n", "stage[0].stiffness_factor: is 0"),
        ("[[stage]]\nsteps = 5\ndamping_factor = 2.0\n", "stage[0].damping_factor: is for dashpots"),
        (
            "[[stage]]\nname = \"b\"\nsteps = 5\nrestitution = 1.5\n",
            "in stage 'b', material_pair[0].restitution: is 1.5",
        ),
        ("[[stage]]\nsteps = 5\nlocal_damping = 1.0\n", "in stage 0, integrator.local_damping: is 1"),
        (
            "[[stage]]\nsteps = 5\nrestitution = 0.5\ndamping_n_s_per_m = 1.0\n",
            "stage[0]: give restitution or damping_n_s_per_m",
        ),
        ("[[stage]]\nsteps = 5\nafter_s = 1.0\n", "stage[0].after_s: does nothing"),
    ] {
        assert!(refusal(stages).contains(told), "{stages}: {}", refusal(stages));
    }
}

/// `time_step = "auto"` obeys the stiffest stage.
#[test]
fn automatic_step_is_that_of_the_stiffest_stage() {
    let auto = |stages: &str| {
        let text = resting(stages).replace("time_step_s = 1e-5", "time_step = \"auto\"");
        Scene::validate(SceneDescription::from_toml(&text).unwrap()).unwrap().time_step_s()
    };
    let (plain, stiff) = (auto(""), auto("[[stage]]\nsteps = 5\nstiffness_factor = 16.0\n"));
    assert!((plain / stiff - 4.0).abs() < 1e-9, "{plain} {stiff}");
    assert_eq!(auto("[[stage]]\nsteps = 5\nstiffness_factor = 0.1\n"), plain);
}
