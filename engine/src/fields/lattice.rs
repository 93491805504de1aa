//! Where a grid is sampled: one point per cell, or several along the homogeneous directions of a cylinder.
//!
//! All coordinates are those of the grid's own frame; of a cylinder that is the one whose third axis is its axis.

use std::f64::consts::TAU;
use std::ops::Range;

use super::definition::Grid;
use super::layout::{Kind, Layout};
use crate::math::{Mat3, Vec3};

/// Points per width along homogeneous directions of a cylinder.
const POINTS_PER_WIDTH: f64 = 2.0;
/// Points along such a direction at most.
const MOST_POINTS: f64 = 720.0;
/// Tiles that a lattice is cut into at most, on any number of threads.
const MOST_TILES: usize = 64;

/// Sample points as a three-dimensional array.
pub(super) struct Lattice {
    grid: Grid,
    /// Points along each parameter of the grid.
    n: [usize; 3],
    /// First point and distance of points.
    first: [f64; 3],
    step: [f64; 3],
    /// Points of a cell along each parameter.
    per_cell: [usize; 3],
    /// (cosine, sine) of each angle of a cylinder.
    angles: Vec<(f64, f64)>,
    full_turn: bool,
    /// The parameter that tiles are cut along: the slowest in memory.
    slow: usize,
    strides: [usize; 3],
    /// Cartesian axes that the kernel resolves.
    pub active: [bool; 3],
}

impl Lattice {
    /// Of a valid grid; `width` is the smallest one.
    pub fn new(grid: &Grid, width: f64) -> Self {
        let mut per_cell = [1; 3];
        let mut full_turn = false;
        if grid.cylinder.is_some() {
            let radius = grid.max_m[0];
            full_turn = grid.max_m[1] - grid.min_m[1] > TAU * (1.0 - 1e-9);
            for (axis, length) in [(0, radius - grid.min_m[0]), (1, radius * (grid.max_m[1] - grid.min_m[1]))] {
                if grid.is_homogeneous(axis) {
                    per_cell[axis] = (POINTS_PER_WIDTH * length / width).clamp(1.0, MOST_POINTS).ceil() as usize;
                }
            }
        }
        let n: [usize; 3] = std::array::from_fn(|axis| grid.cells[axis] as usize * per_cell[axis]);
        let step = std::array::from_fn(|axis| (grid.max_m[axis] - grid.min_m[axis]) / n[axis] as f64);
        let first: [f64; 3] = std::array::from_fn(|axis| grid.min_m[axis] + 0.5 * step[axis]);
        let angles = match grid.cylinder {
            Some(_) => (0..n[1]).map(|j| first[1] + j as f64 * step[1]).map(|a| (a.cos(), a.sin())).collect(),
            None => Vec::new(),
        };
        let active = match grid.cylinder {
            Some(_) => [true, true, !grid.is_homogeneous(2)],
            None => [0, 1, 2].map(|axis| !grid.is_homogeneous(axis)),
        };
        // angles wrap around: never cut along them
        let slow = match grid.cylinder {
            Some(_) if n[2] > n[0] => 2,
            Some(_) => 0,
            None => (0..3).max_by_key(|&axis| (n[axis], 3 - axis)).unwrap_or(0),
        };
        let (second, third) = [(1, 2), (0, 2), (0, 1)][slow];
        let mut strides = [1; 3];
        strides[second] = n[third];
        strides[slow] = n[second] * n[third];
        Self { grid: *grid, n, first, step, per_cell, angles, full_turn, slow, strides, active }
    }

    /// All points.
    pub fn len(&self) -> usize {
        self.n.iter().product()
    }

    /// Cells of the grid.
    pub fn n_cells(&self) -> usize {
        self.grid.cells.iter().map(|&cells| cells as usize).product()
    }

    /// Dimensions that the kernel resolves.
    pub fn dimensions(&self) -> usize {
        self.active.iter().filter(|active| **active).count()
    }

    /// Bounds of the cartesian axis `axis`; of a homogeneous one its extent.
    pub fn bounds(&self, axis: usize) -> (f64, f64) {
        match self.grid.cylinder {
            Some(_) if axis < 2 => (-self.grid.max_m[0], self.grid.max_m[0]),
            _ => (self.grid.min_m[axis], self.grid.max_m[axis]),
        }
    }

    /// One over the extent along homogeneous axes.
    pub fn homogeneous_factor(&self) -> f64 {
        let extents = (0..3).filter(|&axis| !self.active[axis]).map(|axis| self.bounds(axis));
        1.0 / extents.map(|(low, high)| high - low).product::<f64>()
    }

    /// Whether a point lies within the extent along homogeneous axes: half-open, so that a particle on a periodic face
    /// counts once.
    pub fn is_within(&self, x: &Vec3) -> bool {
        (0..3).filter(|&axis| !self.active[axis]).all(|axis| {
            let (low, high) = self.bounds(axis);
            x[axis] >= low && x[axis] < high
        })
    }

