//! Vehicles by name and by numbers; what their impacts leave behind, and how serious it is.

use column_twin::assessment::Action;
use column_twin::column::{ImpactSpecification, Outcome};
use column_twin::parameters::Value;
use column_twin::twin::{Command, ImpactCommand, Journal, Output, RejectionCode, TwinPhase};

use super::{Bench, MS, START, event, parameters};

/// A vehicle with its own mass.
fn vehicle(name: &str, velocity: f64) -> ImpactCommand {
    ImpactCommand {
        vehicle: name.to_owned(),
        impact: ImpactSpecification {
            mass: f64::NAN,
            velocity,
            ..event("a", START).impact
        },
        ..event("a", START)
    }
}

/// The catalogue's car as parameters.
fn car_by_numbers() -> Vec<(&'static str, Value)> {
    vec![
        ("vehicle.name", Value::from("")),
        ("vehicle.masses", Value::from(vec![1000.0])),
        ("vehicle.spring_1.crush", Value::from(vec![0.2, 1.0])),
        ("vehicle.spring_1.force", Value::from(vec![100e3, 300e3])),
        ("vehicle.spring_1.unloading_stiffness", Value::from(5e6)),
        ("impact.mass", Value::from(0.0)),
    ]
}

#[test]
fn a_vehicle_of_the_catalogue_crushes_and_has_its_own_mass() {
    let mut bench = Bench::new(&[]);
    bench.hit(vehicle("mid_car", 10.0));
    bench.rest();
    let report = bench.reports()[0];
    assert_eq!(&*report.striking.vehicle, "mid_car");
    assert_eq!(report.striking.impact.mass, 1719.0);
    let crushed = &report.report.vehicle;
    assert_eq!(crushed.masses, 1);
    assert!(crushed.max_crush[0] >= crushed.permanent_crush[0]);
    assert!(crushed.permanent_crush[0] > 0.1 && crushed.dissipated[0] > 10e3);
    // The rigid mass of the same car bends the column far more.
    let mut rigid = Bench::new(&[]);
    rigid.hit(ImpactCommand {
        impact: ImpactSpecification {
            mass: 1719.0,
            ..vehicle("rigid", 10.0).impact
        },
        ..vehicle("rigid", 10.0)
    });
    rigid.rest();
    assert!(rigid.reports()[0].report.max_v1 > 5.0 * report.report.max_v1);
    assert_eq!(bench.status().vehicle, report.report.vehicle);
}

#[test]
fn an_event_without_a_vehicle_has_that_of_the_parameters() {
    let mut bench = Bench::new(&car_by_numbers());
    bench.hit(vehicle("", 8.0));
    bench.rest();
    let report = bench.reports()[0];
    assert_eq!(&*report.striking.vehicle, "");
    assert_eq!(report.striking.impact.mass, 1000.0);
    assert_eq!(report.report.vehicle.masses, 1);
    // Another mass than its own.
    let mut heavy = Bench::new(&car_by_numbers());
    heavy.hit(ImpactCommand {
        impact: ImpactSpecification {
            mass: 1500.0,
            ..vehicle("", 8.0).impact
        },
        ..vehicle("", 8.0)
    });
    heavy.rest();
    assert_eq!(heavy.reports()[0].striking.impact.mass, 1500.0);
    assert!(heavy.reports()[0].report.impulse > report.report.impulse);
}

#[test]
fn impossible_vehicles_are_rejected_with_their_code() {
    for (bad, code, reason) in [
        (
            vehicle("mid_kar", 5.0),
            RejectionCode::VehicleInvalid,
            "did you mean mid_car?",
        ),
        (
            vehicle(&"x".repeat(65), 5.0),
            RejectionCode::VehicleInvalid,
            "too long",
        ),
        (
            vehicle("mid\ncar", 5.0),
            RejectionCode::VehicleInvalid,
            "control characters",
        ),
        (
            vehicle("rigid", 5.0),
            RejectionCode::ImpactOutOfRange,
            "a rigid vehicle has no mass of its own",
        ),
    ] {
        let mut bench = Bench::new(&[]);
        bench.hit(bad);
        let rejection = &bench.rejections()[0].rejection;
        assert_eq!(rejection.code, code, "{rejection}");
        assert!(rejection.reason.contains(reason), "{rejection}");
        assert_eq!(bench.status().counts.events_accepted, 0);
    }
}

