//! Why a command was rejected: a stable code for programs beside a sentence for people.

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// Longest reason of a rejection in characters; a longer one is cut.
pub const MAX_REASON_CHARS: usize = 2_000;

macro_rules! rejection_codes {
    ($($(#[$doc:meta])* $variant:ident = $number:literal $name:literal;)*) => {
        /// Why a command was rejected. The numbers are part of the interface and never change their meaning; they are
        /// the constants `REJECTED_...` of `column_twin_msgs/msg/TwinStatus`.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum RejectionCode {
            $($(#[$doc])* $variant = $number,)*
        }

        impl RejectionCode {
            /// All codes.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// The name in messages that have no field for a code, e.g. `stamp_too_old`.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

rejection_codes! {
    /// The command names another column.
    OtherColumn = 1 "other_column";
    /// `event_id` is empty, too long or has control characters.
    EventIdInvalid = 2 "event_id_invalid";
    /// An impact with this `event_id` was accepted before.
    EventIdRepeated = 3 "event_id_repeated";
    /// The stamp is older than `event.max_age`.
    StampTooOld = 4 "stamp_too_old";
    /// The stamp is further ahead than `event.max_ahead`.
    StampTooFarAhead = 5 "stamp_too_far_ahead";
    /// The stamp is earlier than that of the impact to which the column is responding.
    StampOutOfOrder = 6 "stamp_out_of_order";
    /// Too many accepted impacts are still to come.
    TooManyImpactsAhead = 7 "too_many_impacts_ahead";
    /// A number of the impact is not finite or out of range.
    ImpactOutOfRange = 8 "impact_out_of_range";
    /// The hinges at the impact point cannot move to the height of the impact.
    HeightNotPossible = 9 "height_not_possible";
    /// The column has collapsed.
    ColumnCollapsed = 10 "column_collapsed";
    /// The twin cannot continue after a fault.
    TwinFaulted = 11 "twin_faulted";
    /// The column described by the parameters is impossible.
    ColumnImpossible = 12 "column_impossible";
    /// A parameter is unknown, has the wrong type, is out of range, or contradicts another one.
    ParametersInvalid = 13 "parameters_invalid";
    /// A parameter cannot be changed while the node runs.
    ParametersReadOnly = 14 "parameters_read_only";
    /// The column is damaged, and the damage belongs to these parameters.
    ColumnDamaged = 15 "column_damaged";
    /// With these values the damaged column has no equilibrium.
    NoEquilibrium = 16 "no_equilibrium";
    /// The response could not be computed to its end.
    NotComputed = 17 "not_computed";
    /// The queue of commands is full.
    QueueFull = 18 "queue_full";
    /// The solver did not answer in time.
    NoAnswer = 19 "no_answer";
    /// The node is stopping.
    Stopping = 20 "stopping";
    /// The vehicle is unknown, its name is too long or has control characters, or the mass does not fit to it.
    VehicleInvalid = 21 "vehicle_invalid";
    /// A hinge of the column has passed its ultimate rotation.
    ColumnFractured = 22 "column_fractured";
    /// The vehicle would not reach the column within `response.duration`.
    ApproachTooLong = 23 "approach_too_long";
    /// The sender is not in `senders.allowed`.
    SenderNotAllowed = 24 "sender_not_allowed";
    /// The sender exceeds `senders.max_rate`.
    SenderTooFast = 25 "sender_too_fast";
    /// There is no such estimate, or nothing is left to be decided about it.
    EstimateNotPending = 26 "estimate_not_pending";
    /// The column is responding to an impact.
    NotAtRest = 27 "not_at_rest";
    /// The measurement is not one of this column, or differs so much from the model that its damage cannot be corrected.
    MeasurementImplausible = 28 "measurement_implausible";
    /// The node is managed and not active.
    NotActive = 29 "not_active";
}

impl RejectionCode {
    /// Whether the twin itself rejected, and so has counted and reported it; otherwise the command did not reach the
    /// twin, or the twin did not answer.
    #[must_use]
    pub fn is_from_twin(self) -> bool {
        !matches!(
            self,
            Self::QueueFull
                | Self::NoAnswer
                | Self::Stopping
                | Self::NotActive
                | Self::SenderNotAllowed
                | Self::SenderTooFast
        )
    }

    /// The number in messages.
    #[must_use]
    pub fn number(self) -> u16 {
        self as u16
    }
}

/// Why a command was rejected; it has changed nothing.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(deny_unknown_fields)]
#[error("{reason}")]
pub struct Rejection {
    /// For programs.
    pub code: RejectionCode,
    /// For people, at most [`MAX_REASON_CHARS`] characters.
    pub reason: Arc<str>,
}

impl Rejection {
    /// A rejection with a reason, which is cut where it is too long.
    #[must_use]
    pub fn new(code: RejectionCode, reason: impl fmt::Display) -> Self {
        let reason = reason.to_string();
        Self {
            code,
            reason: truncated(&reason, MAX_REASON_CHARS).into(),
        }
    }

    /// That of a command to which the solver has not answered in time.
    #[cfg(feature = "live")]
    pub(crate) fn no_answer(after_secs: u64) -> Self {
        let reason = format!(
            "the solver did not answer within {after_secs} s; the command may still be executed, see twin_status"
        );
        Self::new(RejectionCode::NoAnswer, reason)
    }

    /// Code and reason in one text, for answers that have no field for the code: `[stamp_too_old] the stamp is ...`.
    #[must_use]
    pub fn tagged(&self) -> String {
        format!("[{}] {}", self.code.name(), self.reason)
    }
}

/// At most `max_chars` characters of a text, with an ellipsis where it was cut.
pub(super) fn truncated(text: &str, max_chars: usize) -> String {
    match text.char_indices().nth(max_chars) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_unique_and_named_as_they_are_serialised() {
        for (index, code) in RejectionCode::ALL.iter().enumerate() {
            assert_eq!(usize::from(code.number()), index + 1);
            let json = serde_json::to_string(code).expect("text");
            assert_eq!(json, format!("\"{}\"", code.name()));
        }
    }
}
