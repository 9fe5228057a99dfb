//! The solver threads of a fleet: the results are those of single twins, bit for bit.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{Duration, Instant};

use column_twin::column::ImpactSpecification;
use column_twin::fleet::make_twins;
use column_twin::live::{
    Clock, FleetHandle, FleetOptions, LiveFleet, MAX_FLEET_COMMANDS, Notifier, RealTime, Receiver,
    SimClock, SystemClock,
};
use column_twin::parameters::{FleetColumn, Parameters, Value};
use column_twin::time::Nanos;
use column_twin::twin::state_file::{self, Loaded};
use column_twin::twin::{
    Command, ImpactCommand, NoticeLevel, Output, RejectionCode, StateOutput, Twin,
};

const START: Nanos = 1_800_000_000_000_000_000;
const MS: Nanos = 1_000_000;

/// Maximum duration of a test.
const DEADLINE: Duration = Duration::from_secs(120);

/// Columns with different loads, whose responses are short.
fn columns(count: usize) -> Vec<FleetColumn> {
    let column = |number: usize| {
        let name = format!("c{number}");
        let values = [
            ("column_id", Value::from(name.as_str())),
            ("solver.dt", Value::from(1e-4)),
            ("response.duration", Value::from(0.2)),
            ("top.load", Value::from(1e5 + 1e4 * number as f64)),
        ];
        FleetColumn {
            name: format!("/{name}"),
            parameters: Arc::new(Parameters::from_values(values).expect("admissible")),
        }
    };
    (0..count).map(column).collect()
}

struct Fleet {
    handle: FleetHandle,
    receiver: Receiver,
    received: BTreeMap<u32, Vec<Output>>,
}

impl Fleet {
    fn start(columns: &[FleetColumn], clock: Arc<dyn Clock>, threads: usize) -> Self {
        let twins = make_twins(columns, &[], || 0, clock.now()).expect("stand");
        let options = FleetOptions {
            real_time: RealTime::none(),
            threads,
            state_files: Vec::new(),
            journals: false,
            further_outputs: Vec::new(),
        };
        let (handle, receiver) = LiveFleet::start(twins, clock, options).expect("starts");
        Self {
            handle,
            receiver,
            received: BTreeMap::new(),
        }
    }

    /// Receives outputs until `done`; `between` is called again and again.
    fn receive(
        &mut self,
        what: &str,
        done: impl Fn(&BTreeMap<u32, Vec<Output>>) -> bool,
        mut between: impl FnMut(),
    ) {
        let given_up = Instant::now() + DEADLINE;
        while !done(&self.received) {
            assert!(Instant::now() < given_up, "no {what}");
            match self.receiver.try_next_of() {
                Some((column, output)) => self.received.entry(column).or_default().push(output),
                None => {
                    between();
                    self.receiver.wait(Duration::from_millis(1));
                }
            }
        }
    }

    fn has(&self, column: u32, is: fn(&Output) -> bool) -> bool {
        self.received
            .get(&column)
            .is_some_and(|it| it.iter().any(is))
    }
}

/// In each of the columns, an output of this kind for each of `count` impacts.
fn of_all(
    columns: u32,
    count: usize,
    is: fn(&Output) -> bool,
) -> impl Fn(&BTreeMap<u32, Vec<Output>>) -> bool {
    move |received| {
        (0..columns).all(|column| {
            let outputs = received.get(&column);
            outputs.is_some_and(|it| it.iter().filter(|it| is(it)).count() >= count)
        })
    }
}

fn is_status(output: &Output) -> bool {
    matches!(output, Output::Status(_))
}

fn is_report(output: &Output) -> bool {
    matches!(output, Output::Report(_))
}

/// A forecast with the error of its time step, after which nothing is left to compute.
fn is_refined(output: &Output) -> bool {
    matches!(output, Output::Forecast(it) if it.error_estimate.is_some())
}

fn impact(column: u32, id: &str, stamp: Nanos) -> Command {
    impact_at(6.0 + f64::from(column), column, id, stamp)
}

/// An impact at this velocity \[m/s\].
fn impact_at(velocity: f64, column: u32, id: &str, stamp: Nanos) -> Command {
    Command::Impact(ImpactCommand {
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
    })
}

