//! Meshes in whole scenes: against planes, closed forms and conservation.

mod common;
#[path = "common/meshes.rs"]
mod meshes;

use common::{engine, header, particle, plane, run_for, shape, steps};
use meshes::{cuboid, mesh, sheet};
use sturz_engine::{Engine, Snapshot};

const LAWS: [&str; 2] = ["normal = \"linear\"", "normal = \"generalized_overlap\""];
const SHAPES: [&str; 4] = [
    "kind = \"sphere\", radius_m = 0.005",
    "kind = \"spherocylinder\", radius_m = 0.003, total_length_m = 0.015",
    "kind = \"cube\", edge_m = 0.01",
    "kind = \"rounded_polyhedron\", radius_m = 0.0005, vertices_m = [[0.004, 0.004, 0.004], [-0.004, -0.004, 0.004], [-0.004, 0.004, -0.004], [0.004, -0.004, -0.004]], faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]",
];
const DOWN: [f64; 3] = [0.0, 0.0, -9.81];
const ELASTIC: &str = "stiffness_n_per_m = 1e5\nrestitution = 1.0";

fn snapshot(engine: &Engine) -> Snapshot {
    let mut snapshot = Snapshot::default();
    engine.snapshot(&mut snapshot);
    snapshot
}

fn mechanical(engine: &Engine) -> f64 {
    let e = engine.report().energy;
    e.kinetic_translation_j + e.kinetic_rotation_j + e.potential_j + e.elastic_j
}

/// Largest difference of positions and velocities.
fn difference(a: &Engine, b: &Engine) -> f64 {
    let (a, b) = (snapshot(a), snapshot(b));
    let of = |x: &[[f64; 3]], y: &[[f64; 3]]| {
        x.as_flattened().iter().zip(y.as_flattened()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    };
    of(&a.positions, &b.positions).max(of(&a.velocities, &b.velocities))
}

#[test]
fn a_finely_meshed_plane_is_a_plane() {
    let floor = sheet(30, [-0.1, 0.3, -0.2, 0.2], |_| 0.0);
    for law in LAWS {
        for geometry in SHAPES {
            for friction in [0.0, 0.3] {
                let pair = format!("stiffness_n_per_m = 1e5\nrestitution = 0.5\nfriction = {friction}");
                let head = header(DOWN, 2e-6, law, &pair) + &shape(geometry);
                let thrown = particle([0.0, 0.0, 0.0062], [0.7, 0.11, -0.05], [1.0, 0.3, 0.2]);
                let mut meshed = engine(&(head.clone() + &mesh("floor", &floor, "") + &thrown));
                let mut flat = engine(&(head + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0]) + &thrown));
                for _ in 0..20 {
                    run_for(&mut meshed, 0.01);
                    run_for(&mut flat, 0.01);
                    let apart = difference(&meshed, &flat);
                    // a tumbling tetrahedron blows rounding up
                    let limit = if geometry.contains("rounded") { 1e-9 } else { 1e-12 };
                    assert!(apart < limit, "{law} {geometry} {friction}: {apart:e}");
                }
                assert!(snapshot(&meshed).positions[0][0] > 0.04);
                assert_eq!(meshed.report().touching_boundary_pairs, flat.report().touching_boundary_pairs);
            }
        }
    }
}

#[test]
fn a_ball_over_a_ridge_keeps_its_energy_and_feels_no_jump() {
    let (dt, speed, stiffness) = (2e-6, 0.25, 1e5);
    let ridge = sheet(8, [-0.1, 0.1, -0.1, 0.1], |x| -0.15 * x.abs());
    let text = header(DOWN, dt, "normal = \"linear\"", ELASTIC)
        + &shape(SHAPES[0])
        + &mesh("ridge", &ridge, "")
        + &particle(
            [-0.012, 0.0, -0.15 * 0.012 + 0.005 * (1.0f64 + 0.15 * 0.15).sqrt()],
            [speed, 0.0, 0.15 * speed],
            [0.0; 3],
        );
    let mut engine = engine(&text);
    let (before, mut last) = (mechanical(&engine), [0.0; 3]);
    let (mut jump, mut worst) = (0.0f64, 0.0f64);
    while snapshot(&engine).positions[0][0] < 0.012 {
        steps(&mut engine, 1);
        let force = snapshot(&engine).boundaries[0].force_n;
        jump = (0..3).map(|k| (force[k] - last[k]).abs()).fold(jump, f64::max);
        last = force;
        worst = worst.max((mechanical(&engine) - before).abs());
    }
    let kinetic = 0.5 * 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.005f64.powi(3) * speed * speed;
    assert!(worst < 1e-5 * kinetic, "{:e}", worst / kinetic);
    assert!(jump < 1.5 * stiffness * speed * dt, "{jump}");
}

