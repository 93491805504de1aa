//! Cost and quality of a step on a settled bed.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use anyhow::ensure;
use serde::Serialize;
use sturz_engine::{Engine, Stage, StageTimer};

use super::cache::Bed;
use super::settle::kinetic;
use super::tiles;
use super::workload::{Softness, Workload};
use crate::scene::{snapshot, steps};

/// How to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Physics threads.
    pub threads: usize,
    /// Steps of each block.
    pub steps: u64,
    /// Timed blocks, of which the median counts.
    pub blocks: usize,
    /// Normal law of the measured run; the bed was settled with the linear one.
    pub normal: NormalLaw,
    /// Copies of the bed along x and y.
    pub tiles: u32,
    /// Untimed steps before: the bed comes without friction history, which must build up.
    pub warm_up: u64,
}

/// Which normal law is timed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum NormalLaw {
    /// `linear`.
    Linear,
    /// `generalized_overlap`, the default of polyhedra; linear for the others.
    #[default]
    GeneralizedOverlap,
    /// The same with F ~ D^1.5, D0 = 1e-2 of the sum of the rounding radii.
    GeneralizedOverlapThreeHalves,
}

impl NormalLaw {
    /// Lines of `[contact]`.
    pub(super) fn lines(self) -> &'static str {
        match self {
            Self::Linear => "normal = \"linear\"",
            Self::GeneralizedOverlap => "normal = \"generalized_overlap\"",
            Self::GeneralizedOverlapThreeHalves => {
                "normal = \"generalized_overlap\"\n\
                 generalized_overlap = { exponent = 1.5, reference_overlap_fraction = 1e-2 }"
            }
        }
    }

    /// As on the command line.
    fn name(self) -> String {
        clap::ValueEnum::to_possible_value(&self).map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

/// What `bench --json` writes. Units are in the names; `per_mgd` is per particle over m g size.
#[derive(Clone, Debug, Serialize)]
pub struct Measurement {
    /// Name of the workload.
    pub workload: String,
    /// Normal law.
    pub normal: String,
    /// Physics threads.
    pub threads: usize,
    /// Steps of each block.
    pub steps: u64,
    /// Timed blocks.
    pub blocks: usize,
    /// Particles.
    pub particles: u64,
    /// Pairs of particles that touch, at the end.
    pub touching_pairs: u64,
    /// Pairs of a particle and a wall that touch, at the end.
    pub touching_boundary_pairs: u64,
    /// Contact points of both.
    pub contact_points: u64,
    /// Of these smooth (and vertex-edge, vertex-vertex), vertex-face, edge-edge.
    pub contact_points_by_kind: [u64; 3],
    /// Pairs of particles, and contact points by kind, of the bed before the first step.
    pub at_start: (u64, [u64; 3]),
    /// Median over the blocks.
    pub particle_steps_per_s: f64,
    /// Slowest and fastest block.
    pub particle_steps_per_s_range: [f64; 2],
    /// Wall time of a step over the touching pairs of particles, microseconds.
    pub us_per_touching_pair: f64,
    /// Part of each stage in the time of a step, from a block of its own.
    pub stage_share: serde_json::Map<String, serde_json::Value>,
    /// Largest resident memory of the process so far, where the system tells.
    pub peak_rss_mib: Option<f64>,
    /// Cost of a rebuild of the neighbour list, with all that a step after it has to do more, over that of a step.
    pub rebuild_over_step: f64,
    /// Rebuilds of the neighbour list in all steps.
    pub neighbour_rebuilds: u64,
    /// Largest overlap over the smaller bounding radius, at the end.
    pub largest_overlap_ratio: f64,
    /// Kinetic energy at the end.
    pub kinetic_energy_per_mgd: f64,
    /// Growth of the energy residual over the measured steps.
    pub energy_residual_per_mgd: f64,
    /// Simulated time step, s.
    pub time_step_s: f64,
    /// Critical time step of a single contact, s.
    pub critical_time_step_s: f64,
}

/// The bed at rest under the plan's law, with the workload's own step where the law allows it.
pub(super) fn started(workload: &Workload, bed: &Bed, plan: &Plan) -> anyhow::Result<Engine> {
    let start = |softness: Softness| tiles::start(workload, bed, plan.tiles, softness, plan.normal.lines());
    match start(Softness::NONE) {
        // The workload's step may be too long for this law; what a step costs does not depend on its length.
        Err(_) if plan.normal != NormalLaw::Linear => start(Softness { step_fraction: Some(0.8), ..Softness::NONE }),
        outcome => outcome,
    }
}

/// Runs the bed and times it.
pub fn measure(workload: &Workload, bed: &Bed, plan: &Plan) -> anyhow::Result<Measurement> {
    let mut engine = started(workload, bed, plan)?;
    engine.set_threads(plan.threads);
    let sizes = snapshot(&engine).scales;
    ensure!(
        plan.tiles > 1 || sizes == bed.scales,
        "the engine gives other sizes to the same seed and ids: raise the cache version"
    );
    let first = engine.report();
    steps(&mut engine, plan.warm_up)?;
    let before = engine.report();
    let mut rates = Vec::with_capacity(plan.blocks);
    for _ in 0..plan.blocks {
        let start = Instant::now();
        steps(&mut engine, plan.steps)?;
        rates.push(engine.len() as f64 * plan.steps as f64 / start.elapsed().as_secs_f64());
    }
    rates.sort_unstable_by(f64::total_cmp);
    let stage_share = stage_shares(&mut engine, plan.steps)?;
    let rebuild_over_step = rebuild_over_step(&mut engine)?;
    let report = engine.report();
    let rate = median(&rates);
    let per_mgd = 1.0 / (engine.len() as f64 * workload.energy_unit_j());
    Ok(Measurement {
        workload: workload.name.to_owned(),
        normal: plan.normal.name(),
        threads: plan.threads,
        steps: plan.steps,
        blocks: plan.blocks,
        particles: report.particles,
        touching_pairs: report.touching_pairs,
        touching_boundary_pairs: report.touching_boundary_pairs,
        contact_points: report.contact_points,
        contact_points_by_kind: report.contact_points_by_kind,
        at_start: (first.touching_pairs, first.contact_points_by_kind),
        particle_steps_per_s: rate,
        particle_steps_per_s_range: [rates[0], rates[rates.len() - 1]],
        us_per_touching_pair: 1e6 * report.particles as f64 / rate / report.touching_pairs.max(1) as f64,
        stage_share,
        peak_rss_mib: peak_rss_mib(),
        rebuild_over_step,
        neighbour_rebuilds: report.neighbour_rebuilds,
        largest_overlap_ratio: report.largest_overlap_ratio,
        kinetic_energy_per_mgd: kinetic(&engine, workload),
        energy_residual_per_mgd: (report.energy.residual_j - before.energy.residual_j) * per_mgd,
        time_step_s: report.time_step_s,
        critical_time_step_s: report.critical_time_step_s,
    })
}

fn median(sorted: &[f64]) -> f64 {
    let n = sorted.len();
    0.5 * (sorted[(n - 1) / 2] + sorted[n / 2])
}

/// Adds up laps; the totals are shared with whoever reads them.
struct Laps {
    last: Instant,
    totals: Arc<Mutex<[Duration; Stage::ALL.len()]>>,
}

impl StageTimer for Laps {
    fn begin(&mut self) {
        self.last = Instant::now();
    }

    fn lap(&mut self, stage: Stage) {
        let now = Instant::now();
        let index = Stage::ALL.iter().position(|&s| s == stage).expect("ALL has every stage");
        self.totals.lock().expect("no reader panics")[index] += now - self.last;
        self.last = now;
    }
}

/// Part of each stage in a block of steps, which is slower than one without a timer and hence not counted elsewhere.
fn stage_shares(engine: &mut Engine, n: u64) -> anyhow::Result<serde_json::Map<String, serde_json::Value>> {
    let totals = Arc::new(Mutex::new([Duration::ZERO; Stage::ALL.len()]));
    engine.set_timer(Some(Box::new(Laps { last: Instant::now(), totals: Arc::clone(&totals) })));
    let outcome = steps(engine, n);
    engine.set_timer(None);
    outcome?;
    let totals = totals.lock().expect("no timer panics");
    let sum: f64 = totals.iter().map(Duration::as_secs_f64).sum();
    let share = |(stage, total): (&Stage, &Duration)| (stage.name().to_owned(), (total.as_secs_f64() / sum).into());
    Ok(Stage::ALL.iter().zip(totals.iter()).map(share).collect())
}

/// Median over pairs of a step with a forced rebuild and a stretch of steps without: what the machine does besides
/// hits both alike.
fn rebuild_over_step(engine: &mut Engine) -> anyhow::Result<f64> {
    const PAIRS: usize = 15;
    const PLAIN: u64 = 4;
    let mut ratios = Vec::with_capacity(PAIRS);
    for _ in 0..PAIRS {
        let start = Instant::now();
        steps(engine, PLAIN)?;
        let plain = start.elapsed().as_secs_f64() / PLAIN as f64;
        engine.expire_neighbours();
        let start = Instant::now();
        steps(engine, 1)?;
        ratios.push(start.elapsed().as_secs_f64() / plain - 1.0);
    }
    ratios.sort_unstable_by(f64::total_cmp);
    Ok(median(&ratios))
}

/// `VmHWM` of `/proc/self/status`.
fn peak_rss_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / 1024.0)
}
