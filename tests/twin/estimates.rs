//! Impacts that the sensors have detected: acceptance, following, and events that are the same impact.

use std::sync::Arc;

use column_twin::assessment::Action;
use column_twin::column::Impact;
use column_twin::estimation::{CredibleInterval, Detection, EstimateRecord, ImpactEstimate, Onset};
use column_twin::parameters::Value;
use column_twin::time::Nanos;
use column_twin::twin::{
    Accepted, Command, Decision, EstimateDecision, EstimateOutput, ImpactCommand, Journal, Output,
    RejectedInput, RejectionCode, StateOutput,
};

use crate::{Bench, MS, START, event, fatal};

/// An estimate of an impact with this instant of contact, which is sure enough if `is_sure`.
fn estimate(id: &str, update: u32, contact: Nanos, best: Impact, is_sure: bool) -> EstimateRecord {
    let interval = |mean: f64, width: f64| CredibleInterval {
        mean,
        low: mean * (1.0 - 0.5 * width),
        high: mean * (1.0 + 0.5 * width),
    };
    let width = if is_sure { 0.1 } else { 0.8 };
    let origin = contact - 3_000_000_000;
    let contact_time = CredibleInterval {
        mean: 3.0,
        low: 2.9995,
        high: 3.0005,
    };
    EstimateRecord {
        event_id: id.into(),
        update,
        is_final: false,
        detection: Detection {
            contact: Onset {
                time: 3.0,
                deviation: 3e-4,
            },
            confirmed_at: 3.01,
            sensor: 0,
            zeros: vec![(0.0, 1e-5)],
        },
        origin,
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
            data_until: 3.02,
            contact_time,
            mass: interval(best.mass, width),
            velocity: interval(best.velocity, width),
            momentum: interval(best.mass * best.velocity, width),
            mass_velocity_correlation: -0.9,
            peak_v1: interval(0.1, width),
            residual_v1: interval(0.05, width),
            yielded: 0.99,
            collapsed: 0.0,
            capacity_ratio: interval(0.8, width),
            action: Action::ALL.map(|it| (it, 0.2)).to_vec(),
            vehicle_probabilities: vec![("rigid".to_owned(), 1.0)],
            effective_sample_size: 80.0,
            doubtful_sensors: Vec::new(),
            scale_not_confirmed: Vec::new(),
            vehicle_by_beam: false,
        },
        best,
    }
}

fn last_of(record: EstimateRecord) -> EstimateRecord {
    EstimateRecord {
        is_final: true,
        ..record
    }
}

const RIGHT: Impact = Impact {
    mass: 1500.0,
    velocity: 10.0,
    gap: 0.0,
    restitution: 0.0,
    vehicle: None,
    bumper_height: 0.0,
    transverse_force: 0.0,
};
const WRONG: Impact = Impact {
    mass: 1100.0,
    velocity: 11.0,
    ..RIGHT
};

fn accepting(accept: &str) -> Bench {
    Bench::new(&[("estimation.accept", Value::from(accept))])
}

impl Bench {
    fn detect(&mut self, record: EstimateRecord) -> Accepted {
        let command = Command::Estimate(Arc::new(record));
        self.handle(command)
            .expect("the twin takes it in every state")
    }

    fn confirm(&mut self, id: &str, accept: bool) -> Result<Accepted, RejectionCode> {
        self.handle(Command::DecideEstimate(EstimateDecision {
            event_id: id.to_owned(),
            accept,
            source: "test".into(),
        }))
        .map_err(|rejection| rejection.code)
    }

    fn estimates(&self) -> Vec<&EstimateOutput> {
        let estimates = self.out.iter().filter_map(|it| match it {
            Output::Estimate(estimate) => Some(estimate),
            _ => None,
        });
        estimates.collect()
    }

    fn decision(&self) -> Decision {
        self.estimates().last().expect("an estimate").decision
    }

    fn impacts(&self) -> (u64, u64, u64) {
        let counts = self.status().counts;
        (
            counts.events_accepted,
            counts.events_merged,
            counts.events_rejected,
        )
    }

    fn said(&self, words: &str) -> bool {
        self.out
            .iter()
            .any(|it| matches!(it, Output::Notice(notice) if notice.text.contains(words)))
    }
}

