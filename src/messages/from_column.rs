//! What the column computes, as messages.
//!
//! A header, a column and an event are not the column's to know: the conversions leave them as they are, or empty.
//! Nothing is allocated, so that a message that is kept can be filled a thousand times a second.

use crate::column::{
    End, HINGES, HingeReport, HingeSample, HingeState, Outcome, Phase, Report, Sample,
};

use super::column_twin::{ColumnState, HingeForces, ImpactReport};

impl ColumnState {
    /// Takes all values from `sample`; header, column and event stay.
    pub fn set_sample(&mut self, sample: &Sample) {
        self.phase = phase_code(sample.phase);
        self.time = sample.time;
        self.v1 = sample.v1;
        self.u1 = sample.u1;
        self.beta1 = sample.beta1;
        self.u2 = sample.u2;
        self.v1_rate = sample.v1_rate;
        self.u1_rate = sample.u1_rate;
        self.u2_rate = sample.u2_rate;
        self.impactor_position = sample.impactor_position;
        self.impactor_velocity = sample.impactor_velocity;
        self.gap = sample.gap;
        self.contact_force = sample.contact_force;
        self.percussion = sample.percussion;
        self.impulse = sample.impulse;
        self.kinetic_energy = sample.kinetic_energy;
        self.elastic_energy = sample.elastic_energy;
        self.plastic_work = sample.plastic_work;
        self.impact_loss = sample.impact_loss;
        self.damping_work = sample.damping_work;
        self.load_work = sample.load_work;
        self.ledger_residual = sample.ledger_residual;
    }
}

impl HingeForces {
    /// Takes all values from `sample`; header, column and event stay.
    pub fn set_sample(&mut self, sample: &Sample) {
        let of = |value: fn(&HingeSample) -> f64| each_hinge(&sample.hinges, value);
        self.moment = of(|hinge| hinge.moment);
        self.normal_force = of(|hinge| hinge.normal_force);
        self.rotation = of(|hinge| hinge.rotation);
        self.elongation = of(|hinge| hinge.elongation);
        self.plastic_rotation = of(|hinge| hinge.plastic_rotation);
        self.plastic_elongation = of(|hinge| hinge.plastic_elongation);
        self.utilisation = of(|hinge| hinge.utilisation);
        self.state = each_hinge(&sample.hinges, |hinge| hinge_state_code(hinge.state));
    }
}

impl From<&Sample> for ColumnState {
    /// With an empty header, column and event.
    fn from(sample: &Sample) -> Self {
        let mut message = Self::default();
        message.set_sample(sample);
        message
    }
}

impl From<&Sample> for HingeForces {
    /// With an empty header, column and event.
    fn from(sample: &Sample) -> Self {
        let mut message = Self::default();
        message.set_sample(sample);
        message
    }
}

impl From<&Report> for ImpactReport {
    /// With an empty header, column and event, of kind FORECAST, and without a compute time (NaN).
    fn from(report: &Report) -> Self {
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
            first_yield_time: each_hinge(&report.hinges, |hinge| or_nan(hinge.first_yield)),
            max_utilisation: each_hinge(&report.hinges, |hinge: &HingeReport| {
                hinge.max_utilisation
            }),
            plastic_rotation: each_hinge(&report.hinges, |hinge| hinge.plastic_rotation),
            end: end_code(report.end),
            end_time: report.end_time,
            ..Self::default()
        }
    }
}

fn each_hinge<H, T>(hinges: &[H; HINGES], value: impl Fn(&H) -> T) -> [T; HINGES] {
    hinges.each_ref().map(value)
}

/// Code of `phase` in [`ColumnState`] and [`super::column_twin::TwinStatus`].
pub fn phase_code(phase: Phase) -> u8 {
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

fn outcome_code(outcome: Outcome) -> u8 {
    match outcome {
        Outcome::Elastic => ImpactReport::ELASTIC,
        Outcome::Plastic => ImpactReport::PLASTIC,
        Outcome::Collapsed => ImpactReport::COLLAPSED,
    }
}

fn end_code(end: End) -> u8 {
    match end {
        End::AtRest => ImpactReport::END_AT_REST,
        End::DurationReached => ImpactReport::END_DURATION_REACHED,
        End::Collapsed => ImpactReport::END_COLLAPSED,
    }
}
