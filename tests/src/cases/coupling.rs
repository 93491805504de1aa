//! CFD1, CFD4 and CFD5: the exchange with a fluid and the laws inside the step, without a bus. The fluids here are of one
//! cell, so that the coupled run has a closed form or an ordinary differential equation to be compared with.
//!
//! Terminal speeds: Haider and Levenspiel, Powder Technol. 58 (1989) 63, with the numbers of PHYSICS.md I20.

use std::f64::consts::PI;

use anyhow::Context as _;
use sturz_engine::coupling::{Exchange, FluidDescription, FluidFields, MeshDescription, Side};
use sturz_engine::hydrodynamics::{
    DragLaw, Flow, HydroShape, HydrodynamicLaws, LiftLaw, PitchingLaw, RotationalDragLaw, VoidageLaw, response,
};
use sturz_engine::math::{Mat3, Vec3};
use sturz_engine::{Command, Engine, Snapshot};

use super::{Case, Checks};
use crate::scene::{SceneText, snapshot as now};

pub fn cases() -> Vec<Case> {
    vec![
        Case::fast("CFD1", "settling: terminal speeds, orientation, and order in the window", settling),
        Case::fast(
            "CFD4",
            "what particles and fluid exchange is conserved, smooth, and the same on two grids",
            exchange,
        ),
        Case::fast("CFD5", "a light particle in a dense fluid: explicit diverges, iterated does not", light_particle),
    ]
}

const WATER: f64 = 1000.0;
const VISCOSITY: f64 = 1e-3;
const GRAVITY: f64 = 9.81;

fn fluid(laws: HydrodynamicLaws) -> FluidDescription {
    FluidDescription {
        density_kg_per_m3: WATER,
        viscosity_pa_s: VISCOSITY,
        buoyancy: true,
        laws,
        ..FluidDescription::default()
    }
}

fn laws(drag: DragLaw) -> HydrodynamicLaws {
    HydrodynamicLaws { drag, voidage: VoidageLaw::None, ..HydrodynamicLaws::default() }
}

/// One body that touches nothing.
fn body(geometry: &str, density: f64, gravity: f64, time_step_s: f64, orientation: &str) -> anyhow::Result<Engine> {
    let placement = format!("method = \"poses\", positions_m = [[0.0, 0.0, 0.0]]{orientation}");
    let scene = SceneText::new([0.0, 0.0, -gravity], "")
        .time_step_s(time_step_s)
        .materials(density, "stiffness_n_per_m = 1e-9\nrestitution = 0.5")
        .shape(geometry)
        .section(&format!("[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nplacement = {{ {placement} }}"));
    Ok(Engine::new(scene.validate()?))
}

fn put(engine: &mut Engine, fluid: FluidDescription) -> anyhow::Result<()> {
    engine.apply(&Command::SetFluid { fluid: Some(Box::new(fluid)), fields: None })?;
    Ok(())
}

fn give(engine: &mut Engine, fields: FluidFields) -> anyhow::Result<()> {
    engine.apply(&Command::SetFluidFields(Some(Box::new(fields))))?;
    Ok(())
}

fn taken(engine: &mut Engine) -> anyhow::Result<Exchange> {
    engine.exchange().context("there is a fluid with a mesh")
}

/// The flow past a body at rest in still water of a void fraction of 1.
fn flow(relative_velocity: Vec3, relative_angular_velocity: Vec3) -> Flow {
    Flow {
        relative_velocity,
        relative_angular_velocity,
        vorticity: Vec3::zeros(),
        void_fraction: 1.0,
        density: WATER,
        viscosity: VISCOSITY,
    }
}

fn settling(checks: &mut Checks) -> anyhow::Result<()> {
    terminal_speeds(checks)?;
    tumbling(checks)?;
    orders_in_the_window(checks)
}

