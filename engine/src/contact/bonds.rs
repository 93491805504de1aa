//! Contacts that hold beyond the touch, under a cohesion with bonds (`jkr`): the touch makes them, and they stay while the
//! parts are no farther apart than the law allows. What a slot had in the step before is the only memory.

use super::find::{FindInputs, push_pair, push_wall};
use super::law::{Jkr, share_stiffness};
use super::table::{Contact, Slot};
use crate::boundary::WallSide;
use crate::math::Vec3;
use crate::narrow::{self, Manifold, PairCache};
use crate::scene::PointLaws;
use crate::shape::{Part, PartGeometry};

/// What a slot has found of a step.
pub(super) struct Found<'a> {
    pub contacts: &'a mut Vec<Contact>,
    pub manifold: &'a mut Manifold,
    /// Its first contact.
    pub start: usize,
}

/// Keeps the bond of a slot whose parts have come apart, and returns the energy (J) of one that was made or has broken.
pub(super) fn follow_bond(
    (index, slot): (u32, &Slot),
    had_one: bool,
    inputs: &FindInputs<'_>,
    laws: &PointLaws,
    found: &mut Found<'_>,
) -> f64 {
    let touches = found.contacts.len() > found.start;
    if had_one == touches {
        return 0.0;
    }
    let Some(bond) = bond(slot, inputs, laws) else { return 0.0 };
    if touches {
        return bond.lost_when_made();
    }
    hold(index, slot, inputs, -bond.overlap_at_breaking(), found);
    if found.contacts.len() > found.start { 0.0 } else { bond.lost_when_broken() }
}

fn bond(slot: &Slot, inputs: &FindInputs<'_>, laws: &PointLaws) -> Option<Jkr> {
    let particles = inputs.particles;
    let (a, b) = (slot.a as usize, slot.b as usize);
    let material_b = if slot.kind.is_wall() {
        WallSide::of(inputs.boundaries, slot.b).boundary.material
    } else {
        particles.material[b]
    };
    let b = (!slot.kind.is_wall()).then_some((b, slot.part_b));
    laws.extras(particles.material[a], material_b).cohesion.bond(laws.effective_radius(particles, (a, slot.part_a), b))
}

/// Finds the contact of parts up to `gap` (m) apart: that of a ball which is larger by the gap.
fn hold(index: u32, slot: &Slot, inputs: &FindInputs<'_>, gap: f64, found: &mut Found<'_>) {
    let particles = inputs.particles;
    let a = slot.a as usize;
    let scale = particles.scale[a];
    let part = &inputs.shapes[particles.shape[a] as usize].parts()[slot.part_a as usize];
    let PartGeometry::Sphere { center, radius } = part.geometry else { unreachable!("validation takes balls only") };
    let radius = radius + gap / scale;
    let larger =
        Part { center, radius, spine: None, geometry: PartGeometry::Sphere { center, radius }, skeleton: None };
    found.manifold.clear();
    if slot.kind.is_wall() {
        let boundary = WallSide::of(inputs.boundaries, slot.b).boundary;
        let wall_from_body = boundary.wall_from_body(&particles.position[a], &particles.rotation[a], scale);
        boundary.shape.contacts(&larger, &wall_from_body, found.manifold);
        share_stiffness(found.manifold.points_mut(), inputs.sharing);
        push_wall(index, (boundary, &wall_from_body.translation), found.manifold, found.contacts);
    } else {
        let b = slot.b as usize;
        let (a_from_b, scale) = particles.a_from_b(a, b, &particles.separation(a, b));
        let part_b = &inputs.shapes[particles.shape[b] as usize].parts()[slot.part_b as usize];
        narrow::collide(&larger, part_b, &a_from_b, &mut PairCache::default(), found.manifold);
        share_stiffness(found.manifold.points_mut(), inputs.sharing);
        push_pair(index, (&particles.rotation[a], scale), found.manifold, found.contacts);
    }
    for contact in &mut found.contacts[found.start..] {
        contact.overlap -= gap;
        contact.arm -= contact.normal * (0.5 * gap);
        contact.spring = Vec3::zeros();
    }
}
