use super::*;
use crate::hydrodynamics::{DragLaw, HydrodynamicLaws, VoidageLaw};
use crate::math::Vec3;
use crate::scene::{Scene, SceneDescription};
use crate::{Command, Engine};

const WATER: [f64; 2] = [1000.0, 1e-3];

/// Balls and cubes in a box of 8 cm without gravity's help: `insertions` is TOML.
fn engine(gravity: &str, step: &str, insertions: &str) -> Engine {
    engine_of(1e3, gravity, step, insertions)
}

/// With contacts of that stiffness, N/m.
fn engine_of(stiffness: f64, gravity: &str, step: &str, insertions: &str) -> Engine {
    let text = format!(
        r#"
        [scene]
        name = "fluid"
        gravity_m_per_s2 = {gravity}
        time_step_s = {step}
        [[material]]
        name = "glass"
        density_kg_per_m3 = 2500.0
        [[material_pair]]
        materials = ["glass", "glass"]
        stiffness_n_per_m = {stiffness:e}
        restitution = 0.8
        [[shape]]
        name = "ball"
        geometry = {{ kind = "sphere", radius_m = 2e-3 }}
        [[shape]]
        name = "cube"
        geometry = {{ kind = "box", size_m = [4e-3, 4e-3, 4e-3] }}
        [[shape]]
        name = "grain"
        geometry = {{ kind = "sphere", radius_m = 25e-6 }}
        {insertions}
        "#
    );
    Engine::new(Scene::validate(SceneDescription::from_toml(&text).unwrap()).unwrap())
}

fn poses(shape: &str, positions: &[[f64; 3]]) -> String {
    format!(
        "[[insertion]]\nshape = \"{shape}\"\nmaterial = \"glass\"\nplacement = {{ method = \"poses\", positions_m = {positions:?} }}\n"
    )
}

fn laws(drag: DragLaw) -> HydrodynamicLaws {
    HydrodynamicLaws { drag, voidage: VoidageLaw::None, ..HydrodynamicLaws::default() }
}

fn water(drag: DragLaw) -> FluidDescription {
    let [density_kg_per_m3, viscosity_pa_s] = WATER;
    FluidDescription { density_kg_per_m3, viscosity_pa_s, laws: laws(drag), ..FluidDescription::default() }
}

fn mesh(counts: [u32; 3], spacing_m: [f64; 3], side: Side) -> MeshDescription {
    MeshDescription::Structured { origin_m: [0.0; 3], spacing_m, counts, sides: [[side; 2]; 3] }
}

fn in_mesh(drag: DragLaw, mesh: MeshDescription, h: f64) -> FluidDescription {
    let laws = HydrodynamicLaws { voidage: VoidageLaw::DiFelice, ..laws(drag) };
    FluidDescription { mesh: Some(mesh), smoothing_length_m: Some(h), laws, ..water(drag) }
}

fn set(engine: &mut Engine, fluid: FluidDescription) {
    engine.apply(&Command::SetFluid { fluid: Some(Box::new(fluid)), fields: None }).unwrap();
}

fn give(engine: &mut Engine, fields: FluidFields) {
    engine.apply(&Command::SetFluidFields(Some(Box::new(fields)))).unwrap();
}

fn steps(engine: &mut Engine, n: u32) {
    (0..n).for_each(|_| engine.step().unwrap());
}

fn momentum(engine: &Engine) -> Vec3 {
    let particles = &engine.particles;
    (0..particles.n_owned()).map(|row| particles.velocity[row] * particles.mass[row]).sum()
}

#[test]
fn a_grain_in_water_reaches_its_speed_at_a_step_far_above_its_relaxation_time() {
    // tau = 347 us
    for step in ["1e-5", "1e-2"] {
        let mut engine = engine_of(1e-9, "[0.0, 0.0, -9.81]", step, &poses("grain", &[[0.0, 0.0, 1.0]]));
        set(&mut engine, FluidDescription { buoyancy: true, ..water(DragLaw::Stokes) });
        steps(&mut engine, if step == "1e-5" { 1500 } else { 50 });
        let wanted = -1500.0 * 9.81 * 50e-6_f64.powi(2) / 18.0 / 1e-3;
        let found = engine.particles.velocity[0].z;
        assert!((found / wanted - 1.0).abs() < 1e-12, "{step}: {found} {wanted}");
    }
}

