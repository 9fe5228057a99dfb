//! The viewer of a running twin: a thread of its own behind a queue of its own.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::ViewerError;
use super::destination::Destination;
use super::item::Item;
use crate::live::{OutputQueue, Receiver, WhenFull};
use crate::parameters::{Parameters, ViewerMode};
use crate::twin::Severity;

/// Name of the queue of outputs to the viewer.
pub const VIEWER_QUEUE: &str = "viewer";

/// Name of the viewer's thread.
pub const VIEWER_THREAD: &str = "viewer";

/// Between two looks at what there is to show: 60 Hz.
const PERIOD: Duration = Duration::from_nanos(16_666_667);

/// Longest wait for something to show.
const MAX_WAIT: Duration = Duration::from_millis(100);

/// How long the end of the thread is waited for.
const ENDS_WITHIN: Duration = Duration::from_millis(700);

/// Most outputs that are shown at once, so that a flood does not grow the memory.
const MAX_AT_ONCE: usize = 2048;

/// Where the viewer's thread says what goes well and what does not.
pub type Telling = Arc<dyn Fn(Severity, String) + Send + Sync>;

/// The queue of outputs that a [`LiveViewer`] reads.
#[must_use]
pub fn output_queue() -> OutputQueue {
    OutputQueue {
        name: VIEWER_QUEUE.to_owned(),
        states: 256,
        others: 64,
        when_full: WhenFull::DropOldest,
    }
}

/// A thread that shows a running twin. Dropped, it is given up at once.
pub struct LiveViewer {
    stop: Arc<AtomicBool>,
    ended: mpsc::Receiver<()>,
    thread: Option<JoinHandle<()>>,
    telling: Telling,
}

impl LiveViewer {
    /// Starts the thread, unless the parameters say off. What goes wrong later, or cannot be had, is told; the twin goes on.
    ///
    /// # Errors
    /// There is no thread.
    pub fn start(
        parameters: &Arc<Parameters>,
        outputs: Receiver,
        now: i64,
        telling: Telling,
    ) -> Result<Option<Self>, ViewerError> {
        if parameters.settings().viewer.mode == ViewerMode::Off {
            return Ok(None);
        }
        let stop = Arc::new(AtomicBool::new(false));
        let (end, ended) = sync_channel(1);
        let thread = {
            let (stop, telling) = (Arc::clone(&stop), Arc::clone(&telling));
            let parameters = Arc::clone(parameters);
            thread::Builder::new()
                .name(VIEWER_THREAD.to_owned())
                .spawn(move || {
                    run(&parameters, outputs, now, &telling, &stop);
                    let _ = end.try_send(()); // nobody waits after a drop
                })
                .map_err(ViewerError::Thread)?
        };
        Ok(Some(Self {
            stop,
            ended,
            thread: Some(thread),
            telling,
        }))
    }

    /// Stops within a second, whatever the viewer does: what it does not take by then is lost, and said.
    pub fn stop(mut self) {
        self.stop.store(true, Ordering::SeqCst);
        let ended = self.ended.recv_timeout(ENDS_WITHIN);
        if ended == Err(RecvTimeoutError::Timeout) {
            (self.telling)(
                Severity::Warning,
                "the viewer takes nothing; what it has not shown is lost".to_owned(),
            );
            return;
        }
        if self
            .thread
            .take()
            .is_some_and(|thread| thread.join().is_err())
        {
            (self.telling)(
                Severity::Error,
                format!("the thread {VIEWER_THREAD} ended by a panic; please report what it wrote"),
            );
        }
    }
}

impl Drop for LiveViewer {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
    }
}

/// Shows what comes until it is told to stop.
fn run(
    parameters: &Arc<Parameters>,
    mut outputs: Receiver,
    now: i64,
    telling: &Telling,
    stop: &AtomicBool,
) {
    let mut destination = match Destination::open(parameters, now, telling) {
        Ok(Some(destination)) => destination,
        Ok(None) => return,
        Err(error) => {
            telling(Severity::Warning, without(&error));
            return;
        }
    };
    loop {
        let next = Instant::now() + PERIOD;
        let last = stop.load(Ordering::SeqCst);
        let mut items = Vec::new();
        while items.len() < MAX_AT_ONCE
            && let Some(output) = outputs.try_next()
        {
            items.extend(Item::of_twin(output));
        }
        let idle = items.is_empty();
        if let Err(error) = destination.show(items) {
            telling(Severity::Error, without(&error));
            return;
        }
        if last {
            // Curves may wait for more.
            if let Err(error) = destination.show(Vec::new()) {
                telling(Severity::Error, without(&error));
            }
            return;
        }
        if idle {
            outputs.wait(MAX_WAIT);
        }
        thread::sleep(next.saturating_duration_since(Instant::now()));
    }
}

/// What is wrong, what to do, and what goes on.
fn without(error: &ViewerError) -> String {
    let help = miette::Diagnostic::help(error).map_or_else(String::new, |help| format!("; {help}"));
    format!("{error}{help}. The twin goes on without pictures")
}
