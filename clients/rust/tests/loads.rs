//! Loads from outside against the real daemon: in windows and between them.

mod common;

use common::Daemon;
use sturz_client::v1::{self, ErrorCode};
use sturz_client::{ClientError, FloatType, FluidFields, Insertion, Loads, Placement, Refusal, Simulation, Window};

/// Of a bead, kg.
const MASS: f64 = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-9;

fn refusal<T: std::fmt::Debug>(answer: Result<T, ClientError>) -> Refusal {
    answer.unwrap_err().refusal().cloned().expect("refused by the daemon")
}

/// Three beads without gravity, and the epoch that they are from.
fn beads(simulation: &Simulation) -> u64 {
    simulation.set_gravity([0.0; 3]).unwrap();
    let positions_m = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]];
    simulation.insert(Insertion::new("bead", "glass", Placement::poses(positions_m))).unwrap();
    simulation.state(&["ids"], FloatType::F64).unwrap().topology_epoch()
}

#[test]
fn windows_carry_loads_and_end_as_the_closed_forms_say() {
    let daemon = Daemon::start("loads");
    let simulation = daemon.connect();
    let topology_epoch = beads(&simulation);
    let window_s = 2e-3;
    let loads = Loads {
        topology_epoch,
        ids: vec![2, 0],
        force_n: vec![[0.0, 1e-5, 0.0], [3e-5, 0.0, 0.0]],
        drag_n_s_per_m: vec![1e3, 0.0],
        fluid_velocity_m_per_s: vec![[0.0, 0.0, 0.5]; 2],
        ramp_s: window_s,
        ..Loads::default()
    };
    let window = Window::new(window_s).with_columns(["velocities"]).with_loads(loads);
    let state = simulation.advance(window).unwrap().state.unwrap();
    let velocities = state.velocities_m_per_s().unwrap();
    let close =
        |value: f64, expected: f64| assert!((value - expected).abs() < 1e-10 * expected.abs(), "{velocities:?}");
    // a force that grows linearly; nothing; a drag so stiff that the bead moves with the fluid and the force on it
    close(velocities[0][0], 0.5 * 3e-5 * window_s / MASS);
    assert_eq!(velocities[1], [0.0; 3]);
    close(velocities[2][2], 0.5);
    close(velocities[2][1], 1e-5 / 1e3);
    // held: a window without loads goes on with those
    let window = Window::new(window_s).with_columns(["velocities"]);
    let velocities = simulation.advance(window).unwrap().state.unwrap().velocities_m_per_s().unwrap();
    assert!((velocities[0][0] - 1.5 * 3e-5 * window_s / MASS).abs() < 1e-10 * velocities[0][0]);
    assert!(simulation.report().unwrap().energy.unwrap().work_loads_j > 0.0);
    simulation.set_loads(Loads { topology_epoch, ..Loads::default() }).unwrap();
    let window = Window::new(window_s).with_columns(["velocities"]);
    let state = simulation.advance(window).unwrap().state.unwrap();
    assert_eq!(state.velocities_m_per_s().unwrap()[0][0], velocities[0][0], "without loads it flies on");
}

#[test]
fn what_is_wrong_with_loads_refuses_the_window_and_changes_nothing() {
    let daemon = Daemon::start("bad-loads");
    let simulation = daemon.connect();
    let epoch = beads(&simulation);
    let good = Loads { topology_epoch: epoch, ids: vec![0, 1], force_n: vec![[1e-5, 0.0, 0.0]; 2], ..Loads::default() };
    simulation.set_loads(good.clone()).unwrap();
    let before = simulation.info().unwrap();
    let refused = |change: &dyn Fn(&mut Loads)| {
        let mut loads = good.clone();
        change(&mut loads);
        let window = refusal(simulation.advance(Window::new(1e-3).with_loads(loads.clone())));
        let alone = refusal(simulation.set_loads(loads));
        assert_eq!((window.code, &window.path, &window.message), (alone.code, &alone.path, &alone.message));
        assert_eq!(window.code, ErrorCode::InvalidInput);
        let after = simulation.info().unwrap();
        assert_eq!(
            (after.state_hash, after.step, after.sim_time_s),
            (before.state_hash, before.step, before.sim_time_s)
        );
        (window.path, window.message)
    };
    let (path, message) = refused(&|loads| loads.topology_epoch += 1);
    assert!(path == "loads.topology_epoch" && message.contains("ask for their ids again"), "{message}");
    assert_eq!(refused(&|loads| loads.ids[1] = 99).0, "loads.ids[1]");
    assert_eq!(refused(&|loads| loads.ids[1] = 0).0, "loads.ids[1]");
    assert_eq!(refused(&|loads| loads.force_n.truncate(1)).0, "loads.force_n");
    assert_eq!(refused(&|loads| loads.force_n[1][2] = f64::NAN).0, "loads.force_n[1]");
    assert_eq!(refused(&|loads| loads.drag_n_s_per_m = vec![-1.0; 2]).0, "loads.drag_n_s_per_m[0]");
    assert_eq!(refused(&|loads| loads.ramp_s = f64::INFINITY).0, "loads.ramp_s");
    assert_eq!(refused(&|loads| loads.valid_until_s = Some(0.0)).0, "loads.valid_until_s");
}

