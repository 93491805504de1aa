//! Who comes and goes, for the log; and the last one that is let in.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::anyhow;
use zenoh::Session;
use zenoh::sample::SampleKind;
use zenoh::session::LinkEvent;

use super::folder::Roles;
use crate::config::Bus;

/// Connections of other sessions.
pub struct Door {
    /// Of clients with a certificate; `None` where everybody may do everything.
    roles: Option<Roles>,
    /// Sessions that zenoh lets in (limit `clients`).
    most: usize,
    /// By the address of the other side.
    inside: Mutex<BTreeMap<String, String>>,
}

impl Door {
    /// Logs, from now on, who comes and goes.
    pub async fn watch(session: &Session, bus: &Bus, most: usize) -> anyhow::Result<()> {
        let roles = bus.tls.as_ref().map(|tls| tls.roles.clone());
        let door = Arc::new(Self { roles, most, inside: Mutex::default() });
        let note = move |event: LinkEvent| door.note(&event);
        let info = session.info();
        let listener = info.link_events_listener().history(true).callback(note).background();
        listener.await.map_err(|error| anyhow!("cannot watch connections: {error}"))
    }

    fn note(&self, event: &LinkEvent) {
        let (address, name) = (event.link().dst().to_string(), event.link().auth_identifier());
        let is_there = event.kind() == SampleKind::Put;
        let mut inside = self.inside.lock().unwrap_or_else(PoisonError::into_inner);
        let name = if is_there {
            let name = self.describe(name);
            inside.insert(address.clone(), name.clone());
            name
        } else {
            inside.remove(&address).unwrap_or_else(|| "somebody".into())
        };
        let count = inside.len();
        drop(inside);
        if !is_there {
            tracing::info!("{name} left ({address})");
        } else if self.is_stranger(event.link().auth_identifier()) {
            tracing::warn!("{name} at {address} is refused everything");
        } else {
            tracing::info!("{name} came in from {address}");
        }
        if is_there && count == self.most {
            tracing::warn!("{count} clients are connected: no more are let in (limit `clients`)");
        }
    }

    fn is_stranger(&self, name: Option<&str>) -> bool {
        self.roles.as_ref().is_some_and(|roles| !name.is_some_and(|name| roles.contains_key(name)))
    }

    fn describe(&self, name: Option<&str>) -> String {
        match (&self.roles, name) {
            (None, _) => "a client".into(),
            (Some(roles), Some(name)) => match roles.get(name) {
                Some(role) => format!("{name} ({role})"),
                None => format!("{name:?}, which roles.toml does not name,"),
            },
            (Some(_), None) => "a client without a name in its certificate".into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Role;
    use super::*;

    #[test]
    fn names_come_with_their_role_and_strangers_are_told_apart() {
        let roles = Some([("alice".to_string(), Role::Steer)].into());
        let door = Door { roles, most: 3, inside: Mutex::default() };
        assert_eq!(door.describe(Some("alice")), "alice (steer)");
        assert!(!door.is_stranger(Some("alice")));
        assert!(door.is_stranger(Some("eve")) && door.is_stranger(None));
        assert!(door.describe(Some("eve")).contains("roles.toml does not name"));
        let open = Door { roles: None, most: 3, inside: Mutex::default() };
        assert!(!open.is_stranger(None));
    }
}
