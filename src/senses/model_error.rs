//! How far the model may be from the column: its own error, beside the noise of the sensors.
//!
//! Without it, intervals would be those of a perfect model. The numbers were chosen on five signals of a fibre-beam model
//! of other authorship (`tests/data/signals/`) and are assumptions \[A\] of this project, rounded up.

use super::sensor::Quantity;

/// Times after contact within which flexural waves, which the model does not have, cross the column \[s\].
const WAVES: f64 = 3e-3;

/// Model error of one quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ModelError {
    /// Standard deviation of the factor between the column's and the model's readings, the same for a whole response.
    pub scale: f64,
    /// Standard deviation of the error of the shape, relative to the largest reading so far.
    shape: f64,
    /// The same at contact, in addition; it fades with [`WAVES`].
    waves: f64,
    /// Shortest time over which the error of the shape is correlated \[s\].
    correlation: f64,
}

/// Share of the time since contact over which the error of the shape is correlated: a residual that stays where it is
/// tells its error only once.
const CORRELATION_SHARE: f64 = 0.5;

impl ModelError {
    pub const fn of(quantity: Quantity) -> Self {
        let [scale, shape, waves, correlation] = match quantity {
            Quantity::Displacement | Quantity::Rotation => [0.08, 0.06, 0.25, 4e-3],
            Quantity::BendingStrain => [0.06, 0.06, 1.5, 4e-3],
            Quantity::ContactForce => [0.1, 0.1, 1.0, 4e-3],
            // Second-order quantities, and what waves dominate.
            Quantity::AxialStrain => [0.5, 1.0, 1.0, 4e-3],
            Quantity::Acceleration => [0.5, 1.0, 1.0, 2e-3],
        };
        Self {
            scale,
            shape,
            waves,
            correlation,
        }
    }

    /// Variance of the mean over a block of `length` that ends `until` after contact \[s\], where the largest reading so far
    /// is `largest`. `yielded`: hinges have yielded, so that strains elsewhere depend on the details of the plastic zones.
    pub fn variance(&self, until: f64, length: f64, largest: f64, yielded: bool) -> f64 {
        let middle = (until - 0.5 * length).max(0.0);
        let correlated = (CORRELATION_SHARE * middle).max(self.correlation);
        let deviation = self.deviation(middle, largest, yielded);
        deviation * deviation * (correlated / length).max(1.0)
    }

    /// Standard deviation of the error of the shape at a time after contact \[s\]; the other arguments are those of
    /// [`variance`](Self::variance), which lets correlated errors count once.
    pub fn deviation(&self, time: f64, largest: f64, yielded: bool) -> f64 {
        let mut share = self.shape + self.waves * libm::exp(-time.max(0.0) / WAVES);
        if yielded {
            share = share.max(YIELDED_STRAIN);
        }
        share * largest
    }
}

/// Error of the shape of strains after a hinge has yielded, relative to the largest reading so far.
const YIELDED_STRAIN: f64 = 0.25;
