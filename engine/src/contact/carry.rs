//! What the narrow phase has learned of a pair, carried over a rebuild of the neighbour list by the ids of the pair.
//!
//! A full test of every listed pair after each rebuild cost as much as all other contact geometry of a drum of crosses.

use rayon::prelude::*;

use super::table::{CHUNK, ContactChunk, ContactTable, Slot, SlotKind, least_chunks};
use crate::narrow::PairCache;
use crate::narrow::features::FeatureList;
use crate::particles::Particles;

/// (lower id, higher id, part, part).
type PairKey = (u64, u64, u16, u16);

/// Caches outside of slots; buffers are kept.
#[derive(Clone, Debug, Default)]
pub struct CarriedCaches {
    /// Sorted by key; then where the cache is.
    keys: Vec<(PairKey, u32)>,
    caches: Vec<PairCache>,
    /// The same for lists of features.
    list_keys: Vec<(PairKey, u32)>,
    lists: Vec<FeatureList>,
}

fn key(slot: &Slot, particles: &Particles) -> PairKey {
    let b = particles.ids[particles.owner(slot.b as usize)];
    (particles.ids[particles.owner(slot.a as usize)], b, slot.part_a, slot.part_b)
}

impl ContactTable {
    /// Takes the caches out of the slots, before rows and slots change.
    pub fn take_caches(&mut self, particles: &Particles) {
        let CarriedCaches { keys, caches, list_keys, lists } = &mut self.carried;
        keys.clear();
        caches.clear();
        list_keys.clear();
        lists.clear();
        for (slots, chunk) in self.slots.chunks(CHUNK).zip(&mut self.chunks) {
            for (slot, list) in slots.iter().zip(&mut chunk.features.lists) {
                if slot.kind == SlotKind::Features && list.knows_something() {
                    list_keys.push((key(slot, particles), lists.len() as u32));
                    lists.push(std::mem::take(list));
                }
            }
            for (slot, cache) in slots.iter().zip(&chunk.caches) {
                if slot.kind == SlotKind::Parts && cache.knows_something() {
                    keys.push((key(slot, particles), caches.len() as u32));
                    caches.push(*cache);
                }
            }
        }
        keys.par_sort_unstable();
        list_keys.sort_unstable();
    }

    /// Gives the new slots what was known of their pair. A cache is valid wherever the pair has moved to meanwhile: it
    /// compares poses itself.
    pub fn give_caches(&mut self, particles: &Particles) {
        let CarriedCaches { keys, caches, list_keys, lists } = &mut self.carried;
        if keys.is_empty() && list_keys.is_empty() {
            return;
        }
        let give = |(slots, chunk): (&[Slot], &mut ContactChunk)| {
            for (slot, cache) in slots.iter().zip(&mut chunk.caches).filter(|(slot, _)| slot.kind == SlotKind::Parts) {
                if let Ok(at) = keys.binary_search_by_key(&key(slot, particles), |(key, _)| *key) {
                    *cache = caches[keys[at].1 as usize];
                }
            }
        };
        (self.slots.par_chunks(CHUNK), &mut self.chunks)
            .into_par_iter()
            .with_min_len(least_chunks(self.slots.len(), 200))
            .for_each(give);
        let of_features = |(slot, _): &(&Slot, &mut FeatureList)| slot.kind == SlotKind::Features;
        for (slots, chunk) in self.slots.chunks(CHUNK).zip(&mut self.chunks) {
            for (slot, list) in slots.iter().zip(&mut chunk.features.lists).filter(of_features) {
                if let Ok(at) = list_keys.binary_search_by_key(&key(slot, particles), |(key, _)| *key) {
                    std::mem::swap(list, &mut lists[list_keys[at].1 as usize]);
                }
            }
        }
    }
}
