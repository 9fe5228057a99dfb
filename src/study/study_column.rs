//! A column that is prepared once for many impacts, and what one impact on it leads to.

use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;

use crate::assessment::{
    Action, AssessedResponse, AssessmentInput, BaseDemand, ConnectedBase, ImpactEvaluation,
    PreparedAssessment, largest_plastic_rotation, observe_from,
};
use crate::column::{
    CapacityError, ColumnProperties, End, HINGES, Impact, ImpactSpecification, Model, Outcome,
    PerBar, Scheme, SimulationError, State, StudyModel, StudyResponse, Vehicle, carried_over,
    residual_state,
};
use crate::parameters::{CatalogueVehicle, ParameterFaults, Parameters, VehicleFault};

/// Margin of a criterion, relative to its limit, below which the plain response decides: ten times the error of a quick
/// response.
const NEAR_LIMIT: f64 = 1e-2;

/// By how much the steps of a fine response are shorter than those of a quick one, whose error they divide by four.
const FINENESS: f64 = 2.0;

/// What a response in long steps can promise. The bounds are those of the errors on the maps of the tests, with a margin.
#[derive(Debug, Clone, Copy)]
struct Promise {
    /// Sum of the yield function of an elastic response above which another response decides whether the column yields. Near
    /// the surface it grows about twice as fast as the displacement.
    near_yield: f64,
    /// Plastic rotation below which many small flows at the crests of a vibration make a column too sensitive whose strength
    /// depends on the rate and that a deformable vehicle strikes \[rad\].
    sensitive_with_rate: f64,
    /// Whether it knows how far a column has moved whose strength depends on the rate when a hinge fractures.
    tears_with_rate: bool,
}

/// A quick response.
const QUICK: Promise = Promise {
    near_yield: 0.98,
    sensitive_with_rate: 5e-3,
    tears_with_rate: false,
};

/// A fine response.
const FINE: Promise = Promise {
    near_yield: 0.995,
    sensitive_with_rate: 0.0,
    tears_with_rate: true,
};

/// Plastic rotation below which the plain response decides whether the column yields \[rad\]: a tenth of a per cent of the
/// yield rotation of a stocky column.
const BARELY_PLASTIC: f64 = 2e-5;

/// What a column has that its parameters do not say, for the bands of boundaries.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) enum Assumed {
    /// Nothing.
    #[default]
    Nothing,
    /// Its steel has the largest strength that it may have; the parameters with the nominal one, of which the base is.
    LargestStrength(Arc<Parameters>),
    /// The plate that is assumed at its base limits the response, too.
    PlateInResponse,
}

/// The column before a bumper of this height \[m\].
type BeforeBumper = (f64, Arc<StudyColumn>);

/// The column with its impact point at this height \[m\].
type StruckElsewhere = (f64, Arc<StudyColumn>);

/// A column that is prepared once for many impacts.
#[derive(Debug, Clone)]
pub struct StudyColumn {
    parameters: Parameters,
    model: Model,
    study_model: StudyModel,
    /// The same with shorter steps, where those are not certain.
    fine_model: StudyModel,
    /// The same with the steps of the model, where those are not, either.
    stepwise_model: StudyModel,
    /// The column at rest, as each impact finds it.
    rest: State,
    assessment: PreparedAssessment,
    /// What it has that its parameters do not say.
    assumed: Assumed,
    /// The same column before the bumpers of other vehicles, by their height, once an impact has needed them.
    before_bumpers: Arc<Mutex<Vec<BeforeBumper>>>,
    /// The same column where other vehicles strike it, by the height of the impact point, once an impact has needed them.
    struck_elsewhere: Arc<Mutex<Vec<StruckElsewhere>>>,
}

