//! Tests of whole studies against closed forms and numerical integrals.

use std::num::NonZeroUsize;

use super::*;
use crate::assessment::Action;
use crate::column::{Impact, Outcome};
use crate::parameters::{Parameters, Value};
use crate::study::{Batch, BatchEnd, StudyColumn};

/// A limit state with a known answer: the action follows from a function of the departure.
struct Known<F>(F);

impl<F: Fn(&Departure) -> Action + Sync> LimitState for Known<F> {
    fn action(&self, departure: &Departure) -> Option<Action> {
        Some((self.0)(departure))
    }
}

fn scenario(name: &str, distributions: &[&str]) -> Scenario {
    let mut scenario = Scenario::shipped(name).unwrap();
    for distribution in distributions {
        scenario.set("test", distribution).unwrap();
    }
    scenario
}

fn run<L: LimitState>(
    study: &RiskStudy<'_, L>,
    threads: usize,
    samples: std::ops::Range<u64>,
) -> Tally {
    let batch = Batch::of_threads(NonZeroUsize::new(threads));
    let (tally, end) = study
        .run(&batch, samples, |_| Ok::<_, StudyRunError>(()))
        .unwrap();
    assert_eq!(end, BatchEnd::Complete);
    tally
}

fn result(scenario: &Scenario, tally: &Tally, confidence: f64) -> RiskResult {
    RiskResult::new(
        scenario,
        tally,
        Exposure::new(scenario, 1000.0, 1.0),
        confidence,
    )
}

/// A study of a column whose load is assumed did not say so.
#[test]
fn a_risk_says_where_an_input_of_the_column_is_assumed() {
    let scenario = scenario("parking_garage", &[]);
    let sampler = DepartureSampler::new(&scenario, 1);
    let column = Known(|_: &Departure| Action::None);
    let tally = run(&RiskStudy::new(&sampler, &column), 1, 0..100);
    let whole = Parameters::default();
    let section = [("section.name", Value::from("HEB300"))];
    let assumed = whole.with_changes(section).unwrap();
    let says = |parameters: &Parameters| {
        let result = result(&scenario, &tally, 0.95).of_column(parameters);
        let mut left_out = result.not_evaluated.iter();
        left_out.any(|it| it.what == "inputs that nobody has given")
    };
    assert!(!says(&whole));
    assert!(says(&assumed));
}

/// At a distance of 0 the speed at the column is that of the road, so that P(V > v) is known.
fn lognormal_exceedance(scenario: &Scenario, speed: f64) -> f64 {
    1.0 - scenario.speed.distribution.probability(speed * 3.6)
}

/// 90 % intervals hold the truth for about 90 % of the seeds: of 400, between 85 % and 95 % (3.3 standard errors of a binomial
/// share on either side). So they do with predictions, where only a part of the responses is computed.
#[test]
fn intervals_have_their_coverage() {
    let scenario = scenario("parking_garage", &["distance_m=fixed:0"]);
    // The critical speed depends on the mass, too, so that the predictions have something to learn.
    let action =
        |departure: &Departure| match departure.velocity * (departure.mass / 1500.0).sqrt() > 4.5 {
            true => Action::Evacuate,
            false => Action::None,
        };
    // By quadrature over the classes and over the quantiles of the mass.
    let mut truth = 0.0;
    for class in &scenario.classes {
        let count = 2000;
        for index in 0..count {
            let mass = class
                .mass
                .distribution
                .quantile((f64::from(index) + 0.5) / f64::from(count));
            let critical = 4.5 / (mass / 1500.0).sqrt();
            truth += class.share / f64::from(count) * lognormal_exceedance(&scenario, critical);
        }
    }
    let known = Known(action);
    let interval = |tally: &Tally| result(&scenario, tally, 0.9).actions[3].given_departure;
    let mut held = 0;
    for seed in 0..400 {
        let sampler = DepartureSampler::new(&scenario, seed);
        let tally = run(&RiskStudy::new(&sampler, &known), 1, 0..1000);
        held += u32::from(interval(&tally).contains(truth));
    }
    assert!(
        (340..=380).contains(&held),
        "{held} of 400 intervals hold {truth}"
    );

    let mut held = 0;
    for seed in 0..20 {
        let sampler = DepartureSampler::new(&scenario, seed);
        let search = Batch::of_threads(None);
        let surface = CriticalSpeedSurface::new(&sampler, seed, &known, 10_000_000, &search)
            .unwrap()
            .unwrap();
        assert_eq!(surface.not_monotonic(), 0);
        let tally = run(
            &RiskStudy::new(&sampler, &known).with_predictions(&surface),
            2,
            0..5000,
        );
        let counts = result(&scenario, &tally, 0.9).counts;
        assert!(counts.responses < counts.samples / 4, "{counts:?}");
        held += u32::from(interval(&tally).contains(truth));
    }
    // The intervals of the audit samples are on the safe side where no prediction is wrong.
    assert!(held >= 15, "{held} of 20 intervals hold {truth}");
}

