//! What pushes particles apart from contacts and gravity: loads of a client, and the fluid. Both half kicks are exact for it.
//!
//! With F = f - K v - M dv/dt on a particle of mass m (M the added mass) each half kick solves (m + M) v' = f_contact + m g +
//! f - K v for a frozen contact force: v(h) = v e^-z + a h (1 - e^-z)/z with z = K h/(m + M) and a = (f_contact + m g + f)/(m +
//! M); the mean velocity over it is v (1 - e^-z)/z + a h (1 - (1 - e^-z)/z)/z, from which the impulse of the drag follows
//! to rounding. Likewise the angular momentum about each principal axis.

use rayon::prelude::*;

use crate::coupling::{Acting, Body, Fluid, Outcome};
use crate::engine::Engine;
use crate::loads::Loads;
use crate::math::{Mat3, Vec3};
use crate::parallel::least;
use crate::particles::Particles;

/// Where the pushed particles are; made anew when rows may have moved. No state.
#[derive(Clone, Debug, Default)]
pub(crate) struct ExternalRows {
    /// Rebuilds of the neighbour list and changes of loads and fluid, when it was made.
    made_at: Option<(u64, u64)>,
    /// By row: which load, or [`NONE`].
    load: Vec<u32>,
    /// By row: slot of the fluid; empty without one.
    slot: Vec<u32>,
    /// By slot of the fluid: row.
    row: Vec<u32>,
    /// By row: force and torque without what is here.
    kept: Vec<[Vec3; 2]>,
    /// By row: what the last half step did; empty without a fluid.
    outcome: Vec<Outcome>,
}

const NONE: u32 = u32::MAX;
/// Rows per sum of work; never a function of the thread count.
const CHUNK: usize = 512;

/// Which half of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Half {
    /// With what was found at the end of the step before.
    First,
    /// With what is found now.
    Second,
}

/// (1 - e^-z)/z.
#[inline(always)]
fn decay_mean(z: f64) -> f64 {
    if z < 1e-12 { 1.0 - 0.5 * z } else { -(-z).exp_m1() / z }
}

/// (1 - (1 - e^-z)/z)/z; by its series where the difference would lose digits.
#[inline(always)]
fn decay_lag(z: f64, mean: f64) -> f64 {
    if z < 1e-2 { 0.5 + z * (-1.0 / 6.0 + z * (1.0 / 24.0 + z * (-1.0 / 120.0 + z / 720.0))) } else { (1.0 - mean) / z }
}

/// Half a step.
struct HalfStep<'a> {
    gravity: &'a Vec3,
    h: f64,
}

/// Columns of one row.
struct Row<'a> {
    velocity: &'a Vec3,
    momentum: &'a Vec3,
    rotation: &'a Mat3,
    inertia: &'a Vec3,
    mass: f64,
}

/// What all pushes of a row add up to.
#[derive(Clone, Copy, Default)]
struct Push {
    force: Vec3,
    drag: f64,
    torque: Vec3,
    rotational_drag: f64,
    added_mass: f64,
}

/// After half a step.
struct After {
    velocity: Vec3,
    mean_velocity: Vec3,
    momentum: Vec3,
}

impl Push {
    fn of(load: Option<(&Loads, usize, f64)>, acting: Option<&Acting>) -> Self {
        let mut push = Self::default();
        if let Some((loads, at, time_s)) = load {
            let load = loads.load(at, time_s);
            (push.force, push.drag, push.torque, push.rotational_drag) =
                (load.force, load.drag, load.torque, load.rotational_drag);
        }
        if let Some(acting) = acting {
            push.force += acting.force;
            push.drag += acting.drag;
            push.torque += acting.torque;
            push.rotational_drag += acting.rotational_drag;
            push.added_mass = acting.added_mass;
        }
        push
    }

    /// Whether it does anything to the rotation.
    #[inline(always)]
    fn turns(&self) -> bool {
        self.rotational_drag != 0.0 || self.torque != Vec3::zeros()
    }
}

