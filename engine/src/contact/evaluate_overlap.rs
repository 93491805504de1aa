//! Forces of the contacts by generalized overlap.

use super::evaluate::ForceInputs;
use super::law::{PairLaw, coulomb_history, rocking_force, torsion_history};
use super::overlap::{OverlapChunk, OverlapContact};
use super::table::{Slot, Sums, Wrench};
use crate::boundary::{Boundary, WallSide};
use crate::math::Vec3;
use crate::narrow::generalized_overlap::OverlapPoint;
use crate::scene::{RoundedShapes, Tangential};

/// Velocity of `b` against `a` as a field over arms from the centre of `a`: `linear + angular x arm`.
#[derive(Clone, Copy)]
struct RelativeMotion {
    linear: Vec3,
    angular: Vec3,
}

impl RelativeMotion {
    #[inline(always)]
    fn at(&self, arm: &Vec3) -> Vec3 {
        self.linear + self.angular.cross(arm)
    }
}

/// What a contact does to `b` about the centre of `a`; `a` takes the opposite.
#[derive(Clone, Copy)]
struct OnB {
    force: Vec3,
    moment: Vec3,
}

/// What all points of a contact have in common.
struct Pair<'a> {
    a: usize,
    /// Row of the other particle and its centre seen from that of `a`; `None` for a boundary.
    b: Option<(usize, Vec3)>,
    boundary: Option<&'a Boundary>,
    law: &'a PairLaw,
    reduced_mass: f64,
    smaller_radius: f64,
    /// Predicted at the full step.
    now: RelativeMotion,
    /// Over the step.
    mean: RelativeMotion,
}

/// Evaluates the contacts of a chunk; `slots` and `wrenches` are those of the chunk.
pub(super) fn evaluate_overlaps(
    slots: &[Slot],
    wrenches: &mut [Wrench],
    (chunk, sums): (&mut OverlapChunk, &mut Sums),
    inputs: &ForceInputs<'_>,
    rounded: &RoundedShapes,
) {
    let OverlapChunk { contacts, points, .. } = chunk;
    for contact in contacts {
        let index = contact.slot as usize;
        let pair = Pair::new(&slots[index], inputs);
        let first = contact.first_point as usize;
        let points = &points[first..first + contact.points[0] as usize];
        let mut on_b = pair.normal(contact, points, inputs, rounded, sums);
        if inputs.tangential == Tangential::CoulombHistory && pair.law.friction > 0.0 {
            pair.add_friction(contact, points, inputs.stretch_time_s, &mut on_b, sums);
        }
        wrenches[index] = pair.wrench(&on_b, contact.points[0], inputs, sums);
        sums.points_by_kind[1] += u64::from(contact.points[0] - contact.points[1]);
        sums.points_by_kind[2] += u64::from(contact.points[1]);
        sums.take_overlap(contact.overlap, pair.smaller_radius, index);
        // at a wall, and without rounding, the law has no end
        if pair.b.is_some() && contact.radius_sum > 0.0 {
            sums.take_rounding(contact.overlap / (0.5 * contact.radius_sum), index);
        }
    }
}

impl<'a> Pair<'a> {
    fn new(slot: &Slot, inputs: &ForceInputs<'a>) -> Self {
        let particles = inputs.particles;
        let (a, b) = (slot.a as usize, slot.b as usize);
        let of_a = &particles.motion[a];
        if slot.kind.is_wall() {
            let boundary = WallSide::of(inputs.boundaries, slot.b).boundary;
            let surface = boundary.surface_velocity(&particles.position[a]);
            return Self {
                a,
                b: None,
                boundary: Some(boundary),
                law: inputs.pairs.law(particles.material[a], boundary.material),
                reduced_mass: particles.mass[a],
                smaller_radius: particles.radius[a],
                now: RelativeMotion {
                    linear: surface - of_a.velocity,
                    angular: boundary.angular_velocity - of_a.angular_velocity,
                },
                mean: RelativeMotion {
                    linear: surface - of_a.mean_velocity,
                    angular: boundary.angular_velocity - of_a.mean_angular_velocity,
                },
            };
        }
        let of_b = &particles.motion[b];
        let d = particles.separation(a, b);
        let motion = |[va, wa, vb, wb]: [&Vec3; 4]| RelativeMotion { linear: vb - wb.cross(&d) - va, angular: wb - wa };
        Self {
            a,
            b: Some((b, d)),
            boundary: None,
            law: inputs.pairs.law(particles.material[a], particles.material[b]),
            reduced_mass: particles.reduced_mass(a, b),
            smaller_radius: particles.radius[a].min(particles.radius[b]),
            now: motion([&of_a.velocity, &of_a.angular_velocity, &of_b.velocity, &of_b.angular_velocity]),
            mean: motion([
                &of_a.mean_velocity,
                &of_a.mean_angular_velocity,
                &of_b.mean_velocity,
                &of_b.mean_angular_velocity,
            ]),
        }
    }

