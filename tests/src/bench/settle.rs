//! Brings a workload to rest: soft and with a large step first, then as specified.
//!
//! A soft bed is compressed by more than a stiff one and would jump when stiffened. So gravity is lowered slowly by the
//! ratio of the stiffnesses first: then overlaps are those of the stiff bed, and the forces of the linear law scale.

use sturz_engine::{Command, Engine};

use super::cache::{self, Bed};
use super::given;
use super::workload::{GRAVITY, Softness, Workload};
use crate::scene::steps;

/// The law that beds settle under: soft, they overlap by more than the rounding of polyhedra.
const LAW: &str = "normal = \"linear\"";

/// Steps between two looks at the kinetic energy, and between two changes of gravity.
const LOOK_EVERY: u64 = 50;

/// Stiffness of the falling bed, and gravity at its end, over the specified ones.
const SOFT: f64 = 0.01;

/// The workload at rest: from the cache, or settled now (and then kept). `say` gets a line per stage.
pub fn settled(workload: &Workload, threads: usize, say: &mut dyn FnMut(String)) -> anyhow::Result<Bed> {
    if workload.is_given {
        return given::bed(workload.name);
    }
    if let Some(bed) = cache::load(workload) {
        return Ok(bed);
    }
    let soft = Softness { stiffness: SOFT, step_fraction: Some(0.2), restitution: Some(workload.restitution.min(0.3)) };
    let mut engine = workload.loose(soft).contact(LAW).start()?;
    engine.set_threads(threads);
    let mut tell = |stage: &str, engine: &Engine| {
        say(format!(
            "{} {stage}: {} steps of {:.2e} s, kinetic energy {:.1e} m g size per particle",
            workload.name,
            engine.clock().step(),
            engine.clock().time_step_s(),
            kinetic(engine, workload)
        ));
    };
    let fall_s = (2.0 * workload.loose_height_m() / GRAVITY).sqrt();
    let short_s = (workload.size_m / GRAVITY).sqrt();
    run(&mut engine, fall_s)?;
    quieten(&mut engine, workload, 1e-6, fall_s + 20.0 * short_s)?;
    tell("has fallen", &engine);
    lower_gravity(&mut engine, 1.5 * short_s)?;
    quieten(&mut engine, workload, 1e-5 * SOFT, 10.0 * short_s)?;
    tell("is light", &engine);
    let mut engine = workload.from_bed(&Bed::of(&engine), Softness::NONE).contact(LAW).start()?;
    engine.set_threads(threads);
    // The friction springs of the soft bed are gone: the bed slips by their stretch before it rests again.
    run(&mut engine, 2000.0 * workload.time_step_s)?;
    quieten(&mut engine, workload, 1e-7, 6000.0 * workload.time_step_s)?;
    tell("is stiff", &engine);
    let bed = Bed::of(&engine);
    cache::store(workload, &bed)?;
    Ok(bed)
}

/// Kinetic energy per particle in m g size.
pub fn kinetic(engine: &Engine, workload: &Workload) -> f64 {
    let energy = engine.report().energy;
    (energy.kinetic_translation_j + energy.kinetic_rotation_j) / (engine.len() as f64 * workload.energy_unit_j())
}

fn run(engine: &mut Engine, time_s: f64) -> anyhow::Result<()> {
    steps(engine, (time_s / engine.clock().time_step_s()).ceil() as u64)
}

/// Steps until the kinetic energy per particle is below `quiet` m g size, or for `longest_s`.
fn quieten(engine: &mut Engine, workload: &Workload, quiet: f64, longest_s: f64) -> anyhow::Result<()> {
    let end_s = engine.clock().time_s() + longest_s;
    while engine.clock().time_s() < end_s && kinetic(engine, workload) >= quiet {
        steps(engine, LOOK_EVERY)?;
    }
    Ok(())
}

/// Gravity falls as exp(-t / tau) to the part [`SOFT`] of it. An exponential keeps jumps below (expansion / tau)^2 / g.
fn lower_gravity(engine: &mut Engine, tau_s: f64) -> anyhow::Result<()> {
    let start_s = engine.clock().time_s();
    let mut factor = 1.0;
    while factor > SOFT {
        factor = (-(engine.clock().time_s() - start_s) / tau_s).exp().max(SOFT);
        engine.apply(&Command::SetGravity([0.0, 0.0, -GRAVITY * factor]))?;
        steps(engine, LOOK_EVERY)?;
    }
    Ok(())
}
