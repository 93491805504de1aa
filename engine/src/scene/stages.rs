//! `[[stage]]`: a scene that changes its laws on the way, as stiff beds are brought to rest.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::validate::Problems;
use super::{NormalLaw, Scene, SceneDescription};
use crate::error::InvalidInput;

/// `[[stage]]`: laws for a time, or until the particles rest. Stages follow each other in the order of the file, from step 0
/// on; behind the last one the laws are those of the scene without stages. A stage without an end, which only the last
/// one may be, goes on for ever.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StageDescription {
    /// For events and errors.
    pub name: String,
    /// Ends after this simulated time, if nothing has ended it before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    /// Ends after so many steps, if nothing has ended it before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps: Option<u64>,
    /// Ends at rest: once the kinetic energy over the potential energy (above the lowest particle's centre) stays below this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kinetic_over_potential: Option<f64>,
    /// Ends at rest: once the kinetic energy over the elastic energy of the contacts stays below this. Where both limits
    /// are given, both must hold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kinetic_over_elastic: Option<f64>,
    /// Rest is looked for from this time of the stage on, and while no inflow goes on.
    pub after_s: f64,
    /// Factor of all contact stiffnesses, above 0: `stiffness_n_per_m`, with `normal = "hertz"` `youngs_modulus_pa`.
    pub stiffness_factor: f64,
    /// Factor of all dashpot coefficients, where they are given as `damping_n_s_per_m`.
    pub damping_factor: f64,
    /// Restitution of all pairs instead of their own, and of their dashpot coefficients.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Dashpot coefficient of all pairs instead of their own, and of their restitution.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping_n_s_per_m: Option<f64>,
    /// Factor of all coefficients of sliding, rolling and twisting friction.
    pub friction_factor: f64,
    /// Local damping instead of that of `[integrator]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub local_damping: Option<f64>,
    /// Factor of gravity.
    pub gravity_factor: f64,
}

impl Default for StageDescription {
    fn default() -> Self {
        Self {
            name: String::new(),
            time_s: None,
            steps: None,
            kinetic_over_potential: None,
            kinetic_over_elastic: None,
            after_s: 0.0,
            stiffness_factor: 1.0,
            damping_factor: 1.0,
            restitution: None,
            damping_n_s_per_m: None,
            friction_factor: 1.0,
            local_damping: None,
            gravity_factor: 1.0,
        }
    }
}

impl StageDescription {
    /// Whether anything ends it.
    pub fn has_end(&self) -> bool {
        self.time_s.is_some() || self.steps.is_some() || self.looks_for_rest()
    }

    /// Whether it ends at rest.
    pub fn looks_for_rest(&self) -> bool {
        self.kinetic_over_potential.is_some() || self.kinetic_over_elastic.is_some()
    }

    /// Its name in quotes, or its place.
    pub fn title(&self, index: usize) -> String {
        if self.name.is_empty() { format!("stage {index}") } else { format!("stage '{}'", self.name) }
    }

    /// The scene with the laws of this stage, without stages.
    pub(super) fn applied_to(&self, scene: &SceneDescription) -> SceneDescription {
        let mut staged = scene.clone();
        staged.stages.clear();
        let scaled = |value: &mut Option<f64>, factor: f64| *value = value.map(|value| value * factor);
        for material in &mut staged.materials {
            scaled(&mut material.youngs_modulus_pa, self.stiffness_factor);
        }
        for pair in &mut staged.material_pairs {
            scaled(&mut pair.stiffness_n_per_m, self.stiffness_factor);
            scaled(&mut pair.damping_n_s_per_m, self.damping_factor);
            scaled(&mut pair.tangential_damping_n_s_per_m, self.damping_factor);
            if self.restitution.is_some() || self.damping_n_s_per_m.is_some() {
                (pair.restitution, pair.damping_n_s_per_m) = (self.restitution, self.damping_n_s_per_m);
            }
            pair.friction *= self.friction_factor;
            pair.rolling_friction *= self.friction_factor;
            pair.twisting_friction *= self.friction_factor;
        }
        if let Some(damping) = self.local_damping {
            staged.integrator.local_damping = damping;
        }
        for component in &mut staged.scene.gravity_m_per_s2 {
            *component *= self.gravity_factor;
        }
        staged
    }

