//! `sturz study`: error against run time over a grid of settings.

use anyhow::Context as _;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli;
use crate::commands::{Failure, print_json};
use crate::study::{self, Plan};

/// Runs it, prints it, draws it.
pub fn study(options: &cli::Study) -> Result<(), Failure> {
    let plan = Plan::new(options)?;
    let target = if options.json { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(None, target);
    let style = ProgressStyle::with_template("{spinner} {msg} {elapsed}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
    bar.enable_steady_tick(std::time::Duration::from_millis(200));
    let study = study::study(&plan, |what, left| bar.set_message(format!("{left} runs left, now {what},")))?;
    bar.finish_and_clear();
    if options.json {
        print_json(&study)?;
    } else {
        study::print(&study);
    }
    if let Some(path) = &options.plot
        && let Some(svg) = study::svg(&study)?
    {
        std::fs::write(path, svg).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}
