//! Measurements from the topics of the sensors, as the node counts them.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use column_twin::live::LiveOptions;
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::column_twin_msgs::Measurement;
use column_twin::messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use column_twin::messages::geometry_msgs::{Accel, AccelStamped, Vector3};
use column_twin::messages::sensor_msgs::Imu;
use column_twin::messages::std_msgs::Header;
use column_twin::parameters::{Parameters, Value, parse_override};
use column_twin::ros::qos::{self, Endpoint};
use column_twin::ros::{LiveColumns, Names, TwinNode};

use super::domain::{Domain, PATIENCE};
use super::live_twin::RunningTwin;
use super::loopback::{Incoming, Outgoing, now, reader};

/// A laser on the topic `measurements`, and accelerometers with common drivers.
fn sensors() -> Vec<(&'static str, Value)> {
    let names = ["laser", "imu_y", "imu_z", "accelerometer"].map(str::to_owned);
    let mut values = vec![
        ("sensors.names", Value::from(names.to_vec())),
        ("sensors.laser.quantity", "displacement".into()),
        ("sensors.laser.height", 1.0.into()),
        ("sensors.laser.rate", 10_000.0.into()),
    ];
    for (quantity, height, rate, topic, message, axis, [topic_value, message_value, axis_value]) in [
        (
            "sensors.imu_y.quantity",
            "sensors.imu_y.height",
            "sensors.imu_y.rate",
            "sensors.imu_y.topic",
            "sensors.imu_y.message",
            "sensors.imu_y.axis",
            ["/imu", "imu", "y"],
        ),
        (
            "sensors.imu_z.quantity",
            "sensors.imu_z.height",
            "sensors.imu_z.rate",
            "sensors.imu_z.topic",
            "sensors.imu_z.message",
            "sensors.imu_z.axis",
            ["/imu", "imu", "z"],
        ),
        (
            "sensors.accelerometer.quantity",
            "sensors.accelerometer.height",
            "sensors.accelerometer.rate",
            "sensors.accelerometer.topic",
            "sensors.accelerometer.message",
            "sensors.accelerometer.axis",
            ["driver/accel", "accel_stamped", "x"],
        ),
    ] {
        values.extend([
            (quantity, "acceleration".into()),
            (height, 1.0.into()),
            (rate, 1000.0.into()),
            (topic, topic_value.into()),
            (message, message_value.into()),
            (axis, axis_value.into()),
        ]);
    }
    values
}

fn header(stamp: i64) -> Header {
    Header {
        stamp: Time::from_nanos(stamp).unwrap(),
        frame_id: String::new(),
    }
}

/// The status of the sensors, and what it says of one of them.
fn status(array: &DiagnosticArray) -> Option<&DiagnosticStatus> {
    let mut statuses = array.status.iter();
    statuses.find(|it| it.name.ends_with(": sensors"))
}

/// What the status of the sensors says under this key.
fn value<'a>(array: &'a DiagnosticArray, key: &str) -> Option<&'a str> {
    let mut values = status(array)?.values.iter();
    values.find(|it| it.key == key).map(|it| it.value.as_str())
}

fn says(array: &DiagnosticArray, sensor: &str, text: &str) -> bool {
    value(array, sensor).is_some_and(|it| it.contains(text))
}

/// Waits until the node says this of a sensor; if it never does, the test fails with what the node said last.
fn expect(diagnostics: &Incoming<DiagnosticArray>, sensor: &str, text: &str) -> DiagnosticArray {
    let mut last = None;
    let deadline = Instant::now() + PATIENCE;
    while let Some(rest) = deadline.checked_duration_since(Instant::now()) {
        let Ok(array) = diagnostics.messages.recv_timeout(rest) else {
            break;
        };
        if says(&array, sensor, text) {
            return array;
        }
        last = status(&array).cloned().or(last);
    }
    panic!("{sensor} has to say {text:?}, but the last status was {last:#?}");
}

