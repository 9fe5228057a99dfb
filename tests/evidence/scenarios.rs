//! Recordings of many scenarios are equal to their recomputation.

use column_twin::column::ImpactSpecification;
use column_twin::evidence::verify;
use column_twin::outgoing::Topic;
use column_twin::parameters::{RecordMode, Value};
use column_twin::recording::{Reader, RecorderOptions};
use column_twin::twin::{ImpactCommand, TwinPhase};

use super::recorded_twin::{MS, RecordedTwin, event, parameters};

#[test]
fn one_impact() {
    let mut twin = RecordedTwin::new(parameters());
    twin.hit(event("a", twin.now));
    twin.until_rest();
    let found = twin.finish().assert_verified();
    // Nothing was detected.
    let expected = Topic::ALL.map(|it| it != Topic::ImpactEstimate);
    assert_eq!(
        found.topics.each_ref().map(|it| it.compared > 0),
        expected,
        "{found}"
    );
    assert_eq!(
        (found.checkpoints, found.states_at_rest, found.inputs),
        (2, 1, 1)
    );
}

#[test]
fn damage_over_several_impacts_with_changes_in_between() {
    let mut twin = RecordedTwin::new(parameters());
    for (index, id) in ["a", "b", "c"].into_iter().enumerate() {
        twin.hit(ImpactCommand {
            impact: ImpactSpecification {
                velocity: 4.0 + index as f64,
                gap: Some(0.05 * index as f64),
                ..event(id, twin.now).impact
            },
            ..event(id, twin.now)
        });
        twin.until_rest();
        twin.advance(1_500 * MS);
        twin.set(&[("top.load", Value::from(1e5 * (1.0 + index as f64)))]);
        twin.set(&[("impact.restitution", Value::from(0.25))]);
        twin.advance(MS);
    }
    assert!(twin.twin.status(twin.now).residual_v1 > 0.0);
    twin.finish().assert_verified();
}

#[test]
fn a_second_impact_during_the_response_on_time_late_and_early() {
    for offset in [0, -7, 9] {
        let mut twin = RecordedTwin::new(parameters());
        twin.hit(event("a", twin.now));
        (0..12).for_each(|_| twin.advance(MS));
        twin.hit(ImpactCommand {
            impact: ImpactSpecification {
                gap: Some(0.02),
                ..event("b", twin.now + offset * MS).impact
            },
            ..event("b", twin.now + offset * MS)
        });
        twin.until_rest();
        twin.finish().assert_verified();
    }
}

/// The response that was over is resumed.
#[test]
fn an_impact_that_arrives_after_the_end_of_the_response_to_which_it_belongs() {
    let mut twin = RecordedTwin::new(parameters());
    let stamp = twin.now;
    twin.hit(event("a", stamp));
    twin.until_rest();
    twin.hit(event("b", stamp + 5 * MS));
    assert!(twin.twin.is_responding());
    twin.until_rest();
    twin.hit(event("c", twin.now));
    twin.until_rest();
    twin.finish().assert_verified();
}

#[test]
fn a_waiting_parameter_change_and_a_reset_during_a_response() {
    let mut twin = RecordedTwin::new(parameters());
    twin.hit(event("a", twin.now));
    (0..5).for_each(|_| twin.advance(MS));
    twin.set(&[("top.load", Value::from(3e5))]);
    twin.set(&[("publish_rate", Value::from(500.0))]);
    twin.until_rest();
    twin.advance(MS);
    twin.hit(event("b", twin.now));
    (0..5).for_each(|_| twin.advance(MS));
    twin.reset();
    twin.advance(MS);
    twin.set(&[("geometry.length_below", Value::from(1.5))]);
    twin.hit(ImpactCommand {
        impact: ImpactSpecification {
            height: Some(1.2),
            ..event("a", twin.now).impact
        },
        ..event("a", twin.now)
    });
    twin.until_rest();
    twin.finish().assert_verified();
}

