//! What comes in over DDS: events, sets of parameters, the clock, and requests.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use futures::{StreamExt, join, pin_mut};
use ros2_client::rcl_interfaces as rcl;
use ros2_client::{MessageInfo, Server, Subscription};

use crate::messages::builtin_interfaces::Time;
use crate::messages::cdr;
use crate::messages::column_twin::{
    ColumnParameters, ImpactEvent, ParameterEntry, PredictImpactRequest, PredictImpactResponse,
};
use crate::messages::rosgraph_msgs::Clock;
use crate::messages::std_msgs::Header;
use crate::messages::std_srvs::{TriggerRequest, TriggerResponse};
use crate::parameters::{Parameters, Value};

use super::bridge::{NotChanged, ParameterChange, Recording, Twin};
use super::diagnostics::NodeCounters;
use super::missed::Missed;
use super::node::{Node, NodeError};
use super::parameter_services as parameters;
use super::qos::{self, Endpoint};

impl ros2_client::Message for TriggerRequest {}
impl ros2_client::Message for TriggerResponse {}
impl ros2_client::Message for PredictImpactRequest {}
impl ros2_client::Message for PredictImpactResponse {}

/// What the twin must hear of without delay.
pub(super) struct Subscriptions {
    events: Subscription<ImpactEvent>,
    clock: Option<Subscription<Clock>>,
    recording: Option<Arc<dyn Recording>>,
}

impl Subscriptions {
    /// Subscribes; the clock only where the parameters say `use_sim_time`.
    pub fn new(
        node: &mut Node,
        parameters: &Parameters,
        recording: Option<Arc<dyn Recording>>,
    ) -> Result<Self, NodeError> {
        let simulated = parameters.settings().use_sim_time;
        Ok(Self {
            events: node.subscription(&qos::IMPACT_EVENT)?,
            clock: simulated
                .then(|| node.subscription(&qos::CLOCK))
                .transpose()?,
            recording,
        })
    }

    /// Passes messages on for ever.
    pub async fn run(self, twin: Arc<dyn Twin>, counters: Arc<NodeCounters>) {
        let events = each(
            &self.events,
            &qos::IMPACT_EVENT,
            &counters,
            |event: ImpactEvent, info| {
                record(&self.recording, &qos::IMPACT_EVENT, &event, &info);
                let event_id = event.event_id.clone();
                if let Err(reason) = twin.submit_impact(event) {
                    tracing::warn!("impact event {event_id:?} is refused: {reason}");
                    if let Some(recording) = &self.recording {
                        recording.not_taken(&qos::IMPACT_EVENT, &event_id, &reason);
                    }
                }
            },
        );
        let clock = async {
            if let Some(clock) = &self.clock {
                each(
                    clock,
                    &qos::CLOCK,
                    &counters,
                    |message: Clock, _| match message.clock.to_nanos() {
                        Some(now) => twin.set_clock(now),
                        None => NodeCounters::count(&counters.unreadable),
                    },
                )
                .await;
            }
        };
        join!(events, clock);
    }
}

/// Hands every message to `take`. What cannot be read, or was lost before, is counted and said.
async fn each<M: serde::de::DeserializeOwned + 'static>(
    subscription: &Subscription<M>,
    endpoint: &Endpoint,
    counters: &NodeCounters,
    mut take: impl FnMut(M, MessageInfo),
) {
    let name = endpoint.name;
    let messages = subscription.async_stream();
    pin_mut!(messages);
    let mut missed = Missed::default();
    while let Some(message) = messages.next().await {
        match message {
            Ok((message, info)) => {
                let lost = missed.before(&info);
                if lost > 0 && endpoint.qos.reliable {
                    counters.missed.fetch_add(lost, Ordering::Relaxed);
                    tracing::error!(
                        "{lost} messages on {name} were lost: they came faster than they could be taken"
                    );
                }
                take(message, info);
            }
            Err(error) => {
                missed.unreadable();
                NodeCounters::count(&counters.unreadable);
                tracing::warn!(
                    "a message on {name} cannot be read: {error}; compare its sender's type"
                );
            }
        }
    }
}

