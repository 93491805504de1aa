//! C_D = 8/Re phi_l^-1/2 + 16/Re phi^-1/2 + 3 Re^-1/2 phi^-3/4 + 0.42 10^(0.4 (-log10 phi)^0.2) / phi_c
//!
//! with the sphericity phi, the lengthwise sphericity phi_l and the crosswise sphericity phi_c (see
//! [`HydroShape`](super::HydroShape)); the last two depend on the orientation.
//! f = 1/3 phi_l^-1/2 + 2/3 phi^-1/2 + 1/8 Re^1/2 phi^-3/4 + 0.42/24 10^(...) Re / phi_c.

pub(crate) const SOURCE: &str = "Hölzer and Sommerfeld 2008, Powder Technol. 184, 361; eq. 10";
pub(crate) const RANGE: &str = "bodies of any shape and orientation, Re below the drag crisis";

/// What of the law does not depend on the orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HolzerSommerfeld {
    /// 2/3 phi^-1/2.
    friction: f64,
    /// 1/8 phi^-3/4.
    intermediate: f64,
    /// 0.42/24 10^(0.4 (-log10 phi)^0.2).
    newton: f64,
}

/// -log10 of a sphericity; 0 for a sphere, whose sphericity may be 1 to rounding only.
pub(crate) fn minus_log10(sphericity: f64) -> f64 {
    if sphericity > 1.0 - 1e-9 { 0.0 } else { -sphericity.log10() }
}

impl HolzerSommerfeld {
    pub fn of(sphericity: f64) -> Self {
        Self {
            friction: 2.0 / 3.0 / sphericity.sqrt(),
            intermediate: 0.125 * sphericity.powf(-0.75),
            newton: 0.42 / 24.0 * 10f64.powf(0.4 * minus_log10(sphericity).powf(0.2)),
        }
    }

    #[inline]
    pub fn factor(&self, reynolds: f64, lengthwise: f64, crosswise: f64) -> f64 {
        1.0 / (3.0 * lengthwise.sqrt())
            + self.friction
            + self.intermediate * reynolds.sqrt()
            + self.newton * reynolds / crosswise
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres() {
        let law = HolzerSommerfeld::of(1.0);
        assert_eq!(law.factor(0.0, 1.0, 1.0), 1.0);
        for re in [1e-3f64, 1.0, 100.0, 1e4] {
            let c_d = 24.0 / re + 3.0 / re.sqrt() + 0.42;
            assert!((law.factor(re, 1.0, 1.0) * 24.0 / re / c_d - 1.0).abs() < 1e-14);
        }
    }
}
