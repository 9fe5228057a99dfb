//! Untouched recordings pass the verification, wherever a recorder ends one and begins the next.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use column_twin::column::ImpactSpecification;
use column_twin::endpoints::NodeKind;
use column_twin::evidence::{JournalLine, Topics, Verification, verify_reader};
use column_twin::messages::column_twin_msgs::ColumnParameters;
use column_twin::parameters::{Parameters, RecordMode, Value};
use column_twin::recording::{
    Entry, Message, Reader, RecorderOptions, SealFinding, SealKey, Session,
};
use column_twin::time::Nanos;
use column_twin::twin::{Command, ImpactCommand, RejectionCode};
use tempfile::TempDir;

use super::copies::messages;
use super::recomputed_estimates;
use super::recorded_twin::{MS, RecordedTwin, event, parameters, the_one_recording};
use super::scenarios::{Random, some_impact};
use super::scripted_fleet::ScriptedFleet;

const SECOND: Nanos = 1_000 * MS;
const HOUR: Nanos = 3_600 * SECOND;

/// Everything that a node recorded, in one recording.
struct Recorded {
    messages: Vec<Message>,
    topics: Topics,
}

impl Recorded {
    fn of(directory: &Path, topics: Topics) -> Self {
        let messages = messages(&the_one_recording(directory));
        Self { messages, topics }
    }

    fn of_twin(twin: RecordedTwin) -> Self {
        let finished = twin.finish();
        let messages = messages(&finished.path());
        let topics = Topics::of_default_node(NodeKind::Single);
        Self { messages, topics }
    }
}

/// The recordings of a recorder.
struct Rotated {
    directory: TempDir,
    key: SealKey,
}

/// What a verification of untouched recordings has found.
#[derive(Debug, Default)]
struct Found {
    recordings: u64,
    /// Those in which nothing could be compared: they end before the first checkpoint after a late rotation.
    incomparable: u64,
    late: u64,
    compared: u64,
}

/// Gives everything to a recorder once more, which has limits and a clock of its own: the time when it takes each message.
fn rotated(
    recorded: &Recorded,
    limits: impl FnOnce(RecorderOptions) -> RecorderOptions,
    mut time: impl FnMut(usize, &Message) -> Duration,
) -> Rotated {
    let directory = TempDir::new().expect("a directory");
    let key = SealKey::fresh().expect("random numbers");
    let options = RecorderOptions {
        sync: false,
        seal: Some(key.clone()),
        ..RecorderOptions::new(directory.path(), SystemTime::now())
    };
    let declared = recorded.topics.declared().expect("topics");
    let places: BTreeMap<_, _> = (0..)
        .zip(&declared)
        .map(|(at, it)| (&*it.name, at))
        .collect();
    let mut session = Session::start(limits(options), declared.clone()).expect("starts");
    for (index, message) in recorded.messages.iter().enumerate() {
        let is_line = message.topic.ends_with("/journal");
        let line = is_line.then(|| JournalLine::decode(&message.data).expect("a line"));
        let entry = Entry {
            topic: places[&*message.topic],
            log_time: message.log_time,
            publish_time: message.publish_time,
            data: message.data.clone().into(),
            checkpoint: line.is_some_and(|it| it.is_checkpoint()),
        };
        let now = time(index, message);
        session.tick(now);
        session.take(entry, now);
    }
    session.finish();
    drop(session);
    Rotated { directory, key }
}

