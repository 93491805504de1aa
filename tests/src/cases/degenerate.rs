//! S6: contacts of exactly degenerate poses.

use super::{Case, Checks};
use crate::scene::{SceneText, snapshot};

pub fn cases() -> Vec<Case> {
    vec![Case::fast("S6", "exact face-face, parallel edges, vertex-vertex, coincident centres", degenerate_poses)]
}

fn base(gravity_z: f64) -> SceneText {
    SceneText::new([0.0, 0.0, gravity_z], "time_step_s = 2e-5")
        .contact("normal = \"linear\"\noverlap_limit = 2.0")
        .materials(1000.0, "stiffness_n_per_m = 1e6\nrestitution = 0.3\nfriction = 0.5")
        .shape("kind = \"cube\", edge_m = 0.2")
        .named_shape("octahedron", "kind = \"octahedron\", edge_m = 0.2")
}

fn turned(axis: usize, angle: f64) -> [f64; 4] {
    let mut q = [(0.5 * angle).cos(), 0.0, 0.0, 0.0];
    q[axis + 1] = (0.5 * angle).sin();
    q
}

/// S6, all parts.
fn degenerate_poses(checks: &mut Checks) -> anyhow::Result<()> {
    stack(checks, "aligned faces", [1.0, 0.0, 0.0, 0.0], [0.0, 0.0], 8.0)?;
    stack(checks, "faces turned by 90 deg", turned(2, std::f64::consts::FRAC_PI_2), [0.0, 0.0], 8.0)?;
    stack(checks, "faces offset by half an edge", [1.0, 0.0, 0.0, 0.0], [0.05, 0.0], 8.0)?;
    stack(checks, "faces turned by 45 deg", turned(2, std::f64::consts::FRAC_PI_4), [0.0, 0.0], 12.0)?;
    let quarter = std::f64::consts::FRAC_PI_4;
    let half_diagonal = 0.1 * 2f64.sqrt();
    // The least translation that parts edges or vertices on the same line is along a face: sin 45 deg, 1 / sqrt 3.
    let (edges, vertices) = (0.5f64.sqrt(), 3f64.sqrt().recip());
    pressed(checks, "parallel edges", "s", [turned(0, quarter); 2], 2.0 * half_diagonal, edges)?;
    pressed(checks, "crossed edges", "s", [turned(0, quarter), turned(1, quarter)], 2.0 * half_diagonal, 1.0)?;
    let straight = [1.0, 0.0, 0.0, 0.0];
    pressed(checks, "vertex on vertex", "octahedron", [straight; 2], 2.0 * half_diagonal, vertices)?;
    pressed(checks, "edge on face", "s", [straight, turned(0, quarter)], 0.1 + half_diagonal, 1.0)?;
    coincident(checks)
}

/// A cube on a cube on the floor: the number of points must settle and stay over 1e4 steps, and nothing may move.
fn stack(checks: &mut Checks, name: &str, upper: [f64; 4], offset: [f64; 2], points: f64) -> anyhow::Result<()> {
    let mass = 8.0;
    let (weight, stiffness) = (mass * 9.81, 1e6);
    let low = 0.1 - 2.0 * weight / stiffness;
    let high = low + 0.2 - weight / stiffness;
    let mut engine = base(-9.81)
        .floor()
        .poses("s", &[[0.0, 0.0, low], [offset[0], offset[1], high]], &[[1.0, 0.0, 0.0, 0.0], upper])
        .start()?;
    checks.steps(&mut engine, 2000)?;
    let (mut fewest, mut most) = (u64::MAX, 0);
    for _ in 0..1000 {
        checks.steps(&mut engine, 10)?;
        let now = engine.report().contact_points;
        (fewest, most) = (fewest.min(now), most.max(now));
    }
    checks.near(format!("{name}: fewest contact points in 1e4 steps"), fewest as f64, points, 0.0, "-");
    checks.near(format!("{name}: most contact points in 1e4 steps"), most as f64, points, 0.0, "-");
    let energy = engine.report().energy;
    let kinetic = (energy.kinetic_translation_j + energy.kinetic_rotation_j) / (2.0 * weight * 0.2);
    checks.vanishes(format!("{name}: kinetic energy per particle over m g a"), kinetic, 1e-9, "-");
    Ok(())
}

/// Two particles one above the other, overlapping by 1 % of 0.2 m along z and by `part` of that along the contact normal:
/// they must part, alike on every run, without net momentum; along z where the normal is unique.
fn pressed(
    checks: &mut Checks,
    name: &str,
    shape: &str,
    orientations: [[f64; 4]; 2],
    touching: f64,
    part: f64,
) -> anyhow::Result<()> {
    let scene = base(0.0).poses(shape, &[[0.0; 3], [0.0, 0.0, touching - 0.002]], &orientations);
    let mut hashes = Vec::new();
    for _ in 0..2 {
        let mut engine = scene.start()?;
        let start = engine.report();
        checks.steps(&mut engine, 2000)?;
        hashes.push(engine.state_hash());
        if hashes.len() == 1 {
            let state = snapshot(&engine);
            let v = state.velocities[1];
            checks.holds(format!("{name}: touches at the start"), start.contact_points > 0);
            checks.near(format!("{name}: overlap"), start.largest_overlap_m, 0.002 * part, 1e-12, "m");
            checks.holds(format!("{name}: parts along z"), v[2] > 0.0);
            if part == 1.0 {
                checks.vanishes(format!("{name}: sideways speed over upward"), v[0].hypot(v[1]) / v[2], 1e-9, "-");
            }
            let net = (0..3).map(|k| (state.velocities[0][k] + v[k]).abs()).fold(0.0, f64::max);
            checks.vanishes(format!("{name}: net velocity over upward"), net / v[2], 1e-12, "-");
        }
    }
    checks.holds(format!("{name}: the same bits again"), hashes[0] == hashes[1]);
    Ok(())
}

/// Coincident centres and identical poses: they part, or the run ends with an error; never NaN.
fn coincident(checks: &mut Checks) -> anyhow::Result<()> {
    for (name, orientation) in
        [("identical pose", [1.0, 0.0, 0.0, 0.0]), ("coincident centres, turned", turned(2, 0.3))]
    {
        for shape in ["s", "octahedron"] {
            let scene = base(0.0).poses(shape, &[[0.0; 3]; 2], &[[1.0, 0.0, 0.0, 0.0], orientation]);
            // Starting is not asked to succeed, only to say why not.
            let Ok(mut engine) = scene.start() else {
                checks.holds(format!("{name}, {shape}: refused"), true);
                continue;
            };
            let outcome = checks.steps(&mut engine, 2000);
            let state = snapshot(&engine);
            let finite = state.positions.iter().flatten().all(|x| x.is_finite());
            let gap: f64 = (0..3).map(|k| (state.positions[1][k] - state.positions[0][k]).powi(2)).sum::<f64>().sqrt();
            checks.holds(
                format!("{name}, {shape}: apart ({gap:.2} m) or an error, no NaN"),
                finite && (outcome.is_err() || gap > 0.15),
            );
        }
    }
    Ok(())
}
