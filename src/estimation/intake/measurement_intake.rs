//! Takes the measurements of all sensors: checks every batch, brings it into the order and the clock of the twin, and counts
//! what is missing.
//!
//! The same sequence of batches with the same times of arrival gives the same result, so that a recording can be followed. Rules:
//! - A batch that follows the one before within [`MAX_JITTER`] continues it. Its times are smoothed if they are off by more than
//!   half a sample.
//! - Samples between two batches that did not arrive are counted as lost; after [`SILENCE`] the sensor was interrupted instead.
//! - Samples that arrive again, or after later ones, are dropped and counted.
//! - A batch that is ahead of the sensor's clock by more than [`MAX_CLOCK_ERROR`], or out of order and as far behind, is doubted: it
//!   is dropped, until [`BELIEVED`] in a row follow one another. Then the clock was set, and the sensor starts again.
//! - A clock that differs from the twin's by more than [`TOLERATED_OFFSET`](super::TOLERATED_OFFSET) is corrected.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::estimation::intake::batch::Batch;
use crate::estimation::intake::sensor_clock::SensorClock;
use crate::estimation::intake::stillness::Stillness;
use crate::sensors::Sensor;
use crate::time::{INVALID_STAMP, INVALID_STAMP_REASON, Nanos};

/// Most samples of one batch.
pub const MAX_BATCH_SAMPLES: usize = 65_536;

/// Share by which the period of the samples may differ from that of the sensor's parameters.
pub const PERIOD_TOLERANCE: f64 = 0.01;

/// Most by which the time of a batch may be off from where the batches before it lead to, for it to continue them \[ns\]; at most half of its duration, and at least half
/// a sample.
pub const MAX_JITTER: u64 = 1_000_000;

/// Most by which a batch may be ahead of its sensor's clock, or late, before its time is doubted \[ns\].
pub const MAX_CLOCK_ERROR: Nanos = 500_000_000;

/// Batches with a doubted time that are believed if they follow one another.
pub const BELIEVED: u32 = 3;

/// Time without a reading after which a sensor is dead \[ns\], or three times the duration of its last batch, if that is longer.
pub const SILENCE: u64 = 1_000_000_000;

/// Share of its error by which the time of a batch that is off is corrected.
const JITTER_SHARE: i64 = 8;

/// Batches whose times are remembered, to tell one that arrives twice from one that is late.
const REMEMBERED: usize = 64;

/// After this time a stamp of 0 says that the sender sets none \[ns\]; simulated time may begin at 0.
const EARLIEST: Nanos = 10_000_000_000;

/// Most characters of a name from outside that a reason shows.
const MAX_SHOWN_CHARS: usize = 64;

/// A batch as its sender describes it.
#[derive(Debug, Clone, Copy)]
pub struct RawBatch<'a> {
    /// Identifier of the column.
    pub column_id: &'a str,
    /// Name of the sensor.
    pub sensor_id: &'a str,
    /// Time of the first sample, by the clock of the sender \[ns\].
    pub stamp: Nanos,
    /// Time between two samples \[s\].
    pub sample_period: f64,
    /// The samples.
    pub values: &'a [f32],
}

/// Why a batch was not taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BatchRejection {
    /// It is for another column.
    #[error("it is for column {found:?}, but this is the twin of column {own:?}")]
    OtherColumn {
        /// The column in the batch.
        found: String,
        /// The column of the twin.
        own: String,
    },
    /// No sensor has this name.
    #[error("no sensor is called {found:?}; sensors.names contains {known}")]
    UnknownSensor {
        /// The name in the batch.
        found: String,
        /// The sensors.
        known: String,
    },
    /// It has no samples.
    #[error("it has no samples; expected 1 to {MAX_BATCH_SAMPLES}")]
    Empty,
    /// It has too many samples.
    #[error("it has {found} samples; expected at most {MAX_BATCH_SAMPLES}: send shorter batches")]
    TooLong {
        /// Number of samples.
        found: usize,
    },
    /// Its period is not that of the sensor.
    #[error(
        "its sample_period is {found} s, but sensors.{sensor}.rate is {rate} Hz, of which the period is {} s; correct one of \
         them",
        1.0 / .rate
    )]
    Period {
        /// Name of the sensor.
        sensor: String,
        /// The period in the batch \[s\].
        found: f64,
        /// The rate in the parameters \[Hz\].
        rate: f64,
    },
    /// Its sender sets no stamp.
    #[error("its stamp is 0; set header.stamp to the time of the first sample")]
    NoStamp,
    /// Its stamp is no time.
    #[error("{INVALID_STAMP_REASON}")]
    InvalidStamp,
    /// It arrived before.
    #[error("a batch with its time arrived before")]
    Duplicate,
    /// A later one arrived before it.
    #[error("it ends {} s before the next sample that is expected", seconds(*behind))]
    Late {
        /// How far \[ns\].
        behind: u64,
    },
    /// Its time contradicts the sensor's clock.
    #[error(
        "its time is {} s off the clock of its sensor; it is taken after {BELIEVED} in a row that follow one another",
        seconds(*by)
    )]
    Doubted {
        /// How far \[ns\].
        by: u64,
    },
}

