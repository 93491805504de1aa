//! F = 1.615 d^2 (rho mu / |omega|)^1/2 (w x omega) m(Re, beta), w = u - v, omega = curl u, Re = rho |w| d / mu.
//!
//! Saffman (1965, with the corrigendum of 1968: 6.46 (d/2)^2 = 1.615 d^2) for Re << Re_omega^1/2 << 1; Mei's m fits
//! Dandy and Dwyer's simulations: with beta = |omega| d / (2 |w|), m = (1 - 0.3314 beta^1/2) exp(-Re/10) + 0.3314
//! beta^1/2 up to Re = 40, 0.0524 (beta Re)^1/2 above (a jump of at most 0.0183 at Re = 40 is published). A body that
//! lags behind the flow is driven to where it is faster.

use crate::math::Vec3;

pub(crate) const SOURCE: &str =
    "Saffman 1965, J. Fluid Mech. 22, 385 and 1968, 31, 624; Mei 1992, Int. J. Multiphase Flow 18, 145";
pub(crate) const RANGE: &str = "spheres that do not spin, Re 0.1 to 100, |omega| d / (2 |w|) 0.005 to 0.4";

pub(crate) fn saffman_mei(diameter: f64, density: f64, viscosity: f64, w: &Vec3, vorticity: &Vec3) -> Vec3 {
    let (speed, omega) = (w.norm(), vorticity.norm());
    if speed == 0.0 || omega == 0.0 {
        return Vec3::zeros();
    }
    let reynolds = density * speed * diameter / viscosity;
    let root_beta = (0.5 * omega * diameter / speed).sqrt();
    let mei = if reynolds <= 40.0 {
        let far = 0.3314 * root_beta;
        (1.0 - far) * (-0.1 * reynolds).exp() + far
    } else {
        0.0524 * root_beta * reynolds.sqrt()
    };
    w.cross(vorticity) * (1.615 * diameter * diameter * (density * viscosity / omega).sqrt() * mei)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn creeping_shear() {
        // u = (g y, 0, 0): curl u = -g z; a lagging particle (w along +x) goes to +y, by 6.46 mu a^2 w (g/nu)^1/2
        let (g, a, rho, mu, w) = (4.0, 1e-4, 1000.0, 1e-3, 1e-6);
        let force = saffman_mei(2.0 * a, rho, mu, &Vec3::new(w, 0.0, 0.0), &Vec3::new(0.0, 0.0, -g));
        let saffman = 6.46 * mu * a * a * w * (g * rho / mu).sqrt();
        // Re = 2e-4: exp(-Re/10) = 1 - 2e-5, times 1 - 0.3314 beta^1/2 with beta = 400
        let root_beta = 20.0;
        let mei = (1.0 - 0.3314 * root_beta) * (-2e-5f64).exp() + 0.3314 * root_beta;
        assert!((force - Vec3::y() * (saffman * mei)).norm() < 1e-12 * saffman, "{force:?} {saffman}");
        assert!((mei - 1.0).abs() < 2e-4);
    }

    #[test]
    fn nothing_without_slip_or_shear() {
        let x = Vec3::x();
        assert_eq!(saffman_mei(1.0, 1.0, 1.0, &Vec3::zeros(), &x), Vec3::zeros());
        assert_eq!(saffman_mei(1.0, 1.0, 1.0, &x, &Vec3::zeros()), Vec3::zeros());
        // the published jump at Re = 40 is (1 - 0.3314 beta^1/2) exp(-4); beta = 0.1 at any Re here
        let mei = |re: f64| {
            let force = saffman_mei(1.0, 1.0, 1.0, &(x * re), &(Vec3::z() * 0.2 * re)).norm();
            force / (1.615 * 0.2f64.sqrt() * re.powf(1.5))
        };
        let jump = (1.0 - 0.3314 * 0.1f64.sqrt()) * (-4.0f64).exp();
        assert!((mei(40.0) - mei(40.001) - jump).abs() < 1e-4, "{} {}", mei(40.0), mei(40.001));
    }
}
