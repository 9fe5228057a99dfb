//! The recorder: what it writes, when it begins a new recording, what it drops.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rosbag2_mcap::{
    Entry, Reader, Recorder, RecorderOptions, RecorderReport, RecordingError, ReportLevel, Writer,
    WriterOptions, directory_name, repair,
};

use super::sample::{text_entry, text_topics};

fn started() -> SystemTime {
    UNIX_EPOCH + Duration::from_secs(1_795_246_800)
}

/// Recordings in `folder`, by name.
pub fn recordings(folder: &Path) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    found.sort();
    found
}

/// Texts in a recording, in order.
pub fn texts(path: &Path) -> Vec<String> {
    let reader = Reader::open(path).unwrap();
    assert!(reader.wholeness().is_whole(), "{}", reader.wholeness());
    reader
        .messages()
        .map(|message| {
            let data = message.unwrap().data;
            // Behind the encapsulation header and the length; in front of the final zero.
            String::from_utf8(data[8..data.len() - 1].to_vec()).unwrap()
        })
        .collect()
}

/// Collects the reports of a recorder.
#[derive(Clone, Default)]
pub struct Reports(Arc<Mutex<Vec<RecorderReport>>>);

impl Reports {
    pub fn listen(&self, options: &mut RecorderOptions) {
        let reports = self.clone();
        options.on_report = Some(Arc::new(move |report| {
            reports.0.lock().unwrap().push(report.clone())
        }));
    }

    pub fn all(&self) -> Vec<RecorderReport> {
        self.0.lock().unwrap().clone()
    }
}

fn plain(index: i64) -> Entry {
    text_entry(0, index, &format!("{index}"), false)
}

fn checkpoint(index: i64) -> Entry {
    text_entry(0, index, &format!("start {index}"), true)
}

#[test]
fn everything_recorded_before_the_stop_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = RecorderOptions::new(folder.path(), started());
    let reports = Reports::default();
    reports.listen(&mut options);
    let recorder = Recorder::start(options, text_topics()).unwrap();
    for index in 0..20_000 {
        assert!(recorder.record(plain(index)));
    }
    let statistics = recorder.stop();
    assert_eq!(
        (statistics.written, statistics.lost, statistics.finished),
        (20_000, 0, 1)
    );
    assert_eq!(
        (
            statistics.queue.pushed,
            statistics.waiting_bytes,
            statistics.current
        ),
        (20_000, 0, None)
    );
    let found = recordings(folder.path());
    assert_eq!(found.len(), 1);
    let name = found[0].file_name().unwrap().to_str().unwrap();
    assert!(name.starts_with("recording_2026_11_21-07_40_0"), "{name}");
    assert_eq!(
        texts(&found[0]),
        (0..20_000)
            .map(|index| index.to_string())
            .collect::<Vec<_>>()
    );
    assert!(matches!(
        &reports.all()[..],
        [RecorderReport::Began { .. }, RecorderReport::Finished(_)]
    ));
}

#[test]
fn without_messages_there_is_no_recording() {
    let folder = tempfile::tempdir().unwrap();
    let recorder = Recorder::start(
        RecorderOptions::new(folder.path(), started()),
        text_topics(),
    )
    .unwrap();
    assert_eq!(recorder.stop().finished, 0);
    assert!(recordings(folder.path()).is_empty());
}

/// A new recording begins with a checkpoint, so that it needs no earlier recording.
#[test]
fn a_new_recording_begins_at_the_checkpoint_after_the_limit() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = RecorderOptions::new(folder.path(), started());
    options.max_file_size = 400_000;
    let recorder = Recorder::start(options, text_topics()).unwrap();
    let text = "x".repeat(10_000);
    assert!(recorder.record(checkpoint(0)));
    for round in 1..=3 {
        // Longer than the limit, shorter than its double.
        for index in 0..45 {
            assert!(recorder.record(text_entry(0, 100 * round + index, &text, false)));
        }
        assert!(recorder.record(checkpoint(100 * round + 99)));
    }
    let statistics = recorder.stop();
    assert_eq!((statistics.finished, statistics.lost), (4, 0));
    for directory in recordings(folder.path()) {
        let texts = texts(&directory);
        assert!(texts[0].starts_with("start"), "{}", &texts[0][..5]);
        let reader = Reader::open(&directory).unwrap();
        assert!(["rotated", "stopped"].contains(&reader.ended().unwrap()));
    }
}

/// Without new checkpoints a recording ends nevertheless, and the next one begins with the last checkpoint.
#[test]
fn a_recording_does_not_grow_without_bound() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = RecorderOptions::new(folder.path(), started());
    options.max_file_size = 400_000;
    let recorder = Recorder::start(options, text_topics()).unwrap();
    let text = "x".repeat(10_000);
    assert!(recorder.record(checkpoint(0)));
    for index in 1..=200 {
        assert!(recorder.record(text_entry(0, index, &text, false)));
    }
    let statistics = recorder.stop();
    assert_eq!((statistics.finished, statistics.lost), (3, 0));
    let found = recordings(folder.path());
    for directory in &found {
        let texts = texts(directory);
        assert_eq!(texts.iter().filter(|it| *it == "start 0").count(), 1);
        assert_eq!(texts[0], "start 0");
    }
    let all: usize = found.iter().map(|it| texts(it).len()).sum();
    assert_eq!(all, 200 + 3);
}

