//! The node of one column or many: all topics and services, in separate threads.
//!
//! | thread | responsibility |
//! |---|---|
//! | `column_twin/ros` | receives events, measurements and the clock, tracks peers |
//! | `column_twin/srv` | answers service requests, receives parameters |
//! | `column_twin/pub` | publishes the outputs of the columns, and diagnostics |
//! | `column_twin/log` | publishes `/rosout` |
//! | `column_twin/topics` | creates and removes the topics of single columns of a fleet |
//! | `column_twin/life` | answers about the lifecycle and the parameters of a managed node, tracks peers |
//!
//! RustDDS adds two or three threads.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use futures::future::Either;

use crate::fleet::LINGER;
use crate::live::{OutputSource, RealTime, Waker, request_for_publisher, request_for_sender};
use crate::messages::{cdr, rcl_interfaces};
use crate::outgoing::RecordingTap;

#[cfg(feature = "alarm")]
use super::alarms::NodeAlarms;
#[cfg(not(feature = "alarm"))]
use super::alarms::none_wanted;
use super::counters::NodeCounters;
use super::dds_threads::{LIFECYCLE_THREAD, PUBLISHING_THREAD, RECEIVING_THREAD, SERVING_THREAD};
use super::fleet::{ColumnTopics, FleetPublishing, RowImpacts, TopicCounts};
#[cfg(feature = "foxglove")]
use super::foxglove::NodeFoxglove;
#[cfg(not(feature = "foxglove"))]
use super::foxglove::not_wanted;
use super::inputs::{NodeServices, Services, Subscriptions};
use super::lifecycle::Lifecycle;
use super::lifecycle_services::{Actions, LifecycleServers};
use super::live_columns::LiveColumns;
use super::measurements::SensedColumns;
use super::metrics::NodeMetrics;
use super::node::{Node, NodeError};
use super::publishing::Publishing;
use super::qos;
use super::qos_overrides::QosOverrides;
use super::receiving::Receiving;
use super::senders::{Identities, Senders};
use super::sending::Sending;
use super::task::{Task, spawn};
use super::transport::Publisher;
use ros_node::clock_watch::ClockWatch;
use ros_node::environment::Environment;
use ros_node::matches::Matches;
use ros_node::names::Names;
use ros_node::raw::Raw;
use ros_node::rosout::{LogEnd, RosoutQueue};

/// How a node starts.
pub struct StartOptions {
    /// How long the topics of a single column of a fleet stay when their last reader has gone.
    pub linger: Duration,
    /// Makes a managed node, which starts unconfigured. The function is called when the node is asked to shut down.
    pub managed: Option<Box<dyn Fn() + Send>>,
}

impl Default for StartOptions {
    fn default() -> Self {
        Self {
            linger: LINGER,
            managed: None,
        }
    }
}

/// The tasks of the inputs; those of a managed node start when it is configured.
type InputTasks = Arc<Mutex<Vec<Task>>>;

/// A running node of one column or many, until [`stop`](Self::stop).
pub struct TwinNode {
    names: Names,
    matches: Arc<Matches>,
    // In the order in which they are stopped.
    inputs: InputTasks,
    /// Those of a fleet.
    column_topics: Option<ColumnTopics>,
    columns: Arc<LiveColumns>,
    publisher: JoinHandle<()>,
    stop: Arc<AtomicBool>,
    waker: Waker,
    /// Of a managed node.
    lifecycle: Option<Task>,
    log: Option<(LogEnd, JoinHandle<()>)>,
    node: Arc<Mutex<Node>>,
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
        let options = StartOptions::default();
        Self::start_with(
            environment,
            names,
            columns,
            outputs,
            log,
            recording,
            options,
        )
    }

    /// As [`start`](Self::start), with options.
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
        options: StartOptions,
    ) -> Result<Self, NodeError> {
        let StartOptions { linger, managed } = options;
        let managed = managed.map(|it| (it, Arc::new(Lifecycle::unconfigured())));
        let lifecycle = managed.as_ref().map(|it| Arc::clone(&it.1));
        let real_time = RealTime::of(columns.node_parameters());
        let sender = real_time.clone();
        let mut node = Node::with_sender(environment, names, move || request_for_sender(&sender))?;
        let settings = columns.node_parameters().settings();
        node.override_qos(QosOverrides::new(&settings.qos_overrides));
        let metrics = NodeMetrics::start(&settings.metrics.address)?;
        #[cfg(feature = "alarm")]
        let alarms = NodeAlarms::start(&settings.alarm, &node.names().fully_qualified())?;
        #[cfg(not(feature = "alarm"))]
        none_wanted(&settings.alarm)?;
        #[cfg(feature = "foxglove")]
        let foxglove = NodeFoxglove::start(&columns, node.names(), lifecycle.clone())?;
        #[cfg(not(feature = "foxglove"))]
        not_wanted(&settings.foxglove)?;
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
            lifecycle,
            ..NodeCounters::default()
        });
        let stop = Arc::new(AtomicBool::new(false));
        let log = log
            .map(|queue| {
                let copies = LogCopies {
                    recording: recording.clone(),
                    #[cfg(feature = "foxglove")]
                    foxglove: foxglove.clone(),
                };
                publish_log(&mut node, queue, &counters, copies)
            })
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
            #[cfg(feature = "foxglove")]
            foxglove,
            is_silent: false,
            is_over: false,
        };
        let publishing = Publishing::new(&mut node, sending, sensed.clone(), fleet)?;
        let inputs = Inputs {
            sensed,
            rows,
            receiving,
        };
        // Before the thread that publishes, which would run on if one of them failed.
        let start = match managed {
            None => Either::Left(inputs.offer(&mut node)?),
            Some(managed) => Either::Right(managed),
        };
        let own = NodeServices::new(&mut node, inputs.receiving.clone())?;
        let stop_publishing = Arc::clone(&stop);
        let waker = outputs.waker();
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
        let (names, matches) = (node.names().clone(), node.matches());
        let node = Arc::new(Mutex::new(node));
        let tasks = InputTasks::default();
        let lifecycle = match start {
            Either::Left((subscriptions, services)) => {
                let receive = move || async move {
                    futures::join!(events, subscriptions.run());
                };
                let serve = move || async move {
                    futures::join!(services.run(), own.run());
                };
                start_both(&tasks, receive, serve)?;
                None
            }
            Either::Right(managed) => {
                Some(inputs.start_managed(&node, &tasks, own, events, managed)?)
            }
        };
        Ok(Self {
            names,
            matches,
            inputs: tasks,
            column_topics,
            columns,
            publisher,
            stop,
            waker,
            lifecycle,
            log,
            node,
        })
    }

    /// The node's names.
    #[must_use]
    pub fn names(&self) -> &Names {
        &self.names
    }

    /// The known peers.
    #[must_use]
    pub fn matches(&self) -> Arc<Matches> {
        Arc::clone(&self.matches)
    }

    /// Stops receiving, stops the columns, publishes queued outputs, and leaves the network.
    pub fn stop(self) {
        stop_all(&self.inputs);
        if let Some(topics) = self.column_topics {
            topics.stop();
        }
        self.columns.stop();
        stop_publishing(&self.stop, &self.waker, self.publisher);
        // Late, so that the answer to a shutdown is sent.
        if let Some(task) = self.lifecycle {
            task.stop();
        }
        // It may have been configured meanwhile.
        stop_all(&self.inputs);
        stop_log(self.log);
        // All threads have ended, and with them all endpoints.
        drop(self.node);
    }
}

