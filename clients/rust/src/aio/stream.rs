//! Frames as the daemon publishes them, awaited.

use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use crate::aio::apart::apart;
use crate::error::ClientError;
use crate::queue::Popped;
use crate::stream::StreamCounts;

/// Frames as they come; the twin of [`crate::Stream`], and a `Stream` of the `futures` crates. A future that is dropped has
/// taken no frame.
pub struct Stream<T> {
    blocking: crate::Stream<T>,
}

impl<T> Stream<T> {
    pub(super) fn new(blocking: crate::Stream<T>) -> Self {
        Self { blocking }
    }

    /// The oldest frame that was not read; `None` when the daemon is gone and all was read.
    pub async fn next(&mut self) -> Option<Result<T, ClientError>> {
        self.blocking.popped().await
    }

    /// As [`crate::Stream::next_within`].
    pub async fn next_within(&mut self, patience: Duration) -> Result<T, ClientError> {
        match tokio::time::timeout(patience, self.blocking.popped()).await {
            Ok(Some(frame)) => frame,
            Ok(None) => {
                let bus = self.blocking.bus();
                Err(apart(move || bus.gone()).await?)
            }
            Err(_) => self.blocking.read(Popped::TimedOut, patience),
        }
    }

    /// As [`crate::Stream::latest`].
    pub fn latest(&mut self) -> Option<Result<T, ClientError>> {
        self.blocking.latest()
    }

    /// As [`crate::Stream::keeping`].
    pub fn keeping(self, frames: usize) -> Self {
        Self { blocking: self.blocking.keeping(frames) }
    }

    /// As [`crate::Stream::counts`].
    pub fn counts(&self) -> StreamCounts {
        self.blocking.counts()
    }
}

impl<T> futures_core::Stream for Stream<T> {
    type Item = Result<T, ClientError>;

    fn poll_next(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        Poll::Ready(ready!(self.blocking.poll_popped(context)))
    }
}
