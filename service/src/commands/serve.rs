//! `sturz serve`

use std::net::SocketAddr;
use std::path::Path;
use std::time::Duration;

use anyhow::anyhow;

use crate::cli::{self, Effective};
use crate::commands::{Failure, runtime};
use crate::config::{Bus, DEFAULT_LISTEN, DEFAULT_LISTEN_TLS, Limits, ServerTls};
use crate::daemon::{self, KeptRun, Options, Ready, Restore, ServeError};
use crate::journal::Folder;
use crate::scenes;
use crate::security::{exposure, folder};

/// Between snapshots unless told otherwise: what a resumed run does again at most, apart from the log's commands.
const SNAPSHOT_EVERY: Duration = Duration::from_secs(60);

/// Serves a scene until it is told to end.
pub fn serve(mut options: cli::Serve) -> Result<(), Failure> {
    check_folders(&options)?;
    let mut effective = std::mem::take(&mut options.effective);
    let (limits, listen) = settle(&options, &mut effective)?;
    if options.show_settings {
        print!("{}", effective.to_toml());
        return Ok(());
    }
    let resumed = options.resume.as_deref().map(Folder::open).transpose()?;
    let (scene, given_name) = match (&resumed, &options.scene) {
        (Some((folder, about)), _) => (folder.scene()?, about.instance.clone()),
        (None, Some(scene)) => (scenes::load_from(scene, options.from.as_deref())?, scenes::instance_name(scene)),
        (None, None) => return Err(Failure::Usage("which scene?".into())),
    };
    let instance = options.name.unwrap_or(given_name);
    sturz_protocol::keys::check_name(&instance).map_err(|error| Failure::Usage(format!("--name: {error}")))?;
    effective.choose("name", instance.clone());
    effective.log();
    let tls = options.tls.as_deref().map(|folder| ServerTls::open(folder, &instance)).transpose();
    let tls = tls.map_err(|error| Failure::Usage(format!("--tls: {error}")))?;
    let most_clients = Some(limits.clients);
    let bus = Bus { listen, connect: options.connect, file: options.config, tls, most_clients, client_tls: None };
    check_exposure(&bus, options.metrics, options.insecure).map_err(|error| Failure::Bus(error.to_string()))?;
    let clients_tls = options.tls.as_ref().map(|folder| folder.join(folder::CLIENTS).join("NAME"));
    let checkpoint_every = options.checkpoint_every.map(interval).transpose()?;
    let restore = options.restore.map(start).transpose()?;
    let (fsync, keep) = (options.journal_fsync, options.journal_keep);
    let resumes = resumed.is_some();
    let folder = match (resumed, &options.journal) {
        (Some((folder, _)), _) => Some(folder),
        (None, Some(path)) => Some(Folder::create(path, &instance, &scene)?),
        (None, None) => None,
    };
    let journal = folder.map(|folder| KeptRun { folder: folder.kept_as(fsync, keep), resumes });
    let checkpoint_every = checkpoint_every.or(journal.as_ref().map(|_| SNAPSHOT_EVERY));
    let (json, paused) = (options.json, options.paused);
    let options = Options {
        instance,
        bus,
        limits,
        threads: options.threads.into(),
        paused,
        checkpoints: options.checkpoints,
        checkpoint_every,
        restore,
        journal,
        stop_on_stdin_eof: options.stop_on_stdin_eof,
        metrics: options.metrics,
    };
    let ready = |ready: &Ready| announce(ready, paused, json, clients_tls.as_deref());
    runtime()?.block_on(daemon::serve(scene, options, ready)).map_err(|error| match error {
        ServeError::Other(error) => Failure::Other(error),
        refused => Failure::Bus(refused.to_string()),
    })
}

