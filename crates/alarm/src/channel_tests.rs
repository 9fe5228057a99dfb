use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use super::*;
use crate::message::State;
use crate::sender::{SendFault, Turns};

type Told = Arc<Mutex<Vec<(Importance, String)>>>;

fn time(seconds: u64) -> SystemTime {
    UNIX_EPOCH + Duration::from_secs(1_800_000_000 + seconds)
}

fn rules() -> Rules {
    Rules::none()
        .with("action", 2)
        .with("sensor_failed", 1)
        .with(NODE_STOPPED, 1)
}

fn open(folder: &Path) -> Channel {
    open_telling(folder).0
}

fn open_telling(folder: &Path) -> (Channel, Told) {
    let told = Told::default();
    let kept = Arc::clone(&told);
    let notices: Notices = Arc::new(move |importance, text| {
        kept.lock().unwrap().push((importance, text));
    });
    let channel = Channel::open("mqtt", "twin", folder, rules(), notices, time(0)).unwrap();
    (channel, told)
}

fn condition(kind: &str, subject: &str, rank: u8, cause: &str) -> Condition {
    Condition {
        watched: Watched {
            kind: kind.to_owned(),
            subject: subject.to_owned(),
            part: None,
        },
        level: Level::new(rank, format!("level {rank}")),
        reason: "A reason.".to_owned(),
        cause: cause.to_owned(),
        time: time(1),
    }
}

/// Delivers everything that waits.
fn deliver(channel: &mut Channel) -> Vec<Message> {
    let mut delivered = Vec::new();
    while let Next::Send(it) = channel.next(Duration::from_secs(1 << 20)) {
        channel.delivered(it.number);
        delivered.push(it.message);
    }
    delivered
}

fn states(messages: &[Message]) -> Vec<(&str, State)> {
    let pairs = messages
        .iter()
        .map(|it| (it.watched.kind.as_str(), it.state));
    pairs.collect()
}

#[test]
fn an_alarm_is_raised_updated_and_cleared_once_also_across_restarts() {
    let folder = tempfile::tempdir().unwrap();
    let mut channel = open(folder.path());
    for (rank, cause) in [(1, "e1"), (2, "e1"), (2, "e1"), (3, "e1"), (3, "e2")] {
        channel.observe(&[condition("action", "a3", rank, cause)]);
    }
    let told = deliver(&mut channel);
    let states: Vec<State> = told.iter().map(|it| it.state).collect();
    assert_eq!(states, [State::Raised, State::Updated, State::Updated]);
    assert_eq!(
        told.iter()
            .map(|it| &it.alarm)
            .collect::<BTreeSet<_>>()
            .len(),
        1
    );
    assert_eq!(
        told.iter().map(|it| &it.id).collect::<BTreeSet<_>>().len(),
        3
    );
    channel.stops("Stopped by a test.", time(2));
    deliver(&mut channel);
    drop(channel);

    let mut channel = open(folder.path());
    channel.observe(&[condition("action", "a3", 3, "e2")]);
    channel.observe(&[condition("action", "a3", 0, "reset")]);
    channel.observe(&[condition("action", "a3", 0, "reset")]);
    let after = deliver(&mut channel);
    let states: Vec<_> = after
        .iter()
        .map(|it| (it.watched.kind.as_str(), it.state))
        .collect();
    assert_eq!(
        states,
        [(NODE_STOPPED, State::Cleared), ("action", State::Cleared)]
    );
    assert_eq!(after[1].alarm, told[0].alarm);
}

#[test]
fn a_kill_is_told_after_the_next_start_with_the_id_of_the_will() {
    let folder = tempfile::tempdir().unwrap();
    let mut channel = open(folder.path());
    let will = channel.will().unwrap();
    assert_eq!(deliver(&mut channel), []);
    // Dropped without `stops`, as by a kill.
    drop(channel);
    let mut channel = open(folder.path());
    let told = deliver(&mut channel);
    assert_eq!(told[0], will);
    assert_eq!(
        states(&told),
        [
            (NODE_STOPPED, State::Raised),
            (NODE_STOPPED, State::Cleared)
        ]
    );
    assert_eq!(told[1].alarm, will.alarm);
    assert_ne!(channel.will().unwrap().id, will.id);
}

