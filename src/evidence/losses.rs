//! Weighs what is missing in a recording against the losses that it declares.

use crate::messages::column_twin_msgs::TwinStatus;
use crate::time::Nanos;

/// Time after a status within which the loss that it declares shows in the recording \[ns\]: a queue to the node counts what
/// it drops at once, and the gap shows when the node has sent what was queued before.
pub const LOSS_SHOWS_WITHIN: Nanos = 60_000_000_000;

/// Further messages that are missing with a state: `dropped_recording` counts it once, but its hinge forces, joint states and
/// markers are missing too.
const FURTHER_MESSAGES_PER_STATE: u64 = 3;

/// What is missing, and what is declared as lost.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Losses {
    declared: Vec<Declared>,
    /// What the last status declares in total.
    total: u64,
    last_status: Option<Nanos>,
    missing: Vec<Missing>,
}

/// A loss that a status declares, beyond those before it.
#[derive(Debug, Clone, PartialEq)]
struct Declared {
    /// Log time of the status before it.
    after: Nanos,
    /// Log time of the status.
    at: Nanos,
    /// Upper bound of the messages.
    left: u64,
}

/// Messages that were found to be missing at one time.
#[derive(Debug, Clone, PartialEq)]
struct Missing {
    at: Nanos,
    count: u64,
}

impl Losses {
    /// Takes note of a recorded status.
    pub fn status(&mut self, status: &TwinStatus, log_time: Nanos) {
        let total = status
            .dropped_states
            .saturating_mul(FURTHER_MESSAGES_PER_STATE)
            .saturating_add(status.dropped_recording);
        let more = total.saturating_sub(self.total);
        if more > 0 {
            self.declared.push(Declared {
                after: self.last_status.unwrap_or(Nanos::MIN),
                at: log_time,
                left: more,
            });
            self.total = total;
        }
        self.last_status = Some(log_time);
    }

    /// Takes note that messages are missing, which shows at this log time.
    pub fn missing(&mut self, count: u64, at: Nanos) {
        match self.missing.last_mut() {
            Some(last) if last.at == at => last.count = last.count.saturating_add(count),
            _ => self.missing.push(Missing { at, count }),
        }
    }

    /// What the statuses declare in total.
    pub fn declared(&self) -> u64 {
        self.total
    }

    /// The number of missing messages whose loss is not declared. The recorder itself declares the loss of `at_end`: a status
    /// declares it too, except what was lost after the last one.
    pub fn undeclared(mut self, at_end: u64) -> u64 {
        let mut at_end = at_end;
        let last_status = self.last_status.unwrap_or(Nanos::MIN);
        self.missing.sort_by_key(|it| it.at);
        let mut undeclared: u64 = 0;
        for Missing { at, count } in self.missing {
            let mut rest = count;
            for declared in &mut self.declared {
                let until = declared.at.saturating_add(LOSS_SHOWS_WITHIN);
                if declared.after <= at && at <= until {
                    let excused = rest.min(declared.left);
                    declared.left -= excused;
                    rest -= excused;
                }
            }
            if at >= last_status {
                let excused = rest.min(at_end);
                at_end -= excused;
                rest -= excused;
            }
            undeclared = undeclared.saturating_add(rest);
        }
        undeclared
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Nanos = 1_000_000_000;

    fn status(dropped_recording: u64) -> TwinStatus {
        TwinStatus {
            dropped_recording,
            ..TwinStatus::default()
        }
    }

    #[test]
    fn a_loss_excuses_as_many_messages_as_it_declares_when_it_declares_them() {
        let undeclared = |at: Nanos, count| {
            let mut losses = Losses::default();
            losses.status(&status(0), SECOND);
            losses.status(&status(5), 2 * SECOND);
            losses.status(&status(5), 200 * SECOND);
            losses.missing(count, at);
            losses.undeclared(0)
        };
        // Before the loss, when it happens, after it, and much later.
        assert_eq!(undeclared(SECOND / 2, 3), 3);
        assert_eq!(undeclared(3 * SECOND / 2, 5), 0);
        assert_eq!(undeclared(3 * SECOND / 2, 7), 2);
        assert_eq!(undeclared(30 * SECOND, 5), 0);
        assert_eq!(undeclared(100 * SECOND, 5), 5);
    }

    #[test]
    fn a_lost_state_was_up_to_four_messages() {
        let mut losses = Losses::default();
        let status = TwinStatus {
            dropped_states: 2,
            dropped_recording: 3,
            ..TwinStatus::default()
        };
        losses.status(&status, SECOND);
        losses.missing(9, SECOND);
        assert_eq!(losses.undeclared(0), 0);
    }

    #[test]
    fn what_the_recorder_lost_after_the_last_status_is_declared_at_the_end() {
        let mut losses = Losses::default();
        losses.status(&status(0), SECOND);
        losses.missing(2, SECOND / 2);
        losses.missing(3, 2 * SECOND);
        assert_eq!(losses.undeclared(4), 2);
    }
}
