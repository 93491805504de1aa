//! Rolling and twisting resistance, cohesion and local damping: RR, CO, LD.

use std::f64::consts::PI;

use super::{Case, Checks};
use crate::scene::{SceneText, snapshot};

pub fn cases() -> Vec<Case> {
    vec![
        Case::fast("RR", "ball on a plane: rolling and twisting resistance", rolling),
        Case::fast("CO", "ball under a ceiling: cohesion holds up to its force", cohesion),
        Case::fast("LD", "local damping: free fall, decay of an oscillation", local_damping),
    ]
}

const G: f64 = 9.81;
const RADIUS: f64 = 0.01;
const DENSITY: f64 = 2500.0;
const STIFFNESS: f64 = 1e5;

fn mass() -> f64 {
    DENSITY * 4.0 / 3.0 * PI * RADIUS.powi(3)
}

fn ball(gravity: [f64; 3], law: &str) -> SceneText {
    SceneText::new(gravity, "time_step_s = 5e-6")
        .materials(DENSITY, &format!("stiffness_n_per_m = {STIFFNESS:?}\nrestitution = 0.5\n{law}"))
        .shape(&format!("kind = \"sphere\", radius_m = {RADIUS:?}"))
}

fn rest_height() -> f64 {
    RADIUS - mass() * G / STIFFNESS
}

/// Rolling without slip: deceleration 5/7 mu_r g; a spin about the normal: 5/2 mu_t g/r. On a slope the ball stays below
/// tan th = mu_r and rolls above with a = 5/7 g (sin th - mu_r cos th). Lever arms are r less half the overlap (4e-4 r).
fn rolling(checks: &mut Checks) -> anyhow::Result<()> {
    let law = "friction = 0.5\nrolling_friction = 0.05\ntwisting_friction = 0.02";
    let weight = [0.0, 0.0, -G];
    let start = |velocity: [f64; 3], spin: [f64; 3]| {
        ball(weight, law).floor().particle([0.0, 0.0, rest_height()], velocity, spin).start()
    };
    let mut engine = start([0.5, 0.0, 0.0], [0.0, 50.0, 0.0])?;
    checks.run_for(&mut engine, 0.2)?;
    let before = snapshot(&engine).velocities[0][0];
    checks.run_for(&mut engine, 0.4)?;
    let slower = (before - snapshot(&engine).velocities[0][0]) / 0.4;
    checks.close("rolling: deceleration", slower, 5.0 / 7.0 * 0.05 * G, 2e-3, "m/s2");
    let energy = engine.report().energy;
    checks.vanishes("rolling: energy residual over the initial", energy.residual_j / (0.7 * mass() * 0.25), 1e-5, "-");
    checks.run_for(&mut engine, 1.4)?;
    checks.vanishes("rolling: speed at rest", snapshot(&engine).velocities[0][0], 1e-6, "m/s");
    let mut engine = start([0.0; 3], [0.0, 0.0, 20.0])?;
    // the dashpot, which acts until the spring has reached its limit, takes 0.2 rad/s at once
    checks.run_for(&mut engine, 0.05)?;
    let before = snapshot(&engine).angular_velocities[0][2];
    checks.run_for(&mut engine, 0.2)?;
    let spin = snapshot(&engine).angular_velocities[0][2];
    checks.close("twisting: loss of spin", (before - spin) / 0.2, 2.5 * 0.02 * G / RADIUS, 2e-3, "rad/s2");
    for (part, rolls) in [(0.9, false), (1.2, true)] {
        let theta = f64::atan(0.05 * part);
        let gravity = [G * theta.sin(), 0.0, -G * theta.cos()];
        let mut engine = ball(gravity, law).floor().particle([0.0, 0.0, rest_height()], [0.0; 3], [0.0; 3]).start()?;
        checks.run_for(&mut engine, 0.5)?;
        let before = snapshot(&engine).velocities[0][0];
        checks.run_for(&mut engine, 0.5)?;
        let after = snapshot(&engine).velocities[0][0];
        if rolls {
            let expected = 5.0 / 7.0 * G * (theta.sin() - 0.05 * theta.cos());
            checks.close("slope above mu_r: acceleration", (after - before) / 0.5, expected, 5e-3, "m/s2");
        } else {
            checks.vanishes("slope below mu_r: speed", after, 1e-6, "m/s");
        }
    }
    same_whatever_is_rebuilt(checks)
}

/// Springs outlive a rebuild of the neighbour list: equal state hash with the caches dropped every 7 steps.
fn same_whatever_is_rebuilt(checks: &mut Checks) -> anyhow::Result<()> {
    let law = "friction = 0.5\nrolling_friction = 0.2\ntwisting_friction = 0.1";
    let mut hashes = Vec::new();
    for drop in [false, true] {
        let mut scene = ball([0.0, 0.0, -G], law).floor();
        for k in 0..12u32 {
            let place = [
                0.019 * f64::from(k % 2) + 0.001 * f64::from(k),
                0.002 * f64::from(k % 3),
                0.01 + 0.0195 * f64::from(k / 2),
            ];
            scene = scene.particle(place, [0.1, 0.0, 0.0], [3.0, 1.0, 5.0]);
        }
        let mut engine = scene.start()?;
        for _ in 0..300 {
            checks.steps(&mut engine, 7)?;
            if drop {
                engine.drop_caches();
            }
        }
        hashes.push(engine.state_hash());
    }
    checks.holds("12 balls: equal state hash, caches dropped or not", hashes[0] == hashes[1]);
    Ok(())
}

