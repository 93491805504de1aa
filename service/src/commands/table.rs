//! The report of a run for people: how wrong, how long.

use crate::commands::run::{Ending, Summary};

/// Prints it.
pub fn print(summary: &Summary) {
    let Summary { report, .. } = summary;
    let ending = match summary.ending {
        Ending::Complete => "complete",
        Ending::Interrupted => "interrupted",
        Ending::Failed => "failed",
    };
    println!("{}: {ending} at t = {:.6} s, step {}", summary.scene, report.time_s, report.step);
    if let Some(failure) = &summary.failure {
        println!("  {failure}");
    }
    println!("\nhow long");
    line("wall time", format!("{:.2} s on {} threads", summary.wall_s, summary.threads));
    line("speed", format!("{:.4e} simulated s per wall s", summary.simulated_s_per_wall_s));
    line("", format!("{:.4e} steps/s, {:.4e} particle-steps/s", summary.steps_per_s, summary.particle_steps_per_s));
    let shares: Vec<String> =
        summary.stage_share.iter().map(|(stage, share)| format!("{stage} {:.0} %", 100.0 * share)).collect();
    line("stages", shares.join(", "));
    line("neighbour lists", format!("{} in {} steps", report.neighbour_rebuilds, report.step));
    println!("\nhow wrong");
    energy(summary);
    line(
        "largest overlap",
        format!(
            "{:.3e} m now; {:.2e} of the bounding radius in the whole run",
            report.largest_overlap_m, report.largest_overlap_ratio_so_far
        ),
    );
    line("time step", format!("{:.3e} s", report.time_step_s));
    line("", format!("{:.3} of the critical one", report.time_step_s / report.critical_time_step_s));
    let present = report.time_step_s / report.present_critical_time_step_s;
    line("", format!("{present:.3} of that of the contacts at the end, all of a body's together"));
    line("", format!("{:.1} per shortest collision", report.contact_duration_s / report.time_step_s));
    line("force residual", format!("{:.2e} N summed over all pairs", report.internal_force_residual_n));
    let warnings = report.warnings;
    line(
        "warnings",
        format!(
            "rotation not converged {}, large overlap {}, fast particle {}, deep rounding {}",
            warnings.rotation_not_converged, warnings.large_overlap, warnings.fast_particle, warnings.deep_rounding
        ),
    );
    println!("\nwhat");
    line("particles", report.particles);
    let (pairs, walls) = (report.touching_pairs, report.touching_boundary_pairs);
    line("touching", format!("{pairs} pairs, {walls} with boundaries, {} points", report.contact_points));
    line("state hash", &summary.state_hash);
}

fn energy(summary: &Summary) {
    let energy = &summary.report.energy;
    let terms = [
        ("kinetic, translation", energy.kinetic_translation_j),
        ("kinetic, rotation", energy.kinetic_rotation_j),
        ("potential", energy.potential_j),
        ("elastic", energy.elastic_j),
        ("lost to dashpots", energy.dissipated_normal_j),
        ("lost to friction", energy.dissipated_friction_j),
        ("lost to local damping", energy.dissipated_local_j),
        ("work of boundaries", energy.work_boundaries_j),
        ("work of commands", energy.work_commands_j),
        ("work of loads", energy.work_loads_j),
    ];
    for (name, joule) in terms {
        line(name, format!("{joule:14.6e} J"));
    }
    let largest = terms.iter().map(|(_, joule)| joule.abs()).fold(0.0, f64::max);
    let relative = if largest > 0.0 { energy.residual_j / largest } else { 0.0 };
    line("energy residual", format!("{:14.6e} J, {relative:.2e} of the largest term", energy.residual_j));
}

fn line(name: &str, value: impl std::fmt::Display) {
    println!("  {name:22} {value}");
}
