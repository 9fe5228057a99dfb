//! Critical velocities in recordings: they are recomputed from the damage.

use column_twin::evidence::{JournalEntry, JournalLine, Verification, verify};
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::TwinStatus;
use column_twin::parameters::{RecordMode, Value};
use column_twin::recording::{Message, Reader};
use column_twin::twin::{CHECKPOINT_PERIOD, Command, Journal};

use super::copies::forged;
use super::recorded_twin::{Finished, MS, RecordedTwin, event, parameters};

const SECOND: i64 = 1_000 * MS;

/// Undamaged, damaged, in another checkpoint, under another load, and undamaged again.
fn recording(mode: RecordMode) -> Finished {
    let mut twin = RecordedTwin::with_mode(parameters(), mode);
    twin.know_critical_velocities();
    twin.advance(SECOND);
    twin.hit(event("a", twin.now));
    twin.until_rest();
    twin.advance(SECOND);
    twin.know_critical_velocities();
    twin.advance(SECOND);
    twin.advance(CHECKPOINT_PERIOD);
    twin.advance(SECOND);
    twin.set(&[("top.load", Value::from(1e5))]);
    twin.advance(SECOND);
    twin.reset();
    twin.know_critical_velocities();
    twin.advance(SECOND);
    twin.finish()
}

fn statuses(recording: &Finished) -> Vec<TwinStatus> {
    let reader = Reader::open(&recording.path()).unwrap();
    let messages = reader.messages().map(|it| it.unwrap());
    let statuses = messages.filter(|it| *it.topic == *"/twin_status");
    statuses.map(|it| cdr::decode(&it.data).unwrap()).collect()
}

#[test]
fn they_are_recorded_and_verified_in_both_modes() {
    for mode in [RecordMode::Always, RecordMode::Events] {
        let recording = recording(mode);
        recording.assert_verified();
        let known: Vec<_> = statuses(&recording)
            .into_iter()
            .filter(|it| !it.critical_vehicle.is_empty())
            .map(|it| it.critical_velocity_restrict)
            .collect();
        let (undamaged, last) = (known.first().unwrap(), known.last().unwrap());
        assert!(known.iter().any(|it| it != undamaged));
        assert_ne!(undamaged, last, "the load differs");
    }
}

/// Verifies a copy in which `change` has changed one message.
fn with(change: impl FnMut(&Message) -> Option<Vec<u8>>) -> Verification {
    let original = recording(RecordMode::Always);
    let (_directory, path) = forged(&original.path(), change);
    verify(&path).unwrap()
}

/// Raises the first critical velocity of a line of the journal, if it has any.
fn raise(line: &mut JournalLine) -> bool {
    let JournalEntry::Twin(entry) = &line.entry else {
        return false;
    };
    let mut entry = entry.clone();
    let vehicles = match &mut entry {
        Journal::Command(record) => match &mut std::sync::Arc::make_mut(record).command {
            Command::CriticalVelocities { vehicles } => vehicles,
            _ => return false,
        },
        Journal::Checkpoint(it) => match &mut std::sync::Arc::make_mut(it).critical_velocities {
            Some(vehicles) => vehicles,
            None => return false,
        },
        Journal::Status(_) => return false,
    };
    let mut raised = vehicles.to_vec();
    raised[1].restrict = Some(1.2);
    *vehicles = raised.into();
    line.entry = JournalEntry::Twin(entry);
    true
}

#[test]
fn a_forged_value_in_a_status_is_named() {
    let mut done = false;
    let found = with(|message| {
        if done || *message.topic != *"/twin_status" {
            return Some(message.data.clone());
        }
        let mut status: TwinStatus = cdr::decode(&message.data).unwrap();
        if status.critical_vehicle.is_empty() {
            return Some(message.data.clone());
        }
        done = true;
        status.critical_velocity_restrict[1] += 0.25;
        Some(cdr::encode(&status).unwrap())
    });
    assert!(found.is_contradicted(), "{found}");
    assert_eq!(found.differences, 1);
    let first = found.first_difference.unwrap();
    assert_eq!(first.field, "critical_velocity_restrict[1]");
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
            if line.is_checkpoint() == in_checkpoint && raise(&mut line) {
                done = true;
                return Some(line.encode().unwrap());
            }
            Some(message.data.clone())
        });
        assert!(done && found.is_contradicted(), "{found}");
        let first = found.first_difference.unwrap();
        assert!(first.field.starts_with("critical"), "{first}");
    }
}

/// Values before anything was computed, as a forger would add them to let a damaged column look strong.
#[test]
fn invented_values_are_found() {
    let mut done = false;
    let found = with(|message| {
        if done || *message.topic != *"/twin_status" {
            return Some(message.data.clone());
        }
        let mut status: TwinStatus = cdr::decode(&message.data).unwrap();
        if status.phase != TwinStatus::CONTACT && !status.critical_vehicle.is_empty() {
            return Some(message.data.clone());
        }
        done = true;
        status.critical_vehicle = vec!["mid_car".to_owned()];
        status.critical_mass = vec![1_500.0];
        status.critical_velocity_restrict = vec![f64::NAN];
        status.critical_velocity_evacuate = vec![f64::NAN];
        Some(cdr::encode(&status).unwrap())
    });
    assert!(done && found.is_contradicted(), "{found}");
}
