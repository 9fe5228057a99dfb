//! Terminal client of the twin: sends an impact or shows what the twin publishes, without a ROS installation.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use futures::join;

use crate::column::ImpactSpecification;
use crate::messages::builtin_interfaces::Time;
use crate::messages::column_twin_msgs::{
    ColumnStatus, FleetStatus, ImpactEvent, ImpactReport, TwinStatus,
};
use crate::messages::std_msgs::Header;
use crate::parameters::readable;

use super::client_error::{ClientError, STATUS_WAIT};
use super::dds_threads::DdsThreads;
use super::fleet_view::FleetView;
use super::lines::{Seen, WatchLines};
use super::node::Node;
use super::qos;
use super::subscribed::{CHECK_INTERVAL, SHOWN_QUEUE, Search, Subscribed, later, next, wait_until};
use super::task::Task;
use super::transport::Subscription;
use ros_node::environment::Environment;
use ros_node::names::{Names, RemapRule};
use ros_node::signals::StopSignals;

/// The twins are found one after another. Only if no further one was found for this time is the only one the one that is there.
const SETTLED: Duration = Duration::from_millis(300);

/// An impact to send to one column.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpactOptions {
    /// The column; `None`: that of the only twin.
    pub column_id: Option<String>,
    /// The impact.
    pub request: ImpactRequest,
}

/// What a client says of an impact, whichever columns are hit.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpactRequest {
    /// Identifier of the event; `None`: a new one.
    pub event_id: Option<String>,
    /// Name of the vehicle; empty: that of the twin's parameters.
    pub vehicle: String,
    /// With which mass and how fast it hits the column; the twin's parameters give what is left open.
    pub impact: ImpactSpecification,
    /// Timeout for finding a twin.
    pub match_timeout: Duration,
    /// Timeout for its forecast, and for that of each column if there are several, after the time of the impact.
    pub answer_timeout: Duration,
}

impl ImpactRequest {
    /// The event that is sent now.
    pub(super) fn event(&self, column_id: String) -> ImpactEvent {
        let since = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        let stamp = i64::try_from(since.as_nanos()).unwrap_or(i64::MAX);
        let event_id = self.event_id.clone();
        ImpactEvent {
            header: Header {
                stamp: Time::from_nanos(stamp).unwrap_or_default(),
                frame_id: String::new(),
            },
            column_id,
            event_id: event_id.unwrap_or_else(|| format!("impact-{stamp}")),
            vehicle: self.vehicle.clone(),
            ..ImpactEvent::from(&self.impact)
        }
    }
}

/// The twin's reply to an impact.
#[derive(Debug, Clone, PartialEq)]
pub enum ImpactOutcome {
    /// It was accepted, and this is the forecast.
    Forecast(Box<ImpactReport>),
    /// It was accepted, but there is no forecast for this reason.
    NoForecast(String),
    /// It was rejected for this reason.
    Rejected(String),
}

/// What is shown of a twin or a fleet.
#[derive(Debug)]
pub enum Shown<'a> {
    /// A line about one column.
    Line(&'a str),
    /// The columns of a fleet, after a message about some of them.
    Fleet {
        /// The message.
        status: &'a FleetStatus,
        /// All columns that are known, in the order of their names.
        columns: &'a [ColumnStatus],
        /// Nothing has come for a moment since the message, which was shown before.
        is_settled: bool,
    },
}

/// Publishes an event and waits for the twin's reply; `say` receives progress messages.
///
/// # Errors
/// No twin is found, there is no reply, or the program is asked to stop.
pub fn send_impact(
    environment: &Environment,
    rules: &[RemapRule],
    options: &ImpactOptions,
    say: &mut dyn FnMut(&str),
) -> Result<ImpactOutcome, ClientError> {
    let signals = StopSignals::listen()?;
    let names = Names::new(&environment.namespace, "column_twin_impact", rules)?;
    let mut node = Node::new(environment, names)?;
    let subscribed = Subscribed {
        forecast: Some(node.subscription(&qos::IMPACT_FORECAST)?),
        status: Some(node.subscription(&qos::TWIN_STATUS)?),
        fleet: later(&mut node, &qos::FLEET_STATUS)?,
        ..Subscribed::default()
    };
    converse(
        node,
        environment,
        subscribed,
        (options, &signals),
        say,
        &mut answer,
    )
}

