//! Torque on a rotating sphere: T = C_T 1/2 rho (d/2)^5 W^2, W the relative angular velocity, Re_W = rho W d^2 / mu,
//! C_T = 64 pi / Re_W (Stokes, T = pi mu d^3 W) at small Re_W and 12.9 Re_W^-1/2 + 128.4 / Re_W from 32 to 1000.
//!
//! As a factor over Stokes: max(1, (12.9 Re_W^1/2 + 128.4) / (64 pi)). The larger of the two instead of the published
//! switch at Re_W = 32, where they differ by 0.2 %: continuous (they meet at 31.7).

use std::f64::consts::PI;

pub(crate) const SOURCE: &str = "Dennis, Singh and Ingham 1980, J. Fluid Mech. 101, 257";
pub(crate) const RANGE: &str =
    "spheres in a fluid at rest, rho W d^2 / mu < 1000; other bodies count as spheres of the same volume";
pub(crate) const STOKES_RANGE: &str = "spheres, rho W d^2 / mu < 30; other bodies count as spheres of the same volume";

#[inline]
pub(crate) fn factor(reynolds: f64) -> f64 {
    ((12.9 * reynolds.sqrt() + 128.4) / (64.0 * PI)).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meets_stokes() {
        assert_eq!(factor(0.0), 1.0);
        assert_eq!(factor(31.0), 1.0);
        assert!((factor(32.0) - 1.0016).abs() < 1e-4);
        // C_T = 12.9/10 + 1.284 at Re = 100
        assert!((factor(100.0) * 64.0 * PI / 100.0 - 2.574).abs() < 1e-12);
    }
}
