//! Probabilities and periods in words.

use column_twin::figures::units::significant;
use column_twin::report::short;
use column_twin::study::risk::Estimate;

/// A probability as a percentage, or with a power of ten where it is small.
pub(super) fn share(value: f64) -> String {
    match value {
        0.0 => "0".to_owned(),
        value if value < 1e-4 => format!("{value:.2e}"),
        value => format!("{} %", significant(100.0 * value, 3)),
    }
}

pub(super) fn small(value: f64) -> String {
    match value {
        0.0 => "0".to_owned(),
        value => format!("{value:.2e}"),
    }
}

pub(super) fn interval(estimate: &Estimate, text: fn(f64) -> String) -> String {
    format!(
        "{} ({} to {})",
        text(estimate.value),
        text(estimate.low),
        text(estimate.high)
    )
}

/// The period in words.
pub(super) fn period(years: f64) -> String {
    match short(years).as_str() {
        "1" => "in 1 year".to_owned(),
        years => format!("in {years} years"),
    }
}
