//! Replayed recordings are received as they were recorded.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use column_twin::endpoints::NodeKind;
use column_twin::evidence::Topics;
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::ColumnState;
use column_twin::recording::{Entry, Reader, Writer, WriterOptions};
use column_twin::ros::qos;
use column_twin::ros::replay::{
    ReplayCommand, ReplayControls, ReplayError, ReplayOptions, ReplayProgress, Replayed, replay,
};
use column_twin::ros::{Names, Node, RosArguments};

use tempfile::TempDir;

use super::domain::{Domain, PATIENCE};
use super::incoming::reader;
use super::node::Bytes;
use super::recorded_twin::{Finished, MS, RecordedTwin, START, event, parameters};

fn recording() -> Finished {
    let mut twin = RecordedTwin::new(parameters());
    twin.hit(event("a", twin.now));
    twin.until_rest();
    twin.finish()
}

#[derive(Default)]
struct Commands {
    commands: Vec<ReplayCommand>,
    last: Option<ReplayProgress>,
}

impl ReplayControls for Commands {
    fn command(&mut self) -> Option<ReplayCommand> {
        self.commands.pop()
    }

    fn show(&mut self, progress: &ReplayProgress) {
        self.last = Some(*progress);
    }

    fn print(&mut self, line: &str) {
        println!("{line}");
    }
}

fn options(bag: &Finished) -> ReplayOptions {
    ReplayOptions {
        bag: bag.path(),
        rate: 1.0,
        repeat: false,
        topics: vec!["column_state".to_owned(), "/impact_report".to_owned()],
        clock: None,
        wait_for_readers: PATIENCE,
    }
}

fn recorded(bag: &Finished, topic: &str) -> Vec<Vec<u8>> {
    let reader = Reader::open(&bag.path()).unwrap();
    let all = reader.messages().map(Result::unwrap);
    let of_topic = all.filter(|it| *it.topic == *topic);
    of_topic.map(|it| it.data).collect()
}

/// Replays to a reader of two remapped topics, and returns what it received.
fn received(
    bag: &Finished,
    rate: f64,
    user: &mut Commands,
) -> (Vec<Vec<u8>>, Vec<Vec<u8>>, Replayed) {
    let domain = Domain::fresh();
    let rules = [
        "replay",
        "--ros-args",
        "-r",
        "/column_state:=/again/column_state",
        "-r",
        "/impact_report:=/again/impact_report",
    ];
    let (_, ros) = RosArguments::split(rules.map(std::ffi::OsString::from)).unwrap();
    let mut node = Node::new(
        &domain.environment,
        Names::new("/again", "reader", &[]).unwrap(),
    )
    .unwrap();
    let states = Bytes::early(&mut node, &qos::COLUMN_STATE);
    let reports = Bytes::early(&mut node, &qos::IMPACT_REPORT);
    let options = ReplayOptions {
        rate,
        ..options(bag)
    };
    let replayed = replay(&domain.environment, &ros.remap_rules, &options, user).unwrap();
    let all = |of: &Bytes, wanted: usize| -> Vec<Vec<u8>> {
        (0..wanted)
            .map_while(|_| of.messages.recv_timeout(PATIENCE).ok())
            .map(|it| it.bytes().to_vec())
            .collect()
    };
    let wanted = recorded(bag, "/column_state").len();
    (all(&states, wanted), all(&reports, 1), replayed)
}

#[test]
fn every_message_arrives_in_order_at_every_rate() {
    let bag = recording();
    for rate in [0.5, 1.0, 10.0] {
        let (states, reports, replayed) = received(&bag, rate, &mut Commands::default());
        assert_eq!(states, recorded(&bag, "/column_state"));
        assert_eq!(reports, recorded(&bag, "/impact_report"));
        assert_eq!((replayed.sent, replayed.lost), (states.len() as u64 + 1, 0));
        println!("rate {rate}: lateness {:?}", replayed.lateness);
    }
}

