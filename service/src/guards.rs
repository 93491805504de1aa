//! Warnings of the engine's guards as events: at most one of a kind in a second, with what was counted meanwhile.

use std::time::{Duration, Instant};

use sturz_engine::{Guard, GuardReading, WarningCounts};
use sturz_protocol::v1;

use crate::runner::Runner;

/// Between two events of one kind.
const QUIET: Duration = Duration::from_secs(1);
/// Between two looks at the critical step of the contacts present, which takes as long as a part of a step, and between two
/// events about it.
const STEP_QUIET: Duration = Duration::from_secs(10);

/// Guards that count.
const COUNTED: [Guard; 4] =
    [Guard::LargeOverlap, Guard::FastParticle, Guard::DeepRounding, Guard::RotationNotConverged];

/// What was told, and when.
pub struct GuardWatch {
    told: WarningCounts,
    /// By guard of [`COUNTED`].
    last: [Option<Instant>; COUNTED.len()],
    step_looked: Option<Instant>,
    step_told: Option<Instant>,
}

/// A guard that is to be told of: how many since the last time, and in all.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Due {
    guard: Guard,
    count: u64,
    total: u64,
}

impl GuardWatch {
    /// Nothing is told of what these have counted.
    pub fn new(told: WarningCounts) -> Self {
        Self { told, last: [None; COUNTED.len()], step_looked: None, step_told: None }
    }

    /// What is to be told now, given all counts.
    fn due(&mut self, now: Instant, counts: WarningCounts) -> Vec<Due> {
        if counts == self.told {
            return Vec::new();
        }
        let mut due = Vec::new();
        for (&guard, last) in COUNTED.iter().zip(&mut self.last) {
            let (told, total) = (count_of(&mut self.told, guard), counts.of(guard));
            // a restored run may have counted less
            *told = total.min(*told);
            let quiet = last.is_some_and(|last| now.saturating_duration_since(last) < QUIET);
            if total > *told && !quiet {
                due.push(Due { guard, count: total - *told, total });
                (*told, *last) = (total, Some(now));
            }
        }
        due
    }

    /// Whether to look at the critical step again.
    fn looks_at_step(&mut self, now: Instant) -> bool {
        let is_due = self.step_looked.is_none_or(|last| now.saturating_duration_since(last) >= STEP_QUIET);
        if is_due {
            self.step_looked = Some(now);
        }
        is_due
    }

    /// Whether to tell that the time step is above the critical one.
    fn tells_of_step(&mut self, now: Instant, reading: &GuardReading) -> bool {
        let quiet = self.step_told.is_some_and(|last| now.saturating_duration_since(last) < STEP_QUIET);
        let tells = reading.value > reading.limit && !quiet;
        if tells {
            self.step_told = Some(now);
        }
        tells
    }
}

fn count_of(counts: &mut WarningCounts, guard: Guard) -> &mut u64 {
    match guard {
        Guard::LargeOverlap => &mut counts.large_overlap,
        Guard::FastParticle => &mut counts.fast_particle,
        Guard::DeepRounding => &mut counts.deep_rounding,
        Guard::RotationNotConverged | Guard::TimeStep => &mut counts.rotation_not_converged,
    }
}

impl Runner<'_> {
    /// After a step: tells of what the guards have seen.
    pub(crate) fn watch_guards(&mut self, now: Instant) {
        for due in self.guards.due(now, self.engine.warnings()) {
            let reading = self.engine.guard_reading(due.guard);
            self.announce_event(event(due, &reading));
        }
        if self.guards.looks_at_step(now) {
            let reading = self.engine.guard_reading(Guard::TimeStep);
            self.warn_of_step(now, reading);
        }
    }

    /// The critical step of a single contact was checked at the start, that of many on one body shows only now.
    pub(crate) fn warn_of_step(&mut self, now: Instant, reading: GuardReading) {
        if self.guards.tells_of_step(now, &reading) {
            let event = event(Due { guard: Guard::TimeStep, count: 0, total: 0 }, &reading);
            tracing::warn!("step {}: {}", self.moment().step, event.message);
            self.announce_event(event);
        }
    }
}

