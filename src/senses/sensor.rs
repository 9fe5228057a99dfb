//! A sensor on the column.

use serde::{Deserialize, Serialize};

/// What a sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Transverse acceleration at a height \[m/s^2\].
    Acceleration,
    /// Transverse displacement at a height \[m\].
    Displacement,
    /// Rotation of the axis at a height \[rad\].
    Rotation,
    /// Bending strain of a fibre at a height.
    BendingStrain,
    /// Axial strain at a height.
    AxialStrain,
    /// Contact force \[N\].
    ContactForce,
}

/// A sensor on the column.
///
/// Its readings are relative to the column at rest, as it was before the impact. Positive are a motion in the vehicle's
/// direction, the rotation of an axis that leans in this direction, tension, and tension on the side away from the vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sensor {
    /// Its name.
    pub name: String,
    /// What it measures.
    pub quantity: Quantity,
    /// Above the base \[m\].
    pub height: f64,
    /// Largest magnitude before clipping, in the unit of the quantity; 0: none.
    pub range: f64,
    /// Root mean square of its noise.
    pub noise: f64,
    /// Its standard deviation from zero.
    pub bias: f64,
    /// Standard deviation of its gain from 1.
    pub gain_error: f64,
    /// Samples per second \[Hz\].
    pub rate: f64,
    /// Of the filter against aliasing \[Hz\]; 0: half the rate.
    pub bandwidth: f64,
    /// `true` if it is mounted in the opposite direction.
    pub reversed: bool,
    /// Distance of the fibre from the centroid \[m\].
    pub fibre: f64,
}
