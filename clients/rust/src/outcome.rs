//! What became of commands.

use std::ops::Range;

use sturz_protocol::v1::{self, outcome::Result as Wire};

use crate::contacts::Contacts;
use crate::error::{ClientError, Refusal};
use crate::field::Field;
use crate::fluid::Exchange;
use crate::state::State;

/// When a command took effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Steps done by then.
    pub step: u64,
    /// Simulated time then, s.
    pub time_s: f64,
    /// The daemon answered from memory: it had the request before, and did not apply it again.
    pub is_repeated: bool,
}

/// Done, and nothing more to say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Applied {
    /// When.
    pub at: Moment,
}

/// Particles were added.
#[derive(Clone, Debug, PartialEq)]
pub struct Inserted {
    /// When.
    pub at: Moment,
    /// Theirs, never used again for others.
    pub ids: Range<u64>,
}

/// Particles were removed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Removed {
    /// When.
    pub at: Moment,
    /// How many.
    pub count: u64,
}

/// Steps were done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepped {
    /// Where they began.
    pub at: Moment,
    /// By this command.
    pub steps_done: u64,
    /// Done by the state now.
    pub step: u64,
    /// Simulated time now, s.
    pub time_reached_s: f64,
    /// All done, or ended early.
    pub stop_reason: v1::StopReason,
}

/// A window was done.
#[derive(Clone, Debug, PartialEq)]
pub struct Advanced {
    /// Where it began.
    pub at: Moment,
    /// Of this window.
    pub steps_done: u64,
    /// That the window was cut into.
    pub window_steps: u64,
    /// Done by the state now.
    pub step: u64,
    /// Simulated time now, s: the bits with which the next window starts.
    pub time_reached_s: f64,
    /// All done, or ended early.
    pub stop_reason: v1::StopReason,
    /// At the end of the window; `None` when no columns were asked for, or when the answer came from memory and the
    /// daemon is at another step by now.
    pub state: Option<State>,
    /// At the end of the window, in the order asked for.
    pub fields: Vec<Field>,
    /// At the end of the window; `None` as for the state.
    pub contacts: Option<Contacts>,
    /// For the fluid, over the window; `None` as for the state, and where there is no fluid with a mesh.
    pub exchange: Option<Exchange>,
}

/// The state was saved.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpointed {
    /// The state that was saved.
    pub at: Moment,
    /// Under which token, and where.
    pub checkpoint: v1::Checkpoint,
}

/// The simulation went to a saved state.
#[derive(Clone, Debug, PartialEq)]
pub struct Restored {
    /// Where it is now.
    pub at: Moment,
    /// What was restored.
    pub checkpoint: v1::Checkpoint,
}

/// The saved states, by token.
pub(crate) struct Checkpoints(pub(crate) Vec<v1::Checkpoint>);

/// A kind of outcome.
pub(crate) trait Kind: Sized {
    /// `None` when the daemon answers as to another command.
    fn from_result(at: Moment, result: Wire) -> Option<Self>;
}

impl Kind for Applied {
    fn from_result(at: Moment, result: Wire) -> Option<Self> {
        matches!(result, Wire::Applied(_)).then_some(Self { at })
    }
}

impl Kind for Inserted {
    fn from_result(at: Moment, result: Wire) -> Option<Self> {
        let Wire::Inserted(v1::Inserted { first_id, count }) = result else { return None };
        Some(Self { at, ids: first_id..first_id.checked_add(count)? })
    }
}

impl Kind for Removed {
    fn from_result(at: Moment, result: Wire) -> Option<Self> {
        let Wire::Removed(v1::Removed { count }) = result else { return None };
        Some(Self { at, count })
    }
}

impl Kind for Stepped {
    fn from_result(at: Moment, result: Wire) -> Option<Self> {
        let Wire::Stepped(done) = result else { return None };
        Some(Self {
            at,
            steps_done: done.steps_done,
            step: done.step,
            time_reached_s: done.time_reached_s,
            stop_reason: done.stop_reason(),
        })
    }
}

