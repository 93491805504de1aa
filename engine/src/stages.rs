//! Stages of a scene: which laws hold now, and when the next ones do.

use std::sync::Arc;

use crate::checkpoint::codec::pack_fields;
use crate::engine::Engine;
use crate::error::InvalidInput;
use crate::happening::Happening;
use crate::math::Vec3;
use crate::scene::StageDescription;

/// Steps between two looks whether the particles rest: a look costs about a step.
const LOOK_EVERY: u64 = 100;
/// Looks in a row at which the kinetic energy must be below the limit: it is also low where motion turns around.
const LOOKS: u32 = 10;

/// Where a run with stages is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StageRun {
    /// Of the stage under way; their number once all are over.
    pub index: u64,
    begun_step: u64,
    begun_s: f64,
    /// In a row, at which the particles rested.
    looks: u32,
    /// Gravity of which the stage takes its part, m/s2.
    pub gravity: Vec3,
}

pack_fields!(StageRun { index: u64, begun_step: u64, begun_s: f64, looks: u32, gravity: Vec3 });

impl StageRun {
    /// Words for the state hash.
    pub(crate) fn words(&self) -> [f64; 7] {
        let [x, y, z] = self.gravity.into();
        [self.index as f64, self.begun_step as f64, self.begun_s, f64::from(self.looks), x, y, z]
    }

    /// Whether an engine of a scene with this number of stages may be there.
    pub(crate) fn check(&self, stages: usize, step: u64) -> Result<(), InvalidInput> {
        let gravity = self.gravity.iter().all(|component| component.is_finite());
        if self.index <= stages as u64 && self.begun_step <= step && self.begun_s.is_finite() && gravity {
            Ok(())
        } else {
            Err(InvalidInput::new("stage", format!("is {self:?}")))
        }
    }
}

impl Engine {
    /// Index of the stage under way, and what the scene says of it; `None` without stages and behind the last one.
    pub fn stage(&self) -> Option<(usize, &StageDescription)> {
        let index = self.stages.as_ref()?.index as usize;
        Some((index, self.written.description().stages.get(index)?))
    }

    /// Whether the scene has stages that are not over.
    pub fn has_stages_ahead(&self) -> bool {
        self.stage().is_some()
    }

    /// Before step 0: the laws of the first stage, where the scene has any.
    pub(crate) fn begin_stages(&mut self) {
        if self.written.stages().is_empty() {
            return;
        }
        let run = StageRun { index: 0, begun_step: 0, begun_s: self.clock.time_s(), looks: 0, gravity: self.gravity };
        self.stages = Some(run);
        self.take_laws_of_stage();
        self.tell_of_stage();
    }

    /// The scene and the gravity of the stage under way.
    pub(crate) fn take_laws_of_stage(&mut self) {
        let Some(run) = self.stages else { return };
        let index = run.index as usize;
        self.scene = self.written.stages().get(index).map_or_else(|| Arc::clone(&self.written), Arc::clone);
        let factor = self.written.description().stages.get(index).map_or(1.0, |stage| stage.gravity_factor);
        self.gravity = run.gravity * factor;
    }

    fn tell_of_stage(&mut self) {
        let stage = self.stage().map(|(index, stage)| (index, stage.name.clone()));
        self.tell(match stage {
            Some((index, name)) => Happening::StageBegan { index, name },
            None => Happening::StagesOver,
        });
    }

    /// After a step: goes to the next stage where this one is over.
    pub(crate) fn follow_stages(&mut self) {
        let Some(run) = self.stages else { return };
        let written = Arc::clone(&self.written);
        let Some(stage) = written.description().stages.get(run.index as usize) else { return };
        let (steps, time_s) = (self.clock.step() - run.begun_step, self.clock.time_s() - run.begun_s);
        let over = stage.steps.is_some_and(|most| steps >= most)
            || stage.time_s.is_some_and(|most| time_s >= most)
            || self.has_come_to_rest(stage, steps, time_s);
        if over {
            self.begin_next_stage();
        }
    }

    fn has_come_to_rest(&mut self, stage: &StageDescription, steps: u64, time_s: f64) -> bool {
        if !stage.looks_for_rest() || !steps.is_multiple_of(LOOK_EVERY) {
            return false;
        }
        let rests = time_s >= stage.after_s && !self.has_inflow_ahead() && self.rests(stage);
        let Some(run) = &mut self.stages else { return false };
        run.looks = if rests { run.looks + 1 } else { 0 };
        run.looks >= LOOKS
    }

    /// Whether the kinetic energy is below the limits now.
    fn rests(&self, stage: &StageDescription) -> bool {
        let energy = self.mechanical_energy();
        let kinetic = energy.translation + energy.rotation;
        // particles that touch nothing do not rest, however slow they are
        energy.elastic > 0.0
            && stage.kinetic_over_elastic.is_none_or(|limit| kinetic < limit * energy.elastic)
            && stage.kinetic_over_potential.is_none_or(|limit| kinetic < limit * self.height_energy())
    }

    /// Potential energy of the free particles above the lowest of their centres, J.
    fn height_energy(&self) -> f64 {
        let particles = &self.particles;
        let free =
            || particles.rows_by_id().into_iter().map(|row| row as usize).filter(|&row| !particles.is_frozen(row));
        let level = |row: usize| -self.gravity.dot(&particles.position[row]);
        let lowest = free().map(level).fold(f64::INFINITY, f64::min);
        free().map(|row| particles.mass[row] * (level(row) - lowest)).sum()
    }

    /// Springs stay, as far as the new laws have any; the difference of the energies is booked as brought in.
    fn begin_next_stage(&mut self) {
        let (begun_step, begun_s) = (self.clock.step(), self.clock.time_s());
        self.change_state(|engine| {
            if let Some(run) = &mut engine.stages {
                *run = StageRun { index: run.index + 1, begun_step, begun_s, looks: 0, ..*run };
            }
            engine.take_laws_of_stage();
        });
        self.tell_of_stage();
    }
}
