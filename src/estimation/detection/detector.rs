//! Finds impacts in the readings of the sensors.
//!
//! Every sensor learns its zero and its noise while nothing happens. A reading far outside of the noise, and far from what it was
//! shortly before, opens a candidate, which is confirmed if the column is still displaced or strained to one side some
//! milliseconds later, or still shaken: a short pulse, as of a door that slams, leaves nothing behind, and a drift comes
//! slowly. Where another sensor would have to detect the impact, one has to.
//!
//! After an impact, the next one is sought as soon as the column is quiet.

use serde::{Deserialize, Serialize};

use crate::exact_number;
use crate::sensors::Sensor;

/// Standard deviations of the noise beyond which a reading opens a candidate.
const OPENING: f64 = 8.0;

/// Standard deviations of the noise that a candidate has to keep, as a root mean square, in each of its parts.
const KEEPING: f64 = 4.0;

/// Share of its first part that the last part of a candidate has to keep.
const KEEPING_SHARE: f64 = 0.1;

/// The same for a level that is confirmed early.
const EARLY_SHARE: f64 = 0.3;

/// Share of the root mean square of a part that its mean has to have: what swings to both sides is no level, nor is the end of a pulse.
const ONE_SIDED: f64 = 0.8;

/// Share of the window of a candidate that is its first part: pulses that are shorter leave nothing in the second.
const FIRST_PART: f64 = 0.6;

/// Time after which a sensor that reads a displacement, a strain or a force confirms a level that lasts \[s\].
const LEVEL_WINDOW: f64 = 10e-3;

/// Duration of a candidate of an accelerometer, and of a level that swings at first \[s\]: an accelerometer detects pulses that
/// do not move the column.
const SHAKING_WINDOW: f64 = 30e-3;

/// Sensors that read a level are averaged over this time before they are judged \[s\].
const AVERAGING: f64 = 1e-3;

/// Time constant with which zero and noise are learned \[s\].
const LEARNING: f64 = 1.0;

/// Samples before a sensor is judged.
const LEAST_SAMPLES: f64 = 20.0;

/// Readings after which the distance to the zero counts as noise, too: with fewer of them, the beginning of a slow impact would.
const SPREAD_SAMPLES: f64 = 500.0;

/// Judged readings that a level is compared with, the older half of them: it has to have risen since.
const RECENT: usize = 64;

/// A sensor that has been outside its noise for this long without an impact learns its zero again \[s\].
const RELEARNING: f64 = 2.0;

/// Onsets of one impact are at most so far apart \[s\].
const COMMON_IMPACT: f64 = 60e-3;

/// Sensors with fewer samples per second are not waited for \[Hz\].
pub(crate) const WITNESS_RATE: f64 = 200.0;

/// A sensor without a sample for so long, by the times of the others, is not waited for \[s\].
const ABSENCE: f64 = 0.5;

/// Share of its declared noise that a sensor has to show, for it to count that it detects nothing.
const WORKING_NOISE: f64 = 0.5;

/// Standard deviation of an instant of contact that one sample shows \[s\]: waves need some tenths of a millisecond from the
/// impact to the sensor.
const LEAST_DEVIATION: f64 = 0.2e-3;

/// Standard deviations of the noise within which a sample may belong to the column at rest.
const QUIET: f64 = 3.0;

/// The column is quiet after an impact if a sensor shows no more than [`QUIET`] times its noise before the impact for this
/// time \[s\].
const REST: f64 = 0.25;

/// After this time the column counts as quiet, and what the sensors show as their noise \[s\].
const MAX_UNREST: f64 = 30.0;

/// When a sensor first detected the impact.
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

/// Finds impacts in streams of readings, one after another.
#[derive(Debug, Clone)]
pub struct Detector {
    channels: Vec<Channel>,
    /// Whether there are sensors of something else than accelerations.
    has_levels: bool,
    /// What one sensor has confirmed, and others have yet to detect.
    pending: Option<Pending>,
    /// When the last impact was detected \[s\], until the column is quiet again.
    unrest_since: Option<f64>,
}