impl Rotated {
    fn paths(&self) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(self.directory.path()).expect("readable");
        let mut paths: Vec<_> = entries.map(|it| it.expect("readable").path()).collect();
        paths.sort_by_key(|path| (path.as_os_str().len(), path.clone()));
        paths
    }

    /// As `column-twin verify --require-seal --trusted-key` of every recording.
    fn verify(&self, found: &mut Found, what: &dyn Fn() -> String) -> Vec<Verification> {
        let verify = |path: PathBuf| {
            let reader = Reader::open(&path).expect("readable");
            let seal = SealFinding::of(&reader).with_neighbours(&reader);
            let seal = seal.required(vec![self.key.public_key()]).to_the_end();
            assert_eq!(seal.fault(), None, "{}", what());
            let verified = verify_reader(&reader).expect("can be verified");
            assert!(
                !verified.is_contradicted(),
                "{}, {}: {verified}",
                what(),
                path.display()
            );
            // Nothing can be compared only where all that was under way had begun in an earlier recording.
            assert!(
                !verified.is_unchecked() || reader.repeats_checkpoint(),
                "{}, {}: {verified}",
                what(),
                path.display()
            );
            found.recordings += 1;
            found.incomparable += u64::from(verified.is_unchecked());
            found.late += u64::from(reader.repeats_checkpoint());
            found.compared += verified.compared();
            verified
        };
        self.paths().into_iter().map(verify).collect()
    }
}

fn rotating_after(duration: Duration) -> impl Fn(RecorderOptions) -> RecorderOptions {
    move |options| RecorderOptions {
        max_duration: Some(duration),
        ..options
    }
}

/// The time of a recorder that takes every message at once.
fn at_once(recorded: &Recorded) -> impl Fn(usize, &Message) -> Duration {
    let first = recorded.messages[0].log_time;
    move |_, message| Duration::from_nanos((message.log_time - first).unsigned_abs())
}

/// Few states, so that many verifications take seconds.
fn short_responses() -> Parameters {
    let values = [
        ("publish_rate", Value::from(500.0)),
        ("response.duration", Value::from(0.08)),
    ];
    parameters().with_changes(values).expect("admissible")
}

fn twin_with_mock_clock(parameters: Parameters, mode: RecordMode) -> RecordedTwin {
    let unsynced = |options| RecorderOptions {
        sync: false,
        ..options
    };
    let mut twin = RecordedTwin::with_options(parameters, mode, unsynced);
    twin.follow_mock_clock();
    twin
}

/// A recording that an impact event has begun late was reported as forged: "the line of the journal about the message before
/// is absent", when the second event came.
#[test]
fn an_event_that_begins_a_recording_late_has_its_line_in_the_journal() {
    for mode in [RecordMode::Events, RecordMode::Always] {
        let mut twin = twin_with_mock_clock(short_responses(), mode);
        twin.hit(event("before", twin.now));
        twin.until_rest();
        // Longer than twice the longest duration, and shorter than the time between two checkpoints.
        twin.advance(25 * SECOND);
        for id in ["a", "b"] {
            twin.hit(event(id, twin.now));
            twin.until_rest();
        }
        let recorded = Recorded::of_twin(twin);
        let limits = rotating_after(Duration::from_secs(10));
        let rotated = rotated(&recorded, limits, at_once(&recorded));
        let mut found = Found::default();
        let verified = rotated.verify(&mut found, &|| format!("{mode:?}"));
        assert_eq!((found.recordings, found.late), (2, 1), "{mode:?}");
        let events = &verified[1].inputs_of[0];
        assert_eq!(
            (events.recorded, events.compared),
            (2, 2),
            "{}",
            verified[1]
        );
    }
}

fn fleet_after_two_quiet_hours(mode: RecordMode) -> Recorded {
    let mut fleet = ScriptedFleet::new(4, &short_responses(), mode);
    fleet.hit(0, fleet.event(0, "before"));
    fleet.until_rest();
    (0..24).for_each(|_| fleet.advance(HOUR / 10));
    for (column, id) in [(0, "a"), (1, "b"), (0, "c")] {
        fleet.hit(column, fleet.event(column, id));
        fleet.until_rest();
    }
    Recorded::of(
        fleet.finish().path(),
        Topics::of_default_node(NodeKind::Fleet),
    )
}

