//! Half kick, drift, and the second half kick, over chunks of rows.

use rayon::prelude::*;

use super::{omelyan, splitting};
use crate::math::{Quat, Vec3};
use crate::parallel::least;
use crate::particles::{ContactMotion, Particles};
use crate::scene::RotationScheme;

/// Rows per task: small enough to balance, large enough to amortise; never a function of the thread count.
const CHUNK: usize = 512;

/// What the odometer adds for rounding.
const ROUNDING: f64 = 1e-9;

/// Troubles met in a drift.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriftReport {
    /// Rows whose rotation did not converge.
    pub not_converged: u64,
    /// Square of the largest displacement over the bounding radius.
    pub largest_displacement_squared: f64,
    /// Lowest row that moved by more than its half-thickness, and by how many of them.
    pub too_fast: Option<(usize, f64)>,
}

impl DriftReport {
    /// Of one row: displacement of its centre over the bounding radius; bound on the path of its points, m.
    #[inline(always)]
    fn of_row(row: usize, converged: bool, relative_displacement: &Vec3, (path, half_thickness): (f64, f64)) -> Self {
        Self {
            not_converged: u64::from(!converged),
            largest_displacement_squared: relative_displacement.norm_squared(),
            too_fast: (path > half_thickness).then(|| (row, path / half_thickness)),
        }
    }

    fn merged(self, other: Self) -> Self {
        Self {
            not_converged: self.not_converged + other.not_converged,
            largest_displacement_squared: self.largest_displacement_squared.max(other.largest_displacement_squared),
            too_fast: match (self.too_fast, other.too_fast) {
                (Some(a), Some(b)) => Some(if a.0 <= b.0 { a } else { b }),
                (a, b) => a.or(b),
            },
        }
    }
}

/// A turn over one step.
struct Turn {
    orientation: Quat,
    /// World axes, rad/s.
    mean_angular_velocity: Vec3,
    converged: bool,
}

/// Turns a body with the angular momentum (world axes) of the middle of the step.
#[inline(always)]
fn turn(scheme: RotationScheme, orientation: &Quat, momentum_in_body: &Vec3, inertia: &Vec3, dt: f64) -> Turn {
    match scheme {
        RotationScheme::Omelyan => {
            let middle = omelyan::middle_angular_velocity(momentum_in_body, inertia, dt);
            let after = omelyan::turned(orientation, &middle.angular_velocity_in_body, dt);
            Turn {
                orientation: after,
                // The Cayley map leaves its own axis alone, so the new rotation may carry it to world axes.
                mean_angular_velocity: after.to_rotation_matrix().into_inner() * middle.angular_velocity_in_body,
                converged: middle.converged,
            }
        }
        RotationScheme::Splitting => {
            let after = splitting::turned(orientation, *momentum_in_body, inertia, dt);
            let mean_angular_velocity = splitting::mean_angular_velocity(orientation, &after, dt);
            Turn { orientation: after, mean_angular_velocity, converged: true }
        }
    }
}

/// v and J to the middle of the step, x and the orientation to its end; predicts the velocities there. Frozen rows go on
/// with their velocity.
///
/// By shape: whether orientations are integrated, and the half-thickness at unit scale, m.
pub fn drift(
    particles: &mut Particles,
    gravity: &Vec3,
    dt: f64,
    shapes: (RotationScheme, &[bool], &[f64]),
) -> DriftReport {
    if particles.frozen.is_empty() {
        drift_rows::<false>(particles, gravity, dt, shapes)
    } else {
        drift_rows::<true>(particles, gravity, dt, shapes)
    }
}

