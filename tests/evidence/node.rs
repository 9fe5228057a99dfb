//! A node on loopback and its recording.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::Instant;

use column_twin::column::ImpactSpecification;
use column_twin::endpoints::NodeKind;
use column_twin::evidence::{JournalEntry, JournalLine, NodeRecording, Topics, verify};
use column_twin::live::{LiveOptions, RealTime};
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::ImpactReport;
use column_twin::messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use column_twin::messages::rcl_interfaces::ParameterEvent;
use column_twin::parameters::{Parameters, Value};
use column_twin::recording::Reader;
use column_twin::ros::qos;
use column_twin::ros::{
    ImpactOptions, ImpactOutcome, ImpactRequest, LiveColumns, Names, Raw, TwinNode, send_impact,
};
use column_twin::twin::{Command as TwinCommand, Journal};
use tempfile::TempDir;

use super::copies::forged;
use super::domain::{Domain, PATIENCE};
use super::incoming::{Incoming, reader};
use super::recorded_twin::the_one_recording;
use super::written::wait_until_written;

/// The bytes of one topic.
pub type Bytes = Incoming<Raw>;

pub fn impact(domain: &Domain, id: &str, velocity: f64) -> Result<ImpactOutcome, String> {
    impact_of(domain, id, 1500.0, velocity)
}

/// Heavy and slow: the column moves for a third of a second, and stays elastic.
pub fn slow_impact(domain: &Domain, id: &str) {
    let outcome = impact_of(domain, id, 1e6, 0.04);
    assert!(
        matches!(outcome, Ok(ImpactOutcome::Forecast(_))),
        "{outcome:?}"
    );
}

fn impact_of(domain: &Domain, id: &str, mass: f64, velocity: f64) -> Result<ImpactOutcome, String> {
    let options = ImpactOptions {
        column_id: Some("column".to_owned()),
        request: ImpactRequest {
            vehicle: String::new(),
            event_id: Some(id.to_owned()),
            impact: ImpactSpecification {
                mass,
                velocity,
                gap: None,
                restitution: None,
                height: None,
                direction: None,
            },
            match_timeout: PATIENCE,
            answer_timeout: PATIENCE,
        },
    };
    send_impact(&domain.environment, &[], &options, &mut |_| {}).map_err(|error| error.to_string())
}

fn recorded(path: &Path) -> BTreeMap<String, Vec<Vec<u8>>> {
    let mut found: BTreeMap<String, Vec<Vec<u8>>> = BTreeMap::new();
    for message in Reader::open(path).unwrap().messages() {
        let message = message.unwrap();
        let topic = found.entry(message.topic.to_string()).or_default();
        topic.push(message.data);
    }
    found
}

