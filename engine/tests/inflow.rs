//! Particles that come in over time.

mod common;

use common::{engine, header, plane, shape, steps};
use sturz_engine::scene::{Scene, SceneDescription};
use sturz_engine::{Engine, Happening, Snapshot};

const PAIR: &str = "stiffness_n_per_m = 1e4\nrestitution = 0.6\nfriction = 0.3";

fn scene(inflow: &str) -> String {
    header([0.0, 0.0, -9.81], 1e-5, "", PAIR)
        + &shape("kind = \"sphere\", radius_m = 2e-3")
        + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
        + "[[inflow]]\nname = \"window\"\nshape = \"s\"\nmaterial = \"m\"\nregion = { kind = \"box\", min_m = [0.0, 0.0, 0.1], max_m = [0.03, 0.03, 0.11] }\n"
        + inflow
}

fn snapshot(engine: &Engine) -> Snapshot {
    let mut snapshot = Snapshot::default();
    engine.snapshot(&mut snapshot);
    snapshot
}

/// Mass of one particle at unit scale, kg.
fn mass() -> f64 {
    2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 8e-9
}

/// Batches at 0, 0.01, ...: each brings what its interval is to bring; the last one what is left.
#[test]
fn particles_come_at_the_rate() {
    let mut engine =
        engine(&scene("rate_per_s = 450.0\ninterval_s = 0.01\ncount = 20\nvelocity_m_per_s = [0.0, 0.0, -0.5]\n"));
    assert_eq!(engine.len(), 0);
    let epoch = engine.topology_epoch();
    let mut seen = Vec::new();
    for _ in 0..5 {
        steps(&mut engine, 1);
        let new = snapshot(&engine);
        assert!(new.velocities.last().unwrap()[2] < -0.5 && new.velocities.last().unwrap()[2] > -0.51);
        assert!(new.positions.last().unwrap()[2] > 0.1);
        seen.push(engine.len());
        steps(&mut engine, 999);
    }
    // 4.5 per batch: whole particles of what is due
    assert_eq!(seen, [4, 9, 13, 18, 20]);
    assert_eq!(engine.topology_epoch(), epoch + 5);
    assert!(!engine.has_inflow_ahead());
    let told = engine.take_happenings();
    assert_eq!(told[0], Happening::Inflow { index: 0, first_id: 0, count: 4 });
    assert_eq!(told.last(), Some(&Happening::InflowOver { index: 0, count: 20 }));
    assert_eq!(told.len(), 6);
    let report = engine.report();
    assert!(report.energy.residual_j.abs() < 1e-6 * report.energy.work_commands_j.abs(), "{:?}", report.energy);
}

#[test]
fn mass_rates_times_and_sizes() {
    let by_mass = format!(
        "mass_rate_kg_per_s = {:?}\ninterval_s = 0.01\nmass_kg = {:?}\nscale = {{ min = 0.5, max = 1.0 }}\n",
        500.0 * mass(),
        10.0 * mass()
    );
    let mut engine_by_mass = engine(&scene(&by_mass));
    steps(&mut engine_by_mass, 1);
    let volume = |engine: &Engine| snapshot(engine).scales.iter().map(|scale| scale.powi(3)).sum::<f64>();
    // until it is reached: by at most one particle more
    assert!((5.0..6.0).contains(&volume(&engine_by_mass)), "{}", volume(&engine_by_mass));
    steps(&mut engine_by_mass, 3000);
    assert!((10.0..11.0).contains(&volume(&engine_by_mass)), "{}", volume(&engine_by_mass));
    assert!(!engine_by_mass.has_inflow_ahead());

    let by_time = "rate_per_s = 100.0\ninterval_s = 0.01\nstart_s = 0.015\nend_s = 0.0351\n";
    let mut engine_by_time = engine(&scene(by_time));
    steps(&mut engine_by_time, 1500);
    assert_eq!(engine_by_time.len(), 0);
    steps(&mut engine_by_time, 1);
    assert_eq!(engine_by_time.len(), 1);
    steps(&mut engine_by_time, 4000);
    assert_eq!(engine_by_time.len(), 3, "at 0.015, 0.025 and 0.035 s");
}

