//! Hits that a structural engineer has judged: the severity of the program beside the action that the engineer would order.

use std::path::PathBuf;

use column_twin::assessment::{
    Assessment, AssessmentInput, MissingData, RemainingCapacity, Severity, assess, respond_and_rest,
};
use column_twin::column::{Model, Report};
use column_twin::parameters::{Parameters, parse_override};
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
    engineer: Severity,
}

/// Cases in which the program is milder than the engineer, because of what it does not know.
const MILDER: [(u32, &str); 5] = [
    (
        10,
        "on the edge of yielding: the strain rate keeps it elastic, a fibre beam without it is left with 35 to 56 mm",
    ),
    (
        11,
        "on the edge of yielding: the strain rate keeps it elastic, a fibre beam without it is left with 52 to 65 mm",
    ),
    (
        12,
        "45 mm remain with strain rate and hardening, 88 mm in a fibre beam",
    ),
    (
        18,
        "22 mm remain with strain rate and hardening; the engineer judged 39 mm",
    ),
    (
        24,
        "69 mm remain; hardening and strain rate leave less bow than the engineer judged",
    ),
];

fn assessed(case: &Case) -> (Report, Assessment) {
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
    let parameters = Parameters::load(&[file], &overrides).expect("parameters");
    let (properties, impact) = (parameters.column_properties(), parameters.impact());
    let model = Model::new(&properties).expect("a column");
    let (report, rest) =
        respond_and_rest(&properties, &impact, parameters.response_duration()).expect("a response");
    let remaining =
        RemainingCapacity::compute(&parameters, &model, rest.as_ref()).expect("capacities");
    let input = AssessmentInput::of_response(&parameters, &model, &impact, &report, remaining);
    (report, assess(&input))
}

#[test]
fn no_verdict_is_milder_than_that_of_an_engineer() {
    let text = include_str!("data/verdict_cases.json");
    let Cases { cases } = serde_json::from_str(text).expect("cases");
    assert_eq!(cases.len(), 25);
    let (mut agree, mut harsher, mut milder) = (0, 0, Vec::new());
    println!("case  program    engineer   residual  decides");
    for case in &cases {
        let (report, assessment) = assessed(case);
        let residual = match report.residual_v1 {
            Some(v1) => format!("{:.1} mm", 1e3 * v1),
            None => "-".to_owned(),
        };
        println!(
            "{:4}  {:9}  {:9}  {residual:>8}  {}  ({} {}, {})",
            case.id,
            assessment.severity.name(),
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
        match assessment.severity.cmp(&case.engineer) {
            std::cmp::Ordering::Less => milder.push(case.id),
            std::cmp::Ordering::Equal => agree += 1,
            std::cmp::Ordering::Greater => {
                harsher += 1;
                let classes = assessment.severity as u8 - case.engineer as u8;
                assert!(classes <= 2, "case {} by {classes} classes", case.id);
            }
        }
    }
    println!(
        "{agree} agree, {harsher} are more severe, {} are milder: {milder:?}",
        milder.len()
    );
    assert!(harsher <= 5, "{harsher} are more severe");
    for id in &milder {
        let known = MILDER.iter().find(|(known, _)| known == id);
        let (_, reason) = known.unwrap_or_else(|| panic!("case {id} is milder than the engineer"));
        println!("case {id}: {reason}");
    }
    // A reason that is no longer one is removed.
    for (id, reason) in MILDER {
        assert!(
            milder.contains(&id),
            "case {id} is no longer milder ({reason}): remove it"
        );
    }
}
