//! A spherocylinder and a cylinder with flat caps.
//!
//! The deepest direction is that of the largest separation among those that can be the nearest way out of the Minkowski
//! difference of segment and cylinder: from either end to its nearest point and across the axis, both caps, across axis and segment, and
//! where a rim is nearest to the segment's line. Each is measured with the full supports, so a direction that does not
//! apply loses. Beside it come both ends of the stretch of the segment that lies over a cap or beside the side, as for
//! a polyhedron.

use super::cylinder::Solid;
use super::outline::Outline;
use super::sphere_cylinder::ball_point;
use super::spherocylinder_spherocylinder::{parallelism, push_shared};
use super::{Cylinder, FeatureKey, Manifold, ManifoldPoint, Spherocylinder, closest_on_segment, segment_segment};
use crate::math::{Similarity, Vec3};

/// Sine of the angle between axis and segment below which they are parallel to rounding.
const PARALLEL: f64 = 1e-14;
/// Sine of the angle to a facet that counts as along it, and length over the radius that counts as none.
const LEVEL: f64 = 1e-9;
/// Cosine to the axis from which a contact is one with a cap.
const CAP: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// At most three points.
pub fn spherocylinder_cylinder(a: &Spherocylinder, b: &Cylinder, b_to_a: &Similarity, out: &mut Manifold) {
    let solid = Solid::of(b).mapped(b_to_a);
    let deepest = Deepest::of(&a.ends, &solid);
    if deepest.distance >= a.radius {
        return;
    }
    let at = |x: &Vec3, k: u32| {
        ball_point(x, a.radius, &(deepest.distance, deepest.outwards), FeatureKey::point(k))
            .expect("the distance is less than the radius")
    };
    let cap = deepest.outwards.dot(&solid.axis);
    let on_cap = cap.abs() >= CAP;
    let stretch = if on_cap { over_cap(&a.ends, &solid) } else { beside(&a.ends, &solid) };
    let Some([first, last]) = stretch else { return out.push(at(&deepest.on_segment, 2)) };
    let length = (last - first).norm();
    // of a segment along the facet all points are equally deep, also those beyond it
    let step = a.ends[1] - a.ends[0];
    let off = if on_cap { step.dot(&solid.axis).abs() } else { step.cross(&solid.axis).norm() };
    let nearest = closest_on_segment(&deepest.on_segment, &first, &last).0;
    let mut point = at(if off <= LEVEL * step.norm() { &nearest } else { &deepest.on_segment }, 2);
    if length <= LEVEL * a.radius {
        return out.push(point);
    }
    let end = |x: &Vec3, k: u32| -> Option<ManifoldPoint> {
        let d = x - solid.center;
        let along = d.dot(&solid.axis);
        let measured = if on_cap {
            (along * 1.0_f64.copysign(cap) - solid.half, solid.axis * 1.0_f64.copysign(cap))
        } else {
            ((d - solid.axis * along).norm() - solid.radius, solid.outwards(x))
        };
        // far inside an end may be deeper by its own measure than the way out of all of it, which it then goes along
        let own = ball_point(x, a.radius, &measured, FeatureKey::point(k))?;
        Some(if own.overlap <= point.overlap { own } else { at(x, k) })
    };
    let ends = [end(&first, 0), end(&last, 1)];
    // across the axis the segment leaves the side at once, and its ends mean nothing
    let fade = if on_cap { 1.0 } else { parallelism(&a.ends, &[solid.cap(-1.0), solid.cap(1.0)]) };
    push_shared(&mut point, ends, fade, length, out);
}

/// Signed distance between segment and cylinder, outward direction of the cylinder, and where on the segment.
struct Deepest {
    distance: f64,
    outwards: Vec3,
    on_segment: Vec3,
}

impl Deepest {
    fn of(ends: &[Vec3; 2], solid: &Solid) -> Self {
        let [p, q] = ends;
        let mut best = Self { distance: f64::MIN, outwards: solid.axis, on_segment: *p };
        // without a place it is the lower end
        let mut offer = |outwards: Vec3, on_segment: Option<Vec3>| {
            let height = |x: &Vec3| outwards.dot(&(x - solid.center));
            let distance = height(p).min(height(q)) - solid.reach_along(&outwards);
            if distance > best.distance {
                let on_segment = on_segment.unwrap_or(if height(p) <= height(q) { *p } else { *q });
                best = Self { distance, outwards, on_segment };
            }
        };
        for x in ends {
            offer(solid.distance(x).1, None);
            offer(solid.outwards(x), None);
        }
        let d = q - p;
        let length = d.norm();
        for cap in [solid.axis, -solid.axis] {
            offer(cap, None);
        }
        if length == 0.0 {
            return best;
        }
        let direction = d / length;
        let cross = solid.axis.cross(&direction);
        let sine = cross.norm();
        if sine > PARALLEL {
            let crossing = segment_segment(ends, &[solid.cap(-1.0), solid.cap(1.0)]).0;
            offer(cross / sine, Some(crossing));
            offer(cross / -sine, Some(crossing));
        }
        let outline = Outline::new(solid, &direction);
        for sense in [1.0, -1.0] {
            outline.feet(sense, p, |foot| offer(foot.outwards, Some(closest_on_segment(&foot.on_rim, p, q).0)));
        }
        best
    }
}

/// The stretch of the segment beside the side.
fn beside([p, q]: &[Vec3; 2], solid: &Solid) -> Option<[Vec3; 2]> {
    let along = |x: &Vec3| solid.axis.dot(&(x - solid.center));
    let (from, rise) = (along(p), solid.axis.dot(&(q - p)));
    if rise == 0.0 {
        return (from.abs() <= solid.half).then_some([*p, *q]);
    }
    let ends = [(-solid.half - from) / rise, (solid.half - from) / rise];
    clipped([p, q], ends[0].min(ends[1]), ends[0].max(ends[1]))
}

/// The stretch of the segment within the radius of the axis.
fn over_cap([p, q]: &[Vec3; 2], solid: &Solid) -> Option<[Vec3; 2]> {
    let across = |x: Vec3| x - solid.axis * solid.axis.dot(&x);
    let (from, step) = (across(p - solid.center), across(q - p));
    let square = step.norm_squared();
    if square == 0.0 {
        return (from.norm() <= solid.radius).then_some([*p, *q]);
    }
    let middle = -from.dot(&step) / square;
    let left = solid.radius * solid.radius - (from + step * middle).norm_squared();
    let half = (left.max(0.0) / square).sqrt();
    (left >= 0.0).then(|| clipped([p, q], middle - half, middle + half)).flatten()
}

fn clipped([p, q]: [&Vec3; 2], enter: f64, leave: f64) -> Option<[Vec3; 2]> {
    let (enter, leave) = (enter.max(0.0), leave.min(1.0));
    (enter < leave).then(|| [p + (q - p) * enter, p + (q - p) * leave])
}
