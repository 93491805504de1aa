//! Brings a workload to rest: soft and with a large step first, then as specified.

use sturz_engine::Engine;

use super::cache::{self, Bed};
use super::workload::{GRAVITY, Softness, Workload};
use crate::scene::steps;

/// A stage of the settling.
struct Stage {
    softness: Softness,
    /// Done when the kinetic energy per particle falls below this, in m g size,
    quiet: f64,
    /// and at the latest after this time, in times of fall from the insertion's height.
    longest: f64,
}

/// Steps between two looks at the kinetic energy.
const LOOK_EVERY: u64 = 100;

fn stages(workload: &Workload) -> [Stage; 3] {
    let soft = |stiffness, step_fraction| Softness {
        stiffness,
        step_fraction: Some(step_fraction),
        restitution: Some(workload.restitution.min(0.3)),
    };
    [
        Stage { softness: soft(0.01, 0.2), quiet: 1e-3, longest: 3.0 },
        Stage { softness: soft(0.1, 0.2), quiet: 1e-4, longest: 0.3 },
        Stage { softness: Softness::NONE, quiet: 1e-6, longest: 0.15 },
    ]
}

/// The workload at rest: from the cache, or settled now (and then kept). `say` gets a line per stage.
pub fn settled(workload: &Workload, threads: usize, say: &mut dyn FnMut(String)) -> anyhow::Result<Bed> {
    if let Some(bed) = cache::load(workload) {
        return Ok(bed);
    }
    let mut bed: Option<Bed> = None;
    for stage in stages(workload) {
        let scene = match &bed {
            None => workload.loose(stage.softness),
            Some(bed) => workload.from_bed(bed, stage.softness),
        };
        let mut engine = scene.start()?;
        engine.set_threads(threads);
        quieten(&mut engine, workload, &stage, bed.is_none())?;
        say(format!(
            "{}: stiffness x {:?}: {} steps of {:.2e} s, kinetic energy {:.1e} m g size",
            workload.name,
            stage.softness.stiffness,
            engine.clock().step(),
            engine.clock().time_step_s(),
            kinetic(&engine, workload)
        ));
        bed = Some(Bed::of(&engine));
    }
    let bed = bed.expect("there are stages");
    cache::store(workload, &bed)?;
    Ok(bed)
}

/// Kinetic energy per particle in m g size.
pub fn kinetic(engine: &Engine, workload: &Workload) -> f64 {
    let energy = engine.report().energy;
    (energy.kinetic_translation_j + energy.kinetic_rotation_j) / (engine.len() as f64 * workload.energy_unit_j())
}

/// Steps until the bed is quiet. A loose one is not asked before it has fallen.
fn quieten(engine: &mut Engine, workload: &Workload, stage: &Stage, loose: bool) -> anyhow::Result<()> {
    let fall_s = (2.0 * workload.loose_height_m() / GRAVITY).sqrt();
    loop {
        steps(engine, LOOK_EVERY)?;
        let time_s = engine.clock().time_s();
        let may_stop = !loose || time_s > fall_s;
        if time_s > stage.longest * fall_s || (may_stop && kinetic(engine, workload) < stage.quiet) {
            return Ok(());
        }
    }
}
