//! Pairs of spheres in one pass: geometry, spring and force from the columns, without slots, contact lists and features.
//!
//! Pairs are sorted by (row of the side with the lower id, id of the other), a row's pairs in one chunk. So side a is
//! read once and summed where it stands, and each side's sum runs in the order of partners' ids: first the pairs in which
//! the row is a, then those in which it is b. A pair keeps its spring in place until the next rebuild, which finds it
//! again in the list of the same particle. Many listed pairs of a bed do not touch: a first pass over a block picks those
//! that do without a branch, which could not be predicted.

mod saved;

use super::evaluate::ForceInputs;
use super::law::PairTable;
use super::sphere_batch::Stretch;
use super::table::Sums;
use crate::math::Vec3;
use crate::parallel::worthwhile;
use crate::particles::Particles;

/// Rows per task; never a function of the thread count.
pub(super) const ROWS: usize = 256;
/// Cost of a listed pair, ns, on average over a bed.
const NS_PER_PAIR: usize = 20;

/// Two spheres that may touch, `a` having the lower id; either may be a ghost, not both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpherePair {
    /// Row of the lower id.
    pub a: u32,
    /// Row of the higher id.
    pub b: u32,
    /// Normal dashpot coefficient, N s/m: a function of masses and materials, which only change with the list.
    pub(super) damping: f64,
}

impl SpherePair {
    /// Ids of both sides.
    pub fn ids(&self, particles: &Particles) -> [u64; 2] {
        [self.a, self.b].map(|row| particles.ids[particles.owner(row as usize)])
    }

    fn id_b(&self, particles: &Particles) -> u64 {
        self.ids(particles)[1]
    }
}

/// Force and torque of one side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Side {
    pub force: Vec3,
    pub torque: Vec3,
}

/// All pairs of spheres.
#[derive(Clone, Debug, Default)]
pub struct SpherePairs {
    /// Sorted by (row that owns side a, id of the other).
    pairs: Vec<SpherePair>,
    /// By pair: tangential spring, m; 0 where nothing touches.
    springs: Vec<Vec3>,
    /// By pair: on side b (0 where nothing touches).
    on_b: Vec<Side>,
    /// By pair.
    touching: Vec<bool>,
    /// By row: sum over the pairs in which it is side a.
    on_a: Vec<Side>,
    /// By row: its pairs as side a (n + 1).
    starts: Vec<u32>,
    /// By row: its entries in `as_b` (n + 1).
    starts_b: Vec<u32>,
    /// Pairs in which a row is side b, in the order of the partners' ids.
    as_b: Vec<u32>,
    /// By chunk of rows.
    sums: Vec<Sums>,
    old: OldPairs,
    next: Vec<u32>,
}

/// What the list before the rebuild knew; and the ids that keep it findable.
#[derive(Clone, Debug, Default)]
struct OldPairs {
    starts: Vec<u32>,
    /// By pair: id of side b.
    ids: Vec<u64>,
    springs: Vec<Vec3>,
}

impl SpherePairs {
    /// Listed pairs.
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// A listed pair.
    pub fn pair(&self, index: usize) -> &SpherePair {
        &self.pairs[index]
    }

    /// Pairs that touch.
    pub fn touching(&self) -> u64 {
        self.touching.iter().filter(|touching| **touching).count() as u64
    }

    /// Those pairs.
    pub fn touching_pairs(&self) -> impl Iterator<Item = &SpherePair> {
        self.pairs.iter().zip(&self.touching).filter(|(_, touching)| **touching).map(|(pair, _)| pair)
    }

    /// Those pairs, and the force on side b, N.
    pub fn touching_forces(&self) -> impl Iterator<Item = (&SpherePair, &Vec3)> {
        let all = self.pairs.iter().zip(&self.on_b).zip(&self.touching);
        all.filter(|(_, touching)| **touching).map(|((pair, on_b), _)| (pair, &on_b.force))
    }

    /// Pairs with a spring, and the springs.
    pub fn springs(&self) -> impl Iterator<Item = (&SpherePair, &Vec3)> {
        self.pairs.iter().zip(&self.springs).filter(|(_, spring)| **spring != Vec3::zeros())
    }

    /// Sums of the chunks, in order.
    pub fn sums(&self) -> &[Sums] {
        &self.sums
    }

    /// Sum over the pairs of an owned row.
    #[inline]
    pub fn sum_of_row(&self, row: usize) -> (Vec3, Vec3) {
        let Some(Side { mut force, mut torque }) = self.on_a.get(row).copied() else {
            return (Vec3::zeros(), Vec3::zeros());
        };
        for &index in &self.as_b[self.starts_b[row] as usize..self.starts_b[row + 1] as usize] {
            let side = &self.on_b[index as usize];
            force += side.force;
            torque += side.torque;
        }
        (force, torque)
    }

    /// Forgets all pairs.
    pub fn clear(&mut self) {
        self.pairs.clear();
        self.springs.clear();
        self.on_b.clear();
        self.touching.clear();
        self.on_a.clear();
        self.starts.clear();
        self.starts_b.clear();
        self.as_b.clear();
        self.sums.clear();
    }

