//! From runs to errors, orders, the Pareto front and a recommendation.

use std::collections::BTreeMap;

use serde::Serialize;

use super::Study;
use super::measure::Measure;
use super::plan::{Plan, Reference};
use super::run::{Runs, Sample, Variant, sample};
use super::vary::{Factor, Setting};
use crate::commands::Failure;

/// A phase that no sample has: the golden section is far from all small fractions.
const FRESH_PHASE: f64 = 0.618_033_988_749_894_9;

/// What one setting gave.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// The setting.
    pub setting: Setting,
    /// Why it came to no end; what follows is 0 then.
    pub problem: Option<String>,
    /// Mean over the samples, component by component.
    pub value: Vec<f64>,
    /// Root mean square over the phases; with seeds the distance of the mean from the reference.
    pub error: f64,
    /// Standard error of it, with seeds (that of the reference in it); else half the spread over the phases.
    pub error_bar: f64,
    /// Steps of a run.
    pub steps: u64,
    /// Median over the samples, physics loop alone, s.
    pub wall_s: f64,
    /// Per wall second.
    pub particle_steps_per_s: f64,
    /// No other setting is both faster and better.
    pub on_front: bool,
}

/// How the error changes with the time step or the stiffness, all else equal.
#[derive(Clone, Debug, Serialize)]
pub struct Order {
    /// `time_step` or `stiffness` (with which the time step goes, unless it was given in seconds).
    pub key: &'static str,
    /// The other values.
    pub others: String,
    /// Slope of log error against log time step (stiffness), least squares.
    pub order: f64,
    /// The same between the two smallest steps (largest stiffnesses).
    pub last: f64,
    /// Points that it is taken from.
    pub points: usize,
}

/// The cheapest setting for an error.
#[derive(Clone, Debug, Serialize)]
pub struct Recommendation {
    /// Place in [`Study::points`].
    pub point: usize,
    /// Its values.
    pub label: String,
    /// Error (with its bar) of a run of its own, at a phase or with seeds that no sample had.
    pub confirmed_error: Option<f64>,
    /// Standard error of that.
    pub confirmed_error_bar: f64,
    /// Its wall time, s.
    pub confirmed_wall_s: f64,
    /// Whether that run kept to the wanted error.
    pub confirmed: Option<bool>,
}

/// A mean over samples.
#[derive(Clone, Debug, Default)]
pub struct Mean {
    /// Component by component.
    pub mean: Vec<f64>,
    /// Of the whole, in the measure's distance.
    pub standard_error: f64,
}

/// All of it.
pub struct Judged {
    /// One for each setting.
    pub points: Vec<Point>,
    /// Of each group that differs in the time step only.
    pub orders: Vec<Order>,
    /// Cheapest that reaches the wanted error.
    pub recommendation: Option<Recommendation>,
    /// What the errors are measured from.
    pub reference: Mean,
    /// The same in words.
    pub reference_words: String,
    /// What distances are divided by.
    pub scale: f64,
    /// Unit of the errors.
    pub unit: &'static str,
    /// What must be known.
    pub remarks: Vec<String>,
}

fn mean(values: &[&Vec<f64>], measure: &Measure) -> Mean {
    let n = values.len() as f64;
    let Some(first) = values.first() else { return Mean::default() };
    let same = |value: &&Vec<f64>| value.len() == first.len();
    let mean: Vec<f64> =
        (0..first.len()).map(|k| values.iter().filter(|v| same(v)).map(|v| v[k]).sum::<f64>() / n).collect();
    let squares: f64 = values.iter().map(|value| measure.distance(value, &mean).powi(2)).sum();
    let standard_error = if n > 1.0 { (squares / (n - 1.0) / n).sqrt() } else { 0.0 };
    Mean { mean, standard_error }
}

fn values(samples: &[Sample]) -> Vec<&Vec<f64>> {
    samples.iter().filter_map(|sample| sample.value.as_ref().ok()).collect()
}

