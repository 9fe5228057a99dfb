//! Estimates from recorded readings: the same detection and the same updates as with live ones.

use crate::estimation::detection::detector::{Detection, Detector};
use crate::estimation::detection::second_blow::SecondBlow;
use crate::estimation::inference::comparison::SensorComparison;
use crate::estimation::inference::estimate::ImpactEstimate;
use crate::estimation::inference::estimator::{
    ASSESSED, COLLAPSE_PERIOD, Estimator, EstimatorError, UPDATE_INSTANTS,
};
use crate::estimation::inference::hypothesis::hypotheses;
use crate::estimation::inference::prediction::HORIZON;
use crate::estimation::inference::update::ASSESSED_IN_HASTE;
use crate::estimation::intake::readings::Readings;
use crate::parameters::Parameters;
use crate::sensors::Sensor;
use crate::standing::StandingColumn;

/// Rounds of refinement for each update of recorded readings, for which there is time.
const ROUNDS: usize = 20;

/// The same of the first updates, up to this instant after contact \[s\]: so much is open then that more rounds seldom suffice either.
const FIRST_ROUNDS: usize = 8;
const FIRST_INSTANTS: f64 = 0.03;

/// How much the rate of readings by their times may differ from the declared one, relative to it.
const RATE_TOLERANCE: f64 = 0.05;

/// What recorded readings say about one impact.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedImpact {
    /// How it was detected.
    pub detection: Detection,
    /// When the column was struck once more \[s\], if it was: the estimates use the readings before that, and the second impact is not
    /// estimated.
    pub further: Option<f64>,
    /// One estimate for each instant of [`UPDATE_INSTANTS`] up to which there are data, and one for all data; at least one. While a
    /// collapse is possible and not told yet, there is one at least every 10 ms.
    pub estimates: Vec<ImpactEstimate>,
    /// For each sensor, what it has read against what the last estimate predicts.
    pub comparisons: Vec<SensorComparison>,
}

/// Finds the first impact in recorded readings and estimates it; `None` without an impact. `progress` is called before each
/// part of the work with the share that is done.
///
/// # Errors
/// Sensors or parameters that cannot be used.
pub fn estimate_recorded(
    parameters: &Parameters,
    sensors: &[Sensor],
    readings: &Readings,
    seed: u64,
    progress: &mut dyn FnMut(f64),
) -> Result<Option<RecordedImpact>, EstimatorError> {
    check(sensors, readings)?;
    let hypotheses = hypotheses(parameters);
    let preparations = hypotheses.len() as f64;
    let column = StandingColumn::undamaged(parameters);
    let mut estimator = Estimator::new(parameters, &column, sensors.to_vec(), hypotheses, seed)?;
    let Some(detection) = detect(&estimator, readings) else {
        return Ok(None);
    };
    let mut prepared = 0.0;
    loop {
        progress(0.5 * prepared / preparations);
        if estimator.prepare() {
            break;
        }
        prepared += 1.0;
    }
    let progress = &mut |share: f64| progress(0.5 + 0.5 * share);
    Ok(Some(follow(&mut estimator, detection, readings, progress)))
}

/// The same with an estimator that is prepared for the undamaged column, for many recordings of the same sensors.
///
/// # Errors
/// Sensors that cannot be used.
pub fn estimate_prepared(
    estimator: &mut Estimator,
    readings: &Readings,
) -> Result<Option<RecordedImpact>, EstimatorError> {
    check(estimator.sensors(), readings)?;
    let detection = detect(estimator, readings);
    Ok(detection.map(|detection| follow(estimator, detection, readings, &mut |_| {})))
}

