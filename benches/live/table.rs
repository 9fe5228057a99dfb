//! Percentiles and table rows.

/// Sorted numbers.
pub struct Ranked(Vec<f64>);

impl Ranked {
    pub fn new(numbers: impl IntoIterator<Item = f64>) -> Self {
        let mut numbers: Vec<_> = numbers.into_iter().collect();
        numbers.sort_by(f64::total_cmp);
        Self(numbers)
    }

    /// The smallest number that `percent` of all numbers do not exceed; NaN if there are none.
    pub fn percentile(&self, percent: f64) -> f64 {
        let place = (percent / 100.0 * self.0.len() as f64).ceil() as usize;
        let number = self.0.get(place.saturating_sub(1));
        number.copied().unwrap_or(f64::NAN)
    }

    pub fn max(&self) -> f64 {
        self.percentile(100.0)
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }
}

/// Prints a row: its name, then its cells.
pub fn row(name: &str, cells: impl IntoIterator<Item = String>) {
    print!("{name:<44}");
    for cell in cells {
        print!("{cell:>12}");
    }
    println!();
}

pub fn number(number: f64) -> String {
    format!("{number:.3}")
}