    /// Puts aside what the next list takes over, before the rows change.
    pub fn keep(&mut self, particles: &Particles) {
        self.old.ids.clear();
        self.old.ids.extend(self.pairs.iter().map(|pair| pair.id_b(particles)));
        std::mem::swap(&mut self.old.springs, &mut self.springs);
        std::mem::swap(&mut self.old.starts, &mut self.starts);
        self.clear();
    }

    /// Takes the pairs of a new list, as (row of the lower id, row of the other), and the springs of the old one. Row k
    /// was row `order[k]` when they were put aside.
    pub fn rebuild<'a>(
        &mut self,
        found: impl Iterator<Item = &'a [[u32; 2]]> + Clone,
        particles: &Particles,
        laws: &PairTable,
        order: &[u32],
    ) {
        if found.clone().all(<[_]>::is_empty) {
            return;
        }
        let n = particles.n_owned();
        let pairs = || found.clone().flatten().map(|&[a, b]| (particles.owner(a as usize), a, b));
        count_starts(&mut self.starts, n, pairs().map(|(owner, ..)| owner));
        let total = self.starts[n] as usize;
        self.pairs.resize(total, SpherePair::default());
        self.next.clone_from(&self.starts);
        for (owner_a, a, b) in pairs() {
            let owner_b = particles.owner(b as usize);
            let (material_a, material_b) = (particles.material[owner_a], particles.material[owner_b]);
            let at = &mut self.next[owner_a];
            self.pairs[*at as usize] = SpherePair {
                a,
                b,
                damping: laws.law(material_a, material_b).damping(particles.reduced_mass(owner_a, owner_b)),
            };
            *at += 1;
        }
        for row in 0..n {
            self.pairs[self.starts[row] as usize..self.starts[row + 1] as usize]
                .sort_unstable_by_key(|pair| (pair.id_b(particles), pair.a, pair.b));
        }
        self.springs.resize(total, Vec3::zeros());
        self.on_b.resize(total, Side::default());
        self.touching.resize(total, false);
        self.on_a.resize(n, Side::default());
        self.sums.resize(n.div_ceil(ROWS), Sums::default());
        self.link(particles);
        self.take_springs(particles, order);
    }

    /// Lists each row's pairs as side b in the order of the partners' ids.
    fn link(&mut self, particles: &Particles) {
        let n = particles.n_owned();
        count_starts(&mut self.starts_b, n, self.pairs.iter().map(|pair| particles.owner(pair.b as usize)));
        self.as_b.resize(self.pairs.len(), 0);
        self.next.clone_from(&self.starts_b);
        for (index, pair) in self.pairs.iter().enumerate() {
            let at = &mut self.next[particles.owner(pair.b as usize)];
            self.as_b[*at as usize] = index as u32;
            *at += 1;
        }
        let Self { starts_b, as_b, pairs, .. } = self;
        let key = |index: &u32| {
            let pair = &pairs[*index as usize];
            (pair.ids(particles)[0], pair.a, pair.b)
        };
        for row in 0..n {
            as_b[starts_b[row] as usize..starts_b[row + 1] as usize].sort_unstable_by_key(key);
        }
    }

    /// Finds the spring of each pair among those of the same particle. A pair with a spring has touched, so that the
    /// next step clears it should the pair have parted.
    fn take_springs(&mut self, particles: &Particles, order: &[u32]) {
        let Self { old, starts, pairs, springs, touching, .. } = self;
        if old.starts.len() != order.len() + 1 {
            return;
        }
        for (row, &was) in order.iter().enumerate() {
            let (mut at, end) = (old.starts[was as usize] as usize, old.starts[was as usize + 1] as usize);
            for index in starts[row] as usize..starts[row + 1] as usize {
                let id = pairs[index].id_b(particles);
                while at < end && old.ids[at] < id {
                    at += 1;
                }
                if at < end && old.ids[at] == id {
                    springs[index] = old.springs[at];
                    touching[index] = old.springs[at] != Vec3::zeros();
                    at += 1;
                }
            }
        }
    }

    /// Gives the pair of two ids, found by `row` of the lower one, a spring that was kept elsewhere.
    pub fn restore(&mut self, row: usize, id_b: u64, spring: Vec3, particles: &Particles) {
        if row + 1 >= self.starts.len() {
            return;
        }
        let range = self.starts[row] as usize..self.starts[row + 1] as usize;
        let found = range.clone().find(|&index| self.pairs[index].id_b(particles) == id_b);
        if let Some(index) = found {
            self.springs[index] = spring;
            self.touching[index] = true;
        }
    }

    /// Geometry, springs and forces of all pairs.
    pub(super) fn evaluate(&mut self, inputs: &ForceInputs<'_>) {
        if self.pairs.is_empty() {
            return;
        }
        let share = worthwhile(self.pairs.len(), NS_PER_PAIR);
        let Self { pairs, springs, on_b, touching, on_a, sums, starts, .. } = self;
        let stretch = Stretch { first_row: 0, pairs, springs, on_b, touching, on_a, sums };
        stretch.evaluate(starts, inputs, share);
    }
}

/// CSR starts over `n` rows from the row of each item.
fn count_starts(starts: &mut Vec<u32>, n: usize, rows: impl Iterator<Item = usize>) {
    starts.clear();
    starts.resize(n + 1, 0);
    rows.for_each(|row| starts[row + 1] += 1);
    for row in 0..n {
        starts[row + 1] += starts[row];
    }
}
