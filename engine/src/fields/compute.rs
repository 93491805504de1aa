//! Sampling of the fields by a truncated Gaussian.
//!
//! rho(r) = sum m_i phi(r - r_i), phi(R) = A exp(-R^2 / (2 w^2)) for R below the cutoff, of integral 1 (Goldhirsch,
//! Granular Matter 12 (2010) 239; Weinhart et al., Granular Matter 14 (2012) 289). Along homogeneous axes (one cell)
//! the kernel is averaged over the extent. Support cut by a periodic face goes on at the other side; support cut by a
//! wall is not corrected.

use rayon::prelude::*;

use super::definition::{FieldColumn, FieldDefinition, FieldFrame, FieldQuantity, Grid};
use crate::cell::Cell;
use crate::error::InvalidInput;
use crate::math::Vec3;

/// What a particle brings into the fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldSample {
    /// m
    pub position: Vec3,
    /// m/s
    pub velocity: Vec3,
    /// kg
    pub mass: f64,
    /// m3
    pub volume: f64,
}

/// Cells of a grid at most.
const MOST_CELLS: u64 = 4_000_000;

/// Sums at one point: mass, momentum (of the velocity less its mean), kinetic, volume.
#[derive(Clone, Copy, Default)]
struct PointSums {
    mass: f64,
    momentum: Vec3,
    twice_kinetic: f64,
    volume: f64,
}

impl FieldDefinition {
    /// Checks names and numbers; `path` names the definition in errors.
    pub fn validate(&self, path: &str) -> Result<(), InvalidInput> {
        let error = |key: &str, problem: String| Err(InvalidInput::new(format!("{path}.{key}"), problem));
        let legal = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if self.name.is_empty() || self.name.len() > 64 || !self.name.chars().all(legal) {
            return error("name", format!("'{}' must have 1 to 64 letters, digits, '_' or '-'", self.name));
        }
        if self.quantities.is_empty() {
            return error("quantities", "is empty; ask for at least one quantity".into());
        }
        if (1..self.quantities.len()).any(|k| self.quantities[..k].contains(&self.quantities[k])) {
            return error("quantities", "names a quantity twice".into());
        }
        if !(self.width_m.is_finite() && self.width_m > 0.0) {
            return error("width_m", format!("is {}; must be finite and above 0", self.width_m));
        }
        if !(1.0..=12.0).contains(&self.cutoff_widths) {
            return error("cutoff_widths", format!("is {}; must be in [1, 12]", self.cutoff_widths));
        }
        let grid = &self.grid;
        for axis in 0..3 {
            let (min, max) = (grid.min_m[axis], grid.max_m[axis]);
            if !(min.is_finite() && max.is_finite() && min < max) {
                return error(
                    &format!("grid.max_m[{axis}]"),
                    format!("is {max} with min_m {min}; needs finite min < max"),
                );
            }
        }
        let cells = grid.cells.iter().map(|&c| u64::from(c)).product::<u64>();
        if grid.cells.contains(&0) || grid.cells.iter().any(|&c| u64::from(c) > MOST_CELLS) || cells > MOST_CELLS {
            return error("grid.cells", format!("is {:?}; needs 1 to {MOST_CELLS} cells in all", grid.cells));
        }
        Ok(())
    }
}

impl Grid {
    /// Distance of sample points along an axis, m.
    pub fn spacing(&self, axis: usize) -> f64 {
        (self.max_m[axis] - self.min_m[axis]) / f64::from(self.cells[axis])
    }

    /// Coordinate of a sample point, m.
    pub fn centre(&self, axis: usize, index: usize) -> f64 {
        self.min_m[axis] + (index as f64 + 0.5) * self.spacing(axis)
    }

    fn is_homogeneous(&self, axis: usize) -> bool {
        self.cells[axis] == 1
    }
}

