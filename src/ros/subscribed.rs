//! What a client of the twin subscribes to, and its waits.

use std::sync::mpsc::{Receiver, SyncSender};
use std::time::{Duration, Instant};

use futures::{StreamExt, join, pin_mut};
use rustdds::GUID;

use crate::messages::column_twin_msgs::{
    ColumnState, FleetStatus, HingeForces, ImpactEstimate, ImpactReport, TwinStatus,
};

use super::client_error::ClientError;
use super::lines::Seen;
use super::node::{Node, NodeError};
use super::qos::{self, Endpoint};
use super::transport::Subscription;
use ros_node::environment::Environment;
use ros_node::missed::Missed;
use ros_node::signals::StopSignals;

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
            pass(&self.state, &qos::COLUMN_STATE, &to, Seen::State),
            pass(&self.forces, &qos::HINGE_FORCES, &to, Seen::Forces),
            pass(&self.forecast, &qos::IMPACT_FORECAST, &to, Seen::Forecast),
            pass(&self.report, &qos::IMPACT_REPORT, &to, Seen::Report),
            pass(&self.status, &qos::TWIN_STATUS, &to, Seen::Status),
            pass(&self.estimate, &qos::IMPACT_ESTIMATE, &to, |it| {
                Seen::Estimate(Box::new(it))
            }),
            pass(&self.fleet, &qos::FLEET_STATUS, &to, Seen::Fleet),
        );
    }
}

/// Passes on all messages of a topic, and how many of them were lost.
pub(super) async fn pass<M: serde::de::DeserializeOwned + 'static>(
    subscription: &Option<Subscription<M>>,
    endpoint: &Endpoint,
    to: &SyncSender<Seen>,
    seen: impl Fn(M) -> Seen,
) {
    let Some(subscription) = subscription else {
        return;
    };
    let messages = subscription.async_stream();
    pin_mut!(messages);
    let mut missed = Missed::default();
    // Not told yet.
    let mut count = 0;
    while let Some(message) = messages.next().await {
        // Unreadable messages are ignored.
        let Ok((message, info)) = message else {
            missed.unreadable();
            continue;
        };
        let before = missed.before(&info);
        // Where only the newest message counts, nobody misses the others.
        count += if endpoint.qos.depth > 1 { before } else { 0 };
        let topic = endpoint.name;
        if count > 0 && to.try_send(Seen::Missed { topic, count }).is_ok() {
            count = 0;
        }
        // When the queue is full, further messages are dropped.
        let is_dropped = to.try_send(seen(message)).is_err();
        count += u64::from(is_dropped);
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

/// A client's wait for the twins that its endpoints are for. A twin's first messages do not reach a reader that is not matched yet.
pub(super) struct Search<'a> {
    pub node: &'a Node,
    pub environment: &'a Environment,
    pub signals: &'a StopSignals,
    /// The endpoint whose topic is named to the user.
    pub endpoint: &'a Endpoint,
    pub timeout: Duration,
}

impl Search<'_> {
    /// Waits until each of these endpoints of the client has a peer. `whom` says in the progress message what is searched for.
    ///
    /// # Errors
    /// None is found within the timeout, or the program is asked to stop.
    pub fn wait_for(
        &self,
        whom: &str,
        guids: &[GUID],
        say: &mut dyn FnMut(&str),
    ) -> Result<(), ClientError> {
        let Self { node, endpoint, .. } = self;
        let topic = node.names().resolve(endpoint.kind(), endpoint.name)?;
        let domain_id = self.environment.domain_id;
        say(&format!(
            "waiting for {whom} on {topic} in domain {domain_id}"
        ));
        let matches = node.matches();
        wait_until(self.signals, self.timeout, |until| {
            let found = |guid: &_| matches.wait_for(*guid, 1, until);
            guids.iter().all(found).then_some(())
        })?
        .ok_or_else(|| ClientError::NoTwin {
            others: node.other_topics(endpoint, &topic),
            topic,
            domain_id,
            waited: self.timeout,
        })
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
