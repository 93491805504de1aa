//! Forces of point contacts under the laws beyond the plain one of `evaluate.rs`.

use super::effective_mass::inverse_mass;
use super::evaluate::{ForceInputs, Pair};
use super::law::{
    OverlapSpring, Resistance, RollingSpring, Slide, TangentialForce, coulomb_history, mindlin, mindlin_stiffness,
    resist_rolling, resist_twisting, viscous,
};
use super::table::{Contact, ContactChunk, Slot, Sums, Wrench};
use crate::math::Vec3;
use crate::scene::{DampingMass, PairExtras, PointLaws, PointNormal, Tangential};

/// Evaluates a chunk: the laws are chosen once, the loop inside is compiled for each choice.
pub(super) fn evaluate_points(
    slots: &[Slot],
    wrenches: &mut [Wrench],
    chunk: &mut ContactChunk,
    inputs: &ForceInputs<'_>,
    laws: &PointLaws,
) {
    let scene = (inputs, laws);
    let coulomb = |slide: &Slide| {
        let coefficients = [slide.stiffness, slide.damping];
        coulomb_history(coefficients, slide.limit, &slide.spring, &slide.normal, &slide.stretch, &slide.velocity)
    };
    let smooth = |_: &Slide| TangentialForce { force: Vec3::zeros(), spring: Vec3::zeros() };
    match (laws.normal, inputs.tangential) {
        (PointNormal::Linear, Tangential::CoulombHistory) => groups(slots, wrenches, chunk, scene, (linear, coulomb)),
        (PointNormal::Linear, Tangential::Viscous) => groups(slots, wrenches, chunk, scene, (linear, viscous)),
        (PointNormal::Linear, _) => groups(slots, wrenches, chunk, scene, (linear, smooth)),
        (PointNormal::Hertz, Tangential::Mindlin) => groups(slots, wrenches, chunk, scene, (hertz, mindlin)),
        (PointNormal::Hertz, Tangential::Viscous) => groups(slots, wrenches, chunk, scene, (hertz, viscous)),
        (PointNormal::Hertz, _) => groups(slots, wrenches, chunk, scene, (hertz, smooth)),
    }
}

/// Normal spring of one point, and its tangential stiffness.
struct PointSpring {
    normal: OverlapSpring,
    /// N/m
    tangential_stiffness: f64,
}

#[inline(always)]
fn linear(slot: &OfSlot<'_>, contact: &Contact) -> PointSpring {
    let stiffness = contact.weight * slot.pair.law.stiffness;
    let force = stiffness * contact.overlap;
    let damping = contact.weight * slot.pair.law.damping(slot.damping_mass);
    PointSpring {
        normal: OverlapSpring { force, energy: 0.5 * force * contact.overlap, damping },
        tangential_stiffness: contact.weight * slot.pair.law.tangential_stiffness,
    }
}

#[inline(always)]
fn hertz(slot: &OfSlot<'_>, contact: &Contact) -> PointSpring {
    let (weight, moduli) = (contact.weight, &slot.extras.hertz);
    // that of a bond beyond the touch is below 0
    let overlap = contact.overlap.max(0.0);
    let one = moduli.spring(slot.pair.law, slot.radius, overlap, slot.damping_mass);
    PointSpring {
        normal: OverlapSpring { force: weight * one.force, energy: weight * one.energy, damping: weight * one.damping },
        tangential_stiffness: weight * mindlin_stiffness(moduli.shear_modulus, slot.radius, overlap),
    }
}

/// Velocities at one point, world axes.
struct PointMotion {
    arm_a: Vec3,
    arm_b: Vec3,
    velocity_b: Vec3,
    /// Of `a` against `b`, predicted at the full step.
    relative: Vec3,
    /// The same, mean over the step.
    mean_relative: Vec3,
}

impl Pair<'_> {
    /// How the sides of a point move.
    #[inline(always)]
    fn motion(&self, contact: &Contact, inputs: &ForceInputs<'_>) -> PointMotion {
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
        PointMotion { arm_a, arm_b, velocity_b, relative: velocity_a - velocity_b, mean_relative: mean_a - mean_b }
    }

    /// Adds the force of one point; books the work of walls.
    #[inline(always)]
    fn push(&self, force: &Vec3, motion: &PointMotion, (wrench, sums): (&mut Wrench, &mut Sums)) {
        if self.boundary.is_some() {
            sums.power_boundaries += force.dot(&motion.velocity_b);
        } else {
            wrench.torque_b -= motion.arm_b.cross(force);
        }
        wrench.force += force;
        wrench.torque_a += motion.arm_a.cross(force);
    }
}

