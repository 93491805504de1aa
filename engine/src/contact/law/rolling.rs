//! Rolling and twisting resistance: elastic-plastic spring and dashpot.

use super::tangential::carried;
use crate::math::Vec3;

/// Parameters of a pair of materials.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RollingLaw {
    /// mu_r: largest rolling torque over R f_n.
    pub rolling: f64,
    /// mu_t: largest twisting torque over R f_n.
    pub twisting: f64,
    /// eta: dashpot over the critical one.
    pub damping_ratio: f64,
}

impl RollingLaw {
    /// Whether it does anything.
    pub fn is_active(&self) -> bool {
        self.rolling > 0.0 || self.twisting > 0.0
    }
}

/// Angles stored in a contact, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RollingSpring {
    /// About axes in the tangent plane.
    pub roll: Vec3,
    /// About the normal.
    pub twist: f64,
}

/// Stiffness (N m/rad), dashpot (N m s/rad) and limit (N m) of one of the two motions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resistance {
    /// k_r = 2.25 k_n mu^2 R^2.
    pub stiffness: f64,
    /// 2 eta sqrt(I_r k_r).
    pub damping: f64,
    /// mu R f_n.
    pub limit: f64,
}

impl Resistance {
    /// Of a coefficient mu, the rolling radius R (m), normal stiffness (N/m), normal force (N), eta, and 1/I_r
    /// (1/(kg m2)).
    #[inline(always)]
    pub fn new(friction: f64, radius: f64, [stiffness, force]: [f64; 2], damping_ratio: f64, inverse: f64) -> Self {
        let arm = friction * radius;
        let stiffness = 2.25 * stiffness * arm * arm;
        Self { stiffness, damping: 2.0 * damping_ratio * (stiffness / inverse).sqrt(), limit: arm * force }
    }

    /// J
    #[inline(always)]
    pub fn energy(&self, angle2: f64) -> f64 {
        0.5 * self.stiffness * angle2
    }
}

/// Rolling torque on `a` and the spring after the step: M = -k_r theta - C_r omega below the limit, else the limit
/// along -theta without dashpot.
///
/// `turn` (rad) and `rate` (rad/s): tangential part of the rotation of `a` against `b`, over the step and now. Energy
/// k_r theta^2/2. Model C of Ai, Chen, Rotter and Ooi (2011) with their k_r = 2.25 k_n mu_r^2 R^2 (after Jiang, Yu and
/// Harris 2005) and no dashpot once mobilised; R is the radius with 1/R = 1/r_a + 1/r_b. Kept in the tangent plane.
#[inline(always)]
pub fn resist_rolling(law: &Resistance, spring: &Vec3, normal: &Vec3, [turn, rate]: [&Vec3; 2]) -> (Vec3, Vec3) {
    let angle = carried(spring, normal) + turn;
    let torque = angle * -law.stiffness;
    let size = torque.norm();
    if size <= law.limit {
        return (torque - rate * law.damping, angle);
    }
    let part = law.limit / size;
    (torque * part, angle * part)
}

/// Twisting torque about the normal and the spring after the step: the same in one dimension.
#[inline(always)]
pub fn resist_twisting(law: &Resistance, spring: f64, turn: f64, rate: f64) -> (f64, f64) {
    let angle = spring + turn;
    let torque = -law.stiffness * angle;
    if torque.abs() <= law.limit {
        return (torque - rate * law.damping, angle);
    }
    let part = law.limit / torque.abs();
    (torque * part, angle * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elastic_below_the_limit_and_constant_above() {
        let law = Resistance { stiffness: 2.0, damping: 0.5, limit: 1.0 };
        let (normal, zero) = (Vec3::z(), Vec3::zeros());
        let (torque, spring) = resist_rolling(&law, &zero, &normal, [&(Vec3::x() * 0.25), &Vec3::x()]);
        assert_eq!((torque.x, spring.x), (-1.0, 0.25));
        let (torque, spring) = resist_rolling(&law, &spring, &normal, [&(Vec3::x() * 3.0), &Vec3::x()]);
        assert_eq!((torque.x, spring.x), (-1.0, 0.5));
        assert_eq!(resist_twisting(&law, 0.0, -0.25, 0.0), (0.5, -0.25));
        assert_eq!(resist_twisting(&law, 0.0, 4.0, 1.0), (-1.0, 0.5));
    }

    /// Below the limit the torque is the negative gradient of the energy.
    #[test]
    fn torque_is_the_gradient_of_the_energy() {
        let law = Resistance { stiffness: 3.0, damping: 0.0, limit: 10.0 };
        let energy = |angle: f64| law.energy(resist_twisting(&law, angle, 0.0, 0.0).1.powi(2));
        let slope = (energy(0.3 + 1e-5) - energy(0.3 - 1e-5)) / 2e-5;
        assert!((resist_twisting(&law, 0.3, 0.0, 0.0).0 + slope).abs() < 1e-9);
    }
}
