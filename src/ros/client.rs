//! The twin's terminal: send an impact, watch what comes of it, without any ROS installed.

use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use futures::{StreamExt, join, pin_mut};
use ros2_client::Subscription;
use rustdds::GUID;

use crate::messages::builtin_interfaces::Time;
use crate::messages::column_twin::{
    ColumnState, HingeForces, ImpactEvent, ImpactReport, TwinStatus,
};
use crate::messages::std_msgs::Header;

use super::environment::Environment;
use super::lines::WatchLines;
use super::names::{NameError, Names, RemapRule};
use super::node::{Node, NodeError};
use super::qos;
use super::signals::StopSignals;
use super::task::Task;

/// Messages that may wait to be shown; the next ones are not shown.
const SHOWN_QUEUE: usize = 1024;

/// How often a wait looks whether the program is asked to stop.
const LOOK: Duration = Duration::from_millis(100);

/// How long to wait for the status that a twin keeps for late joiners.
const STATUS_WAIT: Duration = Duration::from_secs(2);

/// One impact to send.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpactOptions {
    /// The column.
    pub column_id: String,
    /// The event; `None`: one that nobody has used.
    pub event_id: Option<String>,
    /// Mass of the vehicle \[kg\].
    pub mass: f64,
    /// Speed over the ground \[m/s\].
    pub velocity: f64,
    /// Distance \[m\]; `None`: the twin's parameter.
    pub gap: Option<f64>,
    /// Coefficient of restitution; `None`: the twin's parameter.
    pub restitution: Option<f64>,
    /// Height above the base \[m\]; `None`: the twin's parameter.
    pub height: Option<f64>,
    /// How long to wait for a twin.
    pub match_timeout: Duration,
    /// How long to wait for its forecast.
    pub answer_timeout: Duration,
}

/// What the twin made of an impact.
#[derive(Debug, Clone, PartialEq)]
pub enum ImpactOutcome {
    /// It was accepted, and this is the forecast.
    Forecast(Box<ImpactReport>),
    /// It was refused, for this reason.
    Refused(String),
}

/// Why an impact found no twin, or no answer.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// A name that is none.
    #[error(transparent)]
    Name(#[from] NameError),
    /// No node.
    #[error(transparent)]
    Node(#[from] NodeError),
    /// No handler.
    #[error("signals cannot be handled: {0}")]
    Signals(#[from] std::io::Error),
    /// Nobody listens.
    #[error(
        "no twin listens on {topic} in domain {domain_id} (waited {waited:?}); is `column-twin run` started, with the \
         same ROS_DOMAIN_ID, namespace and ROS_AUTOMATIC_DISCOVERY_RANGE?"
    )]
    NoTwin {
        /// The topic.
        topic: String,
        /// The domain.
        domain_id: u16,
        /// How long.
        waited: Duration,
    },
    /// The event cannot be written.
    #[error("the event cannot be sent: {0}")]
    NotSent(String),
    /// Sent, but nothing came back.
    #[error(
        "the event {event_id} was sent, but neither forecast nor refusal came within {waited:?}; look at `twin_status`"
    )]
    NoAnswer {
        /// The event.
        event_id: String,
        /// How long.
        waited: Duration,
    },
    /// The twin refuses it.
    #[error("the twin refuses the event: {0}")]
    Refused(String),
    /// The model has failed.
    #[error("the twin has a fault: {0}; ~/reset makes the column virgin again")]
    Faulted(String),
    /// Interrupted.
    #[error("interrupted")]
    Interrupted,
}

/// What a twin says.
#[derive(Debug, Clone)]
pub enum Seen {
    /// The column at one instant.
    State(ColumnState),
    /// Its hinges at one instant.
    Forces(HingeForces),
    /// What will come of an impact.
    Forecast(ImpactReport),
    /// What came of it.
    Report(ImpactReport),
    /// How the twin is.
    Status(TwinStatus),
}

