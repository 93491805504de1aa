//! Wall time per stage of a step: the engine says when a stage ends, the daemon owns the clock.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Instant;

use sturz_engine::{Stage, StageTimer};
use sturz_protocol::v1;

/// Nanoseconds per stage since the start, readable beside the engine that owns the timer.
#[derive(Clone, Default)]
pub struct StageTotals {
    nanoseconds: Arc<[AtomicU64; Stage::ALL.len()]>,
}

/// Adds to the totals.
struct StageClock {
    totals: StageTotals,
    last: Instant,
}

impl StageTotals {
    /// A timer for the engine that adds to these totals.
    pub fn timer(&self) -> Box<dyn StageTimer> {
        Box::new(StageClock { totals: self.clone(), last: Instant::now() })
    }

    /// Totals now, ns, in the order of [`Stage::ALL`].
    pub fn read(&self) -> [u64; Stage::ALL.len()] {
        std::array::from_fn(|stage| self.nanoseconds[stage].load(Relaxed))
    }
}

/// Cost per step between two readings that are `steps` apart; nothing when there was no step.
pub fn costs(before: &[u64; Stage::ALL.len()], after: &[u64; Stage::ALL.len()], steps: u64) -> Vec<v1::StageCost> {
    if steps == 0 {
        return Vec::new();
    }
    let cost = |(at, stage): (usize, &Stage)| v1::StageCost {
        name: stage.name().into(),
        s_per_step: (after[at] - before[at]) as f64 * 1e-9 / steps as f64,
    };
    Stage::ALL.iter().enumerate().map(cost).collect()
}

impl StageTimer for StageClock {
    fn begin(&mut self) {
        self.last = Instant::now();
    }

    fn lap(&mut self, stage: Stage) {
        let now = Instant::now();
        let spent = now.duration_since(self.last).as_nanos() as u64;
        self.last = now;
        if let Some(at) = Stage::ALL.iter().position(|&other| other == stage) {
            self.totals.nanoseconds[at].fetch_add(spent, Relaxed);
        }
    }
}
