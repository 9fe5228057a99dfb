//! What an impact would do to the column as it is: a snapshot of the twin that answers without touching it.

use super::striking::{Striking, Travel};
use std::sync::Arc;

use super::assessed::{Assessed, Capacities, LastImpact, UndamagedCapacity, assessed};
use super::opinion::OpinionTask;
use super::opinion_state::{BeamResult, KnownBeamDamage, OpinionState};
use super::plant::{Condition, Plant, Struck};
use super::registry::check_column_id;
use super::rejection::{Rejection, RejectionCode};
use super::timeline::{LookAhead, Outlook};
use crate::assessment::{BaseDemand, imperfection};
use crate::column::{
    ColumnProperties, Impact, ImpactSpecification, Model, Report, Response, State, Vehicle,
};
use crate::parameters::{
    BeamMode, CRUSHED_BY, CatalogueVehicle, Parameter, Parameters, RIGID, Value, readable,
    split_crush,
};
use crate::second_opinion::{Movement, SecondOpinion, is_out_of_plane};
use crate::standing::StandingColumn;
use crate::standing::{is_same_height, with_impact_height};
use crate::time::seconds;
use printable::is_printable;

/// Longest name of a vehicle in characters.
pub const MAX_VEHICLE_NAME_CHARS: usize = 64;

/// The column at one instant with its parameters: all that a what-if needs.
#[derive(Debug, Clone)]
pub struct ColumnSnapshot {
    pub(super) column_id: Arc<str>,
    pub(super) parameters: Arc<Parameters>,
    pub(super) plant: Plant,
    pub(super) undamaged: Option<UndamagedCapacity>,
    /// What earlier impacts have put into the base.
    pub(super) base_before: Option<BaseDemand>,
    /// The damage of the column as the beam knows it.
    pub(super) beam: KnownBeamDamage,
}

/// The forecast of an impact that has not happened.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// What would hit the column.
    pub striking: Striking,
    /// What the impact would do.
    pub report: Report,
    /// The assessment of the column that it would leave behind; `None` if that column cannot be computed.
    pub assessed: Option<Arc<Assessed>>,
    /// Estimated relative error of `max_v1` by the time step; `None` if it is not known.
    pub error_estimate: Option<f64>,
    /// Length of a time step \[ns\].
    pub step_nanos: u64,
    /// What computing it took \[s\].
    pub compute_time: f64,
    /// Where the second opinion stands. It is awaited where the vehicle travels out of the plane of the two bars, and where `beam.mode`
    /// is `governing`.
    pub opinion: OpinionState,
    /// What the second opinion needs, while it is awaited.
    pending: Option<Box<PendingOpinion>>,
}

/// What the second opinion on a prediction needs.
#[derive(Debug, Clone, PartialEq)]
struct PendingOpinion {
    task: OpinionTask,
    parameters: Arc<Parameters>,
    at_rest: Plant,
    capacities: Capacities,
    last: LastImpact,
}

/// Why a prediction in the plane of the two bars has no second opinion.
const IN_PLANE: &str = "no second opinion: a prediction has one where the vehicle travels out of the plane of the two bars, or with \
                        beam.mode: governing";
/// Why a prediction of a column that cannot be computed has none.
const NOT_ASSESSED: &str = "no second opinion: the column cannot be assessed";

impl Prediction {
    /// What is to be computed with the fibre beam, in any thread; `None` where no second opinion is awaited.
    #[must_use]
    pub fn opinion_task(&self) -> Option<OpinionTask> {
        Some(self.pending.as_ref()?.task.clone())
    }

    /// The prediction with what the beam has found, by which the assessment is that of both models.
    #[must_use]
    pub fn with_opinion(mut self, found: &BeamResult) -> Self {
        let Some(pending) = self.pending.take() else {
            return self;
        };
        self.opinion = OpinionState::after(found);
        if let BeamResult::Answer(answer) = found {
            let PendingOpinion {
                parameters,
                at_rest,
                capacities,
                last,
                ..
            } = &*pending;
            let direction = self.striking.direction();
            let opinion = SecondOpinion::new(answer, direction, parameters, &self.report);
            let last = LastImpact {
                second_opinion: Some(Arc::new(opinion)),
                ..last.clone()
            };
            self.assessed = Some(assessed(parameters, at_rest, Some(&last), capacities));
        }
        self
    }

