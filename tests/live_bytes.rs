//! What live columns send and record under a simulated clock, byte for byte: the digests in `tests/data/live_bytes_*.txt` come from the
//! program of version 0.2, which had one engine for a single twin and another one for a fleet.
//!
//! The two engines and their nodes had drifted apart in nine cases. That there is one of each now changed no digest here, because what
//! differed was what a node makes of the outputs, or no bytes at all:
//! - in `/diagnostics`, a fleet said that its solvers had made 0 steps and 0 Newton iterations;
//! - in `twin_status`, `dropped_viewer` of a fleet was always 0;
//! - on `/parameter_events`, only a single twin announced its parameters at the start;
//! - on `/rosout`, a fleet did not name the engineer whose calibration or decision it rejected, nor say which parameters wait for the
//!   end of a response, nor their old and new values, nor the latency; a single twin said that outputs which it could not publish
//!   before its end were recorded, even without a recording;
//! - a fleet computed ahead in longer slices and without a bound on the share of the background, which is a matter of time alone;
//! - the viewer of a fleet did not show measured beside predicted readings.
//!
//! `UPDATE_BYTES=1 cargo test --release --test live_bytes` writes them again, in a commit that says why they change.
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;
use std::time::{Duration, Instant};

use column_twin::column::ImpactSpecification;
use column_twin::fleet::make_twins;
use column_twin::live::{
    FleetHandle, FleetOptions, Live, LiveFleet, LiveHandle, LiveOptions, RealTime, Receiver,
    SimClock,
};
use column_twin::outgoing::Outgoing;
use column_twin::parameters::{FleetColumn, Parameters, Value};
use column_twin::time::Nanos;
use column_twin::twin::{Command, ImpactCommand, Output, Twin};
use sha2::{Digest, Sha256};

const START: Nanos = 1_800_000_000_000_000_000;
const MS: Nanos = 1_000_000;

/// Maximum duration of a wait.
const DEADLINE: Duration = Duration::from_secs(120);

const COLUMNS: u32 = 12;

/// The columns of the fleet that are hit.
const HIT: [u32; 3] = [0, 5, 11];

fn parameters(column: u32) -> Arc<Parameters> {
    let values = [
        ("column_id", Value::from(format!("c{column}").as_str())),
        ("solver.dt", Value::from(1e-4)),
        ("response.duration", Value::from(0.2)),
        ("top.load", Value::from(2e5 + 1e5 * f64::from(column % 2))),
    ];
    Arc::new(Parameters::from_values(values).expect("admissible"))
}

fn impact(column: u32, id: &str, stamp: Nanos, velocity: f64) -> ImpactCommand {
    ImpactCommand {
        event_id: id.to_owned(),
        column_id: format!("c{column}"),
        stamp,
        vehicle: String::new(),
        impact: ImpactSpecification {
            mass: 1500.0,
            velocity,
            gap: None,
            restitution: None,
            height: None,
            direction: None,
        },
    }
}

enum Engine {
    Single(LiveHandle),
    Fleet(FleetHandle),
}

impl Engine {
    fn execute(&self, column: u32, command: Command) {
        // A rejection is among the outputs.
        let _ = match self {
            Self::Single(live) => live.execute(command),
            Self::Fleet(fleet) => fleet.execute(column, command),
        };
    }

    /// Waits until the column has done what the clock asks for. The engine answers at most eight questions before that.
    fn settle(&self, column: u32) {
        for _ in 0..9 {
            match self {
                Self::Single(live) => drop(live.snapshot().expect("an answer")),
                Self::Fleet(fleet) => {
                    let _ = fleet.check_impact(column, impact(column, "", 0, 0.0));
                }
            }
        }
    }
}

/// The course of a run: the digests of what was given out, by column and topic.
struct Run {
    engine: Engine,
    receiver: Receiver,
    clock: Arc<SimClock>,
    now: Nanos,
    converters: Vec<Outgoing>,
    digests: BTreeMap<(u32, String), (u64, Sha256)>,
    newest: BTreeMap<u32, Vec<Output>>,
}

impl Run {
    fn new(engine: Engine, receiver: Receiver, clock: Arc<SimClock>, columns: u32) -> Self {
        let converters = (0..columns).map(|it| Outgoing::new(&parameters(it)));
        Self {
            engine,
            receiver,
            clock,
            now: START,
            converters: converters.collect(),
            digests: BTreeMap::new(),
            newest: BTreeMap::new(),
        }
    }

