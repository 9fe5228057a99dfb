//! Tests of the command `simulate` in this process.

use std::fs;

use clap::Parser;

use super::failure::{Exit, Failure};
use super::simulate::{SimulateArgs, run};
use column_twin::column::simulate;
use column_twin::parameters::{Parameters, Value};

#[derive(Parser)]
struct CommandLine {
    #[command(flatten)]
    arguments: SimulateArgs,
}

fn typed(line: &[&str]) -> (String, Result<(), Failure>) {
    let line = CommandLine::try_parse_from(["simulate"].iter().chain(line)).unwrap();
    let mut output = Vec::new();
    let ended = run(&line.arguments, &mut output);
    (String::from_utf8(output).unwrap(), ended)
}

#[test]
fn json_is_all_that_is_printed() {
    let (output, ended) = typed(&["--json", "--mass", "1500", "--velocity", "10"]);
    assert!(ended.is_ok());
    let json: serde_json::Value = serde_json::from_str(&output).unwrap();
    assert!(json["max_v1_m"].as_f64().unwrap() > 0.09);
}

#[test]
fn history_and_figures_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("history.csv");
    let figures = folder.path().join("figures");
    let (output, ended) = typed(&[
        "--csv",
        csv.to_str().unwrap(),
        "--figures",
        figures.to_str().unwrap(),
    ]);
    assert!(ended.is_ok(), "{ended:?}");
    assert!(
        output.contains("history.csv") && output.contains("28 files"),
        "{output}"
    );
    let rows = csv::Reader::from_path(csv).unwrap().records().count();
    assert!(rows > 500);
    assert_eq!(fs::read_dir(figures).unwrap().count(), 28);
}

#[test]
fn only_the_history_goes_to_the_standard_output() {
    let (output, ended) = typed(&["--csv", "-"]);
    assert!(ended.is_ok());
    assert!(output.starts_with("t_s,"));
    let mut table = csv::Reader::from_reader(output.as_bytes());
    assert!(table.records().all(|row| row.is_ok()));
}

/// The printed history is the one that the library simulates, in every number of every step.
#[test]
fn the_history_is_the_simulation() {
    let (output, ended) = typed(&["--csv", "-", "--mass", "1500", "--velocity", "8"]);
    assert!(ended.is_ok());
    let changes = [
        ("impact.mass", Value::from(1500.0)),
        ("impact.velocity", Value::from(8.0)),
    ];
    let parameters = Parameters::from_values(changes).unwrap();
    let mut samples = Vec::new();
    simulate(
        &parameters.column_properties(),
        &parameters.impact(),
        parameters.response_duration(),
        &mut |sample| samples.push(*sample),
    )
    .unwrap();
    let mut table = csv::Reader::from_reader(output.as_bytes());
    let names = table.headers().unwrap().clone();
    let at = |name: &str| names.iter().position(|it| it == name).unwrap();
    let columns = [
        at("t_s"),
        at("v1_m"),
        at("u2_m"),
        at("impact_impulse_Ns"),
        at("M3_Nm"),
    ];
    let mut steps = 0;
    for (row, sample) in table.records().zip(&samples) {
        let row = row.unwrap();
        let printed = columns.map(|column| row[column].parse::<f64>().unwrap());
        let simulated = [
            sample.time,
            sample.v1,
            sample.u2,
            sample.impact_impulse,
            sample.hinges[3].moment,
        ];
        assert_eq!(printed, simulated);
        steps += 1;
    }
    assert_eq!(steps, samples.len());
}

#[test]
fn bad_input_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let csv = folder.path().join("history.csv");
    let csv = csv.to_str().unwrap();
    let lines: [&[&str]; 9] = [
        &["--csv", csv, "--config", "missing.yaml"],
        &["--csv", csv, "--height", "7"],
        &["--csv", csv, "--height", "NaN"],
        &["--csv", csv, "--mass", "NaN"],
        &["--csv", csv, "--vehicle", "rigid", "--mass", "0"],
        &["--csv", csv, "--vehicle", "mid_cra"],
        &["--csv", csv, "--velocity", "-10"],
        &["--csv", csv, "-p", "impact.mas:=3"],
        &["--csv", "-", "--json"],
    ];
    for line in lines {
        let (output, ended) = typed(line);
        let failure = ended.unwrap_err();
        assert_eq!(failure.exit, Exit::BadInput, "{line:?}");
        assert!(
            output.is_empty() && fs::read_dir(folder.path()).unwrap().count() == 0,
            "{line:?}"
        );
    }
}

#[test]
fn unwritable_places_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    for option in ["--csv", "--figures"] {
        let (output, ended) = typed(&[option, file.join("x").to_str().unwrap()]);
        let failure = ended.unwrap_err();
        assert_eq!(failure.exit, Exit::Failed);
        assert!(
            failure.report.to_string().contains("file/x"),
            "{}",
            failure.report
        );
        assert!(output.is_empty());
    }
}

