//! The outcome of one impact under the names that programs see.

use std::collections::BTreeMap;
use std::time::Duration;

use serde::Serialize;

use super::beam_fields::BeamAnswer;

use crate::assessment::{
    Action, ActionRange, Assumption, Criterion, ImpactEvaluation, MissingData, PARTIAL_FACTOR,
    Variation,
};
use crate::column::{
    BaseFailure, BaseForces, BaseReport, End, ForceSpectrum, HINGE_NAMES, HINGES, HingeReport,
    Outcome, WEB_NAMES, WebReport,
};
use crate::parameters::LoadBasis;

/// The word for an outcome.
#[must_use]
pub fn outcome_word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Elastic => "elastic",
        Outcome::Plastic => "plastic",
        Outcome::Collapsed => "collapsed",
        Outcome::Fractured => "fractured",
    }
}

/// How the vehicle travels before it hits the column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    /// Its speed \[m/s\].
    pub velocity: f64,
    /// Its direction \[rad\].
    pub direction: f64,
    /// The component of its velocity in the plane of the two bars, which they take \[m/s\].
    pub in_plane: f64,
}

fields! {
    /// The outcome of one impact for programs, in SI units; the names are a stable interface. A value that does not exist is null.
    ///
    /// The name of the vehicle is empty for one that is given by numbers; the time is the computing time of the response alone. The
    /// numbers of the response and its energies are those of the two bars.
    pub struct ImpactFields<'a> of(evaluation: &'a ImpactEvaluation, vehicle_name: &'a str, travel: Travel, solve_time: Duration) {
        let report = &evaluation.report;
        let assessment = evaluation.assessment.as_ref();
        let remaining = evaluation.remaining.as_ref();
        let vehicle = &report.vehicle;
    }
    action: Option<Action> = assessment.map(|it| it.action);
    at_least: Option<bool> = assessment.map(|it| it.at_least);
    deciding_criterion: Option<&'static str> = assessment.map(|it| it.deciding_criterion);
    reason: Option<&'a str> = assessment.map(|it| it.reason.as_str());
    outcome: Outcome = report.outcome;
    end: End = report.end;
    end_time_s: f64 = report.end_time;
    max_v1_m: f64 = report.max_v1;
    max_v1_time_s: f64 = report.max_v1_time;
    residual_v1_m: Option<f64> = report.residual_v1;
    max_u2_m: f64 = report.max_u2;
    residual_u2_m: Option<f64> = report.residual_u2;
    first_contact_time_s: Option<f64> = report.first_contact_time;
    release_time_s: Option<f64> = report.release_time;
    contact_duration_s: f64 = report.contact_duration;
    impactor_velocity_m_s: f64 = report.impactor_velocity;
    peak_contact_force_n: f64 = report.peak_contact_force;
    peak_contact_force_time_s: Option<f64> = report.peak_contact_force_time;
    impact_impulses: u32 = report.impact_impulses;
    impact_impulse_n_s: f64 = report.total_impact_impulse;
    impulse_n_s: f64 = report.impulse;
    input_energy_j: f64 = report.input_energy;
    load_work_j: f64 = report.load_work;
    plastic_work_j: f64 = report.plastic_work;
    impact_loss_j: f64 = report.impact_loss;
    damping_work_j: f64 = report.damping_work;
    column_kinetic_energy_j: f64 = report.column_kinetic_energy;
    impactor_kinetic_energy_j: f64 = report.impactor_kinetic_energy;
    elastic_energy_change_j: f64 = report.elastic_energy_change;
    ledger_residual: f64 = report.ledger_residual;
    steps: u64 = report.steps;
    solve_time_s: f64 = solve_time.as_secs_f64();
    dt_s: f64 = evaluation.step;
    error_estimate: Option<f64> = evaluation.error_estimate;
    max_v1_hardening_band_m: Option<[f64; 2]> =
        evaluation.range.as_ref().and_then(ActionRange::band).map(|ends| ends.map(|it| it.report.max_v1));
    vehicle: &'a str = vehicle_name;
    velocity_m_s: f64 = travel.velocity;
    direction_rad: f64 = travel.direction;
    velocity_in_plane_m_s: f64 = travel.in_plane;
    crush_max_m: &'a [f64] = &vehicle.max_crush[..vehicle.masses];
    crush_permanent_m: &'a [f64] = &vehicle.permanent_crush[..vehicle.masses];
    vehicle_dissipated_j: &'a [f64] = &vehicle.dissipated[..vehicle.masses];
    vehicle_elastic_energy_j: f64 = vehicle.elastic_energy;
    // A rigid vehicle is one mass without a spring.
    vehicle_velocity_m_s: &'a [f64] = match vehicle.masses {
        0 => std::slice::from_ref(&report.impactor_velocity),
        masses => &vehicle.velocity[..masses],
    };
    plateau_force_n: f64 = evaluation.plateau;
    front_force_n: Option<f64> = evaluation.front_force;
    dynamic_factor_max: [f64; HINGES] = report.max_dynamic_factor;
    undamaged_capacity_n: Option<f64> = remaining.map(|it| it.undamaged.force);
    residual_capacity_n: Option<f64> = remaining.map(|it| it.now.force);
    capacity_ratio: Option<f64> = remaining.map(|it| it.ratio);
    carried_load_n: Option<f64> = remaining.map(|it| it.carried_load);
    load: Option<&'a str> = assessment.map(|it| it.load.as_str());
    load_basis: Option<LoadBasis> = assessment.map(|it| it.load_basis);
    gamma_m: f64 = PARTIAL_FACTOR;
    axial_capacity_n: Option<f64> = remaining.map(|it| it.axial_capacity);
    remaining_resistance_n: Option<f64> = remaining.and_then(|it| it.resistance);
    reserve: Option<f64> = remaining.and_then(|it| it.reserve);
    not_evaluated: Option<&'a [MissingData]> = assessment.map(|it| &*it.not_evaluated);
    range: Option<RangeFields<'a>> = evaluation.range.as_ref().map(RangeFields::of);
    criteria: Option<&'a [Criterion]> = assessment.map(|it| it.criteria.as_slice());
    hinges: BTreeMap<&'static str, HingeFields> =
        HINGE_NAMES.into_iter().zip(report.hinges.iter().map(HingeFields::of)).collect();
    /// `None` where the webs do not yield in shear.
    webs: Option<BTreeMap<&'static str, WebFields>> = evaluation.no_shear.is_none().then(|| {
        let webs = report.webs.iter().map(WebFields::of);
        WEB_NAMES.into_iter().zip(webs).collect()
    });
    /// Why they do not; `None` where they do.
    shear_not_evaluated: Option<String> = evaluation.no_shear.map(|why| why.to_string());
    base: BaseFields = BaseFields::of(&report.base);
    /// Absent where the history of the contact force was not asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    contact_force_spectrum: Option<SpectrumFields> = None;
    /// Absent where the beam was not asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    beam: Option<BeamAnswer> = None;
}