/// Shows states, forecasts, reports and rejections, one line each, and the columns of a fleet, until the program is asked to stop
/// or `show` returns `Break`.
///
/// # Errors
/// The node cannot be created, or a thread of the DDS library panics.
pub fn watch(
    environment: &Environment,
    rules: &[RemapRule],
    show: &mut dyn FnMut(Shown<'_>) -> ControlFlow<()>,
) -> Result<(), ClientError> {
    let signals = StopSignals::listen()?;
    let dds_threads = DdsThreads::stop_on_panic();
    let names = Names::new(&environment.namespace, "column_twin_watch", rules)?;
    let mut node = Node::new(environment, names)?;
    let subscribed = Subscribed {
        state: Some(node.subscription(&qos::COLUMN_STATE)?),
        forecast: Some(node.subscription(&qos::IMPACT_FORECAST)?),
        report: Some(node.subscription(&qos::IMPACT_REPORT)?),
        status: Some(node.subscription(&qos::TWIN_STATUS)?),
        estimate: later(&mut node, &qos::IMPACT_ESTIMATE)?,
        fleet: later(&mut node, &qos::FLEET_STATUS)?,
        ..Subscribed::default()
    };
    let topic = node
        .names()
        .resolve(qos::COLUMN_STATE.kind(), qos::COLUMN_STATE.name)?;
    let mut shown = show(Shown::Line(&format!(
        "watching {topic} in domain {}; stop with Ctrl-C",
        environment.domain_id
    )));
    let (sender, seen) = sync_channel(SHOWN_QUEUE);
    let events = node.participant_events();
    let task = Task::start("column_twin/see", move || async move {
        join!(events, subscribed.show(sender));
    })?;
    let mut lines = WatchLines::default();
    let peers = node.matches().lost_peers();
    let (mut losses, mut returns) = (0, 0);
    let mut fleet: Option<FleetView> = None;
    // The last message of a fleet, until no other one has come for a moment.
    let mut last = None;
    while !signals.asked() && shown.is_continue() {
        let mut seen = match next(&seen, Instant::now() + CHECK_INTERVAL) {
            Some(Seen::Fleet(status)) => {
                let columns = fleet.get_or_insert_default().take(&status);
                shown = show(Shown::Fleet {
                    status: &status,
                    columns: &columns,
                    is_settled: false,
                });
                last = Some((status, columns));
                continue;
            }
            seen => seen,
        };
        if seen.is_none()
            && let Some((status, columns)) = last.take()
        {
            shown = show(Shown::Fleet {
                status: &status,
                columns: &columns,
                is_settled: true,
            });
        }
        // The columns of a fleet are shown together.
        if fleet.is_some() {
            seen = seen.filter(|it| !matches!(it, Seen::State(_) | Seen::Status(_)));
        }
        let mut said = Vec::new();
        let grown = |before: &mut u64, now: u64| std::mem::replace(before, now) < now;
        if grown(&mut losses, peers.losses()) {
            said.push(
                "a twin has fallen silent: check its machine and the network; its messages in the meantime are missing here"
                    .to_owned(),
            );
        }
        if grown(&mut returns, peers.returns()) {
            said.push("the twin that had fallen silent is heard again".to_owned());
        }
        said.extend(lines.lines(seen, Instant::now()));
        for line in said {
            shown = show(Shown::Line(&line));
            if shown.is_break() {
                break;
            }
        }
    }
    task.stop();
    match dds_threads.has_panicked() {
        true => Err(ClientError::Deaf),
        false => Ok(()),
    }
}

/// Publishes an event and passes on all messages of the twin until the report of the response. `hear` receives each message
/// with the time since the event was sent; `say` receives progress messages.
///
/// # Errors
/// No twin is found, it rejects the event or is faulted, only its status arrives within `answer_timeout`, or the
/// program is asked to stop by `signals`.
pub fn follow_impact(
    environment: &Environment,
    options: &ImpactOptions,
    signals: &StopSignals,
    say: &mut dyn FnMut(&str),
    hear: &mut dyn FnMut(&Seen, Duration),
) -> Result<(), ClientError> {
    let names = Names::new(&environment.namespace, "column_twin_demo", &[])?;
    let mut node = Node::new(environment, names)?;
    let subscribed = Subscribed {
        state: Some(node.subscription(&qos::COLUMN_STATE)?),
        forces: Some(node.subscription(&qos::HINGE_FORCES)?),
        forecast: Some(node.subscription(&qos::IMPACT_FORECAST)?),
        report: Some(node.subscription(&qos::IMPACT_REPORT)?),
        status: Some(node.subscription(&qos::TWIN_STATUS)?),
        ..Subscribed::default()
    };
    let ended = converse(
        node,
        environment,
        subscribed,
        (options, signals),
        say,
        &mut |word, sent| {
            hear(word, sent.ago);
            match (word, answer(word, sent)) {
                (Seen::Report(report), _) if report.event_id == sent.event_id => {
                    Relation::Last(Ok(()))
                }
                (_, Relation::Last(ImpactOutcome::Rejected(reason))) => {
                    Relation::Last(Err(ClientError::Rejected(reason)))
                }
                (_, Relation::LastUnlessFollowed(ImpactOutcome::Rejected(reason))) => {
                    Relation::LastUnlessFollowed(Err(ClientError::Rejected(reason)))
                }
                (Seen::Status(status), _) if status.phase == TwinStatus::FAULTED => {
                    Relation::Last(Err(ClientError::Faulted(status.fault.clone())))
                }
                // A status arrives every second, whether or not the impact is handled.
                (Seen::Status(_) | Seen::Missed { .. }, _) => Relation::None,
                _ => Relation::OfEvent,
            }
        },
    );
    ended?
}

/// An event that the client has sent.
struct Sent<'a> {
    event_id: &'a str,
    /// The column that it is for: every other twin on the topic rejects the event.
    column_id: &'a str,
    /// Whether the twin of that column is known to be there.
    is_known: bool,
    /// Number of rejections before the event; `None` if unknown.
    rejected_before: Option<u64>,
    ago: Duration,
}

