//! The parameters that exist once for each sensor in `sensors.names`, and the sensors that they describe.

use super::inconsistency::Inconsistency;
use super::parameter::Admissible::{self, Choice, Sign};
use super::parameter::{Applies, DefaultValue, Parameter, or_zero, parameters, real, text};
use super::section::{or_else, section_of};
use super::settings::{SensorAxis, SensorMessage, SensorSettings, Settings};
use super::value::{Kind, Value, readable};
use crate::sensors::{Quantity, Sensor};

/// The parameters of each sensor, which continue [`PARAMETERS`](super::PARAMETERS): each exists once for every element of
/// `sensors.names`, with the element in the place of `<name>`.
pub const SENSOR_PARAMETERS: &[Parameter] = parameters! {
    "sensors.<name>.quantity", "", Required(Kind::String), Choice(&Quantity::WORDS), Restart,
        "quantity that the sensor measures: transverse acceleration [m/s^2] or displacement [m], positive in the vehicle's direction; \
         rotation of the axis [rad], positive if it leans in this direction; bending strain of a fibre, positive for tension on the side \
         away from the vehicle; axial strain, tension positive; or contact force [N]";
    "sensors.<name>.height", "m", Required(Kind::Double), real(0.0, 200.0), Restart,
        "height of the sensor above the base, within the column; a contact force does not need it";
    "sensors.<name>.range", "", Double(0.0), or_zero(1e-12, 1e12, "no clipping"), Restart,
        "largest magnitude before the sensor clips, in the unit of its quantity";
    "sensors.<name>.noise", "", Double(0.0), ERROR, Restart,
        "root mean square of the noise, in the unit of the quantity";
    "sensors.<name>.bias", "", Double(0.0), ERROR, Restart,
        "standard deviation of the unknown constant offset, in the unit of the quantity";
    "sensors.<name>.gain_error", "", Double(0.0), real(0.0, 1.0), Restart,
        "standard deviation of the unknown gain from 1";
    "sensors.<name>.rate", "Hz", Double(10_000.0), real(1.0, 1e6), Restart, "number of samples per second";
    "sensors.<name>.bandwidth", "Hz", Double(0.0), or_zero(0.1, 1e6, "half the rate"), Restart,
        "cut-off frequency of the anti-alias filter; more than half the rate has the effect of half the rate";
    "sensors.<name>.sign", "", Integer(1), Sign, Restart,
        "-1 if the sensor is mounted in the opposite direction, so that its readings have the opposite sign";
    "sensors.<name>.fibre", "m", Double(0.0), or_zero(1e-4, 10.0, "half the section height"), Restart,
        "distance of the strained fibre from the centroid, on either side; for a bending strain only";
    "sensors.<name>.topic", "", Text(""), text(0, 255), Restart,
        "topic on which the sensor's messages arrive; empty: the topic measurements, which all sensors share. Sensors may share another \
         topic, too, if they have the same message";
    "sensors.<name>.message", "", Text("measurement"), Choice(&["measurement", "imu", "accel_stamped"]), Restart,
        "type of its messages: column_twin_msgs/msg/Measurement with a batch of samples, or one sample in the linear acceleration of \
         sensor_msgs/msg/Imu or of geometry_msgs/msg/AccelStamped";
    "sensors.<name>.axis", "", Text("x"), Choice(&["x", "y", "z"]), Restart,
        "component of the linear acceleration in the vehicle's direction, or against it with the sign -1; for imu and accel_stamped only";
};

/// Where the messages of a sensor come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SensorSource {
    /// Name of the topic before expansion and remapping; empty: that of the measurements.
    pub topic: String,
    /// Type of the messages.
    pub message: SensorMessage,
    /// Component of a message with a vector.
    pub axis: SensorAxis,
}

const ERROR: Admissible = real(0.0, 1e12);

/// What the name of a row has in the place of the name of a sensor.
pub(super) const PLACEHOLDER: &str = "<name>";

/// The group of all parameters of sensors.
pub(super) const GROUP: &str = "sensors";

