//! Tests of the direction of a hit by scenario, and of samples that the fibre beam judges.

use super::*;
use crate::assessment::Action;
use crate::parameters::{Parameters, Value};
use crate::second_opinion::JointVerdict;
use crate::study::{Batch, BatchEnd, VerdictModel};

fn scenario(distributions: &[&str]) -> Scenario {
    let mut scenario = Scenario::shipped("parking_garage").unwrap();
    for distribution in distributions {
        scenario.set("test", distribution).unwrap();
    }
    scenario
}

/// The orientation is drawn beside all other numbers, which stay as they are, and the direction is the angle of the course less that
/// of the web: its mean and spread are those of the distribution, within four standard errors.
#[test]
fn every_sample_has_the_direction_of_its_scenario() {
    let (plain, turned) = (scenario(&[]), scenario(&["orientation_deg=uniform:-90:90"]));
    let [plain, turned] = [&plain, &turned].map(|it| DepartureSampler::new(it, 3));
    let count = 4000;
    let (mut sum, mut squares) = (0.0, 0.0);
    for index in 0..count {
        let (without, with) = (plain.departure(index), turned.departure(index));
        assert_eq!(without.direction, None);
        let direction = with.direction.unwrap();
        let of_the_plane = INPUTS - 1;
        assert_eq!(
            with.quantiles[..of_the_plane],
            without.quantiles[..of_the_plane]
        );
        assert_eq!(
            Departure {
                direction: None,
                quantiles: without.quantiles,
                ..with
            },
            without
        );
        let of_web = (with.angle - direction).to_degrees();
        assert!((-90.0..=90.0).contains(&of_web), "{of_web}");
        sum += of_web;
        squares += of_web * of_web;
    }
    let n = count as f64;
    let (mean, variance) = (sum / n, squares / n);
    assert!(
        mean.abs() < 4.0 * (180.0 * 180.0 / 12.0 / n).sqrt(),
        "{mean}"
    );
    assert!((variance / (180.0 * 180.0 / 12.0) - 1.0).abs() < 4.0 * (0.8 / n).sqrt());
    // Beyond half a turn the direction is the same one, seen from the other side.
    let behind = scenario(&["orientation_deg=fixed:-170", "angle_deg=fixed:30"]);
    let direction = DepartureSampler::new(&behind, 1).departure(0).direction;
    assert!((direction.unwrap() + 160_f64.to_radians()).abs() < 1e-12);
}

/// A sample is the simulation of its hit, bit for bit, by both models and by the two bars.
#[test]
fn a_sample_is_the_simulation_of_its_hit() {
    let scenario = scenario(&[
        "orientation_deg=fixed:0",
        "yield_strength_factor=fixed:1",
        "top_load_factor=fixed:1",
    ]);
    let parameters = Parameters::default();
    let column = RiskColumn::new(&parameters, &scenario).unwrap();
    let column = column.judged_by(VerdictModel::Both).unwrap();
    let class = &scenario.classes[0];
    let departure = Departure {
        class: 0,
        mass: 1500.0,
        velocity: 8.0,
        direction: Some(0.2),
        force_factor: 1.0,
        yield_factor: 1.0,
        load_factor: 1.0,
        ..DepartureSampler::new(&scenario, 1).departure(0)
    };
    let settings = &parameters.settings().geometry;
    let total = settings.length_below + settings.length_above;
    let height = class.height.unwrap();
    let same = parameters
        .with_changes([
            ("geometry.length_below", Value::Double(height)),
            ("geometry.length_above", Value::Double(total - height)),
            ("vehicle.name", Value::from(class.vehicle)),
            ("impact.mass", Value::Double(departure.mass)),
            ("impact.velocity", Value::Double(departure.velocity)),
            ("impact.direction", Value::Double(0.2)),
        ])
        .unwrap();
    let expected = JointVerdict::of_parameters(&same).unwrap();
    let found = column.joint(&departure).unwrap();
    assert_eq!(found.report, expected.report);
    // The texts name the direction of the parameters, which a sample does not have.
    let [found_opinion, expected_opinion] = [&found, &expected].map(|it| {
        let opinion = it.second_opinion.as_ref().unwrap();
        (
            opinion.beam,
            opinion.direction,
            opinion.capacity,
            &opinion.counts,
        )
    });
    assert_eq!(found_opinion, expected_opinion);
    assert_eq!(found.assessment.action, expected.assessment.action);
    assert_eq!(column.action(&departure), Some(expected.assessment.action));
    assert!(expected.second_opinion.is_ok());
}

