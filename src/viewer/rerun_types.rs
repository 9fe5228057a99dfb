//! Conversions to Rerun's own types.

use rerun::components::TextLogLevel;
use rerun::log::ChunkBatcherConfig;
use rerun::{Color, TimeColumn};

use super::colour::Rgb;
use super::timeline::{IMPACT_TIME, Moment, STEP, WALL_CLOCK};
use crate::twin::NoticeLevel;

/// Maximum number of bytes on their way to a viewer; further data wait in the queue of the twin's outputs.
const BYTES_IN_FLIGHT: u64 = 8_000_000;

/// A colour as Rerun represents it.
pub(super) fn color([red, green, blue]: Rgb) -> Color {
    Color::from_rgb(red, green, blue)
}

/// The times of several rows on all timelines.
pub(super) fn time_columns(moments: impl IntoIterator<Item = Moment>) -> Vec<TimeColumn> {
    let moments: Vec<_> = moments.into_iter().collect();
    let of = |time: fn(&Moment) -> i64| moments.iter().map(time).collect::<Vec<_>>();
    vec![
        TimeColumn::new_duration_nanos(IMPACT_TIME, of(|it| it.impact_time)),
        TimeColumn::new_sequence(STEP, of(|it| it.step)),
        TimeColumn::new_timestamp_nanos_since_epoch(WALL_CLOCK, of(|it| it.wall_clock)),
    ]
}

/// The level of a line of the log.
pub(super) fn log_level(level: NoticeLevel) -> TextLogLevel {
    let level = match level {
        NoticeLevel::Info => TextLogLevel::INFO,
        NoticeLevel::Warning => TextLogLevel::WARN,
        NoticeLevel::Error => TextLogLevel::ERROR,
    };
    TextLogLevel::from(level)
}

/// How a stream collects data before it sends them.
#[must_use]
pub(super) fn batching() -> ChunkBatcherConfig {
    ChunkBatcherConfig {
        max_bytes_in_flight: BYTES_IN_FLIGHT,
        ..ChunkBatcherConfig::LOW_LATENCY
    }
}