/// The bench after an event, for comparison with estimates of the same impact.
fn after_event(impact: Impact, stamp: Nanos) -> Bench {
    let mut bench = Bench::new(&[]);
    bench.hit(of(impact, "event", stamp));
    bench.rest();
    bench
}

fn of(impact: Impact, id: &str, stamp: Nanos) -> ImpactCommand {
    ImpactCommand {
        impact: impact.into(),
        ..event(id, stamp)
    }
}

/// Whether two columns at rest are the same, bit for bit, after the same outcome.
fn assert_same_outcome(bench: &Bench, expected: &Bench) {
    let own = bench.twin.checkpoint(bench.now).expect("at rest");
    let other = expected.twin.checkpoint(bench.now).expect("at rest");
    assert_eq!(own.state, other.state);
    assert_eq!(
        own.life.plastic_work_since_reset,
        other.life.plastic_work_since_reset
    );
    assert_eq!(own.life.last_impact, other.life.last_impact);
    assert_eq!(own.life.impacts_since_reset, other.life.impacts_since_reset);
    let report = |it: &Bench| it.reports().last().expect("a report").report;
    assert_eq!(report(bench), report(expected));
    let (assessed, expected) = (bench.status().assessed, expected.status().assessed);
    assert_eq!(assessed, expected);
}

#[test]
fn an_estimate_that_nobody_confirms_is_only_published() {
    for accept in ["never", "confirmation"] {
        let mut bench = accepting(accept);
        for update in 0..3 {
            bench.go_on(10 * MS);
            let record = estimate("detected", update, START, RIGHT, true);
            bench.detect(if update == 2 { last_of(record) } else { record });
        }
        let published: Vec<_> = bench
            .estimates()
            .iter()
            .map(|it| it.record.update)
            .collect();
        assert_eq!(published, [0, 1, 2]);
        assert_eq!(bench.decision(), Decision::Pending);
        assert_eq!(bench.estimates()[0].stamp, START);
        assert!(!bench.twin.is_responding());
        assert_eq!(bench.impacts(), (0, 0, 0));
        let waiting = bench.status().waiting_estimate;
        assert_eq!(&*waiting, if accept == "never" { "" } else { "detected" });
        assert!(bench.said("the sensors have detected an impact, \"detected\""));
        if accept == "never" {
            assert_eq!(
                bench.confirm("", true),
                Err(RejectionCode::EstimateNotPending)
            );
            assert_eq!(bench.rejections()[0].what, RejectedInput::Estimate);
        }
    }
}

/// The damage is that of an event with the same impact, bit for bit, and so is every state.
#[test]
fn a_confirmed_estimate_is_an_impact_at_its_instant_of_contact() {
    let mut bench = accepting("confirmation");
    let contact = START + 7 * MS + 123_456;
    bench.go_to(START + 40 * MS);
    bench.detect(estimate("detected", 0, contact, RIGHT, false));
    assert_eq!(bench.confirm("detected", true), Ok(Accepted::Applied));
    assert_eq!(bench.decision(), Decision::Accepted);
    assert_eq!(&*bench.status().waiting_estimate, "");
    bench.rest();
    let mut expected = Bench::new(&[]);
    expected.go_to(START + 40 * MS);
    expected.hit(of(RIGHT, "detected", contact));
    expected.rest();
    assert_same_outcome(&bench, &expected);
    let values =
        |it: &Bench| -> Vec<_> { it.states().iter().map(|it| (it.stamp, it.sample)).collect() };
    assert_eq!(values(&bench), values(&expected));
    assert_eq!(bench.impacts(), (1, 0, 0));
    assert_eq!(&*bench.status().event_id, "detected");
    assert_eq!(
        bench.confirm("detected", false),
        Err(RejectionCode::EstimateNotPending)
    );
}

#[test]
fn a_rejected_estimate_is_none_and_may_be_confirmed_after_all() {
    let mut bench = accepting("confirmation");
    assert_eq!(
        bench.confirm("", true),
        Err(RejectionCode::EstimateNotPending)
    );
    bench.detect(estimate("detected", 0, START, RIGHT, true));
    assert_eq!(
        bench.confirm("another", true),
        Err(RejectionCode::EstimateNotPending)
    );
    assert_eq!(bench.confirm("", false), Ok(Accepted::Applied));
    assert_eq!(bench.decision(), Decision::Declined);
    bench.detect(last_of(estimate("detected", 1, START, RIGHT, true)));
    assert_eq!(bench.decision(), Decision::Declined);
    assert!(!bench.twin.is_responding());
    assert_eq!(bench.confirm("detected", true), Ok(Accepted::Applied));
    bench.rest();
    assert_same_outcome(&bench, &after_event(RIGHT, START));
}

