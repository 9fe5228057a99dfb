//! Forged recordings: every change is found, and the first one is named.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use column_twin::endpoints::NodeKind;
use column_twin::evidence::{
    JournalEntry, JournalError, JournalLine, Topics, Verification, VerifyError, verify,
};
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::{ColumnState, ImpactReport};
use column_twin::messages::std_msgs;
use column_twin::outgoing::Topic;
use column_twin::recording::{Entry, Message, Writer, WriterOptions};
use column_twin::twin::{ImpactCommand, Journal};
use tempfile::TempDir;

use super::copies::{forged, messages, written, written_with};
use super::recorded_twin::{Finished, MS, RecordedTwin, event, parameters};

/// Two impacts and the time between them.
fn recording() -> Finished {
    let mut twin = RecordedTwin::new(parameters());
    for id in ["a", "b"] {
        twin.hit(event(id, twin.now));
        twin.until_rest();
        twin.advance(100 * MS);
    }
    twin.finish()
}

/// Verifies a copy in which one field of the `which`-th message of a topic is changed.
fn changed<M: column_twin::messages::Message>(
    original: &Path,
    topic: &str,
    which: usize,
    mut change: impl FnMut(&mut M),
) -> Verification {
    let mut count = 0;
    let (_directory, path) = forged(original, |message| {
        if *message.topic == *topic {
            count += 1;
            if count == which {
                let mut value: M = cdr::decode(&message.data).unwrap();
                change(&mut value);
                return Some(cdr::encode(&value).unwrap());
            }
        }
        Some(message.data.clone())
    });
    verify(&path).unwrap()
}

/// A copy in which the last bit of `v1` of the seventh state is changed.
pub fn with_one_bit_flipped(original: &Path) -> (TempDir, PathBuf) {
    let mut count = 0;
    forged(original, |message| {
        count += usize::from(*message.topic == *"/column_state");
        if *message.topic != *"/column_state" || count != 7 {
            return Some(message.data.clone());
        }
        let mut state: ColumnState = cdr::decode(&message.data).unwrap();
        flip(&mut state.v1);
        Some(cdr::encode(&state).unwrap())
    })
}

/// Flips the last bit.
fn flip(number: &mut f64) {
    *number = f64::from_bits(number.to_bits() ^ 1);
}

#[test]
fn an_unchanged_copy_is_equal() {
    let original = recording();
    let (_directory, path) = forged(&original.path(), |message| Some(message.data.clone()));
    let found = verify(&path).unwrap();
    assert!(found.is_equal(), "{found}");
}

#[test]
fn one_flipped_bit_is_named() {
    let original = recording();
    let mut stamp = None;
    let found = changed(
        &original.path(),
        "/column_state",
        17,
        |state: &mut ColumnState| {
            flip(&mut state.u2_rate);
            stamp = state.header.stamp.to_nanos();
        },
    );
    assert!(!found.is_equal());
    assert_eq!(found.differences, 1);
    let first = found.first_difference.clone().unwrap();
    assert_eq!(
        (first.topic.as_str(), first.field.as_str()),
        ("/column_state", "u2_rate")
    );
    assert_eq!((first.stamp, first.event_id.as_str()), (stamp, "a"));
    let by = first.by.unwrap().abs();
    assert!(by > 0.0 && by < 1e-12, "{first}");
    assert!(found.to_string().contains("u2_rate"), "{found}");
}

#[test]
fn reports_are_compared_except_for_their_compute_time() {
    let original = recording();
    let found = changed(
        &original.path(),
        "/impact_report",
        2,
        |report: &mut ImpactReport| {
            report.compute_time = 77.0;
        },
    );
    assert!(found.is_equal(), "{found}");
    let found = changed(
        &original.path(),
        "/impact_report",
        2,
        |report: &mut ImpactReport| {
            flip(&mut report.plastic_rotation[3]);
        },
    );
    let first = found.first_difference.unwrap();
    assert_eq!(
        (first.field.as_str(), first.event_id.as_str()),
        ("plastic_rotation[3]", "b")
    );
}

