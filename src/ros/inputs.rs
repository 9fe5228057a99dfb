//! The inputs over DDS: impact events, parameters, the clock, and service requests.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use futures::{StreamExt, join, pin_mut};
use ros2_client::rcl_interfaces as rcl;
use ros2_client::{Gid, MessageInfo, Server, Subscription};

use crate::incoming::{column_command, impact_command, nanos};
use crate::messages::builtin_interfaces::Time;
use crate::messages::cdr;
use crate::messages::column_twin_msgs::{
    CalibrateRequest, CalibrateResponse, ColumnParameters, ConfirmEstimateRequest,
    ConfirmEstimateResponse, ImpactEvent, ImpactReport, PredictImpactRequest,
    PredictImpactResponse,
};
use crate::messages::rosgraph_msgs::Clock;
use crate::messages::std_msgs::Header;
use crate::messages::std_srvs::{TriggerRequest, TriggerResponse};
use crate::messages::words::mass_in_words;
use crate::outgoing::RecordingTap;
use crate::parameters::Parameters;
use crate::twin::{Accepted, Command, Refusal};

use super::diagnostics::NodeCounters;
use super::guid_prefix::GuidPrefix;
use super::live_twin::LiveTwin;
use super::measurements::{MeasurementSubscriptions, SensorInputs};
use super::missed::Missed;
use super::node::{Node, NodeError};
use super::parameter_services as parameters;
use super::qos::{self, Endpoint};
use super::requests;
use super::senders::{Rejected, Senders};
use super::type_descriptions::{self, GetTypeDescriptionRequest, GetTypeDescriptionResponse};

impl ros2_client::Message for TriggerRequest {}
impl ros2_client::Message for TriggerResponse {}
impl ros2_client::Message for PredictImpactRequest {}
impl ros2_client::Message for PredictImpactResponse {}

/// The subscriptions that must be handled without delay.
pub(super) struct Subscriptions {
    events: Subscription<ImpactEvent>,
    clock: Option<Subscription<Clock>>,
    measurements: Option<MeasurementSubscriptions>,
    senders: Arc<Senders>,
    recording: Option<Arc<dyn RecordingTap>>,
}

impl Subscriptions {
    /// Subscribes to events, to the topics of the sensors if there are any and, under `use_sim_time`, to the clock.
    pub fn new(
        node: &mut Node,
        parameters: &Parameters,
        senders: Arc<Senders>,
        sensors: Option<Arc<SensorInputs>>,
        recording: Option<Arc<dyn RecordingTap>>,
    ) -> Result<Self, NodeError> {
        let simulated = parameters.settings().use_sim_time;
        let measurements = sensors.map(|inputs| {
            let (senders, recording) = (Arc::clone(&senders), recording.clone());
            MeasurementSubscriptions::new(node, parameters, inputs, senders, recording)
        });
        Ok(Self {
            measurements: measurements.transpose()?,
            events: node.subscription(&qos::IMPACT_EVENT)?,
            clock: simulated
                .then(|| node.subscription(&qos::CLOCK))
                .transpose()?,
            senders,
            recording,
        })
    }

    /// Handles messages until the task is stopped.
    pub async fn run(self, twin: Arc<LiveTwin>, counters: Arc<NodeCounters>) {
        let events = each(
            &self.events,
            &qos::IMPACT_EVENT,
            &counters,
            |event: ImpactEvent, info| {
                let sender = info.publisher_gid();
                if let Err(rejected) = self.senders.admit(sender, Instant::now()) {
                    let id = event.event_id.chars().take(MAX_NAMED_CHARS);
                    let what = id.collect::<String>();
                    return tell(&self.recording, None, &qos::IMPACT_EVENT, &what, &rejected);
                }
                record(
                    &self.recording,
                    None,
                    &qos::IMPACT_EVENT,
                    &event,
                    Some(&info),
                );
                let event_id = event.event_id.clone();
                tracing::debug!(
                    "received impact event {event_id:?} of {}: {}, {} m/s, gap {} m, {:.6} s old",
                    GuidPrefix::from(sender),
                    mass_in_words(event.mass),
                    event.velocity,
                    event.gap,
                    1e-9 * (twin.now().saturating_sub(nanos(event.header.stamp))) as f64,
                );
                if let Err(refusal) = twin.submit(impact_command(event)) {
                    tracing::warn!("impact event {event_id:?} was rejected: {refusal}");
                    if let Some(recording) = &self.recording {
                        recording.rejected(
                            None,
                            &qos::IMPACT_EVENT,
                            &event_id,
                            Some(refusal.code),
                            &refusal.reason,
                        );
                    }
                }
            },
        );
        let clock = follow_clock(self.clock.as_ref(), &counters, |now| twin.set_clock(now));
        let measurements = async {
            if let Some(measurements) = self.measurements {
                measurements.run(|| twin.now(), &counters).await;
            }
        };
        join!(events, clock, measurements);
    }
}

