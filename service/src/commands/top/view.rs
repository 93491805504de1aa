//! What `sturz top` shows, as lines of text.

use sturz_protocol::v1;

use crate::commands::inspect::state_name;

/// Longest bar of a stage, columns.
const BAR: usize = 40;

/// A daemon at one moment.
pub struct View {
    /// Newest answer to `info`.
    pub info: v1::Info,
    /// Newest report.
    pub report: v1::Report,
    /// Why it may be out of date.
    pub trouble: Option<String>,
}

impl View {
    /// All of it, for a terminal of so many columns.
    pub fn text(&self, columns: usize) -> String {
        self.lines(columns).iter().map(|line| format!("{line}\n")).collect()
    }

    /// Line by line. Bars get what width is left.
    pub fn lines(&self, columns: usize) -> Vec<String> {
        let mut lines = self.head();
        lines.extend(self.stages(columns));
        lines.extend(self.accuracy());
        lines.extend(self.streams());
        lines.extend(self.warnings());
        lines
    }

    fn head(&self) -> Vec<String> {
        let (info, report) = (&self.info, &self.report);
        let state = match info.failure.as_str() {
            "" => state_name(info.state()),
            failure => format!("{}: {failure}", state_name(info.state())),
        };
        let title = format!("{} ({}), sturz {}, pid {}", info.instance, info.scene, info.version, info.pid);
        let mut lines = vec![format!("{title}, {} threads, up {:.0} s", info.threads, report.wall_s)];
        lines.extend(self.trouble.iter().map(|trouble| row("NO NEWS", trouble.clone())));
        lines.push(row("state", state));
        let header = report.header.clone().unwrap_or_default();
        lines.push(row("time", format!("{:.6} s, step {}", header.sim_time_s, header.step)));
        if let Some(progress) = &report.progress {
            let share = share(progress.steps_done as f64, progress.steps_total as f64);
            let end = progress.to_time_s;
            lines.push(row(
                "window",
                format!("{} {:3.0} % of the way to {end:.6} s", bar(share, BAR / 2), 100.0 * share),
            ));
        }
        let touching =
            format!("{} pairs touch, {} with boundaries", report.touching_pairs, report.touching_boundary_pairs);
        lines.push(row("particles", format!("{}, {touching}", report.particles)));
        let particle_steps = report.steps_per_wall_s * report.particles as f64;
        let speed = format!("{:.4e} steps/s, {particle_steps:.4e} particle-steps/s", report.steps_per_wall_s);
        lines.push(row("speed", format!("{speed}, {:.4e} simulated s per wall s", report.sim_s_per_wall_s)));
        lines.push(row("longest pause", format!("{:.3} ms", 1e3 * report.longest_pause_s)));
        let holder = Some(info.lease_holder.as_str()).filter(|holder| !holder.is_empty());
        lines.push(row("lease", holder.unwrap_or("nobody").into()));
        lines
    }

    fn stages(&self, columns: usize) -> Vec<String> {
        let stages = &self.report.stages;
        let total: f64 = stages.iter().map(|stage| stage.s_per_step).sum();
        if stages.is_empty() {
            return vec![row("stages", "no step yet".into())];
        }
        let name = stages.iter().map(|stage| stage.name.len()).max().unwrap_or_default();
        let room = columns.saturating_sub(name + 28).clamp(4, BAR);
        let mut lines = vec![row("stages", format!("{:.1} us per step", 1e6 * total))];
        lines.extend(stages.iter().map(|stage| {
            let share = share(stage.s_per_step, total);
            let (filled, us) = (bar(share, room), 1e6 * stage.s_per_step);
            format!("    {:name$} {filled} {:5.1} % {us:10.1} us", stage.name, 100.0 * share)
        }));
        lines
    }

    fn accuracy(&self) -> Vec<String> {
        let report = &self.report;
        let energy = report.energy.unwrap_or_default();
        let kinetic = energy.kinetic_translation_j + energy.kinetic_rotation_j;
        let lost = energy.dissipated_normal_j + energy.dissipated_friction_j + energy.dissipated_local_j;
        let work = energy.work_boundaries_j + energy.work_commands_j + energy.work_loads_j;
        let (potential, elastic) = (energy.potential_j, energy.elastic_j);
        let largest = [kinetic, potential, elastic, lost, work].map(f64::abs).into_iter().fold(0.0, f64::max);
        let relative = share(energy.residual_j, largest);
        vec![
            row("energy", format!("kinetic {kinetic:.4e} J, potential {potential:.4e} J, elastic {elastic:.4e} J")),
            row("", format!("lost {lost:.4e} J, work done on it {work:.4e} J")),
            row("residual", format!("{:.3e} J, {relative:.2e} of the largest of these", energy.residual_j)),
            row(
                "overlap",
                format!(
                    "{:.3e} m now, {:.2e} of the bounding radius at most so far",
                    report.largest_overlap_m, report.largest_overlap_ratio_so_far
                ),
            ),
            row(
                "time step",
                format!(
                    "{:.3e} s, {:.3} of the critical one, {:.3} of that of the contacts now",
                    report.time_step_s,
                    report.time_step_s / report.critical_time_step_s,
                    report.time_step_s / report.present_critical_time_step_s
                ),
            ),
        ]
    }