/// Spheres against the six digits of PHYSICS.md I20, other bodies against the balance of weight and drag of the same law, by bisection.
fn terminal_speeds(checks: &mut Checks) -> anyhow::Result<()> {
    for (millimetres, wanted) in
        [(0.05, 1.96449e-3), (0.1, 7.13811e-3), (0.5, 7.21326e-2), (1.0, 0.146517), (2.0, 0.268748)]
    {
        let geometry = format!("kind = \"sphere\", radius_m = {:?}", millimetres * 5e-4);
        let speed = settled(checks, &geometry, 2500.0, DragLaw::HaiderLevenspiel)?;
        checks.close(format!("glass, d = {millimetres} mm: terminal speed"), speed.0, wanted, 4e-6, "m/s");
        checks.close(format!("glass, d = {millimetres} mm: against the law"), speed.0, speed.1, 1e-9, "m/s");
    }
    let bar = "kind = \"box\", size_m = ";
    let cross = format!(
        "kind = \"composite\", parts = [{{ shape = {{ {bar}[3e-3, 6e-4, 6e-4] }} }}, {{ shape = {{ {bar}[6e-4, 3e-3, 6e-4] }} \
         }}, {{ shape = {{ {bar}[6e-4, 6e-4, 3e-3] }} }}]"
    );
    let cylinder = "kind = \"cylinder\", radius_m = 5e-4, length_m = 3e-3";
    for (name, geometry) in
        [("cylinder", cylinder), ("cross", &cross), ("cube", "kind = \"box\", size_m = [1e-3, 1e-3, 1e-3]")]
    {
        for drag in [DragLaw::HaiderLevenspiel, DragLaw::Ganser, DragLaw::HolzerSommerfeld] {
            let (speed, wanted) = settled(checks, geometry, 2500.0, drag)?;
            checks.close(format!("{name}, {drag:?}: terminal speed against the law"), speed, wanted, 1e-9, "m/s");
            checks.shows(format!("{name}, {drag:?}: terminal speed"), speed, "m/s");
        }
    }
    Ok(())
}

/// (speed of the engine after a long fall, speed at which weight and drag balance)
fn settled(checks: &mut Checks, geometry: &str, density: f64, drag: DragLaw) -> anyhow::Result<(f64, f64)> {
    let mut engine = body(geometry, density, GRAVITY, 1e-3, "")?;
    put(&mut engine, fluid(laws(drag)))?;
    checks.steps(&mut engine, 3000)?;
    let state = now(&engine);
    let (shape, rotation) = shape_and_rotation(&engine, &state);
    let weight = (density - WATER) * shape.volume_m3() * GRAVITY;
    let (mut low, mut high) = (0.0, 10.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        let flow = flow(Vec3::new(0.0, 0.0, middle), Vec3::zeros());
        let drag = response(&laws(drag), &shape, 1.0, &rotation, &flow).drag_n_s_per_m * middle;
        if drag < weight { low = middle } else { high = middle }
    }
    Ok((-state.velocities[0][2], low))
}

fn shape_and_rotation(engine: &Engine, state: &Snapshot) -> (HydroShape, Mat3) {
    let [w, x, y, z] = state.orientations[0];
    let rotation = Mat3::new(
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    );
    (HydroShape::of(&engine.scene().shapes()[0]), rotation)
}

/// Velocity in the plane (x, z), angle and angular velocity about y.
type Planar = [f64; 4];

/// A cylinder that starts tilted and turns broadside, against a Runge-Kutta integration of the same forces and torques.
fn tumbling(checks: &mut Checks) -> anyhow::Result<()> {
    let laws = HydrodynamicLaws {
        lift: LiftLaw::CrossFlow,
        pitching: PitchingLaw::Rosendahl,
        rotational_drag: RotationalDragLaw::Stokes,
        ..laws(DragLaw::HolzerSommerfeld)
    };
    let duration_s = 0.2;
    let tilt = ", orientations_wxyz = [[0.968912421710645, 0.0, 0.247403959254523, 0.0]]";
    let mut points = Vec::new();
    let mut reference = None;
    for time_step_s in [4e-4, 2e-4, 1e-4, 5e-5] {
        let geometry = "kind = \"cylinder\", radius_m = 5e-4, length_m = 3e-3";
        let mut engine = body(geometry, 2500.0, GRAVITY, time_step_s, tilt)?;
        put(&mut engine, fluid(laws))?;
        let begun = now(&engine);
        let wanted = *reference.get_or_insert_with(|| planar_reference(&engine, &begun, &laws, duration_s));
        checks.run_for(&mut engine, duration_s)?;
        let state = now(&engine);
        let (_, end) = shape_and_rotation(&engine, &state);
        let turn = end * shape_and_rotation(&engine, &begun).1.transpose();
        let angle = turn[(0, 2)].atan2(turn[(0, 0)]);
        let error = (angle - wanted[2]).abs();
        let [vx, _, vz] = state.velocities[0];
        let speed = (vx - wanted[0]).hypot(vz - wanted[1]) / wanted[0].hypot(wanted[1]);
        points.push((time_step_s, checks.loop_time_s(), error.max(1e-16)));
        if time_step_s == 5e-5 {
            checks.shows("tumbling cylinder: angle turned in 0.2 s", wanted[2], "rad");
            checks.near("tumbling cylinder at 0.05 ms: angle", angle, wanted[2], 1e-4, "rad");
            checks.vanishes("tumbling cylinder at 0.05 ms: error of the velocity", speed, 1e-4, "-");
        }
    }
    let order = (points[1].2 / points[3].2).log2() / 2.0;
    checks.near("tumbling cylinder: order of the angle's error in the step", order, 2.0, 0.3, "-");
    checks.work_precision("error of the angle, rad", "time step, s", "tumbling cylinder", &points);
    Ok(())
}

