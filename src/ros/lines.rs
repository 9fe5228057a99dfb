//! Lines that show the twin's messages to people.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use crate::column::{HINGE_NAMES, WEB_NAMES};
use crate::messages::column_twin_msgs::{
    ColumnState, FleetStatus, HingeForces, ImpactEstimate, ImpactReport, TwinStatus,
};
use crate::messages::words::{
    action_alone, estimate_line, phase_word, range_in_words, verdict_in_words,
};
pub use crate::messages::words::{action_word, actions_in_words, decision_word, in_unit};

/// A message of the twin.
#[derive(Debug, Clone)]
pub enum Seen {
    /// State of the column.
    State(ColumnState),
    /// Forces in the hinges.
    Forces(HingeForces),
    /// Forecast of a response.
    Forecast(ImpactReport),
    /// Result of a response.
    Report(ImpactReport),
    /// Status of the twin.
    Status(TwinStatus),
    /// What the sensors say about an impact.
    Estimate(Box<ImpactEstimate>),
    /// Status of columns of a fleet.
    Fleet(FleetStatus),
    /// Messages on a reliable topic were lost before the next one.
    Missed {
        /// Name of the topic.
        topic: &'static str,
        /// Number of lost messages.
        count: u64,
    },
}

impl Seen {
    /// Topic, column and stamp \[ns\] of a message that publishers keep for late joiners; `None` for the others.
    fn kept(&self) -> Option<(u8, &str, Option<i64>)> {
        let (topic, header, column_id) = match self {
            Seen::State(_) | Seen::Forces(_) | Seen::Fleet(_) | Seen::Missed { .. } => return None,
            Seen::Forecast(report) => (0, &report.header, &report.column_id),
            Seen::Report(report) => (1, &report.header, &report.column_id),
            Seen::Status(status) => (2, &status.header, &status.column_id),
            Seen::Estimate(estimate) => (3, &estimate.header, &estimate.column_id),
        };
        Some((topic, column_id, header.stamp.to_nanos()))
    }
}

/// Minimum time between two lines of state.
const STATE_LINES: Duration = Duration::from_millis(100);

/// Minimum time between two lines about lost messages. What is lost meanwhile is part of the next one.
const MISSED_LINES: Duration = Duration::from_secs(1);

/// Maximum number of columns whose last critical velocities are kept: anybody may send names of columns.
const MAX_COLUMNS: usize = 2_000;

/// Time from the first message on in which those arrive that publishers keep for late joiners.
const HISTORY_ARRIVES: Duration = Duration::from_millis(500);

/// The messages that publishers keep for late joiners.
#[derive(Debug)]
enum History {
    /// None has arrived.
    Awaited,
    /// The newest one of each topic and column, until all of them have arrived.
    Arriving { since: Instant, newest: Vec<Seen> },
    /// Messages are new from now on.
    Shown,
}

/// Converts messages to lines, omitting repetitions.
#[derive(Debug)]
pub(super) struct WatchLines {
    history: History,
    last_state: Option<(Instant, u8)>,
    last_status: Option<(u8, u64, u64)>,
    /// The last critical velocities that were shown, by column.
    last_critical: BTreeMap<String, Vec<CriticalVelocities>>,
    /// Event and stamp of the last result that was shown, by column.
    last_result: BTreeMap<String, (String, Option<i64>)>,
    /// Lost messages that have not been shown yet, by topic, and when the last ones were shown.
    missed: BTreeMap<&'static str, u64>,
    last_missed: Option<Instant>,
}

impl Default for WatchLines {
    fn default() -> Self {
        Self {
            history: History::Awaited,
            last_state: None,
            last_status: None,
            last_critical: BTreeMap::new(),
            last_result: BTreeMap::new(),
            missed: BTreeMap::new(),
            last_missed: None,
        }
    }
}

