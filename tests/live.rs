//! The live twin in its own thread. Tests that depend on exact times use simulated clocks; no test measures time.
// A test may start an unnamed thread and listen without a bound: it ends with the test.
#![allow(clippy::disallowed_methods)]

use column_twin::column::ImpactSpecification;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use column_twin::live::{
    Clock, Grant, Live, LiveHandle, LiveOptions, MAX_CLOCK_STEP_BACK, OutputQueue, RealTime,
    Receiver, SimClock, SystemClock, WhenFull,
};
use column_twin::parameters::{Parameters, Value};
use column_twin::time::Nanos;
use column_twin::twin::state_file::{self, Loaded};
use column_twin::twin::{
    Accepted, Command, ImpactCommand, NoticeLevel, Output, Rejection, RejectionCode, StateOutput,
    Twin,
};

const START: Nanos = 1_800_000_000_000_000_000;
const MS: Nanos = 1_000_000;

/// Maximum duration of a test.
const DEADLINE: Duration = Duration::from_secs(120);

fn parameters() -> Parameters {
    Parameters::from_values([("solver.dt", Value::from(1e-4))]).expect("admissible")
}

fn twin(now: Nanos) -> Twin {
    Twin::new(parameters(), None, Box::new(|| 0), now).expect("the column stands")
}

fn options() -> LiveOptions {
    LiveOptions {
        real_time: RealTime::none(),
        ..LiveOptions::default()
    }
}

fn event(id: &str, stamp: Nanos) -> ImpactCommand {
    ImpactCommand {
        event_id: id.to_owned(),
        column_id: "column".to_owned(),
        stamp,
        vehicle: String::new(),
        impact: ImpactSpecification {
            mass: 1500.0,
            velocity: 10.0,
            gap: None,
            restitution: None,
            height: None,
            direction: None,
        },
    }
}

/// Receives outputs up to the first that satisfies `last`.
fn receive(receiver: &mut Receiver, mut last: impl FnMut(&Output) -> bool) -> Vec<Output> {
    let given_up = Instant::now() + DEADLINE;
    let mut received = Vec::new();
    while Instant::now() < given_up {
        match receiver.try_next() {
            Some(output) => {
                received.push(output);
                if received.last().is_some_and(&mut last) {
                    return received;
                }
            }
            None => receiver.wait(Duration::from_millis(50)),
        }
    }
    panic!("not received: {received:?}");
}

fn states(outputs: &[Output]) -> Vec<&StateOutput> {
    outputs
        .iter()
        .filter_map(|it| match it {
            Output::State(state) => Some(state),
            _ => None,
        })
        .collect()
}

fn is_report(output: &Output) -> bool {
    matches!(output, Output::Report(_))
}

/// The outputs of a twin without threads.
fn expected(event: &ImpactCommand) -> Vec<Output> {
    let mut twin = twin(event.stamp);
    let mut out = Vec::new();
    let _ = twin.handle(Command::Impact(event.clone()), event.stamp, &mut out);
    let mut now = event.stamp;
    while twin.is_responding() {
        now += MS;
        twin.advance_to(now, &mut out);
    }
    out
}

fn check_stream(received: &[Output], event: &ImpactCommand) {
    let values = |outputs: &[Output]| -> Vec<_> {
        states(outputs)
            .iter()
            .map(|it| (it.stamp, it.phase, it.sample))
            .collect()
    };
    assert_eq!(values(received), values(&expected(event)));
    let place = |wanted: fn(&Output) -> bool| received.iter().position(wanted);
    let forecast = place(|it| matches!(it, Output::Forecast(_))).expect("a forecast");
    let last_state = received
        .iter()
        .rposition(|it| matches!(it, Output::State(_)));
    let report = place(is_report).expect("a report");
    assert!(forecast < report && last_state < Some(report));
}

