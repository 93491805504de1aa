//! Ergun's law in dense beds, Wen and Yu's in dilute ones.
//!
//! Ergun (1952): -dp/dx = 150 phi^2 mu U / (eps^3 psi^2 d^2) + 1.75 phi rho U^2 / (eps^3 psi d), with U = eps w. By
//! eps (-dp/dx) = phi K w / V: K = V (150 phi mu / (eps psi^2 d^2) + 1.75 rho |w| / (psi d)), so that
//! K / (3 pi mu d) = (150 phi / (eps psi^2) + 1.75 Re / (eps psi)) / 18.
//!
//! Wen and Yu (1966): K / (3 pi mu d) = f(Re) eps^-2.65. Published with Schiller and Naumann's f; here f is the chosen
//! one-particle law's.
//!
//! Gidaspow switches at eps = 0.8, with a jump. Here the two are mixed by a cubic step (3 s^2 - 2 s^3) from eps = 0.75
//! to 0.85: exactly Ergun below, exactly Wen and Yu above. (Huilin and Gidaspow 2003, Chem. Eng. Sci. 58, 3777, mix them
//! by an arctangent, which leaves 2.4 % of the other law at 0.75.) Both are model A's: Gidaspow's set A.

use super::Swarm;

pub(crate) const SOURCE: &str = "Gidaspow 1994, Multiphase Flow and Fluidization, ch. 2; Ergun 1952, Chem. Eng. Prog. 48, 89; \
                                 Wen and Yu 1966, Chem. Eng. Prog. Symp. Ser. 62, 100";
pub(crate) const RANGE: &str = "Ergun: packed beds, void fraction 0.36 to 0.75, Re/(1 - eps) 1 to 2500, any grains by their \
                                sphericity; Wen and Yu: void fraction 0.85 to 1; in between a mixture";

/// Void fractions where the mixture begins and ends.
const MIXED: [f64; 2] = [0.75, 0.85];

#[inline]
pub(crate) fn factor(swarm: &Swarm<'_>) -> f64 {
    let dilute = ((swarm.void_fraction - MIXED[0]) / (MIXED[1] - MIXED[0])).clamp(0.0, 1.0);
    if dilute == 0.0 {
        return ergun(swarm);
    }
    let wen_yu = swarm.alone() * swarm.void_fraction.powf(-2.65);
    if dilute == 1.0 {
        return wen_yu;
    }
    let weight = dilute * dilute * (3.0 - 2.0 * dilute);
    ergun(swarm) + weight * (wen_yu - ergun(swarm))
}

#[inline]
fn ergun(swarm: &Swarm<'_>) -> f64 {
    let (eps, psi) = (swarm.void_fraction, swarm.shape.sphericity());
    (150.0 * (1.0 - eps) / psi + 1.75 * swarm.reynolds) / (eps * psi) * super::VOLUME_OVER_STOKES
}
