//! The words that people see for the numbers of phases and actions in messages. Those that call for somebody are capitals.

use crate::assessment;

use super::column_twin_msgs::{CredibleInterval, ImpactEstimate, TwinStatus};

/// The word for a phase in `ColumnState`, `TwinStatus` and `ColumnStatus`.
#[must_use]
pub fn phase_word(phase: u8) -> &'static str {
    match phase {
        TwinStatus::IDLE => "idle",
        TwinStatus::APPROACH => "approach",
        TwinStatus::CONTACT => "contact",
        TwinStatus::FREE => "free",
        TwinStatus::REST => "rest",
        TwinStatus::COLLAPSED => "COLLAPSED",
        TwinStatus::FAULTED => "FAULTED",
        TwinStatus::FRACTURED => "FRACTURED",
        _ => "unknown",
    }
}

/// The word for an action in `ImpactReport`, `TwinStatus` and `ColumnStatus`.
#[must_use]
pub fn action_word(action: u8) -> &'static str {
    match action {
        TwinStatus::ACTION_NONE => "none",
        TwinStatus::ACTION_INSPECT => "inspect",
        TwinStatus::ACTION_RESTRICT => "RESTRICT",
        TwinStatus::ACTION_SHORE => "SHORE",
        TwinStatus::ACTION_EVACUATE => "EVACUATE",
        _ => "unknown",
    }
}

/// What has to be done and why, by the action and the reason of a report or a status: `RESTRICT: Keep people away ...`. The reason of an
/// action that is a lower bound names it itself.
#[must_use]
pub fn verdict_in_words(action: u8, reason: &str) -> String {
    let word = action_word(action).to_uppercase();
    match (action, reason) {
        (_, "") => word,
        (TwinStatus::ACTION_UNKNOWN, _) => format!("NOT ASSESSED: {reason}"),
        _ if reason.starts_with(assessment::AT_LEAST) => reason.to_owned(),
        _ => format!("{word}: {reason}"),
    }
}

/// The action alone: `RESTRICT`, or `at least RESTRICT` where its reason says that it is a lower bound.
#[must_use]
pub fn action_alone(action: u8, reason: &str) -> String {
    let word = action_word(action).to_uppercase();
    match reason.starts_with(assessment::AT_LEAST) {
        true => format!("at least {word}"),
        false => word,
    }
}

/// The same of a column that cannot be assessed.
#[must_use]
pub fn not_assessed_in_words() -> String {
    verdict_in_words(TwinStatus::ACTION_UNKNOWN, assessment::NOT_ASSESSED)
}

/// The range of a verdict in a report or a status in words; `None` where it is not known.
#[must_use]
pub fn range_in_words(least: u8, most: u8, at_least: bool, decided_by: &str) -> Option<String> {
    let is_known = ![least, most].contains(&TwinStatus::ACTION_UNKNOWN);
    let [least, most] = [least, most].map(|it| action_word(it).to_uppercase());
    is_known.then(|| assessment::range_in_words(&least, &most, at_least, decided_by))
}

/// The mass of an event, which leaves it open with NaN or 0.
#[must_use]
pub fn mass_in_words(mass: f64) -> String {
    match mass.is_nan() || mass == 0.0 {
        true => "a vehicle of its own mass".to_owned(),
        false => format!("{mass} kg"),
    }
}

/// One line about an estimate.
#[must_use]
pub fn estimate_line(it: &ImpactEstimate) -> String {
    let last = if it.is_final { "final " } else { "" };
    let named = |what, names: &[String]| match names {
        [] => String::new(),
        _ => format!("; {what}: {}", names.join(", ")),
    };
    format!(
        "{last}estimate of {} by data until {:.0} ms after contact: momentum {}, v1 up to {}, residual {}, action {} ({}){}{}",
        it.event_id,
        1e3 * it.data_until,
        in_unit(&it.momentum, 1e-3, "kN s"),
        in_unit(&it.peak_v1, 1e3, "mm"),
        in_unit(&it.residual_v1, 1e3, "mm"),
        actions_in_words(it),
        decision_word(it.decision),
        named("sensors in doubt", &it.doubtful_sensors),
        named("scale not confirmed", &it.scale_not_confirmed)
    )
}

/// Mean and 90 % interval of a quantity, times a factor, in a unit: `15.0 (13.9 to 16.1) kN s`.
#[must_use]
pub fn in_unit(interval: &CredibleInterval, factor: f64, unit: &str) -> String {
    let CredibleInterval { mean, low, high } = interval;
    if ![mean, low, high].into_iter().all(|it| it.is_finite()) {
        return "unknown".to_owned();
    }
    let largest = (factor * high).abs().max((factor * mean).abs());
    // Three digits of the largest of the three numbers.
    let decimals = match largest {
        0.0..1.0 => 3,
        1.0..10.0 => 2,
        10.0..100.0 => 1,
        _ => 0,
    };
    let [mean, low, high] = [mean, low, high].map(|it| factor * it);
    format!("{mean:.decimals$} ({low:.decimals$} to {high:.decimals$}) {unit}")
}

/// The probabilities of the actions, the most probable first; those below half a percent are left out.
#[must_use]
pub fn actions_in_words(estimate: &ImpactEstimate) -> String {
    const LEAST_NAMED: f64 = 0.005;
    let shares = (0_u8..).zip(estimate.action_probabilities);
    let mut named: Vec<_> = shares.filter(|(_, share)| *share >= LEAST_NAMED).collect();
    named.sort_by(|a, b| b.1.total_cmp(&a.1));
    let words = named
        .iter()
        .map(|(action, share)| format!("{} {:.0} %", action_word(*action), 100.0 * share));
    words.collect::<Vec<_>>().join(", ")
}

/// What has become of an estimate, in words.
#[must_use]
pub fn decision_word(decision: u8) -> &'static str {
    match decision {
        ImpactEstimate::DECISION_PENDING => "not accepted yet",
        ImpactEstimate::DECISION_ACCEPTED => "accepted",
        ImpactEstimate::DECISION_MERGED => "the twin follows an event for the same impact",
        ImpactEstimate::DECISION_DECLINED => "declined",
        ImpactEstimate::DECISION_REJECTED => "rejected: the column cannot take it",
        _ => "unknown",
    }
}
