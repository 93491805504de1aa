//! Loads from outside against closed forms; what is refused; bits on any threads, after rebuilds and from checkpoints.

mod common;

use common::{drum, engine, header, particle, run_for, shape, steps};
use sturz_engine::{Command, Engine, InvalidInput, LoadDescription, Snapshot};

const LAW: &str = "stiffness_n_per_m = 1e-2\nrestitution = 0.5";

fn snapshot(engine: &Engine) -> Snapshot {
    let mut snapshot = Snapshot::default();
    engine.snapshot(&mut snapshot);
    snapshot
}

fn set(engine: &mut Engine, loads: LoadDescription) -> Result<(), InvalidInput> {
    engine.apply(&Command::SetLoads(loads)).map(drop)
}

/// One box of 2 x 3 x 4 mm, turning about none of its axes unless told so.
fn free(gravity: [f64; 3], dt: f64, velocity: [f64; 3], rate: [f64; 3]) -> Engine {
    let text = header(gravity, dt, "", LAW)
        + &shape("kind = \"box\", size_m = [0.002, 0.003, 0.004]")
        + &particle([0.1, 0.2, 0.3], velocity, rate);
    engine(&text)
}

const MASS: f64 = 2500.0 * 2.4e-8;
/// About x, y and z.
const INERTIA: [f64; 3] = [MASS * 25e-6 / 12.0, MASS * 20e-6 / 12.0, MASS * 13e-6 / 12.0];

fn close(value: f64, reference: f64, tolerance: f64, what: &str) {
    assert!(
        (value - reference).abs() <= tolerance * reference.abs().max(1e-300),
        "{what}: {value:e} for {reference:e}"
    );
}

/// x = v0 t + F t^2/2m and w = T t/I; 2000 steps round to some 2000 ulp.
#[test]
fn a_constant_force_and_torque() {
    for axis in 0..3 {
        let mut engine = free([0.0; 3], 1e-4, [0.3, 0.0, 0.0], [0.0; 3]);
        let mut torque = [0.0; 3];
        torque[axis] = 2e-9;
        let loads = LoadDescription {
            ids: vec![0],
            force_n: vec![[0.0, 6e-5, 0.0]],
            torque_n_m: vec![torque],
            ..LoadDescription::default()
        };
        set(&mut engine, loads).unwrap();
        run_for(&mut engine, 0.2);
        let state = snapshot(&engine);
        close(state.positions[0][1], 0.2 + 0.5 * 6e-5 / MASS * 0.04, 1e-12, "y");
        close(state.positions[0][0], 0.1 + 0.06, 1e-12, "x");
        close(state.velocities[0][1], 6e-5 / MASS * 0.2, 1e-12, "vy");
        close(state.angular_velocities[0][axis], 2e-9 * 0.2 / INERTIA[axis], 1e-12, "rate");
        let energy = engine.report().energy;
        let gained = 0.5 * MASS * (0.2 * 6e-5 / MASS).powi(2) + 0.5 * (0.2 * 2e-9f64).powi(2) / INERTIA[axis];
        close(energy.work_loads_j, gained, 1e-11, "work");
        assert!(energy.residual_j.abs() < 1e-12 * energy.work_loads_j, "{energy:?}");
    }
}