/// Publishes one event and waits for what the twin makes of it; `say` is told what is going on.
///
/// # Errors
/// When there is no twin, or no answer, or the program is asked to stop.
pub fn send_impact(
    environment: &Environment,
    rules: &[RemapRule],
    options: &ImpactOptions,
    say: &mut dyn FnMut(&str),
) -> Result<ImpactOutcome, ClientError> {
    let names = Names::new(&environment.namespace, "column_twin_impact", rules)?;
    let mut node = Node::new(environment, names)?;
    let sight = Sight {
        forecast: Some(node.subscription(&qos::IMPACT_FORECAST)?),
        status: Some(node.subscription(&qos::TWIN_STATUS)?),
        ..Sight::default()
    };
    converse(
        node,
        environment,
        sight,
        options,
        say,
        &mut |word, sent| match answer(word, sent.event_id, sent.refused_before) {
            Some(outcome) => Heard::Last(outcome),
            None => Heard::Other,
        },
    )
}

/// Shows state, forecasts, reports and refusals, one line each, until the program is asked to stop or `show` says that nobody
/// looks any more.
///
/// # Errors
/// When there is no node to be had.
pub fn watch(
    environment: &Environment,
    rules: &[RemapRule],
    show: &mut dyn FnMut(&str) -> ControlFlow<()>,
) -> Result<(), ClientError> {
    let signals = StopSignals::listen()?;
    let names = Names::new(&environment.namespace, "column_twin_watch", rules)?;
    let mut node = Node::new(environment, names)?;
    let sight = Sight {
        state: Some(node.subscription(&qos::COLUMN_STATE)?),
        forecast: Some(node.subscription(&qos::IMPACT_FORECAST)?),
        report: Some(node.subscription(&qos::IMPACT_REPORT)?),
        status: Some(node.subscription(&qos::TWIN_STATUS)?),
        ..Sight::default()
    };
    let topic = node
        .names()
        .resolve(qos::COLUMN_STATE.kind(), qos::COLUMN_STATE.name)?;
    let mut shown = show(&format!(
        "watching {topic} in domain {}; stop with Ctrl-C",
        environment.domain_id
    ));
    let (sender, seen) = sync_channel(SHOWN_QUEUE);
    let events = node.participant_events();
    let task = Task::start("column_twin/see", move || async move {
        join!(events, sight.show(sender));
    })?;
    let mut lines = WatchLines::default();
    while !signals.asked() && shown.is_continue() {
        if let Some(seen) = next(&seen, Instant::now() + LOOK)
            && let Some(line) = lines.line(&seen, Instant::now())
        {
            shown = show(&line);
        }
    }
    task.stop();
    Ok(())
}

/// Publishes one event and hands over all that the twin says of it, until its report, or until the program is asked to stop.
/// `hear` is given each word with the time since the event was sent; `say` is told what is going on.
///
/// # Errors
/// When there is no twin, it refuses or fails, nothing but its status comes for `options.answer_timeout`, or the program is
/// asked to stop.
pub fn follow_impact(
    environment: &Environment,
    options: &ImpactOptions,
    say: &mut dyn FnMut(&str),
    hear: &mut dyn FnMut(&Seen, Duration),
) -> Result<(), ClientError> {
    let names = Names::new(&environment.namespace, "column_twin_demo", &[])?;
    let mut node = Node::new(environment, names)?;
    let sight = Sight {
        state: Some(node.subscription(&qos::COLUMN_STATE)?),
        forces: Some(node.subscription(&qos::HINGE_FORCES)?),
        forecast: Some(node.subscription(&qos::IMPACT_FORECAST)?),
        report: Some(node.subscription(&qos::IMPACT_REPORT)?),
        status: Some(node.subscription(&qos::TWIN_STATUS)?),
    };
    let ended = converse(node, environment, sight, options, say, &mut |word, sent| {
        hear(word, sent.ago);
        match (word, answer(word, sent.event_id, sent.refused_before)) {
            (Seen::Report(report), _) if report.event_id == sent.event_id => Heard::Last(Ok(())),
            (_, Some(ImpactOutcome::Refused(reason))) => {
                Heard::Last(Err(ClientError::Refused(reason)))
            }
            (Seen::Status(status), _) if status.phase == TwinStatus::FAULTED => {
                Heard::Last(Err(ClientError::Faulted(status.fault.clone())))
            }
            // It comes every second, whatever becomes of the impact.
            (Seen::Status(_), _) => Heard::Other,
            _ => Heard::Ours,
        }
    });
    ended?
}

