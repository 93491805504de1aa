//! `memory`: bytes per particle and per contact point of the workloads. A program of its own: where arrays happen to lie
//! shows in the rate of spheres by five percent, so `bench` is left to the system's allocator.

use clap::Parser;
use peak_alloc::PeakAlloc;
use sturz_tests::bench::{NormalLaw, Plan, Size, Workload, memory, settled};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Weighs the engine on settled beds (settled first where no cached bed is found, which takes minutes).
#[derive(Parser)]
#[command(version)]
struct Arguments {
    /// W1, W2-cubes, W2-pinacoids, W2r, R-octahedra, W3, W3r, W4 or all
    workload: String,
    /// Steps before: the bed comes without friction history, and changes its law
    #[arg(long, default_value_t = 10_000)]
    warm_up: u64,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let names = if arguments.workload == "all" { Workload::NAMES.to_vec() } else { vec![arguments.workload.as_str()] };
    let normal = NormalLaw::GeneralizedOverlap;
    let plan = Plan { threads: 1, steps: 1, blocks: 1, normal, tiles: 1, warm_up: arguments.warm_up };
    println!(
        "{:13} {:>9} {:>9} {:>14} {:>19}",
        "workload", "particles", "points", "bytes/particle", "more bytes/point"
    );
    for name in names {
        let workload = Workload::named(name, Size::Full)?;
        let bed = settled(&workload, 1, &mut |line| eprintln!("{line}"))?;
        let found = memory(&workload, &bed, &plan, || MEMORY.current_usage())?;
        println!(
            "{:13} {:>9} {:>9} {:>14.0} {:>19.0}",
            found.workload,
            found.particles,
            found.contact_points,
            found.bytes_per_particle,
            found.bytes_per_contact_point
        );
    }
    Ok(())
}
