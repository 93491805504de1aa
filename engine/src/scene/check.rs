//! What `sturz check` tells about a scene before it runs.

use serde::Serialize;

use super::auto_step::{STEPS_PER_CONTACT, contacts_per_body};
use super::{NormalLaw, Scene};
use crate::engine::Engine;
use crate::math::Vec3;

/// Plan, time scales and doubts.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
    /// Overlap of the heaviest particle resting on one point, over its bounding radius; `None` without gravity or
    /// particles, and with Hertz.
    pub resting_overlap_ratio: Option<f64>,
    /// Doubts, one sentence each.
    pub warnings: Vec<String>,
}

/// Steps per collision below which accuracy suffers (PHYSICS.md D).
const FEW_STEPS_PER_CONTACT: f64 = 20.0;

/// Overlap at rest over the bounding radius above which shapes count as too soft.
const LARGE_RESTING_OVERLAP: f64 = 0.05;

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
                duration / STEPS_PER_CONTACT
            ));
        }
        let contacts = contacts_per_body(self.description().normal_law());
        // a step chosen at this very bound must not warn for its rounding
        if dt * contacts.sqrt() > critical * (1.0 + 1e-12) {
            warnings.push(format!(
                "the step is {:.2} of the critical one of a single contact; several contacts on a body add up: stay below {:.2}",
                dt / critical,
                1.0 / contacts.sqrt()
            ));
        }
        let resting = self.resting_overlap_ratio();
        if let Some(ratio) = resting.filter(|&ratio| ratio > LARGE_RESTING_OVERLAP) {
            warnings.push(format!(
                "a particle rests on one point with an overlap of {:.1} % of its bounding radius: raise stiffness_n_per_m",
                100.0 * ratio
            ));
        }
        if let Some(ratio) = self.initial_overlap_ratio().filter(|&ratio| ratio > LARGE_RESTING_OVERLAP) {
            warnings.push(format!(
                "particles overlap by up to {:.0} % of their bounding radius at the start and will fly apart: place them apart, or give [relax]",
                100.0 * ratio
            ));
        }
        warnings.extend(self.resolution().and_then(|resolution| resolution.warning()));
        SceneCheck {
            plan: self.plan().lines.clone(),
            particles: self.particles().len() as u64,
            time_step_s: dt,
            critical_time_step_s: critical,
            contact_duration_s: duration,
            resting_overlap_ratio: resting,
            warnings,
        }
    }

    /// Largest overlap at the start over the smaller bounding radius; `None` where it is relaxed.
    fn initial_overlap_ratio(&self) -> Option<f64> {
        if self.description().relax.is_some() || self.particles().is_empty() {
            return None;
        }
        Some(Engine::new(self.clone()).sums.largest_ratio)
    }

    /// Largest overlap of a particle resting on one point, over its bounding radius; over all shapes and materials
    /// at unit scale while there are no particles.
    fn resting_overlap_ratio(&self) -> Option<f64> {
        if self.description().normal_law() == NormalLaw::Hertz {
            return None;
        }
        let gravity = Vec3::from(self.description().scene.gravity_m_per_s2).norm();
        let softest = |material: usize| {
            let walls = self.boundaries().iter().map(|boundary| boundary.material as usize);
            walls
                .chain([material])
                .filter_map(|other| self.pairs().get(material, other))
                .map(|law| law.stiffness)
                .fold(f64::INFINITY, f64::min)
        };
        let ratio = |material: usize, mass: f64, radius: f64| mass * gravity / softest(material) / radius;
        let present = self.particles().iter().map(|p| ratio(p.material as usize, p.mass, p.radius)).reduce(f64::max);
        let possible = || {
            let solid = self.description().materials.iter().enumerate();
            let solid = solid.filter_map(|(m, material)| Some((m, material.density_kg_per_m3?)));
            solid
                .flat_map(|(m, density)| self.shapes().iter().map(move |shape| (m, density, shape)))
                .map(|(m, density, shape)| ratio(m, density * shape.mass_properties().volume, shape.bounding_radius()))
                .reduce(f64::max)
        };
        present.or_else(possible).filter(|&ratio| ratio > 0.0)
    }
}
