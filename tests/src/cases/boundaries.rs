//! Boundaries beyond planes and drums: rollers, boxes, meshes, servos.

use std::f64::consts::PI;

use sturz_engine::Engine;

use super::{Case, Checks};
use crate::scene::{SceneText, snapshot};

pub fn cases() -> Vec<Case> {
    vec![Case::fast("BOUNDARY", "rollers, boxes, triangle meshes and servos", boundaries)]
}

const DENSITY: f64 = 2500.0;
const RADIUS: f64 = 0.005;
const STIFFNESS: f64 = 1e5;
const ELASTIC: &str = "stiffness_n_per_m = 1e5\nrestitution = 1.0";
const DAMPED: &str = "stiffness_n_per_m = 1e5\nrestitution = 0.4\nfriction = 0.3";
const DOWN: [f64; 3] = [0.0, 0.0, -9.81];
const BALL: &str = "kind = \"sphere\", radius_m = 0.005";
const SHAPES: [(&str, &str); 3] = [
    ("ball", BALL),
    ("spherocylinder", "kind = \"spherocylinder\", radius_m = 0.003, total_length_m = 0.015"),
    ("cube", "kind = \"cube\", edge_m = 0.01"),
];

type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

fn boundaries(checks: &mut Checks) -> anyhow::Result<()> {
    roller(checks)?;
    box_of_planes(checks)?;
    meshed_plane(checks)?;
    ridge(checks)?;
    block(checks)?;
    tumbling(checks)?;
    rim(checks)?;
    servo(checks)?;
    bed(checks)
}

fn ball_mass() -> f64 {
    DENSITY * 4.0 / 3.0 * PI * RADIUS.powi(3)
}

fn scene(gravity: [f64; 3], dt: f64, law: &str, geometry: &str) -> SceneText {
    SceneText::new(gravity, &format!("time_step_s = {dt:?}")).materials(DENSITY, law).shape(geometry)
}

impl SceneText {
    fn boundary(self, name: &str, geometry: &str, motion: &str) -> Self {
        self.section(&format!(
            "[[boundary]]\nname = \"{name}\"\nmaterial = \"w\"\ngeometry = {{ {geometry} }}\n{motion}"
        ))
    }

    fn mesh(self, (vertices, triangles): &Triangles) -> Self {
        self.boundary("mesh", &format!("kind = \"mesh\", vertices_m = {vertices:?}, triangles = {triangles:?}"), "")
    }
}

/// A sheet of n x n squares over [x0, x1] x [y0, y1], facing up.
fn sheet(n: u32, [x0, x1, y0, y1]: [f64; 4], height: impl Fn(f64) -> f64) -> Triangles {
    let part = |k: u32| f64::from(k) / f64::from(n);
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for j in 0..=n {
        for i in 0..=n {
            let x = x0 + (x1 - x0) * part(i);
            vertices.push([x, y0 + (y1 - y0) * part(j), height(x)]);
            if i < n && j < n {
                let [a, b, c, d] = [0, 1, n + 2, n + 1].map(|k| j * (n + 1) + i + k);
                triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
            }
        }
    }
    (vertices, triangles)
}

/// A closed cube about the origin, facing outwards.
fn cube(half: f64) -> Triangles {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { half } else { -half });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}

fn mechanical(engine: &Engine) -> f64 {
    let e = engine.report().energy;
    e.kinetic_translation_j + e.kinetic_rotation_j + e.potential_j + e.elastic_j
}

