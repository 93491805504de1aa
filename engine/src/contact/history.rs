//! Tangential springs outside of rows and slots, keyed by ids: what survives a rebuild, and what is hashed.

use rayon::prelude::*;

use super::law::RollingSpring;
use super::table::{CHUNK, Contact, ContactChunk, ContactTable, Slot, least_chunks};
use crate::math::Vec3;
use crate::narrow::FeatureKey;
use crate::particles::Particles;

/// Key of a boundary among ids: above every particle.
const BOUNDARY: u64 = 1 << 63;

/// One spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringRecord {
    /// (lower id, higher id or boundary, part, part, feature).
    pub key: (u64, u64, u16, u16, FeatureKey),
    /// m
    pub spring: Vec3,
}

/// Features under which the two springs of a contact by generalized overlap are kept: a vector, and an arc in x.
const SLIDE: FeatureKey = FeatureKey::point(0);
const TWIST: FeatureKey = FeatureKey::point(1);

/// (lower id, higher id or boundary, part, part).
pub(super) type SlotKey = (u64, u64, u16, u16);

impl SpringRecord {
    fn slot_key(&self) -> SlotKey {
        (self.key.0, self.key.1, self.key.2, self.key.3)
    }
}
/// Those of the rolling and the twisting spring of a slot, in rad; no point contact has as many points.
const ROLL: FeatureKey = FeatureKey::point((1 << 30) - 2);
const SPIN: FeatureKey = FeatureKey::point((1 << 30) - 1);

/// Key of a slot, without the feature.
pub(super) fn slot_key(slot: &Slot, particles: &Particles) -> SlotKey {
    let b = match slot.kind {
        kind if kind.is_wall() => BOUNDARY | u64::from(slot.b),
        _ => particles.ids[particles.owner(slot.b as usize)],
    };
    (particles.ids[particles.owner(slot.a as usize)], b, slot.part_a, slot.part_b)
}

impl ContactTable {
    /// All springs, sorted by key.
    pub fn springs(&self, particles: &Particles) -> Vec<SpringRecord> {
        let mut records = self.slot_springs(particles);
        records.extend(self.spheres.springs().map(|(pair, spring)| {
            let [a, b] = pair.ids(particles);
            SpringRecord { key: (a, b, 0, 0, FeatureKey::point(0)), spring: *spring }
        }));
        records.sort_unstable_by_key(|record| record.key);
        records
    }

    /// Springs of all slots, sorted by key: sphere pairs carry theirs over a rebuild themselves.
    pub fn slot_springs(&self, particles: &Particles) -> Vec<SpringRecord> {
        let mut records: Vec<SpringRecord> = self
            .contacts()
            .filter(|(_, contact)| self.keeps_bonds || contact.spring != Vec3::zeros())
            .map(|(slot, contact)| {
                let (a, b, part_a, part_b) = slot_key(&self.slots[slot], particles);
                SpringRecord { key: (a, b, part_a, part_b, contact.feature), spring: contact.spring }
            })
            .collect();
        self.push_overlap_springs(particles, &mut records);
        self.push_rolling_springs(particles, &mut records);
        records.par_sort_unstable_by_key(|record| record.key);
        records
    }

    fn push_overlap_springs(&self, particles: &Particles, records: &mut Vec<SpringRecord>) {
        for (k, chunk) in self.chunks.iter().enumerate() {
            for contact in &chunk.overlaps.contacts {
                let (a, b, part_a, part_b) = slot_key(&self.slots[k * CHUNK + contact.slot as usize], particles);
                let mut push = |feature: FeatureKey, spring: Vec3| {
                    if spring != Vec3::zeros() {
                        records.push(SpringRecord { key: (a, b, part_a, part_b, feature), spring });
                    }
                };
                push(SLIDE, contact.spring);
                push(TWIST, Vec3::x() * contact.twist);
            }
        }
    }

    fn push_rolling_springs(&self, particles: &Particles, records: &mut Vec<SpringRecord>) {
        for (k, chunk) in self.chunks.iter().enumerate() {
            for (slot, spring) in chunk.rolling.iter().enumerate().filter(|(_, s)| **s != RollingSpring::default()) {
                let (a, b, part_a, part_b) = slot_key(&self.slots[k * CHUNK + slot], particles);
                for (feature, spring) in [(ROLL, spring.roll), (SPIN, Vec3::x() * spring.twist)] {
                    if spring != Vec3::zeros() {
                        records.push(SpringRecord { key: (a, b, part_a, part_b, feature), spring });
                    }
                }
            }
        }
    }

    /// Gives new slots the springs of the old ones (sorted by key).
    pub fn restore_springs(&mut self, records: &[SpringRecord], particles: &Particles) {
        if records.is_empty() {
            return;
        }
        let slots = self.slots.len();
        (self.slots.par_chunks(CHUNK), &mut self.chunks)
            .into_par_iter()
            .with_min_len(least_chunks(slots, 100))
            .for_each(|(slots, chunk)| restore_in_chunk(slots, chunk, records, particles));
    }

    /// Gives sphere pairs the springs among `records` that outlived a change of the particles.
    pub fn restore_sphere_springs(&mut self, records: &[SpringRecord], particles: &Particles) {
        if self.spheres.is_empty() || records.is_empty() {
            return;
        }
        let rows = particles.rows_by_id();
        for record in records {
            let (a, b) = (record.key.0, record.key.1);
            if let Ok(at) = rows.binary_search_by_key(&a, |&row| particles.ids[row as usize]) {
                self.spheres.restore(rows[at] as usize, b, record.spring, particles);
            }
        }
    }
}

fn restore_in_chunk(slots: &[Slot], chunk: &mut ContactChunk, records: &[SpringRecord], particles: &Particles) {
    for (index, slot) in (0..).zip(slots) {
        let key = slot_key(slot, particles);
        let start = records.partition_point(|record| record.slot_key() < key);
        let own = records[start..].iter().take_while(|record| record.slot_key() == key);
        if slot.kind.is_rounded() {
            let (mut spring, mut twist) = (Vec3::zeros(), 0.0);
            let mut found = false;
            for record in own {
                found = true;
                if record.key.4 == SLIDE { spring = record.spring } else { twist = record.spring.x }
            }
            if found {
                chunk.overlaps.restore(index, spring, twist);
            }
            continue;
        }
        let is_turn = |record: &SpringRecord| [ROLL, SPIN].contains(&record.key.4);
        for record in own.clone().filter(|record| is_turn(record)) {
            let known = chunk.rolling.len().max(index as usize + 1);
            chunk.rolling.resize(known, RollingSpring::default());
            let of_slot = &mut chunk.rolling[index as usize];
            if record.key.4 == ROLL { of_slot.roll = record.spring } else { of_slot.twist = record.spring.x }
        }
        chunk.contacts.extend(own.filter(|record| !is_turn(record)).map(|record| Contact {
            slot: index,
            feature: record.key.4,
            weight: 0.0,
            overlap: 0.0,
            arm: Vec3::zeros(),
            normal: Vec3::zeros(),
            spring: record.spring,
        }));
    }
}
