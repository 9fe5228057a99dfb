//! The command `report`, run as by a user.

use std::path::Path;

use assert_cmd::Command;
use tempfile::TempDir;

use column_twin::column::ImpactSpecification;
use column_twin::messages::cdr;
use column_twin::messages::column_twin_msgs::ImpactReport;
use column_twin::parameters::Value;
use column_twin::twin::ImpactCommand;

use super::copies::forged;
use super::recorded_twin::{Finished, MS, RecordedTwin, event, parameters};

/// Runs the program in a folder: exit code, standard output, standard error.
pub fn typed(folder: &Path, line: &str) -> (i32, String, String) {
    let output = Command::cargo_bin("column-twin")
        .unwrap()
        .current_dir(folder)
        .args(line.split(' '))
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (
        output.status.code().unwrap(),
        text(output.stdout),
        text(output.stderr),
    )
}

/// Writes the report about a recording: exit code and standard error.
pub fn reported(bag: &Path, html: &Path, options: &[&str]) -> (i32, String) {
    let output = Command::cargo_bin("column-twin")
        .unwrap()
        .arg("report")
        .arg(bag)
        .arg("-o")
        .arg(html)
        .args(options)
        .output()
        .unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    (output.status.code().unwrap(), stderr)
}

/// Three impacts with a change of the load between them, of which the second hits the moving column, a rejected event, and
/// a last impact whose response is cut off by the end.
pub fn three_impacts() -> Finished {
    let mut twin = RecordedTwin::new(parameters());
    twin.hit(event("first", twin.now));
    (0..12).for_each(|_| twin.advance(MS));
    twin.hit(ImpactCommand {
        impact: ImpactSpecification {
            gap: Some(0.02),
            ..event("second", twin.now).impact
        },
        ..event("second", twin.now)
    });
    twin.until_rest();
    twin.set(&[("top.load", Value::from(4e5))]);
    twin.hit(ImpactCommand {
        impact: ImpactSpecification {
            mass: f64::NAN,
            ..event("rejected", twin.now).impact
        },
        ..event("rejected", twin.now)
    });
    twin.advance(MS);
    twin.hit(event("third", twin.now));
    twin.until_rest();
    twin.advance(MS);
    twin.hit(event("last", twin.now));
    twin.advance(MS);
    twin.finish()
}

/// Writes the report about a recording: exit code, the report, and standard error.
pub fn report_of(bag: &Path, options: &[&str]) -> (i32, String, String) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("report.html");
    let (code, stderr) = reported(bag, &path, options);
    let html = std::fs::read_to_string(path).unwrap_or_default();
    (code, html, stderr)
}

#[test]
fn every_impact_of_a_recording_has_its_section_and_the_recording_is_verified() {
    let recording = three_impacts();
    let (code, html, stderr) = report_of(&recording.path(), &[]);
    assert_eq!((code, stderr.as_str()), (0, ""));
    // The first one has no outcome, because the second hit the moving column, nor has the last one.
    assert_eq!(html.matches("class=\"impact\"").count(), 2);
    for text in [
        "Impact 1: ",
        "Impact 2: ",
        "<strong>Equal",
        "no report in this recording",
        "no report of its own: ",
        "rejected: ",
        "The column was still moving when this impact began",
        "SHA-256 of ",
        "4.000 m",
        "The applied load N of 400 kN",
    ] {
        assert!(html.contains(text), "{text}");
    }
    let hash = sha256(&recording.path());
    assert!(html.contains(&hash), "{hash}");
}

/// The hash of the only MCAP file of a recording, by another program.
fn sha256(bag: &Path) -> String {
    let file = std::fs::read_dir(bag)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .find(|path| path.extension().is_some_and(|it| it == "mcap"))
        .unwrap();
    let output = std::process::Command::new("sha256sum")
        .arg(file)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    text.split(' ').next().unwrap().to_owned()
}

#[test]
fn one_event_is_chosen_by_its_identifier() {
    let recording = three_impacts();
    let (code, html, _) = report_of(&recording.path(), &["--event", "third"]);
    assert_eq!(code, 0);
    assert_eq!(html.matches("class=\"impact\"").count(), 1);
    assert!(html.contains("<td>third</td>"));
    let (code, html, stderr) = report_of(&recording.path(), &["--event", "fourth"]);
    assert_eq!((code, html.as_str()), (2, ""));
    assert!(
        stderr.contains("first, second, rejected, third, last")
            && stderr.contains("--event fourth"),
        "{stderr}"
    );
}

/// The numbers of a report about a recorded simulation are those of the simulation.
#[test]
fn a_recorded_impact_is_reported_as_the_simulated_one() {
    let folder = TempDir::new().unwrap();
    let options = "--mass 1200 --velocity 9 --record bag --report simulated.html";
    let (code, _, stderr) = typed(folder.path(), &format!("simulate {options}"));
    assert_eq!(code, 0, "{stderr}");
    let (code, _, stderr) = typed(folder.path(), "report bag -o recorded.html");
    assert_eq!(code, 0, "{stderr}");
    let figures = |name: &str| {
        let html = std::fs::read_to_string(folder.path().join(name)).unwrap();
        let svgs = html.split("<svg").skip(1).map(|rest| {
            let end = rest.rfind("</svg>").unwrap_or(rest.len());
            rest[..end].to_owned()
        });
        // Each drawing is within a frame, which has no text.
        svgs.filter(|svg| svg.contains("<text")).collect::<Vec<_>>()
    };
    // The recording of a simulation has no second opinion.
    let (mut simulated, recorded) = (figures("simulated.html"), figures("recorded.html"));
    let with_beam = simulated.len();
    simulated.retain(|svg| !svg.contains("by both models"));
    assert_eq!(with_beam - simulated.len(), 2);
    assert!(simulated.len() > 10);
    assert!(simulated == recorded, "other figures");
}

