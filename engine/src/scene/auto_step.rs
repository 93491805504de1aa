//! The time step that the engine chooses, and what is left of the critical one where contacts add up.

use super::NormalLaw;
use crate::integrate::critical_step::ContactBounds;

/// Steps per collision at which restitution is accurate (PHYSICS.md D).
pub(super) const STEPS_PER_CONTACT: f64 = 50.0;

/// What the contacts on one body add up to, as a factor of the stiffness of one: the step should stay below the
/// critical one of a single contact by the root of it.
pub(super) fn contacts_per_body(law: NormalLaw) -> f64 {
    match law {
        NormalLaw::Linear | NormalLaw::FeaturePairs | NormalLaw::Hertz => 12.0,
        // Its bound counts all contacts of a pair in: packings were stable up to 0.95 of it.
        NormalLaw::GeneralizedOverlap | NormalLaw::Volume => 1.1,
    }
}

/// The step of `time_step = "auto"`, s.
pub(super) fn chosen_time_step(bounds: &ContactBounds, law: NormalLaw) -> f64 {
    let most = match law {
        NormalLaw::Linear | NormalLaw::FeaturePairs | NormalLaw::Hertz => contacts_per_body(law).sqrt().recip(),
        // below the 0.95 above, for a margin
        NormalLaw::GeneralizedOverlap | NormalLaw::Volume => 0.8,
    };
    (bounds.duration_s / STEPS_PER_CONTACT).min(most * bounds.critical_time_step_s)
}
