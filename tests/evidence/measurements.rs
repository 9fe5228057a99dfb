//! Recorded measurements: the journal shows every change of them.

use column_twin::endpoints;
use column_twin::evidence::{Verification, verify};
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::Measurement;
use column_twin::messages::std_msgs::Header;
use column_twin::parameters::RecordMode;
use column_twin::recording::Message;

use super::copies::{messages, written};
use super::recorded_twin::{MS, RecordedTwin, event, parameters};

const TOPIC: &str = "/measurements";

/// Measurements before, during and after an impact, with times between the lines of the journal.
fn recorded(mode: RecordMode) -> Vec<Message> {
    let mut twin = RecordedTwin::with_mode(parameters(), mode);
    let measure = |twin: &RecordedTwin| {
        twin.measure(&Measurement {
            header: Header {
                stamp: Time::from_nanos(twin.now - 11 * MS).expect("a stamp"),
                frame_id: String::new(),
            },
            column_id: "column".to_owned(),
            sensor_id: "laser".to_owned(),
            sample_period: 1e-4,
            values: vec![0.25; 100],
        });
    };
    for _ in 0..30 {
        measure(&twin);
        twin.advance(100 * MS);
    }
    twin.hit(event("a", twin.now));
    for _ in 0..30 {
        measure(&twin);
        twin.advance(10 * MS);
    }
    twin.until_rest();
    twin.advance(1_200 * MS);
    measure(&twin);
    let finished = twin.finish();
    messages(&finished.path())
}

fn verified(messages: &[Message]) -> Verification {
    let (_directory, path) = written(messages);
    verify(&path).expect("a journal")
}

#[test]
fn genuine_measurements_are_recorded_in_both_modes_with_the_time_of_their_arrival() {
    for mode in [RecordMode::Always, RecordMode::Events] {
        let all = recorded(mode);
        let measurements: Vec<_> = all.iter().filter(|it| &*it.topic == TOPIC).collect();
        assert_eq!(measurements.len(), 61);
        for message in measurements {
            let measurement: Measurement = cdr::decode(&message.data).expect("readable");
            let stamp = measurement.header.stamp.to_nanos().expect("a stamp");
            assert_eq!(message.publish_time, stamp + 11 * MS);
            assert_eq!(&*message.type_name, endpoints::MEASUREMENTS.type_name);
        }
        let found = verified(&all);
        assert!(found.is_equal(), "{found}");
    }
}

#[test]
fn every_change_of_a_measurement_is_found() {
    let all = recorded(RecordMode::Always);
    let places: Vec<_> = (0..all.len())
        .filter(|index| &*all[*index].topic == TOPIC)
        .collect();
    for place in [places[0], places[20], places[45], places[60]] {
        let mut changed = all.clone();
        let last = changed[place].data.len() - 1;
        changed[place].data[last] ^= 1;
        let mut moved = all.clone();
        moved[place].publish_time += 1;
        let mut dropped = all.clone();
        dropped.remove(place);
        let mut doubled = all.clone();
        doubled.insert(place, all[place].clone());
        for (what, forged) in [
            ("changed", changed),
            ("moved", moved),
            ("dropped", dropped),
            ("doubled", doubled),
        ] {
            let found = verified(&forged);
            assert!(!found.is_equal(), "{what}: {found}");
        }
    }
}
