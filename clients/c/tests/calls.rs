//! Calls as C makes them, against the real daemon: what they do, and what they say of bad input.
#![allow(unsafe_code)]

#[path = "../../rust/tests/common/mod.rs"]
mod common;

use std::ffi::{CStr, CString, c_char};
use std::ptr::{null, null_mut};
use std::{mem, thread};

use common::Daemon;
use sturz_c::sturz_code::*;
use sturz_c::*;

const SCENE: &str = include_str!("../examples/settling.toml");

fn text(text: *const c_char) -> String {
    // SAFETY: of this thread, and read at once.
    unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned()
}

/// The last failure of this thread: path and message.
fn last() -> (String, String) {
    (text(sturz_last_error_path()), text(sturz_last_error_message()))
}

/// As `= {0}` in C.
fn zeros<T>() -> T {
    // SAFETY: used for structs of numbers and pointers, for all of which zeros are sound.
    unsafe { mem::zeroed() }
}

struct Handle(*mut sturz_simulation);

impl Handle {
    fn of(daemon: &Daemon) -> Self {
        let (name, endpoint) = (CString::new(&*daemon.instance).unwrap(), CString::new(&*daemon.endpoint).unwrap());
        let mut simulation = null_mut();
        // SAFETY: texts and place are sound.
        let code = unsafe { sturz_connect(name.as_ptr(), endpoint.as_ptr(), 30.0, &mut simulation) };
        assert_eq!(code, SturzOk, "{:?}", last());
        Self(simulation)
    }
}

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: nobody has it any more.
        unsafe { sturz_close(self.0) };
    }
}

fn info(handle: &Handle) -> sturz_info {
    let mut info = zeros::<mem::MaybeUninit<sturz_info>>();
    // SAFETY: the place is sound, and written when the code says so.
    unsafe {
        assert_eq!(sturz_get_info(handle.0, info.as_mut_ptr()), SturzOk, "{:?}", last());
        info.assume_init()
    }
}

/// The ball: height, m, and vertical velocity, m/s, of the last row.
fn ball(handle: &Handle) -> (f64, f64) {
    let (mut position, mut velocity) = ([0.0; 3], [0.0; 3]);
    let mut state: sturz_state = zeros();
    (state.capacity, state.positions_m, state.velocities_m_per_s) = (1, position.as_mut_ptr(), velocity.as_mut_ptr());
    // SAFETY: both arrays have room for one row.
    assert_eq!(unsafe { sturz_get_state(handle.0, &mut state) }, SturzOk, "{:?}", last());
    (position[2], velocity[2])
}

/// Water in one column of 10 cells.
fn water(mesh: &sturz_structured_mesh) -> sturz_fluid {
    let mut fluid = sturz_fluid_default();
    (fluid.density_kg_per_m3, fluid.viscosity_pa_s) = (1000.0, 1e-3);
    (fluid.structured_mesh, fluid.smoothing_length_m) = (mesh, 0.02);
    fluid
}

const MESH: sturz_structured_mesh = sturz_structured_mesh {
    origin_m: [-0.02, -0.02, 0.0],
    spacing_m: [0.04, 0.04, 0.02],
    counts: [1, 1, 10],
    low_sides: [0; 3],
    high_sides: [0; 3],
};

