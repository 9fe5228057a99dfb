//! How far the model may be from the column: its own error, beside the noise of the sensors.
//!
//! Without it, intervals would be those of a perfect model. The numbers were chosen on five signals of a fibre-beam model
//! of other authorship (`tests/data/signals/`) and are assumptions \[A\] of this project, rounded up.

use crate::estimation::inference::block_layout::Block;
use crate::estimation::inference::blocks::BlockMean;
use crate::sensors::Quantity;

/// Times after contact within which flexural waves, which the model does not have, cross the column \[s\].
const WAVES: f64 = 3e-3;

/// The same for what moves \[s\]: a displacement is the acceleration integrated twice, in which waves of more than a
/// kilohertz vanish. What remains is that the column's mass takes part little by little, and in the model at once.
const WAVES_OF_MOTION: f64 = 1e-3;

/// Time after contact over which the error of a motion grows to its full size \[s\], about two periods of a column of usual
/// length. At first the impact point moves with the vehicle, and a wrong force only changes how fast that is slowed down.
const GROWTH: f64 = 20e-3;

/// Share of the full error of a motion that there is at contact already.
const AT_CONTACT: f64 = 1.0 / 3.0;

/// Model error of one quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModelError {
    /// Standard deviation of the factor between the column's and the model's readings, the same for a whole response.
    pub scale: f64,
    /// Standard deviation of the error of the shape, relative to the largest reading so far.
    shape: f64,
    /// The same at contact, in addition; it fades with the waves.
    waves: f64,
    /// Shortest time over which the error of the shape is correlated \[s\].
    correlation: f64,
    /// Whether the quantity is a motion, which has no jumps because the column has mass.
    is_motion: bool,
}

/// Share of a reading that its error is relative to at least, where it is far larger than all before \[A\].
const FAR_LARGER: f64 = 0.5;

/// Share of the time since contact over which the error of the shape is correlated: a residual that stays where it is
/// tells its error only once.
const CORRELATION_SHARE: f64 = 0.5;

impl ModelError {
    pub const fn of(quantity: Quantity) -> Self {
        let [scale, shape, waves, correlation] = match quantity {
            // A quarter of the period of a column of usual length.
            Quantity::Displacement | Quantity::Rotation => [0.08, 0.06, 0.25, 2e-3],
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
            is_motion: quantity.is_motion(),
        }
    }

    /// The error of the mean over a block, given that over the block before it: the share of the latter that is expected to
    /// come again, and the variance of the rest, noise included.
    ///
    /// What is expected to come again tells nothing new about a response, but an error that changes faster than that of a
    /// motion can contradicts it: this is what tells the sudden start of a rigid hit from the smooth one of a spring, and a
    /// heavy vehicle from one that the column slows down.
    pub fn given(
        &self,
        before: Option<&(Block, BlockMean)>,
        now: &(Block, BlockMean),
    ) -> (f64, f64) {
        let own = self.variance(now);
        let variance = own + now.1.variance;
        let Some(before) = before.filter(|_| self.is_motion) else {
            return (0.0, variance);
        };
        // Matern's correlation of a process that has a velocity, but no acceleration.
        let distance = (middle(&now.0) - middle(&before.0)) / self.correlation;
        let correlation = (1.0 + distance) * libm::exp(-distance);
        let other = self.variance(before);
        let covariance = correlation * (own * other).sqrt();
        let carried = covariance / (other + before.1.variance).max(f64::MIN_POSITIVE);
        (carried, variance - carried * covariance)
    }

    /// Variance of the mean over a block, without noise. It is larger by how long the error is correlated, as far as the
    /// next blocks do not take that into account themselves, so that it counts once.
    fn variance(&self, (block, mean): &(Block, BlockMean)) -> f64 {
        let time = middle(block).max(0.0);
        let deviation = self.shape_deviation(time, mean);
        let persistent = CORRELATION_SHARE * time;
        let inflation = match self.is_motion {
            true => persistent / block.length.max(self.correlation),
            false => persistent.max(self.correlation) / block.length,
        };
        // A vibration is over within its period, and counts in each block.
        deviation * deviation * inflation.max(1.0) + mean.swing * mean.swing
    }

    /// Standard deviation of the error at a time after contact \[s\], without noise.
    pub fn deviation(&self, time: f64, mean: &BlockMean) -> f64 {
        let shape = self.shape_deviation(time, mean);
        (shape * shape + mean.swing * mean.swing).sqrt()
    }

