//! S3: one large sphere among many small ones.
//!
//! Contacts are counted against a look at all pairs; the cost of a neighbour rebuild per particle is compared with that
//! of the same small spheres alone. S3 of PHYSICS.md allows a factor of 2.

use std::time::{Duration, Instant};

use sturz_engine::Engine;

use super::{Case, Checks};
use crate::scene::{SceneText, snapshot};

/// Radius of a small sphere, m.
const SMALL: f64 = 0.5;
/// Spacing of their lattice over the diameter: neighbours along the axes overlap by 1 %.
const SPACING: f64 = 0.99;

pub fn cases() -> Vec<Case> {
    vec![
        Case::fast("S3", "size ratio 1:100 and 1:1000: contacts as by all pairs", contacts),
        Case::slow("S3-cost", "size ratio 1:100 and 1:1000: rebuild per particle over that of equal sizes", cost),
    ]
}

/// Small spheres on a square lattice of `side` by `side` in `layers`, and one `ratio` times as large under them (or in
/// none of their number when `ratio` is 0); it overlaps the lowest layer around its summit.
fn scene(ratio: f64, side: u32, layers: u32) -> SceneText {
    let middle = 0.5 * f64::from(side - 1) * SPACING;
    let small: Vec<[f64; 3]> = (0..layers)
        .flat_map(|z| (0..side).flat_map(move |y| (0..side).map(move |x| [x, y, z])))
        .map(|[x, y, z]| [f64::from(x) * SPACING - middle, f64::from(y) * SPACING - middle, f64::from(z) * SPACING])
        .collect();
    let text = SceneText::new([0.0; 3], "time_step_s = 1e-6")
        .contact("overlap_limit = 1.0")
        .materials(1000.0, "stiffness_n_per_m = 1e5\nrestitution = 0.5\nfriction = 0.5")
        .shape(&format!("kind = \"sphere\", radius_m = {SMALL:?}"))
        .poses("s", &small, &[]);
    if ratio == 0.0 {
        return text;
    }
    let radius = SMALL * ratio;
    text.named_shape("large", &format!("kind = \"sphere\", radius_m = {radius:?}")).poses(
        "large",
        &[[0.0, 0.0, 0.02 * SMALL - radius - SMALL]],
        &[],
    )
}

/// Touching pairs of the present state by looking at all of them.
fn all_pairs(engine: &Engine, ratio: f64) -> u64 {
    let state = snapshot(engine);
    let large = state.positions.len() - 1;
    let radius = |k: usize| if k == large { SMALL * ratio } else { SMALL };
    let mut touching = 0;
    for a in 0..state.positions.len() {
        for b in 0..a {
            let reach = radius(a) + radius(b);
            let (x, y) = (state.positions[a], state.positions[b]);
            let distance2: f64 = (0..3).map(|k| (x[k] - y[k]).powi(2)).sum();
            touching += u64::from(distance2 < reach * reach);
        }
    }
    touching
}

fn contacts(checks: &mut Checks) -> anyhow::Result<()> {
    for ratio in [100.0, 1000.0] {
        let mut engine = scene(ratio, 24, 4).start()?;
        checks.steps(&mut engine, 20)?;
        let (found, expected) = (engine.report().touching_pairs, all_pairs(&engine, ratio));
        checks.holds(format!("1:{ratio}: some of {expected} pairs are of both sizes"), expected > 6144);
        checks.near(format!("1:{ratio}: touching pairs"), found as f64, expected as f64, 0.0, "-");
    }
    Ok(())
}

fn cost(checks: &mut Checks) -> anyhow::Result<()> {
    let mut equal = scene(0.0, 60, 28).start()?;
    for ratio in [100.0, 1000.0] {
        let mut mixed = scene(ratio, 60, 28).start()?;
        let mut ratios = Vec::new();
        // In turns and by the median: whatever else the machine does hits both alike.
        for _ in 0..15 {
            let reference = rebuild(&mut equal)?;
            ratios.push(rebuild(&mut mixed)?.as_secs_f64() / reference.as_secs_f64());
        }
        ratios.sort_unstable_by(f64::total_cmp);
        checks.near(format!("1:{ratio}: step with rebuild over equal sizes"), ratios[7], 1.0, 1.0, "-");
    }
    Ok(())
}

/// A step with a rebuild of the neighbour list.
fn rebuild(engine: &mut Engine) -> anyhow::Result<Duration> {
    engine.expire_neighbours();
    let start = Instant::now();
    engine.step()?;
    Ok(start.elapsed())
}
