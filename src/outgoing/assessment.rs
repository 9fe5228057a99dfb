//! The outcome of an impact with its assessment as messages.

use crate::assessment::{
    Action, Assessment, Criterion, ImpactEvaluation, NOT_ASSESSED, ResidualCapacity, VerdictRange,
    capitalised,
};
use crate::column::Impact;
use crate::messages::column_twin_msgs::{AssessmentCriterion, ImpactReport, PerMass, TwinStatus};
use crate::study::VehicleLimits;
use crate::time::seconds;
use crate::twin::{Assessed, Prediction, ReportOutput, Status, Striking};

/// Why a column has to be inspected whose state file could not be used.
const UNKNOWN_DAMAGE: &str = "the state file with the damage from before could not be used, so the column may have more damage than the twin has: restore the file, or examine the column and call ~/reset if it is undamaged";

/// How the reason of a lower bound begins before and after the damage that is not known makes it an inspection.
const AT_LEAST_NONE: &str = "At least NONE: ";
const AT_LEAST_INSPECT: &str = "At least INSPECT: ";

impl From<&ReportOutput> for ImpactReport {
    /// Leaves header, column and event empty, and sets the kind FORECAST.
    fn from(output: &ReportOutput) -> Self {
        Self {
            error_estimate: output.error_estimate.unwrap_or(f64::NAN),
            dt: seconds(output.step_nanos),
            compute_time: output.compute_time,
            ..Self::from(&output.report)
                .struck_by(&output.striking)
                .with_opinion(&output.opinion, output.assessed.as_deref())
                .assessed(output.assessed.as_deref())
                .ranged(output.range.as_deref())
        }
    }
}

impl From<&Prediction> for ImpactReport {
    /// Leaves header, column and event empty.
    fn from(prediction: &Prediction) -> Self {
        Self {
            kind: Self::PREDICTION,
            error_estimate: prediction.error_estimate.unwrap_or(f64::NAN),
            dt: seconds(prediction.step_nanos),
            compute_time: prediction.compute_time,
            ..Self::from(&prediction.report)
                .struck_by(&prediction.striking)
                .with_opinion(&prediction.opinion, prediction.assessed.as_deref())
                .assessed(prediction.assessed.as_deref())
        }
    }
}

impl ImpactReport {
    /// The prediction of an impact that was simulated without a twin. Leaves header, column and event empty.
    #[must_use]
    pub fn evaluated(
        evaluation: &ImpactEvaluation,
        vehicle: &str,
        impact: &Impact,
        direction: f64,
    ) -> Self {
        let assessed = evaluation.remaining.zip(evaluation.assessment.clone());
        let assessed = assessed.map(|(remaining, assessment)| Assessed {
            remaining,
            assessment,
            second_opinion: None,
        });
        Self {
            kind: Self::PREDICTION,
            error_estimate: evaluation.error_estimate.unwrap_or(f64::NAN),
            dt: evaluation.step,
            ..Self::from(&evaluation.report)
                .of_impact(vehicle, impact.mass, impact.velocity, direction)
                .assessed(assessed.as_ref())
                .ranged(evaluation.range.as_ref().map(|it| &it.ends))
        }
    }

    /// The report with what hit the column.
    pub(super) fn struck_by(self, striking: &Striking) -> Self {
        self.of_impact(
            &striking.vehicle,
            striking.impact.mass,
            striking.velocity(),
            striking.direction(),
        )
    }

    /// The report with its assessment; without one the action is unknown.
    fn assessed(self, assessed: Option<&Assessed>) -> Self {
        let numbers = Numbers::of(assessed);
        let criteria = assessed.map_or(&[][..], |it| &it.assessment.criteria);
        Self {
            undamaged_capacity: numbers.undamaged_capacity,
            residual_capacity: numbers.residual_capacity,
            capacity_ratio: numbers.capacity_ratio,
            reserve: numbers.reserve,
            action: numbers.action,
            deciding_criterion: numbers.deciding_criterion.to_owned(),
            action_reason: numbers.reason.to_owned(),
            criteria: criteria.iter().map(AssessmentCriterion::from).collect(),
            ..self
        }
    }