impl WatchLines {
    /// The lines for a message, or for a time without one.
    ///
    /// Of the messages that the twin keeps for late joiners only the newest of each topic is shown, whichever order they
    /// arrive in: some publishers send everything that they ever published.
    pub(super) fn lines(&mut self, seen: Option<Seen>, now: Instant) -> Vec<String> {
        let arrived = match &self.history {
            History::Arriving { since, .. } => {
                now.saturating_duration_since(*since) >= HISTORY_ARRIVES
            }
            History::Awaited | History::Shown => false,
        };
        let mut due = Vec::new();
        if arrived
            && let History::Arriving { mut newest, .. } =
                std::mem::replace(&mut self.history, History::Shown)
        {
            newest.sort_by_key(|seen| seen.kept().and_then(|(_, _, stamp)| stamp));
            due = newest;
        }
        due.extend(seen.and_then(|seen| self.not_history(seen, now)));
        let lines = due
            .iter()
            .flat_map(|seen| [self.line(seen, now), self.critical_line(seen)]);
        let mut lines: Vec<_> = lines.flatten().collect();
        lines.extend(self.missed_line(now));
        lines
    }

    /// The line about lost messages.
    fn missed_line(&mut self, now: Instant) -> Option<String> {
        let since = self
            .last_missed
            .map(|last| now.saturating_duration_since(last));
        if self.missed.is_empty() || since.is_some_and(|since| since < MISSED_LINES) {
            return None;
        }
        self.last_missed = Some(now);
        let missed = std::mem::take(&mut self.missed);
        let counts = missed
            .iter()
            .map(|(topic, count)| format!("{count} on {topic}"));
        Some(format!(
            "messages were lost, while the network was interrupted or this program was stopped or too slow: {}",
            counts.collect::<Vec<_>>().join(", ")
        ))
    }

    /// Returns the message unless it is, or may be, one that is kept for late joiners.
    fn not_history(&mut self, seen: Seen, now: Instant) -> Option<Seen> {
        let Some((topic, column_id, stamp)) = seen.kept() else {
            return Some(seen);
        };
        match &mut self.history {
            History::Shown => return Some(seen),
            History::Awaited => {
                self.history = History::Arriving {
                    since: now,
                    newest: vec![seen],
                };
            }
            History::Arriving { newest, .. } => {
                let other = newest.iter_mut().find(|other| {
                    other
                        .kept()
                        .is_some_and(|(other, of, _)| (other, of) == (topic, column_id))
                });
                match other {
                    None => newest.push(seen),
                    Some(other) if other.kept().is_some_and(|(_, _, than)| stamp >= than) => {
                        *other = seen;
                    }
                    Some(_) => {}
                }
            }
        }
        None
    }

    /// The line for a message; `None` if it says nothing new or follows too soon.
    fn line(&mut self, seen: &Seen, now: Instant) -> Option<String> {
        match seen {
            Seen::State(state) => {
                let last = self.last_state;
                let spaced = last.is_none_or(|(at, phase)| {
                    phase != state.phase || now.saturating_duration_since(at) >= STATE_LINES
                });
                spaced.then(|| {
                    self.last_state = Some((now, state.phase));
                    state_line(state)
                })
            }
            Seen::Forecast(report) if report.kind == ImpactReport::WITHDRAWN => Some(format!(
                "the forecast of {} no longer holds: {}",
                report.event_id, report.action_reason
            )),
            Seen::Forecast(report) if report.kind == ImpactReport::NO_FORECAST => Some(format!(
                "no forecast of {}: {}",
                report.event_id, report.action_reason
            )),
            // Forecast and result are published again with the range of the verdict.
            Seen::Forecast(report) if range_of(report).is_some() => range_line("forecast", report),
            Seen::Report(report) if self.has_shown_result(report) => range_line("result", report),
            // It is published again with the error of its time step.
            Seen::Forecast(report) if !report.error_estimate.is_nan() => Some(format!(
                "forecast of {}: the time step makes an error of about {:.2e} of the peak displacement",
                report.event_id, report.error_estimate
            )),
            Seen::Forecast(report) => Some(report_line("forecast", report)),
            Seen::Report(report) => Some(report_line("result", report)),
            Seen::Estimate(estimate) => Some(estimate_line(estimate)),
            Seen::Forces(_) | Seen::Fleet(_) => None,
            Seen::Missed { topic, count } => {
                *self.missed.entry(topic).or_default() += count;
                None
            }
            Seen::Status(status) => {
                let state = (
                    status.phase,
                    status.events_rejected,
                    status.parameters_rejected,
                );
                let before = self.last_status.replace(state);
                (before != Some(state)).then(|| status_line(status, before))
            }
        }
    }