/// Loads are part of a checkpoint: a repeated window needs not send them again.
#[test]
fn a_restored_window_has_the_loads_of_its_checkpoint() {
    let daemon = Daemon::start("loads-again");
    let simulation = daemon.connect();
    let topology_epoch = beads(&simulation);
    let force_n = vec![[1e-5, 0.0, 0.0], [0.0, 2e-5, 0.0]];
    let loads = Loads { topology_epoch, ids: vec![0, 1], force_n, ramp_s: 3e-3, ..Loads::default() };
    simulation.advance(Window::new(1e-3).with_loads(loads)).unwrap();
    simulation.checkpoint("within-the-ramp").unwrap();
    let hash = |simulation: &Simulation| {
        simulation.advance(Window::new(4e-3)).unwrap();
        simulation.info().unwrap().state_hash
    };
    let first = hash(&simulation);
    simulation.set_loads(Loads { topology_epoch, ..Loads::default() }).unwrap();
    simulation.restore("within-the-ramp").unwrap();
    assert_eq!(hash(&simulation), first);
}

/// A fluid of 2 x 2 x 2 boxes around a bead at rest.
fn fluid() -> v1::FluidDefinition {
    let vector = |x: f64| Some(v1::Vec3 { x, y: x, z: x });
    let mesh = v1::StructuredMesh {
        origin_m: vector(-0.05),
        spacing_m: vector(0.05),
        count_x: 2,
        count_y: 2,
        count_z: 2,
        ..Default::default()
    };
    v1::FluidDefinition {
        density_kg_per_m3: 1000.0,
        viscosity_pa_s: 1e-3,
        drag: v1::DragLaw::Stokes.into(),
        voidage: v1::VoidageLaw::None.into(),
        mesh: Some(v1::fluid_definition::Mesh::Structured(mesh)),
        smoothing_length_m: Some(0.02),
        ..Default::default()
    }
}

#[test]
fn a_window_takes_a_fluid_in_and_brings_back_what_it_gets() {
    let daemon = Daemon::start("fluid");
    let simulation = daemon.connect();
    simulation.set_gravity([0.0; 3]).unwrap();
    simulation.insert(Insertion::new("bead", "glass", Placement::poses(vec![[0.0; 3]]))).unwrap();
    let fields = FluidFields { velocity_m_per_s: vec![[0.1, 0.0, 0.0]; 8], ..FluidFields::default() };
    let early = refusal(simulation.advance(Window::new(1e-3).with_fluid(fields.clone())));
    assert_eq!((early.code, early.path.as_str()), (ErrorCode::InvalidInput, "fluid"));
    simulation.set_fluid(Some(fluid()), Some(fields.clone())).unwrap();
    let window_s = 0.02;
    let done = simulation.advance(Window::new(window_s).with_columns(["velocities"]).with_fluid(fields)).unwrap();
    let exchange = done.exchange.unwrap();
    // v = u (1 - exp(-t / tau)), Stokes' drag being linear
    let rate = 6.0 * std::f64::consts::PI * 1e-3 * 1e-3 / MASS;
    let wanted = 0.1 * -(-rate * window_s).exp_m1();
    let found = done.state.unwrap().velocities_m_per_s().unwrap()[0][0];
    assert!((found / wanted - 1.0).abs() < 1e-10, "{found} {wanted}");
    let given = exchange.interaction_n_per_m3().unwrap().iter().map(|force| force[0]).sum::<f64>();
    assert!((given * 0.05_f64.powi(3) * window_s / (-MASS * found) - 1.0).abs() < 1e-10);
    let solid: f64 = exchange.void_fraction().unwrap().iter().map(|void| (1.0 - void) * 0.05_f64.powi(3)).sum();
    assert!((solid * 2500.0 / MASS - 1.0).abs() < 1e-10);
    assert_eq!((exchange.from_time_s(), exchange.time_s()), (0.0, done.time_reached_s));
    assert!(exchange.drag_kg_per_m3_s().unwrap().iter().all(|&drag| drag > 0.0));
    assert_eq!(exchange.solid_velocity_m_per_s().unwrap().len(), 8);
    assert_eq!(simulation.exchange().unwrap().void_fraction().unwrap(), exchange.void_fraction().unwrap());
    simulation.set_fluid(None, None).unwrap();
    assert_eq!(refusal(simulation.exchange()).code, ErrorCode::NotFound);
}
