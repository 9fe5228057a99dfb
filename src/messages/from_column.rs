//! Conversions between the mechanics and messages.
//!
//! The mechanics knows neither header nor column nor event, which are left empty. The conversions allocate nothing.

use crate::column::{
    self, End, HingeSample, HingeState, ImpactSpecification, Outcome, Phase, Report, Sample,
};

use super::column_twin_msgs::{
    BaseForces, ColumnState, HingeForces, ImpactEvent, ImpactReport, PerHinge, PerMass,
    PredictImpactRequest,
};

impl From<&Sample> for ColumnState {
    /// Leaves header, column and event empty.
    fn from(sample: &Sample) -> Self {
        let vehicle = &sample.vehicle;
        Self {
            phase: phase_code(sample.phase),
            time: sample.time,
            v1: sample.v1,
            u1: sample.u1,
            beta1: sample.beta1,
            u2: sample.u2,
            v1_rate: sample.v1_rate,
            u1_rate: sample.u1_rate,
            u2_rate: sample.u2_rate,
            impactor_position: sample.impactor_position,
            impactor_velocity: sample.impactor_velocity,
            gap: sample.gap,
            contact_force: sample.contact_force,
            impact_impulse: sample.impact_impulse,
            impulse: sample.impulse,
            kinetic_energy: sample.kinetic_energy,
            elastic_energy: sample.elastic_energy,
            plastic_work: sample.plastic_work,
            impact_loss: sample.impact_loss,
            damping_work: sample.damping_work,
            load_work: sample.load_work,
            ledger_residual: sample.ledger_residual,
            vehicle_velocity: PerMass::first(&vehicle.velocity, vehicle.masses),
            crush: PerMass::first(&vehicle.crush, vehicle.masses),
            permanent_crush: PerMass::first(&vehicle.permanent_crush, vehicle.masses),
            spring_force: PerMass::first(&vehicle.force, vehicle.masses),
            vehicle_dissipated: PerMass::first(&vehicle.dissipated, vehicle.masses),
            vehicle_elastic_energy: vehicle.elastic_energy,
            ..Self::default()
        }
    }
}

impl From<&Sample> for HingeForces {
    /// Leaves header, column and event empty.
    fn from(sample: &Sample) -> Self {
        let of = |value: fn(&HingeSample) -> f64| each(&sample.hinges, value);
        Self {
            moment: of(|hinge| hinge.moment),
            normal_force: of(|hinge| hinge.normal_force),
            rotation: of(|hinge| hinge.rotation),
            elongation: of(|hinge| hinge.elongation),
            plastic_rotation: of(|hinge| hinge.plastic_rotation),
            plastic_elongation: of(|hinge| hinge.plastic_elongation),
            utilisation: of(|hinge| hinge.utilisation),
            state: each(&sample.hinges, |hinge| hinge_state_code(hinge.state)),
            dynamic_factor: of(|hinge| hinge.dynamic_factor),
            shear_force: each(&sample.webs, |web| web.shear_force),
            shear_angle: each(&sample.webs, |web| web.plastic_angle),
            shear_utilisation: each(&sample.webs, |web| web.utilisation),
            web_state: each(&sample.webs, |web| hinge_state_code(web.state)),
            web_dynamic_factor: each(&sample.webs, |web| web.dynamic_factor),
            base: BaseForces::from(&sample.base),
            ..Self::default()
        }
    }
}

impl BaseForces {
    /// Forces that nobody knows.
    pub const UNKNOWN: Self = Self {
        shear: f64::NAN,
        moment: f64::NAN,
        normal_force: f64::NAN,
    };
}

impl From<&column::BaseForces> for BaseForces {
    fn from(forces: &column::BaseForces) -> Self {
        let column::BaseForces {
            shear,
            moment,
            normal_force,
        } = *forces;
        Self {
            shear,
            moment,
            normal_force,
        }
    }
}

