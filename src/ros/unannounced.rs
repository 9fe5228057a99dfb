//! Which parameters have not been announced on `/parameter_events` as new yet, and when they are.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use super::face::Face;

/// Maximum wait for a first reader of `/parameter_events` before the parameters are announced without one. Discovery between ROS 2
/// programs takes up to 3.5 s.
const MAX_WAIT_FOR_READER: Duration = Duration::from_secs(5);

/// Time between two announcements of parameters. That of a column takes some 10 kB, of which a network, and a reader that keeps the
/// newest 1000 messages, are to be spared a burst from a fleet of 2000 columns.
const ANNOUNCEMENT_PERIOD: Duration = Duration::from_millis(10);

/// The parameters that have not been announced, column by column.
pub(super) struct Unannounced {
    /// The columns; `None`: the parameters of the node of a fleet.
    left: BTreeSet<Option<u32>>,
    /// When the next ones are announced, with or without a reader.
    due: Instant,
    /// None have been announced, because there was no reader.
    awaits_reader: bool,
}

impl Unannounced {
    pub fn new(face: &Face) -> Self {
        let columns = (0..).zip(face.ids()).map(|(column, _)| Some(column));
        let of_node = face.is_fleet().then_some(None);
        Self {
            left: of_node.into_iter().chain(columns).collect(),
            due: Instant::now() + MAX_WAIT_FOR_READER,
            awaits_reader: true,
        }
    }

    /// Those that are to be announced now, if any are.
    pub fn next(
        &mut self,
        now: Instant,
        at_once: bool,
        has_reader: impl FnOnce() -> bool,
    ) -> Option<Option<u32>> {
        if self.left.is_empty() {
            return None;
        }
        if !at_once && now < self.due && !(self.awaits_reader && has_reader()) {
            return None;
        }
        self.awaits_reader = false;
        self.due = now + ANNOUNCEMENT_PERIOD;
        self.left.pop_first()
    }

    /// Whether those of a column, which are about to change, have to be announced before.
    pub fn take(&mut self, column: u32) -> bool {
        self.left.remove(&Some(column))
    }

    /// Time until the next ones are due.
    pub fn wait(&self) -> Duration {
        match self.left.is_empty() {
            true => Duration::MAX,
            false => self.due.saturating_duration_since(Instant::now()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fleet_announces_its_node_and_each_column_once() {
        let names = ["a3", "a4", "a5"].map(Into::into).to_vec();
        let mut left = Unannounced::new(&Face::of_many(names.clone(), names));
        let now = Instant::now();
        assert_eq!(left.next(now, false, || false), None);
        assert_eq!(left.next(now, false, || true), Some(None));
        // The next one has to wait, unless its parameters change.
        assert_eq!(left.next(now, false, || true), None);
        assert!(left.take(1) && !left.take(1));
        let due = now + ANNOUNCEMENT_PERIOD;
        assert_eq!(left.next(due, false, || false), Some(Some(0)));
        assert_eq!(left.next(now, true, || true), Some(Some(2)));
        assert_eq!(left.next(now, true, || true), None);
        assert_eq!(left.wait(), Duration::MAX);
    }

    #[test]
    fn a_single_twin_has_no_parameters_beside_those_of_its_column() {
        let mut left = Unannounced::new(&Face::of_one("a3"));
        assert_eq!(left.next(Instant::now(), true, || false), Some(Some(0)));
        assert_eq!(left.next(Instant::now(), true, || false), None);
    }
}
