//! Saving a run and going on from there, bitwise.
//!
//! A checkpoint is a string of bytes with all that decides the future of a run, apart from its scene: particles, ids,
//! epoch, clock, springs, forces, loads, boundaries and their motions, gravity, energy balance, counters, and the means
//! over time that are being taken. Taking one does not
//! touch the engine, and an engine of the same scene that restores it has the state hash of the saved one, then and at
//! every later step, on any number of threads. (The energies of the report are sums in the order of rows, which is
//! another one after a restore, as after any rebuild of the neighbour list: they agree to rounding.)
//!
//! ```
//! # use sturz_engine::{Engine, scene::{Scene, SceneDescription}};
//! # let text = "[scene]\nname = \"empty\"\ntime_step_s = 1e-5";
//! # let scene = || Scene::validate(SceneDescription::from_toml(text).unwrap()).unwrap();
//! let mut engine = Engine::new(scene());
//! engine.step()?;
//! let saved = engine.checkpoint()?;
//! engine.step()?;
//! let mut other = Engine::new(scene());
//! other.restore(&saved)?;
//! other.step()?;
//! assert_eq!(other.state_hash(), engine.state_hash());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bed;
pub(crate) mod codec;
mod container;
mod error;
mod layout;
mod state;
#[cfg(test)]
mod tests;

pub(crate) use bed::Bed;
use bed::WrittenScene;
use codec::pack_fields;
use container::{Sections, Tag, Writer};
pub use error::CheckpointError;
use layout::Layout;
use state::State;

use crate::engine::Engine;
use crate::error::InvalidInput;

const SUMMARY: Tag = *b"SUMM";
const CLOCK: Tag = *b"CLOK";
const TOTALS: Tag = *b"TOTL";
const BOUNDARIES: Tag = *b"WALL";
const PARTICLES: Tag = *b"PART";
const SPRINGS: Tag = *b"SPRG";
const TOUCHING: Tag = *b"TOUC";
const LOADS: Tag = *b"LOAD";
/// Only where somebody is frozen.
const FROZEN: Tag = *b"FROZ";
/// Only where the scene has stages or inflows.
const COURSE: Tag = *b"COUR";
/// Only where other scenes are to start with it.
const SCENE: Tag = *b"SCNE";
/// Only where means are being taken.
const AVERAGES: Tag = *b"AVRG";
/// Only where there is a fluid.
const FLUID: Tag = *b"FLUI";

/// What a checkpoint says of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckpointSummary {
    /// Steps done.
    pub step: u64,
    /// Simulated time.
    pub time_s: f64,
    /// Particles present.
    pub particles: u64,
    /// Counts insertions and removals.
    pub topology_epoch: u64,
    /// Of the saved state.
    pub state_hash: u64,
    layout: Layout,
}

pack_fields!(CheckpointSummary {
    step: u64,
    time_s: f64,
    particles: u64,
    topology_epoch: u64,
    state_hash: u64,
    layout: Layout,
});

impl CheckpointSummary {
    /// Reads it from a checkpoint that is whole and sound.
    pub fn read(bytes: &[u8]) -> Result<Self, CheckpointError> {
        Sections::open(bytes)?.section(SUMMARY)
    }
}

/// All between the summary and the scene.
fn read_state(sections: &mut Sections<'_>) -> Result<State, CheckpointError> {
    Ok(State {
        clock: sections.section(CLOCK)?,
        totals: sections.section(TOTALS)?,
        boundaries: sections.section(BOUNDARIES)?,
        particles: sections.section(PARTICLES)?,
        springs: sections.section(SPRINGS)?,
        touching: sections.section(TOUCHING)?,
        loads: sections.section(LOADS)?,
        frozen: sections.optional(FROZEN)?,
        course: sections.optional(COURSE)?,
        averages: sections.optional(AVERAGES)?.unwrap_or_default(),
        fluid: sections.optional(FLUID)?,
    })
}

impl Engine {
    /// All that decides the future, as bytes. The engine is left alone.
    ///
    /// # Errors
    /// [`CheckpointError::RunFailed`]: nothing could go on from there.
    pub fn checkpoint(&self) -> Result<Vec<u8>, CheckpointError> {
        self.checkpoint_with(None)
    }

