//! How wrong a response is by the length of its step.

use super::properties::ColumnProperties;
use super::report::{Outcome, Report};

/// Factor from the difference that half the step makes to the error that is estimated from it. With an error that is
/// proportional to `dt^p` it is `2^p / (2^p - 1)`: 4/3 for the second order of smooth stretches, 2 for the first order that
/// first yield and contact events leave. Events fall into the steps at random, so that the order of a single response is not known:
/// the factor is half as large again.
pub const ERROR_PER_DIFFERENCE: f64 = 3.0;

/// Relative error of the peak `v1` that both runs may have in common, and that their difference does not show. Of random columns, one
/// in some hundred has a larger one: see `docs/theory.md`.
pub const COMMON_ERROR: f64 = 5e-5;

/// The properties with half the step, for the run that [`error_estimate`] compares with; `None` where the step is 1 ns or
/// still to be chosen. Takes those of a [`Model`](super::Model), whose step is chosen.
pub fn with_half_the_step(properties: &ColumnProperties) -> Option<ColumnProperties> {
    (properties.step_nanos > 1).then_some(ColumnProperties {
        step_nanos: properties.step_nanos / 2,
        ..*properties
    })
}

/// Estimated relative error of the peak `v1` of a response, from that of the same response with half the step: the
/// relative difference times [`ERROR_PER_DIFFERENCE`], and [`COMMON_ERROR`]. The error of at least 99 in 100 responses is
/// smaller. `None` where the two have nothing in common: in one of them the column collapses or is fractured, and not in the
/// other, or one of the displacements is 0 or not a number. A column that flows by round-off only may be elastic with one step
/// and plastic with the other.
///
/// The response with half the step may be advanced in pieces, by [`Response::advance`](super::Response::advance) on a model
/// of [`with_half_the_step`].
pub fn error_estimate(report: &Report, with_half_the_step: &Report) -> Option<f64> {
    let difference = relative_difference(report.max_v1, with_half_the_step.max_v1);
    let error = ERROR_PER_DIFFERENCE * difference + COMMON_ERROR;
    let is_comparable = alike(report.outcome, with_half_the_step.outcome);
    (is_comparable && error.is_finite()).then_some(error)
}

/// Whether the column stands after both responses, or has failed in the same way.
fn alike(one: Outcome, other: Outcome) -> bool {
    one == other || (one.stands() && other.stands())
}

fn relative_difference(max_v1: f64, max_v1_half: f64) -> f64 {
    if max_v1 == max_v1_half {
        return 0.0;
    }
    ((max_v1 - max_v1_half) / max_v1_half).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_estimate_covers_an_error_of_first_order() {
        let with_step = |dt: f64| 2.0 * (1.0 + 0.03 * dt);
        let (whole, half) = (with_step(1.0), with_step(0.5));
        let error = whole / 2.0 - 1.0;
        let estimate = ERROR_PER_DIFFERENCE * relative_difference(whole, half);
        assert!(
            (1.4..1.6).contains(&(estimate / error)),
            "{estimate} {error}"
        );
    }

    #[test]
    fn what_cannot_be_compared_has_no_finite_difference() {
        assert_eq!(relative_difference(0.1, 0.1), 0.0);
        assert_eq!(relative_difference(0.0, 0.0), 0.0);
        assert_eq!(relative_difference(0.1, 0.0), f64::INFINITY);
        assert!(relative_difference(f64::NAN, 0.1).is_nan());
        assert!(relative_difference(0.1, f64::NAN).is_nan());
    }

    #[test]
    fn only_a_column_that_fails_has_another_outcome() {
        use Outcome::{Collapsed, Elastic, Fractured, Plastic};
        assert!(alike(Elastic, Plastic) && alike(Plastic, Elastic) && alike(Collapsed, Collapsed));
        for (one, other) in [
            (Elastic, Collapsed),
            (Plastic, Fractured),
            (Collapsed, Fractured),
        ] {
            assert!(!alike(one, other) && !alike(other, one));
        }
    }
}