#[test]
fn the_way_to_that_speed_is_exact_for_a_linear_drag() {
    let mut engine = engine_of(1e-9, "[0.0, 0.0, -9.81]", "1e-4", &poses("grain", &[[0.0, 0.0, 1.0]]));
    let added = HydrodynamicLaws { added_mass_coefficient: 0.5, ..laws(DragLaw::Stokes) };
    set(&mut engine, FluidDescription { buoyancy: true, laws: added, ..water(DragLaw::Stokes) });
    steps(&mut engine, 5);
    // 1/tau = K/(m + added mass)
    let rate = 18.0 * 1e-3 / 50e-6_f64.powi(2) / (2500.0 + 500.0);
    let terminal = -1500.0 * 9.81 * 50e-6_f64.powi(2) / 18.0 / 1e-3;
    let wanted = terminal * -(-rate * 5e-4).exp_m1();
    assert!((engine.particles.velocity[0].z / wanted - 1.0).abs() < 1e-12);
}

#[test]
fn a_nonlinear_drag_is_followed_in_second_order() {
    let speed = |step: &str, n: u32| {
        let mut engine = engine_of(1.0, "[0.0, 0.0, -9.81]", step, &poses("ball", &[[0.0, 0.0, 1.0]]));
        set(&mut engine, FluidDescription { buoyancy: true, ..water(DragLaw::SchillerNaumann) });
        steps(&mut engine, n);
        engine.particles.velocity[0].z
    };
    let exact = speed("1e-5", 5000);
    let errors = [speed("1e-3", 50), speed("5e-4", 100), speed("2.5e-4", 200)].map(|found| (found / exact - 1.0).abs());
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    assert!(errors[0] < 1e-5 && orders.iter().all(|order| (order - 2.0).abs() < 0.1), "{errors:?} {orders:?}");
}

/// Twenty bodies that hit each other in a shearing fluid with a pressure gradient.
fn crowd() -> Engine {
    let at = |k: u32| {
        let part = |a: f64| (f64::from(k) * a).fract();
        [8e-3 + 0.044 * part(0.618), 8e-3 + 0.044 * part(0.414), 4e-3 + 3e-3 * f64::from(k)]
    };
    let balls: Vec<[f64; 3]> = (0..10).map(|k| at(2 * k)).collect();
    let cubes: Vec<[f64; 3]> = (0..10).map(|k| at(2 * k + 1)).collect();
    engine("[0.0, 0.0, -9.81]", "2e-5", &(poses("ball", &balls) + &poses("cube", &cubes)))
}

fn shear(n: usize, ramp_s: f64) -> FluidFields {
    let row = |k: usize| f64::from(k as u32 % 13) * 0.05;
    FluidFields {
        velocity_m_per_s: (0..n).map(|k| [0.3 + row(k), -0.1, 0.2 * row(k)]).collect(),
        pressure_gradient_pa_per_m: (0..n).map(|k| [10.0, row(k) * 100.0, -9810.0]).collect(),
        acceleration_m_per_s2: (0..n).map(|k| [row(k), 0.0, 1.0]).collect(),
        vorticity_rad_per_s: vec![[0.0, 5.0, 0.0]; n],
        ramp_s,
    }
}

/// With all sources and the added mass.
fn full(mesh: MeshDescription, h: f64) -> FluidDescription {
    let mut fluid = in_mesh(DragLaw::HolzerSommerfeld, mesh, h);
    fluid.laws.added_mass_coefficient = 0.5;
    fluid.laws.rotational_drag = crate::hydrodynamics::RotationalDragLaw::Stokes;
    fluid
}

fn points() -> MeshDescription {
    let at = |k: u32, a: f64| (f64::from(k) * a).fract() * 0.06;
    let points_m = (0..3000).map(|k| [at(k, 0.618_034), at(k, 0.414_214), at(k, 0.732_051)]).collect();
    MeshDescription::Points { points_m, volumes_m3: vec![0.06_f64.powi(3) / 3000.0; 3000] }
}