/// Turns runs into findings.
pub fn judge(plan: &Plan, settings: &[Setting], runs: &Runs<'_>) -> Result<Judged, Failure> {
    let (reference, reference_words) = reference(plan, settings, runs)?;
    let components = runs.samples.iter().flat_map(|samples| values(samples)).next().map(Vec::len);
    if let Some(n) = components.filter(|&n| n != reference.mean.len()) {
        let given = reference.mean.len();
        return Err(Failure::Usage(format!("--reference has {given} numbers, {} has {n}", plan.measure)));
    }
    let norm = plan.measure.distance(&reference.mean, &vec![0.0; reference.mean.len()]);
    let (scale, unit) = match plan.scale {
        Some(scale) => (scale, "-"),
        None if matches!(plan.measure, Measure::Orientation(_)) => (1.0, "rad"),
        None if plan.measure.is_relative() => (1.0, "-"),
        None if norm > 0.0 => (norm, "-"),
        None => (1.0, "of the measure's own"),
    };
    let mut points: Vec<Point> = settings
        .iter()
        .zip(&runs.samples)
        .map(|(setting, samples)| point(plan, setting, samples, (&reference, scale)))
        .collect();
    mark_front(&mut points);
    let orders = orders(plan, &points);
    let recommendation = recommend(&points, plan.wanted_error);
    let mut remarks = remarks(plan, &points, recommendation.is_some());
    if orders.iter().any(|order| order.key == "time_step" && order.order.abs() < 0.1) {
        remarks.push(
            "where the order in the time step is 0 the error comes from elsewhere: the law, its stiffness, the scene"
                .into(),
        );
    }
    Ok(Judged { points, orders, recommendation, reference, reference_words, scale, unit, remarks })
}

fn reference(plan: &Plan, settings: &[Setting], runs: &Runs<'_>) -> Result<(Mean, String), Failure> {
    match &plan.reference {
        Reference::Value(value) => Ok((Mean { mean: value.clone(), standard_error: 0.0 }, "the value given".into())),
        Reference::Exact => {
            let exact = vec![plan.measure.exact().unwrap_or(0.0)];
            Ok((Mean { mean: exact, standard_error: 0.0 }, "what holds exactly".into()))
        }
        Reference::Finest => {
            if let Some(problem) = &runs.reference_problem {
                return Err(Failure::Usage(problem.clone()));
            }
            if let Some(Err(reason)) = runs.reference.iter().map(|sample| &sample.value).find(|value| value.is_err()) {
                return Err(Failure::Usage(format!("--reference finest: its run {reason}")));
            }
            let finest = plan.finest(settings)?;
            let others = finest.label_without("time_step");
            let words = format!(
                "{}{} at a quarter of the smallest time step, {:.3e} s",
                if plan.seeds { format!("the mean of {} runs", runs.reference.len()) } else { "a run".into() },
                if others.is_empty() { others } else { format!(" of {others}") },
                finest.time_step_s
            );
            Ok((mean(&values(&runs.reference), &plan.measure), words))
        }
    }
}

fn point(plan: &Plan, setting: &Setting, samples: &[Sample], (reference, scale): (&Mean, f64)) -> Point {
    let problem = samples.iter().find_map(|sample| sample.value.as_ref().err().cloned());
    let mut point = Point {
        setting: setting.clone(),
        problem,
        value: Vec::new(),
        error: 0.0,
        error_bar: 0.0,
        steps: 0,
        wall_s: 0.0,
        particle_steps_per_s: 0.0,
        on_front: false,
    };
    if point.problem.is_some() {
        return point;
    }
    let values = values(samples);
    let own = mean(&values, &plan.measure);
    let distances: Vec<f64> =
        values.iter().map(|value| plan.measure.distance(value, &reference.mean) / scale).collect();
    if plan.seeds {
        point.error = plan.measure.distance(&own.mean, &reference.mean) / scale;
        point.error_bar = own.standard_error.hypot(reference.standard_error) / scale;
    } else {
        point.error = (distances.iter().map(|d| d * d).sum::<f64>() / distances.len() as f64).sqrt();
        let largest = distances.iter().fold(0.0f64, |a, &b| a.max(b));
        let smallest = distances.iter().fold(f64::INFINITY, |a, &b| a.min(b));
        point.error_bar = 0.5 * (largest - smallest);
    }
    point.value = own.mean;
    point.steps = samples[0].steps;
    let mut walls: Vec<f64> = samples.iter().map(|sample| sample.wall_s).collect();
    walls.sort_by(f64::total_cmp);
    point.wall_s = walls[walls.len() / 2].max(1e-9);
    point.particle_steps_per_s = samples[0].particle_steps as f64 / point.wall_s;
    point
}

