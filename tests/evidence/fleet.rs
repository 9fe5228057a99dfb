//! Recordings of a fleet: verified column by column, and whatever is changed in one of them is found and named.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use column_twin::evidence::{
    JournalEntry, JournalLine, NodeRecording, Topics, Verification, VerifyError, verify,
    verify_column,
};
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin_msgs::{
    ColumnParameters, ColumnState, FleetStatus, HingeForces, ImpactEvent, ImpactReport, TwinStatus,
};
use column_twin::messages::std_msgs::Header;
use column_twin::messages::{Message as Encoded, cdr};
use column_twin::outgoing::RecordingTap;
use column_twin::parameters::{FleetColumn, FleetColumns, Parameters, RecordMode, Value};
use column_twin::recording::{Message, Reader, WriterOptions};
use column_twin::report::ReportDocument;
use column_twin::ros::qos::{Endpoint, NodeKind, Qos};
use column_twin::ros::{LiveColumns, Names, Node, Publisher, TwinNode, qos};
use column_twin::twin::Command;
use serde::de::DeserializeOwned;
use tempfile::TempDir;

use super::copies::{messages, written_on};
use super::domain::{Domain, PATIENCE};
use super::incoming::{Incoming, reader};
use super::written::wait_until_written;

/// Few steps and few states, so that many verifications take seconds.
fn parameters(column_id: &str, more: &[(&str, Value)]) -> Parameters {
    let values = [
        ("column_id", Value::from(column_id)),
        ("solver.dt", Value::from(1e-4)),
        ("publish_rate", Value::from(500.0)),
        ("response.duration", Value::from(0.08)),
        ("state.directory", Value::from("")),
        ("assessment.ultimate_rotation", Value::from(0.0)),
        ("real_time.priority", Value::Integer(0)),
        ("real_time.lock_memory", Value::Bool(false)),
        ("real_time.threads", Value::Integer(2)),
    ];
    let all = values.into_iter().chain(more.iter().cloned());
    Parameters::from_values(all).expect("admissible")
}

/// A fleet whose node is recorded, and a peer that hits its columns.
struct RecordedFleet {
    node: TwinNode,
    fleet: Arc<LiveColumns>,
    recording: Arc<NodeRecording>,
    events: Publisher<ImpactEvent>,
    parameters: Publisher<ColumnParameters>,
    statuses: Incoming<TwinStatus>,
    /// The newest status of each column. A column at rest does not repeat its own every second.
    newest: RefCell<BTreeMap<String, TwinStatus>>,
    _peer: Node,
    directory: TempDir,
}

impl RecordedFleet {
    fn start(columns: usize, mode: RecordMode, more: &[(&str, Value)]) -> Self {
        let domain = Domain::fresh();
        let directory = TempDir::new().expect("a directory");
        let word = match mode {
            RecordMode::Events => "events",
            _ => "always",
        };
        let place = directory.path().display().to_string();
        let record = [
            ("record.mode", Value::from(word)),
            ("record.directory", Value::from(place)),
        ];
        let more = [more, &record].concat();
        let column = |number: usize| FleetColumn {
            name: format!("/hall/c{number}"),
            parameters: Arc::new(parameters(&format!("c{number}"), &more)),
        };
        let columns = FleetColumns {
            columns: (0..columns).map(column).collect(),
            node: parameters("node", &more),
            warnings: Vec::new(),
        };
        let ids = columns.columns.iter();
        let ids = ids.map(|it| it.parameters.settings().column_id.as_str().into());
        let recording = NodeRecording::start(
            &columns.node.settings().record,
            &Topics::of_default_node(NodeKind::Fleet),
            ids.collect(),
            |options| options,
        );
        let recording = recording.expect("starts").expect("is asked for");
        let (fleet, outputs) = LiveColumns::start_fleet(&columns).expect("starts");
        let tap: Arc<dyn RecordingTap> = Arc::clone(&recording) as _;
        let node = TwinNode::start(
            &domain.environment,
            Names::new("/", "column_twin", &[]).expect("valid"),
            Arc::clone(&fleet),
            outputs,
            None,
            Some(tap),
        );
        let mut peer = reader(&domain);
        let events = peer.publisher(&qos::IMPACT_EVENT).expect("a publisher");
        let parameters = peer
            .publisher(&qos::COLUMN_PARAMETERS)
            .expect("a publisher");
        // A history of one status would lose those of columns that change together.
        let of_all = Endpoint {
            qos: Qos {
                depth: 100,
                ..qos::TWIN_STATUS.qos
            },
            ..qos::TWIN_STATUS
        };
        let statuses = Incoming::start(&mut peer, &of_all);
        let matched = Instant::now() + PATIENCE;
        assert!(peer.matches().wait_for(events.guid(), 1, matched));
        assert!(peer.matches().wait_for(parameters.guid(), 1, matched));
        Self {
            node: node.expect("a node"),
            fleet,
            recording,
            events,
            parameters,
            statuses,
            newest: RefCell::default(),
            _peer: peer,
            directory,
        }
    }

