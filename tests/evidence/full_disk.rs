//! A disk that becomes full while a node records.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

use column_twin::evidence::verify;
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::ImpactReport;
use column_twin::messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use column_twin::recording::Reader;
use column_twin::ros::qos;

use super::domain::{Domain, PATIENCE};
use super::incoming::reader;
use super::node::{Bytes, program, recordings, slow_impact, stopped};
use super::small_disk::SmallDisk;

/// The next diagnostics of the recording.
fn recording_status(diagnostics: &Bytes) -> DiagnosticStatus {
    let message = diagnostics
        .messages
        .recv_timeout(PATIENCE)
        .expect("diagnostics");
    let status: DiagnosticArray = cdr::decode(message.bytes()).unwrap();
    let of_recording = |it: &DiagnosticStatus| it.name.ends_with(": recording");
    status
        .status
        .into_iter()
        .find(of_recording)
        .expect("a recording")
}

/// Waits for the report of an impact; that of an earlier one may come once more, with the range of its verdict.
fn wait_for_report(reports: &Bytes, event_id: &str) {
    loop {
        let message = reports.messages.recv_timeout(PATIENCE).expect("a report");
        let report: ImpactReport = cdr::decode(message.bytes()).unwrap();
        if report.event_id == event_id {
            return;
        }
    }
}

/// Fills the disk.
fn fill(path: &Path) {
    let mut file = File::create(path).unwrap();
    for size in [65_536, 1] {
        while file.write_all(&vec![1; size]).is_ok() {}
    }
}

/// The twin keeps running, and its diagnostics report an ERROR with the number of lost messages. The recording up to then is
/// complete and verified, and another one starts when there is space again. The exit code reports the loss.
#[test]
fn a_node_survives_a_full_disk_and_reports_its_losses() {
    let Some(disk) = SmallDisk::mount() else {
        return;
    };
    let domain = Domain::fresh();
    let node = program(&domain, disk.path());
    let mut reader = reader(&domain);
    let reports = Bytes::start(&mut reader, &qos::IMPACT_REPORT);
    let diagnostics = Bytes::start(&mut reader, &qos::DIAGNOSTICS);
    slow_impact(&domain, "before");
    wait_for_report(&reports, "before");
    let status = recording_status(&diagnostics);
    assert_eq!(status.level, DiagnosticStatus::OK, "{status:?}");

    let ballast = disk.path().join("ballast");
    fill(&ballast);
    // Until the preallocated space is used up.
    let status = (0..)
        .map(|number| {
            slow_impact(&domain, &format!("without room {number}"));
            reports.messages.recv_timeout(PATIENCE).expect("a report");
            diagnostics.messages.try_iter().for_each(drop);
            recording_status(&diagnostics)
        })
        .take(60)
        .find(|status| status.level == DiagnosticStatus::ERROR)
        .expect("an ERROR");
    let lost = status.values.iter().find(|it| it.key == "messages lost");
    let lost: u64 = lost.expect("a count").value.parse().expect("a number");
    assert!(lost > 0, "{status:?}");

    std::fs::remove_file(&ballast).unwrap();
    let given_up = Instant::now() + PATIENCE;
    while recordings(disk.path()).len() < 2 {
        assert!(Instant::now() < given_up, "no second recording");
        std::thread::park_timeout(Duration::from_millis(20));
    }
    slow_impact(&domain, "after");
    wait_for_report(&reports, "after");
    drop((reports, diagnostics));
    let (code, log) = stopped(node);
    assert_eq!(code, Some(3), "{log}");
    assert!(
        log.contains("messages are missing in the recordings"),
        "{log}"
    );
    assert!(log.contains("ERROR"), "{log}");

    let found = recordings(disk.path());
    assert_eq!(found.len(), 2, "{found:?}");
    for (path, event) in found.iter().zip(["before", "after"]) {
        let reader = Reader::open(path).unwrap();
        assert!(reader.wholeness().is_whole(), "{}", reader.wholeness());
        let whole: Vec<_> = reader.messages().map(Result::unwrap).collect();
        let told = whole.iter().any(|it| {
            *it.topic == *"/impact_report"
                && it
                    .data
                    .windows(event.len())
                    .any(|it| it == event.as_bytes())
        });
        assert!(told, "no report of {event:?} in {}", path.display());
        let found = verify(path).unwrap();
        assert!(found.is_equal(), "{found}");
        assert!(found.compared() > 40, "{found}");
    }
}
