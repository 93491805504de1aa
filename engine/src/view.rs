//! What the outside may read: snapshot, report, state hash. Fields are in `fields`.

use xxhash_rust::xxh3::Xxh3;

use crate::boundary::WallSide;
use crate::contact::SpringRecord;
use crate::engine::Engine;
use crate::math::Vec3;
use crate::report::{EnergyBalance, Report};
use crate::snapshot::{BoundaryState, Snapshot};

impl Engine {
    /// Copies the state, in the order of ids, into `snapshot`, whose buffers are reused; forces and torques are left out.
    pub fn snapshot(&self, snapshot: &mut Snapshot) {
        let particles = &self.particles;
        let rows = particles.rows_by_id();
        snapshot.step = self.clock.step();
        snapshot.time_s = self.clock.time_s();
        snapshot.topology_epoch = self.topology_epoch;
        snapshot.gravity_m_per_s2 = self.gravity.into();
        let rows = || rows.iter().map(|&row| row as usize);
        fill(&mut snapshot.ids, rows().map(|row| particles.ids[row]));
        fill(&mut snapshot.shapes, rows().map(|row| particles.shape[row]));
        fill(&mut snapshot.materials, rows().map(|row| particles.material[row]));
        fill(&mut snapshot.scales, rows().map(|row| particles.scale[row]));
        fill(&mut snapshot.positions, rows().map(|row| particles.position[row].into()));
        fill(
            &mut snapshot.orientations,
            rows().map(|row| {
                let q = &particles.orientation[row];
                [q.w, q.i, q.j, q.k]
            }),
        );
        fill(&mut snapshot.velocities, rows().map(|row| particles.velocity[row].into()));
        fill(&mut snapshot.angular_velocities, rows().map(|row| particles.angular_velocity(row).into()));
        let any_frozen = !particles.frozen.is_empty();
        fill(&mut snapshot.frozen, rows().filter(|_| any_frozen).map(|row| u32::from(particles.frozen[row])));
        snapshot.forces.clear();
        snapshot.torques.clear();
        snapshot.boundaries = self.boundary_states();
    }

    /// Adds forces and torques to a snapshot of the same state.
    pub fn snapshot_forces(&self, snapshot: &mut Snapshot) {
        let particles = &self.particles;
        let rows = particles.rows_by_id();
        let rows = || rows.iter().map(|&row| row as usize);
        fill(&mut snapshot.forces, rows().map(|row| particles.force[row].into()));
        fill(&mut snapshot.torques, rows().map(|row| particles.torque[row].into()));
    }

    fn boundary_states(&self) -> Vec<BoundaryState> {
        let mut states: Vec<BoundaryState> = self
            .boundaries
            .iter()
            .map(|boundary| BoundaryState {
                name: boundary.name.clone(),
                point_m: boundary.point.into(),
                direction: boundary.direction().into(),
                angle_rad: boundary.angle,
                angular_velocity_rad_per_s: boundary.angular_velocity.norm(),
                force_n: [0.0; 3],
                torque_n_m: [0.0; 3],
                orientation_wxyz: boundary.orientation_wxyz(),
            })
            .collect();
        for (slot, wrench) in self.touching_walls() {
            let state = &mut states[slot.1];
            let centre = self.particles.position[slot.0] - self.boundaries[slot.1].point;
            let force = Vec3::from(state.force_n) - wrench.force;
            let torque = Vec3::from(state.torque_n_m) - wrench.torque_a - centre.cross(&wrench.force);
            (state.force_n, state.torque_n_m) = (force.into(), torque.into());
        }
        states
    }

    /// (row, boundary) and wrench of every wall slot that touches.
    fn touching_walls(&self) -> impl Iterator<Item = ((usize, usize), &crate::contact::Wrench)> {
        let table = &self.contacts;
        table
            .slots
            .iter()
            .zip(&table.wrenches)
            .filter(|(slot, wrench)| slot.kind.is_wall() && wrench.points > 0)
            .map(|(slot, wrench)| ((slot.a as usize, WallSide::of(&self.boundaries, slot.b).index), wrench))
    }

