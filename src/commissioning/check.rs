//! The check itself: faults that a sensor shows alone, then what it shows beside the others, then the stiffness of the supports.

use std::ops::Range;

use column_beam::{BeamColumn, BeamError};
use thiserror::Error;

use super::expected::{Candidates, MODES, lag, shows_vibration, vibrating};
use super::explanation::{Amplitude, Comparison, Explanation, MeasuredMode, Suspicion};
use super::motion::{LEAST_MEANS, LEAST_OF_NOISE, Motion, Vibration};
use super::stiffness::{SupportStiffness, stiffness};
use crate::estimation::Readings;
use crate::sensors::Sensor;

/// How much the rate of readings by their times may differ from the declared one, relative to it.
const RATE_TOLERANCE: f64 = 0.05;

/// A sensor is stuck that repeats one value for this share of its readings, and at least so many times, while another one varies by
/// this share of all that it varies by.
const STUCK_SHARE: f64 = 0.25;
const LEAST_STUCK: usize = 200;
const MOVING_SHARE: f64 = 0.5;

/// A sensor is saturated that stays at an end of its range from one reading to the next for this share of its readings.
const SATURATED_SHARE: f64 = 0.005;

/// A limit holds this many times as many readings as the value next to it; at the crest of a sine in steps it is 2.4 times.
const LIMIT_OVER_NEXT: usize = 5;

/// Different values that a sensor must show before its largest one counts as an end of its range.
const LEAST_VALUES: usize = 50;

/// A vibration out of phase with the others by more than this sine has another clock.
const LEAST_SINE: f64 = 0.35;

/// Why nothing is checked.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CheckError {
    /// No column.
    #[error(transparent)]
    Beam(#[from] BeamError),
    /// No sensor shows vibrations across the column.
    #[error(
        "expected a sensor that shows vibrations across the column ({}); found {found}",
        vibrating()
    )]
    NoSensor {
        /// What the sensors measure.
        found: String,
    },
    /// No such sensor has readings that vary.
    #[error("expected readings that vary; each sensor is dead, stuck or saturated: {found}")]
    NoReadings {
        /// The sensors with what is wrong.
        found: String,
    },
    /// Too short, or too slow.
    #[error(
        "expected readings of at least {expected:.2} s, four periods of the first frequency; found {found:.2} s"
    )]
    Short {
        /// \[s\]
        expected: f64,
        /// \[s\]
        found: f64,
    },
    /// Too few readings in a segment.
    #[error(
        "expected a sensor with at least {LEAST_MEANS} readings in {secs:.2} s, four or more periods of the first frequency; \
         found none"
    )]
    Sparse {
        /// Length of the segment \[s\].
        secs: f64,
    },
    /// No sensor is fast enough.
    #[error(
        "expected a sensor with more than {expected:.0} samples per second, twice the first frequency; the fastest one has {found:.0}"
    )]
    Slow {
        /// \[Hz\]
        expected: f64,
        /// \[Hz\]
        found: f64,
    },
    /// The column vibrates too little.
    #[error(
        "not enough motion between {:.1} and {:.1} Hz: expected at least {expected:.2e} {unit} at {sensor}, found {found:.2e} {unit}",
        .band[0],
        .band[1]
    )]
    NotEnoughMotion {
        /// The sensor that shows the motion best.
        sensor: String,
        /// Its unit.
        unit: &'static str,
        /// Least amplitude.
        expected: f64,
        /// The amplitude that was found.
        found: f64,
        /// Where it was looked for \[Hz\].
        band: [f64; 2],
    },
}

/// A natural frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedMode {
    /// With the supports of the parameters \[Hz\].
    pub declared: f64,
    /// With all supports that are looked at \[Hz\].
    pub band: [f64; 2],
    /// \[Hz\]; `None` if it does not exceed the noise.
    pub found: Option<f64>,
}

/// What is wrong with a sensor.
#[derive(Debug, Clone, PartialEq)]
pub enum SensorFault {
    /// It has no readings.
    NoReadings,
    /// It repeats this value, for this share of its readings.
    Stuck(f64, f64),
    /// This share of its readings is at an end of its range, which is this value.
    Saturated(f64, f64),
    /// Its readings come at this rate by their times \[Hz\].
    Rate(f64),
    /// It vibrates out of phase with the others, by this angle \[rad\] at the lowest frequency that tells it, which there is this
    /// time \[s\].
    OutOfPhase(f64, f64),
    /// It contradicts the others.
    Explained(Explanation),
}