#[test]
fn the_recording_has_the_published_bytes_and_is_verified() {
    let domain = Domain::fresh();
    let directory = TempDir::new().unwrap();
    let place = directory.path().display().to_string();
    let parameters = Parameters::from_values([
        ("state.directory", Value::from("")),
        ("record.mode", Value::from("always")),
        ("record.directory", Value::from(place)),
    ])
    .unwrap();
    let names = Names::new("/", "column_twin", &[]).unwrap();
    let topics =
        Topics::resolved(NodeKind::Single, |it| names.resolve(it.kind(), it.name)).unwrap();
    let record = parameters.settings().record.clone();
    let recording = NodeRecording::start(&record, &topics, Arc::new(["column".into()]), |it| it)
        .unwrap()
        .unwrap();
    let options = LiveOptions {
        real_time: RealTime::none(),
        ..LiveOptions::default()
    };
    let (twin, outputs) = LiveColumns::start_one(parameters, options).unwrap();
    let node = TwinNode::start(
        &domain.environment,
        names,
        Arc::clone(&twin),
        outputs,
        None,
        Some(Arc::clone(&recording) as _),
    )
    .unwrap();
    let mut reader = reader(&domain);
    let states = Bytes::start(&mut reader, &qos::COLUMN_STATE);
    let forces = Bytes::start(&mut reader, &qos::HINGE_FORCES);
    let reports = Bytes::start(&mut reader, &qos::IMPACT_REPORT);
    // The readers have found the node, but perhaps not the node the readers, and states are not kept for late joiners.
    let deadline = Instant::now() + PATIENCE;
    for it in [states.guid, forces.guid] {
        assert!(node.matches().wait_for_peer(it, deadline), "{it:?}");
    }
    for (id, velocity) in [("a", 3.0), ("b", 8.0)] {
        let outcome = impact(&domain, id, velocity);
        assert!(
            matches!(outcome, Ok(ImpactOutcome::Forecast(_))),
            "{outcome:?}"
        );
        reports.messages.recv_timeout(PATIENCE).expect("a report");
        let load = TwinCommand::SetParameters {
            changes: vec![("top.load".to_owned(), Value::from(1e5 * velocity))],
            source: "test".into(),
        };
        twin.execute(0, load).unwrap();
        let rejected = impact(&domain, id, velocity);
        assert!(
            matches!(rejected, Ok(ImpactOutcome::Rejected(_))),
            "{rejected:?}"
        );
    }
    let reset = TwinCommand::Reset {
        source: "test".into(),
    };
    twin.execute(0, reset).unwrap();
    node.stop();
    let statistics = recording.stop().unwrap();
    assert_eq!((statistics.lost, statistics.write_errors), (0, 0));

    let path = the_one_recording(directory.path());
    let recorded = recorded(&path);
    for (topic, wire) in [("/column_state", states), ("/hinge_forces", forces)] {
        assert!(
            recorded[topic].len() > 40,
            "{topic}: {}",
            recorded[topic].len()
        );
        for recorded in &recorded[topic] {
            assert_eq!(recorded[..], wire.next().bytes()[..], "{topic}");
        }
        assert!(wire.newest().is_none(), "{topic}");
    }
    assert_eq!(recorded["/impact_event"].len(), 4);
    let diagnostics: DiagnosticArray =
        cdr::decode(recorded["/diagnostics"].last().unwrap()).unwrap();
    let of_recording = diagnostics
        .status
        .iter()
        .find(|it| it.name.ends_with(": recording"));
    assert_eq!(
        of_recording.unwrap().level,
        DiagnosticStatus::OK,
        "{diagnostics:?}"
    );
    assert!(recorded["/parameter_events"].len() >= 3);
    let found = verify(&path).unwrap();
    assert!(found.is_equal(), "{found}");
    // What is computed in the background is a command, too; how much of it was known in time depends on the machine.
    let journal = recorded["/column_twin/journal"].iter();
    let in_background = journal.filter(|line| {
        let entry = JournalLine::decode(line).unwrap().entry;
        matches!(entry, JournalEntry::Twin(Journal::Command(it)) if matches!(
            it.command,
            TwinCommand::CriticalVelocities { .. }
                | TwinCommand::VerdictRange(_)
                | TwinCommand::SecondOpinion(_)
        ))
    });
    assert_eq!(found.inputs, 7 + in_background.count() as u64, "{found}");
    assert_eq!(
        (found.unchecked_messages(), found.missing()),
        (0, 0),
        "{found}"
    );
    // All parameters as new ones, and two changes.
    assert_eq!(found.parameter_events.compared, 3, "{found}");
    let mut events = 0;
    let (_kept, forged) = forged(&path, |message| {
        let is_event = *message.topic == *qos::PARAMETER_EVENTS.name;
        events += usize::from(is_event);
        if !is_event || events != 2 {
            return Some(message.data.clone());
        }
        let mut event: ParameterEvent = cdr::decode(&message.data).unwrap();
        assert_eq!(event.changed_parameters[0].name, "top.load");
        event.changed_parameters[0].value.double_value *= 0.5;
        Some(cdr::encode(&event).unwrap())
    });
    let first = verify(&forged).unwrap().first_difference.unwrap();
    assert_eq!(
        (first.topic.as_str(), first.by),
        (qos::PARAMETER_EVENTS.name, Some(-1.5e5)),
        "{first}"
    );
}

/// A slow recorder does not delay the node, and its losses are counted and declared.
#[test]
fn losses_are_counted_and_declared() {
    use column_twin::outgoing::RecordingTap;
    use column_twin::parameters::{RecordMode, RecordSettings};
    use column_twin::recording::RecorderOptions;

    let directory = TempDir::new().unwrap();
    let record = RecordSettings {
        mode: RecordMode::Always,
        directory: directory.path().display().to_string(),
        ..Parameters::default().settings().record.clone()
    };
    let short = |options| RecorderOptions {
        queue_messages: 4,
        ..options
    };
    let topics = Topics::of_default_node(NodeKind::Single);
    let recording = NodeRecording::start(&record, &topics, Arc::new(["column".into()]), short)
        .unwrap()
        .unwrap();
    let bytes: Arc<[u8]> = vec![0, 1, 0, 0].into();
    (0..10_000).for_each(|_| recording.sent(&qos::DIAGNOSTICS, &bytes));
    let health = recording.health();
    assert!(
        health.lost > 0 && health.queue.dropped == health.lost,
        "{health:?}"
    );
    let statistics = recording.stop().unwrap();
    // The last one is the end of the journal.
    assert_eq!(statistics.written + statistics.lost, 10_001);
    let reader = Reader::open(&the_one_recording(directory.path())).unwrap();
    assert_eq!(reader.lost_messages(), Some(statistics.lost));
}

