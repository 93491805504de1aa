//! Who may let time go on: the holder of the lease, as long as its liveliness lasts; anybody while there is none.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

use sturz_protocol::keys::{Verb, check_name};
use sturz_protocol::v1::{self, outcome::Result as Wire};

use crate::journal::record::{Entry, LeaseLost};
use crate::order::{RequestKey, error};
use crate::runner::{Phase, Runner};

/// Clients whose liveliness tokens are there. Written by the bus, read by the physics.
#[derive(Default)]
pub struct Clients {
    alive: Mutex<BTreeSet<String>>,
    /// The holder of the lease, and whether it has vanished since it is, be it for a moment.
    watched: Mutex<Option<(String, bool)>>,
    changes: AtomicU64,
}

impl Clients {
    /// The bus has heard of a client. Of those that would be more than `most`, nothing is noted.
    pub fn note(&self, name: &str, is_alive: bool, most: usize) {
        let mut alive = self.alive.lock().unwrap_or_else(PoisonError::into_inner);
        if !is_alive {
            alive.remove(name);
        } else if alive.len() < most {
            alive.insert(name.into());
        } else if !alive.contains(name) {
            tracing::warn!("{name} is not watched: {most} clients are (limit `clients`)");
        }
        drop(alive);
        let mut watched = self.watched.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, vanished)) = watched.as_mut().filter(|(watched, _)| watched == name) {
            *vanished |= !is_alive;
        }
        drop(watched);
        self.changes.fetch_add(1, Relaxed);
    }

    /// Has [`Clients::has_vanished`] tell of this client from now on.
    fn watch(&self, name: &str) {
        *self.watched.lock().unwrap_or_else(PoisonError::into_inner) = Some((name.into(), false));
    }

    /// Whether the watched client has vanished, even if it is there again: it has given up what it waited for.
    fn has_vanished(&self, name: &str) -> bool {
        let watched = self.watched.lock().unwrap_or_else(PoisonError::into_inner);
        watched.as_ref().is_some_and(|(watched, vanished)| watched == name && *vanished)
    }

    fn has(&self, name: &str) -> bool {
        self.alive.lock().unwrap_or_else(PoisonError::into_inner).contains(name)
    }

    fn count(&self) -> usize {
        self.alive.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    fn changes(&self) -> u64 {
        self.changes.load(Relaxed)
    }
}

/// Who holds it, and the changes among the clients that this was checked against.
pub struct Lease {
    holder: String,
    checked: u64,
}

/// What others than the holder may not do.
const HOLDERS_ONLY: [Verb; 6] =
    [Verb::Step, Verb::Advance, Verb::Resume, Verb::Restore, Verb::SetLoads, Verb::SetFluid];

