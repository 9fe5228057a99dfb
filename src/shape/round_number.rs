//! Round numbers for scales and axes.

/// The smallest of ..., 1, 2, 5, 10, ... that is not below `value`; 1 for anything but a positive number.
#[must_use]
pub fn round_number(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 1.0;
    }
    let decade = 10f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0]
        .map(|digit| digit * decade)
        .into_iter()
        .find(|round| *round >= value * (1.0 - 1e-6))
        .unwrap_or(10.0 * decade)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_numbers() {
        let rounded = [0.81e6, 1.0, 1.01, 5.0, 5.1, 0.0, f64::NAN].map(round_number);
        assert_eq!(rounded, [1e6, 1.0, 2.0, 5.0, 10.0, 1.0, 1.0]);
    }
}