/// What all points of a slot have in common.
struct OfSlot<'a> {
    pair: Pair<'a>,
    extras: &'a PairExtras,
    /// R, 1/R = 1/r_a + 1/r_b, m; 0 where no law reads it.
    radius: f64,
    /// Sum of the points' weights.
    weights: f64,
    /// Effective mass over the sum of weights, kg: with stiffness W k the dashpot of a point is w 2 zeta sqrt(k m/W).
    /// Shared over bodies, W of one slot is below 1 and the pair's stiffness is k.
    damping_mass: f64,
}

impl<'a> OfSlot<'a> {
    #[inline(always)]
    fn new(slot: &Slot, group: &[Contact], (inputs, laws): (&ForceInputs<'a>, &'a PointLaws)) -> Self {
        let particles = inputs.particles;
        let pair = Pair::new(slot, inputs);
        let material_b = match (pair.b, pair.boundary) {
            (Some((b, _)), _) => particles.material[b],
            (None, boundary) => boundary.map_or(0, |boundary| boundary.material),
        };
        let extras = laws.extras(particles.material[pair.a], material_b);
        let radius = if laws.reads_radius {
            laws.effective_radius(particles, (pair.a, slot.part_a), pair.b.map(|(b, _)| (b, slot.part_b)))
        } else {
            0.0
        };
        let inverse_of = |row: usize| if particles.is_frozen(row) { 0.0 } else { 1.0 / particles.mass[row] };
        let central = inverse_of(pair.a) + pair.b.map_or(0.0, |(b, _)| inverse_of(b));
        let (inverse, weights) = if laws.damping_mass == DampingMass::Contact {
            inverse_mass(&pair, group, particles)
        } else {
            (central, group.iter().map(|contact| contact.weight).sum())
        };
        Self { pair, extras, radius, weights, damping_mass: 1.0 / (inverse * weights.max(1.0)) }
    }
}

