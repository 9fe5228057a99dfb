//! Every accepted impact has a forecast, or an output that tells why it has none.

use std::collections::BTreeMap;

use column_twin::column::ImpactSpecification;
use column_twin::twin::{
    ForecastEnd, ImpactCommand, MAX_SUPERSEDED_FORECASTS, Output, WithdrawnForecast,
};

use crate::{Bench, MS, START, event, fatal, light};

/// What the outputs say of the forecasts of one impact.
#[derive(Debug, Default, PartialEq)]
struct Told {
    forecasts: u32,
    withdrawals: Vec<(bool, ForecastEnd)>,
    reports: u32,
}

fn told(bench: &Bench) -> BTreeMap<String, Told> {
    let mut all = BTreeMap::<String, Told>::new();
    for output in &bench.out {
        match output {
            Output::Forecast(it) => {
                let told = all.entry(it.event_id.to_string()).or_default();
                assert!(told.withdrawals.is_empty(), "{} came back", it.event_id);
                told.forecasts += u32::from(it.error_estimate.is_none());
            }
            Output::Withdrawn(WithdrawnForecast {
                impact,
                was_known,
                end,
                reason,
                ..
            }) => {
                assert!(!reason.is_empty());
                let told = all.entry(impact.event_id.to_string()).or_default();
                told.withdrawals.push((*was_known, *end));
            }
            Output::Report(it) => all.entry(it.event_id.to_string()).or_default().reports += 1,
            _ => {}
        }
    }
    all
}

/// Two events back to back once gave 59 forecasts for 80 accepted events.
#[test]
fn two_events_back_to_back_have_a_forecast_each() {
    let mut bench = Bench::new(&[]);
    for pair in 0..40 {
        // Both are handled before anything of the first forecast is computed.
        bench.hit(light(&format!("{pair} first"), bench.now));
        bench.hit(light(&format!("{pair} second"), bench.now));
        bench.rest();
        bench.go_on(MS);
    }
    assert_eq!(bench.status().counts.events_accepted, 80);
    let told = told(&bench);
    assert_eq!(told.len(), 80);
    for (id, told) in told {
        let expected = match id.ends_with("first") {
            true => Told {
                forecasts: 1,
                withdrawals: vec![(true, ForecastEnd::Superseded)],
                reports: 0,
            },
            false => Told {
                forecasts: 1,
                withdrawals: Vec::new(),
                reports: 1,
            },
        };
        assert_eq!(told, expected, "{id}");
    }
}

/// It is that of the impact alone, as if it had been computed before the other one came.
#[test]
fn a_forecast_that_is_completed_late_has_the_same_numbers() {
    let forecast_of_first = |runs_ahead: bool| {
        let mut bench = Bench::new(&[]);
        bench.hit(event("a", START));
        if runs_ahead {
            bench.twin.run_ahead(u64::MAX, START, &mut bench.out);
        }
        bench.hit(event("b", START));
        bench.rest();
        let of_first = bench
            .forecasts()
            .into_iter()
            .filter(|it| &*it.event_id == "a");
        let numbers: Vec<_> = of_first
            .map(|it| (it.report, it.assessed.clone(), it.error_estimate))
            .collect();
        assert_eq!(numbers.len(), 2, "the second has the error estimate");
        numbers
    };
    assert_eq!(forecast_of_first(false), forecast_of_first(true));
}

#[test]
fn the_forecast_of_the_present_response_comes_first() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.hit(event("b", START));
    while bench.forecasts().is_empty() {
        bench.twin.run_ahead(1, START, &mut bench.out);
    }
    assert_eq!(&*bench.forecasts()[0].event_id, "b");
}

/// More impacts follow one another than forecasts can be computed in time: the oldest are given up, and say so.
#[test]
fn a_burst_of_impacts_leaves_none_without_a_word() {
    let mut bench = Bench::new(&[]);
    for impact in 0..40 {
        bench.hit(light(&impact.to_string(), START));
    }
    bench.rest();
    let told = told(&bench);
    assert_eq!(told.len(), 40);
    let given_up = 40 - 1 - MAX_SUPERSEDED_FORECASTS;
    for (id, told) in told {
        let impact: usize = id.parse().expect("a number");
        let superseded = |was_known| vec![(was_known, ForecastEnd::Superseded)];
        let (forecasts, withdrawals, reports) = match impact {
            39 => (1, Vec::new(), 1),
            _ if impact < given_up => (0, superseded(false), 0),
            _ => (1, superseded(true), 0),
        };
        let expected = Told {
            forecasts,
            withdrawals,
            reports,
        };
        assert_eq!(told, expected, "{id}");
    }
}

