//! Pairs of spheres that touch now, for checkpoints.

use super::super::saved::SavedSphere;
use super::{Side, SpherePairs};
use crate::particles::Particles;

impl SpherePairs {
    /// Pairs that touch, sorted by ids.
    pub(crate) fn saved(&self, particles: &Particles) -> Vec<SavedSphere> {
        let all = self.pairs.iter().zip(&self.on_b).zip(&self.touching);
        let mut saved: Vec<SavedSphere> = all
            .filter(|(_, touching)| **touching)
            .map(|((pair, on_b), _)| SavedSphere { ids: pair.ids(particles), force: on_b.force, torque: on_b.torque })
            .collect();
        saved.sort_unstable_by_key(|pair| pair.ids);
        saved
    }

    /// Tells the pairs of a new list that they touch, and how hard; whether each of `saved` (sorted by ids) was found.
    pub(crate) fn restore_touching(&mut self, saved: &[SavedSphere], particles: &Particles) -> bool {
        let mut found = 0;
        for (index, pair) in self.pairs.iter().enumerate() {
            if let Ok(at) = saved.binary_search_by_key(&pair.ids(particles), |pair| pair.ids) {
                self.touching[index] = true;
                self.on_b[index] = Side { force: saved[at].force, torque: saved[at].torque };
                found += 1;
            }
        }
        found == saved.len()
    }
}