fn check_folders(options: &cli::Serve) -> Result<(), Failure> {
    let has_folder = [&options.checkpoints, &options.journal, &options.resume].iter().any(|folder| folder.is_some());
    if options.checkpoint_every.is_some() && !has_folder {
        return Err(Failure::Usage("--checkpoint-every needs a folder: --journal or --checkpoints".into()));
    }
    if options.restore.is_some() && options.checkpoints.is_none() {
        return Err(Failure::Usage("--restore needs the folder of the checkpoint: --checkpoints".into()));
    }
    Ok(())
}

/// Limits and endpoints, with what is chosen where nothing was given.
fn settle(options: &cli::Serve, effective: &mut Effective) -> Result<(Limits, Vec<String>), Failure> {
    let asked = Limits::read(options.limits.as_deref());
    let asked = asked.map_err(|error| Failure::Usage(format!("--limits: {error:#}")))?;
    let mut table = effective.file_limits.clone();
    table.extend(asked.clone());
    let limits = Limits::from_table(table).map_err(|error| Failure::Usage(format!("limits: {error:#}")))?;
    effective.note_limits(&limits, (&asked, options.limits.as_deref()));
    // A configuration file says where to listen, unless the command line does.
    let listen = match (&options.tls, options.listen.is_empty() && options.config.is_none()) {
        (None, true) => vec![DEFAULT_LISTEN.into()],
        (Some(_), true) => vec![DEFAULT_LISTEN_TLS.into()],
        (_, false) => options.listen.clone(),
    };
    if !listen.is_empty() {
        effective.choose("listen", listen.clone());
    }
    if let (Some(scene), None) = (&options.scene, &options.name) {
        effective.choose("name", scenes::instance_name(scene));
    }
    if options.journal.is_some() || options.resume.is_some() {
        effective.choose("checkpoint_every", SNAPSHOT_EVERY.as_secs_f64());
    }
    Ok((limits, listen))
}

/// Refuses endpoints, that of the metrics included, which other machines can reach unasked. The metrics have no certificates.
fn check_exposure(bus: &Bus, metrics: Option<SocketAddr>, insecure: bool) -> anyhow::Result<()> {
    let Some(exposed) = metrics.filter(|address| !address.ip().is_loopback()) else {
        return bus.check_exposure(insecure);
    };
    if !insecure {
        return Err(anyhow!(
            "--metrics: whoever reaches {exposed} can read the report, without a certificate: listen on 127.0.0.1:PORT, or allow it with --insecure"
        ));
    }
    exposure::warn(&format!("--insecure: whoever reaches {exposed} can read the report"));
    // Else it would be told that it is not needed.
    bus.check_exposure(false).or_else(|_| bus.check_exposure(true))
}

fn interval(seconds: f64) -> Result<Duration, Failure> {
    let positive = Duration::try_from_secs_f64(seconds).ok().filter(|every| !every.is_zero());
    positive.ok_or_else(|| Failure::Usage(format!("--checkpoint-every is {seconds}, must be positive and finite")))
}

fn start(token: String) -> Result<Restore, Failure> {
    if token == "newest" {
        return Ok(Restore::Newest);
    }
    sturz_protocol::keys::check_name(&token).map_err(|error| Failure::Usage(format!("--restore: {error}")))?;
    Ok(Restore::Token(token))
}

fn announce(ready: &Ready, paused: bool, json: bool, tls: Option<&Path>) {
    if json {
        let text = serde_json::to_string(ready).unwrap_or_default();
        println!("ready {text}");
        return;
    }
    let state = if paused { "paused: it waits for commands" } else { "running" };
    println!("{} is served at {}, {state}", ready.instance, ready.endpoint);
    let tls = tls.map_or_else(String::new, |folder| format!(", tls=\"{}\"", folder.display()));
    if let Some(metrics) = &ready.metrics {
        println!("metrics for Prometheus at {metrics}");
    }
    println!("in Python:  sturz.connect(\"{}\", endpoint=\"{}\"{tls})", ready.instance, ready.endpoint);
    println!("Ctrl-C ends it");
}
