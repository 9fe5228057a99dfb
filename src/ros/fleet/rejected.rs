//! What a recording of a fleet is told of a message that did not reach its column.

use std::sync::Arc;

use crate::endpoints::Endpoint;
use crate::outgoing::RecordingTap;
use crate::twin::Refusal;

/// Records that a message which was received did not reach its column.
pub(super) fn not_taken(
    recording: &Option<Arc<dyn RecordingTap>>,
    column_id: &str,
    endpoint: &Endpoint,
    what: &str,
    refusal: &Refusal,
) {
    if let Some(recording) = recording {
        let Refusal { code, reason } = refusal;
        recording.rejected(Some(column_id), endpoint, what, Some(*code), reason);
    }
}
