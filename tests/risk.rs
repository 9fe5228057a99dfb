//! `column-twin risk` as a user meets it: results, files, wrong input, Ctrl-C.
#![cfg(all(feature = "cli", target_os = "linux"))]

mod program;

use std::fs;
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

use program::{interrupt, program, run};
use serde_json::Value as Json;

/// A column beside a street, with few samples.
const STREET: [&str; 7] = [
    "risk",
    "--scenario",
    "urban",
    "--vehicles-per-day",
    "10000",
    "--seed",
    "7",
];

/// A study of the street with further arguments.
fn street<'a>(arguments: &[&'a str]) -> Vec<&'a str> {
    STREET.iter().chain(arguments).copied().collect()
}

fn json(output: &Output) -> Json {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut outputs = Vec::new();
    for threads in ["1", "2", "3"] {
        let csv = format!("curves{threads}.csv");
        let samples = format!("samples{threads}.csv");
        let arguments = [
            "--samples",
            "60",
            "--threads",
            threads,
            "--json",
            "--csv",
            &csv,
            "--samples-csv",
            &samples,
        ];
        let found = json(&run(folder.path(), &street(&arguments)));
        let read = |name: &str| fs::read_to_string(folder.path().join(name)).expect("written");
        outputs.push((found.to_string(), read(&csv), read(&samples)));
    }
    assert_eq!(outputs[0], outputs[1]);
    assert_eq!(outputs[0], outputs[2]);
    let (found, curves, samples) = &outputs[0];
    let found: Json = serde_json::from_str(found).expect("JSON");
    assert_eq!(found["counts"]["samples"], 60);
    assert_eq!(found["complete"], true);
    assert_eq!(found["inputs"]["speed_km_h"]["tag"], "T");
    assert!(curves.starts_with("vehicle,action,speed_from_m_s,"));
    assert_eq!(samples.lines().count(), 61);
    // The samples of the table are those of the result.
    let evacuate = samples
        .lines()
        .filter(|line| line.contains(",evacuate,"))
        .count();
    let given_impact = found["actions"][3]["given_impact"]["value"]
        .as_f64()
        .expect("a number");
    assert!((given_impact - evacuate as f64 / 60.0).abs() < 1e-12);
    // Other inputs have another result.
    let other = json(&run(
        folder.path(),
        &street(&[
            "--samples",
            "60",
            "--json",
            "--distribution",
            "speed_km_h=fixed:40",
        ]),
    ));
    assert_ne!(other["classes"], found["classes"]);
}

#[test]
fn measures_and_targets_are_compared_and_say_what_they_assume() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = street(&[
        "--samples",
        "200",
        "--measures",
        "-p",
        "section.name:=HEB220",
    ]);
    let found = json(&run(folder.path(), &[&arguments[..], &["--json"]].concat()));
    let number = |it: &Json| it.as_f64().expect("a number");
    let measures = found["measures"].as_array().expect("measures");
    let names: Vec<_> = measures.iter().map(|it| it["name"].as_str()).collect();
    let expected = [
        "bollard",
        "guard_rail_n2",
        "heavier_section",
        "concrete_base",
    ];
    assert_eq!(names, expected.map(Some));
    assert_eq!(measures[2]["section"], "HEB280");
    for measure in measures {
        assert!(measure["source"].as_str().is_some_and(|it| it.len() > 20));
        for (with, without) in
            [0, 1, 2, 3].map(|it| (&measure["actions"][it], &found["annual"][it]))
        {
            let annual = number(&with["annual"]["value"]);
            let base = number(&without["annual"]["value"]);
            assert!(annual <= base, "{measure}");
            let times = with["times"].as_f64().unwrap_or(0.0);
            assert!((times * base - annual).abs() <= 1e-12 * base, "{measure}");
        }
    }
    // n T lambda dx by hand, with dx = b / sin(10 degrees).
    let evacuate = &found["annual"][3];
    let departures = 10_000.0 * 365.25 * 1e-10 * 2.5 / 10_f64.to_radians().sin();
    let given = number(&found["actions"][3]["given_departure"]["value"]);
    let expected = 1.0 - (-departures * given).exp();
    assert!((number(&evacuate["annual"]["value"]) / expected - 1.0).abs() < 1e-6);
    assert_eq!(evacuate["target"]["beta"], 4.7);
    assert_eq!(evacuate["comparison"], "exceeded");
    // The summary states the same, and what is left out.
    let text = run(folder.path(), &arguments);
    let text = String::from_utf8_lossy(&text.stdout);
    for expected in [
        "takes 98.8 kJ from a vehicle [C]",
        "target 1.30e-6 (beta 4.7) [M]: EXCEEDED",
        "orientation and oblique hits: every hit has the direction of impact.direction",
        "x 5 on inspect only where no base plate is checked",
        "x 5 on inspect, which does not multiply with the orientation",
        "  encroachment_rate_per_m 0.0000000001 [T]",
        "no curve: ",
    ] {
        assert!(text.contains(expected), "{text}");
    }
}

