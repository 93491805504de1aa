//! Effective mass of a contact, rotation included: what its damping must be calibrated for.

use super::evaluate::Pair;
use super::table::Contact;
use crate::math::Vec3;
use crate::particles::Particles;

/// 1/m_eff (1/kg) of the motion along the contact's own direction, and the sum W of the points' weights.
///
/// 1/m_eff = F.F (1/m_a + 1/m_b) + T_a . I_a^-1 T_a + T_b . I_b^-1 T_b with F = sum w_i n_i / W and T = sum w_i r_i x n_i / W:
/// the force of equal overlaps, per unit of the scalar force. For one point that is 1/m + (r x n) . I^-1 (r x n). One mass for the
/// whole manifold, not one per point: a corner of a face gives way four times as easily as the cube, so damping each
/// corner for its own mass would leave a central face hit with half of its dashpot (e = 0.5 asked, 0.71 got).
pub(super) fn inverse_mass(pair: &Pair<'_>, group: &[Contact], particles: &Particles) -> (f64, f64) {
    let (mut force, mut torque_a, mut torque_b, mut weights) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros(), 0.0);
    for contact in group {
        let push = contact.normal * contact.weight;
        force += push;
        torque_a += contact.arm.cross(&push);
        if let Some((_, centre)) = pair.b {
            torque_b += (contact.arm - centre).cross(&push);
        }
        weights += contact.weight;
    }
    let of = |row: usize, torque: &Vec3| inverse_mass_of(particles, row, &force, torque);
    let of_b = pair.b.map_or(0.0, |(b, _)| of(b, &torque_b));
    ((of(pair.a, &torque_a) + of_b) / (weights * weights), weights)
}

/// F.F/m + T . I^-1 T of one row: how fast it gives way to a unit of a scalar force, 1/kg; 0 where it is frozen.
#[inline(always)]
fn inverse_mass_of(particles: &Particles, row: usize, force: &Vec3, torque: &Vec3) -> f64 {
    if particles.is_frozen(row) {
        return 0.0;
    }
    let in_body = particles.rotation[row].tr_mul(torque);
    let turning = in_body.dot(&in_body.component_div(&particles.inertia[particles.owner(row)]));
    force.norm_squared() / particles.mass[row] + turning
}
