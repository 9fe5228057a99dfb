//! How a message leaves the node: to its readers, and to the recording.

use std::sync::Arc;

use crate::endpoints::Endpoint;
use crate::messages::cdr::CdrError;
use crate::messages::column_twin_msgs::TwinStatus;
use crate::outgoing::{RecordingHealth, RecordingTap};

use super::counters::NodeCounters;
use super::live_columns::{Health, LiveColumns};
use super::metrics::FoxgloveCounts;
use super::transport::Publisher;
use ros_node::raw::Raw;

/// Publishes messages, counts those that are not published, and passes the same bytes to the recording.
pub(super) struct Sending {
    pub columns: Arc<LiveColumns>,
    pub counters: Arc<NodeCounters>,
    pub recording: Option<Arc<dyn RecordingTap>>,
    /// Alarms that leave past DDS, if the parameters ask for them.
    #[cfg(feature = "alarm")]
    pub alarms: Option<super::alarms::NodeAlarms>,
    /// Metrics, if the parameters ask for them.
    pub metrics: Option<super::metrics::NodeMetrics>,
    /// Foxglove, if the parameters ask for it.
    #[cfg(feature = "foxglove")]
    pub foxglove: Option<super::foxglove::NodeFoxglove>,
    /// A managed node is not active, and no column responds: what shows the columns at rest is only recorded.
    pub is_silent: bool,
    /// The time to publish is over: what remains is only recorded.
    pub is_over: bool,
}

impl Sending {
    /// Publishes and records a message without waiting. If a reader is so slow that the history is full, the message is lost for it, and
    /// counted.
    pub fn send(
        &self,
        publisher: &Publisher<Raw>,
        endpoint: &Endpoint,
        bytes: Result<Vec<u8>, CdrError>,
    ) {
        let raw = encoded(bytes);
        self.send_raw(publisher, endpoint, raw.as_ref());
    }

    /// The same of an encoded message; `None` is one that could not be encoded.
    pub fn send_raw(&self, publisher: &Publisher<Raw>, endpoint: &Endpoint, raw: Option<&Raw>) {
        let is_withheld = self.withholds(endpoint);
        let is_sent = match raw {
            Some(_) if is_withheld => true,
            Some(raw) => self.publish(publisher, raw.clone()),
            None => false,
        };
        if !is_sent {
            NodeCounters::count(&self.counters.unpublished);
            tracing::debug!("a message on {} was not published", endpoint.name);
        }
        if let (Some(recording), Some(raw)) = (&self.recording, raw) {
            recording.sent(endpoint, raw.bytes());
        }
        #[cfg(feature = "foxglove")]
        if let (Some(foxglove), Some(raw), false) = (&self.foxglove, raw, is_withheld) {
            foxglove.sent(endpoint, raw.bytes());
        }
    }

    /// Whether a message on this endpoint is only recorded now, because the node is managed and not active.
    pub fn withholds(&self, endpoint: &Endpoint) -> bool {
        self.is_silent && endpoint.shows_rest
    }

    /// Publishes a message that is not recorded; returns whether it is sent.
    pub fn publish(&self, publisher: &Publisher<Raw>, raw: Raw) -> bool {
        self.counters.lost_peers.count_published();
        !self.is_over && publisher.publish(raw).is_ok()
    }

    /// Adds the state of threads and queues, which all columns share and a twin does not know.
    pub fn add_health(&self, status: &mut TwinStatus) {
        let health = self.columns.health();
        status.overruns = health.overruns;
        status.worst_lateness = health.worst_lateness;
        status.dropped_inputs = health.dropped_inputs + self.counters.rejected_senders();
        status.dropped_states = health.dropped_states;
        status.dropped_recording = self.recording_health(&health).map_or(0, |it| it.lost);
        status.dropped_viewer = health.dropped_viewer;
    }

    /// What the server for Foxglove has done; `None` without one.
    #[cfg(feature = "foxglove")]
    pub fn foxglove_counts(&self) -> Option<FoxgloveCounts> {
        self.foxglove.as_ref().map(|it| it.counts())
    }

    /// What the server for Foxglove has done: this program has none.
    #[cfg(not(feature = "foxglove"))]
    #[allow(clippy::unused_self)] // as with the feature
    pub fn foxglove_counts(&self) -> Option<FoxgloveCounts> {
        None
    }

    /// Outputs that the queue to the publishing thread dropped are missing in the recording too, which receives its messages there.
    pub fn recording_health(&self, health: &Health) -> Option<RecordingHealth> {
        let mut recording = self.recording.as_ref()?.health();
        recording.lost += health.dropped_recording;
        Some(recording)
    }
}

/// `None` if the message could not be encoded.
pub(super) fn encoded(bytes: Result<Vec<u8>, CdrError>) -> Option<Raw> {
    Raw::new(bytes.ok()?.into()).ok()
}