#[test]
fn an_estimate_is_accepted_by_itself_when_it_is_sure_enough_or_final() {
    let mut bench = accepting("automatic");
    bench.detect(estimate("detected", 0, START, WRONG, false));
    assert_eq!(bench.decision(), Decision::Pending);
    let few = estimate("detected", 1, START, WRONG, true);
    let few = EstimateRecord {
        estimate: ImpactEstimate {
            effective_sample_size: 10.0,
            ..few.estimate.clone()
        },
        ..few
    };
    bench.detect(few);
    let open = estimate("detected", 2, START, WRONG, true);
    let open = EstimateRecord {
        estimate: ImpactEstimate {
            yielded: 0.6,
            ..open.estimate.clone()
        },
        ..open
    };
    bench.detect(open);
    assert_eq!(bench.decision(), Decision::Pending);
    bench.detect(estimate("detected", 3, START, RIGHT, true));
    assert_eq!(bench.decision(), Decision::Accepted);
    bench.rest();
    assert_same_outcome(&bench, &after_event(RIGHT, START));

    let mut bench = accepting("automatic");
    bench.detect(last_of(estimate("detected", 0, START, RIGHT, false)));
    assert_eq!(bench.decision(), Decision::Accepted);
    bench.rest();
    assert_same_outcome(&bench, &after_event(RIGHT, START));
}

/// No sample is given out twice, and those after the update are of the impact of the update.
#[test]
fn a_later_estimate_replaces_the_impact_of_the_response() {
    let mut bench = accepting("automatic");
    bench.go_to(START + 12 * MS);
    bench.detect(estimate("detected", 0, START, WRONG, true));
    bench.go_to(START + 20 * MS);
    let earlier = bench.states().len();
    let contact = START + MS / 2;
    bench.detect(estimate("detected", 1, contact, RIGHT, true));
    assert!(
        bench
            .out
            .iter()
            .any(|it| matches!(it, Output::Replaced(id) if **id == *"detected"))
    );
    bench.rest();
    let expected = after_event(RIGHT, contact);
    assert_same_outcome(&bench, &expected);
    assert_eq!(bench.impacts(), (1, 0, 0));
    let stamps: Vec<_> = bench.states().iter().map(|it| it.stamp).collect();
    assert!(
        stamps.windows(2).all(|pair| pair[0] < pair[1]),
        "{stamps:?}"
    );
    let later: Vec<&StateOutput> = bench.states().split_off(earlier);
    assert!(later.len() > 10);
    for state in later {
        let same = expected
            .states()
            .into_iter()
            .find(|it| it.stamp == state.stamp);
        assert_eq!(state.sample, same.expect("the same instants").sample);
        assert_eq!(&*state.event_id, "detected");
    }
    let forecast = bench.forecasts().last().expect("a forecast").report;
    assert_eq!(forecast.max_v1, bench.reports()[0].report.max_v1);
    assert_eq!(bench.reports().len(), 1);
}

/// The same impact once more changes nothing.
#[test]
fn an_estimate_of_the_same_impact_does_not_disturb_the_response() {
    let mut bench = accepting("automatic");
    bench.detect(estimate("detected", 0, START, RIGHT, true));
    bench.go_to(START + 20 * MS);
    bench.detect(last_of(estimate("detected", 1, START, RIGHT, true)));
    bench.rest();
    let mut expected = Bench::new(&[]);
    expected.hit(of(RIGHT, "detected", START));
    expected.rest();
    assert_same_outcome(&bench, &expected);
    assert!(!bench.out.iter().any(|it| matches!(it, Output::Replaced(_))));
    assert_eq!(bench.states().len(), expected.states().len());
}

