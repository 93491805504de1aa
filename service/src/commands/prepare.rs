//! `sturz prepare`: runs a scene through its stages and writes a checkpoint that later scenes start from.

use std::path::Path;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

use anyhow::Context as _;
use indicatif::ProgressBar;
use serde::Serialize;
use sturz_engine::scene::SceneDescription;
use sturz_engine::{Engine, StepError};

use crate::archive::write_whole;
use crate::cli;
use crate::commands::run::{tell_happenings, watch_signals};
use crate::commands::{Failure, print_json};
use crate::scenes;

/// How long the engine steps before somebody looks at signals and the screen.
const SLICE: Duration = Duration::from_millis(100);

/// What ended the preparation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum End {
    /// The last stage is over.
    Stages,
    /// The time given.
    Time,
}

/// What was written.
#[derive(Debug, Serialize)]
struct Prepared {
    scene: String,
    file: String,
    bytes: u64,
    ended_by: End,
    step: u64,
    time_s: f64,
    particles: u64,
    kinetic_j: f64,
    elastic_j: f64,
    largest_overlap_ratio: f64,
    state_hash: String,
    wall_s: f64,
}

/// Runs the scene to the end of its stages, or to a time, and writes the checkpoint.
pub fn prepare(options: &cli::Prepare) -> Result<(), Failure> {
    let scene = scenes::load_from(&options.scene.scene, options.from.as_deref())?;
    let stop_s = stop_time(options, scene.description())?;
    let (folder, name) = place(&options.out)?;
    let mut engine = Engine::new(scene);
    engine.set_threads(options.threads.into());
    let interrupted = watch_signals()?;
    let bar = if options.json { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
    let started = Instant::now();
    let ended_by = loop {
        let outcome = engine.in_pool(|engine| slice(engine, stop_s));
        show(&bar, &mut engine);
        if let Err(failure) = outcome {
            bar.finish_and_clear();
            eprintln!("sturz: {failure}; nothing is written");
            return Err(Failure::Reported(4));
        }
        if let Some(end) = end(&engine, stop_s) {
            break end;
        }
        if interrupted.load(Relaxed) {
            bar.finish_and_clear();
            eprintln!("sturz: interrupted at {} s; nothing is written", engine.clock().time_s());
            return Err(Failure::Reported(130));
        }
    };
    bar.finish_and_clear();
    let bytes = engine.prepared().map_err(anyhow::Error::from)?;
    let length = bytes.len() as u64;
    let written = write_whole(folder, name, &[bytes.into()]);
    written.with_context(|| format!("cannot write {}", options.out.display()))?;
    let report = engine.report();
    let prepared = Prepared {
        scene: engine.scene().description().scene.name.clone(),
        file: options.out.display().to_string(),
        bytes: length,
        ended_by,
        step: report.step,
        time_s: report.time_s,
        particles: report.particles,
        kinetic_j: report.energy.kinetic_translation_j + report.energy.kinetic_rotation_j,
        elastic_j: report.energy.elastic_j,
        largest_overlap_ratio: report.largest_overlap_ratio,
        state_hash: format!("{:016x}", engine.state_hash()),
        wall_s: started.elapsed().as_secs_f64(),
    };
    if options.json { print_json(&prepared) } else { print(&prepared) }
}

fn print(prepared: &Prepared) -> Result<(), Failure> {
    let Prepared { scene, file, bytes, ended_by, step, time_s, particles, wall_s, .. } = prepared;
    let by = if *ended_by == End::Stages { "at the end of its stages" } else { "at the time given" };
    println!("{scene}: {particles} particles {by}, step {step}, {time_s:.6} s; {wall_s:.1} s of wall time");
    println!("kinetic energy           {:.3e} J", prepared.kinetic_j);
    println!("elastic energy           {:.3e} J", prepared.elastic_j);
    println!("largest overlap          {:.2e} of the bounding radius", prepared.largest_overlap_ratio);
    println!("written                  {file}, {bytes} bytes; start with it by --from {file}");
    Ok(())
}

/// Where a run without a given time ends by itself, and the time where there is one.
fn stop_time(options: &cli::Prepare, scene: &SceneDescription) -> Result<f64, Failure> {
    let given = options.until.or(scene.stop.time_s);
    if let Some(until) = given.filter(|until| !(until.is_finite() && *until > 0.0)) {
        return Err(Failure::Usage(format!("--until is {until}, must be positive and finite")));
    }
    let ends = scene.stages.last().is_some_and(|stage| stage.has_end());
    match given {
        Some(until) => Ok(until),
        None if ends => Ok(f64::INFINITY),
        None => Err(Failure::Usage(
            "when shall it end? Give --until SECONDS, `[stop] time_s` in the scene, or a last [[stage]] that has an end".into(),
        )),
    }
}

fn place(out: &Path) -> Result<(&Path, &str), Failure> {
    let name = out.file_name().and_then(|name| name.to_str());
    let name = name.ok_or_else(|| Failure::Usage(format!("--out {}: is no name of a file", out.display())))?;
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(Failure::Usage(format!("--out: there is no folder {}", folder.display())));
    }
    Ok((folder, name))
}

fn end(engine: &Engine, stop_s: f64) -> Option<End> {
    let has_stages = !engine.scene().description().stages.is_empty();
    if has_stages && !engine.has_stages_ahead() {
        Some(End::Stages)
    } else {
        (engine.clock().time_s() >= stop_s).then_some(End::Time)
    }
}

fn slice(engine: &mut Engine, stop_s: f64) -> Result<(), StepError> {
    let begin = Instant::now();
    while end(engine, stop_s).is_none() && begin.elapsed() < SLICE {
        engine.step()?;
    }
    Ok(())
}

fn show(bar: &ProgressBar, engine: &mut Engine) {
    tell_happenings(bar, engine);
    let clock = engine.clock();
    bar.set_message(format!("t = {:.4} s, step {}, {} particles", clock.time_s(), clock.step(), engine.len()));
    bar.tick();
}