/// What one impact leads to, as far as a study compares it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Evaluation {
    /// What has to be done.
    pub action: Action,
    /// Name of the criterion that decides.
    pub deciding_criterion: &'static str,
    /// Whether the column yields, collapses or fractures.
    pub outcome: Outcome,
    /// Peak displacement of the impact point \[m\].
    pub max_v1: f64,
    /// The same in the equilibrium that remains \[m\]; `None` if there is none.
    pub residual_v1: Option<f64>,
    /// Largest contact force \[N\].
    pub peak_contact_force: f64,
    /// `N_u`: residual axial capacity \[N\]; 0 if the column carries nothing.
    pub residual_capacity: f64,
    /// `N_u` over that of the undamaged column.
    pub capacity_ratio: f64,
    /// `N_u` over the load that the column carries; `None` where that is not compressive.
    pub reserve: Option<f64>,
    /// Largest plastic rotation, of hinges 1a and 1b together \[rad\].
    pub max_plastic_rotation: f64,
    /// Largest plastic shear angle of the web of a bar \[rad\]; above 0 the web has yielded in shear.
    pub max_plastic_shear: f64,
    /// Largest utilisation of the base by shear, moment or uplift, with the overstrength of the column; above 1 the connection
    /// fails. `None` where it is not known.
    pub base_utilisation: Option<f64>,
}

/// What a search for boundaries needs to know of an impact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Glance {
    /// What has to be done.
    pub action: Action,
    /// Whether the web of a bar yields in shear.
    pub web_yields: bool,
    /// Whether the connection of the base fails.
    pub base_fails: bool,
}

impl From<&Evaluation> for Glance {
    fn from(evaluation: &Evaluation) -> Self {
        Self {
            action: evaluation.action,
            web_yields: evaluation.max_plastic_shear > 0.0,
            base_fails: evaluation.base_utilisation.is_some_and(|it| it > 1.0),
        }
    }
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
    /// The impact point.
    #[error("the column cannot be hit where this vehicle strikes: {}", .0.in_one_line())]
    ImpactPoint(ParameterFaults),
    /// A damaged column before a bumper.
    #[error(
        "the damaged column has no equilibrium before the bumper of this vehicle; give another vehicle, or its bumper_height"
    )]
    NoEquilibrium,
}

impl StudyColumn {
    /// The undamaged column.
    ///
    /// # Errors
    /// Properties that make no column, or an imperfection out of its range.
    pub fn undamaged(parameters: &Parameters) -> Result<Self, StudyError> {
        let model = Model::new(&parameters.column_properties()).map_err(SimulationError::from)?;
        Self::at_rest(parameters, model, State::at_rest(&model))
    }

    /// The column of this model as it is at rest, with all damage that it has. The model may have hinges 1a and 1b at another
    /// height than the parameters.
    ///
    /// # Errors
    /// An imperfection out of its range.
    pub fn at_rest(parameters: &Parameters, model: Model, rest: State) -> Result<Self, StudyError> {
        let [study_model, fine_model] =
            [1.0, FINENESS].map(|fineness| StudyModel::of_model(model, fineness));
        let assessment = PreparedAssessment::new(parameters, &model)?;
        Ok(Self {
            parameters: parameters.clone(),
            model,
            study_model,
            fine_model,
            stepwise_model: StudyModel::stepwise(model),
            rest,
            assessment,
            assumed: Assumed::Nothing,
            before_bumpers: Arc::default(),
            struck_elsewhere: Arc::default(),
        })
    }

    /// As [`undamaged`](Self::undamaged), with what the parameters do not say.
    ///
    /// # Errors
    /// As [`undamaged`](Self::undamaged).
    pub(super) fn assuming(parameters: &Parameters, assumed: &Assumed) -> Result<Self, StudyError> {
        let own = parameters.column_properties();
        let properties = match assumed {
            Assumed::Nothing => own,
            // The plate of the base is not of the same piece of steel.
            Assumed::LargestStrength(nominal) => {
                let nominal = nominal.column_properties();
                ColumnProperties {
                    base: nominal.base,
                    base_connection: nominal.base_connection,
                    ..own
                }
            }
            Assumed::PlateInResponse => {
                ConnectedBase::of(parameters).map_or(own, |base| own.on_plate(base.resistance))
            }
        };
        let model = Model::new(&properties).map_err(SimulationError::from)?;
        let mut column = Self::at_rest(parameters, model, State::at_rest(&model))?;
        if let Assumed::LargestStrength(nominal) = assumed {
            column.assessment = column.assessment.with_overstrength(nominal);
        }
        column.assumed = assumed.clone();
        Ok(column)
    }

    /// Whether the web of a bar can yield in shear, and whether the base is checked.
    #[must_use]
    pub fn limits(&self) -> [bool; 2] {
        let web = self.model.properties.shear.is_some();
        [web, self.assessment.has_base()]
    }