#[test]
fn a_later_estimate_takes_back_a_response_that_is_over() {
    let mut bench = accepting("automatic");
    bench.detect(estimate("detected", 0, START, WRONG, true));
    bench.rest();
    bench.detect(last_of(estimate("detected", 1, START, RIGHT, true)));
    assert!(bench.twin.is_responding());
    bench.rest();
    assert_same_outcome(&bench, &after_event(RIGHT, START));
    assert_eq!(bench.reports().len(), 2);
    let taken_back = bench
        .out
        .iter()
        .filter(|it| matches!(it, Output::Journal(Journal::Command(record)) if record.taken_back));
    assert_eq!(taken_back.count(), 1);
    assert_eq!(
        bench
            .saved()
            .last()
            .expect("saved")
            .plastic_work_since_reset,
        bench.status().plastic_work_since_reset
    );
}

#[test]
fn nothing_follows_the_final_estimate() {
    let mut bench = accepting("automatic");
    bench.detect(last_of(estimate("detected", 4, START, RIGHT, true)));
    for update in [3, 4, 5] {
        let late = bench.detect(estimate("detected", update, START, WRONG, true));
        assert_eq!(late, Accepted::Unchanged);
    }
    bench.rest();
    assert_same_outcome(&bench, &after_event(RIGHT, START));
    assert_eq!(bench.estimates().len(), 1);
}

/// On a moving column the instant of contact remains, and the motion before it too.
#[test]
fn a_later_estimate_replaces_the_second_impact_on_a_moving_column() {
    let second = START + 12 * MS;
    let mut bench = accepting("automatic");
    bench.hit(event("first", START));
    bench.go_to(START + 20 * MS);
    bench.change(&[("estimation.merge_window", 0.001.into())]);
    bench.detect(estimate("detected", 0, second, WRONG, true));
    bench.go_to(START + 30 * MS);
    bench.detect(last_of(estimate("detected", 1, second + MS, RIGHT, true)));
    bench.rest();
    let mut expected = Bench::new(&[]);
    expected.hit(event("first", START));
    expected.go_to(START + 20 * MS);
    expected.hit(of(RIGHT, "detected", second));
    expected.rest();
    assert_same_outcome(&bench, &expected);
}

/// After another impact nobody can say what the column would be like with another first one.
#[test]
fn an_estimate_is_not_followed_once_another_impact_has_come() {
    let mut bench = accepting("automatic");
    bench.change(&[("estimation.merge_window", 0.001.into())]);
    bench.detect(estimate("detected", 0, START, RIGHT, true));
    bench.go_to(START + 12 * MS);
    bench.hit(event("second", bench.now));
    bench.detect(last_of(estimate("detected", 1, START, WRONG, true)));
    bench.rest();
    let mut expected = Bench::new(&[]);
    expected.hit(of(RIGHT, "detected", START));
    expected.go_to(START + 12 * MS);
    expected.hit(event("second", expected.now));
    expected.rest();
    assert_same_outcome(&bench, &expected);
    assert!(bench.said("cannot be followed"));
}

#[test]
fn an_event_of_an_accepted_estimate_is_merged_with_it() {
    let mut bench = accepting("automatic");
    bench.go_to(START + 30 * MS);
    bench.detect(estimate("detected", 0, START, RIGHT, true));
    let seen = ImpactCommand {
        stamp: START - 200 * MS,
        ..of(WRONG, "camera", START)
    };
    assert_eq!(bench.handle(Command::Impact(seen)), Ok(Accepted::Merged));
    assert_eq!(bench.impacts(), (1, 1, 0));
    let last = bench.estimates().pop().expect("published once more");
    assert_eq!(last.merged_event_id.as_deref(), Some("camera"));
    assert_eq!(last.decision, Decision::Accepted);
    let merged: Vec<_> = bench
        .out
        .iter()
        .filter_map(|it| match it {
            Output::Merged(merged) => Some(merged),
            _ => None,
        })
        .collect();
    assert_eq!(merged.len(), 1);
    assert_eq!(merged[0].striking.impact, WRONG);
    // As evidence, with the standard deviations of the parameters.
    let evidence = &merged[0].evidence;
    let said = (&*evidence.event_id, evidence.mass, evidence.velocity);
    assert_eq!(said, ("camera", WRONG.mass, WRONG.velocity));
    let settings = &bench.twin.parameters().settings().estimation;
    assert_eq!(evidence.mass_deviation, settings.event_mass_deviation);
    assert_eq!(
        evidence.velocity_deviation,
        settings.event_velocity_deviation
    );
    assert_eq!(
        (&*merged[0].event_id, &*merged[0].estimate_id),
        ("camera", "detected")
    );
    assert!(bench.said("merged with \"detected\""));
    bench.hit(of(WRONG, "camera", START));
    assert_eq!(
        bench.rejections()[0].rejection.code,
        RejectionCode::EventIdRepeated
    );
    bench.rest();
    let expected = after_event(RIGHT, START);
    let report = |it: &Bench| it.reports().last().expect("a report").report;
    assert_eq!(report(&bench), report(&expected));
    let second = of(RIGHT, "other", bench.now);
    bench.go_on(600 * MS);
    let second = ImpactCommand {
        stamp: bench.now,
        ..second
    };
    assert_eq!(bench.handle(Command::Impact(second)), Ok(Accepted::Applied));
    assert_eq!(bench.impacts(), (2, 1, 1));
}

