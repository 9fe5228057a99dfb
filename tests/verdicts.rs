//! Hits that a structural engineer has judged: the action of the program beside the action that the engineer would order.

use std::cmp::Ordering;
use std::path::PathBuf;

use column_twin::assessment::{
    Action, Assessment, Assumption, ImpactEvaluation, MissingData, VerdictRange, respond_and_rest,
};
use column_twin::column::Outcome;
use column_twin::parameters::{Parameters, parse_override};
use column_twin::second_opinion::evaluate;
use serde::Deserialize;

#[derive(Deserialize)]
struct Cases {
    cases: Vec<Case>,
}

/// One hit on a column that is `config/heb220_s355.yaml` otherwise.
#[derive(Deserialize)]
struct Case {
    id: u32,
    section: String,
    grade: String,
    height_m: f64,
    base: String,
    top: String,
    load_n: f64,
    vehicle: String,
    speed_m_s: f64,
    hit_height_m: f64,
    note: String,
    /// What the engineer would order.
    engineer: Action,
}

/// Cases in which the program is more severe than the engineer, and why: at most five, none of them by more than two classes.
const HARSHER: [(u32, &str); 5] = [
    (
        4,
        "the web yields in shear and leaves a bow of L/136; the engineer had only its resistance",
    ),
    (
        5,
        "the column collapses without strain rate; the engineer judged the bow of L/56 that one leaves",
    ),
    (
        10,
        "on the edge of yielding: a bow just above L/100 remains, nothing with the strain rate",
    ),
    (
        14,
        "the web yields in shear and leaves a bow of L/347; the engineer had only its resistance",
    ),
    (
        23,
        "the web fractures in shear; the engineer had only its resistance",
    ),
];

/// Of the cases that are harsher those whose range does not reach down to the action of the engineer.
const OUT_OF_RANGE: [u32; 1] = [23];

/// Cases in which the fibre beam alone makes the program more severe than the engineer: it bends and buckles between the hinges of
/// the two bars, and the more severe verdict of both models counts.
const HARSHER_BY_THE_BEAM: [u32; 3] = [13, 16, 20];

fn cases() -> Vec<Case> {
    // The engineer's word for taking the load off a column is the program's former one.
    let text = include_str!("data/verdict_cases.json").replace("\"prop\"", "\"shore\"");
    let Cases { cases } = serde_json::from_str(&text).expect("cases");
    assert_eq!(cases.len(), 25);
    cases
}

fn parameters_of(case: &Case) -> Parameters {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("config/heb220_s355.yaml");
    let overrides = [
        format!("section.name:={}", case.section),
        format!("steel.grade:={}", case.grade),
        format!("geometry.length_below:={:?}", case.hit_height_m),
        format!(
            "geometry.length_above:={:?}",
            case.height_m - case.hit_height_m
        ),
        format!("support.base:={}", case.base),
        format!("support.top:={}", case.top),
        format!("top.load:={:?}", case.load_n),
        format!("vehicle.name:={}", case.vehicle),
        format!("impact.velocity:={:?}", case.speed_m_s),
    ];
    let overrides: Vec<_> = overrides.iter().map(|it| parse_override(it)).collect();
    Parameters::load(&[file], &overrides).expect("parameters")
}

fn evaluated(case: &Case) -> ImpactEvaluation {
    let parameters = parameters_of(case);
    let (properties, impact) = (parameters.column_properties(), parameters.impact());
    let ended =
        respond_and_rest(&properties, &impact, parameters.response_duration()).expect("a response");
    ImpactEvaluation::complete(&parameters, &properties, &impact, ended).expect("an evaluation")
}