/// Marks the points that no other one beats in both error and wall time.
fn mark_front(points: &mut [Point]) {
    let of = |point: &Point| (point.problem.is_none()).then_some((point.wall_s, point.error));
    let all: Vec<Option<(f64, f64)>> = points.iter().map(of).collect();
    for (point, own) in points.iter_mut().zip(&all) {
        let Some((wall, error)) = *own else { continue };
        let beats = |&(w, e): &(f64, f64)| w <= wall && e <= error && (w < wall || e < error);
        point.on_front = !all.iter().flatten().any(beats);
    }
}

/// Orders are of single motions: the error of a mean does not fall with the step below its bar.
fn orders(plan: &Plan, points: &[Point]) -> Vec<Order> {
    if plan.seeds {
        return Vec::new();
    }
    let step = |point: &Point| Some(point.setting.time_step_s);
    let mut orders = orders_in("time_step", points, step);
    orders.extend(orders_in("stiffness", points, |point| point.setting.number_of("stiffness")));
    orders
}

fn orders_in(key: &'static str, points: &[Point], size: impl Fn(&Point) -> Option<f64>) -> Vec<Order> {
    let mut groups: BTreeMap<String, Vec<(f64, f64)>> = BTreeMap::new();
    let usable = |point: &&Point| point.problem.is_none() && point.error > 1e-13;
    for point in points.iter().filter(usable).filter(|point| point.setting.number_of(key).is_some()) {
        if let Some(size) = size(point) {
            let others = point.setting.label_without(key);
            groups.entry(others).or_default().push((size.ln(), point.error.ln()));
        }
    }
    groups
        .into_iter()
        .filter(|(_, points)| points.len() >= 3)
        .map(|(others, mut points)| {
            // the most accurate end first
            let sign = if key == "time_step" { 1.0 } else { -1.0 };
            points.sort_by(|a, b| (sign * a.0).total_cmp(&(sign * b.0)));
            let last = (points[1].1 - points[0].1) / (points[1].0 - points[0].0);
            Order { key, others, order: slope(&points), last, points: points.len() }
        })
        .collect()
}

/// Least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (x, y) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let sxx: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / sxx
}

/// Cheapest whose error, with its bar, is not above the wanted one.
fn recommend(points: &[Point], wanted: f64) -> Option<Recommendation> {
    let good = |(_, point): &(usize, &Point)| point.problem.is_none() && point.error + point.error_bar <= wanted;
    let cheapest = points.iter().enumerate().filter(good).min_by(|a, b| a.1.wall_s.total_cmp(&b.1.wall_s));
    cheapest.map(|(place, point)| Recommendation {
        point: place,
        label: point.setting.label(),
        confirmed_error: None,
        confirmed_error_bar: 0.0,
        confirmed_wall_s: 0.0,
        confirmed: None,
    })
}

fn remarks(plan: &Plan, points: &[Point], recommended: bool) -> Vec<String> {
    let mut remarks = Vec::new();
    let done: Vec<&Point> = points.iter().filter(|point| point.problem.is_none()).collect();
    if plan.seeds && !done.is_empty() && done.iter().all(|point| point.error <= 2.0 * point.error_bar) {
        remarks.push(
            "every error is within two of its bars: the settings cannot be told apart by runs of this number and length; \
             raise --samples, --time or the averaged span"
                .into(),
        );
    }
    if !recommended {
        let best = done.iter().map(|point| point.error + point.error_bar).fold(f64::INFINITY, f64::min);
        remarks.push(if best.is_finite() {
            format!(
                "no setting reaches the wanted error {:e}; the best, with its bar, is {best:.2e}",
                plan.wanted_error
            )
        } else {
            "no setting came to its end".into()
        });
    }
    let follows =
        |axis: &&super::Axis| axis.key == "time_step" && axis.values.iter().any(|v| matches!(v, Factor::Times(_)));
    if plan.axes.iter().any(|axis| axis.key == "stiffness")
        && plan.axes.iter().all(|axis| axis.key != "time_step" || follows(&axis))
    {
        remarks.push("the time step follows the stiffness: it keeps its part of the critical one".into());
    }
    if plan.samples < 4 {
        remarks.push("wall times are medians of fewer than four runs".into());
    }
    remarks
}