    /// The same without vibrations. Where hinges have yielded, strains elsewhere depend on the details of the plastic zones.
    fn shape_deviation(&self, time: f64, mean: &BlockMean) -> f64 {
        let mut share = self.share(time);
        if mean.yielded {
            share = share.max(YIELDED_STRAIN);
        }
        share * self.relative_to(time, mean)
    }

    /// The reading that the error at a time after contact \[s\] is relative to: the largest one before. If it were the reading that the error
    /// is part of, one that comes out large by its error would count less than one that comes out small, and the vehicle would seem too
    /// light. While waves prevail, which the model does not have, it is that one all the same, because nothing before shows their size, and so
    /// it is before contact.
    fn relative_to(&self, time: f64, mean: &BlockMean) -> f64 {
        match self.by_waves(time) < self.by_shape(time) {
            true => mean.largest_before.max(FAR_LARGER * mean.largest),
            false => mean.largest,
        }
    }

    /// The same relative to that reading.
    pub fn share(&self, time: f64) -> f64 {
        let time = time.max(0.0);
        self.by_shape(time) + self.by_waves(time)
    }

    fn by_shape(&self, time: f64) -> f64 {
        match self.is_motion {
            true => self.shape * (1.0 - (1.0 - AT_CONTACT) * libm::exp(-time / GROWTH)),
            false => self.shape,
        }
    }

    fn by_waves(&self, time: f64) -> f64 {
        let faded = match self.is_motion {
            true => WAVES_OF_MOTION,
            false => WAVES,
        };
        self.waves * libm::exp(-time / faded)
    }
}

/// Error of a motion within the first period of the column under a hard front that is light: relative to the largest reading so far, times
/// the power 1.5 of the mass that the model has at the impact point over that of the front \[A\]. The beam moves by its own modes then:
/// under 290 kg its displacement differs from that of the bars by 0.45 of the largest reading, under 450 kg by 0.25. With its largest value.
const LIGHT_FRONT: [f64; 2] = [2.4, 1.0];

/// What of this every motion has already, so that a front as heavy as that of a car adds nothing \[A\].
const OF_ANY_FRONT: f64 = 0.1;

/// See [`LIGHT_FRONT`], by this ratio of the masses.
pub(crate) fn light_front(ratio: f64) -> f64 {
    let [size, most] = LIGHT_FRONT;
    let whole = (size * ratio * ratio.sqrt()).min(most);
    (whole * whole - OF_ANY_FRONT * OF_ANY_FRONT)
        .max(0.0)
        .sqrt()
}

/// Error of motions under a soft front, relative to the largest reading so far, times the angle by which the bars have swung since contact
/// \[A\]: under a force that rises steadily, a column swings about the displacement by that force, and the swing is the smaller beside it
/// the longer the force has risen. Bars and beam do so with different frequencies.
///
/// Under soft fronts of all kinds the displacement of the beam differs from that of the bars by at most 0.53 of the largest reading at
/// 2.5 ms, 0.21 at 5.5 ms, 0.12 at 12 ms and 0.08 at 21 ms.
const SOFT_FRONT: f64 = 1.4;

/// See [`SOFT_FRONT`], by the stiffness of the front over that of the column at the impact point: a stiff front prescribes a motion.
pub(crate) fn soft_front(ratio: f64) -> f64 {
    SOFT_FRONT / (1.0 + ratio)
}

/// What of it is left where the readings of the bars are corrected by the beam: the column is a few per cent stiffer or heavier, the vehicle
/// is slowed down, and hinges yield \[A\].
const LEFT_BY_CORRECTION: f64 = 0.3;

/// The angle before which this error is not larger \[rad\].
const LEAST_ANGLE: f64 = 3.0;

/// What the error of motions depends on beside [`ModelError`]: what strikes the column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum FrontError {
    /// Relative to the largest reading within the first period of the column: see [`light_front`].
    Light(f64),
    /// See [`soft_front`].
    Soft(f64),
}

impl FrontError {
    /// None.
    pub const NONE: Self = Self::Light(0.0);

    pub fn squared(self) -> f64 {
        let (Self::Light(it) | Self::Soft(it)) = self;
        it * it
    }

