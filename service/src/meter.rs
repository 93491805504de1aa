//! How fast the physics goes, counted over the time that it spends stepping.

use std::time::{Duration, Instant};

use sturz_engine::Stage;
use sturz_protocol::v1;

use crate::stages::{StageTotals, costs};

/// Shorter spans give rates that jump.
const SHORTEST_SPAN: Duration = Duration::from_millis(200);

/// Rates since the report before.
#[derive(Clone, Debug, Default)]
pub struct Rates {
    /// Simulated seconds per wall second.
    pub sim_s_per_wall_s: f64,
    /// Steps per wall second.
    pub steps_per_wall_s: f64,
    /// Wall time per step of each stage.
    pub stages: Vec<v1::StageCost>,
    /// Longest wall time from the end of a step to that of the next one, s.
    pub longest_pause_s: f64,
}

/// Where a span began.
#[derive(Clone, Copy, Default)]
struct Reading {
    busy: Duration,
    steps: u64,
    simulated_s: f64,
    stages: [u64; Stage::ALL.len()],
}

/// Counts steps, simulated and wall time.
pub struct Meter {
    started: Instant,
    last_tick: Instant,
    totals: StageTotals,
    now: Reading,
    before: Reading,
    longest_pause: Duration,
    rates: Rates,
}

impl Meter {
    /// Starts the wall clock.
    pub fn new(totals: StageTotals) -> Self {
        let now = Instant::now();
        Self {
            started: now,
            last_tick: now,
            totals,
            now: Reading::default(),
            before: Reading::default(),
            longest_pause: Duration::ZERO,
            rates: Rates::default(),
        }
    }

    /// The physics has slept: the time since the last tick does not count.
    pub fn woke(&mut self) {
        self.last_tick = Instant::now();
    }

    /// A tick has ended; `stepped_s` is the simulated time of its step, if it made one.
    pub fn tick(&mut self, now: Instant, stepped_s: Option<f64>) {
        if let Some(simulated) = stepped_s {
            let pause = now.saturating_duration_since(self.last_tick);
            self.now.busy += pause;
            self.longest_pause = self.longest_pause.max(pause);
            self.now.steps += 1;
            self.now.simulated_s += simulated;
        }
        self.last_tick = now;
    }

    /// Wall seconds since the start.
    pub fn wall_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Rates since the report before, or those of it when that was a moment ago.
    pub fn rates(&mut self) -> Rates {
        let busy = self.now.busy - self.before.busy;
        if busy >= SHORTEST_SPAN || (self.before.steps == 0 && self.now.steps > 0) {
            self.now.stages = self.totals.read();
            let steps = self.now.steps - self.before.steps;
            let wall = busy.as_secs_f64().max(1e-9);
            self.rates = Rates {
                sim_s_per_wall_s: (self.now.simulated_s - self.before.simulated_s) / wall,
                steps_per_wall_s: steps as f64 / wall,
                stages: costs(&self.before.stages, &self.now.stages, steps),
                longest_pause_s: std::mem::take(&mut self.longest_pause).as_secs_f64(),
            };
            self.before = self.now;
        }
        self.rates.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sleep_does_not_count() {
        let mut meter = Meter::new(StageTotals::default());
        let start = Instant::now();
        meter.last_tick = start;
        for second in 1..=4 {
            meter.tick(start + Duration::from_secs(second), Some(0.5));
        }
        meter.tick(start + Duration::from_secs(100), None);
        meter.tick(start + Duration::from_secs(101), Some(0.5));
        let rates = meter.rates();
        assert!((rates.steps_per_wall_s - 1.0).abs() < 1e-9);
        assert!((rates.sim_s_per_wall_s - 0.5).abs() < 1e-9);
    }
}