/// Runs the recommended setting once more, at a phase (or with as many seeds) that no sample had.
pub fn confirm(plan: &Plan, settings: &[Setting], study: &mut Study, progress: &mut impl FnMut(&str, usize)) {
    let Some(recommendation) = &mut study.recommendation else { return };
    let setting = &settings[recommendation.point];
    let n = if plan.seeds { plan.samples } else { 1 };
    let samples: Vec<Sample> = (0..n)
        .map(|k| {
            progress(&format!("again: {}", setting.label()), n - k);
            let fresh = plan.samples + k;
            sample(setting, plan, if plan.seeds { Variant::Seed(fresh as u64) } else { Variant::Phase(FRESH_PHASE) })
        })
        .collect();
    let reference = Mean { mean: study.reference_value.clone(), standard_error: study.reference_standard_error };
    let again = point(plan, setting, &samples, (&reference, study.scale));
    if let Some(problem) = again.problem {
        study.remarks.push(format!("the recommended setting did not come to its end when it was run again: {problem}"));
        recommendation.confirmed = Some(false);
        return;
    }
    recommendation.confirmed_error = Some(again.error);
    recommendation.confirmed_error_bar = if plan.seeds { again.error_bar } else { 0.0 };
    recommendation.confirmed_wall_s = again.wall_s;
    // a mean may miss by its own bar: what is asked of it is that it does not contradict the recommendation
    let allowed = plan.wanted_error + recommendation.confirmed_error_bar;
    recommendation.confirmed = Some(again.error <= allowed);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(wall_s: f64, error: f64) -> Point {
        Point {
            setting: Setting { values: vec![], threads: 1, scene: Err(String::new()), time_step_s: 1.0 },
            problem: None,
            value: vec![],
            error,
            error_bar: 0.0,
            steps: 1,
            wall_s,
            particle_steps_per_s: 1.0,
            on_front: false,
        }
    }

    #[test]
    fn the_front_holds_what_nothing_beats_and_the_cheapest_good_one_is_recommended() {
        let mut points = vec![named(1.0, 0.1), named(2.0, 0.01), named(3.0, 0.02), named(4.0, 0.001)];
        points.push(Point { problem: Some("refused".into()), ..named(0.0, 0.0) });
        mark_front(&mut points);
        assert_eq!(points.iter().map(|p| p.on_front).collect::<Vec<_>>(), [true, true, false, true, false]);
        assert_eq!(recommend(&points, 0.03).unwrap().point, 1);
        assert!(recommend(&points, 1e-4).is_none());
        points[1].error_bar = 0.05;
        assert_eq!(recommend(&points, 0.03).unwrap().point, 2);
    }

    #[test]
    fn the_slope_of_a_power_is_its_exponent() {
        let points: Vec<(f64, f64)> = [1.0, 2.0, 4.0, 8.0].map(|h: f64| (h.ln(), (3.0 * h * h).ln())).into();
        assert!((slope(&points) - 2.0).abs() < 1e-12);
    }

    /// The standard error of the mean of 0, 1, 2, 3: variance 5/3 over 4.
    #[test]
    fn means_have_their_standard_error() {
        let values: Vec<Vec<f64>> = (0..4).map(|k| vec![f64::from(k)]).collect();
        let mean = mean(&values.iter().collect::<Vec<_>>(), &Measure::KineticEnergy);
        assert_eq!(mean.mean, [1.5]);
        assert!((mean.standard_error - (5.0f64 / 12.0).sqrt()).abs() < 1e-15);
    }
}
