//! `column-twin map` as a user meets it: bad input, files in every format, parts, Ctrl-C; and its numbers against `simulate`.
#![cfg(all(feature = "cli", target_os = "linux"))]

mod program;

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use arrow_array::{Array, Float64Array, RecordBatch, StringArray, UInt64Array};
use arrow_ipc::reader::FileReader;
use column_twin::assessment::Action;
use column_twin::parameters::{Parameters, Value as ParameterValue};
use column_twin::study::{ACTIONS, Batch, DamageMap, MapAxis, RowBoundary, StudyColumn};
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::Field;
use program::{interrupt, program, run};
use serde_json::Value;

/// A map of the paper's column that reaches every class.
const SMALL: [&str; 7] = [
    "map",
    "--config",
    concat!(env!("CARGO_MANIFEST_DIR"), "/config/heb220_paper.yaml"),
    "--mass",
    "1000:9000:5",
    "--velocity",
    "0.5:15:7",
];

fn succeed(folder: &Path, arguments: &[&str]) -> String {
    let ended = run(folder, arguments);
    let errors = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(0), "{arguments:?}: {errors}");
    String::from_utf8(ended.stdout).expect("text")
}

/// The rows of a table: each a text for every column, empty where there is no value. Numbers in the shortest form that reads back.
type Rows = Vec<BTreeMap<String, String>>;

fn of_csv(path: &Path) -> Rows {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    reader
        .deserialize()
        .map(|row| row.expect("a row"))
        .collect()
}

fn of_json(path: &Path) -> (Value, Rows) {
    let document: Value =
        serde_json::from_str(&fs::read_to_string(path).expect("a file")).expect("JSON");
    let text = |value: &Value| match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Number(number) if number.is_u64() => number.to_string(),
        number => format!("{:?}", number.as_f64().expect("a number")),
    };
    let rows = document["cells"].as_array().expect("a list").iter();
    let rows = rows.map(|row| {
        let row = row.as_object().expect("a row").iter();
        row.map(|(name, value)| (name.clone(), text(value)))
            .collect()
    });
    let rows = rows.collect();
    (document, rows)
}

fn of_parquet(path: &Path) -> (BTreeMap<String, String>, Rows) {
    let reader = SerializedFileReader::new(File::open(path).expect("a file")).expect("Parquet");
    let about = reader.metadata().file_metadata().key_value_metadata();
    let about = about.into_iter().flatten();
    let about = about.map(|pair| (pair.key.clone(), pair.value.clone().unwrap_or_default()));
    let rows = reader.get_row_iter(None).expect("rows").map(|row| {
        let row = row.expect("a row");
        let fields = row.get_column_iter().map(|(name, field)| {
            let text = match field {
                Field::Null => String::new(),
                Field::Str(text) => text.clone(),
                Field::Double(number) => format!("{number:?}"),
                Field::Long(number) => number.to_string(),
                other => panic!("{name}: {other:?}"),
            };
            (name.clone(), text)
        });
        fields.collect()
    });
    (about.collect(), rows.collect())
}

fn of_arrow(path: &Path) -> Rows {
    let reader = FileReader::try_new(File::open(path).expect("a file"), None).expect("Arrow");
    let mut rows = Rows::new();
    for batch in reader {
        let batch: RecordBatch = batch.expect("a batch");
        for row in 0..batch.num_rows() {
            let fields = batch.schema_ref().fields().iter().zip(batch.columns());
            let fields = fields.map(|(field, column)| {
                let column = column.as_any();
                let text = if let Some(it) = column.downcast_ref::<StringArray>() {
                    it.is_valid(row).then(|| it.value(row).to_owned())
                } else if let Some(it) = column.downcast_ref::<Float64Array>() {
                    it.is_valid(row).then(|| format!("{:?}", it.value(row)))
                } else {
                    let it = column.downcast_ref::<UInt64Array>().expect("whole numbers");
                    it.is_valid(row).then(|| it.value(row).to_string())
                };
                (field.name().clone(), text.unwrap_or_default())
            });
            rows.push(fields.collect());
        }
    }
    rows
}

fn with<'a>(base: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [base, more].concat()
}