/// v = u + (v0 - u) e^(-K t/m), w = q + (w0 - q) e^(-L t/I), at every ratio of the step to the time of relaxation.
#[test]
fn drag_relaxes_exactly_however_stiff() {
    for steps_per_relaxation in [1e4, 10.0, 1.0, 0.1, 1e-3, 1e-9] {
        let dt = 1e-4;
        let drag = MASS / (dt * steps_per_relaxation);
        let mut engine = free([0.0; 3], dt, [1.0, -2.0, 0.0], [0.0, 0.0, 30.0]);
        let rotational_drag = INERTIA[2] / (dt * steps_per_relaxation);
        let loads = LoadDescription {
            ids: vec![0],
            drag_n_s_per_m: vec![drag],
            fluid_velocity_m_per_s: vec![[0.5, 0.0, 0.25]],
            rotational_drag_n_m_s: vec![rotational_drag],
            fluid_angular_velocity_rad_per_s: vec![[0.0, 0.0, -10.0]],
            ..LoadDescription::default()
        };
        set(&mut engine, loads).unwrap();
        let n = 100;
        steps(&mut engine, n);
        let decay = (-(n as f64) / steps_per_relaxation).exp();
        let state = snapshot(&engine);
        for (axis, (start, fluid)) in [(1.0, 0.5), (-2.0, 0.0), (0.0, 0.25)].into_iter().enumerate() {
            let expected = fluid + (start - fluid) * decay;
            assert!((state.velocities[0][axis] - expected).abs() < 1e-12, "{steps_per_relaxation}: {state:?}");
        }
        let expected = -10.0 + 40.0 * decay;
        assert!((state.angular_velocities[0][2] - expected).abs() < 1e-10, "{steps_per_relaxation}: {state:?}");
    }
}

/// The terminal velocity u + m g/K, and the way there to second order in the step.
#[test]
fn falling_through_a_fluid_is_of_second_order_and_keeps_the_energy_balance() {
    let (relaxation, g) = (0.02, -9.81);
    let fall = |dt: f64| {
        let mut engine = free([0.0, 0.0, g], dt, [0.0; 3], [0.0; 3]);
        let drag_n_s_per_m = vec![MASS / relaxation];
        set(&mut engine, LoadDescription { ids: vec![0], drag_n_s_per_m, ..LoadDescription::default() }).unwrap();
        run_for(&mut engine, 0.1);
        let state = snapshot(&engine);
        let terminal = g * relaxation;
        close(state.velocities[0][2], terminal * (1.0 - (-5.0f64).exp()), 1e-11, "velocity");
        let way = terminal * (0.1 - relaxation * (1.0 - (-5.0f64).exp()));
        let energy = engine.report().energy;
        assert!(energy.work_loads_j < 0.0, "drag takes energy");
        [state.positions[0][2] - 0.3 - way, energy.residual_j]
    };
    let (coarse, fine) = (fall(2e-3), fall(1e-3));
    for (coarse, fine) in coarse.into_iter().zip(fine) {
        // of second order, up to terms of the fourth: (dt/relaxation)^2 = 1 %
        assert!((coarse / fine - 4.0).abs() < 0.05, "{coarse:e} {fine:e}");
    }
}

/// During a ramp the loads before change linearly into those after: the trapezoidal rule is exact on that.
#[test]
fn ramps_lead_from_the_loads_before_to_those_after() {
    let mut engine = free([0.0; 3], 1e-4, [0.0; 3], [0.0; 3]);
    let pull = |force: f64, ramp_s: f64| LoadDescription {
        ids: vec![0],
        force_n: vec![[force, 0.0, 0.0]],
        ramp_s,
        ..LoadDescription::default()
    };
    let speed = |engine: &Engine| snapshot(engine).velocities[0][0] * MASS;
    set(&mut engine, pull(6e-5, 0.02)).unwrap();
    run_for(&mut engine, 0.02);
    close(speed(&engine), 0.5 * 6e-5 * 0.02, 1e-11, "from 0");
    run_for(&mut engine, 0.01);
    close(speed(&engine), 6e-5 * 0.02, 1e-11, "held");
    set(&mut engine, pull(-2e-5, 0.01)).unwrap();
    run_for(&mut engine, 0.01);
    close(speed(&engine), 6e-5 * 0.02 + 2e-5 * 0.01, 1e-11, "to another");
    // half way into the next ramp, none at all are asked for: those of now fade
    set(&mut engine, pull(6e-5, 0.01)).unwrap();
    run_for(&mut engine, 0.005);
    let before = speed(&engine);
    set(&mut engine, LoadDescription { ramp_s: 0.01, ..LoadDescription::default() }).unwrap();
    run_for(&mut engine, 0.02);
    close(speed(&engine) - before, 0.5 * 2e-5 * 0.01, 1e-9, "fading");
    set(&mut engine, pull(1.0, 0.0)).unwrap();
    let before = speed(&engine);
    set(&mut engine, LoadDescription::default()).unwrap();
    run_for(&mut engine, 0.01);
    assert_eq!(speed(&engine), before, "gone at once");
}

