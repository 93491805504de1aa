//! Motion against closed forms: free flight, bounce, sliding and rolling, incline, momentum, energy.

mod common;

use common::{engine, header, particle, plane, run_for, shape, steps};
use sturz_engine::{Engine, Snapshot};

fn snapshot(engine: &Engine) -> Snapshot {
    let mut snapshot = Snapshot::default();
    engine.snapshot(&mut snapshot);
    snapshot
}

const BALL: &str = "kind = \"sphere\", radius_m = 0.01";

/// Velocity Verlet integrates a parabola exactly; rounding of 1000 additions of numbers of order 1.
#[test]
fn free_flight_is_a_parabola() {
    let scene = header([0.0, 0.0, -9.81], 1e-4, "", "stiffness_n_per_m = 1e5\nrestitution = 0.9");
    let mut engine = engine(&(scene + &shape(BALL) + &particle([0.0; 3], [1.0, 2.0, 3.0], [0.0, 5.0, 0.0])));
    run_for(&mut engine, 0.1);
    let state = snapshot(&engine);
    assert_eq!(state.time_s, 0.1);
    let expected = [0.1, 0.2, 0.3 - 0.5 * 9.81 * 0.01];
    for (position, expected) in state.positions[0].iter().zip(expected) {
        assert!((position - expected).abs() < 1e-13);
    }
    assert!((state.angular_velocities[0][1] - 5.0).abs() < 1e-13);
    assert!(engine.report().energy.residual_j.abs() < 1e-12);
}

/// Restitution of a normal impact on a wall and on a ball, for both ends of contact. PHYSICS.md D, WP2: the error at
/// dt = Tc/20 is 2.2e-3 (tension, order 2) and 4.4e-3 (clip, order 1); here dt is about Tc/400.
#[test]
fn restitution_is_what_was_asked_for() {
    for end in ["tension", "clip"] {
        for e in [0.9, 0.5, 0.2] {
            let pair = format!("stiffness_n_per_m = 1e5\nrestitution = {e}");
            let head = header([0.0; 3], 5e-7, &format!("contact_end = \"{end}\""), &pair) + &shape(BALL);
            let wall = head.clone()
                + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
                + &particle([0.0, 0.0, 0.0101], [0.0, 0.0, -1.0], [0.0; 3]);
            let mut on_wall = engine(&wall);
            steps(&mut on_wall, 10_000);
            assert!((snapshot(&on_wall).velocities[0][2] - e).abs() < 1e-3, "{end} {e}");
            let two = head
                + &particle([0.0, 0.0, 0.01005], [0.0, 0.0, -0.5], [0.0; 3])
                + &particle([0.0, 0.0, -0.01005], [0.0, 0.0, 0.5], [0.0; 3]);
            let mut on_ball = engine(&two);
            steps(&mut on_ball, 10_000);
            let v = snapshot(&on_ball).velocities;
            assert!((v[0][2] - v[1][2] - e).abs() < 1e-3, "{end} {e}");
            assert!((v[0][2] + v[1][2]).abs() < 1e-15);
        }
    }
}

/// I10: a ball set down sliding at v0 rolls from t = 2 v0/(7 mu g), x = 12 v0^2/(49 mu g) on, at v = v0 q/(1 + q),
/// q = 2.5 (a/r)^2 with the lever arm a = r - d/2 of the law.
#[test]
fn sliding_turns_into_rolling() {
    let (r, mass) = (0.01, 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-6);
    let stiffness = 1e6;
    let overlap = mass * 9.81 / stiffness;
    let scene = header([0.0, 0.0, -9.81], 2e-6, "", "stiffness_n_per_m = 1e6\nrestitution = 0.5\nfriction = 0.3")
        + &shape(BALL)
        + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
        + &particle([0.0, 0.0, r - overlap], [1.0, 0.0, 0.0], [0.0; 3]);
    let mut engine = engine(&scene);
    let slid = 2.0 / (7.0 * 0.3 * 9.81);
    run_for(&mut engine, slid * 0.999);
    let v = snapshot(&engine);
    assert!((v.velocities[0][0] - (1.0 - 0.3 * 9.81 * slid * 0.999)).abs() < 1e-4);
    run_for(&mut engine, slid * 0.001);
    let x = snapshot(&engine).positions[0][0];
    assert!((x / (12.0 / (49.0 * 0.3 * 9.81)) - 1.0).abs() < 1e-3, "{x}");
    run_for(&mut engine, 0.2);
    let q = 2.5 * ((r - 0.5 * overlap) / r).powi(2);
    let state = snapshot(&engine);
    assert!((state.velocities[0][0] - q / (1.0 + q)).abs() < 1e-9, "{:e}", state.velocities[0][0] - q / (1.0 + q));
    assert!((state.angular_velocities[0][1] * (r - 0.5 * overlap) - state.velocities[0][0]).abs() < 1e-8);
    let energy = engine.report().energy;
    assert!(energy.residual_j.abs() < 2e-6 * mass, "{energy:?}");
}