/// Compiled without a word of frozen rows where there are none.
fn drift_rows<const FROZEN: bool>(
    particles: &mut Particles,
    gravity: &Vec3,
    dt: f64,
    (scheme, rotates, half_thickness): (RotationScheme, &[bool], &[f64]),
) -> DriftReport {
    let n = particles.n_owned();
    let Particles {
        position,
        velocity,
        orientation,
        angular_momentum,
        force,
        torque,
        shape,
        scale,
        radius,
        mass,
        inertia,
        rotation,
        motion,
        odometer,
        frozen,
        ..
    } = particles;
    let rows = (
        position[..n].par_iter_mut(),
        velocity[..n].par_iter_mut(),
        orientation[..n].par_iter_mut(),
        angular_momentum[..n].par_iter_mut(),
        rotation[..n].par_iter_mut(),
        motion[..n].par_iter_mut(),
        odometer[..n].par_iter_mut(),
    );
    let half = 0.5 * dt;
    rows.into_par_iter()
        .enumerate()
        .with_min_len(least(n, CHUNK, 15))
        .map(|(row, (x, v, q, momentum, rotation, motion, odometer))| {
            let shape = shape[row] as usize;
            let size = (radius[row], half_thickness[shape] * scale[row]);
            if FROZEN && frozen[row] {
                *x += *v * dt;
                *motion = ContactMotion { velocity: *v, mean_velocity: *v, ..ContactMotion::default() };
                return report(row, true, motion, odometer, (dt, 0.0, size));
            }
            // One division where `/` on vectors makes three.
            let acceleration = force[row] * (1.0 / mass[row]) + gravity;
            *v += acceleration * half;
            *x += *v * dt;
            motion.mean_velocity = *v;
            motion.velocity = *v + acceleration * half;
            *momentum += torque[row] * half;
            let predicted = *momentum + torque[row] * half;
            let inertia = &inertia[row];
            if !rotates[shape] {
                motion.spin([momentum, &predicted], 1.0 / inertia.x);
                return report(row, true, motion, odometer, (dt, 0.0, size));
            }
            let turn = turn(scheme, q, &rotation.tr_mul(momentum), inertia, dt);
            *q = turn.orientation;
            *rotation = q.to_rotation_matrix().into_inner();
            motion.mean_angular_velocity = turn.mean_angular_velocity;
            motion.angular_velocity = *rotation * rotation.tr_mul(&predicted).component_div(inertia);
            report(row, turn.converged, motion, odometer, (dt, radius[row], size))
        })
        .reduce(DriftReport::default, DriftReport::merged)
}

/// Adds a row's path to its odometer; `lever` is how far from the centre rotation moves points, `size` (bounding radius,
/// half-thickness), m.
#[inline(always)]
fn report(
    row: usize,
    converged: bool,
    motion: &ContactMotion,
    odometer: &mut f64,
    (dt, lever, size): (f64, f64, (f64, f64)),
) -> DriftReport {
    let path = path_m(motion, dt, lever);
    *odometer += path;
    let displacement = motion.mean_velocity * (dt / size.0);
    DriftReport::of_row(row, converged, &displacement, (path, size.1))
}

/// Bound on how far a step moves the points within `lever` of the centre, m.
fn path_m(motion: &ContactMotion, dt: f64, lever: f64) -> f64 {
    // the Cayley map turns by 2 atan(|w| dt / 2), less than |w| dt
    let speed = motion.mean_velocity.norm() + motion.mean_angular_velocity.norm() * lever;
    speed * dt * (1.0 + ROUNDING)
}

/// v and J from the middle of the step to its end, with the forces there. Returns the first row that is not finite.
pub fn kick(particles: &mut Particles, gravity: &Vec3, dt: f64) -> Option<usize> {
    let n = particles.n_owned();
    let Particles { position, velocity, angular_momentum, force, torque, mass, frozen, .. } = particles;
    let (position, force, torque, mass, frozen) = (&*position, &*force, &*torque, &*mass, &*frozen);
    let half = 0.5 * dt;
    (velocity[..n].par_iter_mut(), angular_momentum[..n].par_iter_mut())
        .into_par_iter()
        .enumerate()
        .with_min_len(least(n, CHUNK, 8))
        .filter_map(|(row, (v, momentum))| {
            if frozen.is_empty() || !frozen[row] {
                *v += (force[row] * (1.0 / mass[row]) + gravity) * half;
                *momentum += torque[row] * half;
            }
            // One sum is finite only if every term is (or overflows, which is as bad).
            let sum = v.sum() + momentum.sum() + position[row].sum();
            if sum.is_finite() { None } else { Some(row) }
        })
        .min()
}

impl ContactMotion {
    /// Of a sphere, from its angular momenta in the middle and predicted at the end of a step.
    #[inline(always)]
    fn spin(&mut self, [momentum, predicted]: [&Vec3; 2], mobility: f64) {
        self.mean_angular_velocity = *momentum * mobility;
        self.angular_velocity = *predicted * mobility;
    }

    /// Motion of a point at `arm` from the centre: (velocity at the full step, mean velocity over the step).
    #[inline(always)]
    pub fn at(&self, arm: &Vec3) -> (Vec3, Vec3) {
        (self.velocity + self.angular_velocity.cross(arm), self.mean_velocity + self.mean_angular_velocity.cross(arm))
    }
}
