//! Finds an impact in the readings of the sensors.
//!
//! Every sensor learns its zero and its noise while nothing happens. A reading far outside of the noise opens a candidate,
//! which is confirmed if the column is still displaced, strained or shaken some milliseconds later: a short pulse, as of a
//! door that slams, leaves nothing behind.

use serde::{Deserialize, Serialize};

use super::sensor::{Quantity, Sensor};
use crate::exact_number;

/// Standard deviations of the noise beyond which a reading opens a candidate.
const OPENING: f64 = 8.0;

/// Standard deviations of the noise that a candidate has to keep, as a root mean square, in each of its two parts.
const KEEPING: f64 = 4.0;

/// Share of its first part that the second part of a candidate has to keep.
const KEEPING_SHARE: f64 = 0.1;

/// Share of a candidate that is its first part: pulses that are shorter leave nothing in the second.
const FIRST_PART: f64 = 0.6;

/// Duration of a candidate of a sensor that reads a displacement, a strain or a force \[s\].
const LEVEL_WINDOW: f64 = 10e-3;

/// Duration of a candidate of an accelerometer \[s\]: longer, because it feels pulses that do not move the column.
const SHAKING_WINDOW: f64 = 30e-3;

/// Sensors that read a level are averaged over this time before they are judged \[s\].
const AVERAGING: f64 = 1e-3;

/// Time constant with which zero and noise are learned \[s\].
const LEARNING: f64 = 1.0;

/// Samples before a sensor is judged.
const LEAST_SAMPLES: f64 = 20.0;

/// An accelerometer's candidate gives the instant of contact if it opened at most so long before the confirmed one \[s\].
const COMMON_IMPACT: f64 = 60e-3;

/// Standard deviation of an instant of contact that one sample shows \[s\]: waves need some tenths of a millisecond from the
/// impact to the sensor.
const LEAST_DEVIATION: f64 = 0.2e-3;

/// Standard deviations of the noise within which a sample may belong to the column at rest.
const QUIET: f64 = 3.0;

/// When a sensor first felt the impact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Onset {
    /// Instant of contact by this sensor \[s\].
    #[serde(with = "exact_number")]
    pub time: f64,
    /// Its standard deviation \[s\].
    #[serde(with = "exact_number")]
    pub deviation: f64,
}

/// A detected impact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Detection {
    /// Instant of contact.
    pub contact: Onset,
    /// When it was confirmed: the data up to then were needed \[s\].
    #[serde(with = "exact_number")]
    pub confirmed_at: f64,
    /// Sensor that confirmed it.
    pub sensor: usize,
    /// Zero of each sensor at that time, with its standard deviation.
    #[serde(with = "exact_number::pairs")]
    pub zeros: Vec<(f64, f64)>,
}

/// Finds impacts in streams of readings.
#[derive(Debug, Clone)]
pub struct Detector {
    channels: Vec<Channel>,
}

#[derive(Debug, Clone)]
struct Channel {
    is_level: bool,
    declared_noise: f64,
    zero: f64,
    variance: f64,
    samples: f64,
    /// The reading that was learned last.
    last: f64,
    averaging: usize,
    group: Vec<(f64, f64)>,
    candidate: Option<Candidate>,
    /// Last onset, confirmed or not.
    onset: Option<Onset>,
    /// When the last candidate ended \[s\].
    ended_at: f64,
    /// The samples that were averaged last.
    previous: Vec<(f64, f64)>,
}

#[derive(Debug, Clone)]
struct Candidate {
    opened_at: f64,
    /// Of each part: number of readings, sum of their squares.
    parts: [[f64; 2]; 2],
    slope_known: bool,
    level_at_opening: f64,
    noise: f64,
}

impl Detector {
    /// For these sensors.
    #[must_use]
    pub fn new(sensors: &[Sensor]) -> Self {
        let channels = sensors.iter().map(Channel::new).collect();
        Self { channels }
    }

    /// Takes a sample: the impact that it confirms, if it does.
    pub fn push(&mut self, sensor: usize, time: f64, value: f64) -> Option<Detection> {
        let confirmed = self.channels[sensor].push(time, value);
        if !confirmed {
            return None;
        }
        // An accelerometer alone may be shaken by anything; where other sensors exist, one of them has to confirm.
        let others_exist = self.channels.iter().any(|channel| channel.is_level);
        if others_exist && !self.channels[sensor].is_level {
            return None;
        }
        let own = self.channels[sensor].onset?;
        let candidates = self.channels.iter().filter_map(|channel| channel.onset);
        let contact = candidates
            .filter(|onset| (own.time - onset.time).abs() <= COMMON_IMPACT)
            .fold(own, |best, onset| {
                if onset.deviation < best.deviation {
                    onset
                } else {
                    best
                }
            });
        let zeros = self.channels.iter().map(Channel::zero);
        Some(Detection {
            contact,
            confirmed_at: time,
            sensor,
            zeros: zeros.collect(),
        })
    }
}

impl Channel {
    fn new(sensor: &Sensor) -> Self {
        let is_level = sensor.quantity != Quantity::Acceleration;
        let averaging = (AVERAGING * sensor.rate).round().max(1.0) as usize;
        Self {
            is_level,
            declared_noise: sensor.noise,
            zero: 0.0,
            variance: 0.0,
            samples: 0.0,
            last: 0.0,
            averaging: if is_level { averaging } else { 1 },
            group: Vec::with_capacity(averaging),
            candidate: None,
            onset: None,
            ended_at: f64::NEG_INFINITY,
            previous: Vec::with_capacity(averaging),
        }
    }