#[test]
fn nulls_are_refused_by_name_everywhere() {
    let none = null::<sturz_simulation>();
    let place: *mut *mut sturz_simulation = &mut null_mut();
    let name = c"x".as_ptr();
    // SAFETY: null is what they must notice.
    unsafe {
        let refused = |code: sturz_code, path: &str| {
            assert_eq!((code, last().0), (SturzInvalidArgument, path.to_owned()), "{}", last().1);
        };
        refused(sturz_connect(null(), null(), 1.0, place), "name");
        refused(sturz_connect(name, null(), 1.0, null_mut()), "simulation");
        refused(sturz_connect(name, null(), f64::NAN, place), "timeout_s");
        refused(sturz_connect_tls(name, null(), null(), 1.0, place), "folder");
        refused(sturz_reconnect(null_mut(), 1.0), "simulation");
        refused(sturz_get_info(none, null_mut()), "simulation");
        refused(sturz_acquire_lease(none), "simulation");
        refused(sturz_release_lease(none), "simulation");
        refused(sturz_set_gravity(none, [0.0; 3].as_ptr()), "simulation");
        refused(sturz_pause(none), "simulation");
        refused(sturz_resume(none), "simulation");
        refused(sturz_stop(none), "simulation");
        refused(sturz_checkpoint(none, name, 0), "simulation");
        refused(sturz_restore(none, name), "simulation");
        refused(sturz_drop_checkpoint(none, name), "simulation");
        refused(sturz_get_state(none, null_mut()), "simulation");
        refused(sturz_get_exchange(none, null_mut()), "simulation");
        refused(sturz_set_loads(none, null()), "simulation");
        refused(sturz_set_fluid(none, null(), null()), "fluid");
        refused(sturz_remove_fluid(none), "simulation");
        refused(sturz_advance(none, 1.0, null_mut(), null_mut(), null_mut()), "simulation");
        refused(sturz_advance_with_fluid(none, 1.0, null(), null_mut(), null_mut(), null_mut()), "fields");
        refused(sturz_advance_with_loads(none, 1.0, null(), null_mut(), null_mut()), "loads");
        refused(sturz_step(none, 1, null_mut()), "simulation");
        refused(sturz_participant_initialize(none, null(), null_mut(), null_mut()), "participant");
        refused(sturz_participant_advance(null(), null(), null_mut()), "fields");
        refused(sturz_participant_advance(null(), &zeros(), null_mut()), "participant");
        sturz_set_fluid(none, null(), null());
        assert_eq!(last().1, "fluid is null");
        sturz_connect(name, null(), f64::NAN, place);
        assert_eq!(last().1, "timeout_s is NaN; must be finite and at least 0");
        assert_eq!(sturz_participant_is_coupling_ongoing(null()), -1);
        assert_eq!(sturz_participant_window_s(null()), -1.0);
        sturz_close(null_mut());
        assert_eq!(sturz_participant_finalize(null_mut()), SturzOk);
    }
    assert_eq!(text(sturz_version()), env!("CARGO_PKG_VERSION"));
}

#[test]
fn no_daemon_no_such_name_and_a_daemon_that_goes_have_their_codes() {
    let mut simulation = null_mut();
    let connect = |name: &CStr, endpoint: &CStr, simulation: &mut *mut sturz_simulation| {
        // SAFETY: texts and place are sound.
        let code = unsafe { sturz_connect(name.as_ptr(), endpoint.as_ptr(), 0.2, simulation) };
        assert!(simulation.is_null());
        (code, last().1)
    };
    let (code, message) = connect(c"x", c"tcp/127.0.0.1:9", &mut simulation);
    assert!(code == SturzNotFound && message.starts_with("no daemon listens at tcp/127.0.0.1:9"), "{message}");
    let (code, message) = connect(c"a/b", c"tcp/127.0.0.1:9", &mut simulation);
    assert!(code == SturzInvalidArgument && message.contains("a/b"), "{message}");
    let mut daemon = Daemon::serve("c-gone", SCENE, &[]);
    let endpoint = CString::new(&*daemon.endpoint).unwrap();
    let (code, message) = connect(c"who", &endpoint, &mut simulation);
    assert!(code == SturzNotFound && message.contains("there are: c-gone"), "{message}");
    let handle = Handle::of(&daemon);
    daemon.kill();
    // SAFETY: the handle is sound.
    unsafe {
        assert_eq!(sturz_pause(handle.0), SturzGone, "{:?}", last());
        assert_eq!(sturz_reconnect(handle.0, 0.2), SturzNotFound);
        assert_eq!(sturz_pause(handle.0), SturzGone);
    }
}

