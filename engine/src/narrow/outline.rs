//! The outline of a cylinder seen along a direction: its rims are ellipses there, and an edge along the direction a point.

use super::cylinder::Solid;
use super::ellipse::nearest;
use crate::math::Vec3;

/// Where a rim is nearest to a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct RimFoot {
    /// Unit normal of the outline, out of the cylinder and across the line.
    pub outwards: Vec3,
    /// Point of the rim.
    pub on_rim: Vec3,
}

/// Axes of the outline.
pub(super) struct Outline<'s> {
    solid: &'s Solid,
    /// Along the long axis of the ellipses, unit.
    long: Vec3,
    /// Across it and the direction, to the side that the axis points to, unit.
    short: Vec3,
    /// Half axis along `short`.
    narrow: f64,
    /// In the plane of the rim, seen along `short`.
    rising: Vec3,
}

impl<'s> Outline<'s> {
    /// Seen along a unit vector.
    pub fn new(solid: &'s Solid, direction: &Vec3) -> Self {
        let cross = direction.cross(&solid.axis);
        let sine = cross.norm();
        // along the axis the ellipses are circles, and any axes serve
        let long = if sine > 1e-14 { cross / sine } else { solid.ring(&solid.axis).side };
        let cosine = direction.dot(&solid.axis);
        let rising = solid.axis.cross(&long) * -1.0_f64.copysign(cosine);
        Self { solid, long, short: long.cross(direction), narrow: solid.radius * cosine.abs().min(1.0), rising }
    }

    /// Whether the line through `x` lies deeper below the rim of a cap than `depth`, for sure.
    pub fn is_deeper(&self, sense: f64, x: &Vec3, depth: f64) -> bool {
        let d = x - self.solid.cap(sense);
        let (across, up) = (self.long.dot(&d), sense * self.short.dot(&d));
        // below the centre only the half of the ellipse above it counts; within, smaller ellipses of the same shape
        (up < 0.0 && -up > depth)
            || (self.narrow > 0.0 && (1.0 - (across / self.solid.radius).hypot(up / self.narrow)) * self.narrow > depth)
    }

    /// Where the rim of a cap is nearest to the line through `x`: every local minimum.
    pub fn feet(&self, sense: f64, x: &Vec3, mut visit: impl FnMut(RimFoot)) {
        let (radius, cap) = (self.solid.radius, self.solid.cap(sense));
        let d = x - cap;
        let at = [self.long.dot(&d), self.short.dot(&d)];
        let (first, second) = nearest([radius, self.narrow], at);
        for (cos, sin) in [Some(first), second].into_iter().flatten() {
            let on_rim = cap + (self.long * cos + self.rising * sin) * radius;
            let normal = self.long * (self.narrow * cos) + self.short * (radius * sin);
            let length = normal.norm();
            let outwards = if length > 0.0 { normal / length } else { self.long * 1.0_f64.copysign(cos) };
            visit(RimFoot { outwards, on_rim });
            // at the sharp ends of a flat ellipse the normal is any, and that towards the line the right one
            let beside = self.long * (at[0] - radius * cos) + self.short * (at[1] - self.narrow * sin);
            let distance = beside.norm();
            if distance > 0.0 && beside.dot(&outwards) >= 0.0 {
                visit(RimFoot { outwards: beside / distance, on_rim });
            }
        }
    }
}