/// The orientation was not among the inputs of the sensitivity, also where it alone decided.
#[test]
fn the_orientation_that_decides_has_all_of_the_variance() {
    struct AcrossTheWeb;
    impl LimitState for AcrossTheWeb {
        fn action(&self, departure: &Departure) -> Option<Action> {
            let quantile = departure.quantiles[INPUTS - 1];
            Some(match (0.2..0.8).contains(&quantile) {
                true => Action::Shore,
                false => Action::None,
            })
        }
        fn at_speeds<'a>(&'a self, departure: &'a Departure) -> ActionAtSpeed<'a> {
            Box::new(|_| self.action(departure))
        }
    }
    let shares = |distributions: &[&str]| {
        let scenario = scenario(distributions);
        let sampler = DepartureSampler::new(&scenario, 3);
        let study = RiskStudy::new(&sampler, &AcrossTheWeb);
        let ran = study.run(&Batch::default(), 0..20_000, |_| Ok::<_, StudyRunError>(()));
        let exposure = Exposure::new(&scenario, 1000.0, 1.0);
        let result = RiskResult::new(&scenario, &ran.unwrap().0, exposure, 0.95);
        result.sensitivity[2].variance.clone()
    };
    let found = shares(&["distance_m=fixed:0", "orientation_deg=uniform:-90:90"]);
    assert_eq!(found[0].input, "orientation");
    assert!(found[0].first_order > 0.99, "{found:?}");
    for other in &found[1..] {
        assert!(other.first_order < 4.0 * other.error + 1e-3, "{other:?}");
    }
    let without = shares(&["distance_m=fixed:0", "orientation_deg=fixed:30"]);
    assert!(without.iter().all(|it| it.input != "orientation"));
}

/// Predictions by another model that knows no direction: they are wrong for every oblique hit, and a little in the plane. What is computed
/// corrects them, so that the intervals hold the truth, which a study that computes everything gives with ten times the samples.
#[test]
fn predictions_of_another_model_do_not_bias_the_result() {
    struct Misled;
    impl LimitState for Misled {
        fn action(&self, departure: &Departure) -> Option<Action> {
            let oblique = departure.direction.unwrap_or(0.0).abs() > 0.1;
            let critical = if oblique { 2.0 } else { 4.2 };
            Some(match departure.velocity > critical {
                true => Action::Evacuate,
                false => Action::None,
            })
        }
        fn doubt(&self, departure: &Departure, by_critical_speeds: usize) -> usize {
            match departure.direction.unwrap_or(0.0).abs() > 0.1 {
                true => 0,
                false => by_critical_speeds.min(2),
            }
        }
        fn at_speeds<'a>(&'a self, _: &'a Departure) -> ActionAtSpeed<'a> {
            Box::new(|speed| {
                Some(match speed > 4.5 {
                    true => Action::Evacuate,
                    false => Action::None,
                })
            })
        }
    }
    let scenario = scenario(&["distance_m=fixed:0", "orientation_deg=uniform:0:40"]);
    let value = |tally: &Tally| {
        RiskResult::new(&scenario, tally, Exposure::new(&scenario, 1000.0, 1.0), 0.9).actions[3]
            .given_departure
    };
    let run = |study: &RiskStudy<'_, Misled>, samples: u64| {
        let ran = study.run(
            &Batch::default(),
            0..samples,
            |_| Ok::<_, StudyRunError>(()),
        );
        let (tally, end) = ran.unwrap();
        assert_eq!(end, BatchEnd::Complete);
        tally
    };
    let sampler = DepartureSampler::new(&scenario, 1000);
    let truth = value(&run(&RiskStudy::new(&sampler, &Misled), 200_000)).value;
    let mut held = 0;
    for seed in 0..20 {
        let sampler = DepartureSampler::new(&scenario, seed);
        let search = Batch::default();
        let surface = CriticalSpeedSurface::new(&sampler, seed, &Misled, 10_000_000, &search)
            .unwrap()
            .unwrap();
        let study = RiskStudy::new(&sampler, &Misled).with_predictions(&surface);
        let tally = run(&study, 5000);
        let total = tally.total();
        assert!(total.wrong_predictions() > 100, "it is misled");
        assert!(total.audit_samples() < 4000);
        held += u32::from(value(&tally).contains(truth));
    }
    // Of 20 intervals of 90 %, fewer than 15 hold the truth with a probability of 1 %.
    assert!(held >= 15, "{held} of 20 intervals hold {truth}");
}
