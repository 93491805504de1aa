//! The functions that smear, of integral 1 in as many dimensions as the grid resolves.
//!
//! With R the distance, w the width and c the support (`cutoff_widths` times w), all zero beyond c:
//! Gaussian exp(-R^2 / (2 w^2)) (D = w^2 up to the cut; seed 003 prints exp(-(R / 2w)^2), whose D is 2 w^2), Lucy
//! (1 + 3 q)(1 - q)^3 with q = R / c (Lucy, Astron. J. 82 (1977) 1013), and Heaviside 1.

use std::f64::consts::{FRAC_2_SQRT_PI, FRAC_PI_2, PI, SQRT_2};

use libm::erf;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The shape of the function that smears.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FieldKernel {
    /// exp(-R^2 / (2 w^2)) up to the cutoff.
    #[default]
    Gaussian,
    /// (1 + 3 R/c)(1 - R/c)^3 with c the cutoff: twice differentiable everywhere.
    Lucy,
    /// 1 up to the cutoff: has no gradient.
    Heaviside,
}

impl FieldKernel {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Gaussian, Self::Lucy, Self::Heaviside];

    /// As on the wire and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gaussian => "gaussian",
            Self::Lucy => "lucy",
            Self::Heaviside => "heaviside",
        }
    }
}

/// A kernel with its numbers, in 0 to 3 dimensions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kernel {
    form: FieldKernel,
    width: f64,
    /// Where it ends, m.
    pub support: f64,
    /// Dimensions that the grid resolves.
    pub dimensions: usize,
    amplitude: f64,
    /// Integral of x^2 times the kernel along any axis, m2.
    pub second_moment: f64,
}

impl Kernel {
    pub fn new(form: FieldKernel, width: f64, support: f64, dimensions: usize) -> Self {
        let (integral, second_moment) = integrals(form, width, support, dimensions);
        Self { form, width, support, dimensions, amplitude: 1.0 / integral, second_moment }
    }

    /// At the squared distance, 1/m^dimensions.
    #[inline(always)]
    pub fn value(&self, squared: f64) -> f64 {
        if squared > self.support * self.support {
            return 0.0;
        }
        self.amplitude * self.profile(squared)
    }

    #[inline(always)]
    fn profile(&self, squared: f64) -> f64 {
        match self.form {
            FieldKernel::Gaussian => (squared * (-0.5 / (self.width * self.width))).exp(),
            FieldKernel::Lucy => {
                let q = squared.sqrt() / self.support;
                (1.0 + 3.0 * q) * (1.0 - q).powi(3)
            }
            FieldKernel::Heaviside => 1.0,
        }
    }

    /// What the vector from the source to the point is multiplied with to give the gradient at the point, where the
    /// kernel has the value `phi`. Of the Gaussian divided by its own second moment instead of w^2, by which the gradient
    /// of a linear field is exact in spite of the cut.
    #[inline(always)]
    pub fn slope(&self, squared: f64, phi: f64) -> f64 {
        match self.form {
            FieldKernel::Gaussian => -phi / self.second_moment,
            FieldKernel::Lucy => {
                let q = squared.sqrt() / self.support;
                -12.0 * self.amplitude * (1.0 - q) * (1.0 - q) / (self.support * self.support)
            }
            FieldKernel::Heaviside => 0.0,
        }
    }

    /// Integral of the kernel along a straight line, over the distance from `from` to `to` (m, measured from the point
    /// of the line that is nearest to the centre), `squared` the square of how far that is from the centre. Exact.
    #[inline]
    pub fn along(&self, squared: f64, from: f64, to: f64) -> f64 {
        let half_chord = self.support * self.support - squared;
        if half_chord <= 0.0 {
            return 0.0;
        }
        let half_chord = half_chord.sqrt();
        let (from, to) = (from.max(-half_chord), to.min(half_chord));
        if from >= to {
            return 0.0;
        }
        let c = self.support;
        self.amplitude
            * match self.form {
                FieldKernel::Gaussian => {
                    let root = SQRT_2 * self.width;
                    let across = (squared * (-0.5 / (self.width * self.width))).exp();
                    across * self.width * FRAC_PI_2.sqrt() * (erf(to / root) - erf(from / root))
                }
                FieldKernel::Lucy => {
                    c * (lucy_along(squared / (c * c), to / c) - lucy_along(squared / (c * c), from / c))
                }
                FieldKernel::Heaviside => to - from,
            }
    }

