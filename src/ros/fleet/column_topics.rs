//! The topics of single columns in their namespaces, such as `/garage/a3/twin_status`: they exist while somebody listens there.
//!
//! Readers are discovered before they find a writer. A thread of its own creates the endpoints, because each takes some tenths of a
//! millisecond, and gives them to the publishing thread, which sends copies of the messages on the shared topics.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustdds::GUID;

use crate::fleet::{Demand, DemandChange, MAX_OPEN_COLUMNS};
use crate::live::{Notifier, Waker};
use crate::outgoing::Topic;

use crate::ros::dds_threads::TOPICS_THREAD;
use crate::ros::live_columns::LiveColumns;
use crate::ros::node::{Node, NodeError, Siblings};
use crate::ros::task::spawn;
use crate::ros::transport::Publisher;
use ros_node::matches::Discovered;
use ros_node::raw::Raw;

/// The name of the node to which the topics of a column belong, in the namespace of the column. It has no services, so it is not
/// that of the node of a single twin.
const NODE_NAME: &str = "column_topics";

/// Openings and closings that wait for the publishing thread; the thread that creates endpoints waits when it is full.
const WAITING_CHANGES: usize = 16;

/// What the names of ROS topics begin with in DDS.
const TOPIC_PREFIX: &str = "rt";

/// The writers of one column.
pub(in crate::ros) struct ColumnWriters(Vec<(Topic, Publisher<Raw>)>);

impl ColumnWriters {
    /// The writer of a topic.
    pub fn of(&self, topic: Topic) -> Option<&Publisher<Raw>> {
        let writer = self.0.iter().find(|(it, _)| *it == topic);
        writer.map(|(_, writer)| writer)
    }
}

/// What the publishing thread is told.
pub(in crate::ros) enum ColumnChange {
    /// A column has topics of its own.
    Opened(u32, ColumnWriters),
    /// It has none any more.
    Closed(u32),
}

/// Counts for `/diagnostics`.
#[derive(Debug, Default)]
pub(in crate::ros) struct TopicCounts {
    /// Columns that have topics of their own.
    pub open: AtomicUsize,
    /// Columns whose readers wait.
    pub waiting: AtomicUsize,
    /// Columns whose topics could not be created, since the start.
    pub failures: AtomicU64,
}

/// What the threads share.
struct Shared {
    /// The columns by their namespaces.
    columns: HashMap<Arc<str>, u32>,
    demand: Mutex<Demand<GUID>>,
    notifier: Notifier,
    stop: AtomicBool,
    started: Instant,
    counts: Arc<TopicCounts>,
}

/// The thread that creates and removes the topics of single columns.
pub(in crate::ros) struct ColumnTopics {
    shared: Arc<Shared>,
    thread: JoinHandle<()>,
}

impl ColumnTopics {
    /// Starts the thread, which wakes the publishing thread by `waker` for each change. The topics of a column stay for `linger` when
    /// their last reader has gone.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn start(
        node: &Node,
        fleet: &LiveColumns,
        linger: Duration,
        waker: Waker,
        counts: Arc<TopicCounts>,
    ) -> Result<(Self, Receiver<ColumnChange>), NodeError> {
        let own = node.names().namespace();
        let names = (0..).zip(fleet.face().names());
        // A column in the namespace of the node would have the topics that all columns share.
        let others = names.filter(|(_, name)| &***name != own);
        let endpoints = Topic::COUNT as u32;
        let shared = Arc::new(Shared {
            columns: others
                .map(|(column, name)| (Arc::clone(name), column))
                .collect(),
            demand: Mutex::new(Demand::new(endpoints, linger)),
            notifier: Notifier::default(),
            stop: AtomicBool::new(false),
            started: Instant::now(),
            counts,
        });
        let (sender, changes) = sync_channel(WAITING_CHANGES);
        let creator = Creator {
            shared: Arc::clone(&shared),
            siblings: node.siblings(),
            names: fleet.face().names().to_vec(),
            nodes: HashMap::new(),
            changes: sender,
            waker,
            has_told: false,
        };
        let thread = spawn(TOPICS_THREAD, move || creator.run())?;
        Ok((Self { shared, thread }, changes))
    }

    /// What is to be done with everything that is discovered.
    pub fn watch(&self) -> impl FnMut(Discovered<'_>) + use<> {
        let shared = Arc::clone(&self.shared);
        move |discovered| shared.take(&discovered)
    }

    /// Ends the thread. The publishing thread must still run.
    pub fn stop(self) {
        self.shared.stop.store(true, Ordering::SeqCst);
        self.shared.notifier.notify();
        if self.thread.join().is_err() {
            tracing::error!("the thread that creates the topics of single columns panicked");
        }
    }
}

impl Shared {
    fn demand(&self) -> MutexGuard<'_, Demand<GUID>> {
        self.demand.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now(&self) -> Duration {
        self.started.elapsed()
    }

