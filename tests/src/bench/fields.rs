//! What a sample of a field costs: balls that touch on a lattice.

use std::time::Instant;

use serde::Serialize;
use sturz_engine::Engine;
use sturz_engine::fields::{FieldDefinition, FieldQuantity as Q, Grid};

use crate::scene::SceneText;

/// Radius of the balls, m, and their distance over the diameter: each touches six.
const RADIUS: f64 = 1e-3;
const SPACING: f64 = 0.999;

/// One line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct FieldCost {
    /// What is sampled.
    pub field: &'static str,
    /// Balls.
    pub particles: usize,
    /// Of the grid.
    pub cells: u32,
    /// Median of the samples, ms.
    pub ms: f64,
}

fn bed(side: u32, threads: usize) -> anyhow::Result<Engine> {
    let step = 2.0 * RADIUS * SPACING;
    let mut engine = SceneText::new([0.0; 3], "time_step_s = 1e-6")
        .materials(2500.0, "stiffness_n_per_m = 1e3\nrestitution = 0.5")
        .shape(&format!("kind = \"sphere\", radius_m = {RADIUS}"))
        .section(&format!(
            "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nplacement = {{ method = \"lattice\", origin_m = [0.0, 0.0, 0.0], \
             spacing_m = [{step}, {step}, {step}], counts = [{side}, {side}, {side}] }}"
        ))
        .start()?;
    engine.set_threads(threads);
    Ok(engine)
}

const FLOW: [Q; 3] = [Q::SolidFraction, Q::Velocity, Q::GranularTemperature];
const SCALE_FREE: [Q; 3] = [Q::KineticStress, Q::KineticStressScaleFree, Q::ShearRate];

/// Name, cells, quantities, further widths over the radius.
type Asked = (&'static str, [u32; 3], &'static [Q], &'static [f64]);

/// Costs of some fields of `side`^3 balls, each the median of `samples`.
pub fn field_costs(side: u32, threads: usize, samples: usize) -> anyhow::Result<Vec<FieldCost>> {
    let mut engine = bed(side, threads)?;
    let size = f64::from(side) * 2.0 * RADIUS * SPACING;
    let fields: [Asked; 7] = [
        ("profile: flow", [1, 1, 50], &FLOW, &[]),
        ("profile: T^k", [1, 1, 50], &SCALE_FREE, &[]),
        ("profile: contact stress", [1, 1, 50], &[Q::ContactStress], &[]),
        (
            "profile: all of these, 4 widths",
            [1, 1, 50],
            &[Q::Stress, Q::KineticStressScaleFree, Q::Velocity],
            &[1.5, 2.0, 2.5],
        ),
        ("profile: solid fraction of shapes", [1, 1, 50], &[Q::SolidFractionOfShapes], &[]),
        ("volume: flow", [side, side, side], &FLOW, &[]),
        ("volume: contact stress", [side, side, side], &[Q::ContactStress], &[]),
    ];
    let mut costs = Vec::new();
    for (field, cells, quantities, more) in fields {
        let grid = Grid { min_m: [-RADIUS; 3], max_m: [size - RADIUS; 3], cells, cylinder: None };
        let definition = FieldDefinition {
            more_widths_m: more.iter().map(|width| width * RADIUS).collect(),
            ..FieldDefinition::new("cost", grid, quantities, RADIUS)
        };
        let mut times: Vec<f64> = (0..samples)
            .map(|_| {
                let begin = Instant::now();
                std::hint::black_box(engine.compute_field(&definition));
                1e3 * begin.elapsed().as_secs_f64()
            })
            .collect();
        times.sort_by(f64::total_cmp);
        let cells = cells.iter().product();
        costs.push(FieldCost { field, particles: engine.len(), cells, ms: times[samples / 2] });
    }
    Ok(costs)
}
