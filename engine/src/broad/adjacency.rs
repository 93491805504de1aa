//! Slots of each row, in the order in which its forces are added.

use crate::contact::Slot;
use crate::particles::Particles;

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

/// Per row: slots it takes part in, sorted so that sums do not depend on rows.
#[derive(Clone, Debug, Default)]
pub struct Adjacency {
    starts: Vec<u32>,
    entries: Vec<Entry>,
    next: Vec<u32>,
}

impl Adjacency {
    /// Lists each row's slots in the order of (partner's id, parts): the order in which forces are added.
    pub fn rebuild(&mut self, particles: &Particles, slots: &[Slot]) {
        let n = particles.n_owned();
        let Self { starts, entries, next } = self;
        let sides = |slot: &Slot| {
            let b = (!slot.kind.is_wall()).then(|| particles.owner(slot.b as usize));
            (particles.owner(slot.a as usize), b)
        };
        starts.clear();
        starts.resize(n + 1, 0);
        for slot in slots {
            let (a, b) = sides(slot);
            starts[a + 1] += 1;
            if let Some(b) = b {
                starts[b + 1] += 1;
            }
        }
        for row in 0..n {
            starts[row + 1] += starts[row];
        }
        next.clone_from(starts);
        entries.clear();
        entries.resize(starts[n] as usize, Entry(0));
        let mut put = |row: usize, entry: Entry| {
            entries[next[row] as usize] = entry;
            next[row] += 1;
        };
        for (index, slot) in slots.iter().enumerate() {
            let (a, b) = sides(slot);
            put(a, Entry::new(index, false));
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
            entries[starts[row] as usize..starts[row + 1] as usize].sort_unstable_by_key(key);
        }
    }

    /// Slots of a row.
    #[inline]
    pub fn of_row(&self, row: usize) -> &[Entry] {
        &self.entries[self.starts[row] as usize..self.starts[row + 1] as usize]
    }
}