    /// What a light front contributes.
    pub fn by_light_front(self) -> f64 {
        match self {
            Self::Light(error) => error,
            Self::Soft(_) => 0.0,
        }
    }

    /// Variance of the mean over a block by this error, where the impact point swings with this circular frequency \[rad/s\], and the readings
    /// under a soft front are corrected by the beam or not.
    pub fn variance(
        self,
        quantity: Quantity,
        (block, mean): &(Block, BlockMean),
        frequency: f64,
        is_corrected: bool,
    ) -> f64 {
        let relative_to = ModelError::of(quantity).relative_to(middle(block), mean);
        let size = match self {
            Self::Soft(_) if quantity.is_motion() => {
                let left = if is_corrected {
                    LEFT_BY_CORRECTION
                } else {
                    1.0
                };
                left * relative_to / (frequency * middle(block)).max(LEAST_ANGLE)
            }
            Self::Soft(_) => 0.0,
            Self::Light(_) if mean.in_waves => relative_to,
            Self::Light(_) => 0.0,
        };
        self.squared() * size * size
    }
}

/// Time from contact to the middle of a block \[s\]; negative before contact.
fn middle(block: &Block) -> f64 {
    block.start + 0.5 * block.length
}

/// Error of the shape of strains after a hinge has yielded, relative to the largest reading so far.
pub(crate) const YIELDED_STRAIN: f64 = 0.25;

#[cfg(test)]
mod tests {
    use super::*;

    fn block(start: f64, mean: f64, deviation: f64) -> (Block, BlockMean) {
        let length = 1e-3;
        let mean = BlockMean {
            mean,
            variance: deviation * deviation,
            largest: mean,
            swing: 0.0,
            largest_before: mean,
            in_waves: false,
            yielded: false,
        };
        (Block { start, length }, mean)
    }

    /// The squared errors of two blocks, one given the other, add up to those with the inverse of their covariance.
    #[test]
    fn two_blocks_weigh_as_their_joint_normal_law() {
        let error = ModelError::of(Quantity::Displacement);
        let noise = 1e-4;
        let (first, second) = (block(1e-3, 0.010, noise), block(2e-3, 0.013, noise));
        let (none, v1) = error.given(None, &first);
        let (carried, v2) = error.given(Some(&first), &second);
        assert!(none.abs() < f64::EPSILON);
        let (s1, s2) = (
            error.deviation(1.5e-3, &first.1),
            error.deviation(2.5e-3, &second.1),
        );
        let covariance = 1.5 * libm::exp(-0.5) * s1 * s2;
        let [a, b] = [s1 * s1 + noise * noise, s2 * s2 + noise * noise];
        for [e1, e2] in [[1e-3, 1e-3], [1e-3, -1e-3], [0.0, 5e-4]] {
            let joint = (b * e1 * e1 - 2.0 * covariance * e1 * e2 + a * e2 * e2)
                / (a * b - covariance * covariance);
            let one_by_one = e1 * e1 / v1 + (e2 - carried * e1) * (e2 - carried * e1) / v2;
            assert!(
                (one_by_one / joint - 1.0).abs() < 1e-9,
                "{one_by_one} {joint}"
            );
        }
    }

    /// What it was relative to used to contain its own error: the vehicle seemed too light.
    #[test]
    fn a_reading_counts_the_same_whether_its_error_makes_it_larger_or_smaller() {
        const BEFORE: f64 = 0.010;
        for quantity in [
            Quantity::Displacement,
            Quantity::BendingStrain,
            Quantity::Acceleration,
        ] {
            let variance = |reading: f64| {
                let (block, mean) = block(20e-3, reading, 0.0);
                let mean = BlockMean {
                    largest: reading.max(BEFORE),
                    largest_before: BEFORE,
                    ..mean
                };
                ModelError::of(quantity).given(None, &(block, mean)).1
            };
            let [larger, smaller] = [1.3 * BEFORE, 0.7 * BEFORE].map(variance);
            assert!(smaller > 0.0 && (larger / smaller - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn blocks_before_contact_without_noise_weigh_something_finite() {
        let error = ModelError::of(Quantity::Rotation);
        let (carried, variance) =
            error.given(Some(&block(-2e-3, 1e-6, 0.0)), &block(-1e-3, 1e-6, 0.0));
        assert!(
            variance > 0.0 && (0.0..1.0).contains(&carried),
            "{carried} {variance}"
        );
    }
}
