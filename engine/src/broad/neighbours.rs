//! The neighbour list: when it is stale, and how it is rebuilt.

use rayon::prelude::*;

use super::cell_list::CellList;
use crate::boundary::Boundary;
use crate::cell::Cell;
use crate::contact::{Slot, SlotKind};
use crate::math::{Quat, Vec3};
use crate::narrow::apart_by;
use crate::particles::Particles;
use crate::shape::{Part, PartGeometry, Shape};

/// How far a shape's parts reach, for unit scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeReach {
    /// Largest distance that rotation moves a point of the surface by, per radian: 0 for a sphere.
    pub lever: f64,
    /// A single sphere about the centre of mass.
    pub is_sphere: bool,
}

impl ShapeReach {
    /// Of a shape.
    pub fn of(shape: &Shape) -> Self {
        let is_sphere = matches!(
            shape.parts(),
            [part] if matches!(part.geometry, PartGeometry::Sphere { .. }) && part.center == Vec3::zeros()
        );
        Self { lever: if is_sphere { 0.0 } else { shape.bounding_radius() }, is_sphere }
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
    /// Periodic cell.
    pub cell: &'a Cell,
    /// Skin over the smallest bounding diameter.
    pub skin_fraction: f64,
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
    cells: CellList,
    /// Per row: slots it takes part in, sorted so that sums do not depend on rows.
    adjacency_starts: Vec<u32>,
    adjacency: Vec<Entry>,
}

/// One slot of a row: index, and which side the row is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry(u32);

impl Entry {
    fn new(slot: usize, is_b: bool) -> Self {
        Self((slot as u32) << 1 | u32::from(is_b))
    }

    /// Index of the slot.
    #[inline(always)]
    pub fn slot(self) -> usize {
        (self.0 >> 1) as usize
    }