#[test]
fn the_journal_has_the_impact_as_the_catalogue_completes_it() {
    let mut bench = Bench::new(&[]);
    bench.hit(vehicle("lorry_8t", 5.0));
    bench.hit(vehicle("unknown", 5.0));
    let recorded: Vec<_> = bench
        .out
        .iter()
        .filter_map(|output| match output {
            Output::Journal(Journal::Command(record)) => Some(record.impact),
            _ => None,
        })
        .collect();
    let [Some(impact), None] = recorded[..] else {
        panic!("{recorded:?}");
    };
    assert_eq!(impact.mass, 8000.0);
    let masses = impact.vehicle.map(|it| it.masses().to_vec());
    assert_eq!(masses, Some(vec![5500.0, 2500.0]));
}

/// First with the residual capacity, then with the error of the time step; the result has both.
#[test]
fn a_forecast_is_given_out_twice_and_the_result_is_the_same() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.rest();
    let [first, second] = bench.forecasts()[..] else {
        panic!("{} forecasts", bench.forecasts().len());
    };
    let result = bench.reports()[0];
    assert_eq!(first.error_estimate, None);
    assert!(second.error_estimate.is_some_and(|it| it < 0.05));
    for forecast in [first, second] {
        assert_eq!(forecast.report, result.report);
        assert_eq!(forecast.assessed, result.assessed);
    }
    assert_eq!(second.error_estimate, result.error_estimate);
    assert_eq!(result.step_nanos, 100_000);
    let status = bench.status();
    assert_eq!(status.assessed, result.assessed);
    assert_eq!(status.error_estimate, result.error_estimate);
}

#[test]
fn a_damaged_column_carries_less_and_the_action_follows() {
    let mut bench = Bench::new(&[]);
    let undamaged = bench.status().assessed.expect("assessed at the start");
    assert_eq!(undamaged.remaining.ratio, 1.0);
    assert_eq!(undamaged.assessment.action, Action::None);
    bench.hit(event("a", START));
    bench.rest();
    let now = bench.status().assessed.expect("assessed");
    assert_eq!(now.remaining.undamaged, undamaged.remaining.undamaged);
    assert!(now.remaining.now.force < undamaged.remaining.now.force);
    assert!(now.assessment.action >= Action::Inspect);
    // More load means less reserve.
    let load = bench.twin.parameters().settings().top.load;
    bench.change(&[("top.load", Value::from(1.2 * load))]);
    let loaded = bench.status().assessed.expect("assessed");
    assert!(loaded.remaining.reserve < now.remaining.reserve);
    bench.reset();
    assert_eq!(
        bench.status().assessed.map(|it| it.remaining.ratio),
        Some(1.0)
    );
}

#[test]
fn an_elastic_impact_leaves_the_whole_capacity() {
    let mut bench = Bench::new(&[]);
    bench.hit(super::light("a", START));
    bench.rest();
    let assessed = bench.reports()[0].assessed.as_ref().expect("assessed");
    assert_eq!(assessed.remaining.ratio, 1.0);
    assert_eq!(assessed.assessment.action, Action::None);
}

/// The forecast of an impact is the prediction of the same impact, with everything that follows from it.
#[test]
fn a_prediction_is_assessed_like_the_impact() {
    let mut bench = Bench::new(&[]);
    let event = vehicle("van", 12.0);
    let predicted = bench
        .twin
        .snapshot()
        .predict("", &event.vehicle, &event.impact, &|| 0)
        .expect("a prediction");
    bench.hit(event);
    bench.rest();
    let result = bench.reports()[0];
    assert_eq!(predicted.report, result.report);
    assert_eq!(predicted.striking, result.striking);
    assert_eq!(predicted.assessed, result.assessed);
    assert_eq!(predicted.error_estimate, result.error_estimate);
}

#[test]
fn a_fractured_column_takes_no_further_impact() {
    let mut bench = Bench::new(&[("assessment.ultimate_rotation", Value::from(0.02))]);
    bench.hit(event("a", START));
    bench.rest();
    let result = bench.reports()[0];
    assert_eq!(result.report.outcome, Outcome::Fractured);
    let assessed = result.assessed.as_ref().expect("assessed");
    assert_eq!(assessed.assessment.action, Action::Evacuate);
    assert_eq!(assessed.remaining.now.force, 0.0);
    assert_eq!(bench.status().phase, TwinPhase::Fractured);
    bench.go_on(MS);
    bench.hit(event("b", bench.now));
    assert_eq!(
        bench.rejections()[0].rejection.code,
        RejectionCode::ColumnFractured
    );
    // After a restart it is fractured still.
    let saved = bench.twin.saved_state(bench.now);
    let text = saved.to_json().expect("JSON");
    let changes = [("assessment.ultimate_rotation", Value::from(0.02))];
    let read = column_twin::twin::SavedState::from_json(&text, &parameters(&changes));
    let restarted = Bench::with(parameters(&changes), Some(&read.expect("its own file")));
    assert_eq!(restarted.status().phase, TwinPhase::Fractured);
    assert_eq!(
        restarted.status().assessed,
        bench.status().assessed,
        "the assessment survives a restart"
    );
    bench.reset();
    assert_eq!(bench.status().phase, TwinPhase::Idle);
}