/// Whether the sensors are fast enough for an impact, and their readings come at the rates that are declared.
fn check(sensors: &[Sensor], readings: &Readings) -> Result<(), EstimatorError> {
    EstimatorError::unless_fast_enough(sensors)?;
    for (index, sensor) in sensors.iter().enumerate() {
        let Some(found) = readings.rate_of(index) else {
            continue;
        };
        if (found / sensor.rate - 1.0).abs() > RATE_TOLERANCE {
            return Err(EstimatorError::Rate {
                sensor: sensor.name.clone(),
                declared: sensor.rate,
                found,
            });
        }
    }
    Ok(())
}

fn follow(
    estimator: &mut Estimator,
    detection: Detection,
    readings: &Readings,
    progress: &mut dyn FnMut(f64),
) -> RecordedImpact {
    let contact = detection.contact.time;
    estimator.begin(contact, detection.contact.deviation, &detection.zeros);
    for (time, values) in readings.rows() {
        for (sensor, &value) in values.iter().enumerate() {
            estimator.push(sensor, time, value);
        }
    }
    let further = second_blow(estimator.sensors(), &detection, readings);
    let last = further.or(readings.times.last().copied());
    let last = last.map_or(0.0, |last| last - contact).min(HORIZON);
    let mut estimates = Vec::new();
    let (mut until, mut is_possible) = (0.0, false);
    loop {
        progress((until / last.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0));
        until = next_instant(until, is_possible, last);
        estimator.observe(contact + until);
        estimator.settle(match until <= FIRST_INSTANTS {
            true => FIRST_ROUNDS,
            false => ROUNDS,
        });
        estimator.ask_beam(until >= last);
        estimator.finish_beam();
        estimator.take_answer_of_beam();
        // Actions of all but the last estimate come in coarser steps, as they do live.
        let assessed = if until >= last {
            ASSESSED
        } else {
            ASSESSED_IN_HASTE
        };
        let estimate = estimator.estimate_assessing(contact + until, assessed);
        is_possible = estimate.expects_collapse();
        estimates.push(estimate);
        if until >= last {
            break;
        }
    }
    RecordedImpact {
        comparisons: estimator.comparisons(),
        detection,
        further,
        estimates,
    }
}

/// The instant after contact of the estimate after one at `until`, which found a collapse possible or not; `last` is that of the last data
/// \[s\].
fn next_instant(until: f64, is_possible: bool, last: f64) -> f64 {
    let next = UPDATE_INSTANTS.into_iter().find(|it| *it > until);
    let soon = if is_possible {
        until + COLLAPSE_PERIOD
    } else {
        last
    };
    next.map_or(soon, |next| next.min(soon)).min(last)
}

fn second_blow(sensors: &[Sensor], detection: &Detection, readings: &Readings) -> Option<f64> {
    let contact = detection.contact.time;
    let mut blow = SecondBlow::new(sensors, &detection.zeros, contact);
    for (time, values) in readings.rows().filter(|(time, _)| *time > contact) {
        for (sensor, &value) in values.iter().enumerate() {
            blow.push(sensor, time, value);
        }
    }
    blow.found()
}

/// The first impact, without the sways that look like one at first.
fn detect(estimator: &Estimator, readings: &Readings) -> Option<Detection> {
    let mut detector = Detector::new(estimator.sensors());
    for (time, values) in readings.rows() {
        for (sensor, &value) in values.iter().enumerate() {
            let detection = detector.push(sensor, time, value);
            if let Some(detection) = detection.filter(|it| !is_sway(estimator, readings, it)) {
                return Some(detection);
            }
        }
    }
    None
}

/// Whether the column sways in what follows a contact, as far as live estimates would know of it.
fn is_sway(estimator: &Estimator, readings: &Readings, detection: &Detection) -> bool {
    let mut sway = estimator.sway(detection);
    let contact = detection.contact.time;
    let end = contact + HORIZON;
    let rows = readings.rows();
    let rows = rows.filter(|(time, _)| (contact..=end).contains(time));
    for (time, values) in rows {
        for (sensor, &value) in values.iter().enumerate() {
            sway.push(sensor, time, value);
        }
    }
    sway.found().is_some()
}