impl BatchRejection {
    /// Whether it follows from the batches before, and what is taken next may follow from it: a recording of what was taken
    /// needs such a batch, too.
    #[must_use]
    pub fn depends_on_order(&self) -> bool {
        matches!(
            self,
            Self::Duplicate | Self::Late { .. } | Self::Doubted { .. }
        )
    }
}

fn seconds(nanos: u64) -> f64 {
    1e-9 * nanos as f64
}

/// What was counted of one sensor since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SensorCounts {
    /// Batches that were taken.
    pub batches: u64,
    /// Samples in them.
    pub samples: u64,
    /// Samples in them that are no numbers.
    pub missing: u64,
    /// Samples at the end of the sensor's range, or beyond.
    pub saturated: u64,
    /// Samples that did not arrive, by the times of the batches around them.
    pub lost: u64,
    /// Pauses of the sensor.
    pub interruptions: u64,
    /// Samples that arrived before.
    pub duplicates: u64,
    /// Samples that arrived after later ones, and were dropped.
    pub late: u64,
    /// Samples with a doubted time, which were dropped.
    pub doubted: u64,
    /// How often the sensor's clock, or the twin's, was set.
    pub clock_jumps: u64,
    /// Batches with another fault, which were dropped.
    pub rejected: u64,
}

/// How a sensor is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorCondition {
    /// Nothing of it was taken yet.
    Waiting,
    /// It sends readings.
    Alive,
    /// It repeats one value for longer than its noise allows.
    Stuck,
    /// No reading of it has arrived for so long \[ns\].
    Dead(u64),
}

/// The health of one sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorHealth {
    /// Its name.
    pub name: Arc<str>,
    /// How it is.
    pub condition: SensorCondition,
    /// What was counted.
    pub counts: SensorCounts,
    /// How much its clock is behind the twin's, with the shortest time of transport \[ns\].
    pub clock_offset: Nanos,
    /// What is added to its times \[ns\]; 0: nothing.
    pub clock_correction: Nanos,
    /// Why the last batch that was rejected was.
    pub last_rejection: Option<BatchRejection>,
}

/// Batches that belong to no sensor, since the start.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Strays {
    /// For another column, which is no fault.
    pub other_column: u64,
    /// Of no sensor in the parameters.
    pub unknown_sensor: u64,
    /// Why the last one of an unknown sensor was rejected.
    pub last: Option<BatchRejection>,
}

/// Everything on which it depends how the next batches are taken: with it, an intake goes on where another one was.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IntakeState {
    /// One for each sensor, in the order of the parameters.
    channels: Vec<ChannelState>,
}