#[test]
fn what_the_particles_get_the_fluid_loses() {
    for mesh in [mesh([12, 12, 13], [5e-3; 3], Side::Closed), points()] {
        let n = mesh.len();
        let mut engine = crowd();
        set(&mut engine, full(mesh.clone(), 8e-3));
        give(&mut engine, shear(n, 4e-3));
        let (before, start) = (momentum(&engine), engine.clock().time_s());
        steps(&mut engine, 500);
        let mass: f64 = engine.particles.mass.iter().take(20).sum();
        let weight = Vec3::new(0.0, 0.0, -9.81) * mass * (engine.clock().time_s() - start);
        let gained = momentum(&engine) - before - weight;
        let exchange = engine.exchange().unwrap();
        let totals = &exchange.totals;
        let given = Vec3::from(totals.pressure_impulse_n_s) - Vec3::from(totals.impulse_on_fluid_n_s);
        assert!((gained - given).norm() < 1e-13 * gained.norm().max(weight.norm()), "{gained:?} {given:?}");
        // and the cells hold it all
        let over = exchange.time_s - exchange.from_time_s;
        let volume = 0.06_f64.powi(3) / 3000.0;
        let volume = if let MeshDescription::Points { .. } = mesh { volume } else { 5e-3_f64.powi(3) };
        let sum = |column: &[[f64; 3]]| column.iter().map(|row| Vec3::from(*row)).sum::<Vec3>() * (volume * over);
        let interaction = sum(&exchange.interaction_n_per_m3);
        assert!((interaction - Vec3::from(totals.impulse_on_fluid_n_s)).norm() < 1e-12 * interaction.norm());
        let pressure = sum(&exchange.pressure_force_n_per_m3);
        assert!((pressure - Vec3::from(totals.pressure_impulse_n_s)).norm() < 1e-12 * pressure.norm());
        let solid: f64 = exchange.void_fraction.iter().map(|void| (1.0 - void) * volume).sum();
        assert!((solid / totals.solid_volume_m3 - 1.0).abs() < 1e-12);
        assert_eq!((totals.outside, totals.immersed_volume_m3 > 0.999_999 * totals.solid_volume_m3), (0, true));
    }
}

#[test]
fn the_pressure_force_is_the_gradient_times_the_solid_of_each_cell_in_sum() {
    // sum_c V_c (1 - e_c) grad p_c = sum_p V_p grad p at p: the same operator both ways
    let mesh = mesh([12, 12, 13], [5e-3; 3], Side::Closed);
    let n = mesh.len();
    let mut engine = crowd();
    set(&mut engine, in_mesh(DragLaw::None, mesh, 8e-3));
    give(&mut engine, shear(n, 0.0));
    let void = engine.exchange().unwrap().void_fraction;
    steps(&mut engine, 1);
    let exchange = engine.exchange().unwrap();
    let wanted: Vec3 = (0..n)
        .map(|cell| Vec3::from(shear(n, 0.0).pressure_gradient_pa_per_m[cell]) * (void[cell] - 1.0) * 125e-9)
        .sum();
    let found = Vec3::from(exchange.totals.pressure_impulse_n_s) / (exchange.time_s - exchange.from_time_s);
    assert!((found - wanted).norm() < 1e-12 * wanted.norm(), "{found:?} {wanted:?}");
}

#[test]
fn readers_threads_and_restored_runs_leave_no_trace_in_the_bits() {
    let mesh = mesh([12, 12, 13], [5e-3; 3], Side::Closed);
    let n = mesh.len();
    let run = |threads: usize, read: bool, restore_at: Option<u32>| {
        let mut engine = crowd();
        engine.set_threads(threads);
        set(&mut engine, full(mesh.clone(), 8e-3));
        give(&mut engine, shear(n, 3e-3));
        for step in 0..400 {
            if read && step % 37 == 0 {
                engine.exchange().unwrap();
            }
            if restore_at == Some(step) {
                let saved = engine.checkpoint().unwrap();
                let mut other = crowd();
                other.set_threads(threads);
                other.restore(&saved).unwrap();
                engine = other;
            }
            engine.step().unwrap();
        }
        give(&mut engine, FluidFields { ramp_s: 1e-3, ..FluidFields::default() });
        steps(&mut engine, 60);
        (engine.state_hash(), engine.exchange().unwrap())
    };
    let plain = run(1, false, None);
    for (threads, read, restore_at) in [(2, false, None), (1, true, None), (1, false, Some(123)), (2, true, Some(1))] {
        assert_eq!(run(threads, read, restore_at), plain, "{threads} {read} {restore_at:?}");
    }
}

