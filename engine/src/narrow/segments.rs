//! Two segments, and the products that every question about the pair needs.

use crate::math::Vec3;

/// Squared sine of the angle below which the crossing of the two lines is too uncertain to stand alone.
const CROSSING: f64 = 1e-6;
/// The same, where it is rounding.
const PARALLEL: f64 = 1e-15;

/// p + s u and q + t v, s and t in [0, 1]. Either may be a point.
pub(crate) struct SegmentPair {
    pub p: Vec3,
    pub u: Vec3,
    pub q: Vec3,
    pub v: Vec3,
    /// From q to p.
    w: Vec3,
    pub uu: f64,
    pub uv: f64,
    pub vv: f64,
    uw: f64,
    vw: f64,
    /// u x v, and its square: that of the sine of the angle between the lines, times both squared lengths.
    pub n: Vec3,
    nn: f64,
    /// 1/u^2 and 1/v^2, 0 for points.
    inverse: (f64, f64),
}

impl SegmentPair {
    #[inline]
    pub fn new(p: &[Vec3; 2], q: &[Vec3; 2]) -> Self {
        let (u, v, w) = (p[1] - p[0], q[1] - q[0], p[0] - q[0]);
        let (uu, vv) = (u.norm_squared(), v.norm_squared());
        let n = u.cross(&v);
        let inverse = |x: f64| if x > 0.0 { 1.0 / x } else { 0.0 };
        Self {
            p: p[0],
            q: q[0],
            uu,
            uv: u.dot(&v),
            vv,
            uw: u.dot(&w),
            vw: v.dot(&w),
            n,
            nn: n.norm_squared(),
            inverse: (inverse(uu), inverse(vv)),
            u,
            v,
            w,
        }
    }

    /// Foot of p + s u on the line of q: its t.
    #[inline]
    pub fn foot_on_q(&self, s: f64) -> f64 {
        (self.vw + s * self.uv) * self.inverse.1
    }

    /// Foot of q + t v on the line of p: its s.
    #[inline]
    pub fn foot_on_p(&self, t: f64) -> f64 {
        (t * self.uv - self.uw) * self.inverse.0
    }

    #[inline]
    pub fn on_p(&self, s: f64) -> Vec3 {
        self.p + self.u * s
    }

    #[inline]
    pub fn on_q(&self, t: f64) -> Vec3 {
        self.q + self.v * t
    }

    /// Squared sine of the angle between the lines, 0 for points.
    #[inline]
    pub fn squared_sine(&self) -> f64 {
        self.nn * self.inverse.0 * self.inverse.1
    }

    /// s and t of the closest points; parallel segments give one of their pairs.
    #[inline]
    pub fn closest(&self) -> (f64, f64) {
        let product = self.uu * self.vv;
        // Any start serves where the lines are parallel to rounding: the ends are asked, too.
        let start = if self.nn > PARALLEL * product { (self.uv * self.vw - self.vv * self.uw) / self.nn } else { 0.5 };
        let s = start.clamp(0.0, 1.0);
        let t = self.foot_on_q(s);
        // Ericson, Real-Time Collision Detection, 5.1.9: clamped to the square, one after the other
        let crossing = self.nn > CROSSING * product;
        if crossing && (0.0..=1.0).contains(&t) {
            return (s, t);
        }
        let t = t.clamp(0.0, 1.0);
        let mut best = (self.foot_on_p(t).clamp(0.0, 1.0), t);
        if crossing {
            return best;
        }
        let mut least = self.squared_distance(best);
        let mut offer = |candidate: (f64, f64)| {
            let distance = self.squared_distance(candidate);
            if distance < least {
                (least, best) = (distance, candidate);
            }
        };
        offer((0.0, self.foot_on_q(0.0).clamp(0.0, 1.0)));
        offer((1.0, self.foot_on_q(1.0).clamp(0.0, 1.0)));
        offer((self.foot_on_p(0.0).clamp(0.0, 1.0), 0.0));
        offer((self.foot_on_p(1.0).clamp(0.0, 1.0), 1.0));
        best
    }

