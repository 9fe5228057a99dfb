//! `column_twin`: the messages and services of this program. Fields and units are in the definition above each struct.
#![allow(missing_docs)]

use serde::{Deserialize, Serialize};

use ros_interface::BoundedSequence;

use super::std_msgs::Header;
use crate::column::MAX_MASSES;

pub use super::column_twin_msgs_beam::*;
pub use super::column_twin_msgs_fleet::*;
pub use super::column_twin_msgs_hinges::*;
pub use super::column_twin_msgs_services::*;

/// One value for each mass of a deformable vehicle, or for the spring in front of it, front first.
pub type PerMass = BoundedSequence<f64, MAX_MASSES>;

/// A vehicle is about to hit the column, or has just hit it.
///
/// ```text
#[doc = include_str!("../../msg/ImpactEvent.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ImpactEvent {
    pub header: Header,
    pub column_id: String,
    pub event_id: String,
    pub vehicle: String,
    pub mass: f64,
    pub velocity: f64,
    pub gap: f64,
    pub restitution: f64,
    pub height: f64,
    pub direction: f64,
}

impl Default for ImpactEvent {
    /// Leaves all optional values to the parameters; the velocity must be given, and the mass of a rigid vehicle.
    fn default() -> Self {
        Self {
            header: Header::default(),
            column_id: String::new(),
            event_id: String::new(),
            vehicle: String::new(),
            mass: 0.0,
            velocity: 0.0,
            gap: f64::NAN,
            restitution: f64::NAN,
            height: f64::NAN,
            direction: f64::NAN,
        }
    }
}

/// Sets parameters of one column: all of them, or none if one is rejected.
///
/// ```text
#[doc = include_str!("../../msg/ColumnParameters.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ColumnParameters {
    pub header: Header,
    pub column_id: String,
    pub geometry_length_below: f64,
    pub geometry_length_above: f64,
    pub section_name: String,
    pub section_area: f64,
    pub section_second_moment: f64,
    pub section_mass_per_length: f64,
    pub section_height: f64,
    pub section_width: f64,
    pub section_web_thickness: f64,
    pub section_flange_thickness: f64,
    pub steel_grade: String,
    pub steel_young_modulus: f64,
    pub steel_yield_strength: f64,
    pub resistance_moment: f64,
    pub resistance_axial: f64,
    pub resistance_shear: f64,
    pub yield_surface_alpha: f64,
    pub yield_surface_beta: f64,
    pub yield_surface_gamma: f64,
    pub hinge_elastic_law: String,
    pub hinge_stiffness_1a: f64,
    pub hinge_stiffness_1b: f64,
    pub hinge_stiffness_2: f64,
    pub hinge_stiffness_3: f64,
    pub support_base: String,
    pub support_base_stiffness: f64,
    pub support_top: String,
    pub support_top_stiffness: f64,
    pub top_spring_stiffness: f64,
    pub top_mass: f64,
    pub top_load: f64,
    pub impact_mass: f64,
    pub impact_velocity: f64,
    pub impact_gap: f64,
    pub impact_restitution: f64,
    pub vehicle_name: String,
    pub vehicle_force_factor: f64,
    pub vehicle_bumper_height: f64,
    pub rate_law: String,
    pub rate_d: f64,
    pub rate_q: f64,
    pub rate_c: f64,
    pub rate_reference: f64,
    pub rate_time_constant: f64,
    pub rate_max_factor: f64,
    pub rate_hinge_length: f64,
    pub shear_model: String,
    pub shear_max_hardening: f64,
    pub hardening_ratio: f64,
    pub solver_scheme: String,
    pub solver_dt: f64,
    pub damping_ratio: f64,
    pub response_duration: f64,
    pub capacity_imperfection: f64,
    pub assessment_ultimate_rotation: f64,
    pub assessment_ultimate_shear_angle: f64,
}