#[test]
fn insertion_and_removal_in_a_window_lose_no_impulse() {
    let mesh = mesh([12, 12, 13], [5e-3; 3], Side::Closed);
    let n = mesh.len();
    let mut engine = crowd();
    set(&mut engine, full(mesh, 8e-3));
    give(&mut engine, shear(n, 0.0));
    steps(&mut engine, 50);
    let gone = momentum(&engine);
    engine.apply(&Command::Remove(vec![0, 7, 19])).unwrap();
    let gone = gone - momentum(&engine);
    steps(&mut engine, 50);
    let weight = |engine: &Engine| -> f64 { engine.particles.mass.iter().take(engine.len()).sum() };
    let ball = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 8e-9;
    let cube = 2500.0 * 64e-9;
    let fallen = Vec3::new(0.0, 0.0, -9.81) * (weight(&engine) * 2e-3 + (2.0 * ball + cube) * 1e-3);
    let totals = engine.exchange().unwrap().totals;
    let given = Vec3::from(totals.pressure_impulse_n_s) - Vec3::from(totals.impulse_on_fluid_n_s);
    let gained = momentum(&engine) + gone - fallen;
    // ids 0 and 7 are balls, 19 is a cube
    assert!((gained - given).norm() < 1e-12 * fallen.norm(), "{gained:?} {given:?}");
}

#[test]
fn frozen_particles_stand_and_the_fluid_feels_them() {
    let text = poses("ball", &[[0.03, 0.03, 0.03]]).replace("material =", "frozen = true\nmaterial =");
    let mut engine = engine("[0.0, 0.0, -9.81]", "1e-4", &text);
    let periodic = mesh([6, 6, 6], [1e-2; 3], Side::Periodic);
    set(&mut engine, FluidDescription { laws: laws(DragLaw::Stokes), ..in_mesh(DragLaw::Stokes, periodic, 5e-3) });
    let velocity_m_per_s = vec![[0.1, 0.0, 0.0]; 216];
    give(&mut engine, FluidFields { velocity_m_per_s, ..FluidFields::default() });
    steps(&mut engine, 10);
    let totals = engine.exchange().unwrap().totals;
    assert_eq!(engine.particles.velocity[0], Vec3::zeros());
    let stokes = -6.0 * std::f64::consts::PI * 1e-3 * 2e-3 * 0.1 * 1e-3;
    assert!((totals.impulse_on_fluid_n_s[0] / stokes - 1.0).abs() < 1e-12);
}

#[test]
fn the_void_fraction_of_a_moving_body_has_no_jump() {
    // a ball of half a cell's size through cells, half-width of the kernel a quarter of a cell
    let text =
        poses("ball", &[[0.011, 0.024, 0.025]]).replace("material =", "velocity_m_per_s = [1.0, 0.2, 0.1]\nmaterial =");
    let mut engine = engine("[0.0, 0.0, 0.0]", "1e-5", &text);
    let fluid = in_mesh(DragLaw::None, mesh([6, 6, 6], [8e-3; 3], Side::Closed), 2e-3);
    set(&mut engine, fluid);
    let mut before = engine.exchange().unwrap().void_fraction;
    let mut largest: f64 = 0.0;
    for _ in 0..1500 {
        steps(&mut engine, 1);
        let now = engine.exchange().unwrap().void_fraction;
        largest = now.iter().zip(&before).map(|(a, b)| (a - b).abs()).fold(largest, f64::max);
        before = now;
    }
    // 1.02e-5 m per step: volume through a face at most the cross-section times that
    let bound = std::f64::consts::PI * 4e-6 * 1.03e-5 / 512e-9;
    assert!(largest < 1.05 * bound && largest > 0.5 * bound, "{largest} {bound}");
}

