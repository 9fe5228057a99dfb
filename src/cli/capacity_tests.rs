//! Tests of the command `capacity` in this process.

use clap::Parser;
use serde_json::Value as Json;

use super::capacity::{CapacityArgs, run};
use super::failure::{Exit, Failure};

#[derive(Parser)]
struct CommandLine {
    #[command(flatten)]
    arguments: CapacityArgs,
}

fn typed(line: &[&str]) -> (String, Result<(), Failure>) {
    let line = CommandLine::try_parse_from(["capacity"].iter().chain(line)).unwrap();
    let mut output = Vec::new();
    let ended = run(&line.arguments, &mut output);
    (String::from_utf8(output).unwrap(), ended)
}

fn json(line: &[&str]) -> Json {
    let (output, ended) = typed(&[&["--json"], line].concat());
    assert!(ended.is_ok(), "{ended:?}");
    serde_json::from_str(&output).unwrap()
}

/// HEB 220 with the numbers of the paper, and Duan and Chen's surface.
const DUAN_CHEN: [&str; 6] = [
    "--config",
    concat!(env!("CARGO_MANIFEST_DIR"), "/config/heb220_paper.yaml"),
    "-p",
    "yield_surface.alpha:=1.0",
    "-p",
    "yield_surface.beta:=1.3",
];

/// Against `heb220_l250` of `crates/mechanics/tests/data/push_down_cases.json`, computed by a program of other authorship.
#[test]
fn an_impact_leaves_the_capacity_of_the_reference() {
    let impact = [
        "--after-impact",
        "--mass",
        "1500",
        "--velocity",
        "10",
        "-p",
        "capacity.imperfection:=0.016",
    ];
    let found = json(&[&DUAN_CHEN[..], &impact].concat());
    let near = |name: &str, expected: f64, tolerance: f64| {
        let value = found[name].as_f64().expect(name);
        assert!((value / expected - 1.0).abs() < tolerance, "{name} {value}");
    };
    near("undamaged_capacity_n", 3_005_187.8, 1e-4);
    near("residual_capacity_n", 2_187_512.5, 1e-3);
    near("capacity_ratio", 0.727_912, 1e-3);
    near("imperfection_m", 0.016, 1e-12);
    assert_eq!(found["undamaged_end"], "force_fell");
    assert_eq!(found["weak_axis_resistance_n"], Json::Null);
    assert_eq!(found["lower_bound"], false);
    // A bow of L/43; the section is given by numbers.
    assert_eq!(found["action"], "shore");
    assert_eq!(found["deciding_criterion"], "residual_bow_100");
    assert_eq!(found["at_least"], true);
    assert_eq!(found["criteria"].as_array().unwrap().len(), 36);
}

#[test]
fn a_undamaged_column_is_compared_with_itself() {
    let (text, ended) = typed(&[]);
    assert!(ended.is_ok());
    assert!(text.starts_with("HEB220, 4 m high: undamaged\n"), "{text}");
    assert!(text.contains("100 % of the undamaged column"), "{text}");
    assert!(text.contains("Action: NONE: "), "{text}");
    assert!(!text.contains("stands"), "{text}");
}

#[test]
fn a_collapsed_column_carries_nothing() {
    let line = [
        "--after-impact",
        "--mass",
        "1500",
        "--velocity",
        "12",
        "-p",
        "top.load:=2.0e6",
        "-p",
        "top.spring_stiffness:=0.0",
    ];
    let found = json(&line);
    assert_eq!(found["residual_capacity_n"], 0.0);
    assert_eq!(found["residual_end"], "no_equilibrium");
    assert_eq!(found["action"], "evacuate");
    assert_eq!(found["deciding_criterion"], "collapse");
    let (text, _) = typed(&line);
    assert!(text.contains("carries nothing"), "{text}");
}

#[test]
fn the_curves_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("push_down.svg");
    let figure = ["--after-impact", "--figure", path.to_str().unwrap()];
    let (text, ended) = typed(&[&DUAN_CHEN[..], &figure].concat());
    assert!(ended.is_ok(), "{ended:?}");
    assert!(text.contains("push_down.svg"), "{text}");
    let svg = std::fs::read_to_string(path).unwrap();
    for words in [
        "Axial force over shortening",
        "undamaged column",
        "column as it is",
        "applied load N",
    ] {
        assert!(svg.contains(words), "{words}");
    }
}

#[test]
fn bad_input_is_rejected_with_what_to_do() {
    let missing = typed(&["--state", "/does/not/exist.json"]).1.unwrap_err();
    assert_eq!(missing.exit, Exit::BadInput);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("state.json");
    std::fs::write(&path, "{}").unwrap();
    let malformed = typed(&["--state", path.to_str().unwrap()]).1.unwrap_err();
    assert_eq!(malformed.exit, Exit::BadInput);
    assert!(format!("{:?}", malformed.report).contains("state file"));
    let alone = typed(&["--mass", "1500"]).1.unwrap_err();
    assert_eq!(alone.exit, Exit::BadInput);
    assert!(format!("{:?}", alone.report).contains("--after-impact"));
    assert!(CommandLine::try_parse_from(["capacity", "--state", "x", "--after-impact"]).is_err());
}
