//! The weights of all particles, and sums with them in both directions.

use rayon::prelude::*;

use super::mesh::{Mesh, SpreadScratch};
use crate::math::{Quat, Vec3};

/// Particles per task, and per partial sum over a mesh: never a function of the thread count.
const CHUNK: usize = 256;
/// Partial sums over a mesh at most.
const MOST_PARTS: usize = 8;

/// Cells and weights.
type Pairs = Vec<(u32, f64)>;

/// Where a particle was when the operator was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    pub position: Vec3,
    pub orientation: Quat,
    pub shape: u32,
    pub scale: f64,
}

/// Rows are particles in the order of ids; each has the cells that it has weights in.
#[derive(Clone, Debug, Default)]
pub(super) struct Operator {
    /// By particle, where its weights start; one more at the end.
    start: Vec<usize>,
    cells: Vec<u32>,
    weights: Vec<f64>,
}

impl Operator {
    /// Of particles whose shapes are filled by points (body frame, unit scale).
    pub fn new(mesh: &Mesh, sub_points: &[Vec<Vec3>], poses: &[Pose]) -> Self {
        let rows: Vec<(Vec<usize>, Pairs)> = poses
            .par_chunks(CHUNK)
            .map(|poses| {
                let (mut scratch, mut parts) = (SpreadScratch::default(), Vec::new());
                let (mut ends, mut pairs) = (Vec::with_capacity(poses.len()), Vec::new());
                for pose in poses {
                    let rotation = pose.orientation.to_rotation_matrix().into_inner() * pose.scale;
                    parts.clear();
                    parts.extend(sub_points[pose.shape as usize].iter().map(|x| pose.position + rotation * x));
                    mesh.spread(&mut parts, &mut scratch, &mut pairs);
                    ends.push(pairs.len());
                }
                (ends, pairs)
            })
            .collect();
        let total = rows.iter().map(|(_, pairs)| pairs.len()).sum();
        let mut operator =
            Self { start: vec![0], cells: Vec::with_capacity(total), weights: Vec::with_capacity(total) };
        for (ends, pairs) in rows {
            let base = operator.cells.len();
            operator.start.extend(ends.into_iter().map(|end| base + end));
            operator.cells.extend(pairs.iter().map(|(cell, _)| *cell));
            operator.weights.extend(pairs.iter().map(|(_, weight)| *weight));
        }
        operator
    }

    /// Particles.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Entries.
    pub fn entries(&self) -> usize {
        self.cells.len()
    }

    /// Cells and weights of a particle.
    pub fn row(&self, particle: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let of = self.start[particle]..self.start[particle + 1];
        self.cells[of.clone()].iter().map(|&cell| cell as usize).zip(self.weights[of].iter().copied())
    }

    /// Adds w(c, p) times `value(p)` to each cell c. The order of the sums depends on the particles and the mesh,
    /// never on the threads.
    pub fn scatter<const N: usize>(&self, value: impl Fn(usize) -> [f64; N] + Sync, sums: &mut [[f64; N]]) {
        let n = self.len();
        // a copy of the mesh per part must not cost more than it saves
        let parts = (self.entries() / sums.len().max(1)).clamp(1, MOST_PARTS);
        let size = n.div_ceil(parts).max(1);
        if parts == 1 {
            return self.scatter_rows(0..n, &value, sums);
        }
        let partial: Vec<Vec<[f64; N]>> = (0..parts)
            .into_par_iter()
            .map(|part| {
                let mut sums = vec![[0.0; N]; sums.len()];
                self.scatter_rows((part * size).min(n)..((part + 1) * size).min(n), &value, &mut sums);
                sums
            })
            .collect();
        for part in &partial {
            for (sum, more) in sums.iter_mut().zip(part) {
                (0..N).for_each(|k| sum[k] += more[k]);
            }
        }
    }

    fn scatter_rows<const N: usize>(
        &self,
        rows: std::ops::Range<usize>,
        value: &(impl Fn(usize) -> [f64; N] + Sync),
        sums: &mut [[f64; N]],
    ) {
        for particle in rows {
            let value = value(particle);
            for (cell, weight) in self.row(particle) {
                (0..N).for_each(|k| sums[cell][k] += weight * value[k]);
            }
        }
    }
}
