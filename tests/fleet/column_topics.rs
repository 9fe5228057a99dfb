//! The topics of single columns in their namespaces, which exist while somebody listens there.

use std::collections::{BTreeMap, BTreeSet};
use std::net::{IpAddr, Ipv4Addr};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::{ColumnState, ImpactEvent, ImpactReport, TwinStatus};
use column_twin::messages::visualization_msgs::MarkerArray;
use column_twin::outgoing::Topic;
use column_twin::ros::{LiveColumns, Names, StartOptions, TwinNode, qos};
use futures::StreamExt;
use futures::future::{AbortHandle, Abortable};
use rustdds::{
    DomainParticipantBuilder, DomainParticipantStatusEvent as Event, GUID, StatusEvented,
};

use super::domain::{Domain, PATIENCE};
use super::incoming::{Incoming, reader};
use super::node::{Running, event, fleet};

/// How long the topics stay without a reader.
const LINGER: Duration = Duration::from_millis(100);

/// A fleet whose columns keep topics of their own for [`LINGER`].
pub fn start(domain: &Domain, columns: usize) -> Running {
    let (fleet, outputs) = LiveColumns::start_fleet(&fleet(columns)).expect("starts");
    let node = TwinNode::start_with(
        &domain.environment,
        Names::new("/", "column_twin", &[]).expect("valid"),
        Arc::clone(&fleet),
        outputs,
        None,
        None,
        StartOptions {
            linger: LINGER,
            ..StartOptions::default()
        },
    );
    Running {
        node: node.expect("a node"),
        fleet,
    }
}

/// A participant that sees which writers there are, until it is dropped.
struct Observer {
    /// A writer with its topic, or none if the writer has gone.
    events: Receiver<(GUID, Option<String>)>,
    abort: AbortHandle,
    thread: Option<JoinHandle<()>>,
    /// The writers that are there.
    writers: BTreeMap<GUID, String>,
    /// Topics on which a writer was ever seen.
    topics: BTreeSet<String>,
}

impl Observer {
    fn start(domain: &Domain) -> Self {
        let participant = DomainParticipantBuilder::new(domain.environment.domain_id)
            .with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)])
            .build()
            .expect("a participant");
        let (sender, events) = channel();
        let (abort, registration) = AbortHandle::new_pair();
        let thread = std::thread::spawn(move || {
            let listener = participant.status_listener();
            let each = listener.as_async_status_stream().for_each(|event| {
                let told = match event {
                    Event::WriterDetected { writer } => {
                        Some((writer.guid, Some(writer.topic_name)))
                    }
                    Event::WriterLost { guid, .. } => Some((guid, None)),
                    _ => None,
                };
                if let Some(told) = told {
                    let _ = sender.send(told);
                }
                futures::future::ready(())
            });
            let _ = futures::executor::block_on(Abortable::new(each, registration));
        });
        Self {
            events,
            abort,
            thread: Some(thread),
            writers: BTreeMap::new(),
            topics: BTreeSet::new(),
        }
    }

    /// Follows the events until the topics that begin with `prefix` and have a writer are these.
    fn wait_for(&mut self, prefix: &str, topics: &BTreeSet<String>) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let present = self.writers.values().filter(|it| it.starts_with(prefix));
            let present: BTreeSet<_> = present.cloned().collect();
            if present == *topics {
                return;
            }
            let rest = deadline.saturating_duration_since(Instant::now());
            match self.events.recv_timeout(rest) {
                Ok((guid, Some(topic))) => {
                    self.topics.insert(topic.clone());
                    self.writers.insert(guid, topic);
                }
                Ok((guid, None)) => drop(self.writers.remove(&guid)),
                Err(_) => panic!("expected {topics:?} below {prefix}, found {present:?}"),
            }
        }
    }
}

impl Drop for Observer {
    fn drop(&mut self) {
        self.abort.abort();
        if let Some(thread) = self.thread.take() {
            thread.join().expect("no panic");
        }
    }
}

/// The endpoint in the namespace of column `c1`.
fn of_c1(name: &'static str, shared: qos::Endpoint) -> qos::Endpoint {
    assert!(name.ends_with(shared.name));
    qos::Endpoint { name, ..shared }
}

/// The states of a response of column `c1`, as bytes.
fn states(incoming: &Incoming<ColumnState>, event_id: &str) -> Vec<Vec<u8>> {
    let mut states = Vec::new();
    incoming.find("the last state", |state| {
        let is_it = state.column_id == "c1" && state.event_id == event_id;
        if is_it {
            states.push(cdr::encode(state).expect("encodes"));
        }
        let goes_on = [TwinStatus::APPROACH, TwinStatus::CONTACT, TwinStatus::FREE];
        is_it && !goes_on.contains(&state.phase)
    });
    states
}

