//! Dates of certificates and documents.

use std::time::Duration;

use jiff::Timestamp;
use openssl::asn1::{Asn1Time, Asn1TimeRef};
use openssl::error::ErrorStack;

/// How long before its end a certificate or a permissions document is announced to expire.
pub const EXPIRY_NOTICE: Duration = Duration::from_secs(30 * 24 * 3600);

/// The whole seconds of a date of a certificate.
pub(crate) fn of_certificate(time: &Asn1TimeRef) -> Result<Timestamp, ErrorStack> {
    let since = Asn1Time::from_unix(0)?.diff(time)?;
    let seconds = i64::from(since.days) * 86_400 + i64::from(since.secs);
    // Dates of certificates end with the year 9999, those of `jiff` as well.
    Ok(Timestamp::from_second(seconds).unwrap_or(Timestamp::MAX))
}

/// A date of a permissions document: XSD `dateTime`, in UTC unless it names an offset.
pub(super) fn of_document(text: &str) -> Option<Timestamp> {
    let text = text.trim();
    text.parse::<Timestamp>().ok().or_else(|| {
        let date: jiff::civil::DateTime = text.parse().ok()?;
        let zoned = date.to_zoned(jiff::tz::TimeZone::UTC).ok()?;
        Some(zoned.timestamp())
    })
}

/// The time that is left, in words.
pub(super) fn remaining(until: Timestamp, now: Timestamp) -> String {
    match until.as_second().saturating_sub(now.as_second()) {
        seconds if seconds >= 2 * 86_400 => format!("in {} days", seconds / 86_400),
        seconds if seconds >= 2 * 3600 => format!("in {} hours", seconds / 3600),
        seconds if seconds >= 0 => format!("in {} minutes", seconds / 60),
        _ => "already".to_owned(),
    }
}

/// Whether a date is so near that it must be announced, or is over.
pub(super) fn is_near(until: Timestamp, now: Timestamp) -> bool {
    let notice = i64::try_from(EXPIRY_NOTICE.as_secs()).unwrap_or(i64::MAX);
    until.as_second().saturating_sub(now.as_second()) < notice
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_of_certificates_are_converted() {
        for (seconds, text) in [
            (0, "1970-01-01T00:00:00Z"),
            (1_795_303_513, "2026-11-21T23:25:13Z"),
            (-86_400, "1969-12-31T00:00:00Z"),
        ] {
            let time = Asn1Time::from_unix(seconds).expect("valid");
            assert_eq!(of_certificate(&time).expect("valid").to_string(), text);
        }
        let far = Asn1Time::from_str("99991231235959Z").expect("valid");
        assert!(
            of_certificate(&far).expect("valid") > Timestamp::from_second(2e11 as i64).unwrap()
        );
    }

    #[test]
    fn dates_of_documents_are_in_utc_unless_they_name_an_offset() {
        for text in [
            "2026-11-22T08:00:00",
            "2026-11-22T08:00:00Z",
            "2026-11-22T10:00:00+02:00",
            " 2026-11-22T03:00:00-05:00\n",
        ] {
            let date = of_document(text).unwrap_or_else(|| panic!("{text}"));
            assert_eq!(date.to_string(), "2026-11-22T08:00:00Z", "{text}");
        }
        assert_eq!(of_document("yesterday"), None);
    }

    #[test]
    fn an_end_is_announced_thirty_days_ahead() {
        let now = of_document("2026-01-01T00:00:00Z").unwrap();
        for (until, is_announced) in [
            ("2026-01-31T00:00:01Z", false),
            ("2026-01-30T23:59:59Z", true),
            ("2025-12-31T00:00:00Z", true),
        ] {
            assert_eq!(is_near(of_document(until).unwrap(), now), is_announced);
        }
    }
}