/// All slots of the chunk that touch.
fn groups<N, T>(
    slots: &[Slot],
    wrenches: &mut [Wrench],
    chunk: &mut ContactChunk,
    scene: (&ForceInputs<'_>, &PointLaws),
    laws: (N, T),
) where
    N: Fn(&OfSlot<'_>, &Contact) -> PointSpring,
    T: Fn(&Slide) -> TangentialForce,
{
    let ContactChunk { contacts, rolling, sums, .. } = chunk;
    if scene.1.rolling {
        rolling.resize(slots.len(), RollingSpring::default());
    }
    let mut next = 0;
    for group in contacts.chunk_by_mut(|a, b| a.slot == b.slot) {
        let index = group[0].slot as usize;
        let slot = OfSlot::new(&slots[index], group, scene);
        let mut wrench = Wrench { points: group.len() as u32, ..Wrench::default() };
        let (mut overlap, mut pressed) = (0.0f64, Vec3::zeros());
        for contact in group {
            pressed += slot.point(contact, scene.0, &laws, (&mut wrench, sums));
            overlap = overlap.max(contact.overlap);
        }
        if scene.1.rolling {
            rolling[next..index].fill(RollingSpring::default());
            next = index + 1;
            slot.resist(&pressed, scene, &mut rolling[index], (&mut wrench, sums));
        }
        wrenches[index] = wrench;
        sums.take_overlap(overlap, slot.pair.smaller_radius, index);
    }
    if scene.1.rolling {
        rolling[next..].fill(RollingSpring::default());
    }
}

impl OfSlot<'_> {
    /// Adds the force of one point, stretches its spring and returns its push (without cohesion) on `b`.
    #[inline(always)]
    fn point<N, T>(
        &self,
        contact: &mut Contact,
        inputs: &ForceInputs<'_>,
        (normal_law, tangential_law): &(N, T),
        (wrench, sums): (&mut Wrench, &mut Sums),
    ) -> Vec3
    where
        N: Fn(&OfSlot<'_>, &Contact) -> PointSpring,
        T: Fn(&Slide) -> TangentialForce,
    {
        let motion = self.pair.motion(contact, inputs);
        let approach_speed = motion.relative.dot(&contact.normal);
        let spring = normal_law(self, contact);
        let normal = spring.normal.scalar_force(approach_speed, inputs.contact_end);
        let (attraction, bond) = self.extras.cohesion.at(self.radius, contact.overlap);
        let part = contact.weight / self.weights;
        let mut force = contact.normal * (part * attraction - normal.force);
        sums.elastic_normal += spring.normal.energy + part * bond;
        sums.power_normal += normal.dissipated_power;
        let law = self.pair.law;
        if law.friction > 0.0 && contact.overlap > 0.0 {
            let tangent = |v: Vec3| v - contact.normal * v.dot(&contact.normal);
            let velocity = tangent(motion.relative);
            let mean = motion.mean_relative * inputs.stretch_time_s;
            let viscosity = self.extras.tangential_damping.map(|c| contact.weight * c);
            let friction = tangential_law(&Slide {
                stiffness: spring.tangential_stiffness,
                damping: viscosity.unwrap_or(spring.normal.damping * law.tangential_damping_ratio),
                limit: law.friction * normal.force.max(0.0),
                spring: contact.spring,
                normal: contact.normal,
                stretch: tangent(mean),
                velocity,
                overlap: contact.overlap,
                former_overlap: contact.overlap - mean.dot(&contact.normal),
            });
            contact.spring = friction.spring;
            force += friction.force;
            sums.elastic_tangential += 0.5 * spring.tangential_stiffness * friction.spring.norm_squared();
            sums.power_tangential -= friction.force.dot(&velocity);
        }
        self.pair.push(&force, &motion, (wrench, sums));
        sums.count_point(contact.feature);
        contact.normal * normal.force
    }

    /// Torque against rolling and twisting, once per slot.
    fn resist(
        &self,
        pressed: &Vec3,
        (inputs, laws): (&ForceInputs<'_>, &PointLaws),
        spring: &mut RollingSpring,
        (wrench, sums): (&mut Wrench, &mut Sums),
    ) {
        let law = &self.extras.rolling;
        let force = pressed.norm();
        if !law.is_active() || force == 0.0 {
            *spring = RollingSpring::default();
            return;
        }
        let normal = pressed / force;
        let (particles, a) = (inputs.particles, self.pair.a);
        let of_a = &particles.motion[a];
        let (rate_b, mean_b) = match (self.pair.b, self.pair.boundary) {
            (Some((b, _)), _) => (particles.motion[b].angular_velocity, particles.motion[b].mean_angular_velocity),
            (None, boundary) => {
                let rate = boundary.map_or_else(Vec3::zeros, |boundary| boundary.angular_velocity);
                (rate, rate)
            }
        };
        let rate = of_a.angular_velocity - rate_b;
        let turn = (of_a.mean_angular_velocity - mean_b) * inputs.stretch_time_s;
        let (about, flat) = (rate.dot(&normal), turn.dot(&normal));
        // 1/I_r of both bodies: about the contact for rolling, about the centre for twisting.
        let inverse = |row: usize| {
            if particles.is_frozen(row) {
                return [0.0; 2];
            }
            let own = particles.inertia[particles.owner(row)].mean();
            let shifted = own + particles.mass[row] * particles.radius[row].powi(2);
            [1.0 / shifted, 1.0 / own]
        };
        let [of_a, of_b] = [inverse(a), self.pair.b.map_or([0.0; 2], |(b, _)| inverse(b))];
        let stiffness = laws.reference_stiffness(self.pair.law, self.extras, self.radius);
        let resistance = |friction: f64, k: usize| {
            Resistance::new(friction, self.radius, [stiffness, force], law.damping_ratio, of_a[k] + of_b[k])
        };
        let mut torque = Vec3::zeros();
        if law.rolling > 0.0 {
            let resistance = resistance(law.rolling, 0);
            let tangent = [&(turn - normal * flat), &(rate - normal * about)];
            let (against, roll) = resist_rolling(&resistance, &spring.roll, &normal, tangent);
            torque += against;
            spring.roll = roll;
            sums.elastic_tangential += resistance.energy(roll.norm_squared());
        }
        if law.twisting > 0.0 {
            let resistance = resistance(law.twisting, 1);
            let (against, twist) = resist_twisting(&resistance, spring.twist, flat, about);
            torque += normal * against;
            spring.twist = twist;
            sums.elastic_tangential += resistance.energy(twist * twist);
        }
        sums.power_tangential -= torque.dot(&rate);
        wrench.torque_a += torque;
        if self.pair.boundary.is_some() {
            sums.power_boundaries += torque.dot(&rate_b);
        } else {
            wrench.torque_b -= torque;
        }
    }
}
