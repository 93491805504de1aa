//! Orders that wait for their simulated time.

use crate::order::{Order, RequestKey};
use crate::ticket::Ticket;

/// Orders by time, then by arrival.
#[derive(Default)]
pub struct Schedule {
    /// Latest first, so that the next one is popped from the end.
    orders: Vec<(f64, Order, Ticket)>,
}

impl Schedule {
    /// Orders that wait.
    pub fn len(&self) -> usize {
        self.orders.len()
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.orders.is_empty()
    }

    /// Puts an order behind all of the same or an earlier time.
    pub fn add(&mut self, time_s: f64, order: Order, ticket: Ticket) {
        let at = self.orders.partition_point(|(other, ..)| *other > time_s);
        self.orders.insert(at, (time_s, order, ticket));
    }

    /// The next order that is due at `now_s`.
    pub fn next_due(&mut self, now_s: f64) -> Option<(Order, Ticket)> {
        if self.orders.last().is_some_and(|(time, ..)| *time <= now_s) {
            return self.orders.pop().map(|(_, order, ticket)| (order, ticket));
        }
        None
    }

    /// All of them, next first.
    pub fn iter(&self) -> impl Iterator<Item = &Ticket> {
        self.orders.iter().rev().map(|(_, _, ticket)| ticket)
    }

    /// Takes one out; of several of one key the next one, as [`Schedule::drain`] does.
    pub fn remove(&mut self, key: &RequestKey) -> Option<Ticket> {
        let at = self.orders.iter().rposition(|(_, order, _)| order.key == *key)?;
        Some(self.orders.remove(at).2)
    }

    /// All of them, for the end.
    pub fn drain(&mut self) -> Vec<Ticket> {
        self.orders.drain(..).rev().map(|(_, _, ticket)| ticket).collect()
    }
}

#[cfg(test)]
mod tests {
    use prost::bytes::Bytes;
    use sturz_protocol::keys::Verb;
    use tokio::sync::oneshot;

    use super::*;
    use crate::order::{Body, RequestKey};

    #[test]
    fn orders_come_by_time_then_by_arrival() {
        let mut schedule = Schedule::default();
        for (name, time) in [("b1", 2.0), ("a", 1.0), ("b2", 2.0), ("c", 3.0)] {
            let key = RequestKey { client_id: name.into(), request_id: String::new() };
            let request = Bytes::new();
            let order = Order { key, verb: Verb::Pause, request, fingerprint: 0, at_time_s: None, body: Body::Pause };
            let ticket = Ticket::new(&order, oneshot::channel().0, 0);
            schedule.add(time, order, ticket);
        }
        let mut due = |now| std::iter::from_fn(|| schedule.next_due(now)).map(|o| o.0.key.client_id).collect();
        let until_2: Vec<String> = due(2.0);
        assert_eq!(until_2, ["a", "b1", "b2"]);
        assert!(schedule.next_due(2.999).is_none());
        assert_eq!(schedule.drain().len(), 1);
        assert!(schedule.is_empty());
    }
}
