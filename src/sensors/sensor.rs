//! A sensor on the column: what it measures, where, and how well.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Most sensors of a column.
pub const MAX_SENSORS: usize = 64;

// Quantities: word in parameters, messages and JSON; SI unit of the readings, empty for a strain; unit in which people see it, and the
// factor from the SI unit; meaning.
macro_rules! quantities {
    ($($quantity:ident $word:literal $unit:literal $shown:literal $per_si:literal $meaning:literal;)*) => {
        /// What a sensor measures.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Quantity { $(#[doc = $meaning] $quantity),* }

        impl Quantity {
            /// Every quantity, in the order of [`WORDS`](Self::WORDS).
            pub const ALL: [Self; Self::WORDS.len()] = [$(Self::$quantity),*];

            /// The words of the quantities in parameters, messages and JSON.
            pub const WORDS: [&'static str; [$($word),*].len()] = [$($word),*];

            /// The SI unit of its readings; empty for a strain.
            #[must_use]
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$quantity => $unit),* }
            }

            /// The usual unit in which people see it, and the factor from the SI unit.
            #[must_use]
            pub const fn shown_unit(self) -> (&'static str, f64) {
                match self { $(Self::$quantity => ($shown, $per_si)),* }
            }
        }
    };
}

quantities! {
    Acceleration "acceleration" "m/s^2" "m/s²" 1.0 "Transverse acceleration at a height.";
    Displacement "displacement" "m" "mm" 1e3 "Transverse displacement at a height.";
    Rotation "rotation" "rad" "mrad" 1e3 "Rotation of the axis at a height.";
    BendingStrain "bending_strain" "" "µm/m" 1e6
        "Strain of a fibre at a height that bending alone causes, without the strain of the axial force.";
    AxialStrain "axial_strain" "" "µm/m" 1e6 "Strain of the centroid at a height, which the axial force causes.";
    ContactForce "contact_force" "N" "kN" 1e-3 "Force between vehicle and column, compression positive.";
}

/// A sensor on the column.
///
/// Its readings are relative to the column at rest, as it was before the impact. Positive are a motion in the vehicle's
/// direction, the rotation of an axis that leans in this direction, an axial tension, and a bending strain that is tension on
/// the side away from the vehicle.
///
/// `noise` is different in every sample; the offset behind `bias` and the gain behind `gain_error` are not known, but stay the
/// same throughout an impact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sensor {
    /// Name in parameters, messages and tables: 1 to 40 ASCII letters, digits and underscores.
    pub name: String,
    /// What it measures.
    pub quantity: Quantity,
    /// Height above the base \[m\], from 0 to the height of the column; a contact force does not depend on it.
    pub height: f64,
    /// Largest magnitude that it can read, in the unit of the quantity; larger ones are clipped to it. 0: no clipping.
    pub range: f64,
    /// Root mean square of its noise, in the unit of the quantity; 0: none.
    pub noise: f64,
    /// Standard deviation of its constant offset, in the unit of the quantity; 0: none.
    pub bias: f64,
    /// Standard deviation of its gain from 1; 0: exact.
    pub gain_error: f64,
    /// Samples per second \[Hz\], above 0.
    pub rate: f64,
    /// Cut-off frequency of its anti-alias filter \[Hz\], above 0 and at most half of `rate`.
    pub bandwidth: f64,
    /// `true` if it is mounted in the opposite direction, so that its readings have the opposite sign.
    pub reversed: bool,
    /// Distance of the fibre from the centroid \[m\]; above 0 for a bending strain, without meaning for other quantities.
    pub fibre: f64,
}

impl Sensor {
    /// A reading as far as it lies within the range.
    #[must_use]
    pub fn clipped(&self, reading: f64) -> f64 {
        match self.range > 0.0 {
            true => reading.clamp(-self.range, self.range),
            false => reading,
        }
    }

    /// Whether a reading is at the end of the range, or beyond. A range is seldom a whole number in single precision, in which
    /// readings come: a reading that is rounded down counts, too.
    #[must_use]
    pub fn is_clipped(&self, reading: f64) -> bool {
        const ROUND_OFF: f64 = 1e-6;
        self.range > 0.0 && reading.abs() >= self.range * (1.0 - ROUND_OFF)
    }
}

/// The word is not that of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("is not a quantity; known: {}", Quantity::WORDS.join(", "))]
pub struct NotAQuantity;

impl Quantity {
    /// Whether it is the strain of a fibre.
    #[must_use]
    pub const fn is_strain(self) -> bool {
        matches!(self, Self::BendingStrain | Self::AxialStrain)
    }

    /// Whether an impact that bends the column shows in it: an axial strain follows from the load and the shortening.
    #[must_use]
    pub const fn shows_bending(self) -> bool {
        !matches!(self, Self::AxialStrain)
    }

    /// Whether it is a motion that has no jumps, because the column has mass; an acceleration has some.
    #[must_use]
    pub const fn is_motion(self) -> bool {
        matches!(self, Self::Displacement | Self::Rotation)
    }

    /// Whether it keeps a value for as long as the column keeps its shape: an acceleration returns to zero.
    #[must_use]
    pub const fn is_level(self) -> bool {
        !matches!(self, Self::Acceleration)
    }

    /// Its word, such as `bending_strain`.
    #[must_use]
    pub const fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

impl FromStr for Quantity {
    type Err = NotAQuantity;

    fn from_str(word: &str) -> Result<Self, NotAQuantity> {
        let mut all = Self::ALL.into_iter();
        all.find(|it| it.word() == word).ok_or(NotAQuantity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantity_has_one_word_everywhere() {
        for (quantity, word) in Quantity::ALL.into_iter().zip(Quantity::WORDS) {
            assert_eq!(quantity.word(), word);
            assert_eq!(word.parse(), Ok(quantity));
            let json = serde_json::to_value(quantity).expect("serializes");
            assert_eq!(json, word);
        }
        for wrong in ["", "Acceleration", "bending strain", "force"] {
            assert_eq!(wrong.parse::<Quantity>(), Err(NotAQuantity), "{wrong}");
        }
    }
}
