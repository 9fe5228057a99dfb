//! The node of a twin: all topics and services, in separate threads.
//!
//! | thread | responsibility |
//! |---|---|
//! | `column_twin/ros` | receives events, measurements and the clock, tracks peers |
//! | `column_twin/srv` | answers service requests, receives parameters |
//! | `column_twin/pub` | publishes the outputs of the twin, and diagnostics |
//! | `column_twin/log` | publishes `/rosout` |
//!
//! RustDDS adds two or three threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use ros2_client::Publisher;

use crate::live::{OutputSource, RealTime, THREAD_STACK, Waker, request_for_publisher};
use crate::messages::{cdr, rcl_interfaces};
use crate::outgoing::RecordingTap;

use super::clock_watch::ClockWatch;
use super::dds_threads::{PUBLISHING_THREAD, RECEIVING_THREAD, SERVING_THREAD};
use super::diagnostics::NodeCounters;
use super::environment::Environment;
use super::inputs::{Services, Subscriptions};
use super::live_columns::LiveColumns;
use super::matches::Matches;
use super::measurements::SensedColumns;
use super::names::Names;
use super::node::{Node, NodeError};
use super::publishing::Publishing;
use super::qos;
use super::raw::Raw;
use super::rosout::{LogEnd, RosoutQueue};
use super::senders::{Identities, Senders};
use super::task::Task;

/// A running node, until [`stop`](Self::stop).
pub struct TwinNode {
    // In the order in which they are stopped.
    inputs: Vec<Task>,
    twin: Arc<LiveColumns>,
    publisher: JoinHandle<()>,
    stop: Arc<AtomicBool>,
    waker: Waker,
    log: Option<(LogEnd, JoinHandle<()>)>,
    node: Node,
}

impl TwinNode {
    /// Starts the node of a running twin; `recording` receives a copy of all messages.
    ///
    /// # Errors
    /// A participant, an endpoint or a thread cannot be created.
    pub fn start(
        environment: &Environment,
        names: Names,
        twin: Arc<LiveColumns>,
        outputs: impl OutputSource,
        log: Option<RosoutQueue>,
        recording: Option<Arc<dyn RecordingTap>>,
    ) -> Result<Self, NodeError> {
        let mut node = Node::new(environment, names)?;
        let is_simulated = twin.parameters(0).settings().use_sim_time;
        let parameters = twin.parameters(0);
        let identities = Identities::new(node.security_peers(), node.protection().has_enclave());
        let senders = Senders::new(&parameters.settings().senders, identities);
        senders.warn_of_enclaves();
        let senders = Arc::new(senders);
        let sensed = SensedColumns::new(&twin, recording.as_ref());
        let counters = Arc::new(NodeCounters {
            lost_peers: node.matches().lost_peers(),
            given_up: node.matches().given_up(),
            senders: senders.is_limited().then(|| Arc::clone(&senders)),
            clock: is_simulated.then(|| ClockWatch::new(Instant::now())),
            ..NodeCounters::default()
        });
        let stop = Arc::new(AtomicBool::new(false));
        let log = log
            .map(|queue| publish_log(&mut node, queue, &counters, recording.clone()))
            .transpose()?;
        let publishing = Publishing::new(
            &mut node,
            Arc::clone(&twin),
            Arc::clone(&counters),
            sensed.clone(),
            recording.clone(),
        )?;
        let subscriptions = Subscriptions::new(
            &mut node,
            &twin.parameters(0),
            Arc::clone(&senders),
            sensed,
            recording.clone(),
        )?;
        let services = Services::new(&mut node, &twin.parameters(0), senders, recording)?;
        let stop_publishing = Arc::clone(&stop);
        let waker = outputs.waker();
        let real_time = RealTime::of(&twin.parameters(0));
        let publisher = spawn(PUBLISHING_THREAD, move || {
            request_for_publisher(&real_time);
            publishing.run(outputs, &stop_publishing);
        })?;
        let events = node.twin_events(&twin.parameters(0).settings().column_id)?;
        let matches = Arc::clone(&counters);
        let (event_twin, service_twin) = (Arc::clone(&twin), Arc::clone(&twin));
        let inputs = vec![
            Task::start(RECEIVING_THREAD, move || async move {
                futures::join!(events, subscriptions.run(event_twin, matches));
            })?,
            Task::start(SERVING_THREAD, move || services.run(service_twin, counters))?,
        ];
        Ok(Self {
            inputs,
            twin,
            publisher,
            stop,
            waker,
            log,
            node,
        })
    }

    /// The node's names.
    #[must_use]
    pub fn names(&self) -> &Names {
        self.node.names()
    }

    /// The known peers.
    #[must_use]
    pub fn matches(&self) -> Arc<Matches> {
        self.node.matches()
    }

    /// Stops receiving, stops the twin, publishes queued outputs, and leaves the network.
    pub fn stop(self) {
        for task in self.inputs {
            task.stop();
        }
        self.twin.stop();
        stop_publishing_threads(&self.stop, &self.waker, self.publisher, self.log);
        // All threads have ended, and with them all endpoints.
        drop(self.node);
    }
}

/// Ends the threads that publish, after what is queued.
pub(super) fn stop_publishing_threads(
    stop: &AtomicBool,
    waker: &Waker,
    publisher: JoinHandle<()>,
    log: Option<(LogEnd, JoinHandle<()>)>,
) {
    stop.store(true, Ordering::Relaxed);
    waker.wake();
    let mut has_panicked = publisher.join().is_err();
    // Last, so that the log messages of the other threads are published.
    if let Some((end, log)) = log {
        end.send();
        has_panicked |= log.join().is_err();
    }
    if has_panicked {
        tracing::error!("a publishing thread panicked");
    }
}

pub(super) fn publish_log(
    node: &mut Node,
    queue: RosoutQueue,
    counters: &Arc<NodeCounters>,
    recording: Option<Arc<dyn RecordingTap>>,
) -> Result<(LogEnd, JoinHandle<()>), NodeError> {
    let publisher: Publisher<Raw> = node.publisher(&qos::ROSOUT)?;
    let logger = node.names().logger();
    let counters = Arc::clone(counters);
    let end = queue.end.clone();
    let thread = spawn("column_twin/log", move || {
        let note_dropped = || {
            let dropped = queue.dropped.load(Ordering::Relaxed);
            counters.unlogged.store(dropped, Ordering::Relaxed);
        };
        while let Ok(Some(record)) = queue.records.recv() {
            note_dropped();
            // A failure is not logged, because the log message would have to be published too.
            let bytes = cdr::encode_as::<rcl_interfaces::Log, _>(&record.into_log(&logger));
            let Some(raw) = bytes.ok().and_then(|bytes| Raw::new(bytes.into()).ok()) else {
                NodeCounters::count(&counters.unpublished);
                continue;
            };
            if let Some(recording) = &recording {
                recording.sent(&qos::ROSOUT, raw.bytes());
            }
            counters.lost_peers.count_published();
            if publisher.publish(raw).is_err() {
                NodeCounters::count(&counters.unpublished);
            }
        }
        note_dropped();
    })?;
    Ok((end, thread))
}

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
