//! Adhesion after Johnson, Kendall and Roberts: an elastic contact of two balls that hold on to each other.

use std::f64::consts::PI;

/// Two balls, or a ball and a plane, with an energy of adhesion.
///
/// With the radius of contact a: overlap d = a^2/R - sqrt(2 pi w a/E*), F = 4 E* a^3/(3 R) - sqrt(8 pi w E* a^3),
/// positive where it repels. w (J/m2) is the work of adhesion, twice the surface energy of equal materials; R (m), 1/R =
/// 1/r_a + 1/r_b; E* (Pa) of [`super::HertzPair`]. In units of the radius of contact at which it breaks, a_c^3 = pi w R^2/
/// (8 E*), and with u^2 = a/a_c: d = a_c^2/R (u^4 - 4 u), F = pi w R (u^6/6 - u^3), W = pi w a_c^2 (u^10/15 - 2/3 u^7 + u^4).
///
/// A contact is made at d = 0 (u^3 = 4, F = -4/3 pi w R) and holds down to d_c = -3 a_c^2/R (u = 1); on the way it pulls
/// with 3/2 pi w R at most (u^3 = 3). Making it turns 0.6 pi w a(0)^2 of surface energy into heat and waves, breaking it
/// 0.4 pi w a_c^2 of elastic energy: see [`Jkr::lost_when_made`]. For soft, large balls (Tabor's parameter
/// (R w^2/(E*^2 z0^3))^(1/3) well above 1, z0 the range of the attraction) and a << R. w = 0 is Hertz.
/// Source: Johnson, Kendall and Roberts, Proc. R. Soc. Lond. A 324 (1971) 301.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jkr {
    /// pi w R, N.
    pull: f64,
    /// a_c^2/R, m.
    unit: f64,
    /// 2 E* a_c, N/m.
    stiffness: f64,
}

impl Jkr {
    /// Of a work of adhesion above 0 (J/m2), E* (Pa) and R (m).
    #[inline]
    pub fn new(work_of_adhesion: f64, modulus: f64, radius: f64) -> Self {
        let pull = PI * work_of_adhesion * radius;
        let breaking = (0.125 * pull * radius / modulus).cbrt();
        Self { pull, unit: breaking * breaking / radius, stiffness: 2.0 * modulus * breaking }
    }

    /// d_c, at which a contact breaks, m: below 0.
    pub fn overlap_at_breaking(&self) -> f64 {
        -3.0 * self.unit
    }

    /// Largest pull, N.
    pub fn pull_off_force(&self) -> f64 {
        1.5 * self.pull
    }

    /// u at an overlap, at least 1: by Newton from above, where u^4 - 4 u is convex and rises.
    #[inline]
    fn root(&self, overlap: f64) -> f64 {
        let wanted = overlap / self.unit;
        // u^2 = 4^(2/3) at d = 0, below (d R/a_c^2)^(1/2) + 4^(2/3) beyond
        let mut u = (wanted.max(0.0).sqrt() + 2.519_842_099_789_747).sqrt();
        // each step doubles the digits; at the double root of d_c it halves the error
        for _ in 0..64 {
            let cube = u * u * u;
            let slope = 4.0 * (cube - 1.0);
            let step = (cube * u - 4.0 * u - wanted) / slope;
            if step <= f64::EPSILON * u {
                break;
            }
            u -= step;
        }
        u.max(1.0)
    }

    /// Repulsion (N) and energy (J; 0 of parts that do not touch) at an overlap (m).
    #[inline]
    pub fn at(&self, overlap: f64) -> (f64, f64) {
        let u = self.root(overlap);
        (self.force(u * u * u), self.energy(u))
    }

    fn force(&self, cube: f64) -> f64 {
        self.pull * cube * (cube / 6.0 - 1.0)
    }

    fn energy(&self, u: f64) -> f64 {
        let cube = u * u * u;
        self.pull * self.unit * cube * u * (cube * (cube / 15.0 - 2.0 / 3.0) + 1.0)
    }

    /// -W(0), J.
    pub fn lost_when_made(&self) -> f64 {
        -self.at(0.0).1
    }

    /// W(d_c), J.
    pub fn lost_when_broken(&self) -> f64 {
        self.energy(1.0)
    }

