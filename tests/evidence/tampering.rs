//! Recordings from which messages were removed or in which messages were changed, doubled or moved: recomputation finds what
//! changes a value, a count, a place or a time, without a seal.

use std::collections::BTreeMap;

use column_twin::column::ImpactSpecification;
use column_twin::endpoints;
use column_twin::evidence::{
    JournalEntry, JournalLine, MAX_DELAY, Tally, Verification, record_impact, verify,
};
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::{
    ColumnParameters, ImpactEvent, ImpactReport, TwinStatus,
};
use column_twin::messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use column_twin::messages::rcl_interfaces::Log;
use column_twin::messages::std_msgs;
use column_twin::outgoing::{Message as TwinMessage, Topic};
use column_twin::parameters::{Parameters, RecordMode, Value};
use column_twin::recording::{Message, WriterOptions};
use column_twin::twin::{Command, ImpactCommand, Journal};
use serde_json::Value as Json;
use sha2::{Digest, Sha256};
use tempfile::TempDir;

use super::copies::{messages, written};
use super::recorded_twin::{Finished, MS, RecordedTwin, event, parameters};

/// Few steps and few states, so that a thousand verifications take seconds.
fn small() -> Parameters {
    let changes = [
        ("publish_rate", Value::from(500.0)),
        ("response.duration", Value::from(0.08)),
    ];
    let changes = changes.map(|(name, value)| (name.to_owned(), value));
    parameters().with_changes(changes).expect("admissible")
}

/// Impacts, one of them on the moving column, a rejected one, a set of parameters, a reset, and messages of the node.
fn recorded(mode: RecordMode) -> Finished {
    let mut twin = RecordedTwin::with_mode(small(), mode);
    let log = |twin: &RecordedTwin, text: &str| {
        let message = Log {
            stamp: Time::from_nanos(twin.now).expect("a stamp"),
            msg: text.to_owned(),
            ..Log::default()
        };
        twin.send(&endpoints::ROSOUT, &message);
    };
    log(&twin, "recording");
    for (index, id) in ["a", "b", "c"].into_iter().enumerate() {
        twin.hit(event(id, twin.now));
        log(&twin, "hit");
        if id == "b" {
            (0..10).for_each(|_| twin.advance(MS));
            twin.hit(event("on the moving column", twin.now));
        }
        twin.until_rest();
        twin.advance(100 * MS);
        twin.send(
            &endpoints::DIAGNOSTICS,
            &DiagnosticArray {
                status: vec![DiagnosticStatus {
                    level: index as u8,
                    ..DiagnosticStatus::default()
                }],
                ..DiagnosticArray::default()
            },
        );
        match id {
            "a" => twin.hit(ImpactCommand {
                impact: ImpactSpecification {
                    mass: -1.0,
                    ..event("bad", twin.now).impact
                },
                ..event("bad", twin.now)
            }),
            "b" => twin.reset(),
            _ => twin.set_column(&ColumnParameters {
                column_id: "column".to_owned(),
                top_load: 3e5,
                ..ColumnParameters::default()
            }),
        }
        twin.advance(MS);
        log(&twin, "done");
        twin.advance(1_200 * MS);
    }
    twin.finish()
}

fn verified(messages: &[Message]) -> Verification {
    let (_directory, path) = written(messages);
    verify(&path).unwrap()
}

fn is_journal(message: &Message) -> bool {
    message.topic.ends_with("/journal")
}

fn line_of(message: &Message) -> JournalLine {
    JournalLine::decode(&message.data).unwrap()
}

#[track_caller]
fn assert_contradicted(messages: &[Message]) -> Verification {
    let found = verified(messages);
    assert!(found.is_contradicted() && !found.is_equal(), "{found}");
    found
}

/// Makes numbers, times and counts of the journal fit to the messages, as a careful forger does.
fn recount(all: &mut [Message]) {
    let (mut number, mut messages, mut others) = (0, 0, 0);
    let mut times = Sha256::new();
    for message in all {
        if !is_journal(message) {
            messages += 1;
            let is_other = ["/rosout", "/diagnostics", "/parameter_events"];
            others += u64::from(is_other.contains(&&*message.topic));
            times.update(message.topic.as_bytes());
            times.update([0]);
            times.update(message.log_time.to_le_bytes());
            continue;
        }
        let mut line = line_of(message);
        line.number = number;
        line.recorded = message.log_time;
        let digest = std::mem::take(&mut times).finalize();
        let digits: String = digest.iter().map(|it| format!("{it:02x}")).collect();
        line.since = Tally {
            messages: std::mem::take(&mut messages),
            others: std::mem::take(&mut others),
            times: digits[..32].to_owned(),
            measurements: String::new(),
            lost_measurements: 0,
        };
        if line.since.messages == 0 {
            line.since.times.clear();
        }
        message.data = line.encode().unwrap();
        number += 1;
    }
}

