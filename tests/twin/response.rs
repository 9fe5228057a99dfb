//! Responses: from the event to the forecast and the report.

use column_twin::column::{ImpactSpecification, Outcome, Report, Sample, simulate};
use column_twin::parameters::{Parameters, Value};
use column_twin::twin::{ImpactCommand, Output, TwinPhase};

use crate::{Bench, MS, START, event, fatal, light, parameters};

/// The result of `column-twin simulate`: every step, and the report.
fn simulated(parameters: &Parameters, event: &ImpactCommand) -> (Vec<Sample>, Report) {
    let impact = event
        .impact
        .complete(&parameters.impact(), None, 0.0)
        .expect("an impact");
    let mut samples = Vec::new();
    let properties = parameters.column_properties();
    let report = simulate(
        &properties,
        &impact,
        parameters.response_duration(),
        &mut |sample| {
            samples.push(*sample);
        },
    );
    (samples, report.expect("it can be simulated"))
}

/// Checks that the samples of the twin are those of the simulation at the times of `publish_rate`.
fn check_against_simulation(changes: &[(&str, Value)], event: &ImpactCommand) {
    let mut bench = Bench::new(changes);
    bench.hit(event.clone());
    bench.rest();
    let (steps, report) = simulated(bench.twin.parameters(), event);
    assert_eq!(bench.reports()[0].report, report);
    assert_eq!(bench.forecasts()[0].report, report);

    let states = bench.states();
    let contact = report.first_contact_time.expect("it hits");
    let mut last_time = f64::NEG_INFINITY;
    let mut compared = 0;
    for state in &states {
        let since = (state.stamp - event.stamp) as f64 * 1e-9;
        assert!(
            (since - state.sample.time).abs() < 1e-12,
            "{since} {}",
            state.sample.time
        );
        // The impact impulse of the twin is the sum since the previous sample, that of the simulation belongs to one step.
        let impact_impulse = steps
            .iter()
            .filter(|step| step.time > last_time && step.time <= state.sample.time)
            .fold(0.0, |sum, step| sum + step.impact_impulse);
        last_time = state.sample.time;
        match steps.iter().find(|step| step.time == state.sample.time) {
            Some(step) => {
                assert_eq!(
                    state.sample,
                    Sample {
                        impact_impulse,
                        ..*step
                    }
                );
                compared += 1;
            }
            // The simulation takes the approach to a column at rest in one step.
            None => assert!(state.sample.time < contact, "{}", state.sample.time),
        }
    }
    let expected = (report.end_time - contact) / 1e-3;
    assert!(f64::from(compared) >= expected, "{compared} of {expected}");
    assert_eq!(states.last().expect("some").sample.time, report.end_time);
}

/// Including the last state, whose time is not a multiple of the period.
#[test]
fn every_state_is_output_when_it_is_due() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("punctual", START));
    let mut seen = 0;
    while bench.twin.is_responding() {
        bench.twin.run_ahead(u64::MAX, bench.now, &mut bench.out);
        bench.now = bench.twin.next_deadline(bench.now);
        bench.twin.advance_to(bench.now, &mut bench.out);
        let states = bench.states();
        assert!(states[seen..].iter().all(|it| it.stamp == bench.now));
        seen = states.len();
    }
    let last = *bench.states().last().expect("some");
    assert_eq!(last.phase, TwinPhase::Rest);
    assert_ne!(
        (last.stamp - START) % MS,
        0,
        "the response of this test must end between two periods"
    );
}

#[test]
fn the_stream_equals_the_simulation() {
    check_against_simulation(&[], &event("plain", START));
}

#[test]
fn the_stream_equals_the_simulation_with_a_gap_and_rebounds() {
    for gap in [0.0123, 0.2, 1.7] {
        let event = ImpactCommand {
            impact: ImpactSpecification {
                gap: Some(gap),
                restitution: Some(0.6),
                ..event("gap", START).impact
            },
            ..event("gap", START)
        };
        check_against_simulation(&[], &event);
    }
}

#[test]
fn the_stream_equals_the_simulation_with_the_papers_scheme() {
    check_against_simulation(
        &[("solver.scheme", "midpoint".into())],
        &event("midpoint", START),
    );
}

#[test]
fn the_stream_equals_the_simulation_of_light_touches() {
    check_against_simulation(&[("damping.ratio", 0.05.into())], &light("light", START));
}

/// Afterwards the column equals the undamaged one bit for bit.
#[test]
fn an_elastic_impact_causes_no_damage() {
    let mut bench = Bench::new(&[]);
    bench.hit(light("light", START));
    bench.rest();
    assert_eq!(bench.reports()[0].report.outcome, Outcome::Elastic);
    let second = event("heavy", bench.now);
    bench.hit(second.clone());
    bench.rest();
    let (_, report) = simulated(bench.twin.parameters(), &second);
    assert_eq!(bench.reports()[1].report, report);
}

