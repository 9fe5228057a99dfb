//! The viewer of a running twin: a thread of its own that reads a queue of its own.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::destination::Destination;
use super::error::{ViewerError, ViewerLogger};
use super::felt::FeltImpacts;
use super::item::ViewerItem;
use crate::live::{OutputQueue, OutputSource, Receiver, RecentBatches, Waker, WhenFull};
use crate::parameters::{Parameters, ViewerMode};
use crate::twin::{NoticeLevel, Output};

/// Name of the queue of outputs to the viewer.
pub const VIEWER_QUEUE: &str = "viewer";

/// Name of the viewer's thread.
pub const VIEWER_THREAD: &str = "viewer";

/// Period of the viewer's thread: two frames of a scene that moves without a pause. A piece of data costs about the same
/// whether it holds one frame or two.
const PERIOD: Duration = Duration::from_nanos(33_333_333);

/// Maximum wait for an output of the twin, which reports its status at least as often.
const MAX_WAIT: Duration = Duration::from_secs(1);

/// How long [`LiveViewer::stop`] waits for the thread.
const STOP_TIMEOUT: Duration = Duration::from_millis(700);

/// Maximum number of items per period, which bounds the memory.
const MAX_ITEMS: usize = 2048;

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

/// A thread that shows a running twin. Dropping the value tells the thread to stop and does not wait for it.
pub struct LiveViewer {
    stop: Arc<AtomicBool>,
    waker: Waker,
    ended: mpsc::Receiver<()>,
    thread: Option<JoinHandle<()>>,
    log: ViewerLogger,
}

impl LiveViewer {
    /// Starts the thread, unless `viewer.mode` is off. `measured` are the readings of the sensors, which it shows with the estimates.
    /// Later failures are logged; they do not affect the twin.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn start(
        parameters: &Arc<Parameters>,
        outputs: Receiver,
        measured: Option<Arc<RecentBatches>>,
        now: i64,
        log: ViewerLogger,
    ) -> Result<Option<Self>, ViewerError> {
        if parameters.settings().viewer.mode == ViewerMode::Off {
            return Ok(None);
        }
        let stop = Arc::new(AtomicBool::new(false));
        let (end, ended) = sync_channel(1);
        let waker = outputs.waker();
        let thread = {
            let (stop, log) = (Arc::clone(&stop), Arc::clone(&log));
            let parameters = Arc::clone(parameters);
            thread::Builder::new()
                .name(VIEWER_THREAD.to_owned())
                .spawn(move || {
                    let measured = measured.as_deref();
                    run(&parameters, outputs, measured, now, &log, &stop);
                    let _ = end.try_send(()); // there is no receiver after a drop
                })
                .map_err(ViewerError::Thread)?
        };
        Ok(Some(Self {
            stop,
            waker,
            ended,
            thread: Some(thread),
            log,
        }))
    }

    /// Stops within a second whatever the viewer does: what it has not read by then is lost, which is logged.
    pub fn stop(mut self) {
        self.tell_to_stop();
        let ended = self.ended.recv_timeout(STOP_TIMEOUT);
        if ended == Err(RecvTimeoutError::Timeout) {
            (self.log)(
                NoticeLevel::Warning,
                "the viewer does not read its data; what it has not shown is lost".to_owned(),
            );
            return;
        }
        if self
            .thread
            .take()
            .is_some_and(|thread| thread.join().is_err())
        {
            (self.log)(
                NoticeLevel::Error,
                format!("the thread {VIEWER_THREAD} panicked; please report its output"),
            );
        }
    }
}

impl LiveViewer {
    fn tell_to_stop(&self) {
        self.stop.store(true, Ordering::SeqCst);
        self.waker.wake();
    }
}

impl Drop for LiveViewer {
    fn drop(&mut self) {
        self.tell_to_stop();
    }
}

/// Shows the outputs of the twin until `stop` is set.
fn run(
    parameters: &Arc<Parameters>,
    mut outputs: Receiver,
    measured: Option<&RecentBatches>,
    now: i64,
    log: &ViewerLogger,
    stop: &AtomicBool,
) {
    let mut destination = match Destination::open(parameters, now, log) {
        Ok(Some(destination)) => destination,
        Ok(None) => return,
        Err(error) => {
            log(NoticeLevel::Warning, without_viewer(&error));
            return;
        }
    };
    let mut felt = FeltImpacts::new(Arc::clone(parameters));
    loop {
        let next = Instant::now() + PERIOD;
        let last = stop.load(Ordering::SeqCst);
        let mut items = Vec::new();
        while items.len() < MAX_ITEMS
            && let Some(output) = outputs.try_next()
        {
            if let Output::ParametersChanged(it) = &output {
                felt.change(Arc::clone(&it.parameters));
            }
            items.extend(match &output {
                Output::Estimate(estimate) => {
                    let readings =
                        |from, until| measured.map_or_else(Vec::new, |it| it.between(from, until));
                    let update = felt.of_twin(estimate, readings);
                    Some(ViewerItem::Felt(Box::new(update)))
                }
                _ => ViewerItem::of_twin(output),
            });
        }
        let idle = items.is_empty();
        if let Err(error) = destination.show(items) {
            log(NoticeLevel::Error, without_viewer(&error));
            return;
        }
        if last {
            // Sends the curves that are still being collected.
            if let Err(error) = destination.show(Vec::new()) {
                log(NoticeLevel::Error, without_viewer(&error));
            }
            return;
        }
        if idle {
            outputs.wait(MAX_WAIT);
        }
        thread::sleep(next.saturating_duration_since(Instant::now()));
    }
}

/// The error with its help, and what it means for the twin.
fn without_viewer(error: &ViewerError) -> String {
    let help = miette::Diagnostic::help(error).map_or_else(String::new, |help| format!("; {help}"));
    format!("{error}{help}. The twin continues without a viewer")
}
