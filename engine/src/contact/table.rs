//! The table of slots (pairs of parts that may touch until the next rebuild), their contacts, wrenches and sums.

use super::body_sharing::BodyPoints;
use super::carry::CarriedCaches;
use super::features::FeatureChunk;
use super::law::RollingSpring;
use super::overlap::OverlapChunk;
use super::rods::RodChunk;
use super::spheres::SpherePairs;
use crate::math::Vec3;
use crate::narrow::{FeatureKey, Manifold, PairCache};
use crate::parallel::worthwhile;

/// Slots per task; never a function of the thread count, so that sums per chunk are the same on any number.
pub const CHUNK: usize = 256;

/// Fewest chunks for rayon to split off a table of `slots` slots.
pub(super) fn least_chunks(slots: usize, ns_each: usize) -> usize {
    if worthwhile(slots, ns_each) { 1 } else { slots.div_ceil(CHUNK).max(1) }
}

/// What a slot pairs; slots of one kind are contiguous. Two spheres have no slot: see [`SpherePairs`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SlotKind {
    /// Two spherocylinders or spheres, each alone and about its centre, that the sphere pass does not take.
    Rods,
    /// Two convex parts that are neither of the above.
    Parts,
    /// Two rounded polyhedra, by generalized overlap.
    RoundedParts,
    /// Two parts, at least one of them a rounded polyhedron, by their pairs of features.
    Features,
    /// A convex part and a boundary.
    Wall,
    /// A rounded polyhedron and a boundary, by generalized overlap.
    RoundedWall,
}

impl SlotKind {
    /// Whether side b is a boundary.
    #[inline(always)]
    pub fn is_wall(self) -> bool {
        matches!(self, Self::Wall | Self::RoundedWall)
    }

    /// Whether the contact is one by generalized overlap.
    #[inline(always)]
    pub fn is_rounded(self) -> bool {
        matches!(self, Self::RoundedParts | Self::RoundedWall)
    }
}

/// A pair of parts that may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slot {
    /// Row of the particle with the lower id (or of the only one).
    pub a: u32,
    /// Row of the other particle, or index of the boundary.
    pub b: u32,
    /// Part of `a`.
    pub part_a: u16,
    /// Part of `b`; 0 for a boundary.
    pub part_b: u16,
    /// What is paired.
    pub kind: SlotKind,
}

/// One touching point. World axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Slot within the chunk.
    pub slot: u32,
    /// Features that touch.
    pub feature: FeatureKey,
    /// Part of the pair's stiffness.
    pub weight: f64,
    /// m
    pub overlap: f64,
    /// From the centre of `a` to the point, m.
    pub arm: Vec3,
    /// From `a` to `b`.
    pub normal: Vec3,
    /// Tangential spring, m.
    pub spring: Vec3,
}

/// What a slot does to its two sides.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// On `a`, N; `b` takes the negative.
    pub force: Vec3,
    /// On `a` about its centre, N m.
    pub torque_a: Vec3,
    /// On `b` about its centre, N m (not kept for boundaries).
    pub torque_b: Vec3,
    /// Touching points; 0: the rest is not read.
    pub points: u32,
}

/// Sums and maxima of a chunk, added up in the order of chunks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    /// J
    pub elastic_normal: f64,
    /// J
    pub elastic_tangential: f64,
    /// Taken by normal dashpots, W.
    pub power_normal: f64,
    /// Of tangential forces against the relative motion, W.
    pub power_tangential: f64,
    /// Energy of bonds made and broken since the last step, J.
    pub lost_bonds: f64,
    /// Done by boundaries on particles, W.
    pub power_boundaries: f64,
    /// Largest overlap, m.
    pub largest_overlap: f64,
    /// Largest overlap over the smaller bounding radius.
    pub largest_ratio: f64,
    /// Slot (in the table) of the largest ratio; numbers from the number of slots on are sphere pairs.
    pub largest_slot: u32,
    /// Largest generalized overlap over the mean rounding radius.
    pub largest_rounding: f64,
    /// Slot (in the table) of that.
    pub rounding_slot: u32,
    /// Touching points by kind: smooth (and vertex-edge, vertex-vertex), vertex-face, edge-edge.
    pub points_by_kind: [u64; 3],
}

impl Sums {
    /// The overlap of a slot of the chunk.
    #[inline(always)]
    pub fn take_overlap(&mut self, overlap: f64, smaller_radius: f64, slot: usize) {
        self.largest_overlap = self.largest_overlap.max(overlap);
        let ratio = overlap / smaller_radius;
        if ratio > self.largest_ratio {
            (self.largest_ratio, self.largest_slot) = (ratio, slot as u32);
        }
    }

    /// A touching point.
    #[inline(always)]
    pub fn count_point(&mut self, feature: FeatureKey) {
        self.points_by_kind[match feature.kind() {
            0 => 0,
            3 => 2,
            _ => 1,
        }] += 1;
    }

