//! Names of recordings: `column_twin_2026_11_21-07_40_00`, UTC, as rosbag2 puts time into names.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// What the names of our recordings begin with.
const PREFIX: &str = "column_twin_";

const SECONDS_PER_DAY: u64 = 86_400;

/// The name of a recording that begins at `time`.
#[must_use]
pub fn directory_name(time: SystemTime) -> String {
    let seconds = time
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default()
        .as_secs();
    let (year, month, day) = date_of(seconds / SECONDS_PER_DAY);
    let (hour, minute, second) = (seconds / 3600 % 24, seconds / 60 % 60, seconds % 60);
    format!("{PREFIX}{year:04}_{month:02}_{day:02}-{hour:02}_{minute:02}_{second:02}")
}

/// When a recording of that name began; `None` where the name is none of ours. What follows the time is not looked at.
#[must_use]
pub fn directory_time(name: &str) -> Option<SystemTime> {
    let digits = |from: usize, to: usize| -> Option<u64> {
        let text = name.strip_prefix(PREFIX)?.get(from..to)?;
        let all_digits = text.bytes().all(|byte| byte.is_ascii_digit());
        all_digits.then(|| text.parse().ok()).flatten()
    };
    let (year, month, day) = (digits(0, 4)?, digits(5, 7)?, digits(8, 10)?);
    let (hour, minute, second) = (digits(11, 13)?, digits(14, 16)?, digits(17, 19)?);
    let days = days_until(year, month, day)?;
    let seconds = days * SECONDS_PER_DAY + hour * 3600 + minute * 60 + second;
    UNIX_EPOCH.checked_add(Duration::from_secs(seconds))
}

/// Year, month and day, `days` after 1970-01-01, in the Gregorian calendar. The year is counted from March, so that the
/// leap day ends it; 400 years have 146097 days.
fn date_of(days: u64) -> (u64, u64, u64) {
    let days = days + 719_468; // from 0000-03-01
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let march_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * march_month + 2) / 5 + 1;
    let month = if march_month < 10 {
        march_month + 3
    } else {
        march_month - 9
    };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    (year, month, day)
}

/// Days from 1970-01-01 to that day; `None` for a day before, or a month that does not exist.
fn days_until(year: u64, month: u64, day: u64) -> Option<u64> {
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) || year < 1970 {
        return None;
    }
    let year = year - u64::from(month <= 2);
    let (era, year_of_era) = (year / 400, year % 400);
    let march_month = if month > 2 { month - 3 } else { month + 9 };
    let day_of_year = (153 * march_month + 2) / 5 + day - 1;
    let day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
    (era * 146_097 + day_of_era).checked_sub(719_468)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: u64) -> SystemTime {
        UNIX_EPOCH + Duration::from_secs(seconds)
    }

    /// Judged by `date -u -d @SECONDS`.
    #[test]
    fn names_are_dates_of_the_calendar() {
        for (seconds, name) in [
            (0, "column_twin_1970_01_01-00_00_00"),
            (951_782_400, "column_twin_2000_02_29-00_00_00"),
            (1_795_246_800, "column_twin_2026_11_21-07_40_00"),
            (4_107_542_399, "column_twin_2100_02_28-23_59_59"),
            (4_107_542_400, "column_twin_2100_03_01-00_00_00"),
        ] {
            assert_eq!(directory_name(at(seconds)), name);
            assert_eq!(directory_time(name), Some(at(seconds)));
        }
    }

    #[test]
    fn what_follows_the_time_does_not_matter() {
        let time = directory_time("column_twin_2026_11_21-07_40_00_2_repaired");
        assert_eq!(time, Some(at(1_795_246_800)));
        for other in [
            "rosbag2_2026_11_21-07_40_00",
            "column_twin_2026",
            "column_twin_2026_13_21-07_40_00",
            "column_twin_äöü",
            "",
        ] {
            assert_eq!(directory_time(other), None, "{other}");
        }
    }
}
