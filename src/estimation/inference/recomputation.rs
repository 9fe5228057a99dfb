//! Estimates computed again from recorded measurements.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use crate::estimation::detection::sensing::feed;
use crate::estimation::inference::comparison::SensorComparison;
use crate::estimation::inference::estimate_record::EstimateRecord;
use crate::estimation::inference::estimator::{Estimator, EstimatorError};
use crate::estimation::inference::event_evidence::MAX_EVENTS;
use crate::estimation::inference::library::{corrected_sensors, estimator_of};
use crate::estimation::inference::update::{Refinement, Update};
use crate::estimation::intake::batch::Batch;
use crate::parameters::Parameters;
use crate::sensors::Sensor;
use crate::standing::StandingColumn;

/// Why an estimate cannot be computed again.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotRecomputed {
    /// The estimates of an impact build upon one another.
    #[error(
        "estimate {update} of {event_id} builds upon the earlier ones of this impact, which were not computed again; \
         begin with the first one"
    )]
    NotInOrder {
        /// The impact.
        event_id: String,
        /// The number of the estimate.
        update: u32,
    },
    /// Measurements did not reach the estimator.
    #[error(
        "{lost} batches of measurements were lost before they reached the estimator, so the data of estimate {update} of {event_id} are not known"
    )]
    Lost {
        /// The impact.
        event_id: String,
        /// The number of the estimate.
        update: u32,
        /// Batches lost.
        lost: u64,
    },
    /// Measurements are missing.
    #[error(
        "estimate {update} of {event_id} rests on batches {expected} to {until} of the measurements, of which batch \
         {missing} is missing"
    )]
    Missing {
        /// The impact.
        event_id: String,
        /// The number of the estimate.
        update: u32,
        /// The first batch that was expected, and the one after the last.
        expected: u64,
        /// See `expected`.
        until: u64,
        /// The one that is missing.
        missing: u64,
    },
    /// The record prescribes more than an estimator ever does.
    #[error("the record of estimate {update} of {event_id} is impossible: {why}")]
    Impossible {
        /// The impact.
        event_id: String,
        /// The number of the estimate.
        update: u32,
        /// What is wrong.
        why: &'static str,
    },
    /// The parameters make no estimator.
    #[error(transparent)]
    Estimator(#[from] EstimatorError),
}

/// Most responses that are drawn for one estimate: more than a live estimator ever does.
const MAX_DRAWN: u32 = 10_000;

/// Most kinds of columns whose prepared responses are kept for further columns; the oldest is dropped.
const MAX_KEPT_PREPARATIONS: usize = 8;

/// Prepared responses that several recomputations of columns share which differ by their names only.
#[derive(Debug, Clone, Default)]
pub struct SharedPreparations(Rc<RefCell<VecDeque<Preparation>>>);

#[derive(Debug)]
struct Preparation {
    parameters: Parameters,
    column: StandingColumn,
    estimator: Estimator,
}

impl SharedPreparations {
    /// What was prepared for such a column of at most this many hypotheses, as many as possible.
    fn find(
        &self,
        parameters: &Parameters,
        column: &StandingColumn,
        most: usize,
    ) -> Option<Estimator> {
        let known = self.0.borrow();
        let suitable = known.iter().filter(|it| {
            it.estimator.prepared() <= most
                && it.column == *column
                && it.parameters.differs_by_names_only(parameters)
        });
        let best = suitable.max_by_key(|it| it.estimator.prepared())?;
        Some(best.estimator.clone())
    }

    /// Keeps what was prepared, unless it is known.
    fn keep(&self, parameters: &Parameters, column: &StandingColumn, estimator: &Estimator) {
        let prepared = estimator.prepared();
        let known = self.find(parameters, column, prepared);
        if known.is_some_and(|it| it.prepared() == prepared) {
            return;
        }
        let mut kept = self.0.borrow_mut();
        if kept.len() == MAX_KEPT_PREPARATIONS {
            kept.pop_front();
        }
        kept.push_back(Preparation {
            parameters: parameters.clone(),
            column: column.clone(),
            estimator: estimator.clone(),
        });
    }
}

/// Computes estimates again, one after another, with the data and the numbers of responses that their records name.
#[derive(Debug)]
pub struct Recomputation {
    parameters: Parameters,
    sensors: Vec<Sensor>,
    prepared: Option<(StandingColumn, Estimator)>,
    /// What others have prepared.
    shared: Option<SharedPreparations>,
    current: Option<Current>,
    /// The comparisons with the final estimate, after which what was prepared is not kept.
    final_comparisons: Vec<SensorComparison>,
}

/// An impact of which estimates were computed again.
#[derive(Debug)]
struct Current {
    /// The first estimate.
    begun: EstimateRecord,
    /// The numbers of the next estimate and of the next batch.
    update: u32,
    batch: u64,
}

