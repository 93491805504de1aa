//! What a scene does not use must cost nothing: each feature switched off against a scene that never had it.

use std::time::Instant;

use serde::Serialize;
use sturz_engine::fields::{FieldDefinition, FieldQuantity, Grid};
use sturz_engine::scene::{BoundaryGeometry, CohesionDescription, DomainSection, Scene, SceneDescription, Tangential};
use sturz_engine::{Engine, Snapshot};

use super::cache::Bed;
use super::workload::{Softness, Workload};
use crate::scene::steps;

/// How often what is read while running is read, in steps.
const EVERY: u64 = 50;

/// Ratios of the time of a step, each the median of paired blocks, with the quartiles.
#[derive(Clone, Debug, Serialize)]
pub struct LeftOut {
    /// Name of the workload.
    pub workload: String,
    /// What is left out.
    pub feature: &'static str,
    /// Switched off over never there.
    pub off: [f64; 3],
    /// In use over never there: the price.
    pub on: [f64; 3],
    /// Never there over itself: the noise.
    pub noise: [f64; 3],
}

/// One of the scenes of a feature.
#[derive(Clone, Copy)]
struct Variant {
    change: fn(&mut SceneDescription),
    /// Done before the blocks, and every [`EVERY`] steps where `always`.
    read: fn(&mut Engine),
    always: bool,
}

const fn scene(change: fn(&mut SceneDescription)) -> Variant {
    Variant { change, read: |_| {}, always: false }
}

const PLAIN: Variant = scene(|_| {});

const fn once(read: fn(&mut Engine)) -> Variant {
    Variant { read, ..PLAIN }
}

const fn always(read: fn(&mut Engine)) -> Variant {
    Variant { read, always: true, ..PLAIN }
}

struct Feature {
    name: &'static str,
    never: Variant,
    off: Variant,
    on: Variant,
}

fn frictionless(description: &mut SceneDescription) {
    description.material_pairs.iter_mut().for_each(|pair| pair.friction = 0.0);
}

fn without_domain(description: &mut SceneDescription) {
    description.domain = DomainSection::default();
}

fn unused_domain(description: &mut SceneDescription) {
    description.domain =
        DomainSection { min_m: [-1e3; 3], max_m: [1e3; 3], periodic: [false; 3], ..DomainSection::default() };
}

fn cohesive(description: &mut SceneDescription, force_n: f64) {
    let cohesion = CohesionDescription::Constant { force_n };
    description.material_pairs.iter_mut().for_each(|pair| pair.cohesion = Some(cohesion));
}

/// Walls out of reach.
fn far_walls(description: &mut SceneDescription) {
    for k in 0..4 {
        let mut wall = description.boundaries[0].clone();
        wall.name = format!("far {k}");
        wall.geometry = BoundaryGeometry::Plane { point_m: [0.0, 0.0, -1e3 - f64::from(k)], normal: [0.0, 0.0, 1.0] };
        description.boundaries.push(wall);
    }
}

fn report(engine: &mut Engine) {
    std::hint::black_box(engine.report());
}

fn compute_field(engine: &mut Engine) {
    let reach = engine.scene().shapes()[0].bounding_radius();
    let side = 16.0 * reach;
    let grid = Grid { min_m: [0.0; 3], max_m: [side; 3], cells: [4; 3], cylinder: None };
    let quantities = [FieldQuantity::SolidFraction, FieldQuantity::Velocity];
    let definition = FieldDefinition::new("left-out", grid, &quantities, 2.0 * reach);
    engine.compute_field(&FieldDefinition { cutoff_widths: 3.0, ..definition });
}

/// The features that workload can be asked about.
fn features(workload: &Workload) -> Vec<Feature> {
    let friction = scene(|d| {
        frictionless(d);
        d.contact.tangential = Tangential::None;
    });
    let mut features = vec![
        Feature { name: "friction and its history", never: friction, off: scene(frictionless), on: PLAIN },
        Feature { name: "reports", never: PLAIN, off: once(report), on: always(report) },
        Feature {
            name: "states with orientations",
            never: PLAIN,
            off: once(|engine| engine.snapshot(&mut Snapshot::default())),
            on: always(|engine| engine.snapshot(&mut Snapshot::default())),
        },
        Feature { name: "fields", never: PLAIN, off: once(compute_field), on: always(compute_field) },
        Feature { name: "walls out of reach", never: PLAIN, off: scene(far_walls), on: scene(far_walls) },
    ];
    if workload.name == "W1" {
        let held = scene(|d| cohesive(d, 1e-6));
        features.push(Feature { name: "cohesion", never: PLAIN, off: scene(|d| cohesive(d, 0.0)), on: held });
    }
    if !workload.periodic {
        features.push(Feature {
            name: "periodic axes",
            never: scene(without_domain),
            off: scene(unused_domain),
            on: scene(unused_domain),
        });
    }
    features
}

/// An engine of a variant, and how it is run.
struct Run {
    engine: Engine,
    variant: Variant,
}

impl Run {
    fn start(workload: &Workload, bed: &Bed, variant: Variant) -> anyhow::Result<Self> {
        let text = workload.from_bed(bed, Softness::NONE).text();
        let mut description = SceneDescription::from_toml(&text)?;
        (variant.change)(&mut description);
        let mut engine = Engine::new(Scene::validate(description)?);
        (variant.read)(&mut engine);
        Ok(Self { engine, variant })
    }

    /// Seconds of a block of steps.
    fn block(&mut self, length: u64) -> anyhow::Result<f64> {
        let start = Instant::now();
        for _ in 0..length.div_ceil(EVERY) {
            steps(&mut self.engine, EVERY)?;
            if self.variant.always {
                (self.variant.read)(&mut self.engine);
            }
        }
        Ok(start.elapsed().as_secs_f64())
    }
}

/// Times every feature of a workload: never there, switched off, in use, and never there once more, in turns.
pub fn left_out(workload: &Workload, bed: &Bed, rounds: usize, length: u64) -> anyhow::Result<Vec<LeftOut>> {
    features(workload).into_iter().map(|feature| time(workload, bed, &feature, (rounds, length))).collect()
}

fn time(workload: &Workload, bed: &Bed, feature: &Feature, (rounds, length): (usize, u64)) -> anyhow::Result<LeftOut> {
    let variants = [feature.never, feature.off, feature.on, feature.never];
    let mut runs: Vec<Run> =
        variants.into_iter().map(|variant| Run::start(workload, bed, variant)).collect::<Result<_, _>>()?;
    for run in &mut runs {
        run.block(length)?;
    }
    let mut ratios = [const { Vec::new() }; 3];
    for round in 0..rounds {
        let mut seconds = [0.0; 4];
        // every variant has each place in the round equally often
        for k in 0..4 {
            let k = (k + round) % 4;
            seconds[k] = runs[k].block(length)?;
        }
        for (k, ratios) in ratios.iter_mut().enumerate() {
            ratios.push(seconds[k + 1] / seconds[0]);
        }
    }
    let [off, on, noise] = ratios.map(quartiles);
    Ok(LeftOut { workload: workload.name.to_owned(), feature: feature.name, off, on, noise })
}

/// Median, lower and upper quartile.
fn quartiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_unstable_by(f64::total_cmp);
    let at = |part: f64| values[((values.len() - 1) as f64 * part).round() as usize];
    [at(0.5), at(0.25), at(0.75)]
}