#[test]
fn the_summary_and_the_figures_of_a_column_that_is_not_hit_are_no_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = run(
        folder.path(),
        &street(&["--samples", "10", "--distance", "1e6", "--figures", "plots"]),
    );
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        text.contains("no vehicle reaches the column") && text.contains("Figures    none"),
        "{text}"
    );
    assert!(!folder.path().join("plots").exists());
}

#[test]
fn wrong_input_is_rejected_with_what_is_expected() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(
        folder.path().join("mine.json"),
        r#"{"scenarios": [{"name": "yard", "based_on": "courtyard",
            "speed_km_h": {"distribution": "lognormal", "mean": 15, "sd": -6}}]}"#,
    )
    .expect("written");
    for (arguments, expected) in [
        (
            &["--distance", "-3"][..],
            "--distance: distance_m: found -3; expected values not below 0 m",
        ),
        (
            &["--distribution", "speed_km_h=lognormal:12:0"],
            "--distribution: speed_km_h.sd: found 0; expected a finite number > 0",
        ),
        (
            &["--confidence", "95"],
            "--confidence 95: expected a number from 0.5 to 0.9999, such as 0.95",
        ),
        (&["--years", "0"], "--years 0: expected a finite number > 0"),
        (&["--samples", "0"], "expected a whole number from 1 to"),
        (
            &["--scenarios", "none.json"],
            "cannot read the scenarios none.json",
        ),
        (
            &[
                "-p",
                "geometry.length_above:=0.1",
                "-p",
                "geometry.length_below:=1.0",
            ],
            "the vehicle lorry_8t strikes 1.25 m above the base; expected less than 1.1 m",
        ),
    ] {
        let output = run(folder.path(), &street(arguments));
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains(expected), "{errors}");
        assert!(output.stdout.is_empty());
    }
    let arguments = [
        "risk",
        "--scenario",
        "yard",
        "--scenarios",
        "mine.json",
        "--vehicles-per-day",
        "10",
    ];
    let output = run(folder.path(), &arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    let expected =
        "mine.json: scenarios.yard.speed_km_h.sd: found -6; expected a finite number > 0";
    assert!(errors.contains(expected), "{errors}");
}

/// The result of an interrupted study is that of its first samples.
/// The time that the processors have spent on a process of ours, in the ticks of the system.
fn ticks_of(process: u32) -> u64 {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).expect("it runs");
    let after_name = stat.rsplit(')').next().expect("its name is in brackets");
    // The 14th and 15th fields, of which two come before the state.
    let fields = after_name.split_whitespace().skip(11).take(2);
    fields.map(|it| it.parse::<u64>().expect("a count")).sum()
}

/// A study without end, interrupted once the program has computed for so long; what it printed.
fn interrupted_after(ticks: u64) -> Output {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["--samples", "1e9", "--exact", "--threads", "1", "--json"];
    let mut command = program(folder.path(), &street(&arguments));
    let child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("runs");
    // SIGINT has the number 2. Before the program handles it, it would end without a result.
    let handles_sigint = || {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id()));
        let status = status.unwrap_or_default();
        let mask = status.lines().find_map(|it| it.strip_prefix("SigCgt:"));
        let mask = mask.and_then(|it| u64::from_str_radix(it.trim(), 16).ok());
        mask.is_some_and(|it| it & (1 << (2 - 1)) != 0)
    };
    let deadline = Instant::now() + Duration::from_secs(300);
    while !handles_sigint() || ticks_of(child.id()) < ticks {
        assert!(
            Instant::now() < deadline,
            "the program ignores SIGINT, or does not compute"
        );
        std::thread::sleep(Duration::from_millis(10));
    }
    interrupt(&child);
    child.wait_with_output().expect("ends")
}

#[test]
fn ctrl_c_leaves_the_result_of_what_is_finished() {
    // Whenever the signal comes, the result is whole; samples are finished once the program has computed for long enough.
    let (mut ticks, most) = (50, 3_200);
    let (found, done) = loop {
        let output = interrupted_after(ticks);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{errors}");
        assert!(
            errors.contains("of 1000000000 samples are finished"),
            "{errors}"
        );
        let found: Json = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(found["complete"], false);
        let done = found["counts"]["samples"].as_u64().expect("a count");
        if done > 0 {
            break (found, done);
        }
        ticks *= 2;
        assert!(ticks <= most, "no sample is finished after {most} ticks");
    };
    let folder = tempfile::tempdir().expect("a folder");
    let samples = done.to_string();
    let again = json(&run(
        folder.path(),
        &street(&["--samples", &samples, "--exact", "--json"]),
    ));
    for part in ["actions", "classes", "fragility", "sensitivity", "counts"] {
        assert_eq!(again[part], found[part], "{part}");
    }
}