#[derive(Debug, Clone, Copy)]
struct Pending {
    sensor: usize,
    onset: Onset,
    confirmed_at: f64,
}

#[derive(Debug, Clone)]
struct Channel {
    is_level: bool,
    /// Whether every impact shows in it at once.
    is_witness: bool,
    declared_noise: f64,
    zero: f64,
    /// From the difference of neighbours.
    variance: f64,
    /// From the distance to the zero.
    spread: f64,
    samples: f64,
    /// The reading that was learned last.
    last: f64,
    /// Time of the last sample \[s\].
    last_time: f64,
    averaging: usize,
    group: Vec<(f64, f64)>,
    /// The last judged values of a level, a ring.
    recent: Vec<f64>,
    oldest: usize,
    candidate: Option<Candidate>,
    /// Last onset, confirmed or not.
    onset: Option<Onset>,
    /// When the first of the candidates opened that follow one another closely \[s\].
    outside_since: f64,
    /// When the last candidate ended \[s\].
    ended_at: f64,
    /// The samples that were averaged last.
    previous: Vec<(f64, f64)>,
    /// After an impact.
    rest: Option<Rest>,
}

/// Sums over the readings of one part of a candidate.
#[derive(Debug, Clone, Copy, Default)]
struct Part {
    count: f64,
    sum: f64,
    squares: f64,
}

#[derive(Debug, Clone)]
struct Candidate {
    opened_at: f64,
    /// Of a level: until 6 ms, until 10 ms, and from 18 ms on; of an accelerometer the first and the last.
    parts: [Part; 3],
    slope_known: bool,
    level_at_opening: f64,
    noise: f64,
}

/// How quiet a sensor is after an impact.
#[derive(Debug, Clone, Copy)]
struct Rest {
    /// Noise before the impact.
    noise: f64,
    /// Beginning of the current window \[s\], and its readings.
    start: f64,
    part: Part,
    /// The readings of the last complete window.
    last: Part,
    /// Whether it was quiet.
    is_quiet: bool,
}

impl Detector {
    /// For these sensors.
    #[must_use]
    pub fn new(sensors: &[Sensor]) -> Self {
        let channels: Vec<_> = sensors.iter().map(Channel::new).collect();
        Self {
            has_levels: channels.iter().any(|channel| channel.is_level),
            channels,
            pending: None,
            unrest_since: None,
        }
    }

    /// Takes a sample: the impact that is detected by then, if one is. Samples of one sensor are in the order of time; those of
    /// several may come in batches.
    pub fn push(&mut self, sensor: usize, time: f64, value: f64) -> Option<Detection> {
        let confirmed = self.channels[sensor].push(time, value);
        if let Some(since) = self.unrest_since {
            if self.is_at_rest(since, time) {
                self.unrest_since = None;
                self.channels.iter_mut().for_each(Channel::rearm);
            }
            return None;
        }
        if confirmed
            && self.pending.is_none()
            // An accelerometer alone may be shaken by anything; where other sensors exist, one of them has to confirm.
            && (self.channels[sensor].is_level || !self.has_levels)
            && let Some(onset) = self.channels[sensor].onset
        {
            self.pending = Some(Pending {
                sensor,
                onset,
                confirmed_at: time,
            });
        }
        let pending = self.pending?;
        match self.is_shared(&pending) {
            None => None,
            Some(is_impact) => {
                self.pending = None;
                is_impact.then(|| self.detected(&pending, time))
            }
        }
    }

    /// Whether a sensor that has to detect the impact has detected it, or there is none; `None` while one may still.
    fn is_shared(&self, pending: &Pending) -> Option<bool> {
        let Pending {
            sensor,
            onset,
            confirmed_at,
        } = *pending;
        let mut witnesses = 0;
        let mut may_follow = false;
        for (index, channel) in self.channels.iter().enumerate() {
            if index == sensor || !channel.is_witness {
                continue;
            }
            let is_common = |other: Onset| (other.time - onset.time).abs() <= COMMON_IMPACT;
            if channel.onset.is_some_and(is_common) {
                return Some(true);
            }
            if !channel.is_working() || channel.last_time < confirmed_at - ABSENCE {
                continue;
            }
            witnesses += 1;
            may_follow |= channel.last_time < onset.time + COMMON_IMPACT;
        }
        match (witnesses, may_follow) {
            (0, _) => Some(true),
            (_, true) => {
                // One that has stopped in the meantime does not hold up the others.
                let newest = self.newest();
                (newest > confirmed_at + ABSENCE).then_some(false)
            }
            (_, false) => Some(false),
        }
    }

