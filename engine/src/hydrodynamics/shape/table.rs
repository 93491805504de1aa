//! Two numbers on a grid of directions that are the same along opposite ones.
//!
//! The grid is that of a cube's faces seen from its centre: three faces, for d and -d are one. Bilinear on a face, and
//! continuous from face to face, whose nodes on the common edge are the same directions.

use crate::math::Vec3;

/// Cells along the side of a face: 3.6 degrees in the middle of it, where the grid is coarsest. Even, so that the planes
/// of the axes, where silhouettes of aligned bodies have kinks, are grid lines.
const CELLS: usize = 32;
const NODES: usize = CELLS + 1;
/// Directions in the mean over half a circle.
const AROUND: usize = 48;

/// The table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DirectionTable {
    values: Vec<[f64; 2]>,
}

impl DirectionTable {
    /// Of a function of the unit direction.
    pub fn tabulate(f: impl Fn(&Vec3) -> [f64; 2]) -> Self {
        let mut values = Vec::with_capacity(3 * NODES * NODES);
        for face in 0..3 {
            for i in 0..NODES {
                for j in 0..NODES {
                    values.push(f(&direction(face, i, j)));
                }
            }
        }
        Self { values }
    }

    /// With the second number the mean of the first over all directions across.
    pub fn with_means_across(self) -> Self {
        Self::tabulate(|d| [self.at(d)[0], mean_across(d, |e| self.at(e)[0])])
    }

    /// Interpolated.
    #[inline]
    pub fn at(&self, d: &Vec3) -> [f64; 2] {
        let (x, y, z) = (d.x.abs(), d.y.abs(), d.z.abs());
        let (face, main, a, b) = if x >= y && x >= z {
            (0, d.x, d.y, d.z)
        } else if y >= z {
            (1, d.y, d.z, d.x)
        } else {
            (2, d.z, d.x, d.y)
        };
        let half = 0.5 * CELLS as f64;
        let cell = |t: f64| {
            let t = half * (t / main + 1.0);
            let i = (t as usize).min(CELLS - 1);
            (i, t - i as f64)
        };
        let ((i, s), (j, t)) = (cell(a), cell(b));
        let row = |i: usize| {
            let k = (face * NODES + i) * NODES + j;
            let (low, high) = (self.values[k], self.values[k + 1]);
            [0, 1].map(|n| low[n] + t * (high[n] - low[n]))
        };
        let (low, high) = (row(i), row(i + 1));
        [0, 1].map(|n| low[n] + s * (high[n] - low[n]))
    }
}

/// Mean of an even function of the direction over the circle across a unit vector.
pub(super) fn mean_across(d: &Vec3, f: impl Fn(&Vec3) -> f64) -> f64 {
    let (p, q) = basis(d);
    let at = |k: usize| {
        let (sine, cosine) = (std::f64::consts::PI * (k as f64 + 0.5) / AROUND as f64).sin_cos();
        f(&(p * cosine + q * sine))
    };
    (0..AROUND).map(at).sum::<f64>() / AROUND as f64
}

/// Two unit vectors across a unit vector.
pub(super) fn basis(d: &Vec3) -> (Vec3, Vec3) {
    let p = d.cross(&Vec3::ith(d.iamin(), 1.0)).normalize();
    (p, d.cross(&p))
}

fn direction(face: usize, i: usize, j: usize) -> Vec3 {
    let at = |i: usize| 2.0 * i as f64 / CELLS as f64 - 1.0;
    let mut d = Vec3::zeros();
    d[face] = 1.0;
    d[(face + 1) % 3] = at(i);
    d[(face + 2) % 3] = at(j);
    d.normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn smooth(d: &Vec3) -> [f64; 2] {
        [1.0 + d.x * d.x + 0.5 * d.y * d.z, d.x.abs()]
    }

    #[test]
    fn interpolates_and_is_even() {
        let table = DirectionTable::tabulate(smooth);
        for k in 0..500 {
            let t = f64::from(k);
            let d = Vec3::new((0.7 * t).sin(), (1.3 * t).cos(), (2.1 * t + 0.3).sin()).normalize();
            let (value, exact) = (table.at(&d), smooth(&d));
            // half a cell squared over two, times second derivatives up to 2
            assert!((value[0] - exact[0]).abs() < 3.5e-3 && (value[1] - exact[1]).abs() < 3.5e-3, "{d:?}");
            let opposite = table.at(&-d);
            assert!((0..2).all(|n| (value[n] - opposite[n]).abs() < 1e-13));
        }
    }

    #[test]
    fn continuous_over_the_edges_of_the_cube() {
        let table = DirectionTable::tabulate(|d| [(7.0 * d.x).cos() + d.y * d.z, d.z * d.z]);
        for k in 0..200 {
            let z = -1.0 + 0.01 * f64::from(k);
            for (a, b) in [(1.0, 1.0), (1.0, -1.0)] {
                let at = |e: f64| table.at(&Vec3::new(a + e, b - e * b, z).normalize());
                let (left, right) = (at(1e-9), at(-1e-9));
                assert!((0..2).all(|n| (left[n] - right[n]).abs() < 1e-7), "{z}: {left:?} {right:?}");
            }
        }
    }
}