/// Some forecasts are completed after another impact has ended their responses, others are given up.
#[test]
fn impacts_that_follow_one_another_faster_than_forecasts_are_computed() {
    for burst in [2, 5, 40] {
        let mut twin = RecordedTwin::new(parameters());
        for impact in 0..burst {
            twin.hit(event(&format!("{impact}"), twin.now));
            if impact % 3 == 1 {
                twin.advance(MS);
            }
        }
        twin.until_rest();
        twin.hit(event("last", twin.now));
        twin.advance(MS);
        twin.reset();
        twin.advance(MS);
        let found = twin.finish().assert_verified();
        let forecasts = &found.topics[Topic::ImpactForecast.index()];
        assert!(forecasts.compared > burst, "{found}");
    }
}

/// The journal has the jump; the response is carried to its end at once, with the stamps it would have had.
#[test]
fn a_clock_that_jumps_back_during_a_response_and_at_rest() {
    let mut twin = RecordedTwin::new(parameters());
    twin.hit(event("a", twin.now));
    (0..12).for_each(|_| twin.advance(MS));
    twin.hit(event("b", twin.now + 5 * MS));
    twin.jump_back(10_000 * MS);
    while twin.twin.is_responding() {
        twin.advance(0);
    }
    twin.advance(MS);
    twin.hit(event("c", twin.now));
    twin.until_rest();
    twin.jump_back(400 * MS);
    twin.advance(MS);
    // Its stamp lies within the last response, to which it does not belong.
    twin.hit(event("d", twin.now));
    twin.until_rest();
    let found = twin.finish().assert_verified();
    assert_eq!(
        found.topics[Topic::ImpactReport.index()].compared,
        3,
        "{found}"
    );
}

#[test]
fn a_collapse_and_rejected_commands() {
    let mut twin = RecordedTwin::new(parameters());
    twin.set(&[("top.load", Value::from(2e6))]);
    let now = twin.now;
    let bad = [
        ImpactCommand {
            impact: ImpactSpecification {
                mass: f64::NAN,
                ..event("nan", now).impact
            },
            ..event("nan", now)
        },
        ImpactCommand {
            impact: ImpactSpecification {
                velocity: f64::NEG_INFINITY,
                ..event("inf", now).impact
            },
            ..event("inf", now)
        },
        ImpactCommand {
            column_id: "other\n".to_owned(),
            ..event("other", now)
        },
        ImpactCommand {
            impact: ImpactSpecification {
                gap: Some(f64::INFINITY),
                ..event("gap", now).impact
            },
            ..event("gap", now)
        },
        event("", now),
        event(&"x".repeat(5000), now),
        event("old", now - 3600 * 1000 * MS),
    ];
    for event in bad {
        twin.hit(event);
        twin.advance(MS);
    }
    twin.set(&[("top.load", Value::from(f64::NAN))]);
    twin.set(&[("no.such", Value::from("x"))]);
    twin.hit(ImpactCommand {
        impact: ImpactSpecification {
            mass: 100_000.0,
            velocity: 50.0,
            ..event("truck", twin.now).impact
        },
        ..event("truck", twin.now)
    });
    twin.until_rest();
    assert_eq!(twin.twin.status(twin.now).phase, TwinPhase::Collapsed);
    twin.hit(event("after", twin.now));
    twin.advance(MS);
    twin.reset();
    twin.hit(event("new", twin.now));
    twin.until_rest();
    twin.finish().assert_verified();
}

/// Commands arrive while the twin is behind the clock.
#[test]
fn a_twin_that_catches_up() {
    let mut twin = RecordedTwin::new(parameters());
    let stamp = twin.now;
    twin.now += 900 * MS;
    twin.hit(event("a", stamp));
    twin.advance(0);
    twin.hit(event("b", stamp + 700 * MS));
    twin.advance(0);
    twin.hit(event("c", stamp + 600 * MS));
    twin.until_rest();
    twin.finish().assert_verified();
}