impl HalfStep<'_> {
    /// With the contact force and torque.
    #[inline(always)]
    fn after(&self, push: &Push, row: &Row<'_>, force: &Vec3, torque: &Vec3) -> After {
        let inertial = 1.0 / (row.mass + push.added_mass);
        let acceleration = (force + push.force + self.gravity * row.mass) * inertial;
        let z = push.drag * inertial * self.h;
        let mean = decay_mean(z);
        let path = acceleration * self.h;
        After {
            // e^-z = 1 - z (1 - e^-z)/z: one exponential for both
            velocity: row.velocity * (1.0 - z * mean) + path * mean,
            mean_velocity: row.velocity * mean + path * decay_lag(z, mean),
            momentum: if push.turns() { self.turned(push, row, torque) } else { row.momentum + torque * self.h },
        }
    }

    /// Angular momentum after half a step.
    fn turned(&self, push: &Push, row: &Row<'_>, torque: &Vec3) -> Vec3 {
        let mut in_body = row.rotation.tr_mul(row.momentum);
        let torque_in_body = row.rotation.tr_mul(&(torque + push.torque));
        for axis in 0..3 {
            let z = push.rotational_drag * self.h / row.inertia[axis];
            let mean = decay_mean(z);
            in_body[axis] = in_body[axis] * (1.0 - z * mean) + torque_in_body[axis] * (self.h * mean);
        }
        row.rotation * in_body
    }

    /// Adds the force and torque that a plain half kick needs, and returns the work of the push, J: its impulse times the
    /// mean of the velocities before and after, which is the energy that it gives the particle.
    #[inline(always)]
    fn add_to(&self, push: &Push, after: &After, row: &Row<'_>, (force, torque): (&mut Vec3, &mut Vec3)) -> f64 {
        let total_force = (after.velocity - row.velocity) * (row.mass / self.h) - self.gravity * row.mass;
        let mut work = (total_force - *force).dot(&(after.velocity + row.velocity));
        *force = total_force;
        if push.turns() {
            let total_torque = (after.momentum - row.momentum) / self.h;
            let rate = |momentum: &Vec3| row.rotation * row.rotation.tr_mul(momentum).component_div(row.inertia);
            work += (total_torque - *torque).dot(&(rate(&after.momentum) + rate(row.momentum)));
            *torque = total_torque;
        }
        0.5 * self.h * work
    }
}

impl ExternalRows {
    /// Finds the rows of loads and of the fluid's slots; particles that are gone take their loads with them.
    fn find(&mut self, particles: &Particles, loads: Option<&Loads>, fluid: Option<&Fluid>, made_at: (u64, u64)) {
        let n = particles.n_owned();
        if self.made_at == Some(made_at) && self.kept.len() == n && self.slot.len() == fluid.map_or(0, |_| n) {
            return;
        }
        self.made_at = Some(made_at);
        self.load.clear();
        if let Some(loads) = loads {
            self.load.extend(particles.ids.iter().map(|&id| loads.find(id).map_or(NONE, |at| at as u32)));
            // nothing pushes what is frozen
            let frozen = self.load.iter_mut().zip(&particles.frozen).filter(|(_, frozen)| **frozen);
            frozen.for_each(|(load, _)| *load = NONE);
        } else {
            self.load.resize(n, NONE);
        }
        self.slot.clear();
        self.row.clear();
        self.outcome.clear();
        if let Some(fluid) = fluid {
            self.slot.extend(particles.ids.iter().map(|&id| fluid.slot(id) as u32));
            self.row.resize(n, 0);
            self.slot.iter().enumerate().for_each(|(row, &slot)| self.row[slot as usize] = row as u32);
            self.outcome.resize(n, Outcome::default());
        }
        self.kept.resize(n, [Vec3::zeros(); 2]);
    }
}

/// All that a chunk of rows reads.
struct Reads<'a> {
    half: HalfStep<'a>,
    which: Half,
    loads: Option<&'a Loads>,
    fluid: Option<&'a Fluid>,
    particles: &'a Columns<'a>,
    time_s: f64,
}

/// Columns of the particles that a half step reads and does not change.
struct Columns<'a> {
    velocity: &'a [Vec3],
    momentum: &'a [Vec3],
    rotation: &'a [Mat3],
    inertia: &'a [Vec3],
    mass: &'a [f64],
    shape: &'a [u32],
    scale: &'a [f64],
    frozen: &'a [bool],
}

impl Columns<'_> {
    fn row(&self, row: usize) -> Row<'_> {
        Row {
            velocity: &self.velocity[row],
            momentum: &self.momentum[row],
            rotation: &self.rotation[row],
            inertia: &self.inertia[row],
            mass: self.mass[row],
        }
    }
}