    /// The zero with its standard deviation.
    fn zero(&self) -> (f64, f64) {
        let count = self.samples.max(1.0);
        (self.zero, self.noise() / count.sqrt())
    }

    /// Standard deviation of what is judged.
    fn noise(&self) -> f64 {
        let declared = self.declared_noise / (self.averaging as f64).sqrt();
        self.variance.sqrt().max(declared).max(f64::MIN_POSITIVE)
    }

    /// Returns whether this sample confirms an impact.
    fn push(&mut self, time: f64, value: f64) -> bool {
        if !value.is_finite() {
            return false;
        }
        self.group.push((time, value));
        if self.group.len() < self.averaging {
            return false;
        }
        let count = self.group.len() as f64;
        let time = self.group.iter().map(|(time, _)| time).sum::<f64>() / count;
        let value = self.group.iter().map(|(_, value)| value).sum::<f64>() / count;
        let confirmed = self.judge(time, value);
        std::mem::swap(&mut self.group, &mut self.previous);
        self.group.clear();
        confirmed
    }

    fn judge(&mut self, time: f64, value: f64) -> bool {
        let reading = value - self.zero;
        let noise = self.noise();
        if self.candidate.is_some() {
            return self.follow(time, reading);
        }
        if self.samples >= LEAST_SAMPLES && reading.abs() > OPENING * noise {
            // What follows a candidate closely is the same motion.
            let is_new = time - self.ended_at > SHAKING_WINDOW;
            let onset = Onset {
                time: self.departure(noise),
                deviation: if self.is_level {
                    2.0 * LEAST_DEVIATION
                } else {
                    LEAST_DEVIATION
                },
            };
            self.onset = self.onset.filter(|_| !is_new).or(Some(onset));
            self.candidate = Some(Candidate {
                opened_at: time,
                parts: [[0.0; 2]; 2],
                slope_known: false,
                level_at_opening: reading,
                noise,
            });
            return self.follow(time, reading);
        }
        self.learn(reading);
        false
    }

    /// The middle between the last sample within the noise and the next one, among those averaged now and before.
    fn departure(&self, noise: f64) -> f64 {
        let limit = QUIET * noise * (self.averaging as f64).sqrt();
        let samples: Vec<_> = self.previous.iter().chain(&self.group).collect();
        let quiet = samples
            .iter()
            .rposition(|(_, value)| (value - self.zero).abs() <= limit);
        match quiet.map(|index| (samples[index], samples.get(index + 1))) {
            Some((before, Some(after))) => 0.5 * (before.0 + after.0),
            Some((before, None)) => before.0,
            None => samples[0].0,
        }
    }

    fn follow(&mut self, time: f64, reading: f64) -> bool {
        let window = if self.is_level {
            LEVEL_WINDOW
        } else {
            SHAKING_WINDOW
        };
        let (is_level, Some(candidate)) = (self.is_level, &mut self.candidate) else {
            return false;
        };
        let elapsed = time - candidate.opened_at;
        // A level that rises slowly left its zero earlier, along a straight line.
        if is_level
            && !candidate.slope_known
            && reading.abs() >= 2.0 * candidate.level_at_opening.abs()
        {
            candidate.slope_known = true;
            let rise = elapsed * candidate.level_at_opening.abs()
                / (reading.abs() - candidate.level_at_opening.abs());
            if let Some(onset) = &mut self.onset {
                let along_the_line = candidate.opened_at - rise;
                if along_the_line < onset.time - AVERAGING {
                    onset.time = along_the_line;
                    onset.deviation = onset.deviation.max(0.3 * rise);
                }
            }
        }
        let part = usize::from(elapsed >= FIRST_PART * window);
        let sums = &mut candidate.parts[part];
        sums[0] += 1.0;
        sums[1] += reading * reading;
        if elapsed < window {
            return false;
        }
        let [first, second] = candidate
            .parts
            .map(|[count, squares]| (squares / f64::max(count, 1.0)).sqrt());
        let least = KEEPING * candidate.noise;
        let kept = first > least && second > least && second > KEEPING_SHARE * first;
        self.candidate = None;
        self.ended_at = time;
        kept
    }

    fn learn(&mut self, reading: f64) {
        // A mean at first, and later one that forgets. A reading that begins to rise may not draw the zero after it.
        let limit = QUIET * self.noise();
        let reading = if self.samples < LEAST_SAMPLES {
            reading
        } else {
            reading.clamp(-limit, limit)
        };
        let most = self.samples_per_learning();
        self.samples = (self.samples + 1.0).min(most);
        let share = 1.0 / self.samples;
        self.zero += share * reading;
        // From the difference of neighbours, which a rise or a drift does not widen.
        let difference = reading - self.last;
        self.last = reading;
        self.variance += share * (0.5 * difference * difference - self.variance);
    }

    fn samples_per_learning(&self) -> f64 {
        // Judged readings in the time constant; at least a hundred.
        (LEARNING / AVERAGING).max(100.0) * if self.is_level { 1.0 } else { 10.0 }
    }
}
