//! Contact geometry of all slots, and the springs of the step before.

use rayon::prelude::*;

use super::bonds::{self, follow_bond};
use super::law::share_stiffness;
use super::table::{CHUNK, Contact, ContactChunk, ContactTable, Slot, SlotKind, least_chunks};
use crate::boundary::{Boundary, WallSide};
use crate::broad::ShapeReach;
use crate::math::{Mat3, Vec3};
use crate::mesh::PartAtMesh;
use crate::narrow::{self, Manifold, PairCache};
use crate::particles::Particles;
use crate::scene::{PointLaws, RoundedShapes, Sharing};
use crate::shape::Shape;

/// What the search reads.
#[derive(Clone, Copy)]
pub struct FindInputs<'a> {
    /// Rows.
    pub particles: &'a Particles,
    /// By shape index.
    pub shapes: &'a [Shape],
    /// By shape index.
    pub reaches: &'a [ShapeReach],
    /// By boundary index.
    pub boundaries: &'a [Boundary],
    /// Weights of several points.
    pub sharing: Sharing,
    /// Cores, where polyhedra meet by generalized overlap.
    pub rounded: Option<&'a RoundedShapes>,
    /// Whether springs are carried at all.
    pub history: bool,
    /// Laws of contacts that hold beyond the touch, where the scene has such.
    pub bonds: Option<&'a PointLaws>,
}

/// Fills each chunk's contacts from the present poses.
pub fn find_contacts(table: &mut ContactTable, inputs: &FindInputs<'_>) {
    let ContactTable { slots, chunks, .. } = table;
    (slots.par_chunks(CHUNK), chunks.par_iter_mut())
        .into_par_iter()
        .with_min_len(least_chunks(slots.len(), 200))
        .for_each(|(slots, chunk)| find_in_chunk(slots, chunk, inputs));
}

fn find_in_chunk(slots: &[Slot], chunk: &mut ContactChunk, inputs: &FindInputs<'_>) {
    let ContactChunk { contacts, previous, caches, manifold, overlaps, features, rods, lost_bonds, .. } = chunk;
    std::mem::swap(contacts, previous);
    contacts.clear();
    features.deepest = (0.0, 0);
    *lost_bonds = 0.0;
    let mut carried = previous.as_slice();
    let mut bonded = previous.as_slice();
    if inputs.rounded.is_some() {
        overlaps.begin();
    }
    for (k, slot) in slots.iter().enumerate() {
        let index = k as u32;
        let start = contacts.len();
        match slot.kind {
            SlotKind::Parts => part_pair(index, slot, &mut caches[k], inputs, manifold, contacts),
            SlotKind::Rods => rods.find_pair(index, slot, inputs, (manifold, contacts)),
            SlotKind::Features => features.find_pair(index, slot, inputs, contacts),
            SlotKind::Wall => part_wall(index, slot, inputs, manifold, contacts),
            SlotKind::RoundedParts | SlotKind::RoundedWall => {
                let rounded = inputs.rounded.expect("only scenes with cores have such slots");
                if slot.kind == SlotKind::RoundedParts {
                    overlaps.find_pair(index, slot, inputs, rounded);
                } else {
                    overlaps.find_wall(index, slot, inputs, rounded);
                }
                continue;
            }
        }
        if inputs.history && !carried.is_empty() {
            carried = carry_springs(index, carried, &mut contacts[start..]);
        }
        if let Some(laws) = inputs.bonds {
            let (own, rest) = of_slot(index, bonded);
            bonded = rest;
            let mut found = bonds::Found { contacts, manifold, start };
            *lost_bonds += follow_bond((index, slot), !own.is_empty(), inputs, laws, &mut found);
        }
    }
    if inputs.history && inputs.rounded.is_some() {
        overlaps.carry_springs();
    }
}

fn part_pair(
    index: u32,
    slot: &Slot,
    cache: &mut PairCache,
    inputs: &FindInputs<'_>,
    manifold: &mut Manifold,
    contacts: &mut Vec<Contact>,
) {
    let particles = inputs.particles;
    let (a, b) = (slot.a as usize, slot.b as usize);
    let d = particles.separation(a, b);
    let reach = particles.radius[a] + particles.radius[b];
    if d.norm_squared() >= reach * reach {
        return;
    }
    let (a_from_b, scale) = particles.a_from_b(a, b, &d);
    let rotation_a = &particles.rotation[a];
    let part_a = &inputs.shapes[particles.shape[a] as usize].parts()[slot.part_a as usize];
    let part_b = &inputs.shapes[particles.shape[b] as usize].parts()[slot.part_b as usize];
    manifold.clear();
    narrow::collide(part_a, part_b, &a_from_b, cache, manifold);
    share_stiffness(manifold.points_mut(), inputs.sharing);
    push_pair(index, (rotation_a, scale), manifold, contacts);
}