fn planar_reference(engine: &Engine, begun: &Snapshot, laws: &HydrodynamicLaws, duration_s: f64) -> Planar {
    let (shape, rotation) = shape_and_rotation(engine, begun);
    let properties = engine.scene().shapes()[0].mass_properties();
    let mass = 2500.0 * shape.volume_m3();
    let inertia = rotation * Mat3::from_diagonal(&(properties.principal_inertia * 2500.0)) * rotation.transpose();
    let weight = (2500.0 - WATER) * shape.volume_m3() * GRAVITY;
    let rates = |[vx, vz, angle, omega]: Planar| -> Planar {
        let (s, c) = angle.sin_cos();
        let turned = Mat3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c) * rotation;
        let flow = flow(Vec3::new(-vx, 0.0, -vz), Vec3::new(0.0, -omega, 0.0));
        let found = response(laws, &shape, 1.0, &turned, &flow);
        let force = flow.relative_velocity * found.drag_n_s_per_m + found.force_n;
        let torque = found.torque_n_m.y - found.rotational_drag_n_m_s * omega;
        [force.x / mass, (force.z - weight) / mass, omega, torque / inertia[(1, 1)]]
    };
    let steps = 40_000;
    let h = duration_s / f64::from(steps);
    let mut state = [0.0; 4];
    let along = |a: Planar, b: Planar, by: f64| [0, 1, 2, 3].map(|k| a[k] + by * b[k]);
    for _ in 0..steps {
        let k1 = rates(state);
        let k2 = rates(along(state, k1, 0.5 * h));
        let k3 = rates(along(state, k2, 0.5 * h));
        let k4 = rates(along(state, k3, h));
        state = [0, 1, 2, 3].map(|k| state[k] + h / 6.0 * (k1[k] + 2.0 * k2[k] + 2.0 * k3[k] + k4[k]));
    }
    state
}

/// A cell without walls, full of a fluid that moves as one.
fn one_cell(side_m: f64) -> MeshDescription {
    MeshDescription::Structured {
        origin_m: [-0.5 * side_m; 3],
        spacing_m: [side_m; 3],
        counts: [1; 3],
        sides: [[Side::Periodic; 2]; 3],
    }
}

fn moving(u: f64, ramp_s: f64) -> FluidFields {
    FluidFields { velocity_m_per_s: vec![[0.0, 0.0, u]], ramp_s, ..FluidFields::default() }
}

const POOL_KG: f64 = 2e-5;
const SIDE_M: f64 = 1e-2;

