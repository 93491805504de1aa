//! Boundaries that move by the force on them.

use crate::boundary::WallSide;
use crate::engine::Engine;
use crate::math::Vec3;

/// What orders the contributions to a sum: boundary, particle, part, element.
type Key = (usize, u64, u16, u32);

impl Engine {
    /// Gives each servo its velocity for the step, from the forces at its start, and moves it.
    pub(crate) fn drive_servos(&mut self) {
        if !self.boundaries.iter().any(|boundary| boundary.is_servo()) {
            return;
        }
        let forces = self.forces_on_servos();
        let time_s = self.clock.time_step_s();
        for (boundary, force) in self.boundaries.iter_mut().zip(&forces) {
            self.ledger.work_boundaries += boundary.drive(force, time_s);
        }
    }

    /// By boundary; summed in the order of ids, as rows are sorted anew at every rebuild.
    fn forces_on_servos(&self) -> Vec<Vec3> {
        let table = &self.contacts;
        let mut contributions: Vec<(Key, Vec3)> = table
            .slots
            .iter()
            .zip(&table.wrenches)
            .filter(|(slot, wrench)| slot.kind.is_wall() && wrench.points > 0)
            .map(|(slot, wrench)| (slot, WallSide::of(&self.boundaries, slot.b), wrench))
            .filter(|(_, side, _)| side.boundary.is_servo())
            .map(|(slot, side, wrench)| {
                let id = self.particles.ids[self.particles.owner(slot.a as usize)];
                ((side.index, id, slot.part_a, slot.b), -wrench.force)
            })
            .collect();
        contributions.sort_unstable_by_key(|(key, _)| *key);
        let mut forces = vec![Vec3::zeros(); self.boundaries.len()];
        contributions.iter().for_each(|((boundary, ..), force)| forces[*boundary] += force);
        forces
    }
}
