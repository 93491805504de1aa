//! Initial overlaps relaxed before step 0: the second half of S9 (PHYSICS.md E).

use std::f64::consts::PI;

use sturz_engine::{Engine, StepError};

use super::Checks;
use crate::scene::{SceneText, snapshot};

const RADIUS: f64 = 0.01;
const DENSITY: f64 = 1000.0;
const STIFFNESS: f64 = 1e5;
/// What [relax] leaves when it is not told otherwise.
const LEFT: f64 = 1e-3;

fn mass() -> f64 {
    DENSITY * 4.0 / 3.0 * PI * RADIUS.powi(3)
}

fn elastic(relax: &str) -> SceneText {
    SceneText::new([0.0; 3], "time_step_s = 2e-6")
        .contact("overlap_limit = 2.0")
        .materials(DENSITY, &format!("stiffness_n_per_m = {STIFFNESS:?}\nrestitution = 1.0\nfriction = 0.3"))
        .section(relax)
}

fn balls(relax: &str) -> SceneText {
    elastic(relax).shape(&format!("kind = \"sphere\", radius_m = {RADIUS:?}"))
}

/// Largest speed of a centre in 2,000 steps, m/s.
fn fastest(checks: &mut Checks, engine: &mut Engine) -> anyhow::Result<f64> {
    let mut fastest = 0.0f64;
    for _ in 0..200 {
        checks.steps(engine, 10)?;
        let speeds = snapshot(engine).velocities.into_iter().map(|v| v.iter().map(|c| c * c).sum::<f64>().sqrt());
        fastest = speeds.fold(fastest, f64::max);
    }
    Ok(fastest)
}

/// All parts.
pub fn relaxation(checks: &mut Checks) -> anyhow::Result<()> {
    two_balls(checks)?;
    clusters(checks)?;
    given_velocities(checks)?;
    no_room(checks)
}

/// Two elastic balls: what is left of the overlap parts them with sqrt(k/m_red) times it at most; unrelaxed, with all of
/// it. The middle stays where it was. `sturz check` warns of the unrelaxed ones.
fn two_balls(checks: &mut Checks) -> anyhow::Result<()> {
    let omega = f64::sqrt(2.0 * STIFFNESS / mass());
    for part in [0.1, 0.5, 0.9] {
        let half = RADIUS * (1.0 - part);
        let places = [[-half, 0.0, 0.0], [half, 0.0, 0.0]];
        let mut engine = balls("[relax]").poses("s", &places, &[]).start()?;
        let overlap = engine.report().largest_overlap_ratio;
        checks.near(format!("overlap {part}: left over the radius"), overlap, 0.5 * LEFT, 0.5 * LEFT, "-");
        let middle: f64 = snapshot(&engine).positions.iter().map(|x| x[0]).sum();
        checks.vanishes(format!("overlap {part}: middle"), middle / RADIUS, 1e-13, "-");
        let speed = fastest(checks, &mut engine)?;
        // each has half the speed of parting
        checks.vanishes(
            format!("overlap {part}: speed over sqrt(k/m) d, relaxed"),
            speed / (0.5 * omega * LEFT * RADIUS),
            1.0,
            "-",
        );
        let warned = |relax: &str| -> anyhow::Result<bool> {
            let scene = balls(relax).poses("s", &places, &[]).validate()?;
            Ok(scene.check().warnings.iter().any(|warning| warning.contains("[relax]")))
        };
        checks.holds(
            format!("overlap {part}: check warns, and does not with [relax]"),
            warned("")? && !warned("[relax]")?,
        );
    }
    Ok(())
}

