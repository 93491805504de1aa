//! All pairs of parts with a gap below the skin.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use rayon::prelude::*;

use super::levels::Levels;
use super::neighbours::NeighbourInputs;
use crate::boundary::Boundary;
use crate::contact::{Slot, SlotKind};
use crate::mesh::Mesh;
use crate::narrow::apart_by;
use crate::parallel::least;
use crate::particles::Particles;
use crate::shape::{Part, PartGeometry};

/// Rows per task; never a function of the thread count.
const ROWS: usize = 256;

/// What one task found, by kind; kept from rebuild to rebuild for its buffers.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Rows of two spheres, that of the lower id first.
    pub spheres: Vec<[u32; 2]>,
    rods: Vec<Slot>,
    parts: Vec<Slot>,
    rounded_parts: Vec<Slot>,
    features: Vec<Slot>,
    walls: Vec<Slot>,
    rounded_walls: Vec<Slot>,
    /// Scratch: elements of a mesh.
    elements: Vec<u32>,
}

impl Found {
    /// In the order of [`SlotKind`].
    fn by_kind(&self) -> [&Vec<Slot>; 6] {
        [&self.rods, &self.parts, &self.rounded_parts, &self.features, &self.walls, &self.rounded_walls]
    }

    fn len(&self) -> usize {
        self.spheres.len() + self.by_kind().iter().map(|slots| slots.len()).sum::<usize>()
    }

    fn clear(&mut self) {
        self.spheres.clear();
        self.rods.clear();
        self.parts.clear();
        self.rounded_parts.clear();
        self.features.clear();
        self.walls.clear();
        self.rounded_walls.clear();
    }
}

/// What the search reads.
pub(super) struct Search<'a> {
    pub particles: &'a Particles,
    pub inputs: &'a NeighbourInputs<'a>,
    pub levels: &'a Levels,
    /// m
    pub skin: f64,
}

fn is_polyhedron(part: &Part) -> bool {
    matches!(part.geometry, PartGeometry::Polyhedron(_))
}

/// Cylinders have no skeleton: their rims are no edges.
fn meet_by_features(a: &Part, b: &Part) -> bool {
    (a.is_rounded_polyhedron() || b.is_rounded_polyhedron()) && a.skeleton.is_some() && b.skeleton.is_some()
}

