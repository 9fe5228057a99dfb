//! The observable quantities of the column at one instant: a row of a history, the content of a message.

use serde::{Deserialize, Serialize};

use super::properties::is_default;
use super::vehicle::MAX_MASSES;

/// Number of generalised hinges; every array over hinges is in the order of [`HINGE_NAMES`].
pub const HINGES: usize = 4;

/// Number of webs; every array over webs is in the order of [`WEB_NAMES`].
pub const WEBS: usize = 2;

/// Names of the webs: of the bar below the impact point and of the one above it.
pub const WEB_NAMES: [&str; WEBS] = ["a", "b"];

/// Names of the hinges: below and above the impact point, top, base.
pub const HINGE_NAMES: [&str; HINGES] = ["1a", "1b", "2", "3"];

/// State of one hinge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HingeState {
    /// It has never flowed.
    #[default]
    Elastic,
    /// It flows.
    Plastic,
    /// It has flowed and is elastic again.
    Unloaded,
}

/// Phase of one impact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// No impactor.
    #[default]
    Idle,
    /// The impactor has not touched the column yet.
    Approach,
    /// Impactor and column move together.
    Contact,
    /// They have separated.
    Free,
}

/// The observable quantities of the column at one instant. SI units; `v` is positive in the impactor's
/// direction of travel, `u` positive downwards, `N` positive in tension.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Sample {
    /// Time since the event \[s\].
    pub time: f64,
    /// Phase of the impact.
    pub phase: Phase,
    /// Transverse displacement of the impact point \[m\].
    pub v1: f64,
    /// Axial displacement of the impact point, down \[m\].
    pub u1: f64,
    /// Rotation of the impact point \[rad\].
    pub beta1: f64,
    /// Axial displacement of the top, down \[m\].
    pub u2: f64,
    /// Rate of `v1` \[m/s\].
    pub v1_rate: f64,
    /// Rate of `u1` \[m/s\].
    pub u1_rate: f64,
    /// Rate of `u2` \[m/s\].
    pub u2_rate: f64,
    /// `v_c`: position of the impactor on the axis of `v1` \[m\]; 0 without an impactor.
    pub impactor_position: f64,
    /// Velocity of the impactor \[m/s\].
    pub impactor_velocity: f64,
    /// `v1 - v_c` >= 0: distance between the two \[m\].
    pub gap: f64,
    /// Smooth contact force \[N\], >= 0.
    pub contact_force: f64,
    /// Impact impulse since the previous sample, >= 0 \[N s\].
    pub impact_impulse: f64,
    /// Impulse since the event, impact impulses included \[N s\].
    pub impulse: f64,
    /// Kinetic energy of column and impactor \[J\].
    pub kinetic_energy: f64,
    /// Elastic energy of the hinges and the top spring \[J\].
    pub elastic_energy: f64,
    /// Work dissipated in the hinges \[J\].
    pub plastic_work: f64,
    /// Energy lost in impact impulses \[J\].
    pub impact_loss: f64,
    /// Work of the damping \[J\].
    pub damping_work: f64,
    /// `P u2 + F x_c`, work of the load and of the transverse force on the vehicle \[J\].
    pub load_work: f64,
    /// Error of the energy balance \[J\].
    pub ledger_residual: f64,
    /// The deformable vehicle; its default for a rigid one or none.
    pub vehicle: VehicleSample,
    /// The hinges.
    pub hinges: [HingeSample; HINGES],
    /// The webs; their default in a column without shear.
    #[serde(default, skip_serializing_if = "is_default")]
    pub webs: [WebSample; WEBS],
    /// What acts on the base, the inertia of the lower bar included.
    #[serde(default, skip_serializing_if = "is_default")]
    pub base: BaseForces,
}

impl Sample {
    /// Normal force of each bar, of the one below the impact point first \[N\]; both hinges of a bar carry it.
    #[must_use]
    pub fn normal_forces(&self) -> [f64; 2] {
        let [below, above, _, _] = self.hinges.map(|hinge| hinge.normal_force);
        [below, above]
    }
}

/// What the column bears upon its base.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct BaseForces {
    /// `V`: shear force \[N\], positive where the base holds the column back from the direction of the hit.
    pub shear: f64,
    /// `M`: moment of hinge 3 \[N m\], positive with a positive shear force.
    pub moment: f64,
    /// Force along the undeformed column \[N\], positive in tension: the base is lifted.
    pub normal_force: f64,
}

/// A deformable vehicle at one instant: arrays over its masses and the springs in front of them, front first.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct VehicleSample {
    /// Number of masses; 0 for a rigid vehicle or none.
    pub masses: usize,
    /// Velocity of each mass \[m/s\].
    pub velocity: [f64; MAX_MASSES],
    /// Crush of each spring \[m\]; negative where it is open.
    pub crush: [f64; MAX_MASSES],
    /// Permanent crush of each spring \[m\].
    pub permanent_crush: [f64; MAX_MASSES],
    /// Force of each spring \[N\], >= 0.
    pub force: [f64; MAX_MASSES],
    /// Energy dissipated in each spring since the event \[J\].
    pub dissipated: [f64; MAX_MASSES],
    /// Elastic energy stored in all springs \[J\].
    pub elastic_energy: f64,
}

/// One hinge at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct HingeSample {
    /// Bending moment \[N m\].
    pub moment: f64,
    /// Normal force \[N\], tension positive.
    pub normal_force: f64,
    /// Rotation \[rad\].
    pub rotation: f64,
    /// Elongation \[m\].
    pub elongation: f64,
    /// Plastic rotation \[rad\].
    pub plastic_rotation: f64,
    /// Plastic elongation \[m\].
    pub plastic_elongation: f64,
    /// `Phi + 1`: 0 unloaded, 1 on the yield surface as strain rate and hardening have enlarged it.
    pub utilisation: f64,
    /// Dynamic increase factor of the resistances; 1 without rate dependence.
    pub dynamic_factor: f64,
    /// Elastic, plastic or unloaded.
    pub state: HingeState,
}

/// The web of one bar at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct WebSample {
    /// `(M_i + M_j) / l`: shear force of the bar \[N\].
    pub shear_force: f64,
    /// `gamma_p`: plastic shear angle \[rad\].
    pub plastic_angle: f64,
    /// Shear force over the resistance as normal force, strain rate and hardening have changed it: 1 where it yields.
    pub utilisation: f64,
    /// Dynamic increase factor of the resistance; 1 without rate dependence.
    pub dynamic_factor: f64,
    /// Work dissipated in it since the event, a part of the plastic work \[J\].
    pub work: f64,
    /// Elastic, plastic or unloaded.
    pub state: HingeState,
}
