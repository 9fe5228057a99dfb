//! A recording that is replayed is received as it was recorded.

use std::thread;
use std::time::Duration;

use column_twin::recording::Reader;
use column_twin::ros::qos;
use column_twin::ros::replay::{
    ReplayCommand, ReplayControls, ReplayError, ReplayOptions, ReplayProgress, Replayed, replay,
};
use column_twin::ros::{Names, Node, RosArguments};

use super::domain::Domain;
use super::node::{Bytes, PATIENCE};
use super::recorded_twin::{Finished, RecordedTwin, event, parameters};

fn recording() -> Finished {
    let mut twin = RecordedTwin::new(parameters());
    twin.hit(event("a", twin.now));
    twin.until_rest();
    twin.finish()
}

#[derive(Default)]
struct Script {
    commands: Vec<ReplayCommand>,
    last: Option<ReplayProgress>,
}

impl ReplayControls for Script {
    fn command(&mut self) -> Option<ReplayCommand> {
        self.commands.pop()
    }

    fn show(&mut self, progress: &ReplayProgress) {
        self.last = Some(*progress);
    }

    fn say(&mut self, line: &str) {
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

/// Replays to a reader of two topics, which are remapped; what it received.
fn received(bag: &Finished, rate: f64, script: &mut Script) -> (Vec<Vec<u8>>, Vec<Vec<u8>>, Replayed) {
    let domain = Domain::fresh();
    let rules = ["replay", "--ros-args", "-r", "/column_state:=/again/column_state", "-r", "/impact_report:=/again/impact_report"];
    let (_, ros) = RosArguments::split(rules.map(std::ffi::OsString::from)).unwrap();
    let mut node = Node::new(&domain.environment, Names::new("/again", "reader", &[]).unwrap()).unwrap();
    let states = Bytes::start(&mut node, &qos::COLUMN_STATE, false);
    let reports = Bytes::start(&mut node, &qos::IMPACT_REPORT, false);
    let options = ReplayOptions { rate, ..options(bag) };
    let replayed = replay(&domain.environment, &ros.remap_rules, &options, script).unwrap();
    let mut all = |of: &Bytes, wanted: usize| -> Vec<Vec<u8>> {
        (0..wanted).map_while(|_| of.messages.recv_timeout(PATIENCE).ok()).map(|it| it.bytes().to_vec()).collect()
    };
    let wanted = recorded(bag, "/column_state").len();
    (all(&states, wanted), all(&reports, 1), replayed)
}

#[test]
fn every_message_arrives_in_order_at_every_rate() {
    let bag = recording();
    for rate in [0.5, 1.0, 10.0] {
        let (states, reports, replayed) = received(&bag, rate, &mut Script::default());
        assert_eq!(states, recorded(&bag, "/column_state"));
        assert_eq!(reports, recorded(&bag, "/impact_report"));
        assert_eq!((replayed.sent, replayed.lost), (states.len() as u64 + 1, 0));
        println!("rate {rate}: lateness {:?}", replayed.lateness);
    }
}

#[test]
fn keys_pause_step_and_end_it() {
    let bag = recording();
    let mut script = Script {
        // The last is taken first.
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
    let options = ReplayOptions { wait_for_readers: Duration::ZERO, ..options(&bag) };
    let replayed = replay(&domain.environment, &[], &options, &mut script).unwrap();
    let last = script.last.unwrap();
    assert!(last.paused && last.rate > 1.0, "{last:?}");
    assert_eq!(replayed.sent, 2, "{last:?}");
}

#[test]
fn it_tells_the_recorded_time_and_begins_again() {
    let bag = recording();
    let domain = Domain::fresh();
    let (environment, span) = (domain.environment.clone(), Reader::open(&bag.path()).unwrap().span().unwrap());
    let mut node = Node::new(&domain.environment, Names::new("/", "reader", &[]).unwrap()).unwrap();
    let clock = Bytes::start(&mut node, &qos::CLOCK, false);
    let states = Bytes::start(&mut node, &qos::COLUMN_STATE, false);
    let options = ReplayOptions {
        clock: Some(1000.0),
        repeat: true,
        topics: vec!["/column_state".to_owned()],
        ..options(&bag)
    };
    struct UntilTold(std::sync::mpsc::Receiver<()>);
    impl ReplayControls for UntilTold {
        fn command(&mut self) -> Option<ReplayCommand> {
            self.0.try_recv().ok().map(|()| ReplayCommand::Stop)
        }
        fn show(&mut self, _: &ReplayProgress) {}
        fn say(&mut self, _: &str) {}
    }
    let (stop, told) = std::sync::mpsc::channel();
    let player = thread::spawn(move || replay(&environment, &[], &options, &mut UntilTold(told)));
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
fn a_wrong_topic_is_said_with_those_that_there_are() {
    let bag = recording();
    let domain = Domain::fresh();
    let options = ReplayOptions { topics: vec!["/nothing".to_owned()], ..options(&bag) };
    let error = replay(&domain.environment, &[], &options, &mut Script::default()).unwrap_err();
    assert!(matches!(error, ReplayError::NoSuchTopic { .. }));
    let said = error.to_string();
    assert!(said.contains("/nothing") && said.contains("/column_state"), "{said}");
}
