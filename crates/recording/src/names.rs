//! Names of recordings: `recording_2026_11_21-07_40_00`, UTC, with the time format of rosbag2.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use jiff::Timestamp;
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

/// Format and length of the time in a name.
const TIME: &str = "%Y_%m_%d-%H_%M_%S";
const TIME_LENGTH: usize = "2026_11_21-07_40_00".len();

/// The name of a recording that `application` begins at `time`.
#[must_use]
pub fn directory_name(application: &str, time: SystemTime) -> String {
    // No clock shows a year after 9999.
    let time = Timestamp::try_from(time).unwrap_or_default();
    format!("{application}_{}", time.strftime(TIME))
}

/// When the recording with this name began; `None` if `application` does not name recordings like this.
/// Whatever follows the time is ignored.
#[must_use]
pub fn directory_time(application: &str, name: &str) -> Option<SystemTime> {
    let time = name.strip_prefix(application)?.strip_prefix('_')?;
    let time = time.get(..TIME_LENGTH)?;
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
            assert_eq!(directory_name("column_twin", at(seconds)), name);
            assert_eq!(directory_time("column_twin", name), Some(at(seconds)));
        }
    }

    #[test]
    fn the_rest_of_a_name_is_ignored() {
        let time = directory_time("column_twin", "column_twin_2026_11_21-07_40_00_2_repaired");
        assert_eq!(time, Some(at(1_795_246_800)));
        for other in [
            "rosbag2_2026_11_21-07_40_00",
            "column_twin_2026",
            "column_twin_2026_13_21-07_40_00",
            "column_twin_äöü",
            "",
        ] {
            assert_eq!(directory_time("column_twin", other), None, "{other}");
        }
    }
}
