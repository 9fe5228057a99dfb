//! Consecutive samples of one sensor, as the intake of measurements passes them on.

use std::sync::Arc;

use crate::time::Nanos;

/// Consecutive samples of one sensor, with corrected times.
#[derive(Debug, Clone, PartialEq)]
pub struct Batch {
    /// Index of the sensor in the parameter `sensors.names`.
    pub sensor: u16,
    /// Time of the first sample, by the clock that drives the twin \[ns\].
    pub first: Nanos,
    /// Time between two samples \[ns\], above 0.
    pub period: u64,
    /// The samples, in the unit of the sensor's quantity, signs corrected. A sample that is missing is NaN.
    pub values: Arc<[f32]>,
}

impl Batch {
    /// The samples with their times \[ns\].
    pub fn samples(&self) -> impl Iterator<Item = (Nanos, f32)> + '_ {
        let times = (0_u64..).map(|index| {
            let since = index.saturating_mul(self.period);
            self.first.saturating_add_unsigned(since)
        });
        times.zip(self.values.iter().copied())
    }

    /// The end of the last sample's period \[ns\].
    #[must_use]
    pub fn end(&self) -> Nanos {
        let duration = (self.values.len() as u64).saturating_mul(self.period);
        self.first.saturating_add_unsigned(duration)
    }
}
