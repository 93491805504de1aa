//! What decoders act upon: a small scene with something of everything, an engine and a daemon's physics without a bus.

use std::cell::RefCell;
use std::sync::Arc;

use sturz_engine::scene::{Scene, SceneDescription};
use sturz_engine::{Command, Engine, FluidDescription, LoadDescription, MeshDescription};
use sturz_service::config::Limits;
use sturz_service::mailbox::mailbox;
use sturz_service::outbox::Outbox;
use sturz_service::runner::Runner;
use tokio::sync::mpsc;

/// A servo presses balls, cubes and a composite onto a floor inside of a turning drum, in a cell that is periodic along y.
pub const SCENE: &str = r#"
[scene]
name = "small"
gravity_m_per_s2 = [0.1, 0.0, -9.81]
time_step_s = 1e-5
seed = 4
[domain]
min_m = [0.0, -0.02, 0.0]
max_m = [0.0, 0.02, 0.0]
periodic = [false, true, false]
[contact]
normal = "linear"
[[material]]
name = "glass"
density_kg_per_m3 = 2500.0
[[material_pair]]
materials = ["glass", "glass"]
stiffness_n_per_m = 1e3
restitution = 0.5
friction = 0.4
rolling_friction = 0.1
[[shape]]
name = "bead"
geometry = { kind = "sphere", radius_m = 2e-3 }
[[shape]]
name = "cube"
geometry = { kind = "cube", edge_m = 4e-3 }
[[shape]]
name = "rod"
geometry = { kind = "spherocylinder", radius_m = 1e-3, total_length_m = 5e-3 }
[[boundary]]
name = "drum"
material = "glass"
geometry = { kind = "cylinder_inside", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], radius_m = 0.02 }
motion = { kind = "rotation", point_m = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], angular_velocity = { kind = "constant", rad_per_s = 5.0 } }
[[boundary]]
name = "lid"
material = "glass"
geometry = { kind = "plane", point_m = [0.0, 0.0, 4e-3], normal = [0.0, 0.0, -1.0] }
motion = { kind = "servo", direction = [0.0, 0.0, -1.0], force_n = 0.01, gain_m_per_s_per_n = 1e-3, max_velocity_m_per_s = 0.02 }
[[insertion]]
shape = "bead"
material = "glass"
placement = { method = "poses", positions_m = [[0.0, 0.0, -0.0179], [0.0039, 0.0, -0.0175], [0.0, 0.006, 0.0015]] }
[[insertion]]
shape = "cube"
material = "glass"
placement = { method = "poses", positions_m = [[0.0, -0.008, -0.017], [0.0, -0.008, -0.0131]] }
[[insertion]]
shape = "rod"
material = "glass"
placement = { method = "poses", positions_m = [[-0.006, 0.0, -0.0145]] }
[[field]]
name = "density"
quantities = ["density", "velocity"]
grid = { min_m = [-0.02, -0.02, -0.02], max_m = [0.02, 0.02, 0.02], cells = [4, 4, 4] }
width_m = 5e-3
"#;

/// Pairs that a step may list: memory for a thousand particles on one spot.
const MOST_PAIRS: usize = 500_000;

/// What a daemon lets a stranger do, on a small scale.
pub fn limits() -> Limits {
    Limits {
        message_bytes: 1 << 16,
        insertion_particles: 100,
        particles: 200,
        remembered_requests: 16,
        fields: 4,
        field_cells: 1_000,
        checkpoints: 2,
        checkpoint_bytes: 1 << 20,
        ..Limits::default()
    }
}

fn new_engine() -> Engine {
    let described = SceneDescription::from_toml(SCENE).unwrap_or_else(|problem| panic!("{problem}"));
    new_engine_of(Scene::validate(described).unwrap_or_else(|problem| panic!("{problem}")))
}

/// On one thread, and in bounded memory.
pub fn new_engine_of(scene: Scene) -> Engine {
    let mut engine = Engine::new(scene);
    engine.set_threads(1);
    engine.set_most_pairs(MOST_PAIRS);
    engine
}

/// An engine in the midst of a run: contacts with springs, loads, a window under way.
pub fn engine_under_way() -> anyhow::Result<Engine> {
    let mut engine = new_engine();
    let loads = LoadDescription {
        topology_epoch: engine.topology_epoch(),
        ids: vec![0, 3],
        force_n: vec![[1e-4, 0.0, 0.0]; 2],
        drag_n_s_per_m: vec![1e-3; 2],
        ramp_s: 1e-2,
        ..Default::default()
    };
    engine.apply(&Command::SetLoads(loads))?;
    let mesh = MeshDescription::Structured {
        origin_m: [-0.05, -0.05, -0.05],
        spacing_m: [0.05; 3],
        counts: [2; 3],
        sides: Default::default(),
    };
    let fluid = FluidDescription { mesh: Some(mesh), smoothing_length_m: Some(0.04), ..Default::default() };
    engine.apply(&Command::SetFluid { fluid: Some(Box::new(fluid)), fields: None })?;
    for _ in 0..200 {
        engine.step()?;
    }
    engine.begin_window(1.05e-4)?;
    for _ in 0..5 {
        engine.step()?;
    }
    Ok(engine)
}

thread_local! {
    /// One engine for all inputs, and the state that it begins each with.
    static WORLD: RefCell<(Engine, Vec<u8>)> = RefCell::new({
        let mut engine = new_engine();
        for _ in 0..100 {
            engine.step().unwrap_or_else(|failure| panic!("{failure}"));
        }
        let saved = engine.checkpoint().unwrap_or_else(|failure| panic!("{failure}"));
        (engine, saved)
    });
}

/// Lets an engine be used that is always in the same state.
pub fn with_engine<R>(use_it: impl FnOnce(&mut Engine) -> R) -> R {
    WORLD.with_borrow_mut(|(engine, saved)| {
        engine.restore(saved).unwrap_or_else(|failure| panic!("the world {failure}"));
        use_it(engine)
    })
}

/// Lets a daemon's physics be used, without a bus.
pub fn with_runner<R>(use_it: impl FnOnce(&mut Runner<'_>) -> R) -> R {
    with_engine(|engine| {
        let (_letters, inbox) = mailbox(1);
        // Nobody reads them; they are all kept.
        let (notices, _heard) = mpsc::channel(64);
        let outbox = Outbox::new(&engine.scene().description().output, notices);
        use_it(&mut Runner::new(engine, inbox, outbox, Arc::default(), limits()))
    })
}
