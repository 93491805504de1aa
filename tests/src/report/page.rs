//! One self-contained page: verdicts, plots, stability, figures of the papers, machine and commit.

use std::fmt::Write as _;
use std::process::Command;

use super::curve::draw_all;
use super::scripts::{Found, ScriptRow};
use super::stability::EXTREMES;
use super::store::Record;
use super::studies::StudyResult;
use crate::cases::{Row, Tier};

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;max-width:1180px;margin:2rem auto;padding:0 1rem;color:#22303c}\
    table{border-collapse:collapse;width:100%;margin:.4rem 0 1.2rem}\
    th,td{text-align:left;padding:.25rem .5rem;border-bottom:1px solid #dde3e8;vertical-align:top}\
    td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}\
    .pass{color:#2f7d4f}.miss{color:#b3261e;font-weight:600}.shown{color:#6b7a86}\
    summary{cursor:pointer}figure{display:inline-block;margin:.3rem;max-width:100%}figure svg{max-width:100%;height:auto}\
    small{color:#6b7a86}";

/// The page.
pub fn page(tier: Tier, records: &[Record], studies: &[StudyResult], scripts: &[Found]) -> anyhow::Result<String> {
    let mut html = String::new();
    writeln!(html, "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Sturz: validation</title>")?;
    writeln!(html, "<style>{STYLE}</style></head><body><h1>Sturz: validation</h1>")?;
    summary(&mut html, tier, records, scripts)?;
    writeln!(html, "<h2>Error against run time</h2>")?;
    writeln!(
        html,
        "<p>Run time is that of the physics loop alone. Errors are means over phases of the time step.</p>"
    )?;
    let curves: Vec<_> = records.iter().flat_map(|record| record.curves.clone()).collect();
    for (title, svg) in draw_all(&curves)? {
        writeln!(html, "<figure aria-label=\"{}\">{}</figure>", escape(&title), inline(&svg))?;
    }
    of_studies(&mut html, studies)?;
    stability(&mut html, records)?;
    papers(&mut html, scripts)?;
    writeln!(html, "<h2>Cases with references</h2>")?;
    for record in records {
        case(&mut html, record)?;
    }
    writeln!(html, "</body></html>")?;
    Ok(html)
}

fn summary(html: &mut String, tier: Tier, records: &[Record], scripts: &[Found]) -> anyhow::Result<()> {
    let rows = || records.iter().flat_map(|record| &record.rows);
    let judged = rows().filter(|row| row.is_judged()).count();
    let missed = rows().filter(|row| !row.pass).count();
    let of_papers = || scripts.iter().flat_map(|found| &found.rows);
    let verdicts = |verdict: &str| of_papers().filter(|row| row.verdict == verdict).count();
    let wall_s: f64 = rows().map(|row| row.wall_s).sum();
    let steps: u64 = rows().map(|row| row.particle_steps).sum();
    writeln!(html, "<p>Tier <b>{}</b>. {} cases: {judged} comparisons, ", tier.name(), records.len())?;
    writeln!(
        html,
        "<span class=\"{}\">{missed} missed</span>; {wall_s:.0} s, ",
        if missed == 0 { "pass" } else { "miss" }
    )?;
    writeln!(
        html,
        "{:.2e} particle-steps. Experiments of the papers: {} within tolerance, ",
        steps as f64,
        verdicts("pass")
    )?;
    writeln!(html, "{} missed, {} only reported.</p>", verdicts("miss"), verdicts("reported"))?;
    writeln!(html, "<p><small>{}</small></p>", escape(&provenance()))?;
    Ok(())
}

/// Commit, machine, date: as much as can be known.
fn provenance() -> String {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success());
        output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let commit = git(&["rev-parse", "--short=12", "HEAD"]).unwrap_or_else(|| "unknown".into());
    let changed = git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|text| !text.is_empty());
    let processor = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = processor.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let model = model.map_or("unknown processor", |(_, name)| name);
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let date = time::OffsetDateTime::now_utc().date();
    format!("Commit {commit}{}; {model}, {cores} cores; {date}.", if changed { " with changes" } else { "" })
}

