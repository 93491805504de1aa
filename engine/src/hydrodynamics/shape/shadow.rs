//! The area of the shadow of a union of parts, by scan lines.
//!
//! Each part is one or more convex pieces; on a line across the shadow each piece covers an interval, exactly; the union
//! of the intervals is integrated over the lines. Lines are denser towards the ends (y = -cos t), which takes away the
//! error of round ends.

use super::table::basis;
use crate::math::Vec3;
use crate::shape::{Part, PartGeometry};
use std::f64::consts::PI;

/// Scan lines.
const LINES: usize = 160;
/// Turn of the lines about the direction, so that edges of aligned bodies do not lie along them, rad.
const TURN: f64 = 0.3217;

/// A union of convex pieces.
pub(super) struct Shadow {
    pieces: Vec<Piece>,
}

enum Piece {
    /// The convex hull of points, swept by a ball.
    Hull {
        points: Vec<Vec3>,
        radius: f64,
    },
    Cylinder {
        ends: [Vec3; 2],
        radius: f64,
    },
}

type Point = [f64; 2];

/// A convex shadow: what bounds it is among its segments and ellipses.
#[derive(Default)]
struct Outline {
    segments: Vec<[Point; 2]>,
    /// Centres; all have the one form below.
    centers: Vec<Point>,
    /// (x, y) - centre = M^1/2 (unit disc), M = [[a, b], [b, c]].
    form: [f64; 3],
    low: f64,
    high: f64,
}

impl Shadow {
    pub fn of(parts: &[Part]) -> Self {
        let mut pieces = Vec::new();
        for part in parts {
            match &part.geometry {
                PartGeometry::Sphere { center, radius } => {
                    pieces.push(Piece::Hull { points: vec![*center], radius: *radius });
                }
                PartGeometry::Spherocylinder { ends, radius } => {
                    pieces.push(Piece::Hull { points: ends.to_vec(), radius: *radius });
                }
                PartGeometry::Cylinder { ends, radius } => {
                    pieces.push(Piece::Cylinder { ends: *ends, radius: *radius });
                }
                PartGeometry::Polyhedron(p) => {
                    pieces.push(Piece::Hull { points: p.vertices().to_vec(), radius: 0.0 });
                }
                PartGeometry::RoundedPolyhedron(p) => {
                    let (skeleton, radius) = (&p.skeleton, p.skeleton.radius);
                    if p.solid.is_some() {
                        pieces.push(Piece::Hull { points: skeleton.vertices().to_vec(), radius });
                        continue;
                    }
                    let at = |v: &u32| skeleton.vertices()[*v as usize];
                    let faces = skeleton.loops().iter().map(|polygon| polygon.iter().map(at).collect());
                    let edges = skeleton.edges().iter().map(|e| vec![e.start, e.start + e.along]);
                    let vertices = skeleton.vertices().iter().map(|v| vec![*v]);
                    pieces.extend(faces.chain(edges).chain(vertices).map(|points| Piece::Hull { points, radius }));
                }
            }
        }
        Self { pieces }
    }

    /// Along a unit direction.
    pub fn area(&self, d: &Vec3) -> f64 {
        let (p, q) = basis(d);
        let (sine, cosine) = TURN.sin_cos();
        let axes = [p * cosine + q * sine, q * cosine - p * sine];
        let outlines: Vec<Outline> = self.pieces.iter().map(|piece| piece.outline(&axes)).collect();
        let low = outlines.iter().map(|o| o.low).fold(f64::MAX, f64::min);
        let high = outlines.iter().map(|o| o.high).fold(f64::MIN, f64::max);
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let mut intervals: Vec<[f64; 2]> = Vec::with_capacity(outlines.len());
        let mut sum = 0.0;
        for k in 0..LINES {
            let (sine, cosine) = (PI * (k as f64 + 0.5) / LINES as f64).sin_cos();
            intervals.clear();
            intervals.extend(outlines.iter().filter_map(|o| o.interval(middle - half * cosine)));
            sum += sine * union_length(&mut intervals);
        }
        sum * half * PI / LINES as f64
    }
}