impl Default for ColumnParameters {
    /// Leaves all parameters unchanged.
    fn default() -> Self {
        Self {
            header: Header::default(),
            column_id: String::new(),
            geometry_length_below: f64::NAN,
            geometry_length_above: f64::NAN,
            section_name: String::new(),
            section_area: f64::NAN,
            section_second_moment: f64::NAN,
            section_mass_per_length: f64::NAN,
            section_height: f64::NAN,
            section_width: f64::NAN,
            section_web_thickness: f64::NAN,
            section_flange_thickness: f64::NAN,
            steel_grade: String::new(),
            steel_young_modulus: f64::NAN,
            steel_yield_strength: f64::NAN,
            resistance_moment: f64::NAN,
            resistance_axial: f64::NAN,
            resistance_shear: f64::NAN,
            yield_surface_alpha: f64::NAN,
            yield_surface_beta: f64::NAN,
            yield_surface_gamma: f64::NAN,
            hinge_elastic_law: String::new(),
            hinge_stiffness_1a: f64::NAN,
            hinge_stiffness_1b: f64::NAN,
            hinge_stiffness_2: f64::NAN,
            hinge_stiffness_3: f64::NAN,
            support_base: String::new(),
            support_base_stiffness: f64::NAN,
            support_top: String::new(),
            support_top_stiffness: f64::NAN,
            top_spring_stiffness: f64::NAN,
            top_mass: f64::NAN,
            top_load: f64::NAN,
            impact_mass: f64::NAN,
            impact_velocity: f64::NAN,
            impact_gap: f64::NAN,
            impact_restitution: f64::NAN,
            vehicle_name: String::new(),
            vehicle_force_factor: f64::NAN,
            vehicle_bumper_height: f64::NAN,
            rate_law: String::new(),
            rate_d: f64::NAN,
            rate_q: f64::NAN,
            rate_c: f64::NAN,
            rate_reference: f64::NAN,
            rate_time_constant: f64::NAN,
            rate_max_factor: f64::NAN,
            rate_hinge_length: f64::NAN,
            shear_model: String::new(),
            shear_max_hardening: f64::NAN,
            hardening_ratio: f64::NAN,
            solver_scheme: String::new(),
            solver_dt: f64::NAN,
            damping_ratio: f64::NAN,
            response_duration: f64::NAN,
            capacity_imperfection: f64::NAN,
            assessment_ultimate_rotation: f64::NAN,
            assessment_ultimate_shear_angle: f64::NAN,
        }
    }
}

/// One parameter in a [`ColumnParameters`] message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParameterEntry<'a> {
    /// A number; NaN leaves the parameter unchanged.
    Number(f64),
    /// A name or a choice; an empty text leaves the parameter unchanged.
    Text(&'a str),
}

impl ParameterEntry<'_> {
    /// Whether the parameter is left unchanged. An infinite number is a value, which is rejected later.
    pub fn is_unchanged(self) -> bool {
        match self {
            Self::Number(number) => number.is_nan(),
            Self::Text(text) => text.is_empty(),
        }
    }
}