/// What the check says of a sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedSensor {
    /// Its name.
    pub name: String,
    /// Its amplitude at the first frequency that follows from the other sensors, and the one that was found, in its unit.
    pub amplitudes: Option<[f64; 2]>,
    /// What is wrong; several explanations of one contradiction are all possible.
    pub faults: Vec<SensorFault>,
    /// Sensors that may be wrong in its place.
    pub or: Vec<String>,
    /// Why it was not compared with the others.
    pub untested: Option<&'static str>,
}

/// The result of a check.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorCheck {
    /// The lowest natural frequencies.
    pub modes: Vec<CheckedMode>,
    /// The sensors in their order.
    pub sensors: Vec<CheckedSensor>,
    /// The stiffness of the supports that turn.
    pub supports: Vec<SupportStiffness>,
}

impl SensorCheck {
    /// Whether no sensor is wrong.
    #[must_use]
    pub fn is_consistent(&self) -> bool {
        self.sensors.iter().all(|it| it.faults.is_empty())
    }
}

/// Checks the sensors on a column with readings that were taken while it vibrated from ambient excitation or from a tap.
///
/// # Errors
/// Why nothing can be checked, such as too little motion.
pub fn check_sensors(
    column: &BeamColumn,
    sensors: &[Sensor],
    readings: &Readings,
) -> Result<SensorCheck, CheckError> {
    let candidates = Candidates::new(column)?;
    let mut checked: Vec<CheckedSensor> = sensors
        .iter()
        .enumerate()
        .map(|(index, sensor)| alone(sensor, index, readings))
        .collect();
    if !sensors.iter().any(|it| shows_vibration(it.quantity)) {
        let words: Vec<&str> = sensors.iter().map(|it| it.quantity.word()).collect();
        let found = match words.is_empty() {
            true => "no sensor".to_owned(),
            false => words.join(", "),
        };
        return Err(CheckError::NoSensor { found });
    }
    let bands = [0, 1].map(|mode| candidates.band(mode));
    let rates: Vec<f64> = (0..sensors.len())
        .map(|it| readings.rate_of(it).unwrap_or(sensors[it].rate))
        .collect();
    let usable = |mode: usize| -> Vec<bool> {
        let each = sensors.iter().zip(&checked).zip(&rates);
        each.map(|((sensor, checked), rate)| {
            let is_whole = checked
                .faults
                .iter()
                .all(|it| matches!(it, SensorFault::Rate(_)));
            shows_vibration(sensor.quantity) && is_whole && *rate > 2.0 * bands[mode][1]
        })
        .collect()
    };
    let in_first = usable(0);
    if !in_first.contains(&true) {
        return Err(unusable(sensors, &checked, &rates, bands[0][1]));
    }
    let first = vibration(readings, &in_first, bands[0])?;
    if !first.is_found() {
        return Err(not_enough(sensors, &first, bands[0]));
    }
    let in_second = usable(1);
    let second = match in_second.contains(&true) {
        true => vibration(readings, &in_second, bands[1]).ok(),
        false => None,
    };
    let found = [Some(first), second.filter(Vibration::is_found)];
    let phases = Phases::new(sensors, &found);
    for (checked, off) in checked.iter_mut().zip(&phases.off) {
        if let Some((fault, or)) = off {
            checked.faults.push(fault.clone());
            checked.or = or.iter().map(|it| sensors[*it].name.clone()).collect();
        }
    }
    let measured = [0, 1].map(|mode| {
        let vibration = found[mode].as_ref()?;
        Some(amplitudes(sensors, vibration, &phases, mode))
    });
    let comparison = Comparison::new(&candidates, sensors, &measured);
    let groups = comparison.explain();
    let believed: Vec<Suspicion> = groups.iter().filter_map(|it| it.first().cloned()).collect();
    note(sensors, &groups, &mut checked);
    let expected = comparison.expected(0, &believed);
    if let Some(first) = &found[0] {
        describe(sensors, first, phases.common[0], &expected, &mut checked);
    }
    let modes = (0..MODES).map(|mode| CheckedMode {
        declared: candidates.declared.modes[mode].frequency,
        band: bands[mode],
        found: found[mode].as_ref().map(|it| it.frequency),
    });
    Ok(SensorCheck {
        modes: modes.collect(),
        sensors: checked,
        supports: stiffness(&candidates, &comparison, &believed),
    })
}

