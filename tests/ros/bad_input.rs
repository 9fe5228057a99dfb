//! Invalid input, by mistake or on purpose: it is rejected or bounded, counted and reported, and the twin continues.

use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::{ColumnParameters, ImpactEvent, TwinStatus};
use column_twin::messages::diagnostic_msgs::DiagnosticArray;
use column_twin::messages::std_msgs;
use column_twin::parameters::Value;
use column_twin::ros::ImpactOutcome;
use column_twin::ros::qos::{self, Endpoint};
use serde::Serialize;

use super::domain::Domain;
use super::live_twin::RunningTwin;
use super::loopback::{Incoming, Outgoing, PATIENCE, event, impact, now, reader};
use super::program::Program;

/// Begins like an event, and then announces a string of 1 GiB that does not follow.
#[derive(Debug, Serialize)]
struct Announcement {
    sec: i32,
    nanosec: u32,
    frame_id_length: u32,
}

/// The counter of this name in the diagnostics.
fn counted(array: &DiagnosticArray, name: &str) -> Option<u64> {
    let mut values = array.status.iter().flat_map(|status| &status.values);
    values.find(|value| value.key == name)?.value.parse().ok()
}

#[test]
fn unreadable_messages_are_counted_and_the_node_continues() {
    let domain = Domain::fresh();
    let twin = RunningTwin::start(&domain, &[]);
    let mut node = reader(&domain);
    let truncated = node
        .publisher::<std_msgs::String>(&qos::IMPACT_EVENT)
        .unwrap();
    let huge = node.publisher::<Announcement>(&qos::IMPACT_EVENT).unwrap();
    let good = node.publisher::<ImpactEvent>(&qos::IMPACT_EVENT).unwrap();
    let other_type = Endpoint {
        type_name: "std_msgs/msg/String",
        name: "impact_event",
        ..qos::IMPACT_EVENT
    };
    let wrong_type = node.publisher::<std_msgs::String>(&other_type).unwrap();
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut node, &qos::DIAGNOSTICS);
    let deadline = Instant::now() + PATIENCE;
    for guid in [truncated.guid(), huge.guid(), good.guid()] {
        assert!(node.matches().wait_for(guid, 1, deadline));
    }
    let text = || std_msgs::String {
        data: "x".to_owned(),
    };
    truncated.publish(text()).unwrap();
    huge.publish(Announcement {
        sec: 1,
        nanosec: 2,
        frame_id_length: 1 << 30,
    })
    .unwrap();
    wrong_type.publish(text()).unwrap();
    good.publish(event("e1", now(), 1500.0, 1.0)).unwrap();
    diagnostics.find("two unreadable messages and an accepted event", |it| {
        // RustDDS 0.15.1 also delivers messages of writers with another type, which are as unreadable as the others.
        counted(it, "unreadable messages").is_some_and(|it| it >= 2)
            && counted(it, "events accepted") == Some(1)
    });
    drop(diagnostics);
    twin.stop();
}

#[test]
fn an_invalid_event_is_rejected_with_the_reason() {
    let domain = Domain::fresh();
    let twin = RunningTwin::start(&domain, &[]);
    let mut node = reader(&domain);
    let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
    let at = |ahead: i64| event("wrong", now() + ahead, 1500.0, 1.0);
    let second = 1_000_000_000;
    let cases: [(ImpactEvent, &str); 11] = [
        (event("wrong", now(), f64::NAN, 1.0), "mass = NaN"),
        (event("wrong", now(), f64::INFINITY, 1.0), "mass = inf"),
        (event("wrong", now(), -5.0, 1.0), "mass = -5"),
        (event("wrong", now(), 1500.0, 0.0), "velocity = 0"),
        (event("wrong", now(), 1500.0, f64::NAN), "velocity = NaN"),
        (
            ImpactEvent {
                gap: f64::NEG_INFINITY,
                ..at(0)
            },
            "gap = -inf",
        ),
        (
            ImpactEvent {
                restitution: 1.5,
                ..at(0)
            },
            "restitution = 1.5",
        ),
        (
            ImpactEvent {
                height: 99.0,
                ..at(0)
            },
            "the column is 4 m high",
        ),
        (at(3600 * second), "s ahead; event.max_ahead is 1 s"),
        (at(-3600 * second), "s old; event.max_age is 5 s"),
        (
            ImpactEvent {
                column_id: "another".to_owned(),
                ..at(0)
            },
            "column_id is \"another\"",
        ),
    ];
    let mut rejected = 0;
    for (wrong, reason) in cases {
        assert!(events.publish(wrong));
        rejected += 1;
        let status = statuses.find(reason, |it| it.events_rejected == rejected);
        assert_eq!(status.last_rejection_event_id, "wrong");
        assert!(
            status.last_rejection_reason.contains(reason),
            "{}",
            status.last_rejection_reason
        );
    }
    // None of them has used the identifier; a second event with the same identifier is rejected.
    for _ in 0..2 {
        assert!(events.publish(at(0)));
    }
    let status = statuses.find("the second one", |it| it.events_rejected == rejected + 1);
    assert_eq!(status.events_accepted, 1);
    assert!(
        status.last_rejection_reason.contains("was accepted before"),
        "{}",
        status.last_rejection_reason
    );
    drop(statuses);
    twin.stop();
}