impl Search<'_> {
    /// Fills `found` by task, and `slots` grouped by kind, in an order that does not depend on the thread count; with
    /// nothing, and returns `false`, where there are more pairs than allowed.
    pub fn run(&self, found: &mut Vec<Found>, slots: &mut Vec<Slot>) -> bool {
        let n = self.particles.n_owned();
        let tasks = n.div_ceil(ROWS);
        let (counted, most) = (AtomicUsize::new(0), self.inputs.most_pairs);
        found.resize_with(tasks, Found::default);
        found.par_iter_mut().enumerate().with_min_len(least(n, ROWS, 150).div_ceil(ROWS)).for_each(|(task, found)| {
            found.clear();
            let mut before = 0;
            for row in task * ROWS..((task + 1) * ROWS).min(n) {
                self.find_partners(row, found);
                self.find_walls(row, found);
                // counted while they are found: the list of a heap in one place would not fit into memory
                let new = found.len() - before;
                before += new;
                if counted.fetch_add(new, Relaxed) + new > most {
                    return;
                }
            }
        });
        slots.clear();
        if counted.into_inner() > most {
            found.iter_mut().for_each(Found::clear);
            return false;
        }
        for kind in 0..6 {
            found.iter().for_each(|found| slots.extend_from_slice(found.by_kind()[kind]));
        }
        true
    }

    fn find_partners(&self, row: usize, found: &mut Found) {
        let particles = self.particles;
        let (owned, id, radius) = (particles.n_owned(), particles.ids[row], particles.radius[row]);
        let reach = radius + self.skin;
        self.levels.visit(&particles.position[row], radius, |others, same_level| {
            for &other in others {
                let other = other as usize;
                // Each pair once. On one level: owned pairs from the lower row, images from the row with the lower id.
                // On two: from the smaller side, so that only the larger one needs images.
                if same_level && other <= row {
                    continue;
                }
                if particles.is_frozen(row) && particles.is_frozen(other) {
                    continue;
                }
                let reach = reach + particles.radius[other];
                if particles.separation(row, other).norm_squared() >= reach * reach {
                    continue;
                }
                let other_id = particles.ids[particles.owner(other)];
                if same_level && other >= owned && other_id <= id {
                    continue;
                }
                let (a, b) = if id < other_id { (row, other) } else { (other, row) };
                self.find_parts(a, b, found);
            }
        });
    }

    fn find_parts(&self, a: usize, b: usize, found: &mut Found) {
        let (particles, inputs) = (self.particles, self.inputs);
        let (shape_a, shape_b) = (particles.shape[a] as usize, particles.shape[b] as usize);
        if inputs.sphere_batch && inputs.reaches[shape_a].is_sphere && inputs.reaches[shape_b].is_sphere {
            found.spheres.push([a as u32, b as u32]);
            return;
        }
        let slot = |part_a: usize, part_b: usize, kind: SlotKind| Slot {
            a: a as u32,
            b: b as u32,
            part_a: part_a as u16,
            part_b: part_b as u16,
            kind,
        };
        let rods =
            inputs.reaches[shape_a].rod.is_some() && inputs.reaches[shape_b].rod.is_some() && inputs.bonds.is_none();
        let (a_from_b, scale) = particles.a_from_b(a, b, &particles.separation(a, b));
        for (ka, part_a) in inputs.shapes[shape_a].parts().iter().enumerate() {
            for (kb, part_b) in inputs.shapes[shape_b].parts().iter().enumerate() {
                if apart_by(part_a, part_b, &a_from_b, self.skin / scale) {
                    continue;
                }
                if rods {
                    found.rods.push(slot(ka, kb, SlotKind::Rods));
                } else if meet_by_features(part_a, part_b) {
                    found.features.push(slot(ka, kb, SlotKind::Features));
                } else if inputs.rounded && is_polyhedron(part_a) && is_polyhedron(part_b) {
                    found.rounded_parts.push(slot(ka, kb, SlotKind::RoundedParts));
                } else {
                    found.parts.push(slot(ka, kb, SlotKind::Parts));
                }
            }
        }
    }

    /// One slot for each element of a mesh that a part may touch.
    fn find_elements(&self, row: usize, boundary: &Boundary, (mesh, first): (&Mesh, u32), found: &mut Found) {
        let (particles, inputs) = (self.particles, self.inputs);
        let scale = particles.scale[row];
        let mesh_from_body = boundary.wall_from_body(&particles.position[row], &particles.rotation[row], scale);
        for (k, part) in inputs.shapes[particles.shape[row] as usize].parts().iter().enumerate() {
            let centre = mesh_from_body.point(&part.center);
            mesh.near(&centre, part.radius * scale + self.skin, self.skin, &mut found.elements);
            for &element in &found.elements {
                let rounded = inputs.rounded && mesh.is_patch(element) && is_polyhedron(part);
                let (kind, list) = if rounded {
                    (SlotKind::RoundedWall, &mut found.rounded_walls)
                } else {
                    (SlotKind::Wall, &mut found.walls)
                };
                list.push(Slot { a: row as u32, b: first + element, part_a: k as u16, part_b: 0, kind });
            }
        }
    }

    fn find_walls(&self, row: usize, found: &mut Found) {
        let (particles, inputs) = (self.particles, self.inputs);
        if particles.is_frozen(row) {
            return;
        }
        for (index, boundary) in inputs.boundaries.iter().enumerate() {
            if let Some((mesh, first)) = boundary.numbered_mesh() {
                self.find_elements(row, boundary, (mesh, first), found);
                continue;
            }
            if boundary.distance(&particles.position[row]) >= particles.radius[row] + self.skin {
                continue;
            }
            for (k, part) in inputs.shapes[particles.shape[row] as usize].parts().iter().enumerate() {
                let scale = particles.scale[row];
                let centre = particles.position[row] + particles.rotation[row] * (part.center * scale);
                if boundary.distance(&centre) < part.radius * scale + self.skin {
                    let rounded = inputs.rounded && boundary.shape.has_overlap_terms() && is_polyhedron(part);
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
}