const MODES: [RecordMode; 2] = [RecordMode::Always, RecordMode::Events];

#[test]
fn a_genuine_recording_is_equal_in_both_modes() {
    for mode in MODES {
        let found = recorded(mode).assert_verified();
        assert_eq!(found.inputs_of.each_ref().map(|it| it.compared), [5, 1]);
        // Nothing was detected.
        let expected = Topic::ALL.map(|it| it != Topic::ImpactEstimate);
        assert_eq!(
            found.topics.each_ref().map(|it| it.compared > 0),
            expected,
            "{found}"
        );
    }
}

/// "keep the journal and drop every other message"
#[test]
fn a_recording_without_every_other_message_is_not_equal() {
    for mode in MODES {
        let mut all = messages(&recorded(mode).path());
        let whole = all.len();
        let mut index = 0;
        all.retain(|it| {
            index += usize::from(!is_journal(it));
            is_journal(it) || index % 2 == 0
        });
        let removed = (whole - all.len()) as u64;
        let found = assert_contradicted(&all);
        assert_eq!(found.undeclared, removed, "{found}");
        // A forger who makes the counts of the journal fit.
        recount(&mut all);
        let found = assert_contradicted(&all);
        assert!(found.undeclared > removed / 2, "{found}");
    }
}

#[test]
fn a_journal_alone_is_not_equal() {
    let mut all = messages(&recorded(RecordMode::Always).path());
    let whole = all.len();
    all.retain(is_journal);
    let removed = (whole - all.len()) as u64;
    let found = assert_contradicted(&all);
    assert_eq!(found.undeclared, removed, "{found}");
}

/// "drop everything after the first impact"
#[test]
fn a_recording_that_stops_after_the_first_impact_is_not_equal() {
    let mut all = messages(&recorded(RecordMode::Always).path());
    let first = all.iter().position(|it| *it.topic == *"/impact_report");
    let with_journal = all.clone();
    all.truncate(first.unwrap() + 1);
    let found = assert_contradicted(&all);
    assert!(
        found
            .to_string()
            .contains("the end of the journal is absent"),
        "{found}"
    );
    // The journal is kept.
    let kept: Vec<_> = with_journal
        .into_iter()
        .enumerate()
        .filter(|(index, it)| *index <= first.unwrap() || is_journal(it))
        .map(|(_, it)| it)
        .collect();
    let found = assert_contradicted(&kept);
    assert!(found.undeclared > 100, "{found}");
}

/// A copy in which one message on a topic is changed, and the digest of it in the journal as well.
fn with_another_input<M: column_twin::messages::Message>(
    all: &[Message],
    topic: &str,
    change: impl Fn(&mut M),
) -> Vec<Message> {
    let mut all = all.to_vec();
    let index = all.iter().position(|it| *it.topic == *topic).unwrap();
    let mut message: M = cdr::decode(&all[index].data).unwrap();
    change(&mut message);
    all[index].data = cdr::encode(&message).unwrap();
    let digest = Sha256::digest(&all[index].data);
    let mut line = line_of(&all[index + 1]);
    let JournalEntry::Received { sha256, .. } = &mut line.entry else {
        panic!("{line:?}");
    };
    *sha256 = digest.iter().map(|it| format!("{it:02x}")).collect();
    all[index + 1].data = line.encode().unwrap();
    all
}

/// "mass 1500 changed to 900 passes, and `info` prints 900"
#[test]
fn an_impact_event_with_another_mass_is_not_equal() {
    let all = messages(&recorded(RecordMode::Always).path());
    let forged = with_another_input(&all, "/impact_event", |event: &mut ImpactEvent| {
        assert_eq!(event.mass, 1500.0);
        event.mass = 900.0;
    });
    let first = assert_contradicted(&forged).first_difference.unwrap();
    assert_eq!(
        (first.topic.as_str(), first.field.as_str()),
        ("/impact_event", "command.impact.impact.mass")
    );
    assert!(
        first.recorded.contains("900") && first.computed.contains("1500"),
        "{first}"
    );
    // Without a new digest.
    let mut simple = all.clone();
    let index = all
        .iter()
        .position(|it| *it.topic == *"/impact_event")
        .unwrap();
    simple[index].data = forged[index].data.clone();
    assert_contradicted(&simple);
    // A field that is not part of the command.
    let frame = with_another_input(&all, "/impact_event", |event: &mut ImpactEvent| {
        event.header.frame_id.push('2');
    });
    let mut simple = all.clone();
    simple[index].data = frame[index].data.clone();
    let first = assert_contradicted(&simple).first_difference.unwrap();
    assert!(first.field.contains("SHA-256"), "{first}");
}