/// A ball in a pool of five times its mass that it sets in motion, marched in windows.
fn pool(checks: &mut Checks, windows: u32, iterated: bool) -> anyhow::Result<[f64; 2]> {
    let mut engine = body("kind = \"sphere\", radius_m = 7e-4", 2500.0, GRAVITY, 1e-5, "")?;
    let mesh = FluidDescription {
        mesh: Some(one_cell(SIDE_M)),
        smoothing_length_m: Some(2e-3),
        ..fluid(laws(DragLaw::SchillerNaumann))
    };
    put(&mut engine, mesh)?;
    let (mut u, window_s) = (0.0, 0.256 / f64::from(windows));
    let volume = SIDE_M.powi(3);
    for _ in 0..windows {
        let saved = engine.checkpoint()?;
        let mut end = u;
        for iteration in 0..if iterated { 60 } else { 1 } {
            if iteration > 0 {
                engine.restore(&saved)?;
            }
            give(&mut engine, moving(end, if iterated { window_s } else { 0.0 }))?;
            checks.run_for(&mut engine, window_s)?;
            let found = u + taken(&mut engine)?.interaction_n_per_m3[0][2] * volume * window_s / POOL_KG;
            let change = (found - end).abs();
            end = found;
            if change < 1e-14 {
                break;
            }
        }
        u = end;
    }
    Ok([now(&engine).velocities[0][2], u])
}

/// The same as an ordinary differential equation, by Runge and Kutta.
fn pool_reference() -> [f64; 2] {
    let volume = 4.0 / 3.0 * PI * 7e-4_f64.powi(3);
    let mass = 2500.0 * volume;
    let rates = |[v, u]: [f64; 2]| {
        let speed: f64 = (u - v).abs();
        let d = 14e-4;
        let reynolds = WATER * speed * d / VISCOSITY;
        let drag = 3.0 * PI * VISCOSITY * d * (1.0 + 0.15 * reynolds.powf(0.687)) * (u - v);
        [(drag - (2500.0 - WATER) * volume * GRAVITY) / mass, -drag / POOL_KG]
    };
    let (steps, mut state) = (200_000, [0.0; 2]);
    let h = 0.256 / f64::from(steps);
    for _ in 0..steps {
        let along = |b: [f64; 2], by: f64| [state[0] + by * b[0], state[1] + by * b[1]];
        let k1 = rates(state);
        let k2 = rates(along(k1, 0.5 * h));
        let k3 = rates(along(k2, 0.5 * h));
        let k4 = rates(along(k3, h));
        state = [0, 1].map(|k| state[k] + h / 6.0 * (k1[k] + 2.0 * k2[k] + 2.0 * k3[k] + k4[k]));
    }
    state
}

fn orders_in_the_window(checks: &mut Checks) -> anyhow::Result<()> {
    let wanted = pool_reference();
    for (name, iterated, order) in [("explicit", false, 1.0), ("iterated", true, 2.0)] {
        let mut points = Vec::new();
        checks.loop_time_s();
        for windows in [8, 16, 32, 64] {
            let found = pool(checks, windows, iterated)?;
            let error = (found[0] - wanted[0]).abs() / wanted[0].abs();
            points.push((0.256 / f64::from(windows), checks.loop_time_s(), error));
        }
        let found = (points[1].2 / points[3].2).log2() / 2.0;
        checks.near(format!("ball in a pool, {name}: order in the window"), found, order, 0.15, "-");
        let label = format!("ball in a pool, {name}: error of its speed at windows of {:.0} ms", 1e3 * points[3].0);
        checks.shows(label, points[3].2, "-");
        let label = format!("ball in a pool, {name}: error of its speed at windows of {:.0} ms", 1e3 * points[0].0);
        checks.shows(label, points[0].2, "-");
        checks.work_precision("error of the speed", "window, s", name, &points);
    }
    Ok(())
}

/// Balls and cubes that collide in a periodic box.
fn crowd() -> anyhow::Result<Engine> {
    let scene = SceneText::new([0.0; 3], "")
        .time_step_s(2e-5)
        .cell([0.0; 3], [0.06; 3])
        .materials(2500.0, "stiffness_n_per_m = 1e3\nrestitution = 0.6")
        .named_shape("ball", "kind = \"sphere\", radius_m = 2e-3")
        .named_shape("cube", "kind = \"box\", size_m = [4e-3, 4e-3, 4e-3]")
        .section(&cloud("ball", 250))
        .section(&cloud("cube", 250));
    Ok(Engine::new(scene.validate()?))
}

fn cloud(shape: &str, count: u32) -> String {
    format!(
        "[[insertion]]\nshape = \"{shape}\"\nmaterial = \"m\"\nvelocity_m_per_s = [0.4, 0.0, -0.2]\n\
         placement = {{ method = \"random\", region = {{ kind = \"box\", min_m = [0.0, 0.0, 0.0], max_m = [0.06, 0.06, 0.06] }}, count = {count} }}"
    )
}