fn case(html: &mut String, record: &Record) -> anyhow::Result<()> {
    let judged = record.rows.iter().filter(|row| row.is_judged()).count();
    let missed = record.rows.iter().filter(|row| !row.pass).count();
    let wall_s: f64 = record.rows.iter().map(|row| row.wall_s).sum();
    let steps: u64 = record.rows.iter().map(|row| row.particle_steps).sum();
    let (class, verdict) = if missed == 0 { ("pass", "holds".into()) } else { ("miss", format!("{missed} missed")) };
    writeln!(html, "<details{}><summary><b id=\"{1}\">{1}</b> ", if missed > 0 { " open" } else { "" }, record.id)?;
    writeln!(
        html,
        "{}: <span class=\"{class}\">{verdict}</span> <small>({judged} comparisons, ",
        escape(&record.title)
    )?;
    writeln!(html, "closest to its tolerance {:.2}; ", closest(&record.rows))?;
    writeln!(html, "{wall_s:.1} s, {:.1e} particle-steps)</small></summary>", steps as f64)?;
    writeln!(
        html,
        "<table><tr><th>figure<th class=n>value<th class=n>reference<th class=n>tolerance<th>unit<th></tr>"
    )?;
    for row in &record.rows {
        let (reference, tolerance, class, verdict) = match (row.is_judged(), row.pass) {
            (false, _) => (String::new(), String::new(), "shown", "shown"),
            (true, pass) => {
                let (class, verdict) = if pass { ("pass", "holds") } else { ("miss", "missed") };
                (number(row.reference), format!("{:.1e}", row.tolerance), class, verdict)
            }
        };
        writeln!(html, "<tr><td>{}<td class=n>{}<td class=n>{reference}", escape(&row.metric), number(row.value))?;
        writeln!(html, "<td class=n>{tolerance}<td>{}<td class={class}>{verdict}</tr>", escape(&row.unit))?;
    }
    writeln!(html, "</table></details>")?;
    Ok(())
}

/// Largest distance from a reference over its tolerance: 1 is at the edge.
fn closest(rows: &[Row]) -> f64 {
    let judged = rows.iter().filter(|row| row.is_judged() && row.tolerance > 0.0);
    judged.map(|row| (row.value - row.reference).abs() / row.tolerance).fold(0.0, f64::max)
}

fn of_studies(html: &mut String, studies: &[StudyResult]) -> anyhow::Result<()> {
    writeln!(html, "<h2>Studies of whole scenes</h2>")?;
    for study in studies {
        writeln!(html, "<h3>{}</h3><p><code>{}</code></p><p>", escape(&study.title), escape(&study.command))?;
        writeln!(
            html,
            "{}: {}, measured from {}. ",
            escape(&study.scene),
            escape(&study.measure),
            escape(&study.reference)
        )?;
        for order in &study.orders {
            let others = if order.others.is_empty() { String::new() } else { format!(" at {}", escape(&order.others)) };
            writeln!(html, "Observed order in {}{others}: {:.2}. ", escape(&order.key), order.order)?;
        }
        match &study.recommendation {
            None => writeln!(html, "No setting reaches {:e}.", study.wanted_error)?,
            Some(found) => {
                let (class, verdict) = match found.confirmed {
                    Some(true) => ("pass", "confirmed"),
                    Some(false) => ("miss", "not confirmed"),
                    None => ("shown", "not run again"),
                };
                writeln!(html, "For an error of {:e}: <b>{}</b>, ", study.wanted_error, escape(&found.label))?;
                let (error, bar) = (found.confirmed_error.unwrap_or(f64::NAN), found.confirmed_error_bar);
                writeln!(
                    html,
                    "<span class={class}>{verdict}</span> by a run of its own: error {error:.2e} &plusmn; {bar:.0e}, "
                )?;
                writeln!(html, "{:.3} s.", found.confirmed_wall_s)?;
            }
        }
        study.remarks.iter().try_for_each(|remark| writeln!(html, "<br><small>{}</small>", escape(remark)))?;
        writeln!(html, "</p><figure aria-label=\"{}\">{}</figure>", escape(&study.title), inline(&study.svg))?;
    }
    Ok(())
}

fn stability(html: &mut String, records: &[Record]) -> anyhow::Result<()> {
    writeln!(html, "<h2>Stiff and extreme cases</h2><table>")?;
    writeln!(html, "<tr><th>id<th>what is tried<th>what others do<th>what Sturz does<th>shown by</tr>")?;
    for extreme in EXTREMES {
        let mut shown = Vec::new();
        for id in extreme.cases {
            shown.push(match records.iter().find(|record| record.id == *id) {
                None => format!("<span class=shown>{id}: not in this tier</span>"),
                Some(record) => {
                    let holds = record.rows.iter().all(|row| row.pass);
                    let (class, verdict) = if holds { ("pass", "holds") } else { ("miss", "missed") };
                    format!("<a href=\"#{id}\">{id}</a> <span class={class}>{verdict}</span>")
                }
            });
        }
        writeln!(html, "<tr><td>{}<td>{}<td>{}", extreme.id, escape(extreme.tried), escape(extreme.others))?;
        writeln!(html, "<td>{}<td>{}</tr>", escape(extreme.here), shown.join("<br>"))?;
    }
    writeln!(html, "</table>")?;
    Ok(())
}