    /// How good the run is.
    pub fn report(&self) -> Report {
        let particles = &self.particles;
        let (touching_pairs, touching_boundary_pairs) = self.count_touching();
        let free = (0..particles.n_owned()).filter(|&row| !particles.is_frozen(row));
        let momentum: Vec3 = free.map(|row| particles.velocity[row] * particles.mass[row]).sum();
        let from_walls: Vec3 = self.touching_walls().map(|(_, wrench)| wrench.force).sum();
        let total: Vec3 = particles.force.iter().sum();
        let bounds = self.scene.contact_bounds(&self.present());
        Report {
            step: self.clock.step(),
            time_s: self.clock.time_s(),
            particles: particles.n_owned() as u64,
            touching_pairs,
            touching_boundary_pairs,
            contact_points: self.sums.points_by_kind.iter().sum(),
            contact_points_by_kind: self.sums.points_by_kind,
            neighbour_rebuilds: self.neighbours.rebuilds,
            energy: self.energy_balance(),
            momentum_kg_m_per_s: momentum.into(),
            internal_force_residual_n: (total - from_walls - self.local_damping.force).norm(),
            largest_overlap_m: self.sums.largest_overlap,
            largest_overlap_ratio: self.sums.largest_ratio,
            largest_overlap_over_rounding: self.sums.largest_rounding,
            largest_overlap_ratio_so_far: self.largest_ratio_so_far,
            time_step_s: self.clock.time_step_s(),
            critical_time_step_s: bounds.map_or(f64::INFINITY, |b| b.critical_time_step_s),
            present_critical_time_step_s: self.present_critical_step(),
            contact_duration_s: bounds.map_or(f64::INFINITY, |b| b.duration_s),
            warnings: self.warnings,
        }
    }

    fn energy_balance(&self) -> EnergyBalance {
        let stored = self.mechanical_energy();
        let ledger = &self.ledger;
        EnergyBalance {
            kinetic_translation_j: stored.translation,
            kinetic_rotation_j: stored.rotation,
            potential_j: stored.potential,
            elastic_j: stored.elastic,
            dissipated_normal_j: ledger.dissipated_normal,
            dissipated_friction_j: ledger.dissipated_friction,
            dissipated_local_j: ledger.dissipated_local,
            work_boundaries_j: ledger.work_boundaries,
            work_commands_j: ledger.work_commands,
            work_loads_j: ledger.work_loads,
            residual_j: stored.total()
                + ledger.dissipated_normal
                + ledger.dissipated_friction
                + ledger.dissipated_local
                - ledger.work_boundaries
                - ledger.work_commands
                - ledger.work_loads
                - ledger.initial,
        }
    }

    /// Pairs of particles, and of a particle and a boundary, that touch in at least one part.
    fn count_touching(&self) -> (u64, u64) {
        let (mut pairs, mut walls) = (self.contacts.spheres.touching(), 0);
        let mut last = None;
        for (slot, wrench) in self.contacts.slots.iter().zip(&self.contacts.wrenches) {
            // Slots of the same two bodies follow each other.
            let is_wall = slot.kind.is_wall();
            let b = if is_wall { WallSide::of(&self.boundaries, slot.b).index } else { slot.b as usize };
            let key = (slot.kind, slot.a, b);
            if wrench.points == 0 || last == Some(key) {
                continue;
            }
            last = Some(key);
            if is_wall {
                walls += 1;
            } else {
                pairs += 1;
            }
        }
        (pairs, walls)
    }

    /// Hash of everything that decides the future, in the order of ids: equal on any number of threads, whoever
    /// listens, and whenever the caches were dropped.
    pub fn state_hash(&self) -> u64 {
        self.hash_with(&self.contacts.springs(&self.particles))
    }

    /// The same with the springs at hand, sorted by key.
    pub(crate) fn hash_with(&self, springs: &[SpringRecord]) -> u64 {
        let particles = &self.particles;
        let mut hash = Xxh3::new();
        let mut words = |values: &[f64]| values.iter().for_each(|v| hash.update(&v.to_bits().to_le_bytes()));
        words(&[self.clock.time_s(), self.clock.step() as f64, self.next_id as f64]);
        words(self.gravity.as_slice());
        for row in particles.rows_by_id() {
            let row = row as usize;
            let image = particles.image[row].map(f64::from);
            let kind = [particles.shape[row] as f64, particles.material[row] as f64, particles.scale[row]];
            words(&[particles.ids[row] as f64]);
            words(&kind);
            words(particles.position[row].as_slice());
            words(particles.velocity[row].as_slice());
            words(particles.orientation[row].coords.as_slice());
            words(particles.angular_momentum[row].as_slice());
            words(&image);
            if particles.is_frozen(row) {
                words(&[1.0]);
            }
        }
        for boundary in &self.boundaries {
            words(&boundary.state_words());
        }
        if let Some(run) = &self.stages {
            words(&run.words());
        }
        self.inflows.iter().for_each(|run| words(&run.words()));
        if let Some(loads) = &self.loads {
            loads.words(&mut words);
        }
        if let Some(fluid) = &self.fluid {
            fluid.words(&mut words);
        }
        for record in springs {
            let (a, b, part_a, part_b, feature) = record.key;
            words(&[a as f64, b as f64, f64::from(part_a), f64::from(part_b), f64::from(feature.0)]);
            words(record.spring.as_slice());
        }
        hash.digest()
    }
}

fn fill<T>(column: &mut Vec<T>, values: impl Iterator<Item = T>) {
    column.clear();
    column.extend(values);
}
