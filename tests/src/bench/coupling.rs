//! What a window with a fluid costs, by stage: balls that touch nothing, in a fluid that moves.

use std::time::Instant;

use serde::Serialize;
use sturz_engine::coupling::{FluidDescription, FluidFields, MeshDescription, Side};
use sturz_engine::hydrodynamics::{DragLaw, HydrodynamicLaws};
use sturz_engine::{Command, Engine};

use crate::scene::SceneText;

/// Radius of the balls, m, and their distance over the diameter.
const RADIUS: f64 = 1e-3;
const SPACING: f64 = 1.2;

/// One line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct CouplingCost {
    /// Shape and drag law.
    pub case: &'static str,
    /// Bodies.
    pub particles: usize,
    /// Of the mesh.
    pub cells: usize,
    /// Fields come in: bodies are looked for in the mesh, and the laws are evaluated, ms.
    pub fields_in_ms: f64,
    /// A step without the fluid, ms.
    pub step_ms: f64,
    /// What the fluid adds to a step, ms.
    pub fluid_in_step_ms: f64,
    /// The exchange is made, ms; the next look is paid for by it.
    pub exchange_ms: f64,
}

fn bed(geometry: &str, side: u32, threads: usize) -> anyhow::Result<Engine> {
    let step = 2.0 * RADIUS * SPACING;
    let first = 0.5 * step;
    let mut engine = SceneText::new([0.0; 3], "time_step_s = 1e-6")
        .materials(2500.0, "stiffness_n_per_m = 1e3\nrestitution = 0.5")
        .shape(geometry)
        .section(&format!(
            "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nplacement = {{ method = \"lattice\", origin_m = [{first}, {first}, {first}], \
             spacing_m = [{step}, {step}, {step}], counts = [{side}, {side}, {side}] }}"
        ))
        .start()?;
    engine.set_threads(threads);
    Ok(engine)
}

/// Median of some runs, ms.
fn median(samples: usize, mut run: impl FnMut() -> anyhow::Result<()>) -> anyhow::Result<f64> {
    let mut times = Vec::with_capacity(samples);
    for _ in 0..samples {
        let begin = Instant::now();
        run()?;
        times.push(1e3 * begin.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    Ok(times[samples / 2])
}

/// Costs for `side`^3 bodies on a mesh of cells of two and a half diameters, half-width of the kernel three diameters.
pub fn coupling_costs(side: u32, threads: usize, samples: usize) -> anyhow::Result<Vec<CouplingCost>> {
    let ball = format!("kind = \"sphere\", radius_m = {RADIUS}");
    let cube = "kind = \"box\", size_m = [1.1e-3, 1.1e-3, 1.1e-3]";
    let mut costs = Vec::new();
    for (case, geometry, drag) in [
        ("balls, Schiller and Naumann", ball.as_str(), DragLaw::SchillerNaumann),
        ("balls, Haider and Levenspiel", ball.as_str(), DragLaw::HaiderLevenspiel),
        ("cubes, Hölzer and Sommerfeld", cube, DragLaw::HolzerSommerfeld),
    ] {
        let mut engine = bed(geometry, side, threads)?;
        let size = f64::from(side) * 2.0 * RADIUS * SPACING;
        let count = (size / (5.0 * RADIUS)).ceil() as u32;
        let mesh = MeshDescription::Structured {
            origin_m: [0.0; 3],
            spacing_m: [size / f64::from(count); 3],
            counts: [count; 3],
            sides: [[Side::Closed; 2]; 3],
        };
        let cells = mesh.len();
        let advance = |engine: &mut Engine| -> anyhow::Result<()> {
            engine.in_pool(|engine| (0..10).try_for_each(|_| engine.step()))?;
            Ok(())
        };
        advance(&mut engine)?;
        let step_ms = median(samples, || advance(&mut engine))? / 10.0;
        let laws = HydrodynamicLaws { drag, ..HydrodynamicLaws::default() };
        let fluid = FluidDescription {
            mesh: Some(mesh),
            smoothing_length_m: Some(6.0 * RADIUS),
            laws,
            ..FluidDescription::default()
        };
        engine.apply(&Command::SetFluid { fluid: Some(Box::new(fluid)), fields: None })?;
        let row = [0.05, 0.0, 0.1];
        let fields = FluidFields {
            velocity_m_per_s: vec![row; cells],
            pressure_gradient_pa_per_m: vec![row; cells],
            ..Default::default()
        };
        let give = Command::SetFluidFields(Some(Box::new(fields)));
        let fields_in_ms = median(samples, || Ok(engine.apply(&give).map(drop)?))?;
        let fluid_in_step_ms = median(samples, || advance(&mut engine))? / 10.0 - step_ms;
        let exchange_ms = median(samples, || {
            std::hint::black_box(engine.exchange());
            Ok(())
        })?;
        costs.push(CouplingCost {
            case,
            particles: engine.len(),
            cells,
            fields_in_ms,
            step_ms,
            fluid_in_step_ms,
            exchange_ms,
        });
    }
    Ok(costs)
}
