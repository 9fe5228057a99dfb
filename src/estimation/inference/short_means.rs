//! Readings averaged over short times, with which the vibrations that a vehicle has left can be compared.

/// Time of a mean \[s\].
pub(crate) const SHORT: f64 = 0.5e-3;

/// Time after contact from which on there are none \[s\]: several periods of a column of usual length.
pub(crate) const LAST: f64 = 45e-3;

/// The sums of one sensor, with their numbers of readings.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct ShortSums(Vec<(f64, u32)>);

impl ShortSums {
    /// Takes a reading, relative to the zero, at a time after contact \[s\].
    pub fn push(&mut self, time: f64, reading: f64) {
        if !(0.0..LAST).contains(&time) {
            return;
        }
        let index = (time / SHORT) as usize;
        if self.0.len() <= index {
            self.0.resize(index + 1, (0.0, 0));
        }
        let (sum, count) = &mut self.0[index];
        *sum += reading;
        *count += 1;
    }

    /// The means that are complete at a time after contact \[s\], with their numbers of readings; `None` where nothing was read.
    pub fn means(&self, until: f64) -> Vec<Option<(f64, u32)>> {
        // Half a nanosecond for the round-off of times.
        let complete = ((until + 5e-10).max(0.0) / SHORT) as usize;
        let each = self.0.iter().take(complete);
        each.map(|&(sum, count)| (count > 0).then(|| (sum / f64::from(count), count)))
            .collect()
    }
}
