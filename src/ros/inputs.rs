//! The inputs of the node: impact events, parameters, the clock, and service requests.

use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

use futures::channel::oneshot;
use futures::{StreamExt, join};
use ros2_client::rcl_interfaces as rcl;
use ros2_client::{Gid, MessageInfo};

use crate::incoming::{column_command, impact_command, nanos};
use crate::live::BACKGROUND_THREAD;
use crate::messages::INTERFACES;
use crate::messages::builtin_interfaces::Time;
use crate::messages::column_twin_msgs::{
    ColumnParameters, ConfirmEstimateRequest, ConfirmEstimateResponse, CorrectDamageRequest,
    CorrectDamageResponse, ImpactEvent, ImpactReport, PredictImpactRequest, PredictImpactResponse,
    ResetColumnRequest, ResetColumnResponse, RowImpactEvent,
};
use crate::messages::rosgraph_msgs::Clock;
use crate::messages::std_msgs::Header;
use crate::messages::std_srvs::{TriggerRequest, TriggerResponse};
use crate::messages::words::mass_in_words;
use crate::twin::{Accepted, Command, Prediction, Rejection};
use printable::Printable;

use super::counters::NodeCounters;
use super::fleet::RowImpacts;
use super::live_columns::LiveColumns;
use super::measurements::{MeasurementSubscriptions, SensedColumns};
use super::node::{Node, NodeError};
use super::parameter_services as parameters;
use super::qos::{self, Endpoint};
use super::receiving::{Receiving, each, named};
use super::requests;
use super::task::spawn;
use super::transport::{Server, Subscription};
use ros_node::guid_prefix::GuidPrefix;
use ros_node::missed::Missed;
use ros_node::type_descriptions::{
    GetTypeDescriptionRequest, GetTypeDescriptionResponse, TypeDescriptions,
};

/// What the types of the node look like.
static DESCRIPTIONS: LazyLock<TypeDescriptions<'static>> = LazyLock::new(|| {
    TypeDescriptions::new(INTERFACES).expect("the definitions are complete, which is tested")
});

impl ros2_client::Message for TriggerRequest {}
impl ros2_client::Message for TriggerResponse {}
impl ros2_client::Message for ResetColumnRequest {}
impl ros2_client::Message for ResetColumnResponse {}
impl ros2_client::Message for PredictImpactRequest {}
impl ros2_client::Message for PredictImpactResponse {}

/// How a rejected set of parameters is called in the recording and in the log.
const SET_OF_PARAMETERS: &str = "a set of parameters";

/// Longest wait of a prediction for its second opinion, which is computed only while no other thread wants the processor.
const OPINION_PATIENCE: Duration = Duration::from_secs(5);

/// Name of the thread that waits for a second opinion.
const WAITING_THREAD: &str = "column_twin/wait";

/// The subscriptions that must be handled without delay.
pub(super) struct Subscriptions {
    events: Subscription<ImpactEvent>,
    clock: Option<Subscription<Clock>>,
    measurements: Option<MeasurementSubscriptions>,
    receiving: Receiving,
}

impl Subscriptions {
    /// Subscribes to events, to the topics of the sensors if there are any and, under `use_sim_time`, to the clock.
    pub fn new(
        node: &mut Node,
        sensed: Option<Arc<SensedColumns>>,
        receiving: Receiving,
    ) -> Result<Self, NodeError> {
        let simulated = receiving.columns.node_parameters().settings().use_sim_time;
        let measurements =
            sensed.map(|sensed| MeasurementSubscriptions::new(node, sensed, receiving.clone()));
        Ok(Self {
            measurements: measurements.transpose()?,
            events: node.subscription(&qos::IMPACT_EVENT)?,
            clock: simulated
                .then(|| node.subscription(&qos::CLOCK))
                .transpose()?,
            receiving,
        })
    }

