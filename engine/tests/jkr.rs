//! Cohesion after Johnson, Kendall and Roberts: pull-off, energy of making and breaking, bits, refusals.

mod common;

use common::{engine, particle, plane, shape, steps};
use sturz_engine::scene::{Scene, SceneDescription};
use sturz_engine::{Command, Engine};

const RADIUS: f64 = 1e-3;
const W: f64 = 0.5;
const YOUNG: f64 = 1e7;
const DENSITY: f64 = 2500.0;

fn mass() -> f64 {
    DENSITY * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3)
}

/// Balls of soft material on themselves and on a rigid wall.
fn scene(gravity: f64, dt: f64, pair: &str, damping: f64) -> String {
    format!(
        "[scene]\nname = \"jkr\"\ngravity_m_per_s2 = [0.0, 0.0, {gravity:?}]\ntime_step_s = {dt:?}\n\
         [contact]\nnormal = \"hertz\"\ntangential = \"mindlin\"\ncontact_end = \"tension\"\n\
         [contact.hertz]\nreference_overlap_fraction = 0.05\n[integrator]\nlocal_damping = {damping:?}\n\
         [[material]]\nname = \"m\"\ndensity_kg_per_m3 = {DENSITY:?}\nyoungs_modulus_pa = {YOUNG:?}\n\
         [[material]]\nname = \"w\"\n\
         [[material_pair]]\nmaterials = [\"m\", \"m\"]\n{pair}\n[[material_pair]]\nmaterials = [\"m\", \"w\"]\n{pair}\n"
    ) + &shape(&format!("kind = \"sphere\", radius_m = {RADIUS:?}"))
}

fn pair(restitution: f64) -> String {
    format!(
        "restitution = {restitution:?}\nfriction = 0.3\n\
         cohesion = {{ kind = \"jkr\", work_of_adhesion_j_per_m2 = {W:?} }}"
    )
}

/// a_c of R = `RADIUS` at E* = `YOUNG`: pi w R^2/(8 E*) = a_c^3.
fn breaking_radius() -> f64 {
    (std::f64::consts::PI * W * RADIUS * RADIUS / (8.0 * YOUNG)).cbrt()
}

/// A ball under the plane z = 0 on which it hangs, pulled with part of 3/2 pi w R: it holds below the whole, and goes above.
#[test]
fn a_ball_hangs_up_to_the_pull_off_force() {
    for (part, holds) in [(0.99, true), (1.01, false)] {
        let floor = plane("ceiling", [0.0; 3], [0.0, 0.0, -1.0]);
        let start = particle([0.0, 0.0, -RADIUS], [0.0, 0.0, 0.01], [0.0; 3]);
        let mut engine = engine(&(scene(0.0, 1e-7, &pair(0.3), 0.7) + &floor + &start));
        steps(&mut engine, 100_000);
        let pull = 1.5 * std::f64::consts::PI * W * RADIUS;
        for k in 1..=50 {
            let gravity = part * pull / mass() * (f64::from(k) / 50.0).sqrt();
            engine.apply(&Command::SetGravity([0.0, 0.0, -gravity])).unwrap();
            steps(&mut engine, 10_000);
        }
        steps(&mut engine, 100_000);
        let report = engine.report();
        assert_eq!(report.touching_boundary_pairs, u64::from(holds), "{part} of the pull-off force");
        if holds {
            let mut snapshot = sturz_engine::Snapshot::default();
            engine.snapshot(&mut snapshot);
            let gap = -RADIUS - snapshot.positions[0][2];
            assert!(gap > 0.0 && gap < 3.0 * breaking_radius().powi(2) / RADIUS, "held over a gap of {gap}");
        }
    }
}

/// Kinetic energy lost and booked, and what is left over, of an elastic hit on a wall: making the bond costs 0.6 pi w a0^2,
/// breaking it 0.4 pi w a_c^2, a0 = 4^(2/3) a_c.
fn hit(dt: f64, speed: f64) -> (f64, f64, f64, Engine) {
    let floor = plane("floor", [0.0; 3], [0.0, 0.0, 1.0]);
    let start = particle([0.0, 0.0, RADIUS + 0.37 * dt * speed], [0.0, 0.0, -speed], [0.0; 3]);
    let mut engine = engine(&(scene(0.0, dt, &pair(1.0), 0.0) + &floor + &start));
    let before = engine.report().energy.kinetic_translation_j;
    steps(&mut engine, (2e-3 / dt) as u64);
    let energy = engine.report().energy;
    (before - energy.kinetic_translation_j, energy.dissipated_normal_j, energy.residual_j, engine)
}