#[test]
fn loads_act_until_they_are_no_longer_valid() {
    let mut engine = free([0.0; 3], 1e-4, [0.0; 3], [0.0; 3]);
    run_for(&mut engine, 0.0033);
    let until = engine.clock().time_s() + 0.0071;
    let loads = LoadDescription {
        ids: vec![0],
        force_n: vec![[0.0, 0.0, 6e-5]],
        valid_until_s: Some(until),
        ..LoadDescription::default()
    };
    set(&mut engine, loads).unwrap();
    run_for(&mut engine, 0.0071);
    let momentum = snapshot(&engine).velocities[0][2] * MASS;
    close(momentum, 6e-5 * 0.0071, 1e-11, "the whole window");
    run_for(&mut engine, 0.0071);
    close(snapshot(&engine).velocities[0][2] * MASS, momentum, 0.0, "nothing after it");
}

#[test]
fn what_cannot_be_used_is_refused_with_its_place_and_changes_nothing() {
    let mut engine = engine(&drum(6));
    steps(&mut engine, 10);
    engine.apply(&Command::Remove(vec![2])).unwrap();
    let good = LoadDescription {
        topology_epoch: 1,
        ids: vec![4, 0, 5],
        force_n: vec![[1e-6, 0.0, 0.0]; 3],
        ..LoadDescription::default()
    };
    set(&mut engine, good.clone()).unwrap();
    let before = engine.state_hash();
    let mut refusal = |change: &dyn Fn(&mut LoadDescription)| {
        let mut loads = good.clone();
        change(&mut loads);
        let error = set(&mut engine, loads).unwrap_err();
        assert_eq!(engine.state_hash(), before, "{error}");
        error.to_string()
    };
    let stale = refusal(&|loads| loads.topology_epoch = 0);
    assert_eq!(stale, "set_loads.topology_epoch: is 0, the particles are of epoch 1: ask for their ids again");
    assert_eq!(refusal(&|loads| loads.ids[1] = 2), "set_loads.ids[1]: particle 2 does not exist");
    assert_eq!(refusal(&|loads| loads.ids[2] = 4), "set_loads.ids[2]: particle 4 has a load already");
    let short = refusal(&|loads| loads.force_n.truncate(2));
    assert_eq!(short, "set_loads.force_n: has 2 rows for 3 ids; give one each, or none");
    assert!(refusal(&|loads| loads.force_n[2][1] = f64::NAN).starts_with("set_loads.force_n[2]: is NaN"));
    assert!(refusal(&|loads| loads.torque_n_m = vec![[f64::INFINITY; 3]; 3]).starts_with("set_loads.torque_n_m[0]"));
    assert!(
        refusal(&|loads| loads.drag_n_s_per_m = vec![1.0, -1.0, 0.0]).starts_with("set_loads.drag_n_s_per_m[1]: is -1")
    );
    let useless = refusal(&|loads| loads.fluid_velocity_m_per_s = vec![[1.0; 3]; 3]);
    assert_eq!(useless, "set_loads.fluid_velocity_m_per_s: does nothing without drag_n_s_per_m");
    assert!(refusal(&|loads| loads.rotational_drag_n_m_s = vec![1.0]).contains("has 1 rows for 3 ids"));
    assert!(refusal(&|loads| loads.ramp_s = -1.0).starts_with("set_loads.ramp_s: is -1"));
    for until in [0.0, f64::NAN, f64::INFINITY] {
        assert!(refusal(&|loads| loads.valid_until_s = Some(until)).starts_with("set_loads.valid_until_s"));
    }
}

