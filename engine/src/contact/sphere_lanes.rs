//! The law of a block of touching sphere pairs, laid out for SIMD: linear spring and dashpot, Coulomb friction with
//! history, as [`normal_force`] and [`coulomb_history`](super::law::coulomb_history) give them pair by pair.
//!
//! Written without a branch, so that the compiler makes four or eight pairs of it at a time. The lanes do not mix, every
//! operation is rounded as in scalar code and nothing is contracted: the bits are the same with any vector length.

use super::law::normal_force;
use crate::math::Vec3;
use crate::scene::ContactEnd;

/// Pairs per block: all columns stay in the first-level cache.
pub const BLOCK: usize = 64;

/// Vectors as three columns.
type Columns = [[f64; BLOCK]; 3];

/// A block of touching pairs. `normal` holds b - a on entry; `force`, `twist`, `spring` and the rest are answers.
pub struct Lanes {
    /// Distance of the centres, m.
    pub distance: [f64; BLOCK],
    /// From a to b: as found, m; then of unit length.
    pub normal: Columns,
    /// m
    pub overlap: [f64; BLOCK],
    /// Velocity of a against b, m/s, without rotation: now, and over the step.
    pub velocity: Columns,
    /// See `velocity`.
    pub mean_velocity: Columns,
    /// Sum of arm times angular velocity of both, m/s: now, and over the step.
    pub turning: Columns,
    /// See `turning`.
    pub mean_turning: Columns,
    /// N/m
    pub stiffness: [f64; BLOCK],
    /// N s/m
    pub damping: [f64; BLOCK],
    /// N/m
    pub tangential_stiffness: [f64; BLOCK],
    /// N s/m
    pub tangential_damping: [f64; BLOCK],
    /// Coulomb coefficient.
    pub friction: [f64; BLOCK],
    /// Tangential spring, m.
    pub spring: Columns,
    /// On a, N.
    pub force: Columns,
    /// Normal x tangential force, N: times a side's arm, its torque.
    pub twist: Columns,
    /// J: in normal and tangential springs.
    pub elastic: [[f64; BLOCK]; 2],
    /// W: taken by normal dashpots, by tangential forces.
    pub power: [[f64; BLOCK]; 2],
}

impl Lanes {
    /// Zeros.
    pub fn new() -> Self {
        let (one, three) = ([0.0; BLOCK], [[0.0; BLOCK]; 3]);
        Self {
            distance: one,
            normal: three,
            overlap: one,
            velocity: three,
            mean_velocity: three,
            turning: three,
            mean_turning: three,
            stiffness: one,
            damping: one,
            tangential_stiffness: one,
            tangential_damping: one,
            friction: one,
            spring: three,
            force: three,
            twist: three,
            elastic: [one; 2],
            power: [one; 2],
        }
    }

    /// Forces of the first `count` pairs; `stretch_time_s` is `None` where there is no friction.
    #[inline(always)]
    pub fn evaluate(&mut self, count: usize, end: ContactEnd, stretch_time_s: Option<f64>) {
        let count = count.min(BLOCK);
        match (end, stretch_time_s) {
            (ContactEnd::Clip, None) => self.push(count, ContactEnd::Clip),
            (ContactEnd::Tension, None) => self.push(count, ContactEnd::Tension),
            (ContactEnd::Clip, Some(time_s)) => self.push_and_rub(count, ContactEnd::Clip, time_s),
            (ContactEnd::Tension, Some(time_s)) => self.push_and_rub(count, ContactEnd::Tension, time_s),
        }
    }

    #[inline(always)]
    fn push(&mut self, count: usize, end: ContactEnd) {
        for k in 0..count {
            self.push_pair(k, end);
        }
    }

    #[inline(always)]
    fn push_and_rub(&mut self, count: usize, end: ContactEnd, time_s: f64) {
        for k in 0..count {
            let (normal, approach_speed, pushing) = self.push_pair(k, end);
            self.rub_pair(k, &normal, approach_speed, (pushing, time_s));
        }
    }

    /// Normal force; returns the normal, the approach speed and the force.
    #[inline(always)]
    fn push_pair(&mut self, k: usize, end: ContactEnd) -> (Vec3, f64, f64) {
        let distance = self.distance[k];
        let d = get(&self.normal, k);
        // Coincident centres have no direction of their own: any fixed one separates them.
        let normal = select(distance > 0.0, &(d * (1.0 / distance)), &Vec3::z());
        let overlap = self.overlap[k];
        let approach_speed = get(&self.velocity, k).dot(&normal);
        let law = normal_force(self.stiffness[k], self.damping[k], overlap, approach_speed, end);
        self.elastic[0][k] = 0.5 * self.stiffness[k] * overlap * overlap;
        self.power[0][k] = law.dissipated_power;
        set(&mut self.normal, k, &normal);
        set(&mut self.force, k, &(normal * -law.force));
        (normal, approach_speed, law.force)
    }

