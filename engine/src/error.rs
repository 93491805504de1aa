//! The engine's errors: what is wrong with an input, and why a step was refused.

use thiserror::Error;

/// Something in a scene or a command that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{path}: {problem}")]
pub struct InvalidInput {
    /// Path into the input, such as `material_pair[1].stiffness_n_per_m`.
    pub path: String,
    /// What is wrong, and what is allowed.
    pub problem: String,
}

impl InvalidInput {
    /// An error at `path`.
    pub fn new(path: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { path: path.into(), problem: problem.into() }
    }
}

/// Everything that is wrong with a scene.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct InvalidScene(pub Vec<InvalidInput>);

/// Why the run cannot go on; the state is the one after the failing step and can still be read.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum StepError {
    /// A number became infinite or not a number.
    #[error(
        "particle {id} has a non-finite {quantity} after step {step}: reduce time_step_s, or look for a collision that is too violent for the stiffness"
    )]
    NonFinite {
        /// The particle.
        id: u64,
        /// What is not finite.
        quantity: &'static str,
        /// The step.
        step: u64,
    },
    /// Two particles overlap too much.
    #[error("particle {a} overlaps {b} by {:.1} % of its bounding radius at step {step} (limit {:.1} %): reduce time_step_s or raise stiffness_n_per_m", ratio * 100.0, limit * 100.0)]
    ExcessiveOverlap {
        /// The particle.
        a: u64,
        /// What it overlaps: `particle 12` or `boundary "floor"`.
        b: String,
        /// Overlap over the smaller bounding radius.
        ratio: f64,
        /// The limit of the scene.
        limit: f64,
        /// The step.
        step: u64,
    },
    /// Two rounded polyhedra overlap by more than the rounding: the law ends there.
    #[error(
        "particle {a} overlaps {b} by a generalized overlap or one of features of {ratio:.2} rounding radii at step {step} (limit {limit}): raise stiffness_n_per_m, contact.generalized_overlap.rounding_fraction or the radius_m of a rounded polyhedron, or reduce time_step_s"
    )]
    BeyondRounding {
        /// The particle.
        a: u64,
        /// What it overlaps: `particle 12` or `boundary "floor"`.
        b: String,
        /// Overlap over the mean rounding radius.
        ratio: f64,
        /// Where the law ends.
        limit: f64,
        /// The step.
        step: u64,
    },
    /// A particle moves so far in one step that it could pass through another without being seen.
    #[error(
        "particle {id} moves by {ratio:.2} of its smallest half-thickness in step {step} (limit {limit}) and could pass through what it hits: reduce time_step_s"
    )]
    TooFast {
        /// The particle.
        id: u64,
        /// Path of its fastest point in the step over its smallest half-thickness.
        ratio: f64,
        /// The limit.
        limit: f64,
        /// The step.
        step: u64,
    },
    /// The overlaps of the start are still there after as many iterations as the scene allows.
    #[error(
        "after {iterations} iterations of [relax] particle {a} overlaps {b} by {:.1} % {measure} (wanted {:.1} %): raise relax.max_iterations or relax.overlap_ratio, or give the particles more room", overlap * 100.0, limit * 100.0
    )]
    NotRelaxed {
        /// The particle.
        a: u64,
        /// What it overlaps: `particle 12` or `boundary "floor"`.
        b: String,
        /// Overlap over the measure.
        overlap: f64,
        /// What was wanted.
        limit: f64,
        /// What the overlap is a part of.
        measure: &'static str,
        /// Iterations done.
        iterations: u64,
    },
    /// The neighbour list would not fit into what it may take.
    #[error(
        "more than {most} candidate pairs would be listed after step {step} (limit `pairs`): too many particles are in one place, or the limit is too low"
    )]
    TooManyPairs {
        /// The limit.
        most: usize,
        /// Steps done.
        step: u64,
    },
    /// The run failed earlier and must not go on.
    #[error("the run stopped at step {step}: {reason}")]
    Stopped {
        /// Step of the failure.
        step: u64,
        /// Its message.
        reason: String,
    },
}
