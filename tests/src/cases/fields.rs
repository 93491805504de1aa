//! C1 to C4 and C6: coarse-grained fields against closed forms, the fixture of the oracle, and the weight above.
//!
//! Seed 003 (Hidalgo et al.) prints the kernel exp(-(R / 2w)^2) cut at 6 w; D = w^2 belongs to exp(-R^2 / (2 w^2)).

use std::f64::consts::PI;

use anyhow::Context as _;
use sturz_engine::fields::{
    AverageWindow, FieldAverage, FieldDefinition, FieldFrame, FieldMean, FieldQuantity as Q, FieldSources, Grid,
    compute,
};
use sturz_engine::scene::Scene;
use sturz_engine::{ContactNetwork, ContactRow, Snapshot};

use super::{Case, Checks};
use crate::scene::SceneText;

pub fn cases() -> Vec<Case> {
    vec![
        Case::fast("C1", "the second moment of the kernel, as printed and as meant", second_moments),
        Case::fast("C2", "density, velocity, kinetic stress and D of a fixed lattice", fixture),
        Case::fast("C3", "kinetic stress grows with the width in shear, T^k does not", shear),
        Case::fast("C4", "contact stress in a column of spheres", column_of_spheres),
        Case::fast("C6", "sigma_zz of a bed at rest is the weight above", bed),
    ]
}

/// Unit masses.
pub(super) fn unit_spheres() -> anyhow::Result<Scene> {
    let law = "stiffness_n_per_m = 1e4\nrestitution = 0.5";
    let scene = SceneText::new([0.0; 3], "time_step_s = 1e-5")
        .materials(6.0 / PI, law)
        .shape("kind = \"sphere\", radius_m = 0.5")
        .floor();
    Ok(scene.validate()?)
}

pub(super) fn state(positions: Vec<[f64; 3]>, velocities: Vec<[f64; 3]>) -> Snapshot {
    let n = positions.len();
    Snapshot {
        ids: (0..n as u64).collect(),
        shapes: vec![0; n],
        materials: vec![0; n],
        scales: vec![1.0; n],
        orientations: vec![[1.0, 0.0, 0.0, 0.0]; n],
        angular_velocities: vec![[0.0; 3]; n],
        positions,
        velocities,
        ..Snapshot::default()
    }
}

/// A grid of eight cells whose first is centred at a point.
pub(super) fn at(point: [f64; 3]) -> Grid {
    Grid { min_m: point.map(|x| x - 0.05), max_m: point.map(|x| x + 0.15), cells: [2; 3], cylinder: None }
}

pub(super) fn numbers(frame: &FieldFrame, quantity: Q) -> anyhow::Result<&[f64]> {
    let column = frame.columns.iter().find(|column| column.quantity == quantity);
    Ok(&column.with_context(|| format!("no column {}", quantity.name()))?.data)
}

/// Reference: the integrals of PHYSICS.md C1. A lattice of spacing h takes them with an error of exp(-2 pi^2 w^2 / h^2) and of
/// the points that the cut passes by, a part of 1e-3 of what is cut off.
fn second_moments(checks: &mut Checks) -> anyhow::Result<()> {
    let scene = unit_spheres()?;
    let spacing = 0.4;
    let line = || (-16..=16).map(|k| f64::from(k) * spacing);
    let positions = line().flat_map(|x| line().flat_map(move |y| line().map(move |z| [x, y, z]))).collect::<Vec<_>>();
    let n = positions.len();
    let state = state(positions, vec![[0.0; 3]; n]);
    let sources = FieldSources::new(&scene, &state, None)?;
    let root = 2.0_f64.sqrt();
    for (name, width, cutoff, wanted, tolerance) in [
        ("exp(-R^2/(2 w^2)), 6 w: D / w^2", 1.0, 6.0, 0.999_999_1, 1e-6),
        ("exp(-R^2/(2 w^2)), 3 w: D / w^2", 1.0, 3.0, 0.917_82, 1e-2),
        ("exp(-(R/2w)^2), 6 w as printed: D / w^2", root, 6.0 / root, 1.994_985, 1e-3),
    ] {
        let definition = FieldDefinition::new("c1", at([0.0; 3]), &[Q::SecondMoment], width);
        let frame = compute(&FieldDefinition { cutoff_widths: cutoff, ..definition }, &sources)?;
        checks.near(name, numbers(&frame, Q::SecondMoment)?[0], wanted, tolerance, "-");
    }
    Ok(())
}