#[test]
fn batches_and_single_samples_are_taken_and_counted() {
    const BATCHES: i64 = 20;
    let domain = Domain::fresh();
    let twin = RunningTwin::start(&domain, &sensors());
    let mut reader = reader(&domain);
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut reader, &qos::DIAGNOSTICS);
    let waiting = diagnostics.find("the status of the sensors", |it| status(it).is_some());
    let status = status(&waiting).unwrap();
    assert_eq!(status.level, DiagnosticStatus::WARN);
    assert!(status.message.contains("laser has not sent anything"));
    let batches = Outgoing::<Measurement>::start(&domain, &qos::MEASUREMENTS);
    let imu = Endpoint {
        name: "/imu",
        type_name: "sensor_msgs/msg/Imu",
        ..qos::MEASUREMENTS
    };
    let accel = Endpoint {
        name: "/driver/accel",
        type_name: "geometry_msgs/msg/AccelStamped",
        ..qos::MEASUREMENTS
    };
    let imus = Outgoing::<Imu>::start(&domain, &imu);
    let accels = Outgoing::<AccelStamped>::start(&domain, &accel);
    for publisher in [batches.guid(), imus.guid(), accels.guid()] {
        twin.wait_for(publisher);
    }
    // In the past, so that no batch arrives before its last sample.
    let start = now() - 1_000_000_000;
    let batch = |sensor: &str, stamp: i64, column: &str| Measurement {
        header: header(stamp),
        column_id: column.to_owned(),
        sensor_id: sensor.to_owned(),
        sample_period: 1e-4,
        values: vec![0.5; 100],
    };
    for k in 0..BATCHES {
        // One batch does not arrive, and one arrives twice.
        if k != 10 {
            assert!(batches.publish(batch("laser", start + k * 10_000_000, "column")));
        }
        if k == 5 {
            assert!(batches.publish(batch("laser", start + k * 10_000_000, "column")));
        }
        for sample in 0..5 {
            let stamp = start + (5 * k + sample) * 1_000_000;
            let linear = Vector3 {
                x: 1.0,
                y: 2.0,
                z: 9.81,
            };
            assert!(imus.publish(Imu {
                header: header(stamp),
                linear_acceleration: linear,
                ..Imu::default()
            }));
            assert!(accels.publish(AccelStamped {
                header: header(stamp),
                accel: Accel {
                    linear,
                    ..Accel::default()
                },
            }));
            // Slower than the sensors: what comes in bursts on topics of best effort may be lost.
            std::thread::sleep(Duration::from_millis(4));
        }
    }
    assert!(batches.publish(batch("camera", start, "column")));
    assert!(batches.publish(batch("laser", start, "another column")));
    for (sensor, text) in [
        ("laser", "1900 samples in 19 batches"),
        ("laser", "100 lost, 100 duplicates, 0 late"),
        ("imu_y", "100 samples in 20 batches"),
        ("imu_z", "100 samples in 20 batches"),
        ("accelerometer", "100 samples in 20 batches"),
        ("batches of unknown sensors", "1"),
        ("last unknown sensor", "no sensor is called \"camera\""),
        ("batches for other columns", "1"),
    ] {
        expect(&diagnostics, sensor, text);
    }
    // None of them sends any more.
    expect(&diagnostics, "laser", "dead for");
    drop(diagnostics);
    twin.stop();
}

fn config(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("config")
        .join(name)
}

#[test]
fn a_simulated_table_is_published_as_its_sensors_would() {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().unwrap();
    let files = ["heb220_s355.yaml", "sensors_industrial.yaml"].map(config);
    let table = folder.path().join("readings.csv");
    let program = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_column-twin"));
        command
            .args(arguments)
            .current_dir(folder.path())
            .env("ROS_DOMAIN_ID", domain.environment.domain_id.to_string())
            .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST");
        for file in &files {
            command.arg("--config").arg(file);
        }
        command
    };
    let simulated = program(&[
        "simulate",
        "--mass",
        "1500",
        "--velocity",
        "10",
        "--readings",
        "readings.csv",
    ])
    .output()
    .unwrap();
    assert!(simulated.status.success(), "{simulated:?}");
    let text = std::fs::read_to_string(&table).unwrap();
    let rows = text.lines().count() - 1;
    let clipped = text.lines().skip(1).filter(|row| {
        let cell = row.split(',').nth(1).unwrap();
        cell.parse::<f64>().unwrap().abs() > 490.33
    });
    let clipped = clipped.count();
    println!("{rows} rows, {clipped} of them clipped");

    let overrides = [
        "state.directory:=''",
        "real_time.priority:=0",
        "real_time.lock_memory:=false",
    ];
    let parameters = Parameters::load(&files, &overrides.map(parse_override)).unwrap();
    let (twin, outputs) = LiveColumns::start_one(parameters, LiveOptions::default()).unwrap();
    let names = Names::new("/", "column_twin", &[]).unwrap();
    let node = TwinNode::start(&domain.environment, names, twin, outputs, None, None).unwrap();
    let mut reader = reader(&domain);
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut reader, &qos::DIAGNOSTICS);
    let sent = program(&["measure", "readings.csv", "--timeout", "30"])
        .output()
        .unwrap();
    assert!(sent.status.success(), "{sent:?}");
    let shown = String::from_utf8(sent.stdout).unwrap();
    let expected = format!("sent {} samples", 3 * rows);
    assert!(shown.contains(&expected), "{shown} {expected}");
    let all = format!("{rows} samples in");
    for sensor in ["accelerometer", "laser", "base_strain"] {
        let array = expect(&diagnostics, sensor, &all);
        assert!(
            says(&array, sensor, "0 lost, 0 duplicates, 0 late"),
            "{array:?}"
        );
    }
    let expected = format!(", {clipped} clipped");
    expect(&diagnostics, "accelerometer", &expected);
    drop(diagnostics);
    node.stop();
}
