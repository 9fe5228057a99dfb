//! Warns if the node uses simulated time, but no message arrives on `/clock`.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Without a message on `/clock` for this long after the start, the node warns.
pub(super) const CLOCK_TIMEOUT: Duration = Duration::from_secs(5);

/// Time between two such warnings.
const WARNING_PERIOD: Duration = Duration::from_secs(60);

/// Counts the messages on `/clock` under `use_sim_time`.
#[derive(Debug)]
pub(super) struct ClockWatch {
    started: Instant,
    received: AtomicU64,
}

impl ClockWatch {
    pub fn new(started: Instant) -> Self {
        Self {
            started,
            received: AtomicU64::new(0),
        }
    }

    /// Takes note of a message.
    pub fn received(&self) {
        self.received.fetch_add(1, Ordering::Relaxed);
    }

    /// Messages since the start.
    pub fn count(&self) -> u64 {
        self.received.load(Ordering::Relaxed)
    }

    /// What is wrong, if no message has arrived in time. A clock that has run and stands still is that of a bag that is paused.
    pub fn problem(&self, now: Instant) -> Option<String> {
        let waited = now.saturating_duration_since(self.started);
        (self.count() == 0 && waited >= CLOCK_TIMEOUT).then(|| {
            format!(
                "use_sim_time is true, but no message has arrived on /clock for {} s: the twin stands still and rejects events; \
                 play a bag with --clock, start the simulator, or set use_sim_time to false",
                waited.as_secs()
            )
        })
    }
}

/// Repeats a warning seldom.
#[derive(Debug, Default)]
pub(super) struct SeldomWarning {
    last: Option<Instant>,
}

impl SeldomWarning {
    /// Whether to warn now.
    pub fn is_due(&mut self, now: Instant) -> bool {
        let since = self.last.map(|last| now.saturating_duration_since(last));
        let due = since.is_none_or(|since| since >= WARNING_PERIOD);
        if due {
            self.last = Some(now);
        }
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn use_sim_time_without_a_clock_is_a_problem_after_some_seconds() {
        let start = Instant::now();
        let watch = ClockWatch::new(start);
        assert!(watch.problem(start + Duration::from_secs(4)).is_none());
        let problem = watch.problem(start + CLOCK_TIMEOUT);
        assert!(problem.is_some_and(|it| it.contains("for 5 s") && it.contains("--clock")));
        watch.received();
        assert!(watch.problem(start + Duration::from_secs(900)).is_none());
    }

    #[test]
    fn the_warning_is_repeated_seldom() {
        let start = Instant::now();
        let mut warning = SeldomWarning::default();
        let warned = (0..130).filter(|second| warning.is_due(start + Duration::from_secs(*second)));
        assert_eq!(warned.collect::<Vec<_>>(), [0, 60, 120]);
    }
}
