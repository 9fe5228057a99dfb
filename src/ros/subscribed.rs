//! What a client of the twin subscribes to, and its waits.

use std::sync::mpsc::{Receiver, SyncSender};
use std::time::{Duration, Instant};

use futures::{StreamExt, join, pin_mut};
use ros2_client::Subscription;
use rustdds::GUID;

use crate::messages::column_twin::{
    ColumnState, FleetStatus, HingeForces, ImpactEstimate, ImpactReport, TwinStatus,
};

use super::client::ClientError;
use super::lines::Seen;
use super::node::{Node, NodeError};
use super::qos::Endpoint;
use super::signals::StopSignals;

/// Maximum number of messages that wait to be shown; further ones are dropped.
pub(super) const SHOWN_QUEUE: usize = 1024;

/// Interval at which a wait checks whether the program is asked to stop.
pub(super) const CHECK_INTERVAL: Duration = Duration::from_millis(100);

/// The subscriptions of a client.
#[derive(Default)]
pub(super) struct Subscribed {
    pub state: Option<Subscription<ColumnState>>,
    pub forces: Option<Subscription<HingeForces>>,
    pub forecast: Option<Subscription<ImpactReport>>,
    pub report: Option<Subscription<ImpactReport>>,
    pub status: Option<Subscription<TwinStatus>>,
    pub estimate: Option<Subscription<ImpactEstimate>>,
    pub fleet: Option<Subscription<FleetStatus>>,
}

impl Subscribed {
    /// The subscriptions but that of a fleet's status.
    pub fn guids(&self) -> Vec<GUID> {
        [
            self.state.as_ref().map(Subscription::guid),
            self.forces.as_ref().map(Subscription::guid),
            self.forecast.as_ref().map(Subscription::guid),
            self.report.as_ref().map(Subscription::guid),
            self.status.as_ref().map(Subscription::guid),
            self.estimate.as_ref().map(Subscription::guid),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Passes on all messages indefinitely.
    pub async fn show(self, to: SyncSender<Seen>) {
        join!(
            pass(&self.state, &to, Seen::State),
            pass(&self.forces, &to, Seen::Forces),
            pass(&self.forecast, &to, Seen::Forecast),
            pass(&self.report, &to, Seen::Report),
            pass(&self.status, &to, Seen::Status),
            pass(&self.estimate, &to, |it| Seen::Estimate(Box::new(it))),
            pass(&self.fleet, &to, Seen::Fleet),
        );
    }
}

pub(super) async fn pass<M: serde::de::DeserializeOwned + 'static>(
    subscription: &Option<Subscription<M>>,
    to: &SyncSender<Seen>,
    seen: impl Fn(M) -> Seen,
) {
    let Some(subscription) = subscription else {
        return;
    };
    let messages = subscription.async_stream();
    pin_mut!(messages);
    while let Some(message) = messages.next().await {
        // When the queue is full, further lines are dropped; unreadable messages are ignored.
        if let Ok((message, _)) = message {
            let _ = to.try_send(seen(message));
        }
    }
}

/// The next message until an instant.
pub(super) fn next(seen: &Receiver<Seen>, until: Instant) -> Option<Seen> {
    let rest = until.saturating_duration_since(Instant::now());
    seen.recv_timeout(rest).ok()
}

/// Subscribes to a topic that later versions have added. An enclave that was made before does not permit it; its client does
/// without.
pub(super) fn later<M: serde::de::DeserializeOwned + Send + 'static>(
    node: &mut Node,
    endpoint: &Endpoint,
) -> Result<Option<Subscription<M>>, NodeError> {
    match node.subscription(endpoint) {
        Err(_) if node.protection().has_enclave() => Ok(None),
        subscription => subscription.map(Some),
    }
}

/// Repeats `attempt`, which receives the deadline of each try; `None` after `timeout`.
pub(super) fn wait_until<T>(
    signals: &StopSignals,
    timeout: Duration,
    mut attempt: impl FnMut(Instant) -> Option<T>,
) -> Result<Option<T>, ClientError> {
    let deadline = Instant::now() + timeout;
    while Instant::now() < deadline {
        if signals.asked() {
            return Err(ClientError::Interrupted);
        }
        if let Some(found) = attempt((Instant::now() + CHECK_INTERVAL).min(deadline)) {
            return Ok(Some(found));
        }
    }
    Ok(None)
}