impl Recomputation {
    /// With the parameters that held.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            sensors: corrected_sensors(parameters),
            parameters: parameters.clone(),
            prepared: None,
            shared: None,
            current: None,
            final_comparisons: Vec::new(),
        }
    }

    /// The same for one of many columns. What is prepared for an impact is shared, and not kept after its final estimate.
    #[must_use]
    pub fn sharing(parameters: &Parameters, shared: SharedPreparations) -> Self {
        Self {
            shared: Some(shared),
            ..Self::new(parameters)
        }
    }

    /// Computes the estimate of a record again, after those before it of the same impact. `batch` gives the batch with a
    /// number that is counted as in the record, or `None` if it is not known.
    ///
    /// The instant of contact and the zeros of the sensors are those of the record: they follow from all that the
    /// sensors have read before.
    ///
    /// # Errors
    /// The data or the earlier estimates are not known, or the record is impossible.
    pub fn repeat<'a>(
        &mut self,
        record: &EstimateRecord,
        batch: impl Fn(u64) -> Option<&'a Batch>,
    ) -> Result<EstimateRecord, NotRecomputed> {
        let current = self.current.take();
        let (event_id, update) = (|| record.event_id.to_string(), record.update);
        let impossible = |why| NotRecomputed::Impossible {
            event_id: event_id(),
            update,
            why,
        };
        if record.lost_batches > 0 {
            return Err(NotRecomputed::Lost {
                event_id: event_id(),
                update,
                lost: record.lost_batches,
            });
        }
        if record.drawn.max(record.drawn_before) > MAX_DRAWN {
            return Err(impossible("it was drawn from too many responses"));
        }
        if record.events.len() > MAX_EVENTS {
            return Err(impossible("too many events count for it"));
        }
        if record.detection.zeros.len() != self.sensors.len() {
            return Err(impossible(
                "it has another number of sensors than the parameters",
            ));
        }
        let (begun, next) = match (&record.column, current) {
            (Some(column), _) if update == 0 => {
                if !column.fits(&self.parameters) {
                    return Err(impossible("its impact is not on the column"));
                }
                self.begin(record, column)?;
                (record.clone(), record.first_batch)
            }
            (None, Some(it)) if it.begun.event_id == record.event_id && it.update == update => {
                (it.begun, it.batch)
            }
            _ => {
                return Err(NotRecomputed::NotInOrder {
                    event_id: event_id(),
                    update,
                });
            }
        };
        let Some((_, estimator)) = &mut self.prepared else {
            return Err(impossible("nothing was prepared"));
        };
        let mut refinement = Refinement::between(record.drawn_before).exactly();
        while !refinement.is_over() {
            refinement.step(estimator);
        }
        for number in next..record.batches {
            let known = batch(number).ok_or_else(|| NotRecomputed::Missing {
                event_id: event_id(),
                update,
                expected: next,
                until: record.batches,
                missing: number,
            })?;
            feed(estimator, begun.origin, known);
        }
        if record.counts_beam {
            estimator.finish_beam();
        }
        let until = record.estimate.data_until;
        estimator.set_events(&record.events);
        let refine = Refinement::at_most(record.drawn).exactly();
        let mut work = Update::new(estimator, until, update, record.is_final, refine);
        while !work.is_over() {
            work.step(estimator);
        }
        let best = estimator
            .best()
            .ok_or_else(|| impossible("no response can be computed"))?;
        let last = record
            .batches
            .checked_sub(1)
            .and_then(&batch)
            .map(|batch| (batch.sensor, batch.first));
        let again = EstimateRecord {
            origin: begun.origin,
            detection: begun.detection.clone(),
            first_batch: begun.first_batch,
            prepared: estimator.prepared() as u32,
            drawn_before: refinement.drawn(),
            drawn: work.drawn(),
            counts_beam: work.counts_beam(),
            events: record.events.clone(),
            last_batch: last.unwrap_or(record.last_batch),
            estimate: work.estimate(estimator),
            best,
            ..record.clone()
        };
        if record.is_final && self.shared.is_some() {
            self.final_comparisons = estimator.comparisons();
            self.prepared = None;
        }
        self.current = Some(Current {
            begun,
            update: update.saturating_add(1),
            batch: record.batches,
        });
        Ok(again)
    }

    /// What each sensor has read against what the estimate predicts that was computed again last; empty without one.
    #[must_use]
    pub fn comparisons(&self) -> Vec<SensorComparison> {
        match (&self.current, &self.prepared) {
            (None, _) => Vec::new(),
            (Some(_), Some((_, estimator))) => estimator.comparisons(),
            (Some(_), None) => self.final_comparisons.clone(),
        }
    }

    fn begin(
        &mut self,
        record: &EstimateRecord,
        column: &StandingColumn,
    ) -> Result<(), NotRecomputed> {
        let wanted = record.prepared as usize;
        let usable = self
            .prepared
            .take_if(|(of, estimator)| of == column && estimator.prepared() <= wanted);
        let mut estimator = match usable {
            Some((_, estimator)) => estimator,
            None => {
                let shared = self.shared.as_ref();
                match shared.and_then(|it| it.find(&self.parameters, column, wanted)) {
                    Some(estimator) => estimator,
                    None => estimator_of(&self.parameters, column, &self.sensors)?,
                }
            }
        };
        while estimator.prepared() < wanted {
            if estimator.prepare() {
                break;
            }
        }
        if let Some(shared) = &self.shared {
            shared.keep(&self.parameters, column, &estimator);
        }
        let contact = &record.detection.contact;
        estimator.begin(contact.time, contact.deviation, &record.detection.zeros);
        self.prepared = Some((column.clone(), estimator));
        Ok(())
    }
}
