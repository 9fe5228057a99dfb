//! Lines of the log with the level of a notice.

use crate::twin::NoticeLevel;

/// Logs a line of a level.
pub(super) fn log(level: NoticeLevel, text: &str) {
    match level {
        NoticeLevel::Info => tracing::info!("{text}"),
        NoticeLevel::Warning => tracing::warn!("{text}"),
        NoticeLevel::Error => tracing::error!("{text}"),
    }
}