    /// The generalized overlap of a slot of the chunk over its mean rounding radius.
    #[inline(always)]
    pub fn take_rounding(&mut self, ratio: f64, slot: usize) {
        if ratio > self.largest_rounding {
            (self.largest_rounding, self.rounding_slot) = (ratio, slot as u32);
        }
    }

    /// Adds the next chunk.
    pub fn add(&mut self, other: &Sums) {
        self.elastic_normal += other.elastic_normal;
        self.elastic_tangential += other.elastic_tangential;
        self.power_normal += other.power_normal;
        self.power_tangential += other.power_tangential;
        self.power_boundaries += other.power_boundaries;
        self.lost_bonds += other.lost_bonds;
        self.largest_overlap = self.largest_overlap.max(other.largest_overlap);
        if other.largest_ratio > self.largest_ratio {
            self.largest_ratio = other.largest_ratio;
            self.largest_slot = other.largest_slot;
        }
        if other.largest_rounding > self.largest_rounding {
            self.largest_rounding = other.largest_rounding;
            self.rounding_slot = other.rounding_slot;
        }
        for kind in 0..3 {
            self.points_by_kind[kind] += other.points_by_kind[kind];
        }
    }
}

/// Contacts of [`CHUNK`] slots, this step's and the last one's, and scratch.
#[derive(Clone, Debug, Default)]
pub struct ContactChunk {
    /// In the order of slots.
    pub contacts: Vec<Contact>,
    /// Of the step before; only slot, feature and spring are read.
    pub previous: Vec<Contact>,
    /// By generalized overlap.
    pub overlaps: OverlapChunk,
    /// Rolling and twisting springs by slot, where the scene has such a law; else empty.
    pub rolling: Vec<RollingSpring>,
    /// By pairs of features.
    pub features: FeatureChunk,
    /// Of rods.
    pub rods: RodChunk,
    /// Energy of bonds made and broken in this step, J.
    pub lost_bonds: f64,
    /// Sums of this step.
    pub sums: Sums,
    /// By slot, where there are pairs of parts: may only skip work whose answer it proves.
    pub caches: Vec<PairCache>,
    /// Scratch.
    pub manifold: Manifold,
}

/// All slots.
#[derive(Clone, Debug, Default)]
pub struct ContactTable {
    /// Pairs of spheres, which have no slots.
    pub spheres: SpherePairs,
    /// Grouped by kind.
    pub slots: Vec<Slot>,
    /// Result of each slot.
    pub wrenches: Vec<Wrench>,
    /// Contacts, [`CHUNK`] slots each.
    pub chunks: Vec<ContactChunk>,
    /// Contacts may hold beyond the touch: that there was one is kept like a spring.
    pub keeps_bonds: bool,
    /// Scratch of sharing over bodies.
    pub body_points: Vec<BodyPoints>,
    /// Scratch of a rebuild.
    pub carried: CarriedCaches,
}

impl ContactTable {
    /// Forgets all pairs, as before a change of the particles.
    pub fn clear(&mut self) {
        self.spheres.clear();
        self.slots.clear();
        self.reset();
    }

    /// Makes room for new `slots`; contacts and wrenches are emptied, buffers kept.
    pub fn reset(&mut self) {
        let n = self.slots.len();
        self.wrenches.clear();
        self.wrenches.resize(n, Wrench::default());
        self.chunks.resize_with(n.div_ceil(CHUNK), ContactChunk::default);
        for (slots, chunk) in self.slots.chunks(CHUNK).zip(&mut self.chunks) {
            let up_to = |kind: SlotKind| slots.iter().rposition(|slot| slot.kind == kind).map_or(0, |last| last + 1);
            chunk.contacts.clear();
            chunk.previous.clear();
            chunk.rolling.clear();
            chunk.sums = Sums::default();
            chunk.caches.clear();
            chunk.caches.resize(up_to(SlotKind::Parts), PairCache::default());
            chunk.overlaps.reset(up_to(SlotKind::RoundedParts));
            chunk.features.reset(up_to(SlotKind::Features));
            chunk.rods.reset(up_to(SlotKind::Rods));
        }
    }

    /// Forgets what the narrow phase has learned.
    pub fn drop_caches(&mut self) {
        for chunk in &mut self.chunks {
            chunk.caches.fill(PairCache::default());
            chunk.overlaps.forget();
            chunk.features.forget();
            chunk.rods.forget();
        }
    }

    /// Contacts with the index of their slot in the table, in order.
    pub fn contacts(&self) -> impl Iterator<Item = (usize, &Contact)> {
        self.chunks.iter().enumerate().flat_map(|(k, chunk)| {
            chunk.contacts.iter().map(move |contact| (k * CHUNK + contact.slot as usize, contact))
        })
    }

    /// Sums over all chunks, in order.
    pub fn sums(&self) -> Sums {
        let mut sums = Sums::default();
        self.chunks.iter().for_each(|chunk| sums.add(&chunk.sums));
        let mut of_spheres = Sums::default();
        self.spheres.sums().iter().for_each(|chunk| of_spheres.add(chunk));
        of_spheres.largest_slot += self.slots.len() as u32;
        sums.add(&of_spheres);
        sums
    }
}
