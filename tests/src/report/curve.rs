//! Curves that cases leave for the report, and how they are drawn: log-log, as SVG.

use std::ops::Range;

use plotters::prelude::*;
use serde::{Deserialize, Serialize};

/// A line of a plot, for positive numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Title of the plot: curves of one title share it.
    pub plot: String,
    /// What the axes are, with units.
    pub axes: (String, String),
    /// Name of this line.
    pub series: String,
    /// (x, y)
    pub points: Vec<(f64, f64)>,
}

const SIZE: (u32, u32) = (560, 400);
const COLOURS: [RGBColor; 8] = [
    RGBColor(61, 79, 150),
    RGBColor(200, 85, 61),
    RGBColor(63, 176, 172),
    RGBColor(224, 160, 48),
    RGBColor(122, 79, 154),
    RGBColor(95, 127, 63),
    RGBColor(34, 48, 60),
    RGBColor(150, 150, 150),
];

/// One plot for each title, in the order of first use: (title, SVG).
pub fn draw_all(curves: &[Curve]) -> anyhow::Result<Vec<(String, String)>> {
    let mut titles: Vec<&str> = Vec::new();
    curves.iter().for_each(|curve| {
        if !titles.contains(&curve.plot.as_str()) {
            titles.push(&curve.plot);
        }
    });
    let mut plots = Vec::new();
    for title in titles {
        let own: Vec<&Curve> = curves.iter().filter(|curve| curve.plot == title).collect();
        if own.iter().any(|curve| curve.points.iter().any(drawable)) {
            plots.push((title.to_owned(), draw(&own)?));
        }
    }
    Ok(plots)
}

/// Logarithms want positive numbers; an error of exactly 0 has no place.
fn drawable((x, y): &(f64, f64)) -> bool {
    *x > 0.0 && *y > 0.0 && x.is_finite() && y.is_finite()
}

fn draw(curves: &[&Curve]) -> anyhow::Result<String> {
    let points = || curves.iter().flat_map(|curve| &curve.points).copied().filter(drawable);
    let (x, y) = (decades(points().map(|p| p.0)), decades(points().map(|p| p.1)));
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        let mut chart = ChartBuilder::on(&root)
            .caption(&curves[0].plot, ("sans-serif", 15))
            .margin(10)
            .x_label_area_size(40)
            .y_label_area_size(64)
            .build_cartesian_2d(x.log_scale(), y.log_scale())?;
        let number = |value: &f64| format!("{value:.0e}");
        chart
            .configure_mesh()
            .x_desc(&curves[0].axes.0)
            .y_desc(&curves[0].axes.1)
            .x_label_formatter(&number)
            .y_label_formatter(&number)
            .light_line_style(TRANSPARENT)
            .draw()?;
        for (k, curve) in curves.iter().enumerate() {
            let colour = COLOURS[k % COLOURS.len()];
            let points: Vec<(f64, f64)> = curve.points.iter().copied().filter(drawable).collect();
            chart
                .draw_series(LineSeries::new(points.clone(), colour.stroke_width(2)))?
                .label(&curve.series)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
            chart.draw_series(points.into_iter().map(|point| Circle::new(point, 3, colour.filled())))?;
        }
        if curves.len() > 1 {
            let corner = if rises(curves) { SeriesLabelPosition::LowerRight } else { SeriesLabelPosition::LowerLeft };
            let labels = &mut chart.configure_series_labels();
            labels.position(corner).background_style(WHITE.mix(0.8)).label_font(("sans-serif", 11)).draw()?;
        }
        root.present()?;
    }
    Ok(text)
}

/// Whether lines go up to the right: the lower left is taken then.
fn rises(curves: &[&Curve]) -> bool {
    let ends = curves.iter().filter_map(|curve| {
        let by_x = |a: &&(f64, f64), b: &&(f64, f64)| a.0.total_cmp(&b.0);
        let points = || curve.points.iter().filter(|point| drawable(point));
        Some((points().min_by(by_x)?.1, points().max_by(by_x)?.1))
    });
    ends.map(|(first, last)| (last / first).ln()).sum::<f64>() > 0.0
}

/// Whole decades around the values, one at least.
fn decades(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
    let (low, high) = ((0.8 * low).log10().floor(), (1.25 * high).log10().ceil());
    10f64.powf(low)..10f64.powf(high.max(low + 1.0))
}
