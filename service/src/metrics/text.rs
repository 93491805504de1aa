//! A report in the text format of Prometheus (version 0.0.4).

use std::fmt::Write as _;

use sturz_protocol::v1;

/// States of a run, each with a sample that is 1 in it and else 0.
const STATES: [(&str, v1::RunState); 5] = [
    ("running", v1::RunState::Running),
    ("paused", v1::RunState::Paused),
    ("advancing", v1::RunState::Advancing),
    ("failed", v1::RunState::Failed),
    ("ended", v1::RunState::Ended),
];

/// A family of samples: name without `sturz_`, help, label.
struct Family<'a>(&'a str, &'a str, &'a str);

/// The page under construction.
#[derive(Default)]
struct Page(String);

impl Page {
    fn head(&mut self, Family(name, help, _): &Family<'_>) {
        let kind = if name.ends_with("_total") { "counter" } else { "gauge" };
        self.0 += &format!("# HELP sturz_{name} {help}\n# TYPE sturz_{name} {kind}\n");
    }

    /// A family of one sample.
    fn one(&mut self, name: &str, help: &str, value: f64) {
        self.head(&Family(name, help, ""));
        self.0 += &format!("sturz_{name} {}\n", number(value));
    }

    /// A family with a sample per value of its label; nothing of it where there is none.
    fn each<'v>(&mut self, family: &Family<'_>, samples: impl IntoIterator<Item = (&'v str, f64)>) {
        let Family(name, _, label) = family;
        let mut samples = samples.into_iter().peekable();
        if samples.peek().is_some() {
            self.head(family);
        }
        for (of, value) in samples {
            self.0 += &format!("sturz_{name}{{{label}=\"{}\"}} {}\n", escaped(of), number(value));
        }
    }
}

/// All metrics of a daemon.
pub fn encode(info: &v1::Info, report: &v1::Report) -> String {
    let mut page = Page::default();
    about(&mut page, info, report);
    progress(&mut page, report);
    speed(&mut page, report);
    accuracy(&mut page, report);
    streams(&mut page, report);
    page.0
}

fn about(page: &mut Page, info: &v1::Info, report: &v1::Report) {
    page.head(&Family("info", "The daemon, in labels.", ""));
    let run_id = report.header.as_ref().map_or("", |header| &header.run_id);
    let labels =
        [("instance_name", &*info.instance), ("run_id", run_id), ("scene", &info.scene), ("version", &info.version)];
    let labels: Vec<String> = labels.iter().map(|(name, value)| format!("{name}=\"{}\"", escaped(value))).collect();
    page.0 += &format!("sturz_info{{{}}} 1\n", labels.join(","));
    let state = report.state();
    let states = STATES.map(|(name, one)| (name, f64::from(u8::from(one == state))));
    page.each(&Family("run_state", "1 in the state that the run is in, else 0.", "state"), states);
    page.one("threads", "Threads of the physics.", info.threads.into());
    page.one("uptime_seconds", "Wall time since the start of the daemon.", report.wall_s);
}

fn progress(page: &mut Page, report: &v1::Report) {
    let header = report.header.clone().unwrap_or_default();
    page.one("simulated_time_seconds", "Simulated time.", header.sim_time_s);
    page.one("steps_total", "Steps done; a restore goes back.", header.step as f64);
    page.one("particles", "Particles present.", report.particles as f64);
    let touching = [("particle", report.touching_pairs as f64), ("boundary", report.touching_boundary_pairs as f64)];
    page.each(
        &Family("touching_pairs", "Pairs of a particle and another one or a boundary that touch.", "with"),
        touching,
    );
    page.one("contact_points", "Contact points.", report.contact_points as f64);
    let rebuilds = report.neighbour_rebuilds as f64;
    page.one("neighbour_rebuilds_total", "Rebuilds of the neighbour list.", rebuilds);
}

fn speed(page: &mut Page, report: &v1::Report) {
    let since = "since the report before";
    page.one("steps_per_second", &format!("Steps per second of wall time, {since}."), report.steps_per_wall_s);
    let speed = report.sim_s_per_wall_s;
    page.one("simulated_seconds_per_second", &format!("Simulated time per wall time, {since}."), speed);
    let pause = report.longest_pause_s;
    page.one("longest_pause_seconds", &format!("Longest wall time from step to step, {since}."), pause);
    let help = format!("Wall time per step in a stage, {since}.");
    let stages = report.stages.iter().map(|stage| (stage.name.as_str(), stage.s_per_step));
    page.each(&Family("stage_seconds_per_step", &help, "stage"), stages);
}

