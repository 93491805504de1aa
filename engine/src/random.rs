//! Random numbers as a function of (seed, id, purpose): no stream that the order of events could shift.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use crate::math::{Quat, Vec3};

/// What a number is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Homothety of an inserted particle.
    Scale,
    /// Its orientation.
    Orientation,
    /// Its place.
    Position,
}

/// Generator for one purpose of one particle.
pub struct Draw(Xoshiro256PlusPlus);

impl Draw {
    /// The generator that (seed, id, purpose) name.
    pub fn new(seed: u64, id: u64, purpose: Purpose) -> Self {
        let mut words = [0u8; 24];
        words[..8].copy_from_slice(&seed.to_le_bytes());
        words[8..16].copy_from_slice(&id.to_le_bytes());
        words[16] = purpose as u8;
        Self(Xoshiro256PlusPlus::seed_from_u64(xxhash_rust::xxh3::xxh3_64(&words)))
    }

    /// Uniform in [0, 1), 53 bits.
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform over rotations (Shoemake 1992).
    pub fn orientation(&mut self) -> Quat {
        let (u, v, w) = (self.unit(), self.unit() * std::f64::consts::TAU, self.unit() * std::f64::consts::TAU);
        let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
        Quat::new_normalize(nalgebra::Quaternion::new(b * w.cos(), a * v.sin(), a * v.cos(), b * w.sin()))
    }

    /// Uniform in a box.
    pub fn in_box(&mut self, min: &Vec3, max: &Vec3) -> Vec3 {
        Vec3::from_fn(|axis, _| self.between(min[axis], max[axis]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of R over uniform rotations is 0, and of each squared entry 1/3; 4 standard errors of 20,000 draws.
    #[test]
    fn orientations_are_uniform() {
        let n = 20_000;
        let (mut mean, mut square) = (crate::math::Mat3::zeros(), crate::math::Mat3::zeros());
        for id in 0..n {
            let r = Draw::new(7, id, Purpose::Orientation).orientation().to_rotation_matrix().into_inner();
            mean += r;
            square += r.component_mul(&r);
        }
        let n = n as f64;
        assert!((mean / n).abs().max() < 4.0 * (1.0 / 3.0f64 / n).sqrt());
        assert!((square / n).add_scalar(-1.0 / 3.0).abs().max() < 4.0 * (4.0 / 45.0f64 / n).sqrt());
    }
}