/// With the default longest duration.
#[test]
fn a_fleet_that_is_hit_after_two_quiet_hours_begins_a_recording_that_is_verified() {
    for mode in [RecordMode::Events, RecordMode::Always] {
        let recorded = fleet_after_two_quiet_hours(mode);
        let longest = Parameters::default().settings().record.max_duration;
        let limits = rotating_after(Duration::from_secs_f64(longest));
        let rotated = rotated(&recorded, limits, at_once(&recorded));
        let mut found = Found::default();
        let verified = rotated.verify(&mut found, &|| format!("{mode:?}"));
        assert!(found.recordings >= 2, "{mode:?}: {found:?}");
        // Every column is whole in the recording that its hit has begun.
        assert_eq!(found.late, 0, "{mode:?}: {found:?}");
        let last = verified.last().expect("one");
        assert_eq!(last.unchecked, Vec::<String>::new(), "{last}");
        assert_eq!(last.unchecked_messages(), 0, "{last}");
    }
}

/// A parameter set, events twice in a row, events that the node rejects, a reset, and commands that cross on their way.
fn everything_at_once(mode: RecordMode) -> Recorded {
    let mut twin = twin_with_mock_clock(short_responses(), mode);
    let a = event("a", twin.now);
    (0..2).for_each(|_| twin.receive_event(&a));
    (0..2).for_each(|_| twin.execute(Command::Impact(a.clone())));
    (0..6).for_each(|_| twin.advance(MS));
    let (b, c) = (event("b", twin.now), event("c", twin.now));
    [&b, &b, &c]
        .into_iter()
        .for_each(|it| twin.receive_event(it));
    twin.reject(&c, RejectionCode::QueueFull);
    [&b, &b]
        .into_iter()
        .for_each(|it| twin.execute(Command::Impact(it.clone())));
    twin.set_column(&top_load(3e5));
    twin.until_rest();
    twin.advance(2 * SECOND);
    twin.set(&[("top.load", Value::from(2e5))]);
    twin.advance(2 * SECOND);
    let d = event("d", twin.now);
    twin.receive_event(&d);
    twin.reject(&d, RejectionCode::NoAnswer);
    twin.advance(70 * SECOND);
    twin.hit(event("e", twin.now));
    (0..6).for_each(|_| twin.advance(MS));
    twin.reset();
    twin.advance(SECOND);
    twin.hit(event("f", twin.now));
    twin.until_rest();
    Recorded::of_twin(twin)
}

fn top_load(load: f64) -> ColumnParameters {
    ColumnParameters {
        column_id: "column".to_owned(),
        top_load: load,
        ..ColumnParameters::default()
    }
}

/// Two columns that are hit at once, one of them while it moves, a rejected event, a change, a reset, and quiet minutes.
fn everything_in_a_fleet(mode: RecordMode) -> Recorded {
    let mut fleet = ScriptedFleet::new(4, &short_responses(), mode);
    fleet.hit(0, fleet.event(0, "a"));
    fleet.advance(MS);
    let (b, c) = (fleet.event(1, "b"), fleet.event(0, "c"));
    [&b, &c].into_iter().for_each(|it| fleet.receive_event(it));
    fleet.execute(0, Command::Impact(c.clone()));
    fleet.execute(1, Command::Impact(b));
    fleet.receive_event(&c);
    fleet.reject(&c, RejectionCode::QueueFull);
    fleet.until_rest();
    fleet.advance(70 * SECOND);
    let source = || "test".into();
    let changes = vec![("top.load".to_owned(), Value::from(2e5))];
    let set = Command::SetParameters {
        changes,
        source: source(),
    };
    fleet.execute(2, set);
    fleet.advance(SECOND);
    fleet.hit(2, fleet.event(2, "d"));
    (0..6).for_each(|_| fleet.advance(MS));
    fleet.execute(2, Command::Reset { source: source() });
    fleet.hit(1, fleet.event(1, "e"));
    fleet.until_rest();
    fleet.advance(SECOND);
    Recorded::of(
        fleet.finish().path(),
        Topics::of_default_node(NodeKind::Fleet),
    )
}

/// The number of recordings that `COLUMN_TWIN_EXPLORE` asks for.
fn explored() -> Option<u64> {
    let count = std::env::var("COLUMN_TWIN_EXPLORE").ok()?;
    Some(
        count
            .parse()
            .expect("COLUMN_TWIN_EXPLORE is a number of recordings"),
    )
}