/// How a message of the twin relates to the event that was sent.
#[derive(Debug, PartialEq)]
enum Relation<T> {
    /// It is unrelated.
    None,
    /// It belongs to the event, and more messages will follow.
    OfEvent,
    /// It is the last message that the client waits for.
    Last(T),
    /// The same, unless another message of the event follows soon.
    LastUnlessFollowed(T),
}

/// Waits until twin and client are matched, sends the event, and passes on messages until the last one.
fn converse<T>(
    mut node: Node,
    environment: &Environment,
    subscribed: Subscribed,
    (options, signals): (&ImpactOptions, &StopSignals),
    say: &mut dyn FnMut(&str),
    hear: &mut dyn FnMut(&Seen, &Sent<'_>) -> Relation<T>,
) -> Result<T, ClientError> {
    let publisher = node.publisher(&qos::IMPACT_EVENT)?;
    let mut endpoints = subscribed.guids();
    endpoints.push(publisher.guid());
    let status = subscribed.status.as_ref().map(Subscription::guid);
    let fleet = subscribed.fleet.as_ref().map(Subscription::guid);
    let (sender, seen) = sync_channel(SHOWN_QUEUE);
    let (events, matches) = (node.participant_events(), node.matches());
    let task = Task::start("column_twin/see", move || async move {
        join!(events, subscribed.show(sender));
    })?;
    let outcome = (|| {
        let search = Search {
            node: &node,
            environment,
            signals,
            endpoint: &qos::IMPACT_EVENT,
            timeout: options.request.match_timeout,
        };
        search.wait_for("a twin", &endpoints, say)?;
        // The counter distinguishes a rejection of this event from one of an earlier event with the same identifier.
        let mut rejected_before = None;
        let mut columns = BTreeSet::new();
        let (mut twins, mut changed) = (0, Instant::now());
        wait_until(signals, STATUS_WAIT, |until| {
            match next(&seen, until) {
                Some(Seen::Fleet(status)) => {
                    let is_of_all = status.columns.len() as u64 >= u64::from(status.columns_total);
                    columns.extend(status.columns.into_iter().map(|it| it.column_id));
                    return (options.column_id.is_none() && (is_of_all || columns.len() > 1))
                        .then_some(());
                }
                Some(Seen::Status(status)) => {
                    if options.column_id.as_ref() == Some(&status.column_id) {
                        rejected_before = Some(status.events_rejected);
                    } else {
                        rejected_before.get_or_insert(status.events_rejected);
                    }
                    columns.insert(status.column_id);
                }
                _ => {}
            }
            let found = status.map_or(0, |status| matches.count(status));
            if std::mem::replace(&mut twins, found) != found {
                changed = Instant::now();
            }
            let is_known = match &options.column_id {
                Some(wanted) => columns.contains(wanted),
                // One node of a fleet has many columns, which its own status names.
                None => {
                    let has_fleet = fleet.is_some_and(|fleet| matches.count(fleet) > 0);
                    !has_fleet && columns.len() >= twins && changed.elapsed() >= SETTLED
                }
            };
            is_known.then_some(())
        })?;
        let column_id = match &options.column_id {
            Some(column_id) => column_id.clone(),
            None => only(&columns)?,
        };
        // What is sent before the column's twin is known as a reader never reaches it.
        let of_twins: Vec<_> = status.into_iter().chain(fleet).collect();
        wait_until(signals, STATUS_WAIT, |until| {
            matches
                .wait_for_participants_of(publisher.guid(), &of_twins, until)
                .then_some(())
        })?;
        let is_known = columns.contains(&column_id);
        let event = options.request.event(column_id.clone());
        let event_id = event.event_id.clone();
        say(&format!(
            "sending impact {event_id:?} to column {:?}: {} at {} m/s",
            event.column_id,
            what_strikes(&event),
            readable(event.velocity)
        ));
        let begun = Instant::now();
        publisher
            .publish(event)
            .map_err(|error| ClientError::NotSent(error.to_string()))?;
        let mut deadline = begun + options.request.answer_timeout;
        let mut last = None;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let word = wait_until(signals, left, |until| next(&seen, until))?;
            let Some(word) = word else {
                return last.ok_or(ClientError::NoAnswer {
                    event_id,
                    waited: options.request.answer_timeout,
                });
            };
            let sent = Sent {
                event_id: &event_id,
                column_id: &column_id,
                is_known,
                rejected_before,
                ago: begun.elapsed(),
            };
            match hear(&word, &sent) {
                Relation::None => {}
                Relation::OfEvent => deadline = Instant::now() + options.request.answer_timeout,
                Relation::LastUnlessFollowed(outcome) => {
                    last.get_or_insert(outcome);
                    deadline = deadline.min(Instant::now() + STATUS_WAIT);
                }
                Relation::Last(outcome) => return Ok(outcome),
            }
        }
    })();
    task.stop();
    outcome
}

