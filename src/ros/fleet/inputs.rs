//! The inputs of a fleet over DDS: events and parameters for its columns, the clock, and service requests.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use futures::join;
use ros2_client::{Gid, Server, Subscription};

use crate::endpoints::Endpoint;
use crate::incoming::{column_command, impact_command};
use crate::messages::builtin_interfaces::Time;
use crate::messages::column_twin_msgs::{
    CalibrateRequest, CalibrateResponse, ColumnParameters, ConfirmEstimateRequest,
    ConfirmEstimateResponse, ImpactEvent, ImpactReport, PredictImpactRequest,
    PredictImpactResponse, ResetColumnRequest, ResetColumnResponse, RowImpactEvent, TwinStatus,
};
use crate::messages::rosgraph_msgs::Clock;
use crate::messages::std_msgs::Header;
use crate::outgoing::RecordingTap;
use crate::printable::Printable;
use crate::twin::{Accepted, Command, Refusal, RefusalCode};

use super::super::diagnostics::NodeCounters;
use super::super::inputs::{
    MAX_NAMED_CHARS, ParameterServers, answer, answer_from, each, follow_clock, record, tell,
};
use super::super::measurements::{MeasurementSubscriptions, SensedColumns};
use super::super::node::{Node, NodeError};
use super::super::parameter_services::{set_rejected, set_rejected_atomically};
use super::super::qos;
use super::super::requests;
use super::super::senders::Senders;
use super::super::type_descriptions::{
    self, GetTypeDescriptionRequest, GetTypeDescriptionResponse,
};
use super::live_fleet::FleetTwin;
use super::parameter_services as parameters;
use super::rejected::not_taken;
use super::rows::RowImpacts;

impl ros2_client::Message for ResetColumnRequest {}
impl ros2_client::Message for ResetColumnResponse {}

/// The subscriptions that must be handled without delay.
pub(super) struct FleetSubscriptions {
    events: Subscription<ImpactEvent>,
    clock: Option<Subscription<Clock>>,
    measurements: Option<MeasurementSubscriptions>,
    senders: Arc<Senders>,
    recording: Option<Arc<dyn RecordingTap>>,
}

impl FleetSubscriptions {
    pub fn new(
        node: &mut Node,
        is_simulated: bool,
        senders: Arc<Senders>,
        sensed: Option<Arc<SensedColumns>>,
        recording: Option<Arc<dyn RecordingTap>>,
    ) -> Result<Self, NodeError> {
        let measurements = sensed.map(|sensed| {
            let (senders, recording) = (Arc::clone(&senders), recording.clone());
            MeasurementSubscriptions::of_fleet(node, sensed, senders, recording)
        });
        Ok(Self {
            measurements: measurements.transpose()?,
            events: node.subscription(&qos::IMPACT_EVENT)?,
            clock: is_simulated
                .then(|| node.subscription(&qos::CLOCK))
                .transpose()?,
            senders,
            recording,
        })
    }

    /// Handles messages until the task is stopped.
    pub async fn run(self, fleet: Arc<FleetTwin>, counters: Arc<NodeCounters>) {
        let events = each(
            &self.events,
            &qos::IMPACT_EVENT,
            &counters,
            |event: ImpactEvent, info| {
                let Some(column) = fleet.index_of(&event.column_id) else {
                    return ignore(&counters, &qos::IMPACT_EVENT, &event.column_id);
                };
                if let Err(rejected) = self.senders.admit(info.publisher_gid(), Instant::now()) {
                    let id = event.event_id.chars().take(MAX_NAMED_CHARS);
                    let what = id.collect::<String>();
                    let column_id = Some(event.column_id.as_str());
                    return tell(
                        &self.recording,
                        column_id,
                        &qos::IMPACT_EVENT,
                        &what,
                        &rejected,
                    );
                }
                let column_id = event.column_id.clone();
                record(
                    &self.recording,
                    Some(&column_id),
                    &qos::IMPACT_EVENT,
                    &event,
                    Some(&info),
                );
                let event_id = event.event_id.clone();
                tracing::debug!(
                    "received impact event {event_id:?} for column {:?}",
                    event.column_id
                );
                if let Err(refusal) = fleet.submit(column, impact_command(event)) {
                    tracing::warn!("impact event {event_id:?} was rejected: {refusal}");
                    not_taken(
                        &self.recording,
                        &column_id,
                        &qos::IMPACT_EVENT,
                        &event_id,
                        &refusal,
                    );
                }
            },
        );
        let clock = follow_clock(self.clock.as_ref(), &counters, |now| fleet.set_clock(now));
        let measurements = async {
            if let Some(measurements) = self.measurements {
                measurements.run(|| fleet.now(), &counters).await;
            }
        };
        join!(events, clock, measurements);
    }
}

/// Counts a message for a column that is not in this fleet.
fn ignore(counters: &NodeCounters, endpoint: &Endpoint, column_id: &str) {
    counters.ignored.fetch_add(1, Ordering::Relaxed);
    tracing::debug!(
        "a message on {} is for column {column_id:?}, which is not in this fleet",
        endpoint.name
    );
}