    fn hit(&self, column: &str, id: &str) {
        self.hit_with(column, id, 1500.0);
    }

    fn hit_with(&self, column: &str, id: &str, mass: f64) {
        let event = ImpactEvent {
            header: Header {
                stamp: Time::from_nanos(self.fleet.now()).expect("a time"),
                frame_id: String::new(),
            },
            column_id: column.to_owned(),
            event_id: id.to_owned(),
            mass,
            velocity: 5.0,
            ..ImpactEvent::default()
        };
        self.events.publish(event).expect("sent");
    }

    /// Waits until the newest status of some column is such a one.
    fn until(&self, what: &str, is: impl Fn(&TwinStatus) -> bool) {
        let mut newest = self.newest.borrow_mut();
        if newest.values().any(&is) {
            return;
        }
        self.statuses.find(what, |it| {
            newest.insert(it.column_id.clone(), it.clone());
            is(it)
        });
    }

    fn until_rest(&self, column: &str, impacts: u32) {
        self.until("a column at rest", |it| {
            it.column_id == column && it.is_at_rest() && it.impacts_since_reset == impacts
        });
    }

    fn stop(self) -> Finished {
        self.node.stop();
        let statistics = self.recording.stop().expect("it ran");
        assert_eq!((statistics.lost, statistics.write_errors), (0, 0));
        Finished {
            directory: self.directory,
        }
    }
}

struct Finished {
    directory: TempDir,
}

impl Finished {
    /// The recordings, in order.
    fn paths(&self) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(self.directory.path()).expect("readable");
        let mut found: Vec<_> = entries.map(|it| it.expect("readable").path()).collect();
        // `_2` precedes `_10`.
        found.sort_by_key(|path| (path.as_os_str().len(), path.clone()));
        found
    }

    fn path(&self) -> PathBuf {
        let mut paths = self.paths();
        assert_eq!(paths.len(), 1, "{paths:?}");
        paths.remove(0)
    }
}

/// Verifies that everything was compared, and is equal.
#[track_caller]
fn assert_verified(found: &Verification) {
    assert!(found.is_equal(), "{found}");
    assert_eq!(found.unchecked, Vec::<String>::new(), "{found}");
    assert_eq!(
        (found.unchecked_messages(), found.missing()),
        (0, 0),
        "{found}"
    );
}

/// A `fleet_status` that tells of both impacts on `c0`.
fn is_of_c0(message: &Message) -> bool {
    let hit_twice = |status: FleetStatus| {
        let mut columns = status.columns.iter();
        columns.any(|it| it.column_id == "c0" && it.impacts_since_reset == 2)
    };
    message.topic.ends_with("fleet_status") && cdr::decode(&message.data).is_ok_and(hit_twice)
}

