//! The outcome of one impact.

use serde::{Deserialize, Serialize};

use super::base_resistance::BaseFailure;
use super::contact::MAX_ELASTIC_IMPACT_IMPULSES;
use super::properties::{is_default, is_zero};
use super::sample::{BaseForces, HINGES, WEBS};
use super::vehicle::MAX_MASSES;

/// How a response ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// No hinge and no web has flowed.
    Elastic,
    /// At least one hinge or web has flowed and the column stands.
    Plastic,
    /// The column has lost its shape or its equilibrium.
    Collapsed,
    /// The plastic rotation of a hinge has exceeded the ultimate rotation, the plastic shear angle of a web the ultimate angle, or
    /// the base has slipped or lifted so far that its anchors are gone ([`BaseReport::fractured`]): it carries nothing.
    Fractured,
}

impl Outcome {
    /// Whether the column stands afterwards.
    #[must_use]
    pub fn stands(self) -> bool {
        matches!(self, Self::Elastic | Self::Plastic)
    }
}

/// Why a response ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The impactor has left or is at rest, and no hinge has flowed for some periods of the slowest mode.
    AtRest,
    /// The longest allowed response has passed.
    DurationReached,
    /// The column has collapsed.
    Collapsed,
    /// A hinge, a web or the base has been fractured.
    Fractured,
    /// The next step did not converge, however small its parts; the report tells what happened until then.
    NotConverged,
}

/// The outcome of one impact. Times count from the event \[s\]; an event that did not happen is `None`. The largest values of a
/// response that ends with a fractured hinge, web or base are those up to the instant of the fracture, which is interpolated within its last step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Elastic, plastic, collapsed or fractured.
    pub outcome: Outcome,
    /// Why the response ended.
    pub end: End,
    /// End of the response \[s\].
    pub end_time: f64,
    /// Peak `v1` \[m\].
    pub max_v1: f64,
    /// Time of the peak `v1` \[s\].
    pub max_v1_time: f64,
    /// `v1` of the static equilibrium under the load with the plastic deformations frozen \[m\]; `None` if collapsed or
    /// fractured.
    pub residual_v1: Option<f64>,
    /// Largest `u2` \[m\].
    pub max_u2: f64,
    /// `u2` of the residual equilibrium \[m\]; `None` if collapsed or fractured.
    pub residual_u2: Option<f64>,
    /// First touch \[s\].
    pub first_contact_time: Option<f64>,
    /// Last separation \[s\].
    pub release_time: Option<f64>,
    /// From first touch to last separation, or to the end \[s\].
    pub contact_duration: f64,
    /// Velocity of the impactor at the end \[m/s\]; negative after a rebound.
    pub impactor_velocity: f64,
    /// Largest smooth contact force \[N\].
    pub peak_contact_force: f64,
    /// Time of the largest smooth contact force \[s\].
    pub peak_contact_force_time: Option<f64>,
    /// Number of impact impulses.
    pub impact_impulses: u32,
    /// Impulse of the impact impulses alone \[N s\].
    pub total_impact_impulse: f64,
    /// Impulse of impact impulses and contact force \[N s\].
    pub impulse: f64,
    /// Kinetic energy of the impactor at the event \[J\].
    pub input_energy: f64,
    /// Kinetic energy of the column at the end \[J\].
    pub column_kinetic_energy: f64,
    /// Kinetic energy of the impactor at the end \[J\].
    pub impactor_kinetic_energy: f64,
    /// Elastic energy at the end less that at the start \[J\].
    pub elastic_energy_change: f64,
    /// Work dissipated in the hinges and webs \[J\].
    pub plastic_work: f64,
    /// Energy lost in impact impulses \[J\].
    pub impact_loss: f64,
    /// Work of the damping \[J\].
    pub damping_work: f64,
    /// Work of the load and of the transverse force on the vehicle since the start, `P Delta u2 + F Delta x_c` \[J\].
    pub load_work: f64,
    /// Largest error of the energy balance after any step, relative to the input energy, or for a very small input to 1e-5
    /// of the energies that the column takes elastically or holds at the event.
    pub ledger_residual: f64,
    /// Largest dynamic increase factor of each hinge; 1 without rate dependence.
    pub max_dynamic_factor: [f64; HINGES],
    /// Time steps taken.
    pub steps: u64,
    /// The hinges.
    pub hinges: [HingeReport; HINGES],
    /// The deformable vehicle; its default for a rigid one.
    pub vehicle: VehicleReport,
    /// The webs; their default in a column without shear.
    #[serde(default, skip_serializing_if = "is_default")]
    pub webs: [WebReport; WEBS],
    /// The reactions of the base.
    #[serde(default, skip_serializing_if = "is_default")]
    pub base: BaseReport,
}