impl Kind for Advanced {
    fn from_result(at: Moment, result: Wire) -> Option<Self> {
        let Wire::Advanced(done) = result else { return None };
        Some(Self {
            at,
            steps_done: done.steps_done,
            window_steps: done.window_steps,
            step: done.step,
            time_reached_s: done.time_reached_s,
            stop_reason: done.stop_reason(),
            state: done.frame.map(State::new),
            fields: done.fields.into_iter().map(Field::new).collect(),
            contacts: done.contacts.map(Contacts::new),
            exchange: done.exchange.map(Exchange::new),
        })
    }
}

impl Kind for Checkpointed {
    fn from_result(at: Moment, result: Wire) -> Option<Self> {
        let Wire::Checkpointed(v1::Checkpointed { checkpoint }) = result else { return None };
        Some(Self { at, checkpoint: checkpoint? })
    }
}

impl Kind for Restored {
    fn from_result(at: Moment, result: Wire) -> Option<Self> {
        let Wire::Restored(v1::Restored { checkpoint }) = result else { return None };
        Some(Self { at, checkpoint: checkpoint? })
    }
}

impl Kind for Checkpoints {
    fn from_result(_: Moment, result: Wire) -> Option<Self> {
        let Wire::Checkpoints(v1::Checkpoints { checkpoints }) = result else { return None };
        Some(Self(checkpoints))
    }
}

/// The outcome, unless it is a refusal.
pub(crate) fn accepted(command: &str, outcome: v1::Outcome) -> Result<v1::Outcome, ClientError> {
    match outcome.result {
        Some(Wire::Error(error)) => Err(Refusal::new(command, error, Some(outcome.step)).into()),
        _ => Ok(outcome),
    }
}

/// Simulated time when the outcome was made, s: behind the steps of a command, not before them.
pub(crate) fn time_reached_s(outcome: &v1::Outcome) -> f64 {
    match &outcome.result {
        Some(Wire::Stepped(done)) => done.time_reached_s,
        Some(Wire::Advanced(done)) => done.time_reached_s,
        _ => outcome.sim_time_s,
    }
}

/// An accepted outcome, as the command promises it.
pub(crate) fn read<K: Kind>(outcome: v1::Outcome) -> Result<K, ClientError> {
    let at = Moment { step: outcome.step, time_s: outcome.sim_time_s, is_repeated: outcome.repeated };
    let kind = outcome.result.and_then(|result| K::from_result(at, result));
    kind.ok_or_else(|| ClientError::unreadable(&outcome.command, "it is of another command"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(result: Wire) -> v1::Outcome {
        let result = Some(result);
        v1::Outcome { command: "insert".into(), step: 4, sim_time_s: 0.5, repeated: true, result, ..Default::default() }
    }

    #[test]
    fn outcomes_say_what_and_when() {
        let inserted: Inserted = read(outcome(Wire::Inserted(v1::Inserted { first_id: 7, count: 3 }))).unwrap();
        assert_eq!(inserted.ids, 7..10);
        assert_eq!(inserted.at, Moment { step: 4, time_s: 0.5, is_repeated: true });
    }

    #[test]
    fn the_time_reached_is_that_behind_the_steps() {
        let stepped = Wire::Stepped(v1::Stepped { time_reached_s: 0.75, ..Default::default() });
        assert_eq!(time_reached_s(&outcome(stepped)), 0.75);
        assert_eq!(time_reached_s(&outcome(Wire::Applied(v1::Applied {}))), 0.5);
    }

    #[test]
    fn a_refusal_is_an_error_with_its_step() {
        let error = v1::Error { code: v1::ErrorCode::Busy.into(), ..Default::default() };
        let error = accepted("insert", outcome(Wire::Error(error))).unwrap_err();
        let refusal = error.refusal().unwrap();
        assert_eq!((refusal.code, refusal.step), (v1::ErrorCode::Busy, Some(4)));
    }

    #[test]
    fn an_outcome_of_another_command_is_not_taken() {
        let applied = outcome(Wire::Applied(v1::Applied {}));
        assert!(matches!(read::<Inserted>(applied), Err(ClientError::Unreadable { .. })));
        let nothing = v1::Outcome::default();
        assert!(matches!(read::<Applied>(nothing), Err(ClientError::Unreadable { .. })));
        let wraps = outcome(Wire::Inserted(v1::Inserted { first_id: u64::MAX, count: 2 }));
        assert!(matches!(read::<Inserted>(wraps), Err(ClientError::Unreadable { .. })));
    }
}
