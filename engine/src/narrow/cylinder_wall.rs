//! A cylinder against the two analytic walls, in the frame of the wall.
//!
//! Plane: the deepest point of either rim, its opposite and the two halfway. The springs of three or more evenly spaced
//! points of a ring add up to the same force and torque whatever their phase, so this one, which follows the tilt, makes
//! them functions of height and tilt alone; and a body that rolls keeps its deepest point, as a ball does.
//! Inside of a cylinder: where the distance of a rim from the axis is largest, up to two places of each.

use super::cylinder::{QUARTERS, Solid};
use super::ellipse::{farthest, second_share};
use super::{FeatureKey, ManifoldPoint};
use crate::math::Vec3;

/// Contacts with the plane z = 0, free where z > 0.
pub(super) fn cylinder_plane(solid: &Solid, mut push: impl FnMut(ManifoldPoint)) {
    let ring = solid.ring(&-Vec3::z());
    let drop = solid.radius * ring.sine;
    let around = [(ring.deepest, -drop), (ring.side, 0.0), (-ring.deepest, drop), (-ring.side, 0.0)];
    for (rim, sense) in [(0, -1.0), (1, 1.0)] {
        let center = solid.cap(sense);
        let whole_rim = center.z + drop < 0.0;
        for (k, (outwards, rise)) in (0..).zip(&around) {
            let overlap = -(center.z + rise);
            if overlap > 0.0 {
                let on_rim = center + outwards * solid.radius;
                // its lowest point is at -overlap, the plane at 0
                let position = Vec3::new(on_rim.x, on_rim.y, -0.5 * overlap);
                let feature = FeatureKey::vertex_of_a(QUARTERS * rim + ring.slot(k, QUARTERS, whole_rim));
                push(ManifoldPoint { position, normal: -Vec3::z(), overlap, share: 1.0, feature });
            }
        }
    }
}

/// Contacts with the inside of the cylinder about z.
pub(super) fn cylinder_in_cylinder(solid: &Solid, wall_radius: f64, mut push: impl FnMut(ManifoldPoint)) {
    // e1 lies across both axes, so that the rim seen along z is an ellipse with its long axis along e1
    let ring = solid.ring(&Vec3::z());
    let (e1, e2) = (ring.side, ring.deepest);
    let flat = |x: Vec3| Vec3::new(x.x, x.y, 0.0);
    for (rim, sense) in [(0, -1.0), (1, 1.0)] {
        let center = solid.cap(sense);
        let along = [e1.dot(&flat(center)), flat(e2).dot(&flat(center))];
        let k = solid.radius * ring.sine * ring.sine;
        let (first, second) = farthest(along, k);
        let share = if second.is_some() { second_share(along, k) } else { 0.0 };
        for ((cos, sin), share) in [Some((first, 1.0)), second.map(|at| (at, share))].into_iter().flatten() {
            let x = center + (e1 * cos + e2 * sin) * solid.radius;
            let rho = x.x.hypot(x.y);
            let overlap = rho - wall_radius;
            if overlap > 0.0 && share > 0.0 {
                // on the axis all directions are equally near: x, so that the answer is finite and repeatable
                let normal = if rho > 0.0 { flat(x) / rho } else { Vec3::x() };
                let position = normal * (wall_radius + 0.5 * overlap) + Vec3::z() * x.z;
                let slot = if second.is_none() { 0 } else { 1 + u32::from(cos < 0.0) };
                let feature = FeatureKey::vertex_of_a(QUARTERS * rim + slot);
                push(ManifoldPoint { position, normal, overlap, share, feature });
            }
        }
    }
}