#[test]
fn a_receiver_that_is_away_for_an_hour_has_every_alarm_afterwards_in_order_and_is_not_flooded() {
    let folder = tempfile::tempdir().unwrap();
    let channel = Mutex::new(open(folder.path()));
    let mut turns = Turns::new();
    let (mut now, mut attempts, mut raised) = (Duration::ZERO, 0, 0_u32);
    let mut ids = BTreeSet::new();
    let hour = Duration::from_secs(3600);
    while now < hour {
        let mut away = |message: &Message| {
            attempts += 1;
            ids.insert(message.id.clone());
            Err(SendFault::Away("no route".to_owned(), None))
        };
        let next = turns.turn(&channel, now, false, &mut away);
        assert!(
            next > now,
            "a receiver that is away is not asked twice at once"
        );
        now = next.min(now + Duration::from_secs(30));
        let subject = format!("column {raised}");
        raised += 1;
        channel
            .lock()
            .unwrap()
            .observe(&[condition("action", &subject, 3, "e")]);
    }
    // 0.5 s, 1 s, ... 32 s, then every minute.
    assert!((60..=70).contains(&attempts), "{attempts}");
    assert_eq!(ids.len(), 1, "an attempt is repeated with its id");
    let mut arrived = Vec::new();
    while channel.lock().unwrap().statistics().waiting > 0 {
        let mut take = |message: &Message| {
            arrived.push(message.clone());
            Ok(())
        };
        now = turns.turn(&channel, now, false, &mut take);
    }
    assert!(now <= hour + Duration::from_secs(90), "{now:?}");
    let subjects: Vec<String> = arrived
        .iter()
        .map(|it| it.watched.subject.clone())
        .collect();
    let expected: Vec<String> = (0..raised).map(|it| format!("column {it}")).collect();
    assert_eq!(subjects, expected);
    let statistics = channel.lock().unwrap().statistics();
    assert_eq!((statistics.lost, statistics.works), (0, Some(true)));
    assert_eq!(statistics.failed, attempts);
}

#[test]
fn a_fresh_alarm_ends_the_wait_but_not_more_often_than_once_per_second() {
    let folder = tempfile::tempdir().unwrap();
    let channel = Mutex::new(open(folder.path()));
    channel
        .lock()
        .unwrap()
        .observe(&[condition("action", "a", 3, "e")]);
    let mut turns = Turns::new();
    let mut attempts = 0;
    // For ten simulated seconds the bell rings every millisecond.
    for millisecond in 0..10_000 {
        let mut away = |_: &Message| {
            attempts += 1;
            Err(SendFault::Away("no route".to_owned(), None))
        };
        turns.turn(
            &channel,
            Duration::from_millis(millisecond),
            true,
            &mut away,
        );
    }
    assert!((10..=12).contains(&attempts), "{attempts}");
}

#[test]
fn each_problem_is_logged_once_and_so_is_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let (mut channel, told) = open_telling(folder.path());
    for _ in 0..100 {
        channel.failed("no route", Duration::from_secs(1));
    }
    channel.failed("certificate expired", Duration::from_secs(1));
    channel.works();
    channel.works();
    let told: Vec<Importance> = told.lock().unwrap().iter().map(|it| it.0).collect();
    assert_eq!(
        told,
        [Importance::Warning, Importance::Warning, Importance::Info]
    );
}