impl Reads<'_> {
    /// One row: changes its force and torque, and returns what became of it and the work done on it.
    fn push_row(&self, row: usize, load: u32, slot: Option<u32>, columns: (&mut Vec3, &mut Vec3)) -> (Outcome, f64) {
        let (force, torque) = columns;
        let body = self.particles.row(row);
        let load = self.loads.filter(|_| load != NONE).map(|loads| (loads, load as usize, self.time_s));
        let frozen = self.particles.frozen.get(row).is_some_and(|frozen| *frozen);
        let mut acting = self.fluid.zip(slot).map(|(fluid, slot)| *fluid.acting(slot as usize));
        if self.which == Half::Second
            && let Some((fluid, slot)) = self.fluid.zip(slot)
        {
            let predicted = match frozen {
                true => (*body.velocity, *body.momentum),
                false => {
                    let after = self.half.after(&Push::of(load, acting.as_ref()), &body, force, torque);
                    (after.velocity, after.momentum)
                }
            };
            acting = Some(self.act(fluid, slot, row, &predicted));
        }
        if frozen {
            let outcome =
                Outcome { acting: acting.unwrap_or_default(), mean_velocity: *body.velocity, change: Vec3::zeros() };
            return (outcome, 0.0);
        }
        let push = Push::of(load, acting.as_ref());
        let after = self.half.after(&push, &body, force, torque);
        let work = self.half.add_to(&push, &after, &body, (force, torque));
        let change = after.velocity - body.velocity;
        (Outcome { acting: acting.unwrap_or_default(), mean_velocity: after.mean_velocity, change }, work)
    }

    /// Of the fluid on a particle with a predicted velocity and angular momentum.
    fn act(&self, fluid: &Fluid, slot: u32, row: usize, (velocity, momentum): &(Vec3, Vec3)) -> Acting {
        let particles = self.particles;
        let rotation = &particles.rotation[row];
        let body = Body {
            shape: particles.shape[row],
            scale: particles.scale[row],
            rotation,
            velocity: *velocity,
            angular_velocity: rotation * rotation.tr_mul(momentum).component_div(&particles.inertia[row]),
        };
        fluid.act(slot as usize, &body, self.half.gravity, self.time_s)
    }
}

impl Engine {
    /// Before the first half kick: makes the kick lead where what pushes at the start of the step leads.
    pub(crate) fn load_first_half(&mut self) {
        let time_s = self.clock.time_s();
        if self.loads.as_ref().is_some_and(|loads| loads.are_over(time_s)) {
            self.set_no_loads();
        }
        self.look_at_fluid_if_due();
        self.load_half(Half::First, time_s);
    }

    /// After the drift: gives the force columns back, and the contact laws the velocities that the pushes lead to.
    pub(crate) fn unload_first_half(&mut self) {
        if self.loads.is_none() && self.fluid.is_none() {
            return;
        }
        self.unload();
        let time_s = self.clock.time_s();
        let half = HalfStep { gravity: &self.gravity, h: 0.5 * self.clock.time_step_s() };
        let (external, loads, fluid) = (&self.external, self.loads.as_ref(), self.fluid.as_ref());
        let Particles { velocity, angular_momentum, rotation, inertia, mass, force, torque, motion, frozen, .. } =
            &mut self.particles;
        let n = external.kept.len();
        motion[..n].par_iter_mut().enumerate().with_min_len(least(n, CHUNK, 40)).for_each(|(row, motion)| {
            let load = loads.filter(|_| external.load[row] != NONE);
            if (load.is_none() && fluid.is_none()) || frozen.get(row).is_some_and(|frozen| *frozen) {
                return;
            }
            let acting = fluid.map(|fluid| fluid.acting(external.slot[row] as usize));
            let push = Push::of(load.map(|loads| (loads, external.load[row] as usize, time_s)), acting);
            let columns = Row {
                velocity: &velocity[row],
                momentum: &angular_momentum[row],
                rotation: &rotation[row],
                inertia: &inertia[row],
                mass: mass[row],
            };
            let after = half.after(&push, &columns, &force[row], &torque[row]);
            motion.velocity = after.velocity;
            if push.turns() {
                let rate = rotation[row].tr_mul(&after.momentum).component_div(&inertia[row]);
                motion.angular_velocity = rotation[row] * rate;
            }
        });
    }

    /// Before the second half kick: the same with what pushes at the end of the step.
    pub(crate) fn load_second_half(&mut self) {
        self.load_half(Half::Second, self.clock.time_after_s(1));
        if let Some(fluid) = &mut self.fluid {
            fluid.count_step();
        }
    }

