//! Outcomes of requests by their id: a retry is answered from here, and nothing is applied twice.

use std::collections::{HashMap, VecDeque};

use sturz_protocol::v1;

use crate::mailbox::ReplyTo;
use crate::order::RequestKey;

/// Remembers the last requests.
pub struct RequestMemory {
    capacity: usize,
    entries: HashMap<RequestKey, Entry>,
    /// Settled ones, oldest first.
    settled: VecDeque<RequestKey>,
}

struct Entry {
    fingerprint: u64,
    state: State,
}

enum State {
    /// Not settled yet; more replies to send when it is.
    Pending(Vec<ReplyTo>),
    /// Settled.
    Settled(Box<v1::Outcome>),
}

/// What is known of a request that comes in.
pub enum Admission {
    /// Nothing: go on with it.
    New(ReplyTo),
    /// It is on its way; the answer will go here too.
    Waits,
    /// It was settled.
    Known(Box<v1::Outcome>, ReplyTo),
    /// The id stands for another request.
    Reused(ReplyTo),
}

impl RequestMemory {
    /// Remembers `capacity` settled requests.
    pub fn new(capacity: usize) -> Self {
        Self { capacity, entries: HashMap::new(), settled: VecDeque::new() }
    }

    /// Looks a request up, and notes it as pending when it is new.
    pub fn admit(&mut self, key: &RequestKey, fingerprint: u64, reply: ReplyTo) -> Admission {
        if key.request_id.is_empty() {
            return Admission::New(reply);
        }
        match self.entries.get_mut(key) {
            None => {
                let entry = Entry { fingerprint, state: State::Pending(Vec::new()) };
                self.entries.insert(key.clone(), entry);
                Admission::New(reply)
            }
            Some(entry) if entry.fingerprint != fingerprint => Admission::Reused(reply),
            Some(Entry { state: State::Pending(waiting), .. }) => {
                waiting.push(reply);
                Admission::Waits
            }
            Some(Entry { state: State::Settled(outcome), .. }) => Admission::Known(outcome.clone(), reply),
        }
    }

    /// Forgets a request that was admitted as new and then refused for what will pass; returns who else waits for it.
    pub fn forget(&mut self, key: &RequestKey) -> Vec<ReplyTo> {
        match self.entries.remove(key).map(|entry| entry.state) {
            Some(State::Pending(waiting)) => waiting,
            Some(State::Settled(_)) | None => Vec::new(),
        }
    }

    /// Settled requests with their fingerprints, oldest first.
    pub fn settled(&self) -> impl Iterator<Item = (u64, &v1::Outcome)> {
        self.settled.iter().filter_map(|key| match self.entries.get(key) {
            Some(Entry { fingerprint, state: State::Settled(outcome) }) => Some((*fingerprint, &**outcome)),
            _ => None,
        })
    }

    /// Remembers what was settled before this process.
    pub fn remember(&mut self, fingerprint: u64, outcome: v1::Outcome) {
        let key = RequestKey { client_id: outcome.client_id.clone(), request_id: outcome.request_id.clone() };
        if !key.request_id.is_empty() {
            let known = Entry { fingerprint, state: State::Settled(Box::new(outcome)) };
            if self.entries.insert(key.clone(), known).is_none() {
                self.settled.push_back(key);
            }
        }
    }

    /// Another outcome of a settled request than the one remembered.
    pub fn correct(&mut self, key: &RequestKey, outcome: &v1::Outcome) {
        if let Some(entry) = self.entries.get_mut(key) {
            entry.state = State::Settled(Box::new(outcome.clone()));
        }
    }

    /// Remembers so many from now on.
    pub fn set_capacity(&mut self, capacity: usize) {
        self.capacity = capacity;
        while self.settled.len() > capacity
            && let Some(oldest) = self.settled.pop_front()
        {
            self.entries.remove(&oldest);
        }
    }

    /// Remembers the outcome of a request that was admitted as new; returns who else waits for it.
    pub fn settle(&mut self, key: &RequestKey, outcome: &v1::Outcome) -> Vec<ReplyTo> {
        let Some(entry) = self.entries.get_mut(key) else {
            return Vec::new();
        };
        let before = std::mem::replace(&mut entry.state, State::Settled(Box::new(outcome.clone())));
        self.settled.push_back(key.clone());
        if self.settled.len() > self.capacity
            && let Some(oldest) = self.settled.pop_front()
        {
            self.entries.remove(&oldest);
        }
        match before {
            State::Pending(waiting) => waiting,
            State::Settled(_) => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use tokio::sync::oneshot;

    use super::*;

    fn key(request_id: &str) -> RequestKey {
        RequestKey { client_id: "c".into(), request_id: request_id.into() }
    }

    fn reply() -> ReplyTo {
        oneshot::channel().0
    }

    #[test]
    fn a_settled_request_is_known_and_a_pending_one_waits() {
        let mut memory = RequestMemory::new(10);
        assert!(matches!(memory.admit(&key("1"), 7, reply()), Admission::New(_)));
        assert!(matches!(memory.admit(&key("1"), 7, reply()), Admission::Waits));
        assert!(matches!(memory.admit(&key("1"), 8, reply()), Admission::Reused(_)));
        let outcome = v1::Outcome { step: 5, ..Default::default() };
        assert_eq!(memory.settle(&key("1"), &outcome).len(), 1);
        match memory.admit(&key("1"), 7, reply()) {
            Admission::Known(known, _) => assert_eq!(*known, outcome),
            _ => panic!("forgotten"),
        }
    }

    #[test]
    fn clients_do_not_share_ids_and_no_id_is_not_remembered() {
        let mut memory = RequestMemory::new(10);
        let other = RequestKey { client_id: "d".into(), ..key("1") };
        assert!(matches!(memory.admit(&key("1"), 7, reply()), Admission::New(_)));
        assert!(matches!(memory.admit(&other, 8, reply()), Admission::New(_)));
        for _ in 0..2 {
            assert!(matches!(memory.admit(&key(""), 7, reply()), Admission::New(_)));
        }
        assert!(memory.settle(&key(""), &v1::Outcome::default()).is_empty());
    }

    #[test]
    fn the_oldest_settled_request_is_forgotten_first() {
        let mut memory = RequestMemory::new(2);
        for id in ["pending", "1", "2", "3"] {
            assert!(matches!(memory.admit(&key(id), 0, reply()), Admission::New(_)));
        }
        for id in ["1", "2", "3"] {
            memory.settle(&key(id), &v1::Outcome::default());
        }
        assert!(matches!(memory.admit(&key("2"), 0, reply()), Admission::Known(..)));
        assert!(matches!(memory.admit(&key("pending"), 0, reply()), Admission::Waits));
        assert!(matches!(memory.admit(&key("1"), 0, reply()), Admission::New(_)));
    }
}