#[test]
fn the_run_is_steered_saved_and_stopped() {
    let mut daemon = Daemon::serve("c-steered", SCENE, &[]);
    let handle = Handle::of(&daemon);
    let simulation = handle.0;
    let start = info(&handle);
    assert_eq!((start.time_s, start.step, start.particles, start.state), (0.0, 0, 1, sturz_run_state::Paused));
    assert_eq!((start.time_step_s, start.gravity_m_per_s2), (1e-4, [0.0, 0.0, -9.81]));
    // SAFETY: handle, texts and places are sound.
    unsafe {
        assert_eq!(sturz_set_gravity(simulation, [0.0, 0.0, -2.0].as_ptr()), SturzOk);
        assert_eq!(sturz_checkpoint(simulation, c"start".as_ptr(), 0), SturzOk);
        let mut done: sturz_advanced = sturz_advanced::default();
        assert_eq!(sturz_step(simulation, 10, &mut done), SturzOk);
        assert_eq!((done.step, done.steps_done, done.stop_reason), (10, 10, sturz_stop_reason::Complete));
        assert!((ball(&handle).1 + 2.0 * 1e-3).abs() < 1e-15, "free fall: {:?}", ball(&handle));
        assert_eq!(sturz_advance(simulation, 1e-3, null_mut(), null_mut(), &mut done), SturzOk);
        assert_eq!((done.step, done.time_s), (20, info(&handle).time_s));
        assert_eq!(sturz_restore(simulation, c"start".as_ptr()), SturzOk);
        assert_eq!(info(&handle).step, 0);
        assert_eq!(sturz_advance(simulation, 1e-3, null_mut(), null_mut(), null_mut()), SturzOk, "it starts there");
        assert_eq!(sturz_drop_checkpoint(simulation, c"start".as_ptr()), SturzOk);
        assert_eq!(sturz_restore(simulation, c"start".as_ptr()), SturzRefusedNotFound);
        assert_eq!(sturz_checkpoint(simulation, c"".as_ptr(), 0), SturzInvalidArgument);

        assert_eq!(sturz_resume(simulation), SturzOk);
        assert_eq!(sturz_step(simulation, 1, null_mut()), SturzRefusedNotPaused);
        assert_eq!(sturz_pause(simulation), SturzOk);
        assert_eq!(sturz_step(simulation, 0, null_mut()), SturzRefusedInvalidInput);
        assert_eq!(last().0, "steps");

        let other = Handle::of(&daemon);
        assert_eq!(sturz_acquire_lease(simulation), SturzOk);
        assert_eq!(sturz_step(other.0, 1, null_mut()), SturzRefusedLease);
        assert_eq!(sturz_release_lease(simulation), SturzOk);
        let _ = info(&handle);
        assert_eq!(sturz_step(other.0, 1, null_mut()), SturzOk);
        let behind = sturz_advance(simulation, 1e-3, null_mut(), null_mut(), null_mut());
        assert_eq!(behind, SturzRefusedWrongTime, "somebody else went on");
        let _ = info(&handle);
        assert_eq!(sturz_advance(simulation, 1e-3, null_mut(), null_mut(), null_mut()), SturzOk);
        assert_eq!(sturz_stop(simulation), SturzOk);
    }
    assert!(daemon.ended_well());
}

#[test]
fn a_window_that_is_paused_from_another_thread_says_so() {
    let daemon = Daemon::serve("c-paused", SCENE, &[]);
    let handle = Handle::of(&daemon);
    let shared = handle.0 as usize;
    let window = thread::spawn(move || {
        let mut done = sturz_advanced::default();
        // SAFETY: the handle outlives the thread.
        let code = unsafe { sturz_advance(shared as *const _, 1e6, null_mut(), null_mut(), &mut done) };
        (code, done.stop_reason, last().1)
    });
    while info(&handle).step == 0 {
        thread::yield_now();
    }
    // SAFETY: the handle is sound.
    assert_eq!(unsafe { sturz_pause(handle.0) }, SturzOk);
    let (code, reason, message) = window.join().unwrap();
    assert_eq!((code, reason), (SturzEndedEarly, sturz_stop_reason::Paused), "{message}");
    assert!(message.starts_with("ended early, at ") && message.ends_with("Paused"), "{message}");
}

#[test]
fn states_come_into_arrays_that_have_room() {
    let daemon = Daemon::serve("c-state", SCENE, &[]);
    let handle = Handle::of(&daemon);
    let mut state: sturz_state = zeros();
    let (mut ids, mut positions, mut velocities, mut spins) = ([9_u64; 2], [9.0; 6], [9.0; 6], [9.0; 6]);
    let mut orientations = [9.0; 8];
    // SAFETY: the arrays have room for two rows, and are given as such or as less.
    unsafe {
        assert_eq!(sturz_get_state(handle.0, &mut state), SturzOk);
        assert_eq!((state.count, state.step), (1, 0));
        state.positions_m = positions.as_mut_ptr();
        assert_eq!(sturz_get_state(handle.0, &mut state), SturzTooSmall);
        assert_eq!(last().1, "state.capacity is 0, and there are 1 rows: give larger arrays and ask again");
        assert_eq!(positions, [9.0; 6]);
        state.capacity = 2;
        state.ids = ids.as_mut_ptr();
        state.orientations_wxyz = orientations.as_mut_ptr();
        state.velocities_m_per_s = velocities.as_mut_ptr();
        state.angular_velocities_rad_per_s = spins.as_mut_ptr();
        assert_eq!(sturz_get_state(handle.0, &mut state), SturzOk);
        state.velocities_m_per_s = velocities.as_mut_ptr().byte_add(1);
        assert_eq!(sturz_get_state(handle.0, &mut state), SturzInvalidArgument);
        assert_eq!(last().1, "state.velocities_m_per_s is not aligned to 8 bytes");
    }
    assert_eq!((ids, positions), ([0, 9], [0.0, 0.0, 0.19, 9.0, 9.0, 9.0]));
    assert_eq!(orientations, [1.0, 0.0, 0.0, 0.0, 9.0, 9.0, 9.0, 9.0]);
    assert_eq!((velocities[..4] == [0.0, 0.0, 0.0, 9.0], spins[..4] == [0.0, 0.0, 0.0, 9.0]), (true, true));
}