/// A ball under a plane, 1.1 and 0.9 times held by a constant force; one held by `sjkr` at an elastic floor.
fn cohesion(checks: &mut Checks) -> anyhow::Result<()> {
    for (part, holds) in [(1.1, true), (0.9, false)] {
        let force = part * mass() * G;
        let law = format!("cohesion = {{ kind = \"constant\", force_n = {force:?} }}");
        let mut engine = ball([0.0, 0.0, -G], &law)
            .plane("ceiling", [0.0; 3], [0.0, 0.0, -1.0])
            .particle([0.0, 0.0, -RADIUS + (force - mass() * G).max(1e-9) / STIFFNESS], [0.0; 3], [0.0; 3])
            .start()?;
        checks.run_for(&mut engine, 0.1)?;
        let z = snapshot(&engine).positions[0][2];
        if holds {
            checks.close("held: overlap", z + RADIUS, (part - 1.0) * mass() * G / STIFFNESS, 1e-6, "m");
        } else {
            checks.holds("not held: falls", z < -RADIUS - 0.01);
        }
    }
    let speed = 0.1;
    for (name, kind) in [
        ("constant", "kind = \"constant\", force_n = 0.05".to_owned()),
        ("sjkr", format!("kind = \"sjkr\", energy_density_j_per_m3 = {:?}", 0.2 * STIFFNESS / (2.0 * PI * RADIUS))),
    ] {
        let law = format!("cohesion = {{ {kind} }}").replace("restitution = 0.5", "");
        let mut engine = SceneText::new([0.0; 3], "time_step_s = 5e-6")
            .materials(DENSITY, &format!("stiffness_n_per_m = {STIFFNESS:?}\nrestitution = 1.0\n{law}"))
            .shape(&format!("kind = \"sphere\", radius_m = {RADIUS:?}"))
            .floor()
            .particle([0.0, 0.0, RADIUS + 1e-6], [0.0, 0.0, -speed], [0.0; 3])
            .start()?;
        checks.steps(&mut engine, 2000)?;
        checks.close(format!("{name}, elastic hit: speed"), snapshot(&engine).velocities[0][2], speed, 1e-3, "m/s");
    }
    Ok(())
}

/// A falling ball feels (1 - alpha) g; an oscillation keeps (1 - alpha)/(1 + alpha) of its energy per half period; the
/// balance closes.
fn local_damping(checks: &mut Checks) -> anyhow::Result<()> {
    let alpha = 0.3;
    let damped = |scene: SceneText| scene.section(&format!("[integrator]\nlocal_damping = {alpha:?}"));
    let mut engine = damped(ball([0.0, 0.0, -G], "")).particle([0.0; 3], [0.0; 3], [0.0; 3]).start()?;
    // the first half step starts from rest, where the damping has no direction
    checks.run_for(&mut engine, 0.1)?;
    let fallen = -snapshot(&engine).velocities[0][2];
    checks.close("free fall: speed", fallen, (1.0 - alpha) * G * 0.1, 1e-4, "m/s");
    let energy = engine.report().energy;
    let scale = mass() * G * 0.05;
    checks.vanishes("free fall: energy residual", energy.residual_j / scale, 1e-4, "-");
    checks.holds("free fall: dissipation is booked", energy.dissipated_local_j > 0.2 * scale);
    // so stiff a scene that the ball never leaves the floor
    let law = format!("stiffness_n_per_m = {STIFFNESS:?}\ndamping_n_s_per_m = 0.0");
    let amplitude = 0.5 * mass() * G / STIFFNESS;
    let scene = SceneText::new([0.0, 0.0, -G], "time_step_s = 1e-6")
        .materials(DENSITY, &law)
        .shape(&format!("kind = \"sphere\", radius_m = {RADIUS:?}"))
        .floor();
    let mut engine = damped(scene).particle([0.0, 0.0, rest_height() + amplitude], [0.0; 3], [0.0; 3]).start()?;
    // (1/sqrt(1 - alpha) + 1/sqrt(1 + alpha)) pi/(2 omega) is one half period
    let omega = (STIFFNESS / mass()).sqrt();
    let half = 0.5 * PI / omega * ((1.0 - alpha).sqrt().recip() + (1.0 + alpha).sqrt().recip());
    checks.run_for(&mut engine, 2.0 * half)?;
    let kept = (snapshot(&engine).positions[0][2] - rest_height()) / amplitude;
    checks.close("oscillation: amplitude after a period", kept, (1.0 - alpha) / (1.0 + alpha), 5e-3, "-");
    let energy = engine.report().energy;
    let scale = 0.5 * STIFFNESS * amplitude * amplitude;
    checks.vanishes("oscillation: energy residual", energy.residual_j / scale, 1e-2, "-");
    checks.close(
        "oscillation: dissipation",
        energy.dissipated_local_j,
        scale * (1.0 - ((1.0 - alpha) / (1.0 + alpha)).powi(2)),
        1e-2,
        "J",
    );
    Ok(())
}