/// The only column.
fn only(columns: &BTreeSet<String>) -> Result<String, ClientError> {
    let mut found = columns.iter();
    match (found.next(), found.next()) {
        (None, _) => Err(ClientError::NoColumn),
        (Some(column), None) => Ok(column.clone()),
        _ => Err(ClientError::SeveralColumns(
            columns.iter().cloned().collect(),
        )),
    }
}

/// How a message answers the event. A twin of another column rejects it; that counts only if the twin of its column, which was not found
/// before the event was sent, says nothing.
fn answer(seen: &Seen, sent: &Sent<'_>) -> Relation<ImpactOutcome> {
    match seen {
        Seen::Forecast(report) if report.event_id == sent.event_id => {
            Relation::Last(match report.kind {
                ImpactReport::NO_FORECAST | ImpactReport::WITHDRAWN => {
                    ImpactOutcome::NoForecast(report.action_reason.clone())
                }
                _ => ImpactOutcome::Forecast(Box::new(report.clone())),
            })
        }
        Seen::Status(status)
            if status.last_rejection_event_id == sent.event_id
                && sent
                    .rejected_before
                    .is_none_or(|before| status.events_rejected > before) =>
        {
            let rejected = ImpactOutcome::Rejected(status.last_rejection_reason.clone());
            match status.column_id == sent.column_id {
                true => Relation::Last(rejected),
                false if sent.is_known => Relation::None,
                false => Relation::LastUnlessFollowed(rejected),
            }
        }
        _ => Relation::None,
    }
}

