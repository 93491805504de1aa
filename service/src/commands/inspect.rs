//! `sturz inspect`: what a running daemon says of itself.

use std::path::Path;
use std::time::Duration;

use anyhow::anyhow;
use prost::Message as _;
use serde_json::{Value, json};
use sturz_protocol::keys::{ALL_ALIVE, Keys};
use sturz_protocol::v1;
use zenoh::Session;

use crate::cli;
use crate::commands::{Failure, print_json, runtime};
use crate::config::Bus;
use crate::security::folder::Identity;

/// How long to wait for an answer.
const PATIENCE: Duration = Duration::from_secs(3);

/// Shows info and report of a daemon.
pub fn inspect(options: &cli::Inspect) -> Result<(), Failure> {
    runtime()?.block_on(async {
        let at = Place { endpoint: &options.endpoint, config: options.config.as_deref(), tls: options.tls.as_deref() };
        let (session, keys) = connect(options.name.as_deref(), at).await?;
        let info = v1::Info::decode(ask(&session, keys.info()).await?.as_slice());
        let report = v1::Report::decode(ask(&session, keys.report_latest()).await?.as_slice());
        let (info, report) = (info.map_err(anyhow::Error::from)?, report.map_err(anyhow::Error::from)?);
        if options.json {
            print_json(&as_json(&info, &report))?;
        } else {
            print_text(&info, &report);
        }
        session.close().await.map_err(|error| anyhow!(error))?;
        Ok(())
    })
}

/// Where a daemon is, and how to get in.
#[derive(Clone, Copy)]
pub(crate) struct Place<'o> {
    /// Of the daemon.
    pub endpoint: &'o str,
    /// A zenoh configuration file.
    pub config: Option<&'o Path>,
    /// Folder of a client's certificate.
    pub tls: Option<&'o Path>,
}

/// A session, and the keys of the instance asked for or of the only one alive.
pub(crate) async fn connect(name: Option<&str>, at: Place<'_>) -> Result<(Session, Keys), Failure> {
    let client_tls = at.tls.map(Identity::of_client).transpose();
    let client_tls = client_tls.map_err(|error| Failure::Usage(format!("--tls: {error}")))?;
    let bus = Bus { connect: vec![at.endpoint.into()], file: at.config.map(Into::into), client_tls, ..Bus::default() };
    let session = zenoh::open(bus.client_config()?)
        .await
        .map_err(|error| Failure::NoDaemon(unreached(at, &error.to_string())))?;
    let instance = choose(&session, name, at).await?;
    let keys = Keys::new(&instance).map_err(|error| Failure::Usage(error.to_string()))?;
    Ok((session, keys))
}

fn unreached(at: Place<'_>, reason: &str) -> String {
    let endpoint = at.endpoint;
    match (endpoint.starts_with("tls/"), at.tls) {
        (false, _) => format!("no daemon listens at {endpoint}: {reason}"),
        (true, None) => format!("{endpoint} wants a certificate (--tls), or no daemon listens there: {reason}"),
        (true, Some(_)) => format!("{endpoint} does not accept the certificate, or no daemon listens there: {reason}"),
    }
}

/// The instance asked for, or the only one alive.
async fn choose(session: &Session, name: Option<&str>, at: Place<'_>) -> Result<String, Failure> {
    let endpoint = at.endpoint;
    let replies = session.liveliness().get(ALL_ALIVE).timeout(PATIENCE).await.map_err(|error| anyhow!(error))?;
    let mut alive = Vec::new();
    while let Ok(reply) = replies.recv_async().await {
        if let Ok(sample) = reply.result() {
            alive.extend(sample.key_expr().as_str().split('/').nth(2).map(String::from));
        }
    }
    let list = if alive.is_empty() { "none".into() } else { alive.join(", ") };
    match (name, &alive[..]) {
        (Some(name), _) if alive.iter().any(|one| one == name) => Ok(name.into()),
        (Some(name), _) => {
            Err(Failure::NoDaemon(format!("no instance {name:?} is alive at {endpoint}: there are {list}")))
        }
        (None, [only]) => Ok(only.clone()),
        (None, []) if at.tls.is_some() => {
            let text = format!("{endpoint} shows this client nothing: its certificate has no role there");
            Err(Failure::NoDaemon(text))
        }
        (None, []) => Err(Failure::NoDaemon(format!("no instance is alive at {endpoint}"))),
        (None, _) => Err(Failure::Usage(format!("which one? There are {list}"))),
    }
}

