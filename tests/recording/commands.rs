//! `info`, `repair` and `export` as a user runs them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use column_twin::parameters::Compression;
use column_twin::recording::{ChunkCompression, Writer, writer_options};

use super::random_damage::{Random, mutate};
use super::sample::{self, sample};

/// Runs a command on a recording; what it starts stays on this machine.
pub fn run(arguments: &[&str], bag: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_column-twin"))
        .args(arguments)
        .arg(bag)
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .output()
        .unwrap()
}

pub fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

pub fn out(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

pub fn err(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn bag(folder: &tempfile::TempDir) -> PathBuf {
    let directory = folder.path().join("bag");
    sample::write(&directory, ChunkCompression::Lz4, &sample(100));
    directory
}

#[test]
fn info_says_what_is_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let bag = bag(&folder);
    let output = run(&["info"], &bag);
    assert_eq!((code(&output), err(&output).as_str()), (0, ""));
    let text = out(&output);
    for part in [
        "compression lz4",
        "column-twin 0.2.0",
        "2026-11-21 07:40:00.000 UTC",
        "/garage/column_state",
        "column_twin_msgs/msg/ColumnState",
        "0 messages according to the recorder; ended: stopped",
        "event 0 on A3, 2026-11-21 07:40:00.000 UTC: 1500 kg at 10 m/s",
        "plastic: peak v1 94.60 mm after 19.79 ms (forecast 94.60 mm), residual 89.34 mm, peak contact force 746.9 kN",
        "rejected: mass and velocity must be above 0",
    ] {
        assert!(text.contains(part), "{part:?} is not in\n{text}");
    }
}

#[test]
fn info_for_programs() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(&["info", "--json"], &bag(&folder));
    let info: serde_json::Value = serde_json::from_str(&out(&output)).unwrap();
    assert_eq!(
        (&info["whole"], &info["lost"], &info["messages"]),
        (&true.into(), &0.into(), &(sample(100).len()).into())
    );
    assert_eq!(info["impacts"][0]["outcome"], "plastic");
    assert_eq!(
        info["topics"].as_array().unwrap().len(),
        sample::topics().len()
    );
}

/// The summary of a recorded simulation with these options, for people and for programs.
fn info_of_simulated(options: &[&str]) -> (String, serde_json::Value) {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("bag");
    let simulate = [&["simulate"], options, &["--record"]].concat();
    let output = run(&simulate, &bag);
    assert_eq!(code(&output), 0, "{}", err(&output));
    let json: serde_json::Value =
        serde_json::from_str(&out(&run(&["info", "--json"], &bag))).unwrap();
    (out(&run(&["info"], &bag)), json["impacts"][0].clone())
}

/// `info` said "no report in this recording" of a fractured column, and its JSON had no outcome.
#[test]
fn info_shows_the_report_of_a_fractured_column() {
    let hit = ["--mass", "1500", "--velocity", "15"];
    let fractured = ["-p", "assessment.ultimate_rotation:=0.02"];
    let (text, json) = info_of_simulated(&[&hit[..], &fractured].concat());
    assert!(text.contains("    fractured: peak v1 "), "{text}");
    assert!(!text.contains("no report"), "{text}");
    assert_eq!(
        (&json["outcome"], &json["end"]),
        (&"fractured".into(), &"fractured".into())
    );
    assert!(json["max_v1"].as_f64().is_some_and(|it| it > 0.0), "{json}");
}

#[test]
fn info_shows_how_a_response_ended() {
    let never = "assessment.ultimate_rotation:=0.0";
    let (text, json) = info_of_simulated(&["--mass", "1e5", "--velocity", "50", "-p", never]);
    assert!(text.contains("    collapsed: peak v1 "), "{text}");
    assert_eq!(
        (&json["outcome"], &json["end"]),
        (&"collapsed".into(), &"collapsed".into())
    );
    let short = [
        "--mass",
        "1500",
        "--velocity",
        "5",
        "-p",
        never,
        "-p",
        "response.duration:=0.015",
    ];
    let (text, json) = info_of_simulated(&short);
    assert!(text.contains("    plastic: peak v1 "), "{text}");
    assert!(
        text.contains("; stopped at response.duration, not at rest\n"),
        "{text}"
    );
    assert_eq!(json["end"], "duration_reached");
}

