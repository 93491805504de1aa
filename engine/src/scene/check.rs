//! What `sturz check` tells about a scene before it runs.

use super::Scene;
use crate::math::Vec3;

/// Plan, time scales and doubts.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCheck {
    /// What a step does and leaves out.
    pub plan: Vec<String>,
    /// Particles at the start.
    pub particles: u64,
    /// Step that will be used, s.
    pub time_step_s: f64,
    /// Largest stable step of a single contact, s; infinite where nothing can meet.
    pub critical_time_step_s: f64,
    /// Shortest collision, s; infinite where nothing can meet.
    pub contact_duration_s: f64,
    /// Doubts, one sentence each.
    pub warnings: Vec<String>,
}

/// Steps per collision below which accuracy suffers (PHYSICS.md D).
const FEW_STEPS_PER_CONTACT: f64 = 20.0;

/// Contacts on one body add: the step should stay below the critical one by the root of this number.
const CONTACTS_PER_BODY: f64 = 12.0;

impl Scene {
    /// Plan, time scales and doubts.
    pub fn check(&self) -> SceneCheck {
        let bounds = self.contact_bounds(self.particles());
        let critical = bounds.map_or(f64::INFINITY, |b| b.critical_time_step_s);
        let duration = bounds.map_or(f64::INFINITY, |b| b.duration_s);
        let dt = self.time_step_s();
        let mut warnings = Vec::new();
        if duration / dt < FEW_STEPS_PER_CONTACT {
            warnings.push(format!(
                "a collision lasts {:.1} steps; below {FEW_STEPS_PER_CONTACT} its restitution is inaccurate: reduce time_step_s to {:e} s",
                duration / dt,
                duration / 50.0
            ));
        }
        if dt * CONTACTS_PER_BODY.sqrt() > critical {
            warnings.push(format!(
                "the step is {:.2} of the critical one of a single contact; with {CONTACTS_PER_BODY} contacts on a body it is unstable: stay below {:.2}",
                dt / critical,
                1.0 / CONTACTS_PER_BODY.sqrt()
            ));
        }
        let (low, high) =
            self.particles().iter().map(|p| p.radius).fold((f64::INFINITY, 0.0f64), |(l, h), r| (l.min(r), h.max(r)));
        if high > 5.0 * low {
            warnings.push(format!(
                "bounding radii span a factor of {:.0}: the neighbour grid has one level, so the search will be slow",
                high / low
            ));
        }
        self.warn_of_overlap(&mut warnings);
        SceneCheck {
            plan: self.plan().lines.clone(),
            particles: self.particles().len() as u64,
            time_step_s: dt,
            critical_time_step_s: critical,
            contact_duration_s: duration,
            warnings,
        }
    }

    /// Overlap of the heaviest particle resting on one point.
    fn warn_of_overlap(&self, warnings: &mut Vec<String>) {
        let gravity = Vec3::from(self.description().scene.gravity_m_per_s2).norm();
        for (k, particle) in self.particles().iter().enumerate() {
            let softest = self
                .boundaries()
                .iter()
                .filter_map(|b| self.pairs().get(particle.material as usize, b.material as usize))
                .chain(self.pairs().get(particle.material as usize, particle.material as usize))
                .map(|law| law.stiffness)
                .fold(f64::INFINITY, f64::min);
            let ratio = particle.mass * gravity / softest / particle.radius;
            if ratio > 0.05 {
                warnings.push(format!(
                    "particle {k} rests on one point with an overlap of {:.1} % of its bounding radius: raise stiffness_n_per_m",
                    100.0 * ratio
                ));
                return;
            }
        }
    }
}