/// A limit state that misleads the predictions: inside a window of mass and yield strength that no smooth interpolation sees,
/// it is exceeded at any speed. The audit samples find it, and the estimate stays unbiased.
#[test]
fn wrong_predictions_do_not_bias_the_result() {
    let scenario = scenario("parking_garage", &["distance_m=fixed:0"]);
    let window = |departure: &Departure| {
        let [.., mass, _, yielding, _] = departure.quantiles;
        (0.45..0.55).contains(&mass) && (0.4..0.6).contains(&yielding)
    };
    let known =
        Known(
            |departure: &Departure| match departure.velocity > 5.0 || window(departure) {
                true => Action::Shore,
                false => Action::None,
            },
        );
    let fast = lognormal_exceedance(&scenario, 5.0);
    let truth = fast + (1.0 - fast) * 0.1 * 0.2;
    // The predictions were learnt without the window.
    let learnt = Known(|departure: &Departure| match departure.velocity > 5.0 {
        true => Action::Shore,
        false => Action::None,
    });
    let (mut sum, mut held, seeds) = (0.0, 0, 16);
    for seed in 0..seeds {
        let sampler = DepartureSampler::new(&scenario, seed);
        let surface = CriticalSpeedSurface::new(
            &sampler,
            seed,
            &learnt,
            10_000_000,
            &Batch::of_threads(None),
        )
        .unwrap()
        .unwrap();
        let study = RiskStudy::new(&sampler, &known).with_predictions(&surface);
        let tally = run(&study, 2, 0..40_000);
        let found = result(&scenario, &tally, 0.95);
        assert!(found.counts.wrong_predictions > 0);
        sum += found.actions[2].given_departure.value;
        held += i32::from(found.actions[2].given_departure.contains(truth));
    }
    let mean = sum / f64::from(seeds as u32);
    // Of about 360 audit samples 2 % are wrong: the standard deviation of one estimate is about 0.007, of the mean of 16 0.0018.
    assert!((mean - truth).abs() < 0.007, "{mean} instead of {truth}");
    assert!(held >= 12, "{held} of {seeds}");
}

/// The real column beside a road, with predictions against every single response: of each action that is often reached, the
/// estimate with few responses has the share of all of them in its interval, and costs a fraction of the responses.
#[test]
fn predictions_agree_with_every_single_response() {
    let mut scenario = scenario("urban", &["distance_m=fixed:0"]);
    // Two classes of which one damages the column now and then, and one nearly always.
    for class in &mut scenario.classes {
        class.share = match class.vehicle {
            "mid_car" => 0.5,
            "lorry_8t" => 0.5,
            _ => 0.0,
        };
    }
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("config/heb220_s355.yaml");
    let parameters = Parameters::load(&[file], &[]).unwrap();
    let column = RiskColumn::new(&parameters, &scenario).unwrap();
    let sampler = DepartureSampler::new(&scenario, 21);
    let samples = 0..4000;
    let all = run(&RiskStudy::new(&sampler, &column), 2, samples.clone());
    // As many designs as for a long study.
    let surface =
        CriticalSpeedSurface::new(&sampler, 21, &column, 10_000_000, &Batch::of_threads(None))
            .unwrap()
            .unwrap();
    let study = RiskStudy::new(&sampler, &column).with_predictions(&surface);
    let few = run(&study, 2, samples);
    let [all, few] = [&all, &few].map(|tally| result(&scenario, tally, 0.99));
    assert_eq!(all.counts.responses, 4000);
    // The forces in the base make the action of a car less monotonic in its speed, so that more predictions are in doubt.
    assert!(few.counts.responses < 1200, "{:?}", few.counts);
    let mut often = 0;
    for (all, few) in all.actions.iter().zip(&few.actions) {
        // The samples are the same, so that only the predictions can be wrong.
        let [truth, found] = [all.given_impact, few.given_impact];
        assert!(found.contains(truth.value), "{found:?} {truth:?}");
        // As narrow as about forty audit samples of the predictions that are in no doubt allow.
        assert!(found.high - found.low < 0.25, "{found:?}");
        often += u32::from((0.05..0.95).contains(&truth.value));
    }
    assert!(often >= 2, "{:?}", all.actions);
}