impl ColumnParameters {
    /// All parameters with their names, in the order of the message.
    #[rustfmt::skip] // one parameter, one line
    pub fn entries(&self) -> impl Iterator<Item = (&'static str, ParameterEntry<'_>)> {
        use ParameterEntry::{Number, Text};
        [
            ("geometry.length_below", Number(self.geometry_length_below)),
            ("geometry.length_above", Number(self.geometry_length_above)),
            ("section.name", Text(&self.section_name)),
            ("section.area", Number(self.section_area)),
            ("section.second_moment", Number(self.section_second_moment)),
            ("section.mass_per_length", Number(self.section_mass_per_length)),
            ("section.height", Number(self.section_height)),
            ("section.width", Number(self.section_width)),
            ("section.web_thickness", Number(self.section_web_thickness)),
            ("section.flange_thickness", Number(self.section_flange_thickness)),
            ("steel.grade", Text(&self.steel_grade)),
            ("steel.young_modulus", Number(self.steel_young_modulus)),
            ("steel.yield_strength", Number(self.steel_yield_strength)),
            ("resistance.moment", Number(self.resistance_moment)),
            ("resistance.axial", Number(self.resistance_axial)),
            ("resistance.shear", Number(self.resistance_shear)),
            ("yield_surface.alpha", Number(self.yield_surface_alpha)),
            ("yield_surface.beta", Number(self.yield_surface_beta)),
            ("yield_surface.gamma", Number(self.yield_surface_gamma)),
            ("hinge.elastic_law", Text(&self.hinge_elastic_law)),
            ("hinge.stiffness_1a", Number(self.hinge_stiffness_1a)),
            ("hinge.stiffness_1b", Number(self.hinge_stiffness_1b)),
            ("hinge.stiffness_2", Number(self.hinge_stiffness_2)),
            ("hinge.stiffness_3", Number(self.hinge_stiffness_3)),
            ("support.base", Text(&self.support_base)),
            ("support.base_stiffness", Number(self.support_base_stiffness)),
            ("support.top", Text(&self.support_top)),
            ("support.top_stiffness", Number(self.support_top_stiffness)),
            ("top.spring_stiffness", Number(self.top_spring_stiffness)),
            ("top.mass", Number(self.top_mass)),
            ("top.load", Number(self.top_load)),
            ("impact.mass", Number(self.impact_mass)),
            ("impact.velocity", Number(self.impact_velocity)),
            ("impact.gap", Number(self.impact_gap)),
            ("impact.restitution", Number(self.impact_restitution)),
            ("vehicle.name", Text(&self.vehicle_name)),
            ("vehicle.force_factor", Number(self.vehicle_force_factor)),
            ("vehicle.bumper_height", Number(self.vehicle_bumper_height)),
            ("rate.law", Text(&self.rate_law)),
            ("rate.d", Number(self.rate_d)),
            ("rate.q", Number(self.rate_q)),
            ("rate.c", Number(self.rate_c)),
            ("rate.reference", Number(self.rate_reference)),
            ("rate.time_constant", Number(self.rate_time_constant)),
            ("rate.max_factor", Number(self.rate_max_factor)),
            ("rate.hinge_length", Number(self.rate_hinge_length)),
            ("shear.model", Text(&self.shear_model)),
            ("shear.max_hardening", Number(self.shear_max_hardening)),
            ("hardening.ratio", Number(self.hardening_ratio)),
            ("solver.scheme", Text(&self.solver_scheme)),
            ("solver.dt", Number(self.solver_dt)),
            ("damping.ratio", Number(self.damping_ratio)),
            ("response.duration", Number(self.response_duration)),
            ("capacity.imperfection", Number(self.capacity_imperfection)),
            ("assessment.ultimate_rotation", Number(self.assessment_ultimate_rotation)),
            ("assessment.ultimate_shear_angle", Number(self.assessment_ultimate_shear_angle)),
        ]
        .into_iter()
    }
}

/// The column and its impactor at one instant.
///
/// ```text
#[doc = include_str!("../../msg/ColumnState.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ColumnState {
    pub header: Header,
    pub column_id: String,
    pub event_id: String,
    pub phase: u8,
    pub time: f64,
    pub v1: f64,
    pub u1: f64,
    pub beta1: f64,
    pub u2: f64,
    pub v1_rate: f64,
    pub u1_rate: f64,
    pub u2_rate: f64,
    pub impactor_position: f64,
    pub impactor_velocity: f64,
    pub gap: f64,
    pub contact_force: f64,
    pub impact_impulse: f64,
    pub impulse: f64,
    pub kinetic_energy: f64,
    pub elastic_energy: f64,
    pub plastic_work: f64,
    pub impact_loss: f64,
    pub damping_work: f64,
    pub load_work: f64,
    pub ledger_residual: f64,
    pub vehicle_velocity: PerMass,
    pub crush: PerMass,
    pub permanent_crush: PerMass,
    pub spring_force: PerMass,
    pub vehicle_dissipated: PerMass,
    pub vehicle_elastic_energy: f64,
}

impl ColumnState {
    pub const IDLE: u8 = 0;
    pub const APPROACH: u8 = 1;
    pub const CONTACT: u8 = 2;
    pub const FREE: u8 = 3;
    pub const REST: u8 = 4;
    pub const COLLAPSED: u8 = 5;
    pub const FAULTED: u8 = 6;
    pub const FRACTURED: u8 = 7;
}

/// What the column bears upon its base.
///
/// ```text
#[doc = include_str!("../../msg/BaseForces.msg")]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct BaseForces {
    pub shear: f64,
    pub moment: f64,
    pub normal_force: f64,
}