impl IntakeState {
    /// Batches that were taken since the start, of all sensors.
    #[must_use]
    pub fn batches(&self) -> u64 {
        let each = self.channels.iter().map(|it| it.batches);
        each.fold(0, u64::saturating_add)
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ChannelState {
    batches: u64,
    next: Option<Nanos>,
    clock: SensorClock,
    doubted: Option<Doubted>,
    /// The times of the last batches, the oldest first.
    remembered: Vec<Nanos>,
    last_received: Option<Nanos>,
}

/// The measurements of all sensors of one column.
#[derive(Debug, Clone)]
pub struct Intake {
    column_id: Arc<str>,
    channels: Vec<Channel>,
    strays: Strays,
}

impl Intake {
    /// For these sensors on the column with this identifier.
    #[must_use]
    pub fn new(sensors: &[Sensor], column_id: &str) -> Self {
        Self {
            column_id: column_id.into(),
            channels: sensors.iter().map(Channel::new).collect(),
            strays: Strays::default(),
        }
    }

    /// Takes a batch that arrived at `received`, by the clock that drives the twin. What is left of it is in the order and the
    /// clock of the twin, with the signs of the model.
    ///
    /// # Errors
    /// Why nothing of it is taken; it was counted.
    pub fn take(&mut self, raw: &RawBatch<'_>, received: Nanos) -> Result<Batch, BatchRejection> {
        if raw.column_id != &*self.column_id {
            self.strays.other_column += 1;
            return Err(BatchRejection::OtherColumn {
                found: shown(raw.column_id),
                own: self.column_id.to_string(),
            });
        }
        let mut channels = self.channels.iter_mut().zip(0..);
        let Some((channel, sensor)) = channels.find(|(it, _)| *it.sensor.name == *raw.sensor_id)
        else {
            return Err(self.unknown(raw.sensor_id));
        };
        let taken = channel.take(raw, received);
        channel.count_rejection(raw, taken.as_ref().err());
        taken.map(|it| Batch {
            sensor,
            first: it.first,
            period: it.period,
            values: it.values,
        })
    }

    fn unknown(&mut self, found: &str) -> BatchRejection {
        let known: Vec<&str> = self.channels.iter().map(|it| &*it.sensor.name).collect();
        let rejection = BatchRejection::UnknownSensor {
            found: shown(found),
            known: match &known[..] {
                [] => "none".to_owned(),
                known => known.join(", "),
            },
        };
        self.strays.unknown_sensor += 1;
        self.strays.last = Some(rejection.clone());
        rejection
    }

    /// The sensors, in the order of the parameters.
    pub fn sensors(&self) -> impl Iterator<Item = &Sensor> {
        self.channels.iter().map(|it| &it.sensor)
    }

    /// What the next batches depend on.
    #[must_use]
    pub fn state(&self) -> IntakeState {
        let channels = self.channels.iter().map(Channel::state).collect();
        IntakeState { channels }
    }

    /// Goes on where the intake of the same sensors was that had this state; `false` if it has another number of sensors. What
    /// was counted is not known then, but for the batches.
    pub fn resume(&mut self, state: &IntakeState) -> bool {
        let fits = state.channels.len() == self.channels.len();
        if fits {
            let channels = self.channels.iter_mut().zip(&state.channels);
            channels.for_each(|(channel, state)| channel.resume(state));
        }
        fits
    }

    /// The health of every sensor at `now`, in the order of the parameters.
    #[must_use]
    pub fn health(&self, now: Nanos) -> Vec<SensorHealth> {
        self.channels.iter().map(|it| it.health(now)).collect()
    }

    /// Batches that belong to no sensor.
    #[must_use]
    pub fn strays(&self) -> &Strays {
        &self.strays
    }
}

fn shown(name: &str) -> String {
    name.chars().take(MAX_SHOWN_CHARS).collect()
}

/// What was taken of a batch.
struct Taken {
    first: Nanos,
    period: u64,
    values: Arc<[f32]>,
}

/// A row of doubted batches that follow one another.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Doubted {
    next: Nanos,
    count: u32,
}

/// How a batch fits to the one before.
enum Fit {
    /// It is the first one, or the first one of a clock that was set.
    Begins,
    /// It continues the one before, with its first sample at this time by the sensor's clock.
    Continues(Nanos),
    /// This many samples are missing between the two.
    Follows { lost: u64 },
    /// So many of its samples arrived before.
    Overlaps(usize),
}

#[derive(Debug, Clone)]
struct Channel {
    sensor: Sensor,
    /// When the next sample is expected, by the sensor's clock; `None` before the first batch.
    next: Option<Nanos>,
    clock: SensorClock,
    doubted: Option<Doubted>,
    /// Times of the last batches, a ring.
    remembered: [Nanos; REMEMBERED],
    /// When the last batch was taken that contained a number, and the duration of that batch.
    last_reading: Option<(Nanos, u64)>,
    /// When the last batch arrived.
    last_received: Option<Nanos>,
    stillness: Stillness,
    counts: SensorCounts,
    last_rejection: Option<BatchRejection>,
}

impl Channel {
    fn new(sensor: &Sensor) -> Self {
        Self {
            sensor: sensor.clone(),
            next: None,
            clock: SensorClock::default(),
            doubted: None,
            remembered: [Nanos::MIN; REMEMBERED],
            last_reading: None,
            last_received: None,
            stillness: Stillness::default(),
            counts: SensorCounts::default(),
            last_rejection: None,
        }
    }

