//! Checkpoints on disk from time to time, without anybody asking: what a crash costs is the time since the last one.

use std::time::{Duration, Instant};

use sturz_protocol::v1;

use crate::runner::Runner;

/// Begin of the tokens; the step follows.
const PREFIX: &str = "auto-";
/// Files that are kept: the one before the last is there while the last is written, and should that be found damaged.
const KEPT: usize = 2;

/// When the next one is due.
pub struct Autosave {
    every: Duration,
    last: Instant,
    last_step: u64,
    /// One is on its way to the disk: a disk that is slower than the interval must not pile them up.
    pub(crate) is_writing: bool,
}

impl Autosave {
    /// One in each interval of wall time in which there were steps.
    pub fn new(every: Duration) -> Self {
        Self { every, last: Instant::now(), last_step: 0, is_writing: false }
    }

    fn is_due(&self, now: Instant, step: u64) -> bool {
        !self.is_writing && step != self.last_step && now.saturating_duration_since(self.last) >= self.every
    }
}

impl Runner<'_> {
    /// Saves the state if that is due.
    pub(crate) fn autosave(&mut self, now: Instant) {
        let step = self.moment().step;
        if self.journal.is_writing() && self.checkpoints.is_writing() {
            // A snapshot has no place for one that is neither asked for nor there.
            return;
        }
        let Some(autosave) = self.autosave.as_mut().filter(|autosave| autosave.is_due(now, step)) else { return };
        (autosave.last, autosave.last_step) = (now, step);
        if self.journal.is_writing() {
            autosave.is_writing = true;
            self.save_snapshot();
            return;
        }
        // A run that has failed is not saved: the last sound state stays.
        let Ok(bytes) = self.engine.checkpoint() else { return };
        let sent = self.checkpoints.send(&format!("{PREFIX}{step}"), bytes.into(), None);
        match sent {
            Some((_, error)) => tracing::warn!("no checkpoint at step {step}: {}", error.message),
            None => autosave.is_writing = true,
        }
    }

    /// One is safe, or failed: removes those that are older than the last few.
    pub(crate) fn autosaved(&mut self, outcome: &Result<v1::Checkpoint, v1::Error>) {
        if let Some(autosave) = &mut self.autosave {
            autosave.is_writing = false;
        }
        match outcome {
            Ok(checkpoint) => self.announce_checkpoint("a checkpoint was written", checkpoint),
            Err(error) => return tracing::error!("{}", error.message),
        }
        let mut saved: Vec<v1::Checkpoint> = self.checkpoints.list();
        saved.retain(|checkpoint| checkpoint.on_disk && is_auto(&checkpoint.token));
        saved.sort_by_key(|checkpoint| std::cmp::Reverse(checkpoint.step));
        for old in saved.iter().skip(KEPT) {
            if let Err(error) = self.checkpoints.drop_one(&old.token) {
                tracing::warn!("{}", error.message);
            }
        }
    }
}

/// Whether a token is one of these.
fn is_auto(token: &str) -> bool {
    token.strip_prefix(PREFIX).is_some_and(|step| step.parse::<u64>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn due_once_in_an_interval_with_steps_and_never_twice_at_a_time() {
        let mut autosave = Autosave::new(Duration::from_secs(10));
        let later = autosave.last + Duration::from_secs(10);
        assert!(!autosave.is_due(later - Duration::from_millis(1), 5));
        assert!(autosave.is_due(later, 5));
        assert!(!autosave.is_due(later, 0), "nothing has happened");
        autosave.is_writing = true;
        assert!(!autosave.is_due(later, 5));
        assert!(is_auto("auto-12") && !is_auto("auto-x") && !is_auto("mine"));
    }
}
