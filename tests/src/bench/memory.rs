//! What an engine holds in memory, per particle and per contact point.

use serde::Serialize;
use sturz_engine::Engine;

use super::cache::Bed;
use super::measure::{Plan, started};
use super::tiles;
use super::workload::{Softness, Workload};
use crate::scene::steps;

/// Bytes of engines of the same particles.
#[derive(Clone, Debug, Serialize)]
pub struct Memory {
    /// Name of the workload.
    pub workload: String,
    /// Particles.
    pub particles: u64,
    /// Contact points of the bed.
    pub contact_points: u64,
    /// Per particle, where nothing is near anything.
    pub bytes_per_particle: f64,
    /// What the bed has more, over its contact points: listed pairs that do not touch included.
    pub bytes_per_contact_point: f64,
}

/// Weighs a bed. `allocated` tells the bytes that the program has allocated.
pub fn memory(workload: &Workload, bed: &Bed, plan: &Plan, allocated: fn() -> usize) -> anyhow::Result<Memory> {
    let softness = Softness { step_fraction: Some(0.1), ..Softness::NONE };
    let contact = plan.normal.lines();
    let weigh = |engine: anyhow::Result<Engine>, before: usize, warm_up: u64| -> anyhow::Result<_> {
        let mut engine = engine?;
        steps(&mut engine, warm_up)?;
        // a rebuild leaves its buffers
        engine.expire_neighbours();
        steps(&mut engine, 1)?;
        Ok(((allocated() - before) as f64, engine.report()))
    };
    let before = allocated();
    let (apart, _) = weigh(tiles::start_apart(workload, bed, softness, contact), before, 0)?;
    let before = allocated();
    let (whole, report) = weigh(started(workload, bed, plan), before, plan.warm_up)?;
    Ok(Memory {
        workload: workload.name.to_owned(),
        particles: report.particles,
        contact_points: report.contact_points,
        bytes_per_particle: apart / report.particles as f64,
        bytes_per_contact_point: (whole - apart) / report.contact_points.max(1) as f64,
    })
}