/// Length of a union of intervals.
fn union_length(intervals: &mut [[f64; 2]]) -> f64 {
    intervals.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut length, mut end) = (0.0, f64::MIN);
    for &[from, to] in intervals.iter() {
        if to > end {
            length += to - from.max(end);
            end = to;
        }
    }
    length
}

impl Piece {
    fn outline(&self, axes: &[Vec3; 2]) -> Outline {
        let flat = |x: &Vec3| [x.dot(&axes[0]), x.dot(&axes[1])];
        match self {
            Self::Hull { points, radius } => {
                let hull = convex_hull(points.iter().map(flat).collect());
                let mut outline = Outline { form: [radius * radius, 0.0, radius * radius], ..Outline::default() };
                for (i, &a) in hull.iter().enumerate() {
                    let b = hull[(i + 1) % hull.len()];
                    let along = [b[0] - a[0], b[1] - a[1]];
                    let length = along[0].hypot(along[1]);
                    if length > 0.0 {
                        // the hull is counter-clockwise: outwards is to the right
                        let out = [along[1] / length * radius, -along[0] / length * radius];
                        outline.segments.push([a, b].map(|x| [x[0] + out[0], x[1] + out[1]]));
                    }
                }
                if *radius > 0.0 {
                    outline.centers = hull;
                }
                outline.measured()
            }
            Self::Cylinder { ends, radius } => {
                let axis = (ends[1] - ends[0]).normalize();
                let [s, t] = flat(&axis);
                let r2 = radius * radius;
                let centers = ends.iter().map(flat).collect::<Vec<_>>();
                let mut outline =
                    Outline { form: [r2 * (1.0 - s * s), -r2 * s * t, r2 * (1.0 - t * t)], ..Outline::default() };
                let across = s.hypot(t);
                if across > 0.0 {
                    for sign in [1.0, -1.0] {
                        let shift = [-t / across * radius * sign, s / across * radius * sign];
                        outline.segments.push([0, 1].map(|k| [centers[k][0] + shift[0], centers[k][1] + shift[1]]));
                    }
                }
                outline.centers = centers;
                outline.measured()
            }
        }
    }
}

impl Outline {
    /// With its range of y.
    fn measured(mut self) -> Self {
        let reach = self.form[2].max(0.0).sqrt();
        let ends = self.segments.iter().flatten().map(|x| x[1]);
        let all = ends.chain(self.centers.iter().flat_map(|c| [c[1] - reach, c[1] + reach]));
        (self.low, self.high) = all.fold((f64::MAX, f64::MIN), |(l, h), y| (l.min(y), h.max(y)));
        self
    }

    /// What the outline covers of a line.
    fn interval(&self, y: f64) -> Option<[f64; 2]> {
        if y < self.low || y > self.high {
            return None;
        }
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        for [a, b] in &self.segments {
            if (a[1] <= y) != (b[1] <= y) {
                let x = a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1]));
                (low, high) = (low.min(x), high.max(x));
            }
        }
        let [a, b, c] = self.form;
        for center in &self.centers {
            let rest = c - (y - center[1]).powi(2);
            if rest > 0.0 {
                let middle = center[0] + b / c * (y - center[1]);
                let half = ((a - b * b / c).max(0.0) * rest / c).sqrt();
                (low, high) = (low.min(middle - half), high.max(middle + half));
            }
        }
        (high > low).then_some([low, high])
    }
}

/// Counter-clockwise, by Andrew's monotone chain.
fn convex_hull(mut points: Vec<Point>) -> Vec<Point> {
    points.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let turn = |a: Point, b: Point, c: Point| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let mut hull: Vec<Point> = Vec::with_capacity(points.len() + 1);
    for upper in [false, true] {
        let start = hull.len();
        let mut add = |p: Point| {
            while hull.len() >= start + 2 && turn(hull[hull.len() - 2], hull[hull.len() - 1], p) <= 0.0 {
                hull.pop();
            }
            hull.push(p);
        };
        if upper {
            points.iter().rev().for_each(|p| add(*p))
        } else {
            points.iter().for_each(|p| add(*p))
        }
        hull.pop();
    }
    hull
}
