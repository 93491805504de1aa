//! Local non-viscous damping of the unbalanced force.

use rayon::prelude::*;

use crate::math::Vec3;
use crate::particles::Particles;

/// Rows per sum; never a function of the thread count.
const CHUNK: usize = 512;

/// What the damping did in one evaluation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LocalDamping {
    /// Taken from the motion, W.
    pub power: f64,
    /// Sum of the damping forces on all particles, N.
    pub force: Vec3,
}

/// F_d = -alpha |F| sign(v), component by component, for force (with weight) and velocity, and for torque and angular
/// velocity, in world axes; alpha in [0, 1). Adds it to the forces of every owned row that is not frozen.
///
/// Damps acceleration only: steady motion under balanced forces is left alone, and all frequencies decay alike: an
/// oscillator keeps (1 - alpha)/(1 + alpha) of its energy per half period. Acts on free flight too (a falling particle feels (1 - alpha) g), and depends on the axes: for quasi-static
/// work. The power alpha |F| |v| is booked as dissipation. Source: Potyondy and Cundall (2004), eq. 16.
pub fn damp_locally(particles: &mut Particles, gravity: &Vec3, alpha: f64) -> LocalDamping {
    let n = particles.n_owned();
    let Particles { force, torque, mass, motion, frozen, .. } = particles;
    let (mass, motion, frozen) = (&*mass, &*motion, &*frozen);
    let parts: Vec<LocalDamping> = (force[..n].par_chunks_mut(CHUNK), torque[..n].par_chunks_mut(CHUNK))
        .into_par_iter()
        .enumerate()
        .map(|(k, (forces, torques))| {
            let mut sum = LocalDamping::default();
            for (offset, (force, torque)) in forces.iter_mut().zip(torques).enumerate() {
                let row = k * CHUNK + offset;
                if !frozen.is_empty() && frozen[row] {
                    continue;
                }
                let push = against(&(*force + gravity * mass[row]), &motion[row].velocity, alpha);
                let turn = against(torque, &motion[row].angular_velocity, alpha);
                *force += push;
                *torque += turn;
                sum.power -= push.dot(&motion[row].velocity) + turn.dot(&motion[row].angular_velocity);
                sum.force += push;
            }
            sum
        })
        .collect();
    parts.iter().fold(LocalDamping::default(), |sum, part| LocalDamping {
        power: sum.power + part.power,
        force: sum.force + part.force,
    })
}

/// -alpha |load| sign(rate) by component; 0 where the rate is 0.
#[inline(always)]
fn against(load: &Vec3, rate: &Vec3, alpha: f64) -> Vec3 {
    load.zip_map(rate, |load, rate| if rate == 0.0 { 0.0 } else { -alpha * load.abs() * rate.signum() })
}