    /// Gives the force columns back.
    pub(crate) fn unload(&mut self) {
        if self.loads.is_none() && self.fluid.is_none() {
            return;
        }
        let Particles { force, torque, .. } = &mut self.particles;
        for (row, kept) in self.external.kept.iter().enumerate() {
            if self.external.load[row] != NONE || self.fluid.is_some() {
                [force[row], torque[row]] = *kept;
            }
        }
    }

    /// Adds to each pushed row's force what makes a plain half kick end where the pushes lead, and books their work.
    fn load_half(&mut self, which: Half, time_s: f64) {
        if self.loads.is_none() && self.fluid.is_none() {
            return;
        }
        let (loads, mut fluid) = (self.loads.take(), self.fluid.take());
        let mut external = std::mem::take(&mut self.external);
        let made_at = (self.neighbours.rebuilds, self.external_changes);
        external.find(&self.particles, loads.as_ref(), fluid.as_ref(), made_at);
        let h = 0.5 * self.clock.time_step_s();
        let n = self.particles.n_owned();
        let Particles {
            velocity, angular_momentum, rotation, inertia, mass, force, torque, shape, scale, frozen, ..
        } = &mut self.particles;
        let columns = Columns { velocity, momentum: angular_momentum, rotation, inertia, mass, shape, scale, frozen };
        let reads = Reads {
            half: HalfStep { gravity: &self.gravity, h },
            which,
            loads: loads.as_ref(),
            fluid: fluid.as_ref(),
            particles: &columns,
            time_s,
        };
        let ExternalRows { load, slot, kept, outcome, .. } = &mut external;
        // without a fluid there are no outcomes to write
        outcome.resize(n * usize::from(fluid.is_some()), Outcome::default());
        let mut outcomes: Vec<&mut [Outcome]> = outcome.chunks_mut(CHUNK).collect();
        outcomes.resize_with(n.div_ceil(CHUNK), Default::default);
        let found: Vec<(f64, f64)> = (
            load.par_chunks(CHUNK),
            kept.par_chunks_mut(CHUNK),
            outcomes.par_iter_mut(),
            force.par_chunks_mut(CHUNK),
            torque.par_chunks_mut(CHUNK),
        )
            .into_par_iter()
            .enumerate()
            .with_min_len(least(n, CHUNK, if reads.fluid.is_some() { 200 } else { 40 }).div_ceil(CHUNK))
            .map(|(chunk, (load, kept, outcome, force, torque))| {
                let (mut work, mut fastest) = (0.0, 0.0_f64);
                for (k, &load) in load.iter().enumerate() {
                    let row = chunk * CHUNK + k;
                    let slot = reads.fluid.map(|_| slot[row]);
                    if load == NONE && slot.is_none() {
                        continue;
                    }
                    kept[k] = [force[k], torque[k]];
                    let (done, more) = reads.push_row(row, load, slot, (&mut force[k], &mut torque[k]));
                    work += more;
                    fastest = fastest.max(columns.velocity[row].norm_squared());
                    if let Some(outcome) = outcome.get_mut(k) {
                        *outcome = done;
                    }
                }
                (work, fastest)
            })
            .collect();
        self.ledger.work_loads += found.iter().map(|(work, _)| work).sum::<f64>();
        if let Some(fluid) = &mut fluid {
            let fastest = found.iter().map(|(_, squared)| *squared).fold(0.0, f64::max).sqrt();
            fluid.book(|slot| external.outcome[external.row[slot] as usize], h, fastest);
        }
        (self.loads, self.fluid, self.external) = (loads, fluid, external);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_means_of_the_decay_join_their_series() {
        for z in [1e-13, 1e-6, 9.999e-3, 1.0001e-2, 0.3, 5.0, 700.0, 1e9] {
            let mean = decay_mean(z);
            let exact = if z < 1e-4 { 1.0 - z / 2.0 + z * z / 6.0 } else { (1.0 - (-z).exp()) / z };
            assert!((mean / exact - 1.0).abs() < 1e-12, "{z}");
            // m dv = (f - K mean) h
            let (v, a) = (0.7, -2.0);
            let after = v * (-z).exp() + a * mean;
            let over = v * mean + a * decay_lag(z, mean);
            assert!((after - v - (a - z * over)).abs() < 1e-13 * (1.0 + z * over.abs()), "{z}");
        }
    }
}