/// A topic has no reply: the status and `/rosout` contain the reason of the rejection.
#[test]
fn a_rejected_set_of_parameters_is_reported() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let quiet = "-p real_time.priority:=0 -p real_time.lock_memory:=false -p state.directory:=''";
    let arguments: Vec<_> = quiet.split(' ').collect();
    let program = Program::ready(&domain, folder.path(), &arguments);
    let mut node = reader(&domain);
    let sets = Outgoing::<ColumnParameters>::start(&domain, &qos::COLUMN_PARAMETERS);
    let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
    let logs = Incoming::<ros2_client::Log>::start(&mut node, &qos::ROSOUT);
    let own = || ColumnParameters {
        column_id: "column".to_owned(),
        ..ColumnParameters::default()
    };
    let cases = [
        (
            ColumnParameters {
                top_load: -1.0,
                ..own()
            },
            "top.load: `-1.0` is out of range",
        ),
        (
            ColumnParameters {
                top_load: f64::INFINITY,
                ..own()
            },
            "is not a finite number",
        ),
        (
            ColumnParameters {
                support_base: "semi_rigid".to_owned(),
                ..own()
            },
            "support.base",
        ),
        (
            ColumnParameters {
                column_id: "another".to_owned(),
                top_load: 1e5,
                ..own()
            },
            "the message is for column \"another\", but this is the twin of column \"column\"",
        ),
    ];
    for (rejected, (wrong, reason)) in (1..).zip(cases) {
        assert!(sets.publish(wrong));
        let status = statuses.find(reason, |it| it.parameters_rejected == rejected);
        assert!(
            status.last_rejection_reason.contains(reason),
            "{}",
            status.last_rejection_reason
        );
        logs.find(reason, |it| {
            it.msg
                .starts_with("a change of parameters by column_parameters was rejected")
                && it.msg.contains(reason)
        });
    }
    assert!(sets.publish(ColumnParameters {
        top_load: 1e5,
        ..own()
    }));
    statuses.find("a set that is accepted", |it| it.parameters_accepted == 1);
    drop((statuses, logs));
    assert!(program.terminate().0.success());
}

/// Of many rejections, the terminal shows a few and the number of the others.
#[test]
fn rejections_are_limited_on_the_terminal() {
    const FLOOD: u64 = 500;
    /// Fewer than the queue of commands holds.
    const PORTION: u64 = 50;
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let quiet = "-p real_time.priority:=0 -p real_time.lock_memory:=false -p state.directory:=''";
    let arguments: Vec<_> = quiet.split(' ').collect();
    let mut program = Program::ready(&domain, folder.path(), &arguments);
    let mut node = reader(&domain);
    let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
    let begin = Instant::now();
    for number in 1..=FLOOD {
        assert!(events.publish(event(&format!("wrong-{number}"), now(), f64::NAN, 1.0)));
        if number % PORTION == 0 {
            statuses.find("all events so far", |it| it.events_rejected == number);
        }
    }
    // Until the next period of the limit begins.
    let given_up = Instant::now() + PATIENCE;
    let mut number = FLOOD;
    while !program.shows("after the flood", Duration::from_millis(100)) {
        assert!(Instant::now() < given_up, "{:#?}", program.seen);
        number += 1;
        let id = format!("after the flood {number}");
        assert!(events.publish(event(&id, now(), f64::NAN, 1.0)));
    }
    let seconds = begin.elapsed().as_secs();
    let last = program.seen.last().unwrap();
    assert!(
        last.contains("similar messages before this one are not shown"),
        "{last}"
    );
    drop(statuses);
    let (_, _, log) = program.terminate();
    let shown = log
        .iter()
        .filter(|line| line.contains("mass = NaN"))
        .count() as u64;
    println!("{shown} of {FLOOD} rejections shown within {seconds} s");
    assert!(shown <= 20 * (seconds + 2), "{shown} lines");
}

