//! Recordings of earlier versions: each command says in one sentence what to do with them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use column_twin::messages::column_twin_msgs::ImpactReport;
use column_twin::messages::{INTERFACES, Message as _, cdr, std_msgs};

/// What every command must say.
const ADVICE: &str = "an earlier version recorded it, whose messages (column_twin/msg/ImpactReport) this version does not read; use \
                      the program that recorded it, or read the numbers with: column-twin export ";

/// A report and a line of the journal as version 0.2 wrote them before its messages were a package of their own.
fn earlier_recording(folder: &Path) -> PathBuf {
    let path = folder.join("earlier.mcap");
    let mut writer = mcap::Writer::new(fs::File::create(&path).unwrap()).unwrap();
    let report = ImpactReport::INTERFACE.schema_text(INTERFACES).unwrap();
    let report = report.replace("column_twin_msgs/", "column_twin/");
    let text = std_msgs::String::INTERFACE.schema_text(INTERFACES).unwrap();
    let journal = std_msgs::String {
        data: r#"{"format": "column_twin journal", "version": 6}"#.to_owned(),
    };
    let mut add = |topic, type_name, schema: &str, data: &[u8]| {
        let schema = writer
            .add_schema(type_name, "ros2msg", schema.as_bytes())
            .unwrap();
        let channel = writer
            .add_channel(schema, topic, "cdr", &BTreeMap::new())
            .unwrap();
        let header = mcap::records::MessageHeader {
            channel_id: channel,
            sequence: 0,
            log_time: 1_800_000_000_000_000_000,
            publish_time: 1_800_000_000_000_000_000,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    };
    let bytes = cdr::encode(&ImpactReport::default()).unwrap();
    add(
        "/impact_report",
        "column_twin/msg/ImpactReport",
        &report,
        &bytes,
    );
    let bytes = cdr::encode(&journal).unwrap();
    add("/column_twin/journal", "std_msgs/msg/String", &text, &bytes);
    writer.finish().unwrap();
    path
}

fn run(arguments: &[&str], bag: &Path) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_column-twin"))
        .args(arguments)
        .arg(bag)
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (
        output.status.code().unwrap(),
        text(output.stdout),
        text(output.stderr),
    )
}

#[test]
fn a_recording_of_an_earlier_version_is_rejected_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let bag = earlier_recording(folder.path());
    let mut commands = vec![vec!["verify"], vec!["report"]];
    if cfg!(feature = "ros") {
        commands.push(vec!["replay"]);
    }
    let shown = folder.path().join("shown.rrd");
    if cfg!(feature = "viewer") {
        commands.push(vec!["replay", "--rrd", shown.to_str().unwrap()]);
    }
    for command in commands {
        let (code, _, errors) = run(&command, &bag);
        assert_eq!(code, 2, "{command:?}: {errors}");
        assert!(errors.contains(ADVICE), "{command:?}: {errors}");
        assert_eq!(errors.trim().lines().count(), 1, "{command:?}: {errors}");
    }
}

/// The definitions are in the recording, so its contents can be listed and its numbers read.
#[test]
fn a_recording_of_an_earlier_version_is_listed_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let bag = earlier_recording(folder.path());
    let (code, listed, errors) = run(&["info"], &bag);
    assert_eq!((code, errors.as_str()), (0, ""));
    assert!(
        listed.contains("/impact_report") && listed.contains(ADVICE),
        "{listed}"
    );
    assert!(!listed.contains("Impacts"), "{listed}");
    let (code, lines, errors) = run(&["export", "--json", "--output", "-"], &bag);
    assert_eq!(code, 0, "{errors}");
    assert!(lines.contains("\"max_v1\""), "{lines}");
}