/// The reactions of the base in a response. Except for the plateau they are means over 1 ms
/// ([`BASE_WINDOW`](super::BASE_WINDOW)); each comes with the other forces of the same millisecond. Impact impulses do not count.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct BaseReport {
    /// Mean over the time in which `v1` grew from 0.30 to 0.95 of its largest value; `None` where it did not grow.
    pub plateau: Option<BaseForces>,
    /// With the largest shear force.
    pub peak_shear: BaseForces,
    /// End of that millisecond \[s\].
    pub peak_shear_time: f64,
    /// With the largest shear force in the direction of the hit after the vehicle has left, negative; 0 if there was none.
    pub reversed_shear: BaseForces,
    /// With the largest moment of hinge 3 by absolute value.
    pub peak_moment: BaseForces,
    /// With the largest tension, or the least compression: uplift where its normal force is positive.
    pub least_compressed: BaseForces,
    /// With the largest compression.
    pub most_compressed: BaseForces,
    /// With the largest moment that a connection has to be checked for, >= 0: that of hinge 3, or once the web of the lower
    /// bar has flowed, `M(N)` of the column, at most `V L_a` and at least `V L_a / 2`.
    pub checked_moment: BaseForces,
    /// How far the base has slipped on its foundation at the end \[m\], >= 0; 0 without a connection.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub slip: f64,
    /// By how much the anchors of one side have been stretched at the end \[m\], >= 0; 0 without a connection.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub anchor_elongation: f64,
    /// Which anchors are fractured, so that the response ended.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fractured: Option<BaseFailure>,
}

/// What became of a deformable vehicle: arrays over its masses and the springs in front of them, front first.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct VehicleReport {
    /// Number of masses; 0 for a rigid vehicle.
    pub masses: usize,
    /// Largest crush of each spring \[m\], >= 0.
    pub max_crush: [f64; MAX_MASSES],
    /// Permanent crush of each spring \[m\], >= 0.
    pub permanent_crush: [f64; MAX_MASSES],
    /// Energy dissipated in each spring \[J\], >= 0.
    pub dissipated: [f64; MAX_MASSES],
    /// Velocity of each mass at the end \[m/s\].
    pub velocity: [f64; MAX_MASSES],
    /// Elastic energy stored in all springs at the end \[J\], >= 0.
    pub elastic_energy: f64,
}

impl Report {
    /// Whether the response had more impact impulses than follow the restitution given (only with the conserving scheme): from
    /// number [`MAX_ELASTIC_IMPACT_IMPULSES`] on they were perfectly inelastic, and what they lost is part of `impact_loss`.
    pub fn restitution_ended_early(&self) -> bool {
        self.impact_impulses > MAX_ELASTIC_IMPACT_IMPULSES
    }
}

/// The history of one hinge in a response.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct HingeReport {
    /// First plastic flow during this response \[s\].
    pub first_yield: Option<f64>,
    /// Largest utilisation, `Phi + 1`.
    pub max_utilisation: f64,
    /// Plastic rotation at the end \[rad\].
    pub plastic_rotation: f64,
    /// Plastic elongation at the end \[m\].
    pub plastic_elongation: f64,
}

/// The history of the web of one bar in a response.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct WebReport {
    /// First plastic flow during this response \[s\].
    pub first_yield: Option<f64>,
    /// Largest utilisation.
    pub max_utilisation: f64,
    /// Largest dynamic increase factor; 1 without rate dependence.
    pub max_dynamic_factor: f64,
    /// Plastic shear angle at the end \[rad\].
    pub plastic_angle: f64,
    /// Work dissipated in it, a part of the plastic work \[J\].
    pub work: f64,
}
