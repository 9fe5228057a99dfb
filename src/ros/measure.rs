//! `column-twin measure`: publishes a table of readings as the sensors would, in real time.

use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crate::estimation::Readings;
use crate::messages::builtin_interfaces::Time;
use crate::messages::column_twin_msgs::Measurement;
use crate::messages::std_msgs::Header;
use crate::sensors::Sensor;

use super::client_error::ClientError;
use super::node::Node;
use super::qos;
use super::subscribed::Search;
use super::task::Task;
use ros_node::environment::Environment;
use ros_node::names::{Names, RemapRule};
use ros_node::signals::StopSignals;

/// Time before the first batch in which the twin finds this publisher. Each discovers the other independently, so the twin may be
/// some milliseconds late, and more on a busy machine. What arrives before that is lost: best effort repeats nothing, and a reader
/// does not report that it is ready.
const TIME_TO_BE_FOUND: Duration = Duration::from_secs(1);

/// Time at the end in which the last batch leaves.
const LAST_BATCH_TIME: Duration = Duration::from_millis(300);

/// Longest table \[s\]: a day.
const MAX_DURATION: f64 = 86_400.0;

/// Longest sleep before the program checks whether it is asked to stop.
const CHECK_INTERVAL: Duration = Duration::from_millis(100);

/// Readings to publish.
#[derive(Debug, Clone)]
pub struct MeasureOptions {
    /// Identifier of the column.
    pub column_id: String,
    /// The sensors, in the order of the columns of the readings.
    pub sensors: Vec<Sensor>,
    /// What they read.
    pub readings: Readings,
    /// Duration of a batch, at least a millisecond.
    pub batch: Duration,
    /// Timeout for finding a twin with sensors.
    pub match_timeout: Duration,
}

/// What was published.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Measured {
    /// Batches.
    pub batches: u64,
    /// Samples in them.
    pub samples: u64,
    /// Batches that could not be sent.
    pub failed: u64,
}

/// A batch that is due when its last sample has been taken.
#[derive(Debug, Clone, PartialEq)]
struct Due {
    sensor: usize,
    /// Times from the first row of the table on \[s\].
    first: f64,
    at: f64,
    values: Vec<f32>,
}

/// Publishes the readings: the first row as soon as a twin can receive it, and each batch as soon as its last sample would have been
/// taken. `say` receives progress messages.
///
/// # Errors
/// No twin with sensors is found, or the program is asked to stop.
pub fn send_measurements(
    environment: &Environment,
    rules: &[RemapRule],
    options: &MeasureOptions,
    say: &mut dyn FnMut(&str),
) -> Result<Measured, ClientError> {
    let signals = StopSignals::listen()?;
    let names = Names::new(&environment.namespace, "column_twin_measure", rules)?;
    let mut node = Node::new(environment, names)?;
    let publisher = node.publisher::<Measurement>(&qos::MEASUREMENTS)?;
    let events = node.participant_events();
    let task = Task::start("column_twin/see", move || events)?;
    let outcome = (|| {
        let search = Search {
            node: &node,
            environment,
            signals: &signals,
            endpoint: &qos::MEASUREMENTS,
            timeout: options.match_timeout,
        };
        search.wait_for("a twin with sensors", &[publisher.guid()], say)?;
        let due = batches(options);
        let duration = due.last().map_or(0.0, |last| last.at);
        if duration.is_nan() || duration > MAX_DURATION {
            return Err(ClientError::TooLong {
                found: duration,
                most: MAX_DURATION,
            });
        }
        say(&format!(
            "sending {} batches of {} sensors in {duration:.2} s",
            due.len(),
            options.sensors.len()
        ));
        thread::sleep(TIME_TO_BE_FOUND);
        let begun = Instant::now();
        let since_epoch = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        let begun_stamp = i64::try_from(since_epoch.as_nanos()).unwrap_or(i64::MAX);
        let mut measured = Measured::default();
        for batch in due {
            let at = begun + Duration::from_secs_f64(batch.at);
            loop {
                if signals.asked() {
                    return Err(ClientError::Interrupted);
                }
                let left = at.saturating_duration_since(Instant::now());
                if left.is_zero() {
                    break;
                }
                thread::sleep(left.min(CHECK_INTERVAL));
            }
            let samples = batch.values.len() as u64;
            match publisher.publish(message(options, batch, begun_stamp)) {
                Ok(()) => {
                    measured.batches += 1;
                    measured.samples += samples;
                }
                Err(_) => measured.failed += 1,
            }
        }
        thread::sleep(LAST_BATCH_TIME);
        Ok(measured)
    })();
    task.stop();
    outcome
}

