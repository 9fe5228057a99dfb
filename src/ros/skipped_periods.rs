//! Periods that the solver skipped, in the log: after a stop of the process, or because the machine is overloaded.

use std::time::{Duration, Instant};

use super::live_twin::Health;

/// Minimum time between two messages. What is skipped meanwhile is part of the next one.
const MIN_INTERVAL: Duration = Duration::from_secs(10);

/// Which of the skipped periods the log has told.
#[derive(Debug, Default)]
pub(super) struct SkippedPeriods {
    told: u64,
    last: Option<Instant>,
}

impl SkippedPeriods {
    /// Logs those that were skipped since the last message.
    pub fn look(&mut self, health: &Health, now: Instant) {
        if let Some(skipped) = self.untold(health.overruns, now) {
            tracing::warn!(
                "the solver was late and skipped {skipped} periods, whose states are not published; its largest lateness since the \
                 start is {:.3} s. The process was stopped, or the machine is busy",
                health.worst_lateness
            );
        }
    }

    /// The number to tell now, of those since the start.
    fn untold(&mut self, skipped: u64, now: Instant) -> Option<u64> {
        let since = self.last.map(|last| now.saturating_duration_since(last));
        if skipped <= self.told || since.is_some_and(|since| since < MIN_INTERVAL) {
            return None;
        }
        self.last = Some(now);
        Some(skipped - std::mem::replace(&mut self.told, skipped))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_skipped_period_is_told_once() {
        let (mut periods, start) = (SkippedPeriods::default(), Instant::now());
        let seconds = [(0, 0), (0, 1), (7, 2), (9, 3), (9, 11), (12, 12), (12, 60)];
        let told: Vec<_> = seconds
            .into_iter()
            .map(|(skipped, at)| periods.untold(skipped, start + Duration::from_secs(at)))
            .collect();
        assert_eq!(told, [None, None, Some(7), None, None, Some(5), None]);
    }
}