#[test]
fn bad_input_says_what_was_expected() {
    let folder = tempfile::tempdir().expect("a folder");
    let velocity = ["--velocity", "1:25:10"];
    for (arguments, expected) in [
        (
            &["--mass", "2000:1000:5"][..],
            "the values run from 2000 to 1000; expected the smaller one first",
        ),
        (
            &["--mass", "2000:9000:1"],
            "an axis of 1 point has no extent; expected at least 2",
        ),
        (
            &["--mass", "nan:9000:5"],
            "`NaN` is not a finite number; omit the unit, which is kg",
        ),
        (
            &["--mass", ""],
            "there are no values; expected from:to:number of points",
        ),
        (
            &["--mass", "heavy"],
            "--mass heavy: expected one number or a range, such as 2000:12000:100",
        ),
        (
            &["--mass", "1:2:10000001"],
            "10000001 x 10 cells of 1 columns are too many; a map has at most 100000000 cells",
        ),
        (
            &["--vary", "viewer.port=1:2:5"],
            "viewer.port cannot vary along an axis: it belongs to the node",
        ),
        (
            &["--vary", "support.base=pinned,built_in"],
            "support.base cannot vary along an axis: it is not a number",
        ),
        (
            &["--vary", "section=HEB221,HEB240"],
            "the catalogue has no section `HEB221` (did you mean HEB220?)",
        ),
        (&["--vary", "top.laod=1:2:5"], "did you mean top.load?"),
        (
            &["--vary", "velocity=1:2:5"],
            "two axes determine the same parameter: velocity and velocity",
        ),
        (
            &["--height", "0.5:9:5"],
            "geometry.length_above: `-5.0` is out of range",
        ),
        (&["--vehicle", "tank", "--mass", "1:2:5"], "did you mean"),
        (&[], "a map has two axes; found 1 (velocity)"),
        (
            &["--mass", "1:2:5", "--shard", "0/4"],
            "--shard 0/4: expected the number of the part and the number of parts, such as 3/16",
        ),
        (
            &["--mass", "1:2:5", "--shard", "5/4"],
            "--shard 5/4: expected",
        ),
        (
            &["--mass", "1:2:5", "--compare", "section=HEB200"],
            "an axis of 1 point has no extent",
        ),
        (
            &["--mass", "1:2:5", "--compare", "mass=1,2"],
            "mass is compared and varies along an axis, too",
        ),
        (
            &["--mass", "1:2:5", "--compare", "heavier"],
            "--compare heavier: expected section=HEB200,HEB240",
        ),
        (
            &["--mass", "1:2:5", "--csv", "-", "--json"],
            "only one of --csv and --json can write to the standard output",
        ),
    ] {
        let ended = run(folder.path(), &with(&with(&["map"], &velocity), arguments));
        let errors = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}: {errors}");
        let plain = errors.split_whitespace().collect::<Vec<_>>().join(" ");
        let is_there = plain.contains(expected)
            || (expected == "did you mean" && plain.contains("is not known"));
        assert!(is_there, "{arguments:?}: {errors}");
        // An error is told once.
        assert!(!errors.contains("╰─▶"), "{arguments:?}: {errors}");
    }
    let ended = run(
        folder.path(),
        &[
            "map",
            "--mass",
            "1:2:5",
            "--velocity",
            "1:2:5",
            "--csv",
            "nowhere/a.csv",
        ],
    );
    assert_eq!(ended.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&ended.stderr).contains("there is no folder nowhere"));
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0);
}

#[test]
fn every_format_holds_the_same_numbers() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let files = [
        "--csv",
        "m.csv",
        "--json",
        "m.json",
        "--parquet",
        "m.parquet",
        "--arrow",
        "m.arrow",
    ];
    let summary = succeed(folder.path(), &with(&SMALL, &files));
    assert!(
        summary.contains("5 x 7 impacts") && summary.contains("evacuate"),
        "{summary}"
    );
    let csv = of_csv(&at("m.csv"));
    assert_eq!(csv.len(), 35);
    let (document, json) = of_json(&at("m.json"));
    let (about, parquet) = of_parquet(&at("m.parquet"));
    assert_eq!(json, csv);
    assert_eq!(parquet, csv);
    assert_eq!(of_arrow(&at("m.arrow")), csv);
    // What the files say about themselves.
    assert_eq!(document["complete"], Value::Bool(true));
    assert_eq!(document["row_axis"]["points"], 5);
    assert_eq!(
        (&*about["complete"], &*about["end_cell"], &*about["shard"]),
        ("true", "35", "1/1")
    );
    let parameters = &document["variants"][0]["parameters"];
    assert!(
        parameters
            .as_str()
            .expect("YAML")
            .contains("column_id: \"heb220_paper\"")
    );
    // The standard output takes one of them.
    let to_output = succeed(folder.path(), &with(&SMALL, &["--csv", "-"]));
    assert_eq!(to_output, fs::read_to_string(at("m.csv")).expect("a table"));
    let to_output = succeed(folder.path(), &with(&SMALL, &["--json"]));
    assert_eq!(
        to_output,
        fs::read_to_string(at("m.json")).expect("a document")
    );
}