fn accuracy(page: &mut Page, report: &v1::Report) {
    let energy = report.energy.unwrap_or_default();
    let terms = [
        ("kinetic_translation", energy.kinetic_translation_j),
        ("kinetic_rotation", energy.kinetic_rotation_j),
        ("potential", energy.potential_j),
        ("elastic", energy.elastic_j),
        ("dissipated_normal", energy.dissipated_normal_j),
        ("dissipated_friction", energy.dissipated_friction_j),
        ("dissipated_local", energy.dissipated_local_j),
        ("work_boundaries", energy.work_boundaries_j),
        ("work_commands", energy.work_commands_j),
        ("work_loads", energy.work_loads_j),
    ];
    page.each(&Family("energy_joules", "Energies, and works since the start.", "term"), terms);
    page.one("energy_residual_joules", "What the balance of energies lacks.", energy.residual_j);
    page.one("largest_overlap_meters", "Largest overlap.", report.largest_overlap_m);
    let bounding = "over the smaller bounding radius";
    page.one("largest_overlap_ratio", &format!("Largest overlap {bounding}."), report.largest_overlap_ratio);
    let so_far = report.largest_overlap_ratio_so_far;
    page.one("largest_overlap_ratio_so_far", &format!("Largest overlap {bounding}, since the start."), so_far);
    page.one("time_step_seconds", "Time step in use.", report.time_step_s);
    let critical = report.critical_time_step_s;
    page.one("critical_time_step_seconds", "Largest stable time step of a single contact.", critical);
    let present = report.present_critical_time_step_s;
    page.one("present_critical_time_step_seconds", "Largest stable time step of the contacts present.", present);
    let duration = report.contact_duration_s;
    page.one("contact_duration_seconds", "Shortest duration of a collision of two particles present.", duration);
    let counts = report.warnings.unwrap_or_default();
    let kinds = [
        ("rotation_not_converged", counts.rotation_not_converged as f64),
        ("large_overlap", counts.large_overlap as f64),
        ("fast_particle", counts.fast_particle as f64),
        ("deep_rounding", counts.deep_rounding as f64),
    ];
    page.each(&Family("warnings_total", "Events that do not stop a run.", "kind"), kinds);
}

fn streams(page: &mut Page, report: &v1::Report) {
    let samples = |count: fn(&v1::StreamCounts) -> u64| {
        report.streams.iter().map(move |stream| (stream.name.as_str(), count(stream) as f64))
    };
    let offered = Family("stream_offered_total", "Frames handed out by the physics.", "stream");
    page.each(&offered, samples(|stream| stream.offered));
    let published = Family("stream_published_total", "Frames given to the bus.", "stream");
    page.each(&published, samples(|stream| stream.published));
    let dropped =
        Family("stream_dropped_total", "Frames overwritten by newer ones before they were published.", "stream");
    page.each(&dropped, samples(|stream| stream.dropped));
}

/// As Go reads it, to the last bit.
fn number(value: f64) -> String {
    if value.is_infinite() { if value > 0.0 { "+Inf".into() } else { "-Inf".into() } } else { format!("{value:e}") }
}

/// A value of a label.
fn escaped(value: &str) -> String {
    let mut text = String::with_capacity(value.len());
    for letter in value.chars() {
        match letter {
            '\\' => text += "\\\\",
            '"' => text += "\\\"",
            '\n' => text += "\\n",
            other => drop(text.write_char(other)),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_bits_and_labels_are_escaped() {
        for value in [0.1, 1e-300, -3.5e20, 0.0, 12.0] {
            assert_eq!(number(value).parse::<f64>(), Ok(value));
        }
        assert_eq!((&*number(f64::INFINITY), &*number(f64::NEG_INFINITY)), ("+Inf", "-Inf"));
        assert_eq!(number(f64::NAN), "NaN");
        assert_eq!(escaped("a\"b\\c\nd"), "a\\\"b\\\\c\\nd");
    }

    #[test]
    fn each_family_has_its_head_once_and_samples_have_one() {
        let stream = |name: &str| v1::StreamCounts { name: name.into(), offered: 3, published: 2, dropped: 1 };
        let streams = vec![stream("state"), stream("field/slice")];
        let page = encode(&v1::Info::default(), &v1::Report { streams, ..Default::default() });
        let mut heads = Vec::new();
        for line in page.lines() {
            match line.split(' ').collect::<Vec<_>>()[..] {
                ["#", "TYPE", name, kind] => {
                    assert_eq!(kind == "counter", name.ends_with("_total"), "{line}");
                    heads.push(name);
                }
                ["#", "HELP", ..] => assert!(line.ends_with('.'), "{line}"),
                [name, value] => {
                    assert_eq!(heads.last(), Some(&name.split('{').next().unwrap()), "{line}");
                    assert!(value.parse::<f64>().is_ok(), "{line}");
                }
                _ => assert!(line.starts_with("sturz_info{"), "{line}"),
            }
        }
        let all = heads.len();
        heads.sort_unstable();
        heads.dedup();
        assert_eq!(heads.len(), all, "a family twice");
        assert!(page.contains("sturz_stream_dropped_total{stream=\"field/slice\"} 1e0\n"), "{page}");
        assert!(!page.contains("stage_seconds_per_step"), "no step, no stages");
    }
}
