//! F = f(Re)/eps^3 + F_phi + F_phi,Re with F_phi = 5.81 phi/eps^3 + 0.48 phi^1/3/eps^4 and
//! F_phi,Re = phi^3 Re (0.95 + 0.61 phi^3/eps^2).
//!
//! F is the *whole* mean force on a particle, mean pressure gradient included, over 3 pi mu d eps |w|. So model A has
//! K w = eps F 3 pi mu d eps w: K / (3 pi mu d) = eps^2 F = f(Re)/eps + eps^2 (F_phi + F_phi,Re). Published with
//! Schiller and Naumann's f; here f is the chosen one-particle law's. At eps = 1 the one-particle law.

use super::Swarm;

pub(crate) const SOURCE: &str = "Tenneti, Garg and Subramaniam 2011, Int. J. Multiphase Flow 37, 1072";
pub(crate) const RANGE: &str = "spheres, void fraction 0.5 to 0.9, Re 0.01 to 300";

#[inline]
pub(crate) fn factor(swarm: &Swarm<'_>) -> f64 {
    let (eps, re) = (swarm.void_fraction, swarm.reynolds);
    let phi = 1.0 - eps;
    let (eps2, phi3) = (eps * eps, phi * phi * phi);
    let at_rest = 5.81 * phi / (eps2 * eps) + 0.48 * phi.cbrt() / (eps2 * eps2);
    let inertial = phi3 * re * (0.95 + 0.61 * phi3 / eps2);
    swarm.alone() / eps + eps2 * (at_rest + inertial)
}
