//! The threads of the DDS library, and those of the node that use it. If one of them panics, messages no longer arrive or leave, while
//! everything else in the process looks healthy: the node has to stop, so that whoever supervises it starts a new one.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use signal_hook::consts::SIGTERM;

/// Name of the node's thread that takes messages.
pub(super) const RECEIVING_THREAD: &str = "column_twin/ros";

/// Name of the one that serves requests.
pub(super) const SERVING_THREAD: &str = "column_twin/srv";

/// Name of the one that publishes.
pub(super) const PUBLISHING_THREAD: &str = "column_twin/pub";

/// Name of the one that creates the topics of single columns.
pub(super) const TOPICS_THREAD: &str = "column_twin/topics";

/// Name of the one that serves the lifecycle of a managed node.
pub(super) const LIFECYCLE_THREAD: &str = "column_twin/life";

/// How the names of all of these threads begin, those of the library first.
const NAMES: [&str; 6] = [
    "RustDDS",
    RECEIVING_THREAD,
    SERVING_THREAD,
    PUBLISHING_THREAD,
    TOPICS_THREAD,
    LIFECYCLE_THREAD,
];

/// Maximum time that the node may take to stop without the library.
const TIME_TO_STOP: Duration = Duration::from_secs(10);

/// Exit code if it takes longer.
const EXIT_CODE: i32 = 1;

/// Whether one of these threads has panicked.
#[derive(Debug, Clone, Default)]
pub(super) struct DdsThreads {
    panicked: Arc<AtomicBool>,
}

impl DdsThreads {
    /// From now on, a panic in one of them is logged and stops the program as SIGTERM does.
    pub fn stop_on_panic() -> Self {
        let threads = Self::default();
        threads.call_on_panic(|| {
            // A handler of the program sets its flag. If that does not help, the process has to end all the same.
            let end = std::thread::Builder::new().name("column_twin/end".to_owned());
            let _ = end.spawn(|| {
                std::thread::sleep(TIME_TO_STOP);
                std::process::exit(EXIT_CODE);
            });
            let _ = signal_hook::low_level::raise(SIGTERM);
        });
        threads
    }

    fn call_on_panic(&self, action: impl Fn() + Send + Sync + 'static) {
        let panicked = Arc::clone(&self.panicked);
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            before(info);
            let thread = std::thread::current();
            let is_one = |name: &&str| NAMES.iter().any(|it| name.starts_with(it));
            let Some(name) = thread.name().filter(is_one) else {
                return;
            };
            if !panicked.swap(true, Ordering::Relaxed) {
                tracing::error!(
                    "the thread \"{name}\" panicked ({info}): the node stops, because it cannot send or receive any more; please \
                     report this"
                );
                action();
            }
        }));
    }

    pub fn has_panicked(&self) -> bool {
        self.panicked.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::sync_channel;

    use super::*;

    fn panicking(name: &str) {
        let thread = std::thread::Builder::new().name(name.to_owned());
        let thread = thread.spawn(|| panic!("on purpose")).expect("a thread");
        assert!(thread.join().is_err());
    }

    #[test]
    fn a_panic_in_a_thread_that_sends_or_receives_does_not_pass_unnoticed() {
        let threads = DdsThreads::default();
        let (sender, calls) = sync_channel(4);
        threads.call_on_panic(move || {
            let _ = sender.send(());
        });
        panicking("another thread");
        assert!(!threads.has_panicked());
        for name in ["RustDDS Participant 0 event loop", RECEIVING_THREAD] {
            panicking(name);
        }
        assert!(threads.has_panicked());
        assert_eq!(calls.try_iter().count(), 1, "it stops once");
    }
}