#[test]
fn column_parameters_with_another_load_are_not_equal() {
    let all = messages(&recorded(RecordMode::Always).path());
    let forged = with_another_input(
        &all,
        "/column_parameters",
        |message: &mut ColumnParameters| {
            message.top_load = 2e5;
        },
    );
    let first = assert_contradicted(&forged).first_difference.unwrap();
    assert!(first.field.starts_with("command.set_parameters"), "{first}");
}

#[test]
fn duplicated_and_removed_inputs_are_found() {
    for topic in ["/impact_event", "/column_parameters"] {
        let all = messages(&recorded(RecordMode::Always).path());
        let index = all.iter().position(|it| *it.topic == *topic).unwrap();
        let mut twice = all.clone();
        twice.insert(index, all[index].clone());
        assert_contradicted(&twice);
        // With its line.
        let mut with_line = all.clone();
        let pair = all[index..=index + 1].to_vec();
        with_line.splice(index + 2..index + 2, pair);
        assert_contradicted(&with_line);
        let mut without = all.clone();
        without.remove(index);
        let found = assert_contradicted(&without);
        assert_eq!(
            found.inputs_of.iter().map(|it| it.missing).sum::<u64>(),
            1,
            "{found}"
        );
        let mut without_both = all;
        without_both.drain(index..=index + 1);
        assert_contradicted(&without_both);
    }
}

#[test]
fn each_removed_forecast_is_missing() {
    let all = messages(&recorded(RecordMode::Always).path());
    let forecasts: Vec<_> = all
        .iter()
        .enumerate()
        .filter(|(_, it)| *it.topic == *"/impact_forecast")
        .map(|(index, _)| index)
        .collect();
    let second = |index: usize| {
        let report: ImpactReport = cdr::decode(&all[index].data).unwrap();
        !report.error_estimate.is_nan()
    };
    assert!(forecasts.iter().any(|it| second(*it)) && forecasts.len() >= 6);
    for index in forecasts {
        let mut without = all.clone();
        without.remove(index);
        let found = assert_contradicted(&without);
        assert_eq!(found.undeclared, 1, "{found}");
    }
}

/// Every log and publish time, with and without the times in the journal.
#[test]
fn times_shifted_by_a_second_are_found() {
    const SECOND: i64 = 1_000_000_000;
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("genuine");
    // In a recording of a simulation all times are those of the twin.
    let origin = 1_700_000_000 * SECOND;
    record_impact(&small(), origin, &path, &WriterOptions::default()).unwrap();
    let all = messages(&path);
    assert!(verified(&all).is_equal());
    const { assert!(SECOND > MAX_DELAY) };
    for shift in [SECOND, -SECOND] {
        for (log, publish) in [(shift, shift), (0, shift), (shift, 0)] {
            let mut shifted = all.clone();
            for message in &mut shifted {
                message.log_time += log;
                message.publish_time += publish;
            }
            assert_contradicted(&shifted);
        }
        let mut rewritten = all.clone();
        for message in &mut rewritten {
            message.log_time += shift;
            message.publish_time += shift;
        }
        recount(&mut rewritten);
        // The publish time of the impact is in the line about it.
        rewritten.retain(|it| *it.topic != *"/impact_event");
        let found = assert_contradicted(&rewritten);
        let delays = found.examples.iter().any(|it| it.field == "log times");
        assert!(delays, "{found}");
    }
    // One message, wherever it goes.
    for index in (0..all.len()).step_by(17) {
        for shift in [SECOND, -SECOND, SECOND / 1000] {
            let mut shifted = all.clone();
            let mut message = shifted.remove(index);
            message.log_time += shift;
            message.publish_time += shift;
            let place = shifted.partition_point(|it| it.log_time <= message.log_time);
            shifted.insert(place, message);
            assert_contradicted(&shifted);
        }
    }
}

