//! Whether a sensor that sends is stuck: it repeats one value for longer than its noise allows.

/// Equal samples in a row that no sensor with noise is suspected for.
const UNSUSPICIOUS: u32 = 200;

/// Probability of a run of equal samples below which the sensor is stuck, as a logarithm: 1e-12.
const LEAST_LOG_PROBABILITY: f64 = -27.6;

/// Samples over which it is learned how often two neighbours are equal.
const LEARNING: f64 = 1e5;

/// The run of equal samples of one sensor.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stillness {
    last: f32,
    run: u32,
    /// Share of the samples that are equal to the one before; coarse sensors repeat themselves often.
    equal: f64,
    samples: f64,
}

impl Stillness {
    /// Takes a sample that is a number and not clipped.
    pub fn push(&mut self, value: f32) {
        let is_equal = self.run > 0 && value.to_bits() == self.last.to_bits();
        self.run = match is_equal {
            true => self.run.saturating_add(1),
            false => 1,
        };
        self.last = value;
        // A sensor that sticks does not teach that sticking is usual.
        if self.run < UNSUSPICIOUS {
            self.samples = (self.samples + 1.0).min(LEARNING);
            self.equal += (f64::from(u8::from(is_equal)) - self.equal) / self.samples;
        }
    }

    /// Ends the run: the next sample may be equal by another cause.
    pub fn interrupt(&mut self) {
        self.run = 0;
    }

    /// Whether noise does not explain the run.
    pub fn is_stuck(&self) -> bool {
        self.run >= UNSUSPICIOUS
            && f64::from(self.run) * libm::log(self.equal.max(f64::MIN_POSITIVE))
                < LEAST_LOG_PROBABILITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_value_is_stuck_but_a_coarse_sensor_is_not() {
        let mut stillness = Stillness::default();
        let noisy = |k: u32| ((k.wrapping_mul(2_654_435_761)) >> 8) as f32;
        (0..10_000).for_each(|k| stillness.push(noisy(k)));
        assert!(!stillness.is_stuck());
        (0..250).for_each(|_| stillness.push(3.5));
        assert!(stillness.is_stuck());
        stillness.push(noisy(1));
        assert!(!stillness.is_stuck());
        // A coarse sensor changes its last digit once in a hundred samples.
        let mut coarse = Stillness::default();
        for k in 0..100_000_u32 {
            coarse.push((k / 100) as f32);
            assert!(!coarse.is_stuck(), "{k}");
        }
        (0..400).for_each(|_| coarse.push(0.0));
        assert!(!coarse.is_stuck());
        (0..4_000).for_each(|_| coarse.push(0.0));
        assert!(coarse.is_stuck());
        coarse.interrupt();
        assert!(!coarse.is_stuck());
    }
}