    fn streams(&self) -> Vec<String> {
        let name = self.report.streams.iter().map(|stream| stream.name.len()).max().unwrap_or_default();
        let line = |stream: &v1::StreamCounts| {
            let v1::StreamCounts { offered, published, dropped, .. } = stream;
            format!("    {:name$} {offered:10} offered {published:10} published {dropped:10} dropped", stream.name)
        };
        let title = row("streams", "frames since the start".into());
        [title].into_iter().chain(self.report.streams.iter().map(line)).collect()
    }

    fn warnings(&self) -> Vec<String> {
        let counts = self.report.warnings.unwrap_or_default();
        let named = [
            ("rotation not converged", counts.rotation_not_converged),
            ("large overlap", counts.large_overlap),
            ("fast particle", counts.fast_particle),
            ("deep rounding", counts.deep_rounding),
        ];
        let seen: Vec<String> =
            named.iter().filter(|(_, count)| *count > 0).map(|(name, count)| format!("{name} {count}")).collect();
        vec![row("warnings", if seen.is_empty() { "none".into() } else { seen.join(", ") })]
    }
}

fn row(name: &str, value: String) -> String {
    format!("  {name:14} {value}")
}

/// A part of a whole; 0 of nothing.
fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

fn bar(share: f64, columns: usize) -> String {
    let filled = ((share * columns as f64).round() as usize).min(columns);
    format!("[{}{}]", "#".repeat(filled), ".".repeat(columns - filled))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> View {
        let stage = |name: &str, s_per_step| v1::StageCost { name: name.into(), s_per_step };
        let report = v1::Report {
            header: Some(v1::Header { sim_time_s: 1.5, step: 150, ..Default::default() }),
            particles: 10,
            steps_per_wall_s: 1e3,
            stages: vec![stage("narrow", 3e-6), stage("forces", 1e-6)],
            energy: Some(v1::EnergyBalance { kinetic_translation_j: 2.0, residual_j: -4e-3, ..Default::default() }),
            time_step_s: 1e-5,
            critical_time_step_s: 1e-4,
            present_critical_time_step_s: f64::INFINITY,
            longest_pause_s: 2e-3,
            streams: vec![v1::StreamCounts { name: "state".into(), offered: 9, published: 7, dropped: 2 }],
            warnings: Some(v1::WarningCounts { fast_particle: 3, ..Default::default() }),
            ..Default::default()
        };
        let mut info = v1::Info { instance: "drum".into(), lease_holder: "abc".into(), ..Default::default() };
        info.set_state(v1::RunState::Running);
        View { info, report, trouble: None }
    }

    #[test]
    fn it_shows_what_the_report_says() {
        let text = view().text(80);
        for part in [
            "state          running",
            "1.500000 s, step 150",
            "1.0000e3 steps/s, 1.0000e4 particle-steps/s",
            "4.0 us per step",
            " 75.0 %        3.0 us",
            " 25.0 %        1.0 us",
            "-4.000e-3 J, -2.00e-3 of the largest",
            "0.100 of the critical one, 0.000 of that of the contacts now",
            "longest pause  2.000 ms",
            "9 offered          7 published          2 dropped",
            "lease          abc",
            "fast particle 3",
        ] {
            assert!(text.contains(part), "{part} in\n{text}");
        }
        assert!(!text.contains("large overlap"), "{text}");
    }

    #[test]
    fn bars_are_as_long_as_the_shares() {
        let lines = view().lines(80);
        let filled = |name: &str| {
            let line = lines.iter().find(|line| line.trim_start().starts_with(name)).unwrap();
            line.matches('#').count()
        };
        assert_eq!((filled("narrow"), filled("forces")), (30, 10));
        assert!(view().lines(30).iter().all(|line| line.matches('#').count() <= 4), "a narrow terminal has short bars");
    }

    #[test]
    fn a_daemon_without_a_step_has_a_view() {
        let view = View { info: v1::Info::default(), report: v1::Report::default(), trouble: Some("silent".into()) };
        let text = view.text(80);
        assert!(text.contains("no step yet") && text.contains("NO NEWS        silent"), "{text}");
        assert!(!text.contains("0 %"), "{text}");
    }
}
