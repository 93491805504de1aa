//! `bench`: particle-steps per second of the workloads W1 to W4, with the quality of what was computed beside.

use std::path::PathBuf;

use anyhow::Context;
use clap::Parser;
use sturz_tests::bench::{Measurement, NormalLaw, Plan, Size, Workload, measure, settled};

/// Times the engine on settled beds (settled first where no cached bed is found, which takes minutes).
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// W1, W2-cubes, W2-pinacoids, W2r, R-octahedra, W3, W3r, W4 or all
    workload: String,
    /// Physics threads
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// Steps of each of the timed blocks
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u64).range(1..))]
    steps: u64,
    /// Timed blocks, of which the median counts
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(5..))]
    blocks: u16,
    /// Normal law of the measured run where polyhedra meet; beds are settled with the linear one
    #[arg(long, value_enum, default_value_t)]
    normal: NormalLaw,
    /// Untimed steps before the first block: the bed comes without friction history, and changes its law
    #[arg(long, default_value_t = 40_000)]
    warm_up: u64,
    /// A few dozen particles instead: a test of the program, no benchmark
    #[arg(long)]
    small: bool,
    /// Write the result here: an object, or an array for all
    #[arg(long)]
    json: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let size = if arguments.small { Size::Small } else { Size::Full };
    let names: Vec<&str> =
        if arguments.workload == "all" { Workload::NAMES.to_vec() } else { vec![arguments.workload.as_str()] };
    let plan = Plan {
        threads: arguments.threads.into(),
        steps: arguments.steps,
        blocks: arguments.blocks.into(),
        normal: arguments.normal,
        warm_up: arguments.warm_up,
    };
    let mut results = Vec::new();
    print_head();
    for name in names {
        let workload = Workload::named(name, size)?;
        let bed = settled(&workload, plan.threads, &mut |line| eprintln!("{line}"))?;
        let result = measure(&workload, &bed, &plan).with_context(|| format!("{name} failed while measured"))?;
        print_row(&result);
        results.push(result);
    }
    if let Some(path) = &arguments.json {
        let text = match &results[..] {
            [only] if arguments.workload != "all" => serde_json::to_string_pretty(only)?,
            _ => serde_json::to_string_pretty(&results)?,
        };
        std::fs::write(path, text + "\n").with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

fn print_head() {
    println!(
        "{:13} {:>3} {:>9} {:>7} {:>7} {:>11} {:>17} {:>8} {:>8} {:>8} {:>8} {:>9} {:>8}",
        "workload",
        "thr",
        "particles",
        "pairs",
        "points",
        "ps/s",
        "slowest..fastest",
        "us/pair",
        "rebuilds",
        "re/step",
        "overlap",
        "E_kin/mgd",
        "RSS MiB"
    );
}

fn print_row(m: &Measurement) {
    let [slowest, fastest] = m.particle_steps_per_s_range;
    println!(
        "{:13} {:>3} {:>9} {:>7} {:>7} {:>11.3e} {:>17} {:>8.3} {:>8} {:>8.1} {:>8.1e} {:>9.1e} {:>8.0}",
        m.workload,
        m.threads,
        m.particles,
        m.touching_pairs,
        m.contact_points,
        m.particle_steps_per_s,
        format!("{slowest:.2e}..{fastest:.2e}"),
        m.us_per_touching_pair,
        m.neighbour_rebuilds,
        m.rebuild_over_step,
        m.largest_overlap_ratio,
        m.kinetic_energy_per_mgd,
        m.peak_rss_mib.unwrap_or(f64::NAN)
    );
    let shares: Vec<String> = m
        .stage_share
        .iter()
        .map(|(stage, share)| format!("{stage} {:.0} %", 100.0 * share.as_f64().unwrap_or(f64::NAN)))
        .collect();
    let (pairs, [smooth, face, edge]) = m.at_start;
    println!(
        "{:17} at start {pairs} pairs, points: {face} vertex-face, {edge} edge-edge, {smooth} others; at the end {:?}",
        "", m.contact_points_by_kind
    );
    println!("{:17} {}; residual {:.1e} m g size per particle", "", shares.join(", "), m.energy_residual_per_mgd);
}
