//! `sturz check`

use crate::cli;
use crate::commands::{Failure, print_json};
use crate::scenes;

/// Tells what a scene needs, its time scales, and every doubt.
pub fn check(options: &cli::Check) -> Result<(), Failure> {
    let scene = scenes::load(&options.scene.scene)?;
    let check = scene.check();
    if options.json {
        return print_json(&check);
    }
    println!("{}: {}", scene.description().scene.name, scene.description().scene.description);
    println!("\nplan");
    check.plan.iter().for_each(|line| println!("  {line}"));
    println!("\nparticles at the start   {}", check.particles);
    println!("time step                {:.4e} s", check.time_step_s);
    println!(
        "critical time step       {:.4e} s for a single contact; the step is {:.3} of it",
        check.critical_time_step_s,
        check.time_step_s / check.critical_time_step_s
    );
    println!(
        "shortest collision       {:.4e} s, {:.1} steps",
        check.contact_duration_s,
        check.contact_duration_s / check.time_step_s
    );
    if let Some(overlap) = check.resting_overlap_ratio {
        println!("overlap at rest          {overlap:.2e} of the bounding radius, the heaviest particle on one point");
    }
    if check.warnings.is_empty() {
        println!("\nno doubts");
    } else {
        println!("\ndoubts");
        check.warnings.iter().for_each(|warning| println!("  {warning}"));
    }
    Ok(())
}
