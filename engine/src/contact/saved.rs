//! What touching pairs do now, outside of rows and slots: for checkpoints.

use super::history::slot_key;
use super::table::{ContactTable, Wrench};
use crate::math::Vec3;
use crate::particles::Particles;

/// A slot that touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SavedSlot {
    /// Lower id; higher id or boundary.
    pub ids: [u64; 2],
    /// Of both sides.
    pub parts: [u16; 2],
    /// What it does.
    pub wrench: Wrench,
}

/// A pair of spheres that touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SavedSphere {
    /// Lower id, higher id.
    pub ids: [u64; 2],
    /// On the higher id, N.
    pub force: Vec3,
    /// On the higher id, N m.
    pub torque: Vec3,
}

impl SavedSlot {
    fn key(&self) -> ([u64; 2], [u16; 2]) {
        (self.ids, self.parts)
    }
}

impl ContactTable {
    /// Slots that touch, sorted by key.
    pub(crate) fn saved_slots(&self, particles: &Particles) -> Vec<SavedSlot> {
        let touching = self.slots.iter().zip(&self.wrenches).filter(|(_, wrench)| wrench.points > 0);
        let mut saved: Vec<SavedSlot> = touching
            .map(|(slot, wrench)| {
                let (a, b, part_a, part_b) = slot_key(slot, particles);
                SavedSlot { ids: [a, b], parts: [part_a, part_b], wrench: *wrench }
            })
            .collect();
        saved.sort_unstable_by_key(SavedSlot::key);
        saved
    }

    /// Gives the slots of a new list their wrenches; whether each of `saved` (sorted by key) has found its slot.
    pub(crate) fn restore_slots(&mut self, saved: &[SavedSlot], particles: &Particles) -> bool {
        let mut found = 0;
        for (slot, wrench) in self.slots.iter().zip(&mut self.wrenches) {
            let (a, b, part_a, part_b) = slot_key(slot, particles);
            if let Ok(at) = saved.binary_search_by_key(&([a, b], [part_a, part_b]), SavedSlot::key) {
                *wrench = saved[at].wrench;
                found += 1;
            }
        }
        found == saved.len()
    }
}