/// Answer to a query.
pub(crate) async fn ask(session: &Session, key: String) -> Result<Vec<u8>, Failure> {
    let replies = session.get(&key).timeout(PATIENCE).await.map_err(|error| anyhow!(error))?;
    match replies.recv_async().await.map(|reply| reply.into_result()) {
        Ok(Ok(sample)) => Ok(sample.payload().to_bytes().to_vec()),
        Ok(Err(error)) => {
            let wire = v1::Error::decode(error.payload().to_bytes().as_ref()).unwrap_or_default();
            Err(Failure::NoDaemon(format!("{key}: {}", wire.message)))
        }
        Err(_) => Err(Failure::NoDaemon(format!("{key}: no answer within {} s", PATIENCE.as_secs()))),
    }
}

/// `RUNNING` rather than `RUN_STATE_RUNNING`, in lower case.
pub(super) fn state_name(state: v1::RunState) -> String {
    state.as_str_name().trim_start_matches("RUN_STATE_").to_lowercase()
}

fn as_json(info: &v1::Info, report: &v1::Report) -> Value {
    let energy = report.energy.unwrap_or_default();
    json!({
        "instance": info.instance,
        "run_id": info.run_id,
        "version": info.version,
        "schema_version": info.schema_version,
        "scene": info.scene,
        "pid": info.pid,
        "threads": info.threads,
        "state": state_name(info.state()),
        "failure": info.failure,
        "step": info.step,
        "time_s": info.sim_time_s,
        "time_step_s": info.time_step_s,
        "particles": info.particles,
        "topology_epoch": info.topology_epoch,
        "state_hash": format!("{:016x}", info.state_hash),
        "fields": info.fields.iter().map(|field| field.name.clone()).collect::<Vec<_>>(),
        "report": {
            "sim_s_per_wall_s": report.sim_s_per_wall_s,
            "steps_per_wall_s": report.steps_per_wall_s,
            "touching_pairs": report.touching_pairs,
            "touching_boundary_pairs": report.touching_boundary_pairs,
            "largest_overlap_m": report.largest_overlap_m,
            "largest_overlap_ratio_so_far": report.largest_overlap_ratio_so_far,
            "critical_time_step_s": report.critical_time_step_s,
            "energy_residual_j": energy.residual_j,
            "kinetic_j": energy.kinetic_translation_j + energy.kinetic_rotation_j,
            "stages_s_per_step": report.stages.iter().map(|s| (s.name.clone(), s.s_per_step)).collect::<Vec<_>>(),
            "streams": report.streams.iter().map(|s| json!({
                "name": s.name, "offered": s.offered, "published": s.published, "dropped": s.dropped
            })).collect::<Vec<_>>(),
        },
    })
}

fn print_text(info: &v1::Info, report: &v1::Report) {
    let energy = report.energy.unwrap_or_default();
    println!("{} ({}), sturz {}, pid {}, {} threads", info.instance, info.scene, info.version, info.pid, info.threads);
    println!("  state       {} {}", state_name(info.state()), info.failure);
    println!("  time        {:.6} s, step {}, time step {:.3e} s", info.sim_time_s, info.step, info.time_step_s);
    println!("  particles   {}, {} touching pairs", info.particles, report.touching_pairs);
    println!(
        "  speed       {:.3e} simulated s per wall s, {:.3e} steps/s",
        report.sim_s_per_wall_s, report.steps_per_wall_s
    );
    let stages: Vec<String> =
        report.stages.iter().map(|stage| format!("{} {:.1}", stage.name, stage.s_per_step * 1e6)).collect();
    println!("  stages      {} us per step", stages.join(", "));
    println!(
        "  energy      kinetic {:.4e} J, residual {:.2e} J",
        energy.kinetic_translation_j + energy.kinetic_rotation_j,
        energy.residual_j
    );
    println!(
        "  overlap     {:.3e} m now, {:.2e} of the bounding radius at most so far",
        report.largest_overlap_m, report.largest_overlap_ratio_so_far
    );
    println!("  time step   {:.3} of the critical one", report.time_step_s / report.critical_time_step_s);
    for stream in &report.streams {
        println!(
            "  stream      {:16} {} offered, {} published, {} dropped",
            stream.name, stream.offered, stream.published, stream.dropped
        );
    }
    println!("  state hash  {:016x}", info.state_hash);
}
