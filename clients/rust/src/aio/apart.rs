//! What blocks, on a thread of its own: one without a runtime, since zenoh refuses runtimes of one thread.

use std::sync::Arc;
use std::thread;

use crate::error::ClientError;
use crate::queue::{End as _, Popped, Queue};

/// Ends the queue when the thread does, in whatever way.
struct Inlet<R: Send>(Arc<Queue<R>>);

impl<R: Send> Drop for Inlet<R> {
    fn drop(&mut self) {
        self.0.end();
    }
}

/// Does it on another thread. Dropped, the work goes on, and what comes of it is dropped too.
pub(super) async fn apart<R: Send + 'static>(work: impl FnOnce() -> R + Send + 'static) -> Result<R, ClientError> {
    let done = Arc::new(Queue::new(1));
    let inlet = Inlet(Arc::clone(&done));
    let body = move || inlet.0.push(work());
    let started = thread::Builder::new().name("sturz-aio".into()).spawn(body);
    started.map_err(|error| ClientError::bus("thread", error))?;
    match done.popped().await {
        Popped::Item(result) => Ok(result),
        Popped::Ended | Popped::TimedOut => Err(ClientError::bus("thread", "it has failed")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_thread_that_fails_leaves_nobody_waiting() {
        assert_eq!(apart(|| 3).await.unwrap(), 3);
        assert!(apart(|| -> u8 { panic!("on purpose") }).await.is_err());
    }
}
