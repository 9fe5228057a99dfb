//! What every input has in common: who may send, what the recording and the log are told, and what cannot be read or was lost.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use futures::{StreamExt, pin_mut};
use ros2_client::{Gid, MessageInfo};

use crate::messages::cdr;
use crate::outgoing::RecordingTap;
use crate::twin::Rejection;

use super::counters::NodeCounters;
use super::face::Face;
use super::live_columns::LiveColumns;
use super::qos::Endpoint;
use super::senders::{Rejected, Senders};
use super::transport::Subscription;
use ros_node::missed::Missed;

/// Most characters of an identifier that a log names before it was checked.
const MAX_NAMED_CHARS: usize = 64;

/// What the inputs of a node share.
#[derive(Clone)]
pub(super) struct Receiving {
    pub columns: Arc<LiveColumns>,
    pub senders: Arc<Senders>,
    pub recording: Option<Arc<dyn RecordingTap>>,
    pub counters: Arc<NodeCounters>,
}

impl Receiving {
    /// The columns, and how others tell them apart.
    pub fn face(&self) -> &Face {
        self.columns.face()
    }

    /// The column that takes a message. One for a column that is elsewhere is counted.
    pub fn addressed(&self, endpoint: &Endpoint, column_id: &str) -> Option<u32> {
        let column = self.face().addressed(column_id);
        if column.is_none() {
            NodeCounters::count(&self.counters.ignored);
            tracing::debug!(
                "a message on {} is for column {column_id:?}, which is not in this fleet",
                endpoint.name
            );
        }
        column
    }

    /// Asks whether a message or a request about a column may be taken from its sender; logs and records that it is not.
    ///
    /// # Errors
    /// The node is not active, or the sender is not allowed or too fast.
    pub fn admit(
        &self,
        sender: Gid,
        column: Option<u32>,
        endpoint: &Endpoint,
        what: &str,
    ) -> Result<(), Rejection> {
        let now = Instant::now();
        let admitted = self
            .check_active(endpoint, now)
            .and_then(|()| self.senders.admit(sender, now));
        admitted.map_err(|rejected| {
            self.tell(column, endpoint, what, &rejected);
            rejected.rejection
        })
    }

    /// Checks that the node takes what comes in on this endpoint, which a managed one may not.
    ///
    /// # Errors
    /// The node is managed and not active.
    pub fn check_active(&self, endpoint: &Endpoint, now: Instant) -> Result<(), Rejected> {
        match &self.counters.lifecycle {
            Some(it) => it.check_active(endpoint, now),
            None => Ok(()),
        }
    }

    /// Logs and records that a message of a sender was rejected.
    pub fn tell(&self, column: Option<u32>, endpoint: &Endpoint, what: &str, rejected: &Rejected) {
        let Rejected { rejection, is_told } = rejected;
        if *is_told {
            tracing::warn!("{what:?} on {} was rejected: {rejection}", endpoint.name);
            self.not_taken(column, endpoint, what, rejection);
        }
    }

    /// Records a received message in the encoding of this program; `info` is absent for a message that the node has derived from
    /// another one.
    pub fn record<M: crate::messages::Message>(
        &self,
        column: u32,
        endpoint: &Endpoint,
        message: &M,
        info: Option<&MessageInfo>,
    ) {
        let Some(recording) = &self.recording else {
            return;
        };
        let column = self.face().recorded(column);
        match cdr::encode(message) {
            Ok(bytes) => {
                let stamp = info.and_then(MessageInfo::source_timestamp);
                let source = stamp.map(|it| it.to_nanos());
                recording.received(column, endpoint, bytes, source);
            }
            Err(error) => {
                recording.rejected(column, endpoint, "a message", None, &error.to_string());
            }
        }
    }

    /// Records that a message which was received did not reach its column.
    pub fn not_taken(
        &self,
        column: Option<u32>,
        endpoint: &Endpoint,
        what: &str,
        rejection: &Rejection,
    ) {
        if let Some(recording) = &self.recording {
            let column = column.and_then(|it| self.face().recorded(it));
            let Rejection { code, reason } = rejection;
            recording.rejected(column, endpoint, what, Some(*code), reason);
        }
    }
}

/// The beginning of an identifier that was not checked yet.
pub(super) fn named(id: &str) -> String {
    id.chars().take(MAX_NAMED_CHARS).collect()
}

/// As [`each_on`] of an endpoint; returns at once if there is no such subscription.
pub(super) async fn each<M: serde::de::DeserializeOwned + 'static>(
    subscription: Option<&Subscription<M>>,
    endpoint: &Endpoint,
    counters: &NodeCounters,
    handle: impl FnMut(M, MessageInfo),
) {
    if let Some(subscription) = subscription {
        let is_reliable = endpoint.qos.reliable;
        each_on(subscription, endpoint.name, is_reliable, counters, handle).await;
    }
}

/// Passes every message to `handle`. Messages that cannot be read, or were lost before on a reliable topic, are counted and logged.
pub(super) async fn each_on<M: serde::de::DeserializeOwned + 'static>(
    subscription: &Subscription<M>,
    name: &str,
    is_reliable: bool,
    counters: &NodeCounters,
    mut handle: impl FnMut(M, MessageInfo),
) {
    let messages = subscription.async_stream();
    pin_mut!(messages);
    let mut missed = Missed::default();
    while let Some(message) = messages.next().await {
        match message {
            Ok((message, info)) => {
                let lost = missed.before(&info);
                if lost > 0 && is_reliable {
                    counters.missed.fetch_add(lost, Ordering::Relaxed);
                    tracing::error!(
                        "{lost} messages on {name} were lost: they arrived faster than they could be handled, were too long, or were \
                         sent while the network was interrupted"
                    );
                }
                handle(message, info);
            }
            Err(error) => {
                missed.unreadable();
                NodeCounters::count(&counters.unreadable);
                tracing::warn!(
                    "a message on {name} cannot be read: {error}; check the message type of its sender"
                );
            }
        }
    }
}