/// The program as a user starts it, with its recordings in this directory.
pub fn command(domain: &Domain, directory: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
    command
        .args([
            "run",
            "--ros-args",
            "-p",
            "record.mode:=always",
            "-p",
            "state.directory:=''",
            "-p",
        ])
        .arg(format!("record.directory:={}", directory.display()))
        .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .env_remove("ROS_NAMESPACE")
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command
}

/// The program as a user starts it, while it runs.
pub fn program(domain: &Domain, directory: &Path) -> Child {
    command(domain, directory).spawn().unwrap()
}

pub fn stopped(child: Child) -> (Option<i32>, String) {
    let pid = i32::try_from(child.id()).unwrap();
    let pid = rustix::process::Pid::from_raw(pid).unwrap();
    rustix::process::kill_process(pid, rustix::process::Signal::TERM).unwrap();
    let output = child.wait_with_output().unwrap();
    (
        output.status.code(),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    )
}

pub fn recordings(directory: &Path) -> Vec<PathBuf> {
    let mut found: Vec<_> = std::fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_dir())
        .collect();
    found.sort();
    found
}

#[test]
fn the_recording_of_a_killed_node_is_repaired_at_the_next_start_and_verified() {
    let directory = TempDir::new().unwrap();
    let first = Domain::fresh();
    let mut node = program(&first, directory.path());
    let mut once = reader(&first);
    let reports = Bytes::start(&mut once, &qos::IMPACT_REPORT);
    let outcome = impact(&first, "before", 6.0);
    assert!(
        matches!(outcome, Ok(ImpactOutcome::Forecast(_))),
        "{outcome:?}"
    );
    reports.messages.recv_timeout(PATIENCE).expect("a report");
    drop(reports);
    let outcome = impact(&first, "a", 6.0);
    assert!(
        matches!(outcome, Ok(ImpactOutcome::Forecast(_))),
        "{outcome:?}"
    );
    let cut_off = the_one_recording(directory.path());
    let file_of = |recording: &Path| {
        let name = recording.file_name().unwrap().display();
        recording.join(format!("{name}_0.mcap"))
    };
    // The forecast is published before it is written.
    wait_until_written(directory.path(), "the forecast", |message| {
        let forecast = cdr::decode::<ImpactReport>(&message.data);
        *message.topic == *"/impact_forecast" && forecast.is_ok_and(|it| it.event_id == "a")
    });
    node.kill().unwrap();
    node.wait().unwrap();

    let second = Domain::fresh();
    let node = program(&second, directory.path());
    let mut again = reader(&second);
    let reports = Bytes::start(&mut again, &qos::IMPACT_REPORT);
    let outcome = impact(&second, "b", 6.0);
    assert!(
        matches!(outcome, Ok(ImpactOutcome::Forecast(_))),
        "{outcome:?}"
    );
    reports.messages.recv_timeout(PATIENCE).expect("a report");
    drop(reports);
    let (code, log) = stopped(node);
    assert_eq!(code, Some(0), "{log}");
    assert!(log.contains("were saved"), "{log}");
    let found = recordings(directory.path());
    assert_eq!(found.len(), 3, "{found:?}");
    for path in &found {
        // The original is unchanged: a file without an end, in a directory without metadata.
        let whole = *path != cut_off;
        let file = file_of(path);
        let found = verify(if whole { path } else { &file }).unwrap();
        assert!(found.is_equal(), "{found}");
        assert!(found.compared() > 40, "{found}");
        assert_eq!(found.unchecked.is_empty(), whole, "{found}");
    }
}

#[test]
fn a_recording_that_cannot_start_ends_the_program() {
    let directory = TempDir::new().unwrap();
    let file = directory.path().join("file");
    std::fs::write(&file, "").unwrap();
    let domain = Domain::fresh();
    let output = program(&domain, &file.join("below"))
        .wait_with_output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("record.directory"), "{stderr}");
}
