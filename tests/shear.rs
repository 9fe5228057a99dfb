//! Shear of the web through the parameters of the program: finite-element impacts, sections by numbers, bumpers of vehicles.

use column_twin::assessment::{
    Action, ActionRange, Assumption, HARDENING_BAND, ImpactEvaluation, respond_and_rest,
};
use column_twin::column::{
    End, Impact, ImpactSpecification, Model, Outcome, Report, State, plastic_plateau,
};
use column_twin::parameters::{NoShear, Parameters, Value};
use column_twin::study::StudyColumn;
use serde_json::Value as Json;

/// Impacts in which 2 % of strength change the displacement by tens of per cent: the front gives just what the web bears.
const AT_THE_THRESHOLD: [&str; 4] = [
    "heb220_0.5_car500_20",
    "heb300_0.5_car900_20",
    "heb220_0.5_elastic300_20",
    "heb220_0.5_elastic300_30_b1e-2",
];

fn number(case: &Json, name: &str) -> f64 {
    case[name]
        .as_f64()
        .unwrap_or_else(|| panic!("{name} in {case}"))
}

fn numbers(case: &Json, name: &str) -> Vec<f64> {
    let list = case[name].as_array().expect("a list");
    list.iter()
        .map(|it| it.as_f64().expect("a number"))
        .collect()
}

fn parameters(values: Vec<(&str, Value)>) -> Parameters {
    Parameters::from_values(values).expect("admissible")
}

/// The finite elements have neither a strain rate nor a cap of the hardening nor fracture.
fn as_the_finite_elements() -> Vec<(&'static str, Value)> {
    vec![
        ("rate.law", "none".into()),
        ("shear.max_hardening", 0.0.into()),
        ("assessment.ultimate_rotation", 0.0.into()),
    ]
}

fn case_parameters(case: &Json) -> Parameters {
    let mut values = as_the_finite_elements();
    values.extend([
        (
            "section.name",
            case["section"].as_str().expect("a name").into(),
        ),
        ("steel.grade", "S355".into()),
        ("geometry.length_below", number(case, "length_below").into()),
        ("geometry.length_above", number(case, "length_above").into()),
        ("top.load", number(case, "load").into()),
        ("top.spring_stiffness", 1e7.into()),
        ("hardening.ratio", number(case, "hardening_ratio").into()),
        ("impact.velocity", number(case, "velocity").into()),
        (
            "vehicle.bumper_height",
            number(case, "bumper_height").into(),
        ),
    ]);
    let front = &case["front"];
    if front.is_null() {
        values.push(("impact.mass", number(case, "mass").into()));
    } else {
        // The points of a parameter begin after (0, 0).
        let points = numbers(front, "crush")
            .into_iter()
            .zip(numbers(front, "force"));
        let (crush, force): (Vec<f64>, Vec<f64>) = points.filter(|(crush, _)| *crush > 0.0).unzip();
        values.extend([
            ("vehicle.masses", vec![number(case, "mass")].into()),
            ("vehicle.spring_1.crush", crush.into()),
            ("vehicle.spring_1.force", force.into()),
            (
                "vehicle.spring_1.unloading_stiffness",
                number(front, "ku").into(),
            ),
        ]);
    }
    parameters(values)
}

fn response(parameters: &Parameters) -> Report {
    let (properties, impact) = (parameters.column_properties(), parameters.impact());
    let (report, _) = respond_and_rest(&properties, &impact, 2.0).expect("a response");
    report
}

