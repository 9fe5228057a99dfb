//! Drivers that publish single samples on topics of their own are sensors of the columns in whose namespaces they publish.

use std::fs;
use std::sync::Arc;
use std::time::{Duration, Instant};

use column_twin::endpoints::Endpoint;
use column_twin::messages::builtin_interfaces::Time;
use column_twin::messages::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use column_twin::messages::geometry_msgs::Vector3;
use column_twin::messages::sensor_msgs::Imu;
use column_twin::messages::std_msgs::Header;
use column_twin::parameters::{FleetColumns, FleetSources, NodeName};
use column_twin::ros::{LiveColumns, Names, StartError, TwinNode, qos};

use super::domain::{Domain, PATIENCE};
use super::incoming::{Incoming, reader};

const SHARED: &str = "\
/**:
  ros__parameters:
    state: {directory: ''}
    real_time: {priority: 0, lock_memory: false, threads: 1}
    sensors:
      names: [imu]
      imu: {quantity: acceleration, height: 1.0, rate: 1000.0, topic: imu, message: imu}
";

fn fleet(columns: usize) -> FleetColumns {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("fleet.yaml");
    let columns = (0..columns).map(|it| format!("/hall/c{it}:\n  ros__parameters:\n"));
    fs::write(&path, SHARED.to_owned() + &columns.collect::<String>()).expect("written");
    let sources = FleetSources {
        files: vec![path],
        ..FleetSources::default()
    };
    FleetColumns::load(&NodeName::default(), &sources).expect("right")
}

#[test]
fn a_driver_of_single_samples_is_the_sensor_of_the_column_in_whose_namespace_it_publishes() {
    let domain = Domain::fresh();
    let (columns, outputs) = LiveColumns::start_fleet(&fleet(2)).expect("starts");
    let names = Names::new("/", "column_twin", &[]).expect("valid");
    let live = Arc::clone(&columns);
    let running = TwinNode::start(&domain.environment, names, live, outputs, None, None);
    let running = running.expect("a node");
    let mut node = reader(&domain);
    let imu = Endpoint {
        name: "/hall/c1/imu",
        type_name: "sensor_msgs/msg/Imu",
        ..qos::MEASUREMENTS
    };
    let driver = node.publisher::<Imu>(&imu).expect("a publisher");
    let diagnostics = Incoming::<DiagnosticArray>::start(&mut node, &qos::DIAGNOSTICS);
    let deadline = Instant::now() + PATIENCE;
    assert!(node.matches().wait_for(driver.guid(), 1, deadline));
    assert!(running.matches().wait_for_peer(driver.guid(), deadline));
    let start = columns.now() - 1_000_000_000;
    for sample in 0..200 {
        let stamp = Time::from_nanos(start + sample * 1_000_000).expect("a time");
        let message = Imu {
            header: Header {
                stamp,
                frame_id: String::new(),
            },
            linear_acceleration: Vector3 {
                x: 0.1,
                y: 0.0,
                z: 9.81,
            },
            ..Imu::default()
        };
        driver.publish(message).expect("sent");
        // Slower than the sensor: what comes in bursts on topics of best effort may be lost.
        std::thread::sleep(Duration::from_millis(2));
    }
    loop {
        assert!(Instant::now() < deadline, "only one of both sensors sends");
        let array = diagnostics.next();
        let of = |name: &str| -> Option<&DiagnosticStatus> {
            let mut statuses = array.status.iter();
            statuses.find(|it| it.name == format!("column_twin: {name}"))
        };
        let all = of("sensors").expect("a status of all sensors");
        let waiting = all.values.iter().find(|it| it.key.starts_with("waiting"));
        if waiting.is_some_and(|it| it.value == "1") {
            let silent = of("c0: sensors").expect("a status of the silent sensor");
            assert_eq!(silent.message, "imu has not sent anything");
            break;
        }
    }
    drop(diagnostics);
    running.stop();
}

#[test]
fn a_fleet_whose_sensors_name_too_many_topics_does_not_start() {
    let Err(error) = LiveColumns::start_fleet(&fleet(257)) else {
        panic!("it has started");
    };
    assert!(matches!(error, StartError::SensorTopics { found: 257 }));
    let text = error.to_string();
    assert!(
        text.contains("257 topics") && text.contains("at most 256"),
        "{text}"
    );
}