    fn single() -> Self {
        let clock = Arc::new(SimClock::new(START));
        let twin = Twin::new(parameters(0), None, Box::new(|| 0), START).expect("stands");
        let options = LiveOptions {
            real_time: RealTime::none(),
            ..LiveOptions::default()
        };
        let live = Live::start(twin, Arc::clone(&clock), options).expect("starts");
        let receiver = live.outputs("ros").expect("the first time");
        Self::new(Engine::Single(live), receiver, clock, 1)
    }

    fn fleet() -> Self {
        let clock = Arc::new(SimClock::new(START));
        let column = |column| FleetColumn {
            name: format!("/c{column}"),
            parameters: parameters(column),
        };
        let columns: Vec<_> = (0..COLUMNS).map(column).collect();
        let twins = make_twins(&columns, &[], || 0, START).expect("stand");
        let options = FleetOptions {
            real_time: RealTime::none(),
            threads: 2,
            state_files: Vec::new(),
            journals: true,
            further_outputs: Vec::new(),
        };
        let (fleet, receiver) =
            LiveFleet::start(twins, Arc::clone(&clock) as _, options).expect("starts");
        Self::new(Engine::Fleet(fleet), receiver, clock, COLUMNS)
    }

    fn add(&mut self, column: u32, topic: &str, bytes: &[u8]) {
        let key = (column, topic.to_owned());
        let (count, digest) = self.digests.entry(key).or_default();
        *count += 1;
        digest.update(bytes);
    }

    fn drain(&mut self) {
        while let Some((column, output)) = self.receiver.try_next_of() {
            let mut messages = Vec::new();
            self.converters[column as usize].convert(&output, |it| messages.push(it));
            for message in messages {
                let bytes = message.encode().expect("bytes");
                self.add(column, message.topic().endpoint().name, &bytes);
            }
            let text = match &output {
                Output::Journal(entry) => {
                    let line = serde_json::to_string(entry).expect("plain data");
                    Some(("journal", line))
                }
                Output::Notice(notice) => Some(("log", format!("{notice:?}"))),
                Output::Rejected(rejected) => Some(("rejections", format!("{rejected:?}"))),
                Output::ParametersChanged(it) => {
                    let text = format!(
                        "{} {:?} {:?} {:?}",
                        it.stamp, it.names, it.change, it.waiting
                    );
                    Some(("changes", text))
                }
                _ => None,
            };
            if let Some((topic, text)) = text {
                self.add(column, topic, text.as_bytes());
            }
            self.newest.entry(column).or_default().push(output);
        }
    }

    /// Lets all of these columns work, without a step of the clock, until each has given this out since the last step.
    fn until(&mut self, columns: &[u32], what: &str, is: fn(&Output) -> bool) {
        let given_up = Instant::now() + DEADLINE;
        loop {
            for column in columns {
                self.engine.settle(*column);
            }
            self.drain();
            let has = |it| self.newest.get(it).is_some_and(|all| all.iter().any(is));
            if columns.iter().all(has) {
                return;
            }
            assert!(Instant::now() < given_up, "no {what}");
            // What is computed in the background gets only the time that no other thread wants.
            self.receiver.wait(Duration::from_millis(5));
        }
    }

    fn step(&mut self, columns: &[u32], nanos: Nanos) {
        self.newest.clear();
        self.now += nanos;
        self.clock.set(self.now);
        for column in columns {
            self.engine.settle(*column);
        }
        self.drain();
    }

    fn execute(&mut self, columns: &[u32], command: impl Fn(u32) -> Command) {
        self.newest.clear();
        for column in columns {
            self.engine.execute(*column, command(*column));
            self.engine.settle(*column);
        }
    }