/// Records what was received, in the one encoding that this program writes.
fn record<M: crate::messages::Message>(
    recording: &Option<Arc<dyn Recording>>,
    endpoint: &Endpoint,
    message: &M,
    info: &MessageInfo,
) {
    let Some(recording) = recording else {
        return;
    };
    match cdr::encode(message) {
        Ok(bytes) => {
            let source = info.source_timestamp().map(|stamp| stamp.to_nanos());
            recording.received(endpoint, bytes, source);
        }
        Err(error) => recording.not_taken(endpoint, "a message", &error.to_string()),
    }
}

/// What is answered, and may take a while to answer: a thread of its own.
pub(super) struct Services {
    column_parameters: Subscription<ColumnParameters>,
    reset: Server<TriggerRequest, TriggerResponse>,
    predict: Server<PredictImpactRequest, PredictImpactResponse>,
    parameters: ParameterServers,
    recording: Option<Arc<dyn Recording>>,
}

struct ParameterServers {
    get: Server<rcl::GetParametersRequest, rcl::GetParametersResponse>,
    types: Server<rcl::GetParameterTypesRequest, rcl::GetParameterTypesResponse>,
    list: Server<rcl::ListParametersRequest, rcl::ListParametersResponse>,
    describe: Server<rcl::DescribeParametersRequest, rcl::DescribeParametersResponse>,
    set: Server<rcl::SetParametersRequest, rcl::SetParametersResponse>,
    set_atomically: Server<rcl::SetParametersRequest, rcl::SetParametersAtomicallyResponse>,
}

impl Services {
    /// Offers all services.
    pub fn new(node: &mut Node, recording: Option<Arc<dyn Recording>>) -> Result<Self, NodeError> {
        Ok(Self {
            column_parameters: node.subscription(&qos::COLUMN_PARAMETERS)?,
            reset: node.server(&qos::RESET)?,
            predict: node.server(&qos::PREDICT)?,
            parameters: ParameterServers {
                get: node.server(&qos::GET_PARAMETERS)?,
                types: node.server(&qos::GET_PARAMETER_TYPES)?,
                list: node.server(&qos::LIST_PARAMETERS)?,
                describe: node.server(&qos::DESCRIBE_PARAMETERS)?,
                set: node.server(&qos::SET_PARAMETERS)?,
                set_atomically: node.server(&qos::SET_PARAMETERS_ATOMICALLY)?,
            },
            recording,
        })
    }

    /// Answers for ever.
    pub async fn run(self, twin: Arc<dyn Twin>, counters: Arc<NodeCounters>) {
        let ParameterServers {
            get,
            types,
            list,
            describe,
            set,
            set_atomically,
        } = self.parameters;
        let recording = self.recording;
        let (twin, counters) = (&*twin, &*counters);
        join!(
            each(
                &self.column_parameters,
                &qos::COLUMN_PARAMETERS,
                counters,
                |message, info| {
                    record(&recording, &qos::COLUMN_PARAMETERS, &message, &info);
                    if let Err(NotChanged {
                        reason,
                        is_in_journal: false,
                    }) = set_column(twin, &message)
                        && let Some(recording) = &recording
                    {
                        recording.not_taken(
                            &qos::COLUMN_PARAMETERS,
                            "a set of parameters",
                            &reason,
                        );
                    }
                }
            ),
            answer(&qos::RESET, &self.reset, counters, |_| trigger(
                twin.reset()
            )),
            answer(&qos::PREDICT, &self.predict, counters, |request| predicted(
                twin, &request
            )),
            answer(&qos::GET_PARAMETERS, &get, counters, |request| {
                parameters::get(&twin.parameters(), &request)
            }),
            answer(&qos::GET_PARAMETER_TYPES, &types, counters, |request| {
                parameters::types(&request)
            }),
            answer(&qos::LIST_PARAMETERS, &list, counters, |request| {
                parameters::list(&request)
            }),
            answer(&qos::DESCRIBE_PARAMETERS, &describe, counters, |request| {
                parameters::describe(&request)
            }),
            answer(&qos::SET_PARAMETERS, &set, counters, |request| {
                parameters::set(twin, request)
            }),
            answer(
                &qos::SET_PARAMETERS_ATOMICALLY,
                &set_atomically,
                counters,
                |request| { parameters::set_atomically(twin, request) }
            ),
        );
    }
}