#[test]
fn keys_pause_step_and_stop_a_replay() {
    let bag = recording();
    let mut user = Commands {
        // Executed from last to first.
        commands: vec![
            ReplayCommand::Stop,
            ReplayCommand::Faster,
            ReplayCommand::Next,
            ReplayCommand::Next,
            ReplayCommand::TogglePause,
        ],
        last: None,
    };
    let domain = Domain::fresh();
    let options = ReplayOptions {
        wait_for_readers: Duration::ZERO,
        ..options(&bag)
    };
    let replayed = replay(&domain.environment, &[], &options, &mut user).unwrap();
    let last = user.last.unwrap();
    assert!(last.paused && last.rate > 1.0, "{last:?}");
    assert_eq!(replayed.sent, 2, "{last:?}");
}

#[test]
fn the_recorded_time_is_published_and_the_replay_repeated() {
    let bag = recording();
    let domain = Domain::fresh();
    let (environment, span) = (
        domain.environment.clone(),
        Reader::open(&bag.path()).unwrap().span().unwrap(),
    );
    let mut node = reader(&domain);
    let clock = Bytes::early(&mut node, &qos::CLOCK);
    let states = Bytes::early(&mut node, &qos::COLUMN_STATE);
    let options = ReplayOptions {
        clock: Some(1000.0),
        repeat: true,
        topics: vec!["/column_state".to_owned()],
        ..options(&bag)
    };
    struct UntilStopped(std::sync::mpsc::Receiver<()>);
    impl ReplayControls for UntilStopped {
        fn command(&mut self) -> Option<ReplayCommand> {
            self.0.try_recv().ok().map(|()| ReplayCommand::Stop)
        }
        fn show(&mut self, _: &ReplayProgress) {}
        fn print(&mut self, _: &str) {}
    }
    let (stop, stopped) = std::sync::mpsc::channel();
    let player =
        thread::spawn(move || replay(&environment, &[], &options, &mut UntilStopped(stopped)));
    let expected = recorded(&bag, "/column_state");
    for message in expected.iter().chain(&expected).chain(&expected) {
        let received = states.messages.recv_timeout(PATIENCE).expect("a state");
        assert_eq!(**received.bytes(), **message);
    }
    let tick = clock.messages.recv_timeout(PATIENCE).expect("a tick");
    let tick: column_twin::messages::rosgraph_msgs::Clock =
        column_twin::messages::cdr::decode(tick.bytes()).unwrap();
    let now = tick.clock.to_nanos().unwrap();
    assert!((span.0..=span.1).contains(&now), "{now} {span:?}");
    stop.send(()).unwrap();
    player.join().unwrap().unwrap();
}

#[test]
fn an_unknown_topic_is_rejected_with_a_list_of_all_topics() {
    let bag = recording();
    let domain = Domain::fresh();
    let options = ReplayOptions {
        topics: vec!["/nothing".to_owned()],
        ..options(&bag)
    };
    let error = replay(&domain.environment, &[], &options, &mut Commands::default()).unwrap_err();
    assert!(matches!(error, ReplayError::NoSuchTopic { .. }));
    let text = error.to_string();
    assert!(
        text.contains("/nothing") && text.contains("/column_state"),
        "{text}"
    );
}

/// Writes one state per millisecond.
fn written(directory: &Path, count: i64) -> (PathBuf, Vec<i64>) {
    let path = directory.join(format!("states_{count}"));
    let declared = Topics::of_default_node(NodeKind::Single)
        .declared()
        .unwrap();
    let topic = declared
        .iter()
        .position(|it| it.name == "/column_state")
        .unwrap();
    let mut writer = Writer::create(&path, &WriterOptions::default(), &declared).unwrap();
    let times: Vec<_> = (0..count).map(|index| START + index * MS).collect();
    for (index, time) in times.iter().enumerate() {
        let mut state = ColumnState {
            v1: 1e-3 * index as f64,
            column_id: "column".to_owned(),
            event_id: "a".to_owned(),
            ..ColumnState::default()
        };
        state.header.stamp = Time::from_nanos(*time).unwrap();
        let entry = Entry {
            topic,
            log_time: *time,
            publish_time: *time,
            data: cdr::encode(&state).unwrap().into(),
            checkpoint: false,
        };
        writer.write(&entry).unwrap();
    }
    writer.finish().unwrap();
    (path, times)
}

fn interop(file: &str) -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    tests.join("interop").join(file)
}