#[test]
fn making_and_breaking_a_bond_is_booked_as_dissipated() {
    let breaking = breaking_radius().powi(2);
    let cost = std::f64::consts::PI * W * breaking * (0.6 * 4f64.powf(4.0 / 3.0) + 0.4);
    let mut residuals = Vec::new();
    for dt in [4e-7, 1e-7, 2.5e-8] {
        let (lost, booked, residual, engine) = hit(dt, 1.0);
        assert_eq!(engine.report().touching_boundary_pairs, 0, "the ball has come off");
        assert!((booked / cost - 1.0).abs() < 1e-12, "booked {booked}, cost {cost}");
        // the force jumps by 4/3 and by 5/6 pi w R, each anywhere within a step
        let jumps = 0.5 * (4.0 / 3.0 + 5.0 / 6.0) * std::f64::consts::PI * W * RADIUS * dt;
        assert!((lost - cost).abs() < jumps, "lost {lost}, cost {cost} at {dt}");
        residuals.push((residual / cost).abs());
    }
    assert!(residuals[2] < 0.2 * residuals[0] && residuals[2] < 2e-3, "{residuals:?}");
    let slow = (0.5 * cost / mass()).sqrt();
    let (_, booked, residual, engine) = hit(1e-7, slow);
    assert_eq!(engine.report().touching_boundary_pairs, 1, "too slow to come off");
    let made = cost - 0.4 * std::f64::consts::PI * W * breaking;
    assert!((booked / made - 1.0).abs() < 1e-12 && residual.abs() < 1e-2 * cost, "{booked} {made} {residual}");
}

/// A cloud of balls that clump: any number of threads, any caches, lists rebuilt at any step, a removal in between.
#[test]
fn bonds_outlive_rebuilds_and_leave_the_bits_alone() {
    let mut text = scene(-9.81, 2e-7, &pair(0.5), 0.0) + &plane("floor", [0.0; 3], [0.0, 0.0, 1.0]);
    for k in 0..60u32 {
        let [x, y, z] = [k % 4, k / 4 % 4, k / 16].map(|n| 2.02 * RADIUS * (f64::from(n) + 0.51));
        let part = |factor: u32| f64::from(k * factor % 7) / 7.0 - 0.4;
        text += &particle([x, y, z], [0.3 * part(3), 0.3 * part(5), 0.3 * part(2)], [100.0 * part(4), 0.0, 0.0]);
    }
    let mut reference: Option<(u64, u64)> = None;
    for (threads, every) in [(1, 0), (2, 0), (4, 13), (1, 1)] {
        let mut engine = engine(&text);
        engine.set_threads(threads);
        for step in 0..8000u64 {
            if every > 0 && step % every == 0 {
                engine.drop_caches();
            }
            steps(&mut engine, 1);
            if step == 5000 {
                engine.apply(&Command::Remove(vec![7, 11])).unwrap();
            }
        }
        let report = engine.report();
        assert!(report.touching_pairs > 20, "{report:?}");
        let now = (engine.state_hash(), report.energy.dissipated_normal_j.to_bits());
        assert_eq!(*reference.get_or_insert(now), now, "{threads} threads, caches dropped every {every} steps");
    }
}

#[test]
fn what_jkr_does_not_know_is_refused() {
    let refusal = |text: &str| {
        let description = SceneDescription::from_toml(text).expect("a scene");
        Scene::validate(description).err().map_or(String::new(), |error| error.to_string())
    };
    let good = scene(0.0, 1e-7, &pair(0.5), 0.0);
    assert_eq!(refusal(&good), "");
    let rod =
        good.replace("kind = \"sphere\", radius_m", "kind = \"spherocylinder\", total_length_m = 0.005, radius_m");
    assert!(refusal(&rod).contains("shape[0].geometry"), "{}", refusal(&rod));
    let negative = good.replace(&format!("{W:?} }}"), "-1.0 }");
    assert!(refusal(&negative).contains("material_pair[0].cohesion.work_of_adhesion_j_per_m2"));
    let linear = common::header([0.0; 3], 1e-7, "", &format!("stiffness_n_per_m = 1e3\n{}", pair(0.5)));
    let linear = linear + &shape(&format!("kind = \"sphere\", radius_m = {RADIUS:?}"));
    assert!(refusal(&linear).contains("material_pair[0].cohesion"), "{}", refusal(&linear));
    let mesh = "[[boundary]]\nname = \"tile\"\nmaterial = \"w\"\ngeometry = { kind = \"mesh\", \
                vertices_m = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], triangles = [[0, 1, 2]] }\n";
    assert!(refusal(&(good + mesh)).contains("boundary[0].geometry"));
}
