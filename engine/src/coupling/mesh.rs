//! Weights of a point of a particle in the cells or points of a mesh.

use super::description::{AxisSides, MeshDescription, Side};
use super::points::PointBins;
use crate::math::Vec3;

/// A checked mesh, ready to be looked up.
#[derive(Clone, Debug)]
pub(super) enum Mesh {
    Structured(Lattice),
    Points(PointBins),
}

/// Equal boxes, and the kernel that spreads points over them.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    origin: Vec3,
    spacing: Vec3,
    counts: [usize; 3],
    sides: [AxisSides; 3],
    half_width: f64,
}

/// The weights of one axis: of the cells `first`, `first + 1`, ... of a lattice without end.
#[derive(Clone, Debug, Default)]
struct AxisWeights {
    first: i64,
    weights: Vec<f64>,
}

/// Buffers of [`Lattice::spread`].
#[derive(Clone, Debug, Default)]
pub(super) struct SpreadScratch {
    axes: [AxisWeights; 3],
    block: Vec<f64>,
}

/// Part of the kernel 15/16 (1 - t^2)^2 below t.
#[inline(always)]
fn part_below(t: f64) -> f64 {
    let t = t.clamp(-1.0, 1.0);
    let s = t * t;
    0.5 + t * (0.9375 - s * (0.625 - 0.1875 * s))
}

impl Mesh {
    /// Of a checked description.
    pub fn new(description: &MeshDescription, smoothing_length: f64) -> Self {
        match description {
            MeshDescription::Structured { origin_m, spacing_m, counts, sides } => Self::Structured(Lattice {
                origin: Vec3::from(*origin_m),
                spacing: Vec3::from(*spacing_m),
                counts: counts.map(|n| n as usize),
                sides: *sides,
                half_width: smoothing_length,
            }),
            MeshDescription::Points { points_m, volumes_m3 } => {
                Self::Points(PointBins::new(points_m, volumes_m3, smoothing_length))
            }
        }
    }

    /// Cells or points.
    pub fn len(&self) -> usize {
        match self {
            Self::Structured(lattice) => lattice.counts.iter().product(),
            Self::Points(points) => points.len(),
        }
    }

    /// m3
    pub fn volume(&self, cell: usize) -> f64 {
        match self {
            Self::Structured(lattice) => lattice.spacing.product(),
            Self::Points(points) => points.volume(cell),
        }
    }

    /// Appends the weights of a body of equal parts at `parts`, which may be moved by a period; a cell may come more than
    /// once.
    pub fn spread(&self, parts: &mut [Vec3], scratch: &mut SpreadScratch, out: &mut Vec<(u32, f64)>) {
        match self {
            Self::Structured(lattice) => lattice.spread(parts, scratch, out),
            Self::Points(points) => points.spread(parts, out),
        }
    }
}

impl AxisWeights {
    /// All in one cell.
    fn set_whole(&mut self) {
        self.first = 0;
        self.weights.clear();
        self.weights.push(1.0);
    }

    /// Of a point at `x` cells from the lowest side, with a kernel of half-width `h` cells.
    fn set(&mut self, x: f64, h: f64) {
        let (low, high) = ((x - h).floor(), (x + h).ceil());
        self.first = low as i64;
        self.weights.clear();
        let mut below = 0.0;
        let cells = ((high - low) as usize).max(1);
        for cell in 1..=cells {
            let up_to = if cell == cells { 1.0 } else { part_below((low + cell as f64 - x) / h) };
            self.weights.push((up_to - below).max(0.0));
            below = up_to;
        }
    }
}

impl Lattice {
    /// Where a cell of the lattice without end is among those of the mesh; `None` beyond an open side.
    fn cell(&self, axis: usize, index: i64) -> Option<usize> {
        let n = self.counts[axis] as i64;
        if (0..n).contains(&index) {
            return Some(index as usize);
        }
        let (side, mirrored) =
            if index < 0 { (self.sides[axis][0], -1 - index) } else { (self.sides[axis][1], 2 * n - 1 - index) };
        match side {
            Side::Periodic => Some(index.rem_euclid(n) as usize),
            Side::Closed => Some(mirrored.clamp(0, n - 1) as usize),
            Side::Open => None,
        }
    }