/// What of the outputs does not depend on when threads run.
fn bits(outputs: &[Output]) -> Vec<String> {
    let describe = |output: &Output| match output {
        Output::State(StateOutput {
            stamp,
            event_id,
            phase,
            sample,
            ..
        }) => Some(format!("{stamp} {event_id} {phase:?} {sample:?}")),
        Output::Forecast(it) | Output::Report(it) => {
            let kind = if matches!(output, Output::Report(_)) {
                "report"
            } else {
                "forecast"
            };
            Some(format!(
                "{kind} {} {:?} {:?} {:?}",
                it.event_id, it.report, it.assessed, it.error_estimate
            ))
        }
        Output::Withdrawn(it) => Some(format!("{} {:?}", it.impact.event_id, it.end)),
        _ => None,
    };
    let mut lines: Vec<_> = outputs.iter().filter_map(describe).collect();
    // Forecasts come between the states where the threads have them ready.
    lines.sort();
    lines
}

/// The outputs of a single twin without threads.
fn expected(column: &FleetColumn, impacts: &[Command]) -> Vec<Output> {
    let parameters = Parameters::clone(&column.parameters);
    let mut twin = Twin::new(parameters, None, Box::new(|| 0), START).expect("stands");
    let mut out = Vec::new();
    for impact in impacts {
        twin.handle(impact.clone(), START, &mut out)
            .expect("accepted");
    }
    let mut now = START;
    twin.run_ahead(u64::MAX, now, &mut out);
    while twin.is_responding() {
        now += MS;
        twin.advance_to(now, &mut out);
        twin.run_ahead(u64::MAX, now, &mut out);
    }
    out
}

#[test]
fn columns_of_a_fleet_respond_as_single_twins_bit_for_bit() {
    const COLUMNS: u32 = 6;
    let columns = columns(COLUMNS as usize);
    for threads in [1, 3] {
        let clock = Arc::new(SimClock::new(START));
        let mut fleet = Fleet::start(&columns, Arc::clone(&clock) as _, threads);
        let impacts = |column: u32| -> Vec<Command> {
            // The second one meets the moving column.
            let all = [
                impact(column, "first", START),
                impact(column, "second", START + 20 * MS),
            ];
            all[..1 + column as usize % 2].to_vec()
        };
        for column in 0..COLUMNS {
            for impact in impacts(column) {
                fleet.handle.submit(column, impact).expect("room");
            }
        }
        fleet.receive("forecasts", of_all(COLUMNS, 1, is_refined), || {});
        let mut now = START;
        fleet.receive("reports", of_all(COLUMNS, 1, is_report), || {
            now += MS;
            clock.set(now);
        });
        for column in 0..COLUMNS {
            let single = expected(&columns[column as usize], &impacts(column));
            assert_eq!(
                bits(&fleet.received[&column]),
                bits(&single),
                "column {column}, {threads} threads"
            );
        }
        assert!(bits(&fleet.received[&1]).len() > 40);
        fleet.handle.stop().expect("no panic");
    }
}

/// Each column that was hit has the range of its verdict, that of a single twin.
#[test]
fn the_range_of_the_verdict_follows_the_forecast_of_each_column() {
    const COLUMNS: u32 = 3;
    let columns = columns(COLUMNS as usize);
    let clock = Arc::new(SimClock::new(START));
    let mut fleet = Fleet::start(&columns, Arc::clone(&clock) as _, 2);
    for column in 0..COLUMNS {
        let hit = impact(column, "a", START);
        fleet.handle.submit(column, hit).expect("room");
    }
    let is_ranged =
        |output: &Output| matches!(output, Output::Supplemented(it) if it.report.range.is_some());
    let is_told = |output: &Output| matches!(output, Output::Status(it) if it.range.is_some());
    let mut now = START;
    let ranges = of_all(COLUMNS, 1, is_ranged);
    let statuses = of_all(COLUMNS, 1, is_told);
    let all = |received: &BTreeMap<u32, Vec<Output>>| ranges(received) && statuses(received);
    fleet.receive("ranges", all, || {
        now += MS;
        clock.set(now);
    });
    for column in 0..COLUMNS {
        let parameters = Parameters::clone(&columns[column as usize].parameters);
        let mut single = Twin::new(parameters, None, Box::new(|| 0), START).expect("stands");
        let mut out = Vec::new();
        let hit = impact(column, "a", START);
        single.handle(hit, START, &mut out).expect("accepted");
        single.run_ahead(u64::MAX, START, &mut out);
        let opinion = single.opinion_task().expect("awaited").compute();
        let told = single.handle(Command::SecondOpinion(opinion), START, &mut out);
        told.expect("accepted");
        let task = single.range_task().expect("awaited");
        let expected = task.compute(&mut || true);
        let received = &fleet.received[&column];
        let ranged: Vec<_> = received
            .iter()
            .filter_map(|it| match it {
                Output::Supplemented(it) if it.report.range.is_some() => {
                    Some(it.report.range.clone())
                }
                _ => None,
            })
            .collect();
        assert_eq!(ranged, [expected], "column {column}");
        let place = |is: &dyn Fn(&Output) -> bool| received.iter().position(is);
        assert!(
            place(&is_refined) < place(&is_ranged),
            "behind the forecast"
        );
    }
    fleet.handle.stop().expect("no panic");
}

