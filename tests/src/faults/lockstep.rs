//! What a window costs over the bus, against the engine alone.

use std::time::Instant;

use anyhow::{Context as _, ensure};
use sturz_client::{Loads, Simulation, Window};
use sturz_engine::Engine;
use sturz_engine::scene::{Scene, SceneDescription};

use crate::cases::Checks;
use crate::faults::Size;
use crate::faults::daemon::{Daemon, Folder, own_cpu_s};

const TIME_STEP_S: f64 = 1e-5;

/// So many balls in free fall, apart from each other: the step itself costs next to nothing.
fn cloud(particles: u32) -> String {
    let side = f64::from(particles).cbrt().ceil() as u32;
    let mut text = String::from(
        "[scene]\nname = \"cloud\"\ngravity_m_per_s2 = [0.0, 0.0, -9.81]\ntime_step_s = 1e-5\nseed = 1\n\
         [[material]]\nname = \"glass\"\ndensity_kg_per_m3 = 2500.0\n\
         [[material_pair]]\nmaterials = [\"glass\", \"glass\"]\nstiffness_n_per_m = 1e4\nrestitution = 0.5\n\
         [[shape]]\nname = \"bead\"\ngeometry = { kind = \"sphere\", radius_m = 1e-3 }\n[[insertion]]\nshape = \"bead\"\nmaterial = \"glass\"\n",
    );
    text += &format!(
        "placement = {{ method = \"lattice\", origin_m = [0.0, 0.0, 0.0], spacing_m = [0.003, 0.003, 0.003], counts = [{side}, {side}, {}] }}\n",
        particles.div_ceil(side * side)
    );
    text
}

/// Overhead of windows of 1 and of 100 steps with loads of 1,000 particles; 100,000 particles both ways.
pub fn check(checks: &mut Checks, size: Size) -> anyhow::Result<()> {
    for (steps, windows) in [(1, size.of(20, 4_000)), (100, size.of(5, 200))] {
        let pairs = Pairs::measure(1_000, steps, windows)?;
        checks.holds(format!("windows of {steps} steps: the engine alone has the same state"), pairs.is_same_state);
        let name = |what: &str| format!("window of {steps} steps, 1000 particles, {what}");
        checks.shows(name("over the bus, median"), 1e6 * part(&pairs.bus_s, 0.5), "us");
        checks.shows(name("engine alone, median"), 1e6 * part(&pairs.engine_s, 0.5), "us");
        let overhead: Vec<f64> = pairs.bus_s.iter().zip(&pairs.engine_s).map(|(bus, engine)| bus - engine).collect();
        checks.shows(name("overhead, median of pairs (wanted: below 150)"), 1e6 * part(&overhead, 0.5), "us");
        let mean = overhead.iter().sum::<f64>() / overhead.len() as f64;
        checks.shows(name("overhead, mean of pairs"), 1e6 * mean, "us");
        checks.shows(name("overhead, tenth part of pairs below"), 1e6 * part(&overhead, 0.1), "us");
        checks.shows(
            name("a question and its answer without the physics, median"),
            1e6 * part(&pairs.question_s, 0.5),
            "us",
        );
        checks.shows(name("CPU time of client and daemon above the engine's"), 1e6 * pairs.cpu_s, "us");
    }
    both_ways(checks, size.of(10_000, 100_000), size.of(2, 20))
}

/// The value that this part of them lies below.
fn part(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[((sorted.len() - 1) as f64 * part) as usize]
}

fn loads(particles: u64, epoch: u64) -> Loads {
    let n = particles as usize;
    Loads {
        topology_epoch: epoch,
        ids: (0..particles).collect(),
        force_n: vec![[1e-6, 0.0, 0.0]; n],
        drag_n_s_per_m: vec![1e-4; n],
        fluid_velocity_m_per_s: vec![[0.0, 0.1, 0.0]; n],
        ..Loads::default()
    }
}

/// A daemon with a journal that serves such a cloud.
pub fn served(particles: u32) -> anyhow::Result<(Daemon, Simulation, Folder)> {
    let folder = Folder::new("lockstep")?;
    let scene = folder.join("scene.toml");
    std::fs::write(&scene, cloud(particles))?;
    let journal = folder.join("journal");
    let daemon = Daemon::serve([&*scene, "--name", "lockstep", "--paused", "--journal", &journal])?;
    let simulation = daemon.connect()?;
    Ok((daemon, simulation, folder))
}

