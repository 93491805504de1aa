//! Where everything is on the bus: `sturz/v1/<instance>/...`.
//!
//! | key | kind | payload |
//! |---|---|---|
//! | `cmd/<verb>` | query (or put) | request -> [`Outcome`](crate::v1::Outcome) |
//! | `info`, `features`, `plan`, `report/latest` | query | `Info`, `Features`, `Plan`, `Report` |
//! | `shapes/<epoch>`, `shapes/latest` | query | `Shapes` |
//! | `state/latest?columns=a\|b;float=f32` | query | `Frame` |
//! | `contacts/latest?columns=a\|b;float=f32` | query | `ContactFrame` |
//! | `field/<name>/latest` | query | `FieldFrame` |
//! | `state/frame`, `contacts/frame` | publication | `Frame`, `ContactFrame` |
//! | `field/<name>`, `report` | publication | `FieldFrame`, `Report` |
//! | `event/{command, run, particles, field, output, warning, checkpoint}` | advanced publication | `Event` |
//! | `alive`, `client/<client id>` | liveliness tokens of the daemon and of clients | |

use thiserror::Error;

/// Longest name of an instance or a field, and longest client and request id, in bytes.
pub const MAX_NAME_BYTES: usize = 64;

/// Liveliness tokens of all daemons on the bus.
pub const ALL_ALIVE: &str = "sturz/v1/*/alive";

/// A name that cannot be part of a key.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{name:?} is no usable name: 1 to {MAX_NAME_BYTES} letters, digits, `_` and `-` are")]
pub struct InvalidName {
    /// The name.
    pub name: String,
}

/// Whether `name` may be an instance's or a field's: it becomes a chunk of a key, where `/`, `*`, `$`, `#`, `?` and
/// blanks have other meanings.
pub fn check_name(name: &str) -> Result<(), InvalidName> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if (1..=MAX_NAME_BYTES).contains(&name.len()) && name.chars().all(plain) {
        Ok(())
    } else {
        Err(InvalidName { name: name.into() })
    }
}

/// A command by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Verb {
    /// Adds particles.
    Insert,
    /// Removes particles.
    Remove,
    /// Sets gravity.
    SetGravity,
    /// Moves a boundary.
    SetMotion,
    /// Loads particles from outside.
    SetLoads,
    /// Puts a fluid around the particles.
    SetFluid,
    /// Stops stepping.
    Pause,
    /// Steps freely.
    Resume,
    /// Does some steps.
    Step,
    /// Advances by a window.
    Advance,
    /// Defines a field.
    DefineField,
    /// Forgets a field.
    DropField,
    /// Sets columns, type and pace of a stream.
    DefineOutput,
    /// Saves the state.
    Checkpoint,
    /// Goes back to a saved state.
    Restore,
    /// Names the saved states.
    ListCheckpoints,
    /// Forgets a saved state.
    DropCheckpoint,
    /// Lets nobody else advance.
    AcquireLease,
    /// Lets others advance again.
    ReleaseLease,
    /// Ends the daemon.
    Stop,
}

impl Verb {
    /// All of them.
    pub const ALL: [Verb; 20] = [
        Verb::Insert,
        Verb::Remove,
        Verb::SetGravity,
        Verb::SetMotion,
        Verb::SetLoads,
        Verb::SetFluid,
        Verb::Pause,
        Verb::Resume,
        Verb::Step,
        Verb::Advance,
        Verb::DefineField,
        Verb::DropField,
        Verb::DefineOutput,
        Verb::Checkpoint,
        Verb::Restore,
        Verb::ListCheckpoints,
        Verb::DropCheckpoint,
        Verb::AcquireLease,
        Verb::ReleaseLease,
        Verb::Stop,
    ];

    /// Last chunk of its key.
    pub fn name(self) -> &'static str {
        match self {
            Verb::Insert => "insert",
            Verb::Remove => "remove",
            Verb::SetGravity => "set_gravity",
            Verb::SetMotion => "set_motion",
            Verb::SetLoads => "set_loads",
            Verb::SetFluid => "set_fluid",
            Verb::Pause => "pause",
            Verb::Resume => "resume",
            Verb::Step => "step",
            Verb::Advance => "advance",
            Verb::DefineField => "define_field",
            Verb::DropField => "drop_field",
            Verb::DefineOutput => "define_output",
            Verb::Checkpoint => "checkpoint",
            Verb::Restore => "restore",
            Verb::ListCheckpoints => "list_checkpoints",
            Verb::DropCheckpoint => "drop_checkpoint",
            Verb::AcquireLease => "acquire_lease",
            Verb::ReleaseLease => "release_lease",
            Verb::Stop => "stop",
        }
    }
}

