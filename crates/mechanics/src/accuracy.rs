//! How wrong a response is by the length of its step.

use super::properties::ColumnProperties;
use super::report::Report;

/// Factor from the difference that half the step makes to the error that is estimated from it. With an error that is
/// proportional to `dt^p` it is `2^p / (2^p - 1)`: 4/3 for the second order of smooth stretches, 2 for the first order that
/// first yield and contact events leave. The estimate assumes the first order, the larger factor.
pub const ERROR_PER_DIFFERENCE: f64 = 2.0;

/// The properties with half the step, for the run that [`error_estimate`] compares with; `None` where the step is 1 ns or
/// still to be chosen. Takes those of a [`Model`](super::Model), whose step is chosen.
pub fn with_half_the_step(properties: &ColumnProperties) -> Option<ColumnProperties> {
    (properties.step_nanos > 1).then_some(ColumnProperties {
        step_nanos: properties.step_nanos / 2,
        ..*properties
    })
}

/// Estimated relative error of the peak `v1` of a response, from that of the same response with half the step: the
/// relative difference times [`ERROR_PER_DIFFERENCE`], >= 0. `None` where the two have nothing in common: they end
/// differently, or one of the displacements is 0 or not a number.
///
/// The response with half the step may be advanced in pieces, by [`Response::advance`](super::Response::advance) on a model
/// of [`with_half_the_step`].
pub fn error_estimate(report: &Report, with_half_the_step: &Report) -> Option<f64> {
    let error = relative_error(report.max_v1, with_half_the_step.max_v1);
    (report.outcome == with_half_the_step.outcome && error.is_finite()).then_some(error)
}

fn relative_error(max_v1: f64, max_v1_half: f64) -> f64 {
    if max_v1 == max_v1_half {
        return 0.0;
    }
    ERROR_PER_DIFFERENCE * ((max_v1 - max_v1_half) / max_v1_half).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_estimate_is_exact_for_an_error_of_first_order() {
        let with_step = |dt: f64| 2.0 * (1.0 + 0.03 * dt);
        let (whole, half) = (with_step(1.0), with_step(0.5));
        let error = whole / 2.0 - 1.0;
        assert!((relative_error(whole, half) / error - 1.0).abs() < 0.02);
        // Of second order it is on the safe side.
        let with_step = |dt: f64| 2.0 * (1.0 + 0.03 * dt * dt);
        let (whole, half) = (with_step(1.0), with_step(0.5));
        assert!(relative_error(whole, half) > whole / 2.0 - 1.0);
    }

    #[test]
    fn what_cannot_be_compared_has_no_finite_error() {
        assert_eq!(relative_error(0.1, 0.1), 0.0);
        assert_eq!(relative_error(0.0, 0.0), 0.0);
        assert_eq!(relative_error(0.1, 0.0), f64::INFINITY);
        assert!(relative_error(f64::NAN, 0.1).is_nan());
        assert!(relative_error(0.1, f64::NAN).is_nan());
    }
}