fn vibration(
    readings: &Readings,
    usable: &[bool],
    band: [f64; 2],
) -> Result<Vibration, CheckError> {
    let ends = [readings.times.first(), readings.times.last()].map(|it| it.copied().unwrap_or(0.0));
    let short = || CheckError::Short {
        expected: 4.0 / band[0],
        found: ends[1] - ends[0],
    };
    let motion = Motion::new(readings, usable, band).ok_or_else(short)?;
    let secs = motion.secs;
    motion.strongest(band).ok_or(CheckError::Sparse { secs })
}

/// What a sensor shows without the others.
fn alone(sensor: &Sensor, index: usize, readings: &Readings) -> CheckedSensor {
    let values = of_sensor(readings, index, 0..readings.times.len());
    let mut faults = Vec::new();
    if values.len() < 2 {
        faults.push(SensorFault::NoReadings);
    } else if let Some((value, share)) = stuck(readings, index) {
        faults.push(SensorFault::Stuck(value, share));
    } else if let Some((value, share)) = saturated(sensor, &values) {
        faults.push(SensorFault::Saturated(value, share));
    }
    if let Some(found) = readings.rate_of(index)
        && (found / sensor.rate - 1.0).abs() > RATE_TOLERANCE
    {
        faults.push(SensorFault::Rate(found));
    }
    let untested = match shows_vibration(sensor.quantity) {
        true => None,
        false => Some("a vibration across the column does not show in it"),
    };
    CheckedSensor {
        name: sensor.name.clone(),
        amplitudes: None,
        faults,
        or: Vec::new(),
        untested,
    }
}

/// The readings of a sensor in these rows.
fn of_sensor(readings: &Readings, index: usize, rows: Range<usize>) -> Vec<f64> {
    rows.map(|row| readings.values[row * readings.sensors + index])
        .filter(|it| it.is_finite())
        .collect()
}

/// The value that a sensor repeats, and for which share of its readings. A column at rest gives equal readings, too, if their steps
/// are larger than the noise.
fn stuck(readings: &Readings, index: usize) -> Option<(f64, f64)> {
    let rows = readings.rows().enumerate();
    let values: Vec<(usize, f64)> = rows
        .map(|(row, (_, values))| (row, values[index]))
        .filter(|it| it.1.is_finite())
        .collect();
    let runs = values.chunk_by(|a, b| a.1 == b.1);
    let longest = runs.max_by_key(|run| run.len())?;
    let share = longest.len() as f64 / values.len() as f64;
    let is_whole = longest.len() == values.len();
    let is_long = longest.len() >= LEAST_STUCK && share >= STUCK_SHARE;
    let during = longest[0].0..longest[longest.len() - 1].0 + 1;
    let is_moving = |other: usize| {
        let all = spread(&of_sensor(readings, other, 0..readings.times.len()));
        all > 0.0 && spread(&of_sensor(readings, other, during.clone())) > MOVING_SHARE * all
    };
    let mut others = (0..readings.sensors).filter(|it| *it != index);
    let is_stuck = is_whole || is_long && others.any(is_moving);
    is_stuck.then_some((longest[0].1, share))
}

/// The difference between the largest and the smallest value.
fn spread(values: &[f64]) -> f64 {
    let ends = values
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], it| {
            [low.min(*it), high.max(*it)]
        });
    ends[1] - ends[0]
}

