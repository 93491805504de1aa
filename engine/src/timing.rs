//! Cost per stage, counted by whoever drives the engine: the engine itself never asks the wall clock.

/// Stages of a step that are timed apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Boundary motion, half kick and drift.
    Drift,
    /// Neighbour list: staleness test, and rebuild when stale.
    Neighbours,
    /// Contact geometry.
    Narrow,
    /// Contact laws.
    Forces,
    /// Sum per particle.
    Gather,
    /// Second half kick, clock and guard.
    Kick,
}

impl Stage {
    /// All stages, in the order of the step.
    pub const ALL: [Stage; 6] =
        [Stage::Drift, Stage::Neighbours, Stage::Narrow, Stage::Forces, Stage::Gather, Stage::Kick];

    /// Name as in reports.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Drift => "drift",
            Stage::Neighbours => "neighbours",
            Stage::Narrow => "narrow",
            Stage::Forces => "forces",
            Stage::Gather => "gather",
            Stage::Kick => "kick",
        }
    }
}

/// Told when a stage has ended.
pub trait StageTimer: Send {
    /// A step begins.
    fn begin(&mut self);
    /// `stage` has just ended.
    fn lap(&mut self, stage: Stage);
}