    /// dF/dd at an overlap, or at that of no force, where it is larger, N/m.
    pub fn stiffness_at(&self, overlap: f64) -> f64 {
        let without_force = 6f64.cbrt() * 2.0 * self.unit;
        let u = self.root(overlap.max(without_force));
        let cube = u * u * u;
        self.stiffness * u * u * (cube - 3.0) / (cube - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const W: f64 = 0.2;
    const MODULUS: f64 = 1e7;
    const RADIUS: f64 = 1e-3;

    fn bond() -> Jkr {
        Jkr::new(W, MODULUS, RADIUS)
    }

    /// a with d(a) = overlap, by bisection of the formula of 1971.
    fn contact_radius(overlap: f64) -> f64 {
        let least = (PI * W * RADIUS * RADIUS / (8.0 * MODULUS)).cbrt();
        let (mut low, mut high) = (least, 10.0 * RADIUS);
        for _ in 0..200 {
            let a = 0.5 * (low + high);
            if a * a / RADIUS - (2.0 * PI * W * a / MODULUS).sqrt() < overlap { low = a } else { high = a }
        }
        low
    }

    #[test]
    fn force_is_that_of_the_formula() {
        let unit = bond().unit;
        for overlap in [-2.9, -1.0, 0.0, 0.3, 3.0, 1e2, 1e4].map(|d| d * unit) {
            let a = contact_radius(overlap);
            let exact = 4.0 * MODULUS * a.powi(3) / (3.0 * RADIUS) - (8.0 * PI * W * MODULUS * a.powi(3)).sqrt();
            let (force, _) = bond().at(overlap);
            // both terms, of which little may be left
            assert!((force - exact).abs() < 1e-11 * (exact.abs() + PI * W * RADIUS), "{overlap}: {force} {exact}");
        }
    }

    /// F = dW/dd, d the overlap.
    #[test]
    fn force_is_the_gradient_of_the_energy() {
        let unit = bond().unit;
        for overlap in [-2.5, -1.0, -1e-3, 0.0, 0.3, 3.0, 1e2, 1e4].map(|d| d * unit) {
            let h = 1e-4 * (unit + 1e-2 * overlap.abs());
            let slope = (bond().at(overlap + h).1 - bond().at(overlap - h).1) / (2.0 * h);
            let force = bond().at(overlap).0;
            assert!((slope - force).abs() < 1e-6 * (force.abs() + bond().pull), "{overlap}: {slope} {force}");
        }
    }

    /// The stiffness is dF/dd where it counts, and no smaller than Hertz's.
    #[test]
    fn stiffness_is_the_slope_of_the_force() {
        for overlap in [4.0, 30.0, 1e3, 1e5].map(|d| d * bond().unit) {
            let h = 1e-4 * overlap;
            let slope = (bond().at(overlap + h).0 - bond().at(overlap - h).0) / (2.0 * h);
            assert!((bond().stiffness_at(overlap) / slope - 1.0).abs() < 1e-6, "{overlap}");
            assert!(slope > 2.0 * MODULUS * (RADIUS * overlap).sqrt() * (1.0 - 0.1), "{overlap}");
        }
    }

    /// The least force along the branch is -3/2 pi w R, at u^3 = 3; at d = 0 it is 8/9, where it breaks 5/9 of that.
    #[test]
    fn pull_off_force_is_exact() {
        let pull = 1.5 * PI * W * RADIUS;
        let at_cube = |cube: f64| bond().at(bond().unit * (cube.powf(4.0 / 3.0) - 4.0 * cube.cbrt())).0;
        assert!((at_cube(3.0) / -pull - 1.0).abs() < 1e-14);
        assert!((bond().pull_off_force() / pull - 1.0).abs() < 1e-15);
        let least = (0..4000).map(|k| bond().at(bond().unit * (f64::from(k) * 1e-3 - 3.0)).0).fold(0.0, f64::min);
        assert!(least >= -pull * (1.0 + 1e-14) && least < -pull * (1.0 - 1e-6), "{least} {pull}");
        assert!((bond().at(0.0).0 / pull + 8.0 / 9.0).abs() < 1e-14);
        // the double root at d_c is known to the root of the rounding
        assert!((bond().at(bond().overlap_at_breaking()).0 / pull + 5.0 / 9.0).abs() < 1e-7);
    }

    /// What is lost on a way in and out is the area between making and breaking.
    #[test]
    fn losses_are_the_loop() {
        let (n, depth) = (200_000, bond().overlap_at_breaking());
        let h = -depth / f64::from(n);
        let work: f64 = (0..n).map(|k| bond().at(depth + (f64::from(k) + 0.5) * h).0 * h).sum();
        let lost = bond().lost_when_made() + bond().lost_when_broken();
        assert!((lost / -work - 1.0).abs() < 1e-5, "{lost} {work}");
    }
}