/// Where only the column with the nominal strength flows, the range judged the base of the stronger one, which stays elastic, by
/// the nominal forces without overstrength, which were smaller than its own: its least end was too mild.
#[test]
fn the_base_of_the_stronger_column_bears_its_own_forces() {
    const OVERSTRENGTH: f64 = 1.25;
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("config/heb220_s355.yaml");
    let hit = |strength: f64| {
        let overrides = [
            "geometry.length_below:=0.5".to_owned(),
            "geometry.length_above:=3.5".to_owned(),
            "vehicle.name:=mid_car".to_owned(),
            "impact.velocity:=10.0".to_owned(),
            format!("steel.yield_strength:={strength:?}"),
        ];
        let overrides: Vec<_> = overrides.iter().map(|it| parse_override(it)).collect();
        let parameters =
            Parameters::load(std::slice::from_ref(&file), &overrides).expect("parameters");
        let (properties, impact) = (parameters.column_properties(), parameters.impact());
        let ended = respond_and_rest(&properties, &impact, parameters.response_duration());
        ImpactEvaluation::complete(
            &parameters,
            &properties,
            &impact,
            ended.expect("a response"),
        )
        .expect("an evaluation")
    };
    let (nominal, stronger) = (hit(355e6), hit(OVERSTRENGTH * 355e6));
    assert_eq!(nominal.report.outcome, Outcome::Plastic);
    assert_eq!(stronger.report.outcome, Outcome::Elastic);
    let anchors = |of: &ImpactEvaluation| {
        let criteria = &of.assessment.as_ref().expect("an assessment").criteria;
        let criterion = criteria.iter().find(|it| it.name == "base_anchors_1_3");
        let criterion = criterion.expect("a criterion");
        criterion.value.zip(criterion.limit).expect("evaluated")
    };
    // Its own forces exceed what the anchors bear, the nominal ones would not without overstrength.
    let (with_overstrength, limit) = anchors(&nominal);
    assert!(with_overstrength / OVERSTRENGTH < limit);
    assert!(anchors(&stronger).0 > limit);
    let range = nominal.range.expect("a range");
    let mut variations = range.of_assumption(Assumption::YieldStrength);
    let variation = variations.next().expect("it is varied");
    assert_eq!(variation.report, stronger.report);
    let action = stronger.assessment.expect("an assessment").action;
    assert_eq!(action, Action::Restrict);
    assert_eq!(variation.action, action);
}

/// The verdict on a hit that these arguments alone describe, with its range.
fn judged(arguments: &[String]) -> (Assessment, VerdictRange) {
    let overrides: Vec<_> = arguments.iter().map(|it| parse_override(it)).collect();
    let parameters = Parameters::load(&[], &overrides).expect("parameters");
    let (properties, impact) = (parameters.column_properties(), parameters.impact());
    let ended =
        respond_and_rest(&properties, &impact, parameters.response_duration()).expect("a response");
    let evaluation = ImpactEvaluation::complete(&parameters, &properties, &impact, ended)
        .expect("an evaluation");
    let assessment = evaluation.assessment.expect("an assessment");
    (assessment, evaluation.range.expect("a range").ends)
}

/// Grade, load and supports that nobody had given were assumed without a word: 7 of 45 verdicts became milder for it.
#[test]
fn a_verdict_that_knows_less_is_as_severe_or_says_at_least_and_reaches_the_other() {
    let mut milder = 0;
    for (section, grade, load, base, vehicle, speed) in [
        ("HEA200", "S235", 4e5, "pinned", "mid_car", 6.0),
        ("HEB160", "S275", 6e5, "pinned", "suv", 6.0),
        ("HEB220", "S235", 1.2e6, "pinned", "lorry_8t", 4.0),
        ("HEB300", "S235", 2e6, "built_in", "lorry_16t", 5.0),
        ("IPE300", "S235", 2.5e5, "pinned", "forklift", 3.0),
        ("HEA240", "S460", 3e5, "built_in", "forklift", 3.5),
    ] {
        let column = [
            ("steel.grade", grade.to_owned()),
            ("top.load", format!("{load:?}")),
            ("support.base", base.to_owned()),
            ("support.top", "built_in".to_owned()),
        ];
        let hit = [
            format!("section.name:={section}"),
            "geometry.height:=4.0".to_owned(),
            format!("vehicle.name:={vehicle}"),
            format!("impact.velocity:={speed:?}"),
        ];
        let without = |removed: &str| {
            let given = column.iter().filter(|(name, _)| *name != removed);
            let given = given.map(|(name, value)| format!("{name}:={value}"));
            judged(&hit.iter().cloned().chain(given).collect::<Vec<_>>())
        };
        let (whole, _) = without("");
        let is_named = |it: &Assessment, name: &str| {
            let mut missing = it.not_evaluated.iter();
            missing.any(|missing| missing.criterion == name)
        };
        for (removed, _) in &column {
            assert!(!is_named(&whole, removed), "{}", whole.reason);
            let (less, range) = without(removed);
            let what = format!("{section} without {removed}: {}", less.reason);
            assert!(is_named(&less, removed), "{what}");
            assert!(less.reason.contains("was not given; "), "{what}");
            assert!(less.action >= whole.action || less.at_least, "{what}");
            assert!(range.most >= whole.action, "{what}");
            assert_eq!(
                less.reason.starts_with("At least "),
                less.at_least,
                "{what}"
            );
            milder += usize::from(less.action < whole.action);
        }
    }
    // Otherwise nothing was at stake.
    assert!(milder > 0);
}

