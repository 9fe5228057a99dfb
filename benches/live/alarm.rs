//! Time from the publication of a forecast to its alarm at a subscriber of a broker.

use std::time::Duration;

use column_twin::messages::column_twin_msgs::{ImpactEvent, ImpactReport};
use column_twin::ros::qos;

use super::domain::Domain;
use super::peers::{Peer, event, now};
use super::program::Program;
use super::programs::{Lines, Mosquitto};
use super::table::{Ranked, number, row};

/// Impacts that need an action. Each is followed by a reset, which clears its alarm.
const EVENTS: usize = 200;

/// The target for the 99th percentile \[ms\].
const TARGET: f64 = 20.0;

pub fn run(_: Duration) {
    let (domain, folder) = (Domain::fresh(), tempfile::tempdir().expect("a folder"));
    let broker = Mosquitto::started(folder.path(), "");
    let subscriber = broker.subscriber();
    let arguments = [
        format!("alarm.mqtt.broker:={}", broker.address()),
        "alarm.mqtt.action:=inspect".to_owned(),
    ];
    let arguments: Vec<_> = arguments.iter().flat_map(|it| ["-p", it]).collect();
    let _program = Program::ready(&domain, folder.path(), &arguments);
    let mut peer = Peer::new(&domain);
    let forecasts = peer.reader(
        &qos::IMPACT_FORECAST,
        |it: ImpactReport, arrival| (it.event_id, arrival),
        |it| it.header.stamp,
    );
    let reports = peer.reader(
        &qos::IMPACT_REPORT,
        |it: ImpactReport, _| it.event_id,
        |it| it.header.stamp,
    );
    let reset = peer.reset();
    let events = peer.publisher::<ImpactEvent>(&qos::IMPACT_EVENT);
    let (mut published, mut received) = (vec![], vec![]);
    for number in 0..EVENTS {
        let id = format!("impact-{number:06}");
        events
            .publish(event(&id, now(), 1500.0, 10.0))
            .expect("room for one");
        let alarm = arrival_of_alarm(&subscriber, &id);
        let (_, forecast) = forecasts.find(|(event, _)| *event == id);
        published.push(1e-6 * (alarm - forecast.source) as f64);
        received.push(1e-6 * (alarm - forecast.received) as f64);
        reports.find(|event| *event == id);
        reset();
    }
    let [published, received] = [published, received].map(Ranked::new);
    println!(
        "{} impacts; mosquitto and mosquitto_sub on loopback, QoS 1, each message on the disk before it is sent",
        published.len()
    );
    row("[ms]", ["p50", "p99", "max"].map(str::to_owned));
    for (name, times) in [
        ("publication of the forecast to the alarm", &published),
        ("forecast at a DDS reader to the alarm", &received),
    ] {
        let columns = [times.percentile(50.0), times.percentile(99.0), times.max()];
        row(name, columns.map(number));
    }
    row(
        "p99 / 20 ms",
        [String::new(), number(published.percentile(99.0) / TARGET)],
    );
}

/// When the alarm that an event has caused reaches the subscriber \[ns\].
fn arrival_of_alarm(subscriber: &Lines, event_id: &str) -> i64 {
    loop {
        let line = subscriber.next();
        let arrived = now();
        // Topic, whether it is retained, payload.
        let payload = line.splitn(3, ' ').nth(2).unwrap_or_default();
        let message: serde_json::Value = serde_json::from_str(payload).unwrap_or_default();
        if message["kind"] == "action" && message["cause"] == event_id {
            return arrived;
        }
    }
}
