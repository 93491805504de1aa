//! Error against wall time, log-log, as SVG.

use std::ops::Range;

use plotters::prelude::*;

use super::{Point, Study};

const SIZE: (u32, u32) = (760, 520);
/// Of the labels, pixels, on average.
const CHARACTER_WIDTH: f64 = 5.2;
/// With more points only those on the front are labelled.
const MOST_LABELS: usize = 12;

/// The plot; points with error 0 are drawn at the lower edge. None without a run that came to its end.
pub fn svg(study: &Study) -> anyhow::Result<Option<String>> {
    let done: Vec<&Point> = study.points.iter().filter(|point| point.problem.is_none()).collect();
    if done.is_empty() {
        return Ok(None);
    }
    let floor = done.iter().map(|p| p.error).filter(|&e| e > 0.0).fold(f64::INFINITY, f64::min).min(study.wanted_error);
    let error = |point: &Point| point.error.max(0.3 * floor);
    let x = decades(done.iter().map(|point| point.wall_s));
    let y = decades(done.iter().map(|point| error(point)).chain([study.wanted_error]));
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let caption = format!("{}: {}", study.scene, study.measure);
        let mut chart = ChartBuilder::on(&root)
            .caption(caption, ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(72)
            .build_cartesian_2d(x.clone().log_scale(), y.clone().log_scale())?;
        let number = |value: &f64| format!("{value:.0e}");
        chart
            .configure_mesh()
            .x_desc("wall time of the physics loop, s")
            .y_desc(format!("error, {}", study.error_unit))
            .x_label_formatter(&number)
            .y_label_formatter(&number)
            .light_line_style(WHITE)
            .draw()?;
        let wanted = [(x.start, study.wanted_error), (x.end, study.wanted_error)];
        chart.draw_series(DashedLineSeries::new(wanted, 6, 4, BLACK.mix(0.6).stroke_width(1)))?;
        let mut front: Vec<(f64, f64)> =
            done.iter().filter(|point| point.on_front).map(|point| (point.wall_s, error(point))).collect();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        chart.draw_series(LineSeries::new(front, BLUE.mix(0.7).stroke_width(2)))?;
        for point in &done {
            let at = (point.wall_s, error(point));
            let (low, high) = ((at.1 - point.error_bar).max(y.start), at.1 + point.error_bar);
            chart.draw_series(LineSeries::new([(at.0, low), (at.0, high)], BLACK.mix(0.5)))?;
            let colour = if point.on_front { BLUE } else { RGBColor(150, 150, 150) };
            chart.draw_series([Circle::new(at, 4, colour.filled())])?;
            if point.on_front || done.len() <= MOST_LABELS {
                let label = point.setting.label();
                // to the left of points in the right half
                let left = at.0.ln() > 0.5 * (x.start.ln() + x.end.ln());
                let shift = if left { -8 - (label.len() as f64 * CHARACTER_WIDTH) as i32 } else { 8 };
                let text = Text::new(label, (shift, -6), ("sans-serif", 11).into_font());
                chart.draw_series([EmptyElement::at(at) + text])?;
            }
        }
        if let Some(found) = &study.recommendation {
            let point = &study.points[found.point];
            chart.draw_series([Circle::new((point.wall_s, error(point)), 8, RED.stroke_width(2))])?;
        }
        root.present()?;
    }
    Ok(Some(text))
}

/// Whole decades around the values, one at least.
fn decades(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
    let (low, high) = ((0.8 * low).log10().floor(), (1.25 * high).log10().ceil());
    10f64.powf(low)..10f64.powf(high.max(low + 1.0))
}
