//! The node of a fleet: its endpoints, in the same threads as the node of a single twin, and one that creates the topics of single
//! columns.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::live::{OutputSource, RealTime, Receiver, Waker, request_for_publisher};
use crate::outgoing::RecordingTap;

use super::super::clock_watch::ClockWatch;
use super::super::dds_threads::{PUBLISHING_THREAD, RECEIVING_THREAD, SERVING_THREAD};
use super::super::diagnostics::NodeCounters;
use super::super::environment::Environment;
use super::super::live_columns::LiveColumns;
use super::super::matches::Matches;
use super::super::measurements::SensedColumns;
use super::super::names::Names;
use super::super::node::{Node, NodeError};
use super::super::rosout::{LogEnd, RosoutQueue};
use super::super::senders::{Identities, Senders};
use super::super::task::Task;
use super::super::twin_node::{publish_log, spawn, stop_publishing_threads};
use super::column_topics::{ColumnTopics, TopicCounts};
use super::inputs::{FleetServices, FleetSubscriptions};
use super::publishing::FleetPublishing;
use super::rows::RowImpacts;

/// A running node of a fleet, until [`stop`](Self::stop).
pub struct FleetNode {
    // In the order in which they are stopped.
    inputs: Vec<Task>,
    column_topics: ColumnTopics,
    fleet: Arc<LiveColumns>,
    publisher: JoinHandle<()>,
    stop: Arc<AtomicBool>,
    waker: Waker,
    log: Option<(LogEnd, JoinHandle<()>)>,
    node: Node,
}

impl FleetNode {
    /// Starts the node of a running fleet; `recording` receives a copy of all messages.
    ///
    /// # Errors
    /// A participant, an endpoint or a thread cannot be created.
    pub fn start(
        environment: &Environment,
        names: Names,
        fleet: Arc<LiveColumns>,
        outputs: Receiver,
        log: Option<RosoutQueue>,
        recording: Option<Arc<dyn RecordingTap>>,
    ) -> Result<Self, NodeError> {
        Self::start_with(environment, names, fleet, outputs, log, recording, None)
    }

    /// As [`start`](Self::start); the topics of a single column stay for `linger` when their last reader has gone, for
    /// [`LINGER`](crate::fleet::LINGER) if none is given.
    ///
    /// # Errors
    /// See [`start`](Self::start).
    pub fn start_with(
        environment: &Environment,
        names: Names,
        fleet: Arc<LiveColumns>,
        outputs: Receiver,
        log: Option<RosoutQueue>,
        recording: Option<Arc<dyn RecordingTap>>,
        linger: Option<Duration>,
    ) -> Result<Self, NodeError> {
        let mut node = Node::new(environment, names)?;
        let settings = fleet.node_parameters().settings();
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
        let rows = Arc::new(RowImpacts::new(recording.clone()));
        let topic_counts = Arc::<TopicCounts>::default();
        let (column_topics, column_changes) = ColumnTopics::start(
            &node,
            &fleet,
            linger,
            outputs.waker(),
            Arc::clone(&topic_counts),
        )?;
        let sensed = SensedColumns::new(&fleet, recording.as_ref());
        let publishing = FleetPublishing::new(
            &mut node,
            Arc::clone(&fleet),
            Arc::clone(&counters),
            Arc::clone(&rows),
            sensed.clone(),
            recording.clone(),
            (column_changes, topic_counts),
        )?;
        let subscriptions = FleetSubscriptions::new(
            &mut node,
            settings.use_sim_time,
            Arc::clone(&senders),
            sensed,
            recording.clone(),
        )?;
        let describes = settings.start_type_description_service;
        let services = FleetServices::new(&mut node, describes, senders, rows, recording)?;
        let stop_publishing = Arc::clone(&stop);
        let waker = outputs.waker();
        let real_time = RealTime::of(fleet.node_parameters());
        let publisher = spawn(PUBLISHING_THREAD, move || {
            request_for_publisher(&real_time);
            publishing.run(outputs, &stop_publishing);
        })?;
        let events = node.events(column_topics.watch());
        let received = Arc::clone(&counters);
        let (event_fleet, service_fleet) = (Arc::clone(&fleet), Arc::clone(&fleet));
        let inputs = vec![
            Task::start(RECEIVING_THREAD, move || async move {
                futures::join!(events, subscriptions.run(event_fleet, received));
            })?,
            Task::start(SERVING_THREAD, move || {
                services.run(service_fleet, counters)
            })?,
        ];
        Ok(Self {
            inputs,
            column_topics,
            fleet,
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
        self.column_topics.stop();
        self.fleet.stop();
        stop_publishing_threads(&self.stop, &self.waker, self.publisher, self.log);
        // All threads have ended, and with them all endpoints.
        drop(self.node);
    }
}