/// Forces and deformations of the hinges and webs at one instant, and the forces on the base.
///
/// ```text
#[doc = include_str!("../../msg/HingeForces.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HingeForces {
    pub header: Header,
    pub column_id: String,
    pub event_id: String,
    pub moment: PerHinge,
    pub normal_force: PerHinge,
    pub rotation: PerHinge,
    pub elongation: PerHinge,
    pub plastic_rotation: PerHinge,
    pub plastic_elongation: PerHinge,
    pub utilisation: PerHinge,
    pub state: PerHinge<u8>,
    pub dynamic_factor: PerHinge,
    pub shear_force: PerHinge,
    pub shear_angle: PerHinge,
    pub shear_utilisation: PerHinge,
    pub web_state: PerHinge<u8>,
    pub web_dynamic_factor: PerHinge,
    pub base: BaseForces,
}

impl HingeForces {
    pub const HINGE_1A: u8 = 0;
    pub const HINGE_1B: u8 = 1;
    pub const HINGE_2: u8 = 2;
    pub const HINGE_3: u8 = 3;
    pub const WEB_A: u8 = 0;
    pub const WEB_B: u8 = 1;
    pub const ELASTIC: u8 = 0;
    pub const PLASTIC: u8 = 1;
    pub const UNLOADED: u8 = 2;
}

/// One criterion of an assessment.
///
/// ```text
#[doc = include_str!("../../msg/AssessmentCriterion.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AssessmentCriterion {
    pub name: String,
    pub edition: String,
    pub value: f64,
    pub limit: f64,
    pub margin: f64,
    pub unit: String,
    pub tag: String,
    pub evaluated: bool,
    pub exceeded: bool,
    pub action: u8,
    pub decides: bool,
    pub statement: String,
}

/// A quantity with its 90 % interval.
///
/// ```text
#[doc = include_str!("../../msg/CredibleInterval.msg")]
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct CredibleInterval {
    pub mean: f64,
    pub low: f64,
    pub high: f64,
}

/// What the sensors say about an impact.
///
/// ```text
#[doc = include_str!("../../msg/ImpactEstimate.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ImpactEstimate {
    pub header: Header,
    pub column_id: String,
    pub event_id: String,
    pub update: u32,
    pub is_final: bool,
    pub data_until: f64,
    pub contact_time: CredibleInterval,
    pub mass: CredibleInterval,
    pub velocity: CredibleInterval,
    pub momentum: CredibleInterval,
    pub mass_velocity_correlation: f64,
    pub peak_v1: CredibleInterval,
    pub residual_v1: CredibleInterval,
    pub capacity_ratio: CredibleInterval,
    pub yielded: f64,
    pub collapsed: f64,
    pub vehicles: Vec<String>,
    pub vehicle_probabilities: Vec<f64>,
    pub action_probabilities: [f64; 5],
    pub effective_sample_size: f64,
    pub reliable: bool,
    pub doubtful_sensors: Vec<String>,
    pub decision: u8,
    pub merged_event_id: String,
}

impl ImpactEstimate {
    pub const DECISION_PENDING: u8 = 0;
    pub const DECISION_ACCEPTED: u8 = 1;
    pub const DECISION_MERGED: u8 = 2;
    pub const DECISION_DECLINED: u8 = 3;
    pub const DECISION_REJECTED: u8 = 4;
}

/// The outcome of one impact.
///
/// ```text
#[doc = include_str!("../../msg/ImpactReport.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ImpactReport {
    pub header: Header,
    pub column_id: String,
    pub event_id: String,
    pub vehicle: String,
    pub mass: f64,
    pub velocity: f64,
    pub direction: f64,
    pub kind: u8,
    pub outcome: u8,
    pub max_v1: f64,
    pub max_v1_time: f64,
    pub residual_v1: f64,
    pub max_u2: f64,
    pub residual_u2: f64,
    pub release_time: f64,
    pub impactor_rebound: f64,
    pub peak_contact_force: f64,
    pub impulse: f64,
    pub plastic_work: f64,
    pub impact_loss: f64,
    pub ledger_residual: f64,
    pub compute_time: f64,
    pub first_yield_time: PerHinge,
    pub max_utilisation: PerHinge,
    pub plastic_rotation: PerHinge,
    pub web_first_yield_time: PerHinge,
    pub web_max_utilisation: PerHinge,
    pub shear_angle: PerHinge,
    pub base_plateau: BaseForces,
    pub base_peak_shear: BaseForces,
    pub base_peak_shear_time: f64,
    pub base_reversed_shear: BaseForces,
    pub base_peak_moment: BaseForces,
    pub base_least_compressed: BaseForces,
    pub base_most_compressed: BaseForces,
    pub base_checked_moment: BaseForces,
    pub end: u8,
    pub end_time: f64,
    pub max_crush: PerMass,
    pub permanent_crush: PerMass,
    pub vehicle_dissipated: PerMass,
    pub vehicle_velocity: PerMass,
    pub max_dynamic_factor: PerHinge,
    pub undamaged_capacity: f64,
    pub residual_capacity: f64,
    pub capacity_ratio: f64,
    pub reserve: f64,
    pub beam: SecondOpinion,
    pub action: u8,
    pub deciding_criterion: String,
    pub action_reason: String,
    pub range_least: u8,
    pub range_most: u8,
    pub range_at_least: bool,
    pub range_decided_by: String,
    pub criteria: Vec<AssessmentCriterion>,
    pub error_estimate: f64,
    pub dt: f64,
}