/// The parameter that declares the sensors.
pub(super) const SENSOR_NAMES: &str = "sensors.names";

/// Most characters of the name of a sensor: errors show the first 60 of the name of a parameter, which contains it.
pub(super) const MAX_SENSOR_NAME_CHARS: usize = 40;

/// `sensors.names` is a parameter itself, and `time` is the first column of a table of measurements.
pub(super) const RESERVED_SENSOR_NAMES: [&str; 2] = ["names", "time"];

/// Whether a sensor may have this name.
pub(super) fn is_sensor_name(name: &str) -> bool {
    let is_part = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    (1..=MAX_SENSOR_NAME_CHARS).contains(&name.len())
        && name.bytes().all(is_part)
        && !RESERVED_SENSOR_NAMES.contains(&name)
}

/// The last part of a row's name, such as `height`.
pub(super) fn field(row: &Parameter) -> &'static str {
    row.name.rsplit('.').next().unwrap_or(row.name)
}

/// The name that a row has for a sensor.
pub(super) fn full_name(row: &Parameter, sensor: &str) -> String {
    with_sensor(row.name, sensor)
}

/// The name with the sensor in the place of its placeholder, if it has one.
pub(super) fn with_sensor(name: &str, sensor: &str) -> String {
    name.replacen(PLACEHOLDER, sensor, 1)
}

/// The sensor and the index of the row of a parameter of this name, whether or not the sensor is declared.
pub(super) fn sensor_and_row(name: &str) -> Option<(&str, usize)> {
    let (sensor, wanted) = name
        .strip_prefix(GROUP)?
        .strip_prefix('.')?
        .rsplit_once('.')?;
    let row = SENSOR_PARAMETERS
        .iter()
        .position(|row| field(row) == wanted)?;
    Some((sensor, row))
}

/// The full names of the parameters of all sensors, sensor by sensor, in the order of the rows.
pub(super) fn names_of_all(settings: &Settings) -> Vec<String> {
    let names = settings.sensors.names.iter();
    names
        .flat_map(|sensor| SENSOR_PARAMETERS.iter().map(|row| full_name(row, sensor)))
        .collect()
}

/// The values that belong to [`names_of_all`].
pub(super) fn values_of_all(settings: &Settings) -> impl Iterator<Item = Value> {
    declared(settings).flat_map(|(_, sensor)| sensor.values())
}

/// Whether a sensor of this quantity must have the parameter of the row.
pub(super) fn is_required(row: &Parameter, quantity: &Value) -> bool {
    let is_force = *quantity == Value::from(Quantity::ContactForce.word());
    matches!(row.default, DefaultValue::Required(_)) && !(field(row) == "height" && is_force)
}

/// Every sensor in `sensors.names` with what is given for it.
fn declared(settings: &Settings) -> impl Iterator<Item = (&str, &SensorSettings)> {
    let sensors = &settings.sensors;
    let names = sensors.names.iter();
    names.filter_map(|name| Some((name.as_str(), sensors.each.get(name)?)))
}

/// Where the messages of each sensor come from, in the order of [`sensors_of`].
pub(super) fn sources_of(settings: &Settings) -> Vec<SensorSource> {
    let source = |(_, given): (&str, &SensorSettings)| SensorSource {
        topic: given.topic.clone(),
        message: given.message,
        axis: given.axis,
    };
    declared(settings).map(source).collect()
}

/// The sensors with their open numbers filled in.
pub(super) fn sensors_of(settings: &Settings) -> Vec<Sensor> {
    let half_height = section_of(&settings.section).height / 2.0;
    let sensor = |(name, given): (&str, &SensorSettings)| {
        let half_rate = given.rate / 2.0;
        Sensor {
            name: name.to_owned(),
            quantity: given
                .quantity
                .parse()
                .expect("the quantity was checked with the other parameters"),
            height: given.height,
            range: given.range,
            noise: given.noise,
            bias: given.bias,
            gain_error: given.gain_error,
            rate: given.rate,
            bandwidth: or_else(given.bandwidth, half_rate).min(half_rate),
            reversed: given.sign < 0,
            fibre: or_else(given.fibre, half_height),
        }
    };
    declared(settings).map(sensor).collect()
}

