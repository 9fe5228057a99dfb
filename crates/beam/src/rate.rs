//! The growth of the yield strength with the strain rate of the outer fibre, which passes a low-pass filter.

use column_mechanics::{RateLaw, RateProperties};

/// A law and its filter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rate {
    law: RateLaw,
    time_constant: f64,
    max_factor: f64,
}

impl Rate {
    pub fn new(rate: &RateProperties) -> Self {
        Self {
            law: rate.law,
            time_constant: rate.time_constant,
            max_factor: rate.max_factor,
        }
    }

    /// Advances the filtered rate \[1/s\] and its factor over `secs` \[s\] at the strain rate `now` \[1/s\].
    pub fn follow(&self, filtered: &mut [f64; 2], now: f64, secs: f64) {
        filtered[0] += -libm::expm1(-secs / self.time_constant) * (now - filtered[0]);
        filtered[1] = self.law.factor(filtered[0]).min(self.max_factor);
    }
}
