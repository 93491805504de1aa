//! Drag = (drag of one particle at the superficial velocity) eps^-chi, chi = 3.7 - 0.65 exp(-(1.5 - log10 Re)^2 / 2).
//!
//! The published force balances the weight less the buoyancy in the *suspension*, eps V (rho_s - rho_f) g: it leaves
//! the mean pressure gradient out and is model A's as it stands. With K w = 3 pi mu d f(Re) eps w eps^-chi,
//! K / (3 pi mu d) = f(Re) eps^(1 - chi). At eps = 1 the one-particle law.

use super::Swarm;

pub(crate) const SOURCE: &str = "Di Felice 1994, Int. J. Multiphase Flow 20, 153";
pub(crate) const RANGE: &str =
    "spheres, void fraction 0.4 to 1, Re 1e-2 to 1e4; other bodies by their one-particle law";

#[inline]
pub(crate) fn factor(swarm: &Swarm<'_>) -> f64 {
    // log10 0 would be minus infinity, whose exponential is 0 as it should be; below 1e-6 it is 0 to rounding anyway
    let off = 1.5 - swarm.reynolds.max(1e-12).log10();
    let chi = 3.7 - 0.65 * (-0.5 * off * off).exp();
    swarm.alone() * swarm.void_fraction.powf(1.0 - chi)
}
