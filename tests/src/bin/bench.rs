//! `bench`: particle-steps per second of the workloads W1 to W4, with the quality of what was computed beside.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Parser;
use serde::Serialize;
use sturz_tests::bench::{
    LeftOut, Measurement, NormalLaw, Plan, Size, Workload, coupling_costs, field_costs, left_out, measure, settled,
};

/// Times the engine on settled beds (settled first where no cached bed is found, which takes minutes).
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// W1, W2-cubes, W2-pinacoids, W2r, R-octahedra, W3, W3r, W4, all of these, fields: what a sample costs, or coupling: what a
    /// window with a fluid costs
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
    /// Copies of the bed along x and y: 10 makes 100 beds of one
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=32))]
    tiles: u32,
    /// Times what the scene does not use instead: each feature switched off against a scene that never had it
    #[arg(long)]
    left_out: bool,
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
    if arguments.workload == "coupling" {
        return time_coupling(&arguments);
    }
    if arguments.workload == "fields" {
        return time_fields(&arguments);
    }
    let names: Vec<&str> =
        if arguments.workload == "all" { Workload::NAMES.to_vec() } else { vec![arguments.workload.as_str()] };
    let plan = Plan {
        threads: arguments.threads.into(),
        steps: arguments.steps,
        blocks: arguments.blocks.into(),
        normal: arguments.normal,
        tiles: arguments.tiles,
        warm_up: arguments.warm_up,
    };
    if arguments.left_out {
        return time_left_out(&names, size, &plan, arguments.json.as_deref());
    }
    let mut results = Vec::new();
    print_head();
    for name in &names {
        let workload = Workload::named(name, size)?;
        let bed = settled(&workload, plan.threads, &mut |line| eprintln!("{line}"))?;
        let result = measure(&workload, &bed, &plan).with_context(|| format!("{name} failed while measured"))?;
        print_row(&result);
        results.push(result);
    }
    match &results[..] {
        [only] if arguments.workload != "all" => write(arguments.json.as_deref(), only),
        _ => write(arguments.json.as_deref(), &results),
    }
}

fn write(path: Option<&Path>, results: &impl Serialize) -> anyhow::Result<()> {
    let Some(path) = path else { return Ok(()) };
    let text = serde_json::to_string_pretty(results)? + "\n";
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

fn time_fields(arguments: &Arguments) -> anyhow::Result<()> {
    let side = if arguments.small { 4 } else { 22 };
    let costs = field_costs(side, arguments.threads.into(), arguments.blocks.into())?;
    println!("{:36} {:>9} {:>7} {:>9}", "field", "particles", "cells", "ms");
    for cost in &costs {
        println!("{:36} {:>9} {:>7} {:>9.2}", cost.field, cost.particles, cost.cells, cost.ms);
    }
    write(arguments.json.as_deref(), &costs)
}

fn time_coupling(arguments: &Arguments) -> anyhow::Result<()> {
    let sides: &[u32] = if arguments.small { &[4] } else { &[22, 47] };
    let mut all = Vec::new();
    println!(
        "{:32} {:>9} {:>7} {:>13} {:>9} {:>17} {:>12}",
        "case", "particles", "cells", "fields in, ms", "step, ms", "fluid per step, ms", "exchange, ms"
    );
    for &side in sides {
        for cost in coupling_costs(side, arguments.threads.into(), arguments.blocks.into())? {
            println!(
                "{:32} {:>9} {:>7} {:>13.2} {:>9.3} {:>17.3} {:>12.2}",
                cost.case,
                cost.particles,
                cost.cells,
                cost.fields_in_ms,
                cost.step_ms,
                cost.fluid_in_step_ms,
                cost.exchange_ms
            );
            all.push(cost);
        }
    }
    write(arguments.json.as_deref(), &all)
}

fn time_left_out(names: &[&str], size: Size, plan: &Plan, json: Option<&Path>) -> anyhow::Result<()> {
    let mut results: Vec<LeftOut> = Vec::new();
    println!("time of a step over that of a scene that never had the feature: median (quartiles)");
    println!("{:13} {:26} {:>22} {:>22} {:>22}", "workload", "feature", "switched off", "in use", "noise");
    for name in names {
        let workload = Workload::named(name, size)?;
        let bed = settled(&workload, plan.threads, &mut |line| eprintln!("{line}"))?;
        for row in left_out(&workload, &bed, plan.blocks, plan.steps)? {
            let cell = |[median, low, high]: [f64; 3]| format!("{median:.3} ({low:.3}..{high:.3})");
            let cells = [row.off, row.on, row.noise].map(cell);
            println!("{:13} {:26} {:>22} {:>22} {:>22}", row.workload, row.feature, cells[0], cells[1], cells[2]);
            results.push(row);
        }
    }
    write(json, &results)
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
