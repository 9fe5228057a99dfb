//! Impacts that the sensors have detected, corrections of the damage, and their recordings.

use std::sync::Arc;

use column_twin::assessment::Action;
use column_twin::column::Impact;
use column_twin::estimation::{CredibleInterval, Detection, EstimateRecord, ImpactEstimate, Onset};
use column_twin::evidence::{JournalEntry, JournalLine, Verification, verify};
use column_twin::messages::column_twin_msgs::{ImpactEstimate as EstimateMessage, TwinStatus};
use column_twin::messages::{Message, cdr, std_msgs};
use column_twin::outgoing::Topic;
use column_twin::parameters::Value;
use column_twin::sensors::Quantity;
use column_twin::time::Nanos;
use column_twin::twin::{Command, EstimateDecision, Journal, ResidualMeasurement};

use crate::copies::forged;
use crate::recorded_twin::{Finished, MS, RecordedTwin, event, parameters};

fn estimate(update: u32, contact: Nanos, velocity: f64) -> EstimateRecord {
    let interval = |mean: f64| CredibleInterval {
        mean,
        low: 0.95 * mean,
        high: 1.05 * mean,
    };
    EstimateRecord {
        event_id: format!("detected-{contact}").into(),
        update,
        is_final: false,
        detection: Detection {
            contact: Onset {
                time: 0.0,
                deviation: 3e-4,
            },
            confirmed_at: 0.01,
            sensor: 0,
            zeros: vec![(0.0, 1e-5)],
        },
        origin: contact,
        column: None,
        batches: 10,
        first_batch: 0,
        last_batch: (0, contact),
        lost_batches: 0,
        prepared: 3,
        drawn_before: 0,
        drawn: 20,
        counts_beam: false,
        events: Vec::new(),
        estimate: ImpactEstimate {
            data_until: 0.02,
            contact_time: CredibleInterval {
                mean: 0.0,
                low: -5e-4,
                high: 5e-4,
            },
            mass: interval(1500.0),
            velocity: interval(velocity),
            momentum: interval(1500.0 * velocity),
            mass_velocity_correlation: -0.9,
            peak_v1: interval(0.1),
            residual_v1: interval(f64::NAN),
            yielded: 0.99,
            collapsed: 0.0,
            capacity_ratio: interval(0.8),
            action: Action::ALL.map(|it| (it, 0.2)).to_vec(),
            vehicle_probabilities: vec![("rigid".to_owned(), 0.7), ("elastic".to_owned(), 0.3)],
            effective_sample_size: 80.0,
            doubtful_sensors: vec!["top".to_owned()],
            scale_not_confirmed: vec!["laser".to_owned()],
            vehicle_by_beam: true,
        },
        best: Impact::rigid(1500.0, velocity),
    }
}

fn accepting(accept: &str) -> RecordedTwin {
    let changes = [
        ("estimation.accept", Value::from(accept)),
        // The times of this script are those of a column that only bends.
        ("shear.model", "none".into()),
    ];
    RecordedTwin::new(parameters().with_changes(changes).expect("admissible"))
}

impl RecordedTwin {
    pub(super) fn detect(&mut self, update: u32, contact: Nanos, velocity: f64) {
        let record = EstimateRecord {
            is_final: update == 3,
            ..estimate(update, contact, velocity)
        };
        self.execute(Command::Estimate(Arc::new(record)));
    }

    pub(super) fn wait(&mut self, nanos: Nanos) {
        for _ in 0..nanos / MS {
            self.advance(MS);
        }
    }
}

