//! Tests of measures against hand calculations and an integral.

use super::input::jcss_steel;
use super::*;
use crate::assessment::Action;
use crate::parameters::{Parameters, Value};
use crate::study::Batch;

/// A column that the vehicles evacuate at 6 m/s and above.
struct FromSixMetresPerSecond;

impl LimitState for FromSixMetresPerSecond {
    fn action(&self, departure: &Departure) -> Option<Action> {
        Some(match departure.velocity > 6.0 {
            true => Action::Evacuate,
            false => Action::Inspect,
        })
    }
}

/// A scenario with these measures.
fn scenario(distributions: &[&str], measures: &str) -> Scenario {
    let text = format!(
        r#"{{"scenarios": [{{"name": "x", "based_on": "urban", "measures": [{measures}]}}]}}"#
    );
    let mut scenario = Scenario::from_json("x.json", &text, "x").expect("a scenario");
    for distribution in distributions {
        scenario.set("test", distribution).expect("a distribution");
    }
    scenario
}

fn result(scenario: &Scenario, measure: Option<&Measure>, samples: u64) -> RiskResult {
    let sampler = DepartureSampler::new(scenario, 5);
    let mut study = RiskStudy::new(&sampler, &FromSixMetresPerSecond);
    if let Some(measure) = measure {
        study = study.behind(measure);
    }
    let done = |_: &RiskSample| Ok::<_, StudyRunError>(());
    let (tally, _) = study
        .run(&Batch::default(), 0..samples, done)
        .expect("runs");
    RiskResult::new(scenario, &tally, Exposure::new(scenario, 1000.0, 1.0), 0.95)
}

/// Without braking, a vehicle of 2000 kg that a bollard takes 64 kJ from keeps sqrt(v^2 - 64): one that hits the column at
/// 6 m/s had 10 m/s. The share of faster ones is that of the lognormal distribution.
#[test]
fn a_bollard_takes_its_energy_from_every_vehicle() {
    let bollard = r#"{"name": "bollard", "takes_energy_kj": 64}"#;
    let mut scenario = scenario(&["distance_m=fixed:0"], bollard);
    for class in &mut scenario.classes {
        class.mass.distribution = Distribution::fixed(2000.0).expect("a mass");
    }
    let measure = &scenario.measures[0];
    let faster = |speed: f64| 1.0 - scenario.speed.distribution.probability(3.6 * speed);
    let with = result(&scenario, Some(measure), 4000);
    let evacuate = with.actions[3].given_departure;
    assert!(
        evacuate.contains(faster(10.0)),
        "{evacuate:?}, {}",
        faster(10.0)
    );
    // A vehicle below 8 m/s does not reach the column at all.
    assert!(with.impact.contains(faster(8.0)), "{:?}", with.impact);
    let without = result(&scenario, None, 4000);
    let risk = MeasureRisk::new(measure, None, &without, &with);
    let expected = faster(10.0) / faster(6.0);
    let found = risk.actions[3].times.expect("a ratio");
    assert!((found / expected - 1.0).abs() < 0.1, "{found} {expected}");
}

/// 1500 kg at 20 degrees and 110 km/h have 81.9 kJ across the rail: m (v sin(angle))^2 / 2.
#[test]
fn a_guard_rail_holds_what_has_less_energy_across_it() {
    let rail = r#"{"name": "rail", "holds_lateral_energy_kj": 81.9}"#;
    for (speed, held) in [(109.8, true), (110.2, false)] {
        let speed = format!("speed_km_h=fixed:{speed}");
        let distributions = [&*speed, "angle_deg=fixed:20", "distance_m=fixed:0"];
        let mut scenario = scenario(&distributions, rail);
        for class in &mut scenario.classes {
            class.mass.distribution = Distribution::fixed(1500.0).expect("a mass");
        }
        let with = result(&scenario, Some(&scenario.measures[0]), 50);
        assert_eq!(with.impact.value, f64::from(u8::from(!held)), "{speed}");
        // Where every vehicle of the samples is held, the next one may be not.
        assert!(!held || with.impact.high > 0.0);
    }
}

/// Cars strike 0.5 m above the road, lorries and vans at 1.25 m.
#[test]
fn a_concrete_base_stops_cars_and_no_lorries() {
    let base = r#"{"name": "base", "stops_up_to_m": 0.8}"#;
    let scenario = scenario(&["distance_m=fixed:0"], base);
    let with = result(&scenario, Some(&scenario.measures[0]), 3000);
    let above = |class: &&TrafficClass| class.height.is_some_and(|it| it > 0.8);
    let share: f64 = scenario
        .classes
        .iter()
        .filter(above)
        .map(|it| it.share)
        .sum();
    assert!((0.05..0.07).contains(&share), "{share}");
    assert!(with.impact.contains(share), "{:?} {share}", with.impact);
    for class in with.classes.iter().filter(|it| it.vehicle.contains("car")) {
        assert_eq!(class.impacts, 0, "{class:?}");
    }
}

