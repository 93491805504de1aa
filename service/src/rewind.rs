//! Orders about checkpoints, on the physics thread, between two steps.

use sturz_engine::CheckpointError;
use sturz_protocol::v1::{self, outcome::Result as Wire};

use crate::order::error;
use crate::runner::{Phase, Runner};
use crate::ticket::Ticket;

impl Runner<'_> {
    /// Saves the state now; a file is answered when it is safe.
    pub(crate) fn checkpoint(&mut self, token: String, on_disk: bool, mut ticket: Ticket) {
        let token = if token.is_empty() { self.checkpoints.new_token(self.moment().step) } else { token };
        let saved = self.checkpoints.check_room(&token, on_disk, &self.limits);
        let saved = saved.and_then(|()| self.engine.checkpoint().map_err(|failure| unusable(&token, &failure)));
        let moment = self.moment();
        match saved {
            Err(error) => self.refuse(ticket, error),
            Ok(bytes) if on_disk && self.journal.is_replaying() => {
                let kept = self.checkpoints.keep_replayed(&token, bytes.into());
                let result =
                    kept.map(|checkpoint| Wire::Checkpointed(v1::Checkpointed { checkpoint: Some(checkpoint) }));
                self.settle(ticket, moment, result.unwrap_or_else(Wire::Error), None);
            }
            Ok(bytes) if on_disk => {
                let bytes = bytes.into();
                self.accept(&mut ticket);
                if let Some((Some((ticket, _)), error)) = self.checkpoints.send(&token, bytes, Some((ticket, moment))) {
                    self.refuse(ticket, error);
                }
            }
            Ok(bytes) => match self.checkpoints.keep(&token, bytes.into(), &self.limits) {
                Err(error) => self.refuse(ticket, error),
                Ok(checkpoint) => {
                    self.announce_checkpoint("a checkpoint was taken", &checkpoint);
                    let result = Wire::Checkpointed(v1::Checkpointed { checkpoint: Some(checkpoint) });
                    self.settle(ticket, moment, result, None);
                }
            },
        }
    }

    /// Answers those whose files are done.
    pub(crate) fn settle_files(&mut self) {
        while let Some((waiting, outcome)) = self.checkpoints.next_done() {
            let Some((ticket, moment)) = waiting else {
                self.autosaved(&outcome);
                continue;
            };
            let result = match outcome {
                Ok(checkpoint) => {
                    self.announce_checkpoint("a checkpoint was written", &checkpoint);
                    Wire::Checkpointed(v1::Checkpointed { checkpoint: Some(checkpoint) })
                }
                Err(error) => {
                    tracing::error!("{}", error.message);
                    Wire::Error(error)
                }
            };
            self.settle(ticket, moment, result, None);
        }
    }

    /// Goes to a saved state. The file is read here: steps done meanwhile would be thrown away.
    pub(crate) fn restore(&mut self, token: &str) -> Result<Wire, v1::Error> {
        self.check_no_window()?;
        let bytes = self.checkpoints.bytes(token)?;
        let checkpoint = self.checkpoints.described(token, &bytes).map_err(|failure| unusable(token, &failure))?;
        self.engine.restore(&bytes).map_err(|failure| unusable(token, &failure))?;
        self.follow_averages();
        if self.engine.clock().is_in_window() {
            // Whose window it was is over.
            self.engine.end_window();
        }
        if let Phase::Failed(_) = self.phase {
            self.phase = Phase::Paused;
        }
        self.last_window = None;
        let now = self.moment();
        self.shared.set_moment(now);
        self.stop_time_s = self.engine.scene().description().stop.time_s.filter(|&stop| stop > now.time_s);
        self.revision += 1;
        let text = format!("the simulation went to a checkpoint of step {}", now.step);
        self.announce_event(checkpoint_event(v1::EventKind::Restored, &text, &checkpoint));
        Ok(Wire::Restored(v1::Restored { checkpoint: Some(checkpoint) }))
    }

    /// Names all that are saved.
    pub(crate) fn list_checkpoints(&self) -> Wire {
        Wire::Checkpoints(v1::Checkpoints { checkpoints: self.checkpoints.list() })
    }

    /// Forgets one.
    pub(crate) fn drop_checkpoint(&mut self, token: &str) -> Result<Wire, v1::Error> {
        self.checkpoints.drop_one(token)?;
        self.announce_named(v1::EventKind::Checkpoint, v1::Severity::Info, "a checkpoint was dropped", token);
        Ok(Wire::Applied(v1::Applied {}))
    }

    pub(crate) fn announce_checkpoint(&self, message: &str, checkpoint: &v1::Checkpoint) {
        self.announce_event(checkpoint_event(v1::EventKind::Checkpoint, message, checkpoint));
    }
}

fn checkpoint_event(kind: v1::EventKind, message: &str, checkpoint: &v1::Checkpoint) -> v1::Event {
    v1::Event {
        kind: kind.into(),
        severity: v1::Severity::Info.into(),
        message: message.into(),
        name: checkpoint.token.clone(),
        checkpoint: Some(checkpoint.clone()),
        ..v1::Event::default()
    }
}

fn unusable(token: &str, failure: &CheckpointError) -> v1::Error {
    match failure {
        CheckpointError::RunFailed { .. } => error(v1::ErrorCode::RunFailed, "", failure.to_string()),
        _ => error(v1::ErrorCode::UnusableCheckpoint, "token", format!("the checkpoint {token:?} {failure}")),
    }
}