/// A real car hardly bends the column that the same speed of a rigid mass bends. Webs do not yield here, as in the paper.
#[test]
fn a_vehicle_crushes_where_a_rigid_mass_does_not() {
    const BENDING_ONLY: [&str; 5] = ["--json", "--velocity", "10", "-p", "shear.model:=none"];
    let json = |line: &[&str]| -> serde_json::Value {
        let (output, ended) = typed(&[line, &BENDING_ONLY].concat());
        assert!(ended.is_ok(), "{ended:?}");
        serde_json::from_str(&output).unwrap()
    };
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let rigid = json(&["--mass", "1719"]);
    let car = json(&["--vehicle", "mid_car"]);
    assert_eq!(
        (&rigid["vehicle"], &car["vehicle"]),
        (&"rigid".into(), &"mid_car".into())
    );
    assert!(number(&rigid["max_v1_m"]) > 10.0 * number(&car["max_v1_m"]));
    assert_eq!(rigid["crush_max_m"], serde_json::json!([]));
    let crush = number(&car["crush_max_m"][0]);
    let permanent = number(&car["crush_permanent_m"][0]);
    assert!(
        0.3 < permanent && permanent < crush && crush < 0.7,
        "{crush}"
    );
    // What the front does not absorb is left to the rebound and the column.
    let absorbed = number(&car["vehicle_dissipated_j"][0]) / number(&car["input_energy_j"]);
    assert!((0.8..1.0).contains(&absorbed), "{absorbed}");
    assert!(number(&car["ledger_residual"]) < 1e-10);
    // Without --mass the vehicle has its own, whatever the parameters give to another one.
    let energy = 0.5 * 1719.0 * 100.0;
    assert_eq!(number(&car["input_energy_j"]), energy);
    let given = json(&["--vehicle", "mid_car", "-p", "impact.mass:=1500.0"]);
    assert_eq!(number(&given["input_energy_j"]), 0.5 * 1500.0 * 100.0);
}

/// The history has columns for the springs and masses that the vehicle has, and for no others.
#[test]
fn the_history_shows_the_crush() {
    let header = |line: &[&str]| {
        let (output, ended) = typed(&[line, &["--csv", "-", "--velocity", "3"]].concat());
        assert!(ended.is_ok(), "{ended:?}");
        let mut table = csv::Reader::from_reader(output.as_bytes());
        let names = table.headers().unwrap().clone();
        let last = table.records().last().unwrap().unwrap();
        names
            .iter()
            .zip(last.iter())
            .map(|(name, value)| (name.to_owned(), value.parse::<f64>().unwrap()))
            .collect::<std::collections::BTreeMap<_, _>>()
    };
    let rigid = header(&[]);
    assert!(!rigid.keys().any(|name| name.contains("crush")));
    let lorry = header(&["--vehicle", "lorry_8t"]);
    for name in [
        "crush1_m",
        "crush2_m",
        "permanent_crush1_m",
        "crush_force2_N",
        "vehicle_velocity2_m_s",
        "vehicle_dissipated1_J",
    ] {
        assert!(lorry.contains_key(name), "{name}");
    }
    assert!(!lorry.contains_key("crush3_m"));
    assert!(lorry["permanent_crush1_m"] > 0.01 && lorry["vehicle_dissipated1_J"] > 1e3);
}

/// The report is one file that refers to nothing outside of itself, and whatever the parameters contain is text in it.
#[test]
fn the_report_is_one_file_and_escapes_every_text() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("report.html");
    let (output, ended) = typed(&[
        "--report",
        path.to_str().unwrap(),
        "-p",
        "column_id:=<script>alert(\"x\")</script>&amp;",
    ]);
    assert!(ended.is_ok(), "{ended:?}");
    assert!(output.contains("report.html"), "{output}");
    let html = fs::read_to_string(path).unwrap();
    assert!(html.starts_with("<!DOCTYPE html>"));
    assert!(!html.contains("<script"), "a script");
    assert!(html.contains("&lt;script&gt;alert(&quot;x&quot;)&lt;/script&gt;&amp;amp;"));
    for outside in ["src=", "href=\"http", "url(", "@import", "<link", "<iframe"] {
        assert!(!html.contains(outside), "{outside}");
    }
    assert!(html.matches("<svg").count() >= 8);
}

/// The same command gives the same bytes: a report contains no date of its own.
#[test]
fn a_report_is_reproducible() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["a.html", "b.html"].map(|name| {
        let path = folder.path().join(name);
        let (_, ended) = typed(&["--report", path.to_str().unwrap(), "--mass", "900"]);
        assert!(ended.is_ok(), "{ended:?}");
        fs::read(path).unwrap()
    });
    assert!(first == second);
}

/// The summary once said "a fractured hinge or web to a fractured hinge or web".
#[test]
fn a_band_of_one_outcome_is_not_from_it_to_itself() {
    let (output, ended) = typed(&["--mass", "20000", "--velocity", "20"]);
    assert!(ended.is_ok());
    let band = output.lines().find(|line| line.contains("peak v1, band"));
    let band = band.expect("a band");
    assert!(
        band.ends_with("a fractured hinge, web or base at both ends"),
        "{band}"
    );
}