    fn take(&self, discovered: &Discovered<'_>) {
        let now = self.now();
        let has_changed = match discovered {
            Discovered::Writer(_) => false,
            Discovered::Reader(reader) => self
                .column_of(reader.topic_name)
                .is_some_and(|column| self.demand().joined(reader.guid, column)),
            Discovered::ReaderLost(guid) => self.demand().left(|it| it == guid, now),
            Discovered::ParticipantLost(prefix) => {
                self.demand().left(|it| it.prefix.as_ref() == prefix.0, now)
            }
        };
        if has_changed {
            self.notifier.notify();
        }
    }

    /// The column to which a topic belongs, by its name in DDS.
    fn column_of(&self, dds_name: &str) -> Option<u32> {
        let (namespace, name) = dds_name.strip_prefix(TOPIC_PREFIX)?.rsplit_once('/')?;
        let is_known = Topic::ALL.iter().any(|it| it.endpoint().name == name);
        let column = self.columns.get(namespace)?;
        is_known.then_some(*column)
    }

    fn count(&self, demand: &Demand<GUID>) {
        self.counts.open.store(demand.open(), Ordering::Relaxed);
        self.counts
            .waiting
            .store(demand.waiting(), Ordering::Relaxed);
    }
}

/// The content of the thread.
struct Creator {
    shared: Arc<Shared>,
    siblings: Siblings,
    /// The full names of the columns.
    names: Vec<Arc<str>>,
    /// The nodes of the columns that have topics of their own, and their writers.
    nodes: HashMap<u32, (Node, Vec<GUID>)>,
    changes: SyncSender<ColumnChange>,
    waker: Waker,
    /// It was said that there are too many columns.
    has_told: bool,
}

impl Creator {
    fn run(mut self) {
        while !self.shared.stop.load(Ordering::SeqCst) {
            let now = self.shared.now();
            let mut demand = self.shared.demand();
            let (change, rest) = (demand.due(now), demand.rest(now));
            self.shared.count(&demand);
            let is_full = demand.open() >= MAX_OPEN_COLUMNS && demand.waiting() > 0;
            drop(demand);
            self.tell_of_limit(is_full);
            let told = match change {
                Some(DemandChange::Open(column)) => self.open(column),
                Some(DemandChange::Close(column)) => self.close(column),
                None => {
                    self.shared.notifier.wait(rest.unwrap_or(Duration::MAX));
                    continue;
                }
            };
            if !told {
                return; // the publishing thread has ended
            }
        }
    }

    fn tell_of_limit(&mut self, is_full: bool) {
        if is_full && !std::mem::replace(&mut self.has_told, true) {
            tracing::warn!(
                "somebody listens to more than {MAX_OPEN_COLUMNS} columns in their namespaces; further columns wait until others have \
                 no readers. The shared topics have all columns"
            );
        }
    }

    /// Creates the topics of a column. Returns `false` if the publishing thread has ended.
    fn open(&mut self, column: u32) -> bool {
        let name = Arc::clone(&self.names[column as usize]);
        match self.create(column, &name) {
            Ok(writers) => {
                tracing::debug!("the topics of {name} are open");
                self.tell(ColumnChange::Opened(column, writers))
            }
            Err(error) => {
                self.forget(column);
                self.shared.demand().failed(column);
                let failures = self.shared.counts.failures.fetch_add(1, Ordering::Relaxed);
                // Most likely all of them have the same cause.
                match failures {
                    0 => tracing::error!(
                        "the topics in {name} could not be created for their readers: {error}; further failures are only counted, in \
                         /diagnostics"
                    ),
                    _ => tracing::debug!("the topics in {name} could not be created: {error}"),
                }
                true
            }
        }
    }

    fn create(&mut self, column: u32, name: &str) -> Result<ColumnWriters, NodeError> {
        let node = self.siblings.node(name, NODE_NAME)?;
        let (node, guids) = self.nodes.entry(column).or_insert((node, Vec::new()));
        let mut writers = Vec::with_capacity(Topic::COUNT);
        for topic in Topic::ALL {
            let writer = node.publisher(topic.endpoint())?;
            guids.push(writer.guid());
            writers.push((topic, writer));
        }
        Ok(ColumnWriters(writers))
    }

    fn close(&mut self, column: u32) -> bool {
        tracing::debug!("the topics of {} are closed", self.names[column as usize]);
        self.forget(column);
        self.tell(ColumnChange::Closed(column))
    }

    fn forget(&mut self, column: u32) {
        if let Some((node, guids)) = self.nodes.remove(&column) {
            let matches = node.matches();
            guids.into_iter().for_each(|it| matches.forget(it));
        }
    }

    fn tell(&self, change: ColumnChange) -> bool {
        let is_taken = self.changes.send(change).is_ok();
        self.waker.wake();
        is_taken
    }
}
