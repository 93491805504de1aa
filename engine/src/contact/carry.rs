//! What the narrow phase has learned of a pair, carried over a rebuild of the neighbour list by the ids of the pair.
//!
//! A full test of every listed pair after each rebuild cost as much as all other contact geometry of a drum of crosses.

use rayon::prelude::*;

use super::table::{CHUNK, ContactChunk, ContactTable, Slot, SlotKind, least_chunks};
use crate::narrow::PairCache;
use crate::narrow::features::FeatureList;
use crate::narrow::generalized_overlap::ActiveTerms;
use crate::particles::Particles;

/// (lower id, higher id, part, part).
type PairKey = (u64, u64, u16, u16);

/// Caches outside of slots.
#[derive(Clone, Debug, Default)]
pub struct CarriedCaches {
    separating_axes: Carried<PairCache>,
    features: Carried<FeatureList>,
    overlaps: Carried<ActiveTerms>,
    /// By slot of a chunk: where its cache is.
    found: Vec<[u32; CHUNK]>,
}

/// Caches of one kind; buffers are kept.
#[derive(Clone, Debug)]
struct Carried<T> {
    /// Sorted by key; then where the cache is.
    keys: Vec<(PairKey, u32)>,
    caches: Vec<T>,
}

impl<T> Default for Carried<T> {
    fn default() -> Self {
        Self { keys: Vec::new(), caches: Vec::new() }
    }
}

/// What a slot without a former cache finds.
const NOTHING: u32 = u32::MAX;

impl<T> Carried<T> {
    fn clear(&mut self) {
        self.keys.clear();
        self.caches.clear();
    }

    fn push(&mut self, key: PairKey, cache: T) {
        self.keys.push((key, self.caches.len() as u32));
        self.caches.push(cache);
    }

    /// Writes where the caches of the slots of one kind are; slots of one particle are neighbours, and so are their
    /// keys, which is why a search is needed once per particle only.
    fn find(&self, kind: SlotKind, slots: &[Slot], particles: &Particles, found: &mut [u32; CHUNK]) {
        if self.keys.is_empty() {
            return;
        }
        let mut of_particle: (u64, &[(PairKey, u32)]) = (u64::MAX, &[]);
        for (slot, found) in slots.iter().zip(found).filter(|(slot, _)| slot.kind == kind) {
            let key = key(slot, particles);
            if of_particle.0 != key.0 {
                let rest = &self.keys[self.keys.partition_point(|(old, _)| old.0 < key.0)..];
                let len = rest.iter().position(|(old, _)| old.0 != key.0).unwrap_or(rest.len());
                of_particle = (key.0, &rest[..len]);
            }
            if let Ok(at) = of_particle.1.binary_search_by_key(&key, |(old, _)| *old) {
                *found = of_particle.1[at].1;
            }
        }
    }
}

fn key(slot: &Slot, particles: &Particles) -> PairKey {
    let b = particles.ids[particles.owner(slot.b as usize)];
    (particles.ids[particles.owner(slot.a as usize)], b, slot.part_a, slot.part_b)
}

impl ContactTable {
    /// Takes the caches out of the slots, before rows and slots change.
    pub fn take_caches(&mut self, particles: &Particles) {
        let CarriedCaches { separating_axes, features, overlaps, .. } = &mut self.carried;
        separating_axes.clear();
        features.clear();
        overlaps.clear();
        for (slots, chunk) in self.slots.chunks(CHUNK).zip(&mut self.chunks) {
            for (k, slot) in slots.iter().enumerate() {
                match slot.kind {
                    SlotKind::Parts if chunk.caches[k].knows_something() => {
                        separating_axes.push(key(slot, particles), chunk.caches[k]);
                    }
                    SlotKind::Features if chunk.features.lists[k].knows_something() => {
                        features.push(key(slot, particles), std::mem::take(&mut chunk.features.lists[k]));
                    }
                    SlotKind::RoundedParts if chunk.overlaps.active[k].knows_something() => {
                        overlaps.push(key(slot, particles), std::mem::take(&mut chunk.overlaps.active[k]));
                    }
                    _ => {}
                }
            }
        }
        separating_axes.keys.par_sort_unstable();
        features.keys.par_sort_unstable();
        overlaps.keys.par_sort_unstable();
    }

    /// Gives the new slots what was known of their pair. A cache is valid wherever the pair has moved to meanwhile: it
    /// compares poses itself.
    pub fn give_caches(&mut self, particles: &Particles) {
        let CarriedCaches { separating_axes, features, overlaps, found } = &mut self.carried;
        if separating_axes.keys.is_empty() && features.keys.is_empty() && overlaps.keys.is_empty() {
            return;
        }
        found.clear();
        found.resize(self.chunks.len(), [NOTHING; CHUNK]);
        (self.slots.par_chunks(CHUNK), &mut *found)
            .into_par_iter()
            .with_min_len(least_chunks(self.slots.len(), 100))
            .for_each(|(slots, found)| {
                separating_axes.find(SlotKind::Parts, slots, particles, found);
                features.find(SlotKind::Features, slots, particles, found);
                overlaps.find(SlotKind::RoundedParts, slots, particles, found);
            });
        for ((slots, chunk), found) in self.slots.chunks(CHUNK).zip(&mut self.chunks).zip(&*found) {
            give_to_chunk(slots, chunk, found, (separating_axes, features, overlaps));
        }
    }
}

type AllCarried<'a> = (&'a Carried<PairCache>, &'a mut Carried<FeatureList>, &'a mut Carried<ActiveTerms>);

fn give_to_chunk(slots: &[Slot], chunk: &mut ContactChunk, found: &[u32; CHUNK], carried: AllCarried<'_>) {
    let (separating_axes, features, overlaps) = carried;
    for (k, slot) in slots.iter().enumerate().filter(|(k, _)| found[*k] != NOTHING) {
        let at = found[k] as usize;
        match slot.kind {
            SlotKind::Parts => chunk.caches[k] = separating_axes.caches[at],
            SlotKind::Features => std::mem::swap(&mut chunk.features.lists[k], &mut features.caches[at]),
            SlotKind::RoundedParts => std::mem::swap(&mut chunk.overlaps.active[k], &mut overlaps.caches[at]),
            SlotKind::Rods | SlotKind::Wall | SlotKind::RoundedWall => {}
        }
    }
}