#[test]
fn a_rejected_message_holds_up_only_those_about_the_same_thing() {
    let folder = tempfile::tempdir().unwrap();
    let mut channel = open(folder.path());
    channel.observe(&[
        condition("action", "bad", 3, "e1"),
        condition("action", "bad", 3, "e2"),
        condition("action", "good", 3, "e3"),
    ]);
    let now = Duration::from_secs(5);
    let Next::Send(first) = channel.next(now) else {
        panic!("nothing waits");
    };
    channel.rejected(first.number, now, "400");
    let Next::Send(other) = channel.next(now) else {
        panic!("the rejected message holds everything up");
    };
    assert_eq!(other.message.watched.subject, "good");
    channel.delivered(other.number);
    let Next::At(again) = channel.next(now) else {
        panic!("the second message about the same thing overtakes the first");
    };
    assert_eq!(again, now + crate::backoff::FIRST);
    let causes: Vec<String> = deliver(&mut channel)
        .into_iter()
        .map(|it| it.cause)
        .collect();
    assert_eq!(causes, ["e1", "e2"]);
}

#[test]
fn a_message_that_breaks_the_connection_each_time_does_not_hold_up_others() {
    let folder = tempfile::tempdir().unwrap();
    let mut channel = open(folder.path());
    channel.observe(&[
        condition("action", "bad", 3, "e"),
        condition("action", "good", 3, "e"),
    ]);
    let Next::Send(first) = channel.next(Duration::ZERO) else {
        panic!("nothing waits");
    };
    channel.postpone(first.number, Duration::ZERO);
    // Both are due by the time that the connection is back.
    let Next::Send(next) = channel.next(Duration::from_secs(60)) else {
        panic!("nothing waits");
    };
    assert_eq!(next.message.watched.subject, "good");
}

#[test]
fn a_second_process_cannot_use_the_spool() {
    let folder = tempfile::tempdir().unwrap();
    let _first = open(folder.path());
    let second = Channel::open(
        "mqtt",
        "twin",
        folder.path(),
        rules(),
        Arc::new(|_, _| {}),
        time(0),
    );
    assert!(matches!(second, Err(StartError::SpoolInUse { .. })));
}

#[test]
fn a_kill_at_any_byte_of_a_write_loses_nothing_that_was_written_before() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mqtt/spool");
    let mut channel = open(folder.path());
    channel.observe(&[
        condition("action", "a", 3, "e1"),
        condition("action", "b", 3, "e1"),
    ]);
    let before = fs::read(&path).unwrap();
    channel.observe(&[condition("action", "c", 3, "e1")]);
    let after = fs::read(&path).unwrap();
    drop(channel);
    let book = folder.path().join("mqtt/active.json");
    for length in before.len()..=after.len() {
        // The book was not yet saved.
        fs::remove_file(&book).ok();
        fs::write(&path, &after[..length]).unwrap();
        let (mut channel, told) = open_telling(folder.path());
        assert_eq!(told.lock().unwrap().len(), 0, "{told:?}");
        let subjects: Vec<String> = deliver(&mut channel)
            .into_iter()
            .map(|it| it.watched.subject)
            .collect();
        let whole = if length == after.len() {
            vec!["a", "b", "c"]
        } else {
            vec!["a", "b"]
        };
        assert_eq!(subjects, whole);
        // What is spooled is active, too, and is not raised again.
        channel.observe(&[condition("action", "a", 3, "e1")]);
        assert_eq!(deliver(&mut channel), []);
        drop(channel);
    }
}

#[test]
fn a_damaged_line_is_counted_as_a_loss() {
    let folder = tempfile::tempdir().unwrap();
    let mut channel = open(folder.path());
    channel.observe(&[
        condition("action", "a", 3, "e"),
        condition("action", "b", 3, "e"),
    ]);
    drop(channel);
    let path = folder.path().join("mqtt/spool");
    let mut bytes = fs::read(&path).unwrap();
    bytes[30] ^= 1;
    fs::write(&path, bytes).unwrap();
    let (mut channel, told) = open_telling(folder.path());
    assert_eq!(channel.statistics().lost, 1);
    assert_eq!(told.lock().unwrap()[0].0, Importance::Error);
    let subjects: Vec<String> = deliver(&mut channel)
        .into_iter()
        .map(|it| it.watched.subject)
        .collect();
    assert_eq!(subjects[0], "b");
}

