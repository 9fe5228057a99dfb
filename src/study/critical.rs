//! Critical velocities: how fast a vehicle may be before its impact has a given action.

use serde::Serialize;

use super::study_column::{Evaluation, StudyColumn, StudyError};
use crate::assessment::Action;

/// Relative width of the bracket in which a critical velocity is found.
pub const CRITICAL_TOLERANCE: f64 = 0.01;
/// Largest ratio of two velocities that follow each other in the scan.
const SCAN_RATIO: f64 = 1.1;
/// Actions that a column can reach, least severe first.
pub const ACTIONS: [Action; 4] = [
    Action::Inspect,
    Action::Restrict,
    Action::Shore,
    Action::Evacuate,
];

/// The critical velocity of one action.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum CriticalVelocity {
    /// The action is reached between `below` and `at` \[m/s\], which differ by at most 1 %.
    Between {
        /// The largest velocity found below it at which the action is not reached \[m/s\].
        below: f64,
        /// The smallest velocity found at which the action is reached \[m/s\].
        at: f64,
    },
    /// The action is reached at the lowest velocity of the scan \[m/s\] already.
    AtMost {
        /// The lowest velocity \[m/s\].
        lowest: f64,
    },
    /// The scan found the action at no velocity up to this one \[m/s\].
    Above {
        /// The highest velocity \[m/s\].
        highest: f64,
    },
}

/// The search for the critical velocities of one vehicle, one response at a time, so that it can be done in the background.
///
/// Action need not grow with the velocity: just above the velocity at which a column first yields, for example, it vibrates
/// so that some ranges of velocity make it yield and others in between do not. The critical velocity of an action is
/// therefore defined by the search. First, a scan goes up from the lowest velocity in equal
/// ratios of at most 1.1, until the highest action is found or the highest velocity is reached. Then, the interval in
/// front of the first velocity that has at least the action is halved until it is 1 % wide. Narrower ranges of velocities
/// with a higher action that lie between two velocities of the scan are not found.
///
/// ```
/// use column_twin::parameters::Parameters;
/// use column_twin::study::{CriticalSearch, CriticalVelocity, StudyColumn};
/// use column_twin::assessment::Action;
///
/// let column = StudyColumn::undamaged(&Parameters::default())?;
/// let mut search = CriticalSearch::new(1.0, 20.0);
/// while let Some(velocity) = search.next() {
///     // One response: a node can serve an impact in between.
///     let impact = column.impact(Some("mid_car"), None, velocity)?;
///     search.record(velocity, column.evaluate(&impact)?.action);
/// }
/// assert!(search.responses() <= search.max_responses());
/// if let CriticalVelocity::Between { below, at } = search.critical_velocity(Action::Inspect) {
///     assert!(below < at && at <= 1.01 * below);
/// }
/// # Ok::<(), column_twin::study::StudyError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct CriticalSearch {
    lowest: f64,
    highest: f64,
    /// Intervals of the scan.
    intervals: u32,
    /// Velocities of the scan that are done.
    scanned: u32,
    /// Velocities and their actions, ascending.
    known: Vec<(f64, Action)>,
}

impl CriticalSearch {
    /// A search from `lowest` to `highest` \[m/s\]; the numbers are put in order and kept above 1 mm/s.
    #[must_use]
    pub fn new(lowest: f64, highest: f64) -> Self {
        const SLOWEST: f64 = 1e-3;
        let (lowest, highest) = (
            lowest.min(highest).max(SLOWEST),
            lowest.max(highest).max(SLOWEST),
        );
        let intervals = libm::ceil(libm::log(highest / lowest) / libm::log(SCAN_RATIO));
        Self {
            lowest,
            highest,
            intervals: (intervals as u32).clamp(1, 128),
            scanned: 0,
            known: Vec::new(),
        }
    }

    /// The velocity of the next response \[m/s\]; `None` when the search is over.
    #[must_use]
    pub fn next(&self) -> Option<f64> {
        self.next_for(&ACTIONS)
    }

    /// As [`next`](Self::next), where only the critical velocities of these actions are wanted: fewer responses suffice.
    #[must_use]
    pub fn next_for(&self, wanted: &[Action]) -> Option<f64> {
        let all_found = self
            .known
            .last()
            .is_some_and(|(_, it)| wanted.iter().all(|action| it >= action));
        if !all_found && self.scanned <= self.intervals {
            return Some(self.scan_velocity(self.scanned));
        }
        // A class is found with those below it, so that one response often serves several.
        wanted.iter().find_map(|action| {
            let (below, at) = self.bracket(*action)?;
            (at > (1.0 + CRITICAL_TOLERANCE) * below).then(|| libm::sqrt(below * at))
        })
    }

    /// The velocity of the scan of this number.
    fn scan_velocity(&self, number: u32) -> f64 {
        match number {
            0 => self.lowest,
            number if number == self.intervals => self.highest,
            number => {
                let part = f64::from(number) / f64::from(self.intervals);
                self.lowest * libm::pow(self.highest / self.lowest, part)
            }
        }
    }

    /// Takes the action at a velocity \[m/s\]: that of [`next`](Self::next), or one that is known from elsewhere.
    pub fn record(&mut self, velocity: f64, action: Action) {
        if self.scanned <= self.intervals && velocity == self.scan_velocity(self.scanned) {
            self.scanned += 1;
        }
        let place = self.known.partition_point(|(known, _)| *known < velocity);
        if self
            .known
            .get(place)
            .is_none_or(|(known, _)| *known != velocity)
        {
            self.known.insert(place, (velocity, action));
        }
    }