#[test]
fn loads_act_and_bad_ones_are_named() {
    let daemon = Daemon::serve("c-loads", SCENE, &[]);
    let handle = Handle::of(&daemon);
    let (ids, force, drag, stream) = ([0_u64], [1e-6, 0.0, 0.0], [1.0], [0.0, 0.0, 0.25]);
    let mut loads: sturz_loads = zeros();
    (loads.topology_epoch, loads.count) = (info(&handle).topology_epoch, 1);
    // SAFETY: the arrays have one row.
    unsafe {
        let advance = |loads: &sturz_loads| sturz_advance_with_loads(handle.0, 1e-3, loads, null_mut(), null_mut());
        assert_eq!(advance(&loads), SturzInvalidArgument);
        assert_eq!(last().1, "loads.ids is null, and loads.count is 1");
        loads.ids = ids.as_ptr();
        (loads.force_n, loads.drag_n_s_per_m) = (force.as_ptr(), drag.as_ptr());
        loads.fluid_velocity_m_per_s = stream.as_ptr();
        assert_eq!(advance(&loads), SturzOk, "{:?}", last());
        // So stiff that the ball moves as the stream, less its weight over the drag: 1.3e-5 N over 1 N s/m.
        assert!((ball(&handle).1 - 0.25).abs() < 2e-5, "{:?}", ball(&handle));
        loads.topology_epoch += 1;
        assert_eq!(sturz_set_loads(handle.0, &loads), SturzRefusedInvalidInput);
        assert_eq!(last().0, "loads.topology_epoch");
        loads.topology_epoch -= 1;
        loads.force_n = [0.0, f64::NAN, 0.0].as_ptr();
        assert_eq!(sturz_set_loads(handle.0, &loads), SturzRefusedInvalidInput);
        assert_eq!(last().0, "loads.force_n[0]");
        let mut none: sturz_loads = zeros();
        none.topology_epoch = loads.topology_epoch;
        assert_eq!(sturz_set_loads(handle.0, &none), SturzOk);
        let before = ball(&handle).1;
        assert_eq!(sturz_advance(handle.0, 1e-3, null_mut(), null_mut(), null_mut()), SturzOk);
        assert!((ball(&handle).1 - before + 9.81e-3).abs() < 1e-12, "free fall");
    }
}