/// A column that stays elastic, hit by a rigid mass: `peak v1 = v+ sqrt((m + m_e) / k)` with `v+ = m V / (m + m_e)`,
/// `m_e = m_l (L_a + L_b) / 3` and `k = 3 E I (L_a + L_b)^3 / (L_a L_b)^3` of the beam that is built in at both ends. A
/// limit on the displacement is a limit on the speed, whose exceedance is that of the lognormal distribution.
struct ElasticColumn {
    column: StudyColumn,
    mass: f64,
    limit: f64,
}

impl LimitState for ElasticColumn {
    fn action(&self, departure: &Departure) -> Option<Action> {
        let impact = Impact::rigid(self.mass, departure.velocity);
        let found = self.column.evaluate(&impact).ok()?;
        assert_eq!(found.outcome, Outcome::Elastic);
        Some(match found.max_v1 > self.limit {
            true => Action::Inspect,
            false => Action::None,
        })
    }
}

#[test]
fn the_probability_of_a_displacement_of_an_elastic_column_is_in_its_interval() {
    let (below, above, mass, limit) = (1.0, 3.0, 1500.0, 2e-3);
    let parameters = Parameters::from_values([
        ("resistance.moment", Value::Double(1e9)),
        ("resistance.axial", Value::Double(1e10)),
        ("top.load", Value::Double(0.0)),
        ("response.duration", Value::Double(0.1)),
        ("shear.model", "none".into()),
    ])
    .unwrap();
    let properties = parameters.column_properties();
    let total: f64 = below + above;
    let stiffness = 3.0 * properties.bending_stiffness * total.powi(3) / (below * above).powi(3);
    let effective = mass + properties.mass_per_length * total / 3.0;
    let critical = limit * (effective / mass) * (stiffness / effective).sqrt();
    let scenario = scenario(
        "parking_garage",
        &["distance_m=fixed:0", "speed_km_h=lognormal:1.6:0.8"],
    );
    let truth = lognormal_exceedance(&scenario, critical);
    assert!((0.1..0.9).contains(&truth), "{truth}");
    let column = ElasticColumn {
        column: StudyColumn::undamaged(&parameters).unwrap(),
        mass,
        limit,
    };
    // The displacement at the critical speed first: the deviation of the mechanics must not eat up the interval.
    let at = column
        .column
        .evaluate(&Impact::rigid(mass, critical))
        .unwrap();
    assert!((at.max_v1 / limit - 1.0).abs() < 2e-3, "{}", at.max_v1);
    for seed in [1, 2, 3] {
        let sampler = DepartureSampler::new(&scenario, seed);
        let tally = run(&RiskStudy::new(&sampler, &column), 2, 0..400);
        let found = result(&scenario, &tally, 0.99).actions[0].given_departure;
        assert!(found.contains(truth), "{found:?} does not hold {truth}");
        assert!(found.high - found.low < 0.15);
    }
}