fn papers(html: &mut String, scripts: &[Found]) -> anyhow::Result<()> {
    writeln!(html, "<h2>Experiments of the papers</h2>")?;
    if scripts.is_empty() {
        writeln!(html, "<p>None in this tier: <code>make validate TIER=nightly</code> runs them.</p>")?;
    }
    for found in scripts {
        writeln!(html, "<h3>{} <small>papers/{}</small></h3><table>", escape(&found.title), escape(&found.name))?;
        writeln!(
            html,
            "<tr><th>case<th>figure<th class=n>value<th class=n>reference<th class=n>tolerance<th>unit<th>"
        )?;
        writeln!(html, "<th class=n>run time<th class=n>particle-steps</tr>")?;
        for row in &found.rows {
            paper_row(html, row)?;
        }
        writeln!(html, "</table>")?;
        for (name, svg) in &found.figures {
            writeln!(html, "<figure aria-label=\"{}\">{}</figure>", escape(name), inline(svg))?;
        }
    }
    Ok(())
}

fn paper_row(html: &mut String, row: &ScriptRow) -> anyhow::Result<()> {
    let optional = |value: Option<f64>| value.map_or_else(String::new, number);
    let bar = row.uncertainty.map_or_else(String::new, |bar| format!(" &plusmn; {bar:.1e}"));
    let class = match row.verdict.as_str() {
        "pass" => "pass",
        "miss" => "miss",
        _ => "shown",
    };
    writeln!(html, "<tr><td>{}<td>{}<td class=n>{}{bar}", escape(&row.id), escape(&row.metric), optional(row.value))?;
    writeln!(html, "<td class=n title=\"{}\">{}", escape(&row.source), optional(row.reference))?;
    let tolerance = row.tolerance.map_or_else(String::new, |tolerance| format!("{tolerance:.1e}"));
    writeln!(html, "<td class=n>{tolerance}<td>{}<td class={class}>{}", escape(&row.unit), escape(&row.verdict))?;
    let wall = row.wall_s.map_or_else(String::new, |wall_s| format!("{wall_s:.0} s"));
    let steps = row.particle_steps.map_or_else(String::new, |steps| format!("{steps:.1e}"));
    writeln!(html, "<td class=n>{wall}<td class=n>{steps}</tr>")?;
    Ok(())
}

fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) { format!("{value:.6}") } else { format!("{value:.4e}") }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// An SVG inside HTML has no prologue.
fn inline(svg: &str) -> &str {
    svg.find("<svg").map_or(svg, |start| &svg[start..])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::registry;
    use crate::report::{Curve, ScriptRow};

    /// Every case of the stability table is one that `validate` has, and every S of it but S5 (towers) and S22 (`faults`)
    /// has a case of its own name.
    #[test]
    fn the_stability_table_names_cases_that_there_are() {
        let ids: Vec<&str> = registry().iter().map(|case| case.id).collect();
        for (k, extreme) in EXTREMES.iter().enumerate() {
            assert_eq!(extreme.id, format!("S{}", k + 1));
            assert!(extreme.cases.iter().all(|id| ids.contains(id)), "{}", extreme.id);
            assert!(["S5", "S22"].contains(&extreme.id) || extreme.cases.contains(&extreme.id), "{}", extreme.id);
        }
    }

    #[test]
    fn a_miss_is_seen_and_text_is_escaped() {
        let row = |metric: &str, value: f64| Row {
            id: "S1".into(),
            metric: metric.into(),
            value,
            reference: 1.0,
            tolerance: 0.5,
            unit: "-".into(),
            pass: (value - 1.0).abs() <= 0.5,
            wall_s: 1.0,
            particle_steps: 7,
        };
        let curve = Curve {
            plot: "error".into(),
            axes: ("time".into(), "error".into()),
            series: "law".into(),
            points: vec![(1.0, 1e-3), (2.0, 1e-4), (3.0, 0.0)],
        };
        let record = Record {
            id: "S1".into(),
            title: "a < b".into(),
            fingerprint: 0,
            rows: vec![row("good", 1.1), row("bad", 2.0)],
            curves: vec![curve],
        };
        let text = r#"{"id": "K1s", "metric": "Z", "value": 8.2, "uncertainty": null, "reference": 8.3, "tolerance": 0.4,
            "unit": "1", "verdict": "pass", "wall_s": 5.0, "particle_steps": 1e6, "source": "seed 000"}"#;
        let rows = vec![serde_json::from_str::<ScriptRow>(text).unwrap()];
        let found = Found { name: "packing".into(), title: "K1s".into(), rows, figures: vec![] };
        let html = page(Tier::Fast, &[record], &[], &[found]).unwrap();
        for expected in ["a &lt; b", "1 missed", "<svg", "8.200000", "<span class=miss>missed</span>"] {
            assert!(html.contains(expected), "{expected} is not in the page");
        }
    }
}