/// `--threads 10000` started as many threads for four cells.
#[test]
fn too_many_threads_are_not_started_and_the_map_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let four = ["map", "--mass", "1000:2000:2", "--velocity", "2:4:2"];
    let ended = run(
        folder.path(),
        &[&four[..], &["--threads", "10000"]].concat(),
    );
    assert_eq!(ended.status.code(), Some(0));
    let told = "Warning: 10000 threads were asked for; 4 are used, because that is the number of computations, which is 4\n";
    assert_eq!(String::from_utf8_lossy(&ended.stderr), told);
    let summary = String::from_utf8_lossy(&ended.stdout);
    assert!(summary.contains(" s on 4 threads\n"), "{summary}");
    // As many as asked for, without a word, and as many as there are processors.
    for threads in [&["--threads", "2"][..], &[]] {
        let ended = run(folder.path(), &[&four[..], threads].concat());
        assert_eq!(
            (ended.status.code(), ended.stderr.as_slice()),
            (Some(0), &b""[..])
        );
    }
    let none = run(folder.path(), &[&four[..], &["--threads", "0"]].concat());
    assert_eq!(none.status.code(), Some(2));
}

/// Another number of threads, and parts that are put together by a reader, make the same map, bit for bit.
#[test]
fn parts_are_the_map() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    succeed(
        folder.path(),
        &with(&SMALL, &["--parquet", "whole.parquet", "--threads", "1"]),
    );
    let (_, whole) = of_parquet(&at("whole.parquet"));
    let mut joined = Rows::new();
    for part in 1..=4 {
        let (shard, file) = (format!("{part}/4"), format!("part-{part}.parquet"));
        succeed(
            folder.path(),
            &with(
                &SMALL,
                &["--parquet", &file, "--shard", &shard, "--threads", "3"],
            ),
        );
        let (about, rows) = of_parquet(&at(&file));
        assert_eq!(about["shard"], shard);
        assert_eq!(about["first_cell"], joined.len().to_string());
        joined.extend(rows);
    }
    assert_eq!(joined, whole);
}

/// The same impacts, each at its own step and followed to the end.
#[test]
fn every_cell_agrees_with_simulate() {
    let folder = tempfile::tempdir().expect("a folder");
    for (config, more) in [
        ("heb220_paper.yaml", &[][..]),
        ("heb220_s355.yaml", &["--vehicle", "mid_car"]),
    ] {
        let config = format!("{}/config/{config}", env!("CARGO_MANIFEST_DIR"));
        let map = [
            "map",
            "--config",
            &config,
            "--mass",
            "1200:4200:4",
            "--velocity",
            "3:18:4",
            "--csv",
            "m.csv",
        ];
        succeed(folder.path(), &with(&map, more));
        for cell in of_csv(&folder.path().join("m.csv")).iter().step_by(3) {
            let (mass, velocity) = (&cell["mass_kg"], &cell["velocity_m_s"]);
            let one = [
                "simulate",
                "--config",
                &config,
                "--json",
                "--mass",
                mass,
                "--velocity",
                velocity,
            ];
            let simulated: Value =
                serde_json::from_str(&succeed(folder.path(), &with(&one, more))).expect("JSON");
            assert_eq!(simulated["action"], cell["action"].as_str(), "{cell:?}");
            let expected = simulated["max_v1_m"].as_f64().expect("a number");
            let found: f64 = cell["max_v1_m"].parse().expect("a number");
            // Of a column that falls, the peak displacement is only where the response ends.
            if cell["residual_v1_m"].is_empty() {
                continue;
            }
            assert!(
                (found / expected - 1.0).abs() < 1e-3,
                "{cell:?}: {expected}"
            );
        }
    }
}

