//! The recorded measurements as the numbered batches that the estimator of the node was given.

use std::collections::VecDeque;

use super::comparison::{Difference, Place};
use super::verification::Verification;
use crate::incoming::raw_batch;
use crate::messages::cdr;
use crate::messages::column_twin::Measurement;
use crate::parameters::Parameters;
use crate::senses::{Batch, Intake, IntakeState};
use crate::twin::Nanos;

/// Most batches that are kept. An estimate rests on those of half a second, and of the second before the impact was detected;
/// the queue of the node holds 8192 that it has not taken yet.
const MAX_BATCHES: usize = 1 << 16;

/// Most samples in them, 64 MB: 100 s of 16 sensors at 10 kHz.
const MAX_SAMPLES: usize = 1 << 24;

/// Before the first checkpoint.
const NO_CHECKPOINT: &str = "the journal does not tell from which measurements on it counts them";

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
}

impl Default for Measured {
    fn default() -> Self {
        Self {
            intake: Err(NO_CHECKPOINT),
            batches: VecDeque::new(),
            samples: 0,
            first: 0,
        }
    }
}

impl Measured {
    /// Takes a recorded message that arrived at `received`, by the clock of the twin.
    pub fn message(
        &mut self,
        bytes: &[u8],
        received: Nanos,
        place: &Place<'_>,
        found: &mut Verification,
    ) {
        let measurement = match cdr::decode::<Measurement>(bytes) {
            Ok(measurement) => measurement,
            Err(error) => {
                self.lose("a message on measurements cannot be read");
                return found.note_difference(place.difference(
                    "the message",
                    format!("not readable ({error})"),
                    "a message of this type",
                ));
            }
        };
        let Ok(intake) = &mut self.intake else {
            return;
        };
        // The node records what it does not take, too, if the batches that follow depend on it.
        if let Ok(batch) = intake.take(&raw_batch(&measurement), received) {
            self.samples += batch.values.len();
            self.batches.push_back(batch);
            while self.samples > MAX_SAMPLES || self.batches.len() > MAX_BATCHES {
                let oldest = self.batches.pop_front();
                self.samples -= oldest.map_or(0, |it| it.values.len());
                self.first = self.first.saturating_add(1);
            }
        }
    }

    /// Takes what a checkpoint tells of the intake of the node.
    pub fn checkpoint(
        &mut self,
        state: Option<&IntakeState>,
        parameters: &Parameters,
        place: &Place<'_>,
        found: &mut Verification,
    ) {
        let Some(state) = state else {
            return self.lose(NO_SENSORS);
        };
        if let Ok(own) = &self.intake {
            let Some(difference) = place.first_difference(state, &own.state()) else {
                return;
            };
            found.note_difference(Difference {
                field: format!("intake.{}", difference.field),
                ..difference
            });
        }
        self.lose(NO_CHECKPOINT);
        let mut intake = Intake::new(&parameters.sensors(), &parameters.settings().column_id);
        if intake.resume(state) {
            self.first = state.batches();
            self.intake = Ok(intake);
        } else {
            let expected = format!("{} sensors", parameters.sensors().len());
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