#[test]
fn bad_fluids_and_fields_change_nothing_and_are_named() {
    let daemon = Daemon::serve("c-fluid", SCENE, &[]);
    let handle = Handle::of(&daemon);
    let mut exchange: sturz_exchange = zeros();
    let good = water(&MESH);
    let set = |change: &dyn Fn(&mut sturz_fluid)| {
        let mut fluid = good;
        change(&mut fluid);
        // SAFETY: meshes are sound.
        let code = unsafe { sturz_set_fluid(handle.0, &fluid, null()) };
        (code, last().0)
    };
    // SAFETY: arrays have room for what they say.
    unsafe {
        assert_eq!(sturz_get_exchange(handle.0, &mut exchange), SturzRefusedNotFound, "{:?}", last());
        assert_eq!(set(&|fluid| fluid.drag = 7), (SturzInvalidArgument, "fluid.drag".into()));
        assert_eq!(last().1, "fluid.drag is 7; must be one of enum sturz_drag");
        let sides = sturz_structured_mesh { high_sides: [0, -1, 0], ..MESH };
        let path = "fluid.structured_mesh.high_sides[1]".to_owned();
        assert_eq!(set(&|fluid| fluid.structured_mesh = &sides), (SturzInvalidArgument, path));
        let points: sturz_point_mesh = zeros();
        let both = set(&|fluid| fluid.point_mesh = &points);
        assert_eq!(both, (SturzInvalidArgument, "fluid.point_mesh".into()));
        let empty = set(&|fluid| (fluid.structured_mesh, fluid.point_mesh) = (null(), &points));
        assert_eq!(empty, (SturzInvalidArgument, "fluid.point_mesh.points_m".into()));
        let path = |name: &str| (SturzRefusedInvalidInput, format!("fluid.{name}"));
        assert_eq!(set(&|fluid| fluid.density_kg_per_m3 = 0.0), path("density_kg_per_m3"));
        assert_eq!(set(&|fluid| fluid.smoothing_length_m = 0.0), path("smoothing_length_m"));
        assert_eq!(sturz_set_fluid(handle.0, &good, null()), SturzOk, "{:?}", last());

        let velocity = [0.0; 30];
        let mut fields: sturz_fluid_fields = zeros();
        (fields.count, fields.velocity_m_per_s) = (9, velocity.as_ptr());
        let advance = |fields: &sturz_fluid_fields, exchange: &mut sturz_exchange| {
            sturz_advance_with_fluid(handle.0, 1e-3, fields, exchange, null_mut(), null_mut())
        };
        assert_eq!(advance(&fields, &mut exchange), SturzRefusedInvalidInput);
        assert!(last().0.ends_with("velocity_m_per_s"), "{:?}", last());
        let mut void_fraction = [9.0; 10];
        (exchange.capacity, exchange.void_fraction) = (9, void_fraction.as_mut_ptr());
        fields.count = 10;
        assert_eq!(advance(&fields, &mut exchange), SturzInvalidArgument);
        assert_eq!(last().1, "exchange.capacity is 9, and the fields have 10 rows: nothing was done");
        assert_eq!(info(&handle).step, 0);
        assert_eq!(sturz_get_exchange(handle.0, &mut exchange), SturzTooSmall);
        assert_eq!((exchange.cells, void_fraction), (10, [9.0; 10]));
        exchange.capacity = 10;
        assert_eq!(advance(&fields, &mut exchange), SturzOk, "{:?}", last());
        assert!(void_fraction.iter().all(|&part| (0.99..=1.0).contains(&part)), "{void_fraction:?}");
        assert_eq!(sturz_remove_fluid(handle.0), SturzOk);
        let gone = sturz_advance(handle.0, 1e-3, &mut exchange, null_mut(), null_mut());
        assert!(gone != SturzOk, "there is no exchange without a fluid");
    }
}

/// The same cells as points: what a finite-volume solver with any mesh gives.
#[test]
fn a_mesh_of_points_takes_up_what_the_ball_gives() {
    let daemon = Daemon::serve("c-points", SCENE, &[]);
    let handle = Handle::of(&daemon);
    let points: Vec<f64> = (0..10).flat_map(|k| [0.0, 0.0, 0.02 * (f64::from(k) + 0.5)]).collect();
    let volumes = [0.04 * 0.04 * 0.02; 10];
    let mesh = sturz_point_mesh { count: 10, points_m: points.as_ptr(), volumes_m3: volumes.as_ptr() };
    let mut fluid = water(&MESH);
    (fluid.structured_mesh, fluid.point_mesh) = (null(), &mesh);
    let (mut interaction, mut exchange) = ([0.0; 30], zeros::<sturz_exchange>());
    (exchange.capacity, exchange.interaction_n_per_m3) = (10, interaction.as_mut_ptr());
    // SAFETY: arrays have ten rows.
    unsafe {
        assert_eq!(sturz_set_fluid(handle.0, &fluid, null()), SturzOk, "{:?}", last());
        assert_eq!(sturz_advance(handle.0, 1e-2, &mut exchange, null_mut(), null_mut()), SturzOk, "{:?}", last());
    }
    let impulse: f64 = interaction.iter().skip(2).step_by(3).map(|force| force * volumes[0] * 1e-2).sum();
    let total = exchange.impulse_on_fluid_n_s[2];
    // The sum over the cells is that over the particles, to rounding.
    assert!(total < 0.0 && (impulse - total).abs() < 1e-12 * total.abs(), "{impulse} {total}");
    assert_eq!((exchange.outside, exchange.cells, exchange.from_time_s), (0, 10, 0.0));
}