    fn state(&self) -> ChannelState {
        let oldest = (self.counts.batches % REMEMBERED as u64) as usize;
        let (newer, older) = self.remembered.split_at(oldest);
        let is_known = |time: &Nanos| *time != Nanos::MIN;
        let remembered = older.iter().chain(newer).copied().filter(is_known);
        ChannelState {
            batches: self.counts.batches,
            next: self.next,
            clock: self.clock.clone(),
            doubted: self.doubted,
            remembered: remembered.collect(),
            last_received: self.last_received,
        }
    }

    fn resume(&mut self, state: &ChannelState) {
        *self = Self::new(&self.sensor);
        // Whatever a file says, there is room to count on.
        self.counts.batches = state.batches.min(u64::MAX / 2);
        self.next = state.next;
        self.clock = state.clock.clone();
        self.doubted = state.doubted.map(|it| Doubted {
            count: it.count.min(BELIEVED),
            ..it
        });
        self.last_received = state.last_received;
        let newest_first = state.remembered.iter().rev().take(REMEMBERED);
        for (age, time) in (1_u64..).zip(newest_first) {
            // Before the slot of the next batch, around the ring.
            let slot = state.batches.wrapping_sub(age) % REMEMBERED as u64;
            self.remembered[slot as usize] = *time;
        }
    }

    fn take(&mut self, raw: &RawBatch<'_>, received: Nanos) -> Result<Taken, BatchRejection> {
        let count = raw.values.len();
        if count == 0 {
            return Err(BatchRejection::Empty);
        }
        if count > MAX_BATCH_SAMPLES {
            return Err(BatchRejection::TooLong { found: count });
        }
        let deviation = (raw.sample_period * self.sensor.rate - 1.0).abs();
        if deviation.is_nan() || deviation > PERIOD_TOLERANCE {
            return Err(BatchRejection::Period {
                sensor: self.sensor.name.clone(),
                found: raw.sample_period,
                rate: self.sensor.rate,
            });
        }
        if raw.stamp == INVALID_STAMP {
            return Err(BatchRejection::InvalidStamp);
        }
        if raw.stamp == 0 && received > EARLIEST {
            return Err(BatchRejection::NoStamp);
        }
        let period = ((1e9 * raw.sample_period).round() as u64).max(1);
        let duration = period.saturating_mul(count as u64);
        let last_received = self.last_received.replace(received);
        if last_received.is_some_and(|last| last.saturating_sub(received) > MAX_CLOCK_ERROR) {
            // The twin's clock was set back.
            self.begin_anew();
        }
        let fit = self.fit(raw.stamp, period, duration, received)?;
        let (stamp, skipped) = match fit {
            Fit::Begins | Fit::Follows { .. } => (raw.stamp, 0),
            Fit::Continues(stamp) => (stamp, 0),
            Fit::Overlaps(skipped) => (after(raw.stamp, period * skipped as u64), skipped),
        };
        match fit {
            Fit::Follows { lost } if lost.saturating_mul(period) > SILENCE => {
                self.counts.interruptions += 1;
                self.stillness.interrupt();
            }
            Fit::Follows { lost } => self.counts.lost += lost,
            Fit::Overlaps(skipped) => self.counts.duplicates += skipped as u64,
            Fit::Begins | Fit::Continues(_) => {}
        }
        self.doubted = None;
        let slot = self.counts.batches % REMEMBERED as u64;
        self.remembered[slot as usize] = raw.stamp;
        let rest = &raw.values[skipped..];
        let end = after(stamp, period.saturating_mul(rest.len() as u64));
        self.next = Some(end);
        let correction = self.clock.correct(end, received);
        let (values, has_numbers) = self.values(rest);
        if has_numbers {
            self.last_reading = Some((received, duration));
        }
        self.counts.batches += 1;
        self.counts.samples += rest.len() as u64;
        Ok(Taken {
            first: stamp.saturating_add(correction),
            period,
            values,
        })
    }