/// The Python interpreter of the environment for interoperability tests, which is built if necessary.
fn python() -> PathBuf {
    let output = Command::new(interop("environment.sh")).output().unwrap();
    assert!(output.status.success(), "environment.sh: {}", output.status);
    let environment = String::from_utf8(output.stdout).unwrap();
    Path::new(environment.trim()).join("bin/python")
}

/// Prints the measured timing, without a limit for this machine.
#[test]
#[ignore = "slow: builds the Python environment of tests/interop, and replays ten times slower"]
fn rclpy_receives_all_in_order_at_a_tenth_one_and_ten() {
    let python = python();
    for (rate, count) in [(0.1, 1_000), (1.0, 5_000), (10.0, 5_000)] {
        let directory = TempDir::new().unwrap();
        let (bag, times) = written(directory.path(), count);
        let v1: Vec<_> = (0..count).map(|index| 1e-3 * index as f64).collect();
        let expected =
            serde_json::json!({ "rate": rate, "log_times": times, "stamps": times, "v1": v1 });
        let path = directory.path().join("expected.json");
        std::fs::write(&path, expected.to_string()).unwrap();
        let domain = Domain::fresh();
        let reader = Command::new(&python)
            .arg(interop("replay_with_rclpy.py"))
            .arg(&path)
            .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
            .env_remove("_ROS_WHEELS_BOOTSTRAP_COMPLETE")
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let options = ReplayOptions {
            bag,
            rate,
            repeat: false,
            topics: vec!["/column_state".to_owned()],
            clock: None,
            wait_for_readers: PATIENCE,
        };
        let replayed =
            replay(&domain.environment, &[], &options, &mut Commands::default()).unwrap();
        let [half, most, worst] = replayed.lateness.unwrap().map(|it| 1e3 * it);
        println!(
            "rate {rate}: delay: median {half:.3} ms, 99th percentile {most:.3} ms, maximum {worst:.3} ms"
        );
        let output = reader.wait_with_output().unwrap();
        print!("{}", String::from_utf8_lossy(&output.stdout));
        assert!(output.status.success(), "{}", output.status);
        assert_eq!((replayed.sent, replayed.lost), (count as u64, 0));
    }
}

/// States and a text in a directory of rosbag2, written by another program.
#[test]
#[ignore = "slow: builds the Python environment of tests/interop"]
fn a_recording_of_another_program_is_replayed() {
    let directory = TempDir::new().unwrap();
    let bag = directory.path().join("foreign");
    let written = Command::new(python())
        .arg(interop("write_recording.py"))
        .arg(&bag)
        .env_remove("_ROS_WHEELS_BOOTSTRAP_COMPLETE")
        .output()
        .unwrap();
    let fault = String::from_utf8_lossy(&written.stderr);
    assert!(written.status.success(), "{fault}");
    let domain = Domain::fresh();
    let mut node = reader(&domain);
    let states = Bytes::early(&mut node, &qos::COLUMN_STATE);
    let options = ReplayOptions {
        bag: bag.clone(),
        rate: 1.0,
        repeat: false,
        topics: Vec::new(),
        clock: None,
        // The texts have no reader, so that the replay starts after this time.
        wait_for_readers: Duration::from_secs(2),
    };
    let mut user = Commands::default();
    let environment = domain.environment.clone();
    let player = thread::spawn(move || replay(&environment, &[], &options, &mut user));
    let replayed = player.join().unwrap().unwrap();
    assert_eq!((replayed.sent, replayed.lost), (600, 0));
    let reader = Reader::open(&bag).unwrap();
    let written: Vec<_> = reader
        .messages()
        .map(Result::unwrap)
        .filter(|it| *it.topic == *"/column_state")
        .map(|it| cdr::decode::<ColumnState>(&it.data).unwrap())
        .collect();
    assert_eq!(written.len(), 500);
    // The first states may have been published before the reader was discovered.
    let mut received: Vec<ColumnState> = Vec::new();
    states.find("the last state", |it| {
        received.push(cdr::decode(it.bytes()).unwrap());
        received.last() == written.last()
    });
    assert!(received.len() > 100, "{}", received.len());
    assert_eq!(
        format!("{:?}", &written[500 - received.len()..]),
        format!("{received:?}")
    );
}