impl Runner<'_> {
    /// Refuses what only the holder of the lease may do.
    pub(crate) fn check_lease(&self, key: &RequestKey, verb: Verb) -> Result<(), v1::Error> {
        match &self.lease {
            Some(lease) if HOLDERS_ONLY.contains(&verb) && lease.holder != key.client_id => {
                let text = format!("{:?} holds the lease: only that client may {} now", lease.holder, verb.name());
                Err(error(v1::ErrorCode::Lease, "", text))
            }
            _ => Ok(()),
        }
    }

    /// Gives the lease to a client that is alive, unless another one has it.
    pub(crate) fn acquire_lease(&mut self, client: &str) -> Result<Wire, v1::Error> {
        self.watch_lease();
        check_name(client)
            .map_err(|problem| error(v1::ErrorCode::InvalidInput, "header.client_id", problem.to_string()))?;
        if let Some(lease) = self.lease.as_ref().filter(|lease| lease.holder != client) {
            let text = format!("{:?} holds the lease", lease.holder);
            return Err(error(v1::ErrorCode::Lease, "", text));
        }
        let checked = self.shared.clients.changes();
        if self.lease.is_none() {
            self.shared.clients.watch(client);
        }
        if !self.shared.clients.has(client) && !self.journal.is_replaying() {
            let text = if self.shared.clients.count() < self.limits.clients {
                format!("the liveliness token client/{client} is not declared: it is how the loss of this client shows")
            } else {
                format!("{} clients are watched, more cannot be (limit `clients`)", self.limits.clients)
            };
            return Err(error(v1::ErrorCode::Lease, "header.client_id", text));
        }
        if self.lease.replace(Lease { holder: client.into(), checked }).is_none() {
            self.announce_lease("the lease was acquired", v1::LeaseChange::Acquired, client);
        }
        Ok(Wire::Applied(v1::Applied {}))
    }

    /// Takes the lease back from its holder.
    pub(crate) fn release_lease(&mut self, client: &str) -> Result<Wire, v1::Error> {
        match &self.lease {
            Some(lease) if lease.holder == client => {
                self.lease = None;
                self.announce_lease("the lease was released", v1::LeaseChange::Released, client);
                Ok(Wire::Applied(v1::Applied {}))
            }
            Some(lease) => Err(error(v1::ErrorCode::Lease, "", format!("{:?} holds the lease", lease.holder))),
            None => Err(error(v1::ErrorCode::Lease, "", "nobody holds the lease")),
        }
    }

    /// Pauses when the holder of the lease was lost.
    pub(crate) fn watch_lease(&mut self) {
        let Some(lease) = &mut self.lease else { return };
        let changes = self.shared.clients.changes();
        if std::mem::replace(&mut lease.checked, changes) == changes {
            return;
        }
        if self.shared.clients.has(&lease.holder) && !self.shared.clients.has_vanished(&lease.holder) {
            return;
        }
        let holder = std::mem::take(&mut lease.holder);
        tracing::warn!("the holder of the lease, {holder}, was lost");
        self.lose_lease(&holder);
    }

    /// Ends what the holder had under way.
    pub(crate) fn lose_lease(&mut self, holder: &str) {
        self.lease = None;
        self.post(Entry::LeaseLost(LeaseLost { holder: holder.into() }));
        self.announce_lease("the holder of the lease was lost", v1::LeaseChange::Lost, holder);
        self.finish_window(v1::StopReason::LeaseLost);
        if self.phase == Phase::Running {
            self.set_phase(Phase::Paused, "the simulation is paused: the holder of the lease was lost");
        }
    }

    /// As a snapshot has it; its holder is not known to be there.
    pub(crate) fn set_lease_holder(&mut self, holder: String) {
        self.lease = (!holder.is_empty()).then_some(Lease { holder, checked: 0 });
    }

    /// Who holds it; empty when nobody does.
    pub(crate) fn lease_holder(&self) -> String {
        self.lease.as_ref().map_or_else(String::new, |lease| lease.holder.clone())
    }

    fn announce_lease(&self, message: &str, change: v1::LeaseChange, client: &str) {
        let is_lost = change == v1::LeaseChange::Lost;
        let severity = if is_lost { v1::Severity::Warning } else { v1::Severity::Info };
        self.announce_event(v1::Event {
            kind: v1::EventKind::Lease.into(),
            severity: severity.into(),
            message: message.into(),
            name: client.into(),
            lease: change.into(),
            ..v1::Event::default()
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_that_was_away_for_a_moment_has_vanished() {
        let clients = Clients::default();
        clients.note("a", true, 9);
        clients.watch("a");
        clients.note("b", true, 9);
        clients.note("b", false, 9);
        assert!(!clients.has_vanished("a"));
        clients.note("a", false, 9);
        clients.note("a", true, 9);
        assert!(clients.has("a") && clients.has_vanished("a"));
        clients.watch("a");
        assert!(!clients.has_vanished("a"));
    }

    #[test]
    fn clients_are_noted_up_to_the_limit() {
        let clients = Clients::default();
        for name in ["a", "b", "c", "a"] {
            clients.note(name, true, 2);
        }
        assert!(clients.has("a") && clients.has("b") && !clients.has("c"));
        clients.note("a", false, 2);
        clients.note("c", true, 2);
        assert!(!clients.has("a") && clients.has("c"));
        assert_eq!(clients.changes(), 6);
    }
}
