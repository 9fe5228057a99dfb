//! Losses of the node in its log: periods that the solver skipped, after a stop of the process or because the machine is overloaded, and
//! messages that no reader got.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::counters::NodeCounters;
use super::live_columns::Health;

/// Minimum time between two messages about the same. What is lost meanwhile is part of the next one.
const MIN_INTERVAL: Duration = Duration::from_secs(10);

/// Which of the losses the log has told.
#[derive(Debug, Default)]
pub(super) struct LossLog {
    periods: Told,
    unpublished: Told,
}

impl LossLog {
    /// Logs what was lost since the last messages.
    pub fn look(&mut self, health: &Health, counters: &NodeCounters, now: Instant) {
        if let Some(skipped) = self.periods.untold(health.overruns, now) {
            tracing::warn!(
                "the solver was late and skipped {skipped} periods, whose states are not published; its largest lateness since the \
                 start is {:.3} s. The process was stopped, or the machine is busy",
                health.worst_lateness
            );
        }
        let unpublished = counters.unpublished.load(Ordering::Relaxed);
        if let Some(unpublished) = self.unpublished.untold(unpublished, now) {
            tracing::warn!(
                "{unpublished} messages were not published, most likely because a reliable reader has acknowledged nothing for long: \
                 it is too slow, was stopped, or is cut off; no reader gets these messages"
            );
        }
    }
}

/// How much of a count was told.
#[derive(Debug, Default)]
struct Told {
    count: u64,
    last: Option<Instant>,
}

impl Told {
    /// The number to tell now, of those since the start.
    fn untold(&mut self, count: u64, now: Instant) -> Option<u64> {
        let since = self.last.map(|last| now.saturating_duration_since(last));
        if count <= self.count || since.is_some_and(|since| since < MIN_INTERVAL) {
            return None;
        }
        self.last = Some(now);
        Some(count - std::mem::replace(&mut self.count, count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_loss_is_told_once() {
        let (mut told, start) = (Told::default(), Instant::now());
        let counts = [(0, 0), (0, 1), (7, 2), (9, 3), (9, 11), (12, 12), (12, 60)];
        let told: Vec<_> = counts
            .into_iter()
            .map(|(count, at)| told.untold(count, start + Duration::from_secs(at)))
            .collect();
        assert_eq!(told, [None, None, Some(7), None, None, Some(5), None]);
    }
}
