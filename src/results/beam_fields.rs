//! What the fibre beam says of an impact, under the names that programs see.

use std::time::Duration;

use serde::Serialize;

use crate::column::Outcome;
use crate::second_opinion::{NoSecondOpinion, SecondOpinion};

/// What the fibre beam says, in SI units, or in words why there is no second opinion. A value that does not exist is null.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum BeamAnswer {
    /// What it says.
    Opinion(BeamFields),
    /// Why it says nothing.
    None(String),
}

impl BeamAnswer {
    /// Of an opinion that has taken this long to compute.
    #[must_use]
    pub fn of(opinion: &Result<SecondOpinion, NoSecondOpinion>, solve_time: Duration) -> Self {
        match opinion {
            Ok(opinion) => Self::Opinion(BeamFields::of(opinion, solve_time)),
            Err(reason) => Self::None(reason.to_string()),
        }
    }
}

fields! {
    /// Displacements are those of the impact point, along the hit and at right angles to it, as magnitudes.
    pub struct BeamFields of(opinion: &SecondOpinion, solve_time: Duration) {
        let beam = &opinion.beam;
        let [undamaged, residual] = opinion.capacity;
    }
    max_displacement_m: f64 = beam.max_displacement_m;
    max_sideways_m: f64 = beam.max_sideways_m;
    residual_displacement_m: f64 = beam.residual_displacement_m;
    residual_sideways_m: f64 = beam.residual_sideways_m;
    /// Largest distance of the axis at rest from that of the undamaged column, and its height above the base.
    residual_bow_m: f64 = beam.residual_bow_m;
    residual_bow_height_m: f64 = beam.residual_bow_height_m;
    max_displacement_time_s: f64 = beam.max_displacement_time_s;
    outcome: Outcome = opinion.outcome();
    /// Bowed about the axes of `beam.bow_axes`.
    undamaged_capacity_n: f64 = undamaged;
    residual_capacity_n: f64 = residual;
    base_shear_n: f64 = beam.base_shear_n;
    base_moment_n_m: f64 = beam.base_moment_n_m;
    error_estimate: f64 = beam.error_estimate;
    elements: usize = beam.elements;
    solve_time_s: f64 = solve_time.as_secs_f64();
    ratio_to_two_bars: Option<f64> = opinion.ratio_to_two_bars;
}