/// Against single impacts just below and just above the boundary, in rows of the map that the boundary interpolates, too.
#[test]
fn a_refined_boundary_is_within_one_per_cent() {
    let paper = concat!(env!("CARGO_MANIFEST_DIR"), "/config/heb220_paper.yaml");
    let parameters = Parameters::load(&[paper.into()], &[]).expect("parameters");
    let axis = |text: &str| MapAxis::parse(text).expect("an axis");
    let axes = || [axis("mass=1000:12000:100"), axis("velocity=1:25:100")];
    let map = DamageMap::new(&parameters, None, axes()).expect("a map");
    let refined = map.refine(&Batch::default()).expect("boundaries");
    assert!(refined.complete);
    assert!(refined.responses < 1000, "{}", refined.responses);
    let column = StudyColumn::undamaged(&parameters).expect("a column");
    let action = |mass: f64, velocity: f64| {
        let impact = column
            .impact(None, Some(mass), velocity)
            .expect("an impact");
        column.evaluate(&impact).expect("a response").action
    };
    for mass in [1000.0, 1130.0, 1777.0, 2900.0, 5555.0, 8300.0, 11_900.0] {
        for class in [Action::Shore, Action::Evacuate] {
            let critical = refined.value_at(&map, 0, class, mass).expect("a boundary");
            assert!(
                action(mass, 0.99 * critical) < class,
                "{mass} kg, {critical} m/s"
            );
            assert!(
                action(mass, 1.01 * critical) >= class,
                "{mass} kg, {critical} m/s"
            );
        }
    }
    // The result is that of any number of threads.
    let mut one_thread = Batch::default();
    one_thread.threads = std::num::NonZeroUsize::new(1);
    assert_eq!(map.refine(&one_thread).expect("boundaries"), refined);
}

/// Of a load, the class changes along an axis that begins with 0 and belongs to the column.
#[test]
fn a_boundary_along_a_parameter_of_the_column() {
    let axes = [
        MapAxis::parse("section=HEB180,HEB220").expect("an axis"),
        MapAxis::parse("top.load=0:2e6:30").expect("an axis"),
    ];
    let changes = [("impact.mass", 3000.0), ("impact.velocity", 6.0)];
    let changes = changes.map(|(name, value)| (name, ParameterValue::Double(value)));
    let parameters = Parameters::default()
        .with_changes(changes)
        .expect("admissible");
    let map = DamageMap::new(&parameters, None, axes).expect("a map");
    let refined = map.refine(&Batch::default()).expect("boundaries");
    let table = map.table(&Batch::default()).expect("a table");
    for (boundary, class) in refined.boundaries.iter().zip(ACTIONS) {
        for point in &boundary.points {
            let holds = |load: u64| {
                let cell = (point.row * 30 + load) as usize;
                table.result[cell].as_ref().expect("a result").action >= class
            };
            match point.place {
                RowBoundary::Between { below, at, rising } => {
                    assert!(at - below <= 0.0101 * 2e6);
                    let last_below = (below / 2e6 * 29.0).floor() as u64;
                    let first_above = (at / 2e6 * 29.0).ceil() as u64;
                    assert_eq!((holds(last_below), holds(first_above)), (!rising, rising));
                }
                RowBoundary::Always => assert!(holds(0) && holds(29)),
                RowBoundary::Never => assert!(!holds(0) && !holds(29)),
                RowBoundary::Infeasible => panic!("{:?}", refined.faults),
            }
        }
    }
}