fn message(options: &MeasureOptions, batch: Due, begun: i64) -> Measurement {
    let sensor = &options.sensors[batch.sensor];
    let stamp = begun.saturating_add((1e9 * batch.first).round() as i64);
    Measurement {
        header: Header {
            stamp: Time::from_nanos(stamp).unwrap_or_default(),
            frame_id: String::new(),
        },
        column_id: options.column_id.clone(),
        sensor_id: sensor.name.clone(),
        sample_period: 1.0 / sensor.rate,
        values: batch.values,
    }
}

/// The batches in the order in which they are due. A sensor whose rate is lower than that of the table has a value in some of
/// its rows only; where one is missing at its own rate, the batch contains NaN.
fn batches(options: &MeasureOptions) -> Vec<Due> {
    let readings = &options.readings;
    let start = readings.times.first().copied().unwrap_or_default();
    let mut due = Vec::new();
    for (index, sensor) in options.sensors.iter().enumerate() {
        let most = (options.batch.as_secs_f64() * sensor.rate).round().max(1.0) as usize;
        let mut open: Option<Due> = None;
        for (time, values) in readings.rows() {
            let value = values[index];
            if value.is_nan() {
                continue;
            }
            let time = time - start;
            let place = open
                .as_ref()
                .map(|batch| ((time - batch.first) * sensor.rate).round() as usize);
            // A pause of the sensor is no row of missing samples.
            if place.is_some_and(|place| place >= most) {
                due.extend(open.take());
            }
            let batch = open.get_or_insert_with(|| Due {
                sensor: index,
                first: time,
                at: 0.0,
                values: Vec::with_capacity(most),
            });
            let place = ((time - batch.first) * sensor.rate).round() as usize;
            batch.values.resize(place.max(batch.values.len()), f32::NAN);
            batch.values.push(value as f32);
            batch.at = batch.first + batch.values.len() as f64 / sensor.rate;
        }
        due.extend(open);
    }
    due.sort_by(|a, b| a.at.total_cmp(&b.at).then(a.sensor.cmp(&b.sensor)));
    due
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::Quantity;

    fn sensor(name: &str, rate: f64) -> Sensor {
        Sensor {
            name: name.to_owned(),
            quantity: Quantity::Displacement,
            height: 1.0,
            range: 0.0,
            noise: 0.0,
            bias: 0.0,
            gain_error: 0.0,
            rate,
            bandwidth: rate / 2.0,
            reversed: false,
            fibre: 0.0,
        }
    }

    #[test]
    fn a_table_becomes_the_batches_of_its_sensors() {
        let nan = f64::NAN;
        // The second sensor has half the rate, and loses its third sample.
        let rows: [[f64; 3]; 8] = [
            [-0.002, 0.0, 10.0],
            [-0.001, 1.0, nan],
            [0.0, 2.0, 11.0],
            [0.001, 3.0, nan],
            [0.002, 4.0, nan],
            [0.003, 5.0, nan],
            [0.004, 6.0, 13.0],
            [0.005, 7.0, nan],
        ];
        let options = MeasureOptions {
            column_id: "column".to_owned(),
            sensors: vec![sensor("fast", 1000.0), sensor("slow", 500.0)],
            readings: Readings {
                times: rows.iter().map(|row| row[0]).collect(),
                values: rows.iter().flat_map(|row| [row[1], row[2]]).collect(),
                sensors: 2,
            },
            batch: Duration::from_millis(4),
            match_timeout: Duration::ZERO,
        };
        let due = batches(&options);
        let facts: Vec<_> = due
            .iter()
            .map(|it| {
                let [first, at] = [it.first, it.at].map(|time| (1e3 * time).round());
                (it.sensor, first, at, it.values.clone())
            })
            .collect();
        let expected = [
            (0, 0.0, 4.0, vec![0.0, 1.0, 2.0, 3.0]),
            (1, 0.0, 4.0, vec![10.0, 11.0]),
            (0, 4.0, 8.0, vec![4.0, 5.0, 6.0, 7.0]),
            (1, 6.0, 8.0, vec![13.0]),
        ];
        assert_eq!(facts, expected);
        let sent = message(&options, due[3].clone(), 1_000_000_000);
        assert_eq!(sent.header.stamp.to_nanos(), Some(1_006_000_000));
        assert_eq!((sent.sample_period, &*sent.sensor_id), (0.002, "slow"));
    }
}