/// The event that a client has sent.
struct Sent<'a> {
    event_id: &'a str,
    /// Refusals that the twin had counted before; `None` where it did not say.
    refused_before: Option<u64>,
    ago: Duration,
}

/// What a client makes of a word of the twin.
enum Heard<T> {
    /// It does not belong to what is waited for.
    Other,
    /// It does, and there is more to come.
    Ours,
    /// It ends the conversation.
    Last(T),
}

/// Waits until twin and client have found each other, sends the event, and hands over what is seen until it is the last word.
fn converse<T>(
    mut node: Node,
    environment: &Environment,
    sight: Sight,
    options: &ImpactOptions,
    say: &mut dyn FnMut(&str),
    hear: &mut dyn FnMut(&Seen, &Sent<'_>) -> Heard<T>,
) -> Result<T, ClientError> {
    let signals = StopSignals::listen()?;
    let publisher = node.publisher(&qos::IMPACT_EVENT)?;
    // What the twin says first is lost on a reader that it has not found yet.
    let mut endpoints = sight.guids();
    endpoints.push(publisher.guid());
    let (sender, seen) = sync_channel(SHOWN_QUEUE);
    let (events, matches) = (node.participant_events(), node.matches());
    let task = Task::start("column_twin/see", move || async move {
        join!(events, sight.show(sender));
    })?;
    let outcome = (|| {
        let topic = node
            .names()
            .resolve(qos::IMPACT_EVENT.kind(), qos::IMPACT_EVENT.name)?;
        say(&format!(
            "waiting for a twin on {topic} in domain {}",
            environment.domain_id
        ));
        wait_until(&signals, options.match_timeout, |until| {
            let found = |guid: &_| matches.wait_for(*guid, 1, until);
            endpoints.iter().all(found).then_some(())
        })?
        .ok_or(ClientError::NoTwin {
            topic,
            domain_id: environment.domain_id,
            waited: options.match_timeout,
        })?;
        // Its counter tells this refusal from one of the same event before.
        let refused_before = wait_until(&signals, STATUS_WAIT, |until| match next(&seen, until) {
            Some(Seen::Status(status)) => Some(status.events_refused),
            _ => None,
        })?;
        let event = event(options);
        let event_id = event.event_id.clone();
        say(&format!(
            "sending impact {event_id:?}: {} kg at {} m/s",
            event.mass, event.velocity
        ));
        let begun = Instant::now();
        publisher
            .publish(event)
            .map_err(|error| ClientError::NotSent(error.to_string()))?;
        let mut given_up = begun + options.answer_timeout;
        loop {
            let left = given_up.saturating_duration_since(Instant::now());
            let word = wait_until(&signals, left, |until| next(&seen, until))?;
            let Some(word) = word else {
                return Err(ClientError::NoAnswer {
                    event_id,
                    waited: options.answer_timeout,
                });
            };
            let sent = Sent {
                event_id: &event_id,
                refused_before,
                ago: begun.elapsed(),
            };
            match hear(&word, &sent) {
                Heard::Other => {}
                Heard::Ours => given_up = Instant::now() + options.answer_timeout,
                Heard::Last(outcome) => return Ok(outcome),
            }
        }
    })();
    task.stop();
    outcome
}

/// The subscriptions of a client.
#[derive(Default)]
struct Sight {
    state: Option<Subscription<ColumnState>>,
    forces: Option<Subscription<HingeForces>>,
    forecast: Option<Subscription<ImpactReport>>,
    report: Option<Subscription<ImpactReport>>,
    status: Option<Subscription<TwinStatus>>,
}

impl Sight {
    fn guids(&self) -> Vec<GUID> {
        [
            self.state.as_ref().map(Subscription::guid),
            self.forces.as_ref().map(Subscription::guid),
            self.forecast.as_ref().map(Subscription::guid),
            self.report.as_ref().map(Subscription::guid),
            self.status.as_ref().map(Subscription::guid),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Passes all messages on for ever.
    async fn show(self, to: SyncSender<Seen>) {
        join!(
            pass(&self.state, &to, Seen::State),
            pass(&self.forces, &to, Seen::Forces),
            pass(&self.forecast, &to, Seen::Forecast),
            pass(&self.report, &to, Seen::Report),
            pass(&self.status, &to, Seen::Status),
        );
    }
}

async fn pass<M: serde::de::DeserializeOwned + 'static>(
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
        // A line too many is one that nobody reads; one that cannot be read is not for this program to repair.
        if let Ok((message, _)) = message {
            let _ = to.try_send(seen(message));
        }
    }
}

fn next(seen: &Receiver<Seen>, until: Instant) -> Option<Seen> {
    let rest = until.saturating_duration_since(Instant::now());
    seen.recv_timeout(rest).ok()
}

/// Tries again and again, giving `attempt` a while each time; `None` after `timeout`.
fn wait_until<T>(
    signals: &StopSignals,
    timeout: Duration,
    mut attempt: impl FnMut(Instant) -> Option<T>,
) -> Result<Option<T>, ClientError> {
    let deadline = Instant::now() + timeout;
    while Instant::now() < deadline {
        if signals.asked() {
            return Err(ClientError::Interrupted);
        }
        if let Some(found) = attempt((Instant::now() + LOOK).min(deadline)) {
            return Ok(Some(found));
        }
    }
    Ok(None)
}

fn event(options: &ImpactOptions) -> ImpactEvent {
    let since = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    let stamp = i64::try_from(since.as_nanos()).unwrap_or(i64::MAX);
    let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN);
    ImpactEvent {
        header: Header {
            stamp: Time::from_nanos(stamp).unwrap_or_default(),
            frame_id: String::new(),
        },
        column_id: options.column_id.clone(),
        event_id: options
            .event_id
            .clone()
            .unwrap_or_else(|| format!("impact-{stamp}")),
        mass: options.mass,
        velocity: options.velocity,
        gap: or_nan(options.gap),
        restitution: or_nan(options.restitution),
        height: or_nan(options.height),
    }
}

