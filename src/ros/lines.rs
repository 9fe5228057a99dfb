//! Lines that show the twin's messages to people.

use std::time::{Duration, Instant};

use crate::column::HINGE_NAMES;
use crate::messages::column_twin::{ColumnState, HingeForces, ImpactReport, TwinStatus};

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
}

/// Minimum time between two lines of state.
const STATE_LINES: Duration = Duration::from_millis(100);

/// Converts messages to lines, omitting repetitions.
#[derive(Debug, Default)]
pub(super) struct WatchLines {
    last_state: Option<(Instant, u8)>,
    last_status: Option<(u8, u64, u64)>,
}

impl WatchLines {
    /// The line for a message; `None` if it says nothing new or follows too soon.
    pub(super) fn line(&mut self, seen: &Seen, now: Instant) -> Option<String> {
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
                report.event_id, report.severity_reason
            )),
            Seen::Forecast(report) if report.kind == ImpactReport::NO_FORECAST => Some(format!(
                "no forecast of {}: {}",
                report.event_id, report.severity_reason
            )),
            // It is published again with the error of its time step.
            Seen::Forecast(report) if !report.error_estimate.is_nan() => Some(format!(
                "forecast of {}: the time step makes an error of about {:.2e} of the largest v1",
                report.event_id, report.error_estimate
            )),
            Seen::Forecast(report) => Some(report_line("forecast", report)),
            Seen::Report(report) => Some(report_line("result", report)),
            Seen::Forces(_) => None,
            Seen::Status(status) => {
                let state = (
                    status.phase,
                    status.events_refused,
                    status.parameters_refused,
                );
                let before = self.last_status.replace(state);
                (before != Some(state)).then(|| status_line(status, before))
            }
        }
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

/// One line about a forecast or a result; `kind` is the word for either.
pub fn report_line(kind: &str, report: &ImpactReport) -> String {
    let outcome = match report.outcome {
        ImpactReport::ELASTIC => "elastic",
        ImpactReport::PLASTIC => "plastic",
        ImpactReport::COLLAPSED => "COLLAPSED",
        ImpactReport::SEVERED => "SEVERED",
        _ => "unknown",
    };
    let hinges: Vec<_> = HINGE_NAMES
        .iter()
        .zip(report.plastic_rotation)
        .filter(|(_, rotation)| *rotation != 0.0)
        .map(|(name, rotation)| format!("{name} {:.2}", 1e3 * rotation))
        .collect();
    let hinges = if hinges.is_empty() {
        String::new()
    } else {
        format!(", plastic rotations [mrad] {}", hinges.join(" "))
    };
    let crush = match &report.max_crush[..] {
        [] => String::new(),
        [front, ..] => format!(", front crushed by {:.0} mm", 1e3 * front),
    };
    format!(
        "{kind} of {}: severity {}: {} Vehicle {}: {outcome}, v1 up to {:.2} mm after {:.4} s, residual {:.2} mm{hinges}{crush}, \
         N_u {:.0} kN of {:.0} kN (computed in {:.2} ms)",
        report.event_id,
        severity_word(report.severity),
        report.severity_reason,
        vehicle_word(&report.vehicle),
        1e3 * report.max_v1,
        report.max_v1_time,
        1e3 * report.residual_v1,
        1e-3 * report.residual_capacity,
        1e-3 * report.virgin_capacity,
        1e3 * report.compute_time
    )
}

/// The word for a severity in `ImpactReport` and `TwinStatus`.
#[must_use]
pub fn severity_word(severity: u8) -> &'static str {
    match severity {
        ImpactReport::SEVERITY_NONE => "none",
        ImpactReport::SEVERITY_INSPECT => "inspect",
        ImpactReport::SEVERITY_RESTRICT => "RESTRICT",
        ImpactReport::SEVERITY_PROP => "PROP",
        ImpactReport::SEVERITY_EVACUATE => "EVACUATE",
        _ => "unknown",
    }
}

fn vehicle_word(name: &str) -> &str {
    match name {
        "" => "by numbers",
        name => name,
    }
}

fn status_line(status: &TwinStatus, before: Option<(u8, u64, u64)>) -> String {
    let refused_since = before.is_some_and(|(_, events, parameters)| {
        status.events_refused > events || status.parameters_refused > parameters
    });
    if refused_since {
        return format!("rejected: {}", status.last_refusal_reason);
    }
    let fault = match status.fault.as_str() {
        "" => String::new(),
        fault => format!(": {fault}"),
    };
    format!(
        "{} {}{fault}; {} impacts since the last reset, residual {:.2} mm, severity {}{}",
        status.column_id,
        phase_word(status.phase),
        status.impacts_since_reset,
        1e3 * status.residual_v1,
        severity_word(status.severity),
        match status.severity {
            TwinStatus::SEVERITY_NONE => String::new(),
            _ => format!(": {}", status.severity_reason),
        }
    )
}

fn phase_word(phase: u8) -> &'static str {
    match phase {
        ColumnState::IDLE => "idle",
        ColumnState::APPROACH => "approach",
        ColumnState::CONTACT => "contact",
        ColumnState::FREE => "free",
        ColumnState::REST => "rest",
        ColumnState::COLLAPSED => "COLLAPSED",
        ColumnState::FAULTED => "FAULTED",
        ColumnState::SEVERED => "SEVERED",
        _ => "unknown",
    }
}

#[cfg(test)]
mod tests {
    use super::super::client::refused;
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
    fn a_status_is_shown_only_when_it_changes() {
        let mut lines = WatchLines::default();
        let now = Instant::now();
        assert!(
            lines
                .line(&refused("a", 1), now)
                .is_some_and(|line| line.contains("idle"))
        );
        assert!(lines.line(&refused("a", 1), now).is_none());
        assert_eq!(
            lines.line(&refused("b", 2), now),
            Some("rejected: too fast".to_owned())
        );
    }
}
