//! The energy balance: what is stored, what was taken out, what was put in.

use crate::checkpoint::codec::pack_fields;
use crate::contact::Sums;
use crate::engine::Engine;
use crate::math::Vec3;

/// Energies stored now, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MechanicalEnergy {
    pub translation: f64,
    pub rotation: f64,
    pub potential: f64,
    pub elastic: f64,
}

impl MechanicalEnergy {
    pub fn total(&self) -> f64 {
        self.translation + self.rotation + self.potential + self.elastic
    }
}

/// Integrals over the run, J.
///
/// Powers are integrated by the trapezoidal rule: in velocity Verlet the force of a full step acts half in the step
/// before and half in the step after it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Ledger {
    pub initial: f64,
    pub dissipated_normal: f64,
    pub dissipated_friction: f64,
    pub dissipated_local: f64,
    pub work_boundaries: f64,
    pub work_commands: f64,
    pub work_loads: f64,
    last: Sums,
}

pack_fields!(Ledger {
    initial: f64,
    dissipated_normal: f64,
    dissipated_friction: f64,
    dissipated_local: f64,
    work_boundaries: f64,
    work_commands: f64,
    work_loads: f64,
    last: Sums,
});

impl Ledger {
    /// Forces were evaluated anew without a step.
    pub fn restart(&mut self, sums: &Sums) {
        self.last = *sums;
    }

    /// A step of length `dt` led to `sums`.
    pub fn add(&mut self, sums: &Sums, dt: f64) {
        let half = 0.5 * dt;
        let last = &self.last;
        self.dissipated_normal += half * (last.power_normal + sums.power_normal) + sums.lost_bonds;
        // Work of tangential forces that is not in a spring is gone, that of a lost contact's spring included.
        self.dissipated_friction += half * (last.power_tangential + sums.power_tangential)
            - (sums.elastic_tangential - last.elastic_tangential);
        self.work_boundaries += half * (last.power_boundaries + sums.power_boundaries);
        self.last = *sums;
    }
}

impl Engine {
    /// Energies stored now, summed in the order of ids; without those of frozen particles, which are like boundaries.
    pub(crate) fn mechanical_energy(&self) -> MechanicalEnergy {
        let particles = &self.particles;
        let cell = self.scene.cell();
        let mut energy = MechanicalEnergy {
            elastic: self.sums.elastic_normal + self.sums.elastic_tangential,
            ..MechanicalEnergy::default()
        };
        for row in particles.rows_by_id() {
            let row = row as usize;
            if particles.is_frozen(row) {
                continue;
            }
            let mass = particles.mass[row];
            energy.translation += 0.5 * mass * particles.velocity[row].norm_squared();
            let momentum_in_body = particles.rotation[row].tr_mul(&particles.angular_momentum[row]);
            let rate_in_body: Vec3 = momentum_in_body.component_div(&particles.inertia[row]);
            energy.rotation += 0.5 * momentum_in_body.dot(&rate_in_body);
            let x = cell.unwrapped(&particles.position[row], particles.image[row]);
            energy.potential -= mass * self.gravity.dot(&x);
        }
        energy
    }
}