/// What takes the inputs of the columns.
struct Inputs {
    sensed: Option<Arc<SensedColumns>>,
    rows: Option<Arc<RowImpacts>>,
    receiving: Receiving,
}

impl Inputs {
    /// Creates the endpoints.
    fn offer(&self, node: &mut Node) -> Result<(Subscriptions, Services), NodeError> {
        let receiving = || self.receiving.clone();
        let subscriptions = Subscriptions::new(node, self.sensed.clone(), receiving())?;
        let services = Services::new(node, self.rows.clone(), receiving())?;
        Ok((subscriptions, services))
    }

    /// Starts the task of a managed node, which starts the others when the node is configured.
    fn start_managed(
        self,
        node: &Arc<Mutex<Node>>,
        tasks: &InputTasks,
        own: NodeServices,
        events: impl Future<Output = ()> + Send + 'static,
        (shut_down, lifecycle): (Box<dyn Fn() + Send>, Arc<Lifecycle>),
    ) -> Result<Task, NodeError> {
        let receiving = self.receiving.clone();
        let (of_inputs, tasks) = (Arc::clone(node), Arc::clone(tasks));
        let configure = move || -> Result<(), NodeError> {
            let (subscriptions, services) = self.offer(&mut lock(&of_inputs))?;
            start_both(&tasks, move || subscriptions.run(), move || services.run())
        };
        let actions = Actions {
            configure: Box::new(configure),
            shut_down,
        };
        let servers = LifecycleServers::new(&mut lock(node), lifecycle, actions)?;
        Task::start(LIFECYCLE_THREAD, move || async move {
            futures::join!(events, own.run(), servers.run(&receiving));
        })
    }
}

/// Starts the tasks of the inputs; if one fails, none runs on.
fn start_both<R: Future<Output = ()>, S: Future<Output = ()>>(
    tasks: &InputTasks,
    receive: impl FnOnce() -> R + Send + 'static,
    serve: impl FnOnce() -> S + Send + 'static,
) -> Result<(), NodeError> {
    let receiving = Task::start(RECEIVING_THREAD, receive)?;
    match Task::start(SERVING_THREAD, serve) {
        Ok(serving) => {
            lock(tasks).extend([receiving, serving]);
            Ok(())
        }
        Err(error) => {
            receiving.stop();
            Err(error)
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn stop_all(tasks: &Mutex<Vec<Task>>) {
    let tasks = std::mem::take(&mut *lock(tasks));
    tasks.into_iter().for_each(Task::stop);
}

/// Ends the thread that publishes, after what is queued.
fn stop_publishing(stop: &AtomicBool, waker: &Waker, publisher: JoinHandle<()>) {
    stop.store(true, Ordering::Relaxed);
    waker.wake();
    if publisher.join().is_err() {
        tracing::error!("the publishing thread panicked");
    }
}

/// Ends the thread that publishes the log: last, so that the log messages of the other threads are published.
fn stop_log(log: Option<(LogEnd, JoinHandle<()>)>) {
    let Some((end, thread)) = log else { return };
    end.send();
    if thread.join().is_err() {
        tracing::error!("the thread that publishes the log panicked");
    }
}

/// Where log messages go besides their readers.
struct LogCopies {
    recording: Option<Arc<dyn RecordingTap>>,
    #[cfg(feature = "foxglove")]
    foxglove: Option<NodeFoxglove>,
}

fn publish_log(
    node: &mut Node,
    queue: RosoutQueue,
    counters: &Arc<NodeCounters>,
    copies: LogCopies,
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
            if let Some(recording) = &copies.recording {
                recording.sent(&qos::ROSOUT, raw.bytes());
            }
            #[cfg(feature = "foxglove")]
            if let Some(foxglove) = &copies.foxglove {
                foxglove.sent(&qos::ROSOUT, raw.bytes());
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
