//! `sturz run`: a scene without a bus, with a progress bar, and a report at the end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use sturz_engine::{Engine, Report, Stage, StepError};

use crate::cli;
use crate::commands::{Failure, print_json, table};
use crate::course;
use crate::scenes;
use crate::stages::StageTotals;

/// How long the engine steps before the progress bar is looked after.
const SLICE: Duration = Duration::from_millis(100);

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// At the time asked for.
    Complete,
    /// By Ctrl-C or SIGTERM.
    Interrupted,
    /// A step was refused.
    Failed,
}

/// How wrong, how long.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// Name of the scene.
    pub scene: String,
    /// How it ended.
    pub ending: Ending,
    /// Why it failed.
    pub failure: Option<String>,
    /// Of the physics.
    pub threads: u16,
    /// Wall time of the steps, s.
    pub wall_s: f64,
    /// Steps per wall second.
    pub steps_per_s: f64,
    /// Particle-steps per wall second.
    pub particle_steps_per_s: f64,
    /// Simulated seconds per wall second.
    pub simulated_s_per_wall_s: f64,
    /// Part of the wall time of each stage.
    pub stage_share: Vec<(&'static str, f64)>,
    /// Hash of the last state, hexadecimal.
    pub state_hash: String,
    /// Report on the last state.
    pub report: Report,
}

/// Runs a scene to its end.
pub fn run(options: &cli::Run) -> Result<(), Failure> {
    let scene = scenes::load_from(&options.scene.scene, options.from.as_deref())?;
    let stop_s = options.time.or(scene.description().stop.time_s).ok_or_else(|| {
        Failure::Usage("when shall it end? Give --time SECONDS, or `[stop] time_s` in the scene".into())
    })?;
    if !(stop_s.is_finite() && stop_s > 0.0) {
        return Err(Failure::Usage(format!("--time is {stop_s}, must be positive and finite")));
    }
    let name = scene.description().scene.name.clone();
    let totals = StageTotals::default();
    let mut engine = Engine::new(scene);
    engine.set_threads(options.threads.into());
    engine.set_timer(Some(totals.timer()));
    let interrupted = watch_signals()?;
    let bar = progress_bar(&name, &engine, stop_s, options.json);
    let started = Instant::now();
    let mut particle_steps = 0;
    let (ending, failure) = loop {
        let slice = engine.in_pool(|engine| step_for_a_slice(engine, stop_s));
        particle_steps += slice.particle_steps;
        tell_happenings(&bar, &mut engine);
        show_progress(&bar, &engine, started);
        match slice.outcome {
            Err(failure) => break (Ending::Failed, Some(failure.to_string())),
            Ok(()) if engine.clock().time_s() >= stop_s => break (Ending::Complete, None),
            Ok(()) if interrupted.load(Relaxed) => break (Ending::Interrupted, None),
            Ok(()) => {}
        }
    };
    bar.finish_and_clear();
    let wall_s = started.elapsed().as_secs_f64().max(1e-9);
    let report = engine.report();
    let summary = Summary {
        scene: name,
        ending,
        failure,
        threads: options.threads,
        wall_s,
        steps_per_s: report.step as f64 / wall_s,
        particle_steps_per_s: particle_steps as f64 / wall_s,
        simulated_s_per_wall_s: report.time_s / wall_s,
        stage_share: shares(&totals),
        state_hash: format!("{:016x}", engine.state_hash()),
        report,
    };
    if options.json {
        print_json(&summary)?;
    } else {
        table::print(&summary);
    }
    match ending {
        Ending::Complete => Ok(()),
        Ending::Failed => Err(Failure::Reported(4)),
        Ending::Interrupted => Err(Failure::Reported(130)),
    }
}

struct Slice {
    particle_steps: u64,
    outcome: Result<(), StepError>,
}

fn step_for_a_slice(engine: &mut Engine, stop_s: f64) -> Slice {
    let begin = Instant::now();
    let mut particle_steps = 0;
    while engine.clock().time_s() < stop_s && begin.elapsed() < SLICE {
        if let Err(failure) = engine.step() {
            return Slice { particle_steps, outcome: Err(failure) };
        }
        particle_steps += engine.len() as u64;
    }
    Slice { particle_steps, outcome: Ok(()) }
}

/// True from the first Ctrl-C or SIGTERM on.
pub(super) fn watch_signals() -> Result<Arc<AtomicBool>, Failure> {
    use tokio::signal::unix::{SignalKind, signal};
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(anyhow::Error::from)?;
    std::thread::spawn(move || {
        runtime.block_on(async {
            if let (Ok(mut interrupt), Ok(mut terminate)) =
                (signal(SignalKind::interrupt()), signal(SignalKind::terminate()))
            {
                tokio::select! { _ = interrupt.recv() => {}, _ = terminate.recv() => {} }
                raised.store(true, Relaxed);
            }
        });
    });
    Ok(flag)
}

fn progress_bar(name: &str, engine: &Engine, stop_s: f64, hidden: bool) -> ProgressBar {
    let steps = (stop_s / engine.clock().time_step_s()).ceil() as u64;
    let bar = ProgressBar::with_draw_target(
        Some(steps),
        if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() },
    );
    let style = ProgressStyle::with_template("{prefix} {wide_bar} {percent}% {msg}, {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_prefix(name.to_string());
    bar
}

/// Stages, inflows that end or find no room.
pub(super) fn tell_happenings(bar: &ProgressBar, engine: &mut Engine) {
    for happening in engine.take_happenings() {
        let event = course::event(engine.scene().description(), &happening);
        if event.inserted.is_none() {
            bar.println(format!("t = {:.6} s: {}", engine.clock().time_s(), event.message));
        }
    }
}

fn show_progress(bar: &ProgressBar, engine: &Engine, started: Instant) {
    let clock = engine.clock();
    let wall_s = started.elapsed().as_secs_f64().max(1e-9);
    bar.set_message(format!("t = {:.4} s, {:.3e} steps/s", clock.time_s(), clock.step() as f64 / wall_s));
    bar.set_position(clock.step());
}

fn shares(totals: &StageTotals) -> Vec<(&'static str, f64)> {
    let spent = totals.read();
    let sum = spent.iter().sum::<u64>().max(1) as f64;
    Stage::ALL.iter().zip(spent).map(|(stage, ns)| (stage.name(), ns as f64 / sum)).collect()
}
