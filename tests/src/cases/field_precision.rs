//! WP5: error of coarse-grained fields against what they cost: spacing of the grid, support of the kernel, width, number of
//! snapshots. Kernel of width w: exp(-R^2 / (2 w^2)).

use std::f64::consts::PI;
use std::time::Instant;

use sturz_engine::fields::{FieldDefinition, FieldKernel, FieldQuantity as Q, FieldSources, Grid, compute};
use sturz_engine::scene::Scene;

use super::fields::{Draws, at, normal, numbers, state, unit_spheres};
use super::{Case, Checks};

pub fn cases() -> Vec<Case> {
    vec![Case::fast("WP5", "fields: error against grid spacing, support, width and snapshots", work_precision)]
}

fn work_precision(checks: &mut Checks) -> anyhow::Result<()> {
    let scene = unit_spheres()?;
    spacing(checks, &scene)?;
    support(checks, &scene)?;
    snapshots(checks, &scene)
}

/// Runs it `times` times: what it gave last, and the median wall time, s.
fn timed<T>(times: usize, mut run: impl FnMut() -> anyhow::Result<T>) -> anyhow::Result<(T, f64)> {
    let mut walls = Vec::new();
    loop {
        let start = Instant::now();
        let found = run()?;
        walls.push(start.elapsed().as_secs_f64());
        if walls.len() == times {
            walls.sort_by(f64::total_cmp);
            return Ok((found, walls[times / 2]));
        }
    }
}

/// Mass of a sphere in the middle of a cell, summed over the grid: a quadrature of the kernel, which errs by what aliases.
/// Poisson's sum gives it for the Gaussian, (1 + 2 sum of exp(-2 pi^2 k^2 w^2 / h^2))^3 - 1, to the 2e-7 that the support
/// of 6 w cuts off: the error falls faster than any power of h. Lucy's kernel has three derivatives to lose.
fn spacing(checks: &mut Checks, scene: &Scene) -> anyhow::Result<()> {
    let state = state(vec![[0.0; 3]], vec![[0.0; 3]]);
    let sources = FieldSources::new(scene, &state, None)?;
    let mut curves = [Vec::new(), Vec::new()];
    for ratio in [2.5_f64, 2.0, 1.75, 1.5, 1.25, 1.0] {
        for (kernel, curve) in [FieldKernel::Gaussian, FieldKernel::Lucy].into_iter().zip(&mut curves) {
            let (cutoff, width) = if kernel == FieldKernel::Lucy { (1.0, 3.0) } else { (6.0, 1.0) };
            let half_cells = (6.5 / ratio).ceil() as u32 + 1;
            let edge = (f64::from(half_cells) - 0.5) * ratio;
            let grid = Grid { min_m: [-edge; 3], max_m: [edge; 3], cells: [2 * half_cells - 1; 3], cylinder: None };
            let definition = FieldDefinition::new("wp5", grid, &[Q::Density], width);
            let definition = FieldDefinition { cutoff_widths: cutoff, kernel, ..definition };
            let (frame, wall) = timed(5, || Ok(compute(&definition, &sources)?))?;
            let mass = numbers(&frame, Q::Density)?.iter().sum::<f64>() * ratio.powi(3);
            if kernel == FieldKernel::Gaussian {
                let images = |k: f64| (-2.0 * (PI * k / ratio).powi(2)).exp();
                let wanted = (1.0 + 2.0 * (1..4).map(|k| images(f64::from(k))).sum::<f64>()).powi(3) - 1.0;
                checks.near(format!("error of the mass, h = {ratio} w"), mass - 1.0, wanted, 2e-7 + 1e-6 * wanted, "-");
            }
            curve.push((ratio, wall, (mass - 1.0).abs()));
        }
    }
    let step = "spacing of the grid over the width";
    checks.work_precision("error of the integral of the density", step, "Gaussian, cut at 6 w", &curves[0]);
    checks.work_precision("error of the integral of the density", step, "Lucy, support 3", &curves[1]);
    Ok(())
}