    /// Where a point is, in cells from the lowest side. What is far outside of the mesh is no further than the kernel
    /// reaches: beyond an open side it has no weights, beyond a closed one those at the wall.
    fn in_cells(&self, x: &Vec3, axis: usize) -> f64 {
        let n = self.counts[axis] as f64;
        let at = (x[axis] - self.origin[axis]) / self.spacing[axis];
        let periods = if self.sides[axis][0] == Side::Periodic { n } else { 0.0 };
        let reach = self.half_width / self.spacing[axis] + 2.0 + periods;
        at.clamp(-reach, n + reach)
    }

    fn spread(&self, parts: &mut [Vec3], scratch: &mut SpreadScratch, out: &mut Vec<(u32, f64)>) {
        let share = 1.0 / parts.len() as f64;
        let shift = Vec3::from(parts.first().map_or([0.0; 3], |first| self.shift(first)));
        parts.iter_mut().for_each(|x| *x -= shift);
        if let [x] = &*parts {
            let first = self.set_axes(x, &mut scratch.axes);
            let sizes = [0, 1, 2].map(|axis| scratch.axes[axis].weights.len());
            let axes = &scratch.axes;
            return self
                .push(&first, &sizes, out, |[i, j, k]| axes[0].weights[i] * axes[1].weights[j] * axes[2].weights[k]);
        }
        let (first, sizes) = self.block_of(parts);
        scratch.block.clear();
        scratch.block.resize(sizes.iter().product(), 0.0);
        for x in &*parts {
            let at = self.set_axes(x, &mut scratch.axes);
            let from = [0, 1, 2].map(|axis| (at[axis] - first[axis]) as usize);
            let [wx, wy, wz] = [0, 1, 2].map(|axis| &scratch.axes[axis].weights);
            for (k, wz) in wz.iter().enumerate() {
                for (j, wy) in wy.iter().enumerate() {
                    let row = sizes[0] * (from[1] + j + sizes[1] * (from[2] + k)) + from[0];
                    let weight = share * wy * wz;
                    let cells = &mut scratch.block[row..row + wx.len()];
                    cells.iter_mut().zip(wx).for_each(|(cell, wx)| *cell += weight * wx);
                }
            }
        }
        let block = &scratch.block;
        self.push(&first, &sizes, out, |[i, j, k]| block[i + sizes[0] * (j + sizes[1] * k)]);
    }

    /// Whether there is but one cell along an axis, which has all that is spread along it.
    fn is_whole(&self, axis: usize) -> bool {
        self.counts[axis] == 1 && !self.sides[axis].contains(&Side::Open)
    }

    /// How far the cell of a periodic lattice without end that a body's first part is in is from the one of the mesh: all its
    /// parts are shifted by that, so that no side tears it.
    fn shift(&self, first: &Vec3) -> [f64; 3] {
        [0, 1, 2].map(|axis| match self.sides[axis][0] {
            Side::Periodic => {
                let n = self.counts[axis] as f64;
                ((first[axis] - self.origin[axis]) / self.spacing[axis] / n).floor() * n * self.spacing[axis]
            }
            Side::Closed | Side::Open => 0.0,
        })
    }

    fn set_axes(&self, x: &Vec3, axes: &mut [AxisWeights; 3]) -> [i64; 3] {
        [0, 1, 2].map(|axis| {
            if self.is_whole(axis) {
                axes[axis].set_whole();
            } else {
                axes[axis].set(self.in_cells(x, axis), self.half_width / self.spacing[axis]);
            }
            axes[axis].first
        })
    }

    /// Lowest cell and number of cells that the parts can have weights in.
    fn block_of(&self, parts: &[Vec3]) -> ([i64; 3], [usize; 3]) {
        let ends = [0, 1, 2].map(|axis| {
            if self.is_whole(axis) {
                return (0, 1);
            }
            let h = self.half_width / self.spacing[axis];
            let at = |x: &Vec3| self.in_cells(x, axis);
            let (low, high) = parts.iter().map(at).fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
            ((low - h).floor() as i64, (high + h).ceil() as i64)
        });
        (ends.map(|(low, _)| low), ends.map(|(low, high)| ((high - low) as usize).max(1)))
    }