/// A recorder that must begin another recording can do so before any message. With `COLUMN_TWIN_EXPLORE` before every message,
/// otherwise before every third one.
#[test]
fn a_recording_may_begin_late_before_any_message() {
    let longest = Duration::from_secs(3600);
    for mode in [RecordMode::Events, RecordMode::Always] {
        for (name, recorded) in [
            ("a twin", everything_at_once(mode)),
            ("a fleet", everything_in_a_fleet(mode)),
        ] {
            let mut found = Found::default();
            let stride = if explored().is_some() { 1 } else { 3 };
            let first = 1 + mode as usize % stride;
            for cut in (first..recorded.messages.len()).step_by(stride) {
                let late = |index, _: &Message| match index < cut {
                    true => Duration::ZERO,
                    false => 2 * longest,
                };
                let rotated = rotated(&recorded, rotating_after(longest), late);
                let topic = &recorded.messages[cut].topic;
                let what = || format!("{name}, {mode:?}, before message {cut}, on {topic}");
                rotated.verify(&mut found, &what);
            }
            // Before a checkpoint a recording is not begun late.
            assert!(found.late > 20, "{found:?}");
            assert!(found.recordings >= 2 * found.late, "{found:?}");
        }
    }
}

/// Measurements and estimates are under way where the next recording begins.
#[test]
fn a_recording_may_begin_late_while_the_sensors_detect_an_impact() {
    let detected = recomputed_estimates::recorded(&[], &|_, _| ());
    let messages = messages(&detected.path());
    let topics = Topics::of_default_node(NodeKind::Single);
    let recorded = Recorded { messages, topics };
    let cuts = if explored().is_some() { 60 } else { 6 };
    let longest = Duration::from_secs(3600);
    let mut found = Found::default();
    for cut in 1..cuts {
        let cut = cut * recorded.messages.len() / cuts;
        let late = |index, _: &Message| match index < cut {
            true => Duration::ZERO,
            false => 2 * longest,
        };
        let rotated = rotated(&recorded, rotating_after(longest), late);
        rotated.verify(&mut found, &|| format!("before message {cut}"));
    }
    assert!(found.late as usize > cuts / 2, "{found:?}");
}

fn scenario(random: &mut Random) -> Recorded {
    let mode = random.of(&[RecordMode::Events, RecordMode::Always]);
    match random.below(3) {
        0 => fleet_scenario(random, mode),
        _ => twin_scenario(random, mode),
    }
}

/// A pause of seconds, minutes or hours.
fn pause(random: &mut Random) -> Nanos {
    let unit = random.of(&[SECOND, SECOND, 10 * SECOND, 60 * SECOND, HOUR]);
    unit * (1 + random.below(7) as Nanos)
}

fn twin_scenario(random: &mut Random, mode: RecordMode) -> Recorded {
    let mut twin = twin_with_mock_clock(short_responses(), mode);
    for id in 0..24 {
        match random.below(16) {
            0..=3 => {
                let impact = some_impact(random, id, twin.now);
                twin.hit(impact);
            }
            4 => {
                let impact = some_impact(random, id, twin.now);
                (0..2).for_each(|_| twin.receive_event(&impact));
                (0..2).for_each(|_| twin.execute(Command::Impact(impact.clone())));
            }
            5 => {
                let impact = some_impact(random, id, twin.now);
                twin.receive_event(&impact);
                twin.reject(
                    &impact,
                    random.of(&[RejectionCode::QueueFull, RejectionCode::NoAnswer]),
                );
            }
            6 => {
                let load = random.of(&[0.0, 1e5, 4e5, 1e9]);
                twin.set(&[("top.load", Value::from(load))]);
            }
            7 => twin.set_column(&top_load(random.of(&[1e5, 2e5, f64::NAN]))),
            8 => twin.reset(),
            9 => twin.jump_back(random.of(&[2 * SECOND, 400 * MS])),
            10 => {
                let contact = twin.now - 3 * MS;
                twin.detect(0, contact, 5.0);
                twin.advance(MS);
                twin.detect(3, contact, 4.0);
            }
            11 => twin.until_rest(),
            12..=13 => {
                twin.until_rest();
                let pause = pause(random);
                let parts = 1 + random.below(9) as Nanos;
                (0..parts).for_each(|_| twin.advance(pause / parts));
            }
            _ => {
                let steps = random.below(30);
                (0..steps).for_each(|_| twin.advance(MS));
            }
        }
    }
    twin.until_rest();
    Recorded::of_twin(twin)
}