/// A reason once began with "collapse: Collapse or fractured hinge or web in the response (1: yes): 1.00; at most 0 [C]".
fn is_an_order_with_its_cause(assessment: &Assessment) {
    let reason = &assessment.reason;
    let headline = &reason[..reason.len() - assessment.reservations().len()];
    if assessment.action != Action::None {
        let order = &assessment.action.order()[1..];
        let begin = format!("{order} Cause: {}.", assessment.cause);
        assert!(headline.contains(&begin), "{headline}");
    }
    let name = format!("{}:", assessment.deciding_criterion);
    for wrong in [" [", "at most", "1: yes", "limit 0", &name] {
        assert!(!headline.contains(wrong), "{headline:?} contains {wrong:?}");
    }
}

#[test]
fn no_verdict_is_milder_than_that_of_an_engineer() {
    let cases = cases();
    let (mut agree, mut harsher, mut out_of_range) = (0, Vec::new(), Vec::new());
    println!("case  program    engineer   residual  decides, and the range");
    for case in &cases {
        let evaluation = evaluated(case);
        let assessment = evaluation.assessment.expect("an assessment");
        is_an_order_with_its_cause(&assessment);
        let range = evaluation.range.expect("a range");
        let residual = match evaluation.report.residual_v1 {
            Some(v1) => format!("{:.1} mm", 1e3 * v1),
            None => "-".to_owned(),
        };
        println!(
            "{:4}  {:9}  {:9}  {residual:>8}  {}; {range}  ({} {}, {})",
            case.id,
            assessment.action.name(),
            case.engineer.name(),
            assessment.deciding_criterion,
            case.section,
            case.grade,
            case.note
        );
        // Of a pinned base nothing is assumed.
        let is_of_the_column = |it: &MissingData| !it.criterion.starts_with("base_");
        let unexpected = assessment.not_evaluated.iter().any(is_of_the_column);
        assert!(!unexpected, "{}: {}", case.id, assessment.reason);
        assert!(
            !assessment.at_least || case.base != "built_in",
            "{}: {}",
            case.id,
            assessment.reason
        );
        let found = (assessment.action, case.engineer);
        match found.0.cmp(&found.1) {
            Ordering::Less => panic!("case {}: {found:?}, milder than the engineer", case.id),
            Ordering::Equal => agree += 1,
            Ordering::Greater => {
                assert!(found.0 as u8 - found.1 as u8 <= 2, "{}: {found:?}", case.id);
                harsher.push(case.id);
            }
        }
        if case.engineer < range.ends.least || case.engineer > range.ends.most {
            out_of_range.push(case.id);
        }
    }
    println!("{agree} agree, {} are more severe", harsher.len());
    for (id, reason) in HARSHER {
        println!("case {id}: {reason}");
    }
    assert_eq!(harsher, HARSHER.map(|(id, _)| id));
    assert_eq!(out_of_range, OUT_OF_RANGE);
}

/// The verdict that `simulate` prints is that of both models; the documents counted only those of the two bars.
#[test]
#[ignore = "slow: 25 hits of the fibre beam"]
fn no_verdict_of_both_models_is_milder_than_that_of_an_engineer() {
    let (mut harsher, mut out_of_range) = (Vec::new(), Vec::new());
    for case in cases() {
        let evaluation = evaluate(&parameters_of(&case))
            .expect("a response")
            .evaluation;
        let action = evaluation.assessment.expect("an assessment").action;
        let found = (action, case.engineer);
        println!("case {}: {action}, the engineer {}", case.id, case.engineer);
        assert!(found.0 >= found.1, "case {}: {found:?}", case.id);
        assert!(found.0 as u8 - found.1 as u8 <= 2, "{}: {found:?}", case.id);
        if found.0 > found.1 {
            harsher.push(case.id);
        }
        let ends = evaluation.range.expect("a range").ends;
        if case.engineer < ends.least || case.engineer > ends.most {
            out_of_range.push(case.id);
        }
    }
    let mut expected = HARSHER.map(|(id, _)| id).to_vec();
    expected.extend(HARSHER_BY_THE_BEAM);
    expected.sort_unstable();
    assert_eq!(harsher, expected);
    assert_eq!(out_of_range, OUT_OF_RANGE);
}

/// The README, the page for operators and the report once drew the line of `restrict` and `shore` differently.
#[test]
fn the_documents_give_the_measure_of_each_action_as_the_program_does() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let page = |name: &str| std::fs::read_to_string(root.join(name)).expect("a page");
    let (criteria, operators) = (page("docs/assessment.md"), page("docs/operators.md"));
    for action in Action::ALL {
        let (first, rest) = action.order().split_at(1);
        let order = first.to_uppercase() + rest;
        let row = format!("| `{action}` | {order} |");
        assert!(criteria.contains(&row), "{row}");
        assert!(operators.contains(&format!("| `{action}` | ")), "{action}");
    }
    let readme = page("README.md");
    let words: Vec<_> = readme.split_whitespace().collect();
    let order = Action::Restrict.order();
    assert!(words.join(" ").contains(&order[1..]), "{order}");
}
