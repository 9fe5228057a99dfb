//! Gathers the statuses of the columns of a fleet for few messages: what has changed, and all of them now and then.

use std::collections::BTreeSet;
use std::time::Duration;

use crate::messages::cdr;
use crate::messages::column_twin_msgs::ColumnStatus;

/// Minimum time between two messages about changes.
pub const STATUS_SPACING: Duration = Duration::from_millis(100);

/// Time between two rounds of all columns.
pub const ROUND_PERIOD: Duration = Duration::from_secs(10);

/// Most columns in one message, which is then some tens of kilobytes long.
pub const MAX_STATUSES_PER_MESSAGE: usize = 100;

/// Most messages of a round at a time, so that a round of 2000 columns does not overflow the sockets of its readers.
const MAX_MESSAGES_AT_ONCE: usize = 4;

/// The columns of one message.
#[derive(Debug, Clone, PartialEq)]
pub struct StatusBatch {
    /// Whether it belongs to a round of all columns.
    pub of_all: bool,
    /// In the order of the fleet.
    pub columns: Vec<ColumnStatus>,
}

/// The latest status of every column. Times are those of a steady clock, since any instant.
#[derive(Debug)]
pub struct StatusBoard {
    columns: Vec<ColumnStatus>,
    changed: BTreeSet<usize>,
    /// The columns of which no status has come, and which no message contains.
    unknown: BTreeSet<usize>,
    last_message: Option<Duration>,
    last_round: Option<Duration>,
    /// The next column of the round that is being sent.
    round_at: Option<usize>,
    is_round_wanted: bool,
}

impl StatusBoard {
    /// For the columns with these identifiers, of which nothing else is known.
    pub fn new(column_ids: impl IntoIterator<Item = String>) -> Self {
        let status = |column_id| ColumnStatus {
            column_id,
            ..ColumnStatus::default()
        };
        let columns: Vec<_> = column_ids.into_iter().map(status).collect();
        Self {
            unknown: (0..columns.len()).collect(),
            columns,
            changed: BTreeSet::new(),
            last_message: None,
            last_round: None,
            round_at: None,
            is_round_wanted: false,
        }
    }

    /// The latest status of every column.
    #[must_use]
    pub fn columns(&self) -> &[ColumnStatus] {
        &self.columns
    }

    /// Takes what is wrong with the sensors of a column; empty: nothing.
    pub fn note_sensors(&mut self, column: usize, problem: &str) {
        if let Some(known) = self.columns.get_mut(column)
            && known.sensor_problem != problem
        {
            problem.clone_into(&mut known.sensor_problem);
            if !self.unknown.contains(&column) {
                self.changed.insert(column);
            }
        }
    }

    /// Takes the status of a column. What is wrong with its sensors stays.
    pub fn update(&mut self, column: usize, status: ColumnStatus) {
        let Some(known) = self.columns.get_mut(column) else {
            return;
        };
        let status = ColumnStatus {
            sensor_problem: known.sensor_problem.clone(),
            ..status
        };
        // Numbers that are not known are NaN, which equals nothing.
        let bytes = |status: &ColumnStatus| cdr::encode(status).ok();
        if self.unknown.remove(&column) || bytes(known) != bytes(&status) {
            *known = status;
            self.changed.insert(column);
        }
    }

    /// A reader has joined, which does not know all columns.
    pub fn want_round(&mut self) {
        self.is_round_wanted = true;
    }

    /// What is to be sent now.
    pub fn due(&mut self, now: Duration) -> Vec<StatusBatch> {
        if !self.is_spaced(now) {
            return Vec::new();
        }
        let is_round_due = self
            .last_round
            .is_none_or(|last| now.saturating_sub(last) >= ROUND_PERIOD);
        // At the start the first round waits for all columns, but not for ever.
        let is_known = self.unknown.is_empty() || now >= ROUND_PERIOD;
        if self.round_at.is_none() && is_known && (is_round_due || self.is_round_wanted) {
            self.round_at = Some(0);
            self.is_round_wanted = false;
            self.last_round = Some(now);
        }
        let mut batches = Vec::new();
        while let Some(from) = self.round_at {
            if batches.len() == MAX_MESSAGES_AT_ONCE {
                break;
            }
            let to = (from + MAX_STATUSES_PER_MESSAGE).min(self.columns.len());
            self.changed.retain(|it| !(from..to).contains(it));
            batches.push(StatusBatch {
                of_all: true,
                columns: (from..to)
                    .filter(|it| !self.unknown.contains(it))
                    .map(|it| self.columns[it].clone())
                    .collect(),
            });
            self.round_at = (to < self.columns.len()).then_some(to);
        }
        if batches.is_empty() && !self.changed.is_empty() {
            let next: Vec<_> = self.changed.iter().copied().collect();
            let next = &next[..next.len().min(MAX_STATUSES_PER_MESSAGE)];
            batches.push(StatusBatch {
                of_all: false,
                columns: next.iter().map(|&it| self.columns[it].clone()).collect(),
            });
            self.changed.retain(|it| !next.contains(it));
        }
        if !batches.is_empty() {
            self.last_message = Some(now);
        }
        batches
    }

