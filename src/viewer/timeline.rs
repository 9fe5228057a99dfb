//! The three timelines on which everything is shown.

use std::sync::Arc;

use crate::twin::StateOutput;

/// Time since the impact. Several impacts of one recording follow one another on it; each begins shortly after the end of
/// the previous one.
pub const IMPACT_TIME: &str = "time_since_impact";

/// Steps of the solver, counted like [`IMPACT_TIME`].
pub const STEP: &str = "step";

/// The time given by the stamps.
pub const WALL_CLOCK: &str = "wall_clock";

/// Minimum time between the end of one impact and the beginning of the next on [`IMPACT_TIME`] \[ns\].
const PAUSE: i64 = 10_000_000;

/// Largest correction of the instant of contact of an impact that is under way \[ns\]: a state that is earlier by more belongs to
/// another impact.
const MAX_CORRECTION: i64 = 5_000_000;

/// An instant on all timelines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    /// On [`IMPACT_TIME`] \[ns\].
    pub impact_time: i64,
    /// On [`STEP`].
    pub step: i64,
    /// On [`WALL_CLOCK`]: nanoseconds since the epoch.
    pub wall_clock: i64,
}

/// Places every state on the timelines.
#[derive(Debug, Clone)]
pub struct Timeline {
    step_nanos: i64,
    /// [`IMPACT_TIME`] and [`STEP`] at which counting steps of this length began.
    counted_from: (i64, i64),
    impact: Option<Begun>,
    /// Before everything that is shown.
    first: Moment,
    /// The last moment shown.
    last: Moment,
    /// The impact that the sensors have detected last.
    detected: Option<Begun>,
    /// End on [`IMPACT_TIME`] of what they have read of impacts so far.
    detected_until: i64,
    /// End on [`IMPACT_TIME`] of what was shown of other columns.
    others_until: i64,
}

/// An impact and its beginning on [`IMPACT_TIME`].
#[derive(Debug, Clone, PartialEq)]
struct Begun {
    event_id: Arc<str>,
    begin: i64,
}

/// The place of a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Placed {
    /// Its moment.
    pub moment: Moment,
    /// Whether it is the first state of an impact.
    pub begins: bool,
}

impl Timeline {
    /// Empty timelines for a solver with steps of `step_nanos`.
    #[must_use]
    pub fn new(step_nanos: u64) -> Self {
        let step_nanos = i64::try_from(step_nanos).unwrap_or(i64::MAX).max(1);
        let before = Moment {
            impact_time: -PAUSE,
            step: -PAUSE / step_nanos,
            wall_clock: 0,
        };
        Self {
            step_nanos,
            counted_from: (0, 0),
            impact: None,
            detected: None,
            detected_until: i64::MIN,
            others_until: i64::MIN,
            first: before,
            last: before,
        }
    }

    /// Timelines that go on after what others have shown until then \[ns on [`IMPACT_TIME`]\].
    #[must_use]
    pub fn continued(step_nanos: u64, shown_until: i64) -> Self {
        let mut timeline = Self::new(step_nanos);
        let first = timeline.last.impact_time;
        timeline.last.impact_time = first.max(shown_until);
        timeline.last.step = timeline.step_at(timeline.last.impact_time);
        timeline.first = timeline.last;
        timeline
    }

    /// Lets the next impact begin after what others have shown until then \[ns on [`IMPACT_TIME`]\].
    pub fn continue_after(&mut self, shown_until: i64) {
        self.others_until = self.others_until.max(shown_until);
    }

    /// Changes the length of the steps from here on; the count continues.
    pub fn change_step(&mut self, step_nanos: u64) {
        self.counted_from = (self.last.impact_time, self.last.step);
        self.step_nanos = i64::try_from(step_nanos).unwrap_or(i64::MAX).max(1);
    }

    /// A moment before everything that is shown, whose first impact has this stamp.
    #[must_use]
    pub fn before(&self, stamp: i64) -> Moment {
        Moment {
            wall_clock: stamp.saturating_sub(PAUSE),
            ..self.first
        }
    }

