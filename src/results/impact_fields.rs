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

/// The outcome of one impact for programs, in SI units; the names are a stable interface. A value that does not exist is null.
#[derive(Debug, Serialize)]
pub struct ImpactFields<'a> {
    action: Option<Action>,
    at_least: Option<bool>,
    deciding_criterion: Option<&'static str>,
    reason: Option<&'a str>,
    outcome: Outcome,
    end: End,
    end_time_s: f64,
    max_v1_m: f64,
    max_v1_time_s: f64,
    residual_v1_m: Option<f64>,
    max_u2_m: f64,
    residual_u2_m: Option<f64>,
    first_contact_time_s: Option<f64>,
    release_time_s: Option<f64>,
    contact_duration_s: f64,
    impactor_velocity_m_s: f64,
    peak_contact_force_n: f64,
    peak_contact_force_time_s: Option<f64>,
    impact_impulses: u32,
    impact_impulse_n_s: f64,
    impulse_n_s: f64,
    input_energy_j: f64,
    load_work_j: f64,
    plastic_work_j: f64,
    impact_loss_j: f64,
    damping_work_j: f64,
    column_kinetic_energy_j: f64,
    impactor_kinetic_energy_j: f64,
    elastic_energy_change_j: f64,
    ledger_residual: f64,
    steps: u64,
    solve_time_s: f64,
    dt_s: f64,
    error_estimate: Option<f64>,
    max_v1_hardening_band_m: Option<[f64; 2]>,
    vehicle: &'a str,
    velocity_m_s: f64,
    direction_rad: f64,
    velocity_in_plane_m_s: f64,
    crush_max_m: &'a [f64],
    crush_permanent_m: &'a [f64],
    vehicle_dissipated_j: &'a [f64],
    vehicle_elastic_energy_j: f64,
    vehicle_velocity_m_s: &'a [f64],
    plateau_force_n: f64,
    front_force_n: Option<f64>,
    dynamic_factor_max: [f64; HINGES],
    undamaged_capacity_n: Option<f64>,
    residual_capacity_n: Option<f64>,
    capacity_ratio: Option<f64>,
    carried_load_n: Option<f64>,
    load: Option<&'a str>,
    load_basis: Option<LoadBasis>,
    gamma_m: f64,
    axial_capacity_n: Option<f64>,
    remaining_resistance_n: Option<f64>,
    reserve: Option<f64>,
    not_evaluated: Option<&'a [MissingData]>,
    range: Option<RangeFields<'a>>,
    criteria: Option<&'a [Criterion]>,
    hinges: BTreeMap<&'static str, HingeFields>,
    /// `None` where the webs do not yield in shear.
    webs: Option<BTreeMap<&'static str, WebFields>>,
    /// Why they do not; `None` where they do.
    shear_not_evaluated: Option<String>,
    base: BaseFields,
    /// Absent where the history of the contact force was not asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    contact_force_spectrum: Option<SpectrumFields>,
    /// Absent where the beam was not asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    beam: Option<BeamAnswer>,
}

/// The equivalent static force of the contact by the period of what it pushes.
#[derive(Debug, Serialize)]
struct SpectrumFields {
    period_s: Vec<f64>,
    force_n: Vec<f64>,
}

#[derive(Debug, Serialize)]
struct WebFields {
    first_yield_s: Option<f64>,
    plastic_angle_rad: f64,
    max_utilisation: f64,
    max_dynamic_factor: f64,
    work_j: f64,
}

/// Between which actions the verdict lies.
#[derive(Debug, Serialize)]
struct RangeFields<'a> {
    least: Action,
    most: Action,
    /// Only in what earlier programs computed: `most` reaches as far as what is not known.
    at_least: bool,
    decided_by: &'a [Assumption],
    /// What is not known and could ask for `most`.
    not_evaluated: &'a [String],
    variations: Vec<VariationFields<'a>>,
    not_varied: BTreeMap<&'static str, &'a str>,
}

#[derive(Debug, Serialize)]
struct VariationFields<'a> {
    assumption: Assumption,
    instead: &'a str,
    outcome: Outcome,
    max_v1_m: f64,
    residual_v1_m: Option<f64>,
    action: Action,
}