/// A merged event has to be a valid one, as any other.
#[test]
fn an_invalid_event_is_rejected_even_if_it_could_be_merged() {
    let mut bench = accepting("automatic");
    bench.detect(estimate("detected", 0, START, RIGHT, true));
    let faulty = [
        of(
            Impact {
                mass: f64::NAN,
                ..RIGHT
            },
            "a",
            START,
        ),
        of(
            Impact {
                velocity: -1.0,
                ..RIGHT
            },
            "b",
            START,
        ),
        ImpactCommand {
            column_id: "another".to_owned(),
            ..of(RIGHT, "c", START)
        },
        of(RIGHT, "detected", START),
    ];
    for faulty in faulty {
        bench.hit(faulty);
    }
    assert_eq!(bench.impacts(), (1, 0, 4));
}

#[test]
fn an_event_that_comes_first_is_the_impact_and_the_estimate_belongs_to_it() {
    for gap in [None, Some(1.0)] {
        let mut bench = accepting("automatic");
        let mut seen = of(RIGHT, "camera", START);
        seen.impact.gap = gap;
        bench.hit(seen.clone());
        bench.go_to(START + 20 * MS);
        // With a gap the vehicle touches the column 0.1 s after the stamp.
        let contact = START + gap.map_or(0, |_| 100 * MS);
        bench.change(&[("estimation.merge_window", 0.05.into())]);
        bench.detect(estimate("detected", 0, contact + 2 * MS, WRONG, true));
        bench.detect(last_of(estimate(
            "detected",
            1,
            contact + 2 * MS,
            WRONG,
            true,
        )));
        let last = bench.estimates().pop().expect("published");
        assert_eq!(last.decision, Decision::Merged);
        assert_eq!(last.merged_event_id.as_deref(), Some("camera"));
        assert_eq!(
            bench.confirm("detected", true),
            Err(RejectionCode::EstimateNotPending)
        );
        bench.rest();
        let mut expected = Bench::new(&[]);
        expected.hit(seen);
        expected.rest();
        assert_same_outcome(&bench, &expected);
        assert_eq!(bench.impacts(), (1, 0, 0));
    }
}

#[test]
fn an_event_decides_about_an_estimate_that_waits() {
    let mut bench = accepting("confirmation");
    bench.go_to(START + 20 * MS);
    bench.detect(estimate("detected", 0, START, WRONG, true));
    assert_eq!(&*bench.status().waiting_estimate, "detected");
    bench.hit(of(RIGHT, "person", START + 3 * MS));
    assert_eq!(bench.decision(), Decision::Merged);
    assert_eq!(&*bench.status().waiting_estimate, "");
    bench.detect(last_of(estimate("detected", 1, START, WRONG, true)));
    bench.rest();
    assert_eq!(bench.impacts(), (1, 0, 0));
    assert_eq!(bench.reports().len(), 1);
    assert_eq!(&*bench.reports()[0].event_id, "person");
}

/// Two impacts that are further apart than the window are two.
#[test]
fn an_event_outside_of_the_window_is_another_impact() {
    let mut bench = accepting("automatic");
    bench.detect(estimate("detected", 0, START, RIGHT, true));
    bench.go_to(START + 501 * MS);
    bench.hit(event("later", bench.now));
    assert_eq!(bench.impacts(), (2, 0, 0));
    bench.rest();
    assert_eq!(bench.status().impacts_since_reset, 2);
}