    /// The vector without its components along homogeneous axes.
    #[inline(always)]
    pub fn resolved(&self, mut d: Vec3) -> Vec3 {
        for axis in 0..3 {
            if !self.active[axis] {
                d[axis] = 0.0;
            }
        }
        d
    }

    /// Where a point is.
    #[inline(always)]
    pub fn point(&self, at: [usize; 3]) -> Vec3 {
        let u: [f64; 3] = std::array::from_fn(|axis| self.first[axis] + at[axis] as f64 * self.step[axis]);
        match self.angles.get(at[1]) {
            Some(&(cosine, sine)) => Vec3::new(u[0] * cosine, u[0] * sine, u[2]),
            None => Vec3::from(u),
        }
    }

    /// Where its sums are.
    #[inline(always)]
    pub fn index(&self, at: [usize; 3]) -> usize {
        at[0] * self.strides[0] + at[1] * self.strides[1] + at[2] * self.strides[2]
    }

    /// Points that may lie within `reach` of `x`, along each parameter; those of an angle are to be taken modulo their
    /// number.
    pub fn ranges(&self, x: &Vec3, reach: f64) -> [Range<usize>; 3] {
        if self.grid.cylinder.is_none() {
            return [0, 1, 2].map(|axis| if self.active[axis] { self.range(axis, x[axis], reach) } else { 0..1 });
        }
        let rho = x.x.hypot(x.y);
        let heights = if self.active[2] { self.range(2, x.z, reach) } else { 0..1 };
        [self.range(0, rho, reach), self.angle_range(x, rho, reach), heights]
    }

    fn range(&self, axis: usize, x: f64, reach: f64) -> Range<usize> {
        let place = |x: f64| (x - self.first[axis]) / self.step[axis];
        let start = place(x - reach).ceil().max(0.0) as usize;
        let last = place(x + reach).floor();
        let end = if last < 0.0 { 0 } else { (last as usize + 1).min(self.n[axis]) };
        start..end.max(start)
    }

    fn angle_range(&self, x: &Vec3, rho: f64, reach: f64) -> Range<usize> {
        let n = self.n[1];
        if reach >= rho || !self.full_turn {
            return 0..n;
        }
        let (angle, half) = (x.y.atan2(x.x), (reach / rho).asin());
        let place = |angle: f64| (angle - self.first[1]) / self.step[1];
        let (start, end) = (place(angle - half).ceil() as i64, place(angle + half).floor() as i64 + 1);
        if end - start >= n as i64 {
            return 0..n;
        }
        let first = start.rem_euclid(n as i64) as usize;
        first..first + (end - start).max(0) as usize
    }

    /// Number modulo that of the angles.
    #[inline(always)]
    pub fn wrapped(&self, j: usize) -> usize {
        if j >= self.n[1] { j - self.n[1] } else { j }
    }

    /// Parameter along which tiles are cut, and the tiles: the same on any number of threads.
    pub fn tiles(&self) -> (usize, usize) {
        let n = self.n[self.slow];
        (self.slow, n.div_ceil(MOST_TILES.min(n)))
    }

    /// Points of one layer of the slow parameter.
    pub fn layer(&self) -> usize {
        self.strides[self.slow]
    }

    /// Whether every point lies in front of all planes, for each point.
    pub fn each_point(&self, mut f: impl FnMut(usize, Vec3)) {
        for i in 0..self.n[0] {
            for j in 0..self.n[1] {
                for k in 0..self.n[2] {
                    f(self.index([i, j, k]), self.point([i, j, k]));
                }
            }
        }
    }

    /// Means over the points of each cell, in the cells' own axes: shape (nx, ny, nz, sums), x slowest.
    pub fn reduced(&self, sums: &[f64], layout: &Layout) -> Vec<f64> {
        let [nx, ny, nz] = self.grid.cells.map(|n| n as usize);
        let mut cells = vec![0.0; nx * ny * nz * layout.size];
        for i in 0..self.n[0] {
            // a ring counts by its length
            let weight_r = if self.grid.cylinder.is_some() { self.ring_weight(i) } else { 1.0 };
            let weight = weight_r / self.per_cell[1] as f64;
            for j in 0..self.n[1] {
                let axes = self.angles.get(j).map(|&(c, s)| Mat3::new(c, s, 0.0, -s, c, 0.0, 0.0, 0.0, 1.0));
                for k in 0..self.n[2] {
                    let cell = ((i / self.per_cell[0]) * ny + j / self.per_cell[1]) * nz + k;
                    let to = &mut cells[cell * layout.size..][..layout.size];
                    let from = &sums[self.index([i, j, k]) * layout.size..][..layout.size];
                    match &axes {
                        None => to.iter_mut().zip(from).for_each(|(to, from)| *to += from),
                        Some(axes) => add_turned(to, from, layout, axes, weight),
                    }
                }
            }
        }
        cells
    }