#[test]
fn info_of_a_file_that_was_cut_off_says_so_and_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let file = bag(&folder).join("bag_0.mcap");
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    let output = run(&["info"], &file);
    assert_eq!(code(&output), 2);
    assert!(out(&output).contains("/garage/column_state"));
    assert!(
        err(&output).contains("cut off") && err(&output).contains("column-twin repair"),
        "{}",
        err(&output)
    );
}

#[test]
fn repair_writes_beside_and_never_over() {
    let folder = tempfile::tempdir().unwrap();
    let bag = bag(&folder);
    let output = run(&["repair"], &bag);
    assert_eq!(code(&output), 0);
    assert!(out(&output).contains("nothing to repair"));
    let file = bag.join("bag_0.mcap");
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    let output = run(&["repair"], &bag);
    assert_eq!(code(&output), 3, "{}", err(&output));
    assert!(out(&output).contains("bag_repaired"), "{}", out(&output));
    let again = run(&["repair"], &bag);
    assert_eq!(code(&again), 2);
    assert!(err(&again).contains("exists already"), "{}", err(&again));
    assert_eq!(
        code(&run(&["info"], &folder.path().join("bag_repaired"))),
        0
    );
    let elsewhere = folder.path().join("elsewhere");
    let output = run(&["repair", "--output", elsewhere.to_str().unwrap()], &bag);
    assert_eq!(code(&output), 3);
    assert!(elsewhere.join("metadata.yaml").exists());
}

/// The first lines said "Complete yes" where messages were missing, and that messages may be missing where none were.
#[test]
fn info_calls_a_recording_complete_only_if_nothing_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("lossy");
    let options = writer_options(Compression::None);
    let mut writer = Writer::create(&directory, &options, &sample::topics()).unwrap();
    writer.add_lost(7);
    writer.finish().unwrap();
    let text = out(&run(&["info"], &directory));
    let expected = "Complete    no: the recorder has lost 7 messages\n";
    assert!(text.contains(expected), "{text}");
    assert!(text.contains("Lost        7 messages"), "{text}");

    let whole = bag(&folder);
    let text = out(&run(&["info"], &whole));
    assert!(text.contains("Complete    yes\n"), "{text}");
    // Without its summary, which follows the final seal, a file still says how it ended.
    let file = whole.join("bag_0.mcap");
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() - 100]).unwrap();
    let text = out(&run(&["info"], &whole));
    assert!(
        text.contains("Complete    no: the file is not whole"),
        "{text}"
    );
    let repaired = folder.path().join("repaired");
    run(&["repair", "--output", repaired.to_str().unwrap()], &whole);
    let text = out(&run(&["info"], &repaired));
    assert!(text.contains("Complete    yes\n"), "{text}");
    assert!(text.contains("Repaired    from"), "{text}");
    assert!(!text.contains("may be missing"), "{text}");

    // In the middle of a chunk nobody knows what followed. Half of the file may be all of the messages: the summary, which
    // repeats every schema, is as long as a chunk that is compressed.
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let chunk = summary.chunk_indexes.last().unwrap();
    let cut = chunk.chunk_start_offset + chunk.chunk_length / 2;
    fs::write(&file, &bytes[..usize::try_from(cut).unwrap()]).unwrap();
    let cut_off = folder.path().join("cut_off");
    run(&["repair", "--output", cut_off.to_str().unwrap()], &whole);
    let text = out(&run(&["info"], &cut_off));
    assert!(
        text.contains("Complete    no: its end was cut off"),
        "{text}"
    );
    assert!(text.contains("may be missing"), "{text}");
}