/// The reactions of the base: means over 1 ms, except for the plateau.
#[derive(Debug, Serialize)]
struct BaseFields {
    plateau: Option<BaseForceFields>,
    peak_shear: BaseForceFields,
    peak_shear_time_s: f64,
    reversed_shear: BaseForceFields,
    peak_moment: BaseForceFields,
    least_compressed: BaseForceFields,
    most_compressed: BaseForceFields,
    checked_moment: BaseForceFields,
    slip_m: f64,
    anchor_elongation_m: f64,
    fractured: Option<&'static str>,
}

#[derive(Debug, Serialize)]
struct BaseForceFields {
    shear_n: f64,
    moment_n_m: f64,
    normal_force_n: f64,
}

#[derive(Debug, Serialize)]
struct HingeFields {
    first_yield_s: Option<f64>,
    plastic_rotation_rad: f64,
    plastic_elongation_m: f64,
    max_utilisation: f64,
}

impl<'a> ImpactFields<'a> {
    /// The fields of this evaluation. `vehicle_name` is empty for a vehicle that is given by numbers; `solve_time` is the
    /// computing time of the response alone. The numbers of the response and its energies are those of the two bars.
    #[must_use]
    pub fn of(
        evaluation: &'a ImpactEvaluation,
        vehicle_name: &'a str,
        travel: Travel,
        solve_time: Duration,
    ) -> Self {
        let report = &evaluation.report;
        let assessment = evaluation.assessment.as_ref();
        let remaining = evaluation.remaining.as_ref();
        let vehicle = &report.vehicle;
        Self {
            action: assessment.map(|it| it.action),
            at_least: assessment.map(|it| it.at_least),
            deciding_criterion: assessment.map(|it| it.deciding_criterion),
            reason: assessment.map(|it| it.reason.as_str()),
            outcome: report.outcome,
            end: report.end,
            end_time_s: report.end_time,
            max_v1_m: report.max_v1,
            max_v1_time_s: report.max_v1_time,
            residual_v1_m: report.residual_v1,
            max_u2_m: report.max_u2,
            residual_u2_m: report.residual_u2,
            first_contact_time_s: report.first_contact_time,
            release_time_s: report.release_time,
            contact_duration_s: report.contact_duration,
            impactor_velocity_m_s: report.impactor_velocity,
            peak_contact_force_n: report.peak_contact_force,
            peak_contact_force_time_s: report.peak_contact_force_time,
            impact_impulses: report.impact_impulses,
            impact_impulse_n_s: report.total_impact_impulse,
            impulse_n_s: report.impulse,
            input_energy_j: report.input_energy,
            load_work_j: report.load_work,
            plastic_work_j: report.plastic_work,
            impact_loss_j: report.impact_loss,
            damping_work_j: report.damping_work,
            column_kinetic_energy_j: report.column_kinetic_energy,
            impactor_kinetic_energy_j: report.impactor_kinetic_energy,
            elastic_energy_change_j: report.elastic_energy_change,
            ledger_residual: report.ledger_residual,
            steps: report.steps,
            solve_time_s: solve_time.as_secs_f64(),
            dt_s: evaluation.step,
            error_estimate: evaluation.error_estimate,
            max_v1_hardening_band_m: evaluation
                .range
                .as_ref()
                .and_then(ActionRange::band)
                .map(|ends| ends.map(|it| it.report.max_v1)),
            vehicle: vehicle_name,
            velocity_m_s: travel.velocity,
            direction_rad: travel.direction,
            velocity_in_plane_m_s: travel.in_plane,
            crush_max_m: &vehicle.max_crush[..vehicle.masses],
            crush_permanent_m: &vehicle.permanent_crush[..vehicle.masses],
            vehicle_dissipated_j: &vehicle.dissipated[..vehicle.masses],
            vehicle_elastic_energy_j: vehicle.elastic_energy,
            // A rigid vehicle is one mass without a spring.
            vehicle_velocity_m_s: match vehicle.masses {
                0 => std::slice::from_ref(&report.impactor_velocity),
                masses => &vehicle.velocity[..masses],
            },
            plateau_force_n: evaluation.plateau,
            front_force_n: evaluation.front_force,
            dynamic_factor_max: report.max_dynamic_factor,
            undamaged_capacity_n: remaining.map(|it| it.undamaged.force),
            residual_capacity_n: remaining.map(|it| it.now.force),
            capacity_ratio: remaining.map(|it| it.ratio),
            carried_load_n: remaining.map(|it| it.carried_load),
            load: assessment.map(|it| it.load.as_str()),
            load_basis: assessment.map(|it| it.load_basis),
            gamma_m: PARTIAL_FACTOR,
            axial_capacity_n: remaining.map(|it| it.axial_capacity),
            remaining_resistance_n: remaining.and_then(|it| it.resistance),
            reserve: remaining.and_then(|it| it.reserve),
            not_evaluated: assessment.map(|it| &*it.not_evaluated),
            range: evaluation.range.as_ref().map(RangeFields::from),
            criteria: assessment.map(|it| it.criteria.as_slice()),
            hinges: HINGE_NAMES
                .into_iter()
                .zip(report.hinges.iter().map(HingeFields::from))
                .collect(),
            webs: evaluation.no_shear.is_none().then(|| {
                let webs = report.webs.iter().map(WebFields::from);
                WEB_NAMES.into_iter().zip(webs).collect()
            }),
            shear_not_evaluated: evaluation.no_shear.map(|why| why.to_string()),
            base: BaseFields::from(&report.base),
            contact_force_spectrum: None,
            beam: None,
        }
    }

