//! What the criteria of a verdict need of the beam.

use column_beam::{BeamOutcome, Outcome as BeamEnd};

use crate::assessment::{AssessmentInput, OtherModel, ResidualCapacity};
use crate::column::{Model, Report};
use crate::parameters::Parameters;

/// The impact of these parameters as the beam sees it, with its axial capacity before and after it \[N\], beside the report of the two
/// bars; `None` for a column that they do not take.
pub(super) fn input_of(
    parameters: &Parameters,
    report: &Report,
    remaining: ResidualCapacity,
    beam: &BeamOutcome,
    capacity: [f64; 2],
) -> Option<AssessmentInput> {
    let impact = parameters.impact();
    let model = Model::new(&parameters.column_properties().before(&impact)).ok()?;
    let bars = AssessmentInput::of_response(parameters, &model, &impact, report, remaining);
    let stands = beam.outcome != BeamEnd::Collapse;
    let residual = libm::hypot(beam.residual_displacement_m, beam.residual_sideways_m);
    Some(bars.by_another_model(&OtherModel {
        collapsed: !stands,
        yielded: beam.outcome != BeamEnd::Elastic,
        residual: stands.then_some(residual),
        peak: libm::hypot(beam.max_displacement_m, beam.max_sideways_m),
        capacity,
        base_shear: beam.base_shear_n,
    }))
}
