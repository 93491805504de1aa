//! What the guards see now: read when one has warned, so a step does not pay for it.

use crate::engine::{DEEP_ROUNDING, Engine, FAST, LARGE_OVERLAP};
use crate::integrate::present_critical_step;
use crate::report::WarningCounts;
use crate::scene::NormalLaw;

/// What a guard warns of; the first four are counted in [`WarningCounts`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guard {
    /// Overlap over the smaller bounding radius.
    LargeOverlap,
    /// Way in a step over the bounding radius.
    FastParticle,
    /// Generalized overlap over the mean rounding radius.
    DeepRounding,
    /// Rotations whose implicit equation did not converge.
    RotationNotConverged,
    /// Time step, s, above the critical one of the contacts that are there.
    TimeStep,
}

/// The worst there is now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuardReading {
    /// Whose it is; of a pair the lower id.
    pub particle: Option<u64>,
    /// As [`Guard`] says; 0 for rotations.
    pub value: f64,
    /// Above which it warns.
    pub limit: f64,
}

impl WarningCounts {
    /// Of one guard; 0 for the time step.
    pub fn of(&self, guard: Guard) -> u64 {
        match guard {
            Guard::LargeOverlap => self.large_overlap,
            Guard::FastParticle => self.fast_particle,
            Guard::DeepRounding => self.deep_rounding,
            Guard::RotationNotConverged => self.rotation_not_converged,
            Guard::TimeStep => 0,
        }
    }
}

impl Engine {
    /// Troubles counted since the start.
    pub fn warnings(&self) -> WarningCounts {
        self.warnings
    }

    /// What a guard sees after the last step.
    pub fn guard_reading(&self, guard: Guard) -> GuardReading {
        let of_slot = |value: f64, slot: u32, limit: f64| GuardReading {
            particle: (value > 0.0).then(|| self.sides(slot).0),
            value,
            limit,
        };
        match guard {
            Guard::LargeOverlap => of_slot(self.sums.largest_ratio, self.sums.largest_slot, LARGE_OVERLAP),
            Guard::DeepRounding => of_slot(self.sums.largest_rounding, self.sums.rounding_slot, DEEP_ROUNDING),
            Guard::FastParticle => self.fastest(),
            Guard::RotationNotConverged => GuardReading { particle: None, value: 0.0, limit: 0.0 },
            Guard::TimeStep => {
                GuardReading { particle: None, value: self.clock.time_step_s(), limit: self.present_critical_step() }
            }
        }
    }

    /// The particle that would go farthest in a step at its present velocity, of its bounding radius; the lowest id of several.
    fn fastest(&self) -> GuardReading {
        let (particles, dt) = (&self.particles, self.clock.time_step_s());
        let mut worst = GuardReading { particle: None, value: 0.0, limit: FAST };
        for row in 0..particles.n_owned() {
            let (id, way) = (particles.ids[row], particles.velocity[row].norm() * dt / particles.radius[row]);
            if way > worst.value || (way == worst.value && worst.particle.is_some_and(|other| id < other)) {
                worst = GuardReading { particle: Some(id), value: way, limit: FAST };
            }
        }
        worst
    }

    /// Infinite under Hertz, whose stiffness has no bound.
    pub(crate) fn present_critical_step(&self) -> f64 {
        match self.scene.description().normal_law() {
            NormalLaw::Hertz => f64::INFINITY,
            _ => present_critical_step(&self.particles, &self.contacts, &self.scene),
        }
    }
}