    /// An impact, another one that meets the moving column, changes that wait, a reset.
    fn play(mut self, all: &[u32], hit: &[u32]) -> String {
        let knows_velocities =
            |it: &Output| matches!(it, Output::Status(it) if it.critical_velocities.is_some());
        // Behind the second opinion.
        let is_ranged =
            |it: &Output| matches!(it, Output::Supplemented(it) if it.report.range.is_some());
        // With the error of the time step, after which nothing is left to compute ahead.
        let is_refined =
            |it: &Output| matches!(it, Output::Forecast(it) if it.error_estimate.is_some());
        let is_report = |it: &Output| matches!(it, Output::Report(_));
        self.until(all, "critical velocities", knows_velocities);
        for _ in 0..5 {
            self.step(all, 500 * MS);
        }
        let now = self.now;
        self.execute(hit, |it| {
            Command::Impact(impact(it, "first", now, 6.0 + f64::from(it) / 4.0))
        });
        self.until(hit, "first range", is_ranged);
        for _ in 0..20 {
            self.step(hit, MS);
        }
        let now = self.now;
        self.execute(hit, |it| {
            Command::Impact(impact(it, "second", now - MS / 2, 2.0))
        });
        self.until(hit, "second forecast", is_refined);
        self.execute(hit, |it| Command::Impact(impact(it, "second", now, 2.0)));
        self.execute(hit, |_| Command::SetParameters {
            changes: vec![("top.load".to_owned(), 2.5e5.into())],
            source: "test".into(),
        });
        let given_up = Instant::now() + DEADLINE;
        let mut left: Vec<u32> = hit.to_vec();
        while !left.is_empty() {
            assert!(Instant::now() < given_up, "no report of {left:?}");
            self.step(hit, MS);
            let over = |it: &u32| {
                self.newest
                    .get(it)
                    .is_some_and(|all| all.iter().any(is_report))
            };
            let over: Vec<u32> = left.iter().copied().filter(over).collect();
            left.retain(|it| !over.contains(it));
            if !over.is_empty() {
                self.until(&over, "critical velocities with damage", knows_velocities);
            }
        }
        for _ in 0..4 {
            self.step(all, 700 * MS);
        }
        self.execute(hit, |_| Command::Reset {
            source: "test".into(),
        });
        self.until(hit, "critical velocities after a reset", knows_velocities);
        match self.engine {
            Engine::Single(live) => drop(live.stop().expect("no panic")),
            Engine::Fleet(fleet) => drop(fleet.stop().expect("no panic")),
        }
        let mut text = String::new();
        for ((column, topic), (count, digest)) in self.digests {
            let digest = digest.finalize();
            let hex: String = digest[..8].iter().map(|it| format!("{it:02x}")).collect();
            let _ = writeln!(text, "c{column} {topic} {count} {hex}");
        }
        text
    }
}

fn path(name: &str) -> String {
    let root = env!("CARGO_MANIFEST_DIR");
    format!("{root}/tests/data/live_bytes_{name}.txt")
}

/// Compares what a run has given out with the lines of `tests/data`.
fn check(name: &str, found: &str) {
    let path = path(name);
    if std::env::var_os("UPDATE_BYTES").is_some() {
        std::fs::write(&path, found).expect("written");
    }
    let expected = std::fs::read_to_string(&path).expect("readable");
    let (found, expected): (Vec<_>, Vec<_>) = (found.lines().collect(), expected.lines().collect());
    assert_eq!(found, expected);
}

#[test]
fn a_single_twin_gives_out_the_same_bytes_as_before() {
    check("single", &Run::single().play(&[0], &[0]));
}

#[test]
fn a_fleet_gives_out_the_same_bytes_as_before() {
    let all: Vec<u32> = (0..COLUMNS).collect();
    check("fleet", &Run::fleet().play(&all, &HIT));
}

/// The journal of a single twin begins with the program, and that of a column of a fleet with the checkpoint before its first command.
/// The joint states and the markers that follow a checkpoint are not thinned out.
#[test]
fn a_column_of_a_fleet_gives_out_what_a_single_twin_does_but_for_the_checkpoints() {
    let read = |name| std::fs::read_to_string(path(name)).expect("readable");
    let (single, fleet) = (read("single"), read("fleet"));
    let of_fleet: Vec<_> = fleet.lines().filter(|it| it.starts_with("c0 ")).collect();
    assert_eq!(of_fleet.len(), single.lines().count());
    let others = single.lines().filter(|it| !of_fleet.contains(it));
    let topics: Vec<_> = others.filter_map(|it| it.split(' ').nth(1)).collect();
    assert_eq!(topics, ["joint_states", "journal", "markers"]);
}