#[test]
fn a_valley_is_two_planes() {
    let pair = "stiffness_n_per_m = 1e5\nrestitution = 0.5\nfriction = 0.3";
    let valley = sheet(10, [-0.1, 0.1, -0.1, 0.1], |x| x.abs());
    for law in LAWS {
        for geometry in SHAPES {
            let head = header(DOWN, 2e-6, law, pair) + &shape(geometry);
            let fall = particle([0.002, 0.001, 0.012], [0.1, 0.05, -0.1], [1.0, 2.0, 3.0]);
            let mut meshed = engine(&(head.clone() + &mesh("valley", &valley, "") + &fall));
            let planes = plane("left", [0.0; 3], [1.0, 0.0, 1.0]) + &plane("right", [0.0; 3], [-1.0, 0.0, 1.0]);
            let mut flat = engine(&(head + &planes + &fall));
            run_for(&mut meshed, 0.05);
            run_for(&mut flat, 0.05);
            let apart = difference(&meshed, &flat);
            assert!(apart < 1e-9, "{law} {geometry}: {apart:e}");
        }
    }
}

#[test]
fn a_closed_cube_reflects_balls_at_faces_edges_and_corners() {
    let (r, half, v) = (0.005, 0.02, 1.0);
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
    let block = cuboid([-half; 3], [half; 3]);
    for towards in [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [-1.0, 0.0, 1.0], [-1.0, 1.0, -1.0]] {
        let norm = f64::sqrt(towards.iter().map(|c: &f64| c * c).sum());
        let n = towards.map(|c| c / norm);
        let start = [0, 1, 2].map(|k| towards[k] * half + n[k] * (r + 1e-4));
        let text = header([0.0; 3], 1e-7, "normal = \"linear\"", ELASTIC)
            + &shape(SHAPES[0])
            + &mesh("block", &block, "")
            + &particle(start, n.map(|c| -c * v), [0.0; 3]);
        let mut engine = engine(&text);
        // half an oscillation of a mass on a spring, then back to where it came from
        let deepest = v * (mass / 1e5f64).sqrt();
        run_for(&mut engine, 1e-4 / v + 0.5 * std::f64::consts::PI * (mass / 1e5f64).sqrt());
        assert!((engine.report().largest_overlap_m / deepest - 1.0).abs() < 1e-4);
        assert_eq!(engine.report().contact_points, 1);
        run_for(&mut engine, 1e-4 / v + 0.5 * std::f64::consts::PI * (mass / 1e5f64).sqrt());
        let state = snapshot(&engine);
        for k in 0..3 {
            assert!((state.velocities[0][k] - n[k] * v).abs() < 1e-9, "{towards:?}: {:?}", state.velocities[0]);
            assert!((state.positions[0][k] - start[k]).abs() < 1e-6);
        }
    }
}

#[test]
fn a_box_rests_half_over_the_rim_of_a_table_or_falls() {
    let table = cuboid([-0.3, -0.2, -0.05], [0.0, 0.2, 0.0]);
    let sheet = sheet(6, [-0.3, 0.0, -0.2, 0.2], |_| 0.0);
    let pair = "stiffness_n_per_m = 1e6\nrestitution = 0.2\nfriction = 0.5";
    for law in LAWS {
        for table in [&table, &sheet] {
            let run = |x: f64| {
                let text = header(DOWN, 5e-6, law, pair)
                    + &shape("kind = \"box\", size_m = [0.1, 0.08, 0.02]")
                    + &mesh("table", table, "")
                    + &particle([x, 0.01, 0.01], [0.0; 3], [0.0; 3]);
                let mut engine = engine(&text);
                run_for(&mut engine, 0.6);
                engine
            };
            let resting = run(-0.01);
            let state = snapshot(&resting);
            let spin = state.angular_velocities[0].iter().fold(0.0f64, |worst, w| worst.max(w.abs()));
            let weight = 2500.0 * 0.1 * 0.08 * 0.02 * 9.81;
            assert!(spin < 1e-3 && (state.positions[0][2] - 0.01).abs() < 1e-4, "{law}: {spin} {:?}", state.positions);
            assert!((state.positions[0][0] + 0.01).abs() < 1e-4);
            assert!((state.boundaries[0].force_n[2] / weight + 1.0).abs() < 1e-3);
            assert!(snapshot(&run(0.015)).positions[0][2] < -0.02);
        }
    }
}

