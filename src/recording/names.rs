//! Names of recordings: `column_twin_2026_11_21-07_40_00`, UTC, as rosbag2 puts time into names.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

/// What the names of our recordings begin with.
const PREFIX: &str = "column_twin_";

/// How the time stands behind it, and how long that is.
const TIME: &str = "%Y_%m_%d-%H_%M_%S";
const TIME_LENGTH: usize = "2026_11_21-07_40_00".len();

/// The name of a recording that begins at `time`.
#[must_use]
pub fn directory_name(time: SystemTime) -> String {
    // No clock is beyond the year 9999.
    let time = Timestamp::try_from(time).unwrap_or_default();
    format!("{PREFIX}{}", time.strftime(TIME))
}

/// When a recording of that name began; `None` where the name is none of ours. What follows the time is not looked at.
#[must_use]
pub fn directory_time(name: &str) -> Option<SystemTime> {
    let time = name.strip_prefix(PREFIX)?.get(..TIME_LENGTH)?;
    let time = DateTime::strptime(TIME, time).ok()?;
    let time = time.to_zoned(TimeZone::UTC).ok()?.timestamp();
    let seconds = u64::try_from(time.as_second()).ok()?;
    UNIX_EPOCH.checked_add(Duration::from_secs(seconds))
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