/// 44 impacts that an explicit finite-element code in plane stress computed.
#[test]
fn impacts_of_finite_elements() {
    let cases = include_str!("../crates/mechanics/tests/data/shear_cases.jsonl");
    let (mut failures, mut soft) = (Vec::new(), Vec::new());
    let mut rigid = 0;
    for line in cases.lines() {
        let case: Json = serde_json::from_str(line).expect("a case");
        let id = case["id"].as_str().expect("a name");
        let report = response(&case_parameters(&case));
        let ratio = report.max_v1 / number(&case, "max_v1");
        println!(
            "{id:<34} v1 {:7.2} mm, {ratio:.3} of the reference",
            1e3 * report.max_v1
        );
        if AT_THE_THRESHOLD.contains(&id) {
            continue;
        }
        let tolerance = match case["front"].is_null() {
            true => {
                rigid += 1;
                0.10
            }
            false => {
                soft.push(ratio);
                0.20
            }
        };
        for (found, name) in [
            (report.max_v1, "max_v1"),
            (report.residual_v1.unwrap_or(f64::NAN), "residual_v1"),
        ] {
            let expected = number(&case, name);
            let error = (found - expected).abs();
            if error.is_nan() || error > (tolerance * expected).max(2e-3) {
                failures.push(format!("{id}: {name} {found} m instead of {expected} m"));
            }
        }
    }
    let mean = soft.iter().sum::<f64>() / soft.len() as f64;
    println!("mean of {} soft vehicles {mean:.3}", soft.len());
    assert_eq!(rigid + soft.len(), 40);
    assert!((mean - 1.0).abs() <= 0.08, "{mean}");
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// HEB 220 in S355, 4 m high, hit at the height of a car by a front of this force \[N\] at 15 m/s.
fn car(force: f64) -> Vec<(&'static str, Value)> {
    vec![
        ("geometry.length_below", 0.5.into()),
        ("geometry.length_above", 3.5.into()),
        ("impact.velocity", 15.0.into()),
        ("vehicle.masses", vec![1719.0].into()),
        ("vehicle.spring_1.crush", vec![0.2, 1.0].into()),
        ("vehicle.spring_1.force", vec![force, force].into()),
        ("vehicle.spring_1.unloading_stiffness", 1e7.into()),
        ("vehicle.bumper_height", 0.2.into()),
    ]
}

/// The commonest hit, for which earlier versions said 1 to 3 mm, none or inspect.
#[test]
fn a_car_at_its_own_height_shears_the_web() {
    for force in [600e3, 800e3] {
        // The weak end of the band: with the hardening of the default the softer front just does not fracture the web.
        let mut values = car(force);
        values.push(("hardening.ratio", HARDENING_BAND[0].into()));
        let parameters = parameters(values);
        let (properties, impact) = (parameters.column_properties(), parameters.impact());
        let ended = respond_and_rest(&properties, &impact, 2.0).expect("a response");
        let evaluation = ImpactEvaluation::complete(&parameters, &properties, &impact, ended)
            .expect("an evaluation");
        let report = &evaluation.report;
        assert_eq!(
            (report.outcome, report.end),
            (Outcome::Fractured, End::Fractured)
        );
        assert!(report.webs[0].plastic_angle >= 0.17, "{report:?}");
        let assessment = evaluation.assessment.expect("an assessment");
        assert_eq!(assessment.action, Action::Evacuate);
        let (report, range) = by_default(force);
        assert!(report.webs[0].plastic_angle > 0.15, "{report:?}");
        assert!(range.ends.least >= Action::Restrict, "{range}");
        // The weak end of the band of the steel once left the webs as they were.
        let weakest = range.of_assumption(Assumption::Hardening).next();
        let weakest = weakest.map(|it| (it.action, it.report.outcome));
        assert_eq!(weakest, Some((Action::Evacuate, Outcome::Fractured)));
        assert_eq!(range.ends.most, Action::Evacuate, "{range}");
        // Without the limits of deformation it bends by as much as the finite elements say: 185 and 206 mm.
        let mut values = car(force);
        values.extend(as_the_finite_elements());
        values.push(("hardening.ratio", 1e-4.into()));
        values.push(("top.spring_stiffness", 1e7.into()));
        let unlimited = response(&self::parameters(values));
        assert!(
            (0.15..0.25).contains(&unlimited.max_v1),
            "{}",
            unlimited.max_v1
        );
        // The paper's model, which only bends.
        let mut values = car(force);
        values.push(("shear.model", "none".into()));
        let bending = response(&self::parameters(values));
        assert!(bending.max_v1 < 4e-3, "{}", bending.max_v1);
    }
}

/// The response and the range of its verdict with the hardening of the default.
fn by_default(force: f64) -> (Report, ActionRange) {
    evaluated(&parameters(car(force)))
}

/// The response and the range of its verdict.
fn evaluated(parameters: &Parameters) -> (Report, ActionRange) {
    let (properties, impact) = (parameters.column_properties(), parameters.impact());
    let ended = respond_and_rest(&properties, &impact, 2.0).expect("a response");
    let evaluation =
        ImpactEvaluation::complete(parameters, &properties, &impact, ended).expect("an evaluation");
    (evaluation.report, evaluation.range.expect("a range"))
}

/// Where 2 % of strength decide, no single number is right, but the band of the steel that is shown with it is, and so is the range of
/// the verdict.
///
/// The band once ended above `heb220_0.5_elastic300_20`, in which the web just yields by the finite elements (2.45 mm), and just does
/// not by two bars whose flanges help it at once (1.42 mm with any hardening).
#[test]
fn the_band_of_the_steel_contains_the_finite_elements_at_the_threshold() {
    let cases = include_str!("../crates/mechanics/tests/data/shear_cases.jsonl");
    let mut compared = 0;
    for line in cases.lines() {
        let case: Json = serde_json::from_str(line).expect("a case");
        let id = case["id"].as_str().expect("a name");
        if !AT_THE_THRESHOLD.contains(&id) {
            continue;
        }
        compared += 1;
        let expected = number(&case, "max_v1");
        let (report, range) = evaluated(&case_parameters(&case));
        let contains = |peaks: &[f64]| {
            let smallest = peaks.iter().copied().fold(report.max_v1, f64::min);
            let largest = peaks.iter().copied().fold(report.max_v1, f64::max);
            println!("{id}: {smallest} to {largest} m, reference {expected} m");
            (smallest..=largest).contains(&expected)
        };
        let band = range.band().expect("a band");
        assert!(contains(&band.map(|it| it.report.max_v1)), "{id}");
        let all = range.variations.iter().map(|it| it.report.max_v1);
        assert!(contains(&all.collect::<Vec<_>>()), "{id}");
    }
    assert_eq!(compared, AT_THE_THRESHOLD.len());
}

/// A section by numbers shears where its web is known, as the same section by its name does.
#[test]
fn a_section_by_numbers_shears_where_its_web_is_known() {
    // A section by its name hardens unless told otherwise.
    let mut values = as_the_finite_elements();
    values.push(("hardening.ratio", 0.0.into()));
    let named = parameters(values.clone());
    let (section, shear) = (named.section(), named.shear().expect("a web"));
    values.extend([
        ("section.area", section.area.into()),
        ("section.second_moment", section.second_moment.into()),
        ("section.mass_per_length", section.mass_per_length.into()),
        ("resistance.moment", named.resistance_moment().into()),
    ]);
    let unknown = parameters(values.clone());
    assert_eq!(unknown.shear(), Err(NoShear::WebNotKnown));
    assert_eq!(unknown.column_properties().shear, None);
    let text = NoShear::WebNotKnown.to_string();
    assert!(text.contains("section.web_thickness"), "{text}");
    values.extend([
        ("section.height", 0.22.into()),
        ("section.web_thickness", 0.0095.into()),
    ]);
    let without_flanges = parameters(values.clone()).shear().expect("a web");
    // f_y / sqrt(3) t_w h, as where the flanges are not known.
    let expected = 355e6 / 3.0_f64.sqrt() * 0.0095 * 0.22;
    assert!((without_flanges.resistance(0.5) / expected - 1.0).abs() < 1e-12);
    values.extend([
        ("section.width", 0.22.into()),
        ("section.flange_thickness", 0.016.into()),
    ]);
    assert_eq!(parameters(values.clone()).shear(), Ok(shear));
    values.push(("resistance.shear", 5e5.into()));
    let given = parameters(values).shear().expect("a web");
    assert_eq!(given.resistance(0.3), 5e5);
    assert_eq!(given.rigidity, shear.rigidity);
}

/// The cap of the hardening follows the steel, and `assessment.ultimate_rotation: 0` lifts every limit of deformation.
#[test]
fn defaults_follow_the_steel_and_the_limits() {
    let shear = |values: Vec<(&str, Value)>| parameters(values).shear().expect("a web");
    assert_eq!(shear(vec![]).max_hardening, 490.0 / 355.0);
    assert_eq!(shear(vec![]).ultimate_angle, 0.17);
    assert_eq!(
        shear(vec![("steel.grade", "S235".into())]).max_hardening,
        360.0 / 235.0
    );
    let lifted = shear(vec![("assessment.ultimate_rotation", 0.0.into())]);
    assert_eq!(lifted.ultimate_angle, 0.0);
    let changed = Parameters::default()
        .with_changes([("steel.grade", Value::from("S460"))])
        .expect("admissible");
    assert_eq!(changed.settings().shear.max_hardening, 540.0 / 460.0);
    let kept = parameters(vec![("shear.max_hardening", 0.0.into())])
        .with_changes([("steel.grade", Value::from("S460"))])
        .expect("admissible");
    assert_eq!(kept.settings().shear.max_hardening, 0.0);
}

/// A vehicle that is named has the bumper of the catalogue; the rigid mass presses on a point.
#[test]
fn the_bumper_belongs_to_the_vehicle() {
    let parameters = parameters(vec![
        ("geometry.length_below", 0.5.into()),
        ("geometry.length_above", 3.5.into()),
    ]);
    assert_eq!(parameters.impact().bumper_height, 0.0);
    assert_eq!(parameters.bumper_named("mid_car"), 0.2);
    let column = StudyColumn::undamaged(&parameters).expect("a column");
    let rigid = column.impact(None, None, 5.0).expect("an impact");
    let behind = Impact {
        bumper_height: 0.2,
        ..rigid
    };
    let [at_a_point, before_a_bumper] =
        [rigid, behind].map(|it| column.evaluate(&it).expect("an evaluation").max_v1);
    // The shorter bar is stronger: 0.2 m take about 4 % off such a hit.
    assert!(
        before_a_bumper < 0.98 * at_a_point,
        "{before_a_bumper} {at_a_point}"
    );
    let (report, _) =
        respond_and_rest(&parameters.column_properties(), &behind, 2.0).expect("a response");
    assert!((report.max_v1 / before_a_bumper - 1.0).abs() < 1e-3);
    let F0 { point, bumper } = plateaus(&parameters);
    assert!((point / 585e3 - 1.0).abs() < 0.13, "{point}");
    assert!((bumper / 608e3 - 1.0).abs() < 0.13, "{bumper}");
    let named = parameters
        .with_changes([("vehicle.name", Value::from("mid_car"))])
        .expect("admissible");
    assert_eq!(named.impact().bumper_height, 0.2);
}

/// `F0` of a force at a point and of a bumper of 0.2 m, without a load; limit analysis has 576 to 594 and 596 to 620 kN.
struct F0 {
    point: f64,
    bumper: f64,
}

fn plateaus(parameters: &Parameters) -> F0 {
    let of = |bumper_height: f64| {
        let impact = Impact {
            bumper_height,
            ..parameters.impact()
        };
        let model = Model::new(&parameters.column_properties().before(&impact)).expect("a column");
        plastic_plateau(&model, 0.0)
    };
    F0 {
        point: of(0.0),
        bumper: of(0.2),
    }
}

#[test]
fn a_bumper_that_leaves_nothing_clear_is_rejected() {
    let faults = Parameters::from_values([
        ("geometry.length_below", Value::from(0.1)),
        ("vehicle.bumper_height", 0.2.into()),
    ])
    .expect_err("no clear length")
    .to_string();
    assert!(
        faults.contains("vehicle.bumper_height is 0.2 m"),
        "{faults}"
    );
    assert!(faults.contains("give at most 0.18 m"), "{faults}");
    let thick = Parameters::from_values([("section.flange_thickness", Value::from(0.11))])
        .expect_err("no web")
        .to_string();
    assert!(
        thick.contains("two flanges are as thick as the section is high"),
        "{thick}"
    );
}

/// Two impacts one after the other: the damage of the first one is found by the second, before another bumper.
#[test]
fn damage_is_carried_from_one_bumper_to_another() {
    let parameters = parameters(vec![
        ("geometry.length_below", 0.5.into()),
        ("geometry.length_above", 3.5.into()),
        ("assessment.ultimate_rotation", 0.0.into()),
    ]);
    let properties = parameters.column_properties();
    let specification = ImpactSpecification {
        mass: 1500.0,
        velocity: 5.0,
        gap: None,
        restitution: None,
        height: None,
        direction: None,
    };
    let impact = specification
        .complete(&parameters.impact(), None, 0.2)
        .expect("an impact");
    let (report, rest) = respond_and_rest(&properties, &impact, 2.0).expect("a response");
    let rest = rest.expect("it stands");
    let residual = report.residual_v1.expect("it stands");
    // Without the bumper the impact point is where it was, but for the elastic part.
    assert!(
        (rest.displacement.v1 / residual - 1.0).abs() < 0.05,
        "{residual}"
    );
    let model = Model::new(&properties).expect("a column");
    let column = StudyColumn::at_rest(&parameters, model, rest).expect("a column");
    for bumper_height in [0.0, 0.2] {
        let next = Impact {
            bumper_height,
            ..impact
        };
        let evaluation = column.evaluate(&next).expect("an evaluation");
        assert!(evaluation.max_v1 > 1.5 * residual, "{evaluation:?}");
    }
    assert!(State::at_rest(&model).plastic != rest.plastic);
}
