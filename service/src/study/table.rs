//! A study for people.

use indicatif::HumanDuration;
use std::time::Duration;

use super::{Point, Study};

/// Prints it.
pub fn print(study: &Study) {
    println!("{}: error of {} at t = {} s", study.scene, study.measure, study.time_s);
    println!("measured from {}, over {:.3e}: errors in {}", study.reference_words(), study.scale, study.error_unit);
    let kind = if study.seeds { "seeds" } else { "phases of the time step" };
    println!("{} runs of each setting at other {kind}; wall time is that of the steps alone, median\n", study.samples);
    let width = study.points.iter().map(|point| point.setting.label().len()).max().unwrap_or(0).max(7);
    println!("  {:width$} {:>10} {:>9} {:>22} {:>10} {:>10}", "setting", "time step", "steps", "error", "wall", "ps/s");
    for (place, point) in study.points.iter().enumerate() {
        let recommended = study.recommendation.as_ref().is_some_and(|r| r.point == place);
        let mark = if recommended {
            "*"
        } else if point.on_front {
            "+"
        } else {
            " "
        };
        println!("{mark} {:width$} {}", point.setting.label(), row(point));
    }
    println!("\n+ no other setting is both faster and better   * recommended");
    for order in &study.orders {
        let others = if order.others.is_empty() { String::new() } else { format!(" at {}", order.others) };
        let key = order.key.replace('_', " ");
        println!("observed order in the {key}{others}: {:.2}, {:.2} at the end", order.order, order.last);
    }
    recommendation(study);
    study.remarks.iter().for_each(|remark| println!("note: {remark}"));
}

impl Study {
    fn reference_words(&self) -> String {
        match self.reference_value.as_slice() {
            [value] if self.reference_standard_error > 0.0 => {
                format!("{} ({value:.6e} +- {:.1e})", self.reference, self.reference_standard_error)
            }
            [value] => format!("{} ({value:.6e})", self.reference),
            _ => self.reference.clone(),
        }
    }
}

fn row(point: &Point) -> String {
    if let Some(problem) = &point.problem {
        return format!("{:>10.3e} {problem}", point.setting.time_step_s);
    }
    let error = format!("{:.3e} +- {:.0e}", point.error, point.error_bar);
    format!(
        "{:>10.3e} {:>9} {:>22} {:>10} {:>10.2e}",
        point.setting.time_step_s,
        point.steps,
        error,
        seconds(point.wall_s),
        point.particle_steps_per_s
    )
}

fn seconds(wall_s: f64) -> String {
    if wall_s < 120.0 { format!("{wall_s:.3} s") } else { HumanDuration(Duration::from_secs_f64(wall_s)).to_string() }
}

fn recommendation(study: &Study) {
    let Some(found) = &study.recommendation else { return };
    let point = &study.points[found.point];
    println!(
        "\nfor an error of {:e}: {} (error {:.2e} +- {:.0e}, {})",
        study.wanted_error,
        found.label,
        point.error,
        point.error_bar,
        seconds(point.wall_s)
    );
    if let (Some(error), Some(confirmed)) = (found.confirmed_error, found.confirmed) {
        let verdict = if confirmed { "confirmed" } else { "NOT confirmed" };
        let bar = found.confirmed_error_bar;
        println!("{verdict} by a run of its own: error {error:.2e} +- {bar:.0e}, {}", seconds(found.confirmed_wall_s));
    }
}