#[test]
fn columns_that_are_hit_at_once_lose_no_state_in_real_time() {
    const COLUMNS: u32 = 10;
    let columns = columns(COLUMNS as usize);
    let clock = Arc::new(SystemClock::new());
    let mut fleet = Fleet::start(&columns, Arc::clone(&clock) as _, 2);
    let stamp = clock.now();
    for column in 0..COLUMNS {
        fleet
            .handle
            .submit(column, impact(column, "a", stamp))
            .expect("room");
    }
    fleet.receive("reports", of_all(COLUMNS, 1, is_report), || {});
    for column in 0..COLUMNS {
        let stamps: Vec<_> = fleet.received[&column]
            .iter()
            .filter_map(|it| match it {
                Output::State(state) => Some(state.stamp),
                _ => None,
            })
            .collect();
        assert!(stamps.len() > 5, "{}", stamps.len());
        assert_eq!(stamps[0], stamp);
        // The last state is where the response ends.
        let spacing: Vec<_> = stamps.windows(2).map(|it| it[1] - it[0]).collect();
        let (_, regular) = spacing.split_last().expect("states");
        assert!(
            regular.iter().all(|it| *it == spacing[0]),
            "column {column}"
        );
        assert!(fleet.has(column, is_refined));
    }
    let statistics = fleet.handle.stop().expect("no panic");
    assert!(
        statistics.queues.iter().all(|it| it.dropped == 0),
        "{:?}",
        statistics.queues
    );
}

/// A thread that found its only column busy watched for a deadline that did not exist yet, and the one that was busy relied on it:
/// the response stood still until the next input.
#[test]
fn a_response_goes_on_when_another_thread_has_looked_in_vain() {
    const ROUNDS: usize = 20;
    /// The column stays elastic [m/s].
    const VELOCITY: f64 = 0.5;
    let columns = columns(1);
    let clock = Arc::new(SystemClock::new());
    let mut fleet = Fleet::start(&columns, Arc::clone(&clock) as _, 2);
    for round in 1..=ROUNDS {
        let hit = impact_at(VELOCITY, 0, &format!("{round}"), clock.now());
        // The repetitions are rejected, but wake the threads while one of them works on the column.
        for _ in 0..8 {
            fleet.handle.submit(0, hit.clone()).expect("room");
        }
        fleet.receive("report", of_all(1, round, is_report), || {});
    }
    fleet.handle.stop().expect("no panic");
}

/// The system clock, which somebody sets.
struct SetClock {
    system: SystemClock,
    /// By how much it was set, and how much of that the threads know \[ns\].
    set_by: AtomicI64,
    known: AtomicI64,
}

impl SetClock {
    fn new() -> Self {
        Self {
            system: SystemClock::new(),
            set_by: AtomicI64::new(0),
            known: AtomicI64::new(0),
        }
    }
}

impl Clock for SetClock {
    fn now(&self) -> Nanos {
        self.system.now() + self.known.load(Ordering::SeqCst)
    }

    fn wait_until(&self, deadline: Nanos, notifier: &Notifier) {
        let known = self.known.load(Ordering::SeqCst);
        let deadline = deadline.saturating_sub(known);
        self.system.wait_for_news(deadline, notifier);
    }

    fn resynchronise(&self) -> bool {
        let set_by = self.set_by.load(Ordering::SeqCst);
        self.known.swap(set_by, Ordering::SeqCst) != set_by
    }
}

/// The first event after the system clock was set was rejected, as too old or too far ahead: an idle fleet did not look at the clock.
#[test]
fn the_first_event_after_the_clock_was_set_is_accepted() {
    const MINUTE: Nanos = 60_000 * MS;
    for set_by in [MINUTE, -MINUTE] {
        let clock = Arc::new(SetClock::new());
        let mut fleet = Fleet::start(&columns(2), Arc::clone(&clock) as _, 1);
        // The columns have begun, and then there is nothing to do.
        fleet.receive("statuses", of_all(2, 1, is_status), || {});
        while fleet.handle.active() > 0 {
            std::thread::park_timeout(Duration::from_millis(1));
        }
        clock.set_by.store(set_by, Ordering::SeqCst);
        let stamp = clock.system.now() + set_by;
        let accepted = fleet.handle.execute(1, impact(1, "a", stamp));
        assert!(accepted.is_ok(), "set by {set_by} ns: {accepted:?}");
        fleet.handle.stop().expect("no panic");
    }
}