/// An accepted estimate that changes twice, an event that is merged with it, another one that waits, is confirmed, and whose
/// response is taken back, one that an event decides, and a correction of the damage.
fn detected() -> Finished {
    let mut twin = accepting("automatic");
    twin.wait(5 * MS);
    let contact = twin.now - 3 * MS;
    twin.detect(0, contact, 6.0);
    twin.wait(10 * MS);
    twin.detect(1, contact + MS / 3, 5.0);
    twin.wait(2 * MS);
    twin.hit(event("camera", contact));
    twin.detect(2, contact, 5.0);
    twin.until_rest();
    twin.detect(3, contact, 4.0);
    twin.until_rest();
    twin.wait(1_000 * MS);
    twin.set(&[("estimation.accept", Value::from("confirmation"))]);
    let contact = twin.now - 20 * MS;
    twin.detect(0, contact, 3.0);
    twin.wait(5 * MS);
    twin.execute(Command::DecideEstimate(EstimateDecision {
        event_id: String::new(),
        accept: true,
        source: "service".into(),
    }));
    twin.wait(2 * MS);
    twin.detect(3, contact, 3.5);
    twin.until_rest();
    twin.wait(1_000 * MS);
    twin.hit(event("person", twin.now));
    twin.detect(0, twin.now + 10 * MS, 6.0);
    twin.until_rest();
    twin.wait(50 * MS);
    let value = 1.1 * twin.twin.status(twin.now).residual_v1;
    let height = parameters().column_properties().length_below;
    twin.execute(Command::CorrectDamage(ResidualMeasurement {
        quantity: Quantity::Displacement,
        height,
        value,
        deviation: 1e-4,
        source: "service".into(),
    }));
    twin.execute(Command::CorrectDamage(ResidualMeasurement {
        quantity: Quantity::Displacement,
        height,
        value: f64::NAN,
        deviation: 1e-4,
        source: "service".into(),
    }));
    twin.wait(1_100 * MS);
    twin.finish()
}

#[test]
fn what_was_detected_is_verified_and_estimates_without_measurements_are_named() {
    let found = detected().verify();
    assert!(found.is_equal(), "{found}");
    assert_eq!((found.missing(), found.differences), (0, 0), "{found}");
    let estimates = &found.topics[Topic::ImpactEstimate.index()];
    // Seven estimates, and one that was published again: those that an event or a person has decided.
    assert_eq!((estimates.recorded, estimates.compared), (9, 9), "{found}");
    let reports = &found.topics[Topic::ImpactReport.index()];
    assert_eq!(reports.compared, 4, "{found}");
    assert_eq!(found.estimates.recorded, 7, "{found}");
    // The estimates of this test come from no measurements.
    assert_eq!(found.estimates.unchecked, 7, "{found}");
    let [unchecked] = &found.unchecked[..] else {
        panic!("{found}");
    };
    let expected = "were not computed again: the recording has no measurements";
    assert!(unchecked.starts_with("7 of the estimates") && unchecked.contains(expected));
}

/// Verifies a copy in which `change` has changed one message of a topic, whether it is the wanted one is its result.
fn changed<M: Message>(
    original: &Finished,
    topic: &str,
    mut change: impl FnMut(&mut M) -> bool,
) -> Verification {
    let mut is_changed = false;
    let (_directory, path) = forged(&original.path(), |message| {
        if is_changed || !message.topic.ends_with(topic) {
            return Some(message.data.clone());
        }
        let mut value: M = cdr::decode(&message.data).expect("a message");
        is_changed = change(&mut value);
        Some(cdr::encode(&value).expect("bytes"))
    });
    assert!(is_changed, "nothing was changed on {topic}");
    verify(&path).expect("can be verified")
}

/// As [`changed`], of a command in the journal.
fn changed_command(
    original: &Finished,
    mut change: impl FnMut(&mut Command) -> bool,
) -> Verification {
    changed(original, "/journal", |text: &mut std_msgs::String| {
        let bytes = cdr::encode(text).expect("bytes");
        let mut line = JournalLine::decode(&bytes).expect("a line");
        let JournalEntry::Twin(Journal::Command(record)) = &mut line.entry else {
            return false;
        };
        let mut other = (**record).clone();
        if !change(&mut other.command) {
            return false;
        }
        *record = other.into();
        *text = cdr::decode(&line.encode().expect("bytes")).expect("a text");
        true
    })
}

