//! The contact of two balls, of which all contacts of round parts are made.

use super::{FeatureKey, Manifold, ManifoldPoint};
use crate::math::Vec3;

/// Below this distance over the radii, the direction between two centres is rounding.
const COINCIDENT: f64 = 1e-14;

/// A ball of a round part: a point of its core and its radius.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub center: Vec3,
    pub radius: f64,
}

/// Unit vector from `a` to `b`, or `otherwise` where they coincide.
pub(crate) fn direction(a: &Ball, b: &Ball, otherwise: &Vec3) -> Vec3 {
    let d = b.center - a.center;
    let distance = d.norm();
    if distance > COINCIDENT * (a.radius + b.radius) { d / distance } else { *otherwise }
}

/// The contact of two balls, or `None` if they do not overlap; `otherwise` is the normal of coincident ones.
pub(crate) fn contact(a: &Ball, b: &Ball, otherwise: &Vec3, feature: FeatureKey, share: f64) -> Option<ManifoldPoint> {
    let overlap = a.radius + b.radius - (b.center - a.center).norm();
    if overlap <= 0.0 {
        return None;
    }
    let normal = direction(a, b, otherwise);
    let position = a.center + normal * (a.radius - 0.5 * overlap);
    Some(ManifoldPoint { position, normal, overlap, share, feature })
}

/// Any unit vector across `d`, the same for `d` and `-d`; x for a null vector.
pub(crate) fn across(d: &Vec3) -> Vec3 {
    d.cross(&Vec3::ith(d.iamin(), 1.0)).try_normalize(0.0).map_or_else(Vec3::x, |n| if n[n.iamax()] < 0.0 { -n } else { n })
}

/// Adds the contact of two balls if there is one.
pub(crate) fn push(a: &Ball, b: &Ball, otherwise: &Vec3, out: &mut Manifold) {
    if let Some(point) = contact(a, b, otherwise, FeatureKey::point(0), 1.0) {
        out.push(point);
    }
}