    /// Whether the row is side b.
    #[inline(always)]
    pub fn is_b(self) -> bool {
        self.0 & 1 == 1
    }
}

/// Slots found by one task, by kind.
#[derive(Default)]
struct Found {
    spheres: Vec<Slot>,
    parts: Vec<Slot>,
    rounded_parts: Vec<Slot>,
    features: Vec<Slot>,
    walls: Vec<Slot>,
    rounded_walls: Vec<Slot>,
}

impl Found {
    /// In the order of [`SlotKind`].
    fn by_kind(&self) -> [&Vec<Slot>; 6] {
        [&self.spheres, &self.parts, &self.rounded_parts, &self.features, &self.walls, &self.rounded_walls]
    }
}

fn is_polyhedron(part: &Part) -> bool {
    matches!(part.geometry, PartGeometry::Polyhedron(_))
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
            let turned = if lever > 0.0 {
                let cosine = particles.orientation[row].coords.dot(&self.orientation[row].coords);
                2.0 * lever * (1.0 - cosine * cosine).max(0.0).sqrt()
            } else {
                0.0
            };
            displacement.norm() + turned > half
        };
        (0..particles.n_owned()).into_par_iter().with_min_len(512).any(moved)
    }

    /// Sorts rows by cell, makes the ghosts, and lists all pairs of parts with a gap below the skin.
    pub fn rebuild(&mut self, particles: &mut Particles, inputs: &NeighbourInputs<'_>) -> Vec<Slot> {
        particles.drop_ghosts();
        let (smallest, largest) = particles
            .radius
            .iter()
            .fold((f64::INFINITY, 0.0f64), |(low, high), &radius| (low.min(radius), high.max(radius)));
        self.skin = if particles.n_owned() == 0 { 0.0 } else { 2.0 * smallest * inputs.skin_fraction };
        let size = 2.0 * largest + self.skin;
        particles.offset.fill(Vec3::zeros());
        self.cells.build(particles.n_owned(), size, |row| particles.position[row]);
        particles.select(self.cells.rows());
        self.push_ghosts(particles, inputs.cell, largest);
        let rows = particles.position.len();
        self.cells.build(rows, size, |row| particles.position[row] + particles.offset[row]);
        let n = particles.n_owned();
        self.position.clear();
        self.position.extend_from_slice(&particles.position[..n]);
        self.orientation.clear();
        self.orientation.extend_from_slice(&particles.orientation);
        self.reach_of_rows = particles.position.iter().map(|x| x.norm()).fold(0.0, f64::max) + size;
        self.built_at_s = inputs.time_s;
        self.valid = true;
        self.rebuilds += 1;
        let slots = self.find(particles, inputs);
        self.link(particles, &slots);
        slots
    }

    /// Images of all rows that a row of the cell may touch.
    fn push_ghosts(&self, particles: &mut Particles, cell: &Cell, largest: f64) {
        if !cell.is_periodic() {
            return;
        }
        let shifts = |row: usize, axis: usize, particles: &Particles| -> [Option<f64>; 3] {
            if !cell.periodic[axis] {
                return [Some(0.0), None, None];
            }
            let margin = particles.radius[row] + largest + self.skin;
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

    /// All slots, grouped by kind, in an order that does not depend on the thread count.
    fn find(&self, particles: &Particles, inputs: &NeighbourInputs<'_>) -> Vec<Slot> {
        const ROWS: usize = 256;
        let n = particles.n_owned();
        let found: Vec<Found> = (0..n.div_ceil(ROWS))
            .into_par_iter()
            .map(|task| {
                let mut found = Found::default();
                for row in task * ROWS..((task + 1) * ROWS).min(n) {
                    self.find_partners(row, particles, inputs, &mut found);
                    self.find_walls(row, particles, inputs, &mut found);
                }
                found
            })
            .collect();
        let mut slots = Vec::with_capacity(found.iter().flat_map(Found::by_kind).map(Vec::len).sum());
        for kind in 0..6 {
            found.iter().for_each(|f| slots.extend_from_slice(f.by_kind()[kind]));
        }
        slots
    }

    fn find_partners(&self, row: usize, particles: &Particles, inputs: &NeighbourInputs<'_>, found: &mut Found) {
        let x = particles.position[row];
        for &other in self.cells.around(&x).flatten() {
            let other = other as usize;
            // Each pair once: owned pairs from the lower row, images from the row with the lower id.
            if other <= row {
                continue;
            }
            let (id, other_id) = (particles.ids[row], particles.ids[particles.owner(other)]);
            if other >= particles.n_owned() && other_id <= id {
                continue;
            }
            let reach = particles.radius[row] + particles.radius[other] + self.skin;
            if particles.separation(row, other).norm_squared() >= reach * reach {
                continue;
            }
            let (a, b) = if id < other_id { (row, other) } else { (other, row) };
            self.find_parts(a, b, particles, inputs, found);
        }
    }

    fn find_parts(&self, a: usize, b: usize, particles: &Particles, inputs: &NeighbourInputs<'_>, found: &mut Found) {
        let (shape_a, shape_b) = (particles.shape[a] as usize, particles.shape[b] as usize);
        let slot = |part_a: usize, part_b: usize, kind: SlotKind| Slot {
            a: a as u32,
            b: b as u32,
            part_a: part_a as u16,
            part_b: part_b as u16,
            kind,
        };
        if inputs.reaches[shape_a].is_sphere && inputs.reaches[shape_b].is_sphere {
            found.spheres.push(slot(0, 0, SlotKind::SphereSphere));
            return;
        }
        let (a_from_b, scale) = particles.a_from_b(a, b, &particles.separation(a, b));
        for (ka, part_a) in inputs.shapes[shape_a].parts().iter().enumerate() {
            for (kb, part_b) in inputs.shapes[shape_b].parts().iter().enumerate() {
                if apart_by(part_a, part_b, &a_from_b, self.skin / scale) {
                    continue;
                }
                if part_a.is_rounded_polyhedron() || part_b.is_rounded_polyhedron() {
                    found.features.push(slot(ka, kb, SlotKind::Features));
                } else if inputs.rounded && is_polyhedron(part_a) && is_polyhedron(part_b) {
                    found.rounded_parts.push(slot(ka, kb, SlotKind::RoundedParts));
                } else {
                    found.parts.push(slot(ka, kb, SlotKind::Parts));
                }
            }
        }
    }

    fn find_walls(&self, row: usize, particles: &Particles, inputs: &NeighbourInputs<'_>, found: &mut Found) {
        for (index, boundary) in inputs.boundaries.iter().enumerate() {
            if boundary.distance(&particles.position[row]) >= particles.radius[row] + self.skin {
                continue;
            }
            for (k, part) in inputs.shapes[particles.shape[row] as usize].parts().iter().enumerate() {
                let scale = particles.scale[row];
                let centre = particles.position[row] + particles.rotation[row] * (part.center * scale);
                if boundary.distance(&centre) < part.radius * scale + self.skin {
                    let rounded = inputs.rounded && is_polyhedron(part);
                    let (kind, list) = if rounded {
                        (SlotKind::RoundedWall, &mut found.rounded_walls)
                    } else {
                        (SlotKind::Wall, &mut found.walls)
                    };
                    list.push(Slot { a: row as u32, b: index as u32, part_a: k as u16, part_b: 0, kind });
                }
            }
        }
    }

    /// Lists each row's slots in the order of (partner's id, parts): the order in which forces are added.
    fn link(&mut self, particles: &Particles, slots: &[Slot]) {
        let n = particles.n_owned();
        let sides = |slot: &Slot| {
            let b = (!slot.kind.is_wall()).then(|| particles.owner(slot.b as usize));
            (slot.a as usize, b)
        };
        let starts = &mut self.adjacency_starts;
        starts.clear();
        starts.resize(n + 1, 0);
        for slot in slots {
            let (a, b) = sides(slot);
            starts[particles.owner(a) + 1] += 1;
            if let Some(b) = b {
                starts[b + 1] += 1;
            }
        }
        for row in 0..n {
            starts[row + 1] += starts[row];
        }
        let mut next: Vec<u32> = starts[..n].to_vec();
        self.adjacency.clear();
        self.adjacency.resize(starts[n] as usize, Entry(0));
        let adjacency = &mut self.adjacency;
        let mut put = |row: usize, entry: Entry| {
            adjacency[next[row] as usize] = entry;
            next[row] += 1;
        };
        for (index, slot) in slots.iter().enumerate() {
            let (a, b) = sides(slot);
            put(particles.owner(a), Entry::new(index, false));
            if let Some(b) = b {
                put(b, Entry::new(index, true));
            }
        }
        let key = |entry: &Entry| {
            let slot = &slots[entry.slot()];
            let is_wall = slot.kind.is_wall();
            let partner = match (is_wall, entry.is_b()) {
                (true, _) => u64::from(slot.b),
                (false, true) => particles.ids[particles.owner(slot.a as usize)],
                (false, false) => particles.ids[particles.owner(slot.b as usize)],
            };
            (is_wall, partner, slot.part_a, slot.part_b)
        };
        for row in 0..n {
            self.adjacency[starts[row] as usize..starts[row + 1] as usize].sort_unstable_by_key(key);
        }
    }

    /// Slots of a row.
    #[inline]
    pub fn of_row(&self, row: usize) -> &[Entry] {
        &self.adjacency[self.adjacency_starts[row] as usize..self.adjacency_starts[row + 1] as usize]
    }
}