    /// The place of a state. Another `event_id`, or a time that runs backwards, begins another impact. A later estimate of the
    /// same impact may correct its instant of contact a little, so that the times of its states, but not their stamps, go back.
    pub fn place(&mut self, state: &StateOutput) -> Placed {
        let since = nanos(state.sample.time);
        let last = self.last;
        let is_same = |it: &&Begun| *it.event_id == *state.event_id;
        let goes_on = self.impact.as_ref().filter(is_same).is_some_and(|it| {
            let back = last
                .impact_time
                .saturating_sub(it.begin.saturating_add(since));
            back <= 0 || (back <= MAX_CORRECTION && state.stamp > last.wall_clock)
        });
        if !goes_on {
            let is_detected = self.detected.as_ref().filter(is_same);
            let is_detected = is_detected.filter(|it| self.impact.as_ref() != Some(*it));
            let begun = is_detected.cloned().unwrap_or_else(|| Begun {
                event_id: Arc::clone(&state.event_id),
                begin: self.next_begin(),
            });
            self.impact = Some(begun);
        }
        let begin = self.impact.as_ref().map_or(0, |it| it.begin);
        let impact_time = begin.saturating_add(since);
        let impact_time = match goes_on {
            true => impact_time.max(last.impact_time),
            false => impact_time,
        };
        self.last = Moment {
            impact_time,
            step: self.step_at(impact_time),
            wall_clock: state.stamp,
        };
        Placed {
            moment: self.last,
            begins: !goes_on,
        }
    }

    /// The beginning of the next impact on [`IMPACT_TIME`]: after everything that was shown so far, on a whole [`PAUSE`].
    fn next_begin(&self) -> i64 {
        let shown_until = self.shown_until().impact_time.max(self.others_until);
        let after = shown_until.saturating_add(PAUSE);
        after.div_euclid(PAUSE) * PAUSE + PAUSE * i64::from(after % PAUSE != 0)
    }

    /// The sensors have detected an impact up to `secs` after its beginning. Its states may come later, or never.
    pub fn detect(&mut self, event_id: &str, secs: f64) {
        let is_same = |it: &&Begun| *it.event_id == *event_id;
        let known = self.detected.as_ref().filter(is_same);
        let known = known.or(self.impact.as_ref().filter(is_same));
        let begun = known.cloned().unwrap_or_else(|| Begun {
            event_id: event_id.into(),
            begin: self.next_begin(),
        });
        let until = begun.begin.saturating_add(nanos(secs));
        self.detected_until = self.detected_until.max(until);
        self.detected = Some(begun);
    }

    /// Whether the impact that the sensors have detected last is this one.
    #[must_use]
    pub fn has_detected(&self, event_id: &str) -> bool {
        self.detected
            .as_ref()
            .is_some_and(|it| *it.event_id == *event_id)
    }

    /// The moment `secs` after the beginning of the impact that the sensors have detected last, whose contact has this stamp.
    #[must_use]
    pub fn in_detected(&self, secs: f64, stamp: i64) -> Moment {
        self.after(self.detected.as_ref(), secs, stamp)
    }

    /// The moment `secs` after the beginning of the current impact, whose event has this stamp.
    #[must_use]
    pub fn in_impact(&self, secs: f64, stamp: i64) -> Moment {
        self.after(self.impact.as_ref(), secs, stamp)
    }

    fn after(&self, begun: Option<&Begun>, secs: f64, stamp: i64) -> Moment {
        let begin = begun.map_or(0, |it| it.begin);
        let impact_time = begin.saturating_add(nanos(secs));
        Moment {
            impact_time,
            step: self.step_at(impact_time),
            wall_clock: stamp.saturating_add(nanos(secs)),
        }
    }

    /// A moment between impacts that does not overwrite what was shown last.
    pub fn after_last(&mut self, stamp: i64) -> Moment {
        let impact_time = match self.impact {
            None => self.last.impact_time,
            Some(_) => self.last.impact_time.saturating_add(PAUSE),
        };
        self.last = Moment {
            impact_time,
            step: self.step_at(impact_time),
            wall_clock: stamp,
        };
        self.last
    }

    /// The moment of a log line with this stamp.
    #[must_use]
    pub fn at_last(&self, stamp: i64) -> Moment {
        Moment {
            wall_clock: stamp,
            ..self.last
        }
    }