    /// # Errors
    /// It arrived before, after later ones, or with a doubted time.
    fn fit(
        &mut self,
        stamp: Nanos,
        period: u64,
        duration: u64,
        received: Nanos,
    ) -> Result<Fit, BatchRejection> {
        let Some(next) = self.next else {
            return Ok(Fit::Begins);
        };
        let off = stamp.saturating_sub(next);
        let (by, half) = (off.unsigned_abs(), period / 2);
        let tolerance = (duration / 2).min(MAX_JITTER).max(half);
        if by <= tolerance {
            let smoothed = next.saturating_add(off / JITTER_SHARE);
            return Ok(Fit::Continues(if by <= half { stamp } else { smoothed }));
        }
        // How long after the fastest batch this one arrives: negative if its time has not come.
        let end = after(stamp, duration);
        let delay = received.saturating_sub(end);
        let lag = delay.saturating_sub(self.clock.offset());
        if off > 0 {
            if lag >= -MAX_CLOCK_ERROR {
                let lost = by.saturating_add(half) / period;
                return Ok(Fit::Follows { lost });
            }
        } else if self.remembered.contains(&stamp) {
            return Err(BatchRejection::Duplicate);
        } else if end > after(next, half) {
            let skipped = by.saturating_add(half) / period;
            // At least the last sample is new.
            let most = duration / period - 1;
            return Ok(Fit::Overlaps(skipped.min(most) as usize));
        } else if lag < MAX_CLOCK_ERROR {
            let behind = next.saturating_sub(end).unsigned_abs();
            return Err(BatchRejection::Late { behind });
        }
        let follows = |it: &Doubted| stamp.saturating_sub(it.next).unsigned_abs() <= tolerance;
        let before = self.doubted.filter(follows).map_or(0, |it| it.count);
        if before + 1 >= BELIEVED {
            self.begin_anew();
            return Ok(Fit::Begins);
        }
        self.doubted = Some(Doubted {
            next: end,
            count: before + 1,
        });
        Err(BatchRejection::Doubted {
            by: lag.unsigned_abs(),
        })
    }

    /// Forgets the clock and the order of the batches so far.
    fn begin_anew(&mut self) {
        self.counts.clock_jumps += 1;
        self.clock = SensorClock::default();
        self.next = None;
        self.doubted = None;
        self.remembered = [Nanos::MIN; REMEMBERED];
        self.stillness.interrupt();
    }

    /// The samples with the signs of the model, NaN where they are no numbers, and whether there is one that is.
    fn values(&mut self, values: &[f32]) -> (Arc<[f32]>, bool) {
        let sign = if self.sensor.reversed { -1.0 } else { 1.0 };
        let mut numbers = 0;
        let each = values.iter().map(|&value| {
            if !value.is_finite() {
                self.counts.missing += 1;
                self.stillness.interrupt();
                return f32::NAN;
            }
            numbers += 1;
            if self.sensor.is_clipped(f64::from(value)) {
                self.counts.saturated += 1;
                self.stillness.interrupt();
            } else {
                self.stillness.push(value);
            }
            sign * value
        });
        (each.collect(), numbers > 0)
    }

    fn count_rejection(&mut self, raw: &RawBatch<'_>, rejection: Option<&BatchRejection>) {
        let Some(rejection) = rejection else { return };
        let samples = raw.values.len() as u64;
        match rejection {
            BatchRejection::Duplicate => self.counts.duplicates += samples,
            BatchRejection::Late { .. } => self.counts.late += samples,
            BatchRejection::Doubted { .. } => self.counts.doubted += samples,
            _ => self.counts.rejected += 1,
        }
        self.last_rejection = Some(rejection.clone());
    }

    fn health(&self, now: Nanos) -> SensorHealth {
        let condition = match self.last_reading {
            None => SensorCondition::Waiting,
            Some((received, duration)) => {
                let silent = u64::try_from(now.saturating_sub(received)).unwrap_or(0);
                if silent > SILENCE.max(duration.saturating_mul(3)) {
                    SensorCondition::Dead(silent)
                } else if self.sensor.noise > 0.0 && self.stillness.is_stuck() {
                    SensorCondition::Stuck
                } else {
                    SensorCondition::Alive
                }
            }
        };
        SensorHealth {
            name: self.sensor.name.as_str().into(),
            condition,
            counts: self.counts,
            clock_offset: self.clock.offset(),
            clock_correction: self.clock.correction(),
            last_rejection: self.last_rejection.clone(),
        }
    }
}

/// A time that is later by a duration \[ns\].
fn after(time: Nanos, duration: u64) -> Nanos {
    time.saturating_add_unsigned(duration)
}

#[cfg(test)]
#[path = "measurement_intake_tests.rs"]
mod tests;
