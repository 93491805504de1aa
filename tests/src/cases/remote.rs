//! S13: coordinates far from the origin.

use super::{Case, Checks};
use crate::scene::{SceneText, snapshot};

pub fn cases() -> Vec<Case> {
    vec![Case::fast("S13", "all coordinates 1e6 and 1e8 sizes away", far_away)]
}

/// Radius of a ball, m; k so that it rests on an overlap of 1e-5 of its diameter.
const RADIUS: f64 = 0.5;

/// Three balls on a floor, one dropped on two, `offset` away along x and z.
fn heap(offset: f64, origin: &str) -> SceneText {
    let mass = 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    let stiffness = mass * 9.81 / 1e-5;
    let law = format!("stiffness_n_per_m = {stiffness:?}\nrestitution = 0.5\nfriction = 0.5");
    SceneText::new([0.0, 0.0, -9.81], "time_step_s = 2e-5")
        .section(&format!("[domain]\n{origin}"))
        .materials(1000.0, &law)
        .shape(&format!("kind = \"sphere\", radius_m = {RADIUS:?}"))
        .plane("floor", [offset, 0.0, offset], [0.0, 0.0, 1.0])
        .plane("left", [offset, 0.0, 0.0], [1.0, 0.0, 0.0])
        .plane("right", [offset + 2.1, 0.0, 0.0], [-1.0, 0.0, 0.0])
        .poses(
            "s",
            &[
                [offset + 0.5, 0.0, offset + 0.5],
                [offset + 1.5625, 0.0, offset + 0.5],
                [offset + 1.0, 0.0, offset + 1.5],
            ],
            &[],
        )
}

/// With `domain.origin_m` and coordinates relative to it, every bit is that of the scene at home. Without, the force
/// on the floor once the balls rest is off by at most 10 ulp(offset) over the overlap; `check` warns of it above 1e-6,
/// and above 1e-2 the scene is refused.
fn far_away(checks: &mut Checks) -> anyhow::Result<()> {
    let mut home = heap(0.0, "").start()?;
    let mut named = heap(0.0, "origin_m = [1e8, 0.0, 1e8]").start()?;
    checks.steps(&mut home, 200_000)?;
    checks.steps(&mut named, 200_000)?;
    checks.holds("with origin_m: state hash as at home", home.state_hash() == named.state_hash());
    let weight = 3.0 * 9.81 * 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
    let force = |engine: &sturz_engine::Engine| -snapshot(engine).boundaries[0].force_n[2];
    checks.close("at home: force on the floor", force(&home), weight, 1e-9, "N");
    let offset = 1e6;
    let far = heap(offset, "");
    let limit = 10.0 * (f64::next_up(offset) - offset) / 1e-5;
    let warned = far.validate()?.check().warnings.iter().any(|warning| warning.contains("origin_m"));
    checks.holds("1e6 sizes away: check warns and names origin_m", warned);
    let quiet = heap(0.0, "").validate()?.check().warnings.iter().all(|warning| !warning.contains("origin_m"));
    checks.holds("at home it does not", quiet);
    let mut engine = far.start()?;
    checks.steps(&mut engine, 200_000)?;
    checks.close("1e6 sizes away: force on the floor", force(&engine), weight, limit, "N");
    let text = heap(1e8, "").validate().err().map_or(String::new(), |error| error.to_string());
    checks.holds("1e8 sizes away: refused, names origin_m", text.contains("domain.origin_m"));
    Ok(())
}