    fn ring_weight(&self, i: usize) -> f64 {
        let radius = |i: usize| self.first[0] + i as f64 * self.step[0];
        let first = i / self.per_cell[0] * self.per_cell[0];
        radius(i) / (first..first + self.per_cell[0]).map(radius).sum::<f64>()
    }

    /// Interpolates vectors of cells, `values` of shape (nx, ny, nz), at a point: linear along each resolved parameter,
    /// over cells that have a value, constant beyond the outermost.
    pub fn interpolated(&self, values: &[Option<Vec3>], x: &Vec3) -> Option<Vec3> {
        let (rho, angle) = (x.x.hypot(x.y), x.y.atan2(x.x));
        let is_cylinder = self.grid.cylinder.is_some();
        let u = if is_cylinder { [rho, angle, x.z] } else { [x.x, x.y, x.z] };
        let sides: [[(usize, f64); 2]; 3] = std::array::from_fn(|axis| self.sides(axis, u[axis]));
        let [_, ny, nz] = self.grid.cells.map(|n| n as usize);
        let (mut sum, mut weights) = (Vec3::zeros(), 0.0);
        for (i, wi) in sides[0] {
            for (j, wj) in sides[1] {
                for (k, wk) in sides[2] {
                    let weight = wi * wj * wk;
                    if weight > 0.0
                        && let Some(value) = &values[(i * ny + j) * nz + k]
                    {
                        sum += value * weight;
                        weights += weight;
                    }
                }
            }
        }
        if weights == 0.0 {
            return None;
        }
        let mean = sum / weights;
        Some(if is_cylinder {
            let (s, c) = angle.sin_cos();
            Vec3::new(c * mean.x - s * mean.y, s * mean.x + c * mean.y, mean.z)
        } else {
            mean
        })
    }

    /// The two cells on both sides of a coordinate, and their shares.
    fn sides(&self, axis: usize, u: f64) -> [(usize, f64); 2] {
        let n = self.grid.cells[axis] as usize;
        if n == 1 {
            return [(0, 1.0), (0, 0.0)];
        }
        let mut place = (u - self.grid.centre(axis, 0)) / self.grid.spacing(axis);
        let turns = self.grid.cylinder.is_some() && axis == 1;
        if turns {
            // the turn whose middle is nearest to the middle of the grid
            let turn = TAU / self.grid.spacing(axis);
            let middle = 0.5 * (n as f64 - 1.0);
            place -= ((place - middle) / turn).round() * turn;
        }
        if turns && self.full_turn {
            let low = place.floor();
            let wrap = |k: f64| (k as i64).rem_euclid(n as i64) as usize;
            return [(wrap(low), 1.0 - (place - low)), (wrap(low + 1.0), place - low)];
        }
        let place = place.clamp(0.0, (n - 1) as f64);
        let low = (place as usize).min(n - 2);
        let share = place - low as f64;
        [(low, 1.0 - share), (low + 1, share)]
    }

    /// The same grid with further cells around it, at least as far as the reach.
    pub fn padded(&self, reach: f64, width: f64) -> Self {
        let mut grid = self.grid;
        for axis in 0..3 {
            if grid.is_homogeneous(axis) || (grid.cylinder.is_some() && axis == 1) {
                continue;
            }
            let spacing = grid.spacing(axis);
            let more = (reach / spacing).ceil() + 1.0;
            let is_radius = grid.cylinder.is_some() && axis == 0;
            let below = if is_radius { more.min((grid.min_m[0] / spacing).floor()) } else { more };
            grid.min_m[axis] -= below * spacing;
            grid.max_m[axis] += more * spacing;
            if is_radius {
                grid.min_m[axis] = grid.min_m[axis].max(0.0);
            }
            grid.cells[axis] += (below + more) as u32;
        }
        Self::new(&grid, width)
    }
}

/// Adds sums in axes turned by `axes` (new from old).
fn add_turned(to: &mut [f64], from: &[f64], layout: &Layout, axes: &Mat3, weight: f64) {
    for (group, at) in layout.groups() {
        let size = group.kind().size();
        let (to, from) = (&mut to[at..at + size], &from[at..at + size]);
        let mut add = |values: &[f64]| to.iter_mut().zip(values).for_each(|(to, value)| *to += weight * value);
        match group.kind() {
            Kind::Scalars(_) => add(from),
            Kind::Vector => add((axes * Vec3::new(from[0], from[1], from[2])).as_slice()),
            Kind::Symmetric => {
                let full = Mat3::new(from[0], from[1], from[2], from[1], from[3], from[4], from[2], from[4], from[5]);
                let m = axes * full * axes.transpose();
                add(&[m[(0, 0)], m[(0, 1)], m[(0, 2)], m[(1, 1)], m[(1, 2)], m[(2, 2)]]);
            }
            Kind::Tensor => {
                let m = axes * Mat3::from_row_slice(from) * axes.transpose();
                add(m.transpose().as_slice());
            }
        }
    }
}