/// The rate of exceedance of a static force, `n T lambda dx P[sqrt(m k (v0^2 - 2 a r)) > X]`, of the JCSS Probabilistic Model
/// Code, against an integral over speed, angle and deceleration by the midpoint rule.
#[test]
fn the_rate_of_exceedance_is_the_integral() {
    let scenario = scenario("urban", &["distance_m=fixed:5"]);
    let (stiffness, force) = (300e3, 150e3);
    let exceeds =
        |mass: f64, square: f64| square > 0.0 && (mass * stiffness * square).sqrt() > force;
    let middle = |index: u32, count: u32| (f64::from(index) + 0.5) / f64::from(count);
    let (angles, decelerations, masses) = (150, 60, 60);
    let mut integral = 0.0;
    for class in &scenario.classes {
        for angle in 0..angles {
            let angle = scenario
                .angle
                .distribution
                .quantile(middle(angle, angles))
                .to_radians();
            let path = 5.0 / angle.sin();
            for deceleration in 0..decelerations {
                let deceleration = scenario
                    .deceleration
                    .distribution
                    .quantile(middle(deceleration, decelerations));
                for mass in 0..masses {
                    let mass = class.mass.distribution.quantile(middle(mass, masses));
                    // The integral over the speed is closed.
                    let least =
                        (force * force / (mass * stiffness) + 2.0 * deceleration * path).sqrt();
                    let weight = class.share / f64::from(angles * decelerations * masses);
                    integral += weight * lognormal_exceedance(&scenario, least);
                }
            }
        }
    }
    let known =
        Known(
            |departure: &Departure| match exceeds(departure.mass, departure.velocity.powi(2)) {
                true => Action::Evacuate,
                false => Action::None,
            },
        );
    let sampler = DepartureSampler::new(&scenario, 5);
    let tally = run(&RiskStudy::new(&sampler, &known), 2, 0..200_000);
    let exposure = Exposure::new(&scenario, 20_000.0, 50.0);
    let found = RiskResult::new(&scenario, &tally, exposure, 0.99);
    // n T lambda dx with b = 2.5 m and a mean angle of 10 degrees.
    let departures = 20_000.0 * 365.25 * 50.0 * 1e-10 * 2.5 / 10_f64.to_radians().sin();
    assert!((found.departures / departures - 1.0).abs() < 1e-12);
    let rate = departures * integral;
    let interval = found.actions[3].given_departure.times(departures);
    assert!(interval.contains(rate), "{interval:?} does not hold {rate}");
    assert!((interval.high - interval.low) < 0.15 * rate, "{interval:?}");
    let years = found.actions[3].return_period_years;
    assert!((years[0].unwrap() * interval.value / 50.0 - 1.0).abs() < 1e-12);
    assert!(years[1].unwrap() < years[0].unwrap() && years[0].unwrap() < years[2].unwrap());
}

#[test]
fn the_result_does_not_depend_on_the_threads_nor_on_the_parts() {
    let scenario = scenario("courtyard", &["distance_m=uniform:1:6"]);
    let column = RiskColumn::new(&Parameters::default(), &scenario).unwrap();
    let sampler = DepartureSampler::new(&scenario, 11);
    let study = RiskStudy::new(&sampler, &column);
    let whole = run(&study, 1, 0..120);
    assert!(whole.total().impacts() > 10);
    for threads in [2, 3] {
        assert_eq!(run(&study, threads, 0..120), whole);
    }
    let mut parts = run(&study, 2, 0..37);
    parts.merge(&run(&study, 1, 37..120));
    assert_eq!(parts, whole);
    // An interrupted study is the study of its first samples.
    let batch = Batch::of_threads(NonZeroUsize::new(2));
    batch.interrupt();
    let (none, end) = study
        .run(&batch, 0..120, |_| Ok::<_, StudyRunError>(()))
        .unwrap();
    assert_eq!((end, none.samples()), (BatchEnd::Interrupted(0), 0));
    let nothing = result(&scenario, &none, 0.95).actions[0].given_departure;
    assert_eq!((nothing.low, nothing.high), (0.0, sampler.reach_bound()));
}

#[test]
fn a_study_without_scatter_is_the_simulation() {
    let mut scenario = scenario(
        "parking_garage",
        &[
            "distance_m=fixed:0",
            "speed_km_h=fixed:36",
            "yield_strength_factor=fixed:1",
            "top_load_factor=fixed:1",
        ],
    );
    scenario.classes.truncate(2);
    for class in &mut scenario.classes {
        class.share = f64::from(class.vehicle == "mid_car");
        class.mass.distribution = Distribution::fixed(1719.0).unwrap();
        class.force_factor.distribution = Distribution::fixed(1.0).unwrap();
        class.height = None;
    }
    let parameters = Parameters::default();
    let column = RiskColumn::new(&parameters, &scenario).unwrap();
    let departure = DepartureSampler::new(&scenario, 3).departure(8);
    let direct = StudyColumn::undamaged(&parameters).unwrap();
    let impact = direct.impact(Some("mid_car"), None, 10.0).unwrap();
    assert_eq!(
        column.evaluate(&departure).unwrap(),
        direct.evaluate(&impact).unwrap()
    );
    // A fixed factor other than 1 changes the column.
    scenario
        .set("test", "yield_strength_factor=fixed:0.5")
        .unwrap();
    scenario.set("test", "top_load_factor=fixed:0.25").unwrap();
    let column = RiskColumn::new(&parameters, &scenario).unwrap();
    let departure = DepartureSampler::new(&scenario, 3).departure(8);
    let (sample, _) = column.sample(&departure).unwrap();
    assert_eq!(sample.parameters().steel().yield_strength, 0.5 * 355e6);
    assert_eq!(
        sample.parameters().settings().top.load,
        0.25 * parameters.settings().top.load
    );
}

