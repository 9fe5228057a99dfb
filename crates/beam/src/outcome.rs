//! What the beam says of a hit, in numbers.

use serde::{Deserialize, Deserializer, Serialize};

/// Length of a plastic zone over the depth of the section, over which the rotation of one hinge is measured, an assumption: in tests on
/// columns that are fixed at their end, yielding and local buckles reach about one and a half depths from there, and a hinge within
/// the height has such a part on both sides.
pub const PLASTIC_ZONE: f64 = 3.0;

/// How a response ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// No fibre has yielded, now or in an earlier impact.
    Elastic,
    /// The column stands, bent by this impact or by an earlier one.
    Plastic,
    /// The column gives way under its load, during the hit or afterwards, about either axis; or it loses its shape, whatever it
    /// would bear then: at rest its top is lower by a quarter of its height, or its impact point is displaced by half of it, or one
    /// of both by twice as much before.
    Collapse,
}

/// What the beam says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BeamOutcome {
    /// Peak displacement of the impact point along the direction of the hit, from where it was before \[m\].
    pub max_displacement_m: f64,
    /// Peak displacement at right angles to it, as a magnitude \[m\].
    pub max_sideways_m: f64,
    /// What remains along the direction \[m\]; NaN after a collapse.
    #[serde(deserialize_with = "nan_where_null")]
    pub residual_displacement_m: f64,
    /// What remains at right angles, as a magnitude \[m\]; NaN after a collapse.
    #[serde(deserialize_with = "nan_where_null")]
    pub residual_sideways_m: f64,
    /// Where earlier impacts had left the impact point, along the direction and at right angles to it, from where it is in the
    /// undamaged column under its load \[m\].
    #[serde(default)]
    pub displaced_before_m: [f64; 2],
    /// What all impacts have left: the largest distance of the axis from that of the undamaged column under its load, in any
    /// direction \[m\]; NaN after a collapse. Between the supports; of a column with a free top, up to the impact point.
    #[serde(default = "not_known", deserialize_with = "nan_where_null")]
    pub residual_bow_m: f64,
    /// At which height above the base \[m\]; NaN after a collapse.
    #[serde(default = "not_known", deserialize_with = "nan_where_null")]
    pub residual_bow_height_m: f64,
    /// Largest angle between two cross-sections at most [`PLASTIC_ZONE`] depths of the section apart that all impacts have left, from
    /// the undamaged column under its load \[rad\]; NaN after a collapse. The shear of the web turns no cross-section.
    #[serde(default = "not_known", deserialize_with = "nan_where_null")]
    pub residual_kink_rad: f64,
    /// Angle by which all impacts have left the web sheared below and above the impact point \[rad\]; NaN after a collapse.
    #[serde(default = "neither_known", deserialize_with = "nans_where_null")]
    pub residual_shear_angle_rad: [f64; 2],
    /// When the peak displacement is reached \[s\].
    pub max_displacement_time_s: f64,
    /// How it ended.
    pub outcome: Outcome,
    /// Whether a section without the residual stresses of rolling would have yielded, too: they make a fibre yield long before, without
    /// leaving anything to be seen.
    #[serde(default = "is_so")]
    pub yielded_beyond_residual_stress: bool,
    /// Largest axial force that the undamaged column bears, bowed about the strong axis and about the weak axis \[N\]; 0 about an
    /// axis about which the column has to be held to bear its load.
    pub undamaged_capacity_n: [f64; 2],
    /// The same of the damaged column \[N\]; 0 after a collapse.
    pub residual_capacity_n: [f64; 2],
    /// Largest base shear along the direction, as a mean over 1 ms \[N\].
    pub base_shear_n: f64,
    /// Largest moment of the base that bends the column along the direction, as a mean over 1 ms \[N m\].
    #[serde(default = "not_known", deserialize_with = "nan_where_null")]
    pub base_moment_n_m: f64,
    /// Estimated relative error of the peak displacement, from a run with fewer elements and longer steps; NaN where it is not known.
    #[serde(deserialize_with = "nan_where_null")]
    pub error_estimate: f64,
    /// Elements along the column.
    pub elements: usize,
    /// Steps of the response.
    pub steps: u64,
    /// Evaluations of its equations, which cost nearly all of the time.
    pub evaluations: u64,
    /// Change of the whole energy over the energy of the vehicle: what the solution of the equations has lost.
    pub energy_error: f64,
}

/// A state file of an earlier build does not have it.
fn not_known() -> f64 {
    f64::NAN
}

fn neither_known() -> [f64; 2] {
    [f64::NAN; 2]
}

fn is_so() -> bool {
    true
}

/// JSON has no NaN, which is written as null.
fn nans_where_null<'de, D: Deserializer<'de>>(from: D) -> Result<[f64; 2], D::Error> {
    let found = <[Option<f64>; 2]>::deserialize(from)?;
    Ok(found.map(|it| it.unwrap_or(f64::NAN)))
}

/// JSON has no NaN, which is written as null.
fn nan_where_null<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}
