//! A coupled run in the verbs of preCICE, as C makes them, against the real daemon.
#![allow(unsafe_code)]

#[path = "../../rust/tests/common/mod.rs"]
mod common;

use std::ffi::{CStr, CString};
use std::mem;
use std::ptr::{null, null_mut};

use common::Daemon;
use sturz_c::sturz_code::*;
use sturz_c::*;

const SCENE: &str = include_str!("../examples/settling.toml");
const WINDOW_S: f64 = 2e-3;
/// Of water and of a cell, kg: the column is so narrow that the ball matters to it.
const CELL_KG: f64 = 1000.0 * 0.004 * 0.004 * 0.02;

/// As `= {0}` in C.
fn zeros<T>() -> T {
    // SAFETY: used for structs of numbers and pointers, for all of which zeros are sound.
    unsafe { mem::zeroed() }
}

fn message() -> String {
    // SAFETY: of this thread, and read at once.
    unsafe { CStr::from_ptr(sturz_last_error_message()) }.to_str().unwrap().to_owned()
}

/// Water that the ball pulls along, each of ten cells by itself: the smallest solver that has something to save.
#[derive(Clone)]
struct Water {
    velocity: [f64; 30],
}

impl Water {
    fn solve(&mut self, interaction: &[f64; 30], window_s: f64) {
        let cell_m3 = CELL_KG / 1000.0;
        for (velocity, force) in self.velocity.iter_mut().zip(interaction) {
            *velocity += force * cell_m3 * window_s / CELL_KG;
        }
    }
}

fn connect(daemon: &Daemon) -> *mut sturz_simulation {
    let (name, endpoint) = (CString::new(&*daemon.instance).unwrap(), CString::new(&*daemon.endpoint).unwrap());
    let mut simulation = null_mut();
    // SAFETY: texts and place are sound.
    let code = unsafe { sturz_connect(name.as_ptr(), endpoint.as_ptr(), 30.0, &mut simulation) };
    assert_eq!(code, SturzOk, "{}", message());
    simulation
}

fn set_water(simulation: *mut sturz_simulation) {
    let mesh = sturz_structured_mesh {
        origin_m: [-0.002, -0.002, 0.0],
        spacing_m: [0.004, 0.004, 0.02],
        counts: [1, 1, 10],
        low_sides: [0; 3],
        high_sides: [0; 3],
    };
    let mut fluid = sturz_fluid_default();
    (fluid.density_kg_per_m3, fluid.viscosity_pa_s, fluid.smoothing_length_m) = (1000.0, 1e-3, 0.01);
    fluid.structured_mesh = &mesh;
    // SAFETY: all sound.
    assert_eq!(unsafe { sturz_set_fluid(simulation, &fluid, null()) }, SturzOk, "{}", message());
}

/// Marches to 10 ms; iterations of each window, the last velocity of the ball's cell, and the state hash.
fn march(name: &str, coupling: &sturz_coupling) -> (Vec<u32>, f64, u64) {
    let daemon = Daemon::serve(name, SCENE, &[]);
    let simulation = connect(&daemon);
    set_water(simulation);
    let (mut water, mut saved) = (Water { velocity: [0.0; 30] }, None);
    let (mut interaction, mut exchange) = ([0.0; 30], zeros::<sturz_exchange>());
    (exchange.capacity, exchange.interaction_n_per_m3) = (10, interaction.as_mut_ptr());
    let (mut windows, mut iterations) = (Vec::new(), 0);
    let mut info = zeros::<mem::MaybeUninit<sturz_info>>();
    // SAFETY: handles, structs and arrays are sound.
    unsafe {
        let mut run = null_mut();
        let code = sturz_participant_initialize(simulation, coupling, &mut exchange, &mut run);
        assert_eq!(code, SturzOk, "{}", message());
        while sturz_participant_is_coupling_ongoing(run) == 1 {
            if sturz_participant_requires_writing_checkpoint(run) == 1 {
                saved = Some(water.clone());
            }
            let window_s = sturz_participant_window_s(run);
            water.solve(&interaction, window_s);
            let mut fields: sturz_fluid_fields = zeros();
            (fields.count, fields.velocity_m_per_s) = (10, water.velocity.as_ptr());
            fields.ramp_s = if coupling.tolerance > 0.0 { window_s } else { 0.0 };
            assert_eq!(sturz_participant_advance(run, &fields, &mut exchange), SturzOk, "{}", message());
            iterations += 1;
            if sturz_participant_requires_reading_checkpoint(run) == 1 {
                water = saved.clone().unwrap();
            }
            if sturz_participant_is_time_window_complete(run) == 1 {
                windows.push(mem::take(&mut iterations));
            }
        }
        assert!((sturz_participant_time_s(run) - coupling.end_time_s).abs() < 1e-12);
        let none: sturz_fluid_fields = zeros();
        assert_eq!(sturz_participant_advance(run, &none, null_mut()), SturzInvalidArgument);
        assert!(message().starts_with("the end, 0.009 s, is reached"), "{}", message());
        assert_eq!(sturz_participant_finalize(run), SturzOk, "{}", message());
        assert_eq!(sturz_get_info(simulation, info.as_mut_ptr()), SturzOk);
        sturz_close(simulation);
        assert!(daemon.connect().checkpoints().unwrap().is_empty(), "nothing is left behind");
        (windows, water.velocity[9 * 3 + 2], info.assume_init().state_hash)
    }
}