/// An idle fleet notices by itself that the clock was set, because other threads use it for their stamps, also while a column
/// remembers an impact.
#[test]
fn an_idle_fleet_follows_the_clock() {
    let clock = Arc::new(SetClock::new());
    let values = [
        ("column_id", Value::from("c0")),
        ("solver.dt", Value::from(1e-4)),
        ("response.duration", Value::from(0.2)),
        ("event.max_age", Value::from(3600.0)),
    ];
    let column = FleetColumn {
        name: "/c0".to_owned(),
        parameters: Arc::new(Parameters::from_values(values).expect("admissible")),
    };
    let mut fleet = Fleet::start(&[column], Arc::clone(&clock) as _, 2);
    let hit = impact(0, "a", clock.now());
    fleet.handle.execute(0, hit).expect("accepted");
    fleet.receive("report", of_all(1, 1, is_report), || {});
    clock.set_by.store(60_000 * MS, Ordering::SeqCst);
    let given_up = Instant::now() + DEADLINE;
    while clock.known.load(Ordering::SeqCst) == 0 {
        assert!(Instant::now() < given_up, "the clock is not looked at");
        std::thread::park_timeout(Duration::from_millis(10));
    }
    fleet.handle.stop().expect("no panic");
}

/// A sender that never pauses filled the memory, and kept the solver threads from all columns while they took its commands.
#[test]
fn a_flood_is_rejected_beyond_the_bound_and_other_columns_go_on() {
    const FLOOD: usize = 50_000;
    let columns = columns(2);
    let clock = Arc::new(SystemClock::new());
    let fleet = Fleet::start(&columns, Arc::clone(&clock) as _, 2);
    let repeated = impact_at(0.5, 0, "a", clock.now());
    let inputs = || fleet.handle.statistics().queues.swap_remove(0);
    let mut rejected = 0;
    for number in 0..FLOOD {
        let submitted = fleet.handle.submit(0, repeated.clone());
        if let Err(rejection) = submitted {
            assert_eq!(rejection.code, RejectionCode::QueueFull);
            rejected += 1;
        }
        if number % 1_000 == 0 {
            assert!(inputs().len <= MAX_FLEET_COMMANDS, "{:?}", inputs());
        }
    }
    println!("{rejected} of {FLOOD} commands rejected");
    assert!(rejected > 0 && inputs().dropped == rejected);
    let given_up = Instant::now() + DEADLINE;
    while inputs().len > 0 {
        assert!(Instant::now() < given_up, "the commands are not executed");
        std::thread::park_timeout(Duration::from_millis(1));
    }
    let other = fleet.handle.execute(1, impact(1, "b", clock.now()));
    assert!(other.is_ok(), "{other:?}");
    fleet.handle.stop().expect("no panic");
}

#[test]
fn a_column_at_rest_has_no_entry_and_knows_its_critical_velocities() {
    let values = [
        ("solver.dt", Value::from(1e-4)),
        ("response.duration", Value::from(0.05)),
    ];
    let columns = super::memory::columns(50, &values);
    let clock = Arc::new(SimClock::new(START));
    let mut fleet = Fleet::start(&columns, Arc::clone(&clock) as _, 2);
    let has_limits =
        |output: &Output| matches!(output, Output::Status(it) if it.critical_velocities.is_some());
    fleet.receive("critical velocities", of_all(50, 1, has_limits), || {});
    let all: Vec<_> = fleet
        .received
        .values()
        .flatten()
        .filter(|it| has_limits(it))
        .collect();
    let limits: Vec<_> = all
        .iter()
        .filter_map(|it| match it {
            Output::Status(it) => it.critical_velocities.clone(),
            _ => None,
        })
        .collect();
    assert!(
        limits.iter().all(|it| Arc::ptr_eq(it, &limits[0])),
        "computed once and shared"
    );
    let given_up = Instant::now() + DEADLINE;
    while fleet.handle.active() > 0 {
        assert!(
            Instant::now() < given_up,
            "{} columns are active",
            fleet.handle.active()
        );
        std::thread::yield_now();
    }
    // After a response, nothing is kept once no event can belong to it any more.
    fleet.handle.submit(7, impact(7, "a", START)).expect("room");
    let mut now = START;
    fleet.receive(
        "a report",
        |it| it[&7].iter().any(is_report),
        || {
            now += MS;
            clock.set(now);
        },
    );
    while fleet.handle.active() > 0 {
        assert!(
            Instant::now() < given_up,
            "{} columns are active",
            fleet.handle.active()
        );
        now += 100 * MS;
        clock.set(now);
        std::thread::yield_now();
    }
    fleet.handle.stop().expect("no panic");
}