/// Reference: `oracles/coarse_graining.py`, a sum in numpy.
fn fixture(checks: &mut Checks) -> anyhow::Result<()> {
    let scene = unit_spheres()?;
    let line = || (0..24).map(|k| (f64::from(k) + 0.5) * 0.5);
    let positions = line().flat_map(|x| line().flat_map(move |y| line().map(move |z| [x, y, z]))).collect::<Vec<_>>();
    let velocity = |[x, y, z]: [f64; 3]| [y - 6.0 + 0.1 * (3.0 * x).sin(), 0.1 * (2.0 * y).cos(), 0.1 * (x + z).sin()];
    let velocities = positions.iter().map(|&x| velocity(x)).collect();
    let state = state(positions, velocities);
    let sources = FieldSources::new(&scene, &state, None)?;
    let width = 0.5 * 2.0_f64.sqrt();
    let quantities = [Q::Density, Q::Velocity, Q::KineticStress, Q::SecondMoment];
    let definition = FieldDefinition::new("c2", at([6.1, 5.9, 6.05]), &quantities, width);
    let frame = compute(&FieldDefinition { cutoff_widths: 3.0 / width, ..definition }, &sources)?;
    checks.near("rho", numbers(&frame, Q::Density)?[0], 8.000_277_925_652_7, 1e-12, "-");
    let velocity = numbers(&frame, Q::Velocity)?;
    for (k, wanted) in [-0.105_516_024_167, 0.026_516_169_887, -0.024_543_504_713].into_iter().enumerate() {
        checks.near(format!("V[{k}]"), velocity[k], wanted, 1e-12, "-");
    }
    checks.near("sigma^k_xx", numbers(&frame, Q::KineticStress)?[0], 4.030_623_173_431, 1e-12, "-");
    for (k, wanted) in [0.498_843, 0.498_843, 0.498_821].into_iter().enumerate() {
        checks.near(format!("D[{k}{k}]"), numbers(&frame, Q::SecondMoment)?[4 * k], wanted, 5e-7, "-");
    }
    Ok(())
}