/// I11: a block on a slope sticks when tan th < mu (at rest, stretched by m g sin th / k_t) and slides with
/// a = g (sin th - mu cos th) when not.
#[test]
fn block_sticks_or_slides_on_a_slope() {
    for (theta, sticks) in [(0.4f64, true), (0.6, false)] {
        let g = 9.81;
        let gravity = [g * theta.sin(), 0.0, -g * theta.cos()];
        let scene = header(gravity, 1e-5, "", "stiffness_n_per_m = 1e6\nrestitution = 0.2\nfriction = 0.5")
            + &shape("kind = \"box\", size_m = [0.1, 0.1, 0.02]")
            + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
            + &particle([0.0, 0.0, 0.01], [0.0; 3], [0.0; 3]);
        let mut engine = engine(&scene);
        run_for(&mut engine, 0.4);
        let before = snapshot(&engine);
        run_for(&mut engine, 0.1);
        let after = snapshot(&engine);
        let gained = after.velocities[0][0] - before.velocities[0][0];
        if sticks {
            assert!(after.velocities[0][0].abs() < 1e-9, "{:e}", after.velocities[0][0]);
            assert!((after.positions[0][0] - before.positions[0][0]).abs() < 1e-10);
        } else {
            let expected = 0.1 * g * (theta.sin() - 0.5 * theta.cos());
            assert!((gained / expected - 1.0).abs() < 1e-3, "{gained} {expected}");
        }
        assert!(after.angular_velocities[0].iter().all(|w| w.abs() < 1e-6), "{:?}", after.angular_velocities[0]);
    }
}

/// Rolling without slip on a slope: a = 5/7 g sin th for a ball.
#[test]
fn ball_rolls_down_a_slope() {
    let (g, theta) = (9.81, 0.5f64);
    let scene = header(
        [g * theta.sin(), 0.0, -g * theta.cos()],
        5e-6,
        "",
        "stiffness_n_per_m = 1e6\nrestitution = 0.5\nfriction = 0.5",
    ) + &shape(BALL)
        + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0])
        + &particle([0.0, 0.0, 0.01], [0.0; 3], [0.0; 3]);
    let mut engine = engine(&scene);
    run_for(&mut engine, 0.3);
    let v = snapshot(&engine).velocities[0][0];
    assert!((v / (0.3 * 5.0 / 7.0 * g * theta.sin()) - 1.0).abs() < 1e-3, "{v}");
}

/// Momentum and angular momentum of free crosses that collide with friction: kept to rounding.
#[test]
fn collisions_keep_momentum() {
    let scene =
        header([0.0; 3], 2e-6, "normal = \"linear\"", "stiffness_n_per_m = 1e4\nrestitution = 0.6\nfriction = 0.5")
            + &shape("kind = \"cross_3d\", beam_length_m = 0.02, beam_width_m = 0.004")
            + &particle([-0.012, 0.001, 0.0], [1.0, 0.0, 0.1], [3.0, 40.0, 5.0])
            + &particle([0.012, 0.0, 0.002], [-1.0, 0.1, 0.0], [30.0, 0.0, -20.0]);
    let mut engine = engine(&scene);
    let momentum = |engine: &Engine| engine.report().momentum_kg_m_per_s;
    let before = momentum(&engine);
    let mut touched = 0;
    for _ in 0..40 {
        steps(&mut engine, 500);
        touched += engine.report().contact_points;
    }
    let after = momentum(&engine);
    assert!(touched > 0, "the crosses must meet");
    for axis in 0..3 {
        assert!((after[axis] - before[axis]).abs() < 1e-16, "{before:?} {after:?}");
    }
}

/// S1: refused above the stability limit, with the allowed value in the text; bounded below.
#[test]
fn step_above_the_critical_one_is_refused() {
    use sturz_engine::scene::{Scene, SceneDescription};
    let mass: f64 = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-6;
    let omega = (1e5 / (0.5 * mass)).sqrt();
    let scene = |product: f64| {
        header([0.0; 3], product / omega, "contact_end = \"tension\"", "stiffness_n_per_m = 1e5\nrestitution = 1.0")
            + &shape(BALL)
            + &particle([0.0; 3], [0.0; 3], [0.0; 3])
            + &particle([0.0195, 0.0, 0.0], [0.0; 3], [0.0; 3])
    };
    for product in [0.1, 1.0, 1.99] {
        let mut engine = engine(&scene(product));
        let initial = engine.report().energy.elastic_j;
        steps(&mut engine, 3);
        let energy = engine.report().energy;
        assert!(energy.kinetic_translation_j <= 5.0 * initial, "{product} {energy:?}");
    }
    for product in [2.01, 2.1] {
        let refused = Scene::validate(SceneDescription::from_toml(&scene(product)).unwrap());
        let text = refused.unwrap_err().to_string();
        assert!(text.contains("scene.time_step_s") && text.contains("critical"), "{text}");
    }
}
