//! Forces of all contacts, summed per slot.

use rayon::prelude::*;

use super::evaluate_overlap::evaluate_overlaps;
use super::evaluate_points::evaluate_points;
use super::law::{PairLaw, PairTable, coulomb_history, normal_force};
use super::table::{CHUNK, Contact, ContactChunk, ContactTable, Slot, SlotKind, Sums, Wrench, least_chunks};
use crate::boundary::{Boundary, WallSide};
use crate::math::Vec3;
use crate::particles::Particles;
use crate::scene::{ContactEnd, PointLaws, RoundedShapes, Tangential};

/// What the laws read.
#[derive(Clone, Copy)]
pub struct ForceInputs<'a> {
    /// Rows.
    pub particles: &'a Particles,
    /// By boundary index.
    pub boundaries: &'a [Boundary],
    /// By pair of materials.
    pub pairs: &'a PairTable,
    /// End of contact.
    pub contact_end: ContactEnd,
    /// Tangential law.
    pub tangential: Tangential,
    /// Laws of point contacts, where they are not the plain ones.
    pub point_laws: Option<&'a PointLaws>,
    /// Cores and law, where polyhedra meet by generalized overlap.
    pub rounded: Option<&'a RoundedShapes>,
    /// Time over which the springs stretch, s (0 when forces are evaluated without a step).
    pub stretch_time_s: f64,
}

/// Evaluates the laws; writes each slot's wrench and each chunk's sums.
pub fn evaluate_forces(table: &mut ContactTable, inputs: &ForceInputs<'_>) {
    let ContactTable { spheres, slots, wrenches, chunks, .. } = table;
    spheres.evaluate(inputs);
    (slots.par_chunks(CHUNK), wrenches.par_chunks_mut(CHUNK), chunks.par_iter_mut())
        .into_par_iter()
        .enumerate()
        .with_min_len(least_chunks(slots.len(), 50))
        .for_each(|(k, (slots, wrenches, chunk))| {
            evaluate_chunk(slots, wrenches, chunk, inputs);
            chunk.sums.largest_slot += (k * CHUNK) as u32;
            chunk.sums.rounding_slot += (k * CHUNK) as u32;
        });
}

fn evaluate_chunk(slots: &[Slot], wrenches: &mut [Wrench], chunk: &mut ContactChunk, inputs: &ForceInputs<'_>) {
    wrenches.iter_mut().for_each(|wrench| wrench.points = 0);
    chunk.sums = Sums { lost_bonds: chunk.lost_bonds, ..Sums::default() };
    match inputs.point_laws {
        None => evaluate_plain(slots, wrenches, chunk, inputs),
        Some(laws) => evaluate_points(slots, wrenches, chunk, inputs, laws),
    }
    let (deepest, slot) = chunk.features.deepest;
    chunk.sums.take_rounding(deepest, slot as usize);
    if let Some(rounded) = inputs.rounded {
        evaluate_overlaps(slots, wrenches, (&mut chunk.overlaps, &mut chunk.sums), inputs, rounded);
    }
}

/// Linear spring and dashpot for the reduced mass, Coulomb friction with history.
fn evaluate_plain(slots: &[Slot], wrenches: &mut [Wrench], chunk: &mut ContactChunk, inputs: &ForceInputs<'_>) {
    for group in chunk.contacts.chunk_by_mut(|a, b| a.slot == b.slot) {
        let index = group[0].slot as usize;
        let slot = &slots[index];
        let pair = Pair::new(slot, inputs);
        let mut wrench = Wrench { points: group.len() as u32, ..Wrench::default() };
        let mut overlap = 0.0f64;
        for contact in group {
            pair.evaluate(contact, inputs, &mut wrench, &mut chunk.sums);
            overlap = overlap.max(contact.overlap);
        }
        wrenches[index] = wrench;
        chunk.sums.take_overlap(overlap, pair.smaller_radius, index);
    }
}