/// A column of 3.23 MN carries no load above that: the boundaries leave out the rows whose cells the map leaves out, for the
/// same reason, and the program ends alike.
#[test]
fn rows_that_cannot_be_computed_are_infeasible() {
    let axes = [
        MapAxis::parse("top.load=1e6:9e6:9").expect("an axis"),
        MapAxis::parse("velocity=5:15:3").expect("an axis"),
    ];
    let map = DamageMap::new(&Parameters::default(), None, axes).expect("a map");
    let table = map.table(&Batch::default()).expect("a table");
    let refined = map.refine(&Batch::default()).expect("boundaries");
    assert!(refined.complete);
    let mut infeasible = 0;
    for boundary in &refined.boundaries {
        for point in &boundary.points {
            let cell = &table.result[(point.row * 3) as usize];
            let is_infeasible = point.place == RowBoundary::Infeasible;
            assert_eq!(cell.is_err(), is_infeasible, "row {}", point.row);
            let fault = refined.faults.iter().find(|it| it.row == point.row);
            assert_eq!(fault.is_some(), is_infeasible);
            if let (Some(fault), Err(reason)) = (fault, cell) {
                assert!(fault.reason.ends_with(reason), "{}", fault.reason);
                infeasible += 1;
            }
        }
    }
    assert!(infeasible > 0);
    // The rows on both sides of the largest load are known.
    let rows = |points: &[column_twin::study::BoundaryPoint]| {
        points.iter().map(|it| it.row).collect::<Vec<_>>()
    };
    let known = rows(&refined.boundaries[0].points);
    assert!(known.contains(&2) && known.contains(&3), "{known:?}");

    let folder = tempfile::tempdir().expect("a folder");
    let arguments = [
        "map",
        "--vary",
        "top.load=1e6:9e6:3",
        "--velocity",
        "5:15:3",
    ];
    let plain = run(folder.path(), &arguments);
    let refines = run(
        folder.path(),
        &with(&arguments, &["--refine", "--csv", "rows.csv"]),
    );
    for ended in [&plain, &refines] {
        let errors = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(3), "{errors}");
        assert!(errors.contains("could not be computed"), "{errors}");
        assert!(errors.contains("the load squashes the column"), "{errors}");
    }
    for row in of_csv(&folder.path().join("rows.csv")) {
        let is_squashed = row["top_load_n"].parse::<f64>().expect("a load") > 3.3e6;
        assert_eq!(row["boundary"] == "infeasible", is_squashed, "{row:?}");
        assert_eq!(row["fault"].is_empty(), !is_squashed, "{row:?}");
    }
}

/// A lorry of the catalogue may have any mass: its load and its lashing scale with it.
#[test]
fn a_lorry_lighter_than_its_own_cab_is_computed() {
    let axes = [
        MapAxis::parse("mass=4000:12000:9").expect("an axis"),
        MapAxis::parse("velocity=5:15:3").expect("an axis"),
    ];
    let map = DamageMap::new(&Parameters::default(), Some("lorry_8t"), axes).expect("a map");
    let table = map.table(&Batch::default()).expect("a table");
    assert!(table.result.iter().all(Result::is_ok));
    // Of equal speed, the heavier lorry is the worse one.
    for column in 0..3 {
        let largest = |row: usize| table.peak_contact_force[3 * row + column];
        assert!(largest(8) >= largest(0), "{:?}", table.peak_contact_force);
    }
}

#[test]
fn figures_are_drawn_for_every_column_and_for_their_comparison() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["--compare", "section=HEB200,HEB 240", "--figures", "plots"];
    let summary = succeed(folder.path(), &with(&SMALL, &arguments));
    assert!(summary.contains("HEB240"), "{summary}");
    let mut names: Vec<_> = fs::read_dir(folder.path().join("plots"))
        .expect("a folder")
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .into_string()
                .expect("plain")
        })
        .collect();
    names.sort();
    let expected = ["HEB200", "HEB240", "comparison"].iter();
    let expected: Vec<_> = expected
        .flat_map(|name| ["png", "svg"].map(|ending| format!("damage_map_{name}.{ending}")))
        .collect();
    assert_eq!(names, expected);
    let svg = fs::read_to_string(folder.path().join("plots/damage_map_HEB200.svg")).expect("SVG");
    for text in [
        "mass of the vehicle [kg]",
        "velocity of the vehicle [m/s (km/h)]",
        "evacuate",
    ] {
        assert!(svg.contains(text), "{text}");
    }
}

