//! One impact with all that an engineer needs to judge it.

use super::action_range::ActionRange;
use super::response::{EarlierImpacts, input_of_response};
use super::{Assessment, AssessmentInput, BaseDemand, ResidualCapacity, assess};
use crate::column::{
    self, CapacityError, ColumnProperties, Impact, Model, Report, SimulationError, State,
    carried_load, follow_from, plastic_plateau, with_half_the_step,
};
use crate::parameters::{NoShear, Parameters};
use crate::standing::StandingColumn;

/// What an impact leads to.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpactEvaluation {
    /// The response.
    pub report: Report,
    /// Capacity of the undamaged column and of the column that the impact leaves; `None` if it could not be computed.
    pub remaining: Option<ResidualCapacity>,
    /// Why there are no capacities, if there are none.
    pub capacity_fault: Option<CapacityError>,
    /// Criteria and action; `None` without the capacities.
    pub assessment: Option<Assessment>,
    /// Length of a time step \[s\].
    pub step: f64,
    /// Estimated relative error of the peak `v1`, from a run with half the step; `None` if that run failed.
    pub error_estimate: Option<f64>,
    /// Between which actions the verdict lies; `None` without the capacities.
    pub range: Option<ActionRange>,
    /// What earlier impacts had left of the column; `None` of an undamaged one.
    pub earlier: Option<EarlierImpacts>,
    /// `F0`: plastic plateau of the undamaged column under the load that it carries \[N\].
    pub plateau: f64,
    /// Largest force of the vehicle's front within its crush curve \[N\]; `None` for a rigid vehicle.
    pub front_force: Option<f64>,
    /// Why the webs of the column do not yield in shear; `None` where they do.
    pub no_shear: Option<NoShear>,
}

impl ImpactEvaluation {
    /// Completes the evaluation of a response of the undamaged column that was computed with
    /// [`respond_and_rest`](super::respond_and_rest).
    ///
    /// More responses are computed, one with half the step and those of [`ActionRange::of`], with the push-downs of the column
    /// that each of them leaves.
    ///
    /// # Errors
    /// A column that is out of range, which the response has excluded.
    pub fn complete(
        parameters: &Parameters,
        properties: &ColumnProperties,
        impact: &Impact,
        ended: (Report, Option<State>),
    ) -> Result<Self, SimulationError> {
        let model = Model::new(&properties.before(impact))?;
        let undamaged = State::at_rest(&model);
        let (mut evaluation, _) = Self::of_one(parameters, &model, undamaged, None, impact, ended);
        let verdict = evaluation.assessment.as_ref();
        evaluation.range =
            verdict.map(|it| ActionRange::of(parameters, properties, impact, None, it));
        Ok(evaluation)
    }

    /// Completes the evaluation of a response of a column that earlier impacts have damaged, which was computed with
    /// [`observe_from`](super::observe_from) from its equilibrium `before`. `base_before` is what they have put into the base. Also all
    /// on which its verdict depends; `None` without the capacities.
    ///
    /// More responses are computed, as by [`ImpactEvaluation::complete`].
    #[must_use]
    pub fn of_damaged(
        parameters: &Parameters,
        model: &Model,
        before: State,
        base_before: Option<&BaseDemand>,
        impact: &Impact,
        ended: (Report, Option<State>),
    ) -> (Self, Option<AssessmentInput>) {
        let (mut evaluation, input) =
            Self::of_one(parameters, model, before, base_before, impact, ended);
        let earlier = EarlierImpacts {
            column: StandingColumn::new(model, &before),
            base: base_before.copied(),
        };
        let (verdict, properties) = (evaluation.assessment.as_ref(), &model.properties);
        evaluation.range =
            verdict.map(|it| ActionRange::of(parameters, properties, impact, Some(&earlier), it));
        evaluation.earlier = Some(earlier);
        (evaluation, input)
    }

    /// Without the range.
    fn of_one(
        parameters: &Parameters,
        model: &Model,
        before: State,
        base_before: Option<&BaseDemand>,
        impact: &Impact,
        (report, rest): (Report, Option<State>),
    ) -> (Self, Option<AssessmentInput>) {
        let (input, capacity_fault) =
            match input_of_response(parameters, model, impact, &report, rest.as_ref()) {
                Ok(input) => (Some(input), None),
                Err(fault) => (None, Some(fault)),
            };
        let input = input.map(|it| AssessmentInput {
            base_demand: it.base_demand.map(|demand| demand.after(base_before)),
            ..it
        });
        let remaining = input.as_ref().map(|it| it.remaining);
        // The same load as in the criteria.
        let carried = match &remaining {
            Some(remaining) => remaining.carried_load,
            None => carried_load(model, &State::at_rest(model)),
        };
        let duration = parameters.response_duration();
        let evaluation = Self {
            no_shear: parameters.shear().err(),
            report,
            remaining,
            capacity_fault,
            assessment: input.as_ref().map(assess),
            step: 1e-9 * model.properties.step_nanos as f64,
            error_estimate: error_estimate(&model.properties, before, impact, duration, &report),
            range: None,
            earlier: None,
            plateau: plastic_plateau(model, carried),
            front_force: impact.vehicle.and_then(|vehicle| {
                let envelope = vehicle.springs().first()?.envelope;
                let forces = envelope.points().iter().map(|point| point[1]);
                Some(forces.fold(0.0, f64::max))
            }),
        };
        (evaluation, input)
    }
}

/// The error of the peak `v1`, estimated from a run with half the step; `None` if that has another outcome.
fn error_estimate(
    properties: &ColumnProperties,
    before: State,
    impact: &Impact,
    duration: f64,
    report: &Report,
) -> Option<f64> {
    let halved = Model::new(&with_half_the_step(properties)?).ok()?;
    let (finer, _) = follow_from(&halved, before, impact, duration, |_, _| ()).ok()?;
    column::error_estimate(report, &finer)
}
