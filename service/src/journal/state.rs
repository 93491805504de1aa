//! The state of the daemon as a snapshot, and back.

use anyhow::{Context as _, anyhow};
use sturz_protocol::convert::{field_definition_from_wire, field_definition_to_wire};
use sturz_protocol::keys::Verb;
use tokio::sync::oneshot;

use crate::advance::Window;
use crate::checkpoints::Saved;
use crate::config::Limits;
use crate::guards::GuardWatch;
use crate::journal::record::{Accepted, DaemonState, Entry, Key, Mark, Remembered, WindowState};
use crate::journal::snapshot::{Snapshot, Written};
use crate::mailbox::{Answer, ReplyTo};
use crate::memory::Admission;
use crate::order::{Body, Order, RequestKey};
use crate::runner::{Phase, Runner};
use crate::ticket::{Logged, Moment, Ticket};

impl Runner<'_> {
    /// Sends a snapshot of now on its way. A run that has failed has none: the last sound one stays.
    pub(crate) fn save_snapshot(&mut self) {
        let Ok(engine) = self.engine.checkpoint() else { return };
        self.post(Entry::Mark(self.journal_mark()));
        let saved = self.checkpoints.saved();
        let daemon = DaemonState {
            sequence: self.journal.next_sequence(),
            running: self.phase == Phase::Running,
            stop_time_s: self.stop_time_s,
            fields: self.outbox.fields.iter().map(|field| field_definition_to_wire(&field.definition)).collect(),
            remembered: self
                .memory
                .settled()
                .map(|(fingerprint, outcome)| Remembered { fingerprint, outcome: Some(outcome.clone()) })
                .collect(),
            scheduled: self.schedule.iter().map(Ticket::accepted).collect(),
            window: self.window.as_ref().map(window_state),
            last_window: self.last_window.as_ref().map(key_to_record),
            tokens_made: saved.made,
            tokens: saved.checkpoints,
            lease_holder: self.lease_holder(),
            outputs: self.outbox.outputs(),
        };
        self.journal.save(Snapshot { daemon, engine: engine.into(), tokens: saved.bytes });
    }

    /// A snapshot is safe, or failed.
    pub(crate) fn snapshot_is_done(&mut self, written: &Written) {
        if let Some(autosave) = &mut self.autosave {
            autosave.is_writing = false;
        }
        match &written.outcome {
            Ok(_) => tracing::debug!("a snapshot was written before record {}", written.sequence),
            Err(failure) => tracing::error!("no snapshot before record {}: {failure}", written.sequence),
        }
    }

    /// The state of now, to be checked against.
    pub(crate) fn journal_mark(&self) -> Mark {
        Mark { state_hash: self.engine.state_hash(), time_s: self.moment().time_s }
    }

    /// Goes to a snapshot. `hear` gets where the outcomes of what was under way will come.
    ///
    /// # Errors
    /// A part of it cannot be: the runner is then of no use.
    pub fn load_snapshot(
        &mut self,
        snapshot: Snapshot,
        mut hear: impl FnMut(RequestKey, oneshot::Receiver<Answer>),
    ) -> anyhow::Result<()> {
        let Snapshot { daemon, engine, tokens } = snapshot;
        self.engine.restore(&engine).map_err(|failure| anyhow!("the snapshot {failure}"))?;
        self.phase = if daemon.running { Phase::Running } else { Phase::Paused };
        self.stop_time_s = daemon.stop_time_s;
        let known: Vec<String> = self.outbox.fields.iter().map(|field| field.definition.name.clone()).collect();
        for name in known {
            self.outbox.drop_field(&name);
        }
        for field in &daemon.fields {
            let definition =
                field_definition_from_wire(field).map_err(|input| anyhow!("a field: {}", input.problem))?;
            self.outbox.define_field(definition);
        }
        self.follow_averages();
        self.outbox.restore_outputs(&daemon.outputs).map_err(|error| anyhow!("an output: {}", error.message))?;
        // what a guard had told of is no news
        self.guards = GuardWatch::new(self.engine.warnings());
        for Remembered { fingerprint, outcome } in daemon.remembered {
            self.memory.remember(fingerprint, outcome.context("a remembered request without outcome")?);
        }
        for command in &daemon.scheduled {
            let (order, mut ticket) = self.taken_up(command, &mut hear)?;
            let time_s = order.at_time_s.context("a command that waits for no time")?;
            ticket.set_logged(Logged::Accepted);
            self.schedule.add(time_s, order, ticket);
        }
        if let Some(state) = &daemon.window {
            let (order, mut ticket) =
                self.taken_up(state.command.as_ref().context("a window of nobody")?, &mut hear)?;
            ticket.set_logged(Logged::Accepted);
            self.window = Some(window(state, order, ticket));
        }
        self.last_window =
            daemon.last_window.map(|key| RequestKey { client_id: key.client_id, request_id: key.request_id });
        self.checkpoints.load(Saved { checkpoints: daemon.tokens, bytes: tokens, made: daemon.tokens_made });
        self.set_lease_holder(daemon.lease_holder);
        let now = self.moment();
        self.shared.set_moment(now);
        Ok(())
    }

    /// An accepted command with a ticket of its own.
    fn taken_up(
        &mut self,
        command: &Accepted,
        hear: &mut impl FnMut(RequestKey, oneshot::Receiver<Answer>),
    ) -> anyhow::Result<(Order, Ticket)> {
        let order = order_of(command)?;
        let (reply, answer) = oneshot::channel();
        let reply = self.admit_again(&order, reply)?;
        hear(order.key.clone(), answer);
        let ticket = Ticket::new(&order, reply, self.moment().step);
        Ok((order, ticket))
    }

    fn admit_again(&mut self, order: &Order, reply: ReplyTo) -> anyhow::Result<ReplyTo> {
        match self.memory.admit(&order.key, order.fingerprint, reply) {
            Admission::New(reply) => Ok(reply),
            _ => Err(anyhow!("the request {:?} is under way and settled at once", order.key)),
        }
    }
}

/// The order of an accepted command.
pub fn order_of(command: &Accepted) -> anyhow::Result<Order> {
    let verb = Verb::ALL.iter().find(|verb| verb.name() == command.verb);
    let verb = *verb.with_context(|| format!("there is no command {:?}", command.verb))?;
    // What was accepted under one limit is not refused under another.
    Order::read(verb, command.request.clone(), &Limits::none())
        .map_err(|refusal| anyhow!("the command {} cannot be read: {}", command.verb, refusal.error.message))
}

fn key_to_record(key: &RequestKey) -> Key {
    Key { client_id: key.client_id.clone(), request_id: key.request_id.clone() }
}

fn window_state(window: &Window) -> WindowState {
    WindowState {
        command: Some(window.ticket.accepted()),
        begun_step: window.begun.step,
        begun_time_s: window.begun.time_s,
        to_time_s: window.to_time_s,
        steps_total: window.steps_total,
        steps_done: window.steps_done,
    }
}

fn window(state: &WindowState, order: Order, ticket: Ticket) -> Window {
    let outputs = match order.body {
        Body::Advance { outputs, .. } => Some(outputs),
        _ => None,
    };
    Window {
        ticket,
        outputs,
        begun: Moment { step: state.begun_step, time_s: state.begun_time_s },
        to_time_s: state.to_time_s,
        steps_total: state.steps_total,
        steps_done: state.steps_done,
    }
}