/// One impact left the status of the solver at WARN for good, with 90 overruns although all states had arrived, and a jump by 100 s
/// counted 100 000: what lies between two steps of the clock is not late.
#[test]
fn a_deadline_between_two_steps_of_a_simulated_clock_is_not_an_overrun() {
    let clock = Arc::new(SimClock::new(START));
    let live = Live::start(twin(START), Arc::clone(&clock), options()).expect("starts");
    let mut receiver = live.outputs("ros").expect("the first time");
    live.submit(Command::Impact(event("a", START)))
        .expect("room");
    receive(&mut receiver, |it| matches!(it, Output::Forecast(_)));
    let mut now = START;
    for step in [MS, 10 * MS, 10 * MS, 7 * MS, 10 * MS, 100_000 * MS] {
        now += step;
        clock.set(now);
        // The next step comes when the solver has seen this one, or the response is over.
        receive(&mut receiver, |it| match it {
            Output::State(state) => state.stamp + MS > now,
            other => is_report(other),
        });
    }
    let statistics = live.stop().expect("no panic");
    assert_eq!(statistics.skipped_periods, 0, "{statistics:?}");
    assert_eq!(statistics.overruns, 0, "{statistics:?}");
}

#[test]
fn a_twin_follows_a_simulated_clock() {
    let clock = Arc::new(SimClock::new(START));
    let live = Live::start(twin(START), Arc::clone(&clock), options()).expect("starts");
    let mut receiver = live.outputs("ros").expect("the first time");
    assert!(live.outputs("ros").is_none() && live.outputs("nobody").is_none());
    let event = event("a", START);
    live.submit(Command::Impact(event.clone())).expect("room");
    let mut received = receive(&mut receiver, |it| matches!(it, Output::Forecast(_)));
    // The clock advances in jumps.
    let player = thread::spawn({
        let clock = Arc::clone(&clock);
        move || (1..=200).for_each(|k| clock.set(START + k * 7 * MS))
    });
    received.extend(receive(&mut receiver, is_report));
    player.join().expect("no panic");
    check_stream(&received, &event);
    live.stop().expect("no panic");
}

#[test]
fn a_twin_follows_the_system_clock() {
    let clock = SystemClock::new();
    let now = clock.now();
    let live = Live::start(twin(now), clock, options()).expect("starts");
    let mut receiver = live.outputs("ros").expect("the first time");
    let event = event("a", now);
    live.submit(Command::Impact(event.clone())).expect("room");
    let received = receive(&mut receiver, is_report);
    check_stream(&received, &event);
    let statistics = live.statistics();
    assert!(statistics.cycles > 1 && statistics.newton_iterations > 0);
    // Forecast, background and response share the column without waiting for each other.
    assert_eq!(statistics.contended_locks, 0);
    assert!(live.is_running());
    live.stop().expect("no panic");
}

/// The impact comes while the critical velocities of the undamaged column are computed in the background.
#[test]
fn the_status_has_the_critical_velocities_of_the_damaged_column_and_no_impact_waits_for_them() {
    let clock = SystemClock::new();
    let now = clock.now();
    let live = Live::start(twin(now), clock, options()).expect("starts");
    let mut receiver = live.outputs("ros").expect("the first time");
    let event = event("a", now);
    let predicted = twin(now)
        .snapshot()
        .predict("", "", &event.impact, &|| 0)
        .expect("computed");
    let accepted = live.execute(Command::Impact(event.clone()));
    assert_eq!(accepted, Ok(Accepted::Applied));
    let received = receive(&mut receiver, is_report);
    check_stream(&received, &event);
    let forecasts = received.iter().filter_map(|it| match it {
        Output::Forecast(forecast) => Some(&forecast.report),
        _ => None,
    });
    assert!(forecasts.clone().count() > 0);
    forecasts.for_each(|it| assert_eq!(*it, predicted.report));

    let mut direct = twin(now);
    let _ = direct.handle(Command::Impact(event), now, &mut Vec::new());
    let mut end = now;
    while direct.is_responding() {
        end += MS;
        direct.advance_to(end, &mut Vec::new());
    }
    let task = direct.critical_velocity_task().expect("awaited");
    let expected = task.compute(&mut || true).expect("not abandoned");
    let known = |it: &Output| matches!(it, Output::Status(it) if it.critical_velocities.is_some());
    let received = loop {
        // The thread gets only the time that no other thread wants.
        receiver.wait(Duration::from_millis(100));
        if let Some(found) = std::iter::from_fn(|| receiver.try_next()).find(known) {
            break found;
        }
    };
    let Output::Status(status) = received else {
        unreachable!("it is a status");
    };
    assert_eq!(status.critical_velocities, Some(expected));
    live.stop().expect("no panic");
}

