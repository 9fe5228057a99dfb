//! Ranges of verdicts in recordings: they are recomputed from the impact.

use std::sync::Arc;

use column_twin::assessment::Action;
use column_twin::evidence::{JournalEntry, JournalLine, Verification, verify};
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::{ImpactReport, TwinStatus};
use column_twin::parameters::RecordMode;
use column_twin::recording::{Message, Reader};
use column_twin::twin::{CHECKPOINT_PERIOD, Command, Journal};

use super::copies::forged;
use super::recorded_twin::{Finished, MS, RecordedTwin, event, parameters};

const SECOND: i64 = 1_000 * MS;

/// The first range is known during the response, the second after it; that of the third impact never is. The fourth impact hits a
/// column that the third has damaged.
fn recording(mode: RecordMode) -> Finished {
    let mut twin = RecordedTwin::with_mode(parameters(), mode);
    twin.hit(event("a", twin.now));
    for _ in 0..500 {
        twin.advance(MS);
        if twin.twin.awaits_opinion() {
            break;
        }
    }
    assert!(twin.twin.is_responding());
    twin.know_range();
    twin.until_rest();
    twin.advance(SECOND);
    twin.reset();
    twin.hit(event("b", twin.now));
    twin.until_rest();
    twin.advance(SECOND);
    twin.know_range();
    twin.advance(SECOND);
    twin.advance(CHECKPOINT_PERIOD);
    twin.advance(SECOND);
    twin.reset();
    twin.hit(event("c", twin.now));
    twin.until_rest();
    twin.hit(event("d", twin.now));
    twin.until_rest();
    twin.advance(SECOND);
    twin.know_range();
    twin.advance(SECOND);
    twin.reset();
    twin.advance(SECOND);
    twin.finish()
}

fn reports(recording: &Finished, topic: &str) -> Vec<ImpactReport> {
    let reader = Reader::open(&recording.path()).unwrap();
    let messages = reader.messages().map(|it| it.unwrap());
    let reports = messages.filter(|it| *it.topic == *topic);
    reports.map(|it| cdr::decode(&it.data).unwrap()).collect()
}

fn is_known(report: &ImpactReport) -> bool {
    report.range_most != ImpactReport::ACTION_UNKNOWN
}

#[test]
fn they_are_recorded_and_verified_in_both_modes() {
    for mode in [RecordMode::Always, RecordMode::Events] {
        let recording = recording(mode);
        recording.assert_verified();
        let known = |topic: &str| -> Vec<_> {
            let reports = reports(&recording, topic).into_iter();
            reports
                .map(|it| (it.event_id.clone(), is_known(&it)))
                .collect()
        };
        let of = |id: &str, is_known| (id.to_owned(), is_known);
        let forecasts = known("/impact_forecast");
        assert!(forecasts.contains(&of("a", true)), "{forecasts:?}");
        assert!(!forecasts.contains(&of("b", true)), "{forecasts:?}");
        // That of the second impact comes once more with the second opinion, and then with the range.
        let b = [false, false, true].map(|is_known| of("b", is_known));
        let mut expected = vec![of("a", true)];
        expected.extend(b);
        expected.push(of("c", false));
        // The beam does not know the damage of the third, so that there is no second opinion on the fourth.
        expected.extend([false, true].map(|is_known| of("d", is_known)));
        assert_eq!(known("/impact_report"), expected);
    }
}

/// Verifies a copy in which `change` has changed one message.
fn with(change: impl FnMut(&Message) -> Option<Vec<u8>>) -> Verification {
    let original = recording(RecordMode::Always);
    let (_directory, copy) = forged(&original.path(), change);
    verify(&copy).unwrap()
}

#[test]
fn a_forged_message_is_named() {
    for topic in ["/impact_forecast", "/impact_report"] {
        let mut done = false;
        let found = with(|message| {
            if done || *message.topic != *topic {
                return Some(message.data.clone());
            }
            let mut report: ImpactReport = cdr::decode(&message.data).unwrap();
            if !is_known(&report) {
                return Some(message.data.clone());
            }
            done = true;
            report.range_most = ImpactReport::ACTION_NONE;
            Some(cdr::encode(&report).unwrap())
        });
        assert!(done && found.is_contradicted(), "{found}");
        assert_eq!(found.first_difference.unwrap().field, "range_most");
    }
    let mut done = false;
    let found = with(|message| {
        if done || *message.topic != *"/twin_status" {
            return Some(message.data.clone());
        }
        let mut status: TwinStatus = cdr::decode(&message.data).unwrap();
        if status.range_most == TwinStatus::ACTION_UNKNOWN {
            return Some(message.data.clone());
        }
        done = true;
        status.range_decided_by = "the weather".to_owned();
        Some(cdr::encode(&status).unwrap())
    });
    assert!(done && found.is_contradicted(), "{found}");
    assert_eq!(found.first_difference.unwrap().field, "range_decided_by");
}

/// Makes the range that an entry of the journal holds milder; whether it holds one.
fn soften(line: &mut JournalLine) -> bool {
    let JournalEntry::Twin(entry) = &mut line.entry else {
        return false;
    };
    let range = match entry {
        Journal::Command(record) => match &mut Arc::make_mut(record).command {
            Command::VerdictRange(range) => Some(range),
            _ => None,
        },
        Journal::Checkpoint(checkpoint) => {
            let judged = Arc::make_mut(checkpoint).judged.as_mut();
            judged.and_then(|it| it.range.as_mut())
        }
        Journal::Status(_) => None,
    };
    if let Some(range) = range {
        Arc::make_mut(range).most = Action::None;
        return true;
    }
    false
}

#[test]
fn a_forged_command_or_checkpoint_is_named() {
    for in_checkpoint in [false, true] {
        let mut done = false;
        let found = with(|message| {
            if done || *message.topic != *"/column_twin/journal" {
                return Some(message.data.clone());
            }
            let mut line = JournalLine::decode(&message.data).unwrap();
            if line.is_checkpoint() == in_checkpoint && soften(&mut line) {
                done = true;
                return Some(line.encode().unwrap());
            }
            Some(message.data.clone())
        });
        assert!(done && found.is_contradicted(), "{found}");
        let first = found.first_difference.unwrap();
        assert!(first.field.contains("range"), "{first}");
    }
}
