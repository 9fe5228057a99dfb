//! A bell between threads: ringing it never waits, and a ring is kept until it is heard.

use std::time::Duration;

/// The bell.
#[derive(Debug, Clone)]
pub(crate) struct Bell {
    ring: flume::Sender<()>,
    hear: flume::Receiver<()>,
}

impl Bell {
    pub fn new() -> Self {
        let (ring, hear) = flume::bounded(1);
        Self { ring, hear }
    }

    pub fn ring(&self) {
        // Full: it rings already.
        let _ = self.ring.try_send(());
    }

    /// Waits for a ring, at most so long.
    pub fn wait(&self, at_most: Duration) -> bool {
        self.hear.recv_timeout(at_most).is_ok()
    }

    /// Waits for a ring in a task.
    pub async fn heard(&self) {
        let _ = self.hear.recv_async().await;
    }
}
