//! A solid cylinder with flat caps, as the functions of this module measure it.

use super::Cylinder;
use super::round::across;
use crate::math::{Similarity, Vec3};

/// Points of a rim at a plane.
pub(super) const QUARTERS: u32 = 4;
/// Points that a contact with another flat part may have: those of the rim, and where it crosses a side or another rim.
pub(crate) const RING_POINTS: u32 = 2 * QUARTERS;
/// Sine of the tilt below which a cap lies flat, to rounding: its deepest point could be anywhere.
const FLAT: f64 = 1e-14;

/// Middle, axis and sizes of a cylinder, with a direction across that turns with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Solid {
    pub center: Vec3,
    pub axis: Vec3,
    pub half: f64,
    pub radius: f64,
    zero: Vec3,
}

/// The rim directions that a contact offers, deepest first, counter-clockwise about the axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ring {
    /// Unit vector from the axis to the deepest point.
    pub deepest: Vec3,
    /// A quarter turn further.
    pub side: Vec3,
    /// Sine of the tilt: how much lower the deepest point is than the axis, over the radius.
    pub sine: f64,
    phase: f64,
}

impl Ring {
    /// Name of the k-th of n points: counted from the deepest one, and where the whole rim touches from the sector of the
    /// cylinder it lies in, so that springs against twisting stay with the material although the deepest point wanders.
    pub fn slot(&self, k: u32, n: u32, whole_rim: bool) -> u32 {
        if !whole_rim {
            return k;
        }
        let sector = (self.phase * f64::from(n) / std::f64::consts::TAU).round();
        (k + sector.rem_euclid(f64::from(n)) as u32) % n
    }
}

impl Solid {
    pub fn new(ends: &[Vec3; 2], radius: f64) -> Self {
        let axis = ends[1] - ends[0];
        let length = axis.norm();
        let center = (ends[0] + ends[1]) * 0.5;
        Self { center, axis: axis / length, half: 0.5 * length, radius, zero: across(&axis) }
    }

    pub fn of(cylinder: &Cylinder) -> Self {
        Self::new(&cylinder.ends, cylinder.radius)
    }

    /// The same in another frame.
    pub fn mapped(&self, to: &Similarity) -> Self {
        Self {
            center: to.point(&self.center),
            axis: to.direction(&self.axis),
            half: self.half * to.scale,
            radius: self.radius * to.scale,
            zero: to.direction(&self.zero),
        }
    }

    /// Centre of the cap that looks along the axis (`sense` 1) or against it (-1).
    pub fn cap(&self, sense: f64) -> Vec3 {
        self.center + self.axis * (sense * self.half)
    }

    /// Radius of the bounding sphere.
    pub fn reach(&self) -> f64 {
        self.half.hypot(self.radius)
    }

    /// How far the cylinder reaches from its middle along a unit vector.
    #[inline]
    pub fn reach_along(&self, n: &Vec3) -> f64 {
        self.half * n.dot(&self.axis).abs() + self.radius * n.cross(&self.axis).norm()
    }

    /// A point of the cylinder that is farthest along a unit vector.
    pub fn support(&self, n: &Vec3) -> Vec3 {
        self.cap(1.0_f64.copysign(n.dot(&self.axis))) + self.ring(n).deepest * self.radius
    }

    /// Points of the rims in the order in which they lie along a unit vector.
    pub fn ring(&self, towards: &Vec3) -> Ring {
        // across the axis by two products: next to the axis the difference of two would be rounding
        let tilt = self.axis.cross(&towards.cross(&self.axis));
        let sine = tilt.norm();
        let (deepest, sine) = if sine > FLAT { (tilt / sine, sine) } else { (self.zero, 0.0) };
        let third = self.axis.cross(&self.zero);
        let phase = third.dot(&deepest).atan2(self.zero.dot(&deepest));
        Ring { deepest, side: self.axis.cross(&deepest), sine, phase }
    }

    /// Unit vector across the axis towards a point; a fixed one on the axis.
    pub fn outwards(&self, x: &Vec3) -> Vec3 {
        let d = x - self.center;
        (d - self.axis * d.dot(&self.axis)).try_normalize(0.0).unwrap_or(self.zero)
    }

    /// Signed distance of a point from the surface and the outward direction to it; on the axis a fixed one across.
    pub fn distance(&self, x: &Vec3) -> (f64, Vec3) {
        let d = x - self.center;
        let along = d.dot(&self.axis);
        let radial = d - self.axis * along;
        let rho = radial.norm();
        let outwards = if rho > 0.0 { radial / rho } else { self.zero };
        let (beyond, beside) = (along.abs() - self.half, rho - self.radius);
        let cap = self.axis * 1.0_f64.copysign(along);
        if beyond > 0.0 && beside > 0.0 {
            let distance = beyond.hypot(beside);
            return (distance, (cap * beyond + outwards * beside) / distance);
        }
        if beyond > beside { (beyond, cap) } else { (beside, outwards) }
    }
}