fn grid(cells: u32) -> MeshDescription {
    MeshDescription::Structured {
        origin_m: [0.0; 3],
        spacing_m: [0.06 / f64::from(cells); 3],
        counts: [cells; 3],
        sides: [[Side::Periodic; 2]; 3],
    }
}

fn exchange(checks: &mut Checks) -> anyhow::Result<()> {
    conservation(checks)?;
    two_grids(checks)?;
    crossing(checks)
}

/// Twenty windows in a fluid whose velocity, pressure gradient and acceleration change from cell to cell and in time.
fn conservation(checks: &mut Checks) -> anyhow::Result<()> {
    let mut engine = crowd()?;
    let laws = HydrodynamicLaws {
        voidage: VoidageLaw::DiFelice,
        added_mass_coefficient: 0.5,
        ..laws(DragLaw::HolzerSommerfeld)
    };
    let description =
        FluidDescription { buoyancy: false, mesh: Some(grid(12)), smoothing_length_m: Some(8e-3), ..fluid(laws) };
    put(&mut engine, description)?;
    let momentum = |engine: &Engine| {
        let state = now(engine);
        let volume = |shape: u32| if shape == 0 { 4.0 / 3.0 * PI * 8e-9 } else { 64e-9 };
        let each = state.velocities.iter().zip(&state.shapes).map(|(v, &s)| Vec3::from(*v) * (2500.0 * volume(s)));
        each.sum::<Vec3>()
    };
    let (mut worst, mut worst_cells, mut worst_volume) = (0.0_f64, 0.0_f64, 0.0_f64);
    for window in 0..20 {
        let phase = f64::from(window);
        let value = |k: usize, a: f64| (0.37 * k as f64 + a + phase).sin();
        let column =
            |size: f64, a: f64| (0..1728).map(|k| [0.0, 1.0, 2.0].map(|axis| size * value(k, a + axis))).collect();
        let fields = FluidFields {
            velocity_m_per_s: column(0.5, 0.0),
            pressure_gradient_pa_per_m: column(2000.0, 5.0),
            acceleration_m_per_s2: column(1.0, 9.0),
            vorticity_rad_per_s: Vec::new(),
            ramp_s: 2e-3,
        };
        give(&mut engine, fields)?;
        let before = momentum(&engine);
        checks.run_for(&mut engine, 2e-3)?;
        let found = taken(&mut engine)?;
        let to_fluid = Vec3::from(found.totals.impulse_on_fluid_n_s);
        let pressure = Vec3::from(found.totals.pressure_impulse_n_s);
        let size = to_fluid.norm() + pressure.norm();
        worst = worst.max((momentum(&engine) - before - pressure + to_fluid).norm() / size);
        let sum = |column: &[[f64; 3]]| column.iter().map(|row| Vec3::from(*row)).sum::<Vec3>() * (125e-9 * 2e-3);
        let cells = (sum(&found.interaction_n_per_m3) - to_fluid).norm()
            + (sum(&found.pressure_force_n_per_m3) - pressure).norm();
        worst_cells = worst_cells.max(cells / size);
        let solid: f64 = found.void_fraction.iter().map(|void| (1.0 - void) * 125e-9).sum();
        worst_volume = worst_volume.max((solid / found.totals.solid_volume_m3 - 1.0).abs());
    }
    checks.vanishes("500 colliding bodies: momentum of particles and fluid per window, relative", worst, 1e-10, "-");
    checks.vanishes("500 colliding bodies: cells against particles, relative", worst_cells, 1e-10, "-");
    checks.vanishes("500 colliding bodies: volume in the cells, relative", worst_volume, 1e-10, "-");
    checks.shows("500 colliding bodies: touching pairs at the end", engine.report().touching_pairs as f64, "-");
    Ok(())
}