/// The table of a topic is what was recorded, to the last bit.
#[test]
fn export_as_tables() {
    let folder = tempfile::tempdir().unwrap();
    let bag = bag(&folder);
    let output = run(&["export", "--csv"], &bag);
    assert_eq!((code(&output), err(&output).as_str()), (0, ""));
    let tables = folder.path().join("bag_csv");
    assert_eq!(
        fs::read_dir(&tables).unwrap().count(),
        sample::topics().len()
    );
    let mut table = csv::Reader::from_path(tables.join("garage.column_state.csv")).unwrap();
    let header = table.headers().unwrap().clone();
    let column = |name: &str| {
        header
            .iter()
            .position(|it| it == name)
            .unwrap_or_else(|| panic!("no column {name}"))
    };
    let (log_time, v1, u1, second) = (
        column("log_time"),
        column("v1"),
        column("u1"),
        column("header.stamp.sec"),
    );
    let messages = sample(100);
    let states: Vec<_> = sample::in_order(&messages)
        .into_iter()
        .filter(|it| it.entry.topic == 0)
        .collect();
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), states.len());
    for (row, state) in rows.iter().zip(states) {
        assert_eq!(row[log_time].parse::<i64>().unwrap(), state.entry.log_time);
        assert_eq!(
            row[v1].parse::<f64>().unwrap().to_bits(),
            state.content["v1"].as_f64().unwrap().to_bits()
        );
        assert_eq!(&row[u1], "NaN");
        assert_eq!(
            row[second].parse::<i64>().unwrap(),
            state.entry.log_time / 1_000_000_000
        );
    }
    let hinges = fs::read_to_string(tables.join("garage.hinge_forces.csv")).unwrap();
    assert!(
        hinges
            .lines()
            .next()
            .unwrap()
            .contains("moment[14],moment[15],normal_force[0]")
    );
    // A topic without messages has its header.
    let parameters = fs::read_to_string(tables.join("garage.column_parameters.csv")).unwrap();
    assert_eq!(parameters.lines().count(), 1);
    let again = run(&["export", "--csv"], &bag);
    assert_eq!(code(&again), 2);
}

#[test]
fn export_as_lines_of_json() {
    let folder = tempfile::tempdir().unwrap();
    let bag = bag(&folder);
    let output = run(
        &[
            "export",
            "--json",
            "--output",
            "-",
            "--topics",
            "/garage/column_state",
            "--",
        ],
        &bag,
    );
    assert_eq!((code(&output), err(&output).as_str()), (0, ""));
    let text = out(&output);
    assert_eq!(text.lines().count(), 100);
    let first: serde_json::Value = serde_json::from_str(text.lines().next().unwrap()).unwrap();
    assert_eq!(
        (&first["topic"], &first["message"]["u1"]),
        (&"/garage/column_state".into(), &"NaN".into())
    );
    let output = run(&["export", "--json"], &bag);
    assert_eq!(code(&output), 0);
    let lines = fs::read_to_string(folder.path().join("bag.jsonl")).unwrap();
    assert_eq!(lines.lines().count(), sample(100).len());
}

#[test]
fn export_says_what_it_cannot_do() {
    let folder = tempfile::tempdir().unwrap();
    let bag = bag(&folder);
    let unknown = run(&["export", "--json", "--topics", "/nothing", "--"], &bag);
    assert_eq!(code(&unknown), 2);
    assert!(err(&unknown).contains("found /nothing") && err(&unknown).contains("/garage/markers"));
    assert_eq!(code(&run(&["export"], &bag)), 2);
    let file = bag.join("bag_0.mcap");
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    let cut_off = run(&["export", "--csv"], &bag);
    assert_eq!(code(&cut_off), 2);
    assert!(
        err(&cut_off).contains("column-twin repair"),
        "{}",
        err(&cut_off)
    );
    assert!(!folder.path().join("bag_csv").exists());
}

