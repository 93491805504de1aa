//! Adds what points and lines bring to the sums of the lattice: linear in sources, one after the other within a tile,
//! so that the bits do not depend on who works on which tile.

use std::ops::Range;

use rayon::prelude::*;

use super::kernel::Kernel;
use super::lattice::Lattice;
use super::layout::{Group, Layout};
use crate::math::Vec3;

/// A point that brings a row of numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointSource {
    /// In the frame of the grid, m.
    pub position: Vec3,
    /// Which row it brings.
    pub row: u32,
    /// What the row is multiplied with.
    pub factor: f64,
}

/// A straight line that brings a tensor.
#[derive(Clone, Debug)]
pub(super) struct LineSource {
    /// In the frame of the grid, m.
    pub start: Vec3,
    /// From there to the end, m.
    pub along: Vec3,
    /// The part of the line that counts, 0 to 1.
    pub part: Range<f64>,
    /// Where the tensor goes.
    pub at: usize,
    /// Row-major.
    pub tensor: [f64; 9],
    /// Points that stand for the line, and their weights, where walls cut off the kernel; else it is integrated exactly.
    pub nodes: Option<Vec<(Vec3, f64)>>,
}

/// A lattice and the kernel that smears over it.
#[derive(Clone, Copy)]
pub(super) struct Deposit<'a> {
    pub lattice: &'a Lattice,
    pub kernel: &'a Kernel,
    pub layout: &'a Layout,
}

/// Sums that need more than the value of the kernel, and where they go.
#[derive(Clone, Copy, Default)]
struct Derived {
    second_moment: Option<usize>,
    mass_gradient: Option<usize>,
    momentum_gradient: Option<usize>,
    mass: usize,
    momentum: usize,
}

impl Deposit<'_> {
    /// Zeros.
    pub fn empty(&self) -> Vec<f64> {
        vec![0.0; self.lattice.len() * self.layout.size]
    }

    /// Adds rows of `length` numbers each to the sums from `at` on.
    pub fn points(&self, sources: &[PointSource], (rows, length, at): (&[f64], usize, usize), sums: &mut [f64]) {
        self.add_points(sources, (rows, length, at), Derived::default(), sums);
    }

    /// Adds what particles bring, their second moments and gradients too.
    pub fn particles(&self, sources: &[PointSource], rows: &[f64], sums: &mut [f64]) {
        let layout = self.layout;
        let derived = Derived {
            second_moment: layout.place(Group::SecondMoment),
            mass_gradient: layout.place(Group::MassGradient),
            momentum_gradient: layout.place(Group::MomentumGradient),
            mass: layout.place(Group::Mass).unwrap_or(0),
            momentum: layout.place(Group::Momentum).unwrap_or(0),
        };
        self.add_points(sources, (rows, layout.of_particles, 0), derived, sums);
    }

    fn add_points(
        &self,
        sources: &[PointSource],
        (rows, length, at): (&[f64], usize, usize),
        derived: Derived,
        sums: &mut [f64],
    ) {
        let needs_more = derived.second_moment.or(derived.mass_gradient).is_some();
        self.each_tile(
            sums,
            sources,
            |source| (source.position, self.kernel.support),
            |source, ranges, base, sums| {
                let row = &rows[source.row as usize * length..][..length];
                self.each_point(ranges, |index, point| {
                    let d = self.lattice.resolved(point - source.position);
                    let squared = d.norm_squared();
                    let phi = source.factor * self.kernel.value(squared);
                    if phi == 0.0 {
                        return;
                    }
                    let cell = &mut sums[(index - base) * self.layout.size..][..self.layout.size];
                    cell[at..at + length].iter_mut().zip(row).for_each(|(to, from)| *to += phi * from);
                    if needs_more {
                        let slope = source.factor * self.kernel.slope(squared, phi / source.factor);
                        derived.add(cell, row, &d, phi, slope);
                    }
                });
            },
        );
    }

    /// Adds what lines bring.
    pub fn lines(&self, sources: &[LineSource], sums: &mut [f64]) {
        let factor = self.lattice.homogeneous_factor();
        self.each_tile(
            sums,
            sources,
            |source| {
                let along = self.lattice.resolved(source.along);
                (source.start + source.along * 0.5, self.kernel.support + 0.5 * along.norm())
            },
            |source, ranges, base, sums| {
                let line = Line::of(source, self.lattice, self.kernel);
                self.each_point(ranges, |index, point| {
                    let phi = factor * line.value(&point, self);
                    if phi != 0.0 {
                        let cell = &mut sums[(index - base) * self.layout.size + source.at..][..9];
                        cell.iter_mut().zip(&source.tensor).for_each(|(to, from)| *to += phi * from);
                    }
                });
            },
        );
    }

    /// Runs `add` for every source of every tile that it reaches, with the ranges of points within both, the number of the
    /// tile's first point, and the tile's sums.
    fn each_tile<S: Sync>(
        &self,
        sums: &mut [f64],
        sources: &[S],
        ball: impl Fn(&S) -> (Vec3, f64),
        add: impl Fn(&S, [Range<usize>; 3], usize, &mut [f64]) + Sync,
    ) {
        let (slow, layers) = self.lattice.tiles();
        let points = layers * self.lattice.layer();
        let n_tiles = self.lattice.len().div_ceil(points);
        let mut lists: Vec<Vec<(u32, [Range<usize>; 3])>> = vec![Vec::new(); n_tiles];
        for (k, source) in sources.iter().enumerate() {
            let (center, reach) = ball(source);
            let ranges = self.lattice.ranges(&center, reach);
            if ranges.iter().any(Range::is_empty) {
                continue;
            }
            let tiles = ranges[slow].start / layers..=(ranges[slow].end - 1) / layers;
            for tile in tiles {
                let mut own = ranges.clone();
                own[slow] = own[slow].start.max(tile * layers)..own[slow].end.min((tile + 1) * layers);
                lists[tile].push((k as u32, own));
            }
        }
        sums.par_chunks_mut(points * self.layout.size).zip(lists).enumerate().for_each(|(tile, (sums, list))| {
            for (k, ranges) in list {
                add(&sources[k as usize], ranges, tile * points, sums);
            }
        });
    }

    #[inline(always)]
    fn each_point(&self, [ri, rj, rk]: [Range<usize>; 3], mut f: impl FnMut(usize, Vec3)) {
        for i in ri {
            for j in rj.clone() {
                let j = self.lattice.wrapped(j);
                for k in rk.clone() {
                    f(self.lattice.index([i, j, k]), self.lattice.point([i, j, k]));
                }
            }
        }
    }
}

