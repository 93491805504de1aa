//! The rims of two cylinders against each other: where the distance of two circles is stationary.

use super::cylinder::Solid;
use crate::math::Vec3;
use std::f64::consts::TAU;
use std::sync::LazyLock;

/// Samples of a rim. Between two of them the distance to the other rim has at most one extremum, or two that a parabola
/// through three samples finds.
const SAMPLES: usize = 32;

/// A rim, as a function of the angle about its axis.
struct Rim {
    center: Vec3,
    cos: Vec3,
    sin: Vec3,
}

impl Rim {
    fn at(&self, (cos, sin): (f64, f64)) -> (Vec3, Vec3) {
        (self.center + self.cos * cos + self.sin * sin, self.sin * cos - self.cos * sin)
    }
}

/// The other rim: points are measured in cylinder coordinates about its axis.
struct Other<'s> {
    solid: &'s Solid,
    center: Vec3,
    /// 1 for the near side of the rim, -1 for the far side.
    side: f64,
}

impl Other<'_> {
    /// Half the derivative of the squared distance of a moving point from the circle.
    fn slope(&self, (x, velocity): &(Vec3, Vec3)) -> f64 {
        let d = x - self.center;
        let (z, z_rate) = (d.dot(&self.solid.axis), velocity.dot(&self.solid.axis));
        let radial = d - self.solid.axis * z;
        let rho = radial.norm();
        // rho rho' is smooth, also on the axis
        let along = radial.dot(velocity);
        z * z_rate + along - self.side * self.solid.radius * (if rho > 0.0 { along / rho } else { 0.0 })
    }

    /// Whether a point of the rim within `reach` of `x` may be one that decides: out beyond the edge, where it separates, or
    /// less than `depth` from it, and no farther than `most`.
    fn may_matter(&self, x: &Vec3, sense: f64, reach: f64, [depth, most]: [f64; 2]) -> bool {
        let d = x - self.center;
        let z = d.dot(&self.solid.axis);
        let farthest = most + reach;
        if z.abs() > farthest {
            return false;
        }
        let beside = (d - self.solid.axis * z).norm() - self.side * self.solid.radius;
        let (distance2, slack) = (z * z + beside * beside, depth + reach);
        distance2 <= farthest * farthest
            && (distance2 <= slack * slack || (self.side > 0.0 && sense * z > -slack && beside > -slack))
    }

    /// The point of the circle beside `x`.
    fn foot(&self, x: &Vec3) -> Option<Vec3> {
        let d = x - self.center;
        let radial = d - self.solid.axis * d.dot(&self.solid.axis);
        let rho = radial.norm();
        (rho > 0.0).then(|| self.center + radial * (self.side * self.solid.radius / rho))
    }
}

/// Visits the direction from `a` to `b`, the middle and the distance of every pair of stationary points that may separate
/// the two, or overlap by less than `depth`, and are no farther from each other than `most`.
pub(super) fn rim_directions(a: &Solid, b: &Solid, bounds: [f64; 2], mut visit: impl FnMut(Vec3, Vec3, f64)) {
    // the smaller one is sampled: a larger one could pass over all of it between two samples
    if b.radius <= a.radius {
        along_rims_of_b(a, b, bounds, visit);
    } else {
        along_rims_of_b(b, a, bounds, |towards, middle, distance| visit(-towards, middle, distance));
    }
}

/// Cosine and sine of the angles of the samples.
static TABLE: LazyLock<[(f64, f64); SAMPLES]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let (sin, cos) = (TAU * k as f64 / SAMPLES as f64).sin_cos();
        (cos, sin)
    })
});