/// The range of the verdict comes behind the forecast, the report or the forecast is given out once more with it, and the status
/// holds it once the column is at rest.
#[test]
fn the_range_of_the_verdict_follows_the_forecast() {
    let clock = SystemClock::new();
    let now = clock.now();
    let live = Live::start(twin(now), clock, options()).expect("starts");
    let mut receiver = live.outputs("ros").expect("the first time");
    let event = event("a", now);
    let accepted = live.execute(Command::Impact(event.clone()));
    assert_eq!(accepted, Ok(Accepted::Applied));
    let mut direct = twin(now);
    let _ = direct.handle(Command::Impact(event), now, &mut Vec::new());
    direct.run_ahead(u64::MAX, now, &mut Vec::new());
    let opinion = direct.opinion_task().expect("awaited").compute();
    let _ = direct.handle(Command::SecondOpinion(opinion), now, &mut Vec::new());
    let task = direct.range_task().expect("awaited");
    let expected = task.compute(&mut || true).expect("not abandoned");

    let (mut forecasts, mut ranged, mut status) = (0, None, None);
    while ranged.is_none() || status.is_none() {
        // The thread gets only the time that no other thread wants.
        receiver.wait(Duration::from_millis(100));
        for output in std::iter::from_fn(|| receiver.try_next()) {
            match output {
                Output::Forecast(it) => {
                    assert_eq!(it.range, None);
                    forecasts += 1;
                }
                Output::Supplemented(it) if it.report.range.is_some() => {
                    assert!(forecasts > 0, "behind the forecast");
                    assert!(ranged.replace(it.report.range).is_none(), "once");
                }
                Output::Status(it) if it.range.is_some() => status = it.range,
                _ => {}
            }
        }
    }
    assert_eq!(ranged.flatten().as_ref(), Some(&expected));
    assert_eq!(status.as_ref(), Some(&expected));
    live.stop().expect("no panic");
}

/// The losses are counted, no report is lost, and another reader loses nothing.
#[test]
fn a_slow_reader_loses_only_its_own_samples() {
    let queue = |name: &str, states, when_full| OutputQueue {
        name: name.to_owned(),
        states,
        others: 100,
        when_full,
    };
    let clock = Arc::new(SimClock::new(START));
    let outputs = vec![
        queue("oldest", 8, WhenFull::DropOldest),
        queue("newest", 8, WhenFull::DropNewest),
        queue("all", 1_000, WhenFull::DropOldest),
    ];
    let options = LiveOptions {
        outputs,
        ..options()
    };
    let live = Live::start(twin(START), Arc::clone(&clock), options).expect("starts");
    let event = event("a", START);
    live.submit(Command::Impact(event.clone())).expect("room");
    let mut all = live.outputs("all").expect("there");
    let mut received = receive(&mut all, |it| matches!(it, Output::Forecast(_)));
    clock.set(START + 1_000 * MS);
    received.extend(receive(&mut all, is_report));
    check_stream(&received, &event);
    let sent = states(&received).len();
    let stamps = |outputs: &[Output]| {
        states(outputs)
            .iter()
            .map(|it| it.stamp)
            .collect::<Vec<_>>()
    };
    let every = stamps(&received);
    for (name, kept) in [("oldest", &every[sent - 8..]), ("newest", &every[..8])] {
        let mut receiver = live.outputs(name).expect("there");
        let late = receive(&mut receiver, is_report);
        assert_eq!(stamps(&late), kept);
        assert!(late.iter().any(|it| matches!(it, Output::Forecast(_))));
        let queues = live.statistics().queues;
        let queue = queues
            .iter()
            .find(|it| it.name == format!("states to {name}"))
            .expect("named");
        assert_eq!(
            (queue.pushed, queue.dropped),
            (sent as u64, sent as u64 - 8)
        );
    }
    live.stop().expect("no panic");
}

