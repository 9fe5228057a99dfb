//! What the sensors say about an impact, and what they have read beside what was predicted, as the viewer shows it.

use std::ops::Range;
use std::sync::Arc;

use super::timeline::nanos;
use crate::estimation::{AVERAGED_OVER, Batch, EstimateRecord, predicted_means};
use crate::messages::builtin_interfaces::Time;
use crate::messages::column_twin_msgs::ImpactEstimate;
use crate::parameters::Parameters;
use crate::standing::StandingColumn;
use crate::time::Nanos;
use crate::twin::EstimateOutput;

/// Time before contact from which on readings are shown \[ms\].
const BEFORE: i64 = 5;

/// An estimate of an impact that the sensors have detected, and what is new of their readings.
#[derive(Debug, Clone)]
pub struct DetectedUpdate {
    /// Instant of contact by the first estimate, from which all times of the impact count here \[ns\].
    pub stamp: Nanos,
    /// The estimate.
    pub estimate: Box<ImpactEstimate>,
    /// Data were used up to this time after `stamp` \[s\].
    pub until: f64,
    /// Whether the estimate itself is new, and not only what has become of it.
    pub is_new: bool,
    /// What is new of each sensor, in the order of the parameters; empty if that is not known.
    pub sensors: Vec<SensorCourse>,
}

impl DetectedUpdate {
    /// The impact of the twin that it is about: the event, if the twin follows one for the same impact.
    #[must_use]
    pub fn impact(&self) -> &str {
        let estimate = &self.estimate;
        match estimate.decision {
            ImpactEstimate::DECISION_MERGED => &estimate.merged_event_id,
            _ => &estimate.event_id,
        }
    }
}

/// What a sensor has read, and what was predicted for it, in the SI unit of its quantity: means over a millisecond, each with its
/// time after the `stamp` \[s\].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SensorCourse {
    /// What it has read, relative to before the impact.
    pub measured: Vec<(f64, f64)>,
    /// What the estimate before this one predicts for the data that are new in this one, which it has not seen.
    pub predicted: Vec<(f64, f64)>,
    /// What the final estimate predicts for all data.
    pub explained: Vec<(f64, f64)>,
}

/// Turns the estimates of one impact after another into what is shown of them.
#[derive(Debug)]
pub struct DetectedImpacts {
    parameters: Arc<Parameters>,
    current: Option<CurrentImpact>,
}

#[derive(Debug)]
struct CurrentImpact {
    event_id: String,
    stamp: Nanos,
    column: Option<StandingColumn>,
    /// Number of the newest estimate.
    update: u32,
    /// Readings up to this time after the stamp have been shown \[ms\].
    shown: i64,
    /// What the newest estimate predicts.
    newest: Option<Predicted>,
}

/// What an estimate predicts for each sensor.
#[derive(Debug)]
struct Predicted {
    /// Means over the cells from contact on.
    means: Vec<Vec<f64>>,
    /// The cell that begins with contact.
    first: i64,
}

impl Predicted {
    /// The predictions for a sensor and some cells, as far as they go. Before contact the column is at rest.
    fn over(&self, sensor: usize, cells: Range<i64>) -> Vec<(f64, f64)> {
        let means = self.means.get(sensor).map_or(&[][..], Vec::as_slice);
        let value = |cell: i64| match usize::try_from(cell - self.first) {
            Ok(index) => means.get(index).copied(),
            Err(_) => Some(0.0),
        };
        cells
            .filter_map(|cell| Some((middle(cell), value(cell)?)))
            .collect()
    }
}

impl DetectedImpacts {
    /// For the sensors of these parameters.
    #[must_use]
    pub fn new(parameters: Arc<Parameters>) -> Self {
        Self {
            parameters,
            current: None,
        }
    }

    /// The parameters from here on.
    pub fn change(&mut self, parameters: Arc<Parameters>) {
        self.parameters = parameters;
    }

    /// What is shown of an output of the twin. `batches` gives the readings between two instants \[ns\]; they may overlap.
    pub fn of_twin(
        &mut self,
        output: &EstimateOutput,
        batches: impl FnOnce(Nanos, Nanos) -> Vec<Batch>,
    ) -> DetectedUpdate {
        let mut estimate = ImpactEstimate::from(output);
        estimate.header.stamp = Time::from_nanos(output.stamp).unwrap_or_default();
        self.update(estimate, Some(&output.record), batches)
    }

