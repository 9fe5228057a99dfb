//! Terminal client of a fleet: sends a vehicle that hits several columns.

use std::collections::BTreeMap;
use std::sync::mpsc::sync_channel;
use std::time::{Duration, Instant};

use futures::join;

use crate::fleet::MAX_ROW_OFFSET;
use crate::messages::column_twin_msgs::{ImpactEvent, ImpactReport, RowImpactEvent};

use super::client::ImpactRequest;
use super::client_error::ClientError;
use super::lines::Seen;
use super::node::Node;
use super::qos;
use super::subscribed::{SHOWN_QUEUE, Search, next, pass, wait_until};
use super::task::Task;
use super::transport::Subscription;
use ros_node::environment::Environment;
use ros_node::names::{Names, RemapRule};
use ros_node::signals::StopSignals;

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
    /// The impact on the first column.
    pub request: ImpactRequest,
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
    endpoints.extend(forecasts.as_ref().map(Subscription::guid));
    let (sender, seen) = sync_channel(SHOWN_QUEUE);
    let events = node.participant_events();
    let task = Task::start("column_twin/see", move || async move {
        join!(
            events,
            pass(&forecasts, &qos::IMPACT_FORECAST, &sender, Seen::Forecast)
        );
    })?;
    let outcome = (|| {
        let search = Search {
            node: &node,
            environment,
            signals: &signals,
            endpoint: &qos::ROW_IMPACT_EVENT,
            timeout: options.request.match_timeout,
        };
        search.wait_for("a fleet", &endpoints, say)?;
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
        let waited =
            options.request.answer_timeout + Duration::from_secs_f64(latest.min(MAX_ROW_OFFSET));
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
    let ImpactEvent {
        header,
        event_id,
        vehicle,
        mass,
        velocity,
        gap,
        restitution,
        height,
        direction,
        column_id: _,
    } = options.request.event(String::new());
    RowImpactEvent {
        header,
        event_id,
        vehicle,
        mass,
        velocity,
        gap,
        restitution,
        height,
        direction,
        column_ids: options.column_ids.clone(),
        offsets: options.offsets.clone(),
        distances: options.distances.clone(),
    }
}
