//! What plane walls cut off a kernel is given back to the part in front of them: each source keeps its whole weight.
//!
//! Exact for one plane and for two that face each other; at other edges and corners the parts are multiplied, which is
//! exact for a Gaussian that is not cut off and planes at right angles.

use super::deposit::LineSource;
use super::kernel::{HalfSpaces, Kernel, LEGENDRE};
use super::lattice::Lattice;
use super::pose::Pose;
use super::sources::FieldSources;
use crate::math::Vec3;

/// A part below this counts as nothing: the source lies behind the wall.
const NOTHING: f64 = 1e-6;

/// Planes in the frame of the grid.
pub(super) struct Walls {
    planes: Vec<(Vec3, Vec3)>,
    halves: HalfSpaces,
    support: f64,
}

impl Walls {
    /// Those planes that stand at right angles to the homogeneous axes: the others cut nothing off.
    pub fn new(sources: &FieldSources<'_>, pose: &Pose, lattice: &Lattice, kernel: &Kernel) -> Self {
        let planes = sources
            .planes()
            .map(|(point, normal)| (pose.in_frame(&point), pose.rotation.tr_mul(&normal)))
            .filter(|(_, normal)| (lattice.resolved(*normal) - normal).norm() < 1e-9)
            .collect();
        Self { planes, halves: kernel.half_spaces(), support: kernel.support }
    }

    fn distances<'a>(&'a self, x: &'a Vec3) -> impl Iterator<Item = (&'a Vec3, f64)> + 'a {
        self.planes.iter().map(move |(point, normal)| (normal, normal.dot(&(x - point))))
    }

    /// Part of a kernel about `x` that lies in front of the walls.
    fn part(&self, x: &Vec3) -> f64 {
        let mut parts: Vec<(&Vec3, f64)> = Vec::new();
        for (normal, distance) in self.distances(x).filter(|(_, distance)| *distance < self.support) {
            let part = self.halves.part(distance);
            // one wall twice
            match parts.iter_mut().find(|(other, _)| other.dot(normal) > 1.0 - 1e-9) {
                Some((_, other)) => *other = other.min(part),
                None => parts.push((normal, part)),
            }
        }
        match parts[..] {
            [] => 1.0,
            [(n, p), (m, q)] if n.dot(m) < 1e-9 - 1.0 => (p + q - 1.0).max(0.0),
            _ => parts.iter().map(|(_, part)| part).product(),
        }
    }

    /// What a point source is multiplied with.
    pub fn factor(&self, x: &Vec3) -> f64 {
        let part = self.part(x);
        if part > NOTHING { 1.0 / part } else { 0.0 }
    }

    /// Replaces a line that walls are near to by points, each of the whole weight.
    pub fn correct(&self, line: &mut LineSource) {
        let end = line.start + line.along;
        let is_far = |x: &Vec3| self.distances(x).all(|(_, distance)| distance >= self.support);
        if is_far(&line.start) && is_far(&end) {
            return;
        }
        let length = line.part.end - line.part.start;
        let nodes = (0..2).flat_map(|half| LEGENDRE.map(|(x, weight)| (0.5 * (f64::from(half) + x), 0.5 * weight)));
        line.nodes = Some(
            nodes
                .map(|(s, weight)| {
                    let x = line.start + line.along * (line.part.start + s * length);
                    (x, length * weight * self.factor(&x))
                })
                .collect(),
        );
    }

    /// Clears the sums of points behind walls.
    pub fn clear_behind(&self, lattice: &Lattice, size: usize, sums: &mut [f64]) {
        if self.planes.is_empty() {
            return;
        }
        lattice.each_point(|index, x| {
            if self.distances(&x).any(|(_, distance)| distance < 0.0) {
                sums[index * size..(index + 1) * size].fill(0.0);
            }
        });
    }
}