#[test]
fn samples_have_the_stamps_of_their_steps() {
    let mut bench = Bench::new(&[]);
    let stamp = START - 123_456_789;
    bench.hit(event("a", stamp));
    bench.rest();
    let states = bench.states();
    let (last, regular) = states.split_last().expect("some");
    for (k, state) in regular.iter().enumerate() {
        assert_eq!(state.stamp, stamp + k as i64 * MS);
        assert_eq!(&*state.event_id, "a");
    }
    assert_eq!(last.phase, TwinPhase::Rest);
    assert!(regular.iter().all(|it| it.phase == it.sample.phase.into()));
}

/// So that values and stamps always match.
#[test]
fn a_period_is_rounded_to_whole_steps() {
    for (rate, steps) in [(300.0, 33), (7_000.0, 1), (10_000.0, 1), (1.0, 10_000)] {
        let mut bench = Bench::new(&[("publish_rate", rate.into())]);
        bench.hit(event("a", START));
        bench.rest();
        let states = bench.states();
        for (k, state) in states[..states.len() - 1].iter().enumerate() {
            assert_eq!(state.stamp, START + k as i64 * steps * 100_000, "{rate} Hz");
            assert_eq!(state.sample.time, (state.stamp - START) as f64 / 1e9);
        }
    }
}

#[test]
fn the_forecast_is_immediate_and_contains_its_compute_time() {
    let ticks = std::sync::atomic::AtomicU64::new(0);
    let stopwatch = move || ticks.fetch_add(1_000_000, std::sync::atomic::Ordering::Relaxed);
    let mut twin = column_twin::twin::Twin::new(parameters(&[]), None, Box::new(stopwatch), START)
        .expect("the column stands");
    let mut out = Vec::new();
    let _ = twin.handle(
        column_twin::twin::Command::Impact(event("a", START)),
        START,
        &mut out,
    );
    assert!(twin.is_looking_ahead());
    let mut slices = 0_u32;
    while !out.iter().any(|it| matches!(it, Output::Forecast(_))) {
        twin.run_ahead(64, START, &mut out);
        slices += 1;
    }
    let forecast = out
        .iter()
        .find_map(|it| {
            if let Output::Forecast(report) = it {
                Some(report)
            } else {
                None
            }
        })
        .expect("a forecast before the clock has moved");
    assert_eq!((&*forecast.event_id, forecast.stamp), ("a", START));
    // Every slice takes one tick of this stopwatch.
    assert!((forecast.compute_time - f64::from(slices) * 1e-3).abs() < 1e-9);
    // The residual capacity takes some more.
    assert!(u64::from(slices) > forecast.report.steps.div_ceil(64));
    assert!(out.iter().all(|it| !matches!(it, Output::State(_))));
}

/// The samples do not depend on the clock.
#[test]
fn late_events_and_uneven_clocks_give_the_same_samples() {
    let mut even = Bench::new(&[]);
    even.hit(event("a", START));
    even.rest();
    let mut late = Bench::new(&[]);
    late.now += 3_000 * MS;
    late.hit(event("a", START));
    late.rest();
    let mut uneven = Bench::new(&[]);
    uneven.hit(event("a", START));
    let mut state = 1_u64;
    for _ in 0..100_000 {
        if !uneven.twin.is_responding() {
            break;
        }
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        uneven.now += (state >> 40) as i64; // up to 17 ms
        uneven.twin.advance_to(uneven.now, &mut uneven.out);
    }
    let of = |bench: &Bench| -> Vec<_> {
        bench
            .states()
            .iter()
            .map(|it| (it.stamp, it.phase, it.sample))
            .collect()
    };
    assert!(of(&even).len() > 30);
    assert_eq!(of(&even), of(&late));
    assert_eq!(of(&even), of(&uneven));
    assert_eq!(even.reports()[0].report, late.reports()[0].report);
    assert_eq!(uneven.forecasts()[0].report, even.forecasts()[0].report);
}

/// A call that does not catch up leaves its next deadline in the past.
#[test]
fn catching_up_is_bounded_per_call() {
    let mut bench = Bench::new(&[("solver.dt", 1e-5.into())]);
    bench.hit(event("a", START));
    bench.now += 1_000 * MS;
    bench.twin.advance_to(bench.now, &mut bench.out);
    let steps = bench.twin.statistics().steps;
    assert!(
        steps <= u64::from(column_twin::twin::MAX_STEPS_PER_CALL),
        "{steps}"
    );
    assert!(bench.twin.is_responding() && bench.twin.next_deadline(bench.now) <= bench.now);
}