/// Two columns that are hit at once, one of them twice while it moves; a rejected impact, a set of parameters, a reset.
fn eventful(mode: RecordMode) -> Finished {
    let fleet = RecordedFleet::start(6, mode, &[]);
    fleet.hit("c0", "a");
    fleet.hit("c1", "b");
    fleet.until("the first moves", |it| {
        it.column_id == "c0" && !it.is_at_rest()
    });
    fleet.hit("c0", "on the moving column");
    fleet.hit("elsewhere", "ignored");
    fleet.hit_with("c2", "impossible", -1.0);
    fleet
        .parameters
        .publish(ColumnParameters {
            column_id: "c3".to_owned(),
            top_load: 3e5,
            ..ColumnParameters::default()
        })
        .expect("sent");
    fleet.until_rest("c0", 2);
    fleet.until("the parameters", |it| {
        it.column_id == "c3" && it.parameters_accepted == 1
    });
    let reset = Command::Reset {
        source: "test".into(),
    };
    fleet.fleet.execute(1, reset).expect("reset");
    fleet.until_rest("c1", 0);
    fleet.hit("c1", "c");
    fleet.until_rest("c1", 1);
    wait_until_written(fleet.directory.path(), "the fleet with both hits", is_of_c0);
    fleet.stop()
}

#[test]
fn a_fleet_is_verified_column_by_column() {
    for mode in [RecordMode::Events, RecordMode::Always] {
        let recorded = eventful(mode);
        let path = recorded.path();
        let found = verify(&path).expect("readable");
        assert_verified(&found);
        assert_eq!(found.fleet, Some(6));
        let columns: Vec<_> = found.columns.keys().map(String::as_str).collect();
        assert_eq!(columns, ["c0", "c1", "c2", "c3"], "{found}");
        assert!(found.columns["c0"].inputs >= 2 && found.columns["c1"].inputs >= 3);
        assert!(found.columns.values().all(|it| it.checkpoints > 0));
        assert!(found.fleet_statuses.compared > 0, "{found}");
        let sum: u64 = found.columns.values().map(|it| it.compared).sum();
        assert_eq!(sum, found.compared());

        let reader = Reader::open(&path).expect("readable");
        let one = verify_column(&reader, "c1").expect("a column");
        assert_verified(&one);
        assert_eq!(one.columns["c1"], found.columns["c1"]);
        assert_eq!(one.columns.len(), 1);
        assert!(one.of_other_columns > 0);
        let none = verify_column(&reader, "c9").expect_err("no such column");
        assert!(matches!(none, VerifyError::NoSuchColumn { .. }), "{none}");
        let known = r#"("c0", "c1", "c2", "c3", "c4", "c5"), found "c9""#;
        assert!(none.to_string().contains(known), "{none}");
        let unnamed = ReportDocument::of_recording(&path, None, None).expect_err("no column");
        let hint = r#"--column (columns in the recording: "c0", "c1", "c2", "c3")"#;
        assert!(unnamed.to_string().ends_with(hint), "{unnamed}");
    }
}

/// A column that nothing happens to is in the recording by its name only.
#[test]
fn an_idle_column_costs_nothing() {
    let fleet = RecordedFleet::start(300, RecordMode::Events, &[]);
    fleet.hit("c7", "a");
    fleet.until_rest("c7", 1);
    let recorded = fleet.stop();
    let path = recorded.path();
    let found = verify(&path).expect("readable");
    assert_verified(&found);
    assert_eq!(found.fleet, Some(300));
    assert!(found.columns.keys().eq(["c7"]), "{found}");
    let lines = messages(&path);
    let lines = lines.iter().filter(|it| it.topic.ends_with("/journal"));
    let of_others: Vec<_> = lines
        .map(|it| JournalLine::decode(&it.data).expect("a line"))
        .filter(|it| it.column_id.as_deref() != Some("c7"))
        .collect();
    assert!(
        matches!(
            of_others.iter().map(|it| &it.entry).collect::<Vec<_>>()[..],
            [JournalEntry::Fleet { .. }, JournalEntry::End {}]
        ),
        "{of_others:?}"
    );
}

