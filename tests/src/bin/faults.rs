//! `faults`: what the service survives, against the real daemon.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::{Context as _, ensure};
use clap::Parser;
use sturz_tests::cases::{self, Row};
use sturz_tests::faults::{self, Size, registry};

/// Kills, damages and floods a daemon, and compares what it does with an undisturbed one. Exit code 1 when a comparison
/// fails. The daemon is the `sturz` beside this program, or STURZ_BINARY.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Checks by id; all when there is none
    ids: Vec<String>,
    /// List the checks and run none
    #[arg(long)]
    list: bool,
    /// A small part of each
    #[arg(long)]
    short: bool,
    /// How long listeners come and go, s
    #[arg(long, default_value_t = 3600.0, value_name = "SECONDS")]
    soak: f64,
    /// Write the comparisons here, as an array
    #[arg(long)]
    json: Option<PathBuf>,
    /// Listen to a daemon until standard input ends: what the checks start many times
    #[arg(long, num_args = 2, value_names = ["ENDPOINT", "NAME"], hide = true)]
    listen: Option<Vec<String>>,
}

fn main() -> anyhow::Result<ExitCode> {
    let arguments = Arguments::parse();
    if let Some([endpoint, instance]) = arguments.listen.as_deref() {
        faults::listen(endpoint, instance)?;
        return Ok(ExitCode::SUCCESS);
    }
    let all = registry();
    for id in &arguments.ids {
        ensure!(all.iter().any(|fault| fault.id == id), "no check '{id}'; --list shows them");
    }
    let soak = Duration::try_from_secs_f64(arguments.soak).context("--soak is no time")?;
    let mut rows = Vec::new();
    let wanted = |id: &str| arguments.ids.is_empty() || arguments.ids.iter().any(|wanted| wanted == id);
    for fault in all.iter().filter(|fault| wanted(fault.id)) {
        println!("{} {}", fault.id, fault.title);
        if arguments.list {
            continue;
        }
        let own = fault.rows(if arguments.short { Size::Short } else { Size::Full { soak } });
        own.iter().for_each(Row::print);
        rows.extend(own);
    }
    if arguments.list {
        return Ok(ExitCode::SUCCESS);
    }
    let failed = cases::conclude(&rows, arguments.json.as_deref())?;
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