    /// Tangential force and the spring after the step.
    #[inline(always)]
    fn rub_pair(&mut self, k: usize, normal: &Vec3, approach_speed: f64, (pushing, time_s): (f64, f64)) {
        let (stiffness, damping) = (self.tangential_stiffness[k], self.tangential_damping[k]);
        let limit = self.friction[k] * pushing.max(0.0);
        let mean = get(&self.mean_velocity, k);
        let velocity = get(&self.velocity, k) - normal * approach_speed + cross(&get(&self.turning, k), normal);
        let mean = mean - normal * mean.dot(normal) + cross(&get(&self.mean_turning, k), normal);

        let spring = get(&self.spring, k);
        let length2 = spring.norm_squared();
        let in_plane = spring - normal * spring.dot(normal);
        let in_plane2 = in_plane.norm_squared();
        let longer = (length2 / in_plane2).sqrt();
        let stretched = in_plane * if in_plane2 > 1e-30 * length2 { longer } else { 0.0 } + mean * time_s;

        let trial = -(stretched * stiffness + velocity * damping);
        let trial2 = trial.norm_squared();
        let limit2 = limit * limit;
        let sticks = trial2 <= limit2;
        let force = trial * if sticks { 1.0 } else { limit / trial2.sqrt() };
        let give = if stiffness > 0.0 { -1.0 / stiffness } else { 0.0 };
        let slid = (force + velocity * damping) * give;
        // A dashpot beyond the cone would otherwise wind the spring up against the sliding direction.
        let wound = slid.norm_squared() * stiffness * stiffness > limit2;
        let spring = select(sticks, &stretched, &select(wound, &(force * give), &slid));

        set(&mut self.spring, k, &spring);
        self.elastic[1][k] = 0.5 * stiffness * spring.norm_squared();
        self.power[1][k] = -force.dot(&velocity);
        set(&mut self.twist, k, &cross(normal, &force));
        let sum = get(&self.force, k) + force;
        set(&mut self.force, k, &sum);
    }
}

/// Element k of a vector column.
#[inline(always)]
pub fn get(columns: &Columns, k: usize) -> Vec3 {
    Vec3::new(columns[0][k], columns[1][k], columns[2][k])
}

/// Sets element k of a vector column.
#[inline(always)]
pub fn set(columns: &mut Columns, k: usize, v: &Vec3) {
    (columns[0][k], columns[1][k], columns[2][k]) = (v.x, v.y, v.z);
}

#[inline(always)]
fn select(first: bool, a: &Vec3, b: &Vec3) -> Vec3 {
    let one = |a: f64, b: f64| if first { a } else { b };
    Vec3::new(one(a.x, b.x), one(a.y, b.y), one(a.z, b.z))
}

/// nalgebra's own checks shapes at run time, which keeps loops from being vectorised.
#[inline(always)]
fn cross(a: &Vec3, b: &Vec3) -> Vec3 {
    Vec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::law::coulomb_history;

    /// Sticking, sliding, spring-free and coincident pairs, each as the scalar laws give it.
    #[test]
    fn lanes_are_the_scalar_laws() {
        let mut lanes = Lanes::new();
        let mut seed = 1u64;
        let mut draw = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut vector = |size: f64| Vec3::new(draw(), draw(), draw()) * size;
        let time_s = 1e-3;
        for k in 0..BLOCK {
            let d = if k == 5 { Vec3::zeros() } else { vector(1.0) };
            set(&mut lanes.normal, k, &d);
            lanes.distance[k] = d.norm();
            lanes.overlap[k] = 0.01;
            for columns in [&mut lanes.velocity, &mut lanes.mean_velocity, &mut lanes.turning, &mut lanes.mean_turning]
            {
                set(columns, k, &vector(1.0));
            }
            set(&mut lanes.spring, k, &vector(if k % 4 == 0 { 0.0 } else { 1e-2 }));
            lanes.stiffness[k] = 100.0;
            lanes.damping[k] = 0.1;
            lanes.tangential_stiffness[k] = if k % 9 == 0 { 0.0 } else { 70.0 };
            lanes.tangential_damping[k] = if k % 5 == 0 { 3.0 } else { 0.05 };
            lanes.friction[k] = [0.0, 0.3, 3.0][k % 3];
        }
        for end in [ContactEnd::Clip, ContactEnd::Tension] {
            let mut answer = Lanes { ..clone(&lanes) };
            answer.evaluate(BLOCK, end, Some(time_s));
            let mut sliding = 0;
            for k in 0..BLOCK {
                let n = if k == 5 { Vec3::z() } else { get(&lanes.normal, k) / lanes.distance[k] };
                let tangent = |v: Vec3| v - n * v.dot(&n);
                let rate = get(&lanes.velocity, k).dot(&n);
                let push = normal_force(lanes.stiffness[k], lanes.damping[k], lanes.overlap[k], rate, end);
                let velocity = tangent(get(&lanes.velocity, k)) + get(&lanes.turning, k).cross(&n);
                let mean = tangent(get(&lanes.mean_velocity, k)) + get(&lanes.mean_turning, k).cross(&n);
                let limit = lanes.friction[k] * push.force.max(0.0);
                let coefficients = [lanes.tangential_stiffness[k], lanes.tangential_damping[k]];
                let spring = get(&lanes.spring, k);
                let friction = coulomb_history(coefficients, limit, &spring, &n, &(mean * time_s), &velocity);
                sliding += usize::from(friction.force.norm() > 0.99 * limit);
                let force = friction.force - n * push.force;
                assert!((get(&answer.force, k) - force).norm() < 1e-13, "force {k}");
                assert!((get(&answer.spring, k) - friction.spring).norm() < 1e-15, "spring {k}");
                assert!((get(&answer.twist, k) - n.cross(&friction.force)).norm() < 1e-13, "twist {k}");
                assert!((answer.power[0][k] - push.dissipated_power).abs() < 1e-13, "power {k}");
                assert!((answer.power[1][k] + friction.force.dot(&velocity)).abs() < 1e-13, "power {k}");
            }
            assert!(sliding > 10 && sliding < BLOCK - 10, "{sliding} slide");
        }
    }

    fn clone(lanes: &Lanes) -> Lanes {
        Lanes { ..*lanes }
    }
}
