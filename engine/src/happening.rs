//! What the engine does of its own accord, for whoever wants to tell of it.

use crate::engine::Engine;

/// Something that no command has asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Happening {
    /// A stage of the scene has begun.
    StageBegan {
        /// In the scene.
        index: usize,
        /// In the scene; may be empty.
        name: String,
    },
    /// The last stage is over.
    StagesOver,
    /// An inflow has brought particles of consecutive ids.
    Inflow {
        /// In the scene.
        index: usize,
        /// Lowest new id.
        first_id: u64,
        /// How many.
        count: u64,
    },
    /// A batch of an inflow found no room for all its particles.
    InflowShort {
        /// In the scene.
        index: usize,
        /// Batches of the inflow that have found too little room so far.
        total: u64,
    },
    /// An inflow has brought all that it was to bring.
    InflowOver {
        /// In the scene.
        index: usize,
        /// Particles in all.
        count: u64,
    },
}

/// What is kept for those who do not ask: the oldest go.
const MOST_KEPT: usize = 1024;

impl Engine {
    /// All since the last call, oldest first; the last 1024 of them. Not part of the state.
    pub fn take_happenings(&mut self) -> Vec<Happening> {
        std::mem::take(&mut self.happenings)
    }

    /// Whether there is anything to take.
    pub fn has_happenings(&self) -> bool {
        !self.happenings.is_empty()
    }

    pub(crate) fn tell(&mut self, happening: Happening) {
        if self.happenings.len() >= MOST_KEPT {
            self.happenings.remove(0);
        }
        self.happenings.push(happening);
    }
}
