//! What the sensors detect, as the viewer gets it: from readings of a simulated impact to the data in a stream.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use column_twin::column::Impact;
use column_twin::estimation::{
    Batch, EstimateRecord, RecordedImpact, estimate_recorded, simulate_sensors,
};
use column_twin::messages::column_twin_msgs::{ImpactEstimate, ImpactReport};
use column_twin::parameters::Parameters;
use column_twin::standing::StandingColumn;
use column_twin::time::Nanos;
use column_twin::twin::{Decision, EstimateOutput};
use column_twin::viewer::{
    Announcement, DetectedImpacts, DetectedUpdate, RecordedMessage, ViewerItem, ViewerStream,
    from_messages,
};
use rerun::external::re_log_types::LogMsg;
use rerun::log::Chunk;

use super::in_memory;

/// First row of the readings, by the clock of the twin \[ns\].
pub const BEGIN: Nanos = 1_800_000_000_000_000_000;

const IMPACT: f64 = 5.0;

/// The parameters of a column with sensors.
pub fn files() -> [PathBuf; 2] {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("config");
    ["heb220_s355.yaml", "sensors_industrial.yaml"].map(|it| config.join(it))
}

fn parameters() -> Arc<Parameters> {
    Arc::new(Parameters::load(&files(), &[]).expect("parameters"))
}

/// What the sensors read of a rigid mass of 1.5 t, as batches of 10 ms, and what is estimated of it.
pub fn struck(parameters: &Parameters) -> (Vec<Batch>, RecordedImpact) {
    let (sensors, properties) = (parameters.sensors(), parameters.column_properties());
    let impact = Impact::rigid(1500.0, IMPACT);
    let readings = simulate_sensors(&properties, &impact, 0.3, &sensors, 2).expect("readings");
    let mut batches = Vec::new();
    for sensor in 0..sensors.len() {
        let values = readings.rows().map(|(_, row)| row[sensor] as f32);
        let values: Vec<f32> = values.collect();
        for (count, values) in (0..).zip(values.chunks(100)) {
            batches.push(Batch {
                sensor: sensor as u16,
                first: BEGIN + 10_000_000 * count,
                period: 100_000,
                values: values.into(),
            });
        }
    }
    let estimated = estimate_recorded(parameters, &sensors, &readings, 1, &mut |_| {});
    (batches, estimated.expect("sensors").expect("an impact"))
}

/// The outputs of a twin that receives the estimates; the best response is the impact itself.
fn outputs(parameters: &Parameters, impact: &RecordedImpact) -> Vec<EstimateOutput> {
    let last = impact.estimates.len() - 1;
    let output = |(update, estimate): (usize, &column_twin::estimation::ImpactEstimate)| {
        let record = EstimateRecord {
            event_id: "detected-1".into(),
            update: update as u32,
            is_final: update == last,
            detection: impact.detection.clone(),
            origin: BEGIN + 100_000_000,
            column: (update == 0).then(|| StandingColumn::undamaged(parameters)),
            batches: 10,
            first_batch: 0,
            last_batch: (0, BEGIN),
            lost_batches: 0,
            prepared: 3,
            drawn_before: 0,
            drawn: 20,
            counts_beam: false,
            events: Vec::new(),
            estimate: estimate.clone(),
            best: Impact::rigid(1500.0, IMPACT),
        };
        let contact = record.origin + (1e9 * estimate.contact_time.mean).round() as i64;
        EstimateOutput {
            stamp: contact,
            record: Arc::new(record),
            decision: Decision::Accepted,
            merged_event_id: None,
        }
    };
    impact.estimates.iter().enumerate().map(output).collect()
}

fn updates() -> (Arc<Parameters>, RecordedImpact, Vec<DetectedUpdate>) {
    let parameters = parameters();
    let (batches, impact) = struck(&parameters);
    let mut detected = DetectedImpacts::new(Arc::clone(&parameters));
    let mut updates = Vec::new();
    for output in outputs(&parameters, &impact) {
        let between = |from: Nanos, until: Nanos| -> Vec<Batch> {
            let inside = batches
                .iter()
                .filter(|it| it.end() > from && it.first < until);
            inside.cloned().collect()
        };
        updates.push(detected.of_twin(&output, between));
    }
    (parameters, impact, updates)
}

/// Every millisecond of every sensor is shown once, and what was predicted for it is near to what was measured.
#[test]
fn readings_are_shown_once_beside_what_was_predicted() {
    let (parameters, impact, updates) = updates();
    assert!(updates.len() > 3 && updates.iter().all(|it| it.is_new));
    let until = updates.last().expect("an update").until;
    assert!(until > 0.05, "{until}");
    for (sensor, declared) in parameters.sensors().iter().enumerate() {
        let of = |part: fn(&column_twin::viewer::SensorCourse) -> &Vec<(f64, f64)>| {
            let courses = updates.iter().filter_map(|it| it.sensors.get(sensor));
            courses.flat_map(|it| part(it).clone()).collect::<Vec<_>>()
        };
        let measured = of(|it| &it.measured);
        let times: Vec<i64> = measured
            .iter()
            .map(|(time, _)| (1e6 * time).round() as i64)
            .collect();
        let expected: Vec<i64> = (0..times.len() as i64)
            .map(|cell| -4_500 + 1_000 * cell)
            .collect();
        assert_eq!(times, expected, "{}", declared.name);
        assert!((times.len() as f64 - 1e3 * (until + 0.005)).abs() < 1.5);
        // Simulated with steps of its own, a filter, and errors of the sensors.
        let predicted: BTreeMap<i64, f64> = of(|it| &it.predicted)
            .iter()
            .map(|(time, value)| ((1e6 * time).round() as i64, *value))
            .collect();
        let explained = of(|it| &it.explained);
        assert_eq!(explained.len(), measured.len());
        let largest = measured
            .iter()
            .fold(0.0, |most: f64, (_, it)| most.max(it.abs()));
        if declared.name == "accelerometer" {
            continue; // clipped, and of vibrations whose phase is that of the steps
        }
        let mut compared = 0;
        for ((time, value), (_, explained)) in times
            .iter()
            .zip(&measured)
            .map(|(t, (_, v))| (t, v))
            .zip(&explained)
        {
            let off = (explained - value).abs() / largest;
            assert!(off < 0.1, "{} at {time} us: {off}", declared.name);
            if let Some(predicted) = predicted.get(time) {
                assert!(
                    (predicted - value).abs() / largest < 0.1,
                    "{} at {time} us",
                    declared.name
                );
                compared += 1;
            }
        }
        // All but the data of the first estimate were predicted.
        let first = updates[0].until;
        assert!(
            (f64::from(compared) - 1e3 * (until - first)).abs() < 1.5,
            "{compared}"
        );
    }
    assert!((impact.estimates[0].momentum.mean / 7500.0 - 1.0).abs() < 0.5);
}