pub fn changed_estimate(
    original: &Finished,
    update: u32,
    mut change: impl FnMut(&mut EstimateRecord),
) -> Verification {
    changed_command(original, |command| {
        let Command::Estimate(record) = command else {
            return false;
        };
        if record.update != update {
            return false;
        }
        let mut other = (**record).clone();
        change(&mut other);
        *record = other.into();
        true
    })
}

pub fn first_field(found: &Verification) -> &str {
    assert!(found.is_contradicted(), "{found}");
    let first = found.first_difference.as_ref();
    first.map_or("", |it| it.field.as_str())
}

#[test]
fn forged_estimates_are_found() {
    let original = detected();
    let estimate = |change: fn(&mut EstimateMessage)| {
        changed(&original, "/impact_estimate", |message| {
            change(message);
            true
        })
    };
    let found = estimate(|it| it.momentum.mean = it.momentum.mean.next_up());
    assert_eq!(
        (first_field(&found), found.differences),
        ("momentum.mean", 1)
    );
    let found = estimate(|it| it.decision = EstimateMessage::DECISION_REJECTED);
    assert_eq!(first_field(&found), "decision");
    let found = estimate(|it| it.doubtful_sensors.clear());
    assert_eq!(first_field(&found), "doubtful_sensors");
    let found = estimate(|it| it.scale_not_confirmed.clear());
    assert_eq!(first_field(&found), "scale_not_confirmed");
    let found = estimate(|it| it.residual_v1.mean = 0.1);
    assert_eq!(first_field(&found), "residual_v1.mean");

    let found = changed_estimate(&original, 1, |it| it.estimate.mass.mean *= 1.001);
    assert_eq!(first_field(&found), "mass.mean");
    let found = changed_estimate(&original, 1, |it| it.best.velocity *= 1.001);
    assert!(first_field(&found).contains("velocity"), "{found}");
    let found = changed_estimate(&original, 3, |it| it.best.mass *= 1.001);
    assert!(first_field(&found).contains("mass"), "{found}");
    let found = changed_estimate(&original, 1, |it| it.is_final = true);
    assert_eq!(first_field(&found), "is_final");
}

#[test]
fn forged_decisions_and_corrections_are_found() {
    let original = detected();
    let found = changed_command(&original, |command| match command {
        Command::DecideEstimate(decision) => {
            decision.accept = false;
            true
        }
        _ => false,
    });
    assert!(found.is_contradicted(), "{found}");
    let found = changed_command(&original, |command| match command {
        Command::CorrectDamage(measured) => {
            measured.value *= 1.001;
            true
        }
        _ => false,
    });
    assert!(found.is_contradicted(), "{found}");
    let found = changed(&original, "/twin_status", |status: &mut TwinStatus| {
        let is_corrected = status.corrections_since_reset > 0;
        if is_corrected {
            status.correction_measured = status.correction_measured.next_up();
        }
        is_corrected
    });
    assert_eq!(first_field(&found), "correction_measured");
    let found = changed(&original, "/twin_status", |status: &mut TwinStatus| {
        std::mem::take(&mut status.events_merged) > 0
    });
    assert_eq!(first_field(&found), "events_merged");
}

#[test]
fn an_estimate_that_was_removed_is_missing() {
    let original = detected();
    let mut left = 3;
    let (_directory, path) = forged(&original.path(), |message| {
        left -= i32::from(message.topic.ends_with("/impact_estimate"));
        let is_removed = left == 0;
        left -= i32::from(is_removed);
        (!is_removed).then(|| message.data.clone())
    });
    let found = verify(&path).expect("can be verified");
    assert!(found.is_contradicted(), "{found}");
    assert_eq!(
        found.topics[Topic::ImpactEstimate.index()].missing,
        1,
        "{found}"
    );
}