#[test]
fn what_cannot_be_is_refused_and_changes_nothing() {
    let mut engine = crowd();
    let hash = engine.state_hash();
    let good = in_mesh(DragLaw::Stokes, mesh([12, 12, 13], [5e-3; 3], Side::Closed), 8e-3);
    let mut refuse = |fluid: FluidDescription, path: &str| {
        let refusal = engine.apply(&Command::SetFluid { fluid: Some(Box::new(fluid)), fields: None }).unwrap_err();
        assert_eq!(refusal.path, path, "{refusal}");
        assert!(!engine.has_fluid());
    };
    refuse(FluidDescription { density_kg_per_m3: 0.0, ..good.clone() }, "fluid.density_kg_per_m3");
    refuse(FluidDescription { viscosity_pa_s: f64::NAN, ..good.clone() }, "fluid.viscosity_pa_s");
    refuse(FluidDescription { smoothing_length_m: None, ..good.clone() }, "fluid.smoothing_length_m");
    refuse(FluidDescription { mesh: None, ..good.clone() }, "fluid.smoothing_length_m");
    refuse(FluidDescription { least_void_fraction: 0.0, ..good.clone() }, "fluid.least_void_fraction");
    let mesh_of = |counts, spacing_m| Some(mesh(counts, spacing_m, Side::Closed));
    refuse(FluidDescription { mesh: mesh_of([0, 1, 1], [1.0; 3]), ..good.clone() }, "fluid.mesh.counts");
    refuse(FluidDescription { mesh: mesh_of([u32::MAX; 3], [1.0; 3]), ..good.clone() }, "fluid.mesh.counts");
    refuse(FluidDescription { mesh: mesh_of([1; 3], [1.0, -1.0, 1.0]), ..good.clone() }, "fluid.mesh.spacing_m[1]");
    let uneven = MeshDescription::Points { points_m: vec![[0.0; 3]], volumes_m3: vec![] };
    refuse(FluidDescription { mesh: Some(uneven), ..good.clone() }, "fluid.mesh.volumes_m3");
    refuse(FluidDescription { mesh: mesh_of([200; 3], [2e-4; 3]), ..good.clone() }, "fluid.smoothing_length_m");
    let fine = mesh_of([250; 3], [2.4e-5; 3]);
    refuse(FluidDescription { mesh: fine, smoothing_length_m: Some(1e-4), ..good.clone() }, "fluid.mesh");
    assert_eq!(engine.state_hash(), hash);
    let orphan = FluidFields::default();
    assert!(engine.apply(&Command::SetFluidFields(Some(Box::new(orphan)))).is_err());
    set(&mut engine, good);
    let hash = engine.state_hash();
    let short = FluidFields { velocity_m_per_s: vec![[0.0; 3]; 7], ..FluidFields::default() };
    let refusal = engine.apply(&Command::SetFluidFields(Some(Box::new(short)))).unwrap_err();
    assert_eq!(refusal.path, "fluid_fields.velocity_m_per_s");
    let mut broken = shear(12 * 12 * 13, 0.0);
    broken.vorticity_rad_per_s[3][1] = f64::INFINITY;
    let refusal = engine.apply(&Command::SetFluidFields(Some(Box::new(broken)))).unwrap_err();
    assert_eq!(refusal.path, "fluid_fields.vorticity_rad_per_s[3]");
    assert_eq!(engine.state_hash(), hash);
}

#[test]
fn a_window_is_free_of_its_own_length() {
    // the same fluid, given anew or not: the bits may differ by when it is looked at, the path hardly
    let end = |windows: u32| {
        let mut engine = crowd();
        let fluid = FluidDescription { refresh_steps: 1, ..full(mesh([12, 12, 13], [5e-3; 3], Side::Closed), 8e-3) };
        set(&mut engine, fluid);
        for _ in 0..windows {
            give(&mut engine, shear(12 * 12 * 13, 0.0));
            steps(&mut engine, 240 / windows);
        }
        engine.particles.rows_by_id().iter().map(|&row| engine.particles.position[row as usize]).collect::<Vec<_>>()
    };
    let once = end(1);
    for windows in [3, 240] {
        let largest = end(windows).iter().zip(&once).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(largest < 1e-12, "{windows}: {largest}");
    }
}
