//! Two spherocylinders: the closest points of their axes, and both ends of the stretch where they lie side by side.
//!
//! Every point is the contact of two balls of the two axes. The shares fade the closest point out as the axes become
//! parallel, where its place is undefined, and fade the ends out as they lift off, so the share-weighted force is
//! continuous in the pose.

use super::round::{Ball, across, contact};
use super::segments::SegmentPair;
use super::{FeatureKey, Manifold, ManifoldPoint, Spherocylinder};
use crate::math::{Similarity, Vec3};

/// Shares below this, over the length side by side, are rounding of parallel axes.
const FADED: f64 = 1e-9;
/// Sine of the angle between the axes at which the ends cease to count: 30 degrees. Across, "side by side" has no sense.
const WIDEST: f64 = 0.5;

/// At most three points.
pub fn spherocylinder_spherocylinder(a: &Spherocylinder, b: &Spherocylinder, b_to_a: &Similarity, out: &mut Manifold) {
    let q = b.ends.map(|e| b_to_a.point(&e));
    round_rods(&SegmentPair::new(&a.ends, &q), (a.radius, b.radius * b_to_a.scale), out);
}

/// At most three points of two rods about these axes, either of which may be a ball; returns how far they are at least
/// apart where they do not touch, and 0 or less where they may.
#[inline]
pub(crate) fn round_rods(axes: &SegmentPair, radii: (f64, f64), out: &mut Manifold) -> f64 {
    let reach = radii.0 + radii.1;
    if axes.lines_are_apart(reach) {
        return axes.distance_of_lines() - reach;
    }
    let (s, t) = axes.closest();
    let balls = |x: Vec3, y: Vec3| (Ball { center: x, radius: radii.0 }, Ball { center: y, radius: radii.1 });
    let (ball_a, ball_b) = balls(axes.on_p(s), axes.on_q(t));
    let Some(mut deepest) = contact(&ball_a, &ball_b, || crossing_normal(axes), FeatureKey::point(0), 1.0) else {
        return (ball_b.center - ball_a.center).norm() - reach;
    };
    let fade = fade(axes.squared_sine());
    let beside = if fade > 0.0 { side_by_side(axes) } else { None };
    let Some((ends, length)) = beside else {
        out.push(deepest);
        return -deepest.overlap;
    };
    let ends = ends.map(|end| {
        let (ball_a, ball_b) = balls(end.on_a, end.on_b);
        contact(&ball_a, &ball_b, || deepest.normal, end.feature, 0.0)
    });
    push_shared(&mut deepest, ends, fade, length, out);
    -deepest.overlap
}

/// 1 for parallel axes, fading to 0 at the widest angle.
pub(super) fn parallelism(p: &[Vec3; 2], q: &[Vec3; 2]) -> f64 {
    fade(SegmentPair::new(p, q).squared_sine())
}

fn fade(squared_sine: f64) -> f64 {
    (1.0 - squared_sine / (WIDEST * WIDEST)).max(0.0)
}

/// Shares `length` among the deepest point and the two ends, and adds those that carry. `fade` scales what the ends get.
pub(super) fn push_shared(
    deepest: &mut ManifoldPoint,
    ends: [Option<ManifoldPoint>; 2],
    fade: f64,
    length: f64,
    out: &mut Manifold,
) {
    let largest = ends.iter().flatten().map(|p| p.overlap).fold(0.0, f64::max);
    deepest.share = length * (1.0 - fade * largest / deepest.overlap);
    if deepest.share > FADED * length {
        out.push(*deepest);
    }
    for mut p in ends.into_iter().flatten().filter(|_| fade > 0.0) {
        p.share = 0.5 * length * fade * p.overlap / deepest.overlap;
        out.push(p);
    }
}

/// The normal of axes that meet: across both, or across one if they are parallel.
fn crossing_normal(axes: &SegmentPair) -> Vec3 {
    if axes.squared_sine() > 1e-18 {
        return axes.n.normalize();
    }
    across(if axes.uu > 0.0 { &axes.u } else { &axes.v })
}

struct End {
    along: f64,
    on_a: Vec3,
    on_b: Vec3,
    feature: FeatureKey,
}

/// First and last end of either segment that lies beside the other one, and the length between them.
fn side_by_side(axes: &SegmentPair) -> Option<([End; 2], f64)> {
    let least = axes.uu.min(axes.vv);
    if least == 0.0 {
        return None;
    }
    // the bisector: the stretch must not depend on which of the two is called a
    let axis = axes.u * axes.vv.sqrt() + axes.v * axes.uu.sqrt().copysign(axes.uv);
    let middle = axes.p + axes.q + (axes.u + axes.v) * 0.5;
    let (mut first, mut last): (Option<End>, Option<End>) = (None, None);
    let mut offer = |s: f64, t: f64, feature: FeatureKey| {
        let (on_a, on_b) = (axes.on_p(s), axes.on_q(t));
        let along = axis.dot(&(on_a + on_b - middle));
        let end = || End { along, on_a, on_b, feature };
        if first.as_ref().is_none_or(|e| along < e.along) {
            first = Some(end());
        }
        if last.as_ref().is_none_or(|e| along > e.along) {
            last = Some(end());
        }
    };
    for (i, s) in [(0, 0.0), (1, 1.0)] {
        if let Some(t) = beside(axes.foot_on_q(s)) {
            offer(s, t, FeatureKey::vertex_of_a(i));
        }
    }
    for (j, t) in [(0, 0.0), (1, 1.0)] {
        if let Some(s) = beside(axes.foot_on_p(t)) {
            offer(s, t, FeatureKey::vertex_of_b(j));
        }
    }
    let (first, last) = (first?, last?);
    let stretch = 0.5 * (last.along - first.along) / axis.norm();
    (stretch > FADED * least.sqrt()).then_some(([first, last], stretch))
}

/// Where a foot lies on a segment, unless it lies beyond its ends.
fn beside(parameter: f64) -> Option<f64> {
    (-FADED..=1.0 + FADED).contains(&parameter).then(|| parameter.clamp(0.0, 1.0))
}
