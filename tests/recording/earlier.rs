//! Recordings of earlier versions: each command says in one sentence what to do with them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use column_twin::messages::column_twin_msgs::ImpactReport;
use column_twin::messages::{INTERFACES, Message as _, cdr, std_msgs};

use super::commands::{code, err, out, run};

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
        let ended = run(&command, &bag);
        let errors = err(&ended);
        assert_eq!(code(&ended), 2, "{command:?}: {errors}");
        assert!(errors.contains(ADVICE), "{command:?}: {errors}");
        assert_eq!(errors.trim().lines().count(), 1, "{command:?}: {errors}");
    }
}

/// The definitions are in the recording, so its contents can be listed and its numbers read.
#[test]
fn a_recording_of_an_earlier_version_is_listed_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let bag = earlier_recording(folder.path());
    let ended = run(&["info"], &bag);
    let listed = out(&ended);
    assert_eq!((code(&ended), err(&ended)), (0, String::new()));
    assert!(
        listed.contains("/impact_report") && listed.contains(ADVICE),
        "{listed}"
    );
    assert!(!listed.contains("Impacts"), "{listed}");
    let ended = run(&["export", "--json", "--output", "-"], &bag);
    let lines = out(&ended);
    assert_eq!(code(&ended), 0, "{}", err(&ended));
    assert!(lines.contains("\"max_v1\""), "{lines}");
}