impl ImpactReport {
    pub const HINGE_1A: u8 = 0;
    pub const HINGE_1B: u8 = 1;
    pub const HINGE_2: u8 = 2;
    pub const HINGE_3: u8 = 3;
    pub const WEB_A: u8 = 0;
    pub const WEB_B: u8 = 1;
    pub const FORECAST: u8 = 0;
    pub const RESULT: u8 = 1;
    pub const PREDICTION: u8 = 2;
    pub const WITHDRAWN: u8 = 3;
    pub const NO_FORECAST: u8 = 4;
    pub const ELASTIC: u8 = 0;
    pub const PLASTIC: u8 = 1;
    pub const COLLAPSED: u8 = 2;
    pub const FRACTURED: u8 = 3;
    pub const OUTCOME_UNKNOWN: u8 = 255;
    pub const END_AT_REST: u8 = 0;
    pub const END_DURATION_REACHED: u8 = 1;
    pub const END_COLLAPSED: u8 = 2;
    pub const END_FRACTURED: u8 = 3;
    pub const END_NOT_CONVERGED: u8 = 4;
    pub const END_SUPERSEDED: u8 = 5;
    pub const END_RESET: u8 = 6;
    pub const END_STOPPED: u8 = 7;
    pub const END_REJECTED: u8 = 8;
    pub const END_NOT_COMPUTED: u8 = 9;
    pub const END_NOT_HIT: u8 = 10;
    pub const ACTION_NONE: u8 = 0;
    pub const ACTION_INSPECT: u8 = 1;
    pub const ACTION_RESTRICT: u8 = 2;
    pub const ACTION_SHORE: u8 = 3;
    pub const ACTION_EVACUATE: u8 = 4;
    pub const ACTION_UNKNOWN: u8 = 255;
}

/// Consecutive samples of one sensor on the column.
///
/// ```text
#[doc = include_str!("../../msg/Measurement.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Measurement {
    pub header: Header,
    pub column_id: String,
    pub sensor_id: String,
    pub sample_period: f64,
    pub values: Vec<f32>,
}

/// State of the twin.
///
/// ```text
#[doc = include_str!("../../msg/TwinStatus.msg")]
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TwinStatus {
    pub header: Header,
    pub column_id: String,
    pub phase: u8,
    pub event_id: String,
    pub events_accepted: u64,
    pub events_merged: u64,
    pub events_rejected: u64,
    pub parameters_accepted: u64,
    pub parameters_rejected: u64,
    pub last_rejection_code: u16,
    pub last_rejection_reason: String,
    pub last_rejection_event_id: String,
    pub fault: String,
    pub overruns: u64,
    pub worst_lateness: f64,
    pub dropped_inputs: u64,
    pub dropped_states: u64,
    pub dropped_recording: u64,
    pub dropped_viewer: u64,
    pub waiting_estimate: String,
    pub impacts_since_reset: u32,
    pub corrections_since_reset: u32,
    pub correction_before: f64,
    pub correction_measured: f64,
    pub correction_after: f64,
    pub residual_v1: f64,
    pub residual_u2: f64,
    pub plastic_work_since_reset: f64,
    pub hinges: Vec<HingeDescription>,
    pub webs: Vec<HingeDescription>,
    pub plastic_rotation: PerHinge,
    pub plastic_elongation: PerHinge,
    pub shear_angle: PerHinge,
    pub undamaged_capacity: f64,
    pub residual_capacity: f64,
    pub capacity_ratio: f64,
    pub reserve: f64,
    pub action: u8,
    pub deciding_criterion: String,
    pub action_reason: String,
    pub range_least: u8,
    pub range_most: u8,
    pub range_at_least: bool,
    pub range_decided_by: String,
    pub crush: PerMass,
    pub error_estimate: f64,
    pub critical_vehicle: Vec<String>,
    pub critical_mass: Vec<f64>,
    pub critical_velocity_restrict: Vec<f64>,
    pub critical_velocity_evacuate: Vec<f64>,
}

