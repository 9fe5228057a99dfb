//! A column that is prepared once for many impacts, and what one impact on it leads to.

use serde::Serialize;

use crate::assessment::{AssessedResponse, PreparedAssessment, Severity};
use crate::column::{
    CapacityError, End, HINGES, Impact, ImpactSpecification, Model, Outcome, PerBar, Progress,
    Response, SimulationError, State, StudyModel, StudyResponse, residual_state,
};
use crate::parameters::{CatalogueVehicle, Parameters, VehicleFault};

/// Margin of a criterion, relative to its limit, below which the plain response decides: ten times the error of a quick
/// response.
const NEAR_LIMIT: f64 = 1e-2;

/// Sum of the yield function of an elastic response above which the plain one decides whether the column yields. Near the
/// surface it grows about twice as fast as the displacement.
const NEAR_YIELD: f64 = 0.98;

/// Plastic rotation below which the plain response decides whether the column yields \[rad\]: a tenth of a per cent of the
/// yield rotation of a stocky column.
const BARELY_PLASTIC: f64 = 2e-5;

/// Plastic rotation below which many small flows at the crests of a vibration make a column sensitive whose strength depends
/// on the rate \[rad\].
const SENSITIVE_WITH_RATE: f64 = 5e-3;

/// Part of the largest displacement by which half of the last step of a torn column may move it without a closer look.
const UNCERTAIN_STEP: f64 = 8e-4;

/// Bound of the error of the instant at which a column tears, relative to the length of a stride, found on the maps of the
/// tests.
const INSTANT_ERROR: f64 = 0.08;

/// A column that is prepared once for many impacts.
#[derive(Debug, Clone)]
pub struct StudyColumn {
    parameters: Parameters,
    model: Model,
    study_model: StudyModel,
    /// The column at rest, as each impact finds it.
    rest: State,
    assessment: PreparedAssessment,
}

/// What one impact leads to, as far as a study compares it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Screening {
    /// What has to be done.
    pub severity: Severity,
    /// Name of the criterion that decides.
    pub deciding_criterion: &'static str,
    /// Whether the column yields, collapses or tears.
    pub outcome: Outcome,
    /// Largest displacement of the impact point \[m\].
    pub max_v1: f64,
    /// The same in the equilibrium that remains \[m\]; `None` if there is none.
    pub residual_v1: Option<f64>,
    /// Largest contact force \[N\].
    pub peak_contact_force: f64,
    /// `N_u`: remaining axial capacity \[N\]; 0 if the column carries nothing.
    pub remaining_capacity: f64,
    /// `N_u` over that of the virgin column.
    pub capacity_ratio: f64,
    /// `N_u` over the load that the column carries; `None` where that is not compressive.
    pub capacity_reserve: Option<f64>,
    /// Largest plastic rotation of a hinge \[rad\].
    pub max_plastic_rotation: f64,
}