#[test]
fn a_full_spool_gives_up_the_oldest_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("spool");
    let mut spool = Spool::open(&path, 3).unwrap().spool;
    let message = |cause: &str| {
        Message::new(
            (new_id(), new_id()),
            State::Raised,
            "twin",
            &condition("action", "a", 3, cause),
        )
    };
    let (lost, written) = spool.append(["1", "2", "3", "4", "5"].map(message).into());
    written.unwrap();
    assert_eq!(lost, 2);
    let again = Spool::open(&path, 3).unwrap();
    let causes: Vec<&str> = again.spool.messages().map(|it| it.cause.as_str()).collect();
    assert_eq!((causes, again.damaged), (vec!["3", "4", "5"], 0));
}

#[test]
fn a_spool_that_never_becomes_empty_does_not_grow_without_end() {
    let folder = tempfile::tempdir().unwrap();
    let mut channel = open(folder.path());
    channel.observe(&[condition("action", "rejected", 3, "e")]);
    let Next::Send(stuck) = channel.next(Duration::ZERO) else {
        panic!("nothing waits");
    };
    for _ in 0..40 {
        channel.rejected(stuck.number, Duration::from_secs(1), "400");
    }
    for round in 0..100 {
        let batch: Vec<Condition> = (0..100)
            .map(|it| condition("action", "a", 3, &format!("{round} {it}")))
            .collect();
        channel.observe(&batch);
        while let Next::Send(it) = channel.next(Duration::from_secs(1)) {
            channel.delivered(it.number);
        }
    }
    let length = fs::metadata(folder.path().join("mqtt/spool"))
        .unwrap()
        .len();
    assert!(length < 3 << 20, "{length} bytes for one message");
    drop(channel);
    assert_eq!(
        open(folder.path())
            .spool
            .messages()
            .next()
            .unwrap()
            .watched
            .subject,
        "rejected"
    );
}

#[test]
fn a_full_disk_does_not_stop_the_delivery() {
    let folder = tempfile::tempdir().unwrap();
    let (mut channel, told) = open_telling(folder.path());
    // /dev/full answers every write with "no space left on device".
    channel.spool.write_into(
        fs::OpenOptions::new()
            .append(true)
            .open("/dev/full")
            .unwrap(),
    );
    channel.observe(&[condition("action", "a", 3, "e")]);
    assert_eq!(told.lock().unwrap()[0].0, Importance::Error);
    let Next::Send(it) = channel.next(Duration::ZERO) else {
        panic!("the message is gone");
    };
    assert_eq!(it.message.watched.subject, "a");
}

#[test]
fn a_message_has_the_fields_of_its_schema() {
    let schema: serde_json::Value = serde_json::from_str(crate::message::JSON_SCHEMA).unwrap();
    let mut part = condition("sensor_failed", "a", 1, "");
    part.watched.part = Some("mid".to_owned());
    part.reason = "\u{e4}".repeat(5000);
    let message = Message::new((new_id(), new_id()), State::Raised, "twin", &part);
    let json: serde_json::Value = serde_json::from_str(&message.json()).unwrap();
    let fields: BTreeSet<&String> = json.as_object().unwrap().keys().collect();
    let known: BTreeSet<&String> = schema["properties"].as_object().unwrap().keys().collect();
    assert_eq!(fields, known);
    assert_eq!(json["schema"], schema["properties"]["schema"]["const"]);
    assert_eq!(json["reason"].as_str().unwrap().chars().count(), 1000);
    assert_eq!(json["time"], "2027-01-15T08:00:01Z");
    let again: Message = serde_json::from_str(&message.json()).unwrap();
    assert_eq!(again, message);
}