/// Integral of exp(-R^2 / (2 w^2)) over the support in `dimensions` dimensions, by Simpson's rule (error < 1e-12).
fn kernel_integral(dimensions: usize, width: f64, cutoff: f64) -> f64 {
    let surface = match dimensions {
        0 => return 1.0,
        1 => 2.0,
        2 => std::f64::consts::TAU,
        _ => 2.0 * std::f64::consts::TAU,
    };
    let n = 2000;
    let h = cutoff / f64::from(n);
    let f = |r: f64| r.powi(dimensions as i32 - 1) * (-0.5 * (r / width).powi(2)).exp();
    let inner: f64 = (1..n).map(|k| f(f64::from(k) * h) * if k % 2 == 1 { 4.0 } else { 2.0 }).sum();
    surface * h / 3.0 * (f(0.0) + inner + f(cutoff))
}

/// Samples and those of their periodic images that reach into the grid, in the order given.
fn with_images(samples: &[FieldSample], grid: &Grid, cell: &Cell, cutoff: f64) -> Vec<FieldSample> {
    let mut all = samples.to_vec();
    for axis in 0..3 {
        let (reach, low, high) = if grid.is_homogeneous(axis) {
            (0.0, grid.min_m[axis], grid.max_m[axis])
        } else {
            (cutoff, grid.min_m[axis], grid.max_m[axis])
        };
        let mut next = Vec::with_capacity(all.len());
        for sample in &all {
            let shifts = if cell.periodic[axis] {
                let length = cell.extent[axis];
                let first = ((low - reach - sample.position[axis]) / length).ceil();
                let last = ((high + reach - sample.position[axis]) / length).floor();
                (first as i64, last as i64, length)
            } else {
                (0, 0, 0.0)
            };
            for k in shifts.0..=shifts.1 {
                let mut image = *sample;
                image.position[axis] += k as f64 * shifts.2;
                let x = image.position[axis];
                // Half-open along homogeneous axes, so that a particle on a periodic face counts once.
                let inside = if grid.is_homogeneous(axis) {
                    x >= low && x < high
                } else {
                    x >= low - reach && x <= high + reach
                };
                if inside {
                    next.push(image);
                }
            }
        }
        all = next;
    }
    all
}

/// Samples the definition. `samples` must come in an order that does not depend on rows (ids).
pub fn compute(
    definition: &FieldDefinition,
    samples: &[FieldSample],
    cell: &Cell,
    (step, time_s): (u64, f64),
) -> FieldFrame {
    let grid = &definition.grid;
    let cutoff = definition.cutoff_widths * definition.width_m;
    let active: Vec<usize> = (0..3).filter(|&axis| !grid.is_homogeneous(axis)).collect();
    let homogeneous: f64 =
        (0..3).filter(|&axis| grid.is_homogeneous(axis)).map(|axis| grid.max_m[axis] - grid.min_m[axis]).product();
    let amplitude = 1.0 / (kernel_integral(active.len(), definition.width_m, cutoff) * homogeneous);
    let total_mass: f64 = samples.iter().map(|sample| sample.mass).sum();
    let total_momentum: Vec3 = samples.iter().map(|sample| sample.velocity * sample.mass).sum();
    let mean = if total_mass > 0.0 { total_momentum / total_mass } else { Vec3::zeros() };
    let images = with_images(samples, grid, cell, cutoff);
    let slab = Slab { grid, active: &active, images: &images, mean, cutoff, width: definition.width_m, amplitude };
    let per_slab = (grid.cells[1] as usize) * (grid.cells[2] as usize);
    let mut sums = vec![PointSums::default(); per_slab * grid.cells[0] as usize];
    sums.par_chunks_mut(per_slab).enumerate().for_each(|(ix, sums)| slab.fill(ix, sums));
    FieldFrame {
        name: definition.name.clone(),
        step,
        time_s,
        grid: *grid,
        width_m: definition.width_m,
        cutoff_widths: definition.cutoff_widths,
        columns: definition.quantities.iter().map(|&quantity| column(quantity, &sums, &mean)).collect(),
        total_mass_kg: total_mass,
        total_momentum_kg_m_per_s: total_momentum.into(),
    }
}

