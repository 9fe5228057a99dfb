//! Named threads that run futures until they are told to stop.

use std::thread::{self, JoinHandle};

use futures::future::{AbortHandle, Abortable};

use super::node::NodeError;

/// A thread that runs one future.
pub(super) struct Task {
    name: &'static str,
    abort: AbortHandle,
    thread: JoinHandle<()>,
}

impl Task {
    /// Starts a thread of that name; the future is made in the thread, so that it need not be `Send`.
    pub fn start<F: Future<Output = ()>>(
        name: &'static str,
        make: impl FnOnce() -> F + Send + 'static,
    ) -> Result<Self, NodeError> {
        let (abort, registration) = AbortHandle::new_pair();
        let run = move || {
            // Aborted is how it is meant to end.
            let _ = futures::executor::block_on(Abortable::new(make(), registration));
        };
        let thread = thread::Builder::new()
            .name(name.to_owned())
            .spawn(run)
            .map_err(|source| NodeError::Thread { name, source })?;
        Ok(Self {
            name,
            abort,
            thread,
        })
    }

    /// Ends the future where it waits and joins the thread.
    pub fn stop(self) {
        self.abort.abort();
        if self.thread.join().is_err() {
            tracing::error!("the thread {} has panicked", self.name);
        }
    }
}
