//! What a window costs over the bus, against the engine alone.

use std::time::Instant;

use anyhow::{Context as _, ensure};
use sturz_client::{Loads, Simulation, Window};
use sturz_engine::Engine;
use sturz_engine::scene::{Scene, SceneDescription};

use crate::cases::Checks;
use crate::faults::Size;
use crate::faults::daemon::{Daemon, Folder};

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
        let (bus_s, state_hash) = over_the_bus(1_000, steps, windows)?;
        let (engine_s, alone) = engine_alone(1_000, steps, windows)?;
        checks.holds(format!("windows of {steps} steps: the engine alone has the same state"), state_hash == alone);
        let name = |what: &str| format!("window of {steps} steps, 1000 particles, {what}");
        checks.shows(name("over the bus"), 1e6 * bus_s, "us");
        checks.shows(name("engine alone"), 1e6 * engine_s, "us");
        checks.shows(name("overhead (wanted: below 150)"), 1e6 * (bus_s - engine_s), "us");
    }
    both_ways(checks, size.of(10_000, 100_000), size.of(2, 20))
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

/// Wall time per window, s, and the state hash at the end.
fn over_the_bus(particles: u32, steps: u32, windows: u32) -> anyhow::Result<(f64, u64)> {
    let (_daemon, simulation, _folder) = served(particles)?;
    let info = simulation.info()?;
    ensure!(info.particles == u64::from(particles), "{} particles", info.particles);
    let loads = loads(info.particles, info.topology_epoch);
    let window = || Window::new(f64::from(steps) * TIME_STEP_S).with_loads(loads.clone());
    let warm_up = windows / 10 + 1;
    for _ in 0..warm_up {
        simulation.advance(window())?;
    }
    let begin = Instant::now();
    for _ in 0..windows {
        simulation.advance(window())?;
    }
    let wall_s = begin.elapsed().as_secs_f64() / f64::from(windows);
    Ok((wall_s, simulation.info()?.state_hash))
}

fn engine_alone(particles: u32, steps: u32, windows: u32) -> anyhow::Result<(f64, u64)> {
    let scene = Scene::validate(SceneDescription::from_toml(&cloud(particles))?)?;
    let mut engine = Engine::new(scene);
    let n = engine.len();
    let loads = sturz_engine::LoadDescription {
        topology_epoch: engine.topology_epoch(),
        ids: (0..n as u64).collect(),
        force_n: vec![[1e-6, 0.0, 0.0]; n],
        drag_n_s_per_m: vec![1e-4; n],
        fluid_velocity_m_per_s: vec![[0.0, 0.1, 0.0]; n],
        ..Default::default()
    };
    let window = |engine: &mut Engine| -> anyhow::Result<()> {
        engine.apply(&sturz_engine::Command::SetLoads(loads.clone()))?;
        for _ in 0..engine.begin_window(f64::from(steps) * TIME_STEP_S)? {
            engine.step()?;
        }
        engine.end_window();
        Ok(())
    };
    // As in the daemon: on one thread, and inside its pool.
    engine.set_threads(1);
    engine.in_pool(|engine| {
        for _ in 0..=windows / 10 {
            window(engine)?;
        }
        let begin = Instant::now();
        for _ in 0..windows {
            window(engine)?;
        }
        Ok((begin.elapsed().as_secs_f64() / f64::from(windows), engine.state_hash()))
    })
}

/// Loads in, state out, of many particles in each window of one step.
fn both_ways(checks: &mut Checks, particles: u32, windows: u32) -> anyhow::Result<()> {
    let (_daemon, simulation, _folder) = served(particles)?;
    let info = simulation.info()?;
    // What a partner has: arrays; making them is its own work.
    let loads = loads(info.particles, info.topology_epoch);
    let columns = ["positions", "orientations", "velocities", "angular_velocities"];
    let mut bytes = 0;
    let begin = Instant::now();
    for _ in 0..windows {
        let window = Window::new(TIME_STEP_S).with_loads(loads.clone()).with_columns(columns);
        let state = simulation.advance(window)?.state.context("the state was asked for")?;
        ensure!(state.len() as u64 == info.particles && state.velocities_m_per_s()?[0][1] > 0.0, "not that state");
        bytes = info.particles * (8 * (1 + 13) + 8 * (1 + 3 + 1 + 3));
    }
    let wall_s = begin.elapsed().as_secs_f64() / f64::from(windows);
    checks.shows(format!("{} particles: loads in, step, state out", info.particles), 1e3 * wall_s, "ms");
    checks.shows("the same", bytes as f64 / wall_s / 1e6, "MB/s");
    Ok(())
}