    /// Whether the result of this impact is the last of its column that was shown.
    fn has_shown_result(&mut self, report: &ImpactReport) -> bool {
        let impact = (report.event_id.clone(), report.header.stamp.to_nanos());
        if self.last_result.get(&report.column_id) == Some(&impact) && range_of(report).is_some() {
            return true;
        }
        if self.last_result.len() == MAX_COLUMNS {
            self.last_result.clear();
        }
        self.last_result.insert(report.column_id.clone(), impact);
        false
    }

    /// The line about critical velocities that have not been shown yet.
    fn critical_line(&mut self, seen: &Seen) -> Option<String> {
        let Seen::Status(status) = seen else {
            return None;
        };
        let critical = critical_velocities(status);
        if critical.is_empty() || self.last_critical.get(&status.column_id) == Some(&critical) {
            return None;
        }
        if self.last_critical.len() == MAX_COLUMNS {
            self.last_critical.clear();
        }
        let line = critical_line(&status.column_id, &critical);
        self.last_critical
            .insert(status.column_id.clone(), critical);
        Some(line)
    }
}

fn state_line(state: &ColumnState) -> String {
    format!(
        "{:9} t {:7.4} s  v1 {:8.2} mm  u2 {:7.2} mm  contact {:8.1} kN",
        phase_word(state.phase),
        state.time,
        1e3 * state.v1,
        1e3 * state.u2,
        1e-3 * state.contact_force
    )
}

/// The range of the verdict in words; `None` where it is not known.
pub fn range_of(report: &ImpactReport) -> Option<String> {
    range_in_words(
        report.range_least,
        report.range_most,
        report.range_at_least,
        &report.range_decided_by,
    )
}

/// One line about the range of the verdict in a forecast or a result.
fn range_line(kind: &str, report: &ImpactReport) -> Option<String> {
    let range = range_of(report)?;
    Some(format!(
        "{kind} of {}: action {}; range {range}",
        report.event_id,
        action_alone(report.action, &report.action_reason)
    ))
}

/// One line about a forecast or a result; `kind` is the word for either.
pub fn report_line(kind: &str, report: &ImpactReport) -> String {
    let outcome = match report.outcome {
        ImpactReport::ELASTIC => "elastic",
        ImpactReport::PLASTIC => "plastic",
        ImpactReport::COLLAPSED => "COLLAPSED",
        ImpactReport::FRACTURED => "FRACTURED",
        _ => "unknown",
    };
    let hinges: Vec<_> = HINGE_NAMES
        .iter()
        .zip(&*report.plastic_rotation)
        .filter(|(_, rotation)| **rotation != 0.0)
        .map(|(name, rotation)| format!("{name} {:.2}", 1e3 * rotation))
        .collect();
    let hinges = if hinges.is_empty() {
        String::new()
    } else {
        format!(", plastic rotations [mrad] {}", hinges.join(" "))
    };
    let webs: String = WEB_NAMES
        .iter()
        .zip(&*report.shear_angle)
        .filter(|(_, angle)| **angle != 0.0 && angle.is_finite())
        .map(|(name, angle)| format!(", web {name} sheared by {:.2} mrad", 1e3 * angle))
        .collect();
    let crush = match &report.max_crush[..] {
        [] => String::new(),
        [front, ..] => format!(", front crushed by {:.0} mm", 1e3 * front),
    };
    let range = range_of(report).map_or(String::new(), |it| format!(" Range: {it}."));
    // A column that collapses or fractures has none.
    let residual = match report.residual_v1.is_finite() {
        true => residual_in_words(report.residual_v1),
        false => String::new(),
    };
    format!(
        "{kind} of {}: {}{range} Vehicle {}: {outcome}, v1 up to {:.2} mm after {:.4} s{residual}{hinges}{webs}{crush}, \
         push-down {:.0} kN of {:.0} kN (computed in {:.2} ms)",
        report.event_id,
        verdict_in_words(report.action, &report.action_reason),
        vehicle_word(&report.vehicle),
        1e3 * report.max_v1,
        report.max_v1_time,
        1e-3 * report.residual_capacity,
        1e-3 * report.undamaged_capacity,
        1e3 * report.compute_time
    )
}

/// What remains of an elastic response may be negative by round-off.
fn residual_in_words(v1: f64) -> String {
    let text = format!(", residual {:.2} mm", 1e3 * v1);
    text.replace(" -0.00 ", " 0.00 ")
}

fn vehicle_word(name: &str) -> &str {
    match name {
        "" => "user-defined",
        name => name,
    }
}

