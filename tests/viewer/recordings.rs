//! Files for the viewer, from simulations and from the messages of a recording.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use column_twin::column::{Impact, Report, Sample, simulate};
use column_twin::messages::column_twin_msgs::{
    ColumnState, HingeForces, ImpactEvent, ImpactReport,
};
use column_twin::parameters::{Parameters, Value};
use column_twin::viewer::{
    Drawing, RecordedMessage, Timeline, ViewerError, ViewerItem, from_messages, from_samples,
    write_rrd,
};

fn impact() -> (Vec<Sample>, Report) {
    let car = Impact {
        mass: 1500.0,
        velocity: 10.0,
        gap: 0.0,
        restitution: 0.0,
        vehicle: None,
        bumper_height: 0.0,
        transverse_force: 0.0,
    };
    let mut samples = Vec::new();
    let column = Parameters::default().column_properties();
    let report = simulate(&column, &car, 2.0, &mut |sample| samples.push(*sample));
    (samples, report.expect("simulated"))
}

/// The messages of one impact: a state per millisecond, and both reports.
fn recorded(event_id: &str) -> (Vec<RecordedMessage>, [RecordedMessage; 2]) {
    let (samples, report) = impact();
    let states = samples.iter().step_by(50).map(|sample| {
        let mut state = ColumnState::from(sample);
        state.event_id = event_id.to_owned();
        RecordedMessage::State(state, HingeForces::from(sample))
    });
    let report = |kind| {
        RecordedMessage::Report(Box::new(ImpactReport {
            kind,
            event_id: event_id.to_owned(),
            ..ImpactReport::from(&report)
        }))
    };
    let reports = [ImpactReport::FORECAST, ImpactReport::RESULT].map(report);
    (states.collect(), reports)
}

/// The items of one recorded impact on a column with the default parameters.
fn items(event_id: &str) -> Vec<ViewerItem> {
    let (states, reports) = recorded(event_id);
    let messages = states.into_iter().chain(reports).collect();
    from_messages(&Arc::default(), messages)
}

#[test]
fn impacts_of_a_recording_follow_one_another_each_with_its_reports() {
    let (one, of_one) = recorded("a");
    let (other, of_other) = recorded("b");
    let (_, without_states) = recorded("c");
    let count = one.len();
    let reports = of_other.into_iter().chain(without_states).chain(of_one);
    let messages = one.into_iter().chain(other).chain(reports).collect();
    let items = from_messages(&Arc::default(), messages);
    assert_eq!(items.len(), 2 * count + 4);
    assert!(matches!(&items[0], ViewerItem::Forecast(it) if &*it.event_id == "a"));
    assert!(matches!(&items[count + 1], ViewerItem::Result(it) if &*it.event_id == "a"));
    assert!(matches!(&items[count + 2], ViewerItem::Forecast(it) if &*it.event_id == "b"));
    assert!(matches!(items.last(), Some(ViewerItem::Result(it)) if &*it.event_id == "b"));
    let mut timeline = Timeline::new(20_000);
    let mut times = items.iter().filter_map(|item| match item {
        ViewerItem::State(state) => Some(timeline.place(state).moment.impact_time),
        _ => None,
    });
    assert_eq!(times.next(), Some(0));
    assert!(times.is_sorted());
}

/// The second impact is at another height, after the column has been replaced by a taller one.
#[test]
fn impacts_are_shown_at_their_height_on_the_column_of_their_time() {
    let taller = Parameters::from_values([("geometry.length_above", Value::from(3.5))]);
    let taller = Arc::new(taller.expect("admissible"));
    let event = ImpactEvent {
        event_id: "b".to_owned(),
        column_id: "column".to_owned(),
        height: 1.25,
        ..ImpactEvent::default()
    };
    let messages = [
        RecordedMessage::Column(Arc::default()),
        recorded("a").0[0].clone(),
        RecordedMessage::Column(Arc::clone(&taller)),
        RecordedMessage::Event(Box::new(event)),
        recorded("b").0[0].clone(),
    ];
    let items = from_messages(&Arc::default(), messages.to_vec());
    let [
        ViewerItem::State(a),
        ViewerItem::Parameters(column),
        ViewerItem::State(b),
    ] = &items[..]
    else {
        panic!("{items:?}");
    };
    assert_eq!(*column, taller);
    assert_eq!(a.lengths, None);
    let lengths = b.lengths.expect("the event gives the height");
    let drawing = Drawing::new(&taller);
    assert_eq!(lengths.below, 1.25);
    assert_eq!(lengths.total(), drawing.lengths.total());
    let moved = Drawing { lengths, ..drawing };
    let scene = moved.scene(&b.sample, None);
    let apart = 2.0 * moved.half_depth();
    let heights = [0, 1].map(|hinge| f64::from(scene.hinges[hinge].place[2]));
    assert!(
        heights.iter().all(|it| (it - 1.25).abs() < apart),
        "{heights:?}"
    );
}

#[test]
fn a_recording_becomes_a_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("impact.rrd");
    let before = Instant::now();
    let items = items("a");
    write_rrd(&path, &Arc::new(Parameters::default()), items, false).expect("written");
    println!(
        "a recording of 57 ms at 1 kHz became a file within {:?}",
        before.elapsed()
    );
    let content = std::fs::read(&path).expect("there");
    assert_eq!(&content[..4], b"RRF2");
    assert!(content.len() > 100_000, "{}", content.len());
    assert_eq!(std::fs::read_dir(folder.path()).expect("there").count(), 1);
}

#[test]
fn every_step_of_a_simulation_becomes_a_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("impact.rrd");
    let (samples, report) = impact();
    let steps = samples.len();
    let before = Instant::now();
    let items = from_samples("car", 0, samples, &ImpactReport::from(&report));
    write_rrd(&path, &Arc::new(Parameters::default()), items, false).expect("written");
    println!("{steps} steps became a file within {:?}", before.elapsed());
}

#[test]
fn a_file_that_cannot_be_written_is_reported_and_leaves_nothing() {
    let parameters = Arc::new(Parameters::default());
    for path in ["/nowhere/at/all/impact.rrd", "/"] {
        let error = write_rrd(Path::new(path), &parameters, items("a"), false).expect_err(path);
        assert!(matches!(error, ViewerError::File { .. }), "{error:?}");
        assert!(error.to_string().starts_with("cannot write /"), "{error}");
    }
}