/// Uniform gas in shear, 60 realisations of 20000 particles: sigma^k_xx = rho (T + D gdot^2), T^k_xx = rho T at every width.
/// Tolerance: four standard errors of the mean over the realisations.
fn shear(checks: &mut Checks) -> anyhow::Result<()> {
    const N: u64 = 20_000;
    let (side, temperature, rate) = (12.0, 0.04_f64, 1.0);
    let scene = unit_spheres()?;
    let quantities =
        [Q::Density, Q::KineticStress, Q::KineticStressScaleFree, Q::KineticStressAboutParticles, Q::ShearRate];
    // homogeneous along x and z, in the middle half along y
    let grid = Grid { min_m: [0.0, 5.0, 0.0], max_m: [side, 7.0, side], cells: [1, 8, 1], cylinder: None };
    let definition = FieldDefinition {
        more_widths_m: vec![0.5, 0.75, 1.0],
        average: Some(FieldAverage {
            every_steps: 1,
            samples_per_block: 1,
            blocks: 60,
            window: AverageWindow::Growing,
            from_time_s: 0.0,
        }),
        ..FieldDefinition::new("c3", grid, &quantities, 0.25)
    };
    let mut mean = FieldMean::new(&definition).context("a mean")?;
    let mut random = Draws { index: 1 };
    for _ in 0..60 {
        let (mut positions, mut velocities) = (Vec::new(), Vec::new());
        for _ in 0..N {
            let u = random.next();
            let x = [u[0] * side, u[1] * side, u[2] * side];
            let more = random.next();
            let noise =
                [normal(u[3], u[4]), normal(u[5], more[0]), normal(more[1], more[2])].map(|v| v * temperature.sqrt());
            positions.push(x);
            velocities.push([noise[0] + rate * (x[1] - 0.5 * side), noise[1], noise[2]]);
        }
        mean.add(&FieldSources::new(&scene, &state(positions, velocities), None)?)?;
    }
    let frame = mean.frame().context("60 samples")?;
    let mut widths = vec![(frame.width_m, &frame.columns)];
    widths.extend(frame.more_widths.iter().map(|more| (more.width_m, &more.columns)));
    for (width, columns) in widths {
        // mean over the cells, whose errors are taken as if they were one
        let mean = |k: usize, component: usize| {
            let step = columns[k].components;
            let over = |data: &[f64]| data.iter().skip(component).step_by(step).sum::<f64>() / 8.0;
            let error = columns[k].standard_error.as_deref().map_or(f64::INFINITY, over);
            (over(&columns[k].data), error)
        };
        let rho = mean(0, 0).0;
        let unit = rho * temperature;
        let d = width * width * 0.998_929_29;
        // T^k has the noise of the gradient, 2 D gdot times its error; the others that of T
        for (name, k, wanted, most) in [
            ("sigma^k_xx / (rho T)", 1, 1.0 + d * rate * rate / temperature, 0.02),
            ("T^k_xx / (rho T)", 2, 1.0, 0.08),
            ("T_xx about V(r_i) / (rho T)", 3, 1.0, 0.02),
        ] {
            let (value, error) = mean(k, 0);
            checks.near(format!("w = {width}: {name}"), value / unit, wanted, 4.0 * error / unit, "-");
            checks.holds(format!("w = {width}: error of {name} below {most}"), error / unit < most * wanted);
        }
        let (yy, error) = mean(1, 4);
        checks.near(format!("w = {width}: sigma^k_yy / (rho T)"), yy / unit, 1.0, 4.0 * error / unit, "-");
        checks.close(format!("w = {width}: shear rate"), mean(4, 0).0, rate, 0.02, "1/s");
    }
    Ok(())
}

/// Numbers in [0, 1)^6.
pub(super) struct Draws {
    pub index: u64,
}

