//! How long a step may be, and how wrong a response is that was made with it.

use std::f64::consts::TAU;

use super::properties::ColumnProperties;
use super::report::Report;

/// Nanoseconds in a second.
pub(crate) const NANOS_PER_SECOND: f64 = 1e9;

/// Longest step that is recommended \[ns\]: the axial vibration needs it where the transverse one is slow.
pub const MAX_RECOMMENDED_STEP_NANOS: u64 = 20_000;

/// Shortest step that is recommended \[ns\]: about what one step takes to compute, so that a response stays in real time.
pub const MIN_RECOMMENDED_STEP_NANOS: u64 = 1_000;

/// Steps per period of the impact point's transverse vibration. Calibrated on random columns with bars of 0.1 to 4 m: see
/// `docs/theory.md`.
pub const STEPS_PER_PERIOD: f64 = 80.0;

/// Recommended steps are multiples of this \[ns\].
const STEP_GRAIN_NANOS: u64 = 100;

/// Factor from the difference that half the step makes to the error that is estimated from it. With an error that is
/// proportional to `dt^p` it is `2^p / (2^p - 1)`: 4/3 for the second order of smooth stretches, 2 for the first order that
/// first yield and contact events leave. The estimate assumes the first order, the larger factor.
pub const ERROR_PER_DIFFERENCE: f64 = 2.0;

/// The step that keeps the error of the largest `v1` below about 3.5e-4 \[ns\]: a fraction of the period in which the mass at
/// the impact point \[kg\] vibrates against the transverse stiffness of the virgin column \[N/m\], within fixed bounds.
pub(crate) fn recommended_step_nanos(impact_point_mass: f64, transverse_stiffness: f64) -> u64 {
    let period = TAU * (impact_point_mass / transverse_stiffness).sqrt();
    let nanos = period / STEPS_PER_PERIOD * NANOS_PER_SECOND;
    // `as` saturates, and what is not a number becomes 0.
    let grains = (nanos as u64) / STEP_GRAIN_NANOS;
    grains
        .saturating_mul(STEP_GRAIN_NANOS)
        .clamp(MIN_RECOMMENDED_STEP_NANOS, MAX_RECOMMENDED_STEP_NANOS)
}

/// The properties with half the step, for the run that [`error_estimate`] compares with; `None` where the step is 1 ns or
/// still to be chosen. Takes those of a [`Model`](super::Model), whose step is chosen.
pub fn with_half_the_step(properties: &ColumnProperties) -> Option<ColumnProperties> {
    (properties.step_nanos > 1).then_some(ColumnProperties {
        step_nanos: properties.step_nanos / 2,
        ..*properties
    })
}

/// Estimated relative error of the largest `v1` of a response, from that of the same response with half the step: the
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
