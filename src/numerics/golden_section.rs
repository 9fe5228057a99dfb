//! The largest value of a function with one peak, by golden sections, one value at a time.

/// Share of an interval by which each section shortens it.
const SHARE: f64 = 0.618_033_988_749_894_9;

/// An interval that holds the peak, and what is known of the values inside it.
#[derive(Debug, Clone)]
pub(crate) struct GoldenSection {
    ends: [f64; 2],
    /// Values at the two inner places.
    values: [Option<f64>; 2],
}

impl GoldenSection {
    /// The peak is between these ends.
    pub fn new(ends: [f64; 2]) -> Self {
        Self {
            ends,
            values: [None; 2],
        }
    }

    fn inner(&self) -> [f64; 2] {
        let [low, high] = self.ends;
        [high - SHARE * (high - low), low + SHARE * (high - low)]
    }

    /// Where a value is needed next.
    pub fn wanted(&self) -> f64 {
        self.inner()[usize::from(self.values[0].is_some())]
    }

    /// Takes the value there.
    pub fn take(&mut self, value: f64) {
        self.values[usize::from(self.values[0].is_some())] = Some(value);
        if let [Some(lower), Some(upper)] = self.values {
            let inner = self.inner();
            if lower > upper {
                self.ends[1] = inner[1];
                self.values = [None, Some(lower)];
            } else {
                self.ends[0] = inner[0];
                self.values = [Some(upper), None];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_of_a_parabola_is_found() {
        let mut section = GoldenSection::new([-1.0, 2.0]);
        for _ in 0..30 {
            let place = section.wanted();
            section.take(-(place - 0.3) * (place - 0.3));
        }
        assert!((section.wanted() - 0.3).abs() < 1e-5);
    }
}