/// What is finished stays, in every file, and the exit code tells that it is a part.
#[test]
fn ctrl_c_leaves_what_is_finished() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    // Responses of 2 ms, so that the first chunk of rows is soon written; the whole map would take hours.
    let short = [
        "map",
        "-p",
        "response.duration:=2.0e-3",
        "-p",
        "solver.dt:=2.0e-5",
        "--mass",
        "1000:9000:4000",
        "--velocity",
        "1:25:4000",
    ];
    let files = [
        "--csv",
        "m.csv",
        "--parquet",
        "m.parquet",
        "--json",
        "m.json",
    ];
    let child = program(folder.path(), &with(&short, &files))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program");
    let written = || {
        let counts = fs::read_to_string(format!("/proc/{}/io", child.id())).unwrap_or_default();
        let line = counts.lines().find_map(|line| line.strip_prefix("wchar: "));
        line.and_then(|count| count.parse().ok()).unwrap_or(0_u64)
    };
    let deadline = Instant::now() + Duration::from_secs(60);
    while written() < 300_000 {
        assert!(Instant::now() < deadline, "{} bytes written", written());
        std::thread::yield_now();
    }
    interrupt(&child);
    let ended = child.wait_with_output().expect("a child");
    let errors = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(3), "{errors}");
    let csv = of_csv(&at("m.csv"));
    assert!(!csv.is_empty());
    let errors = errors.split_whitespace().collect::<Vec<_>>().join(" ");
    let expected = format!(
        "interrupted: {} of 16000000 impacts are done, the cells 0 to {}",
        csv.len(),
        csv.len() - 1
    );
    assert!(errors.contains(&expected), "{errors}");
    let (about, parquet) = of_parquet(&at("m.parquet"));
    assert_eq!(about["complete"], "false");
    assert_eq!(parquet, csv);
    assert_eq!(of_json(&at("m.json")).1, csv);
    // The cells are those from the first on, without a gap.
    assert!(
        csv.iter()
            .enumerate()
            .all(|(number, row)| row["cell"] == number.to_string())
    );
}

/// HEB240 carries 3.5 MN and HEB200 no more than 7808 mm2 times 355 MPa: both kinds of map leave out the same cells, and the
/// boundaries are those of the other cells.
#[test]
fn the_part_of_a_row_that_can_be_computed_has_its_boundaries() {
    const POINTS: u64 = 13;
    const FIRST: f64 = 5e5;
    const STEP: f64 = 2.5e5;
    let axes = [
        MapAxis::parse("section=HEB200,HEB240").expect("an axis"),
        MapAxis::parse("top.load=5e5:3.5e6:13").expect("an axis"),
    ];
    let velocity = [("impact.velocity", ParameterValue::Double(6.0))];
    let parameters = Parameters::default()
        .with_changes(velocity)
        .expect("admissible");
    let map = DamageMap::new(&parameters, Some("mid_car"), axes).expect("a map");
    let refined = map.refine(&Batch::default()).expect("boundaries");
    let table = map.table(&Batch::default()).expect("a table");
    let cell = |row: u64, column: u64| &table.result[(row * POINTS + column) as usize];
    assert!(cell(0, 0).is_ok() && cell(0, POINTS - 1).is_err() && cell(1, POINTS - 1).is_ok());

    let [fault] = &refined.faults[..] else {
        panic!("{:?}", refined.faults);
    };
    assert_eq!(fault.row, 0);
    let largest = fault.computed.expect("a part of the row")[1];
    let squash_load = 7808e-6 * 355e6;
    assert!(
        (0.99 * squash_load..1.001 * squash_load).contains(&largest),
        "{largest}"
    );
    let mut between = 0;
    for (boundary, class) in refined.boundaries.iter().zip(ACTIONS) {
        assert_eq!(boundary.points.len(), 2);
        for point in &boundary.points {
            let holds = |load: f64| {
                let result = cell(point.row, ((load - FIRST) / STEP).round() as u64).as_ref();
                result.expect("a result").action >= class
            };
            let heaviest = if point.row == 0 { 2.75e6 } else { 3.5e6 };
            match point.place {
                RowBoundary::Between { below, at, rising } => {
                    assert!(at <= 1.0101 * below && at <= largest.max(heaviest));
                    let lower = (below / STEP).floor() * STEP;
                    assert_eq!(holds(lower), !rising, "{point:?}");
                    let upper = (at / STEP).ceil() * STEP;
                    if upper <= heaviest {
                        assert_eq!(holds(upper), rising, "{point:?}");
                    }
                    between += 1;
                }
                RowBoundary::Always => assert!(holds(FIRST) && holds(heaviest)),
                RowBoundary::Never => assert!(!holds(FIRST) && !holds(heaviest)),
                RowBoundary::Infeasible => panic!("{:?}", refined.faults),
            }
        }
    }
    assert!(between > 0, "{:?}", refined.boundaries);
}
