//! Symmetric splitting of the free rotation into exact rotations about the principal axes.
//!
//! The kinetic energy is the sum of L_k^2 / (2 I_k). The flow of one term turns the body about its axis k by the angle
//! h L_k / I_k and keeps L_k; composed as x/2 y/2 z y/2 x/2 it is explicit, time-reversible, symplectic and of order 2.
//! At small steps its error is 3 (pinacoid) to 33 times (I = 1, 2, 3) below Omelyan's scheme; at |w| dt near 1 the energy
//! oscillates by some percent, where Omelyan's keeps it (PHYSICS.md A.6 and D). Source: Touma and Wisdom, Astron. J. 107
//! (1994) 1189; Dullweber, Leimkuhler and McLachlan, J. Chem. Phys. 107 (1997) 5840.

use crate::math::{Quat, Vec3};

/// Axis and part of the step of each stage.
const STAGES: [(usize, f64); 5] = [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)];

/// The orientation after `dt`, from the angular momentum in body axes (kg m2/s) and the principal moments (kg m2).
pub fn turned(orientation: &Quat, mut momentum_in_body: Vec3, inertia: &Vec3, dt: f64) -> Quat {
    let mut q = *orientation.quaternion();
    for (axis, part) in STAGES {
        let (sine, cosine) = (0.5 * part * dt * momentum_in_body[axis] / inertia[axis]).sin_cos();
        let mut turn = nalgebra::Quaternion::new(cosine, 0.0, 0.0, 0.0);
        turn.coords[axis] = sine;
        q *= turn;
        // The body turns one way, so its axes see the momentum turn the other way: by the double angle.
        let (s, c) = (2.0 * sine * cosine, cosine * cosine - sine * sine);
        let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
        let (y, z) = (momentum_in_body[j], momentum_in_body[k]);
        momentum_in_body[j] = c * y + s * z;
        momentum_in_body[k] = c * z - s * y;
    }
    Quat::new_normalize(q)
}

/// Mean angular velocity in world axes of the turn from `before` to `after` within `dt`, rad/s.
pub fn mean_angular_velocity(before: &Quat, after: &Quat, dt: f64) -> Vec3 {
    (after * before.inverse()).scaled_axis() / dt
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Attitude after `n` torque-free steps to t = 20, and the largest relative energy error.
    fn spin(inertia: Vec3, w0: Vec3, dt: f64, n: usize) -> (Quat, f64) {
        let momentum = inertia.component_mul(&w0);
        let energy = |q: &Quat| {
            let in_body = q.inverse_transform_vector(&momentum);
            0.5 * in_body.dot(&in_body.component_div(&inertia))
        };
        let mut q = Quat::identity();
        let start = energy(&q);
        let mut worst = 0.0f64;
        for _ in 0..n {
            q = turned(&q, q.inverse_transform_vector(&momentum), &inertia, dt);
            worst = worst.max((energy(&q) / start - 1.0).abs());
        }
        (q, worst)
    }

    /// I9: Dzhanibekov top; the reference is the Jacobi elliptic functions' (PHYSICS.md I9).
    #[test]
    fn dzhanibekov_top_converges_with_order_two() {
        let reference = Vec3::new(-0.105321007988, -0.994438779049, 0.060812593881);
        let (inertia, w0) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(1e-3, 1.0, 1e-3));
        let error = |n: usize| {
            let (q, _) = spin(inertia, w0, 20.0 / n as f64, n);
            (q.inverse_transform_vector(&inertia.component_mul(&w0)).component_div(&inertia) - reference).norm()
        };
        let (coarse, fine) = (error(2000), error(4000));
        assert!(((coarse / fine).log2() - 2.0).abs() < 0.05, "{coarse:e} {fine:e}");
    }

    /// PHYSICS.md D: 5.7e-2 at |w| dt = 1.5, against 2e-13 of Omelyan's; bounded by a fall with the square of the step.
    #[test]
    fn the_energy_error_is_bounded_and_of_order_two() {
        let inertia = Vec3::new(0.0396807, 0.0462751, 0.0522329);
        let w0 = Vec3::new(0.3, 1.0, 0.2);
        let worst = |product: f64| spin(inertia, w0, product / w0.norm(), 10_000).1;
        assert!((worst(1.5) - 5.7e-2).abs() < 5e-3, "{:e}", worst(1.5));
        let order = (worst(0.2) / worst(0.1)).log2();
        assert!((order - 2.0).abs() < 0.1, "{order}");
    }

    #[test]
    fn the_mean_angular_velocity_is_that_of_a_steady_turn() {
        let (inertia, w) = (Vec3::new(1.0, 1.0, 1.0), Vec3::new(0.3, -1.2, 0.4));
        let start = Quat::from_scaled_axis(Vec3::new(0.1, 0.2, 0.3));
        let momentum = start.inverse_transform_vector(&w);
        let error = |dt: f64| (mean_angular_velocity(&start, &turned(&start, momentum, &inertia, dt), dt) - w).norm();
        assert!(error(1e-3) < 1e-6 && error(1e-3) < 0.3 * error(2e-3), "{:e}", error(1e-3));
    }
}