#[test]
fn energy_of_tumbling_parts_at_a_block() {
    let block = cuboid([-0.02; 3], [0.02; 3]);
    for law in LAWS {
        for geometry in SHAPES {
            for k in 0..6 {
                let a = f64::from(k);
                let start = [0.024 + 0.002 * a.sin(), 0.017 + 0.002 * a, 0.03];
                let text = header([0.0; 3], 5e-7, law, ELASTIC)
                    + &shape(geometry)
                    + &mesh("block", &block, "")
                    + &particle(start, [-0.4, -0.3, -0.5], [40.0 * a.cos(), 30.0, -20.0]);
                let mut engine = engine(&text);
                let before = mechanical(&engine);
                run_for(&mut engine, 0.06);
                let change = mechanical(&engine) / before - 1.0;
                assert!(change.abs() < 3e-5, "{law} {geometry} {k}: {change:e}");
            }
        }
    }
}

#[test]
fn neither_rebuilds_nor_threads_nor_caches_change_a_bit() {
    let blades = sheet(12, [-0.05, 0.05, -0.05, 0.05], |x| 0.01 * (100.0 * x).sin());
    let turning = "motion = { kind = \"rotation\", point_m = [0.0, 0.0, 0.1], axis = [0.0, 1.0, 0.0], angular_velocity = { kind = \"oscillation\", amplitude_rad_per_s = 1.0, frequency_hz = 10.0 } }";
    let pair = "stiffness_n_per_m = 1e5\nrestitution = 0.5\nfriction = 0.3";
    let mut text = header(DOWN, 5e-6, "", pair) + &shape(SHAPES[2]) + &mesh("bed", &blades, turning);
    for k in 0..8 {
        let x = [0.018 * f64::from(k % 4) - 0.027, 0.02 * f64::from(k / 4) - 0.01, 0.025];
        text += &particle(x, [0.0, 0.0, -0.3], [3.0, 2.0, f64::from(k)]);
    }
    let hash = |threads: usize, drop: bool| {
        let mut engine = engine(&text);
        engine.set_threads(threads);
        for k in 0..100 {
            if drop && k % 3 == 0 {
                engine.drop_caches();
            }
            steps(&mut engine, 100);
        }
        assert!(engine.report().largest_overlap_ratio_so_far > 1e-3);
        assert!(engine.report().energy.residual_j.abs() < 1e-4, "{:?}", engine.report().energy);
        engine.state_hash()
    };
    let first = hash(1, false);
    assert_eq!(first, hash(2, false));
    assert_eq!(first, hash(1, true));
}

#[test]
fn what_slides_off_a_rim_loses_little_energy() {
    let table = cuboid([-0.1, -0.1, -0.05], [0.0, 0.1, 0.0]);
    for law in LAWS {
        for (geometry, height) in SHAPES.iter().zip([0.005, 0.003, 0.005, 0.0045]) {
            let text = header(DOWN, 1e-6, law, ELASTIC)
                + &shape(geometry)
                + &mesh("table", &table, "")
                + &particle([-0.02, 0.0, height], [0.4, 0.05, 0.0], [0.0, 0.0, 0.1]);
            let mut engine = engine(&text);
            let before = mechanical(&engine);
            run_for(&mut engine, 0.09);
            let state = snapshot(&engine);
            assert!(
                state.positions[0][0] > 0.01 && state.positions[0][2] < height,
                "{geometry}: {:?}",
                state.positions
            );
            let gained = (mechanical(&engine) - before) / engine.report().energy.kinetic_translation_j;
            assert!(gained.abs() < 1e-4, "{law} {geometry}: {gained:e}");
        }
    }
}