#[test]
fn a_jump_of_the_clock_completes_the_response() {
    let columns = columns(2);
    let clock = Arc::new(SimClock::new(START));
    let mut fleet = Fleet::start(&columns, Arc::clone(&clock) as _, 2);
    fleet.handle.submit(0, impact(0, "a", START)).expect("room");
    fleet.receive("a forecast", of_all(1, 1, is_refined), || {});
    clock.set(START + 10 * MS);
    fleet.receive(
        "states",
        |it| {
            it[&0]
                .iter()
                .filter(|it| matches!(it, Output::State(_)))
                .count()
                > 5
        },
        || {},
    );
    clock.set(START - 60_000 * MS);
    fleet.receive("a report", of_all(1, 1, is_report), || {});
    let jumped = |output: &Output| matches!(output, Output::Notice(it) if it.text.contains("jumped back by 60.01 s"));
    assert!(fleet.has(0, jumped));
    fleet.handle.stop().expect("no panic");
}

#[test]
fn rejections_name_their_column_and_a_full_queue_rejects() {
    let columns = columns(2);
    let clock = Arc::new(SimClock::new(START));
    let fleet = Fleet::start(&columns, Arc::clone(&clock) as _, 1);
    let other = fleet
        .handle
        .execute(1, impact(0, "a", START))
        .expect_err("another column");
    assert_eq!(other.code, RejectionCode::OtherColumn);
    fleet
        .handle
        .execute(1, impact(1, "a", START))
        .expect("accepted");
    let again = fleet
        .handle
        .execute(1, impact(1, "a", START))
        .expect_err("the same");
    assert_eq!(again.code, RejectionCode::EventIdRepeated);
    let report = fleet.handle.predict(
        0,
        "",
        &ImpactSpecification {
            mass: 1500.0,
            velocity: 5.0,
            gap: None,
            restitution: None,
            height: None,
            direction: None,
        },
    );
    assert!(report.expect("a prediction").report.max_v1 > 0.0);
    fleet.handle.stop().expect("no panic");
}

#[test]
fn a_stop_saves_the_columns_that_were_hit_and_no_others() {
    let folder = tempfile::tempdir().expect("a folder");
    let directory = folder.path().to_string_lossy().into_owned();
    let columns: Vec<_> = columns(5)
        .into_iter()
        .map(|column| {
            let saved = [("state.directory", Value::from(directory.as_str()))];
            let parameters = column.parameters.with_changes(saved).expect("admissible");
            FleetColumn {
                parameters: Arc::new(parameters),
                ..column
            }
        })
        .collect();
    let paths: Vec<_> = columns
        .iter()
        .map(|it| state_file::path(&it.parameters).expect("a path"))
        .collect();
    let clock = Arc::new(SimClock::new(START));
    let twins = make_twins(&columns, &[], || 0, START).expect("stand");
    let options = FleetOptions {
        real_time: RealTime::none(),
        threads: 2,
        state_files: paths.clone(),
        journals: false,
        further_outputs: Vec::new(),
    };
    let (handle, mut receiver) = LiveFleet::start(twins, clock, options).expect("starts");
    handle.execute(3, impact(3, "a", START)).expect("accepted");
    // The response is under way: its forecast is completed and saved.
    handle.stop().expect("no panic");
    let exist: Vec<_> = paths.iter().map(|it| it.exists()).collect();
    assert_eq!(exist, [false, false, false, true, false]);
    let loaded = state_file::load(&paths[3], &columns[3].parameters).expect("readable");
    let Loaded::Damage(saved) = loaded else {
        panic!("{loaded:?}");
    };
    assert!(saved.plastic_work_since_reset > 0.0);
    let restored = [None, None, None, Some(saved), None];
    let twins = make_twins(&columns, &restored, || 0, START).expect("stand");
    let status = |index: usize| twins[index].status(START);
    assert!(
        status(3).residual_v1 > 0.0 && status(2).residual_v1 == status(2).residual_v1.min(1e-6)
    );
    assert_eq!(status(3).impacts_since_reset, 1);
    let errors = std::iter::from_fn(|| receiver.try_next_of())
        .filter(|(_, it)| matches!(it, Output::Notice(it) if it.level == NoticeLevel::Error && it.text.contains("lost")))
        .count();
    assert_eq!(errors, 0);
}