    /// The velocities around the lowest known crossing; `None` if there is no crossing.
    fn bracket(&self, action: Action) -> Option<(f64, f64)> {
        let at = self.known.iter().position(|(_, found)| *found >= action)?;
        let below = at.checked_sub(1)?;
        Some((self.known[below].0, self.known[at].0))
    }

    /// The critical velocity of this action, as far as the search is; [`next`](Self::next) tells whether it is over.
    #[must_use]
    pub fn critical_velocity(&self, action: Action) -> CriticalVelocity {
        match self.bracket(action) {
            Some((below, at)) => CriticalVelocity::Between { below, at },
            None if self.known.first().is_some_and(|(_, it)| *it >= action) => {
                CriticalVelocity::AtMost {
                    lowest: self.lowest,
                }
            }
            None => CriticalVelocity::Above {
                highest: self
                    .known
                    .last()
                    .map_or(self.lowest, |(velocity, _)| *velocity),
            },
        }
    }

    /// Responses so far.
    #[must_use]
    pub fn responses(&self) -> usize {
        self.known.len()
    }

    /// An upper bound of the number of responses.
    #[must_use]
    pub fn max_responses(&self) -> usize {
        let ratio = libm::log(self.highest / self.lowest) / f64::from(self.intervals);
        let halvings =
            libm::ceil(libm::log2(ratio / libm::log1p(CRITICAL_TOLERANCE))).max(0.0) as usize;
        // One more halving, because rounding may leave a bracket just above the tolerance.
        self.intervals as usize + 1 + ACTIONS.len() * (halvings + 1)
    }
}

/// The critical velocities of a vehicle on a column, at once.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CriticalVelocities {
    /// One for each of [`ACTIONS`].
    pub velocities: [CriticalVelocity; ACTIONS.len()],
    /// Number of responses.
    pub responses: usize,
}

impl StudyColumn {
    /// The critical velocities of a vehicle between `lowest` and `highest` \[m/s\]: that of the parameters, where none is named;
    /// its own mass or that of the parameters, where no mass \[kg\] is given. [`CriticalSearch`] defines them.
    ///
    /// # Errors
    /// An impact that is out of range, or a step that does not converge.
    pub fn critical_velocities(
        &self,
        vehicle: Option<&str>,
        mass: Option<f64>,
        [lowest, highest]: [f64; 2],
    ) -> Result<CriticalVelocities, StudyError> {
        if let Some(column) = self.struck_by(vehicle)? {
            return column.critical_velocities(vehicle, mass, [lowest, highest]);
        }
        let mut search = CriticalSearch::new(lowest, highest);
        while let Some(velocity) = search.next() {
            let impact = self.impact(vehicle, mass, velocity)?;
            let Evaluation { action, .. } = self.evaluate(&impact)?;
            search.record(velocity, action);
        }
        Ok(CriticalVelocities {
            velocities: ACTIONS.map(|action| search.critical_velocity(action)),
            responses: search.responses(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn search(lowest: f64, highest: f64, action: impl Fn(f64) -> Action) -> CriticalSearch {
        let mut search = CriticalSearch::new(lowest, highest);
        while let Some(velocity) = search.next() {
            search.record(velocity, action(velocity));
            assert!(search.responses() <= search.max_responses());
        }
        search
    }

    /// Against thresholds that are known.
    #[test]
    fn known_thresholds_are_found_to_one_per_cent() {
        let thresholds = [0.7, 3.3, 3.4, 41.0];
        let action = |velocity: f64| {
            let reached = thresholds.iter().filter(|it| velocity >= **it).count();
            [Action::None]
                .into_iter()
                .chain(ACTIONS)
                .nth(reached)
                .expect("an action")
        };
        let found = search(0.5, 60.0, action);
        for (action, threshold) in ACTIONS.into_iter().zip(thresholds) {
            let CriticalVelocity::Between { below, at } = found.critical_velocity(action) else {
                panic!("{action}");
            };
            assert!(
                below < threshold && threshold <= at && at <= 1.01 * below,
                "{action}"
            );
        }
        assert!(found.responses() < 80, "{}", found.responses());
    }

    #[test]
    fn what_lies_outside_of_the_range_is_said() {
        let always = search(2.0, 30.0, |_| Action::Restrict);
        assert_eq!(
            always.critical_velocity(Action::Restrict),
            CriticalVelocity::AtMost { lowest: 2.0 }
        );
        assert_eq!(
            always.critical_velocity(Action::Shore),
            CriticalVelocity::Above { highest: 30.0 }
        );
    }

    /// Action falls again above 8 m/s: the lowest crossing counts.
    #[test]
    fn the_lowest_crossing_of_the_scan_counts() {
        let action = |velocity: f64| match velocity {
            4.0..8.0 => Action::Shore,
            20.0.. => Action::Evacuate,
            _ => Action::None,
        };
        let found = search(1.0, 50.0, action);
        for action in [Action::Inspect, Action::Restrict, Action::Shore] {
            let critical = found.critical_velocity(action);
            let CriticalVelocity::Between { below, at } = critical else {
                panic!("{critical:?}");
            };
            assert!(below < 4.0 && (4.0..4.04).contains(&at));
        }
    }

    /// A search that is continued from a copy ends as one that is not.
    #[test]
    fn a_search_can_be_interrupted_and_continued() {
        let action = |velocity: f64| {
            if velocity < 9.0 {
                Action::None
            } else {
                Action::Evacuate
            }
        };
        let whole = search(1.0, 50.0, action);
        let mut parts = CriticalSearch::new(1.0, 50.0);
        while let Some(velocity) = parts.next() {
            let mut continued = parts.clone();
            assert_eq!(continued.next(), Some(velocity));
            continued.record(velocity, action(velocity));
            parts = continued;
        }
        assert_eq!(parts, whole);
    }
}
