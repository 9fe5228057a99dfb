//! Second opinions in recordings: the beam is computed once more, from the damage that it had.

use std::sync::Arc;

use column_twin::evidence::{JournalEntry, JournalLine, Verification, verify};
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::{ImpactReport, SecondOpinion};
use column_twin::parameters::{Parameters, RecordMode, Value};
use column_twin::recording::{Message, Reader};
use column_twin::twin::{BeamResult, CHECKPOINT_PERIOD, Command, Journal};

use super::copies::forged;
use super::recorded_twin::{Finished, MS, RecordedTwin, event};

const SECOND: i64 = 1_000 * MS;

fn hit(twin: &mut RecordedTwin, id: &str, direction: f64) {
    let mut event = event(id, twin.now);
    event.vehicle = "rigid".to_owned();
    event.impact.velocity = 6.0;
    event.impact.height = Some(1.0);
    event.impact.direction = Some(direction);
    twin.hit(event);
}

/// The first second opinion is known during the response, the second one, on the damaged column, after it.
fn recording(mode: RecordMode) -> Finished {
    let given = Parameters::load(&["config/heb220_s355.yaml".into()], &[]).expect("admissible");
    let changes = [
        ("column_id", Value::from("column")),
        // With it the forecast, in slices, is complete before the response is over.
        ("solver.dt", Value::from(1e-4)),
    ];
    let parameters = given.with_changes(changes).expect("admissible");
    let mut twin = RecordedTwin::with_mode(parameters, mode);
    hit(&mut twin, "a", 0.2);
    for _ in 0..500 {
        twin.advance(MS);
        if twin.twin.awaits_opinion() {
            break;
        }
    }
    assert!(twin.twin.is_responding());
    twin.know_opinion();
    twin.until_rest();
    twin.advance(SECOND);
    hit(&mut twin, "b", -0.1);
    twin.until_rest();
    twin.advance(SECOND);
    twin.know_opinion();
    twin.advance(SECOND);
    twin.advance(CHECKPOINT_PERIOD);
    twin.advance(SECOND);
    twin.finish()
}

fn reports(recording: &Finished, topic: &str) -> Vec<(String, u8)> {
    let reader = Reader::open(&recording.path()).unwrap();
    let messages = reader.messages().map(|it| it.unwrap());
    let reports = messages.filter(|it| *it.topic == *topic);
    reports
        .map(|it| cdr::decode::<ImpactReport>(&it.data).unwrap())
        .map(|it| (it.event_id, it.beam.state))
        .collect()
}

#[test]
fn they_are_recorded_and_verified_in_both_modes() {
    for mode in [RecordMode::Always, RecordMode::Events] {
        let recording = recording(mode);
        recording.assert_verified();
        let of = |id: &str, state| (id.to_owned(), state);
        let forecasts = reports(&recording, "/impact_forecast");
        assert!(
            forecasts.contains(&of("a", SecondOpinion::KNOWN)),
            "{forecasts:?}"
        );
        let expected = [
            of("a", SecondOpinion::KNOWN),
            of("b", SecondOpinion::PENDING),
            of("b", SecondOpinion::KNOWN),
        ];
        assert_eq!(reports(&recording, "/impact_report"), expected);
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
    let mut done = false;
    let found = with(|message| {
        if done || *message.topic != *"/impact_report" {
            return Some(message.data.clone());
        }
        let mut report: ImpactReport = cdr::decode(&message.data).unwrap();
        done = true;
        report.beam.residual_sideways = 0.0;
        Some(cdr::encode(&report).unwrap())
    });
    assert!(done && found.is_contradicted(), "{found}");
    let first = found.first_difference.unwrap();
    assert_eq!(first.field, "beam.residual_sideways");
}

/// Makes the opinion that an entry of the journal holds milder; whether it holds one.
fn soften(line: &mut JournalLine) -> bool {
    let JournalEntry::Twin(entry) = &mut line.entry else {
        return false;
    };
    match entry {
        Journal::Command(record) => {
            let command = &mut Arc::make_mut(record).command;
            let Command::SecondOpinion(result) = command else {
                return false;
            };
            let BeamResult::Answer(answer) = Arc::make_mut(result) else {
                return false;
            };
            answer.capacity[1] = answer.capacity[0];
        }
        Journal::Checkpoint(checkpoint) => {
            let last = Arc::make_mut(checkpoint).life.last_impact.as_mut();
            let Some(opinion) = last.and_then(|it| it.second_opinion.as_mut()) else {
                return false;
            };
            Arc::make_mut(opinion).capacity[1] *= 1.5;
        }
        Journal::Status(_) => return false,
    }
    true
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
        let is_named = first.field.contains("opinion");
        assert!(is_named, "{first}");
    }
}
