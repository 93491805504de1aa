//! The neighbour list: when it is stale, and how it is rebuilt.

use rayon::prelude::*;

use super::adjacency::{Adjacency, Entry};
use super::levels::Levels;
use super::search::{Found, Search};
use crate::boundary::Boundary;
use crate::cell::Cell;
use crate::contact::Slot;
use crate::math::{Quat, Vec3};
use crate::parallel::least;
use crate::particles::Particles;
use crate::scene::PointLaws;
use crate::shape::{Part, PartGeometry, Shape};

/// How far a shape's parts reach, for unit scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeReach {
    /// Largest distance that rotation moves a point of the surface by, per radian: 0 for a sphere.
    pub lever: f64,
    /// A single sphere about the centre of mass.
    pub is_sphere: bool,
    /// A single spherocylinder or sphere about the centre of mass: half its axis, body axes, and its radius.
    pub rod: Option<(Vec3, f64)>,
}

impl ShapeReach {
    /// Of a shape.
    pub fn of(shape: &Shape) -> Self {
        let is_sphere = matches!(
            shape.parts(),
            [part] if matches!(part.geometry, PartGeometry::Sphere { .. }) && part.center == Vec3::zeros()
        );
        let rod = match shape.parts() {
            [Part { geometry: PartGeometry::Sphere { radius, .. }, .. }] if is_sphere => Some((Vec3::zeros(), *radius)),
            // the ends of any other would have to be asked one by one
            [Part { geometry: PartGeometry::Spherocylinder { ends: [e, f], radius }, .. }]
                if (e + f).norm() < 1e-14 * radius =>
            {
                Some(((f - e) * 0.5, *radius))
            }
            _ => None,
        };
        Self { lever: if is_sphere { 0.0 } else { shape.bounding_radius() }, is_sphere, rod }
    }
}

/// What the list reads.
#[derive(Clone, Copy)]
pub struct NeighbourInputs<'a> {
    /// By shape index.
    pub shapes: &'a [Shape],
    /// By shape index.
    pub reaches: &'a [ShapeReach],
    /// By boundary index.
    pub boundaries: &'a [Boundary],
    /// Whether polyhedra meet by generalized overlap.
    pub rounded: bool,
    /// Whether two spheres meet by the laws that the sphere batch knows; else they are parts like any other.
    pub sphere_batch: bool,
    /// Periodic cell.
    pub cell: &'a Cell,
    /// Skin over the harmonic mean of the bounding diameters.
    pub skin_fraction: f64,
    /// Pairs of parts that may be listed.
    pub most_pairs: usize,
    /// Laws of contacts that hold beyond the touch, where the scene has such.
    pub bonds: Option<&'a PointLaws>,
    /// Present time, s.
    pub time_s: f64,
}

/// State of the neighbour list.
#[derive(Clone, Debug, Default)]
pub struct Neighbours {
    /// Distance up to which gaps are listed, m.
    pub skin: f64,
    /// Rebuilds so far.
    pub rebuilds: u64,
    valid: bool,
    built_at_s: f64,
    reach_of_rows: f64,
    position: Vec<Vec3>,
    orientation: Vec<Quat>,
    levels: Levels,
    found: Vec<Found>,
    /// Row k was row `order[k]` before the last rebuild.
    order: Vec<u32>,
    adjacency: Adjacency,
}

impl Neighbours {
    /// Makes the next staleness test fail.
    pub fn invalidate(&mut self) {
        self.valid = false;
    }

    /// Whether some pair may touch that is not listed: nothing may have moved by more than half the skin.
    pub fn is_stale(&self, particles: &Particles, inputs: &NeighbourInputs<'_>) -> bool {
        if !self.valid {
            return true;
        }
        let half = 0.5 * self.skin;
        let elapsed = inputs.time_s - self.built_at_s;
        let wall = inputs
            .boundaries
            .iter()
            .map(|boundary| boundary.largest_closing_speed(self.reach_of_rows + boundary.pivot.norm()) * elapsed)
            .fold(0.0, f64::max);
        if wall > half {
            return true;
        }
        let moved = |row: usize| {
            let displacement = (particles.position[row] + particles.offset[row]) - self.position[row];
            let lever = inputs.reaches[particles.shape[row] as usize].lever * particles.scale[row];
            if lever == 0.0 {
                return displacement.norm_squared() > half * half;
            }
            let cosine = particles.orientation[row].coords.dot(&self.orientation[row].coords);
            displacement.norm() + 2.0 * lever * (1.0 - cosine * cosine).max(0.0).sqrt() > half
        };
        let n = particles.n_owned();
        (0..n).into_par_iter().with_min_len(least(n, 512, 5)).any(moved)
    }

