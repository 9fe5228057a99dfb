//! A limit on how many messages go into a log per period.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Admits a number of messages per period, and counts those that it hides.
#[derive(Debug, Clone)]
pub struct LogLimit {
    max: u64,
    period: Duration,
    period_start: Option<Instant>,
    shown: u64,
    hidden: u64,
}

impl LogLimit {
    /// Admits at most `max` messages per period, which begins with a message.
    pub const fn new(max: u64, period: Duration) -> Self {
        Self {
            max,
            period,
            period_start: None,
            shown: 0,
            hidden: 0,
        }
    }

    /// Whether to show a message; then with the number of messages that were hidden before it.
    pub fn admit(&mut self, now: Instant) -> Option<u64> {
        let since = self
            .period_start
            .map(|it| now.saturating_duration_since(it));
        if since.is_none_or(|since| since >= self.period) {
            self.period_start = Some(now);
            self.shown = 0;
        }
        if self.shown == self.max {
            self.hidden += 1;
            return None;
        }
        self.shown += 1;
        Some(std::mem::take(&mut self.hidden))
    }
}

/// A limit on messages about one subject, which several threads may write.
#[derive(Debug)]
pub struct SubjectLimit {
    /// What the messages are about, in the plural.
    subject: &'static str,
    limit: Mutex<LogLimit>,
}

impl SubjectLimit {
    /// Admits at most `max` messages about a subject, in the plural, per period.
    pub const fn new(subject: &'static str, max: u64, period: Duration) -> Self {
        Self {
            subject,
            limit: Mutex::new(LogLimit::new(max, period)),
        }
    }

    /// Whether to show a message; then with what to append to it about those that were hidden before.
    pub fn admit(&self, now: Instant) -> Option<String> {
        let mut limit = self.limit.lock().unwrap_or_else(PoisonError::into_inner);
        let subject = self.subject;
        limit.admit(now).map(|hidden| match hidden {
            0 => String::new(),
            _ => format!(" ({hidden} messages about {subject} before this one are not shown)"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_messages_are_counted_once() {
        let period = Duration::from_secs(10);
        let (mut limit, start) = (LogLimit::new(2, period), Instant::now());
        let mut admitted = |now| (0..5).map(|_| limit.admit(now)).collect::<Vec<_>>();
        assert_eq!(admitted(start), [Some(0), Some(0), None, None, None]);
        assert_eq!(admitted(start + period / 2), [None; 5]);
        let next = [Some(8), Some(0), None, None, None];
        assert_eq!(admitted(start + period), next);
    }
}
