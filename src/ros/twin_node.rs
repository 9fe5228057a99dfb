//! The node of one column or many: all topics and services, in separate threads.
//!
//! | thread | responsibility |
//! |---|---|
//! | `column_twin/ros` | receives events, measurements and the clock, tracks peers |
//! | `column_twin/srv` | answers service requests, receives parameters |
//! | `column_twin/pub` | publishes the outputs of the columns, and diagnostics |
//! | `column_twin/log` | publishes `/rosout` |
//! | `column_twin/topics` | creates and removes the topics of single columns of a fleet |
//!
//! RustDDS adds two or three threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ros2_client::Publisher;

use crate::fleet::LINGER;
use crate::live::{OutputSource, RealTime, Waker, request_for_publisher};
use crate::messages::{cdr, rcl_interfaces};
use crate::outgoing::RecordingTap;

#[cfg(feature = "alarm")]
use super::alarms::NodeAlarms;
#[cfg(not(feature = "alarm"))]
use super::alarms::none_wanted;
use super::clock_watch::ClockWatch;
use super::counters::NodeCounters;
use super::dds_threads::{PUBLISHING_THREAD, RECEIVING_THREAD, SERVING_THREAD};
use super::environment::Environment;
use super::fleet::{ColumnTopics, FleetPublishing, RowImpacts, TopicCounts};
use super::inputs::{Services, Subscriptions};
use super::live_columns::LiveColumns;
use super::matches::Matches;
use super::measurements::SensedColumns;
use super::metrics::NodeMetrics;
use super::names::Names;
use super::node::{Node, NodeError};
use super::publishing::Publishing;
use super::qos;
use super::raw::Raw;
use super::receiving::Receiving;
use super::rosout::{LogEnd, RosoutQueue};
use super::senders::{Identities, Senders};
use super::sending::Sending;
use super::task::{Task, spawn};

/// A running node of one column or many, until [`stop`](Self::stop).
pub struct TwinNode {
    // In the order in which they are stopped.
    inputs: Vec<Task>,
    /// Those of a fleet.
    column_topics: Option<ColumnTopics>,
    columns: Arc<LiveColumns>,
    publisher: JoinHandle<()>,
    stop: Arc<AtomicBool>,
    waker: Waker,
    log: Option<(LogEnd, JoinHandle<()>)>,
    node: Node,
}

impl TwinNode {
    /// Starts the node of running columns; `recording` receives a copy of all messages.
    ///
    /// # Errors
    /// A participant, an endpoint or a thread cannot be created.
    pub fn start(
        environment: &Environment,
        names: Names,
        columns: Arc<LiveColumns>,
        outputs: impl OutputSource,
        log: Option<RosoutQueue>,
        recording: Option<Arc<dyn RecordingTap>>,
    ) -> Result<Self, NodeError> {
        Self::start_with(environment, names, columns, outputs, log, recording, LINGER)
    }

    /// As [`start`](Self::start); the topics of a single column of a fleet stay for `linger` when their last reader has gone.
    ///
    /// # Errors
    /// See [`start`](Self::start).
    pub fn start_with(
        environment: &Environment,
        names: Names,
        columns: Arc<LiveColumns>,
        outputs: impl OutputSource,
        log: Option<RosoutQueue>,
        recording: Option<Arc<dyn RecordingTap>>,
        linger: Duration,
    ) -> Result<Self, NodeError> {
        let mut node = Node::new(environment, names)?;
        let settings = columns.node_parameters().settings();
        let metrics = NodeMetrics::start(&settings.metrics.address)?;
        #[cfg(feature = "alarm")]
        let alarms = NodeAlarms::start(&settings.alarm, &node.names().fully_qualified())?;
        #[cfg(not(feature = "alarm"))]
        none_wanted(&settings.alarm)?;
        let identities = Identities::new(node.security_peers(), node.protection().has_enclave());
        let senders = Senders::new(&settings.senders, identities);
        senders.warn_of_enclaves();
        let senders = Arc::new(senders);
        let counters = Arc::new(NodeCounters {
            lost_peers: node.matches().lost_peers(),
            given_up: node.matches().given_up(),
            senders: senders.is_limited().then(|| Arc::clone(&senders)),
            clock: settings
                .use_sim_time
                .then(|| ClockWatch::new(Instant::now())),
            ..NodeCounters::default()
        });
        let stop = Arc::new(AtomicBool::new(false));
        let log = log
            .map(|queue| publish_log(&mut node, queue, &counters, recording.clone()))
            .transpose()?;
        let sensed = SensedColumns::new(&columns, recording.as_ref());
        let receiving = Receiving {
            columns: Arc::clone(&columns),
            senders,
            recording: recording.clone(),
            counters: Arc::clone(&counters),
        };
        let (mut column_topics, mut rows, mut fleet) = (None, None, None);
        if columns.face().is_fleet() {
            let counts = Arc::<TopicCounts>::default();
            let own = Arc::clone(&counts);
            let (topics, changes) =
                ColumnTopics::start(&node, &columns, linger, outputs.waker(), own)?;
            let row_impacts = Arc::new(RowImpacts::new(receiving.clone()));
            rows = Some(Arc::clone(&row_impacts));
            let changes = (changes, counts);
            let (node, sensed) = (&mut node, sensed.clone());
            fleet = Some(FleetPublishing::new(
                node,
                &columns,
                row_impacts,
                sensed,
                changes,
            )?);
            column_topics = Some(topics);
        }
        let sending = Sending {
            columns: Arc::clone(&columns),
            counters,
            recording,
            #[cfg(feature = "alarm")]
            alarms,
            metrics,
            is_over: false,
        };
        let publishing = Publishing::new(&mut node, sending, sensed.clone(), fleet)?;
        let subscriptions = Subscriptions::new(&mut node, sensed, receiving.clone())?;
        let services = Services::new(&mut node, rows, receiving)?;
        let stop_publishing = Arc::clone(&stop);
        let waker = outputs.waker();
        let real_time = RealTime::of(columns.node_parameters());
        let publisher = spawn(PUBLISHING_THREAD, move || {
            request_for_publisher(&real_time);
            publishing.run(outputs, &stop_publishing);
        })?;
        let mut watch = column_topics.as_ref().map(ColumnTopics::watch);
        let events = node.twin_events(Arc::clone(&columns), move |discovered| {
            if let Some(watch) = &mut watch {
                watch(discovered);
            }
        })?;
        let inputs = vec![
            Task::start(RECEIVING_THREAD, move || async move {
                futures::join!(events, subscriptions.run());
            })?,
            Task::start(SERVING_THREAD, move || services.run())?,
        ];
        Ok(Self {
            inputs,
            column_topics,
            columns,
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

    /// Stops receiving, stops the columns, publishes queued outputs, and leaves the network.
    pub fn stop(self) {
        for task in self.inputs {
            task.stop();
        }
        if let Some(topics) = self.column_topics {
            topics.stop();
        }
        self.columns.stop();
        stop_publishing_threads(&self.stop, &self.waker, self.publisher, self.log);
        // All threads have ended, and with them all endpoints.
        drop(self.node);
    }
}

/// Ends the threads that publish, after what is queued.
fn stop_publishing_threads(
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

fn publish_log(
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
