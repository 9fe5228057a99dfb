//! Readers that we did not write find every message and every value: rosbags, mcap with mcap-ros2-support, @mcap/core with
//! @foxglove/rosmsg2-serialization, and rerun. Needs Python 3.11 and node, and network the first time:
//! `cargo test --test recording other_readers -- --ignored`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use column_twin::messages::{cdr, std_msgs::String as Text};
use column_twin::recording::{Entry, Reader, TopicInfo, repair};

use super::forging::Parts;
use super::killed_process::missing_after_a_kill;
use super::sample::{self, COMPRESSIONS, Expected, sample, text_topics, topics};

fn interop(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/interop")
        .join(file)
}

/// An environment that a script builds when there is none.
fn environment(script: &str) -> PathBuf {
    let output = Command::new(interop(script))
        .stderr(Stdio::inherit())
        .output()
        .unwrap();
    assert!(output.status.success(), "{script}: {}", output.status);
    PathBuf::from(String::from_utf8(output.stdout).unwrap().trim())
}

/// Lets all of them read the recording.
fn assert_others_read(directory: &Path, messages: &[Expected], topics: &[TopicInfo]) {
    let expected = directory.with_extension("expected");
    fs::write(&expected, sample::expected_lines(messages, topics)).unwrap();
    let python = environment("environment.sh").join("bin/python");
    let mut with_python = Command::new(python);
    with_python.arg(interop("read_recording.py"));
    assert_seal_checked_by_others(directory);
    let modules = environment("node_environment.sh");
    let mut with_node = Command::new("node");
    with_node
        .arg(interop("read_recording.js"))
        .env("NODE_PATH", modules);
    for mut reader in [with_python, with_node] {
        let status = reader
            .arg(directory)
            .arg(&expected)
            .env_remove("_ROS_WHEELS_BOOTSTRAP_COMPLETE")
            .status()
            .unwrap();
        assert!(status.success(), "{reader:?}: {status}");
    }
}

/// A checker in Python, which shares nothing with the program but docs/seal.md, comes to the same result.
fn assert_seal_checked_by_others(directory: &Path) {
    let reader = Reader::open(directory).unwrap();
    let seal = reader.seals()[0].as_ref().expect("the samples are sealed");
    assert!(seal.holds(), "{seal:?}");
    let check = |file: &Path| {
        let output = Command::new(environment("environment.sh").join("bin/python"))
            .arg(interop("check_seal.py"))
            .arg(file)
            .env_remove("_ROS_WHEELS_BOOTSTRAP_COMPLETE")
            .output()
            .unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (
            output.status.success(),
            text(output.stdout),
            text(output.stderr),
        )
    };
    let (holds, found, reason) = check(&reader.files()[0]);
    assert!(holds, "{reason}");
    let found: serde_json::Value = serde_json::from_str(&found).unwrap();
    let expected = serde_json::json!({
        "public_key": seal.public_key.unwrap().to_string(),
        "covered": seal.covered,
        "messages": reader.message_count(),
        "final": seal.is_final,
        "attachment": seal.is_final,
    });
    assert_eq!(found, expected);
    let mut parts = Parts::read(&reader.files()[0]);
    parts.message(1).1[5] ^= 1;
    let forged = directory.with_extension("forged");
    parts.write(&forged);
    let (holds, found, reason) = check(&forged);
    assert!(
        !holds && reason.contains("is not about what precedes it"),
        "{found}{reason}"
    );
}

#[test]
#[ignore = "slow: other people's readers, from PyPI and npm"]
fn others_read_every_message_and_value() {
    let messages = sample(2000);
    for compression in COMPRESSIONS {
        let folder = tempfile::tempdir().unwrap();
        let directory = folder.path().join("bag");
        sample::write(&directory, compression, &messages);
        assert_others_read(&directory, &messages, &topics());
    }
}

#[test]
#[ignore = "slow: other people's readers, from PyPI and npm"]
fn others_read_a_repaired_recording() {
    for compression in COMPRESSIONS {
        let folder = tempfile::tempdir().unwrap();
        let directory = folder.path().join("bag");
        let messages = sample(3000);
        sample::write(&directory, compression, &messages);
        let file = directory.join("bag_0.mcap");
        let bytes = fs::read(&file).unwrap();
        fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
        fs::remove_file(directory.join("metadata.yaml")).unwrap();
        let repaired = repair(&directory, None).unwrap().unwrap();
        let saved = usize::try_from(repaired.messages).unwrap();
        assert_others_read(&repaired.directory, &messages[..saved], &topics());
    }
}

/// The tests of `crates/recording` check that no message before the kill is missing.
#[test]
#[ignore = "slow: other people's readers, from PyPI and npm"]
fn others_read_what_a_kill_left() {
    for compression in COMPRESSIONS {
        let folder = tempfile::tempdir().unwrap();
        missing_after_a_kill(folder.path(), compression, 3000);
        let directory = folder.path().join("repaired");
        let reader = Reader::open(&directory).unwrap();
        let expected = |message: column_twin::recording::Message| Expected {
            content: serde_json::to_value(cdr::decode::<Text>(&message.data).unwrap()).unwrap(),
            entry: Entry {
                topic: 0,
                log_time: message.log_time,
                publish_time: message.publish_time,
                data: message.data.into(),
                checkpoint: false,
            },
        };
        let messages: Vec<Expected> = reader
            .messages()
            .map(|message| expected(message.unwrap()))
            .collect();
        assert!(messages.len() > 2000);
        assert_others_read(&directory, &messages, &text_topics());
    }
}
