//! What must be answered: kept with an order until it is settled.

use prost::bytes::Bytes;
use sturz_engine::Effect;
use sturz_protocol::keys::Verb;
use sturz_protocol::v1::{self, outcome::Result as Wire};

use crate::journal::record::{Accepted, Due, Entry};
use crate::mailbox::ReplyTo;
use crate::order::{Order, RequestKey};

/// An order that awaits its outcome.
pub struct Ticket {
    key: RequestKey,
    verb: Verb,
    request: Bytes,
    reply: ReplyTo,
    logged: Logged,
    /// Steps done when it was taken on.
    taken_on: u64,
}

/// What the journal knows of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Logged {
    /// Nothing: it is settled at once, or refused.
    No,
    /// That it was accepted.
    Accepted,
    /// That it waits for its simulated time, which has come.
    Due,
}

/// When an order took effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Steps done by then.
    pub step: u64,
    /// Simulated time then.
    pub time_s: f64,
}

impl Ticket {
    /// For an order.
    pub fn new(order: &Order, reply: ReplyTo, taken_on: u64) -> Self {
        let request = order.request.clone();
        Self { key: order.key.clone(), verb: order.verb, request, reply, logged: Logged::No, taken_on }
    }

    /// The step of its entry in the journal, if that is made at step `now`: a command that changes the step is found
    /// where it came.
    pub fn entry_step(&self, now: u64) -> u64 {
        if self.logged == Logged::No { self.taken_on } else { now }
    }

    /// Which request it is of.
    pub fn key(&self) -> &RequestKey {
        &self.key
    }

    /// Which command it is.
    pub fn verb(&self) -> Verb {
        self.verb
    }

    /// What the journal knows of it.
    pub fn logged(&self) -> Logged {
        self.logged
    }

    /// For the journal: the command, without what becomes of it.
    pub fn accepted(&self) -> Accepted {
        Accepted { verb: self.verb.name().into(), request: self.request.clone(), outcome: None }
    }

    /// The journal knows.
    pub fn set_logged(&mut self, logged: Logged) {
        self.logged = logged;
    }

    /// What the journal shall say at its outcome; nothing of a refusal.
    pub fn entry(&self, outcome: &v1::Outcome) -> Option<Entry> {
        let is_refused = matches!(outcome.result, Some(Wire::Error(_)));
        match self.logged {
            Logged::Accepted => Some(Entry::Settled(outcome.clone())),
            Logged::Due => Some(Entry::Due(Due { outcome: Some(outcome.clone()) })),
            Logged::No if is_refused || self.verb == Verb::ListCheckpoints => None,
            Logged::No => Some(Entry::Command(Accepted { outcome: Some(outcome.clone()), ..self.accepted() })),
        }
    }

    /// Where its answer goes.
    pub fn into_reply(self) -> ReplyTo {
        self.reply
    }
}

/// An outcome.
pub fn outcome(key: &RequestKey, verb: Verb, moment: Moment, result: Wire) -> v1::Outcome {
    v1::Outcome {
        client_id: key.client_id.clone(),
        request_id: key.request_id.clone(),
        command: verb.name().into(),
        step: moment.step,
        sim_time_s: moment.time_s,
        repeated: false,
        result: Some(result),
    }
}

/// What an engine command did, for the wire.
pub fn effect_to_wire(effect: &Effect) -> Wire {
    match *effect {
        Effect::Inserted { first_id, count } => Wire::Inserted(v1::Inserted { first_id, count }),
        Effect::Removed { count } => Wire::Removed(v1::Removed { count }),
        Effect::GravitySet | Effect::MotionSet | Effect::LoadsSet | Effect::FluidSet => Wire::Applied(v1::Applied {}),
    }
}