/// 64 bodies at spacings of 0.6 of their size, over a floor: no pair is left with more than the limit (D of the generalized
/// overlap, a p-norm of up to 16 overlaps with p = 8, with 16^(1/8) of it), none gets faster than all of the elastic energy
/// that is left could make it, and the result is the same again.
fn clusters(checks: &mut Checks) -> anyhow::Result<()> {
    let places: Vec<[f64; 3]> = (0..64u32)
        .map(|k| {
            let shift = |factor: u32| 1e-4 * f64::from(k * factor % 11);
            [
                0.6 * 2.0 * RADIUS * f64::from(k % 4) + shift(3),
                0.6 * 2.0 * RADIUS * f64::from(k / 4 % 4) + shift(5),
                RADIUS + 0.6 * 2.0 * RADIUS * f64::from(k / 16) + shift(7),
            ]
        })
        .collect();
    let edge = 1.6 * RADIUS;
    for (name, contact, geometry) in [
        ("balls", "", format!("kind = \"sphere\", radius_m = {RADIUS:?}")),
        (
            "rods",
            "",
            format!("kind = \"spherocylinder\", radius_m = {:?}, total_length_m = {:?}", 0.5 * RADIUS, 2.0 * RADIUS),
        ),
        ("cubes, linear", "normal = \"linear\"", format!("kind = \"cube\", edge_m = {edge:?}")),
        ("cubes, generalized_overlap", "", format!("kind = \"cube\", edge_m = {edge:?}")),
        ("cubes, volume", "normal = \"volume\"", format!("kind = \"cube\", edge_m = {edge:?}")),
    ] {
        let scene = elastic("[relax]").contact(contact).shape(&geometry).floor().poses("s", &places, &[]);
        let mut engine = scene.start()?;
        let report = engine.report();
        let limit = LEFT * if name.ends_with("generalized_overlap") { 16f64.powf(0.125) } else { 1.0 };
        checks.near(
            format!("{name}: left over the radius"),
            report.largest_overlap_ratio,
            0.5 * limit,
            0.5 * limit,
            "-",
        );
        let same = scene.start()?.state_hash() == engine.state_hash();
        checks.holds(format!("{name}: the same bits again"), same);
        let mass = engine.scene().particles()[0].mass;
        let bound = (2.0 * report.energy.elastic_j / mass).sqrt();
        let speed = fastest(checks, &mut engine)?;
        checks.vanishes(
            format!("{name}: largest speed over that of all elastic energy in one body"),
            speed / bound.max(f64::MIN_POSITIVE),
            1.0,
            "-",
        );
        let unrelaxed = elastic("").contact(contact).shape(&geometry).floor().poses("s", &places, &[]);
        checks.shows(
            format!("{name}: overlap over the radius without [relax]"),
            unrelaxed.start()?.report().largest_overlap_ratio,
            "-",
        );
    }
    Ok(())
}

/// Velocities and spins are those of the scene, and the clock is at 0.
fn given_velocities(checks: &mut Checks) -> anyhow::Result<()> {
    let scene = elastic("[relax]")
        .shape("kind = \"box\", size_m = [0.02, 0.01, 0.005]")
        .particle([0.0; 3], [0.3, 0.0, -0.1], [1.0, 2.0, 3.0])
        .particle([0.012, 0.004, 0.002], [0.0, -0.2, 0.0], [-3.0, 0.5, 0.0]);
    let engine = scene.start()?;
    let state = snapshot(&engine);
    let moved = (state.positions[0][0]).abs() > 1e-5;
    let wanted = [[0.3, 0.0, -0.1], [0.0, -0.2, 0.0], [1.0, 2.0, 3.0], [-3.0, 0.5, 0.0]];
    let given: Vec<[f64; 3]> = state.velocities.into_iter().chain(state.angular_velocities).collect();
    let off = given.iter().zip(&wanted).flat_map(|(a, b)| (0..3).map(move |k| (a[k] - b[k]).abs())).fold(0.0, f64::max);
    checks.vanishes("given velocities and spins, after relaxing", off, 1e-14, "-");
    checks.holds(
        "moved, at step 0, with a balance of 0",
        moved && state.step == 0 && engine.report().energy.residual_j == 0.0,
    );
    Ok(())
}

/// Two balls between walls that leave room for one and a half: the first step is refused, with both names.
fn no_room(checks: &mut Checks) -> anyhow::Result<()> {
    let mut engine = balls("[relax]\nmax_iterations = 500")
        .plane("low", [0.0; 3], [0.0, 0.0, 1.0])
        .plane("high", [0.0, 0.0, 3.0 * RADIUS], [0.0, 0.0, -1.0])
        .poses("s", &[[0.0, 0.0, RADIUS], [0.0, 0.0, 2.0 * RADIUS]], &[])
        .start()?;
    let error = engine.step().err();
    let text = error.as_ref().map_or(String::new(), ToString::to_string);
    let named = matches!(&error, Some(StepError::NotRelaxed { a: 0 | 1, iterations: 500, .. }));
    checks.holds(format!("no room: refused ({text})"), named && text.contains("relax.max_iterations"));
    checks.holds("no room: refused again", engine.step().is_err());
    Ok(())
}