/// The vehicle and the mass of an event in words, as far as the event tells them.
fn what_strikes(event: &ImpactEvent) -> String {
    let mass = (event.mass > 0.0).then(|| format!("{} kg", readable(event.mass)));
    match (event.vehicle.as_str(), mass) {
        ("", Some(mass)) => mass,
        ("", None) => "the vehicle of the parameters".to_owned(),
        (vehicle, Some(mass)) => format!("{vehicle} of {mass}"),
        (vehicle, None) => vehicle.to_owned(),
    }
}

/// A status with a rejection.
#[cfg(test)]
pub(super) fn rejected(event_id: &str, count: u64) -> Seen {
    Seen::Status(TwinStatus {
        last_rejection_event_id: event_id.to_owned(),
        last_rejection_reason: "too fast".to_owned(),
        events_rejected: count,
        ..TwinStatus::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_belongs_to_this_event() {
        let sent = |event_id, rejected_before| Sent {
            event_id,
            column_id: "",
            is_known: true,
            rejected_before,
            ago: Duration::ZERO,
        };
        let forecast = Seen::Forecast(ImpactReport {
            event_id: "a".to_owned(),
            ..ImpactReport::default()
        });
        assert_eq!(answer(&forecast, &sent("b", None)), Relation::None);
        assert!(matches!(
            answer(&forecast, &sent("a", None)),
            Relation::Last(ImpactOutcome::Forecast(_))
        ));
        let none = Seen::Forecast(ImpactReport {
            event_id: "a".to_owned(),
            kind: ImpactReport::NO_FORECAST,
            action_reason: "superseded".to_owned(),
            ..ImpactReport::default()
        });
        assert_eq!(
            answer(&none, &sent("a", None)),
            Relation::Last(ImpactOutcome::NoForecast("superseded".to_owned()))
        );
        assert_eq!(
            answer(&rejected("a", 3), &sent("a", Some(3))),
            Relation::None
        );
        let too_fast = ImpactOutcome::Rejected("too fast".to_owned());
        assert_eq!(
            answer(&rejected("a", 4), &sent("a", Some(3))),
            Relation::Last(too_fast.clone())
        );
        // A twin of another column on the same topic rejects the event.
        let for_a3 = |is_known| Sent {
            column_id: "a3",
            is_known,
            ..sent("a", Some(3))
        };
        assert_eq!(answer(&rejected("a", 4), &for_a3(true)), Relation::None);
        assert_eq!(
            answer(&rejected("a", 4), &for_a3(false)),
            Relation::LastUnlessFollowed(too_fast)
        );
    }

    #[test]
    fn the_only_column_is_found_and_several_are_listed() {
        let of = |columns: &[&str]| only(&columns.iter().map(|it| (*it).to_owned()).collect());
        assert!(of(&["a3"]).is_ok_and(|column| column == "a3"));
        let none = of(&[]).expect_err("no column").to_string();
        assert!(none.contains("name it with --column"), "{none}");
        let several = of(&["b", "a\u{202e}"])
            .expect_err("two columns")
            .to_string();
        assert_eq!(
            several,
            r#"there are twins of several columns: "a\u{202e}", "b"; choose one with --column"#
        );
    }

    #[test]
    fn omitted_values_are_nan_and_identifiers_differ() {
        let options = ImpactOptions {
            column_id: None,
            request: ImpactRequest {
                event_id: None,
                vehicle: "mid_car".to_owned(),
                impact: ImpactSpecification {
                    mass: 1500.0,
                    velocity: 10.0,
                    gap: None,
                    restitution: Some(0.0),
                    height: None,
                    direction: None,
                },
                match_timeout: CHECK_INTERVAL,
                answer_timeout: CHECK_INTERVAL,
            },
        };
        let event = options.request.event("column".to_owned());
        assert!(event.gap.is_nan() && event.height.is_nan() && event.restitution == 0.0);
        assert!(event.event_id.starts_with("impact-1"));
        assert_eq!(event.vehicle, "mid_car");
    }
}