    /// The column before the bumper of this impact, where that is another than the one for which this column was prepared.
    ///
    /// # Errors
    /// The bumper leaves too little of a bar clear, or the damaged column has no equilibrium before it.
    fn before(&self, impact: &Impact) -> Result<Option<Arc<Self>>, StudyError> {
        let properties = self.model.properties.before(impact);
        let height = |properties: &ColumnProperties| properties.shear.map(|it| it.bumper_height);
        let wanted = height(&properties);
        let Some(wanted) = wanted.filter(|_| wanted != height(&self.model.properties)) else {
            return Ok(None);
        };
        let lock = || {
            self.before_bumpers
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        if let Some((_, known)) = lock().iter().find(|(height, _)| *height == wanted) {
            return Ok(Some(Arc::clone(known)));
        }
        let model = Model::new(&ColumnProperties {
            step_nanos: self.step_nanos(),
            ..properties
        })
        .map_err(SimulationError::from)?;
        let carried = carried_over(&self.model, &self.rest, &model);
        let rest = match carried.plastic == PerBar::default() {
            true => carried,
            false => residual_state(&model, &carried).ok_or(StudyError::NoEquilibrium)?,
        };
        let column = Self::at_rest(&self.parameters, model, rest)?;
        let mut column = column.with_base_before(self.base_before().copied());
        if let Assumed::LargestStrength(nominal) = &self.assumed {
            column.assessment = column.assessment.with_overstrength(nominal);
        }
        column.assumed = self.assumed.clone();
        let column = Arc::new(column);
        lock().push((wanted, Arc::clone(&column)));
        Ok(Some(column))
    }

    /// This column where a vehicle of this name strikes it, see [`Parameters::impact_height_of`]; `None` where it is that already,
    /// and for a damaged column, whose hinges stay where they are.
    ///
    /// # Errors
    /// The vehicle strikes too near to the top of the column, or above it.
    pub fn struck_by(&self, vehicle: Option<&str>) -> Result<Option<Arc<Self>>, StudyError> {
        let height = self.parameters.impact_height_of(vehicle.unwrap_or(""));
        let height = height.filter(|_| !self.is_damaged());
        let (Some(height), Some(vehicle)) = (height, vehicle) else {
            return Ok(None);
        };
        let lock = || {
            self.struck_elsewhere
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        if let Some((_, known)) = lock().iter().find(|(known, _)| *known == height) {
            return Ok(Some(Arc::clone(known)));
        }
        let there = self.parameters.struck_by(vehicle);
        let Some(there) = there.map_err(StudyError::ImpactPoint)? else {
            return Ok(None);
        };
        let column = Arc::new(Self::assuming(&there, &self.assumed)?);
        lock().push((height, Arc::clone(&column)));
        Ok(Some(column))
    }

    /// Length of a step as the parameters give it \[ns\]; 0 where the model chooses it.
    fn step_nanos(&self) -> u64 {
        self.parameters.column_properties().step_nanos
    }

    /// The parameters.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The impact of a vehicle: that of the parameters, where none is named. Without a mass \[kg\] a named vehicle has its own,
    /// that of the parameters theirs. Gap, restitution and direction are those of the parameters; the velocity is that of the vehicle in
    /// m/s, of which the two bars take the component in their plane.
    ///
    /// # Errors
    /// A vehicle that is not known, or a mass that is not a finite number > 0.
    pub fn impact(
        &self,
        vehicle: Option<&str>,
        mass: Option<f64>,
        velocity: f64,
    ) -> Result<Impact, StudyError> {
        self.impacts_of(vehicle)?.impact(mass, velocity)
    }

    /// The impacts of one vehicle, for many masses and velocities; see [`impact`](Self::impact).
    ///
    /// # Errors
    /// A vehicle that is not known.
    pub fn impacts_of(&self, vehicle: Option<&str>) -> Result<VehicleImpacts, StudyError> {
        let defaults = self.parameters.whole_impact();
        let name = vehicle.unwrap_or("");
        let named = self.parameters.vehicle_named(name)?;
        let own_mass = vehicle.is_some_and(|name| CatalogueVehicle::named(name).is_some());
        // A rigid vehicle has the mass of the parameters, but not the own mass of their vehicle.
        let given_mass = self.parameters.settings().impact.mass;
        let lacks_mass = vehicle.is_some() && named.is_none() && given_mass == 0.0;
        let has_default = !(own_mass || lacks_mass);
        Ok(VehicleImpacts {
            default_mass: if has_default { defaults.mass } else { f64::NAN },
            defaults,
            direction: self.parameters.direction(),
            vehicle: named,
            bumper_height: self.parameters.bumper_named(name),
        })
    }

    /// The column that this impact leaves, at rest once the vehicle is gone; `None` if it has collapsed or is fractured.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn after(&self, impact: &Impact) -> Result<Option<Self>, StudyError> {
        let before = self.before(impact)?;
        let struck = before.as_deref().unwrap_or(self);
        let response = struck.respond_with(&struck.stepwise_model, impact)?;
        let stands = response.outcome.stands();
        let Some(mut rest) = response.rest.filter(|_| stands) else {
            return Ok(None);
        };
        if before.is_some() {
            let carried = carried_over(&struck.model, &rest, &self.model);
            rest = residual_state(&self.model, &carried).ok_or(StudyError::NoEquilibrium)?;
        }
        let base = self.assessment.demand(&Ended::from(&response).response);
        let left = Self::at_rest(&self.parameters, self.model, rest);
        left.map(|it| Some(it.with_base_before(Some(base))))
    }

    /// The same after impacts that have put this into the base.
    #[must_use]
    pub fn with_base_before(self, base_before: Option<BaseDemand>) -> Self {
        Self {
            assessment: self.assessment.with_base_before(base_before),
            ..self
        }
    }

    /// This column as it is, with parameters that differ in impact and vehicle alone.
    ///
    /// # Errors
    /// As [`at_rest`](Self::at_rest).
    pub fn with_impact_of(&self, parameters: &Parameters) -> Result<Self, StudyError> {
        let column = Self::at_rest(parameters, self.model, self.rest);
        column.map(|it| it.with_base_before(self.base_before().copied()))
    }

    /// What earlier impacts have put into the base.
    #[must_use]
    pub fn base_before(&self) -> Option<&BaseDemand> {
        self.assessment.base_before()
    }

    /// One impact on the column as it is, evaluated as in a node, and all on which the verdict depends; `None` without the capacities.
    /// `observe` sees the state at the event and after every step. Only [`ImpactEvaluation::complete`] has a range.
    ///
    /// # Errors
    /// An impact that is out of range, or a step that does not converge. A collapse is a result.
    pub fn follow(
        &self,
        impact: &Impact,
        observe: impl FnMut(&Model, &State),
    ) -> Result<(ImpactEvaluation, Option<AssessmentInput>), StudyError> {
        let before = self.before(impact)?;
        let Self { model, rest, .. } = before.as_deref().unwrap_or(self);
        let (parameters, base) = (&self.parameters, self.base_before());
        let duration = parameters.response_duration();
        let ended = observe_from(model, *rest, impact, duration, observe)?;
        Ok(ImpactEvaluation::of_damaged(
            parameters, model, *rest, base, impact, ended,
        ))
    }

    /// The column at rest, as each impact finds it.
    #[must_use]
    pub fn rest(&self) -> &State {
        &self.rest
    }

    /// Its constants.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Whether it is damaged.
    #[must_use]
    pub fn is_damaged(&self) -> bool {
        self.rest.plastic != PerBar::default()
    }

    /// What this impact leads to.
    ///
    /// Action, deciding criterion and outcome are those of the plain simulation with its full assessment; the largest
    /// displacement agrees with it within 2e-3 (1.55e-3 is the largest difference seen), the largest contact force within 3e-3. The residual capacity is that of the
    /// residual state found and agrees within 1e-3. Where the quick response cannot promise that, a finer one is computed, and
    /// where that cannot either, and for a column that is damaged before the impact, the plain one.
    ///
    /// # Errors
    /// An impact that is out of range, or a step that does not converge. A collapse is a result.
    pub fn evaluate(&self, impact: &Impact) -> Result<Evaluation, StudyError> {
        if let Some(column) = self.before(impact)? {
            return column.evaluate(impact);
        }
        if self.has_long_steps() {
            for (model, promise) in [(&self.study_model, &QUICK), (&self.fine_model, &FINE)] {
                let Ok(response) = self.respond_with(model, impact) else {
                    break;
                };
                match self.certain(impact, promise, &response)? {
                    Certainty::Certain(evaluation) => return Ok(evaluation),
                    Certainty::CloserLook => {}
                    Certainty::PlainOnly => break,
                }
            }
        }
        let (evaluation, _) = self.judged(impact, &self.respond(impact)?)?;
        Ok(evaluation)
    }

    /// The action of this impact, without the other numbers of [`evaluate`](Self::evaluate): neither does a collapse need its
    /// peak displacement, nor a push-down its end.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn action(&self, impact: &Impact) -> Result<Action, StudyError> {
        Ok(self.glance(impact)?.action)
    }

