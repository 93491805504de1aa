//! Sliding and rolling on planes: I10, I11.

use std::f64::consts::PI;

use super::{Case, Checks};
use crate::scene::{SceneText, snapshot};

pub fn cases() -> Vec<Case> {
    vec![
        Case::fast("I10", "sphere: sliding turns into rolling", slide_to_roll),
        Case::fast("I11", "slope: block sticks, slides and topples, sphere rolls", slope),
    ]
}

const G: f64 = 9.81;
const RADIUS: f64 = 0.01;
const DENSITY: f64 = 2500.0;

fn ball_mass() -> f64 {
    DENSITY * 4.0 / 3.0 * PI * RADIUS.powi(3)
}

/// A ball on a floor that is tilted by an angle.
fn ball_on_slope(theta: f64, time_step_s: f64, law: &str) -> SceneText {
    SceneText::new([G * theta.sin(), 0.0, -G * theta.cos()], &format!("time_step_s = {time_step_s:?}"))
        .materials(DENSITY, law)
        .shape(&format!("kind = \"sphere\", radius_m = {RADIUS:?}"))
        .floor()
}

/// I10: v0 = 1, mu = 0.3: rolls from t = 2 v0/(7 mu g) = .0970827 s, x = 12 v0^2/(49 mu g) = .0832137 m on, at
/// v = v0 q/(1 + q), q = 2.5 (a/r)^2 with the law's lever arm a = r - overlap/2.
fn slide_to_roll(checks: &mut Checks) -> anyhow::Result<()> {
    let stiffness = 1e6;
    let overlap = ball_mass() * G / stiffness;
    let law = "stiffness_n_per_m = 1e6\nrestitution = 0.5\nfriction = 0.3";
    let scene = ball_on_slope(0.0, 2e-6, law).particle([0.0, 0.0, RADIUS - overlap], [1.0, 0.0, 0.0], [0.0; 3]);
    let mut engine = scene.start()?;
    let arm = RADIUS - 0.5 * overlap;
    checks.run_for(&mut engine, 0.0965)?;
    // The surface slips at a rate of 7/2 mu g until it stops: the first step on which it does not slip forward.
    let (mut time, mut x) = (f64::NAN, f64::NAN);
    for _ in 0..1000 {
        checks.steps(&mut engine, 1)?;
        let state = snapshot(&engine);
        if state.velocities[0][0] - arm * state.angular_velocities[0][1] <= 0.0 {
            (time, x) = (state.time_s, state.positions[0][0]);
            break;
        }
    }
    checks.close("time of the end of sliding", time, 2.0 / (7.0 * 0.3 * G), 1e-3, "s");
    checks.close("place of the end of sliding", x, 12.0 / (49.0 * 0.3 * G), 1e-3, "m");
    checks.run_for(&mut engine, 0.2)?;
    let state = snapshot(&engine);
    let q = 2.5 * (arm / RADIUS).powi(2);
    checks.near("rolling speed", state.velocities[0][0], q / (1.0 + q), 1e-9, "m/s");
    checks.near("rolling speed, hard sphere", state.velocities[0][0], 5.0 / 7.0, 0.6 * overlap / RADIUS, "m/s");
    checks.vanishes("slip while rolling", arm * state.angular_velocities[0][1] - state.velocities[0][0], 1e-9, "m/s");
    let energy = engine.report().energy;
    checks.vanishes("energy residual over the kinetic energy", energy.residual_j / (0.5 * ball_mass()), 1e-5, "-");
    Ok(())
}

/// I11, all parts.
fn slope(checks: &mut Checks) -> anyhow::Result<()> {
    block(checks, 0.2)?;
    block(checks, 0.4)?;
    block(checks, 0.6)?;
    rolling_ball(checks)?;
    sliding_ball(checks)?;
    toppling_box(checks, 0.98)?;
    toppling_box(checks, 1.02)
}