    /// The same with the response spectrum of the contact force.
    #[must_use]
    pub fn with_spectrum(self, spectrum: &ForceSpectrum) -> Self {
        let fields = SpectrumFields {
            period_s: ForceSpectrum::periods().to_vec(),
            force_n: spectrum.equivalent_forces().to_vec(),
        };
        Self {
            contact_force_spectrum: Some(fields),
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

impl<'a> From<&'a ActionRange> for RangeFields<'a> {
    fn from(range: &'a ActionRange) -> Self {
        let variation = |it: &'a Variation| VariationFields {
            assumption: it.assumption,
            instead: &it.instead,
            outcome: it.report.outcome,
            max_v1_m: it.report.max_v1,
            residual_v1_m: it.report.residual_v1,
            action: it.action,
        };
        let not_varied = range.not_varied.iter();
        Self {
            least: range.ends.least,
            most: range.ends.most,
            at_least: range.ends.at_least,
            decided_by: &range.ends.decided_by,
            not_evaluated: &range.ends.not_evaluated,
            variations: range.variations.iter().map(variation).collect(),
            not_varied: not_varied
                .map(|(assumption, reason)| (assumption.in_words(), reason.as_str()))
                .collect(),
        }
    }
}

impl From<&HingeReport> for HingeFields {
    fn from(hinge: &HingeReport) -> Self {
        Self {
            first_yield_s: hinge.first_yield,
            plastic_rotation_rad: hinge.plastic_rotation,
            plastic_elongation_m: hinge.plastic_elongation,
            max_utilisation: hinge.max_utilisation,
        }
    }
}

impl From<&WebReport> for WebFields {
    fn from(web: &WebReport) -> Self {
        Self {
            first_yield_s: web.first_yield,
            plastic_angle_rad: web.plastic_angle,
            max_utilisation: web.max_utilisation,
            max_dynamic_factor: web.max_dynamic_factor,
            work_j: web.work,
        }
    }
}

impl From<&BaseReport> for BaseFields {
    fn from(base: &BaseReport) -> Self {
        Self {
            plateau: base.plateau.as_ref().map(BaseForceFields::from),
            peak_shear: BaseForceFields::from(&base.peak_shear),
            peak_shear_time_s: base.peak_shear_time,
            reversed_shear: BaseForceFields::from(&base.reversed_shear),
            peak_moment: BaseForceFields::from(&base.peak_moment),
            least_compressed: BaseForceFields::from(&base.least_compressed),
            most_compressed: BaseForceFields::from(&base.most_compressed),
            checked_moment: BaseForceFields::from(&base.checked_moment),
            slip_m: base.slip,
            anchor_elongation_m: base.anchor_elongation,
            fractured: base.fractured.map(BaseFailure::name),
        }
    }
}

impl From<&BaseForces> for BaseForceFields {
    fn from(forces: &BaseForces) -> Self {
        Self {
            shear_n: forces.shear,
            moment_n_m: forces.moment,
            normal_force_n: forces.normal_force,
        }
    }
}
