//! Linear spring and dashpot.

use crate::scene::ContactEnd;

/// Normal force of one point and the power that it takes out of the motion beyond the spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalForce {
    /// N, positive when it pushes.
    pub force: f64,
    /// W.
    pub dissipated_power: f64,
}

/// F = k d + c d', d the overlap (m), d' the approach speed (m/s); energy of the spring k d^2 / 2.
///
/// With [`ContactEnd::Clip`] never below 0. Source: Cundall and Strack (1979); ends of contact after Schwager and
/// Poeschel (2007).
#[inline(always)]
pub fn normal_force(stiffness: f64, damping: f64, overlap: f64, approach_speed: f64, end: ContactEnd) -> NormalForce {
    let spring = stiffness * overlap;
    let damped = spring + damping * approach_speed;
    let force = match end {
        ContactEnd::Clip => damped.max(0.0),
        ContactEnd::Tension => damped,
    };
    NormalForce { force, dissipated_power: (force - spring) * approach_speed }
}
