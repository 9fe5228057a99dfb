//! Follows a twin whose sensors detect an impact, without a ROS installation.

use std::ops::ControlFlow;
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};

use futures::join;

use super::client_error::ClientError;
use super::lines::Seen;
use super::node::Node;
use super::qos;
use super::subscribed::{CHECK_INTERVAL, SHOWN_QUEUE, Search, Subscribed, next};
use super::task::Task;
use ros_node::environment::Environment;
use ros_node::names::Names;
use ros_node::signals::StopSignals;

/// Waits at most `timeout` for a twin, calls `ready`, and passes on its estimates, reports and statuses until `hear` returns
/// `Break`. `hear` is called with `None` at least ten times per second, so that it can give up.
///
/// # Errors
/// No twin is found, or the program is asked to stop by `signals`.
pub fn follow_sensors(
    environment: &Environment,
    signals: &StopSignals,
    timeout: Duration,
    ready: impl FnOnce(),
    hear: &mut dyn FnMut(Option<&Seen>) -> ControlFlow<()>,
) -> Result<(), ClientError> {
    let names = Names::new(&environment.namespace, "column_twin_demo", &[])?;
    let mut node = Node::new(environment, names)?;
    let subscribed = Subscribed {
        report: Some(node.subscription(&qos::IMPACT_REPORT)?),
        status: Some(node.subscription(&qos::TWIN_STATUS)?),
        estimate: Some(node.subscription(&qos::IMPACT_ESTIMATE)?),
        ..Subscribed::default()
    };
    let endpoints = subscribed.guids();
    let (sender, seen) = sync_channel(SHOWN_QUEUE);
    let events = node.participant_events();
    let task = Task::start("column_twin/see", move || async move {
        join!(events, subscribed.show(sender));
    })?;
    let outcome = (|| {
        let search = Search {
            node: &node,
            environment,
            signals,
            endpoint: &qos::IMPACT_ESTIMATE,
            timeout,
        };
        search.wait_for("a twin with sensors", &endpoints, &mut |_| {})?;
        ready();
        loop {
            if signals.asked() {
                return Err(ClientError::Interrupted);
            }
            let message = next(&seen, Instant::now() + CHECK_INTERVAL);
            if hear(message.as_ref()).is_break() {
                return Ok(());
            }
        }
    })();
    task.stop();
    outcome
}
