//! `[[inflow]]`: particles that come in over time, through an insertion window.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::validate::Problems;
use super::{InsertionDescription, Placement, Region, ScaleLaw, ScaleSection, Scene};
use crate::insertion;
use crate::particles::NewParticle;

/// `[[inflow]]`: batches of particles at random places and orientations in a region, without overlap, until an amount or a
/// time is reached. What finds no room is owed and tried again with the next batch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InflowDescription {
    /// For events.
    #[serde(default)]
    pub name: String,
    /// Name of the shape.
    pub shape: String,
    /// Name of the material.
    pub material: String,
    /// Where particles come in: wholly inside.
    pub region: Region,
    /// Particles per second. Give this or `mass_rate_kg_per_s`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_per_s: Option<f64>,
    /// Mass per second. Give this or `rate_per_s`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_rate_kg_per_s: Option<f64>,
    /// Simulated time between batches.
    pub interval_s: f64,
    /// Time of the first batch.
    #[serde(default)]
    pub start_s: f64,
    /// No batch from this time on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_s: Option<f64>,
    /// Particles in all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<u64>,
    /// Mass in all: until it is reached.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Velocity of every particle as it comes in.
    #[serde(default)]
    pub velocity_m_per_s: [f64; 3],
    /// Angular velocity of every particle as it comes in, in world axes.
    #[serde(default)]
    pub angular_velocity_rad_per_s: [f64; 3],
    /// Sizes relative to the shape; 1 when absent.
    #[serde(default)]
    #[schemars(with = "ScaleSection")]
    pub scale: ScaleLaw,
    /// Unrotated instead of random orientations.
    #[serde(default)]
    pub fixed_orientation: bool,
    /// Places tried for a particle before it is owed to the next batch.
    #[serde(default = "default_attempts")]
    pub attempts: u32,
}

fn default_attempts() -> u32 {
    200
}

impl InflowDescription {
    /// A batch as an insertion; how many is up to whoever places it.
    pub(crate) fn batch(&self) -> InsertionDescription {
        InsertionDescription {
            shape: self.shape.clone(),
            material: self.material.clone(),
            placement: Placement::Random {
                region: self.region.clone(),
                count: Some(1),
                solid_fraction: None,
                fixed_orientation: self.fixed_orientation,
                attempts: self.attempts,
            },
            velocity_m_per_s: self.velocity_m_per_s,
            angular_velocity_rad_per_s: self.angular_velocity_rad_per_s,
            scale: self.scale.clone(),
            frozen: false,
        }
    }

    /// Its name in quotes, or its place.
    pub fn title(&self, index: usize) -> String {
        if self.name.is_empty() { format!("inflow {index}") } else { format!("inflow '{}'", self.name) }
    }

    pub(super) fn check(&self, path: &str, problems: &mut Problems) {
        match (self.rate_per_s, self.mass_rate_kg_per_s) {
            (Some(rate), None) => {
                problems.in_range(&format!("{path}.rate_per_s"), rate, "finite and above 0", rate > 0.0);
            }
            (None, Some(rate)) => {
                problems.in_range(&format!("{path}.mass_rate_kg_per_s"), rate, "finite and above 0", rate > 0.0);
            }
            _ => problems.add(path, "give rate_per_s or mass_rate_kg_per_s, not both"),
        }
        let interval = self.interval_s;
        problems.in_range(&format!("{path}.interval_s"), interval, "finite and above 0", interval > 0.0);
        let start = self.start_s;
        problems.in_range(&format!("{path}.start_s"), start, "finite and at least 0", start >= 0.0);
        if let Some(end) = self.end_s {
            problems.in_range(&format!("{path}.end_s"), end, "finite and above start_s", end > start);
        }
        if let Some(mass) = self.mass_kg {
            problems.in_range(&format!("{path}.mass_kg"), mass, "finite and above 0", mass > 0.0);
        }
        if self.end_s.is_none() && self.count.is_none() && self.mass_kg.is_none() {
            problems.add(path, "never ends: give count, mass_kg or end_s");
        }
        if self.attempts == 0 {
            problems.add(format!("{path}.attempts"), "is 0; must be at least 1");
        }
    }

    /// What it does, for `sturz check`.
    pub(super) fn line(&self, index: usize) -> String {
        let rate = match (self.rate_per_s, self.mass_rate_kg_per_s) {
            (Some(rate), _) => format!("{rate} particles/s"),
            (None, rate) => format!("{} kg/s", rate.unwrap_or_default()),
        };
        let ends = [
            self.count.map(|count| format!("{count} particles")),
            self.mass_kg.map(|mass| format!("{mass} kg")),
            self.end_s.map(|end| format!("{end} s")),
        ];
        let ends: Vec<String> = ends.into_iter().flatten().collect();
        let (title, every) = (self.title(index), self.interval_s);
        format!(
            "{title}: {rate} of '{}', a batch each {every} s from {} s on, until {}",
            self.shape,
            self.start_s,
            ends.join(" or ")
        )
    }
}

impl Scene {
    /// Checks all inflows against the scene; the smallest and the largest particle of each.
    pub(super) fn check_inflows(&self, problems: &mut Problems) -> Vec<NewParticle> {
        let mut samples = Vec::new();
        for (k, inflow) in self.description().inflows.iter().enumerate() {
            let path = format!("inflow[{k}]");
            let ends = insertion::smallest_and_largest(&inflow.batch(), self, &path);
            let Some(ends) = problems.keep(ends) else { continue };
            let largest = ends[1].radius;
            problems.keep(self.check_sizes(&ends, &path));
            problems.keep(insertion::check_room(&inflow.region, largest, &format!("{path}.region")));
            samples.extend(ends);
        }
        samples
    }
}
