//! The example in C, compiled as a user would, against the real daemon.

#[path = "../../rust/tests/common/mod.rs"]
mod common;

use std::env;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use common::Daemon;
use sturz_client::{Exchange, FluidFields, Simulation, Window, v1};

const SCENE: &str = include_str!("../examples/settling.toml");
const CELLS: usize = 50;
/// Area of the column, m2, and height of a cell, m.
const COLUMN: (f64, f64) = (4e-4, 4e-3);
/// Of the ball, m.
const DIAMETER: f64 = 1e-3;

/// Compiles the example against the shared library that cargo has built beside this test.
fn compiled(folder: &Path) -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let test = env::current_exe().unwrap();
    let libraries = test.parent().unwrap();
    let program = folder.join("settling");
    let output = Command::new("cc")
        .args(["-std=c99", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror"])
        .arg(package.join("examples/settling.c"))
        .arg(format!("-I{}", package.join("include").display()))
        .arg(format!("-L{}", libraries.display()))
        .arg(format!("-Wl,-rpath,{}", libraries.display()))
        .args(["-lsturz_c", "-lm", "-o"])
        .arg(&program)
        .output()
        .expect("there is a C compiler `cc`: the tests need a C toolchain");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    program
}

fn run(program: &Path, name: &str, endpoint: &str) -> Output {
    Command::new(program).args([name, endpoint]).output().unwrap()
}

/// Speed at which weight and buoyancy balance Schiller and Naumann's drag, m/s.
fn terminal_speed() -> f64 {
    let (viscosity, weight) = (1e-3, 1500.0 * 9.81 * PI / 6.0 * DIAMETER.powi(3));
    let drag = |speed: f64| {
        let reynolds = 1000.0 * speed * DIAMETER / viscosity;
        3.0 * PI * viscosity * DIAMETER * speed * (1.0 + 0.15 * reynolds.powf(0.687))
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if drag(middle) < weight { low = middle } else { high = middle }
    }
    low
}

/// The same march by the Rust client; the lines that the example prints.
fn marched(simulation: &Simulation) -> Vec<String> {
    let vec3 = |x, y, z| Some(v1::Vec3 { x, y, z });
    let mesh = v1::StructuredMesh {
        origin_m: vec3(-0.01, -0.01, 0.0),
        spacing_m: vec3(0.02, 0.02, COLUMN.1),
        count_x: 1,
        count_y: 1,
        count_z: CELLS as u32,
        ..Default::default()
    };
    let fluid = v1::FluidDefinition {
        density_kg_per_m3: 1000.0,
        viscosity_pa_s: 1e-3,
        mesh: Some(v1::fluid_definition::Mesh::Structured(mesh)),
        smoothing_length_m: Some(8e-3),
        drag: v1::DragLaw::SchillerNaumann.into(),
        voidage: v1::VoidageLaw::None.into(),
        buoyancy: true,
        ..Default::default()
    };
    let mut water = FluidFields { velocity_m_per_s: vec![[0.0; 3]; CELLS], ..FluidFields::default() };
    simulation.set_fluid(Some(fluid), Some(water.clone())).unwrap();
    let solve = |exchange: &Exchange| {
        let (void_fraction, solid) = (exchange.void_fraction().unwrap(), exchange.solid_velocity_m_per_s().unwrap());
        let cells = void_fraction.iter().zip(&solid);
        cells.map(|(void_fraction, solid)| [0.0, 0.0, -(1.0 - void_fraction) * solid[2] / void_fraction]).collect()
    };
    let mut lines = Vec::new();
    for window in 1..=200 {
        let asked = Window::new(5e-3).with_columns(["positions", "velocities"]).with_fluid(water.clone());
        let done = simulation.advance(asked).unwrap();
        water.velocity_m_per_s = solve(done.exchange.as_ref().unwrap());
        let state = done.state.unwrap();
        let (height, speed) = (state.positions_m().unwrap()[0][2], -state.velocities_m_per_s().unwrap()[0][2]);
        if window % 20 == 0 {
            lines.push(format!("time {:.3} s  height {height:.6} m  speed {speed:.9} m/s", state.time_s()));
        }
    }
    lines
}

#[test]
fn the_ball_settles_as_in_rust_and_at_the_terminal_speed() {
    let daemon = Daemon::serve("settling-c", SCENE, &[]);
    let program = compiled(&common::folder("settling-c-built"));
    let output = run(&program, &daemon.instance, &daemon.endpoint);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let other = Daemon::serve("settling-rust", SCENE, &[]);
    assert_eq!(lines, marched(&other.connect()));

    let speed: f64 = lines.last().unwrap().rsplit("speed ").next().unwrap().trim_end_matches(" m/s").parse().unwrap();
    // The water that the ball displaces flows past it: at most as the ball's part of one cell says, of its speed.
    let most = PI / 6.0 * DIAMETER.powi(3) / (COLUMN.0 * COLUMN.1);
    let relative = 1.0 - speed / terminal_speed();
    assert!((0.0..most).contains(&relative), "{speed} m/s, alone {} m/s", terminal_speed());
}

#[test]
fn what_goes_wrong_ends_the_example_with_the_reason() {
    let daemon = Daemon::serve("settling-bad", SCENE, &[]);
    let program = compiled(&common::folder("settling-bad-built"));
    let failed = |name: &str, endpoint: &str| {
        let output = run(&program, name, endpoint);
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8(output.stderr).unwrap()
    };
    let text = failed("nobody", &daemon.endpoint);
    assert!(text.contains("connect: no simulation \"nobody\" is alive") && text.contains("(code 3"), "{text}");
    let text = failed(&daemon.instance, "nonsense");
    assert!(text.contains("\"nonsense\" is no endpoint") && text.contains("(code 1"), "{text}");
    let holder = daemon.connect();
    holder.acquire_lease().unwrap();
    let text = failed(&daemon.instance, &daemon.endpoint);
    assert!(text.contains("lease: acquire_lease refused (LEASE") && text.contains("(code 115"), "{text}");
}
