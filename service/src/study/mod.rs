//! `sturz study`: error against run time.
//!
//! A grid of settings of one scene is run, each setting several times ([`run`]), the errors of a measure are set against
//! the wall time of the physics loop alone, and what comes out is the Pareto front, the observed order in the time step
//! and the cheapest setting for a wanted error ([`judge`]), which is then confirmed by a run of its own.

mod judge;
mod measure;
mod plan;
mod plot;
mod run;
mod table;
mod vary;

pub use judge::{Judged, Order, Point, Recommendation};
pub use measure::{MEASURES, Measure};
pub use plan::{Plan, Reference};
pub use plot::svg;
pub use run::{Sample, sample};
pub use table::print;
pub use vary::{Axis, Factor, Setting, parse_axes};

use serde::Serialize;

use crate::commands::Failure;

/// All that a study has found.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// Name of the scene.
    pub scene: String,
    /// What was measured.
    pub measure: String,
    /// Unit of the errors; `-` for relative ones.
    pub error_unit: &'static str,
    /// End of every run, simulated s.
    pub time_s: f64,
    /// Runs of each setting.
    pub samples: usize,
    /// Whether each sample has a seed of its own, so that errors are those of means and have bars.
    pub seeds: bool,
    /// What the errors are measured from, in words.
    pub reference: String,
    /// Its value, component by component.
    pub reference_value: Vec<f64>,
    /// Standard error of it; 0 without seeds.
    pub reference_standard_error: f64,
    /// What a difference was divided by to make an error.
    pub scale: f64,
    /// One for each setting, in the order of the grid.
    pub points: Vec<Point>,
    /// Observed orders in the time step and the stiffness.
    pub orders: Vec<Order>,
    /// The error that was wanted.
    pub wanted_error: f64,
    /// Cheapest setting that reaches it, if any does.
    pub recommendation: Option<Recommendation>,
    /// What a reader must know before believing it.
    pub remarks: Vec<String>,
}

/// Runs a study. `progress` is told what is about to be run, and how many runs are left with it.
pub fn study(plan: &Plan, mut progress: impl FnMut(&str, usize)) -> Result<Study, Failure> {
    let settings = plan.settings()?;
    let mut runs = run::Runs::new(plan, &settings);
    runs.go(&mut progress);
    let judged = judge::judge(plan, &settings, &runs)?;
    let mut study = Study {
        scene: plan.base.scene.name.clone(),
        measure: plan.measure.to_string(),
        error_unit: judged.unit,
        time_s: plan.time_s,
        samples: plan.samples,
        seeds: plan.seeds,
        reference: judged.reference_words,
        reference_value: judged.reference.mean,
        reference_standard_error: judged.reference.standard_error,
        scale: judged.scale,
        points: judged.points,
        orders: judged.orders,
        wanted_error: plan.wanted_error,
        recommendation: judged.recommendation,
        remarks: judged.remarks,
    };
    if plan.confirm {
        judge::confirm(plan, &settings, &mut study, &mut progress);
    }
    Ok(study)
}