/// The same windows over the bus and in the engine alone, in turn: what else the machine does meets both.
struct Pairs {
    /// Wall time of each, s.
    bus_s: Vec<f64>,
    /// Of each, s.
    engine_s: Vec<f64>,
    /// Of a question and its answer, both small: what the bus alone costs.
    question_s: Vec<f64>,
    /// Of client and daemon for a window over the bus, without that of the window in the engine alone, s.
    cpu_s: f64,
    /// The last state is the same.
    is_same_state: bool,
}

impl Pairs {
    fn measure(particles: u32, steps: u32, windows: u32) -> anyhow::Result<Self> {
        let (daemon, simulation, _folder) = served(particles)?;
        let info = simulation.info()?;
        ensure!(info.particles == u64::from(particles), "{} particles", info.particles);
        let loads = loads(info.particles, info.topology_epoch);
        let length_s = f64::from(steps) * TIME_STEP_S;
        let over_the_bus = || -> anyhow::Result<f64> {
            let begin = Instant::now();
            simulation.advance(Window::new(length_s).with_loads(loads.clone()))?;
            Ok(begin.elapsed().as_secs_f64())
        };
        let scene = Scene::validate(SceneDescription::from_toml(&cloud(particles))?)?;
        let mut engine = Engine::new(scene);
        let command = sturz_engine::Command::SetLoads(description(&loads));
        // As in the daemon: on one thread, and inside its pool.
        engine.set_threads(1);
        engine.in_pool(|engine| {
            let mut alone = || -> anyhow::Result<f64> {
                let begin = Instant::now();
                engine.apply(&command)?;
                for _ in 0..engine.begin_window(length_s)? {
                    engine.step()?;
                }
                engine.end_window();
                Ok(begin.elapsed().as_secs_f64())
            };
            for _ in 0..=windows / 10 {
                over_the_bus()?;
                alone()?;
            }
            let (mut bus_s, mut engine_s, mut question_s) = (Vec::new(), Vec::new(), Vec::new());
            let cpu_before_s = own_cpu_s()? + daemon.cpu_s()?;
            for _ in 0..windows {
                bus_s.push(over_the_bus()?);
                engine_s.push(alone()?);
            }
            let cpu_s = own_cpu_s()? + daemon.cpu_s()? - cpu_before_s;
            // Twice the engine's own: once here, once in the daemon.
            let cpu_s = cpu_s / f64::from(windows) - 2.0 * part(&engine_s, 0.5);
            for _ in 0..windows {
                let begin = Instant::now();
                simulation.plan()?;
                question_s.push(begin.elapsed().as_secs_f64());
            }
            let is_same_state = simulation.info()?.state_hash == engine.state_hash();
            Ok(Self { bus_s, engine_s, question_s, cpu_s, is_same_state })
        })
    }
}

fn description(loads: &Loads) -> sturz_engine::LoadDescription {
    sturz_engine::LoadDescription {
        topology_epoch: loads.topology_epoch,
        ids: loads.ids.clone(),
        force_n: loads.force_n.clone(),
        drag_n_s_per_m: loads.drag_n_s_per_m.clone(),
        fluid_velocity_m_per_s: loads.fluid_velocity_m_per_s.clone(),
        ..Default::default()
    }
}

/// Loads in, state out, of many particles in each window of one step.
fn both_ways(checks: &mut Checks, particles: u32, windows: u32) -> anyhow::Result<()> {
    let (_daemon, simulation, _folder) = served(particles)?;
    let info = simulation.info()?;
    // What a partner has: arrays; making them is its own work.
    let loads = loads(info.particles, info.topology_epoch);
    let columns = ["positions", "orientations", "velocities", "angular_velocities"];
    let mut walls_s = Vec::new();
    for _ in 0..windows {
        let window = Window::new(TIME_STEP_S).with_loads(loads.clone()).with_columns(columns);
        let begin = Instant::now();
        let state = simulation.advance(window)?.state.context("the state was asked for")?;
        walls_s.push(begin.elapsed().as_secs_f64());
        ensure!(state.len() as u64 == info.particles && state.velocities_m_per_s()?[0][1] > 0.0, "not that state");
    }
    let (bytes, wall_s) = (info.particles * (8 * (1 + 13) + 8 * (1 + 3 + 1 + 3)), part(&walls_s, 0.5));
    checks.shows(format!("{} particles: loads in, step, state out, median", info.particles), 1e3 * wall_s, "ms");
    checks.shows("the same", bytes as f64 / wall_s / 1e6, "MB/s");
    Ok(())
}