#[test]
fn a_reset_forgets_what_the_sensors_have_detected_before() {
    let mut bench = accepting("automatic");
    bench.detect(estimate("detected", 0, START, RIGHT, true));
    bench.go_to(START + 20 * MS);
    bench.reset();
    assert_eq!(
        bench.detect(last_of(estimate("detected", 1, START, RIGHT, true))),
        Accepted::Unchanged
    );
    assert!(!bench.twin.is_responding());
    assert_eq!(bench.status().impacts_since_reset, 0);
    assert_eq!(
        bench.confirm("", true),
        Err(RejectionCode::EstimateNotPending)
    );
    bench.go_on(500 * MS);
    bench.detect(estimate("again", 0, bench.now, RIGHT, true));
    assert!(bench.twin.is_responding());
}

#[test]
fn a_column_that_has_collapsed_takes_no_estimate() {
    let mut bench = Bench::new(&[
        ("estimation.accept", Value::from("automatic")),
        ("top.load", 2e6.into()),
    ]);
    bench.hit(fatal("crash", START));
    bench.rest();
    bench.go_on(1_000 * MS);
    bench.detect(last_of(estimate("detected", 0, bench.now, RIGHT, true)));
    assert_eq!(bench.decision(), Decision::Rejected);
    assert_eq!(bench.impacts(), (1, 0, 1));
    let rejected = bench.rejections().pop().expect("rejected");
    assert_eq!(rejected.rejection.code, RejectionCode::ColumnCollapsed);
    assert_eq!(&*rejected.event_id, "detected");
}

/// Whatever an estimate contains, the twin goes on, and its journal reads back.
#[test]
fn impossible_numbers_are_rejected_and_read_back_from_the_journal() {
    for wrong in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e300] {
        let mut bench = accepting("automatic");
        let best = Impact {
            mass: wrong,
            ..RIGHT
        };
        let mut record = last_of(estimate("detected", 0, START, best, true));
        record.estimate.residual_v1.mean = wrong;
        record.estimate.contact_time.low = f64::NEG_INFINITY;
        record.detection.zeros = vec![(wrong, f64::NAN)];
        bench.detect(record.clone());
        assert_eq!(bench.decision(), Decision::Rejected, "{wrong}");
        record.event_id = "nowhere".into();
        record.estimate.contact_time.mean = wrong * 1e9;
        bench.detect(record);
        bench.go_on(100 * MS);
        assert!(!bench.twin.is_responding());
        for output in &bench.out {
            let Output::Journal(entry) = output else {
                continue;
            };
            let text = serde_json::to_string(entry).expect("JSON");
            let read: Journal = serde_json::from_str(&text).expect("reads back");
            assert_eq!(serde_json::to_string(&read).expect("JSON"), text);
        }
        bench.hit(event("genuine", bench.now));
        assert!(bench.twin.is_responding());
    }
}

/// What was detected is part of a checkpoint: a twin that continues from it goes on alike.
#[test]
fn a_twin_from_a_checkpoint_knows_what_was_detected() {
    let mut bench = accepting("confirmation");
    bench.hit(event("event", START));
    bench.rest();
    bench.go_on(2_000 * MS);
    bench.detect(last_of(estimate(
        "detected",
        0,
        bench.now - 10 * MS,
        RIGHT,
        true,
    )));
    let checkpoint = bench.twin.checkpoint(bench.now).expect("at rest");
    let text = serde_json::to_string(&checkpoint).expect("JSON");
    let read = serde_json::from_str(&text).expect("reads back");
    assert_eq!(checkpoint, read);
    let twin = column_twin::twin::Twin::from_checkpoint(&read, Box::new(|| 0)).expect("stands");
    let mut other = Bench {
        twin,
        now: bench.now,
        out: Vec::new(),
    };
    assert_eq!(&*other.status().waiting_estimate, "detected");
    for it in [&mut bench, &mut other] {
        assert_eq!(it.confirm("detected", true), Ok(Accepted::Applied));
        it.rest();
    }
    assert_same_outcome(&other, &bench);
}