fn status_line(status: &TwinStatus, before: Option<(u8, u64, u64)>) -> String {
    let rejected_since = before.is_some_and(|(_, events, parameters)| {
        status.events_rejected > events || status.parameters_rejected > parameters
    });
    if rejected_since {
        return format!("rejected: {}", status.last_rejection_reason);
    }
    let fault = match status.fault.as_str() {
        "" => String::new(),
        fault => format!(": {fault}"),
    };
    let range = range_in_words(
        status.range_least,
        status.range_most,
        status.range_at_least,
        &status.range_decided_by,
    );
    // Of a column that nothing has hit, the reason says nothing new.
    let verdict = match (status.action, status.impacts_since_reset) {
        (TwinStatus::ACTION_NONE, 0) => action_alone(status.action, &status.action_reason),
        (action, _) => verdict_in_words(action, &status.action_reason),
    };
    // A verdict with a reason ends its sentence itself.
    let range = range.map_or(String::new(), |it| match verdict.ends_with('.') {
        true => format!(" Range: {it}."),
        false => format!("; range {it}"),
    });
    // The displacement at which the response of such a column ended is not one that remains.
    let residual = match status.phase {
        TwinStatus::COLLAPSED | TwinStatus::FRACTURED => String::new(),
        _ => residual_in_words(status.residual_v1),
    };
    let impacts = match status.impacts_since_reset {
        1 => "1 impact".to_owned(),
        number => format!("{number} impacts"),
    };
    format!(
        "{} {}{fault}; {impacts} since the last reset{residual}; {verdict}{range}",
        status.column_id,
        phase_word(status.phase),
    )
}

/// The critical velocities of one vehicle, as a status has them.
#[derive(Debug, Clone, PartialEq)]
struct CriticalVelocities {
    vehicle: String,
    /// For restrict and evacuate \[m/s\]; `None`: not reached.
    velocities: [Option<f64>; 2],
}

/// The critical velocities in a status, of as many vehicles as all its arrays have.
fn critical_velocities(status: &TwinStatus) -> Vec<CriticalVelocities> {
    let reached = |velocity: &f64| (!velocity.is_nan()).then_some(*velocity);
    let velocities = status.critical_velocity_restrict.iter().map(reached);
    let velocities = velocities.zip(status.critical_velocity_evacuate.iter().map(reached));
    let vehicles = status.critical_vehicle.iter().zip(velocities);
    vehicles
        .map(|(vehicle, (restrict, evacuate))| CriticalVelocities {
            vehicle: vehicle.clone(),
            velocities: [restrict, evacuate],
        })
        .collect()
}

