//! Which columns have topics of their own, because somebody listens there. Knows neither topics nor threads.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

/// Most columns that have topics of their own at a time.
pub const MAX_OPEN_COLUMNS: usize = 100;

/// Most endpoints that are created in a second for columns with topics of their own.
pub const MAX_ENDPOINTS_PER_SECOND: u32 = 200;

/// How long the topics of a column stay when their last reader has gone, unless other columns wait for the room.
pub const LINGER: Duration = Duration::from_secs(60);

/// What is to be done for a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DemandChange {
    /// Create its topics.
    Open(u32),
    /// Remove its topics.
    Close(u32),
}

/// A column with readers, or with topics.
#[derive(Debug, Default)]
struct Column {
    readers: usize,
    is_open: bool,
    /// Its topics could not be created. They are tried again for the next reader.
    has_failed: bool,
    /// Since when it has no reader.
    left: Duration,
}

/// The readers of the topics of single columns, and what follows from them. `K` names a reader. Times are those of a steady clock,
/// since any instant.
#[derive(Debug)]
pub struct Demand<K> {
    readers: BTreeMap<K, u32>,
    columns: BTreeMap<u32, Column>,
    open: BTreeSet<u32>,
    linger: Duration,
    /// Time between the openings of two columns.
    spacing: Duration,
    next_opening: Duration,
}

impl<K: Ord> Demand<K> {
    /// For columns with so many endpoints each, which stay for `linger` when their last reader has gone: [`LINGER`] by default.
    #[must_use]
    pub fn new(endpoints: u32, linger: Duration) -> Self {
        Self {
            readers: BTreeMap::new(),
            columns: BTreeMap::new(),
            open: BTreeSet::new(),
            linger,
            spacing: Duration::from_secs(1) * endpoints / MAX_ENDPOINTS_PER_SECOND,
            next_opening: Duration::ZERO,
        }
    }

    /// Takes a reader on a topic of a column; `false` if it was known.
    pub fn joined(&mut self, reader: K, column: u32) -> bool {
        let is_new = self.readers.insert(reader, column).is_none();
        if is_new {
            let column = self.columns.entry(column).or_default();
            column.readers += 1;
            column.has_failed = false;
        }
        is_new
    }

    /// Forgets the readers for which `is_gone` is true; `false` if there are none.
    pub fn left(&mut self, is_gone: impl Fn(&K) -> bool, now: Duration) -> bool {
        let mut any = false;
        let columns = &mut self.columns;
        self.readers.retain(|reader, column| {
            let is_gone = is_gone(reader);
            if is_gone && let Some(column) = columns.get_mut(column) {
                column.readers -= 1;
                column.left = now;
            }
            any |= is_gone;
            !is_gone
        });
        columns.retain(|_, it| it.readers > 0 || it.is_open);
        any
    }

    /// What is to be done now, one column at a time. It counts as done.
    pub fn due(&mut self, now: Duration) -> Option<DemandChange> {
        let waiting = self.next_waiting();
        let is_full = self.open.len() >= MAX_OPEN_COLUMNS;
        if let Some((column, left)) = self.longest_unread()
            && (now.saturating_sub(left) >= self.linger || (is_full && waiting.is_some()))
        {
            self.open.remove(&column);
            self.columns.remove(&column);
            return Some(DemandChange::Close(column));
        }
        let column = waiting.filter(|_| !is_full && now >= self.next_opening)?;
        self.next_opening = now + self.spacing;
        self.open.insert(column);
        self.columns.get_mut(&column)?.is_open = true;
        Some(DemandChange::Open(column))
    }

    /// The time until something may be due; `None`: not before a reader joins or leaves.
    #[must_use]
    pub fn rest(&self, now: Duration) -> Option<Duration> {
        let has_room = self.open.len() < MAX_OPEN_COLUMNS;
        let opening = self.next_waiting().filter(|_| has_room);
        let opening = opening.map(|_| self.next_opening);
        let closing = self.longest_unread().map(|(_, left)| left + self.linger);
        let next = [opening, closing].into_iter().flatten().min()?;
        Some(next.saturating_sub(now))
    }

    /// The topics of a column could not be created.
    pub fn failed(&mut self, column: u32) {
        self.open.remove(&column);
        if let Some(it) = self.columns.get_mut(&column) {
            it.is_open = false;
            it.has_failed = true;
        }
        self.columns.retain(|_, it| it.readers > 0 || it.is_open);
    }

    /// Number of columns that have topics of their own.
    #[must_use]
    pub fn open(&self) -> usize {
        self.open.len()
    }

    /// Number of columns with readers that have no topics, because there is no room, or not yet.
    #[must_use]
    pub fn waiting(&self) -> usize {
        let is_waiting = |it: &&Column| !it.is_open && !it.has_failed;
        self.columns.values().filter(is_waiting).count()
    }

