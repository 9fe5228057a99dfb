//! Corrects the damage of the column at rest by what was measured on it.
//!
//! The plastic deformation of all hinges is multiplied by one factor, so that the mechanism remains that of the impacts, and
//! the column is brought into its new equilibrium; the factor is the one with which the model reads what was measured.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::plant::Plant;
use super::rejection::{Rejection, RejectionCode};
use crate::estimation::Probe;
use crate::exact_number;
use crate::sensors::Quantity;
use crate::time::Nanos;

/// Factors by which the plastic deformation may be corrected \[A\]: a measurement that asks for more contradicts the model, which
/// then has another mechanism than the column.
pub const CORRECTION_FACTORS: [f64; 2] = [0.5, 2.0];

/// Halvings with which the factor is found: to the last bits.
const HALVINGS: u32 = 60;

/// Standard deviations of the measurement by which the corrected model may miss it.
const TOLERANCE: f64 = 0.01;

/// What was measured on the column at rest, relative to the undamaged column.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResidualMeasurement {
    /// [`Quantity::Displacement`] \[m\] or [`Quantity::Rotation`] \[rad\], positive as in the readings of sensors.
    pub quantity: Quantity,
    /// Above the base \[m\].
    #[serde(with = "exact_number")]
    pub height: f64,
    /// What was measured.
    #[serde(with = "exact_number")]
    pub value: f64,
    /// Its standard deviation, > 0; at most the height of the column, or a right angle.
    #[serde(with = "exact_number")]
    pub deviation: f64,
    /// The sender, for logs.
    pub source: Arc<str>,
}

/// A comparison of the model with a measurement on the column at rest, and what has become of the damage.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DamageCorrection {
    /// When.
    pub stamp: Nanos,
    /// What was measured: a displacement \[m\] or a rotation \[rad\], relative to the undamaged column.
    pub quantity: Quantity,
    /// Above the base \[m\].
    pub height: f64,
    /// What the model read before.
    pub before: f64,
    /// What was measured.
    pub measured: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// What the model reads now.
    pub after: f64,
    /// By which the plastic deformation of all hinges was multiplied; 1 where the model agreed.
    pub factor: f64,
}

impl DamageCorrection {
    /// What was compared, and what has changed.
    #[must_use]
    pub fn in_words(&self) -> String {
        let Self {
            quantity,
            height,
            before,
            measured,
            deviation,
            after,
            factor,
            ..
        } = self;
        let unit = quantity.unit();
        let compared = format!(
            "residual {quantity} at {height} m: the model had {before} {unit}, measured are {measured} {unit} with a standard \
             deviation of {deviation} {unit}"
        );
        match *factor == 1.0 {
            true => format!("{compared}; they agree, and nothing is changed"),
            false => format!(
                "{compared}; the plastic deformation of all hinges is multiplied by {factor}, and the model has {after} {unit} now"
            ),
        }
    }
}

/// The comparison, and the corrected column; `None` where the model agrees with the measurement.
pub(super) fn correct(
    at_rest: &Plant,
    measured: &ResidualMeasurement,
    stamp: Nanos,
) -> Result<(DamageCorrection, Option<Plant>), Rejection> {
    let ResidualMeasurement {
        quantity,
        height,
        value,
        deviation,
        ..
    } = *measured;
    let implausible = |reason: String| {
        Err(Rejection::new(
            RejectionCode::MeasurementImplausible,
            reason,
        ))
    };
    if !matches!(quantity, Quantity::Displacement | Quantity::Rotation) {
        return implausible(format!(
            "the quantity is {quantity}; a column at rest is measured by its displacement or its rotation"
        ));
    }
    let properties = &at_rest.model.properties;
    let whole = properties.length_below + properties.length_above;
    if !(0.0..=whole).contains(&height) {
        return implausible(format!(
            "height = {height} m is not on the column, which is {whole} m high"
        ));
    }
    if !value.is_finite() {
        return implausible(format!("value = {value}: expected a finite number"));
    }
    let unit = quantity.unit();
    // What may be off by more says nothing, and would agree with every column.
    let most = match quantity {
        Quantity::Displacement => whole,
        _ => FRAC_PI_2,
    };
    if !(deviation > 0.0 && deviation <= most) {
        return implausible(format!(
            "deviation = {deviation} {unit}: expected the standard deviation of the measurement, above 0 and at most {most} {unit}"
        ));
    }
    let probe = Probe::ideal(&at_rest.model, quantity, height);
    let before = probe.read(&at_rest.state);
    let correction = DamageCorrection {
        stamp,
        quantity,
        height,
        before,
        measured: value,
        deviation,
        after: before,
        factor: 1.0,
    };
    if (value - before).abs() <= deviation {
        return Ok((correction, None));
    }
    let differs = format!(
        "the model has a {quantity} of {before} {unit} at {height} m, measured are {value} {unit}"
    );
    if !at_rest.is_damaged() {
        return implausible(format!(
            "{differs}; the column has no plastic deformation that could be corrected: report the impact that has caused it"
        ));
    }
    let found = CORRECTION_FACTORS
        .into_iter()
        .find_map(|bound| factor_towards(bound, at_rest, &probe, value, TOLERANCE * deviation));
    let Some((factor, corrected)) = found else {
        let [least, most] = CORRECTION_FACTORS;
        return implausible(format!(
            "{differs}; no factor from {least} to {most} on the plastic deformation of all hinges makes the column meet this in \
             equilibrium: the column has another damage than its impacts explain, and must be examined"
        ));
    };
    let correction = DamageCorrection {
        after: probe.read(&corrected.state),
        factor,
        ..correction
    };
    Ok((correction, Some(corrected)))
}

/// The factor between 1 and a bound with which the model meets the measurement, and the column with it.
fn factor_towards(
    bound: f64,
    at_rest: &Plant,
    probe: &Probe,
    wanted: f64,
    tolerance: f64,
) -> Option<(f64, Plant)> {
    let is_above = probe.read(&at_rest.state) > wanted;
    let (mut near, mut far) = (1.0, bound);
    let mut trial = bound;
    for _ in 0..HALVINGS {
        // Without an equilibrium the factor is too far from 1.
        match at_rest.with_damage_scaled(trial) {
            Some(scaled) => {
                let reading = probe.read(&scaled.state);
                if (reading - wanted).abs() <= tolerance {
                    return Some((trial, scaled));
                }
                match (reading > wanted) == is_above {
                    true if trial == bound => return None,
                    true => near = trial,
                    false => far = trial,
                }
            }
            None => far = trial,
        }
        trial = 0.5 * (near + far);
    }
    None
}