fn change(name: &str, value: Value) -> Command {
    Command::SetParameters {
        changes: vec![(name.to_owned(), value)],
        source: "test".into(),
    }
}

#[test]
fn commands_and_predictions_are_answered() {
    let live = Live::start(twin(START), SimClock::new(START), options()).expect("starts");
    assert_eq!(
        live.execute(change("impact.gap", 0.1.into())),
        Ok(Accepted::Applied)
    );
    let rejected = live.execute(change("impact.velocity", (-1.0).into()));
    let Rejection { code, reason } = rejected.expect_err("a velocity below zero");
    assert_eq!(code, RejectionCode::ParametersInvalid);
    assert!(reason.contains("out of range"), "{reason}");
    let impact = ImpactSpecification {
        mass: 1500.0,
        velocity: 10.0,
        gap: None,
        restitution: None,
        height: None,
        direction: None,
    };
    let prediction = live.predict("", "", &impact).expect("a prediction");
    assert_eq!(
        prediction
            .report
            .first_contact_time
            .map(|it| (it * 1e6).round()),
        Some(10_000.0)
    );
    assert!(
        live.predict(
            "",
            "",
            &ImpactSpecification {
                mass: f64::NAN,
                ..impact
            }
        )
        .is_err()
    );
    let reset = Command::Reset {
        source: "test".into(),
    };
    assert_eq!(live.execute(reset), Ok(Accepted::Applied));
    live.stop().expect("no panic");
}

/// `ros2 param get` showed a change while it waited for the end of a response, as if it had been made.
#[test]
fn a_waiting_change_is_not_read_back_before_it_holds() {
    let clock = Arc::new(SimClock::new(START));
    let live = Live::start(twin(START), Arc::clone(&clock), options()).expect("starts");
    let mut receiver = live.outputs("ros").expect("the first time");
    let load = || live.parameters().get("top.load");
    live.submit(Command::Impact(event("a", START)))
        .expect("room");
    receive(&mut receiver, |it| matches!(it, Output::Forecast(_)));
    let waits = live.execute(change("top.load", 4e5.into()));
    assert_eq!(waits, Ok(Accepted::Waiting));
    assert_eq!(load(), Some(Value::from(5e5)));
    let damages = live.execute(change("section.name", "HEB300".into()));
    let code = damages.map_err(|rejection| rejection.code);
    assert_eq!(code, Err(RejectionCode::ColumnDamaged));
    clock.set(START + 1_000 * MS);
    receive(
        &mut receiver,
        |it| matches!(it, Output::ParametersChanged(changed) if changed.change == Accepted::Applied),
    );
    assert_eq!(load(), Some(Value::from(4e5)));
    live.stop().expect("no panic");
}

/// Every event of a flood is either rejected immediately or answered.
#[test]
fn a_flood_of_events_is_bounded_and_counted() {
    let outputs = vec![OutputQueue {
        others: 20_000,
        ..OutputQueue::ros()
    }];
    let options = LiveOptions {
        outputs,
        ..options()
    };
    let live = Live::start(twin(START), SimClock::new(START), options).expect("starts");
    let rejected = (0..10_000)
        .filter(|k| {
            let bad = ImpactCommand {
                impact: ImpactSpecification {
                    velocity: 0.0,
                    ..event(&k.to_string(), START).impact
                },
                ..event(&k.to_string(), START)
            };
            live.submit(Command::Impact(bad)).is_err()
        })
        .count();
    let mut answers = 0;
    let mut receiver = live.outputs("ros").expect("there");
    if rejected < 10_000 {
        receive(&mut receiver, |it| {
            answers += usize::from(matches!(it, Output::Rejected(_)));
            answers == 10_000 - rejected
        });
    }
    let inputs = live.statistics().queues[0].clone();
    assert_eq!((inputs.pushed, inputs.dropped), (10_000, rejected as u64));
    assert_eq!((inputs.capacity, inputs.when_full), (64, WhenFull::Reject));
    let reset = Command::Reset {
        source: "test".into(),
    };
    assert_eq!(live.execute(reset), Ok(Accepted::Applied));
    live.stop().expect("no panic");
}