impl TwinStatus {
    pub const HINGE_1A: u8 = 0;
    pub const HINGE_1B: u8 = 1;
    pub const HINGE_2: u8 = 2;
    pub const HINGE_3: u8 = 3;
    pub const IDLE: u8 = 0;
    pub const APPROACH: u8 = 1;
    pub const CONTACT: u8 = 2;
    pub const FREE: u8 = 3;
    pub const REST: u8 = 4;
    pub const COLLAPSED: u8 = 5;
    pub const FAULTED: u8 = 6;
    pub const FRACTURED: u8 = 7;
    pub const REJECTED_NONE: u16 = 0;
    pub const REJECTED_OTHER_COLUMN: u16 = 1;
    pub const REJECTED_EVENT_ID_INVALID: u16 = 2;
    pub const REJECTED_EVENT_ID_REPEATED: u16 = 3;
    pub const REJECTED_STAMP_TOO_OLD: u16 = 4;
    pub const REJECTED_STAMP_TOO_FAR_AHEAD: u16 = 5;
    pub const REJECTED_STAMP_OUT_OF_ORDER: u16 = 6;
    pub const REJECTED_TOO_MANY_IMPACTS_AHEAD: u16 = 7;
    pub const REJECTED_IMPACT_OUT_OF_RANGE: u16 = 8;
    pub const REJECTED_HEIGHT_NOT_POSSIBLE: u16 = 9;
    pub const REJECTED_COLUMN_COLLAPSED: u16 = 10;
    pub const REJECTED_TWIN_FAULTED: u16 = 11;
    pub const REJECTED_COLUMN_IMPOSSIBLE: u16 = 12;
    pub const REJECTED_PARAMETERS_INVALID: u16 = 13;
    pub const REJECTED_PARAMETERS_READ_ONLY: u16 = 14;
    pub const REJECTED_COLUMN_DAMAGED: u16 = 15;
    pub const REJECTED_NO_EQUILIBRIUM: u16 = 16;
    pub const REJECTED_NOT_COMPUTED: u16 = 17;
    pub const REJECTED_QUEUE_FULL: u16 = 18;
    pub const REJECTED_NO_ANSWER: u16 = 19;
    pub const REJECTED_STOPPING: u16 = 20;
    pub const REJECTED_VEHICLE_INVALID: u16 = 21;
    pub const REJECTED_COLUMN_FRACTURED: u16 = 22;
    pub const REJECTED_APPROACH_TOO_LONG: u16 = 23;
    pub const REJECTED_SENDER_NOT_ALLOWED: u16 = 24;
    pub const REJECTED_SENDER_TOO_FAST: u16 = 25;
    pub const REJECTED_ESTIMATE_NOT_PENDING: u16 = 26;
    pub const REJECTED_NOT_AT_REST: u16 = 27;
    pub const REJECTED_MEASUREMENT_IMPLAUSIBLE: u16 = 28;
    pub const REJECTED_NOT_ACTIVE: u16 = 29;
    pub const ACTION_NONE: u8 = 0;
    pub const ACTION_INSPECT: u8 = 1;
    pub const ACTION_RESTRICT: u8 = 2;
    pub const ACTION_SHORE: u8 = 3;
    pub const ACTION_EVACUATE: u8 = 4;
    pub const ACTION_UNKNOWN: u8 = 255;
}

/// Whether no response is running in this phase of a status.
pub(super) fn is_at_rest(phase: u8) -> bool {
    use TwinStatus as It;
    !matches!(phase, It::APPROACH | It::CONTACT | It::FREE)
}

impl TwinStatus {
    /// Whether no response is running.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        is_at_rest(self.phase)
    }
}
