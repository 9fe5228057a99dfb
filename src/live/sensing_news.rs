//! What the solvers tell a thread that detects impacts: without a lock, because they have deadlines.

use std::sync::Arc;

use crossbeam_queue::ArrayQueue;

use super::marked::Marked;
use super::measurements::MeasurementQueue;
use crate::estimation::MAX_EVENTS;
use crate::time::Nanos;
use crate::twin::{MergedEvent, Notice, NoticeLevel, Output};

/// Most events that wait to become evidence for an estimate.
const MAX_MERGED_EVENTS: usize = MAX_EVENTS;

/// The same of all columns of a fleet together.
const MAX_MERGED_EVENTS_OF_A_FLEET: usize = 16 * MAX_MERGED_EVENTS;

/// Which columns may have changed, and which events are the same impact as an estimate.
#[derive(Debug)]
pub(super) struct SensingNews {
    /// The columns that may have changed since they were taken out.
    changed: Marked,
    is_sensed: Box<[bool]>,
    merged: ArrayQueue<(u32, MergedEvent)>,
    /// Whose reader takes the news.
    measurements: Arc<MeasurementQueue>,
}

impl SensingNews {
    /// For the columns for which this is `true`, all of which are new.
    pub fn new(
        is_sensed: impl IntoIterator<Item = bool>,
        measurements: Arc<MeasurementQueue>,
    ) -> Self {
        let is_sensed: Box<[bool]> = is_sensed.into_iter().collect();
        let events = match is_sensed.len() {
            1 => MAX_MERGED_EVENTS,
            _ => MAX_MERGED_EVENTS_OF_A_FLEET,
        };
        let news = Self {
            changed: Marked::new(is_sensed.len()),
            merged: ArrayQueue::new(events),
            is_sensed,
            measurements,
        };
        for column in 0..news.is_sensed.len() {
            news.changed(column as u32);
        }
        news
    }

    /// Takes note of what an output says. A [`Notice`] is returned if an event is lost.
    pub fn take(&self, column: u32, output: &Output) -> Option<Notice> {
        match output {
            Output::Save(_) | Output::ParametersChanged(_) => {
                self.changed(column);
                None
            }
            Output::Merged(event) => self.merged(column, event),
            _ => None,
        }
    }

    fn changed(&self, column: u32) {
        if self.is_sensed.get(column as usize) == Some(&true) {
            self.changed.mark(column);
            self.measurements.notifier().notify();
        }
    }

    fn merged(&self, column: u32, event: &MergedEvent) -> Option<Notice> {
        let lost = self.merged.force_push((column, event.clone()));
        self.measurements.notifier().notify();
        let (_, lost) = lost?;
        let text = format!(
            "impact event \"{}\" does not count as evidence for \"{}\": more than {} events wait to be taken",
            lost.event_id,
            lost.estimate_id,
            self.merged.capacity(),
        );
        let stamp: Nanos = event.contact;
        Some(Notice {
            stamp,
            level: NoticeLevel::Error,
            text: text.into(),
        })
    }

    /// A column that may have changed since it was returned last.
    pub fn next_changed(&self) -> Option<u32> {
        self.changed.next()
    }

    /// An event that is the same impact as an estimate of this column.
    pub fn next_merged(&self) -> Option<(u32, MergedEvent)> {
        self.merged.pop()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_is_told_once_until_it_is_looked_at_and_one_without_sensors_never() {
        let news = SensingNews::new([true, false, true], Arc::default());
        let told = || -> Vec<u32> { std::iter::from_fn(|| news.next_changed()).collect() };
        assert_eq!(told(), [0, 2], "all of them are new");
        for column in [2, 1, 2, 9, 0] {
            news.changed(column);
        }
        assert_eq!(told(), [2, 0]);
        news.changed(2);
        assert_eq!(told(), [2]);
    }
}
