//! Reports about impacts that sensors have detected.

use std::path::Path;
use std::sync::Arc;

use tempfile::TempDir;

use column_twin::column::Impact;
use column_twin::estimation::{
    EstimateRecord, ImpactEstimate, RecordedImpact, estimate_recorded, simulate_sensors,
};
use column_twin::parameters::{Parameters, Value};
use column_twin::twin::{Command, EstimateDecision};

use super::recorded_twin::{Finished, MS, RecordedTwin, parameters};
use super::recordings::{report_of, typed};

const CONFIG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/config");

/// What industrial sensors say about a rigid mass that hits the column.
fn estimated() -> RecordedImpact {
    let files = ["heb220_s355.yaml", "sensors_industrial.yaml"];
    let files = files.map(|it| Path::new(CONFIG).join(it));
    let sensors = Parameters::load(&files, &[]).expect("parameters").sensors();
    let properties = parameters().column_properties();
    let impact = Impact::rigid(1500.0, 6.0);
    let readings = simulate_sensors(&properties, &impact, 0.3, &sensors, 1).expect("readings");
    estimate_recorded(&parameters(), &sensors, &readings, 1, &mut |_| {})
        .expect("sensors")
        .expect("an impact")
}

/// The twin receives each estimate, and decides as `estimation.accept` says; with `confirmation` an operator accepts the first one.
/// Then a camera reports the same impact.
fn detected(impact: &RecordedImpact, accept: &str) -> Finished {
    let parameters = parameters().with_changes([("estimation.accept", Value::from(accept))]);
    let mut twin = RecordedTwin::new(parameters.expect("admissible"));
    (0..500).for_each(|_| twin.advance(MS));
    let origin = twin.now - 450 * MS;
    for (update, estimate) in (0..).zip(&impact.estimates) {
        let record = EstimateRecord {
            event_id: "detected-1".into(),
            update,
            is_final: update as usize + 1 == impact.estimates.len(),
            detection: impact.detection.clone(),
            origin,
            column: None,
            batches: 10,
            first_batch: 0,
            last_batch: (0, twin.now),
            lost_batches: 0,
            prepared: 3,
            drawn_before: 0,
            drawn: 20,
            counts_beam: false,
            events: Vec::new(),
            estimate: estimate.clone(),
            best: Impact::rigid(1500.0, 6.0),
        };
        twin.execute(Command::Estimate(Arc::new(record)));
        if update == 0 && accept == "confirmation" {
            twin.execute(Command::DecideEstimate(EstimateDecision {
                event_id: "detected-1".to_owned(),
                accept: true,
                source: "operator 7".into(),
            }));
        }
        twin.advance(MS);
    }
    twin.hit(super::recorded_twin::event("camera", twin.now));
    // A response that is over gives nothing out any more; what has become of the estimate comes with the next instant.
    twin.advance(MS);
    twin.until_rest();
    twin.finish()
}

/// The peak as the table of a report shows it.
fn peak(estimate: &ImpactEstimate) -> String {
    let shown = |si: f64| column_twin::figures::units::significant(1e3 * si, 3);
    let it = &estimate.peak_v1;
    format!(
        "{} ({} to {}) mm",
        shown(it.mean),
        shown(it.low),
        shown(it.high)
    )
}

#[test]
fn a_report_about_a_recording_shows_how_what_was_detected_was_estimated() {
    let impact = estimated();
    let recording = detected(&impact, "never");
    let (_, html, stderr) = report_of(&recording.path(), &[]);
    assert!(html.contains("<h3>Impact detected-1</h3>"), "{stderr}");
    // The tested truth is 6 m/s; the table has one row for each estimate.
    for estimate in &impact.estimates {
        let row = format!("<td class=\"number\">{}</td>", peak(estimate));
        assert!(html.contains(&row), "{row}");
    }
    let last = impact.estimates.last().expect("an estimate");
    assert!((last.velocity.low..=last.velocity.high).contains(&6.0));
    assert!(html.contains("Forecast of the displacement"));
    // The camera has reported what the sensors detected, and the twin follows it.
    assert!(html.contains("the event &quot;camera&quot; is the same impact, and the twin follows"));
    assert!(html.contains("<a href=\"#impact\">impact &quot;camera&quot;</a>"));
    assert!(!html.contains("The recording ends before the final estimate"));
    let (_, html, _) = report_of(&recording.path(), &["--event", "camera"]);
    assert!(html.contains("Impact report") && !html.contains("detected-1</h3>"));
}