/// The commands say what is wrong with damaged files and end with the code for bad input or for losses.
#[test]
fn the_commands_end_well_on_mutated_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    let originals = sample::COMPRESSIONS.map(|compression| {
        let directory = folder.path().join(format!("{compression:?}"));
        sample::write(&directory, compression, &sample(3));
        fs::read(directory.join(format!("{compression:?}_0.mcap"))).unwrap()
    });
    for number in 0..60 {
        let mut random = Random(number);
        let original = &originals[random.below(originals.len())];
        fs::write(&path, mutate(original, &mut random)).unwrap();
        let tables = folder.path().join(format!("tables_{number}"));
        let tables = tables.to_str().unwrap();
        for arguments in [
            &["info"][..],
            &["export", "--json", "--output", "-"],
            &["export", "--csv", "--output", tables],
        ] {
            let output = Command::new(env!("CARGO_BIN_EXE_column-twin"))
                .args(arguments)
                .arg(&path)
                .output()
                .unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            let code = output.status.code().unwrap();
            assert!(
                [0, 2, 3].contains(&code),
                "mutation {number}: {code} {said}"
            );
            assert_eq!(
                code == 0,
                said.trim().is_empty(),
                "mutation {number}: {said}"
            );
        }
    }
}

/// Rust accepts no width above 65 535, and `info` panicked.
#[test]
fn info_shows_a_topic_with_a_name_of_70_000_characters() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.mcap");
    let mut writer = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    let name = format!("/{}", "x".repeat(70_000));
    writer
        .add_channel(0, &name, "cdr", &Default::default())
        .unwrap();
    writer.finish().unwrap();
    fs::write(&path, writer.into_inner().into_inner()).unwrap();
    let output = run(&["info"], &path);
    assert_eq!(code(&output), 0, "{}", err(&output));
    assert!(out(&output).contains(&name));
}

/// A spreadsheet would take the text for a formula, and a terminal would obey it.
#[test]
fn export_writes_texts_that_no_spreadsheet_takes_for_a_formula() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("text.mcap");
    let mut writer = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    let schema = writer
        .add_schema(
            "test_msgs/msg/Pair",
            "ros2msg",
            b"string text\nint32 number\nstring[] list\n",
        )
        .unwrap();
    let channel = writer
        .add_channel(schema, "/text", "cdr", &Default::default())
        .unwrap();
    let texts = [
        "=1+1",
        "+1",
        "-1",
        "@SUM(1)",
        "\tx",
        "\rx",
        "\u{1b}[2J",
        "plain",
        "a=b",
        "a\nb",
    ];
    for (number, text) in (0..).zip(texts) {
        let length = u32::try_from(text.len() + 1).unwrap();
        let mut data = vec![0, 1, 0, 0];
        data.extend(length.to_le_bytes());
        data.extend(text.bytes());
        data.push(0);
        while data.len() % 4 != 0 {
            data.push(0);
        }
        data.extend((-7_i32).to_le_bytes());
        data.extend(0_u32.to_le_bytes());
        let header = mcap::records::MessageHeader {
            channel_id: channel,
            sequence: number,
            log_time: number.into(),
            publish_time: number.into(),
        };
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    writer.finish().unwrap();
    fs::write(&path, writer.into_inner().into_inner()).unwrap();
    let output = run(&["export", "--csv"], &path);
    assert_eq!(code(&output), 0, "{}", err(&output));
    let mut table = csv::Reader::from_path(folder.path().join("text_csv/text.csv")).unwrap();
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    let found: Vec<_> = rows.iter().map(|row| row[2].to_owned()).collect();
    let expected = [
        "'=1+1",
        "'+1",
        "'-1",
        "'@SUM(1)",
        "'\\tx",
        "'\\rx",
        "\\u{1b}[2J",
        "plain",
        "a=b",
        "a\nb",
    ];
    assert_eq!(found, expected);
    // A number stays one.
    assert!(rows.iter().all(|row| &row[3] == "-7"));
}