/// Exact states at rest are compared too.
/// A program with another catalogue of vehicles cannot confirm the recording, and tells which number differs.
#[test]
fn another_catalogue_of_vehicles_is_named() {
    let mut twin = RecordedTwin::new(parameters());
    twin.hit(ImpactCommand {
        vehicle: "mid_car".to_owned(),
        ..event("a", twin.now)
    });
    twin.until_rest();
    let original = twin.finish();
    original.assert_verified();
    let (_directory, path) = forged(&original.path(), |message| {
        if *message.topic != *"/column_twin/journal" {
            return Some(message.data.clone());
        }
        let text: std_msgs::String = cdr::decode(&message.data).unwrap();
        let mut line: serde_json::Value = serde_json::from_str(&text.data).unwrap();
        let impact = line.pointer_mut("/entry/twin/command/impact/vehicle/springs/0");
        if let Some(spring) = impact {
            spring["unloading_stiffness"] = serde_json::json!(16e6);
        }
        let data = line.to_string();
        Some(cdr::encode(&std_msgs::String { data }).unwrap())
    });
    let found = verify(&path).unwrap();
    assert!(found.is_contradicted(), "{found}");
    let first = found.first_difference.clone().unwrap();
    assert!(
        first.field.starts_with("impact.vehicle") && first.field.ends_with("unloading_stiffness"),
        "{first}"
    );
    assert!(
        found.unchecked[0].contains("catalogue of vehicles"),
        "{found}"
    );
}

#[test]
fn a_changed_state_at_rest_is_found() {
    let original = recording();
    let mut points = 0;
    let (_directory, path) = forged(&original.path(), |message| {
        if !message.topic.ends_with("/journal") {
            return Some(message.data.clone());
        }
        let mut line = JournalLine::decode(&message.data).unwrap();
        if let JournalEntry::Twin(Journal::Checkpoint(point)) = &mut line.entry {
            points += 1;
            if points == 2 {
                let mut other = (**point).clone();
                flip(&mut other.state.plastic.below.rotation[0]);
                *point = other.into();
            }
        }
        Some(line.encode().unwrap())
    });
    let found = verify(&path).unwrap();
    assert!(!found.is_equal());
    let first = found.first_difference.unwrap();
    assert!(first.topic.ends_with("/journal"));
    assert_eq!(first.field, "state.plastic.below.rotation[0]");
}

#[test]
fn removed_messages_are_missing() {
    let original = recording();
    for topic in [
        "/column_state",
        "/hinge_forces",
        "/impact_report",
        "/twin_status",
        "/markers",
    ] {
        let mut count = 0;
        let (_directory, path) = forged(&original.path(), |message| {
            count += usize::from(*message.topic == *topic);
            (*message.topic != *topic || count != 2).then(|| message.data.clone())
        });
        let found = verify(&path).unwrap();
        // Nothing follows the last report that would show its absence, but a status follows this one.
        assert_eq!(
            (found.missing(), found.is_equal()),
            (1, false),
            "{topic}: {found}"
        );
    }
}

#[test]
fn inserted_messages_are_found() {
    let original = recording();
    let mut all = messages(&original.path());
    let report = all.iter().position(|it| *it.topic == *"/impact_report");
    let report = report.unwrap();
    all.insert(report, all[report].clone());
    let (_directory, path) = written(&all);
    let found = verify(&path).unwrap();
    assert!(!found.is_equal(), "{found}");
    assert_eq!(
        found.topics[Topic::ImpactReport.index()].unexpected,
        1,
        "{found}"
    );
}