    /// Integral over the planes at the signed distance `x` from the centre.
    fn marginal(&self, x: f64) -> f64 {
        let (c, squared) = (self.support, x * x);
        if squared >= c * c {
            return 0.0;
        }
        match self.dimensions {
            0 => 0.0,
            1 => self.value(squared),
            2 => self.along(squared, -c, c),
            _ => {
                let q = x.abs() / c;
                self.amplitude
                    * match self.form {
                        FieldKernel::Gaussian => {
                            let at = |squared: f64| (squared * (-0.5 / (self.width * self.width))).exp();
                            2.0 * PI * self.width * self.width * (at(squared) - at(c * c))
                        }
                        FieldKernel::Lucy => {
                            let up_to = |q: f64| q * q * (0.5 - 1.5 * q * q + 1.6 * q.powi(3) - 0.5 * q.powi(4));
                            2.0 * PI * c * c * (up_to(1.0) - up_to(q))
                        }
                        FieldKernel::Heaviside => PI * (c * c - squared),
                    }
            }
        }
    }

    /// Part of the kernel on the near side of a plane at any distance from its centre. The table is over the angle whose
    /// sine is the distance over the support, in which a marginal that ends like a root is smooth.
    pub fn half_spaces(&self) -> HalfSpaces {
        let step = FRAC_PI_2 / HALF_SPACES as f64;
        let slope = |angle: f64| self.marginal(self.support * angle.sin()) * self.support * angle.cos();
        let mut part = 0.5;
        let mut parts = vec![part];
        for k in 0..HALF_SPACES {
            let first = k as f64 * step;
            part += step * LEGENDRE.iter().map(|(x, weight)| weight * slope(first + x * step)).sum::<f64>();
            parts.push(part);
        }
        // the last digits of the quadrature
        let scale = 0.5 / (part - 0.5);
        parts.iter_mut().for_each(|part| *part = 0.5 + (*part - 0.5) * scale);
        let slopes = (0..=HALF_SPACES).map(|k| slope(k as f64 * step)).collect();
        HalfSpaces { support: self.support, step, parts, slopes }
    }
}

/// Intervals of the table.
const HALF_SPACES: usize = 512;

/// Nodes and weights of Gauss-Legendre quadrature with five nodes on [0, 1].
pub(super) const LEGENDRE: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_6, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// Part of a kernel on one side of a plane, as a table.
pub(super) struct HalfSpaces {
    support: f64,
    step: f64,
    parts: Vec<f64>,
    slopes: Vec<f64>,
}

impl HalfSpaces {
    /// On the side that the centre lies `distance` deep in; below 1/2 where that is negative.
    pub fn part(&self, distance: f64) -> f64 {
        let x = (distance.abs() / self.support).min(1.0).asin() / self.step;
        let k = x as usize;
        let part = if k >= self.parts.len() - 1 {
            1.0
        } else {
            // cubic Hermite
            let t = x - k as f64;
            let (a, b) = (self.parts[k], self.parts[k + 1]);
            let (da, db) = (self.slopes[k] * self.step, self.slopes[k + 1] * self.step);
            let s = 1.0 - t;
            s * s * ((1.0 + 2.0 * t) * a + t * da) + t * t * ((1.0 + 2.0 * s) * b - s * db)
        };
        if distance >= 0.0 { part } else { 1.0 - part }
    }
}

/// Integral of (1 + 3 q)(1 - q)^3 over u up to `u`, q^2 = `squared` + u^2, lengths over the support.
fn lucy_along(squared: f64, u: f64) -> f64 {
    let q = (squared + u * u).sqrt();
    let fourth = squared * squared;
    let log = if squared > 0.0 { 0.375 * fourth * (u / squared.sqrt()).asinh() } else { 0.0 };
    let third = u * (2.0 * u * u + 5.0 * squared) * q / 8.0 + log;
    u - 6.0 * (squared * u + u.powi(3) / 3.0) + 8.0 * third
        - 3.0 * (fourth * u + 2.0 / 3.0 * squared * u.powi(3) + u.powi(5) / 5.0)
}