/// Why a study cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StudyError {
    /// The column, the impact or a step.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The capacity.
    #[error(transparent)]
    Capacity(#[from] CapacityError),
    /// The vehicle.
    #[error(transparent)]
    Vehicle(#[from] VehicleFault),
}

impl StudyColumn {
    /// The virgin column.
    ///
    /// # Errors
    /// Properties that make no column, or an imperfection out of its range.
    pub fn virgin(parameters: &Parameters) -> Result<Self, StudyError> {
        let model = Model::new(&parameters.column_properties()).map_err(SimulationError::from)?;
        Self::at_rest(parameters, model, State::at_rest(&model))
    }

    /// The column of this model as it is at rest, with all damage that it has. The model may have hinges 1a and 1b at another
    /// height than the parameters.
    ///
    /// # Errors
    /// An imperfection out of its range.
    pub fn at_rest(parameters: &Parameters, model: Model, rest: State) -> Result<Self, StudyError> {
        let study_model = StudyModel::of_model(model, 1.0);
        let assessment = PreparedAssessment::new(parameters, &model)?;
        Ok(Self {
            parameters: parameters.clone(),
            model,
            study_model,
            rest,
            assessment,
        })
    }

    /// The parameters.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The impact of a vehicle: that of the parameters, where none is named. Without a mass \[kg\] a named vehicle has its own,
    /// that of the parameters theirs. Gap and restitution are those of the parameters; the velocity is in m/s.
    ///
    /// # Errors
    /// A vehicle that is not known, or a mass that leaves nothing for its rearmost mass.
    pub fn impact(
        &self,
        vehicle: Option<&str>,
        mass: Option<f64>,
        velocity: f64,
    ) -> Result<Impact, StudyError> {
        let defaults = self.parameters.impact();
        // The rigid mass has none of its own.
        let own_mass = vehicle.is_some_and(|name| CatalogueVehicle::named(name).is_some());
        let default_mass = if own_mass { f64::NAN } else { defaults.mass };
        let specification = ImpactSpecification {
            mass: mass.unwrap_or(default_mass),
            velocity,
            gap: None,
            restitution: None,
            height: None,
        };
        let vehicle = self.parameters.vehicle_named(vehicle.unwrap_or(""))?;
        let completed = specification.complete(&defaults, vehicle);
        Ok(completed.map_err(VehicleFault::from)?)
    }

    /// What this impact leads to.
    ///
    /// Severity, deciding criterion and outcome are those of the plain simulation with its full assessment; the largest
    /// displacement agrees with it within 1e-3, the largest contact force within 3e-3. The remaining capacity is that of the
    /// residual state found and agrees within 1e-3. Where the quick response cannot promise the severity, and for a column that is damaged before the impact, the plain one is computed.
    ///
    /// # Errors
    /// An impact that is out of range, or a step that does not converge. A collapse is a result.
    pub fn screen(&self, impact: &Impact) -> Result<Screening, StudyError> {
        // The rules of the quick response were validated on virgin columns.
        if self.rest.plastic == PerBar::default()
            && let Ok(quick) = self.respond_quickly(impact)
            && let Some(screening) = self.certain(impact, quick)?
        {
            return Ok(screening);
        }
        let (screening, _) = self.judged(impact, &self.respond(impact)?)?;
        Ok(screening)
    }

    /// The severity of this impact, without the other numbers of [`screen`](Self::screen): neither does a collapse need its
    /// largest displacement, nor a push-down its end.
    ///
    /// # Errors
    /// As [`screen`](Self::screen).
    pub fn severity(&self, impact: &Impact) -> Result<Severity, StudyError> {
        if self.rest.plastic == PerBar::default()
            && let Ok(quick) = self.respond_quickly(impact)
            && let Some(severity) = self.certain_severity(impact, &quick)?
        {
            return Ok(severity);
        }
        let (screening, _) = self.judged(impact, &self.respond(impact)?)?;
        Ok(screening.severity)
    }

    /// The severity after a quick response; `None` if the plain one might have another.
    fn certain_severity(
        &self,
        impact: &Impact,
        quick: &StudyResponse,
    ) -> Result<Option<Severity>, StudyError> {
        let at_limit = match quick.outcome {
            Outcome::Collapsed | Outcome::Severed => return Ok(Some(Severity::Evacuate)),
            Outcome::Elastic => quick.utilisation_sum > NEAR_YIELD,
            Outcome::Plastic => largest(&quick.plastic_rotation) < BARELY_PLASTIC,
        };
        let Some(rest) = quick
            .rest
            .filter(|_| !at_limit && quick.end != End::DurationReached)
        else {
            return Ok(None);
        };
        let response = AssessedResponse {
            outcome: quick.outcome,
            plastic_rotation: quick.plastic_rotation,
            max_v1: quick.max_v1,
        };
        let assessment = &self.assessment;
        Ok(assessment.severity(&self.model, impact, &response, &rest, NEAR_LIMIT)?)
    }

    /// The response in long steps, which ends as soon as nothing can change any more.
    fn respond_quickly(&self, impact: &Impact) -> Result<StudyResponse, SimulationError> {
        let duration = self.parameters.response_duration();
        self.study_model.respond(&self.rest, impact, duration)
    }

    /// The screening by a quick response; `None` if the plain one might have another result.
    fn certain(
        &self,
        impact: &Impact,
        mut quick: StudyResponse,
    ) -> Result<Option<Screening>, StudyError> {
        let at_limit = match quick.outcome {
            // Its largest displacement has no limit for short steps.
            Outcome::Collapsed => true,
            Outcome::Severed => !self.settle_torn(&mut quick),
            Outcome::Elastic => quick.utilisation_sum > NEAR_YIELD,
            Outcome::Plastic => {
                let largest = largest(&quick.plastic_rotation);
                let rates = self.study_model.model().properties.rate.is_some();
                largest < BARELY_PLASTIC
                    || (rates && impact.vehicle.is_some() && largest < SENSITIVE_WITH_RATE)
            }
        };
        if at_limit || quick.end == End::DurationReached {
            return Ok(None);
        }
        let response = Ended {
            response: AssessedResponse {
                outcome: quick.outcome,
                plastic_rotation: quick.plastic_rotation,
                max_v1: quick.max_v1,
            },
            rest: quick.rest,
            peak_contact_force: quick.peak_contact_force,
        };
        let (screening, least_margin) = self.judged(impact, &response)?;
        Ok((least_margin > NEAR_LIMIT || quick.outcome == Outcome::Severed).then_some(screening))
    }

    /// The largest displacement of a column that is torn is where the step ends in which that happens, so that it depends on
    /// how the instants of the steps lie. Where a step moves the column little, the middle of what is possible is taken, at
    /// most half a step away; otherwise the instant must be certain. `false` if it is not, or if the displacement at which a
    /// hinge tears depends on the rate.
    fn settle_torn(&self, quick: &mut StudyResponse) -> bool {
        let model = self.study_model.model();
        let Some(share) = quick.torn_after.filter(|_| model.properties.rate.is_none()) else {
            return false;
        };
        let moved = quick.end_rate * model.step_secs;
        if 0.5 * moved.abs() <= UNCERTAIN_STEP * quick.max_v1 {
            // It has moved by `1 - share` of a step since, and may move by anything between nothing and a whole one.
            quick.max_v1 += (share - 0.5) * moved;
            return true;
        }
        let error = INSTANT_ERROR * quick.stride_secs / model.step_secs;
        share.min(1.0 - share) > error
    }

    /// The plain response.
    fn respond(&self, impact: &Impact) -> Result<Ended, SimulationError> {
        let model = &self.model;
        let mut state = self.rest;
        let duration = self.parameters.response_duration();
        let mut response = Response::begin(model, &mut state, *impact, duration)?;
        let report = loop {
            if let Progress::Over(end) = response.advance(model, &mut state, u64::MAX)? {
                break response.report(model, &state, end);
            }
        };
        let stands = matches!(report.outcome, Outcome::Elastic | Outcome::Plastic);
        Ok(Ended {
            response: AssessedResponse {
                outcome: report.outcome,
                plastic_rotation: report.hinges.map(|hinge| hinge.plastic_rotation),
                max_v1: report.max_v1,
            },
            rest: stands.then(|| residual_state(model, &state)).flatten(),
            peak_contact_force: report.peak_contact_force,
        })
    }

    /// The screening of a response, and the least margin of its criteria.
    fn judged(&self, impact: &Impact, ended: &Ended) -> Result<(Screening, f64), CapacityError> {
        let Ended { response, rest, .. } = ended;
        let remaining = self.assessment.remaining(&self.model, rest.as_ref())?;
        let verdict = self
            .assessment
            .verdict(&self.model, impact, response, remaining);
        let screening = Screening {
            severity: verdict.severity,
            deciding_criterion: verdict.deciding_criterion,
            outcome: response.outcome,
            max_v1: response.max_v1,
            residual_v1: rest.as_ref().map(|rest| rest.displacement.v1),
            peak_contact_force: ended.peak_contact_force,
            remaining_capacity: remaining.now.force,
            capacity_ratio: remaining.ratio,
            capacity_reserve: remaining.reserve,
            max_plastic_rotation: largest(&response.plastic_rotation),
        };
        Ok((screening, verdict.least_margin))
    }
}

/// A response that is over, quick or plain.
struct Ended {
    response: AssessedResponse,
    rest: Option<State>,
    peak_contact_force: f64,
}

/// The largest absolute plastic rotation \[rad\].
fn largest(rotations: &[f64; HINGES]) -> f64 {
    let rotations = rotations.iter().map(|rotation| rotation.abs());
    rotations.fold(0.0, f64::max)
}
