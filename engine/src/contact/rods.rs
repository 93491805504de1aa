//! Contacts of spherocylinders that are bodies of their own, and of spheres with them: in world axes straight from the columns,
//! without frames. Pairs with a gap are asked again when the way travelled since could have closed it.

use super::find::{FindInputs, quiet_until};
use super::law::share_stiffness;
use super::table::{Contact, Slot};
use crate::math::Vec3;
use crate::narrow::{Manifold, SegmentPair, round_rods};

/// What the slots of rods need in one chunk.
#[derive(Clone, Debug, Default)]
pub struct RodChunk {
    /// By slot: while the odometers of its particles add up to less, nothing touches.
    quiet_until: Vec<f64>,
}

impl RodChunk {
    /// Empties it for `slots` new slots.
    pub fn reset(&mut self, slots: usize) {
        self.quiet_until.clear();
        self.quiet_until.resize(slots, f64::NEG_INFINITY);
    }

    /// Makes every pair be asked again.
    pub fn forget(&mut self) {
        self.quiet_until.fill(f64::NEG_INFINITY);
    }

    /// Appends the contacts of two rods.
    #[inline]
    pub fn find_pair(
        &mut self,
        index: u32,
        slot: &Slot,
        inputs: &FindInputs<'_>,
        (manifold, contacts): (&mut Manifold, &mut Vec<Contact>),
    ) {
        let particles = inputs.particles;
        let (a, b) = (slot.a as usize, slot.b as usize);
        let travelled = particles.odometer[a] + particles.odometer[b];
        if travelled < self.quiet_until[index as usize] {
            return;
        }
        let (half_a, radius_a) = inputs.rod(a);
        let (half_b, radius_b) = inputs.rod(b);
        let d = particles.separation(a, b);
        let axes = SegmentPair::new(&[-half_a, half_a], &[d - half_b, d + half_b]);
        manifold.clear();
        let gap = round_rods(&axes, (radius_a, radius_b), manifold);
        if gap > 0.0 {
            self.quiet_until[index as usize] = quiet_until(travelled, gap, particles.radius[a] + particles.radius[b]);
            return;
        }
        share_stiffness(manifold.points_mut(), inputs.sharing);
        contacts.extend(manifold.points().iter().map(|point| Contact {
            slot: index,
            feature: point.feature,
            weight: point.share,
            overlap: point.overlap,
            arm: point.position,
            normal: point.normal,
            spring: Vec3::zeros(),
        }));
    }
}

impl FindInputs<'_> {
    /// Half the axis of a rod, world axes, and its radius, m.
    #[inline(always)]
    fn rod(&self, row: usize) -> (Vec3, f64) {
        let particles = self.particles;
        let scale = particles.scale[row];
        // Only rows of such shapes have these slots.
        let (half, radius) = self.reaches[particles.shape[row] as usize].rod.unwrap_or_default();
        (particles.rotation[row] * (half * scale), radius * scale)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::math::{Quat, Similarity};
    use crate::narrow::{Spherocylinder, spherocylinder_spherocylinder};

    prop_compose! {
        fn rod()(axis in prop::array::uniform3(-1.0..1.0f64), length in prop_oneof![Just(0.0), 0.1..4.0f64], radius in 0.1..1.0f64)
            -> (Vec3, f64) {
            (Vec3::from(axis).try_normalize(1e-3).unwrap_or_else(Vec3::z) * (0.5 * length), radius)
        }
    }

    /// The gap is one, and the points are those that the frame of a rod gives.
    fn check(a: (Vec3, f64), b: (Vec3, f64), d: Vec3) -> Result<(), TestCaseError> {
        let (mut here, mut there) = (Manifold::default(), Manifold::default());
        let axes = SegmentPair::new(&[-a.0, a.0], &[d - b.0, d + b.0]);
        let gap = round_rods(&axes, (a.1, b.1), &mut here);
        let turned = Similarity {
            rotation: Quat::from_euler_angles(0.3, -1.1, 2.0).to_rotation_matrix().into_inner(),
            translation: Vec3::zeros(),
            scale: 1.0,
        };
        let [half_a, half_b, apart] = [a.0, b.0, d].map(|v| turned.point(&v));
        let rod = |half: Vec3, radius: f64| Spherocylinder { ends: [-half, half], radius };
        let b_to_a = Similarity { translation: apart, ..Similarity::identity() };
        spherocylinder_spherocylinder(&rod(half_a, a.1), &rod(half_b, b.1), &b_to_a, &mut there);
        prop_assert_eq!(here.len(), there.len());
        for (p, q) in here.points().iter().zip(there.points()) {
            prop_assert_eq!(p.feature, q.feature);
            prop_assert!(
                (p.overlap - q.overlap).abs() < 1e-12 && (turned.point(&p.position) - q.position).norm() < 1e-7
            );
        }
        let (s, t) = axes.closest();
        let distance = (axes.on_p(s) - axes.on_q(t)).norm() - a.1 - b.1;
        prop_assert_eq!(here.is_empty(), gap >= 0.0);
        prop_assert!(gap <= distance.max(0.0) + 1e-12, "{} is above {}", gap, distance);
        Ok(())
    }

    proptest! {
        #[test]
        fn a_gap_is_never_too_wide(a in rod(), b in rod(), d in prop::array::uniform3(-3.0..3.0f64)) {
            check(a, b, Vec3::from(d))?;
        }

        #[test]
        fn nor_where_rods_are_nearly_parallel(
            a in rod(), length in 0.1..4.0f64, d in prop::array::uniform3(-2.0..2.0f64),
            tilt in -7.0..0.0f64, across in prop::array::uniform3(-1.0..1.0f64)
        ) {
            prop_assume!(a.0.norm() > 0.0);
            let axis = (a.0.normalize() + Vec3::from(across) * 10f64.powf(tilt)).normalize();
            check(a, (axis * (0.5 * length), 0.4), Vec3::from(d))?;
        }
    }
}