/// The services and parameter messages, which may take longer and have a separate thread.
pub(super) struct FleetServices {
    rows: Subscription<RowImpactEvent>,
    row_impacts: Arc<RowImpacts>,
    column_parameters: Subscription<ColumnParameters>,
    reset: Server<ResetColumnRequest, ResetColumnResponse>,
    predict: Server<PredictImpactRequest, PredictImpactResponse>,
    confirm_estimate: Server<ConfirmEstimateRequest, ConfirmEstimateResponse>,
    calibrate: Server<CalibrateRequest, CalibrateResponse>,
    parameters: ParameterServers,
    /// Unless the parameter `start_type_description_service` is false.
    descriptions: Option<Server<GetTypeDescriptionRequest, GetTypeDescriptionResponse>>,
    senders: Arc<Senders>,
    recording: Option<Arc<dyn RecordingTap>>,
}

impl FleetServices {
    pub fn new(
        node: &mut Node,
        describes: bool,
        senders: Arc<Senders>,
        row_impacts: Arc<RowImpacts>,
        recording: Option<Arc<dyn RecordingTap>>,
    ) -> Result<Self, NodeError> {
        Ok(Self {
            rows: node.subscription(&qos::ROW_IMPACT_EVENT)?,
            row_impacts,
            column_parameters: node.subscription(&qos::COLUMN_PARAMETERS)?,
            reset: node.server(&qos::RESET_COLUMN)?,
            predict: node.server(&qos::PREDICT)?,
            confirm_estimate: node.server(&qos::CONFIRM_ESTIMATE)?,
            calibrate: node.server(&qos::CALIBRATE)?,
            parameters: ParameterServers::new(node)?,
            descriptions: describes
                .then(|| node.server(&qos::GET_TYPE_DESCRIPTION))
                .transpose()?,
            senders,
            recording,
        })
    }

    /// Answers requests until the task is stopped.
    pub async fn run(self, fleet: Arc<FleetTwin>, counters: Arc<NodeCounters>) {
        let (fleet, counters) = (&*fleet, &*counters);
        let descriptions = self.descriptions;
        let ParameterServers {
            get,
            types,
            list,
            describe,
            set,
            set_atomically,
        } = self.parameters;
        let describe_types = async {
            if let Some(server) = &descriptions {
                let describe = |request| type_descriptions::describe(&request);
                answer(&qos::GET_TYPE_DESCRIPTION, server, counters, describe).await;
            }
        };
        let recording = self.recording;
        let admit = |gid: Gid, column_id: &str, endpoint: &Endpoint, what: &str| {
            let admitted = self.senders.admit(gid, Instant::now());
            admitted.map_err(|rejected| {
                let column_id = fleet.index_of(column_id).map(|_| column_id);
                tell(&recording, column_id, endpoint, what, &rejected);
                rejected.refusal
            })
        };
        join!(
            each(
                &self.rows,
                &qos::ROW_IMPACT_EVENT,
                counters,
                |message: RowImpactEvent, info| {
                    // Columns that are elsewhere are those of another fleet on this topic.
                    let ids = &message.column_ids;
                    if !ids.is_empty() && ids.iter().all(|it| fleet.index_of(it).is_none()) {
                        return ignore(counters, &qos::ROW_IMPACT_EVENT, &ids[0]);
                    }
                    let id = message.event_id.chars().take(MAX_NAMED_CHARS);
                    let id = Printable(&id.collect::<String>()).to_string();
                    let sender = info.publisher_gid();
                    if admit(sender, "", &qos::ROW_IMPACT_EVENT, &id).is_err() {
                        return;
                    }
                    match self.row_impacts.take_event(message, fleet) {
                        Ok(()) => tracing::info!("row impact event \"{id}\" accepted"),
                        Err(reasons) => {
                            NodeCounters::count(&counters.rejected_rows);
                            tracing::warn!(
                                "row impact event \"{id}\" was rejected, no column is hit by it: {reasons}"
                            );
                        }
                    }
                }
            ),
            each(
                &self.column_parameters,
                &qos::COLUMN_PARAMETERS,
                counters,
                |message: ColumnParameters, info| {
                    let Some(column) = fleet.index_of(&message.column_id) else {
                        return ignore(counters, &qos::COLUMN_PARAMETERS, &message.column_id);
                    };
                    let (sender, column_id) = (info.publisher_gid(), message.column_id.as_str());
                    let what = "a set of parameters";
                    if admit(sender, column_id, &qos::COLUMN_PARAMETERS, what).is_err() {
                        return;
                    }
                    record(
                        &recording,
                        Some(column_id),
                        &qos::COLUMN_PARAMETERS,
                        &message,
                        Some(&info),
                    );
                    if let Err(refusal) = set_column(fleet, column, &message)
                        && !refusal.code.is_from_twin()
                    {
                        let endpoint = &qos::COLUMN_PARAMETERS;
                        not_taken(&recording, column_id, endpoint, what, &refusal);
                    }
                }
            ),
            answer_from(
                &qos::RESET_COLUMN,
                &self.reset,
                counters,
                |sender, request| {
                    let column_id = request.column_id.as_str();
                    let admitted = admit(sender, column_id, &qos::RESET_COLUMN, "a reset");
                    reset(admitted.and_then(|()| {
                        let column = known(fleet, &request.column_id)?;
                        let source = "service ~/reset_column".into();
                        fleet.execute(column, Command::Reset { source }).map(|_| ())
                    }))
                }
            ),
            answer(&qos::PREDICT, &self.predict, counters, |request| {
                predicted(fleet, &request)
            }),
            answer_from(
                &qos::CONFIRM_ESTIMATE,
                &self.confirm_estimate,
                counters,
                |sender, request| {
                    let (endpoint, what) = (&qos::CONFIRM_ESTIMATE, "a decision about an estimate");
                    let admitted = admit(sender, &request.column_id, endpoint, what);
                    let column = admitted.and_then(|()| known(fleet, &request.column_id));
                    requests::confirm_estimate(request, |command| fleet.execute(column?, command))
                }
            ),
            answer_from(
                &qos::CALIBRATE,
                &self.calibrate,
                counters,
                |sender, request| {
                    let (endpoint, what) = (&qos::CALIBRATE, "a calibration");
                    let admitted = admit(sender, &request.column_id, endpoint, what);
                    let column = admitted.and_then(|()| known(fleet, &request.column_id));
                    requests::calibrate(&request, |command| fleet.execute(column?, command))
                }
            ),
            answer(&qos::GET_PARAMETERS, &get, counters, |request| {
                parameters::get(fleet, &request)
            }),
            answer(&qos::GET_PARAMETER_TYPES, &types, counters, |request| {
                parameters::types(fleet, &request)
            }),
            answer(&qos::LIST_PARAMETERS, &list, counters, |request| {
                parameters::list(fleet, &request)
            }),
            answer(&qos::DESCRIBE_PARAMETERS, &describe, counters, |request| {
                parameters::describe(fleet, &request)
            }),
            answer_from(&qos::SET_PARAMETERS, &set, counters, |sender, request| {
                match admit(sender, "", &qos::SET_PARAMETERS, "a request") {
                    Ok(()) => parameters::set(fleet, &request),
                    Err(refusal) => set_rejected(&request, &refusal),
                }
            }),
            answer_from(
                &qos::SET_PARAMETERS_ATOMICALLY,
                &set_atomically,
                counters,
                |sender, request| {
                    match admit(sender, "", &qos::SET_PARAMETERS_ATOMICALLY, "a request") {
                        Ok(()) => parameters::set_atomically(fleet, request),
                        Err(refusal) => set_rejected_atomically(&refusal),
                    }
                }
            ),
            describe_types,
        );
    }
}

