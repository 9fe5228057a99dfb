//! Times of a recording for people.

use jiff::Timestamp;

/// A time \[ns since 1970\] as a date in UTC, to the millisecond.
#[must_use]
pub fn instant(nanos: i64) -> String {
    // Every 64-bit number of nanoseconds is a valid date.
    let time = Timestamp::from_nanosecond(i128::from(nanos)).unwrap_or_default();
    time.strftime("%Y-%m-%d %H:%M:%S%.3f UTC").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instant_is_a_date() {
        assert_eq!(instant(0), "1970-01-01 00:00:00.000 UTC");
        assert_eq!(
            instant(1_795_246_800_123_999_999),
            "2026-11-21 07:40:00.123 UTC"
        );
        assert_eq!(instant(i64::MAX), "2262-04-11 23:47:16.854 UTC");
    }
}