/// The assessment of the report depends on the parameters at the beginning of the response, that of the column at rest
/// afterwards on the new ones.
#[test]
fn other_criteria_during_a_response_apply_to_the_column_at_rest() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.go_on(5 * MS);
    let only_collapse = vec!["collapse".to_owned()];
    bench.change(&[("assessment.criteria", Value::from(only_collapse))]);
    bench.rest();
    let result = bench.reports()[0].assessed.clone().expect("assessed");
    assert!(result.assessment.action >= Action::Inspect);
    let at_rest = bench.status().assessed.expect("assessed");
    assert_eq!(at_rest.assessment.action, Action::None);
    assert_eq!(at_rest.remaining, result.remaining);
}

/// While a forecast is computed in slices, a reset or an impact does not have to wait for it.
#[test]
fn commands_end_a_forecast_that_is_not_complete() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.twin.run_ahead(3, bench.now, &mut bench.out);
    assert!(bench.forecasts().is_empty());
    let _ = bench.handle(Command::Reset {
        source: "test".into(),
    });
    assert!(!bench.twin.is_looking_ahead());
    assert!(bench.forecasts().is_empty() && bench.reports().is_empty());
}

/// However thin the slices are, the numbers are the same.
#[test]
fn slices_do_not_change_the_forecast() {
    let run = |slice| {
        let mut bench = Bench::new(&[]);
        bench.hit(event("a", START));
        while bench.twin.is_looking_ahead() {
            bench.twin.run_ahead(slice, bench.now, &mut bench.out);
        }
        let forecasts = bench.forecasts().into_iter();
        let seen: Vec<_> = forecasts
            .map(|it| (it.report, it.assessed.clone(), it.error_estimate))
            .collect();
        assert_eq!(seen.len(), 2);
        seen
    };
    assert_eq!(run(1), run(u64::MAX));
    assert_eq!(run(7), run(1_000));
}

/// Where the hinges of the impact point are \[m above the base\].
fn impact_height(bench: &Bench) -> f64 {
    bench.status().at_rest.expect("at rest").lengths.below
}

/// On a column that is given by its height each vehicle strikes where it does, unless its event names a height.
#[test]
fn a_vehicle_strikes_at_its_own_height() {
    let by_height = [
        ("geometry.height", Value::from(4.0)),
        ("vehicle.name", Value::from("mid_car")),
    ];
    let by_lengths = [("vehicle.name", Value::from("mid_car"))];
    for (changes, heights) in [
        (&by_height[..], [0.5, 1.25, 0.75]),
        (&by_lengths, [1.0, 1.0, 1.0]),
    ] {
        for (name, height) in ["", "lorry_8t", "forklift"].into_iter().zip(heights) {
            let mut bench = Bench::new(changes);
            bench.hit(vehicle(name, 1.0));
            bench.rest();
            assert_eq!(bench.reports().len(), 1, "{name}");
            assert_eq!(impact_height(&bench), height, "{name}");
        }
    }
    let mut bench = Bench::new(&by_height);
    let mut named = vehicle("lorry_8t", 1.0);
    named.impact.height = Some(2.0);
    bench.hit(named);
    bench.rest();
    assert_eq!(impact_height(&bench), 2.0);
}

/// Without the bumper the webs are longer, and the column at rest bends a little less; the verdict is on what the report states.
#[test]
fn the_bow_of_the_verdict_is_that_of_the_report() {
    let mut bench = Bench::new(&[
        ("section.name", Value::from("HEB220")),
        ("steel.grade", Value::from("S355")),
    ]);
    bench.hit(vehicle("mid_car", 10.0));
    bench.rest();
    let found = bench.reports()[0];
    let properties = bench.twin.parameters().column_properties();
    let left = found.report.residual_v1.expect("it stands");
    let expected = left / (properties.length_below + properties.length_above);
    let assessment = &found.assessed.as_ref().expect("assessed").assessment;
    let bow = assessment
        .criteria
        .iter()
        .find(|it| it.name == "residual_bow_100");
    let value = bow.and_then(|it| it.value).expect("a bow");
    assert!(left > 1e-3, "{left}");
    assert!((value / expected - 1.0).abs() < 1e-12, "{value} {expected}");
}
