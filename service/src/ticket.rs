//! What must be answered: kept with an order until it is settled.

use std::sync::Arc;

use sturz_engine::Effect;
use sturz_protocol::keys::Verb;
use sturz_protocol::v1::{self, outcome::Result as Wire};

use crate::mailbox::{Answer, Capture, ReplyTo};
use crate::memory::RequestMemory;
use crate::order::RequestKey;

/// An order that awaits its outcome.
pub struct Ticket {
    key: RequestKey,
    verb: Verb,
    reply: ReplyTo,
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
    /// For a request of this key.
    pub fn new(key: RequestKey, verb: Verb, reply: ReplyTo) -> Self {
        Self { key, verb, reply }
    }

    /// Which request it is of.
    pub fn key(&self) -> &RequestKey {
        &self.key
    }

    /// Which command it is.
    pub fn verb(&self) -> Verb {
        self.verb
    }

    /// Remembers the outcome, and sends it to all who wait for it.
    pub fn settle(self, memory: &mut RequestMemory, moment: Moment, result: Wire, capture: Option<Arc<Capture>>) {
        let outcome = outcome(&self.key, self.verb, moment, result);
        for twin in memory.settle(&self.key, &outcome) {
            let outcome = v1::Outcome { repeated: true, ..outcome.clone() };
            drop(twin.send(Answer { outcome, capture: capture.clone() }));
        }
        // A client that has gone no longer wants to know.
        drop(self.reply.send(Answer { outcome, capture }));
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
        Effect::GravitySet | Effect::MotionSet | Effect::LoadsSet => Wire::Applied(v1::Applied {}),
    }
}
