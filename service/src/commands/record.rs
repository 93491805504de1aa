//! `sturz record`

use std::time::Duration;

use anyhow::anyhow;
use serde_json::json;
use sturz_protocol::keys::Keys;

use crate::cli::{self, RecordTopic};
use crate::commands::{Failure, Place, connect, print_json, runtime};
use crate::daemon::asked_to_end;
use crate::record::{self, Options, Streams, Summary};

/// Records a daemon until Ctrl-C, SIGTERM, its end, or the time asked for.
pub fn record(options: &cli::Record) -> Result<(), Failure> {
    let has = |topic| options.topics.contains(&topic);
    let recording = Options {
        out: options.out.clone(),
        streams: Streams {
            state: has(RecordTopic::State),
            fields: has(RecordTopic::Fields),
            report: has(RecordTopic::Report),
            events: has(RecordTopic::Events),
            contacts: has(RecordTopic::Contacts),
        },
        compressed: !options.uncompressed,
        queue_bytes: u64::from(options.queue_mb) * 1_000_000,
        duration: options.duration_s.map(duration).transpose()?,
        until_sim_s: options.until_sim.map(|time_s| finite(time_s, "--until-sim")).transpose()?,
    };
    let summary = runtime()?.block_on(async {
        let at = Place { endpoint: &options.endpoint, config: options.config.as_deref(), tls: options.tls.as_deref() };
        let (session, keys) = connect(options.name.as_deref(), at).await?;
        let end = asked_to_end(false)?;
        let summary = record::record(&session, &keys, &recording, end, || announce(options, &keys)).await;
        let summary = summary.map_err(Failure::from_any)?;
        session.close().await.map_err(|error| anyhow!(error))?;
        Ok::<_, Failure>(summary)
    })?;
    if options.json {
        return print_json(&summary);
    }
    print_text(&summary);
    Ok(())
}

fn duration(seconds: f64) -> Result<Duration, Failure> {
    let positive = Duration::try_from_secs_f64(seconds).ok().filter(|duration| !duration.is_zero());
    positive.ok_or_else(|| Failure::Usage(format!("--for is {seconds}, must be positive and finite")))
}

/// A time of the command line.
pub(super) fn finite(time_s: f64, option: &str) -> Result<f64, Failure> {
    if time_s.is_finite() { Ok(time_s) } else { Err(Failure::Usage(format!("{option} is {time_s}, must be finite"))) }
}

fn announce(options: &cli::Record, keys: &Keys) {
    if options.json {
        println!("ready {}", json!({ "instance": keys.instance(), "file": options.out, "pid": std::process::id() }));
    } else {
        eprintln!("recording {} to {}; Ctrl-C ends it", keys.instance(), options.out.display());
    }
}

fn print_text(summary: &Summary) {
    let messages: u64 = summary.streams.values().map(|stream| stream.messages).sum();
    let raw: u64 = summary.streams.values().map(|stream| stream.bytes).sum();
    println!("{}: {messages} messages, {}", summary.file.display(), ending(summary));
    println!("  {:.1} MB on disk, {:.1} MB of messages", summary.bytes as f64 / 1e6, raw as f64 / 1e6);
    if let Some([first, last]) = summary.sim_time_s {
        println!("  simulated time {first:.6} to {last:.6} s");
    }
    for (tail, stream) in &summary.streams {
        println!("  {tail:20} {} messages, {:.1} MB, {} lost", stream.messages, stream.bytes as f64 / 1e6, stream.lost);
    }
    if summary.dropped_at_disk > 0 {
        println!("  {} of the lost ones came while the disk was too slow", summary.dropped_at_disk);
    }
}

fn ending(summary: &Summary) -> &'static str {
    match summary.ended_by {
        "duration" => "ended after the time of --for",
        "sim_time" => "ended at the simulated time asked for",
        "daemon_ended" => "ended with the daemon",
        _ => "ended when asked to",
    }
}