/// A declared loss excuses as many messages as it declares, and only when it declares them.
#[test]
fn a_recording_of_an_overflowing_queue_is_equal_and_says_what_it_lost() {
    let mut twin = RecordedTwin::new(small());
    for (id, drops) in [("a", 0), ("b", 3), ("c", 0)] {
        twin.hit(event(id, twin.now));
        twin.drop_states(drops);
        twin.until_rest();
        twin.advance(1_100 * MS);
    }
    let original = twin.finish();
    let found = original.verify();
    assert!(found.is_equal(), "{found}");
    assert!(found.missing() == 6 && found.undeclared == 0, "{found}");
    assert!(found.declared_losses >= found.missing(), "{found}");
    // As many messages, removed before the loss is declared.
    let mut all = messages(&original.path());
    let mut left = 4;
    all.retain(|it| {
        let state = *it.topic == *"/column_state" && left > 0;
        left -= i32::from(state);
        !state
    });
    let found = assert_contradicted(&all);
    assert_eq!(found.undeclared, 4, "{found}");
    // More messages than are declared.
    let mut all = messages(&original.path());
    let event_id = |it: &Message| {
        let of = Topic::ALL
            .iter()
            .find(|topic| it.topic.ends_with(topic.endpoint().name));
        of.and_then(|topic| TwinMessage::decode(*topic, &it.data).ok())
            .and_then(|it| it.event_id().map(str::to_owned))
    };
    all.retain(|it| {
        let state = *it.topic == *"/hinge_forces" || *it.topic == *"/column_state";
        !(state && event_id(it).as_deref() == Some("b"))
    });
    let found = assert_contradicted(&all);
    assert!(found.undeclared > 0, "{found}");
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % limit as u64) as usize
    }
}

/// What may be changed unnoticed without a seal, by topic: the paths of fields that cannot be recomputed.
fn cannot_be_recomputed(topic: &str, path: &str) -> bool {
    match topic {
        "/impact_forecast" | "/impact_report" => path == "compute_time",
        "/twin_status" => [
            "overruns",
            "worst_lateness",
            "dropped_inputs",
            "dropped_states",
            "dropped_recording",
            "dropped_viewer",
        ]
        .contains(&path),
        "/diagnostics" | "/rosout" => true,
        "/parameter_events" => path.starts_with("stamp"),
        "/column_twin/journal" => {
            let ends = [
                // Times of the twin's clock that decide about nothing.
                "command.now",
                "checkpoint.stamp",
                // Who sent a command by a service.
                "reset.source",
                // What recorded it.
                "about.program",
                "about.build",
                "about.events_only",
            ];
            ends.iter().any(|it| path.ends_with(it)) || path.contains("about.topics")
        }
        _ => false,
    }
}

/// The paths at which two values differ.
fn differences(path: &str, one: &Json, other: &Json, into: &mut Vec<String>) {
    match (one, other) {
        (Json::Object(one), Json::Object(other)) if one.keys().eq(other.keys()) => {
            for (name, value) in one {
                differences(&format!("{path}.{name}"), value, &other[name], into);
            }
        }
        (Json::Array(one), Json::Array(other)) if one.len() == other.len() => {
            for (index, (one, other)) in one.iter().zip(other).enumerate() {
                differences(&format!("{path}[{index}]"), one, other, into);
            }
        }
        _ => {
            // As texts, because -0 equals 0.
            let [one, other] = [one, other].map(Json::to_string);
            if one != other {
                into.push(path.trim_start_matches('.').to_owned());
            }
        }
    }
}

/// The content of a message; `None` if it cannot be read.
fn content(message: &Message) -> Option<Json> {
    if is_journal(message) {
        let text: std_msgs::String = cdr::decode(&message.data).ok()?;
        return serde_json::from_str(&text.data).ok();
    }
    let twin = Topic::ALL
        .iter()
        .find(|it| *message.topic == *format!("/{}", it.endpoint().name.trim_start_matches("~/")))
        .or_else(|| {
            let markers = message.topic.ends_with("/markers");
            markers.then_some(&Topic::Markers)
        });
    let json = |value| serde_json::to_value(value).ok();
    match (&*message.topic, twin) {
        (_, Some(topic)) => {
            let message = TwinMessage::decode(*topic, &message.data).ok()?;
            serde_json::to_value(message).ok()
        }
        ("/impact_event", _) => {
            let event = cdr::decode::<ImpactEvent>(&message.data).ok()?;
            json(&serde_json::to_value(event).ok()?)
        }
        ("/column_parameters", _) => {
            let set = cdr::decode::<ColumnParameters>(&message.data).ok()?;
            json(&serde_json::to_value(set).ok()?)
        }
        _ => json(&Json::from(message.data.clone())),
    }
}

/// What one random change does, and where.
#[derive(Debug)]
enum Change {
    Byte,
    Drop,
    Duplicate,
    Place,
    Time,
}