#[test]
fn a_heavier_section_is_that_of_the_series() {
    let heavier = r#"{"name": "heavier", "sections_heavier": 3}"#;
    let scenario = scenario(&[], heavier);
    let named = |name: &str| {
        let changes = [("section.name", Value::from(name))];
        Parameters::from_values(changes).expect("a column")
    };
    let measure = &scenario.measures[0];
    let column = measure.column(&named("HEB220")).expect("a section");
    assert_eq!(column.expect("another").section().name, Some("HEB280"));
    let fault = measure.column(&named("HEB1000")).expect_err("the last one");
    assert_eq!(
        fault.to_string(),
        "the series of HEB1000 has no section 3 sizes heavier"
    );
}

#[test]
fn wrong_measures_are_rejected_with_what_is_expected() {
    for (measures, expected) in [
        (
            r#"{"name": "b", "takes_energy_kj": 5, "stops_up_to_m": 1}"#,
            "measures[0]: found 2 of them; expected one of takes_energy_kj, holds_lateral_energy_kj, stops_up_to_m and \
             sections_heavier",
        ),
        (r#"{"name": "b"}"#, "measures[0]: found 0 of them"),
        (
            r#"{"name": "b", "takes_energy_kj": -5}"#,
            "measures[0].takes_energy_kj: found -5; expected a number above 0, at most 1000000",
        ),
        (
            r#"{"name": "b c", "takes_energy_kj": 5}"#,
            "measures[0].name: found b c; expected 1 to 32 letters, digits and underscores",
        ),
        (
            r#"{"name": "b", "takes_energy_kj": 5}, {"name": "b", "stops_up_to_m": 1}"#,
            "measures[1].name: found b; expected a name that no other measure has",
        ),
        (
            r#"{"name": "b", "stops": 5}"#,
            "measures[0]: found unknown field `stops`",
        ),
    ] {
        let text = format!(
            r#"{{"scenarios": [{{"name": "x", "based_on": "urban", "measures": [{measures}]}}]}}"#
        );
        let fault = Scenario::from_json("x.json", &text, "x").unwrap_err();
        let fault = fault.to_string();
        assert!(fault.contains(expected), "{fault}");
    }
}

/// `f_y exp(1.5 x 0.07) - 20 MPa` by hand for S235, S355 and S460, with exp(0.105) = 1.11071.
#[test]
fn the_yield_strength_is_that_of_the_model_code() {
    for (nominal, mean) in [(235.0, 241.02), (355.0, 374.30), (460.0, 490.93)] {
        let distribution = jcss_steel(nominal * 1e6).expect("a distribution");
        assert!(
            (distribution.mean() * nominal - mean).abs() < 0.02,
            "{nominal} {}",
            distribution.mean()
        );
        // A lognormal distribution with a coefficient of variation of 0.07: ln(84 % / 50 %) = sqrt(ln(1 + 0.07^2)).
        let deviation =
            libm::log(distribution.quantile(0.841_344_746) / distribution.quantile(0.5));
        assert!((deviation - 0.069_914).abs() < 1e-5, "{deviation}");
    }
    let steel = [("steel.grade", Value::from("S235"))];
    let steel = Parameters::from_values(steel).expect("a column");
    let scenario = Scenario::shipped("urban")
        .expect("shipped")
        .for_column(&steel);
    let mean = scenario.yield_strength_factor.distribution.mean();
    assert!((mean * 235.0 - 241.02).abs() < 0.02, "{mean}");
    // A distribution of one's own stays.
    let mut own = Scenario::shipped("urban").expect("shipped");
    own.set("test", "yield_strength_factor=fixed:1.2")
        .expect("a distribution");
    assert_eq!(
        own.for_column(&steel)
            .yield_strength_factor
            .distribution
            .mean(),
        1.2
    );
    let elsewhere = Scenario::shipped("urban")
        .expect("shipped")
        .set("test", "top_load_factor=jcss_steel");
    let expected = "test: top_load_factor.distribution: found jcss_steel; expected another distribution: jcss_steel is that of yield_strength_factor";
    assert_eq!(elsewhere.unwrap_err().to_string(), expected);
}