/// What the sums of one layer of cells (one index along x) need.
struct Slab<'a> {
    grid: &'a Grid,
    active: &'a [usize],
    images: &'a [FieldSample],
    mean: Vec3,
    cutoff: f64,
    width: f64,
    amplitude: f64,
}

impl Slab<'_> {
    fn fill(&self, ix: usize, sums: &mut [PointSums]) {
        let grid = self.grid;
        let exponent = -0.5 / (self.width * self.width);
        for sample in self.images {
            let ranges = [0, 1, 2].map(|axis| self.range(axis, sample.position[axis]));
            if !ranges[0].contains(&ix) {
                continue;
            }
            let velocity = sample.velocity - self.mean;
            for iy in ranges[1].clone() {
                for iz in ranges[2].clone() {
                    let index = [ix, iy, iz];
                    let distance2: f64 = self
                        .active
                        .iter()
                        .map(|&axis| (grid.centre(axis, index[axis]) - sample.position[axis]).powi(2))
                        .sum();
                    if distance2 > self.cutoff * self.cutoff {
                        continue;
                    }
                    let phi = self.amplitude * (exponent * distance2).exp();
                    let sum = &mut sums[iy * grid.cells[2] as usize + iz];
                    sum.mass += sample.mass * phi;
                    sum.momentum += velocity * (sample.mass * phi);
                    sum.twice_kinetic += sample.mass * phi * velocity.norm_squared();
                    sum.volume += sample.volume * phi;
                }
            }
        }
    }

    /// Cells along an axis within the cutoff of `x`.
    fn range(&self, axis: usize, x: f64) -> std::ops::Range<usize> {
        let cells = self.grid.cells[axis] as usize;
        if self.grid.is_homogeneous(axis) {
            return 0..cells;
        }
        let spacing = self.grid.spacing(axis);
        let first = ((x - self.cutoff - self.grid.min_m[axis]) / spacing - 0.5).ceil().max(0.0) as usize;
        let last = ((x + self.cutoff - self.grid.min_m[axis]) / spacing - 0.5).floor();
        let end = if last < 0.0 { 0 } else { (last as usize + 1).min(cells) };
        first..end.max(first)
    }
}

