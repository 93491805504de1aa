//! F = 10 phi/eps^2 + eps^2 (1 + 1.5 phi^1/2)
//!   + 0.413 Re/(24 eps^2) (1/eps + 3 phi eps + 8.4 Re^-0.343) / (1 + 10^(3 phi) Re^-(1 + 4 phi)/2).
//!
//! F is the drag over 3 pi mu d U with U = eps w, *without* the mean pressure gradient: the paper states F_d = eps times
//! the whole force, and its first term is Carman and Kozeny's 180 phi^2 mu U/(eps^3 d^2) times eps. So it is model A's:
//! K / (3 pi mu d) = eps F. At Re = 0 and eps = 1 Stokes' law; at finite Re its dilute limit
//! is *not* the drag of one sphere: Schiller and Naumann's times 0.94 at Re = 1 and 10, 1.16 at 100, 1.69 at 1000.
//! The chosen one-particle law has no part in it: bodies count as spheres of the same volume.

use super::Swarm;

pub(crate) const SOURCE: &str = "Beetstra, van der Hoef and Kuipers 2007, AIChE J. 53, 489";
pub(crate) const RANGE: &str = "spheres, void fraction 0.4 to 0.9, Re < 1000; the one-particle law is not used";

#[inline]
pub(crate) fn factor(swarm: &Swarm<'_>) -> f64 {
    let (eps, re) = (swarm.void_fraction, swarm.reynolds);
    let phi = 1.0 - eps;
    let eps2 = eps * eps;
    let at_rest = 10.0 * phi / eps2 + eps2 * (1.0 + 1.5 * phi.sqrt());
    // numerator times Re and fraction times Re^(...): no negative powers of Re, which may be 0
    let growth = re.powf(0.5 * (1.0 + 4.0 * phi));
    let inertial = (re * (1.0 / eps + 3.0 * phi * eps) + 8.4 * re.powf(0.657)) * growth
        / (growth + (3.0 * std::f64::consts::LN_10 * phi).exp());
    eps * (at_rest + 0.413 / (24.0 * eps2) * inertial)
}
