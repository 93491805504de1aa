//! `validate`: runs the cases of PHYSICS.md that the engine can do, and compares with their references.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context as _, bail};
use clap::Parser;
use sturz_tests::cases::{self, Case, Row, Tier, registry};
use sturz_tests::report::{self, SCRIPTS, STUDIES, Store};

/// Compares the engine with closed forms, papers and other programs. Exit code 1 when a comparison fails.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Cases by id, as in PHYSICS.md; all of the tier when there is none
    ids: Vec<String>,
    /// How much to run
    #[arg(long, value_enum, default_value_t = Tier::Fast)]
    tier: Tier,
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
    /// Write one self-contained page here: cases, studies, and, from the nightly tier on, the papers' experiments
    #[arg(long, value_name = "FILE", conflicts_with = "ids")]
    report: Option<PathBuf>,
    /// Folder of what the report is made of; what is in it is not run again
    #[arg(long, value_name = "DIR", default_value = "out/validation")]
    keep: PathBuf,
    /// Python with the package `sturz`, for the papers' experiments
    #[arg(long, value_name = "PROGRAM", default_value = ".venv/bin/python")]
    python: String,
    /// Threads of the papers' experiments
    #[arg(long, default_value_t = 2)]
    threads: usize,
    /// Make the report of what is in --keep and run nothing more than the fast tier
    #[arg(long)]
    only_kept: bool,
}

fn main() -> anyhow::Result<ExitCode> {
    let arguments = Arguments::parse();
    // The list shows all, whatever the tier.
    let cases = if arguments.list && arguments.ids.is_empty() { registry() } else { chosen(&arguments)? };
    if arguments.list {
        let tier =
            |case: &Case| if case.tier == Tier::Fast { String::new() } else { format!(" ({})", case.tier.name()) };
        cases.iter().for_each(|case| println!("{:6} {}{}", case.id, case.title, tier(case)));
        return Ok(ExitCode::SUCCESS);
    }
    let data = arguments.data.clone().unwrap_or_else(Case::default_data);
    let rows = match &arguments.report {
        Some(path) => reported(&arguments, &cases, &data, path)?,
        None => {
            let mut rows = Vec::new();
            for case in cases {
                println!("{} {}", case.id, case.title);
                let own = case.rows_with(&data);
                print(&own, arguments.quiet);
                rows.extend(own);
            }
            rows
        }
    };
    let failed = cases::conclude(&rows, arguments.json.as_deref())?;
    Ok(if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn print(rows: &[Row], quiet: bool) {
    rows.iter().filter(|row| !quiet || !row.pass).for_each(Row::print);
}

/// The cases of these ids, in their order; all of the tier without ids.
fn chosen(arguments: &Arguments) -> anyhow::Result<Vec<Case>> {
    let (ids, mut all) = (&arguments.ids, registry());
    if ids.is_empty() {
        all.retain(|case| case.tier <= arguments.tier);
        return Ok(all);
    }
    if let Some(unknown) = ids.iter().find(|id| all.iter().all(|case| case.id != **id)) {
        bail!("no case '{unknown}'; --list shows them");
    }
    all.retain(|case| ids.iter().any(|id| id == case.id));
    Ok(all)
}

/// Runs what is not done, and writes the page anew after each step of it: whatever ends the run, the page is there.
fn reported(arguments: &Arguments, cases: &[Case], data: &Path, path: &Path) -> anyhow::Result<Vec<Row>> {
    let store = Store::open(&arguments.keep.join("cases"))?;
    let mut page = Page { path, tier: arguments.tier, records: Vec::new(), studies: Vec::new(), papers: Vec::new() };
    for case in cases {
        println!("{} {}", case.id, case.title);
        // cases that others rely on are cheap: a slow one of the past is taken as it is
        let record = if arguments.only_kept && case.tier > Tier::Fast {
            match store.done(case.id) {
                Some(record) => record,
                None => continue,
            }
        } else {
            store.run(case, data)?
        };
        print(&record.rows, true);
        page.records.push(record);
    }
    page.write()?;
    let sturz = std::env::current_exe()?.with_file_name("sturz");
    let studies = arguments.keep.join("studies");
    for study in STUDIES.iter().filter(|study| study.tier <= arguments.tier) {
        if arguments.only_kept && study.tier > Tier::Fast && !study.is_kept(&studies) {
            continue;
        }
        println!("study: {}", study.title);
        page.studies.push(study.run(&sturz, &studies)?);
        page.write()?;
    }
    let folder = arguments.keep.join("papers");
    for script in SCRIPTS.iter().filter(|script| script.tier <= arguments.tier) {
        println!("paper: {}", script.title);
        let run = !arguments.only_kept;
        let outcome = if run { script.run(&arguments.python, &folder, arguments.threads) } else { Ok(()) };
        if let Some(found) = script.found(&folder)? {
            // what an earlier entry of the same folder showed is in it
            page.papers.retain(|earlier| earlier.name != found.name);
            page.papers.push(found);
        }
        page.write()?;
        if let Err(error) = outcome {
            eprintln!("{}: {error:#}; what it left is in the report", script.name);
        }
    }
    Ok(page.records.into_iter().flat_map(|record| record.rows).collect())
}

/// The page so far.
struct Page<'a> {
    path: &'a Path,
    tier: Tier,
    records: Vec<report::Record>,
    studies: Vec<report::StudyResult>,
    papers: Vec<report::Found>,
}

impl Page<'_> {
    fn write(&self) -> anyhow::Result<()> {
        if let Some(folder) = self.path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let html = report::page(self.tier, &self.records, &self.studies, &self.papers)?;
        std::fs::write(self.path, html).with_context(|| format!("cannot write {}", self.path.display()))
    }
}
