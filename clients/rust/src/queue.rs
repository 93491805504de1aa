//! A bounded queue between the bus, which must never wait, and a thread or task that may.

use std::collections::VecDeque;
use std::future::poll_fn;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};
use std::time::Instant;

/// Keeps the newest items: a slow reader loses the oldest, and slows nobody down.
pub(crate) struct Queue<T> {
    content: Mutex<Content<T>>,
    changed: Condvar,
}

struct Content<T> {
    items: VecDeque<T>,
    keep: usize,
    overwritten: u64,
    ended: bool,
    /// Of tasks that wait.
    wakers: Vec<Waker>,
}

/// What a reader gets.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Popped<T> {
    /// The oldest item.
    Item(T),
    /// All was read, and nothing will follow.
    Ended,
    /// Nothing came in time.
    TimedOut,
}

/// Something that waiting threads are released from.
pub(crate) trait End: Send + Sync {
    /// Nothing will follow; what is there can still be read.
    fn end(&self);
}

impl<T> Queue<T> {
    /// Holds at most `keep` items, at least one.
    pub(crate) fn new(keep: usize) -> Self {
        let content =
            Content { items: VecDeque::new(), keep: keep.max(1), overwritten: 0, ended: false, wakers: Vec::new() };
        Self { content: Mutex::new(content), changed: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, Content<T>> {
        // No code that may panic runs under the lock.
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes how many items it holds, at least one.
    pub(crate) fn set_keep(&self, keep: usize) {
        let mut content = self.lock();
        content.keep = keep.max(1);
        content.forget_oldest();
    }

    /// Adds an item; forgets the oldest one when there is no room.
    pub(crate) fn push(&self, item: T) {
        let mut content = self.lock();
        if content.ended {
            return;
        }
        content.items.push_back(item);
        content.forget_oldest();
        self.changed(content);
    }

    /// Wakes whoever waits, threads and tasks.
    fn changed(&self, mut content: MutexGuard<'_, Content<T>>) {
        let wakers = std::mem::take(&mut content.wakers);
        drop(content);
        self.changed.notify_all();
        wakers.into_iter().for_each(Waker::wake);
    }

    /// The oldest item, for a task; nothing when all was read and nothing will follow.
    pub(crate) fn poll_pop(&self, context: &mut Context<'_>) -> Poll<Option<T>> {
        let mut content = self.lock();
        if let Some(item) = content.items.pop_front() {
            return Poll::Ready(Some(item));
        }
        if content.ended {
            return Poll::Ready(None);
        }
        if !content.wakers.iter().any(|waker| waker.will_wake(context.waker())) {
            content.wakers.push(context.waker().clone());
        }
        Poll::Pending
    }

    /// Waits for the oldest item without a thread. Dropped, it has taken none.
    pub(crate) async fn popped(&self) -> Popped<T> {
        match poll_fn(|context| self.poll_pop(context)).await {
            Some(item) => Popped::Item(item),
            None => Popped::Ended,
        }
    }

    /// Takes the oldest item; waits for one until `deadline`, or for ever.
    pub(crate) fn pop(&self, deadline: Option<Instant>) -> Popped<T> {
        let mut content = self.lock();
        loop {
            if let Some(item) = content.items.pop_front() {
                return Popped::Item(item);
            }
            if content.ended {
                return Popped::Ended;
            }
            content = match deadline {
                None => self.changed.wait(content).unwrap_or_else(PoisonError::into_inner),
                Some(deadline) => {
                    let rest = deadline.saturating_duration_since(Instant::now());
                    if rest.is_zero() {
                        return Popped::TimedOut;
                    }
                    self.changed.wait_timeout(content, rest).unwrap_or_else(PoisonError::into_inner).0
                }
            };
        }
    }

    /// Takes the newest item, and forgets the older ones; never waits.
    pub(crate) fn pop_newest(&self) -> Option<T> {
        let mut content = self.lock();
        let newest = content.items.pop_back();
        content.overwritten += content.items.len() as u64;
        content.items.clear();
        newest
    }

    /// Items that were forgotten before they were read.
    pub(crate) fn overwritten(&self) -> u64 {
        self.lock().overwritten
    }
}

impl<T> Content<T> {
    fn forget_oldest(&mut self) {
        while self.items.len() > self.keep {
            self.items.pop_front();
            self.overwritten += 1;
        }
    }
}

impl<T: Send> End for Queue<T> {
    fn end(&self) {
        let mut content = self.lock();
        content.ended = true;
        self.changed(content);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::thread;
    use std::time::Duration;

    use super::*;

    fn now() -> Option<Instant> {
        Some(Instant::now())
    }

    #[test]
    fn the_newest_are_kept_in_order() {
        let queue = Queue::new(3);
        (0..10).for_each(|item| queue.push(item));
        let read: Vec<_> = (0..3).map(|_| queue.pop(now())).collect();
        assert_eq!(read, [Popped::Item(7), Popped::Item(8), Popped::Item(9)]);
        assert_eq!((queue.pop(now()), queue.overwritten()), (Popped::TimedOut, 7));
    }

    #[test]
    fn a_smaller_queue_forgets_the_oldest() {
        let queue = Queue::new(4);
        (0..4).for_each(|item| queue.push(item));
        queue.set_keep(0);
        assert_eq!((queue.pop(now()), queue.overwritten()), (Popped::Item(3), 3));
    }

    #[test]
    fn the_newest_one_alone_can_be_taken() {
        let queue = Queue::new(4);
        (0..3).for_each(|item| queue.push(item));
        assert_eq!((queue.pop_newest(), queue.pop_newest(), queue.overwritten()), (Some(2), None, 2));
    }

    #[test]
    fn what_came_before_the_end_is_read_and_nothing_after() {
        let queue = Queue::new(4);
        queue.push(1);
        queue.end();
        queue.push(2);
        assert_eq!((queue.pop(None), queue.pop(None)), (Popped::Item(1), Popped::Ended));
    }

    #[test]
    fn a_waiting_reader_is_woken_by_items_and_by_the_end() {
        let queue = Arc::new(Queue::new(1));
        let reader = thread::spawn({
            let queue = Arc::clone(&queue);
            move || (queue.pop(None), queue.pop(None))
        });
        thread::sleep(Duration::from_millis(20));
        queue.push(5);
        thread::sleep(Duration::from_millis(20));
        queue.end();
        assert_eq!(reader.join().unwrap(), (Popped::Item(5), Popped::Ended));
    }
}