#[test]
fn a_vehicle_that_brakes_long_enough_stops() {
    let distributions = [
        "speed_km_h=fixed:36",
        "angle_deg=fixed:30",
        "deceleration_m_s2=fixed:4",
        "distance_m=fixed:3",
    ];
    let scenario = scenario("parking_garage", &distributions);
    // v^2 = 100 - 2 * 4 * 6 = 52.
    let sampler = DepartureSampler::new(&scenario, 1);
    let departure = sampler.departure(0);
    assert!((departure.velocity - 52_f64.sqrt()).abs() < 1e-12);
    assert!((sampler.reach_bound() - 1.0).abs() < 1e-12);
    let mut farther = scenario;
    farther.set("test", "distance_m=fixed:6.3").unwrap();
    let sampler = DepartureSampler::new(&farther, 1);
    assert!(!sampler.departure(0).reaches_column());
    assert_eq!(sampler.reach_bound(), 0.0);
    // The result of a column that cannot be hit is a probability of 0.
    let known = Known(|_: &Departure| Action::Evacuate);
    let tally = run(&RiskStudy::new(&sampler, &known), 2, 0..100);
    let found = result(&farther, &tally, 0.95);
    assert_eq!(found.impact.high, 0.0);
    assert_eq!(found.actions[3].in_period.high, 0.0);
}

/// The vehicles that reach the column have the same distribution as those that a search among all departures finds, and their share
/// is the same: in a common case, where the search finds enough of them, and with distances that scatter.
#[test]
fn those_that_reach_the_column_are_those_of_all_departures() {
    for distance in ["distance_m=fixed:0.7", "distance_m=uniform:0.2:1.2"] {
        let scenario = scenario("urban", &[distance]);
        let sampler = DepartureSampler::new(&scenario, 9);
        let (mut mean, mut square, mut points) = ([0.0; 5], [0.0; 5], 0);
        let count = 40_000;
        for index in 0..count {
            let it = sampler.departure(index);
            points += it.points;
            let found = [
                it.velocity,
                it.angle,
                it.deceleration,
                it.distance,
                it.speed,
            ];
            for (input, x) in found.into_iter().enumerate() {
                mean[input] += x / count as f64;
                square[input] += x * x / count as f64;
            }
        }
        let share = sampler.reach_bound() * count as f64 / points as f64;
        assert!(points < 3 * count, "{points} points");
        // A plain search over sequences of Weyl, which have nothing in common with the sampler.
        let generators = [2_f64, 3.0, 5.0, 7.0].map(|it| it.sqrt().fract());
        let (all, mut reached, mut expected) = (1_000_000_u32, 0.0, [0.0; 5]);
        for point in 1..=all {
            let [speed, angle, deceleration, distance] =
                generators.map(|it| (f64::from(point) * it).fract());
            let speed = scenario.speed.distribution.quantile(speed) / 3.6;
            let angle = scenario.angle.distribution.quantile(angle).to_radians();
            let deceleration = scenario.deceleration.distribution.quantile(deceleration);
            let distance = scenario.distance.distribution.quantile(distance);
            let square = speed * speed - 2.0 * deceleration * distance / angle.sin();
            if square > LEAST_SPEED * LEAST_SPEED {
                reached += 1.0;
                for (sum, x) in
                    expected
                        .iter_mut()
                        .zip([square.sqrt(), angle, deceleration, distance, speed])
                {
                    *sum += x;
                }
            }
        }
        let plain = reached / f64::from(all);
        assert!(
            (share / plain - 1.0).abs() < 0.02,
            "{distance}: {share} {plain}"
        );
        for input in 0..5 {
            let expected = expected[input] / reached;
            let error =
                ((square[input] - mean[input] * mean[input]).max(0.0) / count as f64).sqrt();
            assert!(
                (mean[input] - expected).abs() < 4.0 * error + 1e-3 * expected,
                "{distance}: {input}: {} {expected}",
                mean[input]
            );
        }
    }
}