    /// The prediction without the second opinion that was awaited, for this reason, in words.
    #[must_use]
    pub fn without_opinion(self, reason: &str) -> Self {
        self.with_opinion(&BeamResult::None(reason.into()))
    }
}

impl ColumnSnapshot {
    /// The parameters that hold.
    #[must_use]
    pub fn parameters(&self) -> &Arc<Parameters> {
        &self.parameters
    }

    /// The same column in another condition.
    #[cfg(test)]
    pub(crate) fn set_condition(&mut self, condition: Condition) {
        self.plant.condition = condition;
    }

    /// The column as the next impact will find it; `None` while it responds to one. Where the hinges at the impact point are
    /// not damaged, they are at the height of the parameters, otherwise where they are.
    ///
    /// # Errors
    /// The column can take no impact.
    pub fn standing(&self) -> Result<Option<StandingColumn>, Condition> {
        if self.plant.condition != Condition::Standing {
            return Err(self.plant.condition.clone());
        }
        if self.plant.state.impactor.is_some() {
            return Ok(None);
        }
        let properties = self.parameters.column_properties();
        let moved = self.plant.with_hinges_at_impact(&properties);
        let (model, state) = moved.unwrap_or((self.plant.model, self.plant.state));
        Ok(Some(StandingColumn::new(&model, &state)))
    }

    /// Predicts what an impact would do to the column, in the caller's thread. An empty `column_id` means this column,
    /// and an empty `vehicle` that of the parameters; `stopwatch` gives monotonic nanoseconds.
    ///
    /// # Errors
    /// The impact would be rejected, or its response cannot be computed to its end.
    pub fn predict(
        &self,
        column_id: &str,
        vehicle: &str,
        specification: &ImpactSpecification,
        stopwatch: &dyn Fn() -> u64,
    ) -> Result<Prediction, Rejection> {
        if !column_id.is_empty() {
            check_column_id(&self.column_id, column_id)?;
        }
        let striking = self.complete(vehicle, specification)?;
        let height = self.height_of_impact(&striking.vehicle, specification.height);
        let struck = self.strike(striking.impact, height)?;
        let mut ahead = LookAhead::new(struck, imperfection(&self.parameters), self.undamaged);
        let not_computed = |reason| Err(Rejection::new(RejectionCode::NotComputed, reason));
        let mut budget = u64::MAX;
        let (report, at_rest, capacities) = match ahead.run(&mut budget, stopwatch) {
            Outlook::Over {
                report,
                at_rest,
                capacities,
                ..
            } => (report, at_rest, capacities),
            Outlook::Failed(reason) => return not_computed(reason),
            Outlook::Running | Outlook::Refined(_) | Outlook::Complete => {
                return not_computed("the prediction was not carried to its end".to_owned());
            }
        };
        let error_estimate = match ahead.run(&mut budget, stopwatch) {
            Outlook::Refined(estimate) => estimate.ok(),
            _ => None,
        };
        let last = LastImpact::new(
            &striking,
            &report,
            error_estimate,
            self.base_before.as_ref(),
        );
        let task = capacities
            .ok_or_else(|| NOT_ASSESSED.into())
            .and_then(|capacities| {
                let task = self.opinion_task(&struck, &striking)?;
                Ok((task, capacities))
            });
        let (opinion, pending) = match task {
            Err(reason) => (OpinionState::None(reason), None),
            Ok((task, capacities)) => {
                let pending = PendingOpinion {
                    task,
                    parameters: Arc::clone(&self.parameters),
                    at_rest: at_rest.clone(),
                    capacities,
                    last: last.clone(),
                };
                (OpinionState::Awaited, Some(Box::new(pending)))
            }
        };
        Ok(Prediction {
            opinion,
            pending,
            assessed: capacities.map(|it| assessed(&self.parameters, &at_rest, Some(&last), &it)),
            striking,
            report,
            error_estimate,
            step_nanos: struck.model.properties.step_nanos,
            compute_time: seconds(ahead.compute_nanos()),
        })
    }

