//! How orders end, on the physics thread: remembered, put into the journal, answered.

use std::sync::Arc;

use sturz_protocol::keys::Verb;
use sturz_protocol::v1::{self, outcome::Result as Wire};

use crate::journal::record::{Due, Entry};
use crate::mailbox::{Answer, Capture};
use crate::order::error;
use crate::runner::Runner;
use crate::ticket::{Logged, Moment, Ticket, outcome};

/// What is possible while the journal cannot be written.
const WHILE_HELD: [Verb; 2] = [Verb::ListCheckpoints, Verb::Stop];

impl Runner<'_> {
    /// Remembers the outcome of an order, puts it into the journal, and answers all who wait for it once it is there.
    pub(crate) fn settle(&mut self, ticket: Ticket, moment: Moment, result: Wire, capture: Option<Arc<Capture>>) {
        let outcome = outcome(ticket.key(), ticket.verb(), moment, result);
        let (entry, step) = (ticket.entry(&outcome), ticket.entry_step(self.moment().step));
        let twins = self.memory.settle(ticket.key(), &outcome);
        let repeated = v1::Outcome { repeated: true, ..outcome.clone() };
        let mut replies = vec![(ticket.into_reply(), Answer { outcome, capture: capture.clone() })];
        replies.extend(twins.into_iter().map(|twin| {
            let answer = Answer { outcome: repeated.clone(), capture: capture.clone() };
            (twin, answer)
        }));
        self.journal.post(step, entry, replies);
    }

    /// Says no.
    pub(crate) fn refuse(&mut self, ticket: Ticket, error: v1::Error) {
        let moment = self.moment();
        self.settle(ticket, moment, Wire::Error(error), None);
    }

    /// Says no for now: the same request may be sent again. At once, since nothing gets through the journal.
    pub(crate) fn put_off(&mut self, ticket: Ticket, error: v1::Error) {
        let outcome = outcome(ticket.key(), ticket.verb(), self.moment(), Wire::Error(error));
        for reply in self.memory.forget(ticket.key()).into_iter().chain([ticket.into_reply()]) {
            // A client that has gone no longer wants to know.
            drop(reply.send(Answer { outcome: outcome.clone(), capture: None }));
        }
    }

    /// Puts an order into the journal whose outcome comes later.
    pub(crate) fn accept(&mut self, ticket: &mut Ticket) {
        let entry = match ticket.logged() {
            Logged::No => Entry::Command(ticket.accepted()),
            Logged::Due => Entry::Due(Due { outcome: None }),
            Logged::Accepted => return,
        };
        ticket.set_logged(Logged::Accepted);
        self.post(entry);
    }

    /// Puts something into the journal that nobody waits for.
    pub(crate) fn post(&mut self, entry: Entry) {
        let step = self.moment().step;
        self.journal.post(step, Some(entry), Vec::new());
    }

    /// Refuses what cannot be put into the journal.
    pub(crate) fn check_held(&self, verb: Verb) -> Option<v1::Error> {
        let reason = self.held.as_ref().filter(|_| !WHILE_HELD.contains(&verb))?;
        let text = format!(
            "nothing was changed: the journal cannot be written ({reason}); the same request may be sent again"
        );
        Some(error(v1::ErrorCode::Disk, "", text))
    }

    /// Holds the run while the journal cannot be written, and lets it go on afterwards.
    pub(crate) fn watch_disk(&mut self) {
        if !self.journal.disk_has_changed() {
            return;
        }
        let (blocked, written) = match self.journal.disk() {
            Some(disk) => (disk.blocked(), disk.take_written()),
            None => return,
        };
        if let Some(written) = written {
            self.snapshot_is_done(&written);
        }
        if self.held.is_some() == blocked.is_some() {
            return;
        }
        self.revision += 1;
        match &blocked {
            Some(reason) => {
                let text = format!("the run is held: the journal cannot be written ({reason})");
                self.announce(v1::EventKind::Journal, v1::Severity::Error, &text);
            }
            None => self.announce(
                v1::EventKind::Journal,
                v1::Severity::Info,
                "the journal is written again: the run goes on",
            ),
        }
        self.held = blocked;
    }
}
