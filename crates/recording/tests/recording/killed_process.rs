//! A process that records until it is killed.

use std::fs::{self, File};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime};

use rosbag2_mcap::{ChunkCompression, Reader, Recorder, RecorderOptions, SealKey, repair};

use super::sample::{COMPRESSIONS, text_entry, text_topics};

/// Environment variable with the directory of the other process.
const FOLDER: &str = "RECORDING_TEST_FOLDER";

/// Environment variable with its compression.
const COMPRESSION: &str = "RECORDING_TEST_COMPRESSION";

/// Messages per second.
pub const RATE: u64 = 10_000;

/// Records at full rate until it is killed, and notes in a file what it has given to the recorder; the page cache survives
/// the kill.
#[test]
#[ignore = "other tests start it in another process and kill it"]
fn records_until_it_is_killed() {
    let Ok(folder) = std::env::var(FOLDER) else {
        return;
    };
    let folder = PathBuf::from(folder);
    let mut options = RecorderOptions::new(folder.join("recordings"), SystemTime::now());
    let wanted = std::env::var(COMPRESSION).unwrap_or_default();
    options.compression = COMPRESSIONS
        .into_iter()
        .find(|it| format!("{it:?}") == wanted)
        .unwrap_or(ChunkCompression::None);
    options.seal = Some(SealKey::fresh().unwrap());
    let recorder = Recorder::start(options, text_topics()).unwrap();
    let sent = File::create(folder.join("sent")).unwrap();
    let text = "x".repeat(500);
    let begin = Instant::now();
    // Ends by itself even if it is not killed.
    for index in 0..RATE * 60 {
        let due = Duration::from_nanos(index * 1_000_000_000 / RATE);
        while let Some(early) = due.checked_sub(begin.elapsed()) {
            std::thread::sleep(early);
        }
        let nanos = i64::try_from(begin.elapsed().as_nanos()).unwrap();
        // The text contains the number, the message the time.
        assert!(recorder.record(text_entry(0, nanos, &format!("{index} {text}"), index == 0)));
        sent.write_all_at(&[index.to_le_bytes(), nanos.to_le_bytes()].concat(), 0)
            .unwrap();
    }
}

fn start(folder: &Path, compression: ChunkCompression) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args([
            "--exact",
            "killed_process::records_until_it_is_killed",
            "--ignored",
            "--nocapture",
        ])
        .env(FOLDER, folder)
        .env(COMPRESSION, format!("{compression:?}"))
        .stdout(Stdio::null())
        .spawn()
        .unwrap()
}

/// Number and time of the last message that was given to the recorder.
fn last_sent(folder: &Path) -> Option<(u64, i64)> {
    let bytes = fs::read(folder.join("sent")).ok()?;
    let (index, nanos) = bytes.get(..16)?.split_at(8);
    Some((
        u64::from_le_bytes(index.try_into().ok()?),
        i64::from_le_bytes(nanos.try_into().ok()?),
    ))
}

/// Kills a recording process after this many messages; returns the time span of the lost messages.
pub fn missing_after_a_kill(
    folder: &Path,
    compression: ChunkCompression,
    messages: u64,
) -> Duration {
    let mut child = start(folder, compression);
    let begin = Instant::now();
    while last_sent(folder).is_none_or(|(index, _)| index < messages) {
        assert!(
            begin.elapsed() < Duration::from_secs(60),
            "the other process does not record"
        );
        std::thread::sleep(Duration::from_micros(200));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let (sent, sent_at) = last_sent(folder).unwrap();
    let bag = fs::read_dir(folder.join("recordings"))
        .unwrap()
        .next()
        .unwrap()
        .unwrap()
        .path();
    let repaired = repair(&bag, Some(&folder.join("repaired")))
        .unwrap()
        .unwrap();
    assert_eq!(repaired.left_out, 0);
    let reader = Reader::open(&repaired.directory).unwrap();
    assert!(reader.wholeness().is_whole());
    // Sealed up to the last flush.
    let seal = reader.seals()[0].as_ref().unwrap();
    assert!(seal.holds() && !seal.is_final, "{seal:?}");
    assert_eq!(repaired.seal.as_ref(), Some(seal));
    assert!(seal.covered > 0 && seal.uncovered < RATE / 20, "{seal:?}");
    let mut last = 0;
    for (index, message) in reader.messages().enumerate() {
        let message = message.unwrap();
        // No gap between the first and the last message.
        assert!(
            message.data[8..].starts_with(format!("{index} ").as_bytes()),
            "message {index}"
        );
        last = message.log_time;
    }
    assert!(reader.message_count() <= sent + 2);
    Duration::from_nanos(u64::try_from(sent_at - last).unwrap_or(0))
}