/// Every event is accepted, rejected or counted as dropped, and the twin answers as before.
#[test]
fn ten_thousand_events_in_a_second_are_bounded_and_counted() {
    const FLOOD: u64 = 10_000;
    const BATCH: u64 = 100;
    let domain = Domain::fresh();
    let unlimited = [("senders.max_rate", Value::from(0.0))];
    let twin = RunningTwin::start(&domain, &unlimited);
    let mut node = reader(&domain);
    let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut node, &qos::DIAGNOSTICS);
    let begin = Instant::now();
    let mut sent = 0;
    for batch in 0..FLOOD / BATCH {
        for number in 0..BATCH {
            let id = format!("flood-{}", batch * BATCH + number);
            sent += u64::from(events.publish(event(&id, now(), 1500.0, 1.0)));
        }
        let due = begin + Duration::from_millis(10) * u32::try_from(batch + 1).unwrap();
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
    }
    println!("{sent} of {FLOOD} events sent within {:?}", begin.elapsed());
    // The last status counts what reached the twin, the diagnostics what did not.
    let of = |it: &TwinStatus| it.events_accepted + it.events_rejected + it.dropped_inputs;
    let mut last = TwinStatus::default();
    let mut missed = 0;
    let deadline = Instant::now() + PATIENCE;
    while of(&last) + missed < sent && Instant::now() < deadline {
        let array = diagnostics.next();
        missed = counted(&array, "missed messages").unwrap_or_default();
        last = statuses.newest().unwrap_or(last);
        println!(
            "accepted {}, rejected {}, dropped {}, missed {missed}",
            last.events_accepted, last.events_rejected, last.dropped_inputs
        );
    }
    assert_eq!(of(&last) + missed, sent);
    drop((statuses, diagnostics));
    let outcome = impact(&domain, 1500.0, PATIENCE);
    assert!(
        matches!(outcome, Ok(ImpactOutcome::Forecast(_))),
        "{outcome:?}"
    );
    twin.stop();
}

/// It vanished without a line, and blocked its reliable sender for good.
#[test]
fn an_event_that_is_longer_than_a_message_may_be_is_given_up_and_the_next_one_arrives() {
    let domain = Domain::fresh();
    let twin = RunningTwin::start(&domain, &[]);
    let mut node = reader(&domain);
    let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut node, &qos::DIAGNOSTICS);
    assert!(events.publish(event("before", now(), 10.0, 0.5)));
    statuses.find("the event before", |it| it.events_accepted == 1);
    assert!(events.publish(event(&"x".repeat(5_000_000), now(), 10.0, 0.5)));
    assert!(events.publish(event("behind", now(), 10.0, 0.5)));
    statuses.find("the event behind it", |it| it.event_id == "behind");
    diagnostics.find("a message that was too long", |it| {
        counted(it, "messages that were too long") == Some(1)
    });
    drop((statuses, diagnostics, events));
    twin.stop();
}

/// Events that come faster than they can be taken, for half a minute.
#[test]
#[ignore = "slow: half a minute of flood"]
fn a_flood_of_130_000_events_leaves_the_memory_flat() {
    const FLOOD: u32 = 130_000;
    const BATCH: u32 = 50;
    /// More than the queues and the histories of the endpoints hold.
    const MAX_GROWTH: f64 = 32.0;
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let quiet = "-p real_time.priority:=0 -p real_time.lock_memory:=false -p state.directory:=''";
    let arguments: Vec<_> = quiet.split(' ').collect();
    let program = Program::ready(&domain, folder.path(), &arguments);
    let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    let mut settled = 0.0;
    for batch in 0..FLOOD / BATCH {
        for number in 0..BATCH {
            let id = format!("flood-{}", batch * BATCH + number);
            // A full history rejects it, which is counted by the sender.
            let _ = events.publish(event(&id, now(), 1500.0, 1.0));
        }
        std::thread::sleep(Duration::from_millis(10));
        if batch == FLOOD / BATCH / 4 {
            settled = program.megabytes();
        }
    }
    let grown = program.megabytes() - settled;
    println!("{settled} MB after a quarter, {grown} MB more at the end");
    assert!(grown < MAX_GROWTH, "{grown} MB");
    drop(events);
    let outcome = impact(&domain, 1500.0, PATIENCE);
    assert!(outcome.is_ok(), "{outcome:?}");
    assert!(program.terminate().0.success());
}

/// Events with identifiers that nobody expects: rejected, each with the reason, and the node goes on.
#[test]
fn event_ids_of_100_000_or_control_characters_are_rejected() {
    let domain = Domain::fresh();
    let twin = RunningTwin::start(&domain, &[]);
    let mut node = reader(&domain);
    let events = Outgoing::<ImpactEvent>::start(&domain, &qos::IMPACT_EVENT);
    let statuses = Incoming::<TwinStatus>::start(&mut node, &qos::TWIN_STATUS);
    let cases = [
        ("x".repeat(100_000), "too long"),
        ("a\u{1b}[31mb".to_owned(), "control characters"),
        ("a\nb".to_owned(), "control characters"),
    ];
    for (rejected, (id, reason)) in (1..).zip(cases) {
        assert!(events.publish(event(&id, now(), 1500.0, 1.0)));
        let status = statuses.find(reason, |it| it.events_rejected == rejected);
        let found = &status.last_rejection_reason;
        assert!(found.contains(reason), "{found}");
        let named = &status.last_rejection_event_id;
        assert!(
            named.len() < 1000 && !named.contains(char::is_control),
            "{named:?}"
        );
    }
    drop((statuses, events));
    twin.stop();
}
