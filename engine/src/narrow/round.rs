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

/// The contact of two balls, or `None` if they do not overlap; `otherwise` is the normal of coincident ones.
#[inline]
pub(crate) fn contact(
    a: &Ball,
    b: &Ball,
    otherwise: impl FnOnce() -> Vec3,
    feature: FeatureKey,
    share: f64,
) -> Option<ManifoldPoint> {
    let d = b.center - a.center;
    let (reach, squared) = (a.radius + b.radius, d.norm_squared());
    // without the root, and not closer than its rounding
    if squared > reach * reach * (1.0 + 1e-12) {
        return None;
    }
    let distance = squared.sqrt();
    let overlap = reach - distance;
    if overlap <= 0.0 {
        return None;
    }
    let normal = if distance > COINCIDENT * reach { d / distance } else { otherwise() };
    let position = a.center + normal * (a.radius - 0.5 * overlap);
    Some(ManifoldPoint { position, normal, overlap, share, feature })
}

/// Any unit vector across `d`, the same for `d` and `-d`; x for a null vector.
pub(crate) fn across(d: &Vec3) -> Vec3 {
    d.cross(&Vec3::ith(d.iamin(), 1.0))
        .try_normalize(0.0)
        .map_or_else(Vec3::x, |n| if n[n.iamax()] < 0.0 { -n } else { n })
}

/// Adds the contact of two balls if there is one.
pub(crate) fn push(a: &Ball, b: &Ball, otherwise: impl FnOnce() -> Vec3, out: &mut Manifold) {
    if let Some(point) = contact(a, b, otherwise, FeatureKey::point(0), 1.0) {
        out.push(point);
    }
}