    /// What is shown of an estimate: its message, and its record if there is one.
    pub fn update(
        &mut self,
        estimate: ImpactEstimate,
        record: Option<&EstimateRecord>,
        batches: impl FnOnce(Nanos, Nanos) -> Vec<Batch>,
    ) -> DetectedUpdate {
        let contact = estimate.header.stamp.to_nanos().unwrap_or_default();
        let is_same = |it: &CurrentImpact| it.event_id == estimate.event_id;
        let (current, is_new) = match self.current.take().filter(is_same) {
            Some(current) => {
                let is_new = current.update < estimate.update;
                (current, is_new)
            }
            None => (CurrentImpact::new(&estimate, contact), true),
        };
        let current = self.current.insert(current);
        let after = |instant: Nanos| 1e-9 * instant.saturating_sub(current.stamp) as f64;
        let until = after(contact) + estimate.data_until;
        let mut sensors = Vec::new();
        current.update = estimate.update;
        if let Some(record) = record.filter(|_| is_new) {
            if let Some(column) = &record.column {
                current.column = Some(column.clone());
            }
            sensors = current.courses(&self.parameters, record, after(contact), until, batches);
        }
        DetectedUpdate {
            stamp: current.stamp,
            until,
            is_new,
            estimate: Box::new(estimate),
            sensors,
        }
    }
}

impl CurrentImpact {
    fn new(estimate: &ImpactEstimate, contact: Nanos) -> Self {
        Self {
            event_id: estimate.event_id.clone(),
            stamp: contact,
            column: None,
            update: estimate.update,
            shown: -BEFORE,
            newest: None,
        }
    }

    /// What is new with the data up to `until` after the stamp \[s\], for an estimate whose contact is `contact` after it \[s\].
    fn courses(
        &mut self,
        parameters: &Parameters,
        record: &EstimateRecord,
        contact: f64,
        until: f64,
        batches: impl FnOnce(Nanos, Nanos) -> Vec<Batch>,
    ) -> Vec<SensorCourse> {
        let cells = self.shown..((until / AVERAGED_OVER + 1e-6).floor() as i64).max(self.shown);
        self.shown = cells.end;
        let mut courses = self.measured(&cells, record, batches);
        if let Some(newest) = &self.newest {
            for (sensor, course) in courses.iter_mut().enumerate() {
                course.predicted = newest.over(sensor, cells.clone());
            }
        }
        let means = self.column.as_ref();
        let means = means.and_then(|it| predicted_means(it, parameters, &record.best));
        self.newest = means.map(|means| Predicted {
            means,
            first: (contact / AVERAGED_OVER).round() as i64,
        });
        if let Some(newest) = self.newest.as_ref().filter(|_| record.is_final) {
            for (sensor, course) in courses.iter_mut().enumerate() {
                course.explained = newest.over(sensor, -BEFORE..cells.end);
            }
        }
        courses
    }

    /// The means over the cells of which a sensor has readings.
    fn measured(
        &self,
        cells: &Range<i64>,
        record: &EstimateRecord,
        batches: impl FnOnce(Nanos, Nanos) -> Vec<Batch>,
    ) -> Vec<SensorCourse> {
        let zeros = &record.detection.zeros;
        let count = usize::try_from(cells.end - cells.start).unwrap_or_default();
        let mut sums = vec![vec![(0.0, 0_u32); count]; zeros.len()];
        let cell_nanos = nanos(AVERAGED_OVER);
        let begin = self
            .stamp
            .saturating_add(cells.start.saturating_mul(cell_nanos));
        let end = self
            .stamp
            .saturating_add(cells.end.saturating_mul(cell_nanos));
        for batch in batches(begin, end) {
            let Some(sums) = sums.get_mut(usize::from(batch.sensor)) else {
                continue;
            };
            for (time, value) in batch.samples().filter(|(_, value)| value.is_finite()) {
                let cell = time.saturating_sub(begin).div_euclid(cell_nanos);
                if let Some((sum, samples)) =
                    usize::try_from(cell).ok().and_then(|it| sums.get_mut(it))
                {
                    *sum += f64::from(value);
                    *samples += 1;
                }
            }
        }
        let course = |(sums, (zero, _)): (Vec<(f64, u32)>, &(f64, f64))| SensorCourse {
            measured: cells
                .clone()
                .zip(sums)
                .filter(|(_, (_, samples))| *samples > 0)
                .map(|(cell, (sum, samples))| (middle(cell), sum / f64::from(samples) - zero))
                .collect(),
            ..SensorCourse::default()
        };
        sums.into_iter().zip(zeros).map(course).collect()
    }
}

/// The middle of a cell \[s\].
fn middle(cell: i64) -> f64 {
    (cell as f64 + 0.5) * AVERAGED_OVER
}
