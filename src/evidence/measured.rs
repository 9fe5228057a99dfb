//! The recorded measurements as the numbered batches that the estimator of the node was given.

use std::collections::VecDeque;

use super::comparison::{Difference, Place};
use super::verification::Verification;
use crate::estimation::{Batch, Intake, IntakeState};
use crate::incoming::raw_batch;
use crate::messages::cdr::CdrError;
use crate::messages::column_twin_msgs::Measurement;
use crate::sensors::Sensor;
use crate::time::Nanos;

/// Most batches that are kept. An estimate rests on those of half a second, and of the second before the impact was detected;
/// the queue of the node holds 8192 that it has not taken yet.
const MAX_BATCHES: usize = 1 << 16;

/// Most samples in them, 64 MB: 100 s of 16 sensors at 10 kHz.
const MAX_SAMPLES: usize = 1 << 24;

/// Before the first checkpoint.
const NO_CHECKPOINT: &str = "the journal does not state the first measurement that it counts";

/// What follows from a message that cannot be read.
pub(super) const UNREADABLE: &str = "a message on measurements cannot be read";

/// The journal tells of no sensors.
const NO_SENSORS: &str = "the recording has no measurements";

/// Passes recorded measurements through the same intake as the node.
#[derive(Debug)]
pub(super) struct Measured {
    /// As that of the node was; otherwise, why that is not known.
    intake: Result<Intake, &'static str>,
    batches: VecDeque<Batch>,
    samples: usize,
    /// Number of the first of the batches.
    first: u64,
    /// Time for which they are kept \[ns\].
    kept_for: Nanos,
}

impl Default for Measured {
    fn default() -> Self {
        Self {
            intake: Err(NO_CHECKPOINT),
            batches: VecDeque::new(),
            samples: 0,
            first: 0,
            kept_for: Nanos::MAX,
        }
    }
}

impl Measured {
    /// None, which will be kept for this time \[ns\].
    pub fn kept_for(kept_for: Nanos) -> Self {
        Self {
            kept_for,
            ..Self::default()
        }
    }

    /// Takes a recorded message that arrived at `received`, by the clock of the twin.
    pub fn message(
        &mut self,
        message: &Result<Measurement, CdrError>,
        received: Nanos,
        place: &Place<'_>,
        found: &mut Verification,
    ) {
        let measurement = match message {
            Ok(measurement) => measurement,
            Err(error) => {
                self.lose(UNREADABLE);
                return found.note_difference(place.unreadable(&error));
            }
        };
        let Ok(intake) = &mut self.intake else {
            return;
        };
        // The node records what it does not take, too, if the batches that follow depend on it.
        if let Ok(batch) = intake.take(&raw_batch(measurement), received) {
            self.samples += batch.values.len();
            let oldest = batch.end().saturating_sub(self.kept_for);
            self.batches.push_back(batch);
            let is_old = |it: &Batch| it.end() < oldest;
            while self.samples > MAX_SAMPLES
                || self.batches.len() > MAX_BATCHES
                || self.batches.front().is_some_and(is_old)
            {
                let oldest = self.batches.pop_front();
                self.samples -= oldest.map_or(0, |it| it.values.len());
                self.first = self.first.saturating_add(1);
            }
        }
    }

    /// Takes what a line tells of the intake of the node, whose sensors are these and whose column has this identifier.
    pub fn line(
        &mut self,
        state: Option<&IntakeState>,
        (sensors, column_id): (&[Sensor], &str),
        place: &Place<'_>,
        found: &mut Verification,
    ) {
        let Some(state) = state else {
            return self.lose(NO_SENSORS);
        };
        if let Ok(own) = &self.intake {
            if !own.sensors().eq(sensors) {
                let words = |count| format!("{count} sensors");
                let own = format!("{} other ones", words(own.sensors().count()));
                found.note_difference(place.difference("sensors", words(sensors.len()), own));
            }
            let Some(difference) = place.first_difference(state, &own.state()) else {
                return;
            };
            found.note_difference(Difference {
                field: format!("intake.{}", difference.field),
                ..difference
            });
        }
        self.lose(NO_CHECKPOINT);
        let mut intake = Intake::new(sensors, column_id);
        if intake.resume(state) {
            self.first = state.batches();
            self.intake = Ok(intake);
        } else {
            let expected = format!("{} sensors", sensors.len());
            found.note_difference(place.difference(
                "intake",
                "another number of sensors",
                expected,
            ));
        }
    }

    /// From here on it is not known which measurements the node took, for this reason, until the next checkpoint.
    pub fn lose(&mut self, why: &'static str) {
        self.intake = Err(why);
        self.batches.clear();
        self.samples = 0;
    }

    /// Why it is not known which measurements the node took.
    pub fn unknown(&self) -> Option<&'static str> {
        self.intake.as_ref().err().copied()
    }

    /// The batch with this number, counted from the first one of the program; `None` if it is not known.
    pub fn batch(&self, number: u64) -> Option<&Batch> {
        let index = number.checked_sub(self.first)?;
        self.batches.get(usize::try_from(index).ok()?)
    }

    /// The number of the next batch.
    pub fn next(&self) -> u64 {
        self.first.saturating_add(self.batches.len() as u64)
    }
}