#[test]
fn the_result_states_what_could_not_be_checked() {
    let original = recording();
    // Without its first checkpoint.
    let mut points = 0;
    let (_directory, path) = forged(&original.path(), |message| {
        if message.topic.ends_with("/journal")
            && JournalLine::decode(&message.data).unwrap().is_checkpoint()
        {
            points += 1;
            if points == 1 {
                return None;
            }
        }
        Some(message.data.clone())
    });
    let found = verify(&path).unwrap();
    assert!(
        !found.is_equal() && found.unchecked_messages() > 20,
        "{found}"
    );
    assert!(
        found
            .unchecked
            .iter()
            .any(|it| it.contains("before the first checkpoint")),
        "{found}"
    );
    assert!(found.compared() > 20, "{found}");
    // No recording begins with another line.
    assert_eq!(found.missing_entries, 1, "{found}");
    // Without a command.
    let mut inputs = 0;
    let (_directory, path) = forged(&original.path(), |message| {
        if message.topic.ends_with("/journal") {
            let line = JournalLine::decode(&message.data).unwrap();
            if matches!(line.entry, JournalEntry::Twin(Journal::Command(_))) {
                inputs += 1;
                if inputs == 1 {
                    return None;
                }
            }
        }
        Some(message.data.clone())
    });
    let found = verify(&path).unwrap();
    assert!(!found.is_equal(), "{found}");
    assert_eq!(found.missing_entries, 1, "{found}");
}

/// For every entry but status, except the first checkpoint, because a recording may also begin with the second one.
#[test]
fn removed_entries_of_the_journal_are_missing() {
    let original = recording();
    let numbered = |message: &Message| {
        message.topic.ends_with("/journal")
            && !matches!(
                JournalLine::decode(&message.data).unwrap().entry,
                JournalEntry::Twin(Journal::Status(_))
            )
    };
    let all = messages(&original.path());
    let count = all.iter().filter(|it| numbered(it)).count();
    assert_eq!(
        count, 8,
        "three states at rest, two messages, two commands and the end"
    );
    for removed in 1..count {
        let mut index = 0;
        let (_directory, path) = forged(&original.path(), |message| {
            index += usize::from(numbered(message));
            let is_it = numbered(message) && index == removed + 1;
            (!is_it).then(|| message.data.clone())
        });
        let found = verify(&path).unwrap();
        assert!(!found.is_equal(), "{removed}: {found}");
        assert_eq!(found.missing_entries, 1, "{removed}: {found}");
    }
}

/// The count of missing entries does not overflow.
#[test]
fn an_entry_with_an_extreme_number_is_not_equal() {
    let original = recording();
    let mut inputs = 0;
    let (_directory, path) = forged(&original.path(), |message| {
        if message.topic.ends_with("/journal") {
            let mut line = JournalLine::decode(&message.data).unwrap();
            if let JournalEntry::Twin(Journal::Command(record)) = &mut line.entry {
                inputs += 1;
                if inputs == 2 {
                    Arc::make_mut(record).number = u64::MAX;
                    return Some(line.encode().unwrap());
                }
            }
        }
        Some(message.data.clone())
    });
    assert!(inputs >= 2);
    let found = verify(&path).unwrap();
    assert!(!found.is_equal() && found.missing() > 1_000_000, "{found}");
}

/// Only the first checkpoint is left of the journal.
#[test]
fn a_recording_without_any_comparable_message_is_not_equal() {
    let original = recording();
    let mut entries = 0;
    let (_directory, path) = forged(&original.path(), |message| {
        if message.topic.ends_with("/journal") {
            entries += 1;
            return (entries == 1).then(|| message.data.clone());
        }
        (*message.topic == *"/column_state").then(|| message.data.clone())
    });
    let found = verify(&path).unwrap();
    assert!(found.is_unchecked() && found.is_contradicted(), "{found}");
    assert!(!found.is_equal(), "{found}");
}