#[test]
fn a_clock_that_is_set_back_pauses_the_response() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.go_on(10 * MS);
    let seen = bench.states().len();
    for instant in [START - 3_600_000 * MS, i64::MIN, START + 5 * MS] {
        bench.twin.advance_to(instant, &mut bench.out);
    }
    assert_eq!(bench.states().len(), seen);
    bench.rest();
    let stamps: Vec<_> = bench.states().iter().map(|it| it.stamp).collect();
    assert!(stamps.windows(2).all(|pair| pair[0] < pair[1]));
}

#[test]
fn an_event_ahead_of_the_clock_waits_for_its_stamp() {
    let mut bench = Bench::new(&[]);
    let stamp = START + 500 * MS;
    bench.hit(event("a", stamp));
    bench.go_to(stamp - 1);
    assert_eq!((bench.states().len(), bench.forecasts().len()), (0, 2));
    bench.go_to(stamp);
    assert_eq!(bench.states().len(), 1);
    bench.rest();
    assert_eq!(bench.reports().len(), 1);
}

#[test]
fn a_collapse_is_reported_and_lasts_until_a_reset() {
    let mut bench = Bench::new(&[("top.load", 2.0e6.into())]);
    bench.hit(fatal("truck", START));
    bench.rest();
    let report = bench.reports()[0].report;
    assert_eq!(
        (report.outcome, report.residual_v1),
        (Outcome::Collapsed, None)
    );
    assert_eq!(
        bench.states().last().expect("some").phase,
        TwinPhase::Collapsed
    );
    assert_eq!(bench.status().phase, TwinPhase::Collapsed);
    bench.hit(event("next", bench.now));
    assert!(
        bench.rejections()[0]
            .rejection
            .reason
            .contains("collapsed; reset"),
        "{:?}",
        bench.rejections()
    );
    bench.reset();
    assert_eq!(bench.status().phase, TwinPhase::Idle);
    bench.hit(light("next", bench.now));
    bench.rest();
    assert_eq!(bench.reports().len(), 2);
}

/// It was accepted before the column collapsed.
#[test]
fn an_impact_after_a_collapse_is_rejected_and_counted_once() {
    let mut bench = Bench::new(&[("top.load", 2.0e6.into())]);
    bench.hit(fatal("truck", START));
    bench.hit(light("next", START + 900 * MS));
    assert_eq!(bench.status().counts.events_accepted, 2);
    bench.rest();
    assert!(
        bench.rejections()[0]
            .rejection
            .reason
            .contains("collapsed; reset")
    );
    let status = bench.status();
    assert_eq!(
        (status.counts.events_accepted, status.counts.events_rejected),
        (1, 1)
    );
    assert_eq!(status.impacts_since_reset, 1);
    let saved = bench.saved();
    assert_eq!(saved.last().expect("kept").impacts_since_reset, 1);
}

#[test]
fn the_status_is_output_every_second_and_on_every_change() {
    let mut bench = Bench::new(&[]);
    bench.go_on(10_000 * MS);
    assert_eq!(bench.statuses().len(), 11);
    bench.hit(event("a", bench.now));
    bench.rest();
    let phases: Vec<_> = bench.statuses()[11..].iter().map(|it| it.phase).collect();
    for phase in [TwinPhase::Contact, TwinPhase::Free, TwinPhase::Idle] {
        assert!(phases.contains(&phase), "{phases:?}");
    }
    let last = bench.statuses().last().copied().expect("some");
    assert_eq!((&*last.event_id, last.impacts_since_reset), ("a", 1));
    let report = bench.reports()[0].report;
    assert_eq!(Some(last.residual_v1), report.residual_v1);
    assert_eq!(last.plastic_work_since_reset, report.plastic_work);
    assert_eq!(
        last.plastic_rotation,
        report.hinges.map(|hinge| hinge.plastic_rotation)
    );
}

#[test]
fn a_prediction_does_not_change_the_twin() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.rest();
    let before = (
        bench
            .twin
            .snapshot()
            .predict("", "", &event("x", 0).impact, &|| 0),
        bench.status(),
    );
    let snapshot = bench.twin.snapshot();
    let second = event("b", bench.now);
    let predicted = snapshot
        .predict("column", "", &second.impact, &|| 0)
        .expect("a prediction");
    assert_eq!(Ok(&predicted), before.0.as_ref());
    assert_eq!(bench.status(), before.1);
    bench.hit(second.clone());
    bench.rest();
    assert_eq!(bench.reports()[1].report, predicted.report);
    let snapshot = bench.twin.snapshot();
    let faults = snapshot.predict(
        "",
        "",
        &ImpactSpecification {
            velocity: 0.0,
            ..second.impact
        },
        &|| 0,
    );
    assert!(
        faults
            .expect_err("no velocity")
            .reason
            .contains("velocity = 0")
    );
    assert!(
        snapshot
            .predict("other", "", &event("x", 0).impact, &|| 0)
            .is_err()
    );
}
