//! What the criteria of a verdict need of the two bars, before the beam replaces what it sees otherwise.

use crate::assessment::{AssessmentInput, ResidualCapacity};
use crate::column::{Model, Report};
use crate::parameters::Parameters;

/// The impact of these parameters with the report of the two bars; `None` for a column that they do not take.
pub(super) fn input_of(
    parameters: &Parameters,
    report: &Report,
    remaining: ResidualCapacity,
) -> Option<AssessmentInput> {
    let impact = parameters.impact();
    let model = Model::new(&parameters.column_properties().before(&impact)).ok()?;
    Some(AssessmentInput::of_response(
        parameters, &model, &impact, report, remaining,
    ))
}