/// What is left of a response when its recording had to end, and the next one ends at its first checkpoint.
#[test]
fn a_recording_of_the_end_of_a_response_is_no_forgery() {
    let original = recording();
    let note = ("repeated_checkpoint".to_owned(), String::new());
    let options = WriterOptions {
        notes: [note].into(),
        ..WriterOptions::default()
    };
    let all = messages(&original.path());
    let of = |topic: &str| all.iter().find(|it| it.topic.ends_with(topic)).unwrap();
    let rest = ["/journal", "/impact_report"].map(|topic| of(topic).clone());
    let (directory, path) = written_with(&options, &rest);
    // The recorder did not stop here.
    let bytes = std::fs::read(path.join("forged_0.mcap")).unwrap();
    let cut = directory.path().join("cut.mcap");
    std::fs::write(&cut, &bytes[..bytes.len() - 100]).unwrap();
    let found = verify(&cut).unwrap();
    assert!(!found.is_contradicted() && found.is_unchecked(), "{found}");
    assert_eq!(found.unchecked_messages(), 1, "{found}");
}

#[test]
fn a_recording_without_a_journal_cannot_be_verified() {
    let original = recording();
    let (_directory, path) = forged(&original.path(), |message| {
        (!message.topic.ends_with("/journal")).then(|| message.data.clone())
    });
    assert!(matches!(
        verify(&path),
        Err(VerifyError::NoCheckpoint { .. })
    ));
    assert!(matches!(
        verify(Path::new("nothing/there")),
        Err(VerifyError::Recording(_))
    ));
}

/// A recording of which the journal consists of this line.
fn with_journal(line: &serde_json::Value) -> (TempDir, PathBuf) {
    let directory = TempDir::new().unwrap();
    let path = directory.path().join("bag");
    let declared = Topics::of_default_node(NodeKind::Single)
        .declared()
        .unwrap();
    let mut writer = Writer::create(&path, &WriterOptions::default(), &declared).unwrap();
    let text = std_msgs::String {
        data: line.to_string(),
    };
    let entry = Entry {
        topic: declared
            .iter()
            .position(|it| it.name.ends_with("/journal"))
            .unwrap(),
        log_time: 0,
        publish_time: 0,
        data: cdr::encode(&text).unwrap().into(),
        checkpoint: true,
    };
    writer.write(&entry).unwrap();
    writer.finish().unwrap();
    (directory, path)
}

/// Version 1 had other names and fields in its entries; only format, version and program are read.
#[test]
fn a_journal_of_version_1_is_rejected_with_the_version_that_recorded_it() {
    let line = serde_json::json!({
        "format": "column_twin journal",
        "version": 1,
        "about": {
            "program": "column_twin 0.1.0",
            "build": "x86_64-linux release 0123",
            "topics": { "~/journal": "/column_twin/journal" },
        },
        "entry": { "twin": { "starting_point": { "number": 0, "stamp": 0, "condition": "stands" } } },
    });
    let (_directory, path) = with_journal(&line);
    let error = verify(&path).unwrap_err();
    assert!(
        matches!(
            &error,
            VerifyError::Journal(JournalError::OtherVersion { version: 1, program: Some(program), .. })
                if program == "column_twin 0.1.0"
        ),
        "{error:?}"
    );
    let text = error.to_string();
    assert!(
        text.contains("version 1, recorded by \"column_twin 0.1.0\"") && text.contains("version 8"),
        "{text}"
    );
    let mut commands = vec!["verify"];
    if cfg!(feature = "viewer") {
        commands.push("replay --rrd impact.rrd");
    }
    for command in commands {
        let line = format!("{command} {}", path.display());
        let (code, _, fault) = super::commands::typed(path.parent().unwrap(), &line);
        assert_eq!(code, 2, "{command}: {fault}");
        assert!(fault.contains("column_twin 0.1.0"), "{command}: {fault}");
    }
    // These commands read any recording with the definitions in it.
    for command in ["info", "export --json --output -"] {
        let line = format!("{command} {}", path.display());
        let (code, _, fault) = super::commands::typed(path.parent().unwrap(), &line);
        assert_eq!(code, 0, "{command}: {fault}");
    }
}