#[test]
fn an_explicit_run_does_each_window_once() {
    let coupling = sturz_coupling { window_s: WINDOW_S, end_time_s: 9e-3, ..zeros() };
    let (windows, velocity, _) = march("c-explicit", &coupling);
    assert_eq!(windows, [1; 5], "the last one is shorter");
    assert!(velocity < 0.0, "the ball pulls the water down: {velocity}");
}

#[test]
fn an_implicit_run_repeats_windows_until_the_fields_stand_and_the_same_each_time() {
    let coupling = sturz_coupling { window_s: WINDOW_S, end_time_s: 9e-3, tolerance: 1e-9, max_iterations: 0 };
    let (windows, velocity, hash) = march("c-implicit", &coupling);
    assert_eq!(windows.len(), 5);
    assert!(windows.iter().all(|&iterations| (2..20).contains(&iterations)), "{windows:?}");
    let looser = sturz_coupling { tolerance: 1e-4, ..coupling };
    let (fewer, other, _) = march("c-looser", &looser);
    assert!(fewer.iter().sum::<u32>() < windows.iter().sum::<u32>(), "{fewer:?} {windows:?}");
    assert!((other - velocity).abs() < 1e-3 * velocity.abs(), "{other} {velocity}");
    assert_eq!(march("c-again", &coupling), (windows, velocity, hash), "to the bit");
}

#[test]
fn what_does_not_converge_is_told_and_leaves_the_particles_at_the_start() {
    let daemon = Daemon::serve("c-diverges", SCENE, &[]);
    let simulation = connect(&daemon);
    let coupling = sturz_coupling { window_s: WINDOW_S, end_time_s: 0.0, tolerance: 1e-9, max_iterations: 3 };
    let mut run = null_mut();
    // SAFETY: handles, structs and arrays are sound.
    unsafe {
        let initialize = |coupling: &sturz_coupling, run: &mut *mut sturz_participant| {
            sturz_participant_initialize(simulation, coupling, null_mut(), run)
        };
        assert_eq!(initialize(&coupling, &mut run), SturzRefusedNotFound, "there is no fluid");
        set_water(simulation);
        assert_eq!(initialize(&sturz_coupling { window_s: 0.0, ..coupling }, &mut run), SturzInvalidArgument);
        assert_eq!(message(), "coupling.window_s is 0; must be finite and above 0");
        assert_eq!(initialize(&sturz_coupling { max_iterations: 1, ..coupling }, &mut run), SturzInvalidArgument);
        assert!(run.is_null());
        assert_eq!(initialize(&coupling, &mut run), SturzOk, "{}", message());
        let mut codes = Vec::new();
        for iteration in 0..3 {
            let velocity = [0.1 * f64::from(iteration + 1); 30];
            let mut fields: sturz_fluid_fields = zeros();
            (fields.count, fields.velocity_m_per_s) = (10, velocity.as_ptr());
            codes.push(sturz_participant_advance(run, &fields, null_mut()));
        }
        assert_eq!(codes, [SturzOk, SturzOk, SturzNotConverged]);
        assert!(message().contains("has not converged in 3 iterations: relative change 3.333e-1"), "{}", message());
        assert_eq!(daemon.connect().info().unwrap().step, 0);
        assert_eq!(sturz_participant_requires_writing_checkpoint(run), 1, "it can be begun again");
        sturz_close(simulation);
        assert_eq!(sturz_participant_finalize(run), SturzOk, "it has a connection of its own");
    }
}