/// The keys of one instance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Keys {
    instance: String,
}

impl Keys {
    /// Keys of `instance`.
    pub fn new(instance: &str) -> Result<Self, InvalidName> {
        check_name(instance)?;
        Ok(Self { instance: instance.into() })
    }

    /// The instance's name.
    pub fn instance(&self) -> &str {
        &self.instance
    }

    /// `sturz/v1/<instance>/<tail>`.
    fn key(&self, tail: &str) -> String {
        format!("sturz/v1/{}/{tail}", self.instance)
    }

    /// Of one command.
    pub fn command(&self, verb: Verb) -> String {
        self.key(&format!("cmd/{}", verb.name()))
    }

    /// Query for `Info`.
    pub fn info(&self) -> String {
        self.key("info")
    }

    /// Query for `Features`.
    pub fn features(&self) -> String {
        self.key("features")
    }

    /// Query for `Plan`.
    pub fn plan(&self) -> String {
        self.key("plan")
    }

    /// Query for `Shapes` of whatever epoch.
    pub fn shapes_latest(&self) -> String {
        self.key("shapes/latest")
    }

    /// Query for `Shapes` of one epoch.
    pub fn shapes(&self, epoch: u64) -> String {
        self.key(&format!("shapes/{epoch}"))
    }

    /// Every query for `Shapes`.
    pub fn all_shapes(&self) -> String {
        self.key("shapes/*")
    }

    /// Query for the `Frame` of now.
    pub fn state_latest(&self) -> String {
        self.key("state/latest")
    }

    /// Publication of `Frame`.
    pub fn state_frame(&self) -> String {
        self.key("state/frame")
    }

    /// Query for the `ContactFrame` of now.
    pub fn contacts_latest(&self) -> String {
        self.key("contacts/latest")
    }

    /// Query for `ExchangeFrame`.
    pub fn exchange_latest(&self) -> String {
        self.key("exchange/latest")
    }

    /// Publication of `ContactFrame`.
    pub fn contacts_frame(&self) -> String {
        self.key("contacts/frame")
    }

    /// Publication of a field's `FieldFrame`.
    pub fn field(&self, name: &str) -> String {
        self.key(&format!("field/{name}"))
    }

    /// Query for a field's `FieldFrame` of now.
    pub fn field_latest(&self, name: &str) -> String {
        self.key(&format!("field/{name}/latest"))
    }

    /// Every query for a field's `FieldFrame` of now.
    pub fn all_fields_latest(&self) -> String {
        self.key("field/*/latest")
    }

    /// Publication of `Report`.
    pub fn report(&self) -> String {
        self.key("report")
    }

    /// Query for the `Report` of now.
    pub fn report_latest(&self) -> String {
        self.key("report/latest")
    }

    /// Publication of one topic of `Event`.
    pub fn event(&self, topic: &str) -> String {
        self.key(&format!("event/{topic}"))
    }

    /// Every event.
    pub fn all_events(&self) -> String {
        self.key("event/**")
    }

    /// Liveliness token of a client: what its lease hangs on.
    pub fn client(&self, client_id: &str) -> String {
        self.key(&format!("client/{client_id}"))
    }

    /// Liveliness tokens of all clients.
    pub fn all_clients(&self) -> String {
        self.key("client/*")
    }

    /// Liveliness token.
    pub fn alive(&self) -> String {
        self.key("alive")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_would_change_a_key_are_refused() {
        for name in ["", "a/b", "*", "a*", "a$*", "#", "a?b", "a b", "ä", "@x", &"x".repeat(65)] {
            assert_eq!(check_name(name), Err(InvalidName { name: name.into() }));
        }
        for name in ["a", "drum-crosses", "A_1", &"x".repeat(64)] {
            assert_eq!(check_name(name), Ok(()));
        }
    }

    #[test]
    fn every_verb_has_its_own_key() {
        let keys = Keys::new("a").unwrap();
        let mut all = Verb::ALL.map(|verb| keys.command(verb)).to_vec();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), Verb::ALL.len());
        assert!(all.contains(&"sturz/v1/a/cmd/define_field".to_string()));
    }
}