fn fleet_scenario(random: &mut Random, mode: RecordMode) -> Recorded {
    let mut fleet = ScriptedFleet::new(5, &short_responses(), mode);
    for id in 0..24 {
        let column = random.below(5) as usize;
        let event = ImpactCommand {
            impact: ImpactSpecification {
                velocity: random.of(&[1.0, 4.0, 7.0, -1.0]),
                ..event("", 0).impact
            },
            ..fleet.event(column, &random.of(&[id, id, 3]).to_string())
        };
        match random.below(12) {
            0..=3 => fleet.hit(column, event),
            4 => {
                fleet.receive_event(&event);
                fleet.reject(&event, RejectionCode::QueueFull);
            }
            5 => {
                let changes = vec![("top.load".to_owned(), Value::from(2e5))];
                let source = "test".into();
                fleet.execute(column, Command::SetParameters { changes, source });
            }
            6 => fleet.execute(
                column,
                Command::Reset {
                    source: "test".into(),
                },
            ),
            7 => fleet.until_rest(),
            8 => {
                fleet.until_rest();
                let pause = pause(random);
                let parts = 1 + random.below(9) as Nanos;
                (0..parts).for_each(|_| fleet.advance(pause / parts));
            }
            _ => {
                let steps = random.below(30);
                (0..steps).for_each(|_| fleet.advance(MS));
            }
        }
    }
    fleet.until_rest();
    Recorded::of(
        fleet.finish().path(),
        Topics::of_default_node(NodeKind::Fleet),
    )
}

/// A recorder with random limits takes everything, at once or with delays.
fn randomly_rotated(random: &mut Random, recorded: &Recorded) -> Rotated {
    let size: usize = recorded.messages.iter().map(|it| it.data.len()).sum();
    let by_size = random.below(2) == 0;
    let by_time = !by_size || random.below(2) == 0;
    let seconds = random.of(&[1, 5, 20, 60, 600, 3600]);
    let parts = random.of(&[2, 5, 12]);
    let limits = |options| RecorderOptions {
        max_duration: by_time.then(|| Duration::from_secs(seconds)),
        max_file_size: match by_size {
            true => (size as u64 / parts).max(60_000),
            false => u64::MAX,
        },
        ..options
    };
    let first = recorded.messages[0].log_time;
    let mut delay = Duration::ZERO;
    rotated(recorded, limits, |_, message| {
        // Every fourth message is written to the file before the next one comes; few wait for long.
        delay += match random.below(400) {
            0 => Duration::from_secs(3 * seconds),
            1..100 => Duration::from_millis(30),
            _ => Duration::ZERO,
        };
        Duration::from_nanos((message.log_time - first).unsigned_abs()) + delay
    })
}

/// Random commands, rotated by size and by time, at checkpoints and late. `COLUMN_TWIN_EXPLORE` is a number of recordings.
#[test]
fn untouched_recordings_pass_whenever_they_are_rotated() {
    let wanted = explored().unwrap_or(150);
    let mut found = Found::default();
    let mut seed = 0;
    while found.recordings < wanted {
        seed += 1;
        let random = &mut Random(seed);
        let recorded = scenario(random);
        for plan in 0..2 {
            let rotated = randomly_rotated(random, &recorded);
            rotated.verify(&mut found, &|| format!("seed {seed}, plan {plan}"));
        }
    }
    println!("{found:?} of {seed} scenarios");
    assert!(found.late > wanted / 20, "{found:?}");
    assert!(found.incomparable < wanted / 4, "{found:?}");
}
