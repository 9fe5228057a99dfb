//! Impacts on a moving column.

use column_twin::column::{
    Impact, ImpactSpecification, Model, Phase, Progress, Response, Sample, State,
};
use column_twin::twin::{ImpactCommand, MAX_IMPACTS_AHEAD, NoticeLevel, Output, StateOutput};

use crate::{Bench, MS, START, event, light, parameters};

const IMPACT: Impact = Impact {
    mass: 1500.0,
    velocity: 10.0,
    gap: 0.0,
    restitution: 0.0,
    vehicle: None,
    bumper_height: 0.0,
    transverse_force: 0.0,
};

/// Computes two impacts with the mechanics alone, the second after `first_steps`: the plastic work of the first, and the
/// samples of the second.
fn by_hand(first_steps: u64) -> (f64, Vec<Sample>) {
    let parameters = parameters(&[]);
    let model = Model::new(&parameters.column_properties()).expect("stands");
    let mut state = State::at_rest(&model);
    let duration = parameters.response_duration();
    let mut response = Response::begin(&model, &mut state, IMPACT, duration).expect("hits");
    while state.step < first_steps {
        let progress = response.advance(&model, &mut state, 1).expect("converges");
        assert_eq!(progress, Progress::Running);
    }
    let first_work = state.ledger.plastic_work;
    let mut response = Response::begin(&model, &mut state, IMPACT, duration).expect("hits");
    let mut samples = vec![state.sample(&model)];
    loop {
        let progress = response.advance(&model, &mut state, 1).expect("converges");
        samples.push(state.sample(&model));
        if progress != Progress::Running {
            return (first_work, samples);
        }
    }
}

fn check_second(bench: &Bench, first_steps: u64, stamp: i64) {
    let (first_work, expected) = by_hand(first_steps);
    let states: Vec<&StateOutput> = bench
        .states()
        .into_iter()
        .filter(|it| &*it.event_id == "b")
        .collect();
    assert!(states.len() > 30);
    for state in states {
        let step = usize::try_from((state.stamp - stamp) / 100_000).expect("after the impact");
        let impact_impulse = state.sample.impact_impulse;
        assert_eq!(
            state.sample,
            Sample {
                impact_impulse,
                ..expected[step]
            }
        );
    }
    assert_eq!(&*bench.reports().last().expect("a report").event_id, "b");
    let work = first_work + expected.last().expect("the end").plastic_work;
    assert!((bench.status().plastic_work_since_reset - work).abs() < 1e-9 * work);
}

#[test]
fn a_second_impact_hits_the_moving_column() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.go_on(12 * MS);
    let stamp = bench.now;
    bench.hit(event("b", stamp));
    bench.rest();
    check_second(&bench, 120, stamp);
    let first = bench.states().into_iter().find(|it| &*it.event_id == "b");
    let first = first.expect("a state").sample;
    assert_eq!(first.phase, Phase::Contact);
    assert!(
        first.contact_force > 0.0,
        "the deformed column resists immediately"
    );
    let ended = |it: &Output| matches!(it, Output::Notice(notice) if notice.text.contains("for which no report will follow"));
    assert!(bench.out.iter().any(ended));
    let complete = bench
        .forecasts()
        .iter()
        .filter(|it| it.error_estimate.is_none())
        .count();
    assert_eq!((complete, bench.forecasts().len()), (2, 4));
    assert_eq!(bench.status().impacts_since_reset, 2);
}

/// The column is rewound to the stamp of the impact, even after the end of the response to which the impact belongs.
#[test]
fn a_late_impact_hits_the_column_as_it_was_then() {
    for (hit_after, arrives_after) in [(12, 13), (12, 30), (1, 35), (0, 30), (12, 60), (30, 900)] {
        let mut bench = Bench::new(&[]);
        bench.hit(event("a", START));
        bench.go_on(arrives_after * MS);
        let stamp = START + hit_after * MS;
        bench.hit(event("b", stamp));
        bench.rest();
        check_second(&bench, hit_after as u64 * 10, stamp);
    }
}