/// A column in a car park at 3 m, which two of a thousand departing vehicles reach: the probability is that of a quadrature.
#[test]
fn rare_impacts_have_the_probability_of_a_quadrature() {
    let scenario = scenario("parking_garage", &["distance_m=fixed:3"]);
    // P(angle > asin(2 a d / v^2)) over speed and deceleration, in their tails, too.
    let count = 1200;
    let deviations = |index: u32| 16.0 * (f64::from(index) + 0.5) / f64::from(count) - 8.0;
    let density = |z: f64| (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let lognormal = |mean: f64, deviation: f64, z: f64| {
        let variance = (deviation / mean).powi(2).ln_1p();
        (mean.ln() - 0.5 * variance + variance.sqrt() * z).exp()
    };
    let scale = 10.0 / std::f64::consts::FRAC_PI_2.sqrt();
    let mut truth = 0.0;
    for i in 0..count {
        let speed = lognormal(10.0, 5.0, deviations(i)) / 3.6;
        for j in 0..count {
            let sine = 2.0 * lognormal(4.0, 1.3, deviations(j)) * 3.0 / (speed * speed);
            if sine < 1.0 {
                let angle = sine.asin().to_degrees();
                let weight = density(deviations(i)) * density(deviations(j));
                truth += weight
                    * (16.0 / f64::from(count)).powi(2)
                    * (-0.5 * (angle / scale).powi(2)).exp();
            }
        }
    }
    assert!(truth < 5e-3, "{truth}");
    let sampler = DepartureSampler::new(&scenario, 4);
    let known = Known(|_: &Departure| Action::Inspect);
    let tally = run(&RiskStudy::new(&sampler, &known), 2, 0..20_000);
    let found = result(&scenario, &tally, 0.99);
    assert!(
        found.impact.contains(truth),
        "{:?} does not hold {truth}",
        found.impact
    );
    assert!(found.impact.high / found.impact.low - 1.0 < 0.05);
    assert_eq!(found.counts.impacts, 20_000);
}

/// Which input matters is known of limit states that depend on one or two of them.
#[test]
fn the_input_that_decides_has_all_of_the_variance() {
    let scenario = scenario("parking_garage", &["distance_m=fixed:0"]);
    let sampler = DepartureSampler::new(&scenario, 2);
    let heavy = Known(|departure: &Departure| match departure.quantiles[5] > 0.7 {
        true => Action::Shore,
        false => Action::None,
    });
    let tally = run(&RiskStudy::new(&sampler, &heavy), 2, 0..20_000);
    let found = &result(&scenario, &tally, 0.95).sensitivity[2];
    assert_eq!(
        (found.inputs[0].input, found.variance[0].input),
        ("mass", "mass")
    );
    assert!(found.variance[0].first_order > 0.99, "{:?}", found.variance);
    let (low, high) = (found.inputs[0].low, found.inputs[0].high);
    // At a distance of 0 every vehicle reaches the column.
    assert!(
        low.value == 0.0 && low.high > 0.0 && low.high < 0.01 && high.contains(1.0),
        "{low:?} {high:?}"
    );
    for other in &found.variance[1..] {
        assert!(other.first_order < 4.0 * other.error + 1e-3, "{other:?}");
    }
    // The event that both of two quantiles exceed 1/2: P = 1/4, V(E[Y|X]) = 1/16, V(Y) = 3/16, so 1/3 each and 1/3 together.
    let both = Known(|departure: &Departure| {
        match departure.quantiles[5].min(departure.quantiles[6]) > 0.5 {
            true => Action::Shore,
            false => Action::None,
        }
    });
    let tally = run(&RiskStudy::new(&sampler, &both), 2, 0..40_000);
    let found = &result(&scenario, &tally, 0.95).sensitivity[2];
    for input in &found.variance[..2] {
        assert!(
            (input.first_order - 1.0 / 3.0).abs() < 4.0 * input.error,
            "{input:?}"
        );
        assert!(input.error < 0.01);
    }
    assert!((found.interactions - 1.0 / 3.0).abs() < 0.02);
    // The highest tenth of the mass: the other one exceeds 1/2 with an even chance.
    assert!(found.inputs[0].high.contains(0.5), "{:?}", found.inputs[0]);
}
