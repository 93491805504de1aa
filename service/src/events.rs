//! What events say, and on which topic.

use sturz_engine::{Command, Effect};
use sturz_protocol::v1::{self, outcome::Result as Wire};

use crate::reply::Identity;
use crate::ticket::Moment;

/// Event topics, each with a history and a count of its own, so that many commands do not push out the start of the run.
pub const TOPICS: [&str; 7] = ["command", "run", "particles", "field", "output", "warning", "checkpoint"];

/// Where events of a kind are published.
pub fn topic(kind: v1::EventKind) -> &'static str {
    match kind {
        v1::EventKind::Command => "command",
        v1::EventKind::Particles => "particles",
        v1::EventKind::Field => "field",
        v1::EventKind::Output => "output",
        v1::EventKind::Warning => "warning",
        v1::EventKind::Checkpoint | v1::EventKind::Restored => "checkpoint",
        _ => "run",
    }
}

/// The outcome of a command, without what is large: frames, fields, contacts, the list of checkpoints.
pub fn command_event(identity: &Identity, mut outcome: v1::Outcome) -> v1::Event {
    match &mut outcome.result {
        Some(Wire::Advanced(advanced)) => {
            (advanced.frame, advanced.contacts, advanced.exchange) = (None, None, None);
            advanced.fields.clear();
        }
        Some(Wire::Checkpoints(all)) => all.checkpoints.clear(),
        _ => {}
    }
    let moment = Moment { step: outcome.step, time_s: outcome.sim_time_s };
    outcome_event(identity.header(moment, 0, 0), outcome)
}

/// The same with a header of one's own, and as it is.
pub(crate) fn outcome_event(header: v1::Header, outcome: v1::Outcome) -> v1::Event {
    let (severity, message) = match &outcome.result {
        Some(Wire::Error(error)) => (v1::Severity::Warning, error.message.clone()),
        _ => (v1::Severity::Info, format!("{} is done", outcome.command)),
    };
    v1::Event {
        header: Some(header),
        kind: v1::EventKind::Command.into(),
        severity: severity.into(),
        message,
        outcome: Some(outcome),
        ..v1::Event::default()
    }
}

/// What a command has done to the set of particles, if it has.
pub fn particles_event(command: &Command, effect: &Effect) -> Option<v1::Event> {
    let mut event = v1::Event {
        kind: v1::EventKind::Particles.into(),
        severity: v1::Severity::Info.into(),
        ..v1::Event::default()
    };
    match (command, effect) {
        (_, &Effect::Inserted { first_id, count }) => {
            event.message = format!("{count} particles were inserted");
            event.inserted = Some(v1::IdRange { first_id, count });
        }
        (Command::Remove(ids), Effect::Removed { count }) => {
            event.message = format!("{count} particles were removed");
            event.removed = ranges(ids);
        }
        _ => return None,
    }
    Some(event)
}

/// Ids as ascending stretches.
fn ranges(ids: &[u64]) -> Vec<v1::IdRange> {
    let mut sorted = ids.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let stretches = sorted.chunk_by(|&a, &b| b - a == 1);
    stretches.map(|ids| v1::IdRange { first_id: ids[0], count: ids.len() as u64 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn removed_ids_are_told_as_stretches() {
        let event = particles_event(&Command::Remove(vec![7, 3, 4, 9, 4, 5]), &Effect::Removed { count: 5 }).unwrap();
        let told: Vec<_> = event.removed.iter().map(|range| (range.first_id, range.count)).collect();
        assert_eq!(told, [(3, 3), (7, 1), (9, 1)]);
        assert!(particles_event(&Command::SetGravity([0.0; 3]), &Effect::GravitySet).is_none());
    }

    #[test]
    fn every_kind_has_a_topic_that_is_declared() {
        let kinds = (0..).map_while(|kind| v1::EventKind::try_from(kind).ok());
        assert!(kinds.clone().count() > 13);
        for kind in kinds {
            assert!(TOPICS.contains(&topic(kind)), "{kind:?}");
        }
    }
}
