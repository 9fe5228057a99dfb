//! Terminal client of a fleet: sends a vehicle that hits several columns.

use std::collections::BTreeMap;
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use futures::join;

use crate::column::ImpactSpecification;
use crate::fleet::MAX_ROW_OFFSET;
use crate::messages::builtin_interfaces::Time;
use crate::messages::column_twin::{ImpactEvent, ImpactReport, RowImpactEvent};
use crate::messages::std_msgs::Header;

use super::client::ClientError;
use super::environment::Environment;
use super::lines::Seen;
use super::names::{Names, RemapRule};
use super::node::Node;
use super::qos;
use super::signals::StopSignals;
use super::subscribed::{SHOWN_QUEUE, next, pass, wait_until};
use super::task::Task;

/// A vehicle that hits several columns.
#[derive(Debug, Clone, PartialEq)]
pub struct RowImpactOptions {
    /// The columns, in their order.
    pub column_ids: Vec<String>,
    /// Time of each impact after the first one \[s\], NaN: with what the column before leaves of the vehicle; empty: all but the
    /// first one so.
    pub offsets: Vec<f64>,
    /// Distance of each column from the one before \[m\], where no offset is given.
    pub distances: Vec<f64>,
    /// Identifier of the event; `None`: a new one.
    pub event_id: Option<String>,
    /// Name of the vehicle; empty: that of the parameters of the columns.
    pub vehicle: String,
    /// With which mass and how fast it hits the first column; the parameters of the columns give what is left open.
    pub impact: ImpactSpecification,
    /// Timeout for finding a fleet.
    pub match_timeout: Duration,
    /// Timeout for each of its answers, after the time of the impact.
    pub answer_timeout: Duration,
}

/// Publishes an event for several columns and waits for the answer of each: a forecast, or a report without results that says why
/// there is none. They come in the order of the columns. `say` receives progress messages.
///
/// # Errors
/// No fleet is found, a column does not answer, or the program is asked to stop.
pub fn send_row_impact(
    environment: &Environment,
    rules: &[RemapRule],
    options: &RowImpactOptions,
    say: &mut dyn FnMut(&str),
) -> Result<Vec<ImpactReport>, ClientError> {
    let signals = StopSignals::listen()?;
    let names = Names::new(&environment.namespace, "column_twin_impact", rules)?;
    let mut node = Node::new(environment, names)?;
    let publisher = node.publisher(&qos::ROW_IMPACT_EVENT)?;
    let forecasts = Some(node.subscription::<ImpactReport>(&qos::IMPACT_FORECAST)?);
    let mut endpoints = vec![publisher.guid()];
    endpoints.extend(forecasts.as_ref().map(ros2_client::Subscription::guid));
    let (sender, seen) = sync_channel(SHOWN_QUEUE);
    let (events, matches) = (node.participant_events(), node.matches());
    let task = Task::start("column_twin/see", move || async move {
        join!(events, pass(&forecasts, &sender, Seen::Forecast));
    })?;
    let outcome = (|| {
        let topic = node
            .names()
            .resolve(qos::ROW_IMPACT_EVENT.kind(), qos::ROW_IMPACT_EVENT.name)?;
        say(&format!(
            "waiting for a fleet on {topic} in domain {}",
            environment.domain_id
        ));
        wait_until(&signals, options.match_timeout, |until| {
            let found = |guid: &_| matches.wait_for(*guid, 1, until);
            endpoints.iter().all(found).then_some(())
        })?
        .ok_or_else(|| ClientError::NoTwin {
            others: node.other_topics(&qos::ROW_IMPACT_EVENT, &topic),
            topic,
            domain_id: environment.domain_id,
            waited: options.match_timeout,
        })?;
        let event = event(options);
        let event_id = event.event_id.clone();
        let sent = event.header.stamp.to_nanos();
        say(&format!(
            "sending impact {event_id:?} to columns {}",
            options.column_ids.join(", ")
        ));
        publisher
            .publish(event)
            .map_err(|error| ClientError::NotSent(error.to_string()))?;
        let latest = options.offsets.iter().copied().fold(0.0, f64::max);
        let waited = options.answer_timeout + Duration::from_secs_f64(latest.min(MAX_ROW_OFFSET));
        let mut deadline = Instant::now() + waited;
        let mut answers = BTreeMap::new();
        let is_answered = |answers: &BTreeMap<String, ImpactReport>, column: &String| {
            answers.contains_key(&format!("{event_id}/{column}"))
        };
        while let Some(open) = options
            .column_ids
            .iter()
            .find(|it| !is_answered(&answers, it))
        {
            let left = deadline.saturating_duration_since(Instant::now());
            match wait_until(&signals, left, |until| next(&seen, until))? {
                Some(Seen::Forecast(report)) => {
                    let ids = &options.column_ids;
                    let is_own = ids
                        .iter()
                        .any(|it| report.event_id == format!("{event_id}/{it}"));
                    // A fleet keeps the answer to an earlier event that had this identifier and was rejected.
                    if is_own && report.header.stamp.to_nanos() >= sent {
                        // A second one has the error of the time step.
                        answers.entry(report.event_id.clone()).or_insert(report);
                        deadline = Instant::now() + waited;
                    }
                }
                Some(_) => {}
                None => {
                    return Err(ClientError::NoAnswer {
                        event_id: format!("{event_id}/{open}"),
                        waited,
                    });
                }
            }
        }
        let answers = options
            .column_ids
            .iter()
            .filter_map(|it| answers.remove(&format!("{event_id}/{it}")));
        Ok(answers.collect())
    })();
    task.stop();
    outcome
}

fn event(options: &RowImpactOptions) -> RowImpactEvent {
    let since = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    let stamp = i64::try_from(since.as_nanos()).unwrap_or(i64::MAX);
    let ImpactEvent {
        mass,
        velocity,
        gap,
        restitution,
        height,
        ..
    } = ImpactEvent::from(&options.impact);
    RowImpactEvent {
        header: Header {
            stamp: Time::from_nanos(stamp).unwrap_or_default(),
            frame_id: String::new(),
        },
        event_id: options
            .event_id
            .clone()
            .unwrap_or_else(|| format!("impact-{stamp}")),
        vehicle: options.vehicle.clone(),
        mass,
        velocity,
        gap,
        restitution,
        height,
        column_ids: options.column_ids.clone(),
        offsets: options.offsets.clone(),
        distances: options.distances.clone(),
    }
}