    /// 1/m_eff = F.F (1/m_a + 1/m_b) + T_a . I_a^-1 T_a + T_b . I_b^-1 T_b, per unit of the scalar force.
    fn inverse_mass(&self, contact: &OverlapContact, inputs: &ForceInputs<'_>) -> f64 {
        let particles = inputs.particles;
        let turning = |row: usize, torque: &Vec3| {
            if particles.is_frozen(row) {
                return 0.0;
            }
            let in_body = particles.rotation[row].tr_mul(torque);
            in_body.dot(&in_body.component_div(&particles.inertia[particles.owner(row)]))
        };
        let of_b = self.b.map_or(0.0, |(b, d)| turning(b, &(contact.moment - d.cross(&contact.force))));
        contact.force.norm_squared() / self.reduced_mass + turning(self.a, &contact.moment) + of_b
    }

    /// Spring, dashpot on D, dashpots against rocking.
    fn normal(
        &self,
        contact: &OverlapContact,
        points: &[OverlapPoint],
        inputs: &ForceInputs<'_>,
        rounded: &RoundedShapes,
        sums: &mut Sums,
    ) -> OnB {
        let effective_mass = 1.0 / self.inverse_mass(contact, inputs);
        let spring = rounded.law.spring(self.law, contact.overlap, contact.radius_sum, effective_mass);
        let rate = -(contact.force.dot(&self.now.linear) + contact.moment.dot(&self.now.angular));
        let normal = spring.scalar_force(rate, inputs.contact_end);
        sums.elastic_normal += spring.energy;
        sums.power_normal += normal.dissipated_power;
        let mut on_b = OnB { force: contact.force * normal.force, moment: contact.moment * normal.force };
        let damping = rounded.law.rocking * spring.damping;
        if points.len() > 1 && damping > 0.0 {
            let approach = |point: &OverlapPoint| -point.normal.dot(&self.now.at(&point.position));
            let mean_rate: f64 = points.iter().map(|point| point.share * approach(point)).sum();
            for point in points {
                let rate = approach(point);
                let of_point = [point.share, point.rocking];
                let force = rocking_force(damping, of_point, [rate, mean_rate], normal.force, inputs.contact_end);
                sums.power_normal += force * rate;
                let push = point.normal * force;
                on_b.force += push;
                on_b.moment += point.position.cross(&push);
            }
        }
        on_b
    }

    /// One tangential and one torsion spring at the mean point of the contact.
    fn add_friction(
        &self,
        contact: &mut OverlapContact,
        points: &[OverlapPoint],
        time_s: f64,
        on_b: &mut OnB,
        sums: &mut Sums,
    ) {
        let length = contact.force.norm();
        let total: f64 = points.iter().map(|point| point.share).sum();
        if length == 0.0 || total == 0.0 {
            return;
        }
        let normal = contact.force / length;
        let centre = points.iter().map(|point| point.position * point.share).sum::<Vec3>() / total;
        let spread = points.iter().map(|point| (point.position - centre).norm() * point.share).sum::<f64>() / total;
        let limit = self.law.friction * on_b.force.dot(&normal).max(0.0);
        let damping = self.law.damping(self.reduced_mass) * self.law.tangential_damping_ratio;
        let coefficients = [self.law.tangential_stiffness, damping];
        let tangent = |v: Vec3| v - normal * v.dot(&normal);
        // of `a` against `b`, as the tangential laws want it
        let velocity = tangent(-self.now.at(&centre));
        let stretch = tangent(-self.mean.at(&centre)) * time_s;
        let slide = coulomb_history(coefficients, limit, &contact.spring, &normal, &stretch, &velocity);
        let spin = -self.now.angular.dot(&normal) * spread;
        let turn = -self.mean.angular.dot(&normal) * spread * time_s;
        let torsion = torsion_history(coefficients, limit, contact.twist, turn, spin);
        (contact.spring, contact.twist) = (slide.spring, torsion.spring);
        on_b.force -= slide.force;
        on_b.moment -= centre.cross(&slide.force) + normal * (torsion.force * spread);
        let stretched2 = slide.spring.norm_squared() + torsion.spring * torsion.spring;
        sums.elastic_tangential += 0.5 * self.law.tangential_stiffness * stretched2;
        sums.power_tangential -= slide.force.dot(&velocity) + torsion.force * spin;
    }

    /// To what the gather adds up; books the work of walls.
    fn wrench(&self, on_b: &OnB, points: u32, inputs: &ForceInputs<'_>, sums: &mut Sums) -> Wrench {
        let torque_b = self.b.map_or_else(Vec3::zeros, |(_, d)| on_b.moment - d.cross(&on_b.force));
        if let Some(boundary) = self.boundary {
            let surface = boundary.surface_velocity(&inputs.particles.position[self.a]);
            sums.power_boundaries -= on_b.force.dot(&surface) + on_b.moment.dot(&boundary.angular_velocity);
        }
        Wrench { force: -on_b.force, torque_a: -on_b.moment, torque_b, points }
    }
}