/// Every recording can be verified by itself: it begins where no column is in the middle of anything.
#[test]
fn every_recording_of_a_fleet_is_verified_by_itself() {
    // On a busy machine, the opinion of the fibre beam arrives only after the column has come to rest and has been reset. A column is then
    // still active when the next round begins, and no new recording starts before the present one reaches its hard limit.
    let small = [
        ("record.max_file_size", Value::Integer(1_000_000)),
        ("beam.mode", Value::from("off")),
    ];
    let fleet = RecordedFleet::start(4, RecordMode::Events, &small);
    let recordings = || std::fs::read_dir(fleet.directory.path()).unwrap().count();
    let mut round = 0;
    while recordings() < 3 {
        round += 1;
        assert!(round < 200, "no other recording has begun");
        for column in ["c0", "c1", "c2"] {
            fleet.hit(column, &format!("{column} {round}"));
        }
        for column in ["c0", "c1", "c2"] {
            fleet.until(column, |it| {
                it.column_id == column && it.is_at_rest() && it.events_accepted == round
            });
        }
        // The damage of many impacts would end in a collapse.
        for column in 0..3 {
            let source = "test".into();
            fleet
                .fleet
                .execute(column, Command::Reset { source })
                .expect("reset");
        }
        // If the status of a reset came after the command of the next hit, the recorder would take the column for one at rest.
        for column in ["c0", "c1", "c2"] {
            fleet.until_rest(column, 0);
        }
    }
    let recorded = fleet.stop();
    for path in recorded.paths() {
        let found = verify(&path).expect("readable");
        assert!(found.is_equal() && found.missing() == 0, "{found}");
        // The next round of events may come while the columns still give the checkpoints with which a recording begins: an
        // event is then the last message of one recording, and its command in the next.
        let is_at_the_end = |it: &String| it.contains("came at the end of the recording");
        assert!(found.unchecked.iter().all(is_at_the_end), "{found}");
        assert_eq!(found.columns.len(), 3, "{found}");
    }
}

fn verified(messages: &[Message]) -> Verification {
    let options = WriterOptions::default();
    let (_directory, path) = written_on(
        &Topics::of_default_node(NodeKind::Fleet),
        &options,
        messages,
    );
    verify(&path).expect("readable")
}

/// Changes a message in its decoded form.
fn changed<M: Encoded + DeserializeOwned>(message: &mut Message, change: impl Fn(&mut M)) {
    let mut decoded: M = cdr::decode(&message.data).expect("a message");
    change(&mut decoded);
    message.data = cdr::encode(&decoded).expect("bytes");
}

/// The identifier of the column of a message.
fn column_of(message: &Message) -> Option<String> {
    let name = message.topic.trim_start_matches('/');
    Some(match name {
        "column_state" => cdr::decode::<ColumnState>(&message.data).ok()?.column_id,
        "hinge_forces" => cdr::decode::<HingeForces>(&message.data).ok()?.column_id,
        "impact_forecast" | "impact_report" => {
            cdr::decode::<ImpactReport>(&message.data).ok()?.column_id
        }
        "impact_event" => cdr::decode::<ImpactEvent>(&message.data).ok()?.column_id,
        "twin_status" => cdr::decode::<TwinStatus>(&message.data).ok()?.column_id,
        _ => return None,
    })
}

/// The same message for another column.
fn moved(message: &mut Message, column: &str) {
    let name = message.topic.to_string();
    match name.trim_start_matches('/') {
        "column_state" => changed::<ColumnState>(message, |it| it.column_id = column.to_owned()),
        "hinge_forces" => changed::<HingeForces>(message, |it| it.column_id = column.to_owned()),
        "impact_forecast" | "impact_report" => {
            changed::<ImpactReport>(message, |it| it.column_id = column.to_owned());
        }
        "impact_event" => changed::<ImpactEvent>(message, |it| it.column_id = column.to_owned()),
        "twin_status" => changed::<TwinStatus>(message, |it| it.column_id = column.to_owned()),
        other => panic!("{other}"),
    }
}

