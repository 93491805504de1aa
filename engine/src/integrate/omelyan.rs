//! Omelyan's revised leapfrog for rotation, in the angular momentum.
//!
//! The world angular momentum J is kicked like a linear momentum. The drift solves, in body axes and with the inertia
//! tensor I, `w = I^-1 (R^T J) + (h/2) I^-1 (I w x w)` for the angular velocity w of the middle of the step, and turns
//! the body by the Cayley map of h w. Torque-free motion keeps J and the energy to rounding, whatever the step.
//! Source: I. P. Omelyan, Phys. Rev. E 58 (1998) 1169; Descantes, Powder Technol. 401 (2022) 117295, eq. 10-11 (its
//! eq. 7 is for another frame: PHYSICS.md F1).

use crate::math::{Quat, Vec3};

/// Angular velocity of the middle of the step and whether it converged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfStep {
    /// Body axes, rad/s.
    pub angular_velocity_in_body: Vec3,
    /// False when the fixed point did not settle to the last bits.
    pub converged: bool,
}

const MOST_ITERATIONS: usize = 60;

/// Solves the implicit equation by fixed-point iteration from the explicit value.
#[inline]
pub fn middle_angular_velocity(angular_momentum_in_body: &Vec3, inertia: &Vec3, dt: f64) -> HalfStep {
    let start = angular_momentum_in_body.component_div(inertia);
    let mut w = start;
    for _ in 0..MOST_ITERATIONS {
        let gyroscopic = inertia.component_mul(&w).cross(&w).component_div(inertia);
        let next = start + gyroscopic * (0.5 * dt);
        let change2 = (next - w).norm_squared();
        w = next;
        if change2 <= 1e-30 * w.norm_squared() {
            return HalfStep { angular_velocity_in_body: w, converged: true };
        }
    }
    HalfStep { angular_velocity_in_body: w, converged: false }
}

/// Turns the orientation by the Cayley map of `dt` times the body angular velocity.
#[inline]
pub fn turned(orientation: &Quat, angular_velocity_in_body: &Vec3, dt: f64) -> Quat {
    let half = angular_velocity_in_body * (0.5 * dt);
    let turn = nalgebra::Quaternion::new(1.0, half.x, half.y, half.z);
    Quat::new_normalize(orientation.quaternion() * turn)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Body angular velocity and energy after `n` torque-free steps.
    fn spin(inertia: Vec3, w0: Vec3, dt: f64, n: usize) -> (Vec3, f64) {
        let momentum = inertia.component_mul(&w0);
        let mut q = Quat::identity();
        let mut worst = 0.0f64;
        let energy0 = 0.5 * w0.dot(&momentum);
        for _ in 0..n {
            let in_body = q.inverse_transform_vector(&momentum);
            let half = middle_angular_velocity(&in_body, &inertia, dt);
            assert!(half.converged);
            q = turned(&q, &half.angular_velocity_in_body, dt);
            let in_body = q.inverse_transform_vector(&momentum);
            let energy = 0.5 * in_body.dot(&in_body.component_div(&inertia));
            worst = worst.max((energy / energy0 - 1.0).abs());
        }
        (q.inverse_transform_vector(&momentum).component_div(&inertia), worst)
    }

    /// I9: Dzhanibekov top; reference from the Jacobi elliptic functions (PHYSICS.md I9).
    #[test]
    fn dzhanibekov_top_converges_with_order_two() {
        let reference = Vec3::new(-0.105321007988, -0.994438779049, 0.060812593881);
        let error = |n: usize| {
            let (w, _) = spin(Vec3::new(1.0, 2.0, 3.0), Vec3::new(1e-3, 1.0, 1e-3), 20.0 / n as f64, n);
            (w - reference).norm()
        };
        let (coarse, fine) = (error(2000), error(4000));
        let order = (coarse / fine).log2();
        assert!((order - 2.0).abs() < 0.05, "order {order}, errors {coarse:e} {fine:e}");
    }

    /// S15 and PHYSICS.md A.6: energy to 3e-13 even at |w| dt = 1.5.
    #[test]
    fn torque_free_energy_is_kept_at_large_steps() {
        let (_, worst) = spin(Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.6, 0.5, 0.6), 1.5, 10_000);
        assert!(worst < 1e-12, "{worst:e}");
    }
}
