//! Which columns of a fleet are in the middle of something that a recording must not be cut off in.

use std::collections::HashMap;

use crate::time::Nanos;
use crate::twin::CHECKPOINT_PERIOD;

/// Time without an entry after which a column counts as idle \[ns\]: its last status was lost, or there was none.
const FORGOTTEN_AFTER: Nanos = CHECKPOINT_PERIOD;

/// The columns that have received something or executed a command since their last status at rest.
#[derive(Debug, Default)]
pub(super) struct Activity {
    columns: HashMap<String, Doing>,
}

/// What a column is doing.
#[derive(Debug, Default)]
struct Doing {
    /// Received messages whose commands have not come.
    waiting: u32,
    /// It has given out a checkpoint, which its next command needs in the same recording.
    awaits_command: bool,
    /// It has executed a command, and its status at rest has not come.
    is_responding: bool,
    last: Nanos,
}

impl Activity {
    fn at(&mut self, column: &str, now: Nanos) -> &mut Doing {
        let doing = self.columns.entry(column.to_owned()).or_default();
        doing.last = now;
        doing
    }

    /// The node received a message for a column.
    pub fn received(&mut self, column: &str, now: Nanos) {
        self.at(column, now).waiting += 1;
    }

    /// A message that was received did not reach the column.
    pub fn rejected(&mut self, column: &str) {
        if let Some(doing) = self.columns.get_mut(column) {
            doing.waiting = doing.waiting.saturating_sub(1);
        }
        self.forget_idle(column);
    }

    /// The column has given out a checkpoint: before a command, or because it has come to rest.
    pub fn checkpoint(&mut self, column: &str, now: Nanos) {
        self.at(column, now).awaits_command = true;
    }

    /// The column has executed a command, of a received message or not.
    pub fn command(&mut self, column: &str, is_received: bool, now: Nanos) {
        let doing = self.at(column, now);
        doing.waiting = doing.waiting.saturating_sub(u32::from(is_received));
        doing.awaits_command = false;
        doing.is_responding = true;
    }

    /// A status of the column was reported.
    pub fn reported(&mut self, column: &str, now: Nanos) {
        if let Some(doing) = self.columns.get_mut(column) {
            doing.last = now;
            doing.awaits_command = false;
        }
        self.forget_idle(column);
    }

    /// A status has shown the column at rest.
    pub fn rests(&mut self, column: &str) {
        if let Some(doing) = self.columns.get_mut(column) {
            doing.is_responding = false;
        }
        self.forget_idle(column);
    }

    fn forget_idle(&mut self, column: &str) {
        let doing = self.columns.get(column);
        if doing.is_some_and(|it| it.waiting == 0 && !it.awaits_command && !it.is_responding) {
            self.columns.remove(column);
        }
    }

    /// Whether the column has executed a command since its last status at rest.
    pub fn is_responding(&self, column: &str) -> bool {
        self.columns.get(column).is_some_and(|it| it.is_responding)
    }

    /// Whether no column is in the middle of something.
    pub fn is_idle(&mut self, now: Nanos) -> bool {
        self.columns
            .retain(|_, doing| now.saturating_sub(doing.last) < FORGOTTEN_AFTER);
        self.columns.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_is_busy_from_its_message_to_its_status_at_rest() {
        let mut activity = Activity::default();
        assert!(activity.is_idle(0));
        activity.received("a", 1);
        assert!(!activity.is_idle(1) && !activity.is_responding("a"));
        activity.command("a", true, 2);
        assert!(activity.is_responding("a"));
        activity.received("a", 3);
        activity.rests("a");
        assert!(!activity.is_idle(4), "the second message has no command");
        activity.rejected("a");
        assert!(activity.is_idle(5));
        activity.checkpoint("b", 6);
        assert!(!activity.is_idle(6) && !activity.is_responding("b"));
        activity.command("b", false, 6);
        activity.rests("b");
        assert!(activity.is_idle(7));
        activity.checkpoint("b", 8);
        activity.reported("b", 9);
        assert!(activity.is_idle(9));
    }

    #[test]
    fn a_column_whose_last_status_is_lost_does_not_keep_the_recording_open() {
        let mut activity = Activity::default();
        activity.command("a", true, 0);
        activity.reported("a", FORGOTTEN_AFTER / 2);
        assert!(!activity.is_idle(FORGOTTEN_AFTER));
        assert!(activity.is_idle(2 * FORGOTTEN_AFTER));
        assert!(!activity.is_responding("a"));
    }
}
