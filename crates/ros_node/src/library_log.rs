//! The warnings and errors of RustDDS and ros2-client, which write to the `log` crate, in the log of this program.
//!
//! A peer can provoke them with every datagram. Each place of the libraries may therefore speak only a few times per minute;
//! what it says beyond that is counted. They are not forwarded to `/rosout`, which would feed itself.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use log::{Level, LevelFilter, Log, Metadata, Record};

use super::log_limit::LogLimit;

/// Most messages of one place of the libraries per [`PERIOD`].
const MAX_PER_PLACE: u64 = 3;

/// Period of [`MAX_PER_PLACE`].
const PERIOD: Duration = Duration::from_secs(60);

/// Maximum number of places with a limit of their own. The libraries have fewer; any further places share one limit.
const MAX_PLACES: usize = 1024;

/// Longest message in characters: a text may come from a peer.
const MAX_CHARS: usize = 300;

/// Places that speak although nothing is wrong: every datagram that is longer than an Ethernet frame, and every question about
/// a peer that is not known yet.
const NOISE: [&str; 2] = ["rustdds::network::udp_sender", "ros2_client::node"];

/// Beginnings of messages that come at every start or stop, on loopback or without an installed ROS 2. They are shown at the
/// level `debug` of the target `rustdds`.
const EXPECTED: [&str; 5] = [
    "No multicast joins succeeded",
    "ROS_DISTRO is not set",
    "leave_multicast_group",
    "send_message_to_readers: No locators",
    // An endpoint that was dropped before it was announced, when a node stops right after its start.
    "Did not find a local ",
];

fn is_expected(text: &str) -> bool {
    EXPECTED.iter().any(|it| text.starts_with(it))
        || text.contains(NO_KEYS_YET)
        || is_about_itself(text)
}

/// What is sent to an endpoint of a peer that is permitted and has just been matched, before its keys have arrived; it is sent
/// again.
const NO_KEYS_YET: &str = "Could not find a remote EndpointCryptoHandle";

/// A protected participant does not match its own built-in endpoints; RustDDS warns about each pair of them.
fn is_about_itself(text: &str) -> bool {
    let mut guids = text.split("GUID {").skip(1);
    let mut prefix = || guids.next().and_then(|it| it.split(' ').next());
    let own = prefix();
    text.starts_with("Local ")
        && text.contains("have incompatible security")
        && own.is_some()
        && own == prefix()
}

/// Forwards what passes.
#[derive(Debug, Default)]
struct LibraryLog {
    places: Mutex<HashMap<Place, LogLimit>>,
}

/// File and line in a library.
type Place = (String, u32);

/// Begins to forward, if no other part of the program takes the records of the `log` crate.
pub fn forward() {
    if log::set_boxed_logger(Box::<LibraryLog>::default()).is_ok() {
        log::set_max_level(LevelFilter::Warn);
    }
}

impl LibraryLog {
    /// Whether a place may speak now; then with the number of its messages that were hidden before.
    fn admit(&self, place: Place, now: Instant) -> Option<u64> {
        let mut places = self.places.lock().unwrap_or_else(PoisonError::into_inner);
        let is_full = places.len() >= MAX_PLACES && !places.contains_key(&place);
        let place = if is_full { Place::default() } else { place };
        let limit = places.entry(place);
        limit
            .or_insert(LogLimit::new(MAX_PER_PLACE, PERIOD))
            .admit(now)
    }
}

impl Log for LibraryLog {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        let root = metadata.target().split("::").next().unwrap_or_default();
        metadata.level() <= Level::Warn
            && ["rustdds", "ros2_client"].contains(&root)
            && !NOISE.contains(&metadata.target())
    }

    fn log(&self, record: &Record<'_>) {
        if !self.enabled(record.metadata()) {
            return;
        }
        let file = record.module_path().unwrap_or_default().to_owned();
        let place = (file, record.line().unwrap_or_default());
        let Some(hidden) = self.admit(place, Instant::now()) else {
            return;
        };
        let text: String = record.args().to_string().chars().take(MAX_CHARS).collect();
        let module = record.target();
        let hidden = match hidden {
            0 => String::new(),
            _ => format!(" ({hidden} similar messages in the last minute are not shown)"),
        };
        match record.level() {
            _ if is_expected(&text) => {
                tracing::debug!(target: "rustdds", "{module}: {text}{hidden}");
            }
            Level::Error => tracing::error!(target: "rustdds", "{module}: {text}{hidden}"),
            _ => tracing::warn!(target: "rustdds", "{module}: {text}{hidden}"),
        }
    }

    fn flush(&self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_enabled(target: &str, level: Level) -> bool {
        let metadata = Metadata::builder().target(target).level(level).build();
        LibraryLog::default().enabled(&metadata)
    }

    #[test]
    fn only_warnings_of_the_libraries_that_mean_something_are_forwarded() {
        assert!(is_enabled("rustdds::rtps::reader", Level::Error));
        assert!(is_enabled("ros2_client::service", Level::Warn));
        assert!(!is_enabled("rustdds::rtps::reader", Level::Info));
        assert!(!is_enabled("rustdds::network::udp_sender", Level::Warn));
        assert!(!is_enabled("wgpu_core::device", Level::Error));
    }

    #[test]
    fn what_comes_at_every_start_is_no_warning() {
        assert!(is_expected(
            "ROS_DISTRO is not set; ros2-client was built for 'jazzy'."
        ));
        assert!(!is_expected("a peer said: ROS_DISTRO is not set"));
        // While a permitted peer joins.
        assert!(is_expected(
            "Failed to send message to readers. Encoding failed: SecurityError { msg: \"Could not find a remote \
             EndpointCryptoHandle for the pair\" }"
        ));
        let incompatible = |remote: &str| {
            format!(
                "Local reader GUID {{95 EntityId::A}} and remote writer GUID {{{remote} EntityId::B}} have incompatible \
                 security, ignoring the remote."
            )
        };
        assert!(is_expected(&incompatible("95")));
        assert!(!is_expected(&incompatible("96")));
    }

    #[test]
    fn a_hostile_peer_cannot_fill_the_log() {
        let log = LibraryLog::default();
        let start = Instant::now();
        let place = || ("rustdds::reader".to_owned(), 7);
        let shown = |now| {
            (0..10_000)
                .filter_map(|_| log.admit(place(), now))
                .collect::<Vec<_>>()
        };
        assert_eq!(shown(start), [0, 0, 0]);
        assert_eq!(shown(start + PERIOD), [9_997, 0, 0]);
        // Nor its memory.
        for line in 0..10 * MAX_PLACES as u32 {
            log.admit((String::new(), line), start);
        }
        assert!(
            log.places
                .lock()
                .is_ok_and(|places| places.len() <= MAX_PLACES + 1)
        );
    }
}
