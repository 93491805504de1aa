//! What a service must survive: kills, damaged files, hostile messages, crowds of listeners. One id a check.

mod bus;
pub(crate) mod chance;
pub(crate) mod daemon;
mod damage;
mod kills;
mod listeners;
mod lockstep;
mod messages;
mod script;

use std::path::PathBuf;
use std::time::Duration;

use crate::cases::{Checks, Row};

pub use listeners::listen;

/// How much of a check is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// For `make test`.
    Short,
    /// All of it.
    Full {
        /// How long listeners come and go.
        soak: Duration,
    },
}

impl Size {
    fn of(self, short: u32, full: u32) -> u32 {
        match self {
            Size::Short => short,
            Size::Full { .. } => full,
        }
    }
}

/// A check.
pub struct Fault {
    /// Its id.
    pub id: &'static str,
    /// One line.
    pub title: &'static str,
    run: fn(&mut Checks, Size) -> anyhow::Result<()>,
}

impl Fault {
    /// Runs it. A check that cannot be run ends with a row that fails and says why.
    pub fn rows(&self, size: Size) -> Vec<Row> {
        let mut checks = Checks::new(self.id, PathBuf::new());
        if let Err(error) = (self.run)(&mut checks, size) {
            checks.holds(format!("ran to its end ({error:#})"), false);
        }
        checks.into_rows()
    }
}

/// All checks.
pub fn registry() -> Vec<Fault> {
    vec![
        Fault { id: "KILL", title: "killed at random moments and taken up again", run: kills::check },
        Fault { id: "DAMAGE", title: "cuts and flipped bits in a journal's files", run: damage::check },
        Fault { id: "HOSTILE", title: "messages that cannot be used, on every key", run: messages::check },
        Fault { id: "S22", title: "commands in the midst of things, out of order, twice, and large", run: bus::check },
        Fault { id: "CROWD", title: "listeners that hang, die, come and go", run: listeners::check },
        Fault { id: "LOCKSTEP", title: "what a window costs over the bus", run: lockstep::check },
    ]
}