fields! {
    struct WebFields of(web: &WebReport) {}
    first_yield_s: Option<f64> = web.first_yield;
    plastic_angle_rad: f64 = web.plastic_angle;
    max_utilisation: f64 = web.max_utilisation;
    max_dynamic_factor: f64 = web.max_dynamic_factor;
    work_j: f64 = web.work;
}

fields! {
    struct HingeFields of(hinge: &HingeReport) {}
    first_yield_s: Option<f64> = hinge.first_yield;
    plastic_rotation_rad: f64 = hinge.plastic_rotation;
    plastic_elongation_m: f64 = hinge.plastic_elongation;
    max_utilisation: f64 = hinge.max_utilisation;
}

fields! {
    /// Between which actions the verdict lies.
    struct RangeFields<'a> of(range: &'a ActionRange) {}
    least: Action = range.ends.least;
    most: Action = range.ends.most;
    /// Only in what earlier programs computed: `most` reaches as far as what is not known.
    at_least: bool = range.ends.at_least;
    decided_by: &'a [Assumption] = &range.ends.decided_by;
    /// What is not known and could ask for `most`.
    not_evaluated: &'a [String] = &range.ends.not_evaluated;
    variations: Vec<VariationFields<'a>> = range.variations.iter().map(VariationFields::of).collect();
    not_varied: BTreeMap<&'static str, &'a str> =
        range.not_varied.iter().map(|(assumption, reason)| (assumption.in_words(), reason.as_str())).collect();
}

fields! {
    struct VariationFields<'a> of(variation: &'a Variation) {}
    assumption: Assumption = variation.assumption;
    instead: &'a str = &variation.instead;
    outcome: Outcome = variation.report.outcome;
    max_v1_m: f64 = variation.report.max_v1;
    residual_v1_m: Option<f64> = variation.report.residual_v1;
    action: Action = variation.action;
}

fields! {
    /// The reactions of the base: means over 1 ms, except for the plateau.
    struct BaseFields of(base: &BaseReport) {}
    plateau: Option<BaseForceFields> = base.plateau.as_ref().map(BaseForceFields::of);
    peak_shear: BaseForceFields = BaseForceFields::of(&base.peak_shear);
    peak_shear_time_s: f64 = base.peak_shear_time;
    reversed_shear: BaseForceFields = BaseForceFields::of(&base.reversed_shear);
    peak_moment: BaseForceFields = BaseForceFields::of(&base.peak_moment);
    least_compressed: BaseForceFields = BaseForceFields::of(&base.least_compressed);
    most_compressed: BaseForceFields = BaseForceFields::of(&base.most_compressed);
    checked_moment: BaseForceFields = BaseForceFields::of(&base.checked_moment);
    slip_m: f64 = base.slip;
    anchor_elongation_m: f64 = base.anchor_elongation;
    fractured: Option<&'static str> = base.fractured.map(BaseFailure::name);
}

fields! {
    struct BaseForceFields of(forces: &BaseForces) {}
    shear_n: f64 = forces.shear;
    moment_n_m: f64 = forces.moment;
    normal_force_n: f64 = forces.normal_force;
}

fields! {
    /// The equivalent static force of the contact by the period of what it pushes.
    struct SpectrumFields of(spectrum: &ForceSpectrum) {}
    period_s: Vec<f64> = ForceSpectrum::periods().to_vec();
    force_n: Vec<f64> = spectrum.equivalent_forces().to_vec();
}

impl ImpactFields<'_> {
    /// The same with the response spectrum of the contact force.
    #[must_use]
    pub fn with_spectrum(self, spectrum: &ForceSpectrum) -> Self {
        Self {
            contact_force_spectrum: Some(SpectrumFields::of(spectrum)),
            ..self
        }
    }

    /// The same with what the fibre beam says, or why it says nothing.
    #[must_use]
    pub fn with_beam(self, beam: BeamAnswer) -> Self {
        Self {
            beam: Some(beam),
            ..self
        }
    }
}
