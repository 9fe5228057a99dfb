//! Units for numbers that people read.

use crate::sensors::Quantity;

/// A unit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Unit {
    /// Symbol behind a number.
    pub symbol: &'static str,
    /// Factor from the SI unit to this unit.
    pub per_si: f64,
}

impl Unit {
    /// The unit for displacements up to `largest` \[m\].
    pub fn length(largest: f64) -> Self {
        Self::fitting(largest, [(1e-5, "µm", 1e6), (10.0, "mm", 1e3)], ("m", 1.0))
    }

    /// The unit for times up to `largest` \[s\].
    pub fn time(largest: f64) -> Self {
        Self::fitting(largest, [(1e-5, "µs", 1e6), (10.0, "ms", 1e3)], ("s", 1.0))
    }

    /// The unit for forces up to `largest` \[N\].
    pub fn force(largest: f64) -> Self {
        Self::fitting(largest, [(1e3, "N", 1.0), (1e7, "kN", 1e-3)], ("MN", 1e-6))
    }

    /// The unit for moments up to `largest` \[N m\].
    pub fn moment(largest: f64) -> Self {
        Self::fitting(
            largest,
            [(1e3, "N m", 1.0), (1e7, "kN m", 1e-3)],
            ("MN m", 1e-6),
        )
    }

    /// The unit for energies up to `largest` \[J\].
    pub fn energy(largest: f64) -> Self {
        Self::fitting(largest, [(1e3, "J", 1.0), (1e7, "kJ", 1e-3)], ("MJ", 1e-6))
    }

    /// The unit for readings of a sensor up to `largest` in the unit of its quantity.
    pub fn of_sensor(quantity: Quantity, largest: f64) -> Self {
        match quantity {
            Quantity::Displacement => Self::length(largest),
            Quantity::ContactForce => Self::force(largest),
            _ => {
                let (symbol, per_si) = quantity.shown_unit();
                Self { symbol, per_si }
            }
        }
    }

    /// The first unit whose limit, in SI units, is above `largest`; the second, most common one for zero.
    fn fitting(
        largest: f64,
        [small, usual]: [(f64, &'static str, f64); 2],
        (symbol, per_si): (&'static str, f64),
    ) -> Self {
        let (symbol, per_si) = if largest != 0.0 && largest.abs() < small.0 {
            (small.1, small.2)
        } else if largest.abs() < usual.0 {
            (usual.1, usual.2)
        } else {
            (symbol, per_si)
        };
        Self { symbol, per_si }
    }

    /// `si` in this unit.
    pub fn of(self, si: f64) -> f64 {
        si * self.per_si
    }

    /// `si` with four significant digits and the symbol. Round-off of the solver is shown as 0.
    pub fn show(self, si: f64) -> String {
        let si = if si.abs() < ROUND_OFF { 0.0 } else { si };
        format!("{} {}", significant(self.of(si), 4), self.symbol)
    }
}

/// What remains of a quantity in SI units that is zero but for round-off is smaller.
pub(crate) const ROUND_OFF: f64 = 1e-15;

/// `value` rounded to this number of significant digits, without an exponent if it stays short.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return format!("{value}");
    }
    let order = value.abs().log10().floor();
    if !(-6.0..9.0).contains(&order) {
        return format!("{value:.*e}", digits.saturating_sub(1));
    }
    let decimals = (digits as f64 - 1.0 - order).max(0.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stay_readable() {
        assert_eq!(Unit::length(0.0946).show(0.094_602_237), "94.60 mm");
        assert_eq!(Unit::force(746.9e3).show(746_921.9), "746.9 kN");
        assert_eq!(Unit::energy(0.0).show(0.0), "0 kJ");
        assert_eq!(Unit::length(0.01).show(-2e-19), "0 mm");
        assert_eq!(Unit::length(2e-9).show(2e-9), "0.002000 µm");
        assert_eq!(Unit::length(12.0).show(-12.0), "-12.00 m");
        assert_eq!(significant(f64::NAN, 4), "NaN");
        assert_eq!(significant(1.5e-12, 4), "1.500e-12");
    }
}