/// A window that is full is no error: what finds no room is owed, told of, and comes later.
#[test]
fn full_window_is_a_warning() {
    let flood = "rate_per_s = 1e5\ninterval_s = 0.01\ncount = 60\nattempts = 50\nvelocity_m_per_s = [0.0, 0.0, -2.0]\n";
    let mut run = engine(&scene(flood));
    steps(&mut run, 1);
    let first = run.len();
    assert!((10..60).contains(&first), "{first}");
    assert!(run.take_happenings().contains(&Happening::InflowShort { index: 0, total: 1 }));
    steps(&mut run, 5000);
    assert_eq!(run.len(), 60);
    let largest = run.report().largest_overlap_ratio_so_far;
    assert!(largest < 0.2, "{largest}: nobody came in on top of another");
}

/// From a checkpoint in the middle of it, on other threads, the same particles come to the same places.
#[test]
fn checkpoints_go_on_with_it() {
    let text = scene(
        "rate_per_s = 2000.0\ninterval_s = 0.005\ncount = 200\nscale = { law = \"normal\", mean = 0.8, standard_deviation = 0.2, min = 0.5, max = 1.0 }\n",
    );
    let mut run = engine(&text);
    steps(&mut run, 3001);
    let saved = run.checkpoint().unwrap();
    let mut other = engine(&text);
    other.set_threads(3);
    other.restore(&saved).unwrap();
    assert_eq!(other.state_hash(), run.state_hash());
    for _ in 0..4 {
        steps(&mut run, 1000);
        steps(&mut other, 1000);
        assert_eq!(other.state_hash(), run.state_hash());
        assert_eq!(snapshot(&other).ids, snapshot(&run).ids);
    }
    assert!(run.len() > 100);
    let faster = text.replace("rate_per_s = 2000.0", "rate_per_s = 3000.0");
    let refused = engine(&faster).restore(&saved).unwrap_err().to_string();
    assert!(refused.contains("[inflow]"), "{refused}");
}

#[test]
fn bad_inflows_are_refused() {
    let refusal = |inflow: &str| {
        let scene = Scene::validate(SceneDescription::from_toml(&scene(inflow)).unwrap());
        scene.err().map(|error| error.to_string()).unwrap_or_default()
    };
    for (inflow, told) in [
        ("interval_s = 0.01\ncount = 3\n", "inflow[0]: give rate_per_s or mass_rate_kg_per_s"),
        ("rate_per_s = 1.0\ninterval_s = 0.0\ncount = 3\n", "inflow[0].interval_s: is 0"),
        ("rate_per_s = 1.0\ninterval_s = 0.1\n", "inflow[0]: never ends"),
        (
            "rate_per_s = 1.0\ninterval_s = 0.1\ncount = 3\nscale = { min = 3.0, max = 3.0 }\n",
            "which must lie inside, needs 1.2e-2 m",
        ),
        (
            "rate_per_s = 1.0\ninterval_s = 0.1\ncount = 3\nscale = { min = 0.05, max = 1.0 }\n",
            "scene.time_step_s: the time step",
        ),
    ] {
        assert!(refusal(inflow).contains(told), "{inflow}: {}", refusal(inflow));
    }
    let unknown = scene("rate_per_s = 1.0\ninterval_s = 0.1\ncount = 3\n")
        .replace("[[inflow]]\nname = \"window\"\nshape = \"s\"", "[[inflow]]\nshape = \"t\"");
    let error = Scene::validate(SceneDescription::from_toml(&unknown).unwrap()).unwrap_err().to_string();
    assert!(error.contains("inflow[0].shape: 't' is not defined"), "{error}");
}
