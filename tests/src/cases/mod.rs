//! Cases with references, named by the ids of PHYSICS.md. One file per group.

mod boundaries;
mod coupling;
mod cylinder;
mod degenerate;
mod energy;
mod extremes;
mod field_precision;
mod fields;
mod glued;
mod hertz;
mod impact;
mod lattice;
mod oblique;
mod oblique_ode;
mod periodic;
mod r518;
mod refusals;
mod relaxation;
mod remote;
mod resistance;
mod restart;
mod restitution;
mod rotation;
mod rounded;
mod rounded_pose;
mod shapes;
mod size_ratio;
mod slender;
mod sliding;
mod stability;
mod standing;

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::Context as _;
use serde::{Deserialize, Deserializer, Serialize};
use sturz_engine::Engine;

use crate::report::Curve;

/// One compared number, as `validate --json` writes it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    /// Id of the case.
    pub id: Cow<'static, str>,
    /// What was measured.
    pub metric: String,
    /// What the engine gives.
    pub value: f64,
    /// What it should give.
    pub reference: f64,
    /// Allowed distance of the two, in the unit of both; infinite (null in JSON) for figures that are shown and not judged.
    #[serde(deserialize_with = "null_as_infinity")]
    pub tolerance: f64,
    /// Unit; `-` for pure numbers, `true` for statements (1 is true).
    pub unit: Cow<'static, str>,
    /// Whether the distance is within the tolerance.
    pub pass: bool,
    /// Wall time since the row before, s.
    pub wall_s: f64,
    /// Particle-steps since the row before.
    pub particle_steps: u64,
}

fn null_as_infinity<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
}

impl Row {
    /// Whether it compares anything.
    pub fn is_judged(&self) -> bool {
        self.tolerance.is_finite()
    }

    /// As a line on standard output.
    pub fn print(&self) {
        let mark = if self.pass { "ok  " } else { "FAIL" };
        if self.unit == "true" {
            println!("  {mark} {}", self.metric);
            return;
        }
        if !self.is_judged() {
            println!("       {:58} {:>15.9e} {}", self.metric, self.value, self.unit);
            return;
        }
        println!(
            "  {mark} {:58} {:>15.9e} reference {:>15.9e} +- {:.1e} {}",
            self.metric, self.value, self.reference, self.tolerance, self.unit
        );
    }
}

/// Sums rows up on standard output and writes them as an array of JSON; how many have failed.
pub fn conclude(rows: &[Row], json: Option<&Path>) -> anyhow::Result<usize> {
    let failed = rows.iter().filter(|row| !row.pass).count();
    let wall_s: f64 = rows.iter().map(|row| row.wall_s).sum();
    let judged = rows.iter().filter(|row| row.is_judged()).count();
    let shown = rows.len() - judged;
    println!("{judged} comparisons, {failed} failed, {shown} figures only shown, {wall_s:.1} s");
    if let Some(path) = json {
        let text = serde_json::to_string_pretty(rows)? + "\n";
        std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(failed)
}

/// Takes down what a case measures.
pub struct Checks {
    id: &'static str,
    rows: Vec<Row>,
    curves: Vec<Curve>,
    since: Instant,
    loop_time: Duration,
    particle_steps: u64,
    data: PathBuf,
}

impl Checks {
    /// Of a case.
    pub fn new(id: &'static str, data: PathBuf) -> Self {
        Self {
            id,
            rows: Vec::new(),
            curves: Vec::new(),
            since: Instant::now(),
            loop_time: Duration::ZERO,
            particle_steps: 0,
            data,
        }
    }

    /// What was taken down, without curves.
    pub fn into_rows(self) -> Vec<Row> {
        self.rows
    }

    /// Wall time of the steps since this was last asked, s: without setting up, looking at and judging.
    pub fn loop_time_s(&mut self) -> f64 {
        std::mem::take(&mut self.loop_time).as_secs_f64()
    }

    /// A line for a plot of the report: error against something, log-log.
    pub fn draws(&mut self, plot: &str, axes: (&str, &str), series: impl Into<String>, points: Vec<(f64, f64)>) {
        let axes = (axes.0.into(), axes.1.into());
        self.curves.push(Curve { plot: format!("{}: {plot}", self.id), axes, series: series.into(), points });
    }

    /// The two lines of a work-precision diagram: error against the time step over the contact duration (or what `step`
    /// names), and against the wall time of the physics loop. Points are (step, wall time in s, error).
    pub fn work_precision(&mut self, error: &str, step: &str, series: &str, points: &[(f64, f64, f64)]) {
        let over = |x: fn(&(f64, f64, f64)) -> f64| points.iter().map(|point| (x(point), point.2)).collect();
        self.draws(&format!("{error} against the step"), (step, error), series, over(|point| point.0));
        let wall = "wall time of the physics loop, s";
        self.draws(&format!("{error} against run time"), (wall, error), series, over(|point| point.1));
    }

    /// Folder of reference data that the repository does not hold.
    pub fn data(&self) -> &Path {
        &self.data
    }

    /// Does `n` steps, which are counted.
    pub fn steps(&mut self, engine: &mut Engine, n: u64) -> anyhow::Result<()> {
        self.particle_steps += n * engine.len() as u64;
        let begin = Instant::now();
        let outcome = crate::scene::steps(engine, n);
        self.loop_time += begin.elapsed();
        outcome
    }

    /// Counts particle-steps done elsewhere.
    pub fn count(&mut self, particle_steps: u64) {
        self.particle_steps += particle_steps;
    }

    /// Steps for a duration, met exactly.
    pub fn run_for(&mut self, engine: &mut Engine, duration_s: f64) -> anyhow::Result<()> {
        let n = engine.begin_window(duration_s)?;
        self.steps(engine, n)?;
        engine.end_window();
        Ok(())
    }

    /// Compares with an absolute tolerance.
    pub fn near(&mut self, metric: impl Into<String>, value: f64, reference: f64, tolerance: f64, unit: &'static str) {
        self.rows.push(Row {
            id: self.id.into(),
            metric: metric.into(),
            value,
            reference,
            tolerance,
            unit: unit.into(),
            pass: (value - reference).abs() <= tolerance,
            wall_s: self.since.elapsed().as_secs_f64(),
            particle_steps: std::mem::take(&mut self.particle_steps),
        });
        self.since = Instant::now();
    }

    /// Compares with a tolerance relative to the reference.
    pub fn close(&mut self, metric: impl Into<String>, value: f64, reference: f64, relative: f64, unit: &'static str) {
        self.near(metric, value, reference, relative * reference.abs(), unit);
    }

    /// A number that should be 0, and may be `limit` off.
    pub fn vanishes(&mut self, metric: impl Into<String>, value: f64, limit: f64, unit: &'static str) {
        self.near(metric, value, 0.0, limit, unit);
    }

    /// A figure for tables, not judged.
    pub fn shows(&mut self, metric: impl Into<String>, value: f64, unit: &'static str) {
        self.near(metric, if value.is_finite() { value } else { f64::MAX }, 0.0, f64::INFINITY, unit);
    }

    /// A statement.
    pub fn holds(&mut self, metric: impl Into<String>, truth: bool) {
        self.near(metric, f64::from(u8::from(truth)), 1.0, 0.0, "true");
    }
}

/// How long a validation may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum Tier {
    /// Minutes; the cases are tests as well.
    Fast,
    /// Two hours at most on two cores.
    Nightly,
    /// Days; all there is.
    Release,
}