    fn checkpoint_with(&self, scene: Option<WrittenScene>) -> Result<Vec<u8>, CheckpointError> {
        if let Some(failure) = &self.failure {
            return Err(CheckpointError::RunFailed { reason: failure.to_string() });
        }
        let state = State::of(self);
        let mut writer = Writer::new();
        let summary = CheckpointSummary {
            step: self.clock.step(),
            time_s: self.clock.time_s(),
            particles: self.len() as u64,
            topology_epoch: self.topology_epoch,
            state_hash: self.hash_with(&state.springs),
            layout: self.layout(),
        };
        writer.section(SUMMARY, &summary);
        writer.section(CLOCK, &state.clock);
        writer.section(TOTALS, &state.totals);
        writer.section(BOUNDARIES, &state.boundaries);
        writer.section(PARTICLES, &state.particles);
        writer.section(SPRINGS, &state.springs);
        writer.section(TOUCHING, &state.touching);
        writer.section(LOADS, &state.loads);
        if let Some(frozen) = &state.frozen {
            writer.section(FROZEN, frozen);
        }
        if let Some(course) = &state.course {
            writer.section(COURSE, course);
        }
        if !state.averages.is_empty() {
            writer.section(AVERAGES, &state.averages);
        }
        if let Some(fluid) = &state.fluid {
            writer.section(FLUID, fluid);
        }
        if let Some(scene) = &scene {
            writer.section(SCENE, scene);
        }
        Ok(writer.finish())
    }

    /// Goes back, or ahead, to a checkpoint of the same scene; threads and timer stay. A run that has failed may go on.
    /// After an error the engine is as it was.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), CheckpointError> {
        let mut sections = Sections::open(bytes)?;
        let summary: CheckpointSummary = sections.section(SUMMARY)?;
        let differing = layout::differing(&summary.layout, &self.layout());
        if !differing.is_empty() {
            return Err(CheckpointError::OtherScene { differing });
        }
        let mut state = read_state(&mut sections)?;
        let _: Option<WrittenScene> = sections.optional(SCENE)?;
        sections.end()?;
        state.check(&self.written)?;
        let averages = std::mem::take(&mut state.averages).into_iter().enumerate();
        let averages = averages
            .map(|(k, saved)| {
                let path = format!("averages[{k}]");
                let average = saved.restored(&path)?;
                average.definition().check_against(&self.written, &path)?;
                Ok(average)
            })
            .collect::<Result<_, InvalidInput>>()?;
        let mut restored = self.blank_twin();
        restored.averages = averages;
        let all_found = restored.in_pool(|engine| engine.put(state));
        let (found, wanted) = (restored.state_hash(), summary.state_hash);
        if found != wanted || !all_found {
            return Err(CheckpointError::OtherState { found, wanted });
        }
        self.become_twin(restored);
        Ok(())
    }

    fn layout(&self) -> Layout {
        *self.layout.get_or_init(|| layout::layout(self.written.description(), self.written.time_step_s()))
    }

    /// Puts a checked state into an engine without particles; whether all that touches has found its place.
    fn put(&mut self, state: State) -> bool {
        let State {
            clock,
            totals,
            boundaries,
            particles,
            springs,
            touching,
            loads,
            fluid,
            frozen,
            course,
            averages: _,
        } = state;
        self.clock = clock;
        if let Some(course) = course {
            (self.stages, self.inflows) = (course.stages, course.inflows);
        }
        self.take_laws_of_stage();
        self.gravity = totals.gravity;
        self.next_id = totals.next_id;
        self.topology_epoch = totals.topology_epoch;
        for (boundary, motion) in self.boundaries.iter_mut().zip(boundaries) {
            boundary.set_present_motion(motion);
        }
        particles.iter().for_each(|row| row.push(&mut self.particles, frozen.as_ref()));
        self.frozen_power = frozen.map_or(0.0, |frozen| frozen.power);
        self.predict_present_motion();
        (self.loads, self.fluid) = (loads, fluid);
        self.kept_springs = springs;
        self.rebuild_neighbours_if_stale(self.clock.time_s());
        self.find_contacts();
        let found = self.contacts.restore_slots(&touching.slots, &self.particles)
            && self.contacts.spheres.restore_touching(&touching.spheres, &self.particles);
        self.kept_springs.clear();
        self.neighbours.rebuilds = totals.rebuilds;
        self.sums = totals.sums;
        self.ledger = totals.ledger;
        self.local_damping = totals.local_damping;
        self.warnings = totals.warnings;
        self.largest_ratio_so_far = totals.largest_ratio_so_far;
        found
    }
}