fn along_rims_of_b(a: &Solid, b: &Solid, [depth, most]: [f64; 2], mut visit: impl FnMut(Vec3, Vec3, f64)) {
    let ring = b.ring(&b.axis);
    // a sample stands for the stretches on both sides of it
    let reach = b.radius * TAU / SAMPLES as f64;
    for sense_b in [1.0, -1.0] {
        let rim = Rim { center: b.cap(sense_b), cos: ring.deepest * b.radius, sin: ring.side * b.radius };
        for sense_a in [1.0, -1.0] {
            let farthest = most + a.radius + b.radius;
            if (rim.center - a.cap(sense_a)).norm_squared() > farthest * farthest {
                continue;
            }
            let moving = TABLE.map(|angle| rim.at(angle));
            for side in [1.0, -1.0] {
                // the far side of a rim is deeper than its radius
                if side < 0.0 && depth < a.radius {
                    continue;
                }
                let other = Other { solid: a, center: a.cap(sense_a), side };
                let may_matter = |k: usize| other.may_matter(&moving[k].0, sense_a, reach, [depth, most]);
                each_zero(
                    |k| other.slope(&moving[k]),
                    may_matter,
                    |angle| other.slope(&rim.at((angle.cos(), angle.sin()))),
                    |angle| visit_stationary(&other, &rim, (b.radius, angle), depth, &mut visit),
                );
            }
        }
    }
}

/// The direction between a point of a rim at an angle and the other rim, and the opposite one where they overlap.
fn visit_stationary(
    other: &Other<'_>,
    rim: &Rim,
    (radius, angle): (f64, f64),
    depth: f64,
    visit: &mut impl FnMut(Vec3, Vec3, f64),
) {
    let a = other.solid;
    let (x, tangent) = rim.at((angle.cos(), angle.sin()));
    let Some(foot) = other.foot(&x) else { return };
    let distance = (x - foot).norm();
    // across both tangents: next to touching, the difference of the points is rounding
    let cross = tangent.cross(&a.axis.cross(&(foot - other.center))) / (a.radius * radius);
    let sine = cross.norm();
    let n = if sine * radius > distance { cross / sine } else { (x - foot) / distance };
    let n = if n.dot(&(x - foot)) < 0.0 { -n } else { n };
    if n.norm_squared() > 0.5 {
        let middle = (x + foot) * 0.5;
        visit(n, middle, distance);
        if distance < depth {
            visit(-n, middle, distance);
        }
    }
}

/// Zeros of a periodic function, near those of its evenly spaced samples that may matter.
fn each_zero(
    sample: impl Fn(usize) -> f64,
    may_matter: impl Fn(usize) -> bool,
    f: impl Fn(f64) -> f64,
    mut visit: impl FnMut(f64),
) {
    let step = TAU / SAMPLES as f64;
    for k in 0..SAMPLES {
        if !may_matter(k) {
            continue;
        }
        let (start, here, next) = (k as f64 * step, sample(k), sample((k + 1) % SAMPLES));
        if (here <= 0.0) != (next <= 0.0) {
            visit(zero(&f, [start, start + step], [here, next]));
            continue;
        }
        // the samples may straddle two zeros: where a parabola through three of them turns
        let before = sample((k + SAMPLES - 1) % SAMPLES);
        let bend = before - 2.0 * here + next;
        let turn = 0.5 * (before - next) / bend;
        if here.abs() > before.abs() || here.abs() > next.abs() || turn.is_nan() || turn.abs() > 1.0 {
            continue;
        }
        let turn = start + turn * step;
        let value = f(turn);
        if (value <= 0.0) != (here <= 0.0) {
            visit(zero(&f, [start - step, turn], [before, value]));
            visit(zero(&f, [turn, start + step], [value, next]));
        }
    }
}

/// The zero between two angles at which the function has opposite signs (Illinois' variant of the false position).
fn zero(f: &impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2], [mut of_low, mut of_high]: [f64; 2]) -> f64 {
    let mut low_moved = None;
    for _ in 0..60 {
        let mut middle = (low * of_high - high * of_low) / (of_high - of_low);
        if !(middle > low && middle < high) {
            middle = 0.5 * (low + high);
        }
        let value = f(middle);
        if value == 0.0 || high - low <= 1e-15 {
            return middle;
        }
        if (value <= 0.0) == (of_low <= 0.0) {
            (low, of_low) = (middle, value);
            // an end that stays twice would hold up the other one
            if low_moved.replace(true) == Some(true) {
                of_high *= 0.5;
            }
        } else {
            (high, of_high) = (middle, value);
            if low_moved.replace(false) == Some(false) {
                of_low *= 0.5;
            }
        }
    }
    0.5 * (low + high)
}