fn event(due: Due, reading: &GuardReading) -> v1::Event {
    let Due { guard, count, total } = due;
    let GuardReading { particle, value, limit } = *reading;
    let who = particle.map_or_else(|| "a particle".into(), |id| format!("particle {id}"));
    let (kind, message) = match guard {
        Guard::LargeOverlap => (
            v1::WarningKind::LargeOverlap,
            format!(
                "{who} overlaps another body by {value:.3} of the smaller bounding radius (warning above {limit}): raise the stiffness"
            ),
        ),
        Guard::FastParticle => (
            v1::WarningKind::FastParticle,
            format!(
                "{who} moves by {value:.3} of its bounding radius in a step (warning above {limit}): reduce the time step"
            ),
        ),
        Guard::DeepRounding => (
            v1::WarningKind::DeepRounding,
            format!(
                "{who} overlaps another body by {value:.3} rounding radii (warning above {limit}): raise the stiffness or the rounding"
            ),
        ),
        Guard::RotationNotConverged => (
            v1::WarningKind::RotationNotConverged,
            format!("{count} rotations did not converge to the last bits: reduce the time step"),
        ),
        Guard::TimeStep => (
            v1::WarningKind::TimeStep,
            format!(
                "the contacts present may be stable below {limit:.2e} s only, the time step is {value:.2e} s: reduce it"
            ),
        ),
    };
    let warning = v1::GuardWarning { kind: kind.into(), count, total, particle_id: particle, value, limit };
    v1::Event {
        kind: v1::EventKind::Warning.into(),
        severity: v1::Severity::Warning.into(),
        message,
        warning: Some(warning),
        ..v1::Event::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn overlaps(large_overlap: u64) -> WarningCounts {
        WarningCounts { large_overlap, ..WarningCounts::default() }
    }

    #[test]
    fn one_event_in_a_second_tells_of_all_before() {
        let mut watch = GuardWatch::new(overlaps(5));
        let start = Instant::now();
        let told = |count, total| vec![Due { guard: Guard::LargeOverlap, count, total }];
        assert_eq!(watch.due(start, overlaps(5)), [], "these were there before");
        assert_eq!(watch.due(start, overlaps(6)), told(1, 6));
        assert_eq!(watch.due(start + QUIET / 2, overlaps(9)), []);
        let both = WarningCounts { fast_particle: 1, ..overlaps(9) };
        assert_eq!(watch.due(start + QUIET / 2, both), [Due { guard: Guard::FastParticle, count: 1, total: 1 }]);
        assert_eq!(watch.due(start + QUIET, both), told(3, 9));
        assert_eq!(watch.due(start + 3 * QUIET, both), []);
        assert_eq!(watch.due(start + 4 * QUIET, overlaps(2)), [], "a restored run has counted less");
        assert_eq!(watch.due(start + 5 * QUIET, overlaps(3)), told(1, 3));
    }

    #[test]
    fn a_step_above_the_critical_one_is_told_now_and_then() {
        let mut watch = GuardWatch::new(WarningCounts::default());
        let start = Instant::now();
        assert!(watch.looks_at_step(start) && !watch.looks_at_step(start + STEP_QUIET / 2));
        assert!(watch.looks_at_step(start + STEP_QUIET));
        let reading = |value| GuardReading { particle: None, value, limit: 1e-5 };
        assert!(!watch.tells_of_step(start, &reading(1e-5)));
        assert!(watch.tells_of_step(start, &reading(2e-5)) && !watch.tells_of_step(start, &reading(2e-5)));
        let later = start + STEP_QUIET;
        assert!(watch.tells_of_step(later, &reading(2e-5)));
        let told = event(Due { guard: Guard::TimeStep, count: 0, total: 0 }, &reading(2e-5));
        assert_eq!(
            told.message,
            "the contacts present may be stable below 1.00e-5 s only, the time step is 2.00e-5 s: reduce it"
        );
    }

    #[test]
    fn an_event_names_the_particle_and_the_remedy() {
        let due = Due { guard: Guard::LargeOverlap, count: 3, total: 9 };
        let told = event(due, &GuardReading { particle: Some(812), value: 0.25, limit: 0.1 });
        let warning = told.warning.unwrap();
        assert_eq!((warning.kind(), warning.count, warning.total), (v1::WarningKind::LargeOverlap, 3, 9));
        assert_eq!((warning.particle_id, warning.value, warning.limit), (Some(812), 0.25, 0.1));
        assert!(told.message.starts_with("particle 812 overlaps another body by 0.250"), "{}", told.message);
    }
}
