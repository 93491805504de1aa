//! Whether the daemon lives, and who must hear when it does not.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use crate::queue::End;

/// Fed by a subscription to the daemon's liveliness token.
#[derive(Default)]
pub(crate) struct Watch {
    life: Mutex<Life>,
    changed: Condvar,
}

#[derive(Default)]
struct Life {
    seen: bool,
    /// For good: a daemon that comes back is another run, whose state nobody here knows.
    gone: bool,
    waiting: Vec<Weak<dyn End>>,
    /// Nobody uses this connection any more.
    unused: bool,
}

impl Watch {
    fn lock(&self) -> MutexGuard<'_, Life> {
        // No code that may panic runs under the lock.
        self.life.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The token is there.
    pub(crate) fn appeared(&self) {
        self.lock().seen = true;
        self.changed.notify_all();
    }

    /// The token is no longer there. Releases whoever waits.
    pub(crate) fn vanished(&self) {
        let waiting = {
            let mut life = self.lock();
            life.gone = true;
            std::mem::take(&mut life.waiting)
        };
        self.changed.notify_all();
        waiting.iter().filter_map(Weak::upgrade).for_each(|queue| queue.end());
    }

    /// Has `queue` ended when the daemon is gone: at once, if it is.
    pub(crate) fn end_with_daemon<Q: End + 'static>(&self, queue: &Arc<Q>) {
        let mut life = self.lock();
        if life.gone {
            drop(life);
            queue.end();
            return;
        }
        life.waiting.retain(|other| other.strong_count() > 0);
        let weak: Weak<Q> = Arc::downgrade(queue);
        life.waiting.push(weak);
    }

    /// Nobody will use this connection any more.
    pub(crate) fn leave(&self) {
        self.lock().unused = true;
        self.changed.notify_all();
    }

    /// Waits until the daemon is lost (`true`) or the connection is unused.
    pub(crate) fn wait_for_the_end(&self) -> bool {
        let life = self.changed.wait_while(self.lock(), |life| !life.gone && !life.unused);
        life.unwrap_or_else(PoisonError::into_inner).gone
    }

    /// Whether the daemon was lost.
    pub(crate) fn is_gone(&self) -> bool {
        self.lock().gone
    }

    /// Waits for the token; `false` when it does not come.
    pub(crate) fn wait_until_seen(&self, patience: Duration) -> bool {
        let life = self.changed.wait_timeout_while(self.lock(), patience, |life| !life.seen);
        life.unwrap_or_else(PoisonError::into_inner).0.seen
    }

    /// Waits for the loss of the daemon; `false` when it stays.
    pub(crate) fn wait_until_gone(&self, patience: Duration) -> bool {
        let life = self.changed.wait_timeout_while(self.lock(), patience, |life| !life.gone);
        life.unwrap_or_else(PoisonError::into_inner).0.gone
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::queue::{Popped, Queue};

    #[test]
    fn the_loss_of_the_daemon_ends_queues_of_before_and_after() {
        let watch = Watch::default();
        let (before, after) = (Arc::new(Queue::<u8>::new(1)), Arc::new(Queue::<u8>::new(1)));
        watch.end_with_daemon(&before);
        before.push(3);
        watch.appeared();
        watch.vanished();
        watch.end_with_daemon(&after);
        assert_eq!((before.pop(None), before.pop(None)), (Popped::Item(3), Popped::Ended));
        assert_eq!(after.pop(None), Popped::Ended);
        assert!(watch.wait_until_seen(Duration::ZERO) && watch.wait_until_gone(Duration::ZERO) && watch.is_gone());
    }

    #[test]
    fn queues_that_nobody_holds_are_forgotten() {
        let watch = Watch::default();
        for _ in 0..100 {
            watch.end_with_daemon(&Arc::new(Queue::<u8>::new(1)));
        }
        assert_eq!(watch.lock().waiting.len(), 1);
    }
}