    /// Sorts rows by level and cell, makes the ghosts, and lists all pairs of parts with a gap below the skin: spheres
    /// in [`Neighbours::sphere_pairs`], the others in `slots`. Lists none, and returns `false`, where there are more than
    /// `inputs.most_pairs`.
    pub fn rebuild(&mut self, particles: &mut Particles, inputs: &NeighbourInputs<'_>, slots: &mut Vec<Slot>) -> bool {
        particles.drop_ghosts();
        let n = particles.n_owned();
        // Grains are dust to each other's eyes: one of a thousandth among many must not cost them their skin, and a few
        // large ones must not lengthen the lists of the many small.
        let inverse: f64 = particles.radius.iter().map(|radius| 1.0 / radius).sum();
        self.skin = if n == 0 { 0.0 } else { 2.0 * inputs.skin_fraction * n as f64 / inverse };
        if let Some(laws) = inputs.bonds {
            let largest = particles.radius.iter().copied().fold(0.0, f64::max);
            self.skin = self.skin.max(laws.least_skin(largest));
        }
        particles.offset.fill(Vec3::zeros());
        self.levels.build(&particles.radius, self.skin, |row| particles.position[row]);
        self.levels.order(&mut self.order);
        particles.select(&self.order);
        self.push_ghosts(particles, inputs.cell);
        self.levels.build(&particles.radius, self.skin, |row| particles.position[row] + particles.offset[row]);
        self.position.clear();
        self.position.extend_from_slice(&particles.position[..n]);
        self.orientation.clear();
        self.orientation.extend_from_slice(&particles.orientation);
        let farthest = particles.position.iter().map(|x| x.norm()).fold(0.0, f64::max);
        self.reach_of_rows = farthest + 2.0 * self.levels.largest() + self.skin;
        self.built_at_s = inputs.time_s;
        self.valid = true;
        self.rebuilds += 1;
        let search = Search { particles, inputs, levels: &self.levels, skin: self.skin };
        let all = search.run(&mut self.found, slots);
        self.adjacency.rebuild(particles, slots);
        all
    }

    /// Rows of the listed pairs of spheres, that of the lower id first.
    pub fn sphere_pairs(&self) -> impl Iterator<Item = &[[u32; 2]]> + Clone {
        self.found.iter().map(|found| found.spheres.as_slice())
    }

    /// Row k was row `order()[k]` before the last rebuild.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Images of each row that a row of its own or of a finer level may touch.
    fn push_ghosts(&self, particles: &mut Particles, cell: &Cell) {
        if !cell.is_periodic() {
            return;
        }
        let shifts = |row: usize, axis: usize, particles: &Particles| -> [Option<f64>; 3] {
            if !cell.periodic[axis] {
                return [Some(0.0), None, None];
            }
            let radius = particles.radius[row];
            let margin = radius + self.levels.largest_beside(radius) + self.skin;
            let inside = particles.position[row][axis] - cell.min[axis];
            let length = cell.extent[axis];
            [Some(0.0), (inside < margin).then_some(length), (inside > length - margin).then_some(-length)]
        };
        for row in 0..particles.n_owned() {
            let [x, y, z] = [0, 1, 2].map(|axis| shifts(row, axis, particles));
            for dx in x.into_iter().flatten() {
                for dy in y.into_iter().flatten() {
                    for dz in z.into_iter().flatten() {
                        let shift = Vec3::new(dx, dy, dz);
                        if shift != Vec3::zeros() {
                            particles.push_ghost(row, shift);
                        }
                    }
                }
            }
        }
    }

    /// Slots of a row.
    #[inline]
    pub fn of_row(&self, row: usize) -> &[Entry] {
        self.adjacency.of_row(row)
    }
}