    fn is_spaced(&self, now: Duration) -> bool {
        self.last_message
            .is_none_or(|last| now.saturating_sub(last) >= STATUS_SPACING)
    }

    /// How long nothing is to be sent, if nothing changes.
    #[must_use]
    pub fn rest(&self, now: Duration) -> Duration {
        let until = |last: Option<Duration>, period: Duration| {
            last.map_or(Duration::ZERO, |last| (last + period).saturating_sub(now))
        };
        let is_waiting = self.round_at.is_some() || !self.changed.is_empty();
        match is_waiting || (self.is_round_wanted && self.unknown.is_empty()) {
            true => until(self.last_message, STATUS_SPACING),
            false if !self.unknown.is_empty() => STATUS_SPACING,
            false => until(self.last_round, ROUND_PERIOD),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A board on which every column is known.
    fn board(columns: usize) -> StatusBoard {
        let id = |number| format!("c{number}");
        let mut board = StatusBoard::new((0..columns).map(id));
        for number in 0..columns {
            let status = ColumnStatus {
                column_id: id(number),
                ..ColumnStatus::default()
            };
            board.update(number, status);
        }
        board
    }

    fn at(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    fn damaged(number: usize) -> ColumnStatus {
        ColumnStatus {
            column_id: format!("c{number}"),
            residual_v1: 0.01,
            reserve: f64::NAN,
            ..ColumnStatus::default()
        }
    }

    /// Sends the first round.
    fn after_the_first_round(columns: usize) -> StatusBoard {
        let mut board = board(columns);
        let mut now = 0;
        let mut sent = Vec::new();
        while sent.len() < columns {
            let batches = board.due(at(now));
            assert!(batches.len() <= MAX_MESSAGES_AT_ONCE);
            for batch in batches {
                assert!(batch.of_all && batch.columns.len() <= MAX_STATUSES_PER_MESSAGE);
                sent.extend(batch.columns.into_iter().map(|it| it.column_id));
            }
            now += 100;
        }
        let all: Vec<_> = (0..columns).map(|number| format!("c{number}")).collect();
        assert_eq!(sent, all);
        board
    }

    #[test]
    fn a_round_has_every_column_once() {
        for columns in [1, 100, 101, 2000] {
            after_the_first_round(columns);
        }
    }

    #[test]
    fn a_column_of_which_nothing_is_known_is_in_no_message() {
        let mut board = StatusBoard::new(["c0", "c1"].map(str::to_owned));
        board.update(1, damaged(1));
        let ids = |batches: Vec<StatusBatch>| -> Vec<(bool, Vec<String>)> {
            let ids = |it: StatusBatch| it.columns.into_iter().map(|it| it.column_id).collect();
            batches.into_iter().map(|it| (it.of_all, ids(it))).collect()
        };
        let c = |number: usize| format!("c{number}");
        assert_eq!(ids(board.due(at(0))), [(false, vec![c(1)])]);
        board.update(0, damaged(0));
        assert_eq!(ids(board.due(at(200))), [(true, vec![c(0), c(1)])]);
        // One that stays unknown does not keep the others back.
        let mut board = StatusBoard::new(["c0", "c1"].map(str::to_owned));
        board.update(1, damaged(1));
        assert_eq!(ids(board.due(at(10_000))), [(true, vec![c(1)])]);
    }

    #[test]
    fn changes_are_sent_ten_times_per_second_at_most_and_repetitions_never() {
        let mut board = after_the_first_round(3);
        assert_eq!(board.due(at(150)), []);
        board.update(2, damaged(2));
        assert_eq!(board.due(at(99)), []);
        assert_eq!(board.rest(at(60)), at(40));
        let batches = board.due(at(160));
        assert_eq!(batches.len(), 1);
        assert!(!batches[0].of_all);
        assert_eq!(batches[0].columns[0].column_id, "c2");
        // NaN is the same as NaN.
        board.update(2, damaged(2));
        assert_eq!(board.due(at(400)), []);
        assert_eq!(board.rest(at(400)), at(9_600));
    }

    #[test]
    fn a_round_comes_every_ten_seconds_and_for_every_reader() {
        let mut board = after_the_first_round(3);
        board.update(1, damaged(1));
        board.want_round();
        let batches = board.due(at(5_000));
        assert!(batches.len() == 1 && batches[0].of_all);
        assert_eq!(batches[0].columns[1].residual_v1, 0.01);
        assert_eq!(board.due(at(5_200)), [], "the change was in the round");
        assert!(board.due(at(14_999)).is_empty());
        assert!(board.due(at(15_000))[0].of_all);
    }
}
