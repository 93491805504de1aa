//! Two edges: their lines' feet, their clamped distance, and the weight of the pair with its gradient.

use crate::math::Vec3;

/// Lines whose sine is below the root of this, times the angle at which the weight is full, count as parallel: their
/// vertices cover them, and their weight would be below 1e-15.
const PARALLEL: f64 = 1e-8;
/// Sine from which on the angle never fades.
const LARGEST_FADE_SINE: f64 = 0.7;

/// How the weight of an edge pair vanishes: where the lines become parallel, and where their feet lie outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeFade {
    /// c1: full weight from sine min(0.7, c1 R / length of the shorter edge) on.
    pub angle_factor: f64,
    /// c2: no weight from feet on that are c2 R outside the edges.
    pub reach_factor: f64,
}

/// Two edges p + s d, s in [0, 1], in one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgePair {
    p1: Vec3,
    d1: Vec3,
    p2: Vec3,
    d2: Vec3,
    lengths: [f64; 2],
    cross: Vec3,
    /// |d1 x d2|^2.
    den: f64,
    /// Parameters of the closest points of the infinite lines.
    feet: [f64; 2],
}

/// Weight of a pair, and its derivatives by both feet and by the squared sine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EdgeWeight {
    pub value: f64,
    by_foot: [f64; 2],
    by_sine2: f64,
}

/// q(u) = u^2 (3 - 2 u) in [0, 1], constant beyond; and its slope.
#[inline(always)]
fn smooth(u: f64) -> (f64, f64) {
    if u >= 1.0 {
        (1.0, 0.0)
    } else if u <= 0.0 {
        (0.0, 0.0)
    } else {
        (u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u))
    }
}

impl EdgePair {
    /// From the ends of both; `lengths` are those of the edges.
    #[inline]
    pub fn new([p1, q1]: &[Vec3; 2], [p2, q2]: &[Vec3; 2], lengths: [f64; 2]) -> Self {
        let (d1, d2, between) = (q1 - p1, q2 - p2, p2 - p1);
        let cross = d1.cross(&d2);
        let den = cross.norm_squared();
        // by triple products: differences of dot products lose digits on nearly parallel lines
        let inverse = 1.0 / den;
        let feet = [between.cross(&d2).dot(&cross) * inverse, between.cross(&d1).dot(&cross) * inverse];
        Self { p1: *p1, d1, p2: *p2, d2, lengths, cross, den, feet }
    }

    /// w = q(sin^2 / sg^2) f(o_s) f(o_t), f(o) = q(1 - o), o = how far a line's foot lies outside its edge over
    /// c2 R; `None` where it is 0.
    #[inline]
    pub fn weight(&self, fade: &EdgeFade, radius: f64) -> Option<EdgeWeight> {
        let [la, lb] = self.lengths;
        let sine2 = self.den / (la * la * lb * lb);
        let full = LARGEST_FADE_SINE.min(fade.angle_factor * radius / la.min(lb));
        let full2 = full * full;
        if sine2 < PARALLEL * full2 {
            return None;
        }
        let beyond = 1.0 / (fade.reach_factor * radius);
        let outside = |foot: f64, length: f64| {
            let slope = length * beyond;
            if foot < 0.0 {
                (-foot * slope, -slope)
            } else if foot > 1.0 {
                ((foot - 1.0) * slope, slope)
            } else {
                (0.0, 0.0)
            }
        };
        let (s, s_slope) = outside(self.feet[0], la);
        let (t, t_slope) = outside(self.feet[1], lb);
        if s >= 1.0 || t >= 1.0 {
            return None;
        }
        let (angle, angle_slope) = smooth(sine2 / full2);
        let ((fs, fs_slope), (ft, ft_slope)) = (smooth(1.0 - s), smooth(1.0 - t));
        let value = angle * fs * ft;
        (value > 0.0).then_some(EdgeWeight {
            value,
            by_foot: [-angle * fs_slope * s_slope * ft, -angle * fs * ft_slope * t_slope],
            by_sine2: angle_slope / full2 * fs * ft,
        })
    }

    /// Closest points of the edges, on the first and on the second.
    #[inline]
    pub fn closest(&self) -> (Vec3, Vec3) {
        let [s, t] = self.feet;
        let (s, t) = if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) { (s, t) } else { self.clamped() };
        (self.p1 + self.d1 * s, self.p2 + self.d2 * t)
    }

    /// Source: Ericson, Real-Time Collision Detection (2004), section 5.1.9.
    fn clamped(&self) -> (f64, f64) {
        let between = self.p1 - self.p2;
        let (a, e, b) = (self.d1.norm_squared(), self.d2.norm_squared(), self.d1.dot(&self.d2));
        let (c, f) = (self.d1.dot(&between), self.d2.dot(&between));
        let s = if self.feet[0].is_finite() { self.feet[0].clamp(0.0, 1.0) } else { 0.0 };
        let t = (b * s + f) / e;
        if t < 0.0 {
            ((-c / a).clamp(0.0, 1.0), 0.0)
        } else if t > 1.0 {
            (((b - c) / a).clamp(0.0, 1.0), 1.0)
        } else {
            (s, t)
        }
    }

    /// Direction of the common perpendicular, of either sense.
    pub fn perpendicular(&self) -> Vec3 {
        self.cross / self.den.sqrt()
    }

    /// Gradient of the weight by a displacement and a rotation of the second edge's body: (force, moment about the
    /// origin), so that dw = force . u + moment . theta for the displacement u + theta x x of its points x.
    ///
    /// With a = d1.d1, e = d2.d2, b = d1.d2, v0 the vector between the lines' feet and y that on the second line:
    /// force (d1 (ks e + kt b) - d2 (ks b + kt a)) / den at y, and the couple
    /// -(ks b + kt a)/den (d2 x v0) - 2 (e1.e2)(e2 x e1) dw/d(sin^2).
    #[inline]
    pub fn gradient(&self, weight: &EdgeWeight) -> (Vec3, Vec3) {
        let (a, e, b) = (self.d1.norm_squared(), self.d2.norm_squared(), self.d1.dot(&self.d2));
        let ([ks, kt], [s, t]) = (weight.by_foot, self.feet);
        let on_second = self.p2 + self.d2 * t;
        let between = on_second - (self.p1 + self.d1 * s);
        let (first, second) = ((ks * e + kt * b) / self.den, (ks * b + kt * a) / self.den);
        let force = self.d1 * first - self.d2 * second;
        // e2 x e1 = -cross / (la lb)
        let [la, lb] = self.lengths;
        let turn = 2.0 * b * weight.by_sine2 / (la * la * lb * lb);
        let couple = self.d2.cross(&between) * -second + self.cross * turn;
        (force, on_second.cross(&force) + couple)
    }
}

impl EdgeWeight {
    /// Whether the weight changes with the pose at all.
    #[inline]
    pub fn varies(&self) -> bool {
        self.by_sine2 != 0.0 || self.by_foot != [0.0; 2]
    }
}
