//! Boundaries that press with a force.

mod common;
#[path = "common/meshes.rs"]
mod meshes;

use common::{engine, header, particle, plane, run_for, shape};
use meshes::{mesh, sheet};
use sturz_engine::scene::MotionDescription;
use sturz_engine::{Command, Engine, Snapshot};

fn snapshot(engine: &Engine) -> Snapshot {
    let mut snapshot = Snapshot::default();
    engine.snapshot(&mut snapshot);
    snapshot
}

/// Four balls upon each other, and a lid a little above.
fn column(lid: &str) -> String {
    let pair = "stiffness_n_per_m = 1e5\nrestitution = 0.4\nfriction = 0.3";
    let mut text = header([0.0, 0.0, -9.81], 1e-5, "", pair)
        + &shape("kind = \"sphere\", radius_m = 0.005")
        + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
        + lid;
    for k in 0..4 {
        text += &particle([0.0, 0.0, 0.005 + 0.01 * f64::from(k)], [0.0; 3], [0.0; 3]);
    }
    text
}

fn servo(target: &str) -> String {
    format!(
        "motion = {{ kind = \"servo\", direction = [0.0, 0.0, -2.0], {target}, gain_m_per_s_per_n = 1e-3, max_velocity_m_per_s = 0.02 }}\n"
    )
}

#[test]
fn a_lid_reaches_its_force_and_holds_it() {
    let mut flipped = sheet(4, [-0.02, 0.02, -0.02, 0.02], |_| 0.0402);
    flipped.1.iter_mut().for_each(|triangle| triangle.swap(0, 1));
    let lids = [
        plane("lid", [0.0, 0.0, 0.0402], [0.0, 0.0, -1.0]) + &servo("force_n = 5.0"),
        plane("lid", [0.0, 0.0, 0.0402], [0.0, 0.0, -1.0]) + &servo("pressure_pa = 1000.0, area_m2 = 5e-3"),
        mesh("lid", &flipped, &servo("force_n = 5.0")),
    ];
    for lid in lids {
        let mut engine = engine(&column(&lid));
        run_for(&mut engine, 0.6);
        let mut worst = 0.0f64;
        for _ in 0..50 {
            run_for(&mut engine, 0.01);
            worst = worst.max((snapshot(&engine).boundaries[1].force_n[2] - 5.0).abs());
        }
        assert!(worst < 5e-3, "{worst}");
        let weight = 4.0 * 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.005f64.powi(3) * 9.81;
        assert!((snapshot(&engine).boundaries[0].force_n[2] + 5.0 + weight).abs() < 1e-2);
        let energy = engine.report().energy;
        eprintln!(
            "off by {worst:.1e} N of 5 N; residual {:.1e} of the work",
            energy.residual_j / energy.work_boundaries_j
        );
        assert!(energy.work_boundaries_j > 0.0);
        assert!(energy.residual_j.abs() < 1e-3 * energy.work_boundaries_j, "{energy:?}");
    }
}

#[test]
fn a_servo_lets_go_and_its_bits_do_not_depend_on_threads_or_rebuilds() {
    let lid = plane("lid", [0.0, 0.0, 0.0402], [0.0, 0.0, -1.0]) + &servo("force_n = 5.0");
    let run = |threads: usize, drop: bool| {
        let mut engine = engine(&column(&lid));
        engine.set_threads(threads);
        for _ in 0..30 {
            run_for(&mut engine, 0.01);
            if drop {
                engine.drop_caches();
            }
        }
        engine
    };
    let mut first = run(1, false);
    assert_eq!(first.state_hash(), run(2, false).state_hash());
    assert_eq!(first.state_hash(), run(1, true).state_hash());
    let up = MotionDescription::Translation { velocity_m_per_s: [0.0, 0.0, 0.1] };
    first.apply(&Command::SetMotion { boundary: "lid".into(), motion: up }).unwrap();
    run_for(&mut first, 0.1);
    assert_eq!(snapshot(&first).boundaries[1].force_n, [0.0; 3]);
}

#[test]
fn bad_servos_are_refused() {
    let refused = |motion: &str| {
        let text = column(&(plane("lid", [0.0, 0.0, 0.05], [0.0, 0.0, -1.0]) + motion));
        let description = sturz_engine::scene::SceneDescription::from_toml(&text).unwrap();
        sturz_engine::scene::Scene::validate(description).expect_err("refused").to_string()
    };
    assert!(refused(&servo("pressure_pa = 3.0")).contains("boundary[1].motion.force_n"));
    assert!(refused(&servo("force_n = 1.0").replace("1e-3", "0.0")).contains("gain_m_per_s_per_n"));
    assert!(refused(&servo("force_n = 1.0").replace("-2.0", "0.0")).contains("direction"));
    let room = "[[boundary]]\nname = \"room\"\nmaterial = \"w\"\ngeometry = { kind = \"box\", min_m = [-1.0, -1.0, 0.0], max_m = [1.0, 1.0, 1.0] }\n";
    let mut engine = engine(&column(room));
    let motion = |direction: [f64; 3]| MotionDescription::Servo {
        direction,
        force_n: Some(1.0),
        pressure_pa: None,
        area_m2: None,
        gain_m_per_s_per_n: 1e-3,
        max_velocity_m_per_s: 0.1,
    };
    let set = |engine: &mut Engine, name: &str| {
        engine.apply(&Command::SetMotion { boundary: name.into(), motion: motion([0.0, 0.0, -1.0]) })
    };
    assert!(set(&mut engine, "room").unwrap_err().problem.contains("room/z+"));
    assert!(set(&mut engine, "room/z+").is_ok());
}
