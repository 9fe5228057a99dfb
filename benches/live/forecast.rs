//! Time from an event to its forecast, both over DDS.

use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::{ImpactEvent, ImpactReport};
use column_twin::ros::qos;

use super::bare::{Bare, PING, PONG};
use super::domain::Domain;
use super::peers::{Peer, event, now};
use super::program::Program;
use super::table::{Ranked, number, row};

const EVENTS: usize = 200;

/// The target without the bare round trip \[ms\].
const TARGET: f64 = 5.0;

pub fn run(_: Duration) {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().expect("a folder");
    let _program = Program::ready(&domain, folder.path(), &[]);
    let _echo = Bare::echo(&domain);
    let mut peer = Peer::new(&domain);
    let taken = |report: ImpactReport, _| (Instant::now(), report);
    let stamp = |it: &ImpactReport| it.header.stamp;
    let forecasts = peer.reader(&qos::IMPACT_FORECAST, taken, stamp);
    let reports = peer.reader(&qos::IMPACT_REPORT, taken, stamp);
    let pongs = peer.reader(&PONG, taken, stamp);
    let reset = peer.reset();
    let events = peer.publisher::<ImpactEvent>(&qos::IMPACT_EVENT);
    let pings = peer.publisher::<ImpactEvent>(&PING);
    let (mut twin, mut bare, mut computing) = (vec![], vec![], vec![]);
    let millis = |from: Instant, to: Instant| 1e3 * to.duration_since(from).as_secs_f64();
    for number in 0..EVENTS {
        let id = format!("impact-{number:06}");
        let sent = Instant::now();
        events
            .publish(event(&id, now(), 1500.0, 10.0))
            .expect("room for one");
        let (received, forecast) = forecasts.find(|(_, it)| it.event_id == id);
        twin.push(millis(sent, received));
        computing.push(1e3 * forecast.compute_time);
        reports.find(|(_, it)| it.event_id == id);
        reset();
        let sent = Instant::now();
        pings
            .publish(event(&id, now(), 1500.0, 10.0))
            .expect("room for one");
        let (received, _) = pongs.find(|(_, it)| it.event_id == id);
        bare.push(millis(sent, received));
    }
    let [twin, bare, computing] = [twin, bare, computing].map(Ranked::new);
    println!(
        "time from publishing an event to receiving its forecast, {} events on an undamaged column, each followed by a bare echo",
        twin.len()
    );
    row("[ms]", ["p50", "p99", "max"].map(str::to_owned));
    for (name, times) in [
        ("event to forecast", &twin),
        ("bare echo of equal messages", &bare),
        ("compute time in it", &computing),
    ] {
        let columns = [times.percentile(50.0), times.percentile(99.0), times.max()];
        row(name, columns.map(number));
    }
    let allowed = TARGET + bare.percentile(99.0);
    row(
        "p99 / (5 ms + p99 of the echo)",
        [String::new(), number(twin.percentile(99.0) / allowed)],
    );
}
