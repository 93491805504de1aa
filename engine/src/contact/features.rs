//! Contacts of rounded polyhedra, one per pair of features that touch.

use super::find::{FindInputs, quiet_until};
use super::table::{Contact, Slot};
use crate::math::Vec3;
use crate::narrow::features::{FeatureList, FeaturePair, FeatureScratch};

/// What the slots of rounded polyhedra need in one chunk.
#[derive(Clone, Debug, Default)]
pub struct FeatureChunk {
    /// By slot; empty where the chunk has no pair of rounded polyhedra.
    pub lists: Vec<FeatureList>,
    /// By slot: while the odometers of its particles add up to less, nothing touches.
    quiet_until: Vec<f64>,
    /// Deepest overlap over the mean rounding radius, and its slot.
    pub deepest: (f64, u32),
    scratch: FeatureScratch,
}

impl FeatureChunk {
    /// Empties it for new slots; `slots` is the number of lists needed.
    pub fn reset(&mut self, slots: usize) {
        self.lists.resize_with(slots, FeatureList::default);
        self.quiet_until.resize(slots, 0.0);
        self.deepest = (0.0, 0);
        self.forget();
    }

    /// Makes every list be made anew.
    pub fn forget(&mut self) {
        self.lists.iter_mut().for_each(FeatureList::forget);
        self.quiet_until.fill(f64::NEG_INFINITY);
    }

    /// Appends the contacts of two rounded polyhedra; each carries the whole stiffness of its pair of materials.
    #[inline]
    pub fn find_pair(&mut self, index: u32, slot: &Slot, inputs: &FindInputs<'_>, contacts: &mut Vec<Contact>) {
        let particles = inputs.particles;
        let (a, b) = (slot.a as usize, slot.b as usize);
        let travelled = particles.odometer[a] + particles.odometer[b];
        if travelled < self.quiet_until[index as usize] {
            return;
        }
        let d = particles.separation(a, b);
        let (a_from_b, unit) = particles.a_from_b(a, b, &d);
        let skeleton = |row: usize, part: u16| {
            let part = &inputs.shapes[particles.shape[row] as usize].parts()[part as usize];
            part.skeleton.as_deref().expect("validation refuses shapes without")
        };
        let pair = FeaturePair { a: skeleton(a, slot.part_a), b: skeleton(b, slot.part_b), b_to_a: &a_from_b };
        let list = &mut self.lists[index as usize];
        let gap = list.update(&pair, &mut self.scratch) * unit;
        if gap > 0.0 {
            self.quiet_until[index as usize] = quiet_until(travelled, gap, particles.radius[a] + particles.radius[b]);
            return;
        }
        let rotation_a = &particles.rotation[a];
        let mut deepest = 0.0f64;
        // a loop, not an iterator of tuples: copying those cost a fifth of the search
        for &feature in list.features() {
            let Some(contact) = pair.contact(feature) else { continue };
            deepest = deepest.max(contact.overlap);
            contacts.push(Contact {
                slot: index,
                feature,
                weight: 1.0,
                overlap: contact.overlap * unit,
                arm: rotation_a * (contact.position * unit),
                normal: rotation_a * contact.normal,
                spring: Vec3::zeros(),
            });
        }
        let ratio = 2.0 * deepest / pair.radius();
        if ratio > self.deepest.0 {
            self.deepest = (ratio, index);
        }
    }
}