/// The end of the range at which a sensor clips, and for which share of its readings.
fn saturated(sensor: &Sensor, values: &[f64]) -> Option<(f64, f64)> {
    let stays = |is_end: &dyn Fn(f64) -> bool| {
        let runs = values.chunk_by(|a, b| is_end(*a) && is_end(*b));
        runs.map(|run| run.len())
            .filter(|it| *it > 1)
            .sum::<usize>()
    };
    let share = |count: usize| count as f64 / values.len() as f64;
    let clipped = share(stays(&|it| sensor.is_clipped(it)));
    if clipped > SATURATED_SHARE {
        return Some((sensor.range, clipped));
    }
    // A range that is smaller than the declared one shows by readings that are all equal to the largest one.
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let levels: Vec<&[f64]> = sorted.chunk_by(|a, b| a == b).collect();
    if levels.len() < LEAST_VALUES {
        return None;
    }
    let last = levels.len() - 1;
    let ends = [(levels[0], levels[1]), (levels[last], levels[last - 1])];
    let limits = ends.into_iter().filter_map(|(end, next)| {
        let count = stays(&|it| it == end[0]);
        let is_limit = count > 5 && count > LIMIT_OVER_NEXT * next.len();
        (is_limit && share(count) > SATURATED_SHARE).then_some((end[0].abs(), share(count)))
    });
    limits.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Why no sensor can be used.
fn unusable(
    sensors: &[Sensor],
    checked: &[CheckedSensor],
    rates: &[f64],
    highest: f64,
) -> CheckError {
    let is_wrong = |it: &CheckedSensor| {
        let mut faults = it.faults.iter();
        faults.any(|it| !matches!(it, SensorFault::Rate(_)))
    };
    let each = sensors.iter().zip(checked).zip(rates);
    let fit = each.filter(|((sensor, it), _)| shows_vibration(sensor.quantity) && !is_wrong(it));
    match fit.map(|(_, rate)| *rate).max_by(f64::total_cmp) {
        Some(found) => CheckError::Slow {
            expected: 2.0 * highest,
            found,
        },
        None => {
            let wrong = checked.iter().filter(|it| is_wrong(it));
            let names: Vec<&str> = wrong.map(|it| it.name.as_str()).collect();
            CheckError::NoReadings {
                found: names.join(", "),
            }
        }
    }
}

fn not_enough(sensors: &[Sensor], vibration: &Vibration, band: [f64; 2]) -> CheckError {
    let sensor = &sensors[vibration.reference];
    let (found, noise) =
        vibration.lines[vibration.reference].map_or((0.0, 0.0), |it| (it.amplitude, it.noise));
    CheckError::NotEnoughMotion {
        sensor: sensor.name.clone(),
        unit: sensor.quantity.unit(),
        expected: LEAST_OF_NOISE * noise,
        found,
        band,
    }
}

/// A ratio without the lags of the filters of the sensor and of the reference.
fn without_lags(ratio: [f64; 2], sensor: [f64; 2], reference: [f64; 2]) -> [f64; 2] {
    let lag = [
        sensor[0] * reference[0] + sensor[1] * reference[1],
        sensor[1] * reference[0] - sensor[0] * reference[1],
    ];
    [
        ratio[0] * lag[0] + ratio[1] * lag[1],
        ratio[1] * lag[0] - ratio[0] * lag[1],
    ]
}

/// What a sensor shows over what the reference shows, in and out of phase with this angle \[rad\], without the lags of their filters;
/// and whether it exceeds the noise so far that its own angle is known.
fn ratio(
    sensors: &[Sensor],
    vibration: &Vibration,
    index: usize,
    angle: f64,
) -> Option<([f64; 2], bool)> {
    let line = vibration.lines[index]?;
    let of = |it: usize| lag(&sensors[it], vibration.frequency);
    let [re, im] = without_lags(line.ratio, of(index), of(vibration.reference));
    let (sin, cos) = angle.sin_cos();
    let is_clear = re.hypot(im) > 2.0 * LEAST_OF_NOISE * line.ratio_noise;
    Some(([re * cos + im * sin, im * cos - re * sin], is_clear))
}

/// The amplitude of a sensor over that of the reference, with its sign by the common phase. A small delay does not change it.
fn amplitude(sensors: &[Sensor], vibration: &Vibration, index: usize, common: f64) -> Option<f64> {
    let ([re, im], is_clear) = ratio(sensors, vibration, index, common)?;
    Some(if is_clear {
        re.hypot(im).copysign(re)
    } else {
        re
    })
}

/// The phases of the sensors in all modes.
struct Phases {
    /// The angle that most sensors have to the reference, for each mode \[rad\].
    common: [f64; MODES],
    /// For each sensor that is out of phase in some mode: how far, and which ones may be wrong in its place.
    off: Vec<Option<(SensorFault, Vec<usize>)>>,
}

impl Phases {
    fn new(sensors: &[Sensor], found: &[Option<Vibration>; MODES]) -> Self {
        let angles = found.each_ref().map(|vibration| -> Vec<Option<f64>> {
            let angle = |index: usize| {
                let ([re, im], is_clear) = ratio(sensors, vibration.as_ref()?, index, 0.0)?;
                // A sign is no phase: the angle is that of an undirected line.
                is_clear.then(|| (im * re.signum()).atan2(re.abs()))
            };
            (0..sensors.len()).map(angle).collect()
        });
        let differs = |a: f64, b: f64| (a - b).sin().abs() > LEAST_SINE;
        let fault = |sensor: usize, other: usize| {
            let mut modes = found.iter().zip(&angles);
            modes.find_map(|(vibration, of)| {
                // Lines are at most a right angle apart.
                let off = (of[sensor]? - of[other]?).tan().atan();
                let frequency = vibration.as_ref()?.frequency;
                let delay = -off / (2.0 * std::f64::consts::PI * frequency);
                Some(SensorFault::OutOfPhase(off, delay))
            })
        };
        let mut phases = Self {
            common: [0.0; MODES],
            off: vec![None; sensors.len()],
        };
        for (mode, of) in angles.iter().enumerate() {
            let known: Vec<(usize, f64)> = (0..sensors.len())
                .filter(|it| phases.off[*it].is_none())
                .filter_map(|it| Some((it, of[it]?)))
                .collect();
            let differing = |angle: f64| -> Vec<usize> {
                let others = known.iter().filter(|it| differs(it.1, angle));
                others.map(|it| it.0).collect()
            };
            let agreed = known.iter().min_by_key(|it| differing(it.1).len());
            let Some(&(agreed, common)) = agreed else {
                continue;
            };
            phases.common[mode] = common;
            let is_majority = 2 * differing(common).len() < known.len();
            for &(sensor, angle) in &known {
                let others = differing(angle);
                let against = match is_majority {
                    true => differs(angle, common).then_some(agreed),
                    false => others.first().copied(),
                };
                let fault = against.and_then(|it| fault(sensor, it));
                let or = if is_majority { Vec::new() } else { others };
                phases.off[sensor] = fault.map(|it| (it, or));
            }
        }
        phases
    }
}

/// The amplitudes of the sensors that are in phase.
fn amplitudes(
    sensors: &[Sensor],
    vibration: &Vibration,
    phases: &Phases,
    mode: usize,
) -> MeasuredMode {
    let amplitudes = (0..sensors.len()).map(|index| {
        let line = vibration.lines[index].filter(|_| phases.off[index].is_none())?;
        Some(Amplitude {
            found: amplitude(sensors, vibration, index, phases.common[mode])?,
            noise: line.ratio_noise,
        })
    });
    MeasuredMode {
        amplitudes: amplitudes.collect(),
        frequency: vibration.frequency,
    }
}

/// Notes what contradicts the others.
fn note(sensors: &[Sensor], groups: &[Vec<Suspicion>], checked: &mut [CheckedSensor]) {
    for group in groups {
        for Suspicion {
            sensor,
            explanation,
        } in group
        {
            let mut named = vec![(*sensor, explanation.clone())];
            if let Explanation::Swapped(other) = explanation {
                named.push((*other, Explanation::Swapped(*sensor)));
            }
            for (at, explanation) in named {
                checked[at].faults.push(SensorFault::Explained(explanation));
                for other in group.iter().filter(|it| it.sensor != at) {
                    let is_swap = *sensor != at
                        || matches!(other.explanation, Explanation::Swapped(with) if with == at);
                    let name = &sensors[other.sensor].name;
                    if !is_swap && !checked[at].or.contains(name) {
                        checked[at].or.push(name.clone());
                    }
                }
            }
        }
    }
}

/// What each sensor should have shown, and which could not be compared.
fn describe(
    sensors: &[Sensor],
    first: &Vibration,
    common: f64,
    expected: &[f64],
    checked: &mut [CheckedSensor],
) {
    let reference = first.lines[first.reference].map_or(0.0, |it| it.amplitude);
    let compared = first.lines.iter().flatten().count();
    // Where no sensor can be believed, nothing is expected.
    let is_expected = expected.iter().any(|it| *it != 0.0);
    for (index, checked) in checked.iter_mut().enumerate() {
        let Some(line) = first.lines[index] else {
            if checked.untested.is_none() && checked.faults.is_empty() {
                checked.untested = Some("it has too few readings for the first frequency");
            }
            continue;
        };
        let found = amplitude(sensors, first, index, common).filter(|_| is_expected);
        checked.amplitudes = found.map(|found| [expected[index] * reference, found * reference]);
        let is_small = expected[index].abs() < LEAST_OF_NOISE * line.ratio_noise;
        if checked.faults.is_empty() {
            checked.untested = match compared {
                1 => Some("there is no other sensor to compare it with"),
                _ if is_small => Some("the vibration that it should show is below its noise"),
                _ => checked.untested,
            };
        }
    }
}