    /// Handles messages until the task is stopped.
    pub async fn run(self) {
        let receiving = &self.receiving;
        let Receiving {
            columns, counters, ..
        } = receiving;
        let take_event = |event: ImpactEvent, info| impact_event(receiving, event, &info);
        let events = each(Some(&self.events), &qos::IMPACT_EVENT, counters, take_event);
        let clock = each(
            self.clock.as_ref(),
            &qos::CLOCK,
            counters,
            |message: Clock, _| match message.clock.to_nanos() {
                Some(now) => {
                    if let Some(clock) = &counters.clock {
                        clock.received(Instant::now());
                    }
                    columns.set_clock(now);
                }
                None => NodeCounters::count(&counters.unreadable),
            },
        );
        let measurements = async {
            if let Some(measurements) = self.measurements {
                measurements.run().await;
            }
        };
        join!(events, clock, measurements);
    }
}

fn impact_event(receiving: &Receiving, event: ImpactEvent, info: &MessageInfo) {
    let endpoint = &qos::IMPACT_EVENT;
    let Some(column) = receiving.addressed(endpoint, &event.column_id) else {
        return;
    };
    let (sender, what) = (info.publisher_gid(), named(&event.event_id));
    if receiving
        .admit(sender, Some(column), endpoint, &what)
        .is_err()
    {
        return;
    }
    receiving.record(column, endpoint, &event, Some(info));
    let event_id = event.event_id.clone();
    let for_column = receiving.face().words("for", column);
    tracing::debug!(
        "received impact event {event_id:?}{for_column} of {}: {}, {} m/s, gap {} m, {:.6} s old",
        GuidPrefix::from(sender),
        mass_in_words(event.mass),
        event.velocity,
        event.gap,
        1e-9 * (receiving
            .columns
            .now()
            .saturating_sub(nanos(event.header.stamp))) as f64,
    );
    if let Err(rejection) = receiving.columns.submit(column, impact_command(event)) {
        tracing::warn!("impact event {event_id:?}{for_column} was rejected: {rejection}");
        receiving.not_taken(Some(column), endpoint, &event_id, &rejection);
    }
}

/// The services and parameter messages, which may take longer and have a separate thread.
pub(super) struct Services {
    /// Vehicles that hit several columns of a fleet.
    rows: Option<(Subscription<RowImpactEvent>, Arc<RowImpacts>)>,
    column_parameters: Subscription<ColumnParameters>,
    /// Of a single twin.
    reset: Option<Server<TriggerRequest, TriggerResponse>>,
    /// Of a fleet.
    reset_column: Option<Server<ResetColumnRequest, ResetColumnResponse>>,
    predict: Server<PredictImpactRequest, PredictImpactResponse>,
    confirm_estimate: Server<ConfirmEstimateRequest, ConfirmEstimateResponse>,
    correct_damage: Server<CorrectDamageRequest, CorrectDamageResponse>,
    receiving: Receiving,
}

/// The services that every node of ROS 2 has.
pub(super) struct NodeServices {
    parameters: ParameterServers,
    /// Unless the parameter `start_type_description_service` is false.
    descriptions: Option<Server<GetTypeDescriptionRequest, GetTypeDescriptionResponse>>,
    receiving: Receiving,
}

impl NodeServices {
    /// Offers all services.
    pub fn new(node: &mut Node, receiving: Receiving) -> Result<Self, NodeError> {
        let settings = receiving.columns.node_parameters().settings();
        let describes = settings.start_type_description_service;
        Ok(Self {
            parameters: ParameterServers::new(node)?,
            descriptions: describes
                .then(|| node.server(&qos::GET_TYPE_DESCRIPTION))
                .transpose()?,
            receiving,
        })
    }

    /// Answers requests until the task is stopped.
    pub async fn run(self) {
        join!(
            self.parameters.run(&self.receiving),
            answer(
                &qos::GET_TYPE_DESCRIPTION,
                self.descriptions.as_ref(),
                &self.receiving.counters,
                |request| DESCRIPTIONS.answer(&request),
            ),
        );
    }
}