/// A looped bag does that: the twin once stood still, without a word, until the clock had come back to where it had been.
#[test]
fn a_clock_that_jumps_back_during_a_response_is_noticed_and_the_twin_goes_on() {
    let clock = Arc::new(SimClock::new(START));
    let live = Live::start(twin(START), Arc::clone(&clock), options()).expect("starts");
    let mut receiver = live.outputs("ros").expect("there");
    let first = event("first", START);
    live.submit(Command::Impact(first.clone())).expect("room");
    let mut received = receive(&mut receiver, |it| matches!(it, Output::State(_)));
    clock.set(START + 10 * MS);
    received.extend(receive(
        &mut receiver,
        |it| matches!(it, Output::State(state) if state.stamp == START + 10 * MS),
    ));
    let next_round = START - 30_000 * MS;
    clock.set(next_round);
    // It waits until the response is complete, and is not out of order.
    let second = event("second", next_round);
    live.submit(Command::Impact(second)).expect("room");
    received.extend(receive(&mut receiver, is_report));
    check_stream(&received, &first);
    let is_told = |it: &Output| matches!(it, Output::Notice(notice) if notice.text.contains("jumped back by 30.01 s"));
    assert!(received.iter().any(is_told));
    let begins = |it: &Output| matches!(it, Output::State(state) if &*state.event_id == "second");
    received.extend(receive(&mut receiver, begins));
    assert!(!received.iter().any(|it| matches!(it, Output::Rejected(_))));
    live.stop().expect("no panic");
}

/// The clocks of several computers differ a little: the response waits.
#[test]
fn a_small_step_back_of_the_clock_is_waited_for() {
    let clock = Arc::new(SimClock::new(START));
    let live = Live::start(twin(START), Arc::clone(&clock), options()).expect("starts");
    let mut receiver = live.outputs("ros").expect("there");
    live.submit(Command::Impact(event("a", START)))
        .expect("room");
    clock.set(START + 5 * MS);
    receive(
        &mut receiver,
        |it| matches!(it, Output::State(state) if state.stamp == START + 5 * MS),
    );
    clock.set(START - MAX_CLOCK_STEP_BACK / 2);
    assert!(live.snapshot().is_ok());
    clock.set(START + 6 * MS);
    let received = receive(
        &mut receiver,
        |it| matches!(it, Output::State(state) if state.stamp == START + 6 * MS),
    );
    assert_eq!(states(&received).len(), 1);
    live.stop().expect("no panic");
}

/// Two events back to back once gave 59 forecasts for 80 accepted events.
#[test]
fn every_event_of_a_live_twin_has_a_forecast_or_a_word_why_not() {
    let clock = Arc::new(SystemClock::new());
    let now = clock.now();
    let light = |id: String, stamp| ImpactCommand {
        impact: ImpactSpecification {
            mass: 10.0,
            velocity: 0.5,
            ..event(&id, stamp).impact
        },
        ..event(&id, stamp)
    };
    let live = Live::start(twin(now), Arc::clone(&clock), options()).expect("starts");
    let mut receiver = live.outputs("ros").expect("there");
    let mut told = std::collections::BTreeSet::new();
    for pair in 0..40 {
        for number in ["first", "second"] {
            let event = light(format!("{pair} {number}"), clock.now());
            live.submit(Command::Impact(event)).expect("room");
        }
        // The first event has a report of its own if the second one comes after its response.
        let mut is_over = false;
        receive(&mut receiver, |output| {
            match output {
                Output::Forecast(it) => drop(told.insert(it.event_id.to_string())),
                Output::Withdrawn(it) => drop(told.insert(it.impact.event_id.to_string())),
                Output::Report(_) => is_over = true,
                _ => {}
            }
            is_over && told.len() == 2 * (pair + 1)
        });
    }
    assert_eq!(told.len(), 80);
    live.stop().expect("no panic");
}

fn stopped(live: LiveHandle, path: &std::path::Path) -> Loaded {
    live.stop().expect("no panic");
    state_file::load(path, &parameters()).expect("readable")
}