    /// As [`action`](Self::action), also whether a web yields in shear and whether the base fails, from the same response. Of
    /// a column that collapses or fractures these are as far as it was followed.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn glance(&self, impact: &Impact) -> Result<Glance, StudyError> {
        if let Some(column) = self.before(impact)? {
            return column.glance(impact);
        }
        if self.has_long_steps()
            && let Ok(quick) = self.respond_with(&self.study_model, impact)
        {
            let response = AssessedResponse {
                outcome: quick.outcome,
                plastic_rotation: quick.plastic_rotation,
                plastic_shear: quick.plastic_shear,
                residual_v1: quick.rest.map(|rest| rest.displacement.v1),
                max_v1: quick.max_v1,
                base: quick.base,
            };
            if let Some(action) = self.certain_action(impact, &quick, &response)? {
                let base = self.assessment.base_utilisation(&response);
                return Ok(Glance {
                    action,
                    web_yields: largest_shear(&response) > 0.0,
                    base_fails: base.is_some_and(|it| it > 1.0),
                });
            }
        }
        let (evaluation, _) = self.judged(impact, &self.respond(impact)?)?;
        Ok(Glance::from(&evaluation))
    }

    /// Whether there are responses in long steps: the paper's scheme has none, and their bounds were found on undamaged columns.
    fn has_long_steps(&self) -> bool {
        self.model.properties.scheme == Scheme::ConservingMidpoint && !self.is_damaged()
    }

    /// The action after a quick response; `None` if the plain one might have another.
    fn certain_action(
        &self,
        impact: &Impact,
        quick: &StudyResponse,
        response: &AssessedResponse,
    ) -> Result<Option<Action>, StudyError> {
        let at_limit = match quick.outcome {
            Outcome::Collapsed | Outcome::Fractured => return Ok(Some(Action::Evacuate)),
            Outcome::Elastic => quick.utilisation_sum > QUICK.near_yield,
            Outcome::Plastic => largest_flow(quick) < BARELY_PLASTIC,
        };
        let Some(rest) = quick
            .rest
            .filter(|_| !at_limit && quick.end != End::DurationReached)
        else {
            return Ok(None);
        };
        let assessment = &self.assessment;
        Ok(assessment.action(&self.model, impact, response, &rest, NEAR_LIMIT)?)
    }

    /// The response, which ends as soon as nothing can change any more.
    fn respond_with(
        &self,
        model: &StudyModel,
        impact: &Impact,
    ) -> Result<StudyResponse, SimulationError> {
        model.respond(&self.rest, impact, self.parameters.response_duration())
    }

    /// The evaluation by a response in long steps, if the plain one would have the same.
    fn certain(
        &self,
        impact: &Impact,
        promise: &Promise,
        response: &StudyResponse,
    ) -> Result<Certainty, StudyError> {
        if response.end == End::DurationReached {
            return Ok(Certainty::PlainOnly);
        }
        let rates = self.model.properties.rate.is_some();
        let at_limit = match response.outcome {
            // Its peak displacement has no limit for short steps.
            Outcome::Collapsed => return Ok(Certainty::PlainOnly),
            Outcome::Fractured if rates && impact.vehicle.is_none() => {
                return Ok(Certainty::PlainOnly);
            }
            Outcome::Fractured => rates && !promise.tears_with_rate,
            Outcome::Elastic => response.utilisation_sum > promise.near_yield,
            Outcome::Plastic => {
                let largest = largest_flow(response);
                largest < BARELY_PLASTIC
                    || (rates && impact.vehicle.is_some() && largest < promise.sensitive_with_rate)
            }
        };
        if at_limit {
            return Ok(Certainty::CloserLook);
        }
        let (evaluation, least_margin) = self.judged(impact, &Ended::from(response))?;
        Ok(
            match least_margin > NEAR_LIMIT || response.outcome == Outcome::Fractured {
                true => Certainty::Certain(evaluation),
                false => Certainty::PlainOnly,
            },
        )
    }

    /// The response in the steps of the model, as the plain simulation has it.
    fn respond(&self, impact: &Impact) -> Result<Ended, SimulationError> {
        let response = self.respond_with(&self.stepwise_model, impact)?;
        Ok(Ended::from(&response))
    }

    /// The evaluation of a response, and the least margin of its criteria.
    fn judged(&self, impact: &Impact, ended: &Ended) -> Result<(Evaluation, f64), CapacityError> {
        let Ended { response, rest, .. } = ended;
        let remaining = self.assessment.remaining(&self.model, rest.as_ref())?;
        let verdict = self
            .assessment
            .verdict(&self.model, impact, response, remaining);
        let evaluation = Evaluation {
            action: verdict.action,
            deciding_criterion: verdict.deciding_criterion,
            outcome: response.outcome,
            max_v1: response.max_v1,
            residual_v1: response.residual_v1,
            peak_contact_force: ended.peak_contact_force,
            residual_capacity: remaining.now.force,
            capacity_ratio: remaining.ratio,
            reserve: remaining.reserve,
            max_plastic_rotation: largest_plastic_rotation(&response.plastic_rotation),
            max_plastic_shear: largest_shear(response),
            base_utilisation: self.assessment.base_utilisation(response),
        };
        Ok((evaluation, verdict.least_margin))
    }
}

