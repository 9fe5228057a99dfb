//! A disk that fills up: the recording ends as a whole one, and recording goes on when there is room again.

use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

use rosbag2_mcap::{
    ChunkCompression, Predecessor, Reader, Recorder, RecorderOptions, RecorderReport,
    RecorderStatistics, ReportLevel, SealKey,
};

use super::recorder::{Reports, recordings};
use super::sample::{text_entry, text_topics};
use super::small_disk::SmallDisk;

/// Maximum time to wait for something that must happen.
const PATIENCE: Duration = Duration::from_secs(60);

/// Texts that compression hardly shortens.
fn text(index: i64) -> String {
    let mut state = index as u64 + 1;
    let next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        format!("{state:016x}")
    };
    std::iter::repeat_with(next).take(60).collect()
}

fn until(what: &str, mut condition: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !condition() {
        assert!(begin.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::yield_now();
    }
}

#[test]
fn a_full_disk_ends_a_recording_properly_and_new_room_begins_another() {
    for compression in [ChunkCompression::None, ChunkCompression::Zstd] {
        let Some(disk) = SmallDisk::mount() else {
            return;
        };
        let ballast = disk.path().join("ballast");
        let mut options = RecorderOptions::new(disk.path(), SystemTime::now());
        options.compression = compression;
        options.retry_after = Duration::from_millis(100);
        options.seal = Some(SealKey::fresh().unwrap());
        let reports = Reports::default();
        reports.listen(&mut options);
        let recorder = Recorder::start(options, text_topics()).unwrap();
        std::fs::write(&ballast, vec![1; 6 << 20]).unwrap();
        let mut sent = 0;
        let mut send = |checkpoint| {
            // Waits for the recorder, so that the disk is the bottleneck and not the queue.
            until("room in the queue", || {
                recorder.statistics().queue.len < 1000
            });
            assert!(recorder.record(text_entry(0, sent, &text(sent), checkpoint)));
            sent += 1;
        };
        send(true);
        until("a full disk", || {
            send(false);
            recorder.statistics().failing.is_some()
        });
        let failing = recorder.statistics();
        assert!(
            failing.failing.as_ref().unwrap().contains("no room"),
            "{failing:?}"
        );
        assert!(failing.write_errors > 0 && failing.lost > 0 && failing.current.is_none());
        // The file up to there is whole although the disk is full.
        let first = recordings(disk.path())
            .into_iter()
            .find(|it| it.is_dir())
            .unwrap();
        let reader = Reader::open(&first).unwrap();
        assert!(reader.wholeness().is_whole(), "{}", reader.wholeness());
        assert_eq!(reader.ended(), Some("no_room"));
        assert_eq!(reader.message_count(), failing.written);
        let times: Vec<i64> = reader.messages().map(|it| it.unwrap().log_time).collect();
        assert_eq!(times, (0..times.len() as i64).collect::<Vec<_>>());

        std::fs::remove_file(&ballast).unwrap();
        until("a new recording", || {
            send(false);
            recorder.statistics().current.is_some()
        });
        (0..100).for_each(|_| send(false));
        let statistics = recorder.stop();
        check_the_second(disk.path(), &first, &statistics, sent);
        check_what_was_reports(&reports.all());
    }
}

fn check_the_second(disk: &Path, first: &Path, statistics: &RecorderStatistics, sent: i64) {
    assert_eq!((statistics.finished, &statistics.failing), (2, &None));
    let second = recordings(disk)
        .into_iter()
        .find(|it| it.is_dir() && it != first)
        .unwrap();
    let reader = Reader::open(&second).unwrap();
    assert!(reader.wholeness().is_whole());
    // The second recording begins with the last checkpoint, which is in both.
    let times: Vec<i64> = reader.messages().map(|it| it.unwrap().log_time).collect();
    assert_eq!(times[0], 0);
    assert!(times.len() >= 100);
    assert_eq!(times.last(), Some(&(sent - 1)));
    // Both are sealed to their ends, and the second continues the first.
    for reader in [&reader, &Reader::open(first).unwrap()] {
        let seal = reader.seals()[0].as_ref().unwrap();
        assert!(
            seal.holds() && seal.is_final && seal.uncovered == 0,
            "{seal:?}"
        );
    }
    let found = Predecessor::Found(std::fs::canonicalize(first).unwrap());
    assert_eq!(reader.predecessor(), found);
    // The messages that are in neither are counted, and the files contain the count.
    let lost: u64 = [first, &second]
        .iter()
        .filter_map(|it| Reader::open(it).unwrap().lost_messages())
        .sum();
    assert_eq!(lost, statistics.lost);
    assert_eq!(statistics.written + statistics.lost, sent as u64 + 1);
}

fn check_what_was_reports(reports: &[RecorderReport]) {
    let kinds: Vec<&str> = reports
        .iter()
        .filter_map(|report| match report {
            RecorderReport::Began { .. } => Some("began"),
            RecorderReport::Finished(_) => Some("finished"),
            RecorderReport::Failing { .. } => Some("failing"),
            RecorderReport::Resumed { .. } => Some("resumed"),
            _ => None,
        })
        .collect();
    assert_eq!(
        kinds,
        ["began", "finished", "failing", "resumed", "finished"]
    );
    let sealing = |it: &&RecorderReport| matches!(it, RecorderReport::Sealing { .. });
    assert_eq!(reports.iter().filter(sealing).count(), 1);
    for report in reports {
        let is_error = matches!(
            report,
            RecorderReport::Failing { .. }
                | RecorderReport::Resumed { .. }
                | RecorderReport::Lost { .. }
        );
        assert_eq!(report.level() == ReportLevel::Error, is_error, "{report}");
    }
}