    /// The report with the range of its verdict; without one its ends are unknown.
    fn ranged(self, range: Option<&VerdictRange>) -> Self {
        let ends = Ends::of(range);
        Self {
            range_least: ends.least,
            range_most: ends.most,
            range_at_least: ends.at_least,
            range_decided_by: ends.decided_by,
            ..self
        }
    }
}

impl TwinStatus {
    /// The status with the assessment of the column at rest and the last impact.
    pub(super) fn assessed(self, status: &Status) -> Self {
        let numbers = Numbers::of(status.assessed.as_deref());
        let ends = Ends::of(status.range.as_deref());
        let (action, deciding_criterion, reason) = match status.is_damage_unknown {
            false => (
                numbers.action,
                numbers.deciding_criterion,
                numbers.reason.to_owned(),
            ),
            true => with_unknown_damage(&numbers),
        };
        Self {
            range_least: ends.least,
            range_most: ends.most,
            range_at_least: ends.at_least,
            range_decided_by: ends.decided_by,
            undamaged_capacity: numbers.undamaged_capacity,
            residual_capacity: numbers.residual_capacity,
            capacity_ratio: numbers.capacity_ratio,
            reserve: numbers.reserve,
            action,
            deciding_criterion: deciding_criterion.to_owned(),
            action_reason: reason,
            crush: PerMass::first(&status.vehicle.permanent_crush, status.vehicle.masses),
            error_estimate: status.error_estimate.unwrap_or(f64::NAN),
            ..self
        }
        .with_critical_velocities(status.critical_velocities.as_deref().unwrap_or_default())
    }

    fn with_critical_velocities(self, vehicles: &[VehicleLimits]) -> Self {
        let velocities = |of: fn(&VehicleLimits) -> Option<f64>| {
            let velocities = vehicles.iter().map(of);
            velocities.map(|it| it.unwrap_or(f64::NAN)).collect()
        };
        Self {
            critical_vehicle: vehicles.iter().map(|it| it.vehicle.to_string()).collect(),
            critical_mass: vehicles.iter().map(|it| it.mass).collect(),
            critical_velocity_restrict: velocities(|it| it.restrict),
            critical_velocity_evacuate: velocities(|it| it.evacuate),
            ..self
        }
    }
}

impl From<&Criterion> for AssessmentCriterion {
    fn from(criterion: &Criterion) -> Self {
        Self {
            name: criterion.name.to_owned(),
            edition: criterion.edition.to_owned(),
            value: criterion.value.unwrap_or(f64::NAN),
            limit: criterion.limit.unwrap_or(f64::NAN),
            margin: criterion.margin.unwrap_or(f64::NAN),
            unit: criterion.unit.to_owned(),
            tag: criterion.tag.to_string(),
            evaluated: criterion.value.is_some(),
            exceeded: criterion.exceeded == Some(true),
            action: action_code(criterion.action),
            decides: criterion.decides,
            statement: criterion.statement.clone(),
        }
    }
}

/// The code of an action in `ImpactReport` and `TwinStatus`.
pub(crate) fn action_code(action: Action) -> u8 {
    match action {
        Action::None => ImpactReport::ACTION_NONE,
        Action::Inspect => ImpactReport::ACTION_INSPECT,
        Action::Restrict => ImpactReport::ACTION_RESTRICT,
        Action::Shore => ImpactReport::ACTION_SHORE,
        Action::Evacuate => ImpactReport::ACTION_EVACUATE,
    }
}

/// What report and status say alike of an assessment.
struct Numbers<'a> {
    undamaged_capacity: f64,
    residual_capacity: f64,
    capacity_ratio: f64,
    reserve: f64,
    action: u8,
    deciding_criterion: &'static str,
    reason: &'a str,
}

