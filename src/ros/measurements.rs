//! The measurements over DDS: from the topics of the sensors through their intake to the recording and to the queue.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use futures::FutureExt;
use futures::future::{LocalBoxFuture, join_all};
use ros2_client::MessageInfo;

use crate::estimation::{BatchRejection, Collector, EstimatorError, Intake, SensorHealth};
use crate::incoming::raw_batch;
use crate::live::FleetMeasurements;
use crate::messages::Message as _;
use crate::messages::builtin_interfaces::Time;
use crate::messages::cdr;
use crate::messages::column_twin_msgs::Measurement;
use crate::messages::geometry_msgs::{AccelStamped, Vector3};
use crate::messages::sensor_msgs::Imu;
use crate::messages::std_msgs::Header;
use crate::outgoing::RecordingTap;
use crate::parameters::{SensorAxis, SensorMessage};
use crate::time::Nanos;

use super::counters::NodeCounters;
use super::live_columns::LiveColumns;
use super::node::{Node, NodeError};
use super::qos::{self, Endpoint};
use super::receiving::{Receiving, each_on};
use super::senders::Rejected;
use super::sensor_watch::{SensorLog, SensorStatus, SensorWatch};
use super::transport::Subscription;

/// Batches of one column of a fleet in the history of its topic: what two sensors send in 80 ms, in batches of 10 ms.
const DEPTH_OF_A_COLUMN: usize = 16;

/// Most batches in the history of the topic of a fleet.
const MAX_DEPTH: usize = 16_384;

/// Takes the measurements of all sensors of a column, from whatever topic: into the recording, and into the queue of those who use
/// them.
pub(super) struct SensorInputs {
    column: u32,
    column_id: String,
    intake: Arc<Mutex<Intake>>,
    queues: FleetMeasurements,
    recording: Option<Arc<dyn RecordingTap>>,
    /// The column, as in [`RecordingTap`].
    recorded: Option<String>,
    watch: Mutex<SensorWatch>,
}

impl SensorInputs {
    /// Those of a column with sensors; `log` is shared by all columns.
    fn new(
        columns: &LiveColumns,
        column: u32,
        queues: &FleetMeasurements,
        log: &Arc<SensorLog>,
        recording: Option<Arc<dyn RecordingTap>>,
    ) -> Self {
        let face = columns.face();
        let column_id = face.id(column);
        let sensors = columns.initial_parameters(column).sensors();
        let intake = Arc::new(Mutex::new(Intake::new(&sensors, column_id)));
        if let Some(recording) = &recording {
            recording.sensors(face.recorded(column), &intake);
        }
        let of = face.words("of", column);
        let too_slow = EstimatorError::unless_fast_enough(&sensors).err();
        let undetected = too_slow.map(|it| it.to_string());
        let log = Arc::clone(log);
        let watch = SensorWatch::new(sensors.len(), undetected, columns.now(), of, log);
        Self {
            column,
            column_id: column_id.to_owned(),
            intake,
            queues: queues.clone(),
            recording,
            recorded: face.recorded(column).map(str::to_owned),
            watch: Mutex::new(watch),
        }
    }

    /// The index of the column.
    pub fn column(&self) -> u32 {
        self.column
    }

    /// The identifier of the column.
    pub fn column_id(&self) -> &str {
        &self.column_id
    }

    /// Takes a batch that arrived at `received`, by the clock that drives the twin.
    fn take(&self, measurement: &Measurement, received: Nanos) {
        // Locked until the batch is recorded: a checkpoint of the journal has the intake after what was recorded before.
        let mut intake = self.intake();
        let taken = intake.take(&raw_batch(measurement), received);
        let is_needed = match &taken {
            Ok(_) => true,
            Err(rejection) => rejection.depends_on_order(),
        };
        // Before anything can follow from it.
        if is_needed {
            self.record(measurement, received, &intake);
        }
        drop(intake);
        match taken {
            Ok(batch) => self.queues.push(self.column, batch),
            // Columns may share a topic.
            Err(BatchRejection::OtherColumn { .. }) => {}
            Err(rejection) => {
                let mut watch = self.watch();
                watch.rejected(&measurement.sensor_id, &rejection, Instant::now());
            }
        }
    }