    fn next_waiting(&self) -> Option<u32> {
        let mut columns = self.columns.iter();
        let (column, _) = columns.find(|(_, it)| !it.is_open && !it.has_failed)?;
        Some(*column)
    }

    /// The column whose topics have had no reader for the longest time, and since when.
    fn longest_unread(&self) -> Option<(u32, Duration)> {
        let unread = self.columns.iter().filter(|(_, it)| it.readers == 0);
        unread
            .map(|(column, it)| (*column, it.left))
            .min_by_key(|(_, left)| *left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENDPOINTS: u32 = 8;

    fn demand() -> Demand<u32> {
        Demand::new(ENDPOINTS, LINGER)
    }

    fn seconds(seconds: f64) -> Duration {
        Duration::from_secs_f64(seconds)
    }

    #[test]
    fn topics_come_with_the_first_reader_and_go_some_time_after_the_last() {
        let mut demand = demand();
        assert_eq!(
            (demand.due(seconds(0.0)), demand.rest(seconds(0.0))),
            (None, None)
        );
        assert!(demand.joined(1, 7) && demand.joined(2, 7) && !demand.joined(2, 7));
        assert_eq!(demand.due(seconds(1.0)), Some(DemandChange::Open(7)));
        assert_eq!(
            (demand.due(seconds(1.0)), demand.rest(seconds(1.0))),
            (None, None)
        );
        assert!(demand.left(|it| *it == 1, seconds(2.0)));
        assert_eq!(demand.rest(seconds(2.0)), None);
        assert!(demand.left(|it| *it == 2, seconds(3.0)));
        assert!(!demand.left(|it| *it == 2, seconds(3.0)));
        assert_eq!(
            (demand.due(seconds(62.9)), demand.rest(seconds(62.0))),
            (None, Some(seconds(1.0)))
        );
        // One that comes back in time finds them.
        demand.joined(3, 7);
        assert_eq!(demand.due(seconds(99.0)), None);
        demand.left(|_| true, seconds(100.0));
        assert_eq!(demand.due(seconds(160.0)), Some(DemandChange::Close(7)));
        assert_eq!(
            (
                demand.open(),
                demand.columns.len(),
                demand.rest(seconds(160.0))
            ),
            (0, 0, None)
        );
    }

    #[test]
    fn endpoints_are_created_at_a_limited_rate() {
        let mut demand = demand();
        (0..60).for_each(|it| assert!(demand.joined(it, it)));
        let (mut now, mut endpoints) = (seconds(5.0), 0);
        while demand.waiting() > 0 {
            match demand.due(now) {
                Some(DemandChange::Open(_)) => endpoints += ENDPOINTS,
                Some(DemandChange::Close(column)) => panic!("column {column} has a reader"),
                None => now += demand.rest(now).expect("some wait"),
            }
            let allowed = MAX_ENDPOINTS_PER_SECOND as f64 * (now - seconds(5.0)).as_secs_f64();
            assert!(f64::from(endpoints) <= allowed + f64::from(ENDPOINTS) + 1e-6);
        }
        assert_eq!(endpoints, 60 * ENDPOINTS);
    }

    #[test]
    fn columns_beyond_the_limit_wait_for_those_that_nobody_reads() {
        let mut demand = demand();
        let most = MAX_OPEN_COLUMNS as u32;
        (0..most + 3).for_each(|it| assert!(demand.joined(it, it)));
        let mut now = seconds(0.0);
        for column in 0..most {
            assert_eq!(demand.due(now), Some(DemandChange::Open(column)));
            now += seconds(1.0);
        }
        assert_eq!(
            (demand.due(now), demand.open(), demand.waiting()),
            (None, MAX_OPEN_COLUMNS, 3)
        );
        assert_eq!(demand.rest(now), None);
        // Without waiting for the end of the time that topics stay.
        demand.left(|it| *it == 40, now);
        assert_eq!(demand.due(now), Some(DemandChange::Close(40)));
        assert_eq!(demand.due(now), Some(DemandChange::Open(most)));
        // One that gives up waiting is forgotten.
        demand.left(|it| *it == most + 1, now);
        assert_eq!((demand.due(now), demand.waiting()), (None, 1));
    }

    #[test]
    fn topics_that_cannot_be_created_are_tried_again_for_the_next_reader() {
        let mut demand = demand();
        demand.joined(1, 7);
        assert_eq!(demand.due(seconds(0.0)), Some(DemandChange::Open(7)));
        demand.failed(7);
        assert_eq!(
            (demand.due(seconds(9.0)), demand.open(), demand.waiting()),
            (None, 0, 0)
        );
        demand.joined(2, 7);
        assert_eq!(demand.due(seconds(9.0)), Some(DemandChange::Open(7)));
    }
}