    fn newest(&self) -> f64 {
        let times = self.channels.iter().map(|channel| channel.last_time);
        times.fold(f64::NEG_INFINITY, f64::max)
    }

    fn detected(&mut self, pending: &Pending, time: f64) -> Detection {
        let own = pending.onset;
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
        let zeros = self.channels.iter().map(Channel::zero).collect();
        self.unrest_since = Some(time);
        self.channels.iter_mut().for_each(Channel::disarm);
        Detection {
            contact,
            confirmed_at: time,
            sensor: pending.sensor,
            zeros,
        }
    }

    /// Whether every sensor that still sends is quiet after the impact that was detected at `since`.
    fn is_at_rest(&self, since: f64, now: f64) -> bool {
        if now - since > MAX_UNREST {
            return true;
        }
        let newest = self.newest();
        let mut present = self
            .channels
            .iter()
            .filter(|channel| channel.is_witness && channel.last_time >= newest - ABSENCE);
        present.all(|channel| channel.rest.is_none_or(|rest| rest.is_quiet))
            && self.channels.iter().any(|channel| channel.is_quiet())
    }
}

impl Part {
    fn add(&mut self, reading: f64) {
        self.count += 1.0;
        self.sum += reading;
        self.squares += reading * reading;
    }

    fn mean(&self) -> f64 {
        self.sum / self.count.max(1.0)
    }

    /// Root mean square.
    fn magnitude(&self) -> f64 {
        (self.squares / self.count.max(1.0)).sqrt()
    }

    fn deviation(&self) -> f64 {
        let mean = self.mean();
        let variance = self.squares / self.count.max(1.0) - mean * mean;
        variance.max(0.0).sqrt()
    }

    /// Whether it is a level far outside of the noise, of at least this share of another one.
    fn is_level(&self, noise: f64, share: f64, of: &Self) -> bool {
        let (mean, magnitude) = (self.mean().abs(), self.magnitude());
        magnitude > KEEPING * noise
            && mean >= ONE_SIDED * magnitude
            && mean > share * of.magnitude()
    }
}