    fn record(&self, measurement: &Measurement, received: Nanos, intake: &Intake) {
        let Some(recording) = &self.recording else {
            return;
        };
        match cdr::encode(measurement) {
            Ok(bytes) => {
                let column = self.recorded.as_deref();
                recording.measured(column, &qos::MEASUREMENTS, bytes, received, intake);
            }
            Err(error) => {
                recording.rejected(
                    self.recorded.as_deref(),
                    &qos::MEASUREMENTS,
                    "a batch",
                    None,
                    &error.to_string(),
                );
            }
        }
    }

    /// The health of the sensors.
    pub fn health(&self, now: Nanos) -> Vec<SensorHealth> {
        self.intake().health(now)
    }

    /// Logs what has changed since the last call, and returns the health of the sensors.
    pub fn status(&self, now: Nanos) -> SensorStatus {
        let (health, strays) = {
            let intake = self.intake();
            (intake.health(now), intake.strays().clone())
        };
        let lost = self.queues.lost_of(self.column);
        let mut watch = self.watch();
        watch.status(&health, &strays, lost, now)
    }

    /// Logs what has changed since the last call, and returns the health of the sensors, what is wrong with them, and the batches that
    /// were lost because the estimation did not take them in time.
    pub fn problems(&self, now: Nanos) -> (Vec<SensorHealth>, Vec<String>, u64) {
        let (health, strays) = {
            let intake = self.intake();
            (intake.health(now), intake.strays().clone())
        };
        let lost = self.queues.lost_of(self.column);
        let problems = self.watch().problems(&health, &strays, lost, now);
        (health, problems, lost)
    }

    fn intake(&self) -> MutexGuard<'_, Intake> {
        self.intake.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn watch(&self) -> MutexGuard<'_, SensorWatch> {
        self.watch.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The columns of a node with sensors.
pub(super) struct SensedColumns {
    columns: Arc<LiveColumns>,
    sensed: Vec<SensorInputs>,
    /// Their places in `sensed`, by the indices of the columns.
    places: HashMap<u32, usize>,
    /// Batches for columns that are not here, or have no sensors.
    strays: AtomicU64,
}

impl SensedColumns {
    /// `None` if no column has sensors.
    pub fn new(
        columns: &Arc<LiveColumns>,
        recording: Option<&Arc<dyn RecordingTap>>,
    ) -> Option<Arc<Self>> {
        let queues = columns.measurements()?;
        let log = Arc::<SensorLog>::default();
        let all = (0..).zip(columns.face().ids()).map(|(column, _)| column);
        let sensed: Vec<_> = all
            .filter(|column| !columns.initial_parameters(*column).sensors().is_empty())
            .map(|column| SensorInputs::new(columns, column, queues, &log, recording.cloned()))
            .collect();
        Some(Arc::new(Self {
            columns: Arc::clone(columns),
            places: sensed.iter().map(SensorInputs::column).zip(0..).collect(),
            sensed,
            strays: AtomicU64::new(0),
        }))
    }

    /// All of them.
    pub fn columns(&self) -> &[SensorInputs] {
        &self.sensed
    }

    /// Batches for columns that are not here, or have no sensors.
    pub fn strays(&self) -> u64 {
        self.strays.load(Ordering::Relaxed)
    }