    /// # Errors
    /// Why a prediction of this impact has no second opinion, in words.
    fn opinion_task(&self, struck: &Struck, striking: &Striking) -> Result<OpinionTask, Arc<str>> {
        let mode = self.parameters.settings().beam.mode;
        if mode == BeamMode::SecondOpinion && !is_out_of_plane(striking.direction()) {
            return Err(IN_PLANE.into());
        }
        let properties = &struck.model.properties;
        OpinionTask::new(0, &self.parameters, properties, striking, &self.beam)
    }

    /// The damage of the column as the beam knows it.
    #[must_use]
    pub fn beam_damage(&self) -> &KnownBeamDamage {
        &self.beam
    }

    /// How the fibre beam moves during this impact, for drawings; `None` where there is no second opinion.
    #[must_use]
    pub fn movement(&self, struck: &ColumnProperties, striking: &Striking) -> Option<Movement> {
        let task = OpinionTask::new(0, &self.parameters, struck, striking, &self.beam);
        task.ok()?.movement()
    }

    /// The column with an impact on its way, for a caller who follows the response in every step. An empty `vehicle` means
    /// that of the parameters.
    ///
    /// # Errors
    /// The impact would be rejected.
    pub fn struck(
        &self,
        vehicle: &str,
        specification: &ImpactSpecification,
    ) -> Result<(Model, State, Response), Rejection> {
        let striking = self.complete(vehicle, specification)?;
        let Struck {
            model,
            state,
            response,
            ..
        } = {
            let height = self.height_of_impact(&striking.vehicle, specification.height);
            self.strike(striking.impact, height)?
        };
        Ok((model, state, response))
    }

    /// The impact with what its specification leaves open taken from the parameters and the catalogue of vehicles, every
    /// number checked against the one table.
    ///
    /// # Errors
    /// The vehicle is unknown; all numbers that are not finite or out of range; the vehicle
    /// is too far away.
    pub(super) fn complete(
        &self,
        vehicle: &str,
        specification: &ImpactSpecification,
    ) -> Result<Striking, Rejection> {
        let invalid = |reason| Rejection::new(RejectionCode::VehicleInvalid, reason);
        let bumper_height = self.parameters.bumper_named(vehicle);
        let (name, vehicle) = self.vehicle_named(vehicle).map_err(invalid)?;
        let direction = specification.direction;
        let direction = direction.unwrap_or(self.parameters.direction());
        let directed = ImpactSpecification {
            direction: Some(direction),
            ..*specification
        };
        let impact = directed
            .complete(&self.parameters.whole_impact(), vehicle, bumper_height)
            .map_err(|error| invalid(error.to_string()))?;
        self.checked(Striking {
            vehicle: name,
            impact,
            travel: Travel::of(specification.velocity, direction),
        })
    }

    /// A complete impact, every number checked against the one table.
    ///
    /// # Errors
    /// All numbers that are not finite or out of range; the vehicle is too far away.
    pub(super) fn checked(&self, striking: Striking) -> Result<Striking, Rejection> {
        let impact = &striking.impact;
        // A mass that is left open is that of a deformable vehicle, which is complete by now.
        let open = (impact.mass == 0.0 || impact.mass.is_nan()).then(|| {
            let mass = impact.mass;
            format!("mass = {mass}: is required, because a rigid vehicle has no mass of its own")
        });
        let faults: Vec<_> = [
            open.or_else(|| fault_of("mass", "impact.mass", impact.mass)),
            fault_of("velocity", "impact.velocity", striking.velocity()),
            fault_of("gap", "impact.gap", impact.gap).map(with_hint_at_nan),
            fault_of("restitution", "impact.restitution", impact.restitution).map(with_hint_at_nan),
        ]
        .into_iter()
        .flatten()
        .collect();
        if !faults.is_empty() {
            let faults = faults.join("; ");
            return Err(Rejection::new(RejectionCode::ImpactOutOfRange, faults));
        }
        self.check_approach(impact)?;
        Ok(striking)
    }

    /// Where an impact of this vehicle meets the column \[m above the base\]: where its specification says, otherwise where the
    /// vehicle strikes, if the column is given by its height; hinges that are damaged or respond take it where they are.
    /// `None`: where the parameters have it.
    pub(super) fn height_of_impact(&self, vehicle: &str, given: Option<f64>) -> Option<f64> {
        if given.is_some() {
            return given;
        }
        let own = self.parameters.impact_height_of(vehicle)?;
        let properties = with_impact_height(&self.parameters.column_properties(), own);
        match self.plant.with_hinges_at_impact(&properties) {
            Ok(_) => Some(own),
            Err(_) => Some(self.plant.impact_height()),
        }
    }

