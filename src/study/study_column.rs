//! A column that is prepared once for many impacts, and what one impact on it leads to.

use serde::Serialize;

use crate::assessment::{PreparedAssessment, Severity};
use crate::column::{
    CapacityError, Impact, ImpactSpecification, Model, Outcome, Progress, Response,
    SimulationError, State, residual_state,
};
use crate::parameters::{CatalogueVehicle, Parameters, VehicleFault};

/// A column that is prepared once for many impacts.
#[derive(Debug, Clone)]
pub struct StudyColumn {
    parameters: Parameters,
    model: Model,
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
        let assessment = PreparedAssessment::new(parameters, &model)?;
        Ok(Self {
            parameters: parameters.clone(),
            model,
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
    /// # Errors
    /// An impact that is out of range, or a step that does not converge. A collapse is a result.
    pub fn screen(&self, impact: &Impact) -> Result<Screening, StudyError> {
        let (parameters, model) = (&self.parameters, &self.model);
        let mut state = self.rest;
        let duration = parameters.response_duration();
        let mut response =
            Response::begin(model, &mut state, *impact, duration).map_err(SimulationError::from)?;
        let report = loop {
            let progress = response.advance(model, &mut state, u64::MAX);
            if let Progress::Over(end) = progress.map_err(SimulationError::from)? {
                break response.report(model, &state, end);
            }
        };
        let stands = matches!(report.outcome, Outcome::Elastic | Outcome::Plastic);
        let rest = stands.then(|| residual_state(model, &state)).flatten();
        let remaining = self.assessment.remaining(model, rest.as_ref())?;
        let verdict = self.assessment.verdict(model, impact, &report, remaining);
        let rotations = report.hinges.map(|hinge| hinge.plastic_rotation.abs());
        Ok(Screening {
            severity: verdict.severity,
            deciding_criterion: verdict.deciding_criterion,
            outcome: report.outcome,
            max_v1: report.max_v1,
            residual_v1: report.residual_v1,
            peak_contact_force: report.peak_contact_force,
            remaining_capacity: remaining.now.force,
            capacity_ratio: remaining.ratio,
            capacity_reserve: remaining.reserve,
            max_plastic_rotation: rotations.into_iter().fold(0.0, f64::max),
        })
    }
}