#[test]
fn the_number_of_recordings_is_limited() {
    let folder = tempfile::tempdir().unwrap();
    for hour in 0..4 {
        let directory = folder.path().join(directory_name(
            "recording",
            started() - Duration::from_secs(3600 * (hour + 1)),
        ));
        let mut writer =
            Writer::create(&directory, &WriterOptions::default(), &text_topics()).unwrap();
        writer.write(&plain(0)).unwrap();
        writer.finish().unwrap();
    }
    let others = folder.path().join("rosbag2_2020_01_01-00_00_00");
    fs::create_dir(&others).unwrap();
    let before = recordings(folder.path());
    let mut options = RecorderOptions::new(folder.path(), started());
    options.max_files = Some(3);
    let reports = Reports::default();
    reports.listen(&mut options);
    let recorder = Recorder::start(options, text_topics()).unwrap();
    assert!(recorder.record(plain(0)));
    assert_eq!(recorder.stop().lost, 0);
    let after = recordings(folder.path());
    assert_eq!(after.len(), 3 + 1);
    assert!(others.exists() && !before[0].exists() && !before[1].exists() && before[2].exists());
    let deleted = reports
        .all()
        .into_iter()
        .filter(|it| matches!(it, RecorderReport::Deleted { .. }))
        .count();
    assert_eq!(deleted, 2);
}

#[test]
fn a_full_queue_drops_the_newest_and_the_file_contains_the_count() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = RecorderOptions::new(folder.path(), started());
    options.queue_bytes = 100_000;
    let reports = Reports::default();
    reports.listen(&mut options);
    let recorder = Recorder::start(options, text_topics()).unwrap();
    assert!(recorder.record(checkpoint(0)));
    // Larger than the whole queue.
    let large = text_entry(0, 1, &"x".repeat(200_000), false);
    for _ in 0..5 {
        assert!(!recorder.record(large.clone()));
    }
    assert_eq!(recorder.statistics().queue.dropped, 5);
    let statistics = recorder.stop();
    assert_eq!((statistics.written, statistics.lost), (1, 5));
    let reader = Reader::open(&recordings(folder.path())[0]).unwrap();
    assert_eq!(reader.lost_messages(), Some(5));
    let finished = reports.all().pop().unwrap();
    assert!(
        finished.to_string().contains("5 messages are missing"),
        "{finished}"
    );
}

#[test]
fn what_cannot_work_fails_at_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let error = Recorder::start(RecorderOptions::new(&file, started()), text_topics()).unwrap_err();
    assert!(matches!(error, RecordingError::Directory { .. }));
    assert!(error.to_string().contains("choose another"), "{error}");
    let twice = [text_topics(), text_topics()].concat();
    let error = Recorder::start(RecorderOptions::new(folder.path(), started()), twice).unwrap_err();
    assert!(matches!(error, RecordingError::DuplicateTopic { .. }));
}

/// A recording that a crash has cut off is repaired at the next start, once, and reported.
#[test]
fn a_cut_off_recording_is_repaired_at_the_next_start() {
    let folder = tempfile::tempdir().unwrap();
    let crashed = folder.path().join(directory_name(
        "recording",
        started() - Duration::from_secs(60),
    ));
    let mut writer = Writer::create(&crashed, &WriterOptions::default(), &text_topics()).unwrap();
    (0..100).for_each(|index| writer.write(&plain(index)).unwrap());
    writer.finish().unwrap();
    let file = fs::read_dir(&crashed)
        .unwrap()
        .map(|it| it.unwrap().path())
        .find(|it| it.extension().is_some_and(|it| it == "mcap"));
    let file = file.unwrap();
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[..bytes.len() - 100]).unwrap();
    fs::remove_file(crashed.join("metadata.yaml")).unwrap();
    for round in 0..2 {
        let mut options = RecorderOptions::new(folder.path(), started());
        let reports = Reports::default();
        reports.listen(&mut options);
        let recorder = Recorder::start(options, text_topics()).unwrap();
        let repaired = PathBuf::from(format!("{}_repaired", crashed.display()));
        while !repaired.join("metadata.yaml").exists() {
            std::thread::yield_now();
        }
        let _ = recorder.stop();
        let repairs: Vec<_> = reports
            .all()
            .into_iter()
            .filter(|it| matches!(it, RecorderReport::Repaired(_)))
            .collect();
        assert_eq!(repairs.len(), usize::from(round == 0));
        if let Some(report) = repairs.first() {
            assert_eq!(report.level(), ReportLevel::Warning);
            assert!(
                report.to_string().contains("100 messages were saved"),
                "{report}"
            );
        }
        assert_eq!(texts(&repaired).len(), 100);
        assert_eq!(recordings(folder.path()).len(), 2);
    }
}

#[test]
fn a_recording_that_is_being_written_is_not_repaired() {
    let folder = tempfile::tempdir().unwrap();
    let running = folder.path().join(directory_name(
        "recording",
        started() - Duration::from_secs(60),
    ));
    let mut writer = Writer::create(&running, &WriterOptions::default(), &text_topics()).unwrap();
    writer.write(&plain(0)).unwrap();
    let recorder = Recorder::start(
        RecorderOptions::new(folder.path(), started()),
        text_topics(),
    )
    .unwrap();
    assert!(recorder.record(plain(0)));
    let _ = recorder.stop();
    assert_eq!(recordings(folder.path()).len(), 2);
    for error in [
        Reader::open(&running).unwrap_err(),
        repair(&running, None).unwrap_err(),
    ] {
        assert!(
            matches!(error, RecordingError::BeingWritten { .. }),
            "{error}"
        );
        assert!(
            error
                .to_string()
                .contains("stop the program that records it")
        );
    }
    writer.finish().unwrap();
}