    /// Where an impact that the sensors have detected meets the column \[m above the base\]: at the hinges, if they are damaged;
    /// `None`: where the parameters have it.
    pub(super) fn height_of_estimates(&self) -> Option<f64> {
        let properties = self.parameters.column_properties();
        let moved = self.plant.with_hinges_at_impact(&properties);
        moved.is_err().then(|| self.plant.impact_height())
    }

    /// # Errors
    /// The vehicle would not reach the column within `response.duration`, if the column stood still.
    fn check_approach(&self, impact: &Impact) -> Result<(), Rejection> {
        let Impact { gap, velocity, .. } = impact;
        let (approach, longest) = (impact.approach_secs(), self.parameters.response_duration());
        if approach <= longest {
            return Ok(());
        }
        let reason = format!(
            "at {velocity} m/s the vehicle needs {approach} s for the gap of {gap} m; response.duration allows {longest} s: \
             report the impact when the vehicle is nearer, or increase response.duration"
        );
        Err(Rejection::new(RejectionCode::ApproachTooLong, reason))
    }

    /// Name and mechanics of a vehicle; `None` is a rigid mass.
    ///
    /// # Errors
    /// Why there is no such vehicle.
    fn vehicle_named(&self, name: &str) -> Result<(Arc<str>, Option<Vehicle>), String> {
        let chars = name.chars().take(MAX_VEHICLE_NAME_CHARS + 1).count();
        if chars > MAX_VEHICLE_NAME_CHARS || name.chars().any(|c| !is_printable(c)) {
            return Err(format!(
                "the name of the vehicle is too long or contains control characters; \
                 allowed: up to {MAX_VEHICLE_NAME_CHARS} characters, no control or invisible characters"
            ));
        }
        let vehicle = self.parameters.vehicle_named(name);
        let vehicle = vehicle.map_err(|fault| fault.to_string())?;
        let (name, crush) = split_crush(name);
        let name = match name.trim() {
            "" => self.parameters.settings().vehicle.name.as_str(),
            _ => CatalogueVehicle::named(name).map_or(RIGID, |row| row.name.as_str()),
        };
        let name = match crush {
            // To the last digit, because a recording is recomputed from it.
            Some(crush) => format!("{name}{CRUSHED_BY}{crush}").into(),
            None => name.into(),
        };
        Ok((name, vehicle))
    }

    /// A copy of the column with an impactor on its way to this height above the base \[m\]; `None`: where the
    /// parameters have it.
    ///
    /// # Errors
    /// The column cannot take an impact, or not at this height.
    pub(super) fn strike(&self, impact: Impact, height: Option<f64>) -> Result<Struck, Rejection> {
        let properties = self.properties_for(height)?.before(&impact);
        let max_duration = self.parameters.response_duration();
        self.plant.strike(&properties, impact, max_duration)
    }

    fn properties_for(&self, height: Option<f64>) -> Result<ColumnProperties, Rejection> {
        let properties = self.parameters.column_properties();
        let Some(height) = height.filter(|it| !is_same_height(*it, properties.length_below)) else {
            return Ok(properties);
        };
        let whole = properties.length_below + properties.length_above;
        let faults = [
            fault_of("height", "geometry.length_below", height),
            fault_of(
                "the length of the column above it",
                "geometry.length_above",
                whole - height,
            ),
        ];
        match faults.into_iter().flatten().next() {
            Some(fault) => Err(Rejection::new(
                RejectionCode::ImpactOutOfRange,
                with_hint_at_nan(format!("{fault}; the column is {whole} m high")),
            )),
            None => Ok(with_impact_height(&properties, height)),
        }
    }
}

/// The fault of a number that has the range of the parameter `name`.
fn fault_of(called: &str, name: &str, number: f64) -> Option<String> {
    let problem = Parameter::named(name)?
        .check(&Value::Double(number))
        .err()?;
    Some(format!("{called} = {}: {problem}", readable(number)))
}

/// A field of a message that is left out is 0.
fn with_hint_at_nan(fault: String) -> String {
    format!("{fault}; NaN (in YAML: .nan) takes the value of the parameter")
}