/// Answers every request with what `reply` makes of it.
async fn answer<Request, Response>(
    endpoint: &Endpoint,
    server: &Server<Request, Response>,
    counters: &NodeCounters,
    mut reply: impl FnMut(Request) -> Response,
) where
    Request: ros2_client::Message + Clone + 'static,
    Response: ros2_client::Message + 'static,
{
    let mut requests = server.receive_request_stream();
    while let Some(request) = requests.next().await {
        match request {
            Ok((id, request)) => {
                if let Err(error) = server.async_send_response(id, reply(request)).await {
                    NodeCounters::count(&counters.unpublished);
                    tracing::warn!("a reply of {} cannot be sent: {error:?}", endpoint.name);
                }
            }
            Err(error) => {
                NodeCounters::count(&counters.unreadable);
                tracing::warn!(
                    "a request to {} cannot be read: {error}; compare its sender's type",
                    endpoint.name
                );
            }
        }
    }
}

fn trigger(outcome: Result<String, String>) -> TriggerResponse {
    TriggerResponse {
        success: outcome.is_ok(),
        message: outcome.unwrap_or_else(|reason| reason),
    }
}

fn predicted(twin: &dyn Twin, request: &PredictImpactRequest) -> PredictImpactResponse {
    let parameters = twin.parameters();
    let settings = parameters.settings();
    match twin.predict(request) {
        Ok(mut report) => {
            report.header = Header {
                stamp: Time::from_nanos(twin.now()).unwrap_or_default(),
                frame_id: settings.frame_id.clone(),
            };
            report.column_id.clone_from(&settings.column_id);
            report.event_id.clone_from(&request.event_id);
            report.kind = crate::messages::column_twin::ImpactReport::PREDICTION;
            PredictImpactResponse {
                success: true,
                message: String::new(),
                report,
            }
        }
        Err(message) => PredictImpactResponse {
            success: false,
            message,
            ..PredictImpactResponse::default()
        },
    }
}

fn set_column(twin: &dyn Twin, message: &ColumnParameters) -> Result<(), NotChanged> {
    let change = ParameterChange {
        column_id: Some(message.column_id.clone()),
        values: changes(message),
        source: qos::COLUMN_PARAMETERS.name,
    };
    // A refusal has been said already: a topic has nobody to answer to.
    twin.set_parameters(change)?;
    tracing::info!(
        "the parameters of {} are taken over",
        qos::COLUMN_PARAMETERS.name
    );
    Ok(())
}

/// What the message does not leave as it is.
fn changes(message: &ColumnParameters) -> Vec<(String, Value)> {
    message
        .entries()
        .filter(|(_, entry)| !entry.leaves_as_is())
        .map(|(name, entry)| {
            let value = match entry {
                ParameterEntry::Number(number) => Value::Double(number),
                ParameterEntry::Text(text) => Value::from(text),
            };
            (name.to_owned(), value)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_the_message_says_is_changed() {
        let message = ColumnParameters {
            top_load: 2e5,
            section_name: "HEB300".to_owned(),
            impact_gap: f64::INFINITY,
            ..ColumnParameters::default()
        };
        let expected = [
            ("section.name", Value::from("HEB300")),
            ("top.load", Value::Double(2e5)),
            ("impact.gap", Value::Double(f64::INFINITY)),
        ];
        assert_eq!(
            changes(&message),
            expected.map(|(name, value)| (name.to_owned(), value))
        );
    }
}