/// What all points of a slot have in common.
pub(super) struct Pair<'a> {
    pub(super) a: usize,
    /// Row of the other particle and its centre seen from that of `a`; `None` for a boundary.
    pub(super) b: Option<(usize, Vec3)>,
    pub(super) boundary: Option<&'a Boundary>,
    pub(super) law: &'a PairLaw,
    damping: f64,
    pub(super) smaller_radius: f64,
}

impl<'a> Pair<'a> {
    #[inline(always)]
    pub(super) fn new(slot: &Slot, inputs: &ForceInputs<'a>) -> Self {
        let particles = inputs.particles;
        let (a, b) = (slot.a as usize, slot.b as usize);
        if slot.kind == SlotKind::Wall {
            let boundary = WallSide::of(inputs.boundaries, slot.b).boundary;
            let law = inputs.pairs.law(particles.material[a], boundary.material);
            let damping = law.damping(particles.mass[a]);
            return Self { a, b: None, boundary: Some(boundary), law, damping, smaller_radius: particles.radius[a] };
        }
        let law = inputs.pairs.law(particles.material[a], particles.material[b]);
        let damping = law.damping(particles.reduced_mass(a, b));
        let smaller_radius = particles.radius[a].min(particles.radius[b]);
        Self { a, b: Some((b, particles.separation(a, b))), boundary: None, law, damping, smaller_radius }
    }

    /// Adds the force of one point and stretches its spring. Shares no code with `evaluate_points.rs`: going through its
    /// structs cost 2 % of a step of spheres.
    #[inline(always)]
    fn evaluate(&self, contact: &mut Contact, inputs: &ForceInputs<'_>, wrench: &mut Wrench, sums: &mut Sums) {
        let particles = inputs.particles;
        let arm_a = contact.arm;
        let (velocity_a, mean_a) = particles.motion[self.a].at(&arm_a);
        let arm_b = self.b.map_or_else(Vec3::zeros, |(_, centre)| arm_a - centre);
        let (velocity_b, mean_b) = match (self.b, self.boundary) {
            (Some((b, _)), _) => particles.motion[b].at(&arm_b),
            (None, Some(boundary)) => {
                let surface = boundary.surface_velocity(&(particles.position[self.a] + arm_a));
                (surface, surface)
            }
            (None, None) => (Vec3::zeros(), Vec3::zeros()),
        };
        let relative = velocity_a - velocity_b;
        let approach_speed = relative.dot(&contact.normal);
        let stiffness = contact.weight * self.law.stiffness;
        let normal =
            normal_force(stiffness, contact.weight * self.damping, contact.overlap, approach_speed, inputs.contact_end);
        let mut force = contact.normal * -normal.force;
        sums.elastic_normal += 0.5 * stiffness * contact.overlap * contact.overlap;
        sums.power_normal += normal.dissipated_power;
        if inputs.tangential == Tangential::CoulombHistory && self.law.friction > 0.0 {
            let tangent = |v: Vec3| v - contact.normal * v.dot(&contact.normal);
            let tangential_stiffness = contact.weight * self.law.tangential_stiffness;
            let velocity = tangent(relative);
            let friction = coulomb_history(
                [tangential_stiffness, contact.weight * self.damping * self.law.tangential_damping_ratio],
                self.law.friction * normal.force.max(0.0),
                &contact.spring,
                &contact.normal,
                &(tangent(mean_a - mean_b) * inputs.stretch_time_s),
                &velocity,
            );
            contact.spring = friction.spring;
            force += friction.force;
            sums.elastic_tangential += 0.5 * tangential_stiffness * friction.spring.norm_squared();
            sums.power_tangential -= friction.force.dot(&velocity);
        }
        if self.boundary.is_some() {
            sums.power_boundaries += force.dot(&velocity_b);
        } else {
            wrench.torque_b -= arm_b.cross(&force);
        }
        wrench.force += force;
        wrench.torque_a += arm_a.cross(&force);
        sums.count_point(contact.feature);
    }
}