/// Integral of the profile, and its second moment along an axis over that.
fn integrals(form: FieldKernel, w: f64, c: f64, dimensions: usize) -> (f64, f64) {
    if dimensions == 0 {
        return (1.0, 0.0);
    }
    match form {
        FieldKernel::Gaussian => {
            let x = c / (SQRT_2 * w);
            let (t, tail) = (x * x, (-x * x).exp());
            // regularised lower incomplete gamma functions of d/2 and d/2 + 1
            let half = erf(x);
            let three_halves = half - FRAC_2_SQRT_PI * x * tail;
            let five_halves = three_halves - FRAC_2_SQRT_PI * t * x * tail / 1.5;
            let root = (2.0 * PI).sqrt() * w;
            let (part, next) = match dimensions {
                1 => (half, three_halves),
                2 => (1.0 - tail, 1.0 - tail * (1.0 + t)),
                _ => (three_halves, five_halves),
            };
            (root.powi(dimensions as i32) * part, w * w * next / part)
        }
        FieldKernel::Lucy => match dimensions {
            1 => (0.8 * c, 2.0 / 21.0 * c * c),
            2 => (0.2 * PI * c * c, 5.0 / 56.0 * c * c),
            _ => (16.0 / 105.0 * PI * c.powi(3), c * c / 12.0),
        },
        FieldKernel::Heaviside => match dimensions {
            1 => (2.0 * c, c * c / 3.0),
            2 => (PI * c * c, c * c / 4.0),
            _ => (4.0 / 3.0 * PI * c.powi(3), c * c / 5.0),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn every() -> impl Iterator<Item = Kernel> {
        FieldKernel::ALL.into_iter().flat_map(|form| (1..=3).map(move |d| Kernel::new(form, 0.3, 0.9, d)))
    }

    /// Simpson's rule over a radius; the integrand ends in a jump that is one of its nodes.
    fn radial(kernel: &Kernel, f: impl Fn(f64) -> f64) -> f64 {
        let surface = [2.0, 2.0 * PI, 4.0 * PI][kernel.dimensions - 1];
        let (n, c) = (4000, kernel.support);
        let g = |r: f64| surface * r.powi(kernel.dimensions as i32 - 1) * f(r) * kernel.value((r * r).min(c * c));
        let inner: f64 = (1..n).map(|k| g(c * f64::from(k) / f64::from(n)) * f64::from(2 + 2 * (k % 2))).sum();
        c / f64::from(n) / 3.0 * (g(0.0) + inner + g(c))
    }

    #[test]
    fn kernels_have_integral_one_and_the_stated_second_moment() {
        for kernel in every() {
            assert!((radial(&kernel, |_| 1.0) - 1.0).abs() < 1e-11, "{kernel:?}");
            let second = radial(&kernel, |r| r * r) / kernel.dimensions as f64;
            assert!((second / kernel.second_moment - 1.0).abs() < 1e-11, "{kernel:?} {second}");
        }
        // PHYSICS.md C1
        let wide = |c| Kernel::new(FieldKernel::Gaussian, 1.0, c, 3);
        assert!((wide(6.0).second_moment - 0.999_999_1).abs() < 1e-7);
        assert!((wide(3.0).second_moment - 0.917_82).abs() < 1e-5);
        assert!((wide(6.0).amplitude - 0.063_493_64).abs() < 1e-8 && (wide(3.0).amplitude - 0.065_409_54).abs() < 1e-8);
        let printed = Kernel::new(FieldKernel::Gaussian, SQRT_2, 6.0, 3);
        assert!((printed.amplitude - 0.022_458_27).abs() < 1e-8 && (printed.second_moment - 1.994_985).abs() < 1e-6);
    }

    /// Against the midpoint rule on 20000 pieces, whose error is that of the jumps at the rim, 1e-4 of a piece's share.
    #[test]
    fn line_integrals_are_those_of_the_values() {
        for kernel in every() {
            for (squared, from, to) in [(0.0, -0.2, 0.5), (0.09, -2.0, 3.0), (0.5, 0.1, 0.4), (1e-20, -0.1, 0.0)] {
                let n = 20_000;
                let h = (to - from) / f64::from(n);
                let sum: f64 =
                    (0..n).map(|k| kernel.value(squared + (from + (f64::from(k) + 0.5) * h).powi(2)) * h).sum();
                let exact = kernel.along(squared, from, to);
                assert!((exact - sum).abs() < 2.0 * h * kernel.value(0.0), "{kernel:?} {exact} {sum}");
            }
            assert_eq!(kernel.along(0.82, -1.0, 1.0), 0.0);
        }
    }

    #[test]
    fn half_spaces_take_their_share() {
        for kernel in every() {
            let halves = kernel.half_spaces();
            assert_eq!((halves.part(0.0), halves.part(2.0), halves.part(-2.0)), (0.5, 1.0, 0.0));
            for distance in [0.01, 0.123, 0.5, 0.77, 0.899] {
                let n = 40_000;
                let h = distance / f64::from(n);
                let sum: f64 = (0..n).map(|k| kernel.marginal((f64::from(k) + 0.5) * h) * h).sum();
                let part = halves.part(distance);
                assert!((part - 0.5 - sum).abs() < 2e-7, "{kernel:?} {distance} {part} {sum}");
                assert!((halves.part(-distance) + part - 1.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn slopes_are_derivatives() {
        for kernel in every().filter(|kernel| kernel.form != FieldKernel::Heaviside) {
            let (r, h) = (0.41, 1e-6);
            let numeric = (kernel.value((r + h) * (r + h)) - kernel.value((r - h) * (r - h))) / (2.0 * h);
            // the Gaussian's is divided by the second moment of the cut kernel
            let cut = if kernel.form == FieldKernel::Gaussian { kernel.second_moment / 0.09 } else { 1.0 };
            let found = kernel.slope(r * r, kernel.value(r * r)) * r * cut;
            assert!((found / numeric - 1.0).abs() < 1e-8, "{kernel:?} {found} {numeric}");
        }
    }
}