/// One random change of a recording, in words; `None` if it changes no value, no count and no place.
fn tamper(all: &mut Vec<Message>, random: &mut Random) -> Option<String> {
    let change = match random.below(6) {
        0 | 1 => Change::Byte,
        2 => Change::Drop,
        3 => Change::Duplicate,
        4 => Change::Place,
        _ => Change::Time,
    };
    // All topics equally often.
    let mut of_topic: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (index, message) in all.iter().enumerate() {
        of_topic
            .entry(message.topic.to_string())
            .or_default()
            .push(index);
    }
    let topics: Vec<_> = of_topic.into_iter().collect();
    let (topic, indices) = &topics[random.below(topics.len())];
    let index = indices[random.below(indices.len())];
    let mut what = format!("{change:?} of message {index} on {topic}");
    match change {
        Change::Byte => {
            let before = content(&all[index]);
            let data = &mut all[index].data;
            // The first four bytes tell the encoding.
            let byte = 4 + random.below(data.len() - 4);
            data[byte] ^= 1 << random.below(8);
            let after = content(&all[index]);
            let mut paths = Vec::new();
            match (&before, &after) {
                (Some(before), Some(after)) => differences("", before, after, &mut paths),
                _ => paths.push("all of it".to_owned()),
            }
            paths.retain(|path| !cannot_be_recomputed(topic, path));
            what = format!("{what}: {paths:?}");
            (!paths.is_empty()).then_some(what)
        }
        Change::Drop => {
            all.remove(index);
            Some(what)
        }
        Change::Duplicate => {
            let message = all[index].clone();
            all.insert(index, message);
            Some(what)
        }
        Change::Place => {
            let message = all.remove(index);
            let place = random.below(all.len() + 1);
            // Messages with equal times have no other order than that of the file.
            let times = |it: &[Message]| it.iter().map(|it| it.log_time).collect::<Vec<_>>();
            all.insert(place, message);
            (place != index && !times(all).is_sorted()).then_some(what)
        }
        Change::Time => {
            let mut message = all.remove(index);
            let nanos = 1 + random.below(2_000_000_000) as i64;
            let nanos = if random.below(2) == 0 { nanos } else { -nanos };
            message.log_time += nanos;
            // The publish time of a received message is its sender's.
            message.publish_time += nanos;
            let place = all.partition_point(|it| it.log_time <= message.log_time);
            all.insert(place, message);
            Some(format!("{what} by {nanos} ns"))
        }
    }
}

fn random_changes(count: u64) {
    let recordings = MODES.map(|mode| messages(&recorded(mode).path()));
    let (mut tried, mut unnoticed) = (0, Vec::new());
    let mut seed = 0;
    while tried < count {
        let mut all = recordings[(seed % 2) as usize].clone();
        let change = tamper(&mut all, &mut Random(seed));
        seed += 1;
        let Some(change) = change else { continue };
        tried += 1;
        let (_directory, path) = written(&all);
        if verify(&path).is_ok_and(|found| found.is_equal()) {
            unnoticed.push(format!("seed {}: {change}", seed - 1));
        }
    }
    assert!(
        unnoticed.is_empty(),
        "{} of {count}: {unnoticed:#?}",
        unnoticed.len()
    );
}

#[test]
fn a_hundred_random_changes_are_found() {
    random_changes(100);
}

#[test]
#[ignore = "slow: more than a thousand verifications"]
fn all_of_1120_random_changes_are_found() {
    random_changes(1120);
}

/// What cannot be recomputed is bounded nevertheless.
#[test]
fn counters_of_the_node_do_not_decrease() {
    let mut all = messages(&recorded(RecordMode::Always).path());
    let status = all
        .iter_mut()
        .find(|it| *it.topic == *"/twin_status")
        .unwrap();
    let mut message: TwinStatus = cdr::decode(&status.data).unwrap();
    message.dropped_states = 1_000_000;
    status.data = cdr::encode(&message).unwrap();
    let first = assert_contradicted(&all).first_difference.unwrap();
    assert_eq!(first.field, "dropped_states");
}

/// The command in the journal and the message are changed alike: the recomputation is another one.
#[test]
fn an_impact_changed_in_message_and_journal_is_not_equal() {
    let all = messages(&recorded(RecordMode::Always).path());
    let mut forged = with_another_input(&all, "/impact_event", |event: &mut ImpactEvent| {
        event.mass = 900.0;
    });
    for message in forged.iter_mut().filter(|it| is_journal(it)) {
        let mut line = line_of(message);
        if let JournalEntry::Twin(Journal::Command(record)) = &mut line.entry
            && let Command::Impact(impact) = &mut std::sync::Arc::make_mut(record).command
            && impact.event_id == "a"
        {
            impact.impact.mass = 900.0;
            message.data = line.encode().unwrap();
        }
    }
    assert_contradicted(&forged);
}