/// The inconsistencies of each sensor; `<name>` in the names of parameters is the sensor.
pub(super) fn inconsistencies(settings: &Settings) -> Vec<(&str, Inconsistency)> {
    let mut found = Vec::new();
    for (name, sensor) in &settings.sensors.each {
        let name = name.as_str();
        found.extend(height_suits_the_column(sensor, settings).map(|it| (name, it)));
        found.extend(strain_has_a_fibre(sensor, settings).map(|it| (name, it)));
        found.extend(message_has_the_quantity(sensor).map(|it| (name, it)));
        found.extend(topic_has_one_message(name, sensor, settings).map(|it| (name, it)));
    }
    found
}

/// Messages of single samples contain accelerations, and their drivers do not publish on `measurements`.
fn message_has_the_quantity(sensor: &SensorSettings) -> Option<Inconsistency> {
    if sensor.message == SensorMessage::Measurement {
        return None;
    }
    let word = sensor.message.word();
    if sensor.quantity != Quantity::Acceleration.word() {
        return Some(Inconsistency {
            names: vec!["sensors.<name>.message", "sensors.<name>.quantity"],
            message: format!(
                "is {word}, of which only the linear acceleration is read, but the quantity is {}; choose the quantity acceleration, \
                 or the message measurement",
                sensor.quantity
            ),
        });
    }
    sensor.topic.is_empty().then(|| Inconsistency {
        names: vec!["sensors.<name>.topic", "sensors.<name>.message"],
        message: format!(
            "is required, because the message is {word}; give the topic on which the driver of the sensor publishes"
        ),
    })
}

fn topic_has_one_message(
    name: &str,
    sensor: &SensorSettings,
    settings: &Settings,
) -> Option<Inconsistency> {
    let each = settings.sensors.each.iter();
    let (other, its) = each
        .take_while(|(other, _)| *other != name)
        .find(|(_, it)| it.topic == sensor.topic && it.message != sensor.message)?;
    if sensor.topic.is_empty() {
        return None; // Reported already, because only measurements need no topic.
    }
    Some(Inconsistency {
        names: vec!["sensors.<name>.message", "sensors.<name>.topic"],
        message: format!(
            "is {}, but sensors.{other} expects {} on the same topic; a topic has one type of message",
            sensor.message.word(),
            its.message.word(),
        ),
    })
}

/// Sums of decimal lengths differ from the decimal sum by round-off.
const ROUND_OFF: f64 = 1.0 + 1e-9;

fn height_suits_the_column(sensor: &SensorSettings, settings: &Settings) -> Option<Inconsistency> {
    let geometry = &settings.geometry;
    let height = geometry.length_below + geometry.length_above;
    (sensor.height > height * ROUND_OFF).then(|| Inconsistency {
        names: vec![
            "sensors.<name>.height",
            "geometry.length_below",
            "geometry.length_above",
        ],
        message: format!(
            "is {} m, but the column is {} m high; give at most that",
            readable(sensor.height),
            readable(height)
        ),
    })
}

fn strain_has_a_fibre(sensor: &SensorSettings, settings: &Settings) -> Option<Inconsistency> {
    if sensor.quantity != Quantity::BendingStrain.word() {
        return None;
    }
    let height = section_of(&settings.section).height;
    let message = if height == 0.0 && sensor.fibre == 0.0 {
        "is required for a bending strain, because a user-defined section has no height; give the distance of the \
         fibre from the centroid in m, or section.height, or name the section"
            .to_owned()
    } else if height > 0.0 && sensor.fibre > height / 2.0 * ROUND_OFF {
        format!(
            "is {} m, outside the section, which is {} m high; give at most {} m, or 0 for half the section height",
            readable(sensor.fibre),
            readable(height),
            readable(height / 2.0)
        )
    } else {
        return None;
    };
    Some(Inconsistency {
        names: vec![
            "sensors.<name>.fibre",
            "section.height",
            "section.name",
            "sensors.<name>.quantity",
        ],
        message,
    })
}
