//! The viewer of a running twin: a thread of its own that reads a queue of its own.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::destination::{Destination, live_options};
use super::error::{ViewerError, ViewerLogger};
use super::fleet::{FleetFeed, FleetStream, ShownFleet};
use super::live_items::LiveItems;
use super::picture::{FleetSubject, Picture};
use super::plots::Ranges;
use super::stream::ViewerStream;
use crate::live::{FleetMeasurements, OutputQueue, OutputSource, Receiver, Waker, WhenFull};
use crate::parameters::{Parameters, ViewerMode};
use crate::twin::{NoticeLevel, Output};

/// Name of the queue of outputs to the viewer.
pub const VIEWER_QUEUE: &str = "viewer";

/// What files of a fleet are named after.
const FLEET: &str = "fleet";

/// Name of the viewer's thread.
pub const VIEWER_THREAD: &str = "viewer";

/// Period of the viewer's thread: two frames of a scene that moves without a pause. A piece of data costs about the same
/// whether it holds one frame or two.
const PERIOD: Duration = Duration::from_nanos(33_333_333);

/// Maximum wait for an output of the twin, which reports its status at least as often.
const MAX_WAIT: Duration = Duration::from_secs(1);

/// How long [`LiveViewer::stop`] waits for a viewer to read its data.
const STOP_TIMEOUT: Duration = Duration::from_millis(700);

/// How long it waits for the rest of a file, which only a busy machine or a full disk delays: `ros2 launch` sends SIGTERM 5 s after
/// SIGINT.
const FILE_STOP_TIMEOUT: Duration = Duration::from_secs(4);

/// Maximum number of items per period, which bounds the memory.
const MAX_ITEMS: usize = 2048;

/// The queue of the outputs of so many columns that a [`LiveViewer`] reads: several columns may respond at once, and at the start each
/// has a status.
#[must_use]
pub fn output_queue(columns: usize) -> OutputQueue {
    OutputQueue {
        name: VIEWER_QUEUE.to_owned(),
        states: columns.saturating_mul(256).min(MAX_ITEMS),
        others: 64 + 2 * columns,
        when_full: WhenFull::DropOldest,
    }
}

/// What a [`LiveViewer`] shows.
#[derive(Debug)]
pub enum Shown {
    /// The column with these parameters.
    Column(Arc<Parameters>),
    /// Several columns: all of them in a plan, and some in full.
    Fleet(ShownFleet),
}

/// A thread that shows a running twin. Dropping the value tells the thread to stop and does not wait for it.
pub struct LiveViewer {
    stop: Arc<AtomicBool>,
    waker: Waker,
    ended: mpsc::Receiver<()>,
    thread: Option<JoinHandle<()>>,
    /// How long a stop waits for the thread.
    patience: Duration,
    log: ViewerLogger,
}

impl LiveViewer {
    /// Starts the thread, as the parameters `viewer.*` of a `node` tell, unless `viewer.mode` is off. It shows the `measurements` of
    /// the sensors with the estimates. Later failures are logged; they do not affect the twin.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn start(
        node: &Parameters,
        shown: Shown,
        outputs: Receiver,
        measurements: Option<FleetMeasurements>,
        now: i64,
        log: ViewerLogger,
    ) -> Result<Option<Self>, ViewerError> {
        let viewer = node.settings().viewer.clone();
        if viewer.mode == ViewerMode::Off {
            return Ok(None);
        }
        if let Some(measurements) = &measurements {
            measurements.remember();
        }
        Self::spawn(viewer.mode, outputs, log, move |outputs, log, stop| {
            match shown {
                Shown::Column(parameters) => {
                    let ranges = Ranges::predicted(&parameters, &parameters.impact());
                    let name = &parameters.settings().column_id;
                    let subject = Arc::clone(&parameters);
                    let options = live_options(ranges);
                    let destination = Destination::<ViewerStream>::open(
                        &viewer, name, subject, options, now, log,
                    );
                    let mut items = LiveItems::new(0, Arc::clone(&parameters), measurements);
                    run(destination, outputs, log, stop, |outputs| {
                        let outputs = outputs.into_iter();
                        outputs.filter_map(|(_, it)| items.of_output(it)).collect()
                    });
                }
                Shown::Fleet(fleet) => {
                    let fleet = Arc::new(fleet);
                    let subject = FleetSubject::new(Arc::clone(&fleet));
                    // The axes are those of each column.
                    let options = live_options(Ranges::default());
                    let destination = Destination::<FleetStream>::open(
                        &viewer, FLEET, subject, options, now, log,
                    );
                    let mut feed = FleetFeed::new(fleet, measurements);
                    run(destination, outputs, log, stop, |outputs| {
                        feed.take(outputs)
                    });
                }
            }
        })
        .map(Some)
    }

    fn spawn(
        mode: ViewerMode,
        outputs: Receiver,
        log: ViewerLogger,
        content: impl FnOnce(Receiver, &ViewerLogger, &AtomicBool) + Send + 'static,
    ) -> Result<Self, ViewerError> {
        let stop = Arc::new(AtomicBool::new(false));
        let (end, ended) = sync_channel(1);
        let waker = outputs.waker();
        let thread = {
            let (stop, log) = (Arc::clone(&stop), Arc::clone(&log));
            thread::Builder::new()
                .name(VIEWER_THREAD.to_owned())
                .spawn(move || {
                    content(outputs, &log, &stop);
                    let _ = end.try_send(()); // there is no receiver after a drop
                })
                .map_err(ViewerError::Thread)?
        };
        Ok(Self {
            stop,
            waker,
            ended,
            thread: Some(thread),
            patience: match mode {
                ViewerMode::Save => FILE_STOP_TIMEOUT,
                _ => STOP_TIMEOUT,
            },
            log,
        })
    }

    /// Stops within a second whatever a viewer does, and within five if a file is written: what it has not shown by then is lost,
    /// which is logged.
    pub fn stop(mut self) {
        self.tell_to_stop();
        let ended = self.ended.recv_timeout(self.patience);
        if ended == Err(RecvTimeoutError::Timeout) {
            (self.log)(
                NoticeLevel::Warning,
                "the viewer does not read its data, or its file is not written in time; the frames that it has not shown are lost".to_owned(),
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

/// Shows the outputs, of which `items` makes what can be shown, until `stop` is set.
fn run<P: Picture + Send + 'static>(
    destination: Result<Option<Destination<P>>, ViewerError>,
    mut outputs: Receiver,
    log: &ViewerLogger,
    stop: &AtomicBool,
    mut items: impl FnMut(Vec<(u32, Output)>) -> Vec<P::Item>,
) {
    let mut destination = match destination {
        Ok(Some(destination)) => destination,
        Ok(None) => return,
        Err(error) => {
            log(NoticeLevel::Warning, without_viewer(&error));
            return;
        }
    };
    loop {
        let next = Instant::now() + PERIOD;
        let last = stop.load(Ordering::SeqCst);
        let mut taken = Vec::new();
        while taken.len() < MAX_ITEMS
            && let Some(output) = outputs.try_next_of()
        {
            taken.push(output);
        }
        let idle = taken.is_empty();
        if let Err(error) = destination.show(items(taken)) {
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