#[test]
fn the_mode_events_records_little_while_the_column_is_at_rest() {
    let count = |mode| {
        let mut twin = RecordedTwin::with_mode(parameters(), mode);
        (0..20).for_each(|_| twin.advance(1_000 * MS));
        twin.hit(event("a", twin.now));
        twin.until_rest();
        (0..20).for_each(|_| twin.advance(1_000 * MS));
        twin.hit(event("a", twin.now));
        (0..20).for_each(|_| twin.advance(1_000 * MS));
        let found = twin.finish().assert_verified();
        (
            found.topics[Topic::ColumnState.index()].compared,
            found.topics[Topic::TwinStatus.index()].compared,
        )
    };
    let ((states, few), (all_states, many)) =
        (count(RecordMode::Events), count(RecordMode::Always));
    assert_eq!(states, all_states);
    assert!((5..=10).contains(&few) && many > 60, "{few} {many}");
}

/// Bytes of the recording of one impact.
pub fn size_of_one_impact() -> u64 {
    let mut twin = RecordedTwin::new(parameters());
    twin.hit(event("a", twin.now));
    twin.until_rest();
    let recordings = twin.finish();
    Reader::open(&recordings.path()).expect("readable").bytes()
}

fn of_size(max_file_size: u64) -> RecordedTwin {
    let limited = |options| RecorderOptions {
        max_file_size,
        ..options
    };
    RecordedTwin::with_options(parameters(), RecordMode::Always, limited)
}

/// Each recording begins with a checkpoint and can be verified without the others; it states what it cannot check because it
/// belongs to an earlier one.
#[test]
fn every_recording_can_be_verified_alone() {
    // Most impacts exceed the limit, and none exceeds it twice, where a recording would have to end during a response. The
    // timing of the recorder's thread decides when it notices.
    let mut twin = of_size(size_of_one_impact() * 6 / 10);
    let mut stamp = twin.now;
    for id in ["a", "b", "c"] {
        stamp = twin.now;
        twin.hit(event(id, stamp));
        twin.until_rest();
        twin.advance(MS);
    }
    twin.hit(event("late", stamp + 5 * MS));
    twin.until_rest();
    let recordings = twin.finish();
    let paths = recordings.paths();
    assert!(paths.len() > 1, "{paths:?}");
    let mut incomplete = 0;
    for (index, path) in paths.iter().enumerate() {
        let found = verify(path).expect("can be verified");
        assert!(found.is_equal(), "{found}");
        assert!(found.checkpoints > 0, "{found}");
        let whole = found.unchecked.is_empty();
        let all = found.topics.iter().map(|it| it.recorded).sum::<u64>();
        assert_eq!(found.compared() == all, whole, "{index}: {found}");
        incomplete += usize::from(!whole);
    }
    // At most the recording that begins after the response to which the late impact belongs.
    assert!(incomplete < 2, "{incomplete} of {paths:?}");
}

/// The result states what could not be checked.
#[test]
fn a_recording_that_begins_during_a_response_is_no_forgery() {
    // Less than one impact, but more than the beginning of every recording, so that not every message starts a new one.
    let mut twin = of_size(size_of_one_impact() * 4 / 10);
    for id in ["a", "b"] {
        twin.hit(event(id, twin.now));
        (0..20).for_each(|_| twin.advance(MS));
        twin.set(&[("impact.gap", Value::from(0.01))]);
        twin.until_rest();
        (0..3).for_each(|_| twin.advance(1000 * MS));
    }
    let recordings = twin.finish();
    let paths = recordings.paths();
    assert!(paths.len() > 1, "{paths:?}");
    let mut unchecked = 0;
    for path in &paths {
        let found = verify(path).expect("can be verified");
        assert!(!found.is_contradicted(), "{found}");
        assert_eq!(found.is_equal(), found.compared() > 0, "{found}");
        // A missing entry of the journal may affect no message.
        assert!(
            found.unchecked_messages() == 0 || !found.unchecked.is_empty(),
            "{found}"
        );
        unchecked += usize::from(!found.unchecked.is_empty());
    }
    // The number depends on the timing of the recorder's thread; the first recording begins at rest.
    assert!(unchecked < paths.len(), "{unchecked} of {}", paths.len());
}