/// The impacts of one vehicle on a column, which differ in mass and velocity.
#[derive(Debug, Clone)]
pub struct VehicleImpacts {
    /// What an impact leaves open.
    defaults: Impact,
    /// Its mass where none is given \[kg\]; NaN for the vehicle's own, and where a rigid vehicle has none.
    default_mass: f64,
    /// Direction of travel \[rad\].
    direction: f64,
    vehicle: Option<Vehicle>,
    bumper_height: f64,
}

impl VehicleImpacts {
    /// The same impacts in this direction of travel \[rad\].
    #[must_use]
    pub fn in_direction(self, direction: f64) -> Self {
        Self { direction, ..self }
    }

    /// The impact with this mass \[kg\], or where there is none that of the vehicle, and this velocity \[m/s\].
    ///
    /// # Errors
    /// A mass that is not a finite number > 0.
    pub fn impact(&self, mass: Option<f64>, velocity: f64) -> Result<Impact, StudyError> {
        let specification = ImpactSpecification {
            mass: mass.unwrap_or(self.default_mass),
            velocity,
            gap: None,
            restitution: None,
            height: None,
            direction: Some(self.direction),
        };
        let completed = specification.complete(&self.defaults, self.vehicle, self.bumper_height);
        Ok(completed.map_err(VehicleFault::from)?)
    }
}

