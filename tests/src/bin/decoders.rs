//! `decoders`: sound inputs for `cargo fuzz`, and the same decoders fed without it.

use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context as _, ensure};
use clap::Parser;
use sturz_tests::decoders::{mutate, registry};

/// Feeds everything that reads bytes from outside with changed sound inputs; a panic ends it. With --seeds it writes the
/// sound inputs, for `cargo fuzz` to begin with. The daemon that makes some of them is the `sturz` beside this program, or
/// STURZ_BINARY.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// Decoders by name; all when there is none
    names: Vec<String>,
    /// List the decoders
    #[arg(long)]
    list: bool,
    /// Write sound inputs into this folder, a folder for each decoder
    #[arg(long, value_name = "DIR")]
    seeds: Option<PathBuf>,
    /// Of each decoder, s
    #[arg(long, default_value_t = 10.0)]
    seconds: f64,
    /// Another one gives other inputs
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let all = registry();
    for name in &arguments.names {
        ensure!(all.iter().any(|target| target.name == name), "no decoder '{name}'; --list shows them");
    }
    let most = Duration::try_from_secs_f64(arguments.seconds).context("--seconds is no time")?;
    let wanted = |name: &str| arguments.names.is_empty() || arguments.names.iter().any(|wanted| wanted == name);
    for target in all.iter().filter(|target| wanted(target.name)) {
        println!("{:12} {}", target.name, target.title);
        if let Some(folder) = &arguments.seeds {
            let folder = folder.join(target.name);
            fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
            for (k, bytes) in target.seeds()?.iter().enumerate() {
                fs::write(folder.join(format!("seed-{k:03}")), bytes)?;
            }
        } else if !arguments.list {
            let tried = mutate(target, arguments.seed, u64::MAX, most)?;
            println!("{:12} {} sound and {} changed inputs, no panic", "", tried.seeds, tried.changed);
        }
    }
    Ok(())
}