/// Vehicles by name and by numbers, on a column whose strength depends on the strain rate and on what has yielded.
#[test]
fn vehicles_strain_rate_hardening_and_capacity() {
    let changes = [
        ("rate.law", Value::from("logarithmic")),
        ("hardening.ratio", Value::from(0.005)),
        ("section.height", Value::from(0.22)),
        ("vehicle.name", Value::from("")),
        ("vehicle.masses", Value::from(vec![800.0, 700.0])),
        ("vehicle.slack", Value::from(vec![0.05])),
        ("vehicle.spring_1.crush", Value::from(vec![0.2, 1.0])),
        ("vehicle.spring_1.force", Value::from(vec![200e3, 400e3])),
        ("vehicle.spring_1.unloading_stiffness", Value::from(5e6)),
        ("vehicle.spring_2.crush", Value::from(vec![0.1, 0.5])),
        ("vehicle.spring_2.force", Value::from(vec![300e3, 300e3])),
        ("vehicle.spring_2.unloading_stiffness", Value::from(8e6)),
    ];
    let changed = parameters().with_changes(changes.map(|(name, value)| (name.to_owned(), value)));
    let mut twin = RecordedTwin::new(changed.expect("admissible"));
    for (id, vehicle, mass, velocity) in [
        ("a", "", 2000.0, 9.0),
        ("b", "van", f64::NAN, 8.0),
        ("c", "rigid", 1500.0, 8.0),
        ("d", "lorry_8t", 0.0, 4.0),
        ("e", "tank", 0.0, 4.0),
    ] {
        twin.hit(ImpactCommand {
            vehicle: vehicle.to_owned(),
            impact: ImpactSpecification {
                mass,
                velocity,
                ..event(id, twin.now).impact
            },
            ..event(id, twin.now)
        });
        // The second one hits the moving column.
        match id {
            "a" => (0..30).for_each(|_| twin.advance(MS)),
            _ => twin.until_rest(),
        }
        twin.set(&[(
            "assessment.criteria",
            Value::from(vec!["damage_20".to_owned()]),
        )]);
        twin.advance(1_100 * MS);
    }
    let status = twin.twin.status(twin.now);
    assert_eq!(
        status.last_rejection_code,
        Some(column_twin::twin::RejectionCode::VehicleInvalid)
    );
    assert!(status.assessed.is_some_and(|it| it.remaining.ratio < 1.0));
    assert!(status.vehicle.permanent_crush[0] > 0.0);
    twin.finish().assert_verified();
}

/// SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % limit
    }

    pub fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u64) as usize]
    }
}

pub fn some_impact(random: &mut Random, id: u64, now: i64) -> ImpactCommand {
    ImpactCommand {
        vehicle: random.of(&["", "", "small_car", "lorry_8t"]).to_owned(),
        impact: ImpactSpecification {
            mass: random.of(&[300.0, 1500.0, 0.0, -1.0]),
            velocity: random.of(&[1.0, 3.0, 7.0]),
            gap: random.of(&[None, Some(0.01), Some(0.1), Some(0.123_456)]),
            restitution: random.of(&[None, Some(0.0), Some(0.5)]),
            height: random.of(&[None, None, Some(1.1)]),
            direction: None,
        },
        ..event(
            &id.to_string(),
            now + random.of(&[0, 0, 3, -11, -400]) * MS / 2,
        )
    }
}

/// Random commands and intervals between calls: the recomputation advances in other strides than the recorded twin.
#[test]
fn random_scenarios() {
    let mut responses = 0;
    for seed in 0..60 {
        let random = &mut Random(seed);
        let mut twin = RecordedTwin::new(parameters());
        for id in 0..40 {
            match random.below(12) {
                0..=4 => {
                    let impact = some_impact(random, id, twin.now);
                    twin.hit(impact);
                }
                5 => twin.set(&[("top.load", Value::from(random.of(&[0.0, 1e5, 4e5, 1e9])))]),
                6 => twin.set(&[(
                    "publish_rate",
                    Value::from(random.of(&[100.0, 1000.0, 3000.0])),
                )]),
                7 => twin.reset(),
                8 => twin.until_rest(),
                _ => {
                    for _ in 0..random.below(30) {
                        let nanos = random.of(&[137_000, MS, 3 * MS + 1]);
                        twin.advance(nanos);
                    }
                }
            }
        }
        twin.until_rest();
        responses += twin.twin.position().response;
        twin.finish().assert_verified();
    }
    assert!(responses > 300, "{responses}");
}