/// Second moment D of a lattice of spheres: what a support of c widths leaves of w^2, int R^4 exp / (3 int R^2 exp).
/// Tolerance: the lattice takes the ball of the support with an error of some 0.3 % at this spacing, as a mean over places.
fn support(checks: &mut Checks, scene: &Scene) -> anyhow::Result<()> {
    let line = || (-25..=25).map(|k| f64::from(k) * 0.25);
    let positions = line().flat_map(|x| line().flat_map(move |y| line().map(move |z| [x, y, z]))).collect::<Vec<_>>();
    let n = positions.len();
    let state = state(positions, vec![[0.0; 3]; n]);
    let sources = FieldSources::new(scene, &state, None)?;
    let mut curve = Vec::new();
    for cutoff in [2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0] {
        let definition = FieldDefinition::new("wp5", at([0.0; 3]), &[Q::SecondMoment], 1.0);
        let definition = FieldDefinition { cutoff_widths: cutoff, ..definition };
        let (frame, wall) = timed(5, || Ok(compute(&definition, &sources)?))?;
        // eight places in the lattice, three axes
        let moments = numbers(&frame, Q::SecondMoment)?;
        let moment = (0..72).filter(|k| k % 9 % 4 == 0).map(|k| moments[k]).sum::<f64>() / 24.0;
        let wanted = moment_within(cutoff);
        checks.near(format!("D / w^2, support {cutoff} w"), moment, wanted, 3e-3, "-");
        curve.push((cutoff, wall, 1.0 - wanted));
    }
    checks.work_precision("part of w^2 that D lacks", "support over the width", "Gaussian", &curve);
    Ok(())
}

/// Integrals by Simpson's rule.
fn moment_within(cutoff: f64) -> f64 {
    let cells = 2000;
    let step = cutoff / f64::from(cells);
    let sum = |power: i32| -> f64 {
        let value = |k: i32| {
            let r = f64::from(k) * step;
            r.powi(power) * (-0.5 * r * r).exp() * if k == 0 || k == cells { 1.0 } else { f64::from(2 + 2 * (k % 2)) }
        };
        (0..=cells).map(value).sum()
    };
    sum(4) / (3.0 * sum(2))
}

/// T^k_xx of a gas in shear (C3): rms error over the cells and over groups of snapshots, which falls with their number as
/// n^(-1/2). Tolerance: two and a half standard errors of the slope, with 16 groups of 8 in two cells.
fn snapshots(checks: &mut Checks, scene: &Scene) -> anyhow::Result<()> {
    const COUNT: usize = 128;
    let (side, temperature) = (6.0, 0.04_f64);
    let mut random = Draws { index: 1 << 40 };
    for width in [0.25, 0.5] {
        let grid = Grid { min_m: [0.0, 2.0, 0.0], max_m: [side, 6.0, side], cells: [1, 2, 1], cylinder: None };
        let definition = FieldDefinition::new("wp5", grid, &[Q::Density, Q::KineticStressScaleFree], width);
        let mut errors = Vec::new();
        let start = Instant::now();
        for _ in 0..COUNT {
            let (positions, velocities) = gas(&mut random, (side, 8.0), temperature);
            let sample = state(positions, velocities);
            let frame = compute(&definition, &FieldSources::new(scene, &sample, None)?)?;
            let density = numbers(&frame, Q::Density)?;
            let stress = numbers(&frame, Q::KineticStressScaleFree)?;
            errors.push([0, 1].map(|cell| stress[9 * cell] / (density[cell] * temperature) - 1.0));
        }
        let wall = start.elapsed().as_secs_f64() / COUNT as f64;
        let mut curve = Vec::new();
        for group in [1, 2, 4, 8] {
            let of_group = |errors: &[[f64; 2]], cell: usize| {
                (errors.iter().map(|error| error[cell]).sum::<f64>() / errors.len() as f64).powi(2)
            };
            let squares: f64 =
                errors.chunks(group).map(|errors| of_group(errors, 0) + of_group(errors, 1)).sum::<f64>();
            let error = (squares / (2 * COUNT / group) as f64).sqrt();
            checks.shows(format!("w = {width}: rms error of T^k_xx over {group} snapshots"), error, "-");
            curve.push((group as f64, wall * group as f64, error));
        }
        let slope = (curve[3].2 / curve[0].2).log2() / 3.0;
        checks.near(format!("w = {width}: order in the number of snapshots"), slope, -0.5, 0.15, "-");
        checks.work_precision("relative error of T^k_xx", "snapshots", &format!("w = {width} d"), &curve);
    }
    Ok(())
}

/// Uniform, in shear dv_x/dy = 1, 12 per unit of volume.
fn gas(random: &mut Draws, (side, height): (f64, f64), temperature: f64) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let count = (12.0 * side * side * height) as usize;
    let one = |_| {
        let (u, more) = (random.next(), random.next());
        let x = [u[0] * side, u[1] * height, u[2] * side];
        let noise =
            [normal(u[3], u[4]), normal(u[5], more[0]), normal(more[1], more[2])].map(|v| v * temperature.sqrt());
        (x, [noise[0] + x[1] - 0.5 * height, noise[1], noise[2]])
    };
    (0..count).map(one).unzip()
}