    fn push(
        &self,
        first: &[i64; 3],
        sizes: &[usize; 3],
        out: &mut Vec<(u32, f64)>,
        weight: impl Fn([usize; 3]) -> f64,
    ) {
        for k in 0..sizes[2] {
            let Some(z) = self.cell(2, first[2] + k as i64) else { continue };
            for j in 0..sizes[1] {
                let Some(y) = self.cell(1, first[1] + j as i64) else { continue };
                let row = self.counts[0] * (y + self.counts[1] * z);
                for i in 0..sizes[0] {
                    let w = weight([i, j, k]);
                    if w != 0.0
                        && let Some(x) = self.cell(0, first[0] + i as i64)
                    {
                        out.push(((row + x) as u32, w));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(counts: [u32; 3], spacing_m: [f64; 3], side: Side, h: f64) -> Mesh {
        let sides = [[side; 2]; 3];
        Mesh::new(&MeshDescription::Structured { origin_m: [0.0; 3], spacing_m, counts, sides }, h)
    }

    fn weights(mesh: &Mesh, cells: usize, parts: &[Vec3]) -> Vec<f64> {
        let (mut scratch, mut pairs) = (SpreadScratch::default(), Vec::new());
        mesh.spread(&mut parts.to_vec(), &mut scratch, &mut pairs);
        let mut sums = vec![0.0; cells];
        pairs.iter().for_each(|&(cell, weight)| sums[cell as usize] += weight);
        sums
    }

    #[test]
    fn the_kernel_has_integral_one_and_is_even() {
        assert_eq!(part_below(1.0), 1.0);
        assert_eq!(part_below(-1.0), 0.0);
        for k in 0..20 {
            let t = f64::from(k) * 0.05;
            assert!((part_below(t) + part_below(-t) - 1.0).abs() < 1e-15);
            let slope = (part_below(t + 1e-5) - part_below(t - 1e-5)) / 2e-5;
            assert!((slope - 0.9375 * (1.0 - t * t).powi(2)).abs() < 1e-9, "{t}");
        }
    }

    #[test]
    fn weights_sum_to_one_anywhere_between_closed_and_periodic_sides() {
        for side in [Side::Closed, Side::Periodic] {
            for h in [0.05, 0.4, 1.7] {
                let mesh = lattice([5, 3, 4], [0.5, 0.7, 0.3], side, h);
                for k in 0..200 {
                    let at = |a: f64, size: f64| (f64::from(k) * a).fract() * size;
                    let x = Vec3::new(at(0.618, 2.5), at(0.271, 2.1), at(0.443, 1.2));
                    let parts = [x, x + Vec3::new(0.1, -0.2, 0.05), x - Vec3::new(0.1, 0.1, 0.3)];
                    let sums = weights(&mesh, 60, &parts);
                    assert!((sums.iter().sum::<f64>() - 1.0).abs() < 1e-14, "{side:?} {h} {x:?}");
                    assert!(sums.iter().all(|&w| (0.0..=1.0 + 1e-15).contains(&w)));
                }
            }
        }
    }

    #[test]
    fn a_body_half_out_of_an_open_side_is_half_in() {
        let mesh = lattice([4, 4, 4], [1.0; 3], Side::Open, 0.6);
        let sum: f64 = weights(&mesh, 64, &[Vec3::new(2.0, 0.0, 2.0)]).iter().sum();
        assert!((sum - 0.5).abs() < 1e-15);
        let far = weights(&mesh, 64, &[Vec3::new(2.0, 1e300, 2.0)]);
        assert_eq!(far.iter().sum::<f64>(), 0.0);
    }

    #[test]
    fn what_a_wall_cuts_off_counts_in_front_of_it() {
        // a uniform row of points up to the wall gives a uniform row of weights
        let mesh = lattice([8, 1, 1], [0.25, 1.0, 1.0], Side::Closed, 0.4);
        let parts: Vec<Vec3> = (0..2000).map(|k| Vec3::new((f64::from(k) + 0.5) * 1e-3, 0.5, 0.5)).collect();
        for weight in weights(&mesh, 8, &parts) {
            assert!((weight - 0.125).abs() < 1e-6, "{weight}");
        }
    }

    #[test]
    fn weights_change_smoothly_as_a_point_crosses_cells_much_wider_than_the_kernel() {
        let mesh = lattice([3, 1, 1], [1.0; 3], Side::Closed, 0.1);
        let mut before = weights(&mesh, 3, &[Vec3::new(0.8, 0.5, 0.5)])[0];
        for k in 1..=4000 {
            let x = 0.8 + 1e-4 * f64::from(k);
            let now = weights(&mesh, 3, &[Vec3::new(x, 0.5, 0.5)])[0];
            // the largest slope is that of the kernel's middle
            assert!((now - before).abs() <= 1e-4 * 0.9375 / 0.1 * (1.0 + 1e-9), "{x}");
            before = now;
        }
        assert_eq!(before, 0.0);
    }
}
