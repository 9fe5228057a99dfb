//! Time from a forecast to the same forecast with the second opinion of the fibre beam, to the one with the range of its verdict, which
//! contains the beam with a second hardening, and what the beam costs the forecast itself and the stream of states at 1 kHz.

use std::time::{Duration, Instant};

use column_twin::messages::column_twin_msgs::{
    ColumnState, ImpactEvent, ImpactReport, SecondOpinion, TwinStatus,
};
use column_twin::ros::qos;

use super::domain::{Domain, PATIENCE};
use super::peers::{Arrival, Peer, event, now};
use super::program::Program;
use super::stream::latency;
use super::table::{Ranked, number, row};

/// Direction \[degrees\], velocity \[m/s\] and vehicle of the hits.
const HITS: [(f64, f64, &str); 8] = [
    (0.0, 3.0, "rigid"),
    (0.0, 6.0, "rigid"),
    (0.0, 10.0, "mid_car"),
    (0.0, 6.0, "lorry_8t"),
    (10.0, 10.0, "mid_car"),
    (45.0, 6.0, "lorry_8t"),
    (90.0, 3.0, "rigid"),
    (90.0, 10.0, "mid_car"),
];

/// How often each of them is repeated.
const ROUNDS: usize = 5;

/// Between two looks at what has arrived, each with its time.
const POLL: Duration = Duration::from_millis(1);

/// The times of all hits \[ms\]: from the event to the forecast, and of those in the plane and of the oblique ones, from the forecast to
/// the one with the beam and to the one with the range of the verdict; and from the stamp of a state to its reader.
struct Times {
    states: Ranked,
    forecast: Ranked,
    opinion: [Ranked; 2],
    range: [Ranked; 2],
}

fn measured(mode: &str) -> Times {
    let domain = Domain::fresh();
    let folder = tempfile::tempdir().expect("a folder");
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/config/heb220_s355.yaml");
    let mode = format!("beam.mode:={mode}");
    let overrides = [
        "--params-file",
        config,
        "-p",
        &mode,
        "-p",
        "column_id:=column",
    ];
    let _program = Program::ready(&domain, folder.path(), &overrides);
    let mut peer = Peer::new(&domain);
    let taken = |report: ImpactReport, _| (Instant::now(), report);
    let stamp = |it: &ImpactReport| it.header.stamp;
    let forecasts = peer.reader(&qos::IMPACT_FORECAST, taken, stamp);
    let reports = peer.reader(&qos::IMPACT_REPORT, taken, stamp);
    let states = peer.reader(
        &qos::COLUMN_STATE,
        |_: ColumnState, it: Arrival| it,
        |it| it.header.stamp,
    );
    let reset = peer.reset();
    let events = peer.publisher::<ImpactEvent>(&qos::IMPACT_EVENT);
    let millis = |from: Instant, to: Instant| 1e3 * to.duration_since(from).as_secs_f64();
    let mut forecast_times = vec![];
    let (mut opinion_times, mut range_times) = ([vec![], vec![]], [vec![], vec![]]);
    for number in 0..ROUNDS * HITS.len() {
        let (degrees, velocity, vehicle) = HITS[number % HITS.len()];
        let id = format!("impact-{number:06}");
        let mass = if vehicle == "rigid" { 1500.0 } else { 0.0 };
        let sent = Instant::now();
        events
            .publish(ImpactEvent {
                vehicle: vehicle.to_owned(),
                direction: f64::to_radians(degrees),
                ..event(&id, now(), mass, velocity)
            })
            .expect("room for one");
        let (mut forecast, mut known, mut range, mut is_over) = (None, None, None, false);
        let end = Instant::now() + PATIENCE;
        // The beam comes with the forecast, or with the result where the response is over by then.
        while forecast.is_none() || known.is_none() || range.is_none() || !is_over {
            assert!(
                Instant::now() < end,
                "no forecast, result, second opinion or range of the verdict on {id}"
            );
            for (reader, is_result) in [(&forecasts, false), (&reports, true)] {
                for (at, it) in reader.arrivals.try_iter() {
                    if it.event_id != id {
                        continue;
                    }
                    is_over |= is_result;
                    forecast.get_or_insert(at);
                    if it.range_most != TwinStatus::ACTION_UNKNOWN {
                        range.get_or_insert(at);
                    }
                    if it.beam.state != SecondOpinion::PENDING {
                        known.get_or_insert((at, it.beam));
                    }
                }
            }
            std::thread::sleep(POLL);
        }
        let received = forecast.expect("it was awaited");
        let (at, beam) = known.expect("it was awaited");
        forecast_times.push(millis(sent, received));
        let kind = usize::from(degrees != 0.0);
        if beam.state == SecondOpinion::KNOWN {
            opinion_times[kind].push(millis(received, at));
        }
        range_times[kind].push(millis(received, range.expect("it was awaited")));
        reset();
    }
    Times {
        states: Ranked::new(states.arrivals.try_iter().map(|it| latency(&it))),
        forecast: Ranked::new(forecast_times),
        opinion: opinion_times.map(Ranked::new),
        range: range_times.map(Ranked::new),
    }
}

pub fn run(_: Duration) {
    let [without, with] = ["off", "second_opinion"].map(measured);
    println!(
        "HEB220 in S355, {} hits by cars, lorries and rigid masses at 0 to 90 degrees, each on an undamaged column",
        with.forecast.len()
    );
    row("[ms]", ["p50", "p95", "p99", "max"].map(str::to_owned));
    for (name, times) in [
        ("event to forecast, beam.mode: off", &without.forecast),
        ("event to forecast, with the beam", &with.forecast),
        ("latency of the states, beam.mode: off", &without.states),
        ("latency of the states, with the beam", &with.states),
        ("forecast to second opinion, in the plane", &with.opinion[0]),
        ("forecast to second opinion, oblique", &with.opinion[1]),
        ("forecast to range, in the plane", &with.range[0]),
        ("forecast to range, oblique", &with.range[1]),
    ] {
        let columns = [50.0, 95.0, 99.0, 100.0].map(|percent| times.percentile(percent));
        row(name, columns.map(number));
    }
    for (name, times) in [
        (
            "forecast with the beam / without",
            [&with, &without].map(|it| &it.forecast),
        ),
        (
            "states with the beam / without",
            [&with, &without].map(|it| &it.states),
        ),
    ] {
        let ratio = |percent: f64| times[0].percentile(percent) / times[1].percentile(percent);
        let percents = [50.0, 95.0, 99.0, 100.0];
        row(name, percents.map(|percent| number(ratio(percent))));
    }
}
