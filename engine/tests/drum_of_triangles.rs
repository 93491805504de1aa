//! A drum with lifters and end plates as one mesh, and blades in a drum of planes and a cylinder.

mod common;
#[path = "common/meshes.rs"]
mod meshes;

use common::{engine, header, plane, run_for, shape, steps};
use meshes::{Triangles, mesh};
use sturz_engine::{Engine, Snapshot};

const RADIUS: f64 = 0.05;
const WIDTH: f64 = 0.03;
const LIFTER: f64 = 0.01;
const RATE: f64 = 5.0;

/// Extrudes a closed profile (x, z), counter-clockwise from x to z, along y; ends in fans about the axis.
fn extruded(profile: &[[f64; 2]], width: f64) -> Triangles {
    let n = profile.len() as u32;
    let mut vertices: Vec<[f64; 3]> = Vec::new();
    for y in [-0.5 * width, 0.5 * width] {
        vertices.extend(profile.iter().map(|[x, z]| [*x, y, *z]));
        vertices.push([0.0, y, 0.0]);
    }
    let mut triangles = Vec::new();
    for i in 0..n {
        let ([a, b], [c, d]) = ([i, (i + 1) % n], [n + 1 + i, n + 1 + (i + 1) % n]);
        triangles.extend([[a, b, d], [a, d, c], [n, b, a], [2 * n + 1, c, d]]);
    }
    (vertices, triangles)
}

/// A drum of 32 flat pieces with 8 lifters.
fn drum(width: f64) -> Triangles {
    let at = |radius: f64, angle: f64| [radius * angle.cos(), radius * angle.sin()];
    let step = std::f64::consts::TAU / 32.0;
    let mut profile = Vec::new();
    for k in 0..32 {
        let angle = step * f64::from(k);
        profile.push(at(RADIUS, angle));
        if k % 4 == 0 {
            profile.push(at(RADIUS - LIFTER, angle + 0.1 * step));
            profile.push(at(RADIUS - LIFTER, angle + 0.5 * step));
            profile.push(at(RADIUS, angle + 0.6 * step));
        }
    }
    extruded(&profile, width)
}

fn turning() -> String {
    format!(
        "motion = {{ kind = \"rotation\", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], angular_velocity = {{ kind = \"constant\", rad_per_s = {RATE} }} }}"
    )
}

fn filled(geometry: &str, boundaries: &str, count: u32) -> Engine {
    // beams are too thin for the rounding of the default law at this stiffness
    let (dt, law) = if geometry.contains("cross") { (5e-6, "normal = \"linear\"") } else { (1e-5, "") };
    let pair = "stiffness_n_per_m = 5e3\nrestitution = 0.5\nfriction = 0.5";
    engine(
        &(header([0.0, 0.0, -9.81], dt, law, pair)
            + &shape(geometry)
            + boundaries
            + &format!(
                "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nplacement = {{ method = \"random\", count = {count}, region = {{ kind = \"cylinder\", point_m = [0.0, -0.014, 0.0], axis = [0.0, 1.0, 0.0], radius_m = 0.036, length_m = 0.028 }} }}\n"
            )),
    )
}

fn snapshot(engine: &Engine) -> Snapshot {
    let mut snapshot = Snapshot::default();
    engine.snapshot(&mut snapshot);
    snapshot
}

fn assert_inside(state: &Snapshot, what: &str) {
    for x in &state.positions {
        let rho = x[0].hypot(x[2]);
        assert!(rho < RADIUS && x[1].abs() < 0.5 * WIDTH, "{what}: {x:?} at {} s", state.time_s);
    }
}

#[test]
fn nothing_escapes_from_a_turning_drum_with_lifters() {
    let shapes = [
        "kind = \"sphere\", radius_m = 0.003",
        "kind = \"cube\", edge_m = 0.005",
        "kind = \"spherocylinder\", radius_m = 0.002, total_length_m = 0.009",
        "kind = \"cross_3d\", beam_length_m = 0.008, beam_width_m = 0.002",
    ];
    let walls = mesh("drum", &drum(WIDTH), &turning());
    for geometry in shapes {
        let mut engine = filled(geometry, &walls, 30);
        let mut highest = f64::MIN;
        for _ in 0..30 {
            run_for(&mut engine, 0.02);
            let state = snapshot(&engine);
            assert_inside(&state, geometry);
            highest = state.positions.iter().map(|x| x[2]).fold(highest, f64::max);
        }
        let energy = engine.report().energy;
        assert!(energy.work_boundaries_j > 0.0 && highest > 0.01, "{geometry}: {highest}");
        let gap = energy.residual_j / energy.work_boundaries_j;
        eprintln!("{geometry}: lifted to {highest:.4} m, residual {gap:.1e} of the work");
        assert!(gap.abs() < 0.02, "{geometry}: {energy:?}");
    }
}

/// Angular momentum of spheres about the axis, and the torque of gravity.
fn about_axis(state: &Snapshot, radius: f64) -> (f64, f64) {
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let own = 0.4 * mass * radius * radius;
    let (mut momentum, mut gravity) = (0.0, 0.0);
    for k in 0..state.ids.len() {
        let (x, v, w) = (state.positions[k], state.velocities[k], state.angular_velocities[k]);
        momentum += mass * (x[2] * v[0] - x[0] * v[2]) + own * w[1];
        gravity += mass * 9.81 * x[0];
    }
    (momentum, gravity)
}

