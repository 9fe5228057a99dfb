//! `column-twin map` and `column-twin risk` over the files of a fleet.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use column_twin::parameters::{Parameters, Value};
use column_twin::study::{ACTIONS, StudyColumn};

const NODE: &str = "\
/**:
  ros__parameters:
    solver: {dt: 1.0e-4}
    vehicle: {name: mid_car}
    impact: {mass: 0.0}
";

/// Five columns of three kinds.
const TABLE: &str = "\
namespace,column_id,section.name
/hall/c1,c1,HEB 160
/hall/c2,c2,HEB 120
/hall/c3,c3,HEB 160
/hall/c4,c4,HEB 200
/hall/c5,c5,HEB 120
";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("fleet.yaml"), NODE).expect("written");
    fs::write(folder.path().join("fleet.csv"), TABLE).expect("written");
    folder
}

fn typed(folder: &Path, line: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_column-twin"))
        .args(line.split_whitespace())
        .current_dir(folder)
        .output()
        .expect("runs")
}

fn done(folder: &Path, line: &str) -> String {
    let output = typed(folder, line);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{line}: {errors}");
    String::from_utf8(output.stdout).expect("text")
}

fn rejected(folder: &Path, line: &str) -> String {
    let output = typed(folder, line);
    assert_eq!(output.status.code(), Some(2), "{line}");
    String::from_utf8(output.stderr).expect("text")
}

const MAP: &str = "map --params-file fleet.yaml --columns fleet.csv --velocity 2:30";

fn fields(line: &str) -> Vec<&str> {
    line.split(',').collect()
}

#[test]
fn every_column_has_the_critical_velocities_of_its_own_properties() {
    let folder = folder();
    let folder = folder.path();
    let table = done(folder, &format!("{MAP} --csv -"));
    let rows: Vec<_> = table.lines().skip(1).map(fields).collect();
    let ids: Vec<_> = rows.iter().map(|it| it[1]).collect();
    assert_eq!(ids, ["c1", "c2", "c3", "c4", "c5"]);
    for (id, section) in [("c2", "HEB120"), ("c3", "HEB160"), ("c4", "HEB200")] {
        let values = [
            ("section.name", Value::from(section)),
            ("solver.dt", Value::from(1e-4)),
            ("vehicle.name", Value::from("mid_car")),
            ("impact.mass", Value::from(0.0)),
        ];
        let parameters = Parameters::from_values(values).expect("admissible");
        let study = StudyColumn::undamaged(&parameters).expect("a column");
        let action_at = |velocity: f64| {
            let impact = study.impact(None, None, velocity).expect("an impact");
            study.evaluate(&impact).expect("computed").action
        };
        let row = rows.iter().find(|it| it[1] == id).expect("its row");
        for (index, action) in ACTIONS.into_iter().enumerate() {
            let below: Option<f64> = row[5 + index].parse().ok();
            match below {
                None => assert!(
                    row[5 + index].is_empty() && action_at(30.0) < action,
                    "{id}"
                ),
                Some(0.0) => assert!(action_at(2.0) >= action, "{id}"),
                Some(below) => {
                    assert!(action_at(below) < action, "{id} {action}");
                    assert!(action_at(1.011 * below) >= action, "{id} {action}");
                }
            }
        }
    }
    // Equal columns have equal results and one kind.
    assert_eq!(rows[0][2..], rows[2][2..]);
    assert_eq!(rows[1][2..], rows[4][2..]);
    let text = done(folder, &format!("{MAP} --column c4,c2"));
    assert!(text.starts_with("2 columns of 2 kinds"), "{text}");
    let place = |id: &str| text.find(&format!("\n{id} ")).expect("its line");
    assert!(place("c2") < place("c4"), "the weaker one first: {text}");
}

#[test]
fn the_parts_of_a_fleet_are_the_whole() {
    let folder = folder();
    let folder = folder.path();
    let rows = |shard: &str| {
        let table = done(folder, &format!("{MAP} --csv - {shard}"));
        let rows = table.lines().skip(1).map(fields_without_kind);
        rows.collect::<Vec<_>>()
    };
    // Kinds are numbered in each part.
    fn fields_without_kind(line: &str) -> Vec<String> {
        let mut fields: Vec<_> = fields(line).into_iter().map(str::to_owned).collect();
        fields.remove(2);
        fields
    }
    let parts: Vec<_> = (1..=3)
        .flat_map(|part| rows(&format!("--shard {part}/3")))
        .collect();
    assert_eq!(parts, rows(""));
}

#[test]
fn the_risk_of_a_column_is_the_same_in_a_fleet_and_alone() {
    const RISK: &str =
        "--scenario parking_garage --distance 0.5 --vehicles-per-day 2000 --samples 300 --json";
    let folder = folder();
    let folder = folder.path();
    let json = |line: &str| -> serde_json::Value {
        serde_json::from_str(&done(folder, line)).expect("JSON")
    };
    let fleet = json(&format!(
        "risk --params-file fleet.yaml --columns fleet.csv {RISK}"
    ));
    let columns = fleet["columns"].as_array().expect("columns");
    assert_eq!(columns.len(), 5);
    let of = |id: &str| {
        let column = columns.iter().find(|it| it["column_id"] == id);
        column.expect("its result")["in_period"].clone()
    };
    for (id, section) in [("c1", "HEB160"), ("c2", "HEB120")] {
        let alone = json(&format!(
            "risk -p section.name:={section} -p solver.dt:=1.0e-4 -p vehicle.name:=mid_car -p impact.mass:=0.0 {RISK}"
        ));
        for action in alone["actions"].as_array().expect("actions") {
            let name = action["action"].as_str().expect("a name");
            assert_eq!(of(id)[name], action["in_period"], "{id} {name}");
        }
    }
    assert_eq!(of("c1"), of("c3"));
    let sum: f64 = columns
        .iter()
        .map(|it| {
            it["in_period"]["inspect"]["value"]
                .as_f64()
                .expect("a number")
        })
        .sum();
    let expected = fleet["expected_columns"]["inspect"]
        .as_f64()
        .expect("a number");
    assert!(
        sum > 0.0 && (sum - expected).abs() <= 1e-12 * sum,
        "{sum} {expected}"
    );
    let risks: Vec<_> = columns
        .iter()
        .map(|it| {
            it["in_period"]["evacuate"]["value"]
                .as_f64()
                .expect("a number")
        })
        .collect();
    assert!(risks.is_sorted_by(|a, b| a >= b), "{risks:?}");
}

#[test]
fn what_a_study_of_a_fleet_does_not_have_is_rejected() {
    let folder = folder();
    let folder = folder.path();
    for (line, expected) in [
        (
            format!("{MAP} --column c9"),
            "the fleet of 5 columns has no c9",
        ),
        (
            format!("{MAP} --refine --height 1"),
            "does not have --height, --refine",
        ),
        (MAP.replace("2:30", "30"), "expected a range from:to"),
        (format!("{MAP} --shard 4/3"), "--shard 4/3"),
        (
            "map --column c1 --mass 1:2:3 --velocity 1:2:3".to_owned(),
            "--column names columns of a fleet",
        ),
        (
            "risk --columns fleet.csv --scenario urban --vehicles-per-day 1 --figures x".to_owned(),
            "does not have --figures",
        ),
    ] {
        let errors = rejected(folder, &line);
        assert!(errors.contains(expected), "{line}: {errors}");
    }
    fs::write(
        folder.join("fleet.csv"),
        TABLE.replace("HEB 200", "HEB 201"),
    )
    .expect("written");
    let errors = rejected(folder, MAP);
    assert!(errors.contains("HEB 201"), "{errors}");
}