#[test]
fn a_reset_tells_of_every_impact_that_it_drops() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("known", START));
    bench.twin.run_ahead(u64::MAX, START, &mut bench.out);
    bench.reset();
    bench.hit(event("under way", START));
    bench.hit(event("still to come", START + 500 * MS));
    bench.reset();
    let told = told(&bench);
    assert_eq!(told["known"].withdrawals, [(true, ForecastEnd::Reset)]);
    assert_eq!(told["under way"].withdrawals, [(false, ForecastEnd::Reset)]);
    let withdrawn = [(false, ForecastEnd::Reset)];
    assert_eq!(told["still to come"].withdrawals, withdrawn);
    assert!(!bench.twin.is_looking_ahead());
}

#[test]
fn an_impact_that_the_column_cannot_take_when_it_is_due_has_no_forecast() {
    let mut bench = Bench::new(&[("top.load", 2.0e6.into())]);
    bench.hit(fatal("fatal", START));
    bench.hit(event("too late", START + 900 * MS));
    bench.rest();
    bench.go_on(1_000 * MS);
    let told = told(&bench);
    let withdrawn = [(false, ForecastEnd::Rejected)];
    assert_eq!(told["too late"].withdrawals, withdrawn);
    assert_eq!(bench.rejections().len(), 1);
}

#[test]
fn a_stop_tells_which_impacts_have_no_forecast() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("first", START));
    bench.hit(event("second", START));
    bench.hit(event("still to come", START + 500 * MS));
    bench.twin.abandon_forecasts(&mut bench.out);
    let told = told(&bench);
    for (id, end) in [
        ("first", ForecastEnd::Superseded),
        ("second", ForecastEnd::Stopped),
        ("still to come", ForecastEnd::Stopped),
    ] {
        assert_eq!(told[id].withdrawals, [(false, end)], "{id}");
    }
}

/// The vehicle would need 1e8 s for the gap, and the twin would publish a state every millisecond until then.
#[test]
fn an_approach_without_end_is_rejected() {
    let mut bench = Bench::new(&[]);
    let slow = |gap: f64, velocity: f64| ImpactCommand {
        impact: ImpactSpecification {
            gap: Some(gap),
            velocity,
            ..event("a", START).impact
        },
        ..event("a", START)
    };
    bench.hit(slow(100.0, 1e-6));
    let rejection = &bench.rejections()[0].rejection;
    assert_eq!(rejection.code.name(), "approach_too_long");
    assert!(
        rejection.reason.contains("response.duration allows 2 s"),
        "{rejection}"
    );
    assert!(!bench.twin.is_responding() && bench.states().is_empty());
    // What response.duration allows is followed.
    bench.hit(slow(1.99, 1.0));
    bench.rest();
    let report = bench.reports()[0].report;
    assert!(report.first_contact_time.is_some_and(|it| it > 1.9));
}

/// From the 27th of equal impacts on, the second forecast with the error estimate was missing without a word: the column had shaken
/// down, so that it flowed by round-off with the whole step or with half of it, but not with both.
#[test]
fn each_of_sixty_equal_impacts_has_an_error_estimate_or_a_reason() {
    let mut bench = Bench::new(&[]);
    for number in 1..=60 {
        bench.out.clear();
        let hard = event(&format!("e{number}"), bench.now);
        let impact = ImpactSpecification {
            velocity: 2.5,
            ..hard.impact
        };
        bench.hit(ImpactCommand { impact, ..hard });
        assert!(bench.rejections().is_empty(), "{:?}", bench.rejections());
        bench.rest();
        bench.go_on(MS);
        let has_estimate = bench
            .forecasts()
            .iter()
            .any(|it| it.error_estimate.is_some());
        let is_told = bench.out.iter().any(
            |it| matches!(it, Output::Notice(notice) if notice.text.contains("no error estimate")),
        );
        assert!(has_estimate || is_told, "impact {number}");
    }
}
