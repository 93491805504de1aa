//! S23: going on from a checkpoint, tangential springs included.

use sturz_engine::Engine;

use super::{Case, Checks};
use crate::scene::{SceneText, steps};

pub fn cases() -> Vec<Case> {
    vec![Case::fast("S23", "a run goes on from a checkpoint, tangential springs included, bit for bit", restart)]
}

/// Blocks that slide and stick on each other and on a slope.
fn slope(contact: &str, geometry: &str) -> SceneText {
    let law = "stiffness_n_per_m = 1e5\nrestitution = 0.4\nfriction = 0.3";
    let scene = SceneText::new([3.5, 0.4, -9.0], "time_step_s = 2e-5")
        .contact(contact)
        .materials(2000.0, law)
        .shape(geometry)
        .floor();
    (0..8).fold(scene, |scene, k| {
        let height = f64::from(k);
        scene.particle([0.004 * (2.0 * height).sin(), 0.0, 0.01 + 0.0205 * height], [0.0; 3], [0.0, 0.0, 3.0])
    })
}

/// Reference: the run that was never stopped; bits, hence no tolerance.
fn restart(checks: &mut Checks) -> anyhow::Result<()> {
    let cube = "kind = \"cube\", edge_m = 0.02";
    for (name, contact, geometry) in [
        ("generalized overlap", "", cube),
        ("points", "normal = \"linear\"", cube),
        ("spheres", "", "kind = \"sphere\", radius_m = 0.01"),
    ] {
        let start = || slope(contact, geometry).start();
        let mut run = start()?;
        checks.steps(&mut run, 8000)?;
        let energy = run.report().energy;
        checks
            .holds(format!("{name}: springs are stretched"), run.report().contact_points > 0 && energy.elastic_j > 0.0);
        checks.holds(format!("{name}: contacts have slid"), energy.dissipated_friction_j > 0.0);
        let saved = run.checkpoint()?;
        let mut restored = start()?;
        restored.set_threads(2);
        restored.restore(&saved)?;
        let hash = |engine: &mut Engine| steps(engine, 1).map(|()| engine.state_hash());
        let mut other = 0u32;
        for _ in 0..1000 {
            other += u32::from(hash(&mut run)? != hash(&mut restored)?);
        }
        checks.vanishes(format!("{name}: steps of 1000 with another state hash"), f64::from(other), 0.0, "-");
        checks.holds(format!("{name}: the energies agree to rounding"), {
            let (a, b) = (run.report().energy, restored.report().energy);
            (a.residual_j - b.residual_j).abs() <= 1e-11 * a.dissipated_friction_j
        });
    }
    Ok(())
}