/// A change of parameters that do not describe the column does not prevent the rewind.
#[test]
fn a_late_impact_rewinds_the_response_after_a_change_of_other_parameters() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.rest();
    bench.change(&[("event.max_ahead", 2.0.into())]);
    let stamp = START + 12 * MS;
    bench.hit(event("b", stamp));
    bench.rest();
    check_second(&bench, 120, stamp);
}

/// The approach takes nearly the maximum duration of a response, which counts from the contact.
#[test]
fn a_distant_vehicle_reaches_the_moving_column() {
    let mut bench = Bench::new(&[("response.duration", 0.1.into())]);
    bench.hit(event("a", START));
    bench.go_on(12 * MS);
    let far = ImpactCommand {
        impact: ImpactSpecification {
            gap: Some(0.99),
            ..event("b", bench.now).impact
        },
        ..event("b", bench.now)
    };
    bench.hit(far);
    bench.rest();
    let report = bench.reports().last().expect("a report").report;
    let touched = report.first_contact_time.expect("a contact");
    assert!((0.09..0.12).contains(&touched), "{touched}");
    assert!(report.end_time <= touched + 0.1001, "{}", report.end_time);
    assert!(report.contact_duration > 0.0);
}

/// It hits the column as it was at the step before.
#[test]
fn an_impact_between_two_steps_keeps_its_stamp() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.go_on(20 * MS);
    let stamp = START + 10 * MS + 77_777;
    bench.hit(event("b", stamp));
    bench.rest();
    check_second(&bench, 100, stamp);
}

#[test]
fn an_impact_ahead_of_the_clock_waits_for_its_stamp() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    let stamp = START + 12 * MS;
    bench.hit(event("b", stamp));
    bench.rest();
    check_second(&bench, 120, stamp);
    let of_first = bench
        .states()
        .iter()
        .filter(|it| &*it.event_id == "a")
        .count();
    assert_eq!(of_first, 13);
}

#[test]
fn an_impact_after_the_response_hits_the_column_at_rest() {
    let mut bench = Bench::new(&[]);
    bench.hit(light("a", START));
    bench.hit(event("b", START + 900 * MS));
    bench.rest();
    assert_eq!(bench.reports().len(), 2);
    check_in_order(&bench);
}

fn check_in_order(bench: &Bench) {
    let stamps: Vec<_> = bench.states().iter().map(|it| it.stamp).collect();
    assert!(stamps.windows(2).all(|pair| pair[0] <= pair[1]));
}

#[test]
fn impacts_are_executed_in_the_order_of_their_stamps() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.go_on(5 * MS);
    bench.hit(event("b", START - MS));
    assert!(
        bench.rejections()[0]
            .rejection
            .reason
            .contains("order of their stamps")
    );
    bench.rest();
    assert_eq!(&*bench.reports()[0].event_id, "a");
}

#[test]
fn the_number_of_impacts_ahead_is_limited() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("first", START));
    for k in 0..=MAX_IMPACTS_AHEAD as i64 {
        bench.hit(light(&k.to_string(), START + (500 - k) * MS));
    }
    assert_eq!(bench.rejections().len(), 1);
    assert!(
        bench.rejections()[0]
            .rejection
            .reason
            .contains("are still to come")
    );
    bench.go_on(1_000 * MS);
    bench.rest();
    assert_eq!(
        bench.status().counts.events_accepted,
        1 + MAX_IMPACTS_AHEAD as u64
    );
    check_in_order(&bench);
}

#[test]
fn a_reset_ends_the_response_and_drops_impacts_ahead() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.hit(event("b", START + 50 * MS));
    bench.go_on(10 * MS);
    bench.reset();
    let forgotten = |it: &Output| {
        matches!(it, Output::Notice(notice) if notice.level == NoticeLevel::Warning
            && notice.text.contains("are still to come: \"b\""))
    };
    assert!(bench.out.iter().any(forgotten));
    bench.go_on(200 * MS);
    assert!(!bench.twin.is_responding());
    assert_eq!((bench.reports().len(), bench.states().len()), (0, 11));
    bench.hit(event("a", bench.now));
    assert!(bench.rejections().is_empty());
}