#[test]
fn a_stop_during_a_response_saves_its_damage() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("column.json");
    let options = LiveOptions {
        state_file: Some(path.clone()),
        ..options()
    };
    let live = Live::start(twin(START), SimClock::new(START), options).expect("starts");
    let event = event("a", START);
    live.submit(Command::Impact(event.clone())).expect("room");
    live.snapshot().expect("an answer: the event was taken");
    let Loaded::Damage(saved) = stopped(live, &path) else {
        panic!("no damage");
    };
    let whole = expected(&event);
    let last = states(&whole).last().expect("some").sample;
    assert_eq!(
        saved.plastic.below.rotation[0],
        last.hinges[0].plastic_rotation
    );
    assert_eq!(saved.impacts_since_reset, 1);
}

/// Under a clock that does not advance, and with a report of what the stop loses.
#[test]
fn a_long_forecast_delays_neither_requests_nor_a_stop() {
    let fine = [
        ("geometry.length_below", Value::from(10.0)),
        ("geometry.length_above", Value::from(10.0)),
        ("solver.dt", Value::from(1e-7)),
        ("response.duration", Value::from(600.0)),
    ];
    let parameters = Parameters::from_values(fine).expect("admissible");
    let twin = Twin::new(parameters, None, Box::new(|| 0), START).expect("the column stands");
    let live = Live::start(twin, SimClock::new(START), options()).expect("starts");
    let mut receiver = live.outputs("ros").expect("there");
    // The contact with the slender column lasts for seconds: tens of millions of steps.
    let heavy = ImpactCommand {
        impact: ImpactSpecification {
            mass: 1e6,
            velocity: 0.01,
            ..event("a", START).impact
        },
        ..event("a", START)
    };
    live.submit(Command::Impact(heavy)).expect("room");
    live.submit(Command::Impact(event("b", START + 500 * MS)))
        .expect("room");
    assert!(live.snapshot().is_ok());
    assert!(live.snapshot().is_ok());
    live.stop().expect("no panic");
    let received = receive(
        &mut receiver,
        |it| matches!(it, Output::Notice(notice) if notice.text.contains("lost by the stop")),
    );
    let Some(Output::Notice(notice)) = received.last() else {
        panic!("no notice");
    };
    assert_eq!(notice.level, NoticeLevel::Error);
    let text = &notice.text;
    assert!(
        text.contains("the damage of impact \"a\"") && text.contains("still to come: \"b\""),
        "{text}"
    );
    assert!(!received.iter().any(|it| matches!(it, Output::Forecast(_))));
}

#[test]
fn a_state_file_that_cannot_be_written_is_reported() {
    let folder = tempfile::tempdir().expect("a folder");
    let occupied = folder.path().join("file");
    std::fs::write(&occupied, "").expect("written");
    let options = LiveOptions {
        state_file: Some(occupied.join("column.json")),
        ..options()
    };
    let live = Live::start(twin(START), SimClock::new(START), options).expect("starts");
    let mut receiver = live.outputs("ros").expect("there");
    let reset = Command::Reset {
        source: "test".into(),
    };
    live.execute(reset).expect("an answer");
    receive(&mut receiver, |it| {
        matches!(it, Output::Notice(notice)
            if notice.level == NoticeLevel::Error && notice.text.contains("cannot be written"))
    });
    assert!(live.statistics().state_file_failures > 0);
    live.stop().expect("no panic");
}

/// The twin runs nevertheless, and the warnings contain a hint.
#[test]
fn denied_real_time_properties_are_warnings() {
    let real_time = RealTime {
        fifo_priority: Some(100),
        processors: vec![100_000],
        lock_memory: false,
    };
    let options = LiveOptions {
        real_time,
        ..options()
    };
    let live = Live::start(twin(START), SimClock::new(START), options).expect("starts");
    let grants = live.statistics().real_time;
    assert_eq!(grants.memory, Grant::NotRequested);
    let warnings: Vec<_> = grants.warnings().collect();
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("SCHED_FIFO not granted") && warnings[0].contains("limits.conf"));
    assert!(warnings[1].contains("no processor 100000"));
    assert!(live.snapshot().is_ok());
    live.stop().expect("no panic");
}
