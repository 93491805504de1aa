//! `validate`: runs the cases of PHYSICS.md that the engine can do, and compares with their references.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::bail;
use clap::Parser;
use sturz_tests::cases::{self, Case, Row, registry};

/// Compares the engine with closed forms, papers and other programs. Exit code 1 when a comparison fails.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Cases by id, as in PHYSICS.md; all fast ones when there is none
    ids: Vec<String>,
    /// List the cases and run none
    #[arg(long)]
    list: bool,
    /// Write the comparisons here, as an array
    #[arg(long)]
    json: Option<PathBuf>,
    /// Folder of reference data that is not part of the repository; `../shared/oracles` beside it when absent
    #[arg(long)]
    data: Option<PathBuf>,
    /// Print failures only
    #[arg(long)]
    quiet: bool,
}

fn main() -> anyhow::Result<ExitCode> {
    let arguments = Arguments::parse();
    // The list shows the slow ones as well, which only run when they are named.
    let cases = if arguments.list && arguments.ids.is_empty() { registry() } else { chosen(&arguments.ids)? };
    if arguments.list {
        cases
            .iter()
            .for_each(|case| println!("{:6} {}{}", case.id, case.title, if case.fast { "" } else { " (slow)" }));
        return Ok(ExitCode::SUCCESS);
    }
    let data = arguments.data.unwrap_or_else(Case::default_data);
    let mut rows = Vec::new();
    for case in cases {
        println!("{} {}", case.id, case.title);
        let own = case.rows_with(&data);
        own.iter().filter(|row| !arguments.quiet || !row.pass).for_each(Row::print);
        rows.extend(own);
    }
    let failed = cases::conclude(&rows, arguments.json.as_deref())?;
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The cases of these ids, in their order; all fast ones without ids.
fn chosen(ids: &[String]) -> anyhow::Result<Vec<Case>> {
    let mut all = registry();
    if ids.is_empty() {
        all.retain(|case| case.fast);
        return Ok(all);
    }
    if let Some(unknown) = ids.iter().find(|id| all.iter().all(|case| case.id != **id)) {
        bail!("no case '{unknown}'; --list shows them");
    }
    all.retain(|case| ids.iter().any(|id| id == case.id));
    Ok(all)
}