impl Tier {
    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Tier::Fast => "fast",
            Tier::Nightly => "nightly",
            Tier::Release => "release",
        }
    }
}

/// A case: what is computed, and against what.
pub struct Case {
    /// Id in PHYSICS.md.
    pub id: &'static str,
    /// One line.
    pub title: &'static str,
    /// From which tier on it runs when no id is given.
    pub tier: Tier,
    run: fn(&mut Checks) -> anyhow::Result<()>,
}

impl Case {
    const fn fast(id: &'static str, title: &'static str, run: fn(&mut Checks) -> anyhow::Result<()>) -> Self {
        Self { id, title, tier: Tier::Fast, run }
    }

    const fn slow(id: &'static str, title: &'static str, run: fn(&mut Checks) -> anyhow::Result<()>) -> Self {
        Self { id, title, tier: Tier::Release, run }
    }

    /// Runs the case with the reference data in its usual place.
    pub fn rows(&self) -> Vec<Row> {
        self.rows_with(&Self::default_data())
    }

    /// `../shared/oracles`, seen from the root of the repository.
    pub fn default_data() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/oracles")
    }

    /// Runs the case. A case that cannot be run ends with a row that fails and says why.
    pub fn rows_with(&self, data: &Path) -> Vec<Row> {
        self.outcome_with(data).0
    }

    /// The same with the curves for the report.
    pub fn outcome_with(&self, data: &Path) -> (Vec<Row>, Vec<Curve>) {
        let mut checks = Checks::new(self.id, data.to_owned());
        if let Err(error) = (self.run)(&mut checks) {
            checks.holds(format!("ran to its end ({error})"), false);
        }
        (checks.rows, checks.curves)
    }
}

/// All cases.
pub fn registry() -> Vec<Case> {
    [
        shapes::cases(),
        lattice::cases(),
        rotation::cases(),
        impact::cases(),
        restitution::cases(),
        hertz::cases(),
        glued::cases(),
        resistance::cases(),
        slender::cases(),
        sliding::cases(),
        stability::cases(),
        cylinder::cases(),
        degenerate::cases(),
        extremes::cases(),
        periodic::cases(),
        boundaries::cases(),
        refusals::cases(),
        remote::cases(),
        size_ratio::cases(),
        rounded::cases(),
        energy::cases(),
        standing::cases(),
        restart::cases(),
        fields::cases(),
        field_precision::cases(),
        coupling::cases(),
        r518::cases(),
    ]
    .into_iter()
    .flatten()
    .collect()
}