    fn check(&self, path: &str, scene: &SceneDescription, problems: &mut Problems) {
        let positive = |value: f64| value > 0.0;
        for (key, value) in [
            ("time_s", self.time_s),
            ("kinetic_over_potential", self.kinetic_over_potential),
            ("kinetic_over_elastic", self.kinetic_over_elastic),
            ("stiffness_factor", Some(self.stiffness_factor)),
        ] {
            let value = value.unwrap_or(1.0);
            problems.in_range(&format!("{path}.{key}"), value, "finite and above 0", positive(value));
        }
        if self.steps == Some(0) {
            problems.add(format!("{path}.steps"), "is 0; must be at least 1");
        }
        for (key, value) in [
            ("after_s", self.after_s),
            ("damping_factor", self.damping_factor),
            ("friction_factor", self.friction_factor),
        ] {
            problems.in_range(&format!("{path}.{key}"), value, "finite and at least 0", value >= 0.0);
        }
        problems.finite(&format!("{path}.gravity_factor"), &[self.gravity_factor]);
        if self.after_s > 0.0 && !self.looks_for_rest() {
            problems.add(format!("{path}.after_s"), "does nothing in a stage that does not end at rest");
        }
        if self.kinetic_over_potential.is_some() && scene.scene.gravity_m_per_s2 == [0.0; 3] {
            let problem = "is never met without gravity; give kinetic_over_elastic";
            problems.add(format!("{path}.kinetic_over_potential"), problem);
        }
        if self.restitution.is_some() && self.damping_n_s_per_m.is_some() {
            problems.add(path, "give restitution or damping_n_s_per_m, not both");
        }
        let own = self.restitution.is_none() && self.damping_n_s_per_m.is_none();
        let raw = scene.material_pairs.iter().all(|pair| pair.damping_n_s_per_m.is_some());
        if self.damping_factor != 1.0 && !(own && raw) {
            let problem = "is for dashpots that every [[material_pair]] gives as damping_n_s_per_m; where they give restitution, give the stage another restitution";
            problems.add(format!("{path}.damping_factor"), problem);
        }
        if self.stiffness_factor != 1.0 && scene.normal_law() == NormalLaw::Hertz {
            let soft = scene.materials.iter().any(|material| material.youngs_modulus_pa.is_some());
            if !soft {
                problems.add(format!("{path}.stiffness_factor"), "has no youngs_modulus_pa to act on");
            }
        }
    }
}

/// Checks all of them, apart from what their laws do to the scene.
pub(super) fn check(scene: &SceneDescription, problems: &mut Problems) {
    for (k, stage) in scene.stages.iter().enumerate() {
        stage.check(&format!("stage[{k}]"), scene, problems);
        if !stage.has_end() && k + 1 < scene.stages.len() {
            let problem =
                "has no end, and a stage follows: give time_s, steps, kinetic_over_potential or kinetic_over_elastic";
            problems.add(format!("stage[{k}]"), problem);
        }
    }
}

/// What they do, a sentence each, for `sturz check`.
pub(super) fn plan_lines(scene: &SceneDescription) -> Vec<String> {
    scene.stages.iter().enumerate().map(|(k, stage)| line(k, stage)).collect()
}

fn line(index: usize, stage: &StageDescription) -> String {
    let changes = [
        ("stiffness times", Some(stage.stiffness_factor).filter(|&factor| factor != 1.0)),
        ("dashpots times", Some(stage.damping_factor).filter(|&factor| factor != 1.0)),
        ("restitution", stage.restitution),
        ("dashpots of (N s/m)", stage.damping_n_s_per_m),
        ("friction times", Some(stage.friction_factor).filter(|&factor| factor != 1.0)),
        ("local damping", stage.local_damping),
        ("gravity times", Some(stage.gravity_factor).filter(|&factor| factor != 1.0)),
    ];
    let changes: Vec<String> =
        changes.into_iter().filter_map(|(what, value)| Some(format!("{what} {}", value?))).collect();
    let changes = if changes.is_empty() { "the laws of the scene".into() } else { changes.join(", ") };
    let ends = [
        stage.time_s.map(|time| format!("after {time} s")),
        stage.steps.map(|steps| format!("after {steps} steps")),
        stage.kinetic_over_potential.map(|limit| format!("at kinetic over potential energy below {limit:e}")),
        stage.kinetic_over_elastic.map(|limit| format!("at kinetic over elastic energy below {limit:e}")),
    ];
    let ends: Vec<String> = ends.into_iter().flatten().collect();
    let ends = if ends.is_empty() { "never ends".into() } else { format!("ends {}", ends.join(" or ")) };
    format!("{}: {changes}; {ends}", stage.title(index))
}

impl Scene {
    /// The laws of each stage, as scenes of their own without particles.
    pub(super) fn build_stages(&mut self, staged: Vec<SceneDescription>, problems: &mut Problems) {
        for (k, description) in staged.into_iter().enumerate() {
            let title = self.description().stages[k].title(k);
            match Self::without_particles(description) {
                Ok(scene) => self.stages.push(Arc::new(scene)),
                Err(found) => problems.0.extend(found.0.into_iter().map(|problem| InvalidInput {
                    path: format!("stage[{k}]"),
                    problem: format!("in {title}, {problem}"),
                })),
            }
        }
    }

    /// By stage.
    pub fn stages(&self) -> &[Arc<Scene>] {
        &self.stages
    }

    /// Itself, and what it is in each stage, with what to call it in errors.
    pub(super) fn with_stages(&self) -> impl Iterator<Item = (Option<String>, &Scene)> {
        let titles = self.description().stages.iter().enumerate().map(|(k, stage)| Some(stage.title(k)));
        std::iter::once((None, self)).chain(titles.zip(self.stages.iter().map(Arc::as_ref)))
    }
}