/// Whatever the twin has made of it, the report says who has decided when, and where the outcome is.
#[test]
fn a_report_tells_who_has_accepted_what_was_detected_and_what_it_became() {
    let impact = estimated();
    let contact = impact.detection.contact.time;
    let until = 1e3 * (impact.estimates[0].data_until - contact);
    // An automatic acceptance comes with the first estimate that is sure enough.
    let first = format!("with estimate 0 (data until {until:.0}");
    for (accept, when, by) in [
        ("confirmation", first.as_str(), "by operator 7"),
        ("automatic", "with estimate ", "by the twin itself"),
    ] {
        let recording = detected(&impact, accept);
        let (_, html, stderr) = report_of(&recording.path(), &[]);
        let accepted = format!("accepted as an impact of the twin {when}");
        assert!(
            html.contains(&accepted) && html.contains(by),
            "{accept}: {stderr}{html}"
        );
        assert!(html.contains("and was merged as evidence"), "{accept}");
        assert!(
            html.contains("<a href=\"#impact\">impact &quot;detected-1&quot;</a>"),
            "{accept}"
        );
        assert!(html.contains("1500 kg with 6.00 m/s"), "{accept}");
    }
}

#[test]
fn the_command_estimate_writes_a_report_and_figures() {
    let folder = TempDir::new().expect("a folder");
    let column =
        format!("--config {CONFIG}/heb220_s355.yaml --config {CONFIG}/sensors_industrial.yaml");
    let simulate = format!("simulate {column} --mass 1500 --velocity 6 --readings readings.csv");
    let (code, _, stderr) = typed(folder.path(), &simulate);
    assert_eq!(code, 0, "{stderr}");
    let estimate = format!("estimate {column} --readings readings.csv");
    let line = format!("{estimate} --report detected.html --figures figures --json");
    let (code, json, stderr) = typed(folder.path(), &line);
    assert_eq!((code, stderr.as_str()), (0, ""));
    let html = std::fs::read_to_string(folder.path().join("detected.html")).expect("a report");
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let momentum = json["momentum_n_s"]["mean"].as_f64().expect("a momentum");
    let momentum = column_twin::figures::units::significant(1e-3 * momentum, 3);
    assert!(
        html.contains(&format!("{momentum} kN s</td>")),
        "{momentum}"
    );
    let figures = [
        "estimate_forecast",
        "sensor_accelerometer",
        "sensor_laser",
        "sensor_base_strain",
    ];
    assert_eq!(html.matches("<figure").count(), figures.len());
    for figure in figures {
        let svg = folder.path().join(format!("figures/{figure}.svg"));
        let svg = std::fs::read_to_string(svg).expect(figure);
        assert!(html.contains(&svg), "{figure}");
        assert!(
            folder
                .path()
                .join(format!("figures/{figure}.png"))
                .is_file()
        );
    }
    // Without an impact there is nothing to draw, and the program says so.
    std::fs::write(
        folder.path().join("quiet.csv"),
        "time,laser\n0,0\n0.0001,0.0001\n0.0002,0\n",
    )
    .expect("a table");
    let quiet = format!("estimate {column} --readings quiet.csv --report quiet.html");
    let (code, _, stderr) = typed(folder.path(), &quiet);
    assert_eq!(code, 0);
    assert!(stderr.contains("no impact was detected"), "{stderr}");
    assert!(!folder.path().join("quiet.html").exists());
    // A file with an odd name, and a report that cannot be written: the result is printed all the same.
    let odd = folder.path().join("a<b>&c.csv");
    std::fs::rename(folder.path().join("readings.csv"), odd).expect("renamed");
    let nowhere = format!(
        "estimate {column} --readings a<b>&c.csv --figures odd --report nowhere/detected.html"
    );
    let (code, summary, stderr) = typed(folder.path(), &nowhere);
    assert_eq!(code, 1, "{stderr}");
    assert!(summary.contains("Impact at"), "{summary}");
    assert!(folder.path().join("odd/sensor_laser.png").is_file());
    assert!(stderr.contains("cannot write the report"), "{stderr}");
}
