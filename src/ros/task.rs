//! Named threads that run futures until they are stopped.

use std::thread::{self, JoinHandle};

use futures::future::{AbortHandle, Abortable};

use super::node::NodeError;
use crate::live::THREAD_STACK;

/// A thread that runs one future.
pub(super) struct Task {
    name: &'static str,
    abort: AbortHandle,
    thread: JoinHandle<()>,
}

impl Task {
    /// Starts a thread; the future is created in it and need not be `Send`.
    pub fn start<F: Future<Output = ()>>(
        name: &'static str,
        make: impl FnOnce() -> F + Send + 'static,
    ) -> Result<Self, NodeError> {
        let (abort, registration) = AbortHandle::new_pair();
        let run = move || {
            // Abortion is the normal end.
            let _ = futures::executor::block_on(Abortable::new(make(), registration));
        };
        Ok(Self {
            name,
            abort,
            thread: spawn(name, run)?,
        })
    }

    /// Ends the future at its next await point and joins the thread.
    pub fn stop(self) {
        self.abort.abort();
        if self.thread.join().is_err() {
            tracing::error!("the thread {} panicked", self.name);
        }
    }
}

/// Starts a thread of the node.
///
/// # Errors
/// The thread cannot be started.
pub(super) fn spawn(
    name: &'static str,
    run: impl FnOnce() + Send + 'static,
) -> Result<JoinHandle<()>, NodeError> {
    thread::Builder::new()
        .name(name.to_owned())
        .stack_size(THREAD_STACK)
        .spawn(run)
        .map_err(|source| NodeError::Thread { name, source })
}
