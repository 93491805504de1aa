//! C_D = 24/Re (1 + 0.15 Re^0.687), and 0.44 from Re of about 1000 on (Newton's range).
//!
//! f = max(1 + 0.15 Re^0.687, 0.44 Re / 24). The larger of the two instead of a switch at Re = 1000, where they differ
//! by 0.4 %: so K is continuous and does not fall with Re. They meet at Re = 988.9.

pub(crate) const SOURCE: &str = "Schiller and Naumann 1933, Z. Ver. Deutsch. Ing. 77, 318";
pub(crate) const RANGE: &str = "spheres, Re < 1000 (5 %); C_D = 0.44 from there to 2e5 (drag crisis, not modelled)";

#[inline]
pub(crate) fn factor(reynolds: f64) -> f64 {
    (1.0 + 0.15 * reynolds.powf(0.687)).max(0.44 / 24.0 * reynolds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_standard_drag_curve() {
        // Clift, Grace and Weber 1978, table 5.2: C_D = 4.26 at 10, 1.09 at 100, 0.46 at 1000; the law is within 6 %
        for (reynolds, expected) in [(10.0, 4.26), (100.0, 1.09), (1000.0, 0.46), (1e4, 0.42)] {
            let c_d = factor(reynolds) * 24.0 / reynolds;
            assert!((c_d / expected - 1.0).abs() < 0.06, "{reynolds}: {c_d}, not {expected}");
        }
        assert_eq!(factor(0.0), 1.0);
        let (below, above) = (factor(988.8), factor(989.1));
        assert!((above / below - 1.0).abs() < 4e-4, "{below} {above}");
    }
}
