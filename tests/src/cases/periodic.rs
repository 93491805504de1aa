//! S14: periodic cells.

use super::{Case, Checks};
use crate::scene::{SceneText, snapshot};

pub fn cases() -> Vec<Case> {
    vec![Case::fast("S14", "periodic cell: contact across a corner, wrap in every step, own image", periodic_cell)]
}

fn scene(periodic: bool, geometry: &str) -> SceneText {
    let scene = SceneText::new([0.0; 3], "time_step_s = 1e-5")
        .contact("normal = \"linear\"")
        .materials(1000.0, "stiffness_n_per_m = 1e6\nrestitution = 0.6\nfriction = 0.5")
        .shape(geometry);
    if periodic { scene.cell([0.0; 3], [2.0; 3]) } else { scene }
}

/// S14, all parts.
fn periodic_cell(checks: &mut Checks) -> anyhow::Result<()> {
    for geometry in [
        "kind = \"sphere\", radius_m = 0.1",
        "kind = \"cube\", edge_m = 0.2",
        "kind = \"cross_3d\", beam_length_m = 0.3, beam_width_m = 0.06",
    ] {
        across_a_corner(checks, geometry)?;
    }
    wrap_every_step(checks)?;
    for (radius, accepted) in [(0.3, true), (0.6, false), (1.1, false)] {
        let outcome = scene(true, &format!("kind = \"sphere\", radius_m = {radius:?}"))
            .particle([1.0; 3], [0.0; 3], [0.0; 3])
            .validate();
        let text = outcome.as_ref().err().map_or("accepted".to_owned(), ToString::to_string);
        checks.holds(format!("radius {radius} in a cell of 2 ({text})"), outcome.is_ok() == accepted);
    }
    Ok(())
}

/// Two particles that collide over the corner (0, 0, 0) = (2, 2, 2) move as they do in free space.
fn across_a_corner(checks: &mut Checks, geometry: &str) -> anyhow::Result<()> {
    let kind = geometry.split('"').nth(1).unwrap_or("shape");
    let spin = [3.0, -1.0, 2.0];
    let run = |checks: &mut Checks, periodic: bool| -> anyhow::Result<_> {
        let (near, far) = ([0.08, 0.07, 0.06], [-0.08, -0.07, -0.06]);
        let far = if periodic { far.map(|x| x + 2.0) } else { far };
        let mut engine = scene(periodic, geometry)
            .particle(near, [-1.0, -0.9, -1.1], spin)
            .particle(far, [1.0, 1.0, 1.0], [0.0; 3])
            .start()?;
        let mut touched = 0;
        for _ in 0..40 {
            checks.steps(&mut engine, 100)?;
            touched += engine.report().contact_points;
        }
        Ok((snapshot(&engine), touched))
    };
    let (in_cell, touched) = run(checks, true)?;
    let (free, _) = run(checks, false)?;
    checks.holds(format!("{kind}: the two met"), touched > 0);
    let mut worst = 0f64;
    for k in 0..2 {
        for axis in 0..3 {
            let apart = (in_cell.positions[k][axis] - free.positions[k][axis]).rem_euclid(2.0);
            worst = worst.max(apart.min(2.0 - apart));
            worst = worst.max((in_cell.velocities[k][axis] - free.velocities[k][axis]).abs());
        }
    }
    checks.vanishes(format!("{kind} over the corner: distance from free space"), worst, 1e-9, "m, m/s");
    Ok(())
}

/// 1.7 m per step in a cell of 2 m: the place is the one of a free particle, modulo the cell.
fn wrap_every_step(checks: &mut Checks) -> anyhow::Result<()> {
    let mut engine = scene(true, "kind = \"sphere\", radius_m = 0.1")
        .particle([0.3, 1.0, 1.0], [1.7e5, 0.0, 0.0], [0.0; 3])
        .start()?;
    checks.steps(&mut engine, 1000)?;
    let state = snapshot(&engine);
    let apart = (state.positions[0][0] - 0.3 - 1700.0).rem_euclid(2.0);
    checks.vanishes("wrap in every step: place modulo the cell", apart.min(2.0 - apart), 1e-9, "m");
    checks.holds("wrap in every step: inside the cell", (0.0..2.0).contains(&state.positions[0][0]));
    checks.holds("wrap in every step: warned of as fast", engine.report().warnings.fast_particle > 0);
    Ok(())
}