/// Largest difference of positions and velocities.
fn difference(a: &Engine, b: &Engine) -> f64 {
    let (a, b) = (snapshot(a), snapshot(b));
    let rows = |x: &[[f64; 3]], y: &[[f64; 3]]| {
        x.as_flattened().iter().zip(y.as_flattened()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    };
    rows(&a.positions, &b.positions).max(rows(&a.velocities, &b.velocities))
}

/// An elastic ball off a roller: a central force keeps the energy and the angular momentum about the axis.
fn roller(checks: &mut Checks) -> anyhow::Result<()> {
    let big = 0.05;
    let x = 0.5 * (RADIUS + big);
    let geometry =
        format!("kind = \"cylinder_outside\", point_m = [0.0, 0.0, -{big}], axis = [0.0, 1.0, 0.0], radius_m = {big}");
    let scene = scene([0.0; 3], 1e-7, ELASTIC, BALL).boundary("roller", &geometry, "");
    let mut engine = scene.particle([x, 0.0, 0.01], [0.0, 0.1, -1.0], [0.0; 3]).start()?;
    let before = mechanical(&engine);
    checks.run_for(&mut engine, 0.04)?;
    let state = snapshot(&engine);
    let (place, v) = (state.positions[0], state.velocities[0]);
    checks.vanishes("roller: energy of an elastic ball", mechanical(&engine) / before - 1.0, 1e-6, "-");
    checks.close("roller: momentum about the axis", v[0] * (place[2] + big) - v[2] * place[0], x, 1e-9, "m2/s");
    Ok(())
}

fn box_of_planes(checks: &mut Checks) -> anyhow::Result<()> {
    let room = "kind = \"box\", min_m = [-0.02, -0.02, 0.0], max_m = [0.02, 0.02, 0.03], open = [\"z+\"]";
    let law = "stiffness_n_per_m = 1e5\nrestitution = 0.4";
    let scene = scene([3.0, 0.0, -9.81], 1e-5, law, BALL).boundary("room", room, "");
    let mut engine = scene.particle([0.0, 0.0, 0.01], [0.0; 3], [0.0; 3]).start()?;
    checks.run_for(&mut engine, 1.0)?;
    let states = snapshot(&engine).boundaries;
    checks.near("box: planes, one side open", states.len() as f64, 5.0, 0.0, "-");
    let force = |name: &str, axis: usize| {
        states.iter().find(|state| state.name == name).map_or(f64::NAN, |state| state.force_n[axis])
    };
    checks.close("box: force on the floor", force("room/z-", 2), -9.81 * ball_mass(), 1e-3, "N");
    checks.close("box: force on a side", force("room/x+", 0), 3.0 * ball_mass(), 1e-3, "N");
    Ok(())
}

/// Sliding over 1800 coplanar triangles is sliding over a plane.
fn meshed_plane(checks: &mut Checks) -> anyhow::Result<()> {
    let floor = sheet(30, [-0.1, 0.3, -0.2, 0.2], |_| 0.0);
    for (name, geometry) in SHAPES {
        let thrown = |scene: SceneText| scene.particle([0.0, 0.0, 0.0062], [0.7, 0.11, -0.05], [1.0, 0.3, 0.2]).start();
        let mut meshed = thrown(scene(DOWN, 2e-6, DAMPED, geometry).mesh(&floor))?;
        let mut flat = thrown(scene(DOWN, 2e-6, DAMPED, geometry).floor())?;
        checks.run_for(&mut meshed, 0.2)?;
        checks.run_for(&mut flat, 0.2)?;
        checks.vanishes(format!("meshed plane: {name} against a plane"), difference(&meshed, &flat), 1e-12, "m, m/s");
    }
    Ok(())
}

/// A ball slides over a convex edge: no jump of the force beyond what the overlap changes by in a step.
fn ridge(checks: &mut Checks) -> anyhow::Result<()> {
    let (dt, speed, slope) = (2e-6, 0.25, 0.15);
    let ridge = sheet(8, [-0.1, 0.1, -0.1, 0.1], |x| -slope * x.abs());
    let start = [-0.012, 0.0, -slope * 0.012 + RADIUS * f64::hypot(1.0, slope)];
    let scene = scene(DOWN, dt, ELASTIC, BALL).mesh(&ridge);
    let mut engine = scene.particle(start, [speed, 0.0, slope * speed], [0.0; 3]).start()?;
    let before = mechanical(&engine);
    let (mut last, mut jump, mut worst) = ([0.0; 3], 0.0f64, 0.0f64);
    for _ in 0..48_000 {
        checks.steps(&mut engine, 1)?;
        let force = snapshot(&engine).boundaries[0].force_n;
        jump = (0..3).map(|k| (force[k] - last[k]).abs()).fold(jump, f64::max);
        last = force;
        worst = worst.max((mechanical(&engine) - before).abs());
    }
    checks.holds("ridge: the ball is on the other side", snapshot(&engine).positions[0][0] > 0.005);
    checks.vanishes("ridge: energy over the kinetic one", worst / (0.5 * ball_mass() * speed * speed), 1e-5, "-");
    checks.vanishes("ridge: step of the force over k v dt", jump / (STIFFNESS * speed * dt), 1.5, "-");
    Ok(())
}

/// Balls straight onto a face, an edge and a corner of a closed cube: half an oscillation each.
fn block(checks: &mut Checks) -> anyhow::Result<()> {
    let (half, gap) = (0.02, 1e-4);
    let quarter = 0.5 * PI * (ball_mass() / STIFFNESS).sqrt();
    for (name, towards) in [("face", [1.0, 0.0, 0.0]), ("edge", [1.0, 0.0, -1.0]), ("corner", [1.0, 1.0, 1.0])] {
        let norm = towards.iter().map(|c: &f64| c * c).sum::<f64>().sqrt();
        let n = towards.map(|c| c / norm);
        let start = [0, 1, 2].map(|k| towards[k] * half + n[k] * (RADIUS + gap));
        let scene = scene([0.0; 3], 1e-7, ELASTIC, BALL).mesh(&cube(half));
        let mut engine = scene.particle(start, n.map(|c| -c), [0.0; 3]).start()?;
        checks.run_for(&mut engine, gap + quarter)?;
        let deepest = (ball_mass() / STIFFNESS).sqrt();
        checks.close(format!("block, {name}: overlap"), engine.report().largest_overlap_m, deepest, 1e-4, "m");
        checks.run_for(&mut engine, gap + quarter)?;
        let v = snapshot(&engine).velocities[0];
        let off = (0..3).map(|k| (v[k] - n[k]).abs()).fold(0.0, f64::max);
        checks.vanishes(format!("block, {name}: velocity after"), off, 1e-9, "m/s");
    }
    Ok(())
}

/// Elastic parts that tumble against faces, edges and corners.
fn tumbling(checks: &mut Checks) -> anyhow::Result<()> {
    for (name, geometry) in SHAPES {
        let mut worst = 0.0f64;
        for k in 0..8 {
            let a = f64::from(k);
            let start = [0.024 + 0.002 * a.sin(), 0.017 + 0.0015 * a, 0.03];
            let scene = scene([0.0; 3], 1e-6, ELASTIC, geometry).mesh(&cube(0.02));
            let mut engine = scene.particle(start, [-0.4, -0.3, -0.5], [40.0 * a.cos(), 30.0, -20.0]).start()?;
            let before = mechanical(&engine);
            checks.run_for(&mut engine, 0.06)?;
            worst = worst.max((mechanical(&engine) / before - 1.0).abs());
        }
        checks.vanishes(format!("block: energy of a tumbling {name}, worst of 8"), worst, 3e-5, "-");
    }
    Ok(())
}

/// A flat box rests half over the rim of a table of triangles.
fn rim(checks: &mut Checks) -> anyhow::Result<()> {
    let table = sheet(6, [-0.3, 0.0, -0.2, 0.2], |_| 0.0);
    let pair = "stiffness_n_per_m = 1e6\nrestitution = 0.2\nfriction = 0.5";
    let scene = scene(DOWN, 5e-6, pair, "kind = \"box\", size_m = [0.1, 0.08, 0.02]").mesh(&table);
    let mut engine = scene.particle([-0.01, 0.01, 0.01], [0.0; 3], [0.0; 3]).start()?;
    checks.run_for(&mut engine, 0.6)?;
    let state = snapshot(&engine);
    let weight = DENSITY * 0.1 * 0.08 * 0.02 * 9.81;
    let spin = state.angular_velocities[0].iter().fold(0.0f64, |worst, w| worst.max(w.abs()));
    checks.vanishes("rim: angular velocity at rest", spin, 1e-3, "rad/s");
    checks.close("rim: force on the table", -state.boundaries[0].force_n[2], weight, 1e-3, "N");
    Ok(())
}

/// A lid on a column of four balls.
fn servo(checks: &mut Checks) -> anyhow::Result<()> {
    let motion = "motion = { kind = \"servo\", direction = [0.0, 0.0, -1.0], force_n = 5.0, gain_m_per_s_per_n = 1e-3, max_velocity_m_per_s = 0.02 }";
    let mut scene = scene(DOWN, 1e-5, DAMPED, BALL).floor().boundary(
        "lid",
        "kind = \"plane\", point_m = [0.0, 0.0, 0.0402], normal = [0.0, 0.0, -1.0]",
        motion,
    );
    for k in 0..4 {
        scene = scene.particle([0.0, 0.0, RADIUS * f64::from(2 * k + 1)], [0.0; 3], [0.0; 3]);
    }
    let mut engine = scene.start()?;
    checks.run_for(&mut engine, 0.6)?;
    let mut worst = 0.0f64;
    for _ in 0..50 {
        checks.run_for(&mut engine, 0.01)?;
        worst = worst.max((snapshot(&engine).boundaries[1].force_n[2] - 5.0).abs());
    }
    checks.vanishes("servo: force off its target of 5 N, from 0.6 to 1.1 s", worst, 5e-3, "N");
    let energy = engine.report().energy;
    checks.vanishes("servo: residual over the work", energy.residual_j / energy.work_boundaries_j, 1e-5, "-");
    Ok(())
}

/// 900 balls on a floor of 7200 triangles and on a plane; the wall time of both rows is the price of the mesh.
fn bed(checks: &mut Checks) -> anyhow::Result<()> {
    let lattice = "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nplacement = { method = \"lattice\", origin_m = [0.0, 0.0, 0.0051], spacing_m = [0.0101, 0.0101, 0.01], counts = [30, 30, 1] }";
    let floor = sheet(60, [-0.05, 0.35, -0.05, 0.35], |_| 0.0);
    let start = |scene: SceneText| scene.section(lattice).start();
    let mut flat = start(scene(DOWN, 1e-5, DAMPED, BALL).floor())?;
    let mut meshed = start(scene(DOWN, 1e-5, DAMPED, BALL).mesh(&floor))?;
    checks.run_for(&mut flat, 0.02)?;
    checks.holds("bed of 900 on a plane: touching", flat.report().touching_boundary_pairs == 900);
    checks.run_for(&mut meshed, 0.02)?;
    checks.holds("bed of 900 on 7200 triangles: touching", meshed.report().touching_boundary_pairs == 900);
    checks.vanishes("bed: on triangles against on a plane", difference(&flat, &meshed), 1e-12, "m, m/s");
    Ok(())
}