#[test]
fn a_column_has_topics_of_its_own_as_long_as_somebody_listens_there() {
    let domain = Domain::fresh();
    let running = start(&domain, 3);
    let mut observer = Observer::start(&domain);
    let shared = BTreeSet::from(["rt/fleet_status".to_owned()]);
    observer.wait_for("rt/fleet_status", &shared);

    // An impact before anybody listens to the column itself.
    let mut node = reader(&domain);
    let publisher = node
        .publisher::<ImpactEvent>(&qos::IMPACT_EVENT)
        .expect("a publisher");
    let all_reports = Incoming::<ImpactReport>::start(&mut node, &qos::IMPACT_REPORT);
    let all_states = Incoming::<ColumnState>::start(&mut node, &qos::COLUMN_STATE);
    let deadline = Instant::now() + PATIENCE;
    assert!(node.matches().wait_for(publisher.guid(), 1, deadline));
    let send = |column: &str, id: &str| {
        let event = event(column, id, running.fleet.now());
        publisher.publish(event).expect("sent");
    };
    send("c1", "before");
    let report = all_reports.find("the report", |it| it.event_id == "before");

    // What is kept for late joiners comes to those who listen from now on.
    let mut own = reader(&domain);
    let reports = of_c1("/hall/c1/impact_report", qos::IMPACT_REPORT);
    let reports = Incoming::<ImpactReport>::start(&mut own, &reports);
    let bytes = |it: &ImpactReport| cdr::encode(it).expect("encodes");
    // The report comes once more if the second opinion takes longer than the response.
    let kept = reports.next();
    if bytes(&kept) != bytes(&report) {
        all_reports.find("what is kept", |it| bytes(it) == bytes(&kept));
    }
    let statuses = of_c1("/hall/c1/twin_status", qos::TWIN_STATUS);
    let statuses = Incoming::<TwinStatus>::start(&mut own, &statuses);
    let status = statuses.find("the status", |it| it.impacts_since_reset == 1);
    assert_eq!(status.column_id, "c1");
    let markers = of_c1("/hall/c1/markers", qos::MARKERS);
    let markers = Incoming::<MarkerArray>::start(&mut own, &markers);
    assert!(!markers.next().markers.is_empty());
    let topics: BTreeSet<_> = Topic::ALL
        .iter()
        .map(|it| format!("rt/hall/c1/{}", it.endpoint().name))
        .collect();
    observer.wait_for("rt/hall/", &topics);

    // What happens from now on is the same on both topics, and only that of this column.
    let own_states = of_c1("/hall/c1/column_state", qos::COLUMN_STATE);
    let own_states = Incoming::<ColumnState>::start(&mut own, &own_states);
    // The reader has found the node, but perhaps not the node the reader, and states are not kept for late joiners.
    let deadline = Instant::now() + PATIENCE;
    let is_known = running
        .node
        .matches()
        .wait_for_peer(own_states.guid, deadline);
    assert!(is_known, "the node has not found the reader of states");
    send("c0", "other");
    send("c1", "after");
    let expected = states(&all_states, "after");
    let mut others = 0;
    let found = {
        let mut found = Vec::new();
        while found.len() < expected.len() {
            let state = own_states.next();
            others += usize::from(state.column_id != "c1");
            found.push(cdr::encode(&state).expect("encodes"));
        }
        found
    };
    assert!(expected.len() > 10, "{}", expected.len());
    assert!(found == expected, "{others} states of other columns");
    let after = reports.find("the second report", |it| it.event_id != "before");
    assert_eq!((&*after.column_id, &*after.event_id), ("c1", "after"));

    // They go when nobody listens any more. The participant stays: one that leaves under load may not tell the end of its readers.
    drop((reports, statuses, markers, own_states));
    observer.wait_for("rt/hall/", &BTreeSet::new());
    let mut ever = observer.topics.iter();
    assert!(ever.all(|it| !it.starts_with("rt/hall/") || it.starts_with("rt/hall/c1/")));
    // And come again. A participant keeps what it has received on a topic, so this is another one.
    let mut another = reader(&domain);
    let reports = of_c1("/hall/c1/impact_report", qos::IMPACT_REPORT);
    let reports = Incoming::<ImpactReport>::start(&mut another, &reports);
    assert_eq!(reports.next().event_id, "after");
    drop((reports, all_reports, all_states));
    running.node.stop();
}