/// What `seen` says of the event; `before` is the number of refusals before it was sent.
fn answer(seen: &Seen, event_id: &str, before: Option<u64>) -> Option<ImpactOutcome> {
    match seen {
        Seen::Forecast(report) if report.event_id == event_id => {
            Some(ImpactOutcome::Forecast(Box::new(report.clone())))
        }
        Seen::Status(status)
            if status.last_refusal_event_id == event_id
                && before.is_none_or(|before| status.events_refused > before) =>
        {
            Some(ImpactOutcome::Refused(status.last_refusal_reason.clone()))
        }
        _ => None,
    }
}

/// A status that tells of a refusal.
#[cfg(test)]
pub(super) fn refused(event_id: &str, count: u64) -> Seen {
    Seen::Status(TwinStatus {
        last_refusal_event_id: event_id.to_owned(),
        last_refusal_reason: "too fast".to_owned(),
        events_refused: count,
        ..TwinStatus::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_of_this_event_and_of_now() {
        let forecast = Seen::Forecast(ImpactReport {
            event_id: "a".to_owned(),
            ..ImpactReport::default()
        });
        assert!(answer(&forecast, "b", None).is_none());
        assert!(matches!(
            answer(&forecast, "a", None),
            Some(ImpactOutcome::Forecast(_))
        ));
        assert!(answer(&refused("a", 3), "a", Some(3)).is_none());
        assert_eq!(
            answer(&refused("a", 4), "a", Some(3)),
            Some(ImpactOutcome::Refused("too fast".to_owned()))
        );
    }

    #[test]
    fn what_is_left_open_is_nan_and_events_are_told_apart() {
        let options = ImpactOptions {
            column_id: "column".to_owned(),
            event_id: None,
            mass: 1500.0,
            velocity: 10.0,
            gap: None,
            restitution: Some(0.0),
            height: None,
            match_timeout: LOOK,
            answer_timeout: LOOK,
        };
        let event = event(&options);
        assert!(event.gap.is_nan() && event.height.is_nan() && event.restitution == 0.0);
        assert!(event.event_id.starts_with("impact-1"));
    }
}