/// The last data of each entity in a stream: their number of rows, by entity.
pub fn rows(messages: &[LogMsg]) -> BTreeMap<String, usize> {
    let mut rows = BTreeMap::new();
    for message in messages {
        if let LogMsg::ArrowMsg(_, data) = message
            && let Ok(chunk) = Chunk::from_arrow_msg(data)
            && !chunk.is_static()
        {
            *rows.entry(chunk.entity_path().to_string()).or_default() += chunk.num_rows();
        }
    }
    rows
}

/// The stream has the curves of every sensor, the forecast at each estimate, and the outcome.
#[test]
fn a_stream_has_forecast_momentum_action_sensors_and_outcome() {
    let (parameters, _, updates) = updates();
    let count = updates.len();
    let (stream, storage, options) = in_memory::stream();
    let mut shown = ViewerStream::new(stream, Arc::clone(&parameters), options).expect("a stream");
    let measured: usize = updates.iter().map(|it| it.sensors[1].measured.len()).sum();
    let stamp = updates[0].stamp;
    let mut items: Vec<_> = updates
        .into_iter()
        .map(|it| ViewerItem::Detected(Box::new(it)))
        .collect();
    let report = ImpactReport {
        event_id: "detected-1".to_owned(),
        max_v1: 0.02,
        residual_v1: 0.01,
        ..ImpactReport::default()
    };
    let result = ViewerItem::Result(Announcement {
        stamp,
        event_id: "detected-1".into(),
        report: Box::new(report),
    });
    items.insert(count - 1, result);
    shown.show(items).expect("written");
    shown.stream().flush_blocking().expect("written");
    let rows = rows(&storage.take());
    let of = |entity: &str| {
        rows.get(&format!("/detected/{entity}"))
            .copied()
            .unwrap_or_default()
    };
    for entity in ["forecast", "momentum", "action"] {
        assert_eq!(of(entity), count, "{entity}: {rows:?}");
    }
    // At the beginning, when it was known, and with the final estimate.
    assert_eq!(of("outcome"), 3, "{rows:?}");
    assert_eq!(of("sensors/laser/measured"), measured, "{rows:?}");
    for sensor in ["accelerometer", "laser", "base_strain"] {
        assert!(of(&format!("sensors/{sensor}/predicted")) > 0, "{rows:?}");
        assert!(of(&format!("sensors/{sensor}/explained")) > 0, "{rows:?}");
    }
}

/// In a recording the result of one impact comes before what the sensors say of the next.
#[test]
fn an_impact_that_is_detected_ends_the_one_before_in_a_recording() {
    let (parameters, _, updates) = updates();
    let report = |event_id: &str| ImpactReport {
        event_id: event_id.to_owned(),
        kind: ImpactReport::RESULT,
        ..ImpactReport::default()
    };
    let state = |event_id: &str| {
        let state = column_twin::messages::column_twin_msgs::ColumnState {
            event_id: event_id.to_owned(),
            ..Default::default()
        };
        RecordedMessage::State(state, Default::default())
    };
    let mut messages = vec![
        state("before"),
        RecordedMessage::Report(Box::new(report("before"))),
        RecordedMessage::Report(Box::new(report("detected-1"))),
    ];
    let detected = |it: &DetectedUpdate| RecordedMessage::Detected(Box::new(it.clone()));
    messages.push(detected(&updates[0]));
    messages.push(state("detected-1"));
    messages.push(detected(&updates[1]));
    let items = from_messages(&parameters, messages);
    let words: Vec<String> = items
        .iter()
        .map(|item| match item {
            ViewerItem::State(it) => format!("state of {}", it.event_id),
            ViewerItem::Result(it) => format!("result of {}", it.event_id),
            ViewerItem::Detected(it) => format!("{} of {}", it.estimate.update, it.impact()),
            other => format!("{other:?}"),
        })
        .collect();
    let expected = [
        "state of before",
        "result of before",
        "0 of detected-1",
        "state of detected-1",
        "1 of detected-1",
        "result of detected-1",
    ];
    assert_eq!(words, expected);
    let merged = DetectedUpdate {
        estimate: Box::new(ImpactEstimate {
            decision: ImpactEstimate::DECISION_MERGED,
            merged_event_id: "camera".to_owned(),
            ..(*updates[0].estimate).clone()
        }),
        ..updates[0].clone()
    };
    assert_eq!(merged.impact(), "camera");
}