impl<'a> Numbers<'a> {
    fn of(assessed: Option<&'a Assessed>) -> Self {
        let Some(Assessed {
            remaining,
            assessment,
            ..
        }) = assessed
        else {
            return Self {
                undamaged_capacity: f64::NAN,
                residual_capacity: f64::NAN,
                capacity_ratio: f64::NAN,
                reserve: f64::NAN,
                action: ImpactReport::ACTION_UNKNOWN,
                deciding_criterion: "",
                reason: NOT_ASSESSED,
            };
        };
        let ResidualCapacity {
            undamaged,
            now,
            ratio,
            reserve,
            ..
        } = remaining;
        let Assessment {
            action,
            deciding_criterion,
            reason,
            ..
        } = assessment;
        Self {
            undamaged_capacity: undamaged.force,
            residual_capacity: now.force,
            capacity_ratio: *ratio,
            reserve: reserve.unwrap_or(f64::NAN),
            action: action_code(*action),
            deciding_criterion,
            reason,
        }
    }
}

/// Action, deciding criterion and reason of a column that may have a damage that the twin does not know: at least an
/// inspection, because the model may be milder than the column is.
fn with_unknown_damage(numbers: &Numbers<'_>) -> (u8, &'static str, String) {
    match numbers.action {
        TwinStatus::ACTION_NONE => {
            let order = capitalised(Action::Inspect.order());
            let (bound, finding) = match numbers.reason.strip_prefix(AT_LEAST_NONE) {
                Some(finding) => (AT_LEAST_INSPECT, finding),
                None => ("", numbers.reason),
            };
            let reason = format!("{bound}{order} Cause: {UNKNOWN_DAMAGE}. {finding}");
            (TwinStatus::ACTION_INSPECT, "state_file", reason)
        }
        action => {
            let reason = format!("{} Besides, {UNKNOWN_DAMAGE}.", numbers.reason);
            (action, numbers.deciding_criterion, reason)
        }
    }
}

/// What report and status say alike of the range of a verdict.
struct Ends {
    least: u8,
    most: u8,
    at_least: bool,
    decided_by: String,
}

impl Ends {
    fn of(range: Option<&VerdictRange>) -> Self {
        let end = |end: fn(&VerdictRange) -> Action| {
            range.map_or(ImpactReport::ACTION_UNKNOWN, |it| action_code(end(it)))
        };
        Self {
            least: end(|it| it.least),
            most: end(|it| it.most),
            at_least: range.is_some_and(|it| it.at_least),
            decided_by: range
                .map(VerdictRange::decided_by_in_words)
                .unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assessment::AT_LEAST;

    /// The inspection that an unknown damage requires took the place of the bound: "Have an engineer ... At least NONE: ...".
    #[test]
    fn an_unknown_damage_leaves_a_lower_bound_a_lower_bound() {
        let reason = |of_column: &str| {
            let numbers = Numbers {
                undamaged_capacity: 3e6,
                residual_capacity: 3e6,
                capacity_ratio: 1.0,
                reserve: 6.0,
                action: TwinStatus::ACTION_NONE,
                deciding_criterion: "collapse",
                reason: of_column,
            };
            let (action, _, reason) = with_unknown_damage(&numbers);
            assert_eq!(action, TwinStatus::ACTION_INSPECT);
            reason
        };
        let order = capitalised(Action::Inspect.order());
        let known = reason("No deciding criterion is exceeded.");
        assert!(known.starts_with(&order), "{known}");
        let bound = reason("At least NONE: No deciding criterion is exceeded.");
        assert!(
            bound.starts_with(&format!("{AT_LEAST}INSPECT: {order} Cause: ")),
            "{bound}"
        );
        assert!(!bound.contains("NONE"), "{bound}");
    }
}