/// A response that is over.
struct Ended {
    response: AssessedResponse,
    rest: Option<State>,
    peak_contact_force: f64,
}

impl From<&StudyResponse> for Ended {
    fn from(response: &StudyResponse) -> Self {
        Self {
            response: AssessedResponse {
                outcome: response.outcome,
                plastic_rotation: response.plastic_rotation,
                plastic_shear: response.plastic_shear,
                residual_v1: response.rest.map(|rest| rest.displacement.v1),
                max_v1: response.max_v1,
                base: response.base,
            },
            rest: response.rest,
            peak_contact_force: response.peak_contact_force,
        }
    }
}

/// What a response in long steps says of the plain one.
enum Certainty {
    /// It would lead to the same.
    Certain(Evaluation),
    /// Shorter steps may tell.
    CloserLook,
    /// Only the plain one tells.
    PlainOnly,
}

/// The largest absolute plastic rotation of a hinge or plastic shear angle of a web \[rad\].
fn largest_flow(response: &StudyResponse) -> f64 {
    let webs = response.plastic_shear.map(f64::abs).into_iter();
    webs.fold(largest(&response.plastic_rotation), f64::max)
}

/// The largest absolute plastic shear angle of a web \[rad\].
fn largest_shear(response: &AssessedResponse) -> f64 {
    let angles = response.plastic_shear.iter().map(|angle| angle.abs());
    angles.fold(0.0, f64::max)
}

/// The largest absolute plastic rotation \[rad\].
fn largest(rotations: &[f64; HINGES]) -> f64 {
    let rotations = rotations.iter().map(|rotation| rotation.abs());
    rotations.fold(0.0, f64::max)
}
