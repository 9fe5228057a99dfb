//! The two largest of the readings of a sensor, and how often each has come: at the end of a range, many are the same.

/// Samples of a block that have to be the same, bit for bit, if a sensor with noise is stuck.
pub(crate) const STUCK_SAMPLES: u32 = 10;

/// The end of a range that is not declared holds at least [`STUCK_SAMPLES`] readings, and so many times as many as the value next to it; at
/// the crest of a sine in steps it is 2.4 times.
const LIMIT_OVER_NEXT: u32 = 5;

/// The two largest values, and how often each has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extremes {
    largest: (f64, u32),
    next: (f64, u32),
}

/// Of no readings.
pub(crate) const NO_EXTREMES: Extremes = Extremes {
    largest: (f64::NEG_INFINITY, 0),
    next: (f64::NEG_INFINITY, 0),
};

impl Extremes {
    /// Takes a value that has come so often.
    pub fn take(&mut self, value: f64, count: u32) {
        if value > self.largest.0 {
            self.next = self.largest;
            self.largest = (value, count);
        } else if value == self.largest.0 {
            self.largest.1 += count;
        } else if value > self.next.0 {
            self.next = (value, count);
        } else if value == self.next.0 {
            self.next.1 += count;
        }
    }

    /// Takes those of other readings.
    pub fn take_all(&mut self, other: &Self) {
        for (value, count) in [other.largest, other.next] {
            self.take(value, count);
        }
    }

    pub fn largest(&self) -> f64 {
        self.largest.0
    }

    /// Whether values beyond the largest one were cut off to it.
    pub fn are_cut_off(&self) -> bool {
        self.largest.1 >= STUCK_SAMPLES && self.largest.1 >= LIMIT_OVER_NEXT * self.next.1
    }
}