/// Passes the simulated time to `set`, if the node follows it, and notes that there is a clock.
pub(super) async fn follow_clock(
    clock: Option<&Subscription<Clock>>,
    counters: &NodeCounters,
    set: impl Fn(i64),
) {
    let Some(clock) = clock else { return };
    let handle = |message: Clock, _| match message.clock.to_nanos() {
        Some(now) => {
            if let Some(clock) = &counters.clock {
                clock.received();
            }
            set(now);
        }
        None => NodeCounters::count(&counters.unreadable),
    };
    each(clock, &qos::CLOCK, counters, handle).await;
}

/// As [`each_on`] of an endpoint.
pub(super) async fn each<M: serde::de::DeserializeOwned + 'static>(
    subscription: &Subscription<M>,
    endpoint: &Endpoint,
    counters: &NodeCounters,
    handle: impl FnMut(M, MessageInfo),
) {
    let is_reliable = endpoint.qos.reliable;
    each_on(subscription, endpoint.name, is_reliable, counters, handle).await;
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

/// Most characters of an identifier that a log names before it was checked.
pub(super) const MAX_NAMED_CHARS: usize = 64;

/// Logs and records that a message of a sender was rejected; `column` is as in [`RecordingTap`].
pub(super) fn tell(
    recording: &Option<Arc<dyn RecordingTap>>,
    column: Option<&str>,
    endpoint: &Endpoint,
    what: &str,
    rejected: &Rejected,
) {
    let Rejected { refusal, is_told } = rejected;
    if !is_told {
        return;
    }
    tracing::warn!("{what:?} on {} was rejected: {refusal}", endpoint.name);
    if let Some(recording) = recording {
        recording.rejected(column, endpoint, what, Some(refusal.code), &refusal.reason);
    }
}

/// Records a received message in the encoding of this program; `column` is as in [`RecordingTap`], and `info` is absent for a
/// message that the node has derived from another one.
pub(super) fn record<M: crate::messages::Message>(
    recording: &Option<Arc<dyn RecordingTap>>,
    column: Option<&str>,
    endpoint: &Endpoint,
    message: &M,
    info: Option<&MessageInfo>,
) {
    let Some(recording) = recording else {
        return;
    };
    match cdr::encode(message) {
        Ok(bytes) => {
            let stamp = info.and_then(MessageInfo::source_timestamp);
            let source = stamp.map(|it| it.to_nanos());
            recording.received(column, endpoint, bytes, source);
        }
        Err(error) => recording.rejected(column, endpoint, "a message", None, &error.to_string()),
    }
}

/// The services and parameter messages, which may take longer and have a separate thread.
pub(super) struct Services {
    column_parameters: Subscription<ColumnParameters>,
    reset: Server<TriggerRequest, TriggerResponse>,
    predict: Server<PredictImpactRequest, PredictImpactResponse>,
    confirm_estimate: Server<ConfirmEstimateRequest, ConfirmEstimateResponse>,
    calibrate: Server<CalibrateRequest, CalibrateResponse>,
    parameters: ParameterServers,
    /// Unless the parameter `start_type_description_service` is false.
    descriptions: Option<Server<GetTypeDescriptionRequest, GetTypeDescriptionResponse>>,
    senders: Arc<Senders>,
    recording: Option<Arc<dyn RecordingTap>>,
}

/// The servers behind `ros2 param`.
pub(super) struct ParameterServers {
    pub get: Server<rcl::GetParametersRequest, rcl::GetParametersResponse>,
    pub types: Server<rcl::GetParameterTypesRequest, rcl::GetParameterTypesResponse>,
    pub list: Server<rcl::ListParametersRequest, rcl::ListParametersResponse>,
    pub describe: Server<rcl::DescribeParametersRequest, rcl::DescribeParametersResponse>,
    pub set: Server<rcl::SetParametersRequest, rcl::SetParametersResponse>,
    pub set_atomically: Server<rcl::SetParametersRequest, rcl::SetParametersAtomicallyResponse>,
}

impl ParameterServers {
    pub fn new(node: &mut Node) -> Result<Self, NodeError> {
        Ok(Self {
            get: node.server(&qos::GET_PARAMETERS)?,
            types: node.server(&qos::GET_PARAMETER_TYPES)?,
            list: node.server(&qos::LIST_PARAMETERS)?,
            describe: node.server(&qos::DESCRIBE_PARAMETERS)?,
            set: node.server(&qos::SET_PARAMETERS)?,
            set_atomically: node.server(&qos::SET_PARAMETERS_ATOMICALLY)?,
        })
    }
}

impl Services {
    /// Offers all services.
    pub fn new(
        node: &mut Node,
        parameters: &Parameters,
        senders: Arc<Senders>,
        recording: Option<Arc<dyn RecordingTap>>,
    ) -> Result<Self, NodeError> {
        Ok(Self {
            senders,
            column_parameters: node.subscription(&qos::COLUMN_PARAMETERS)?,
            reset: node.server(&qos::RESET)?,
            predict: node.server(&qos::PREDICT)?,
            confirm_estimate: node.server(&qos::CONFIRM_ESTIMATE)?,
            calibrate: node.server(&qos::CALIBRATE)?,
            parameters: ParameterServers::new(node)?,
            descriptions: parameters
                .settings()
                .start_type_description_service
                .then(|| node.server(&qos::GET_TYPE_DESCRIPTION))
                .transpose()?,
            recording,
        })
    }

    /// Answers requests until the task is stopped.
    pub async fn run(self, twin: Arc<LiveTwin>, counters: Arc<NodeCounters>) {
        let ParameterServers {
            get,
            types,
            list,
            describe,
            set,
            set_atomically,
        } = self.parameters;
        let recording = self.recording;
        let descriptions = self.descriptions;
        let describe_types = async {
            if let Some(server) = &descriptions {
                let describe = |request| type_descriptions::describe(&request);
                answer(&qos::GET_TYPE_DESCRIPTION, server, &counters, describe).await;
            }
        };
        let (twin, counters) = (&*twin, &*counters);
        let admit = |gid: Gid, endpoint: &Endpoint, what: &str| {
            let admitted = self.senders.admit(gid, Instant::now());
            admitted.map_err(|rejected| {
                tell(&recording, None, endpoint, what, &rejected);
                rejected.refusal
            })
        };
        join!(
            each(
                &self.column_parameters,
                &qos::COLUMN_PARAMETERS,
                counters,
                |message, info| {
                    let sender = info.publisher_gid();
                    if admit(sender, &qos::COLUMN_PARAMETERS, "a set of parameters").is_err() {
                        return;
                    }
                    record(
                        &recording,
                        None,
                        &qos::COLUMN_PARAMETERS,
                        &message,
                        Some(&info),
                    );
                    tracing::debug!(
                        "received a set of parameters of {}",
                        GuidPrefix::from(sender)
                    );
                    let Err(refusal) = set_column(twin, &message) else {
                        return;
                    };
                    if let Some(recording) = &recording
                        && !refusal.code.is_from_twin()
                    {
                        recording.rejected(
                            None,
                            &qos::COLUMN_PARAMETERS,
                            "a set of parameters",
                            Some(refusal.code),
                            &refusal.reason,
                        );
                    }
                }
            ),
            answer_from(&qos::RESET, &self.reset, counters, |sender, _| {
                match admit(sender, &qos::RESET, "a reset") {
                    Ok(()) => reset(twin),
                    Err(refusal) => TriggerResponse {
                        success: false,
                        message: refusal.tagged(),
                    },
                }
            }),
            answer(&qos::PREDICT, &self.predict, counters, |request| predicted(
                twin, &request
            )),
            answer_from(
                &qos::CONFIRM_ESTIMATE,
                &self.confirm_estimate,
                counters,
                |sender, request| {
                    match admit(
                        sender,
                        &qos::CONFIRM_ESTIMATE,
                        "a decision about an estimate",
                    ) {
                        Ok(()) => {
                            let own = requests::check_column(twin.column_id(), &request.column_id);
                            requests::confirm_estimate(request, |command| {
                                own.and_then(|()| twin.execute(command))
                            })
                        }
                        Err(refusal) => requests::not_decided(&refusal),
                    }
                }
            ),
            answer_from(
                &qos::CALIBRATE,
                &self.calibrate,
                counters,
                |sender, request| {
                    match admit(sender, &qos::CALIBRATE, "a calibration") {
                        Ok(()) => {
                            let own = requests::check_column(twin.column_id(), &request.column_id);
                            requests::calibrate(&request, |command| {
                                own.and_then(|()| twin.execute(command))
                            })
                        }
                        Err(refusal) => requests::not_calibrated(&refusal),
                    }
                }
            ),
            answer(&qos::GET_PARAMETERS, &get, counters, |request| {
                parameters::get(&twin.parameters(), &request)
            }),
            answer(&qos::GET_PARAMETER_TYPES, &types, counters, |request| {
                parameters::types(&twin.parameters(), &request)
            }),
            answer(&qos::LIST_PARAMETERS, &list, counters, |request| {
                parameters::list(&twin.parameters(), &request)
            }),
            answer(&qos::DESCRIBE_PARAMETERS, &describe, counters, |request| {
                parameters::describe(&twin.parameters(), &request)
            }),
            answer_from(&qos::SET_PARAMETERS, &set, counters, |sender, request| {
                match admit(sender, &qos::SET_PARAMETERS, "a request") {
                    Ok(()) => parameters::set(twin, request),
                    Err(refusal) => parameters::set_rejected(&request, &refusal),
                }
            }),
            answer_from(
                &qos::SET_PARAMETERS_ATOMICALLY,
                &set_atomically,
                counters,
                |sender, request| {
                    match admit(sender, &qos::SET_PARAMETERS_ATOMICALLY, "a request") {
                        Ok(()) => parameters::set_atomically(twin, request),
                        Err(refusal) => parameters::set_rejected_atomically(&refusal),
                    }
                }
            ),
            describe_types,
        );
    }
}

/// Answers every request with the result of `reply`.
pub(super) async fn answer<Request, Response>(
    endpoint: &Endpoint,
    server: &Server<Request, Response>,
    counters: &NodeCounters,
    mut reply: impl FnMut(Request) -> Response,
) where
    Request: ros2_client::Message + Clone + 'static,
    Response: ros2_client::Message + 'static,
{
    answer_from(endpoint, server, counters, |_, request| reply(request)).await;
}

/// Answers every request with the result of `reply`, which is given the sender too.
pub(super) async fn answer_from<Request, Response>(
    endpoint: &Endpoint,
    server: &Server<Request, Response>,
    counters: &NodeCounters,
    mut reply: impl FnMut(Gid, Request) -> Response,
) where
    Request: ros2_client::Message + Clone + 'static,
    Response: ros2_client::Message + 'static,
{
    let mut requests = server.receive_request_stream();
    while let Some(request) = requests.next().await {
        match request {
            Ok((id, request)) => {
                tracing::debug!(
                    "received a request to {} of {}",
                    endpoint.name,
                    GuidPrefix::from(id.writer_gid)
                );
                if let Err(error) = server
                    .async_send_response(id, reply(id.writer_gid, request))
                    .await
                {
                    NodeCounters::count(&counters.unpublished);
                    tracing::warn!("a response of {} cannot be sent: {error:?}", endpoint.name);
                }
            }
            Err(error) => {
                NodeCounters::count(&counters.unreadable);
                tracing::warn!(
                    "a request to {} cannot be read: {error}; check the service type of its sender",
                    endpoint.name
                );
            }
        }
    }
}

fn reset(twin: &LiveTwin) -> TriggerResponse {
    let outcome = twin.execute(Command::Reset {
        source: "service ~/reset".into(),
    });
    TriggerResponse {
        success: outcome.is_ok(),
        message: match outcome {
            Ok(_) => "the column is virgin".to_owned(),
            Err(refusal) => refusal.tagged(),
        },
    }
}

fn predicted(twin: &LiveTwin, request: &PredictImpactRequest) -> PredictImpactResponse {
    let parameters = twin.parameters();
    let settings = parameters.settings();
    match twin.predict(&request.column_id, &request.vehicle, &request.into()) {
        Ok(prediction) => PredictImpactResponse {
            success: true,
            report: ImpactReport {
                header: Header {
                    stamp: Time::from_nanos(twin.now()).unwrap_or_default(),
                    frame_id: settings.frame_id.clone(),
                },
                column_id: settings.column_id.clone(),
                event_id: request.event_id.clone(),
                ..ImpactReport::from(&prediction)
            },
            ..PredictImpactResponse::default()
        },
        Err(Refusal { code, reason }) => PredictImpactResponse {
            success: false,
            refusal_code: code.number(),
            message: reason.to_string(),
            ..PredictImpactResponse::default()
        },
    }
}

fn set_column(twin: &LiveTwin, message: &ColumnParameters) -> Result<Accepted, Refusal> {
    let topic = qos::COLUMN_PARAMETERS.name;
    let command = column_command(message, twin.column_id());
    let outcome = twin.execute(command);
    match &outcome {
        Ok(Accepted::Waiting) => tracing::info!(
            "the parameters on {topic} were accepted; they take effect when the response ends"
        ),
        Ok(_) => tracing::info!("the parameters on {topic} were accepted"),
        // The twin reports its refusals among its outputs.
        Err(refusal) if refusal.code.is_from_twin() => {}
        Err(refusal) => {
            tracing::warn!("a change of parameters on {topic} was rejected: {refusal}");
        }
    }
    outcome
}