/// A flat block sticks iff tan th < mu = 0.5: at rest with the spring stretched by m g sin th / kt; else it slides with
/// a = g (sin th - mu cos th).
///
/// Friction acts h/2 below the centre of mass, so the block also leans: with forces k d_i^2 / sum(d_j) (sharing per
/// point) at four corners b apart the moment is k phi b^2 / 2, hence phi = m g sin th h / (k b^2), and the centre moves by
/// another phi h / 2. Measured on a gentle
/// slope: on a steep one the sudden load of the start overshoots, and slips a little.
fn block(checks: &mut Checks, theta: f64) -> anyhow::Result<()> {
    let (stiffness, size) = (1e6, [0.1, 0.1, 0.02]);
    let mass = DENSITY * size.iter().product::<f64>();
    let scene = SceneText::new([G * theta.sin(), 0.0, -G * theta.cos()], "time_step_s = 1e-5")
        .contact("normal = \"linear\"")
        .materials(DENSITY, "stiffness_n_per_m = 1e6\nrestitution = 0.2\nfriction = 0.5")
        .shape(&format!("kind = \"box\", size_m = {size:?}"))
        .floor()
        .particle([0.0, 0.0, 0.5 * size[2] - mass * G * theta.cos() / stiffness], [0.0; 3], [0.0; 3]);
    let mut engine = scene.start()?;
    checks.run_for(&mut engine, 0.4)?;
    let before = snapshot(&engine);
    checks.run_for(&mut engine, 0.1)?;
    let after = snapshot(&engine);
    if theta.tan() < 0.5 {
        let lean = size[2] * size[2] / (2.0 * size[0] * size[0]);
        let stretch = mass * G * theta.sin() / stiffness * (3.5 + lean);
        if theta.tan() < 0.25 {
            checks.close("block sticks: displacement", after.positions[0][0], stretch, 1e-3, "m");
        }
        checks.vanishes(format!("block sticks at {theta} rad: velocity"), after.velocities[0][0], 1e-9, "m/s");
    } else {
        let acceleration = (after.velocities[0][0] - before.velocities[0][0]) / 0.1;
        checks.close("block slides: acceleration", acceleration, G * (theta.sin() - 0.5 * theta.cos()), 1e-3, "m/s2");
    }
    let spin = after.angular_velocities[0].iter().fold(0f64, |worst, w| worst.max(w.abs()));
    checks.vanishes(format!("block at {theta} rad: angular velocity"), spin, 1e-6, "rad/s");
    Ok(())
}

const BALL_LAW: &str = "stiffness_n_per_m = 1e6\nrestitution = 0.5\nfriction = 0.3";

/// Acceleration along the slope between 0.1 s and 0.3 s.
fn ball_acceleration(checks: &mut Checks, theta: f64) -> anyhow::Result<f64> {
    let overlap = ball_mass() * G * theta.cos() / 1e6;
    let scene = ball_on_slope(theta, 5e-6, BALL_LAW).particle([0.0, 0.0, RADIUS - overlap], [0.0; 3], [0.0; 3]);
    let mut engine = scene.start()?;
    checks.run_for(&mut engine, 0.1)?;
    let before = snapshot(&engine).velocities[0][0];
    checks.run_for(&mut engine, 0.2)?;
    Ok((snapshot(&engine).velocities[0][0] - before) / 0.2)
}

/// Without slip if tan th <= 3.5 mu: a = 5/7 g sin th.
fn rolling_ball(checks: &mut Checks) -> anyhow::Result<()> {
    let theta = (0.95f64 * 3.5 * 0.3).atan();
    let acceleration = ball_acceleration(checks, theta)?;
    checks.close("ball rolls at 0.95 of 3.5 mu: acceleration", acceleration, 5.0 / 7.0 * G * theta.sin(), 1e-3, "m/s2");
    Ok(())
}

/// Beyond, it slides: a = g (sin th - mu cos th).
fn sliding_ball(checks: &mut Checks) -> anyhow::Result<()> {
    let theta = (1.05f64 * 3.5 * 0.3).atan();
    let acceleration = ball_acceleration(checks, theta)?;
    let expected = G * (theta.sin() - 0.3 * theta.cos());
    checks.close("ball slides at 1.05 of 3.5 mu: acceleration", acceleration, expected, 1e-3, "m/s2");
    Ok(())
}

/// A box of width b and height h = 2 b topples at tan th = b/h = 0.5 when friction holds it.
fn toppling_box(checks: &mut Checks, part_of_limit: f64) -> anyhow::Result<()> {
    let theta = (0.5 * part_of_limit).atan();
    let scene = SceneText::new([G * theta.sin(), 0.0, -G * theta.cos()], "time_step_s = 1e-5")
        .materials(DENSITY, "stiffness_n_per_m = 1e8\nrestitution = 0.2\nfriction = 2.0")
        .shape("kind = \"box\", size_m = [0.1, 0.1, 0.2]")
        .floor()
        .particle([0.0, 0.0, 0.1], [0.0; 3], [0.0; 3]);
    let mut engine = scene.start()?;
    checks.run_for(&mut engine, 1.0)?;
    let q = snapshot(&engine).orientations[0];
    let tilt = 2.0 * q[0].abs().min(1.0).acos();
    let topples = part_of_limit > 1.0;
    let verb = if topples { "topples" } else { "stands" };
    checks.holds(format!("box {verb} at tan th = {part_of_limit} b/h (tilt {tilt:.1e} rad)"), (tilt > 0.5) == topples);
    Ok(())
}
