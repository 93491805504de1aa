//! Two spherocylinders: the closest points of their axes, and both ends of the stretch where they lie side by side.
//!
//! Every point is the contact of two balls of the two axes. The shares fade the closest point out as the axes become
//! parallel, where its place is undefined, and fade the ends out as they lift off, so the share-weighted force is
//! continuous in the pose.

use super::closest::{closest_on_segment, segment_segment};
use super::round::{Ball, across, contact, direction};
use super::{FeatureKey, Manifold, ManifoldPoint, Spherocylinder};
use crate::math::{Similarity, Vec3};

/// Shares below this, over the length side by side, are rounding of parallel axes.
const FADED: f64 = 1e-9;
/// Sine of the angle between the axes at which the ends cease to count: 30 degrees. Across, "side by side" has no sense.
const WIDEST: f64 = 0.5;

/// At most three points.
pub fn spherocylinder_spherocylinder(a: &Spherocylinder, b: &Spherocylinder, b_to_a: &Similarity, out: &mut Manifold) {
    let q = b.ends.map(|e| b_to_a.point(&e));
    let radii = (a.radius, b.radius * b_to_a.scale);
    let balls = |x: Vec3, y: Vec3| (Ball { center: x, radius: radii.0 }, Ball { center: y, radius: radii.1 });
    let (x, y) = segment_segment(&a.ends, &q);
    let (ball_a, ball_b) = balls(x, y);
    let fallback = crossing_normal(&a.ends, &q);
    let Some(mut deepest) = contact(&ball_a, &ball_b, &fallback, FeatureKey::point(0), 1.0) else { return };
    let normal = direction(&ball_a, &ball_b, &fallback);
    let ends = side_by_side(&a.ends, &q).map(|(first, last, length)| {
        let end = |e: &End| {
            let (ball_a, ball_b) = balls(e.on_a, e.on_b);
            contact(&ball_a, &ball_b, &normal, e.feature, 0.0)
        };
        ([end(&first), end(&last)], length)
    });
    let Some((ends, length)) = ends else { return out.push(deepest) };
    push_shared(&mut deepest, ends, parallelism(&a.ends, &q), length, out);
}

/// 1 for parallel axes, fading to 0 at the widest angle.
pub(super) fn parallelism(p: &[Vec3; 2], q: &[Vec3; 2]) -> f64 {
    let (u, v) = (p[1] - p[0], q[1] - q[0]);
    let sine2 = u.cross(&v).norm_squared() / (u.norm_squared() * v.norm_squared());
    (1.0 - sine2 / (WIDEST * WIDEST)).max(0.0)
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
fn crossing_normal(p: &[Vec3; 2], q: &[Vec3; 2]) -> Vec3 {
    let (u, v) = (p[1] - p[0], q[1] - q[0]);
    let cross = u.cross(&v);
    let length = cross.norm();
    if length > 1e-9 * u.norm() * v.norm() {
        return cross / length;
    }
    across(if u.norm_squared() > 0.0 { &u } else { &v })
}

struct End {
    along: f64,
    on_a: Vec3,
    on_b: Vec3,
    feature: FeatureKey,
}

/// First and last end of either segment that lies beside the other one, and the length between them.
fn side_by_side(p: &[Vec3; 2], q: &[Vec3; 2]) -> Option<(End, End, f64)> {
    let (u, v) = (p[1] - p[0], q[1] - q[0]);
    let length = u.norm().min(v.norm());
    if length == 0.0 {
        return None;
    }
    // the bisector: the stretch must not depend on which of the two is called a
    let (u, v) = (u.normalize(), v.normalize());
    let axis = if u.dot(&v) >= 0.0 { u + v } else { u - v }.normalize();
    let middle = (p[0] + p[1] + q[0] + q[1]) * 0.25;
    let (mut first, mut last): (Option<End>, Option<End>) = (None, None);
    let mut offer = |on_a: Vec3, on_b: Vec3, feature: FeatureKey| {
        let along = axis.dot(&((on_a + on_b) * 0.5 - middle));
        let end = || End { along, on_a, on_b, feature };
        if first.as_ref().is_none_or(|e| along < e.along) {
            first = Some(end());
        }
        if last.as_ref().is_none_or(|e| along > e.along) {
            last = Some(end());
        }
    };
    for (i, x) in (0..).zip(p) {
        let (y, t) = closest_on_segment(x, &q[0], &q[1]);
        if inside(t, x, &y, &q[0], &q[1]) {
            offer(*x, y, FeatureKey::vertex_of_a(i));
        }
    }
    for (j, y) in (0..).zip(q) {
        let (x, s) = closest_on_segment(y, &p[0], &p[1]);
        if inside(s, y, &x, &p[0], &p[1]) {
            offer(x, *y, FeatureKey::vertex_of_b(j));
        }
    }
    let (first, last) = (first?, last?);
    let stretch = last.along - first.along;
    (stretch > FADED * length).then_some((first, last, stretch))
}

/// Whether `x` lies beside the segment, that is, `y` is its foot and not merely the nearer end.
fn inside(parameter: f64, x: &Vec3, y: &Vec3, from: &Vec3, to: &Vec3) -> bool {
    let d = to - from;
    (parameter > 0.0 && parameter < 1.0) || d.dot(&(x - y)).abs() <= FADED * d.norm_squared()
}