/// The servers behind `ros2 param`.
struct ParameterServers {
    get: Server<rcl::GetParametersRequest, rcl::GetParametersResponse>,
    types: Server<rcl::GetParameterTypesRequest, rcl::GetParameterTypesResponse>,
    list: Server<rcl::ListParametersRequest, rcl::ListParametersResponse>,
    describe: Server<rcl::DescribeParametersRequest, rcl::DescribeParametersResponse>,
    set: Server<rcl::SetParametersRequest, rcl::SetParametersResponse>,
    set_atomically: Server<rcl::SetParametersRequest, rcl::SetParametersAtomicallyResponse>,
}

impl ParameterServers {
    fn new(node: &mut Node) -> Result<Self, NodeError> {
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

impl ParameterServers {
    /// Answers requests until the task is stopped.
    async fn run(&self, receiving: &Receiving) {
        let (columns, counters) = (&*receiving.columns, &*receiving.counters);
        let admit = |sender, endpoint| receiving.admit(sender, None, endpoint, "a request");
        let Self {
            get,
            types,
            list,
            describe,
            set,
            set_atomically,
        } = self;
        join!(
            answer(&qos::GET_PARAMETERS, Some(get), counters, |request| {
                parameters::get(columns, &request)
            }),
            answer(
                &qos::GET_PARAMETER_TYPES,
                Some(types),
                counters,
                |request| { parameters::types(columns, &request) }
            ),
            answer(&qos::LIST_PARAMETERS, Some(list), counters, |request| {
                parameters::list(columns, &request)
            }),
            answer(
                &qos::DESCRIBE_PARAMETERS,
                Some(describe),
                counters,
                |request| { parameters::describe(columns, &request) }
            ),
            answer_from(
                &qos::SET_PARAMETERS,
                Some(set),
                counters,
                |sender, request| {
                    match admit(sender, &qos::SET_PARAMETERS) {
                        Ok(()) => parameters::set(columns, &request),
                        Err(rejection) => parameters::set_rejected(&request, &rejection),
                    }
                }
            ),
            answer_from(
                &qos::SET_PARAMETERS_ATOMICALLY,
                Some(set_atomically),
                counters,
                |sender, request| {
                    match admit(sender, &qos::SET_PARAMETERS_ATOMICALLY) {
                        Ok(()) => parameters::set_atomically(columns, request),
                        Err(rejection) => parameters::set_rejected_atomically(&rejection),
                    }
                }
            ),
        );
    }
}

impl Services {
    /// Offers the services of the columns; `rows` are those of a fleet.
    pub fn new(
        node: &mut Node,
        rows: Option<Arc<RowImpacts>>,
        receiving: Receiving,
    ) -> Result<Self, NodeError> {
        let kind = receiving.face().kind();
        let rows = rows.map(|rows| {
            let events = node.subscription(&qos::ROW_IMPACT_EVENT)?;
            Ok::<_, NodeError>((events, rows))
        });
        Ok(Self {
            rows: rows.transpose()?,
            column_parameters: node.subscription(&qos::COLUMN_PARAMETERS)?,
            reset: qos::RESET
                .is_of(kind)
                .then(|| node.server(&qos::RESET))
                .transpose()?,
            reset_column: qos::RESET_COLUMN
                .is_of(kind)
                .then(|| node.server(&qos::RESET_COLUMN))
                .transpose()?,
            predict: node.server(&qos::PREDICT)?,
            confirm_estimate: node.server(&qos::CONFIRM_ESTIMATE)?,
            correct_damage: node.server(&qos::CORRECT_DAMAGE)?,
            receiving,
        })
    }

    /// Answers requests until the task is stopped.
    pub async fn run(self) {
        let receiving = &self.receiving;
        let columns = &*receiving.columns;
        let counters = &*receiving.counters;
        // Of a request about a column: which one.
        let column_of = |sender, column_id: &str, endpoint, what| {
            let face = receiving.face();
            receiving.admit(sender, face.index_of(column_id), endpoint, what)?;
            face.requested(column_id)
        };
        let execute = |column: Result<u32, Rejection>, command| columns.execute(column?, command);
        let rows = async {
            if let Some((events, rows)) = &self.rows {
                let take = |message, info: MessageInfo| row_event(receiving, rows, message, &info);
                each(Some(events), &qos::ROW_IMPACT_EVENT, counters, take).await;
            }
        };
        join!(
            rows,
            each(
                Some(&self.column_parameters),
                &qos::COLUMN_PARAMETERS,
                counters,
                |message, info| set_column(receiving, &message, &info),
            ),
            answer_from(&qos::RESET, self.reset.as_ref(), counters, |sender, _| {
                let admitted = receiving.admit(sender, None, &qos::RESET, "a reset");
                requests::was_reset(execute(admitted.map(|()| 0), reset_by(&qos::RESET)))
            }),
            answer_from(
                &qos::RESET_COLUMN,
                self.reset_column.as_ref(),
                counters,
                |sender, request| {
                    let endpoint = &qos::RESET_COLUMN;
                    let column = column_of(sender, &request.column_id, endpoint, "a reset");
                    requests::column_was_reset(execute(column, reset_by(endpoint)))
                }
            ),
            // Other requests are answered while the second opinion on a prediction is computed.
            answer_in_time(
                &qos::PREDICT,
                Some(&self.predict),
                counters,
                async |_, request| predicted(columns, &request).await
            ),
            answer_from(
                &qos::CONFIRM_ESTIMATE,
                Some(&self.confirm_estimate),
                counters,
                |sender, request| {
                    let (endpoint, what) = (&qos::CONFIRM_ESTIMATE, "a decision about an estimate");
                    let column = column_of(sender, &request.column_id, endpoint, what);
                    requests::confirm_estimate(request, |command| execute(column, command))
                }
            ),
            answer_from(
                &qos::CORRECT_DAMAGE,
                Some(&self.correct_damage),
                counters,
                |sender, request| {
                    let (endpoint, what) = (&qos::CORRECT_DAMAGE, "a correction of the damage");
                    match column_of(sender, &request.column_id, endpoint, what) {
                        Ok(it) => requests::correct_damage(&request, |command| {
                            columns.execute(it, command)
                        }),
                        Err(rejection) => requests::not_corrected(&rejection),
                    }
                }
            ),
        );
    }
}

/// Answers every request with the result of `reply`.
pub(super) async fn answer<Request, Response>(
    endpoint: &Endpoint,
    server: Option<&Server<Request, Response>>,
    counters: &NodeCounters,
    mut reply: impl FnMut(Request) -> Response,
) where
    Request: ros2_client::Message + Clone + 'static,
    Response: ros2_client::Message + 'static,
{
    answer_from(endpoint, server, counters, |_, request| reply(request)).await;
}

/// Answers every request with the result of `reply`, which is given the sender too; returns at once if there is no such server.
pub(super) async fn answer_from<Request, Response>(
    endpoint: &Endpoint,
    server: Option<&Server<Request, Response>>,
    counters: &NodeCounters,
    mut reply: impl FnMut(Gid, Request) -> Response,
) where
    Request: ros2_client::Message + Clone + 'static,
    Response: ros2_client::Message + 'static,
{
    let reply = async |sender, request| reply(sender, request);
    answer_in_time(endpoint, server, counters, reply).await;
}

/// As [`answer_from`], with results that may take their time: the requests of this server wait meanwhile, and no others.
async fn answer_in_time<Request, Response>(
    endpoint: &Endpoint,
    server: Option<&Server<Request, Response>>,
    counters: &NodeCounters,
    mut reply: impl AsyncFnMut(Gid, Request) -> Response,
) where
    Request: ros2_client::Message + Clone + 'static,
    Response: ros2_client::Message + 'static,
{
    let Some(server) = server else { return };
    let mut requests = server.receive_request_stream();
    let mut missed = Missed::default();
    while let Some(request) = requests.next().await {
        match request {
            Ok((id, request)) => {
                // Clients number their requests, as writers their messages.
                let lost = missed.before_number(id.writer_gid, id.sequence_number);
                if lost > 0 {
                    counters.missed.fetch_add(lost, Ordering::Relaxed);
                    tracing::error!(
                        "{lost} requests to {} were lost and are not answered: they arrived faster than they could be handled, were \
                         too long, or were sent while the network was interrupted",
                        endpoint.name
                    );
                }
                tracing::debug!(
                    "received a request to {} of {}",
                    endpoint.name,
                    GuidPrefix::from(id.writer_gid)
                );
                let response = reply(id.writer_gid, request).await;
                if let Err(error) = server.async_send_response(id, response).await {
                    NodeCounters::count(&counters.unpublished);
                    tracing::warn!("a response of {} cannot be sent: {error}", endpoint.name);
                }
            }
            Err(error) => {
                missed.unreadable();
                NodeCounters::count(&counters.unreadable);
                tracing::warn!(
                    "a request to {} cannot be read: {error}; check the service type of its sender",
                    endpoint.name
                );
            }
        }
    }
}

fn row_event(
    receiving: &Receiving,
    rows: &RowImpacts,
    message: RowImpactEvent,
    info: &MessageInfo,
) {
    let endpoint = &qos::ROW_IMPACT_EVENT;
    // Columns that are elsewhere are those of another fleet on this topic.
    let ids = &message.column_ids;
    let is_own = |it: &String| receiving.face().index_of(it).is_some();
    if !ids.is_empty() && !ids.iter().any(is_own) {
        receiving.addressed(endpoint, &ids[0]);
        return;
    }
    let id = Printable(&named(&message.event_id)).to_string();
    if receiving
        .admit(info.publisher_gid(), None, endpoint, &id)
        .is_err()
    {
        return;
    }
    match rows.take_event(message) {
        Ok(()) => tracing::info!("row impact event \"{id}\" accepted"),
        Err(reasons) => {
            NodeCounters::count(&receiving.counters.rejected_rows);
            tracing::warn!(
                "row impact event \"{id}\" was rejected, no column is hit by it: {reasons}"
            );
        }
    }
}

fn reset_by(endpoint: &Endpoint) -> Command {
    let source = format!("service {}", endpoint.name).into();
    Command::Reset { source }
}

/// Answers a request for a prediction, with its second opinion where that is computed in time.
pub(super) async fn predicted(
    columns: &LiveColumns,
    request: &PredictImpactRequest,
) -> PredictImpactResponse {
    let face = columns.face();
    let prediction = face.requested(&request.column_id).and_then(|column| {
        let prediction = columns.predict(column, &request.vehicle, &request.into())?;
        Ok((column, prediction))
    });
    let prediction = match prediction {
        Ok((column, prediction)) => Ok((column, with_opinion(columns, prediction).await)),
        Err(rejection) => Err(rejection),
    };
    match prediction {
        Ok((column, prediction)) => PredictImpactResponse {
            success: true,
            report: ImpactReport {
                header: Header {
                    stamp: Time::from_nanos(columns.now()).unwrap_or_default(),
                    frame_id: columns.parameters(column).settings().frame_id.clone(),
                },
                column_id: face.id(column).to_owned(),
                event_id: request.event_id.clone(),
                ..ImpactReport::from(&prediction)
            },
            ..PredictImpactResponse::default()
        },
        Err(Rejection { code, reason }) => PredictImpactResponse {
            success: false,
            rejection_code: code.number(),
            message: reason.to_string(),
            ..PredictImpactResponse::default()
        },
    }
}

/// The prediction with its second opinion, where it awaits one; without it after [`OPINION_PATIENCE`].
async fn with_opinion(columns: &LiveColumns, prediction: Prediction) -> Prediction {
    let Some(task) = prediction.opinion_task() else {
        return prediction;
    };
    let (sender, opinion) = sync_channel(1);
    let reply = Box::new(move |found| {
        // After the timeout the receiver is gone.
        let _ = sender.send(found);
    });
    if let Err(rejection) = columns.ask_opinion(task, reply) {
        return prediction.without_opinion(&format!("no second opinion: {}", rejection.reason));
    }
    // The executor has no timer, so that a thread waits while other requests are answered.
    let (teller, told) = oneshot::channel();
    let wait = move || {
        // After a stop the receiver is gone.
        let _ = teller.send(opinion.recv_timeout(OPINION_PATIENCE));
    };
    if let Err(error) = spawn(WAITING_THREAD, wait) {
        return prediction.without_opinion(&format!("no second opinion: {error}"));
    }
    match told.await.unwrap_or(Err(RecvTimeoutError::Disconnected)) {
        Ok(found) => prediction.with_opinion(&found),
        Err(RecvTimeoutError::Timeout) => prediction.without_opinion(&format!(
            "no second opinion: it was not computed within {} s",
            OPINION_PATIENCE.as_secs()
        )),
        Err(RecvTimeoutError::Disconnected) if columns.is_stopping() => {
            prediction.without_opinion("no second opinion: the node is being stopped")
        }
        Err(RecvTimeoutError::Disconnected) => {
            tracing::error!(
                "the thread \"{BACKGROUND_THREAD}\", which computes second opinions and critical velocities, has ended: it panicked, or \
                 could not give up its real-time priority; restart the node, and report a panic"
            );
            prediction
                .without_opinion("no second opinion: this node computes none any more; see its log")
        }
    }
}

fn set_column(receiving: &Receiving, message: &ColumnParameters, info: &MessageInfo) {
    let (endpoint, sender) = (&qos::COLUMN_PARAMETERS, info.publisher_gid());
    let Some(column) = receiving.addressed(endpoint, &message.column_id) else {
        return;
    };
    let what = SET_OF_PARAMETERS;
    if receiving
        .admit(sender, Some(column), endpoint, what)
        .is_err()
    {
        return;
    }
    receiving.record(column, endpoint, message, Some(info));
    let (face, topic) = (receiving.face(), endpoint.name);
    let of_column = face.words("of", column);
    let sender = GuidPrefix::from(sender);
    tracing::debug!("received a set of parameters{of_column} of {sender}");
    let command = column_command(message, face.id(column));
    match receiving.columns.execute(column, command) {
        Ok(Accepted::Waiting) => tracing::info!(
            "the parameters{of_column} on {topic} were accepted; they take effect when the response ends"
        ),
        Ok(_) => tracing::info!("the parameters{of_column} on {topic} were accepted"),
        // The twin reports its rejections among its outputs.
        Err(rejection) if rejection.code.is_from_twin() => {}
        Err(rejection) => {
            tracing::warn!(
                "a change of parameters{of_column} on {topic} was rejected: {rejection}"
            );
            receiving.not_taken(Some(column), endpoint, what, &rejection);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::endpoints::{Direction, ENDPOINTS};
    use crate::messages::find;

    #[test]
    fn every_type_of_the_program_is_described() {
        // Two types without fields or with equal ones would have one hash if the name were not part of it.
        let names: Vec<_> = DESCRIPTIONS
            .all()
            .map(|it| it.type_description.type_name.as_str())
            .collect();
        let mut services: Vec<_> = ENDPOINTS
            .iter()
            .filter(|it| it.direction == Direction::Service)
            .map(|it| it.type_name)
            .filter(|it| find(&format!("{it}_Request")).is_some())
            .collect();
        services.sort_unstable();
        services.dedup();
        assert!(services.iter().all(|it| names.contains(it)), "{names:?}");
        // Those behind `ros2 param` are of the client library.
        assert_eq!(services.len(), 9, "{services:?}");
        assert_eq!(names.len(), INTERFACES.len() + services.len());
    }
}