/// The line about critical velocities.
fn critical_line(column_id: &str, critical: &[CriticalVelocities]) -> String {
    let velocity = |velocity: Option<f64>| match velocity {
        None => "-".to_owned(),
        Some(velocity) => format!("{velocity:.1}"),
    };
    let vehicles: Vec<_> = critical
        .iter()
        .map(|it| {
            let [restrict, evacuate] = it.velocities.map(velocity);
            format!("{} {restrict}/{evacuate}", vehicle_word(&it.vehicle))
        })
        .collect();
    format!(
        "{column_id} critical velocities for RESTRICT/EVACUATE in m/s: {}",
        vehicles.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::super::client::rejected;
    use super::*;

    #[test]
    fn states_are_shown_at_intervals_and_when_the_phase_changes() {
        let mut lines = WatchLines::default();
        let start = Instant::now();
        let mut shown = |phase, millis| {
            let state = Seen::State(ColumnState {
                phase,
                ..ColumnState::default()
            });
            lines
                .line(&state, start + Duration::from_millis(millis))
                .is_some()
        };
        let steps = [(2, 0), (2, 50), (3, 60), (3, 100), (3, 160)];
        let seen = steps.map(|(phase, millis)| shown(phase, millis));
        assert_eq!(seen, [true, false, true, false, true]);
    }

    #[test]
    fn lost_messages_are_shown_once_and_not_too_often() {
        let (mut lines, start) = (WatchLines::default(), Instant::now());
        let mut shown = |missed: Option<(&'static str, u64)>, millis| {
            let seen = missed.map(|(topic, count)| Seen::Missed { topic, count });
            let lines = lines.lines(seen, start + Duration::from_millis(millis));
            lines.concat().split_once(": ").map(|it| it.1.to_owned())
        };
        assert_eq!(shown(None, 0), None);
        assert_eq!(shown(Some(("b", 3)), 1).as_deref(), Some("3 on b"));
        assert_eq!(shown(Some(("b", 4)), 2), None);
        assert_eq!(shown(Some(("a", 1)), 3), None);
        assert_eq!(shown(None, 1001).as_deref(), Some("1 on a, 4 on b"));
        assert_eq!(shown(None, 9000), None);
    }

    /// `watch` once gave a fractured column a residual displacement, and its report "residual NaN mm".
    #[test]
    fn a_fractured_column_has_no_residual_displacement() {
        let report = |outcome, residual_v1| ImpactReport {
            outcome,
            residual_v1,
            ..ImpactReport::default()
        };
        let line = report_line("result", &report(ImpactReport::FRACTURED, f64::NAN));
        assert!(
            line.contains("FRACTURED") && !line.contains("residual"),
            "{line}"
        );
        let line = report_line("result", &report(ImpactReport::PLASTIC, 0.0193));
        assert!(line.contains("residual 19.30 mm"), "{line}");
        let status = |phase| TwinStatus {
            phase,
            residual_v1: 0.1273,
            ..TwinStatus::default()
        };
        let line = status_line(&status(TwinStatus::FRACTURED), None);
        assert!(
            line.contains("FRACTURED") && !line.contains("residual"),
            "{line}"
        );
        let line = status_line(&status(TwinStatus::REST), None);
        assert!(line.contains("residual 127.30 mm"), "{line}");
    }

    /// A status with so many impacts since the last reset, and its stamp \[s\].
    fn status(sec: i32, impacts: u32) -> Seen {
        let mut status = TwinStatus {
            impacts_since_reset: impacts,
            ..TwinStatus::default()
        };
        status.header.stamp.sec = sec;
        Seen::Status(status)
    }

    #[test]
    fn watch_does_not_show_old_statuses_first() {
        let mut lines = WatchLines::default();
        let start = Instant::now();
        // The newest in the middle, as after a retransmission.
        for (sec, impacts) in [(1, 1), (3, 3), (2, 2)] {
            assert!(lines.lines(Some(status(sec, impacts)), start).is_empty());
        }
        let shown = lines.lines(None, start + HISTORY_ARRIVES);
        assert_eq!(shown.len(), 1);
        assert!(shown[0].contains("; 3 impacts"), "{shown:?}");
        // From now on messages are shown as they come, also when simulated time has jumped back.
        let rejected = rejected("a", 1);
        assert_eq!(
            lines.lines(Some(rejected), start + HISTORY_ARRIVES).len(),
            1
        );
    }

    #[test]
    fn a_state_is_shown_while_kept_messages_arrive() {
        let mut lines = WatchLines::default();
        let start = Instant::now();
        assert!(lines.lines(Some(status(1, 1)), start).is_empty());
        let state = Seen::State(ColumnState::default());
        assert_eq!(lines.lines(Some(state), start).len(), 1);
    }

    #[test]
    fn critical_velocities_are_shown_once_each_time_they_are_known() {
        let mut lines = WatchLines::default();
        let mut line = |restrict: &[f64], evacuate: &[f64]| {
            lines.critical_line(&Seen::Status(TwinStatus {
                column_id: "c".to_owned(),
                critical_vehicle: vec![String::new(), "mid_car".to_owned()],
                critical_velocity_restrict: restrict.to_vec(),
                critical_velocity_evacuate: evacuate.to_vec(),
                ..TwinStatus::default()
            }))
        };
        assert_eq!(line(&[], &[]), None);
        let first = "c critical velocities for RESTRICT/EVACUATE in m/s: user-defined 0.0/3.5, mid_car 2.5/-";
        assert_eq!(line(&[0.0, 2.5], &[3.5, f64::NAN]), Some(first.to_owned()));
        // They are in every status, and there are none during a response.
        assert_eq!(line(&[0.0, 2.5], &[3.5, f64::NAN]), None);
        assert_eq!(line(&[], &[]), None);
        assert!(line(&[0.0, 2.4], &[3.5, f64::NAN]).is_some());
    }

    #[test]
    fn a_residual_displacement_of_zero_has_no_sign() {
        assert_eq!(residual_in_words(-4e-7), ", residual 0.00 mm");
        assert_eq!(residual_in_words(-4e-3), ", residual -4.00 mm");
    }

    #[test]
    fn the_range_of_a_verdict_has_a_line_of_its_own_once_it_is_known() {
        let mut lines = WatchLines::default();
        let now = Instant::now();
        let unknown = ImpactReport {
            event_id: "e".to_owned(),
            action: ImpactReport::ACTION_SHORE,
            range_least: ImpactReport::ACTION_UNKNOWN,
            range_most: ImpactReport::ACTION_UNKNOWN,
            ..ImpactReport::default()
        };
        let known = ImpactReport {
            range_least: ImpactReport::ACTION_INSPECT,
            range_most: ImpactReport::ACTION_SHORE,
            range_at_least: true,
            range_decided_by: "the height of the hit".to_owned(),
            ..unknown.clone()
        };
        let range = "INSPECT to at least SHORE, decided by the height of the hit";
        let line = lines.line(&Seen::Forecast(known.clone()), now);
        let expected = format!("forecast of e: action SHORE; range {range}");
        assert_eq!(line, Some(expected));
        let line = lines.line(&Seen::Report(unknown), now);
        assert!(line.is_some_and(|it| !it.to_lowercase().contains("range")));
        let line = lines.line(&Seen::Report(known.clone()), now);
        assert_eq!(
            line,
            Some(format!("result of e: action SHORE; range {range}"))
        );
        // Of another impact, whose result was not shown before.
        let other = ImpactReport {
            event_id: "f".to_owned(),
            ..known
        };
        let line = lines.line(&Seen::Report(other), now).expect("shown");
        assert!(
            line.contains(&format!("Range: {range}.")) && line.contains("v1"),
            "{line}"
        );
    }

    /// The status said NONE without a reservation, and the last line about a hit the action without "at least".
    #[test]
    fn an_action_that_is_a_lower_bound_is_nowhere_shown_without_at_least() {
        let reason = "At least NONE: No deciding criterion is exceeded.";
        let mut status = TwinStatus {
            action: TwinStatus::ACTION_NONE,
            action_reason: reason.to_owned(),
            range_least: TwinStatus::ACTION_UNKNOWN,
            ..TwinStatus::default()
        };
        let untouched = status_line(&status, None);
        assert!(untouched.ends_with("; at least NONE"), "{untouched}");
        status.impacts_since_reset = 1;
        let hit = status_line(&status, None);
        assert!(hit.contains("; 1 impact since the last reset"), "{hit}");
        assert!(hit.ends_with(reason), "{hit}");
        let report = ImpactReport {
            event_id: "e".to_owned(),
            action: ImpactReport::ACTION_INSPECT,
            action_reason: "At least INSPECT: Have an engineer examine the column.".to_owned(),
            range_least: ImpactReport::ACTION_INSPECT,
            range_most: ImpactReport::ACTION_EVACUATE,
            range_decided_by: "missing data".to_owned(),
            ..ImpactReport::default()
        };
        let line = range_line("result", &report);
        let expected = "result of e: action at least INSPECT; range INSPECT to EVACUATE, decided by missing data";
        assert_eq!(line.as_deref(), Some(expected));
    }

    /// It was "... and it governs.; range INSPECT to RESTRICT".
    #[test]
    fn the_range_in_a_status_follows_a_whole_sentence() {
        let status = TwinStatus {
            action: TwinStatus::ACTION_RESTRICT,
            action_reason: "Keep people away. The bow governs.".to_owned(),
            range_least: TwinStatus::ACTION_INSPECT,
            range_most: TwinStatus::ACTION_RESTRICT,
            range_decided_by: "the load".to_owned(),
            ..TwinStatus::default()
        };
        let line = status_line(&status, None);
        let expected = "The bow governs. Range: INSPECT to RESTRICT, decided by the load.";
        assert!(line.ends_with(expected), "{line}");
    }

    #[test]
    fn a_status_is_shown_only_when_it_changes() {
        let mut lines = WatchLines::default();
        let now = Instant::now();
        assert!(
            lines
                .line(&rejected("a", 1), now)
                .is_some_and(|line| line.contains("idle"))
        );
        assert!(lines.line(&rejected("a", 1), now).is_none());
        assert_eq!(
            lines.line(&rejected("b", 2), now),
            Some("rejected: too fast".to_owned())
        );
    }
}