impl Channel {
    fn new(sensor: &Sensor) -> Self {
        let is_level = sensor.quantity.is_level();
        let averaging = (AVERAGING * sensor.rate).round().max(1.0) as usize;
        Self {
            is_level,
            is_witness: sensor.quantity.shows_bending() && sensor.rate >= WITNESS_RATE,
            declared_noise: sensor.noise,
            zero: 0.0,
            variance: 0.0,
            spread: 0.0,
            samples: 0.0,
            last: 0.0,
            last_time: f64::NEG_INFINITY,
            averaging: if is_level { averaging } else { 1 },
            group: Vec::with_capacity(averaging),
            recent: Vec::with_capacity(if is_level { RECENT } else { 0 }),
            oldest: 0,
            candidate: None,
            onset: None,
            outside_since: f64::NEG_INFINITY,
            ended_at: f64::NEG_INFINITY,
            previous: Vec::with_capacity(averaging),
            rest: None,
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
        let is_known = self.samples >= SPREAD_SAMPLES;
        let spread = if is_known { self.spread } else { 0.0 };
        let learned = self.variance.max(spread).sqrt();
        learned.max(declared).max(f64::MIN_POSITIVE)
    }

    fn is_judged(&self) -> bool {
        self.samples >= LEAST_SAMPLES
    }

    /// Whether its silence says something: it is judged, and shows its noise, which a sensor that is stuck does not.
    fn is_working(&self) -> bool {
        let declared = WORKING_NOISE * self.declared_noise / (self.averaging as f64).sqrt();
        self.is_judged() && self.variance > declared * declared
    }

    /// Returns whether this sample confirms an impact.
    fn push(&mut self, time: f64, value: f64) -> bool {
        if !value.is_finite() {
            return false;
        }
        self.last_time = time;
        self.group.push((time, value));
        if self.group.len() < self.averaging {
            return false;
        }
        let count = self.group.len() as f64;
        let time = self.group.iter().map(|(time, _)| time).sum::<f64>() / count;
        let value = self.group.iter().map(|(_, value)| value).sum::<f64>() / count;
        let confirmed = match &mut self.rest {
            Some(rest) => {
                rest.push(time, value);
                false
            }
            None => self.judge(time, value),
        };
        std::mem::swap(&mut self.group, &mut self.previous);
        self.group.clear();
        confirmed
    }

    fn judge(&mut self, time: f64, value: f64) -> bool {
        let reading = value - self.zero;
        if self.candidate.is_some() {
            return self.follow(time, reading);
        }
        let noise = self.noise();
        let limit = OPENING * noise;
        if self.is_judged() && reading.abs() > limit && self.has_risen(value, limit) {
            // What follows a candidate closely is the same motion.
            let is_new = time - self.ended_at > SHAKING_WINDOW;
            if is_new {
                self.outside_since = time;
            } else if time - self.outside_since > RELEARNING {
                self.samples = 0.0;
                self.recent.clear();
                self.oldest = 0;
                self.learn(reading);
                return false;
            }
            let onset = self.departure(noise);
            self.onset = self.onset.filter(|_| !is_new).or(Some(onset));
            self.candidate = Some(Candidate {
                opened_at: time,
                parts: [Part::default(); 3],
                slope_known: false,
                level_at_opening: reading,
                noise,
            });
            return self.follow(time, reading);
        }
        if self.is_level {
            self.remember(value);
        }
        self.learn(reading);
        false
    }

    fn remember(&mut self, value: f64) {
        if self.recent.len() < RECENT {
            self.recent.push(value);
        } else {
            self.recent[self.oldest] = value;
            self.oldest = (self.oldest + 1) % RECENT;
        }
    }

    /// Whether a level differs by more than `limit` from what it was shortly before. A drift does not.
    fn has_risen(&self, value: f64, limit: f64) -> bool {
        if self.recent.len() < RECENT {
            return true;
        }
        const HALF: usize = RECENT / 2;
        let older = (0..HALF).map(|k| self.recent[(self.oldest + k) % RECENT]);
        let before = older.sum::<f64>() / HALF as f64;
        (value - before).abs() > limit
    }

    /// The middle between the last sample within the noise and the next one, among those averaged now and before. The instant may
    /// be anywhere between them, which matters where samples are missing.
    fn departure(&self, noise: f64) -> Onset {
        let limit = QUIET * noise * (self.averaging as f64).sqrt();
        let samples: Vec<_> = self.previous.iter().chain(&self.group).collect();
        let quiet = samples
            .iter()
            .rposition(|(_, value)| (value - self.zero).abs() <= limit);
        let (before, after) = match quiet.map(|index| (samples[index], samples.get(index + 1))) {
            Some((before, Some(after))) => (before.0, after.0),
            Some((before, None)) => (before.0, before.0),
            None => (samples[0].0, samples[0].0),
        };
        let least = LEAST_DEVIATION * if self.is_level { 2.0 } else { 1.0 };
        Onset {
            time: 0.5 * (before + after),
            // That of a uniform distribution.
            deviation: least.max((after - before) / 12.0_f64.sqrt()),
        }
    }

    fn follow(&mut self, time: f64, reading: f64) -> bool {
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
        let Some(is_impact) = (match is_level {
            true => candidate.judge_level(elapsed, reading),
            false => candidate.judge_shaking(elapsed, reading),
        }) else {
            return false;
        };
        self.candidate = None;
        self.ended_at = time;
        is_impact
    }

    fn learn(&mut self, reading: f64) {
        // A mean at first, and later one that forgets. A reading that begins to rise may not draw the zero after it.
        let limit = QUIET * self.noise();
        let reading = if self.is_judged() {
            reading.clamp(-limit, limit)
        } else {
            reading
        };
        let most = self.samples_per_learning();
        self.samples = (self.samples + 1.0).min(most);
        let share = 1.0 / self.samples;
        self.zero += share * reading;
        // A rise or a drift does not widen the difference of neighbours; slow vibrations widen only the distance to the zero.
        let difference = reading - self.last;
        self.last = reading;
        self.variance += share * (0.5 * difference * difference - self.variance);
        self.spread += share * (reading * reading - self.spread);
    }

    fn samples_per_learning(&self) -> f64 {
        // Judged readings in the time constant; at least a hundred.
        (LEARNING / AVERAGING).max(100.0) * if self.is_level { 1.0 } else { 10.0 }
    }

    /// An impact was detected: what is read from now on belongs to it.
    fn disarm(&mut self) {
        self.candidate = None;
        self.rest = Some(Rest {
            noise: self.noise(),
            start: f64::NEG_INFINITY,
            part: Part::default(),
            last: Part::default(),
            is_quiet: false,
        });
    }

    fn is_quiet(&self) -> bool {
        self.rest.is_some_and(|rest| rest.is_quiet)
    }

    /// The column is quiet: the next impact is sought from where this one has left the sensor.
    fn rearm(&mut self) {
        let Some(Rest { last, .. }) = self.rest.take() else {
            return;
        };
        self.onset = None;
        self.ended_at = f64::NEG_INFINITY;
        self.recent.clear();
        self.oldest = 0;
        if last.count < LEAST_SAMPLES {
            // A slow sensor learns again.
            self.samples = 0.0;
            return;
        }
        self.zero = last.mean();
        self.samples = last.count.min(self.samples_per_learning());
        let variance = last.deviation() * last.deviation();
        (self.variance, self.spread, self.last) = (variance, variance, 0.0);
    }
}

impl Candidate {
    /// Whether a level is an impact, as soon as that is known.
    fn judge_level(&mut self, elapsed: f64, reading: f64) -> Option<bool> {
        let [first, early, late] = &mut self.parts;
        if elapsed < FIRST_PART * LEVEL_WINDOW {
            first.add(reading);
        } else if elapsed < LEVEL_WINDOW {
            early.add(reading);
        } else if elapsed >= FIRST_PART * SHAKING_WINDOW {
            late.add(reading);
        }
        if elapsed >= SHAKING_WINDOW {
            return Some(late.is_level(self.noise, KEEPING_SHARE, first));
        }
        // A slow sensor has no sample in the early part.
        if elapsed < LEVEL_WINDOW || late.count > 0.0 || early.count == 0.0 {
            return None;
        }
        let least = KEEPING * self.noise;
        if first.magnitude() <= least || early.magnitude() <= least {
            return Some(false);
        }
        let is_early = early.is_level(self.noise, EARLY_SHARE, first);
        is_early.then_some(true)
    }

    /// Whether an accelerometer detects an impact, as soon as that is known.
    fn judge_shaking(&mut self, elapsed: f64, reading: f64) -> Option<bool> {
        let [first, _, last] = &mut self.parts;
        if elapsed < FIRST_PART * SHAKING_WINDOW {
            first.add(reading);
        } else {
            last.add(reading);
        }
        if elapsed < SHAKING_WINDOW {
            return None;
        }
        let (first, last) = (first.magnitude(), last.magnitude());
        let least = KEEPING * self.noise;
        Some(first > least && last > least && last > KEEPING_SHARE * first)
    }
}

impl Rest {
    fn push(&mut self, time: f64, value: f64) {
        if self.start == f64::NEG_INFINITY {
            self.start = time;
        }
        if time - self.start >= REST {
            self.start = time;
            self.last = std::mem::take(&mut self.part);
            self.is_quiet = self.last.deviation() <= QUIET * self.noise;
        }
        self.part.add(value);
    }
}