    /// Until when something is shown: the states, and what the sensors have detected.
    #[must_use]
    pub fn shown_until(&self) -> Moment {
        let impact_time = self.last.impact_time.max(self.detected_until);
        Moment {
            impact_time,
            step: self.step_at(impact_time),
            ..self.last
        }
    }

    fn step_at(&self, impact_time: i64) -> i64 {
        let (from, steps) = self.counted_from;
        let since = impact_time.saturating_sub(from);
        let (whole, rest) = (
            since.div_euclid(self.step_nanos),
            since.rem_euclid(self.step_nanos),
        );
        steps + whole + i64::from(rest >= self.step_nanos - rest)
    }
}

/// Seconds as nanoseconds; NaN becomes 0.
pub(super) fn nanos(secs: f64) -> i64 {
    (secs * 1e9).round() as i64 // `as` saturates
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::Sample;
    use crate::twin::TwinPhase;

    fn state(event_id: &str, time: f64) -> StateOutput {
        StateOutput {
            stamp: 0,
            event_id: event_id.into(),
            phase: TwinPhase::Contact,
            sample: Sample {
                time,
                ..Sample::default()
            },
            lengths: None,
            vehicle: None,
        }
    }

    #[test]
    fn the_first_impact_begins_at_zero_and_the_next_follows() {
        let mut timeline = Timeline::new(20_000);
        let mut at = |event, time| {
            let placed = timeline.place(&state(event, time));
            let Moment {
                impact_time, step, ..
            } = placed.moment;
            (placed.begins, impact_time, step)
        };
        assert_eq!(at("a", 0.0), (true, 0, 0));
        assert_eq!(at("a", 0.001), (false, 1_000_000, 50));
        assert_eq!(at("a", 0.057_12), (false, 57_120_000, 2856));
        assert_eq!(at("b", 0.0), (true, 70_000_000, 3500));
        assert_eq!(at("b", 0.001), (false, 71_000_000, 3550));
        // The same identifier after a reset, or a recording that contains the impact twice.
        assert_eq!(at("b", 0.0), (true, 90_000_000, 4500));
        // The steps are five times as long from here on.
        timeline.change_step(100_000);
        let placed = timeline.place(&state("c", 0.0));
        assert_eq!(
            (placed.moment.impact_time, placed.moment.step),
            (100_000_000, 4600)
        );
    }

    #[test]
    fn the_sensors_may_detect_an_impact_before_and_longer_than_it_has_states() {
        let mut timeline = Timeline::new(20_000);
        timeline.detect("a", 0.01);
        assert_eq!(timeline.in_detected(-0.005, 0).impact_time, -5_000_000);
        let placed = timeline.place(&state("a", 0.0));
        assert!(placed.begins);
        assert_eq!(placed.moment.impact_time, 0);
        assert!(!timeline.place(&state("a", 0.05)).begins);
        timeline.detect("a", 0.5);
        // The contact is a millisecond later than it was believed.
        let corrected = StateOutput {
            stamp: 1,
            ..state("a", 0.049)
        };
        let placed = timeline.place(&corrected);
        assert!(!placed.begins);
        assert_eq!(placed.moment.impact_time, 50_000_000);
        let placed = timeline.place(&state("b", 0.0));
        assert!(placed.begins);
        assert_eq!(placed.moment.impact_time, 510_000_000);
        // The final estimate of the first impact disturbs the second one as little as a third one that is detected.
        timeline.detect("a", 0.5);
        assert_eq!(timeline.in_detected(0.5, 0).impact_time, 500_000_000);
        timeline.detect("c", 0.01);
        assert_eq!(timeline.in_detected(0.0, 0).impact_time, 520_000_000);
        let placed = timeline.place(&state("b", 0.001));
        assert!(!placed.begins);
        assert_eq!(placed.moment.impact_time, 511_000_000);
    }

    #[test]
    fn a_moment_between_impacts_overwrites_none_of_them() {
        let mut timeline = Timeline::new(20_000);
        assert_eq!(timeline.after_last(5).impact_time, -10_000_000);
        assert_eq!(timeline.place(&state("a", 0.0)).moment.impact_time, 0);
        assert_eq!(timeline.place(&state("a", 0.05)).moment.step, 2500);
        assert_eq!(timeline.after_last(5).impact_time, 60_000_000);
        assert_eq!(timeline.in_impact(0.02, 7).wall_clock, 20_000_007);
    }
}