impl Draws {
    pub fn next(&mut self) -> [f64; 6] {
        // splitmix64 of the index: reproducible, and independent from axis to axis
        self.index += 1;
        std::array::from_fn(|axis| {
            let mut z = (self.index * 6 + axis as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        })
    }
}

/// Box and Muller.
pub(super) fn normal(u: f64, v: f64) -> f64 {
    (-2.0 * (1.0 - u).ln()).sqrt() * (2.0 * PI * v).cos()
}

/// Reference: force balance. Positive in compression.
fn column_of_spheres(checks: &mut Checks) -> anyhow::Result<()> {
    let scene = unit_spheres()?;
    let state = state((0..6).map(|i| [0.0, 0.0, 0.5 + f64::from(i)]).collect(), vec![[0.0; 3]; 6]);
    let mut network = ContactNetwork::default();
    for i in 0..6_u64 {
        let (force, height) = (6.0 - i as f64, i as f64);
        let below = ContactRow { point_m: [0.0, 0.0, height], normal_force_n: force, ..ContactRow::default() };
        network.rows.push(match i.checked_sub(1) {
            None => ContactRow { id_a: 0, boundary: Some(0), normal: [0.0, 0.0, -1.0], ..below },
            Some(lower) => ContactRow { id_a: lower, id_b: Some(i), normal: [0.0, 0.0, 1.0], ..below },
        });
    }
    network.rows.sort_by_key(|row| (row.id_a, row.id_b.unwrap_or(u64::MAX)));
    let sources = FieldSources::new(&scene, &state, Some(&network))?;
    let grid = Grid { min_m: [-0.5, -0.5, -2.025], max_m: [0.5, 0.5, 8.025], cells: [1, 1, 201], cylinder: None };
    let definition = FieldDefinition::new("c4", grid, &[Q::ContactStress], 0.3);
    let frame = compute(&FieldDefinition { cutoff_widths: 6.0, ..definition }, &sources)?;
    let zz = |k: usize| numbers(&frame, Q::ContactStress).map(|stress| stress[9 * k + 8]);
    let total = (0..201).map(zz).sum::<anyhow::Result<f64>>()? * 0.05;
    checks.near("integral over the volume", total, 18.0, 1e-6, "N m");
    for (height, wanted) in [(1.5, 4.5), (2.0, 4.0), (3.0, 3.0), (4.0, 2.0), (5.0, 1.0)] {
        let k = ((height + 2.0) / 0.05_f64).round() as usize;
        checks.near(format!("integral over the plane z = {height}"), zz(k)?, wanted, 1e-4, "N");
    }
    Ok(())
}

/// Spheres of 0.9 to 1.1 of a size on a floor, at rest: div sigma = rho g integrated from above. Tolerance: 1 % of the weight,
/// which is what the bed still moves by.
fn bed(checks: &mut Checks) -> anyhow::Result<()> {
    let (side, g) = (0.02, 9.81);
    let law = "stiffness_n_per_m = 2e3\nrestitution = 0.5\nfriction = 0.3";
    let mut engine = SceneText::new([0.0, 0.0, -g], "time_step_s = 1e-5")
        .materials(2500.0, law)
        .section("[integrator]\nlocal_damping = 0.3")
        .section(&format!("[domain]\nmin_m = [0.0, 0.0, 0.0]\nmax_m = [{side}, {side}, 0.0]\nperiodic = [true, true, false]"))
        .shape("kind = \"sphere\", radius_m = 1e-3")
        .floor()
        .section(
            "[[insertion]]\nshape = \"s\"\nmaterial = \"m\"\nscale = { min = 0.9, max = 1.1 }\n\
             placement = { method = \"lattice\", origin_m = [0.001, 0.001, 0.0012], spacing_m = [0.0025, 0.0025, 0.0024], \
             counts = [8, 8, 10] }",
        )
        .start()?;
    checks.steps(&mut engine, 30_000)?;
    let report = engine.report();
    checks.holds("the bed is at rest", report.energy.kinetic_translation_j < 1e-6 * report.energy.potential_j.abs());
    let grid = Grid { min_m: [0.0; 3], max_m: [side, side, 0.03], cells: [1, 1, 150], cylinder: None };
    let quantities = [Q::Density, Q::Stress, Q::WallForceDensity];
    let definition = FieldDefinition::new("c6", grid, &quantities, 1.5e-3);
    let frame = engine.compute_field(&FieldDefinition { wall_correction: true, ..definition });
    let (density, stress) = (numbers(&frame, Q::Density)?, numbers(&frame, Q::Stress)?);
    let dz = 2e-4;
    let mass = density.iter().sum::<f64>() * dz * side * side;
    checks.close("integral of the density, corrected at the floor", mass, frame.total_mass_kg, 1e-4, "kg");
    let weight = frame.total_mass_kg * g / (side * side);
    for height in [0.008, 0.01, 0.012, 0.014] {
        let k = (height / dz).round() as usize;
        let above = (density[k + 1..].iter().sum::<f64>() + 0.5 * density[k]) * dz * g;
        checks.near(format!("sigma_zz at {height} m"), stress[9 * k + 8], above, 0.01 * weight, "Pa");
        checks.vanishes(format!("sigma_xz at {height} m"), stress[9 * k + 2], 0.01 * weight, "Pa");
    }
    let traction: f64 = numbers(&frame, Q::WallForceDensity)?.iter().skip(2).step_by(3).sum::<f64>() * dz;
    checks.close("traction on the floor", -traction, weight, 0.01, "Pa");
    Ok(())
}
