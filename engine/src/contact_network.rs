//! The contact network: who touches whom, where, and with what force, for whoever lives outside the physics thread.
//!
//! One row per pair of convex parts that touch, with the very force that acted in the last step: the laws are not
//! evaluated again. Nothing here costs a step anything.

use crate::boundary::WallSide;
use crate::contact::{CHUNK, Contact, ContactChunk, OverlapContact, Slot, Wrench};
use crate::engine::Engine;
use crate::math::Vec3;
use crate::narrow::generalized_overlap::OverlapPoint;

/// What touches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactKind {
    /// One point of smooth surfaces, or of vertices and edges of rounded polyhedra.
    #[default]
    Smooth,
    /// One point of a vertex (or a rim) on a face.
    VertexFace,
    /// One point of two edges.
    EdgeEdge,
    /// Several points: faces or edges that lie on each other.
    Manifold,
    /// A contact by generalized overlap.
    Overlap,
}

/// One touching pair of convex parts: of particles `a` and `b`, `a` having the lower id, or of a particle and a boundary.
///
/// On `a` acts `tangential_force_n - normal_force_n * normal`, and about its centre that force at `point_m` and
/// `moment_n_m`; on `b` the opposite of all.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactRow {
    /// Of `a`.
    pub id_a: u64,
    /// Of `b`; `None` at a boundary.
    pub id_b: Option<u64>,
    /// In the order of the scene; `None` between particles.
    pub boundary: Option<u32>,
    /// Of `a`; of `b`, or which element of a mesh (0 at other boundaries).
    pub parts: [u32; 2],
    /// Mean of the touching points, weighted by what their springs carry, at the wrapped centre of `a`, m.
    pub point_m: [f64; 3],
    /// Unit vector from `a` to `b`, weighted in the same way.
    pub normal: [f64; 3],
    /// Largest of the points; the overlap of the law where that is a generalized one, m. Below 0 where cohesion holds
    /// parts that are apart.
    pub overlap_m: f64,
    /// Along the normal, N: positive where the parts are pushed apart.
    pub normal_force_n: f64,
    /// On `a`, at right angles to the normal, N.
    pub tangential_force_n: [f64; 3],
    /// On `a` about the point, N m: several points' couple, rolling and twisting resistance.
    pub moment_n_m: [f64; 3],
    /// What touches.
    pub kind: ContactKind,
    /// Touching points.
    pub points: u32,
}

/// All contacts of one state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactNetwork {
    /// Steps done.
    pub step: u64,
    /// Simulated time.
    pub time_s: f64,
    /// Counts insertions and removals.
    pub topology_epoch: u64,
    /// In ascending order of id of `a`, then of `b`, boundaries last, then of the parts: the same on any number of threads.
    pub rows: Vec<ContactRow>,
}

impl ContactRow {
    fn key(&self) -> (u64, u64, u32, [u32; 2]) {
        (self.id_a, self.id_b.unwrap_or(u64::MAX), self.boundary.unwrap_or(0), self.parts)
    }

    /// On `a`, N.
    pub fn force_on_a_n(&self) -> [f64; 3] {
        std::array::from_fn(|c| self.tangential_force_n[c] - self.normal_force_n * self.normal[c])
    }

    fn set_force(&mut self, force_on_a: &Vec3, normal: &Vec3) {
        let along = force_on_a.dot(normal);
        self.normal = (*normal).into();
        self.normal_force_n = -along;
        self.tangential_force_n = (force_on_a - normal * along).into();
    }
}

impl Engine {
    /// Writes the contacts of the present state into `network`, whose buffer is reused. The engine is left alone.
    pub fn contact_network(&self, network: &mut ContactNetwork) {
        network.step = self.clock.step();
        network.time_s = self.clock.time_s();
        network.topology_epoch = self.topology_epoch;
        network.rows.clear();
        self.push_sphere_contacts(&mut network.rows);
        for (k, chunk) in self.contacts.chunks.iter().enumerate() {
            self.push_chunk(k * CHUNK, chunk, &mut network.rows);
        }
        // A pair that meets across the cell on two sides has two rows of one key.
        let x = |row: &ContactRow| row.point_m;
        network.rows.sort_unstable_by(|p, q| {
            let by_place = || (0..3).map(|c| x(p)[c].total_cmp(&x(q)[c])).find(|order| order.is_ne());
            p.key().cmp(&q.key()).then_with(|| by_place().unwrap_or(std::cmp::Ordering::Equal))
        });
    }