/// What is taken off a distance that must not be overestimated, over all that was added up for it.
const ROUNDING: f64 = 1e-9;

/// Two bodies with a gap between them cannot touch while their odometers, now at `travelled` together, add up to less than
/// this, m.
#[inline]
pub(super) fn quiet_until(travelled: f64, gap: f64, reach: f64) -> f64 {
    travelled + gap - ROUNDING * (travelled + gap + reach)
}

/// Points of two parts, in the frame and the unit of `a`, as contacts.
#[inline(always)]
pub(super) fn push_pair(
    index: u32,
    (rotation_a, scale): (&Mat3, f64),
    manifold: &Manifold,
    contacts: &mut Vec<Contact>,
) {
    contacts.extend(manifold.points().iter().map(|point| Contact {
        slot: index,
        feature: point.feature,
        weight: point.share,
        overlap: point.overlap * scale,
        arm: rotation_a * (point.position * scale),
        normal: rotation_a * point.normal,
        spring: Vec3::zeros(),
    }));
}

fn part_wall(index: u32, slot: &Slot, inputs: &FindInputs<'_>, manifold: &mut Manifold, contacts: &mut Vec<Contact>) {
    let particles = inputs.particles;
    let a = slot.a as usize;
    let WallSide { boundary, element, .. } = WallSide::of(inputs.boundaries, slot.b);
    // The neighbour list saw the row one or more periodic cells away: walls stay where they are.
    if boundary.distance(&particles.position[a]) >= particles.radius[a] {
        return;
    }
    let part = &inputs.shapes[particles.shape[a] as usize].parts()[slot.part_a as usize];
    let wall_from_body = boundary.wall_from_body(&particles.position[a], &particles.rotation[a], particles.scale[a]);
    manifold.clear();
    match element {
        None => boundary.shape.contacts(part, &wall_from_body, manifold),
        Some((mesh, element)) => {
            let deepest = inputs.shapes[particles.shape[a] as usize].half_thickness() * particles.scale[a];
            mesh.contacts(element, &PartAtMesh { part, mesh_from_body: &wall_from_body, deepest }, manifold);
        }
    }
    // each vertex of a rounded polyhedron is a contact of its own, as between two of them
    if !part.is_rounded_polyhedron() {
        share_stiffness(manifold.points_mut(), inputs.sharing);
    }
    push_wall(index, (boundary, &wall_from_body.translation), manifold, contacts);
}

/// Points of a part at a boundary, in its frame, as contacts; `centre` is that of the particle there.
#[inline(always)]
pub(super) fn push_wall(
    index: u32,
    (boundary, centre): (&Boundary, &Vec3),
    manifold: &Manifold,
    contacts: &mut Vec<Contact>,
) {
    contacts.extend(manifold.points().iter().map(|point| Contact {
        slot: index,
        feature: point.feature,
        weight: point.share,
        overlap: point.overlap,
        arm: boundary.rotation * (point.position - centre),
        normal: boundary.rotation * point.normal,
        spring: Vec3::zeros(),
    }));
}

/// Copies the springs of slot `index` by feature and returns what is left of the previous contacts.
#[inline]
fn carry_springs<'a>(index: u32, previous: &'a [Contact], contacts: &mut [Contact]) -> &'a [Contact] {
    let (own, rest) = of_slot(index, previous);
    for contact in contacts {
        if let Some(old) = own.iter().find(|old| old.feature == contact.feature) {
            contact.spring = old.spring;
        }
    }
    rest
}

/// The previous contacts of slot `index`, and those of the slots after it.
#[inline]
fn of_slot(index: u32, previous: &[Contact]) -> (&[Contact], &[Contact]) {
    let own_start = previous.iter().position(|old| old.slot >= index).unwrap_or(previous.len());
    let rest = &previous[own_start..];
    let own_len = rest.iter().position(|old| old.slot > index).unwrap_or(rest.len());
    rest.split_at(own_len)
}