#[test]
fn a_changed_recording_is_reported_as_changed() {
    let recording = three_impacts();
    let (_kept, path) = forged(&recording.path(), |message| {
        let is_report = *message.topic == *"/impact_report";
        let mut data = message.data.clone();
        if is_report {
            let mut report: ImpactReport = cdr::decode(&data).unwrap();
            report.max_v1 *= 0.5;
            data = cdr::encode(&report).unwrap();
        }
        Some(data)
    });
    let (code, html, stderr) = report_of(&path, &[]);
    assert_eq!(code, 1, "{stderr}");
    assert!(stderr.contains("2 differences"), "{stderr}");
    let main = &html[html.find("<main>").unwrap()..];
    let headline = "<p class=\"headline\">This recording differs from its recomputation</p>";
    // It precedes every verdict.
    assert_eq!(main.find("<p class=\"headline\">"), main.find(headline));
    assert!(html.contains("/impact_report: max_v1 is "));
}

/// Without a journal nothing can be recomputed: the report shows what the messages contain, and gives no verdict.
#[test]
fn a_recording_without_a_journal_gives_no_verdict() {
    let recording = three_impacts();
    let (_kept, path) = forged(&recording.path(), |message| {
        (!message.topic.ends_with("/journal")).then(|| message.data.clone())
    });
    let (code, html, stderr) = report_of(&path, &[]);
    assert_eq!(code, 3, "{stderr}");
    assert!(stderr.contains("could not be verified"), "{stderr}");
    assert!(html.contains("This recording could not be verified"));
    assert!(!html.contains("class=\"impact\"") && !html.contains("predicted"));
    assert!(
        html.contains("<th scope=\"row\">third</th>"),
        "the overview"
    );
}

#[test]
fn a_recording_that_was_cut_off_is_reported_as_far_as_it_goes() {
    let recording = three_impacts();
    let file = std::fs::read_dir(recording.path())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .find(|path| path.extension().is_some_and(|it| it == "mcap"))
        .unwrap();
    let bytes = std::fs::read(file).unwrap();
    let folder = TempDir::new().unwrap();
    let cut = folder.path().join("cut.mcap");
    // Without the end of the file, and in the middle of the last response.
    for missing in [100, bytes.len() / 8] {
        std::fs::write(&cut, &bytes[..bytes.len() - missing]).unwrap();
        let (code, html, stderr) = report_of(&cut, &[]);
        assert_eq!(code, 3, "{missing}: {stderr}");
        assert!(html.contains("This recording is not complete"), "{missing}");
        assert!(html.contains("Impact 1: "), "{missing}");
        assert!(stderr.contains("column-twin repair"), "{stderr}");
    }
    std::fs::write(&cut, &bytes[..100]).unwrap();
    let (code, html, stderr) = report_of(&cut, &[]);
    assert_eq!((code, html.as_str()), (2, ""), "{stderr}");
}

#[test]
fn what_is_not_a_recording_of_an_impact_is_rejected_with_the_reason() {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("text.mcap"), "no recording").unwrap();
    std::fs::create_dir(folder.path().join("folder")).unwrap();
    for bag in ["nothing", "text.mcap", "folder"] {
        let (code, _, stderr) = typed(folder.path(), &format!("report {bag}"));
        assert_eq!(code, 2, "{bag}: {stderr}");
        assert!(stderr.contains(bag), "{bag}: {stderr}");
    }
    // A twin to which nothing happened.
    let idle = RecordedTwin::new(parameters()).finish();
    let (code, html, stderr) = report_of(&idle.path(), &[]);
    assert_eq!((code, html.as_str()), (2, ""));
    assert!(stderr.contains("contains no impact"), "{stderr}");
    let (code, _, stderr) = typed(folder.path(), "simulate --record bag");
    assert_eq!(code, 0, "{stderr}");
    let (code, _, stderr) = typed(folder.path(), "report bag -o nowhere/report.html");
    assert_eq!(code, 1, "{stderr}");
    assert!(stderr.contains("nowhere/report.html"), "{stderr}");
}

#[test]
fn a_report_tells_how_fast_a_vehicle_may_hit_the_column_next() {
    let mut twin = RecordedTwin::new(parameters());
    twin.hit(event("a", twin.now));
    twin.until_rest();
    twin.advance(MS);
    twin.know_critical_velocities();
    twin.advance(MS);
    let known = twin.twin.status(twin.now).critical_velocities;
    let known = known.expect("known");
    let (code, html, _) = report_of(&twin.finish().path(), &[]);
    assert_eq!(code, 0);
    let (_, section) = html
        .split_once("id=\"critical-velocities\"")
        .expect("a section");
    for it in known.iter() {
        assert!(section.contains(&*it.vehicle));
        let evacuate = it.evacuate.filter(|it| *it > 0.0);
        assert!(evacuate.is_none_or(|it| section.contains(&format!("{it:.1} m/s"))));
    }
    let recording = three_impacts();
    let (_, html, _) = report_of(&recording.path(), &[]);
    assert!(!html.contains("id=\"critical-velocities\""), "not known");
}