/// The column of a request, which somebody waits for: one that is elsewhere is rejected.
fn known(fleet: &FleetTwin, column_id: &str) -> Result<u32, Refusal> {
    fleet.index_of(column_id).ok_or_else(|| {
        let reason = format!(
            "column {column_id:?} is not in this fleet of {} columns; give the column_id of one of them, see fleet_status",
            fleet.column_ids().len()
        );
        Refusal::new(RefusalCode::OtherColumn, reason)
    })
}

fn reset(outcome: Result<(), Refusal>) -> ResetColumnResponse {
    match outcome {
        Ok(()) => ResetColumnResponse {
            success: true,
            refusal_code: TwinStatus::REFUSED_NONE,
            message: String::new(),
        },
        Err(Refusal { code, reason }) => ResetColumnResponse {
            success: false,
            refusal_code: code.number(),
            message: reason.to_string(),
        },
    }
}

fn predicted(fleet: &FleetTwin, request: &PredictImpactRequest) -> PredictImpactResponse {
    let prediction = known(fleet, &request.column_id).and_then(|column| {
        let prediction = fleet.predict(column, &request.vehicle, &request.into())?;
        Ok((prediction, fleet.parameters(column)))
    });
    match prediction {
        Ok((prediction, parameters)) => PredictImpactResponse {
            success: true,
            report: ImpactReport {
                header: Header {
                    stamp: Time::from_nanos(fleet.now()).unwrap_or_default(),
                    frame_id: parameters.settings().frame_id.clone(),
                },
                column_id: request.column_id.clone(),
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

fn set_column(
    fleet: &FleetTwin,
    column: u32,
    message: &ColumnParameters,
) -> Result<Accepted, Refusal> {
    let command = column_command(message, &message.column_id);
    let outcome = fleet.execute(column, command);
    match &outcome {
        Ok(_) => tracing::info!("parameters of column {:?} were accepted", message.column_id),
        // The twin reports its refusals among its outputs.
        Err(refusal) if refusal.code.is_from_twin() => {}
        Err(refusal) => tracing::warn!(
            "a change of parameters of column {:?} was rejected: {refusal}",
            message.column_id
        ),
    }
    outcome
}
