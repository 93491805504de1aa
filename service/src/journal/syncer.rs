//! Forces the log to the disk beside the thread that writes it. A second of a lockstep with large loads is tens of megabytes,
//! for which a disk takes longer than the next reply may wait.

use std::fs::File;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::mpsc::{Sender, channel};
use std::thread::{self, JoinHandle};

/// A thread that waits for the disk.
pub struct Syncer {
    files: Option<Sender<File>>,
    is_busy: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Syncer {
    /// `failed` is called from the thread when the disk refuses.
    pub fn start(failed: impl Fn(io::Error) + Send + 'static) -> io::Result<Self> {
        let (files, told) = channel::<File>();
        let is_busy = Arc::<AtomicBool>::default();
        let busy = Arc::clone(&is_busy);
        let body = move || {
            while let Ok(file) = told.recv() {
                if let Err(failure) = file.sync_data() {
                    failed(failure);
                }
                busy.store(false, SeqCst);
            }
        };
        let thread = thread::Builder::new().name("journal-sync".into()).spawn(body)?;
        Ok(Self { files: Some(files), is_busy, thread: Some(thread) })
    }

    /// Begins with what is in the file now, and waits for nothing; `false` while the disk is still at what was before.
    pub fn begin(&self, file: File) -> bool {
        let Some(files) = self.files.as_ref().filter(|_| !self.is_busy.swap(true, SeqCst)) else { return false };
        let is_begun = files.send(file).is_ok();
        if !is_begun {
            self.is_busy.store(false, SeqCst);
        }
        is_begun
    }
}

impl Drop for Syncer {
    fn drop(&mut self) {
        drop(self.files.take());
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the thread that syncs the journal has failed");
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::sync_channel;
    use std::time::Duration;

    use super::*;

    #[test]
    fn what_the_disk_refuses_is_told() {
        let (sender, heard) = sync_channel(1);
        let syncer = Syncer::start(move |failure| drop(sender.send(failure))).unwrap();
        assert!(syncer.begin(tempfile::tempfile().unwrap()));
        // The end of the first is seen by that of the second, which has no disk behind it.
        let refused = || File::options().write(true).open("/dev/null").unwrap();
        while !syncer.begin(refused()) {
            thread::yield_now();
        }
        assert!(heard.recv_timeout(Duration::from_secs(60)).is_ok(), "a device without a disk cannot be synced");
    }
}
