//! The rims of two cylinders against each other: where the distance of two circles is stationary.

use super::cylinder::Solid;
use crate::math::Vec3;
use std::f64::consts::TAU;

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

    /// Whether a point of the rim within the slack of `x` can be out beyond the edge, where it separates, or within the
    /// slack of it.
    fn may_matter(&self, x: &Vec3, sense: f64, slack: f64) -> bool {
        let d = x - self.center;
        let z = d.dot(&self.solid.axis);
        let rho = (d - self.solid.axis * z).norm();
        let beside = rho - self.side * self.solid.radius;
        z.hypot(beside) <= slack || (self.side > 0.0 && sense * z > -slack && beside > -slack)
    }

    /// The point of the circle beside `x`.
    fn foot(&self, x: &Vec3) -> Option<Vec3> {
        let d = x - self.center;
        let radial = d - self.solid.axis * d.dot(&self.solid.axis);
        let rho = radial.norm();
        (rho > 0.0).then(|| self.center + radial * (self.side * self.solid.radius / rho))
    }
}

/// Visits the direction from `a` to `b` and the middle of every pair of stationary points that may separate the two, or
/// overlap by less than `depth`.
pub(super) fn rim_directions(a: &Solid, b: &Solid, depth: f64, mut visit: impl FnMut(Vec3, Vec3)) {
    // the smaller one is sampled: a larger one could pass over all of it between two samples
    if b.radius <= a.radius {
        along_rims_of_b(a, b, depth, visit);
    } else {
        along_rims_of_b(b, a, depth, |towards, middle| visit(-towards, middle));
    }
}

fn along_rims_of_b(a: &Solid, b: &Solid, depth: f64, mut visit: impl FnMut(Vec3, Vec3)) {
    let table: [(f64, f64); SAMPLES] = std::array::from_fn(|k| {
        let (sin, cos) = (TAU * k as f64 / SAMPLES as f64).sin_cos();
        (cos, sin)
    });
    let ring = b.ring(&b.axis);
    // a sample stands for the stretches on both sides of it
    let reach = b.radius * TAU / SAMPLES as f64;
    for sense_b in [1.0, -1.0] {
        let rim = Rim { center: b.cap(sense_b), cos: ring.deepest * b.radius, sin: ring.side * b.radius };
        let moving = table.map(|angle| rim.at(angle));
        for sense_a in [1.0, -1.0] {
            for side in [1.0, -1.0] {
                // the far side of a rim is deeper than its radius
                if side < 0.0 && depth < a.radius {
                    continue;
                }
                let other = Other { solid: a, center: a.cap(sense_a), side };
                let slopes = moving.map(|m| other.slope(&m));
                let may_matter = |k: usize| other.may_matter(&moving[k].0, sense_a, depth + reach);
                each_zero(
                    &slopes,
                    may_matter,
                    |angle| other.slope(&rim.at((angle.cos(), angle.sin()))),
                    |angle| {
                        let (x, tangent) = rim.at((angle.cos(), angle.sin()));
                        let Some(foot) = other.foot(&x) else { return };
                        let distance = (x - foot).norm();
                        // across both tangents: next to touching, the difference of the points is rounding
                        let cross = tangent.cross(&a.axis.cross(&(foot - other.center))) / (a.radius * b.radius);
                        let sine = cross.norm();
                        let n = if sine * b.radius > distance { cross / sine } else { (x - foot) / distance };
                        let n = if n.dot(&(x - foot)) < 0.0 { -n } else { n };
                        if n.norm_squared() > 0.5 {
                            let middle = (x + foot) * 0.5;
                            visit(n, middle);
                            if distance < depth {
                                visit(-n, middle);
                            }
                        }
                    },
                );
            }
        }
    }
}

/// Zeros of a periodic function known at evenly spaced angles.
fn each_zero(
    samples: &[f64; SAMPLES],
    may_matter: impl Fn(usize) -> bool,
    f: impl Fn(f64) -> f64,
    mut visit: impl FnMut(f64),
) {
    let step = TAU / SAMPLES as f64;
    for k in 0..SAMPLES {
        let (start, here, next) = (k as f64 * step, samples[k], samples[(k + 1) % SAMPLES]);
        if !may_matter(k) {
            continue;
        }
        if (here <= 0.0) != (next <= 0.0) {
            visit(zero(&f, [start, start + step], [here, next]));
            continue;
        }
        // the samples may straddle two zeros: where a parabola through three of them turns
        let before = samples[(k + SAMPLES - 1) % SAMPLES];
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