/// The same bodies on a grid and on one of cells half as wide.
fn two_grids(checks: &mut Checks) -> anyhow::Result<()> {
    let (mut engine, mut seen) = (crowd()?, Vec::new());
    for cells in [10, 20] {
        let description = FluidDescription {
            buoyancy: false,
            mesh: Some(grid(cells)),
            smoothing_length_m: Some(1.2e-2),
            ..fluid(laws(DragLaw::None))
        };
        put(&mut engine, description)?;
        seen.push(taken(&mut engine)?.void_fraction);
    }
    let mut worst = 0.0_f64;
    for (k, coarse) in seen[0].iter().enumerate() {
        let (i, j, l) = (k % 10, k / 10 % 10, k / 100);
        let fine = (0..8).map(|c| seen[1][2 * i + c % 2 + 20 * (2 * j + c / 2 % 2 + 20 * (2 * l + c / 4))]);
        worst = worst.max((fine.sum::<f64>() / 8.0 - coarse).abs());
    }
    let least = seen[1].iter().copied().fold(1.0, f64::min);
    checks.vanishes(
        "void fraction on two grids: largest difference of a cell and the mean of its eighths",
        worst,
        1e-13,
        "-",
    );
    checks.shows("smallest void fraction on the finer grid", least, "-");
    checks.holds("void fraction within 0 and 1", seen.iter().flatten().all(|void| (0.0..=1.0).contains(void)));
    Ok(())
}

/// A body through the side between two cells: what the void fraction changes by goes with the step that it makes.
fn crossing(checks: &mut Checks) -> anyhow::Result<()> {
    for (name, geometry) in
        [("ball", "kind = \"sphere\", radius_m = 2e-3"), ("cube", "kind = \"box\", size_m = [3e-3, 3e-3, 3e-3]")]
    {
        let mut largest = Vec::new();
        for speed in [1.0, 0.5] {
            let mut engine = body(geometry, 2500.0, 0.0, 1e-5, "")?;
            // halfway between two cells wider than the body, and a kernel narrower than it
            let mesh = MeshDescription::Structured {
                origin_m: [-0.015, -0.005, -0.005],
                spacing_m: [1e-2; 3],
                counts: [4, 1, 1],
                sides: [[Side::Closed; 2]; 3],
            };
            let laws = laws(DragLaw::None);
            let description =
                FluidDescription { mesh: Some(mesh), smoothing_length_m: Some(1e-3), buoyancy: false, ..fluid(laws) };
            put(&mut engine, description)?;
            let push = sturz_engine::LoadDescription {
                topology_epoch: engine.topology_epoch(),
                ids: vec![0],
                drag_n_s_per_m: vec![1e9],
                fluid_velocity_m_per_s: vec![[speed, 0.0, 0.0]],
                ..Default::default()
            };
            engine.apply(&Command::SetLoads(push))?;
            let mut before = taken(&mut engine)?.void_fraction;
            let mut jump = 0.0_f64;
            for _ in 0..1500 {
                checks.steps(&mut engine, 1)?;
                let after = taken(&mut engine)?.void_fraction;
                jump = after.iter().zip(&before).map(|(a, b)| (a - b).abs()).fold(jump, f64::max);
                before = after;
            }
            largest.push(jump);
        }
        checks.shows(format!("{name} over a side, 10 um per step: largest change of a void fraction"), largest[0], "-");
        checks.near(
            format!("{name} over a side: change per step over that of half a step"),
            largest[0] / largest[1],
            2.0,
            0.02,
            "-",
        );
    }
    Ok(())
}

/// A particle ten times lighter than the fluid that it must push aside, in a closed cell: the fluid goes the other way,
/// e u + (1 - e) v = 0, and its pressure gradient carries its inertia, dp/dz = -rho du/dt + (force on the fluid)/e.
struct Closed {
    engine: Engine,
    void_fraction: f64,
    u: f64,
}

/// Velocity, pressure gradient, acceleration of the fluid at the end of a window.
type Fluid1 = [f64; 2];

const LIGHT: f64 = 100.0;
const WINDOW_S: f64 = 1e-3;

impl Closed {
    fn new() -> anyhow::Result<Self> {
        let radius = (0.4 * 3.0 / 4.0 / PI).cbrt() * SIDE_M;
        let mut engine = body(&format!("kind = \"sphere\", radius_m = {radius:?}"), LIGHT, GRAVITY, 1e-4, "")?;
        let laws = laws(DragLaw::Stokes);
        let description = FluidDescription {
            viscosity_pa_s: 1.0,
            mesh: Some(one_cell(SIDE_M)),
            smoothing_length_m: Some(1e-2),
            ..fluid(laws)
        };
        put(&mut engine, description)?;
        Ok(Self { engine, void_fraction: 0.6, u: 0.0 })
    }