#[test]
fn torque_on_the_drum_is_that_of_gravity_and_its_work_is_in_the_books() {
    let walls = mesh("drum", &drum(WIDTH), &turning());
    let mut engine = filled("kind = \"sphere\", radius_m = 0.003", &walls, 60);
    run_for(&mut engine, 0.3);
    let dt = engine.clock().time_step_s();
    let (before, work_before) = (snapshot(&engine), engine.report().energy.work_boundaries_j);
    let (mut impulse, mut work) = (0.0, 0.0);
    let rates = |state: &Snapshot| {
        let torque = state.boundaries[0].torque_n_m[1];
        (about_axis(state, 0.003).1 - torque, -torque * RATE)
    };
    let mut last = rates(&before);
    for _ in 0..20_000 {
        steps(&mut engine, 1);
        let now = rates(&snapshot(&engine));
        impulse += 0.5 * dt * (last.0 + now.0);
        work += 0.5 * dt * (last.1 + now.1);
        last = now;
    }
    let after = snapshot(&engine);
    let change = about_axis(&after, 0.003).0 - about_axis(&before, 0.003).0;
    let scale = 0.4 * about_axis(&after, 0.003).1.abs();
    assert!((impulse - change).abs() < 1e-3 * scale, "{impulse} {change} {scale}");
    let booked = engine.report().energy.work_boundaries_j - work_before;
    assert!((work / booked - 1.0).abs() < 1e-9, "{work} {booked}");
}

#[test]
fn a_drum_may_be_periodic_along_its_axis_if_it_reaches_far_enough() {
    let cell = format!(
        "[domain]\nmin_m = [0.0, {:?}, 0.0]\nmax_m = [0.0, {:?}, 0.0]\nperiodic = [false, true, false]\n",
        -0.5 * WIDTH,
        0.5 * WIDTH
    );
    let walls = |width: f64| cell.clone() + &mesh("drum", &drum(width), &turning());
    let mut engine = filled("kind = \"sphere\", radius_m = 0.003", &walls(2.0 * WIDTH), 30);
    let kick = sturz_engine::Command::SetGravity([0.0, 3.0, -9.81]);
    engine.apply(&kick).unwrap();
    for _ in 0..30 {
        run_for(&mut engine, 0.02);
        assert_inside(&snapshot(&engine), "periodic");
    }
    let along = snapshot(&engine).velocities.iter().map(|v| v[1]).sum::<f64>() / 30.0;
    assert!(along > 0.1, "nothing stops them along the axis: {along}");
    let text = header([0.0; 3], 1e-5, "", "stiffness_n_per_m = 5e3\nrestitution = 0.5")
        + &shape("kind = \"sphere\", radius_m = 0.003")
        + &walls(1.2 * WIDTH);
    let description = sturz_engine::scene::SceneDescription::from_toml(&text).unwrap();
    let refused = sturz_engine::scene::Scene::validate(description).expect_err("too short").to_string();
    assert!(refused.contains("boundary[0]: is not the same in every periodic image"), "{refused}");
}

#[test]
fn blades_of_no_thickness_lift_in_a_round_drum() {
    let mut blades: Triangles = (Vec::new(), Vec::new());
    for k in 0..6 {
        let (sine, cosine) = (f64::from(k) * std::f64::consts::TAU / 6.0).sin_cos();
        let first = blades.0.len() as u32;
        for (radius, y) in [(1.02, -0.6), (1.02, 0.6), (0.75, 0.6), (0.75, -0.6)] {
            blades.0.push([radius * RADIUS * cosine, y * WIDTH, radius * RADIUS * sine]);
        }
        // front and back with a vertex each of their own on the diagonal: only the rim is shared
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| first + k);
        blades.1.extend([[a, b, c], [a, c, d]]);
        let middle = blades.0.len() as u32;
        blades.0.push([0.9 * RADIUS * cosine, 0.0, 0.9 * RADIUS * sine]);
        blades.1.extend([[b, a, middle], [c, b, middle], [d, c, middle], [a, d, middle]]);
    }
    let walls = format!(
        "[[boundary]]\nname = \"shell\"\nmaterial = \"w\"\ngeometry = {{ kind = \"cylinder_inside\", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], radius_m = {RADIUS} }}\n{}\n",
        turning()
    ) + &plane("back", [0.0, -0.5 * WIDTH, 0.0], [0.0, 1.0, 0.0])
        + &plane("front", [0.0, 0.5 * WIDTH, 0.0], [0.0, -1.0, 0.0])
        + &mesh("blades", &blades, &turning());
    for geometry in ["kind = \"sphere\", radius_m = 0.003", "kind = \"cube\", edge_m = 0.005"] {
        let mut engine = filled(geometry, &walls, 30);
        for _ in 0..40 {
            run_for(&mut engine, 0.02);
            assert_inside(&snapshot(&engine), geometry);
        }
        let highest = snapshot(&engine).positions.iter().map(|x| x[2]).fold(f64::MIN, f64::max);
        assert!(engine.report().energy.work_boundaries_j > 0.0 && highest > -0.03, "{highest}");
    }
}