    /// Whether the whole lines are at least `distance` apart: then so are the segments. False means nothing.
    #[inline]
    pub fn lines_are_apart(&self, distance: f64) -> bool {
        let height = self.w.dot(&self.n);
        self.nn > CROSSING * self.uu * self.vv && height * height > distance * distance * self.nn * (1.0 + CROSSING)
    }

    /// Distance of the whole lines, which must not be parallel.
    #[inline]
    pub fn distance_of_lines(&self) -> f64 {
        self.w.dot(&self.n).abs() / self.nn.sqrt()
    }

    #[inline]
    fn squared_distance(&self, (s, t): (f64, f64)) -> f64 {
        (self.w + self.u * s - self.v * t).norm_squared()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn segment() -> impl Strategy<Value = [Vec3; 2]> {
        let point = || prop::array::uniform3(-1.0..1.0f64).prop_map(Vec3::from);
        (point(), point()).prop_map(|(x, y)| [x, y])
    }

    /// Random pairs, and some that are parallel but for a tilt of 1e-12 to 1.
    fn pair() -> impl Strategy<Value = ([Vec3; 2], [Vec3; 2])> {
        (segment(), segment(), -12.0..0.0f64, any::<bool>()).prop_map(|(p, q, tilt, tilted)| {
            let along = if tilted { p[1] - p[0] + (q[1] - q[0]) * 10f64.powf(tilt) } else { q[1] - q[0] };
            (p, [q[0], q[0] + along])
        })
    }

    proptest! {
        #[test]
        fn closest_points_beat_any_others((p, q) in pair(), s in 0.0..=1.0f64, t in 0.0..=1.0f64) {
            let axes = SegmentPair::new(&p, &q);
            let (at, on) = axes.closest();
            prop_assert!((0.0..=1.0).contains(&at) && (0.0..=1.0).contains(&on));
            let least = (axes.on_p(at) - axes.on_q(on)).norm();
            prop_assert!(least <= (axes.on_p(s) - axes.on_q(t)).norm() + 1e-14);
            // nor can one of them alone do better
            prop_assert!(least <= (axes.on_p(at) - axes.on_q(axes.foot_on_q(at).clamp(0.0, 1.0))).norm() + 1e-14);
            prop_assert!(least <= (axes.on_q(on) - axes.on_p(axes.foot_on_p(on).clamp(0.0, 1.0))).norm() + 1e-14);
        }

        #[test]
        fn lines_apart_are_segments_apart((p, q) in pair(), part in 0.5..1.5f64) {
            let axes = SegmentPair::new(&p, &q);
            let (s, t) = axes.closest();
            let distance = (axes.on_p(s) - axes.on_q(t)).norm();
            prop_assert!(part <= 1.0 || !axes.lines_are_apart(part * distance));
            prop_assert!(!axes.lines_are_apart(0.0) || axes.distance_of_lines() <= distance + 1e-12);
        }
    }

    #[test]
    fn crossing_lines_are_apart_by_their_height() {
        let axes = SegmentPair::new(&[-Vec3::x(), Vec3::x()], &[Vec3::new(0.3, -1.0, 0.5), Vec3::new(0.1, 2.0, 0.5)]);
        assert!(axes.lines_are_apart(0.499) && !axes.lines_are_apart(0.501));
    }

    #[test]
    fn points_are_segments() {
        let axes = SegmentPair::new(&[Vec3::x(); 2], &[Vec3::zeros(), Vec3::x() * 4.0]);
        let (s, t) = axes.closest();
        assert_eq!((axes.on_p(s), axes.on_q(t), axes.squared_sine()), (Vec3::x(), Vec3::x(), 0.0));
        assert!(!axes.lines_are_apart(0.0));
    }
}