    /// The particles over the window in a fluid that ends like that, and the fluid that they leave.
    fn march(&mut self, checks: &mut Checks, [u, gradient]: Fluid1, ramp_s: f64) -> anyhow::Result<Fluid1> {
        let fields = FluidFields {
            velocity_m_per_s: vec![[0.0, 0.0, u]],
            pressure_gradient_pa_per_m: vec![[0.0, 0.0, gradient]],
            ramp_s,
            ..FluidFields::default()
        };
        give(&mut self.engine, fields)?;
        checks.run_for(&mut self.engine, WINDOW_S)?;
        let found = taken(&mut self.engine)?;
        let e = self.void_fraction;
        let after = -(1.0 - e) / e * found.solid_velocity_m_per_s[0][2];
        let gradient = -WATER * (after - self.u) / WINDOW_S + found.interaction_n_per_m3[0][2] / e;
        Ok([after, gradient])
    }
}

fn light_particle(checks: &mut Checks) -> anyhow::Result<()> {
    // closed form of the coupled pair: v = A/B (1 - exp(-B t))
    let (e, phi) = (0.6, 0.4);
    let radius = (0.4 * 3.0 / 4.0 / PI).cbrt() * SIDE_M;
    let (volume, stokes) = (phi * SIDE_M.powi(3), 6.0 * PI * radius);
    let inertia = LIGHT + WATER * phi / e;
    let (a, b) = ((WATER - LIGHT) * GRAVITY / inertia, stokes / (e * e * volume) / inertia);
    let windows = 20;
    let wanted = a / b * -(-b * WINDOW_S * f64::from(windows)).exp_m1();
    checks.shows("pressure of the fluid's inertia over the particle's own", WATER * phi / e / LIGHT, "-");

    let mut run = Closed::new()?;
    let mut fluid = [0.0, 0.0];
    let mut largest = 0.0_f64;
    for _ in 0..windows {
        fluid = run.march(checks, fluid, 0.0)?;
        run.u = fluid[0];
        largest = largest.max(now(&run.engine).velocities[0][2].abs());
    }
    checks.holds("explicit: the speed grows beyond a million times the exact one", largest > 1e6 * wanted);

    for (name, aitken) in [("relaxed by 0.15", false), ("Aitken", true)] {
        let (speed, iterations, bitwise) = iterated(checks, windows, aitken)?;
        checks.close(format!("{name}: speed after {windows} windows"), speed, wanted, 2e-3, "m/s");
        checks.shows(format!("{name}: iterations per window"), f64::from(iterations) / f64::from(windows), "-");
        checks.holds(format!("{name}: each rejected window is restored to the bit"), bitwise);
    }
    Ok(())
}

/// (speed at the end, iterations in all, whether all restored states were those of the start)
fn iterated(checks: &mut Checks, windows: u32, aitken: bool) -> anyhow::Result<(f64, u32, bool)> {
    let mut run = Closed::new()?;
    let (mut fluid, mut iterations, mut bitwise) = ([0.0, 0.0], 0, true);
    for _ in 0..windows {
        let saved = run.engine.checkpoint()?;
        let hash = run.engine.state_hash();
        let (mut guess, mut before): (Fluid1, Option<Fluid1>) = (fluid, None);
        let mut omega = 0.15;
        for iteration in 0.. {
            anyhow::ensure!(iteration < 400, "no convergence");
            iterations += 1;
            let found = run.march(checks, guess, WINDOW_S)?;
            let residual = [found[0] - guess[0], (found[1] - guess[1]) / 1e4];
            if residual[0].hypot(residual[1]) < 1e-9 {
                break;
            }
            run.engine.restore(&saved)?;
            bitwise &= run.engine.state_hash() == hash;
            if let Some(old) = before.filter(|_| aitken) {
                let change = [residual[0] - old[0], residual[1] - old[1]];
                omega *= -(old[0] * change[0] + old[1] * change[1]) / (change[0].powi(2) + change[1].powi(2));
            }
            before = Some(residual);
            guess = [guess[0] + omega * residual[0], guess[1] + omega * residual[1] * 1e4];
        }
        fluid = guess;
        run.u = guess[0];
    }
    Ok((now(&run.engine).velocities[0][2], iterations, bitwise))
}