impl From<&Report> for ImpactReport {
    /// Leaves header, column, event and what hits it empty, and sets the kind FORECAST, no compute time (NaN), and no
    /// assessment.
    fn from(report: &Report) -> Self {
        let (vehicle, base) = (&report.vehicle, &report.base);
        let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN);
        Self {
            kind: Self::FORECAST,
            outcome: outcome_code(report.outcome),
            max_v1: report.max_v1,
            max_v1_time: report.max_v1_time,
            residual_v1: or_nan(report.residual_v1),
            max_u2: report.max_u2,
            residual_u2: or_nan(report.residual_u2),
            release_time: or_nan(report.release_time),
            impactor_rebound: report.impactor_velocity,
            peak_contact_force: report.peak_contact_force,
            impulse: report.impulse,
            plastic_work: report.plastic_work,
            impact_loss: report.impact_loss,
            ledger_residual: report.ledger_residual,
            compute_time: f64::NAN,
            first_yield_time: each(&report.hinges, |hinge| or_nan(hinge.first_yield)),
            max_utilisation: each(&report.hinges, |hinge| hinge.max_utilisation),
            plastic_rotation: each(&report.hinges, |hinge| hinge.plastic_rotation),
            web_first_yield_time: each(&report.webs, |web| or_nan(web.first_yield)),
            web_max_utilisation: each(&report.webs, |web| web.max_utilisation),
            shear_angle: each(&report.webs, |web| web.plastic_angle),
            base_plateau: base
                .plateau
                .as_ref()
                .map_or(BaseForces::UNKNOWN, BaseForces::from),
            base_peak_shear: BaseForces::from(&base.peak_shear),
            base_peak_shear_time: base.peak_shear_time,
            base_reversed_shear: BaseForces::from(&base.reversed_shear),
            base_peak_moment: BaseForces::from(&base.peak_moment),
            base_least_compressed: BaseForces::from(&base.least_compressed),
            base_most_compressed: BaseForces::from(&base.most_compressed),
            base_checked_moment: BaseForces::from(&base.checked_moment),
            end: end_code(report.end),
            end_time: report.end_time,
            max_crush: PerMass::first(&vehicle.max_crush, vehicle.masses),
            permanent_crush: PerMass::first(&vehicle.permanent_crush, vehicle.masses),
            vehicle_dissipated: PerMass::first(&vehicle.dissipated, vehicle.masses),
            vehicle_velocity: PerMass::first(&vehicle.velocity, vehicle.masses),
            max_dynamic_factor: report.max_dynamic_factor.into(),
            undamaged_capacity: f64::NAN,
            residual_capacity: f64::NAN,
            capacity_ratio: f64::NAN,
            reserve: f64::NAN,
            action: Self::ACTION_UNKNOWN,
            range_least: Self::ACTION_UNKNOWN,
            range_most: Self::ACTION_UNKNOWN,
            error_estimate: f64::NAN,
            ..Self::default()
        }
    }
}

impl ImpactReport {
    /// The report with what hit the column.
    #[must_use]
    pub fn of_impact(self, vehicle: &str, mass: f64, velocity: f64, direction: f64) -> Self {
        Self {
            vehicle: vehicle.to_owned(),
            mass,
            velocity,
            direction,
            ..self
        }
    }
}

/// A value of each hinge or web.
fn each<H, T: Copy + Default, const N: usize>(
    hinges: &[H; N],
    value: impl Fn(&H) -> T,
) -> PerHinge<T> {
    hinges.each_ref().map(value).into()
}

impl From<&ImpactSpecification> for ImpactEvent {
    /// Leaves header, column and event empty; an open value becomes NaN.
    fn from(impact: &ImpactSpecification) -> Self {
        Self {
            mass: impact.mass,
            velocity: impact.velocity,
            gap: impact.gap.unwrap_or(f64::NAN),
            restitution: impact.restitution.unwrap_or(f64::NAN),
            height: impact.height.unwrap_or(f64::NAN),
            direction: impact.direction.unwrap_or(f64::NAN),
            ..Self::default()
        }
    }
}

impl From<&ImpactEvent> for ImpactSpecification {
    fn from(event: &ImpactEvent) -> Self {
        Self {
            mass: event.mass,
            velocity: event.velocity,
            gap: given(event.gap),
            restitution: given(event.restitution),
            height: given(event.height),
            direction: given(event.direction),
        }
    }
}

impl From<&PredictImpactRequest> for ImpactSpecification {
    fn from(request: &PredictImpactRequest) -> Self {
        Self {
            mass: request.mass,
            velocity: request.velocity,
            gap: given(request.gap),
            restitution: given(request.restitution),
            height: given(request.height),
            direction: given(request.direction),
        }
    }
}

/// NaN means that the parameters give the value. An infinite value counts as given, and is rejected later.
fn given(number: f64) -> Option<f64> {
    (!number.is_nan()).then_some(number)
}

fn phase_code(phase: Phase) -> u8 {
    match phase {
        Phase::Idle => ColumnState::IDLE,
        Phase::Approach => ColumnState::APPROACH,
        Phase::Contact => ColumnState::CONTACT,
        Phase::Free => ColumnState::FREE,
    }
}

fn hinge_state_code(state: HingeState) -> u8 {
    match state {
        HingeState::Elastic => HingeForces::ELASTIC,
        HingeState::Plastic => HingeForces::PLASTIC,
        HingeState::Unloaded => HingeForces::UNLOADED,
    }
}

pub(crate) fn outcome_code(outcome: Outcome) -> u8 {
    match outcome {
        Outcome::Elastic => ImpactReport::ELASTIC,
        Outcome::Plastic => ImpactReport::PLASTIC,
        Outcome::Collapsed => ImpactReport::COLLAPSED,
        Outcome::Fractured => ImpactReport::FRACTURED,
    }
}

pub(crate) fn end_code(end: End) -> u8 {
    match end {
        End::AtRest => ImpactReport::END_AT_REST,
        End::DurationReached => ImpactReport::END_DURATION_REACHED,
        End::Collapsed => ImpactReport::END_COLLAPSED,
        End::Fractured => ImpactReport::END_FRACTURED,
        End::NotConverged => ImpactReport::END_NOT_CONVERGED,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_nan_leaves_a_value_open() {
        let open = ImpactSpecification {
            mass: 1500.0,
            velocity: f64::NEG_INFINITY,
            gap: None,
            restitution: Some(f64::INFINITY),
            height: None,
            direction: None,
        };
        assert_eq!(ImpactSpecification::from(&ImpactEvent::from(&open)), open);
    }
}
