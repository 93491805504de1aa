//! `sturz export`

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use anyhow::anyhow;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::record::finite;
use super::run::watch_signals;
use crate::cli::{self, ExportPart};
use crate::commands::{Failure, Place, connect, print_json, runtime};
use crate::daemon::asked_to_end;
use crate::export::{
    Choice, ExportError, Exporter, Options, Precision, SceneRun, Written, export_daemon, export_recording, export_scene,
};
use crate::scenes;

/// Writes VTK files.
pub fn export(options: &cli::Export) -> Result<(), Failure> {
    let runs_scene = options.time.is_some() || options.checkpoint.is_some();
    let choice = choice(options)?;
    let has = |part| options.what.is_empty() || options.what.contains(&part);
    let wanted = Options {
        out: options.out.clone(),
        particles: has(ExportPart::Particles),
        contacts: has(ExportPart::Contacts),
        fields: has(ExportPart::Fields),
        boundaries: has(ExportPart::Boundaries),
        glyphs: options.glyphs,
        // A run chooses its times itself.
        choice: if runs_scene { Choice::All } else { choice },
        encoding: options.encoding,
        precision: if options.f64 { Precision::Double } else { Precision::Single },
    };
    let (written, ending) = if runs_scene {
        run_scene(options, wanted)?
    } else if is_recording(&options.source)? {
        let mut exporter = Exporter::new(wanted).map_err(anyhow::Error::from)?;
        export_recording(Path::new(&options.source), &mut exporter)?;
        (exporter.finish(), Ok(()))
    } else {
        (from_daemon(options, wanted)?, Ok(()))
    };
    tell(&written, options.json)?;
    ending
}

fn choice(options: &cli::Export) -> Result<Choice, Failure> {
    if let Some(every_s) = options.every {
        return if every_s.is_finite() && every_s > 0.0 {
            Ok(Choice::Every(every_s))
        } else {
            Err(Failure::Usage(format!("--every is {every_s}, must be positive and finite")))
        };
    }
    if let Some(stride) = options.stride {
        return Ok(Choice::Stride(stride));
    }
    if options.times.is_empty() {
        return Ok(Choice::All);
    }
    let mut times = options.times.clone();
    times.iter().try_for_each(|&time_s| finite(time_s, "--times").map(drop))?;
    times.sort_by(f64::total_cmp);
    Ok(Choice::Times(times))
}

/// Whether the source is a file that begins as MCAP files do.
fn is_recording(source: &str) -> Result<bool, Failure> {
    let path = Path::new(source);
    let named_so = path.extension().is_some_and(|extension| extension == "mcap");
    let mut magic = [0; mcap::MAGIC.len()];
    match File::open(path).and_then(|mut file| file.read_exact(&mut magic)) {
        Ok(()) if magic == mcap::MAGIC => Ok(true),
        _ if named_so => Ok(true),
        Ok(()) => Err(Failure::Usage(format!("{source} is no recording. Of a scene, say how long to run it: --time"))),
        Err(_) => Ok(false),
    }
}

fn from_daemon(options: &cli::Export, wanted: Options) -> Result<Written, Failure> {
    let exporter = runtime()?.block_on(async {
        let at = Place { endpoint: &options.endpoint, config: options.config.as_deref(), tls: options.tls.as_deref() };
        let (session, keys) = connect(Some(&options.source), at).await.map_err(hint)?;
        let exporter = Exporter::new(wanted).map_err(anyhow::Error::from)?;
        let end = asked_to_end(false)?;
        let exporter = export_daemon(&session, &keys, exporter, options.follow, end).await;
        let exporter = exporter.map_err(Failure::from_any)?;
        session.close().await.map_err(|error| anyhow!(error))?;
        Ok::<_, Failure>(exporter)
    })?;
    Ok(exporter.finish())
}

/// A bundled scene without --time looks like the name of a daemon.
fn hint(failure: Failure) -> Failure {
    match failure {
        Failure::NoDaemon(text) => {
            Failure::NoDaemon(format!("{text}. A recording is a file .mcap; to run a scene, say how long: --time"))
        }
        other => other,
    }
}

fn run_scene(options: &cli::Export, wanted: Options) -> Result<(Written, Result<(), Failure>), Failure> {
    if !options.times.is_empty() || options.stride.is_some() || options.follow {
        return Err(Failure::Usage(
            "--times, --stride and --follow are not for a scene that is run here: --every".into(),
        ));
    }
    if let Some(time_s) = options.time.filter(|&time_s| !(time_s.is_finite() && time_s >= 0.0)) {
        return Err(Failure::Usage(format!("--time is {time_s}, must be finite and not negative")));
    }
    let scene = scenes::load(&options.source)?;
    let name = scene.description().scene.name.clone();
    let mut exporter = Exporter::new(wanted).map_err(anyhow::Error::from)?;
    let run = SceneRun {
        scene,
        checkpoint: options.checkpoint.as_deref(),
        stop_s: options.time,
        every_s: options.every,
        threads: options.threads.into(),
    };
    let bar = progress_bar(&name, options);
    let stop_s = options.time.unwrap_or_default();
    let interrupted = watch_signals()?;
    let ended = export_scene(run, &mut exporter, &interrupted, |engine| {
        let time_s = engine.clock().time_s();
        bar.set_position((1000.0 * time_s / stop_s) as u64);
        bar.set_message(format!("t = {time_s:.4} s"));
    })?;
    bar.finish_and_clear();
    let ending = match ended {
        Some(failure) => {
            eprintln!("sturz: the run failed, the last files show the state that was refused: {failure}");
            Err(Failure::Reported(4))
        }
        None if interrupted.load(std::sync::atomic::Ordering::Relaxed) => Err(Failure::Reported(130)),
        None => Ok(()),
    };
    Ok((exporter.finish(), ending))
}

fn progress_bar(name: &str, options: &cli::Export) -> ProgressBar {
    let hidden = options.json || options.time.is_none();
    let target = if hidden { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(1000), target);
    let style = ProgressStyle::with_template("{prefix} {wide_bar} {percent}% {msg}, {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.with_prefix(name.to_string())
}

fn tell(written: &Written, json: bool) -> Result<(), Failure> {
    if !written.times_missed.is_empty() {
        tracing::warn!("the source ends before the times {:?} s", written.times_missed);
    }
    if json {
        return print_json(written);
    }
    if written.files.is_empty() {
        let nothing = "there was nothing to write: the source has none of what was asked for";
        return Err(anyhow::Error::from(ExportError::Message(nothing.into())).into());
    }
    for (name, files) in &written.files {
        println!("{}: {files} files", written.out.join(format!("{name}.pvd")).display());
    }
    Ok(())
}