    fn push_sphere_contacts(&self, rows: &mut Vec<ContactRow>) {
        let particles = &self.particles;
        for (pair, force_on_b) in self.contacts.spheres.touching_forces() {
            // In the operations of the force evaluation, and from the same columns: ghosts are not kept elsewhere.
            let (a, b) = (&particles.places[pair.a as usize], &particles.places[pair.b as usize]);
            let d = (b.position - a.position) + (b.offset - a.offset);
            let distance = d.norm();
            let normal = if distance > 0.0 { d * (1.0 / distance) } else { Vec3::z() };
            let overlap = (a.radius + b.radius) - distance;
            let [id_a, id_b] = pair.ids(particles);
            let mut row = ContactRow {
                id_a,
                id_b: Some(id_b),
                point_m: (a.position + normal * (a.radius - 0.5 * overlap)).into(),
                overlap_m: overlap,
                points: 1,
                ..ContactRow::default()
            };
            row.set_force(&-*force_on_b, &normal);
            rows.push(row);
        }
    }

    /// Contacts of a chunk whose first slot is `first`.
    fn push_chunk(&self, first: usize, chunk: &ContactChunk, rows: &mut Vec<ContactRow>) {
        let table = &self.contacts;
        for group in chunk.contacts.chunk_by(|a, b| a.slot == b.slot) {
            let index = first + group[0].slot as usize;
            if table.wrenches[index].points > 0 {
                rows.push(self.row(&table.slots[index], &table.wrenches[index], &Geometry::of_points(group)));
            }
        }
        for contact in &chunk.overlaps.contacts {
            let index = first + contact.slot as usize;
            let from = contact.first_point as usize;
            let points = &chunk.overlaps.points[from..from + contact.points[0] as usize];
            if table.wrenches[index].points > 0 {
                let geometry = Geometry::of_overlap(contact, points);
                rows.push(self.row(&table.slots[index], &table.wrenches[index], &geometry));
            }
        }
    }

    fn row(&self, slot: &Slot, wrench: &Wrench, geometry: &Geometry) -> ContactRow {
        let particles = &self.particles;
        let owner_a = particles.owner(slot.a as usize);
        let mut row = ContactRow {
            id_a: particles.ids[owner_a],
            parts: [slot.part_a.into(), slot.part_b.into()],
            point_m: (particles.position[owner_a] + geometry.arm).into(),
            overlap_m: geometry.overlap,
            moment_n_m: (wrench.torque_a - geometry.arm.cross(&wrench.force)).into(),
            kind: geometry.kind,
            points: wrench.points,
            ..ContactRow::default()
        };
        if slot.kind.is_wall() {
            let side = WallSide::of(&self.boundaries, slot.b);
            row.boundary = Some(side.index as u32);
            row.parts[1] = side.element.map_or(0, |(_, element)| element);
        } else {
            row.id_b = Some(particles.ids[particles.owner(slot.b as usize)]);
        }
        row.set_force(&wrench.force, &geometry.normal);
        row
    }
}

/// Where a pair of parts touches, seen from the centre of `a`, world axes.
struct Geometry {
    arm: Vec3,
    normal: Vec3,
    overlap: f64,
    kind: ContactKind,
}

impl Geometry {
    fn of_points(points: &[Contact]) -> Self {
        let kind = match points {
            [one] => match one.feature.kind() {
                0 => ContactKind::Smooth,
                3 => ContactKind::EdgeEdge,
                _ => ContactKind::VertexFace,
            },
            _ => ContactKind::Manifold,
        };
        let weighted = points.iter().map(|point| (point.weight * point.overlap.max(0.0), &point.arm, &point.normal));
        let (arm, normal) = mean(weighted);
        let overlap = points.iter().map(|point| point.overlap).fold(f64::NEG_INFINITY, f64::max);
        Self { arm, normal, overlap, kind }
    }

    fn of_overlap(contact: &OverlapContact, points: &[OverlapPoint]) -> Self {
        let (arm, of_points) = mean(points.iter().map(|point| (point.share, &point.position, &point.normal)));
        let normal = contact.force.try_normalize(0.0).unwrap_or(of_points);
        Self { arm, normal, overlap: contact.overlap, kind: ContactKind::Overlap }
    }
}

/// Mean of the points and unit vector along the mean of the normals; all weigh the same where the weights add up to 0.
fn mean<'a>(points: impl Iterator<Item = (f64, &'a Vec3, &'a Vec3)> + Clone) -> (Vec3, Vec3) {
    let total: f64 = points.clone().map(|(weight, ..)| weight).sum();
    let weight = |weight: f64| if total > 0.0 { weight } else { 1.0 };
    let (mut sum, mut arm, mut normal) = (0.0, Vec3::zeros(), Vec3::zeros());
    let mut any = Vec3::z();
    for (given, at, along) in points {
        sum += weight(given);
        arm += at * weight(given);
        normal += along * weight(given);
        any = *along;
    }
    // normals that cancel have no mean: any one of them will do
    (arm / sum, normal.try_normalize(1e-12 * sum).unwrap_or(any))
}