    fn take(&self, measurement: &Measurement, received: Nanos) {
        let column = self.columns.face().addressed(&measurement.column_id);
        let place = column.and_then(|it| self.places.get(&it));
        match place.and_then(|it| self.sensed.get(*it)) {
            Some(column) => column.take(measurement, received),
            None => {
                self.strays.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
}

/// A sensor that sends each sample in a message of its own.
struct Collecting {
    /// The place of its column among those with sensors.
    place: usize,
    name: String,
    axis: SensorAxis,
    period: f64,
    collector: Collector,
}

impl Collecting {
    /// Takes a sample: the message that a sender of batches would have sent, if one is complete.
    fn push(&mut self, column_id: &str, stamp: Nanos, vector: &Vector3) -> Option<Measurement> {
        let value = match self.axis {
            SensorAxis::X => vector.x,
            SensorAxis::Y => vector.y,
            SensorAxis::Z => vector.z,
        };
        let collected = self.collector.push(stamp, value as f32)?;
        Some(Measurement {
            header: Header {
                stamp: Time::from_nanos(collected.stamp).unwrap_or_default(),
                frame_id: String::new(),
            },
            column_id: column_id.to_owned(),
            sensor_id: self.name.clone(),
            sample_period: self.period,
            values: collected.values,
        })
    }
}

/// A topic of sensors.
enum Topic {
    Measurements(Subscription<Measurement>),
    Imu(Subscription<Imu>, Vec<Collecting>),
    Accel(Subscription<AccelStamped>, Vec<Collecting>),
}

impl Topic {
    fn message(&self) -> SensorMessage {
        match self {
            Self::Measurements(_) => SensorMessage::Measurement,
            Self::Imu(..) => SensorMessage::Imu,
            Self::Accel(..) => SensorMessage::AccelStamped,
        }
    }
}

/// The subscriptions of all topics of the sensors.
pub(super) struct MeasurementSubscriptions {
    inputs: Arc<SensedColumns>,
    receiving: Receiving,
    /// With the names of the topics.
    topics: Vec<(String, Topic)>,
}

impl MeasurementSubscriptions {
    /// Subscribes to `measurements`, with a history for these columns, and to the topics that their parameters name.
    pub fn new(
        node: &mut Node,
        inputs: Arc<SensedColumns>,
        receiving: Receiving,
    ) -> Result<Self, NodeError> {
        let mut endpoint = qos::MEASUREMENTS;
        let depth = inputs.sensed.len().saturating_mul(DEPTH_OF_A_COLUMN);
        endpoint.qos.depth = depth.clamp(endpoint.qos.depth, MAX_DEPTH);
        let mut topics = vec![subscribe_to_measurements(node, &endpoint)?];
        for (place, column) in inputs.sensed.iter().enumerate() {
            subscribe_to_sensors(node, &mut topics, place, &inputs.columns, column.column)?;
        }
        Ok(Self {
            inputs,
            receiving,
            topics,
        })
    }

    /// Takes measurements until the task is stopped.
    pub async fn run(self) {
        let Self {
            inputs,
            receiving,
            mut topics,
        } = self;
        let (inputs, counters) = (&*inputs, &*receiving.counters);
        // A simulated clock cannot be before its beginning, but a message can say so.
        let now = || receiving.columns.now().max(0);
        let now = &now;
        let admits = |info: &MessageInfo, topic: &str| {
            let (senders, at) = (&receiving.senders, Instant::now());
            let admitted = receiving
                .check_active(&qos::MEASUREMENTS, at)
                .and_then(|()| senders.admit_stream(info.publisher_gid(), at));
            let told = |rejected: &Rejected| {
                let what = format!("a measurement on {topic}");
                receiving.tell(None, &qos::MEASUREMENTS, &what, rejected);
            };
            admitted.inspect_err(told).is_ok()
        };
        let admits = &admits;
        let collected = |collecting: &mut [Collecting], stamp: Time, vector: &Vector3| {
            for sensor in collecting {
                let Some(column) = inputs.sensed.get(sensor.place) else {
                    return;
                };
                let Some(stamp) = stamp.to_nanos() else {
                    NodeCounters::count(&counters.unreadable);
                    return;
                };
                let complete = sensor.push(&column.column_id, stamp, vector);
                if let Some(measurement) = complete {
                    column.take(&measurement, now());
                }
            }
        };
        let collected = &collected;
        let runs = topics.iter_mut().map(|(name, topic)| {
            let name = name.as_str();
            let run: LocalBoxFuture<'_, ()> = match topic {
                Topic::Measurements(subscription) => each_on(
                    subscription,
                    name,
                    false,
                    counters,
                    move |message: Measurement, info| {
                        if admits(&info, name) {
                            inputs.take(&message, now());
                        }
                    },
                )
                .boxed_local(),
                Topic::Imu(subscription, collecting) => each_on(
                    subscription,
                    name,
                    false,
                    counters,
                    move |message: Imu, info| {
                        if admits(&info, name) {
                            let vector = acceleration(&message);
                            collected(collecting, message.header.stamp, &vector);
                        }
                    },
                )
                .boxed_local(),
                Topic::Accel(subscription, collecting) => each_on(
                    subscription,
                    name,
                    false,
                    counters,
                    move |message: AccelStamped, info| {
                        if admits(&info, name) {
                            let vector = &message.accel.linear;
                            collected(collecting, message.header.stamp, vector);
                        }
                    },
                )
                .boxed_local(),
            };
            run
        });
        join_all(runs).await;
    }
}

/// Subscribes to the topic that sensors share.
fn subscribe_to_measurements(
    node: &mut Node,
    endpoint: &Endpoint,
) -> Result<(String, Topic), NodeError> {
    let full = node.names().resolve(endpoint.kind(), endpoint.name)?;
    let subscription = node.subscription(endpoint)?;
    Ok((full, Topic::Measurements(subscription)))
}

/// Subscribes to the topics that the parameters of a column name, unless another sensor has done so.
fn subscribe_to_sensors(
    node: &mut Node,
    topics: &mut Vec<(String, Topic)>,
    place: usize,
    columns: &LiveColumns,
    column: u32,
) -> Result<(), NodeError> {
    let parameters = columns.initial_parameters(column);
    let (sensors, sources) = (parameters.sensors(), parameters.sensor_sources());
    for (sensor, source) in sensors.iter().zip(&sources) {
        if source.topic.is_empty() {
            continue;
        }
        let kind = qos::MEASUREMENTS.kind();
        let topic = columns.face().topic_of(column, &source.topic);
        let full = node.names().resolve(kind, &topic)?;
        let known = topics.iter().position(|(name, _)| *name == full);
        let index = match known {
            Some(index) => index,
            None => {
                let topic = subscribe(node, &topic, source.message)?;
                topics.push((full.clone(), topic));
                topics.len() - 1
            }
        };
        let topic = &mut topics[index].1;
        if topic.message() != source.message {
            return Err(NodeError::Endpoint {
                what: full,
                reason: format!(
                    "sensors.{}.message is {}, but messages of the type {} are expected on this topic already; name \
                     another topic",
                    sensor.name,
                    source.message.word(),
                    topic.message().word()
                ),
            });
        }
        if let Topic::Imu(_, collecting) | Topic::Accel(_, collecting) = topic {
            collecting.push(Collecting {
                place,
                name: sensor.name.clone(),
                axis: source.axis,
                period: 1.0 / sensor.rate,
                collector: Collector::new(sensor.rate),
            });
        }
    }
    Ok(())
}

fn subscribe(node: &mut Node, topic: &str, message: SensorMessage) -> Result<Topic, NodeError> {
    let qos = &qos::SENSOR_DATA;
    Ok(match message {
        SensorMessage::Measurement => {
            let type_name = qos::MEASUREMENTS.type_name;
            Topic::Measurements(node.subscription_of(topic, type_name, qos)?)
        }
        SensorMessage::Imu => {
            let type_name = Imu::INTERFACE.ros_name();
            Topic::Imu(node.subscription_of(topic, &type_name, qos)?, Vec::new())
        }
        SensorMessage::AccelStamped => {
            let type_name = AccelStamped::INTERFACE.ros_name();
            Topic::Accel(node.subscription_of(topic, &type_name, qos)?, Vec::new())
        }
    })
}

/// The acceleration, of which the first covariance is -1 if the unit does not measure it.
fn acceleration(message: &Imu) -> Vector3 {
    const NOT_MEASURED: f64 = -1.0;
    if message.linear_acceleration_covariance[0] == NOT_MEASURED {
        return Vector3 {
            x: f64::NAN,
            y: f64::NAN,
            z: f64::NAN,
        };
    }
    message.linear_acceleration
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_of_single_samples_becomes_measurements() {
        let mut sensor = Collecting {
            place: 0,
            name: "a".to_owned(),
            axis: SensorAxis::Y,
            period: 1e-3,
            collector: Collector::new(1e3),
        };
        let first = 5_000_000_000;
        let complete: Vec<_> = (0..10)
            .filter_map(|k| {
                let message = Imu {
                    linear_acceleration: Vector3 {
                        x: 9.81,
                        y: k as f64,
                        z: -1.0,
                    },
                    linear_acceleration_covariance: [if k == 7 { -1.0 } else { 0.0 }; 9],
                    ..Imu::default()
                };
                sensor.push("c", first + k * 1_000_000, &acceleration(&message))
            })
            .collect();
        assert_eq!(complete.len(), 2);
        let Measurement {
            header,
            column_id,
            sensor_id,
            sample_period,
            values,
        } = &complete[0];
        assert_eq!(header.stamp.to_nanos(), Some(first));
        assert_eq!((column_id.as_str(), sensor_id.as_str()), ("c", "a"));
        assert_eq!(
            (*sample_period, values.as_slice()),
            (1e-3, &[0.0, 1.0, 2.0, 3.0, 4.0][..])
        );
        assert!(complete[1].values[2].is_nan());
        assert_eq!(complete[1].values[3], 8.0);
    }
}