fn column(quantity: FieldQuantity, sums: &[PointSums], mean: &Vec3) -> FieldColumn {
    let scalar =
        |f: &dyn Fn(&PointSums) -> f64| FieldColumn { quantity, components: 1, data: sums.iter().map(f).collect() };
    let vector = |f: &dyn Fn(&PointSums) -> Vec3| FieldColumn {
        quantity,
        components: 3,
        data: sums.iter().flat_map(|sum| <[f64; 3]>::from(f(sum))).collect(),
    };
    let velocity = |sum: &PointSums| if sum.mass > 0.0 { sum.momentum / sum.mass + mean } else { Vec3::zeros() };
    match quantity {
        FieldQuantity::SolidFraction => scalar(&|sum| sum.volume),
        FieldQuantity::Density => scalar(&|sum| sum.mass),
        FieldQuantity::Momentum => vector(&|sum| sum.momentum + mean * sum.mass),
        FieldQuantity::Velocity => vector(&velocity),
        FieldQuantity::GranularTemperature => scalar(&|sum| {
            if sum.mass > 0.0 {
                ((sum.twice_kinetic - sum.momentum.norm_squared() / sum.mass) / (3.0 * sum.mass)).max(0.0)
            } else {
                0.0
            }
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(periodic: [bool; 3]) -> Cell {
        Cell { min: Vec3::zeros(), extent: Vec3::repeat(1.0), periodic }
    }

    fn definition(cells: [u32; 3], quantities: &[FieldQuantity]) -> FieldDefinition {
        FieldDefinition {
            name: "test".into(),
            grid: Grid { min_m: [0.0; 3], max_m: [1.0; 3], cells },
            quantities: quantities.to_vec(),
            width_m: 0.1,
            cutoff_widths: 4.0,
        }
    }

    fn cloud() -> Vec<FieldSample> {
        (0..40)
            .map(|id| {
                let mut draw = crate::random::Draw::new(3, id, crate::random::Purpose::Position);
                FieldSample {
                    position: draw.in_box(&Vec3::zeros(), &Vec3::repeat(1.0)),
                    velocity: draw.in_box(&Vec3::repeat(4.0), &Vec3::repeat(5.0)),
                    mass: 1.0 + draw.unit(),
                    volume: 0.001,
                }
            })
            .collect()
    }

    /// The midpoint rule sums a smooth periodic function nearly exactly; what is left is the kernel's edge,
    /// exp(-8) of its top, on a grid of a fifth of the width.
    #[test]
    fn integrals_are_mass_and_momentum_in_every_dimension() {
        let samples = cloud();
        for cells in [[50, 50, 50], [50, 1, 50], [1, 1, 50], [1, 1, 1]] {
            let definition = definition(cells, &[FieldQuantity::Density, FieldQuantity::Momentum]);
            let frame = compute(&definition, &samples, &cell([true; 3]), (0, 0.0));
            let volume: f64 = (0..3).map(|axis| frame.grid.spacing(axis)).product();
            let mass: f64 = frame.columns[0].data.iter().sum::<f64>() * volume;
            assert!((mass / frame.total_mass_kg - 1.0).abs() < 2e-4, "{cells:?} {mass} {}", frame.total_mass_kg);
            let momentum_y: f64 = frame.columns[1].data.iter().skip(1).step_by(3).sum::<f64>() * volume;
            assert!((momentum_y / frame.total_momentum_kg_m_per_s[1] - 1.0).abs() < 2e-4);
        }
    }

    #[test]
    fn fields_equal_the_brute_force_sum() {
        let samples = cloud();
        let quantities = [FieldQuantity::SolidFraction, FieldQuantity::Velocity, FieldQuantity::GranularTemperature];
        let frame = compute(&definition([5, 6, 7], &quantities), &samples, &cell([false, true, false]), (0, 0.0));
        let amplitude = 1.0 / kernel_integral(3, 0.1, 0.4);
        let (mut worst, mut touched) = (0.0f64, 0);
        for index in 0..5 * 6 * 7 {
            let at = [index / 42, index / 7 % 6, index % 7];
            let r = Vec3::from_fn(|axis, _| frame.grid.centre(axis, at[axis]));
            let (mut volume, mut mass, mut momentum) = (0.0, 0.0, Vec3::zeros());
            let weight = |sample: &FieldSample, shift: f64| {
                let d = r - sample.position - Vec3::y() * shift;
                if d.norm() <= 0.4 { amplitude * (-0.5 * d.norm_squared() / 0.01).exp() } else { 0.0 }
            };
            let images = || samples.iter().flat_map(|s| [-1.0, 0.0, 1.0].map(|shift| (s, weight(s, shift))));
            for (sample, phi) in images() {
                volume += sample.volume * phi;
                mass += sample.mass * phi;
                momentum += sample.velocity * (sample.mass * phi);
            }
            if mass == 0.0 {
                continue;
            }
            touched += 1;
            let v = momentum / mass;
            let temperature =
                images().map(|(s, phi)| s.mass * phi * (s.velocity - v).norm_squared()).sum::<f64>() / (3.0 * mass);
            worst = worst.max((frame.columns[0].data[index] / volume - 1.0).abs());
            worst = worst.max((frame.columns[1].data[3 * index + 2] - v.z).abs());
            worst = worst.max((frame.columns[2].data[index] - temperature).abs());
        }
        assert!(touched > 100 && worst < 1e-12, "{touched} {worst:e}");
    }

    #[test]
    fn empty_fields_are_zero_and_finite() {
        let quantities = [FieldQuantity::Velocity, FieldQuantity::GranularTemperature];
        let frame = compute(&definition([3, 1, 2], &quantities), &[], &cell([false; 3]), (0, 0.0));
        assert!(frame.columns.iter().all(|column| column.data.iter().all(|&v| v == 0.0)));
    }
}