/// A drum of crosses in a swirl: loads on all, then on some, with particles that go.
fn swirl(threads: usize, drop_every: u64, restore_at: u64) -> Vec<u64> {
    let text = drum(40);
    let mut engine = engine(&text);
    engine.set_threads(threads);
    let mut hashes = Vec::new();
    for step in 0..3000u64 {
        if step % 500 == 0 {
            let state = snapshot(&engine);
            let some = state.ids.iter().enumerate().filter(|(k, _)| step < 1000 || k % 2 == 0);
            let rows: Vec<(u64, [f64; 3])> = some.map(|(k, &id)| (id, state.positions[k])).collect();
            let loads = LoadDescription {
                topology_epoch: engine.topology_epoch(),
                ids: rows.iter().map(|(id, _)| *id).collect(),
                torque_n_m: rows.iter().map(|(_, x)| [1e-9 * x[2], 0.0, 1e-9]).collect(),
                drag_n_s_per_m: rows.iter().map(|(id, _)| 1e-4 * (1.0 + *id as f64)).collect(),
                fluid_velocity_m_per_s: rows.iter().map(|(_, x)| [-3.0 * x[2], 0.2, 3.0 * x[0]]).collect(),
                rotational_drag_n_m_s: vec![1e-10; rows.len()],
                ramp_s: if step == 500 { 0.0 } else { 0.005 },
                valid_until_s: (step == 2500).then(|| engine.clock().time_s() + 0.004),
                ..LoadDescription::default()
            };
            set(&mut engine, loads).unwrap();
        }
        if step == 1700 {
            engine.apply(&Command::Remove(vec![0, 7])).unwrap();
        }
        if drop_every > 0 && step % drop_every == 0 {
            engine.drop_caches();
        }
        if step == restore_at {
            let saved = engine.checkpoint().unwrap();
            engine = common::engine(&text);
            engine.restore(&saved).unwrap();
            engine.set_threads(threads);
        }
        steps(&mut engine, 1);
        if step % 250 == 249 {
            hashes.push(engine.state_hash());
        }
    }
    let energy = engine.report().energy;
    assert!(energy.work_loads_j != 0.0);
    hashes
}

#[test]
fn threads_rebuilds_and_checkpoints_are_invisible_in_the_bits() {
    let reference = swirl(1, 0, u64::MAX);
    assert_eq!(swirl(2, 0, u64::MAX), reference);
    assert_eq!(swirl(4, 13, u64::MAX), reference);
    assert_eq!(swirl(1, 0, 1130), reference, "in the midst of a ramp");
    assert_eq!(swirl(2, 0, 2600), reference, "with an end");
}

/// A heap in a very viscous fluid that carries it: contacts and stiff drag together stay finite and balanced.
#[test]
fn a_heap_in_a_stiff_fluid_stays_where_the_fluid_is() {
    let mut engine = engine(&drum(60));
    let ids: Vec<u64> = (0..60).collect();
    let drag_n_s_per_m = vec![1e3; 60];
    let rotational_drag_n_m_s = vec![1.0; 60];
    let loads = LoadDescription { ids, drag_n_s_per_m, rotational_drag_n_m_s, ..LoadDescription::default() };
    set(&mut engine, loads).unwrap();
    let start = snapshot(&engine).positions;
    steps(&mut engine, 3000);
    let state = snapshot(&engine);
    for (x, y) in start.iter().zip(&state.positions) {
        assert!((0..3).all(|k| (x[k] - y[k]).abs() < 1e-6), "carried away: {x:?} {y:?}");
    }
    assert!(state.velocities.iter().flatten().all(|v| v.abs() < 1e-4));
}