/// One bit of a number in the message.
fn bent(message: &mut Message) {
    let next = |number: &mut f64| *number = f64::from_bits(number.to_bits() ^ 1);
    let name = message.topic.to_string();
    match name.trim_start_matches('/') {
        "column_state" => changed::<ColumnState>(message, |it| next(&mut it.v1)),
        "hinge_forces" => changed::<HingeForces>(message, |it| next(&mut it.moment[0])),
        "impact_forecast" | "impact_report" => {
            changed::<ImpactReport>(message, |it| next(&mut it.max_v1));
        }
        "impact_event" => changed::<ImpactEvent>(message, |it| next(&mut it.mass)),
        "twin_status" => changed::<TwinStatus>(message, |it| next(&mut it.residual_v1)),
        other => panic!("{other}"),
    }
}

/// Two columns that are hit at once, and one that is not.
fn hit_at_once() -> Finished {
    let fleet = RecordedFleet::start(3, RecordMode::Events, &[]);
    fleet.hit("c0", "a");
    fleet.hit("c1", "b");
    for column in ["c0", "c1"] {
        fleet.until_rest(column, 1);
    }
    fleet.stop()
}

/// Of each topic one message of column `c1`: changed, removed, twice, and moved to another column that was hit; one also to a column
/// that was not hit, and to one that does not exist.
#[test]
fn what_is_changed_in_one_column_is_found_and_named() {
    let all = messages(&hit_at_once().path());
    assert_verified(&verified(&all));
    for topic in [
        "column_state",
        "hinge_forces",
        "impact_forecast",
        "impact_report",
        "impact_event",
        "twin_status",
    ] {
        let of_column = |it: &Message| {
            it.topic.trim_start_matches('/') == topic && column_of(it).as_deref() == Some("c1")
        };
        let places: Vec<_> = (0..all.len()).filter(|it| of_column(&all[*it])).collect();
        let place = places[places.len() / 2];
        let ways = ["changed", "removed", "twice", "c0", "c2", "nowhere"];
        let count = if topic == "column_state" { 6 } else { 4 };
        for way in &ways[..count] {
            let way = *way;
            let mut forged = all.clone();
            match way {
                "changed" => bent(&mut forged[place]),
                "removed" => drop(forged.remove(place)),
                "twice" => forged.insert(place, all[place].clone()),
                other => moved(&mut forged[place], other),
            }
            let found = verified(&forged);
            assert!(found.is_contradicted(), "{topic} {way}: {found}");
            let findings = found.examples.iter().chain(&found.missing_examples);
            let named: BTreeSet<_> = findings.map(|it| it.column_id.as_str()).collect();
            assert!(named.contains("c1"), "{topic} {way}: {found}");
            if way == "nowhere" {
                let text = found.to_string();
                assert!(text.contains("a column of the fleet"), "{topic}: {text}");
            }
        }
    }
}

/// The columns in `fleet_status` are those of the last `twin_status`.
#[test]
fn a_changed_fleet_status_is_found() {
    let all = messages(&eventful(RecordMode::Always).path());
    let mut forged = all.clone();
    let mut of_c0 = forged.iter_mut().filter(|it| is_of_c0(it));
    let message = of_c0.next().expect("the status of c0");
    changed::<FleetStatus>(message, |status| {
        for column in status.columns.iter_mut().filter(|it| it.column_id == "c0") {
            column.residual_v1 += 1.0;
        }
    });
    let found = verified(&forged);
    assert!(found.is_contradicted(), "{found}");
    let first = found.first_difference.as_ref().expect("a difference");
    assert_eq!(
        (first.column_id.as_str(), first.field.as_str()),
        ("c0", "residual_v1")
    );
}
