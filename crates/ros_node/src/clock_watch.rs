//! Warns if the node uses simulated time, but no message arrives on `/clock`, or none any more during a response.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Without a message on `/clock` for this long after the start, or during a response, the node warns.
pub const CLOCK_TIMEOUT: Duration = Duration::from_secs(5);

/// Time between two such warnings.
const WARNING_PERIOD: Duration = Duration::from_secs(60);

/// Counts the messages on `/clock` under `use_sim_time`.
#[derive(Debug)]
pub struct ClockWatch {
    started: Instant,
    received: AtomicU64,
    /// When the last message arrived, after the start \[ms\].
    last: AtomicU64,
}

impl ClockWatch {
    /// For a node that was started then.
    pub fn new(started: Instant) -> Self {
        Self {
            started,
            received: AtomicU64::new(0),
            last: AtomicU64::new(0),
        }
    }

    /// Takes note of a message.
    pub fn received(&self, now: Instant) {
        self.last.store(self.millis(now), Ordering::Relaxed);
        self.received.fetch_add(1, Ordering::Relaxed);
    }

    /// Messages since the start.
    pub fn count(&self) -> u64 {
        self.received.load(Ordering::Relaxed)
    }

    /// What is wrong, if no message has arrived in time. A clock that has run and stands still is that of a bag that is paused, which is
    /// a problem only while a column responds: its response stands still, too.
    pub fn problem(&self, now: Instant, is_responding: impl FnOnce() -> bool) -> Option<String> {
        let last = self.last.load(Ordering::Relaxed);
        let waited = Duration::from_millis(self.millis(now).saturating_sub(last));
        let has_begun = self.count() > 0;
        if waited < CLOCK_TIMEOUT || (has_begun && !is_responding()) {
            return None;
        }
        let seconds = waited.as_secs();
        Some(match has_begun {
            false => format!(
                "use_sim_time is true, but no message has arrived on /clock for {seconds} s: the twin stands still and rejects events; \
                 play a bag with --clock, start the simulator, or set use_sim_time to false"
            ),
            true => format!(
                "use_sim_time is true, but no further message has arrived on /clock for {seconds} s: the response under way stands \
                 still; resume the bag or the simulator"
            ),
        })
    }

    fn millis(&self, now: Instant) -> u64 {
        let since = now.saturating_duration_since(self.started).as_millis();
        u64::try_from(since).unwrap_or(u64::MAX)
    }
}

/// Repeats a warning seldom.
#[derive(Debug, Default)]
pub struct SeldomWarning {
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
        let at = |seconds| start + Duration::from_secs(seconds);
        assert!(watch.problem(at(4), || false).is_none());
        let problem = watch.problem(start + CLOCK_TIMEOUT, || false);
        assert!(problem.is_some_and(|it| it.contains("for 5 s") && it.contains("--clock")));
        watch.received(at(6));
        assert!(watch.problem(at(900), || false).is_none());
    }

    /// It was never noticed.
    #[test]
    fn a_clock_that_stops_in_the_middle_of_a_response_is_a_problem_until_it_goes_on() {
        let start = Instant::now();
        let watch = ClockWatch::new(start);
        let at = |seconds| start + Duration::from_secs(seconds);
        watch.received(at(100));
        assert!(watch.problem(at(104), || true).is_none());
        let problem = watch.problem(at(107), || true);
        assert!(problem.is_some_and(|it| it.contains("for 7 s") && it.contains("response")));
        watch.received(at(108));
        assert!(watch.problem(at(109), || true).is_none());
    }

    #[test]
    fn the_warning_is_repeated_seldom() {
        let start = Instant::now();
        let mut warning = SeldomWarning::default();
        let warned = (0..130).filter(|second| warning.is_due(start + Duration::from_secs(*second)));
        assert_eq!(warned.collect::<Vec<_>>(), [0, 60, 120]);
    }
}
