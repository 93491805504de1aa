//! The time step: chosen by the engine, and refused where particles could tunnel.

mod common;

use common::{header, particle, plane, shape};
use sturz_engine::scene::{Scene, SceneDescription};
use sturz_engine::{Engine, StepError};

const PAIR: &str = "stiffness_n_per_m = 1e5\nrestitution = 0.9\nfriction = 0.3";
const BALL: &str = "kind = \"sphere\", radius_m = 0.01";
const CUBE: &str = "kind = \"cube\", edge_m = 0.02";

fn with_step(line: &str, geometry: &str) -> Result<Scene, String> {
    let text = header([0.0; 3], 1e-6, "", PAIR).replace("time_step_s = 1e-6", line) + &shape(geometry);
    let text = text + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0]);
    let description = SceneDescription::from_toml(&text).map_err(|error| error.to_string())?;
    Scene::validate(description).map_err(|error| error.to_string())
}

/// The smaller of a fiftieth of the collision and what the law leaves of the critical step; `check` has no doubt.
#[test]
fn auto_is_accurate_and_stable() {
    for (geometry, most) in [(BALL, 12f64.sqrt().recip()), (CUBE, 0.8)] {
        let check = with_step("time_step = \"auto\"", geometry).unwrap().check();
        let expected = (check.contact_duration_s / 50.0).min(most * check.critical_time_step_s);
        assert!((check.time_step_s / expected - 1.0).abs() < 1e-14, "{geometry}: {}", check.time_step_s);
        assert!(check.warnings.is_empty(), "{geometry}: {:?}", check.warnings);
    }
}

/// Exactly one of the three keys.
#[test]
fn one_time_step_is_given() {
    let (auto, seconds, fraction) = ("time_step = \"auto\"\n", "time_step_s = 1e-6\n", "time_step_fraction = 0.1\n");
    for line in [auto, seconds, fraction] {
        assert!(with_step(line, BALL).is_ok(), "{line}");
    }
    let more = [[auto, seconds], [auto, fraction], [seconds, fraction]].map(|lines| lines.concat());
    for line in more.iter().map(String::as_str).chain(["", &[auto, seconds, fraction].concat()]) {
        let error = with_step(line, BALL).unwrap_err();
        assert!(error.contains("exactly one of time_step_s"), "{line}: {error}");
    }
    assert!(with_step("time_step = \"fast\"", BALL).is_err());
}

/// One step at a speed and a rate, of a body far from anything, in halves of the half-thickness of 0.01 m.
fn step(geometry: &str, speed: f64, rate: f64, floor: bool) -> Result<(), StepError> {
    let head = header([0.0; 3], 1e-6, "", PAIR) + &shape(geometry);
    let floor = if floor { plane("floor", [0.0; 3], [0.0, 0.0, 1.0]) } else { String::new() };
    let text = head + &floor + &particle([0.0, 0.0, 1.0], [speed, 0.0, 0.0], [rate, 0.0, 0.0]);
    let scene = Scene::validate(SceneDescription::from_toml(&text).unwrap()).unwrap();
    Engine::new(scene).step()
}

/// v dt, and |w| dt times the bounding radius of what is not a ball, against the half-thickness.
#[test]
fn a_step_beyond_the_half_thickness_is_refused() {
    for geometry in [BALL, CUBE] {
        assert!(step(geometry, 0.99e4, 0.0, true).is_ok());
        let error = step(geometry, 1.5e4, 0.0, true).unwrap_err();
        assert!(
            matches!(error, StepError::TooFast { id: 0, ratio, step: 1, .. } if (ratio - 1.5).abs() < 1e-8),
            "{error}"
        );
        assert!(step(geometry, 1.5e4, 0.0, false).is_ok(), "nothing to hit");
    }
    assert!(step(BALL, 0.0, 1e7, true).is_ok());
    // bounding radius sqrt(3) half-thicknesses
    assert!(step(CUBE, 0.0, 0.5e6, true).is_ok());
    assert!(matches!(step(CUBE, 0.0, 0.6e6, true), Err(StepError::TooFast { id: 0, .. })));
}

/// Frictionless undamped balls in a row between two walls, k = 1e5 N/m: each has two springs, and a row of many swings
/// at omega^2 = 4 k/m, which is the bound. Just below it nothing grows, just above it does.
#[test]
fn the_critical_step_of_a_row_of_balls_is_that_of_its_highest_mode() {
    let pair = "stiffness_n_per_m = 1e5\nrestitution = 1.0";
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-6;
    let critical = (mass / 1e5f64).sqrt();
    let row = |dt: f64| {
        let mut text = header([0.0; 3], dt, "contact_end = \"tension\"", pair) + &shape(BALL);
        text += &plane("left", [0.0; 3], [1.0, 0.0, 0.0]);
        text += &plane("right", [0.7795, 0.0, 0.0], [-1.0, 0.0, 0.0]);
        for k in 0..40 {
            let off = if k % 2 == 0 { 1e-6 } else { -1e-6 };
            text += &particle([0.0095 + 0.0195 * f64::from(k) + off, 0.0, 0.0], [0.0; 3], [0.0; 3]);
        }
        common::engine(&text)
    };
    let swing = |factor: f64| {
        let mut engine = row(factor * critical);
        let present = engine.report().present_critical_time_step_s;
        assert!((present / critical - 1.0).abs() < 1e-12, "{present} {critical}");
        for _ in 0..1500 {
            if engine.step().is_err() {
                return f64::INFINITY;
            }
        }
        let energy = engine.report().energy;
        energy.kinetic_translation_j
    };
    let (below, above) = (swing(0.98), swing(1.02));
    assert!(below < 1e-5 && above > 100.0 * below, "{below} {above}");
}

/// Cubes stacked by generalized overlap stay at rest with nine tenths of the step of their contacts; without contacts
/// there is no bound.
#[test]
fn the_critical_step_of_a_stack_holds() {
    let pair = "stiffness_n_per_m = 1e5\nrestitution = 0.5\nfriction = 0.5";
    let stack = |dt: f64| {
        let mut text =
            header([0.0, 0.0, -9.81], dt, "", pair) + &shape(CUBE) + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0]);
        for k in 0..4 {
            text += &particle([0.0, 0.0, 0.01 + 0.02 * f64::from(k) - 1e-6], [0.0; 3], [0.0; 3]);
        }
        common::engine(&text)
    };
    let bound = stack(1e-7).report().present_critical_time_step_s;
    let single = stack(1e-7).report().critical_time_step_s;
    assert!(bound > 0.1 * single && bound < 3.0 * single, "{bound} {single}");
    let mut engine = stack(0.9 * bound.min(single));
    common::steps(&mut engine, 40_000);
    let report = engine.report();
    let kinetic = report.energy.kinetic_translation_j + report.energy.kinetic_rotation_j;
    assert!(kinetic < 1e-12, "{kinetic}");
    let alone = header([0.0; 3], 1e-6, "", pair) + &shape(CUBE) + &particle([0.0; 3], [0.0; 3], [0.0; 3]);
    assert_eq!(common::engine(&alone).report().present_critical_time_step_s, f64::INFINITY);
}