impl Derived {
    /// `d` from the source to the point, `phi` the kernel there, `slope` times `d` its gradient.
    #[inline(always)]
    fn add(&self, cell: &mut [f64], row: &[f64], d: &Vec3, phi: f64, slope: f64) {
        let mass = row[self.mass];
        if let Some(at) = self.second_moment {
            let weight = mass * phi;
            let products = [d.x * d.x, d.x * d.y, d.x * d.z, d.y * d.y, d.y * d.z, d.z * d.z];
            cell[at..at + 6].iter_mut().zip(products).for_each(|(to, product)| *to += weight * product);
        }
        if let (Some(of_mass), Some(of_momentum)) = (self.mass_gradient, self.momentum_gradient) {
            for k in 0..3 {
                cell[of_mass + k] += mass * slope * d[k];
                for a in 0..3 {
                    cell[of_momentum + 3 * a + k] += row[self.momentum + a] * slope * d[k];
                }
            }
        }
    }
}

/// Lines shorter than this part of the support are points: the error is their square, the rounding of the exact
/// integral their inverse.
const SHORT: f64 = 1e-5;

/// A line as the resolved axes see it.
struct Line<'s> {
    source: &'s LineSource,
    along: Vec3,
    length: f64,
    is_point: bool,
}

impl<'s> Line<'s> {
    fn of(source: &'s LineSource, lattice: &Lattice, kernel: &Kernel) -> Self {
        let along = lattice.resolved(source.along);
        let length = along.norm();
        Self { source, along, length, is_point: length < SHORT * kernel.support }
    }

    /// Integral of the kernel over the line's parameter, at a point.
    #[inline(always)]
    fn value(&self, point: &Vec3, deposit: &Deposit<'_>) -> f64 {
        let d = |from: &Vec3| deposit.lattice.resolved(point - from);
        if let Some(nodes) = &self.source.nodes {
            return nodes.iter().map(|(node, weight)| weight * deposit.kernel.value(d(node).norm_squared())).sum();
        }
        let Range { start, end } = self.source.part;
        let d = d(&self.source.start);
        if self.is_point {
            let middle = d - self.along * (0.5 * (start + end));
            return (end - start) * deposit.kernel.value(middle.norm_squared());
        }
        let along = d.dot(&self.along) / self.length;
        let squared = (d.norm_squared() - along * along).max(0.0);
        deposit.kernel.along(squared, start * self.length - along, end * self.length - along) / self.length
    }
}
